"""Networks as controllers: the loop of their neurons, files of weights, and regions that both checkers accept."""

import json
from fractions import Fraction
from importlib.resources import files
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from tampering import assert_both_reject, edited

from lure import ExpressionNonlinearity, InputError, Quantiser, Saturation, as_plant
from lure.analysis import certify, region
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.cli import main
from lure.analysis.inequality.ellipsoids import Local, ellipsoid, linear_ellipsoid
from lure.analysis.inequality.many_ellipsoids import many_ellipsoid
from lure.analysis.numerics.precision import working_precision
from lure.analysis.questions.region_proofs import proved_ellipsoid, proved_on
from lure.analysis.questions.region_sets import loop_asked, matrix_of, parted, shape_of, volume_below
from lure.analysis.questions.regions import AttractedSet, RegionOfAttraction
from lure.analysis.verdict import Verdict
from lure.expressions.rigorous import ball
from lure.files import loop_to_toml, parse_system, read_system
from lure.networks import Network, equilibrium, read_network
from lure.plants.multivariable import MultivariablePlant


def phi_of(plant, laws, x):
    """The nonlinearities' values, channel after channel."""
    _, _, C, D = plant.doubles()
    phi = np.zeros(len(laws))
    for i, law in enumerate(laws):
        phi[i] = law(C[i] @ x - D[i] @ phi)
    return phi


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), activation=st.sampled_from(["tanh", "relu", "leaky relu", "saturation"]))
def test_the_loop_of_a_network_moves_as_the_network_does(seed, activation):
    rng = np.random.default_rng(seed)
    sizes = [3, *rng.integers(1, 5, size=rng.integers(1, 4)), 2]
    network = Network.given(
        [rng.normal(size=(after, before)) for before, after in pairwise(sizes)],
        activation=activation,
        negative_slope=0.1 if activation == "leaky relu" else None,
        saturation=None if seed % 2 else 0.5,
    )
    A, B, C = rng.normal(size=(4, 4)), rng.normal(size=(4, 3)), rng.normal(size=(4, 4))
    own = np.zeros((4, 3))
    own[0, 1:] = rng.normal(size=2)  # u may feed a channel of the plant, and its mu what is measured
    own[1:, 0] = 0 if own[0, 1:].any() else 1
    plant = MultivariablePlant(*(tuple(tuple(map(Fraction, row)) for row in side) for side in (A, B, C, own)))
    closed, laws = network.closed(plant), [Saturation(limit=2), *network.nonlinearities()]
    assert closed.inputs == closed.outputs == len(laws)
    x = rng.normal(size=4)
    u = network(C[1:] @ x)
    mu = -Saturation(limit=2)(C[0] @ x + own[0, 1:] @ u)
    order = [*range(1, len(laws)), 0]  # sigma of the plant's own channel depends on u
    turned = MultivariablePlant(
        closed.A,
        tuple(tuple(row[i] for i in order) for row in closed.B),
        tuple(closed.C[i] for i in order),
        tuple(tuple(closed.D[i][j] for j in order) for i in order),
    )
    moved = turned.doubles()[0] @ x - turned.doubles()[1] @ phi_of(turned, [laws[i] for i in order], x)
    assert np.allclose(moved, A @ x + B @ [mu, *u], atol=1e-9)


# x' = x + u, u = -3 sat(2 x) of one neuron: x' > 0 where x > 3 sat(2 x), from 3 on; the region is (-3, 3).
def test_one_neuron_is_a_saturation():
    network = Network.given([[[2]], [[-3]]], activation="saturation")
    closed = network.closed(MultivariablePlant.of_one_channel(as_plant(([[1]], [1], [1], 0))))
    found = region(closed, network.nonlinearities())
    assert found.sets[0].interval == found.outside[0].interval == (-3, 3)


# |u| <= 1 beside x' = 2 x: every solution from |x| >= 1/2 on grows, so no set reaches it; the network's own limit is 3.
def test_the_limit_of_the_output_counts():
    network = Network.given([[[2]], [[-3]]], activation="saturation", saturation=1)
    closed = network.closed(MultivariablePlant.of_one_channel(as_plant(([[2]], [1], [1], 0))))
    found = region(closed, network.nonlinearities())
    assert 0.9 < found.area[0] < 1


# Two inputs, limits 5 and 2 (Tarbouriech et al. 2011), and a cubic of a discrete loop.
@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("points", [None, np.array([[1.0, 1.0], [1.0, -1.0]]), np.array([[1e9, 1e9], [1e9, -1e9]])])
def test_both_searches_find_the_same_ellipsoid(discrete, points):
    A, B = np.array([[0.1, -0.1], [0.1, -3.0]]), np.array([[5.0, 0.0], [0.0, 1.0]])
    C = np.array([[0.7283, 0.0338], [0.0135, 1.3583]])
    if discrete:
        A, B = np.eye(2) + 0.1 * A, 0.1 * B
    plant, local = (A, B, C, np.zeros((2, 2))), [Local(0, 1, 5.0, np.inf), Local(0.5, 1, None, 3.0)]
    few = ellipsoid(plant, local, discrete=discrete, points=points)
    first = linear_ellipsoid(plant, local, discrete=discrete)
    many = many_ellipsoid(plant, local, first.P, discrete=discrete, points=points)

    def size(P):
        """The logarithm of the volume, or of the factor of the points."""
        return -np.linalg.slogdet(P)[1] if points is None else -np.log(max(p @ P @ p for p in points))

    assert size(many.P) == pytest.approx(size(few.P), abs=2e-3)
    upper, lower = np.eye(2), np.diag([0, 0.5])  # what a certificate needs: V falls where both terms are not negative
    F, phi = np.hstack([A, -B]), np.hstack([np.zeros((2, 2)), np.eye(2)])
    kept = np.hstack([np.eye(2), np.zeros((2, 2))])
    Y, h = np.hstack([C, np.zeros((2, 2))]), np.hstack([many.rows, np.zeros((2, 2))])
    half = (upper @ Y - phi).T @ np.diag(many.weights) @ (phi - lower @ Y - h)
    fall = kept.T @ many.P @ kept - F.T @ many.P @ F if discrete else -(kept.T @ many.P @ F + F.T @ many.P @ kept)
    assert np.linalg.eigvalsh(fall - half - half.T)[0] > 0
    assert many.rows[0] @ np.linalg.solve(many.P, many.rows[0]) <= 25


def imitation(gain, seed=0, neurons=5):
    """Weights of a network of two layers that imitates ``u = -gain y`` near 0."""
    rng = np.random.default_rng(seed)
    one, two = rng.normal(size=(neurons, len(gain))) / 4, rng.normal(size=(neurons, neurons)) / 3
    last = np.linalg.lstsq((two @ one).T, -np.array(gain), rcond=None)[0]
    return [np.round(one, 4).tolist(), np.round(two, 4).tolist(), np.round([last], 4).tolist()]


FILE = """
[plant]
A = [[1, 0.1], [0.4, 0.9]]
B = [[0], [0.4]]
C = [[1, 0]]
dt = 0.1
[nonlinearity]
kind = "expression"
expression = "sigma - sin(sigma)"
[controller]
network = "weights.json"
activation = "tanh"
saturation = 1
Bu = [[0], [0.5]]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("network")
    (found / "weights.json").write_text(json.dumps({"weights": imitation([2.0, 1.0])}))
    (found / "plant.toml").write_text(FILE)
    return found


@pytest.fixture(scope="module")
def proof(folder):
    """The ellipsoid of the loop in the file: 1 + 10 + 1 channels."""
    system = read_system(folder / "plant.toml")
    return proved_ellipsoid(system.block, [shape_of(one) for one in system.nonlinearities], None)


@pytest.mark.slow
def test_a_region_from_a_file_is_accepted_by_both_checkers(folder, proof):
    certificate = proof.certificate
    check(json.dumps(certificate))
    assert recheck(json.dumps(certificate)).accepted
    network = read_network(folder / "weights.json", activation="tanh", saturation=1)
    rows = certificate["proof"]["P"]
    P = np.array([[float(Fraction(rows[max(i, j)][min(i, j)])) for j in range(2)] for i in range(2)])
    assert np.pi / np.sqrt(np.linalg.det(P)) > 1
    z = np.random.default_rng(1).normal(size=(2000, 2))
    x = np.linalg.solve(np.linalg.cholesky(P).T, (z / np.linalg.norm(z, axis=1)[:, None]).T).T
    before = np.ones(len(x))
    for _ in range(60):
        u = network(x)[:, 0]
        x = np.stack(
            [x[:, 0] + 0.1 * x[:, 1], 0.4 * np.sin(x[:, 0]) + 0.9 * x[:, 1] + 0.5 * u], axis=1
        )  # sin x1 = x1 - (x1 - sin x1)
        now = np.einsum("ki,ij,kj->k", x, P, x)
        assert np.all(now < before + 1e-12)
        before = now
    assert before.max() < 1e-2


@pytest.mark.slow
def test_a_changed_weight_sector_or_sign_is_refused_by_both(proof):
    good = proof.certificate
    terms = good["multiplier"]["terms"]
    for bad in (
        edited(good, "system", "D", 7, 2, value=lambda v: str(Fraction(v) + 3)),  # a weight of the second layer
        edited(good, "system", "D", 11, 8, value=lambda v: str(-4 * Fraction(v) - 4)),  # and of the last
        edited(good, "proof", "P", 0, 0, value=lambda v: str(Fraction(v) / 2)),
        edited(good, "multiplier", "terms", 8, "weight", value=lambda v: str(-Fraction(v))),
        edited(
            good, "multiplier", "terms", 8, "reach", value=lambda v: str(Fraction(v) / 2)
        ),  # what reaches it is more
        edited(good, "multiplier", "terms", 8, "sector", 0, value=lambda v: str(Fraction(v) + Fraction(1, 20))),
        edited(good, "multiplier", "terms", value=terms[:8] + terms[9:]),  # of one neuron nothing
        edited(good, "laws", "graphs", 8, "reach", value=lambda v: str(Fraction(v) / 2)),
    ):
        assert_both_reject(bad)


# |u| <= 0.26 |y_1| + 0.16 |y_2|, as |tanh v| <= |v|: too little to unsettle x'' = -2 x - 3 x' + u.
def test_a_network_of_little_gain_is_stable_from_everywhere():
    network = Network.given([[[0.5, 0.2], [-0.3, 0.4]], [[0.5, -0.25]], [[-0.8]]], activation="tanh")
    plant = network.closed(as_plant(([[0, 1], [-2, -3]], [[0], [1]], [[1, 0], [0, 1]], 0)))
    found = region(plant, network.nonlinearities())
    assert found.sets[0].kind == "everything"
    assert certify(plant, network.nonlinearities()).verdict is Verdict.PROVED


def test_the_drawing_follows_the_network(folder, proof):
    system = read_system(folder / "plant.toml")
    one = AttractedSet(kind="ellipsoid", P=matrix_of(proof.certificate), level=Fraction(1), volume=1.0, proof=proof)
    found = RegionOfAttraction(
        verdict=Verdict.PROVED,
        states=2,
        sets=(one,),
        area=(1.0, None),
        plant=system.block,
        nonlinearities=system.nonlinearities,
    )
    axes = found.plot(ax=Figure().add_subplot())
    paths = [line.get_xydata() for line in axes.get_lines() if len(line.get_xydata()) > 30]
    assert paths
    network = read_network(folder / "weights.json", activation="tanh", saturation=1)
    x = paths[0][0]
    moved = [x[0] + 0.1 * x[1], 0.4 * np.sin(x[0]) + 0.9 * x[1] + 0.5 * network(x)[0]]
    assert np.allclose(paths[0][1], moved, atol=1e-9)


def test_the_file_reads_back_with_one_channel_a_neuron(folder):
    system = read_system(folder / "plant.toml")
    assert system.block.inputs == 12
    again = parse_system(loop_to_toml(system), name="again", source="a text")
    assert (again.block, again.nonlinearities) == (system.block, system.nonlinearities)


# Yin, Seiler, Arcak (2022): |v1| <= 0.1 and |x1| <= 0.73 give the area 1.74987 by the least trace.
@pytest.mark.thorough
def test_the_published_pendulum_is_certified_on_the_published_intervals():
    system = read_system(files("lure.networks") / "pendulum.toml")
    shapes = [shape_of(one) for one in system.nonlinearities]
    found = proved_on(system.block, shapes, [Fraction("0.73"), *[Fraction("0.1")] * 32, *[None] * 33], None)
    assert 2.2 < volume_below(matrix_of(found.certificate)) < 2.25
    assert recheck(json.dumps(dict(found.certificate))).accepted


@pytest.mark.thorough
def test_the_published_pendulum_has_a_larger_region_with_other_intervals():
    found = region(read_system(files("lure.networks") / "pendulum.toml"))
    assert found.area[0] > 7.6


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"weights.json"', '"none.json"', "controller: the file of the network"),
        ('"weights.json"', '"weights.csv"', "none of the endings"),
        ('"weights.json"', "3", "give the path of a file in quotes"),
        ('activation = "tanh"\n', "", "does not say what its neurons do"),
        ('"tanh"', '"sigmoid"', "choose from tanh, relu"),
        ("saturation = 1", "saturation = -1", "give a positive bound"),
        (
            "Bu = [[0], [0.5]]",
            "Bu = [[0, 1], [0.5, 1]]",
            "Bu has 2 rows of 2 numbers; with 2 states and a network of 2 ",
        ),
        ("Bu = [[0], [0.5]]", "Bu = [[0], [0.5], [1]]", "Bu has 3 rows of 1 number; with 2 states"),
        ("Bu = [[0], [0.5]]", "Bu = [[0], [0.5]]\nCy = [[1, 0]]", "Cy has 1 row of 2 numbers"),
        ('"weights.json"', '"."', "is a folder; give the path of a file in it"),
        ("Bu = [[0], [0.5]]", "Cy = [[1, 0]]", "Cy is given without Bu"),
        ('"tanh"', '"tanh"\nnegative_slope = 0.1', "goes with the activation 'leaky relu'"),
        ("[controller]", "[class]\nsector = [0, 1]\n[controller]", "it is given beside [controller]"),
    ],
)
def test_bad_controllers_are_refused_in_a_sentence(folder, capsys, old, new, words):
    file = folder / "bad.toml"
    file.write_text(FILE.replace(old, new))
    assert main(["region", str(file)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert words in said


# x' = -x + u, u = 1 - max(x + 1/2, 0): x = 1 - x - 1/2 at x = 1/4, where the neuron sees 3/4 and turns at x = -1/2.
# Around there x' = -2 x while x > -3/4, and x' = -x + 3/4 below: every solution tends to 1/4.
BIASED = {"weights": [[[1]], [[-1]]], "biases": [["1/2"], [1]], "activation": "relu"}
BIASED_FILE = """
[plant]
A = [[-1]]
[controller]
network = "biased.json"
origin = "equilibrium"
Bu = [[1]]
"""


def test_a_network_with_biases_is_taken_around_its_equilibrium(tmp_path, capsys):
    (tmp_path / "biased.json").write_text(json.dumps(BIASED | {"biases": [[0.5], [1]]}))
    (tmp_path / "loop.toml").write_text(BIASED_FILE)
    system = read_system(tmp_path / "loop.toml")
    assert "x counted from (0.25)" in system.title
    assert "through (-0.75, -0.75), (0, 0)" in str(system.nonlinearities[0])
    assert "wherever it starts" in str(region(system))
    assert certify(system).verdict is Verdict.PROVED
    (tmp_path / "loop.toml").write_text(BIASED_FILE.replace('origin = "equilibrium"\n', ""))
    assert main(["certify", str(tmp_path / "loop.toml")]) == 2
    assert "rests at x = (0.25); write origin = 'equilibrium'" in " ".join(capsys.readouterr().err.split())


# Around the equilibrium the loop of closed() moves as the plant and the network do, whatever the layers, in both times.
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), activation=st.sampled_from(["tanh", "relu", "leaky relu", "saturation"]))
def test_the_loop_around_an_equilibrium_moves_as_the_network_does(seed, activation):
    rng = np.random.default_rng(seed)
    sizes = [2, *rng.integers(1, 5, size=rng.integers(1, 3)), 1]
    network = Network.given(
        [np.round(rng.normal(size=(after, before)) / 2, 2) for before, after in pairwise(sizes)],
        [np.round(rng.normal(size=after), 2) for after in sizes[1:]],
        activation=activation,
        negative_slope=0.1 if activation == "leaky relu" else None,
        saturation=None if seed % 2 else 0.5,
    )
    discrete = bool(seed % 3)
    A, B = np.round(rng.normal(size=(2, 2)), 1) + (0 if discrete else -3) * np.eye(2), np.array([[0.5], [1.0]])
    A = A / 4 if discrete else A
    plant = as_plant((A.tolist(), B.tolist(), [[1, 0], [0, 1]], 0), dt=1 if discrete else None)
    try:
        found = equilibrium(network, plant)
    except InputError as error:  # there may be none
        assert "no equilibrium" in str(error)  # noqa: PT017  (which it is, is what is tested)
        return
    rest, x = np.array([float(v) for v in found.x]), rng.normal(size=2)
    assert np.allclose(A @ rest + B @ network(rest), rest if discrete else 0, atol=1e-9)
    moved = found.plant.doubles()[0] @ x - found.plant.doubles()[1] @ phi_of(found.plant, found.nonlinearities, x)
    there = A @ (x + rest) + B @ network(x + rest)
    assert np.allclose(moved, there - rest if discrete else there, atol=1e-9)


# x'' = x + u, u = 1 - max(4 x + 2 x' + 1, 0): around 0 the neuron is active, x'' = -3 x - 2 x'.  No sector
# from 0 on, which is all that a ReLU at its kink has, would do: with u = 0 the plant is unstable.
@pytest.mark.slow
def test_a_region_uses_that_a_neuron_is_active_around_the_equilibrium():
    network = Network.given([[[4, 2]], [[-1]]], [[1], [1]], activation="relu")
    loop = equilibrium(network, as_plant(([[0, 1], [1, 0]], [[0], [1]], [[1, 0], [0, 1]], 0)))
    assert loop.x == (0, 0)
    found = region(loop.plant, loop.nonlinearities)
    assert found.area[0] > 1
    assert recheck(json.dumps(dict(found.sets[0].proof.certificate))).accepted


# Around each equilibrium all neurons are lines, and the loop is linear and stable: some ellipsoid is invariant, whose
# strip is |sigma| < 2235/184 with slope 1/10; < 5/8, 3/8 with none; < 16/3 with none before an output at its limit.
@pytest.mark.slow_for("A1-network1")
@pytest.mark.parametrize(
    ("A", "network"),
    [
        ([[-0.5, 0.125], [1.125, -0.5]], ([[[1, 1.25]], [[0.5]]], [[-1.125], [-1]], "leaky relu", Fraction(1, 10))),
        (
            [[-0.875, 0.375], [0.375, -0.375]],
            ([[[4, 0.75], [3.5, 2]], [[1, 0]]], [[-0.625, -0.375], [0]], "relu", None),
        ),
        ([[-0.375, -0.25], [0.375, -0.125]], ([[[-0.375, -2.25]], [[-0.875]]], [[0], [1.125]], "relu", None)),
    ],
)
def test_a_region_is_found_wherever_neurons_are_lines(A, network):
    weights, biases, activation, slope = network
    given = Network.given(
        weights, biases, activation=activation, negative_slope=slope, saturation=1 if biases[1] == [1.125] else None
    )
    loop = equilibrium(given, as_plant((A, [[0], [1]], [[1, 0], [0, 1]], 0)))
    shapes = [shape_of(one) for one in loop.nonlinearities]
    found = proved_ellipsoid(loop.plant, shapes, None)
    assert found is not None
    assert recheck(json.dumps(dict(found.certificate))).accepted


# x' = -x + 1 - tanh(x + 1/2) falls in x: it is positive below its one zero and negative above.
def test_the_equilibrium_of_tanh_neurons_lies_where_it_is_said_to():
    network = Network.given([[[1]], [[-1]]], [[Fraction(1, 2)], [1]], activation="tanh")
    found = equilibrium(network, as_plant(([[-1]], [[1]], [[1]], 0)))
    with working_precision(300):
        for side in (1, -1):
            x = found.x[0] - side * found.within
            moved = 1 - ball(x) - (ball(x + Fraction(1, 2))).tanh()
            assert moved * side > 0
    assert found.within <= Fraction(1, 2**100)
    assert found.nonlinearities[0].sector.upper < 1  # chords from 0.82 on are less steep than the tangent at 0


BIASED_TANH = {
    "weights": [[["0.8", "0.5"], ["-0.5", "1"]], [["-1.8", "-0.9"]]],
    "biases": [["0.3", "-0.2"], ["0.4"]],
    "activation": "tanh",
}
TANH_FILE = """
[plant]
A = [[0, 1], [1, 0]]
B = [[0], [1]]
C = [[1, 0]]
[nonlinearity]
kind = "expression"
expression = "sigma - sin(sigma)"
[controller]
network = "tanh.json"
saturation = 3
Bu = [[0], [2]]
origin = "equilibrium"
"""


@pytest.fixture(scope="module")
def biased(tmp_path_factory):
    """A pendulum held by two tanh neurons with biases, an output with a limit, and the proof of an ellipsoid."""
    folder = tmp_path_factory.mktemp("biased")
    (folder / "tanh.json").write_text(json.dumps(BIASED_TANH))
    (folder / "loop.toml").write_text(TANH_FILE)
    system = read_system(folder / "loop.toml")
    plant, shapes = parted(
        *loop_asked(system, None)
    )  # the limit acts in two channels: one that is exact, and what is left
    assert plant.inputs == system.block.inputs + 1 == 5
    reaches = [Fraction(12, 25), Fraction(43, 100), Fraction(6, 5)]
    return system, proved_on(plant, shapes, [*reaches, None, None], None).certificate


# x2' = sin(x1) + 2 sat(N(x)): counted from the equilibrium, where sin(x1) = -2 N(x), all motions in the set come back.
@pytest.mark.slow
def test_a_loop_of_tanh_neurons_with_biases_has_a_certified_region(biased):
    system, certificate = biased
    again = parse_system(loop_to_toml(system), name="again", source="a text")
    assert (again.block, again.nonlinearities) == (system.block, system.nonlinearities)
    assert recheck(json.dumps(dict(certificate))).accepted
    network = Network.given(**BIASED_TANH, saturation=3)
    low, high = 0.0, 1.0  # sin x + 2 N(x, 0) falls from positive to negative values
    for _ in range(60):
        x1 = (low + high) / 2
        low, high = (x1, high) if np.sin(x1) + 2 * network([x1, 0.0])[0] > 0 else (low, x1)
    assert f"x counted from ({x1:.6g}, 0), to within 7.9e-31" in system.title
    P = np.array(matrix_of(certificate), dtype=float)
    assert np.pi / np.sqrt(np.linalg.det(P)) > 1
    z = np.random.default_rng(2).normal(size=(1000, 2))
    rest = np.array([x1, 0.0])
    x = np.linalg.solve(np.linalg.cholesky(P).T, (z / np.linalg.norm(z, axis=1)[:, None]).T).T + rest

    def rate(x):
        return np.stack([x[:, 1], np.sin(x[:, 0]) + 2 * network(x)[:, 0]], axis=1)

    before = np.ones(len(x))
    for _ in range(300):
        half = x + 0.01 * rate(x)
        x = x + 0.02 * rate(half)
        now = np.einsum("ki,ij,kj->k", x - rest, P, x - rest)
        assert np.all(now < before + 1e-9)
        before = now
    assert before.max() < 0.2


def test_a_biased_network_with_a_limit_is_proved_from_everywhere_where_its_class_is():
    # |N| <= 1.5 |4 x1 + 2 x2| around a plant of gain 1: with slope 1 of the neuron the loop is s^2 + 4 s + 7
    network = Network.given([[[4, 2]], [[-1.5]]], [[0.5], [0.5]], activation="tanh", saturation=1)
    found = equilibrium(network, as_plant(([[0, 1], [-1, -1]], [[0], [1]], [[1, 0], [0, 1]], 0)))
    assert region(found.plant, found.nonlinearities).sets[0].kind == "everything"


def test_a_changed_region_of_a_biased_network_is_refused_by_both(biased):
    good = biased[1]
    assert {one["kind"] for one in good["laws"]["graphs"]} == {"sector", "piecewise-polynomial"}
    for bad in (
        edited(good, "proof", "P", 0, 0, value=lambda v: str(Fraction(v) / 2)),
        edited(good, "multiplier", "terms", 1, "sector", 0, value=lambda v: str(Fraction(v) + Fraction(1, 50))),
        edited(good, "laws", "graphs", 4, "sector", value=["-1", "1"]),  # more is left of the limit than was used
        edited(good, "multiplier", "terms", value=good["multiplier"]["terms"][:4]),
        edited(good, "laws", "graphs", 3, "cuts", 1, value=lambda v: str(Fraction(v) / 2)),
        edited(good, "system", "D", 4, 1, value=lambda v: str(1000 * Fraction(v))),
    ):
        assert_both_reject(bad)


def test_what_has_no_equilibrium_or_none_that_can_be_moved_to_is_refused():
    plant = as_plant(([[-1, 0], [0, -2]], [[1], [1]], [[1, 0]], 0))
    # x1' = -x1 + |x1| + 1: none for x1 < 0, as -2 x1 + 1 > 0, nor for x1 > 0, where it is 1
    both = Network.given([[[1], [-1]], [[1, 1]]], [[0, 0], [1]], activation="relu")
    with pytest.raises(InputError, match="no equilibrium of the loop"):
        equilibrium(both, plant)
    tanh = Network.given([[[1]], [[1]]], [[0], [2]], activation="tanh")  # x' = tanh(x) + 2 > 0
    with pytest.raises(InputError, match="no equilibrium of the loop"):
        equilibrium(tanh, as_plant(([[0]], [[1]], [[1]], 0)))
    # x = 1 + tanh(0), at which a saturation of the plant that sees x has its kink
    kink = Network.given([[[0]], [[1]]], [[0], [1]], activation="tanh")
    own = as_plant(([[-1]], [[0, 1]], [[1], [1]], [[0, 0], [0, 0]]))
    with pytest.raises(InputError, match="it may lie at a kink"):
        equilibrium(kink, own, [Saturation(limit=1)])
    with pytest.raises(InputError, match="only piecewise linear ones, tanh, cubics and smooth formulas are moved"):
        equilibrium(kink, own, [Quantiser(step=1)])
    bent = ExpressionNonlinearity("sigma*abs(sigma)/(1 + sigma**2)")  # without a second derivative at 0
    with pytest.raises(InputError, match="only piecewise linear ones, tanh, cubics and smooth formulas are moved"):
        equilibrium(kink, own, [bent])
