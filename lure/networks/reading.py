"""Networks from files: weights in JSON or NumPy's format, ONNX models, and state dicts of PyTorch."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from lure.arrays import np
from lure.errors import InputError, did_you_mean
from lure.networks.network import Network

MAX_BYTES = 1 << 24
_TOLD = ("activation", "negative_slope", "saturation")
_KEYS = ("weights", "biases", *_TOLD)
_BESIDE = ("source", "licence", "license", "name", "title", "comment")  # which say nothing of the network


def read_network(path: str | Path, **told: object) -> Network:
    """The network of a file.

    Parameters
    ----------
    path : str or Path
        ``.json`` with ``weights``, a list of matrices, and if wanted ``biases``, ``activation``, ``negative_slope`` and
        ``saturation``, decimals taken exactly; ``.npz`` with arrays such as ``W1``, ``b1``, ``W2``; ``.onnx``, a chain
        of layers, which needs the package ``onnx``; ``.pt`` or ``.pth``, the state dict of a chain of linear layers,
        which needs PyTorch.
    **told : object
        ``activation``, ``negative_slope`` and ``saturation``, where the file does not say them.

    Raises
    ------
    InputError
        The file cannot be read, holds no such network, or says otherwise than what is told.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "network.json"
    >>> _ = file.write_text(json.dumps({"weights": [[[1, 2]], [[0.5]]]}))
    >>> print(read_network(file, activation="tanh"))
    2 inputs, 1 neuron (tanh) in 1 layer, 1 output
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"the file of the network {path.name or '.'!r:.60} is a folder; give the path of a file in it")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path.name!r:.60} has none of the endings {', '.join(_READERS)}; give a file of weights")
    try:
        large = path.stat().st_size > MAX_BYTES
    except (OSError, ValueError):
        raise InputError(f"the file of the network {str(path)!r:.80} cannot be read; give the path of one") from None
    if large or not path.is_file():
        raise InputError(
            f"{path.name!r:.60} is no ordinary file of at most 16 MiB; give the weights of a small network"
        )
    found = reader(path)
    for key, value in told.items():
        if value is None:
            continue
        if found.get(key) is not None and found[key] != value:
            raise InputError(f"{key} is {value!s:.40}, and {path.name} says {found[key]!s:.40}; leave one of them out")
        found[key] = value
    if found.get("activation") is None:
        raise InputError(f"{path.name} does not say what its neurons do; give activation, such as 'tanh'")
    try:
        return Network.given(found.pop("weights"), found.pop("biases", ()), **found)
    except InputError as error:
        raise InputError(f"{path.name}: {error}") from None


def _json(path: Path) -> dict[str, Any]:
    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        """An object without two values of one key, of which one would be left out."""
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a key is there twice")
        return dict(pairs)

    try:
        found = json.loads(path.read_text("utf-8"), parse_float=Decimal, object_pairs_hook=once)
    except (OSError, ValueError, RecursionError, ArithmeticError):  # the last of exponents beyond those of decimals
        raise InputError(
            f"{path.name} is no JSON with each key once; give an object with weights, a list of matrices"
        ) from None
    if not isinstance(found, dict) or not isinstance(found.get("weights"), list):
        raise InputError(f"{path.name} has no list of weights; give an object with weights, a list of matrices")
    for key in found.keys() - {*_KEYS, *_BESIDE}:
        hint = did_you_mean(key.lower(), _KEYS)
        raise InputError(
            f"{path.name} has the unknown key {key!r:.40}; {hint}it takes {', '.join(_KEYS)}, and beside these "
            f"{', '.join(_BESIDE)}"
        )
    kept = {key: found[key] for key in _KEYS if key in found}
    if not isinstance(kept.get("biases", []), list) or not all(isinstance(b, list) for b in kept.get("biases", [])):
        raise InputError(f"{path.name}: biases are a list of vectors, one for each layer")
    return kept


def _npz(path: Path) -> dict[str, Any]:
    try:
        with zipfile.ZipFile(path) as held:
            size = sum(one.file_size for one in held.infolist())
        found = {}
        if size <= MAX_BYTES:
            with np.load(path, allow_pickle=False) as arrays:
                found = {name: arrays[name] for name in arrays.files}
    except Exception:  # whatever the modules of archives and of arrays raise, of a header that asks for too much memory
        raise InputError(f"{path.name} is no archive of arrays; write it by numpy.savez(file, W1=W1, W2=W2)") from None
    if size > MAX_BYTES:
        raise InputError(f"{path.name} unpacks to more than 16 MiB; give the weights of a small network")
    return _of_arrays(path, found)


def _of_arrays(path: Path, arrays: Mapping[str, Any]) -> dict[str, Any]:
    """Matrices and vectors in the order of the numbers in their names, which have nothing else of their own."""

    def place(name: str) -> list[int]:
        """The numbers in a name."""
        return [int(digits) for digits in re.findall(r"\d+", name)]

    names = sorted(arrays, key=place)
    wrong = next((name for name in names if np.ndim(arrays[name]) not in (1, 2)), None)
    if wrong is not None or len({tuple(place(name)) for name in names if np.ndim(arrays[name]) == 2}) < 2:
        raise InputError(f"{path.name} has no matrices of two layers or more; name them W1, W2, and the biases b1, b2")
    for size in (2, 1):  # of networks side by side, or of one that feeds back, some would be left out
        own = [name for name in names if np.ndim(arrays[name]) == size]
        if len({re.sub(r"\d+", "", name) for name in own}) > 1 or len({tuple(place(name)) for name in own}) < len(own):
            raise InputError(
                f"{path.name} has {', '.join(map(repr, own)):.80}, which are not told apart by numbers alone; write "
                "the layers of one network, such as W1, b1, W2 and b2"
            )
    weights = {tuple(place(name)): arrays[name] for name in names if np.ndim(arrays[name]) == 2}
    given = {tuple(place(name)): arrays[name] for name in names if np.ndim(arrays[name]) == 1}
    if not given.keys() <= weights.keys():
        raise InputError(f"{path.name} has biases of layers without a matrix; number both alike, as W1 and b1")
    return {"weights": [*weights.values()], "biases": [given.get(k, np.zeros(len(W))) for k, W in weights.items()]}


def _torch(path: Path) -> dict[str, Any]:
    try:
        import torch
    except ImportError:
        raise InputError(
            f"{path.name} needs PyTorch, which is not installed; write the weights by numpy.savez instead"
        ) from None
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        large = 8 * sum(value.numel() for value in state.values()) > MAX_BYTES  # one number may stand for a matrix
        arrays = {} if large else {name: value.double().numpy() for name, value in state.items()}
    except Exception:  # whatever that package raises
        raise InputError(f"{path.name} is no state dict; write it by torch.save(network.state_dict(), file)") from None
    if large:
        raise InputError(f"{path.name} unpacks to more than 16 MiB; give the weights of a small network")
    return _of_arrays(path, arrays)


def _onnx(path: Path) -> dict[str, Any]:
    try:
        import onnx
        from onnx import numpy_helper
    except ImportError:
        raise InputError(
            f"{path.name} needs the package onnx, which is not installed; install lure[networks]"
        ) from None
    try:
        graph = onnx.load(path).graph
        arrays = {one.name: numpy_helper.to_array(one) for one in graph.initializer}
        return _of_nodes(path, graph, arrays)
    except InputError:
        raise
    except Exception:  # whatever that package raises
        raise InputError(f"{path.name} is no ONNX model that can be read; export the network again") from None


_ACTIVATIONS = {"Tanh": "tanh", "Relu": "relu", "LeakyRelu": "leaky relu"}


def _of_nodes(path: Path, graph: Any, arrays: dict[str, Any]) -> dict[str, Any]:  # noqa: ANN401  (of that package)
    """A chain of ``Gemm``, or ``MatMul`` and ``Add``, with activations between them."""
    weights, biases, told = list[Any](), list[Any](), list[tuple[str, float | None]]()
    value = None  # what the node before puts out
    for node in graph.node:
        settings = {one.name: one for one in node.attribute}
        given = [name for name in node.input if name in arrays]
        free = [name for name in node.input if name and name not in arrays]
        if len(free) != 1 or value not in (None, free[0]):
            raise InputError(
                f"{path.name} is no chain of layers: {node.op_type!r:.40} does not take what is before it alone"
            )
        value = node.output[0]
        turn = len(told) == len(weights)  # a layer's, not an activation's
        if turn and given and (node.op_type == "MatMul" or (node.op_type == "Gemm" and free[0] == node.input[0])):
            plain = all(settings[key].f == 1.0 for key in ("alpha", "beta") if key in settings)
            if node.op_type == "Gemm" and (not plain or ("transA" in settings and settings["transA"].i)):
                raise InputError(f"{path.name} has a Gemm with factors or a transposed input; export it as W x + b")
            W = arrays[given[0]]
            turned = bool("transB" in settings and settings["transB"].i)
            left = node.op_type == "MatMul" and node.input[0] == given[0]
            weights.append(W if turned or left else W.T)
            biases.append(np.ravel(arrays[given[1]]) if len(given) > 1 else np.zeros(len(weights[-1])))
        elif node.op_type == "Add" and not turn and len(given) == 1:
            if np.any(biases[-1]):
                raise InputError(f"{path.name} adds two biases behind one layer; export it as W x + b")
            biases[-1] = np.ravel(arrays[given[0]])
        elif node.op_type in _ACTIVATIONS and not turn:
            slope = (settings["alpha"].f if "alpha" in settings else 0.01) if node.op_type == "LeakyRelu" else None
            told.append((_ACTIVATIONS[node.op_type], slope))
        elif node.op_type not in ("Flatten", "Identity"):
            raise InputError(
                f"{path.name} has a layer {node.op_type!r:.40}; linear layers are taken, with Tanh, Relu or LeakyRelu "
                "between them"
            )
    if [one.name for one in graph.output] != [value]:
        raise InputError(f"{path.name} puts out something else than its last layer; export the chain of layers alone")
    if len(set(told)) != 1 or len(told) != len(weights) - 1:
        raise InputError(f"{path.name} has not one and the same activation behind each layer but the last")
    return {"weights": weights, "biases": biases, "activation": told[0][0], "negative_slope": told[0][1]}


_READERS: dict[str, Callable[[Path], dict[str, Any]]] = {
    ".json": _json,
    ".npz": _npz,
    ".onnx": _onnx,
    ".pt": _torch,
    ".pth": _torch,
}
