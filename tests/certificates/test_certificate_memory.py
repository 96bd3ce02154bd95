"""Play and stop operators: certificates by hand, what neither checker accepts, and the operators themselves."""

import copy
from dataclasses import replace
from fractions import Fraction
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from certificate_format import FORMAT
from flint import fmpq, fmpq_mat
from second_plants import PLAIN
from second_plants import asked as as_asked
from tampering import assert_both_reject, edited, refused_again

from lure import InputError, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis import l2_gain
from lure.analysis.certificates import memory as first
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import channels, plant
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check, contains
from lure.analysis.certificates.second import memory as second
from lure.analysis.certificates.second.opinion import recheck
from lure.files import find_system
from lure.files.loop import loop_to_toml

PLAY, STOP = NonlinearityClass.hysteretic("play"), NonlinearityClass.hysteretic("stop")
LAG = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": [["1"]], "C": [["1"]], "D": [["0"]]}


def memory(kind, k):
    bounds = {"sector": ["0", str(k)], "slope": ["0", str(k)], "odd": False, "time_varying": False, "linear": False}
    return bounds | {"memory": kind}


def draft(system, one, **more):
    return {"verdict": "PROVED", "system": system, "laws": {"channels": [one], "repeated": False}, **more}


def growing(system, kind, gain):
    proof = {"method": "linear-gains", "gains": [gain], "growth": "1/2"}
    return draft(system, memory(kind, 1), theorem="counterexample", proof=proof) | {"verdict": "REFUTED"}


# y = x', y' = -y - g y: with V = y^2 and lambda = 1/2 there is 2 y^2 + 2 y phi - phi (y - phi), of determinant 7/4
PROVED = draft(
    LAG,
    memory("stop", 1),
    theorem="diagonal-circle",
    multiplier={"lambda": ["1/2"]},
    proof={"method": "matrix", "P": [["1"]], "exponent": 0},
)
GROWS = growing(LAG | {"B": [["-2"]]}, "play", "1")  # x' = -x + 2 play: at the rate 1
BOUNDED = growing(LAG | {"A": [["1"]]}, "stop", "0")  # x' = x - stop, the stop bounded
MAP = growing(LAG | {"A": [["2"]], "time": "discrete"}, "stop", "0")
# x' = -x - stop - f, sigma = (x, y), y = -x - stop: y' = f - y - psi, x' = y - f.  With V = y^2, lambda = 1 for the
# stop and 4 for f in [0, 1/2] the form in (y, psi, f) is -[2, 0, -3; 0, 2, 1; -3, 1, 8], of determinant 32 - 2 - 18
BESIDE = {"sector": ["0", "1/2"], "slope": None, "odd": False, "time_varying": True, "linear": False}
MIXED = draft(
    LAG | {"B": [["1", "1"]], "C": [["1"], ["-1"]], "D": [["0", "0"], ["1", "0"]]},
    memory("stop", 1),
    theorem="diagonal-circle",
    multiplier={"lambda": ["1", "4"]},
    proof={"method": "matrix", "P": [["1"]], "exponent": 0},
)
MIXED["laws"]["channels"].append(BESIDE)
ALL = {"proved": PROVED, "grows": GROWS, "bounded": BOUNDED, "map": MAP, "mixed": MIXED}
CONVERGES = "every motion converges to the set of equilibria"
MOVES = "a loop of the class has a motion that does not converge to an equilibrium"


PARTS = ("verdict", "system", "laws", "theorem", "multiplier", "proof")


@cache
def certificate(name):
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    check(found)
    assert recheck(found).accepted
    assert found["conclusion"] == (CONVERGES if name in ("proved", "mixed") else MOVES)


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        ("proved", ("laws", "channels", 0, "memory"), "relay"),
        ("proved", ("laws", "channels", 0, "odd"), True),
        ("proved", ("laws", "channels", 0, "slope"), ["-1", "1"]),
        ("proved", ("laws", "channels", 0), memory("stop", 20)),
        ("proved", ("system", "B"), [["-2"]]),
        ("proved", ("system", "A"), [["0"]]),
        ("proved", ("system", "D"), [["1"]]),
        ("proved", ("theorem",), "diagonal-popov"),
        ("grows", ("proof", "growth"), "2"),
        ("grows", ("proof", "growth"), "0"),
        ("grows", ("proof", "gains"), ["2"]),
        ("grows", ("proof", "gains"), ["0"]),
        ("grows", ("laws", "channels", 0, "memory"), "stop"),
        ("bounded", ("laws", "channels", 0, "memory"), "play"),
        ("bounded", ("system", "A"), [["1/3"]]),
        ("map", ("system", "A"), [["1"]]),
        ("mixed", ("laws", "channels", 1, "sector"), ["0", "73/100"]),  # 4 lambda - 1 > (1 + lambda u)^2 up to .718
        ("mixed", ("laws", "channels", 1, "sector"), ["-1/2", "1/2"]),
        ("mixed", ("laws", "channels", 1, "sector"), ["0", "inf"]),
        ("mixed", ("laws", "channels", 1), {**BESIDE, "time_varying": False, "regularity": "any"}),
        ("mixed", ("system", "D"), [["0", "0"], ["9/10", "0"]]),  # the stop moves sigma_2 at rest
        ("mixed", ("system", "D"), [["0", "0"], ["1", "9/10"]]),  # f of y - 9 f/10 in place of y
        ("mixed", ("system", "C"), [["1"], ["1"]]),
        ("mixed", ("system", "time"), "discrete"),
        ("mixed", ("multiplier", "lambda"), ["1", "0"]),
    ],
)
def test_neither_accepts_what_was_changed(name, path, value):
    assert_both_reject(edited(certificate(name), *path, value=value))


KERNEL = {"channels": [1, 1], "coefficient": "1/9", "rate": "1", "order": 1, "side": "causal"}


@pytest.mark.parametrize(
    ("theorem", "multiplier"),
    [
        ("diagonal-popov", {"lambda": ["1/2"], "theta": ["1/100"]}),
        ("matrix-zames-falb", {"gamma": [["1"]], "theta": ["0"], "kernels": [KERNEL]}),
    ],
)
def test_popovs_terms_and_kernels_are_refused(theorem, multiplier):
    given = {**certificate("proved"), "theorem": theorem, "multiplier": multiplier, "proof": {"method": "determinant"}}
    with pytest.raises(Rejected):
        complete_and_check(given)
    assert refused_again(given)


@pytest.mark.parametrize("name", ["proved", "grows"])
def test_no_rate_is_shown_of_play_and_stop(name):
    given = {**certificate(name), "rate": "1/100"}  # which is one of the derivatives: the limits are not 0
    with pytest.raises(Rejected, match="at a rate"):
        complete_and_check(given)
    assert "limits" in recheck(given).reason


DAMPED = ([[0, 1], [-1, -1]], [[0, 0], [1, 1]], [[0, 1], [1, 0]], [[0, 0], [0, 0]])  # q'' + q' + q = -f(q') - phi(q)


def _sector(k, **more):
    return NonlinearityClass(sector=Sector(0, k), **more)


@pytest.mark.slow
def test_a_sector_beside_memory_is_covered_where_that_does_not_move_it_at_rest():
    # without f the circle criterion has Re 1/(1 - w^2 + i w) >= -1/3, at w^2 = 2; with V = q'^2 + q^2 + phi^2/k the
    # stop and any damper only take energy, so that storage functions have no end
    plant = as_plant(DAMPED)
    near = certify(plant, [_sector(2.999, time_varying=True), NonlinearityClass.hysteretic("play", 2.999)])
    assert near.verdict.name == "PROVED"
    assert_both_reject(edited(near.shown.certificate, "system", "D", 1, value=["1/999999", "0"]))  # f' in sigma_2'
    stop = NonlinearityClass.hysteretic("stop", 1000)
    for each in (_sector(1000), NonlinearityClass.slope_restricted(0, 1000)):
        shown = certify(plant, [each, stop])
        assert shown.verdict.name == "PROVED"
        assert "converges to the set of equilibria: channel 1: all time-invariant nonlinearities" in str(shown)
        assert recheck(shown.shown.certificate).accepted
    data = shown.shown.certificate  # whose Popov's term of f is for one that does not depend on time
    assert data["theorem"] == "storage-circle"
    assert Fraction(data["multiplier"]["theta"][0]) != 0
    assert_both_reject(edited(data, "laws", "channels", 0, "time_varying", value=True))
    assert_both_reject(
        edited(data, "multiplier", "theta", value=lambda theta: [str(-Fraction(theta[0]) * 9), theta[1]])
    )
    assert_both_reject(edited(data, "system", "D", 0, value=["1/9", "0"]))
    # without a spring the stop moves an eigenvalue 0, and the mass rests anywhere
    free = certify(as_plant(([[0, 1], [0, 0]], *DAMPED[1:])), [NonlinearityClass(sector=Sector(0.5, 1000)), stop])
    assert free.verdict.name == "PROVED"
    assert recheck(free.shown.certificate).accepted
    # f of q' + q/2: elsewhere at rest f may be steep
    moved = as_plant((*DAMPED[:2], [[0.5, 1], [1, 0]], DAMPED[3]))
    refused = certify(moved, [_sector(0.1), STOP])
    assert refused.verdict.name == "INCONCLUSIVE"
    assert "slope bounds would serve" in str(refused)
    assert certify(moved, [NonlinearityClass.slope_restricted(0, 0.1), STOP]).verdict.name == "PROVED"


@pytest.mark.slow
def test_a_proved_v_falls_along_solutions_with_steep_functions_beside_a_stop():
    # V = y'Py + Theta H(0) phi^2 + |theta| phi^2/k + 2 theta phi sigma of the stop, and 2 theta int f
    k = 5.0
    shown = certify(as_plant(DAMPED), [_sector(k), NonlinearityClass.hysteretic("stop", k)])
    data = shown.shown.certificate
    (turn, theta), half = (float(Fraction(v)) for v in data["multiplier"]["theta"]), data["proof"]
    a, b, c = (float(Fraction(v)) / 2 ** half["exponent"] for row in half["P"] for v in row)
    assert turn != 0 > theta
    grid = np.linspace(0, 20, 20_001)  # a damper that acts from the speed 0.4 on, with slopes up to 30
    force = k * grid * np.clip((grid - 0.4) / 0.1, 0, 1)
    work = np.concatenate([[0], np.cumsum((force[1:] + force[:-1]) / 2000)])
    rng, dt, rises = np.random.default_rng(4), 1e-3, {}
    for kind in ("stop", "play"):
        r = 10 ** rng.uniform(-1, 1, size=30)
        q, v = rng.normal(size=(2, 30)) * 3
        p, last, rise = q + r * rng.uniform(-1, 1, size=30), np.inf, np.zeros(30)
        for _ in range(3000):
            p = np.clip(p, q - r, q + r)
            phi, f = k * (q - p if kind == "stop" else p), np.sign(v) * np.interp(np.abs(v), grid, force)
            y = -q - v - phi
            V = a * v**2 + 2 * b * v * y + c * y**2 + 2 * turn * np.interp(np.abs(v), grid, work)
            V += (theta + abs(theta) / k) * phi**2 + 2 * theta * phi * q
            rise, last = np.maximum(rise, V - last), V
            q, v = q + dt * v, v + dt * (y - f)
        rises[kind] = (rise / np.abs(V).max()).max()
    assert rises["stop"] < 1e-4 < rises["play"]


def test_increments_of_play_and_stop_are_those_of_the_class_and_their_values_are_not():
    rng = np.random.default_rng(2)
    for _ in range(50):
        sigma, r, k = np.cumsum(rng.normal(size=200)), rng.uniform(0.1, 3), rng.uniform(0.1, 2)
        play = [rng.uniform(-r, r)]
        for value in sigma:
            play.append(min(max(play[-1], value - r), value + r))
        play = k * np.array(play[1:])
        for out in (play, k * sigma - play):
            rise, move = np.diff(out), np.diff(sigma)
            assert (rise * (k * move - rise)).min() > -1e-9
            assert (out * (k * sigma - out)).min() < 0  # so that Popov's theorem is not for them


def test_what_is_proved_in_discrete_time_comes_to_rest_not_always_at_zero():
    # x+ = x/2 + mu: with the gain k the eigenvalue is 1/2 - k > -1 for k < 3/2
    found = max_sector(as_plant("1/(z-0.5)", dt=1), [PLAY])
    assert found.largest.low == pytest.approx(1.5, rel=1e-6)
    assert found.refuted_at == pytest.approx(1.5, rel=1e-6)
    ends = set()
    for start in (0.0, 0.5, -0.5):  # of the play, which is at rest within its width
        x, p = 0.7, start
        for _ in range(400):
            p = min(max(p, x - 1), x + 1)
            x, before = x / 2 - 1.4 * p, x
        assert x == pytest.approx(before, abs=1e-9)
        ends.add(round(x, 6))
    assert len(ends) > 1


@pytest.mark.slow
def test_a_play_beside_a_slope_from_a_file_and_the_time_varying_circle(tmp_path):
    # Re 1/(1 + i w)^3 = cos^3 a cos 3a with tan a = w is least, -1/4, at a = pi/4: k < 4; growth from k = 8 on, and
    # periodic solutions before (test_certificate_memory_orbits.py)
    found = max_sector(as_plant("1/(s+1)^3"), [PLAY])
    assert found.largest.low == pytest.approx(4, rel=1e-6)
    assert 5.5 < found.refuted_at < 8
    assert "converges to the set of equilibria for every play phi of a slope in [0, 3.99999" in str(found)
    path = tmp_path / "loop.toml"
    path.write_text(
        '[plant]\ntransfer = [["1/(s+1)", "1/(s+2)"], ["-1/(s+1)", "1/(s+3)"]]\n'
        '[[class]]\nmemory = "stop"\nslope = [0, 2]\n[[class]]\nslope = [0, 1]\n'
    )
    system = find_system(str(path), [])
    assert str(system.classes) == "stop phi_1 of a slope in [0, 2]; phi_2 with slope in [0, 1]"
    assert certify(system).verdict.name == "PROVED"
    again = tmp_path / "again.toml"
    again.write_text(loop_to_toml(system))
    assert find_system(str(again), []).classes == system.classes


@pytest.mark.slow
def test_what_is_not_covered_beside_memory_is_inconclusive():
    rows = [["1/(s+1)", "0"], ["0", "1/(s+1)"]]
    for link, verdict in (("0", "PROVED"), ("1/(s+2)", "INCONCLUSIVE")):  # side by side, and one driving the other
        shown = certify(as_plant([rows[0], [link, rows[1][1]]]), [PLAY, NonlinearityClass.norm_bounded(0.1)])
        assert shown.verdict.name == verdict
    asked = max_sector(as_plant([rows[0], ["1/(s+2)", rows[1][1]]]), [PLAY, NonlinearityClass.norm_bounded(0.1)])
    assert asked.verdict.name == "INCONCLUSIVE"  # and no exception
    assert "play and stop are covered beside functions and a gain" in str(asked)
    one = memory("play", 1)
    assert contains(memory("play", 2), one)
    assert not contains(memory("play", 2), memory("stop", 1))
    assert not contains({key: value for key, value in one.items() if key != "memory"}, one)
    assert certify("exp(-s)/(s+1)", PLAY).verdict.name == "INCONCLUSIVE"
    with pytest.raises(InputError, match="of whose differences nothing is known"):
        l2_gain(as_plant(([[-1]], [[1]], [[1]], [[0]])), [PLAY], {"Bw": [[1]], "Cz": [[1]]}, incremental=True)
    with pytest.raises(InputError, match="has memory and other properties"):
        NonlinearityClass(sector=PLAY.sector, slope=PLAY.slope, memory="play", odd=True)


def test_which_functions_are_taken_by_their_increments():
    kinds = (
        *({}, {"memory": ("play", Fraction(1))}, {"time_varying": True}, {"slope": None}, {"operator": "any"}),
        *({"slope": (Fraction(0), "inf")}, {"slope": ("-inf", Fraction(1))}),
    )
    m = len(kinds)
    given = [replace(PLAIN, **kind) for kind in kinds]
    assert second._by_increments(as_asked([[-1]], [[1] * m], [[1]] * m, [[0] * m] * m, *given)) == [0, 1]


# with d = s, in samples z - 1, a channel by its increments has d mu and d sigma, the others mu and sigma
@pytest.mark.parametrize("time", ["continuous", "discrete"])
def test_the_first_checker_takes_increments_of_what_moves_and_the_rest_as_it_is(time):
    A, B, E = np.array([[-1, 1], [0, -2]]), np.array([[1, 2, 1], [-1, 1, 3]]), np.array([1, 2])
    T = A - (time == "discrete") * np.eye(2, dtype=int)
    C = np.array([[1, -1], [2, 1], E @ T])  # sigma_3 = E (T x + B_1 mu_1 + B_2 mu_2) is 0 at rest
    D = np.array([[0, 0, 0], [1, 0, 0], [*E @ B[:, :2], 0]])
    sides = {name: [[str(v) for v in row] for row in M] for name, M in zip("ABCD", (A, B, C, D), strict=True)}
    steep = {"sector": ["0", "1/2"], "slope": ["0", "1/3"], "odd": False, "time_varying": False, "linear": False}
    laws = {"channels": [memory("play", 2), steep, BESIDE], "repeated": False}
    H, asked = first.increments(plant(LAG | sides | {"time": time}), channels(laws, 3))
    assert [(one.sector, one.varying) for one in asked.families] == [
        *(((0, Fraction(2)), True), ((0, Fraction(1, 3)), True), ((0, Fraction(1, 2)), True)),
    ]
    at = 0.3 + 0.8j
    inner = [np.linalg.solve(at * np.eye(2) - M, N) for M, N in ((A, B), (np.array(H.A, float), np.array(H.B, float)))]
    before, after = C @ inner[0] + D, np.array(H.C, float) @ inner[1] + np.array(H.D, float)
    d = at - (time == "discrete")
    scale = np.array([d, d, 1])
    assert after == pytest.approx(scale[:, None] * before / scale, abs=1e-12)


def test_a_sector_that_does_not_depend_on_time_keeps_it_beside_increments():
    laws = {"channels": [memory("stop", 1), BESIDE | {"time_varying": False}], "repeated": False}
    _, asked = first.increments(plant(MIXED["system"]), channels(laws, 2))
    assert [one.varying for one in asked.families] == [True, False]


def test_only_inputs_and_outputs_of_a_gain_stay_one_operator():
    gain, stop = {"slope": None, "operator": "performance"}, {"memory": ("stop", Fraction(2))}
    given = [replace(PLAIN, **kind) for kind in (stop, stop, gain, gain)]
    none = [[0] * 4] * 4
    found = second.increments(as_asked([[-1]], [[1] * 4], [[1], [1], [0], [0]], none, *given, repeated=(0, 0, 2, 2)))
    assert found.repeated == (0, 1, 2, 2)
    assert [one.ends for one in found.nonlinearities[:2]] == [(0, 2)] * 2
    assert all(one.time_varying for one in found.nonlinearities[:2])


# v = x - T^-1 b phi, T = A or, in samples, A - 1: v' = T v - e f + g w - T^-1 b u, u = phi', of play or stop phi with
# sigma = c v + .., a function f of c_1 v and, in continuous time, z = c_2 v
@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(
    ("kind", "turn", "popov"), [("play", "1/8", "2"), ("stop", "-1/3", "-2"), ("stop", "-1/8", "1")]
)
def test_the_second_checker_stores_what_its_formulas_say(monkeypatch, kind, turn, popov, discrete):
    found, m, popov = list[fmpq_mat](), 2 if discrete else 3, "0" if discrete else popov
    monkeypatch.setattr(second, "_require_definite", lambda *matrices: found.extend(matrices))
    T, P, B = fmpq_mat([[-2, 1], [fmpq(1, 2), -3]]), fmpq_mat([[3, 1], [1, 2]]), fmpq_mat([[1, 5, 1], [2, 1, -3]])
    b, e, g = (fmpq_mat([[row[j]] for row in B.tolist()]) for j in range(3))
    rows, moved = [fmpq_mat([row]) for row in ([1, 4], [2, -1], [3, 1])], T.inv() * b
    ends = (Fraction(0), Fraction(4, 3)), (Fraction(-1, 5), Fraction(1, 2)), (Fraction(-7), Fraction(7))
    kinds = {"memory": (kind, Fraction(4, 3))}, {"slope": None}, {"slope": None, "operator": "performance"}
    given = [replace(PLAIN, lower=a, upper=h, **more) for (a, h), more in zip(ends, kinds, strict=True)]
    plant = as_asked(
        (T + fmpq_mat([[int(discrete), 0], [0, int(discrete)]])).tolist(),
        [row[:m] for row in B.tolist()],
        [row.tolist()[0] for row in rows[:m]],
        [[0] * m, *([(row * moved)[0, 0], *[0] * (m - 1)] for row in rows[1:m])],
        *given[:m],
        discrete=discrete,
    )
    shares = ["2", "3/5", "1/9"][:m]
    multiplier = {"lambda": shares, "theta": [turn, popov, "0"][:m]}
    proof = {"method": "matrix", "P": [["3"], ["1", "2"]], "exponent": 0}
    second.require_storage(SimpleNamespace(multiplier=multiplier, proof=proof), plant)
    V, falls = found
    theta, t, k, low, high = (fmpq(*Fraction(v).as_integer_ratio()) for v in (turn, popov, "4/3", "-1/5", "1/2"))

    def form(M, x, y):
        return (x.transpose() * M * y)[0, 0]

    Q, v, u, f, w, phi = T.transpose() * P * T, fmpq_mat([[2], [-5]]), fmpq(3), fmpq(-4), fmpq(7), fmpq(11)
    eta, seen, z = ((row * v)[0, 0] for row in rows)
    H, down = -(rows[0] * moved)[0, 0], min(theta, fmpq(0))
    stored = theta * H * phi**2 + abs(theta) / k * phi**2 + 2 * down * phi * (eta - H * phi)
    both = fmpq_mat([*v.tolist(), [phi]])
    assert form(V, both, both) == form(Q, v, v) + min(t * low, t * high) * seen**2 + stored
    rate = T * v - e * f - moved * u + (fmpq_mat(2, 1) if discrete else g * w)
    slope, after = (rows[0] * (rate + moved * u))[0, 0], v + rate
    rise = form(Q, after, after) - form(Q, v, v) if discrete else 2 * form(Q, v, rate)
    rise += 2 * 2 * u * (k * slope - u) + 2 * fmpq(3, 5) * (f - low * seen) * (high * seen - f)
    later = (rows[0] * after)[0, 0] if theta > 0 else eta
    if discrete:  # 2 theta u (sigma+ or sigma), less what is stored
        rise += 2 * theta * u * later - (1 if theta > 0 else -1) * theta * H * u**2 - abs(theta) / k * u**2
    else:
        rise += 2 * theta * u * eta + 2 * t * f * (rows[1] * rate)[0, 0] + 2 * fmpq(1, 9) * (49 * z**2 - w**2)
    both = fmpq_mat([*v.tolist(), [u], [f], [w]][: 2 + m])
    assert form(falls, both, both) == -rise


# y = A x - b phi, x' = y + b_w w, phi = -(y_1 + y_2) of a stop with sigma = c x, and z = x_2 = y_1
def test_what_moves_an_eigenvalue_0_is_stored_as_its_formula_says(monkeypatch):
    found = list[fmpq_mat]()
    monkeypatch.setattr(second, "_require_definite", lambda *matrices: found.extend(matrices))
    kinds = {"memory": ("stop", Fraction(4, 3))}, {"slope": None, "operator": "performance", "lower": Fraction(-7)}
    given = [replace(PLAIN, upper=Fraction(7), **more) for more in kinds]
    plant = as_asked([[0, 1], [0, -1]], [[0, 3], [1, 4]], [[1, 5], [0, 1]], [[0, 0]] * 2, *given)
    document = {"multiplier": {"lambda": ["2", "1/9"], "theta": ["-1/3", "0"]}}
    proof = {"method": "matrix", "P": [["3"], ["1", "2"]], "exponent": 0}
    second.require_storage(SimpleNamespace(**document, proof=proof), plant)
    y, P, psi, w, phi, k = fmpq_mat([[2], [-5]]), fmpq_mat([[3, 1], [1, 2]]), 3, 7, -(2 - 5), fmpq(4, 3)
    assert (y.transpose() * found[0] * y)[0, 0] == (y.transpose() * P * y)[0, 0] + phi**2 / (3 * k)
    rate, slope, z = fmpq_mat([[-5 + 4 * w], [5 - 4 * w - psi]]), 2 + 3 * w + 5 * (-5 + 4 * w), 2
    rise = 2 * (y.transpose() * P * rate)[0, 0] + 2 * 2 * psi * (k * slope - psi) + fmpq(2, 3) * phi * slope
    both = fmpq_mat([[2], [-5], [psi], [-w]])
    assert (both.transpose() * found[1] * both)[0, 0] == -rise - fmpq(2, 9) * (49 * z**2 - w**2)
