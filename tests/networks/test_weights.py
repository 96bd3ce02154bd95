"""Files of weights: each form is read as the network it is, and what is none is refused in a sentence."""

import json
import sys
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from lure import InputError
from lure.networks import Network, read_network


def test_weights_in_numpys_format(tmp_path):
    one, two = np.array([[1.0, 2.0], [0.5, -1.0]]), np.array([[1.0, 1.0]])
    np.savez(tmp_path / "net.npz", W2=two, b1=np.zeros(2), W1=one)
    assert read_network(tmp_path / "net.npz", activation="relu") == Network.given([one, two], activation="relu")


@pytest.mark.parametrize(
    ("network", "words"),
    [
        ({"weights": [[[1]]]}, "has 1 layer"),
        ({"weights": [[[1]], [[1, 2]]]}, "layer 2 of the network has 2 inputs"),
        ({"weights": [[[1], [1, 2]], [[1]]]}, "rows of numbers of equal length"),
        ({"weights": [[["x"]], [[1]]]}, "layer 1 of the network, row 1, column 1 is 'x'; give a number"),
        ({"weights": [[[1]], [[1]]], "biases": [[1]]}, "biases are given of 1 layer of 2; give all, or none"),
        ({"weights": [[[1]], [[1]]], "biases": [[1, 2], [0]]}, "layer 1 .* 1 output and biases of length 2; give one"),
        ({"weights": [[[1]], [[1]]], "bias": [[1], [0]]}, "has the unknown key 'bias'; did you mean 'biases'"),
        ({"weights": 3}, "no list of weights"),
        ([], "no list of weights"),
    ],
)
def test_bad_weights_are_refused_in_a_sentence(tmp_path, network, words):
    (tmp_path / "net.json").write_text(json.dumps(network))
    with pytest.raises(InputError, match=words):
        read_network(tmp_path / "net.json", activation="tanh")
    (tmp_path / "net.npz").write_text("none")
    with pytest.raises(InputError, match="no archive of arrays"):
        read_network(tmp_path / "net.npz", activation="tanh")


def test_a_key_that_is_there_twice_is_refused(tmp_path):
    (tmp_path / "net.json").write_text('{"weights": [[[1]], [[1]]], "weights": [[[1]], [[-9]]]}')
    with pytest.raises(InputError, match=r"net\.json is no JSON with each key once"):
        read_network(tmp_path / "net.json", activation="tanh")


@pytest.mark.parametrize(
    "names",
    [
        ("actor.0.weight", "actor.2.weight", "critic.0.weight", "critic.2.weight"),  # the critic was read
        ("weight_ih_l0", "weight_hh_l0", "weight_ih_l1", "weight_hh_l1"),  # and a recurrent network for a chain
        ("fc1.weight", "fc2.weight", "out.weight"),  # and the last layer for the first
    ],
)
def test_arrays_that_numbers_do_not_put_in_order_are_refused(tmp_path, names):
    np.savez(tmp_path / "net.npz", **{name: np.eye(2) * (k + 1) for k, name in enumerate(names)})
    with pytest.raises(InputError, match="not told apart by numbers alone; write the layers of one network"):
        read_network(tmp_path / "net.npz", activation="tanh")


def test_arrays_of_other_layers_are_not_passed_over(tmp_path):
    plain = {"W1": np.eye(2), "W2": np.eye(2), "W3": np.eye(2)}
    for name, array in (("W0", np.ones((2, 2, 3, 3))), ("W4", np.array(2.0)), ("b4", np.zeros(2))):
        np.savez(tmp_path / "net.npz", **plain, **{name: array})
        with pytest.raises(InputError, match=r"no matrices of two layers or more|biases of layers without a matrix"):
            read_network(tmp_path / "net.npz", activation="tanh")


def test_a_chain_of_nodes_is_read_as_the_network_it_is(tmp_path, monkeypatch):
    # ONNX itself is no dependency: in its place stands what the reader asks of it
    one, two, b, c = np.array([[1.0, 2.0], [0.0, 1.0]]), np.array([[0.5, -1.0]]), np.array([1.0, 2.0]), np.array([3.0])
    arrays = {"W": one, "V": two.T, "b": b, "c": c}

    def node(kind, taken, put, **settings):
        kept = [SimpleNamespace(name=key, i=value, f=value) for key, value in settings.items()]
        return SimpleNamespace(op_type=kind, input=taken.split(), output=[put], attribute=kept)

    chain = [node("Gemm", "y W b", "p", transB=1), node("Tanh", "p", "q"), node("MatMul", "q V", "r")]
    model, end = SimpleNamespace(), node("Add", "r c", "u")
    stored = [SimpleNamespace(name=name, values=values) for name, values in arrays.items()]

    def read(nodes, output="u"):
        model.graph = SimpleNamespace(node=nodes, initializer=stored, output=[SimpleNamespace(name=output)])
        return read_network(tmp_path / "net.onnx")

    helper = SimpleNamespace(to_array=lambda one: one.values)
    monkeypatch.setitem(sys.modules, "onnx", SimpleNamespace(load=lambda _: model, numpy_helper=helper))
    (tmp_path / "net.onnx").write_text("")
    assert read([*chain, end]) == Network.given([one, two], [b, c], activation="tanh")
    for nodes, output, words in (
        ([*chain, end, node("Add", "u c", "v")], "v", "adds two biases behind one layer"),
        ([chain[0], node("Add", "p b", "s"), node("Tanh", "s", "q"), *chain[2:]], "r", "adds two biases"),
        ([*chain, end], "r", "puts out something else than its last layer"),
        ([node("Gemm", "y W b", "p", transB=1, alpha=2.0), *chain[1:]], "r", "a Gemm with factors"),
        ([*chain, node("Tanh", "r", "u")], "u", "not one and the same activation behind each layer but the last"),
        ([chain[0], node("Sigmoid", "p", "q"), chain[2]], "r", "has a layer 'Sigmoid'"),
        ([*chain, node("Add", "r p", "u")], "u", "no chain of layers"),
        ([*chain, node("Gemm\r\n", "r p", "u")], "u", r"no chain of layers: 'Gemm\\r\\n'"),
    ):
        with pytest.raises(InputError, match=words):
            read(nodes, output)


def test_a_state_dict_is_read_in_the_order_of_its_layers(tmp_path, monkeypatch):
    # PyTorch itself is no dependency: in its place stands what the reader asks of it, tensors with double().numpy()
    class Tensor(np.ndarray):
        def double(self):
            return self.astype(float)

        def numpy(self):
            return np.asarray(self)

        def numel(self):
            return self.size

    one, two = np.array([[1.0, 2.0], [0.0, 1.0]]), np.array([[0.5, -1.0]])
    parts = {"10.weight": two, "2.weight": one, "2.bias": np.zeros(2), "10.bias": np.zeros(1)}
    asked = []

    def load(path, **settings):
        asked.append((path.name, settings))
        if path.name == "bad.pt":
            raise RuntimeError("invalid header")
        if path.name == "vast.pt":  # 13 GB, of which the file holds one number
            return {"0.weight": np.broadcast_to(np.zeros(1).view(Tensor), (40_000, 40_000), subok=True)}
        return {name: value.astype(np.float32).view(Tensor) for name, value in parts.items()}

    monkeypatch.setitem(sys.modules, "torch", SimpleNamespace(load=load))
    for name in ("net.pt", "bad.pt", "vast.pt"):
        (tmp_path / name).write_text("")
    assert read_network(tmp_path / "net.pt", activation="tanh") == Network.given([one, two], activation="tanh")
    assert asked == [("net.pt", {"map_location": "cpu", "weights_only": True})]  # nothing in the file is run
    with pytest.raises(InputError, match=r"bad\.pt is no state dict; write it by torch\.save"):
        read_network(tmp_path / "bad.pt", activation="tanh")
    with pytest.raises(InputError, match="unpacks to more than 16 MiB"):
        read_network(tmp_path / "vast.pt", activation="tanh")
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(InputError, match=r"net\.pt needs PyTorch, which is not installed"):
        read_network(tmp_path / "net.pt", activation="tanh")


def test_texts_of_weights_are_the_decimals_they_say():
    network = Network.given([[["0.1"]], [["1/3"]]], [["0.2"], [0]], activation="tanh", saturation="0.7")
    assert network.weights == (((Fraction(1, 10),),), ((Fraction(1, 3),),))
    assert (network.biases[0], network.saturation) == ((Fraction(1, 5),), Fraction(7, 10))
    with pytest.raises(InputError, match="is 'x'; give a number"):
        Network.given([[["x"]], [[1]]], activation="tanh")
