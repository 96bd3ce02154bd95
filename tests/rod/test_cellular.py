"""lure.rod.cellular: the dynamics (40)-(41), the rod through it (42)-(49), and two classical networks."""

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import AssumptionError, InputError
from lure.analysis.rod.simulation import simulate
from lure.rod import Rod, Scenario, builtin_system, initial_state, upwind
from lure.rod.cellular import (
    CellularNetwork,
    Template,
    chua_yang,
    chua_yang_energy,
    diffusion_network,
    edge_network,
    rod_network,
    rod_ring,
    saturation,
)
from lure.rod.systems import paper_rod

BOUNDARIES = ("fixed", "zero-flux", "periodic")
seeds = st.integers(0, 10**6)


def neighbour(cell, offset, shape, boundary):
    """The cell read, or None for the virtual one; mirror images fold back across either edge until they are inside."""
    place = []
    for i, k, n in zip(cell, offset, shape, strict=True):
        j = i + k
        if boundary == "periodic":
            j %= n
        elif boundary == "zero-flux":
            while not 0 <= j < n:
                j = -1 - j if j < 0 else 2 * n - 1 - j
        elif not 0 <= j < n:
            return None
        place.append(j)
    return tuple(place)


def loops(shape, tables, boundary, edge):
    """sum of table[o] * value[cell + o], one cell and one neighbour at a time, straight from (40)."""
    table, values = tables
    total, radius = np.zeros(shape), table.shape[0] // 2
    for cell in np.ndindex(shape):
        for place in np.ndindex(table.shape):
            read = neighbour(cell, tuple(p - radius for p in place), shape, boundary)
            total[cell] += table[place] * (edge if read is None else values[read])
    return total


@given(
    seed=seeds,
    shape=st.one_of(st.tuples(st.integers(1, 6)), st.tuples(st.integers(1, 4), st.integers(1, 5))),
    radius=st.integers(0, 3),
    boundary=st.sampled_from(BOUNDARIES),
)
def test_the_right_hand_side_is_the_sum_40_cell_by_cell(seed, shape, radius, boundary):
    rng = np.random.default_rng(seed)
    A, B, C = (rng.normal(size=(2 * radius + 1,) * len(shape)) for _ in range(3))
    x, u, bias = 2.0 * rng.normal(size=shape), rng.normal(size=shape), rng.normal(size=shape)
    network = CellularNetwork(
        shape=shape,
        A=Template.uniform(A),
        B=Template.uniform(B),
        C=Template.uniform(C),
        bias=bias,
        boundary=boundary,
        edge_state=1.7,
        edge_input=-0.4,
    )
    f = 0.5 * (np.abs(x + 1) - np.abs(x - 1))
    expected = loops(shape, (A, f), boundary, 1.0) + loops(shape, (B, u), boundary, -0.4)  # f(1.7) = 1
    expected += bias - loops(shape, (C, x), boundary, 1.7)
    assert np.allclose(network.rhs(0.0, x, u), expected, rtol=1e-12, atol=1e-12)


@given(x=st.floats(-1e6, 1e6))
def test_the_output_is_41(x):
    assert saturation(x) == pytest.approx(0.5 * (abs(x + 1) - abs(x - 1)), abs=1e-9)


# a conductivity c(i) between the cells i and i+1 varies along the line: the flux form, written out by hand
def test_a_regularly_varying_template_is_read_at_each_place():
    between = np.array([0.0, 2.0, 5.0, 3.0, 0.0])  # between cells -1|0, 0|1, 1|2, 2|3, 3|4
    varying = Template.varying({-1: lambda i: between[i], 0: lambda i: -between[i] - between[i + 1], 1: between[1:]})
    network = CellularNetwork(shape=(4,), A=varying, C=Template.varying({0: 0.0}), output="linear", boundary="fixed")
    expected = [[-2, 2, 0, 0], [2, -7, 5, 0], [0, 5, -8, 3], [0, 0, 3, -3]]
    assert network.matrix().toarray().tolist() == expected
    plane = Template.varying({(0, 1): lambda i, j: 10.0 * i + j})
    grid = CellularNetwork(shape=(2, 3), A=plane, output="linear", boundary="periodic")
    x = np.arange(6.0).reshape(2, 3)
    assert grid.rhs(0.0, x).tolist() == [[0 - 0, 2 - 1, 0 - 2], [40 - 3, 55 - 4, 36 - 5]]


@given(
    seed=seeds,
    N=st.integers(1, 40),
    k=st.just(0.0) | st.floats(1e-9, 5),
    form=st.sampled_from(("corrected", "as-printed")),
)
def test_the_network_49_is_the_matrix_form_for_every_n(seed, N, k, form):
    rng = np.random.default_rng(seed)
    rod = Rod(youngs_modulus=3.0, density=2.0, length=1.5, area=0.7, damping=k, compliance=0.2, exponent=1.5)
    scheme, g = upwind(rod, N, form=form, ordering="eq48"), float(rng.normal())
    y = rng.normal(size=2 * N + 1)  # z of either sign
    mu = -float(rod.nonlinearity(y[N]))
    expected = scheme.A @ y + scheme.b1 * mu + scheme.b2 * g
    found = rod_network(scheme, lambda t: g * t).rhs(1.0, y)
    assert np.allclose(found, expected, rtol=1e-13, atol=1e-13 * scheme.rate * np.abs(y).max())
    if N > 1:
        assert max(abs(k) for o in rod_network(scheme).A.offsets for k in o) == 2


@given(seed=seeds, N=st.integers(1, 40), form=st.sampled_from(("corrected", "as-printed")))
def test_the_ring_42_and_the_simple_network_43_are_the_matrix_form(seed, N, form):
    rng = np.random.default_rng(seed)
    scheme, rod = upwind(paper_rod("0.3"), N, form=form), paper_rod("0.3")
    y, g = rng.normal(size=2 * N + 1), float(rng.normal())
    p = float(rod.nonlinearity(y[-1]))
    ring, u = rod_ring(scheme), np.zeros(2 * N)
    u[0], u[N] = g, p
    expected = scheme.A @ y - scheme.b1 * p + scheme.b2 * g
    found = np.append(ring.rhs(0.0, y[:-1], u), y[N - 1] - rod.mobility * p)
    assert np.allclose(found, expected, rtol=1e-13, atol=1e-12 * scheme.rate)
    assert np.array_equal(ring.matrix().toarray(), upwind(rod, N).A.toarray()[:-1, :-1])


# contact within the run: z starts 1e-4 short of the obstacle and the end swings by 2e-4
def test_the_rod_moves_as_the_event_exact_simulation_of_the_scheme_says():
    rod = Rod(youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=2e-1, compliance=2e-10, gap=1e-5)
    scenario = Scenario(displacement=builtin_system("paper-rod").scenario.displacement)
    scheme = upwind(rod, 10, ordering="eq48")
    until = 8 * rod.travel_time
    run = rod_network(scheme).simulate(initial_state(scheme, scenario), until=until, samples=81, at_rest=1e-300)
    exact = simulate(scheme, scenario, until=until, samples=81)
    assert exact.contact
    assert run.t.size == 81
    assert np.abs(run.x[:, 10] - exact.z).max() < 1e-7 * np.abs(exact.z).max()


def mode(n, m, boundary):
    """A mode of the second difference on n cells, and its phi: Laplacian eigenvalue -4 sin^2(phi/2)."""
    i = np.arange(n)
    if boundary == "periodic":
        return np.cos(2 * np.pi * m * i / n + 0.3), 2 * np.pi * m / n
    if boundary == "zero-flux":
        return np.cos(np.pi * m * (i + 0.5) / n), np.pi * m / n
    return np.sin(np.pi * (m + 1) * (i + 1) / (n + 1)), np.pi * (m + 1) / (n + 1)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("modes", [(3,), (2, 1)])
def test_a_diffusion_template_follows_the_exact_discrete_solution(boundary, modes):
    shape, rate = ((12,), 1.5) if len(modes) == 1 else ((7, 9), 0.8)
    parts = [mode(n, m, boundary) for n, m in zip(shape, modes, strict=True)]
    x0 = parts[0][0] if len(parts) == 1 else np.outer(parts[0][0], parts[1][0])
    decay = rate * sum(4 * np.sin(phi / 2) ** 2 for _, phi in parts)
    run = diffusion_network(shape, rate, boundary=boundary).simulate(x0, until=2.0 / decay, samples=9)
    expected = np.exp(-decay * run.t).reshape(-1, *[1] * x0.ndim) * x0
    assert np.abs(run.x - expected).max() < 1e-8
    assert not run.steady


@pytest.mark.slow_for("4000000.0")
@pytest.mark.parametrize("until", [400.0, 4e6])  # the second takes the implicit method
def test_diffusion_rests_at_the_mean_without_flux_and_at_the_edge_value_if_that_is_fixed(until):
    x0 = np.arange(5.0)
    free = diffusion_network((5,), 1.0).simulate(x0, until=until)
    held = diffusion_network((5,), 1.0, boundary="fixed", edge_state=7.0).simulate(x0, until=until)
    assert free.steady
    assert held.steady
    assert max(free.t[-1], held.t[-1]) < until
    assert np.allclose(free.x[-1], 2.0, atol=1e-6)
    assert np.allclose(held.x[-1], 7.0, atol=1e-6)


def edges(image):
    """Black pixels with a white pixel among the eight around them; white outside."""
    padded = np.pad(image, 1, constant_values=-1)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    return np.where((image > 0) & (windows.min(axis=(2, 3)) < 0), 1.0, -1.0)


def test_the_edge_of_a_square_and_a_line_by_hand():
    picture = ["........", ".#####.#", ".#####.#", ".#####.#", ".#####.#", ".#####..", "........"]
    outline = ["........", ".#####.#", ".#...#.#", ".#...#.#", ".#...#.#", ".#####..", "........"]
    image, expected = ([[1.0 if c == "#" else -1.0 for c in row] for row in rows] for rows in (picture, outline))
    run = edge_network((7, 8)).simulate(0.0, u=image, until=60.0)
    assert run.steady
    assert np.allclose(run.output[-1], expected, atol=1e-6)


@pytest.mark.slow
@given(seed=seeds, black=st.floats(0.2, 0.98))
@settings(max_examples=sampled(3, of=100))
def test_edges_are_found_from_every_initial_state(seed, black):
    rng = np.random.default_rng(seed)
    image = np.where(rng.random((6, 7)) < black, 1.0, -1.0)
    run = edge_network(image.shape).simulate(rng.uniform(-3, 3, image.shape), u=image, until=60.0, samples=2)
    assert run.steady
    assert np.allclose(run.output[-1], edges(image), atol=1e-6)


@pytest.mark.slow
@given(seed=seeds, boundary=st.sampled_from(BOUNDARIES))
@settings(max_examples=sampled(6, of=100))
def test_the_energy_falls_and_outputs_become_binary_under_the_hypotheses(seed, boundary):
    rng = np.random.default_rng(seed)
    p, q, r, middle = *rng.normal(size=3), 1.5 + rng.random()
    A = Template.uniform([[p, q, r], [q, middle, q], [r, q, p]])
    network = CellularNetwork(
        shape=(4, 5),
        A=A,
        B=Template.uniform(rng.normal(size=(3, 3))),
        bias=rng.normal(),
        boundary=boundary,
        edge_state=0.4,
    )
    verdict = chua_yang(network)
    if boundary == "zero-flux" and not verdict.holds:
        return  # mirror images need not keep the interconnections symmetric: then nothing is claimed
    assert verdict.holds
    x0, u = rng.normal(size=(4, 5)), rng.normal(size=(4, 5))
    run = network.simulate(x0, u=u, until=200.0, samples=400)
    V = np.array([chua_yang_energy(network, x, u) for x in run.x])
    assert np.all(np.diff(V) <= 1e-9 * np.abs(V).max())
    assert V[-1] < V[0]
    assert run.steady
    if verdict.binary:
        assert np.allclose(np.abs(run.output[-1]), 1.0, atol=1e-6)


# x1' = -x1 + 2 f(x1) - 4 f(x2), x2' = -x2 + 4 f(x1) + 2 f(x2): antisymmetric coupling, the origin a focus with
# eigenvalues 1 +- 4i, no equilibrium elsewhere: it turns for ever
@pytest.mark.slow
def test_an_antisymmetric_template_is_refused_and_does_oscillate():
    network = CellularNetwork(shape=(2,), A=Template.uniform([4, 2, -4]), boundary="fixed")
    assert not chua_yang(network).holds
    with pytest.raises(AssumptionError, match=r"not symmetric; two of its weights differ by 8$"):
        chua_yang_energy(network, [0.0, 0.0])
    run = network.simulate([0.1, 0.0], until=40.0, samples=401)
    assert run.steady is False
    assert np.ptp(run.x[200:, 0]) > 2.0
    assert "nothing" in str(chua_yang(network))


def test_the_obstacles_to_the_theorem_are_named():
    symmetric = Template.uniform([1, 2, 1])
    cases = {
        "saturation": CellularNetwork(shape=(3,), A=symmetric, output="linear"),
        "changes in time": CellularNetwork(shape=(3,), A=symmetric, bias=lambda t: t),
        "own state": CellularNetwork(shape=(3,), A=symmetric, C=Template.uniform([1, 2, 1])),
        "positive": CellularNetwork(shape=(3,), A=symmetric, C=Template.uniform([-1])),
    }
    for words, network in cases.items():
        assert words in str(chua_yang(network))
    assert chua_yang(CellularNetwork(shape=(3,), A=symmetric)).binary
    assert not chua_yang(CellularNetwork(shape=(3,), A=Template.uniform([1, 1, 1]))).binary


def test_a_network_on_an_unstable_equilibrium_looks_steady_at_once():
    run = CellularNetwork(shape=(3,), A=Template.uniform([2.0])).simulate(0.0, until=5.0)
    assert run.steady
    assert run.t.tolist() == [0.0]


def test_rest_is_not_looked_for_where_the_bias_changes_in_time():
    # x' = -x + cos t from 1/2: x = (cos t + sin t)/2, since C = 1 and A = 0
    network = CellularNetwork(shape=(1,), A=Template.varying({0: 0.0}), bias=np.cos)
    run = network.simulate(0.5, until=7.0, samples=50)
    assert run.steady is None
    assert np.abs(run.x[:, 0] - 0.5 * (np.cos(run.t) + np.sin(run.t))).max() < 1e-8


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Template.uniform([1, 2]), r"shape \(2,\); give"),
        (lambda: Template.uniform(np.ones((3, 5))), r"shape \(3, 5\)"),
        (lambda: Template.varying({}), "0 offsets"),
        (lambda: Template.varying({(0, 0): 1.0, (1,): 1.0}), "one number each"),
        (lambda: CellularNetwork(shape=(3, 3), A=Template.uniform([1])), "dimension 1 does not fit"),
        (lambda: CellularNetwork(shape=(0,), A=Template.uniform([1])), "positive whole numbers"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1]), boundary="open"), "give one of fixed"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1]), output="tanh"), "give saturation, linear"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1]), output=np.tanh), "no virtual cell"),
        (lambda: CellularNetwork(shape=(3,), A=Template.varying({0: [1.0, 2.0]})), r"offset \(0,\) has shape \(2,\)"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([np.nan])), "not finite"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1]), bias=[1.0]), r"bias has shape \(1,\)"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1])).rhs(0.0, [1.0]), r"states of shape \(1,\)"),
        (lambda: CellularNetwork(shape=(3,), A=Template.uniform([1])).matrix(), 'needs output="linear"'),
        (lambda: edge_network((2, 2)).simulate(0.0, until=-1.0), "until is -1.0"),
        (lambda: edge_network((2, 2)).simulate(0.0, until=1.0, samples=1), "samples is 1"),
        (lambda: edge_network((2, 2)).simulate(0.0, until=1.0, at_rest=0.0), "at_rest is 0.0"),
        (lambda: edge_network((2, 2)).simulate([1.0], until=1.0), r"x0 has shape \(1,\)"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_name(make, message):
    with pytest.raises(InputError, match=message):
        make()
