"""Storage functions of play and stop, and gains beside these: both checkers, what neither accepts, random operators."""

import copy
import json
from fractions import Fraction
from functools import cache
from itertools import pairwise

import control
import numpy as np
import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, as_plant, max_sector
from lure.analysis import l2_gain
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Plant, channels
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.memory import storages, with_storage
from lure.analysis.certificates.second.opinion import recheck

PLAY, STOP = NonlinearityClass.hysteretic("play"), NonlinearityClass.hysteretic("stop")
CONVERGES = "every motion converges to the set of equilibria"
GAIN = "the L2 gain from w to z is at most gamma in every loop of the class"
EXCEEDED = "the L2 gain from w to z is above gamma in a loop of the class"


def channel(kind, k=1):
    bounds = {"sector": ["0", str(k)], "slope": ["0", str(k)], "odd": False, "time_varying": False, "linear": False}
    return bounds | ({"memory": kind} if kind else {})


def performance(r):
    plain = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    return {"sector": [str(-Fraction(r)), r], **plain, "operator": "performance"}


def draft(system, channels, repeated=False, **more):
    plant = {"kind": "multivariable", "time": "continuous", **system}
    return {"verdict": "PROVED", "system": plant, "laws": {"channels": channels, "repeated": repeated}, **more}


def stored(theta, weights=("1/2",), P=(("1",),)):
    return {
        "theorem": "storage-circle",
        "multiplier": {"lambda": list(weights), "theta": list(theta)},
        "proof": {"method": "matrix", "P": [list(row) for row in P], "exponent": 0},
    }


# y' = -y - psi, sigma' = y, eta = -y: with V = y^2 and lambda = 1/2 there is 2 y^2 + 2 y psi + 2 theta y psi - psi (y -
# psi), definite for (1 + 2 theta)^2 < 8; in (y, phi) play, theta > 0, has V = y^2 + theta (1 + 1) phi^2, stop y^2 - 2
# theta phi y - 2 theta phi^2, definite for theta^2 < -2 theta
LAG = {"A": [["-1"]], "B": [["1"]], "C": [["1"]], "D": [["0"]]}
TWO = {"A": [["-1", "0"], ["0", "-1"]], "B": [["1", "0"], ["0", "1"]], "C": [["1", "0"], ["0", "1"]]}
TWO |= {"D": [["0", "0"], ["0", "0"]]}
# q'' + q'/2 + q = w - phi, z = q', with the stop: V = q'^2 + ..., gamma = 4; a gain g has q' = 2 w at omega^2 = 1 + g
MASS = {"A": [["0", "1"], ["-1", "-1/2"]], "B": [["0", "0"], ["1", "1"]], "C": [["1", "0"], ["0", "1"]]}
MASS |= {"D": [["0", "0"], ["0", "0"]]}
MEMBER = {"method": "linear-members", "gains": ["3", "0"], "operators": [], "omega": "2", "input": [["1", "0"]]}
# q' = v, v' = -v - stop(q): phi = -(y_1 + y_2), and with V = 2 y_1^2 + 2 y_1 y_2 + 2 y_2^2 + phi^2, lambda = 13/10
# there is 2 y_1^2 + 2 y_2^2 - (3/5) y_1 psi + 4 y_2 psi + (13/5) psi^2
SLIDES = {"A": [["0", "1"], ["0", "-1"]], "B": [["0"], ["1"]], "C": [["1", "0"]], "D": [["0"]]}
ALL = {
    "slides": draft(SLIDES, [channel("stop")], **stored(["-1"], ["13/10"], [["2"], ["1", "2"]])),
    "stop": draft(LAG, [channel("stop")], **stored(["-1/8"])),
    "play": draft(LAG, [channel("play")], **stored(["1/8"])),
    "both": draft(
        TWO,
        [channel("stop"), channel("play")],
        **stored(["-1/8", "1/8"], ["1/2", "1/2"], [["1"], ["0", "1"]]),
    ),
    "function": draft(
        TWO,
        [channel("play"), channel("")],
        **stored(["1/8", "-1/8"], ["1/2", "1/2"], [["1"], ["0", "1"]]),
    ),
    "exceeded": draft(MASS, [channel("stop", 4), performance("100/199")], theorem="counterexample", proof=MEMBER)
    | {"verdict": "REFUTED"},
}


@cache
def certificate(name):
    if name == "gain":
        found = l2_gain(
            ([[0, 1], [-1, "-1/2"]], [[0], [1]], [[1, 0]], [[0]]), [STOP], {"Bw": [[0], [1]], "Cz": [[0, 1]]}
        )
        return dict(found.proof.certificate)
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.slow_for("gain")
@pytest.mark.parametrize("name", [*ALL, "gain"])
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    check(found)
    assert recheck(found).accepted
    assert found["conclusion"] == {"gain": GAIN, "exceeded": EXCEEDED}.get(name, CONVERGES)


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        ("slides", ("multiplier", "theta"), ["1"]),
        ("slides", ("multiplier", "theta"), ["0"]),
        ("slides", ("multiplier", "theta"), ["-1/20"]),
        ("slides", ("multiplier", "lambda"), ["9/10"]),
        ("slides", ("laws", "channels", 0, "memory"), "play"),
        ("slides", ("laws", "channels", 0), channel("")),
        ("slides", ("system", "A"), [["0", "1"], ["0", "0"]]),
        ("slides", ("system", "A"), [["0", "0"], ["0", "-1"]]),
        ("slides", ("system", "B"), [["1"], ["-1"]]),  # which does not move the integrator
        ("slides", ("system", "time"), "discrete"),
        ("slides", ("theorem",), "diagonal-circle"),
        ("stop", ("multiplier", "theta"), ["1/8"]),
        ("play", ("multiplier", "theta"), ["-1/8"]),
        ("stop", ("multiplier", "theta"), ["1/1000"]),
        ("play", ("multiplier", "theta"), ["-1/1000"]),
        ("stop", ("multiplier", "theta"), ["-5/2"]),  # V is indefinite, and only it: (1 - 5)^2 > 8 is not so for -3/2
        ("play", ("multiplier", "theta"), ["1"]),  # (1 + 2)^2 > 8
        ("stop", ("multiplier", "lambda"), ["-1/2"]),
        ("stop", ("laws", "channels", 0, "memory"), "play"),
        ("play", ("laws", "channels", 0), channel("play", 20)),
        ("play", ("laws", "channels", 0), channel("")),  # a function needs no such theorem: 0 attracts then
        ("stop", ("system", "time"), "discrete"),
        ("stop", ("system", "A"), [["0"]]),
        ("stop", ("system", "A"), [["1"]]),
        ("stop", ("system", "D"), [["1"]]),
        ("stop", ("proof", "P"), [["-1"]]),
        ("stop", ("proof",), {"method": "determinant"}),
        ("stop", ("theorem",), "diagonal-popov"),
        ("both", ("system", "B"), [["1", "1/9"], ["0", "1"]]),  # Theta H(0) is not symmetric
        ("both", ("multiplier", "theta"), ["-1/8", "-1/8"]),
        ("both", ("system", "D"), [["0", "1/1000"], ["0", "0"]]),
        ("function", ("laws", "channels", 1, "time_varying"), True),
        ("function", ("laws", "channels", 1, "slope"), ["-1/9", "1"]),
        ("function", ("laws", "channels", 1, "slope"), ["-1/1000", "1"]),
        ("function", ("laws", "channels", 1, "regularity"), "any"),
        ("stop", ("system", "D"), [["1/1000"]]),
        ("function", ("multiplier", "theta"), ["1/8", "0"]),  # solutions are not shown to be bounded
        ("function", ("multiplier", "theta"), ["0", "-1/8"]),
        ("gain", ("laws", "channels", 1), performance("501/1000")),
        ("gain", ("laws", "channels", 1), performance("1")),
        ("gain", ("laws", "channels", 0, "memory"), "play"),
        ("gain", ("system", "C", 1), ["1", "1"]),  # z is the position, too, which may rest displaced
        ("gain", ("system", "D", 0, 1), "1"),
        ("gain", ("system", "D", 1, 0), "1"),
        ("gain", ("system", "A"), [["0", "1"], ["0", "-1/2"]]),
        ("exceeded", ("proof", "gains"), ["5", "0"]),
        ("exceeded", ("proof", "gains"), ["-1", "0"]),
        ("exceeded", ("proof", "gains"), ["1", "0"]),
        ("exceeded", ("laws", "channels", 1), performance("1/2")),
        ("exceeded", ("proof", "omega"), "1"),
    ],
)
def test_neither_accepts_what_was_changed(name, path, value):
    assert_both_reject(edited(certificate(name), *path, value=value))


def test_what_is_stored_is_added_in_one_unit():
    # 4 M - 4 2 (1/2)(1/2) 5 and 4 V + 4 (1/2) 5
    half = Fraction(1, 2)
    assert with_storage([[4]], [[3]], 5, ([([half], [half])], [[half]])) == ([[6]], [[22]])


def test_a_form_that_holds_without_a_positive_v_is_refused():
    # x' = -x + 2 play, k = 1: x grows.  y' = -y + 2 psi, eta = -y; with P = 1/4, lambda = theta = 1 the form -y^2/2 +
    # y psi - 2 psi^2 is negative definite, but V = y^2/4 + (1 + H(0)) phi^2 with H(0) = -2
    back = LAG | {"B": [["-2"]]}
    given = draft(back, [channel("play")], **stored(["4"], ["4"], [["1"]]))
    assert_both_reject({**certificate("play"), **given})
    with pytest.raises(Rejected, match="V > 0 fails"):
        complete_and_check(given)
    found = max_sector(as_plant("-2/(s+1)"), [PLAY])
    assert found.largest.low <= found.refuted_at == pytest.approx(0.5)


def _driven(kind, sigma, r, k, start):
    """The output of a play or a stop with piecewise linear input, exactly at its corners."""
    p, found = start, []
    for value in sigma:
        p = min(max(p, value - r), value + r)
        found.append(k * p if kind == "play" else k * (value - p))
    return np.array(found)


@pytest.mark.parametrize("kind", ["play", "stop"])
def test_random_operators_store_what_the_theorem_says_and_not_the_other_sign(kind):
    rng, other = np.random.default_rng(5), []
    for _ in range(40):
        corners = np.cumsum(rng.normal(size=60))
        sigma = np.interp(np.linspace(0, 59, 2400), np.arange(60), corners)
        r, k = 10 ** rng.uniform(-1, 1), rng.uniform(0.1, 2)
        first = sigma[0] + r * rng.uniform(-1, 1)
        phi = _driven(kind, sigma, r, k, first)
        rise, move = np.diff(phi), np.diff(sigma)
        middle = (phi[1:] + phi[:-1]) / 2, (sigma[1:] + sigma[:-1]) / 2
        supplied = np.cumsum(middle[1] * rise if kind == "play" else middle[0] * move)
        gap = np.abs(move).max()
        slack = 60 * gap * k * gap * 20  # corners of the play between two samples
        assert (supplied - (phi[1:] ** 2 - phi[0] ** 2) / (2 * k)).min() > -slack
        other.append(float((np.cumsum(middle[0] * move if kind == "play" else middle[1] * rise)).min() / (k * r * r)))
    assert min(other) < -1  # the other product stores nothing: it may be drawn from for ever


@pytest.mark.slow
def test_a_stop_is_proved_as_far_as_its_elastic_loop_is_stable():
    # Re H - 3 Im H/w = (10 - 6 w^2)/(1 + w^2)^3 >= -1/8, at w^2 = 3: k < 8, where the elastic loop has a root i sqrt 3
    found = max_sector(as_plant("1/(s+1)^3"), [STOP])
    assert found.criterion == "storage-circle"
    assert found.largest.low == pytest.approx(8, rel=1e-5)
    assert found.largest.low < 8
    # of play no such sign: 4 remains, by the circle criterion
    assert max_sector(as_plant("1/(s+1)^3"), [PLAY]).largest.low == pytest.approx(4, rel=1e-6)
    # 1/(s^2 + s/10 + 1) is passive for stops: Im H < 0; the circle criterion ends at 2 zeta + zeta^2 = 0.21
    assert max_sector(as_plant("1/(s^2+s/10+1)"), [STOP]).largest.low > 1000


def test_no_solution_of_a_proved_loop_keeps_moving():
    rng, k, dt = np.random.default_rng(3), 6.0, 1e-2  # 1/(s + 1)^3, from random states, widths and inner states
    A = np.array([[-1.0, 1, 0], [0, -1, 1], [0, 0, -1]])
    step = np.eye(3) + A * dt + A @ A * dt * dt / 2 + A @ A @ A * dt**3 / 6
    push = np.linalg.solve(A, (step - np.eye(3))[:, 2])
    x, r = rng.normal(size=(3, 20)) * 3, 10 ** rng.uniform(-1, 0.5, size=20)
    xi, before, late = r * rng.uniform(-1, 1, size=20), x[0], []
    for i in range(6_000):
        x = step @ x - np.outer(push, k * xi)
        xi, before = np.clip(xi + x[0] - before, -r, r), x[0]
        late += [np.abs(A @ x - np.outer([0, 0, 1], k * xi)).max(axis=0) / r] if i % 2_000 > 1_800 else []
    assert np.max(late[-180:], axis=0).max() < 0.1 * np.max(late[:180], axis=0).max()


@pytest.mark.slow
def test_the_gain_to_a_velocity_beside_a_stop_is_that_of_the_damping():
    # q' w = (energy)' + q'^2/2 + phi q', phi q' >= (phi^2/2 k)': gamma = 2, and a gain has it at its resonance
    mass = ([[0, 1], [-1, "-1/2"]], [[0], [1]], [[1, 0]], [[0]])
    found = l2_gain(mass, [NonlinearityClass.hysteretic("stop", 5)], {"Bw": [[0], [1]], "Cz": [[0, 1]]})
    assert found.gain.low == pytest.approx(2, rel=1e-8)
    assert found.gain.high == pytest.approx(2, rel=1e-6)
    assert "play and stop have phi = 0 at first" in str(found)
    assert all(recheck(one).accepted for one in found.certificates.values())
    moved = l2_gain(mass, [PLAY], {"Bw": [[0], [1]], "Cz": [[0, 1]]})
    assert 2 < moved.gain.high < 12
    rest = l2_gain(mass, [STOP], {"Bw": [[0], [1]], "Cz": [[1, 0]]})
    assert rest.verdict.name == "INCONCLUSIVE"
    assert "z is not 0 where play and stop may rest" in str(rest)


def test_the_gain_of_differences_beside_a_play_in_discrete_time():
    # x+ = x/2 - phi + w, z = x+ - x = w - x/2 - phi: 0 at rest; without play z/w = (z - 1)/(z - 1/2), 4/3 at z = -1
    plant, at = (
        control.ss([[0.5]], [[1]], [[1]], [[0]], dt=1),
        {"Bw": [[1]], "Cz": [[-0.5]], "Dzw": [[1]], "Dzmu": [[1]]},
    )
    found = l2_gain(plant, [NonlinearityClass.hysteretic("play", Fraction(1, 4))], at)
    # with the gain g: (z - 1)/(z - 1/2 + g), at z = -1 2/(3/2 - g): 1.6 for g = 1/4
    assert found.gain.low == pytest.approx(1.6, rel=1e-6)
    assert found.gain.high == pytest.approx(1.6, rel=1e-4)


def test_gains_beside_integrators():
    # x' = -phi(x + w), z = phi: (x^2)' = -2 phi (sigma - w) <= -2 phi^2 + 2 phi w, so 1; a gain has it at infinity
    at = {"Bw": [[0]], "Cz": [[0]], "Dzmu": [[-1]], "Dsigmaw": [[1]]}
    found = l2_gain(([[0]], [[1]], [[1]], [[0]]), [Sector(0, 1)], at)
    assert found.gain.high == pytest.approx(1, rel=1e-5)
    assert found.gain.low == pytest.approx(1, rel=1e-2)
    assert recheck(found.proof.certificate).accepted
    seen = {**dict(found.proof.certificate)}
    assert_both_reject(edited(seen, "system", "B", value=[["1", "1"]]))  # w moves the integrator


@pytest.mark.slow
def test_the_published_gain_of_an_integrator_inside_a_dead_zone():
    # q' = phi(v - q), v = G phi + f, G = (s - 9)/(s^2 + s + 1), slopes in [0, 0.3]: IQCbeta prints 2.32; a
    # programme with 98 kernels at 600 frequencies ends at 2.2514, and phi = 0.3 sigma has 2.0242
    plant = ([[0, 1, 0], [-1, -1, 0], [0, 0, 0]], [[0], [1], [1]], [[9, -1, 1]], [[0]])
    at = {"Bw": [[0], [0], [0]], "Cz": [[9, -1, 0]], "Dzw": [[1]], "Dsigmaw": [[1]]}
    found = l2_gain(plant, [NonlinearityClass.slope_restricted(0, Fraction(3, 10))], at)
    assert found.gain.high == pytest.approx(2.2514, rel=0.01)
    assert found.gain.low == pytest.approx(2.0242, rel=1e-3)
    assert recheck(found.proof.certificate).accepted
    kernels = found.proof.certificate
    assert_both_reject(edited(kernels, "system", "B", 2, 1, value="1/100"))  # w moves the integrator
    assert_both_reject(edited(kernels, "system", "C", 1, 2, value="1/100"))  # z sees it


@cache
def moved():
    return max_sector(as_plant("1/(s*(s+1)*(s+2))"), [STOP])


@pytest.mark.slow
def test_a_stop_moves_an_integrator():
    # the elastic loop s (s + 1)(s + 2) + k is stable for k < 6; a mass with a damper and friction comes to rest
    found = moved()
    assert found.criterion == "storage-circle"
    assert 5.99 < found.largest.low < 6 < found.refuted_at < 6.02
    certificate = found.proof.certificate
    FORMAT.validate(dict(certificate))
    assert certificate["conclusion"] == CONVERGES
    assert recheck(certificate).accepted
    play = max_sector(as_plant("1/(s*(s+1)*(s+2))"), [PLAY])  # sigma, which a play needs, is no function of y
    assert play.largest.low == 0
    assert "no stop moves" in play.reason
    mass = ([[0, 1], [0, -0.5]], [[0], [1]], [[1, 0]], [[0]])
    gain = l2_gain(mass, [NonlinearityClass.hysteretic("stop", 3)], {"Bw": [[0], [1]], "Cz": [[0, 1]]})
    assert gain.gain.high == pytest.approx(2, rel=1e-4)
    assert gain.gain.low == pytest.approx(2, rel=1e-6)
    assert recheck(gain.proof.certificate).accepted
    moves = gain.proof.certificate
    assert_both_reject(edited(moves, "system", "C", 1, value=["1", "1"]))  # the position, too
    assert_both_reject(edited(moves, "laws", "channels", 1, value=performance("51/100")))


@pytest.mark.slow_for("path0-play")
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("laws", "channels", 0, "memory"), "play"),
        (("laws", "channels", 0), channel("stop", 7)),
        (("laws", "channels", 0), channel("", 1)),
        (("multiplier", "theta", 0), lambda v: v.removeprefix("-")),
        (("multiplier", "theta", 0), "0"),
        (("multiplier", "theta", 0), lambda v: str(3 * Fraction(v))),
        (("multiplier", "lambda", 0), "0"),
        (("system", "B"), lambda rows: [[f"-{v}" if v != "0" else v for v in row] for row in rows]),
        (("system", "C"), lambda rows: [[f"-{v}" if v != "0" else v for v in row] for row in rows]),
        (("system", "D"), [["1"]]),
    ],
)
def test_neither_accepts_another_integrator(path, value):
    assert_both_reject(edited(moved().proof.certificate, *path, value=value))


def test_an_integrator_beside_functions_and_a_stop_is_left_open():
    two = {"A": [["0", "0"], ["0", "-1"]], "B": [["1", "0"], ["0", "1"]], "C": [["1", "0"], ["0", "1"]], "D": TWO["D"]}
    shape = stored(["-1", "0"], ["1/2", "1/2"], [["0"], ["0", "1"]])
    complete_and_check(draft(two, [channel("stop"), channel("stop")], **shape))
    assert_both_reject({**certificate("both"), **draft(two, [channel("stop"), channel("")], **shape)})


# y' = -psi, sigma' = y and phi = -y of stops: V = y^2 falls as -2 theta y^2 + ... where theta < 0
def test_two_integrators_are_moved_by_two_stops_and_by_no_function():
    none = [["0", "0"], ["0", "0"]]
    two, shape = TWO | {"A": none}, stored(["-1", "-1"], ["1/2", "1/2"], [["0"], ["0", "0"]])
    shown = complete_and_check(draft(two, [channel("stop"), channel("stop")], **shape)).certificate
    assert shown["conclusion"] == CONVERGES
    assert recheck(shown).accepted
    assert_both_reject(edited(shown, "laws", "channels", 1, value=channel("")))


# H = -1/s: the gain 1 has the eigenvalue 1, and of a play phi(sigma) = sigma is one
def test_no_play_moves_an_integrator():
    integrator = {**LAG, "A": [["0"]]}
    shown = complete_and_check(draft(integrator, [channel("stop")], **stored(["-1"], P=[["0"]]))).certificate
    assert recheck(shown).accepted
    play = edited(shown, "laws", "channels", 0, value=channel("play"))
    assert_both_reject(
        edited(shown, "laws", "channels", 0, value=channel("stop") | {"sector": ["-1", "1"], "slope": ["-1", "1"]})
    )
    for C in ("1", "-1"):
        assert_both_reject(edited(edited(play, "multiplier", "theta", 0, value="1/2"), "system", "C", value=[[C]]))


# 1/(s + 1)^3 with s = 10 (z - 1): constant gains are stable up to 5.49820, where (10 (z - 1) + 1)^3 = -k has |z| = 1,
# and the circle criterion ends at 3.45454 for play and stop
SAMPLED = as_plant([["1/((10*(z - 1) + 1)^3)"]], dt=1)
LIMIT = 5.498204


@pytest.fixture(scope="module")
def sampled():
    return max_sector(SAMPLED, [STOP])


def test_a_stop_in_discrete_time_is_proved_as_far_as_gains_are_stable(sampled):
    z = np.roots([1000, -2700, 2430, -729 + LIMIT])
    assert np.abs(z).max() == pytest.approx(1, abs=1e-6)
    assert LIMIT * (1 - 1e-4) < sampled.largest.low < LIMIT
    certificate = json.loads(json.dumps(dict(sampled.proof.certificate)))
    FORMAT.validate(certificate)
    assert certificate["theorem"] == "storage-circle"
    assert certificate["conclusion"] == CONVERGES
    assert recheck(certificate).accepted


@pytest.mark.slow
def test_a_play_in_discrete_time_has_a_little_more_than_the_circle_criterion():
    found = max_sector(as_plant([["1/((100*(z - 1) + 1)^3)"]], dt=1), [PLAY])  # 3.93665 by the circle criterion
    assert found.criterion == "storage-circle"
    assert found.largest.low == pytest.approx(3.9403, abs=1e-4)
    assert Fraction(found.proof.certificate["multiplier"]["theta"][0]) > 0
    assert recheck(dict(found.proof.certificate)).accepted


def test_a_stop_beside_a_function_in_discrete_time():
    pair = as_plant([["1/((10*(z - 1) + 1)^3)", "0"], ["0", "1/((10*(z - 1) + 1)^3)"]], dt=1)
    found = max_sector(pair, [STOP, NonlinearityClass.slope_restricted(0, 1)])
    assert LIMIT * (1 - 1e-4) < found.largest.low < LIMIT < found.refuted_at * (1 + 1e-6)
    assert recheck(dict(found.proof.certificate)).accepted


@pytest.mark.parametrize("kind", ["play", "stop"])
def test_random_operators_store_what_the_theorem_says_in_samples(kind):
    rng, broken = np.random.default_rng(20261127), 0
    for _ in range(40):
        k, r = rng.uniform(0.2, 3), rng.uniform(0.1, 2)
        sigma, p = rng.normal(scale=2, size=60), rng.normal()
        p = np.clip(p, sigma[0] - r, sigma[0] + r)
        phi = k * (p if kind == "play" else sigma[0] - p)
        for before, after in pairwise(sigma):
            p = np.clip(p, after - r, after + r)
            moved = k * (p if kind == "play" else after - p)
            stored = (moved**2 - phi**2 + (moved - phi) ** 2) / (2 * k)
            supplied = after * (moved - phi) if kind == "play" else moved * (after - before)
            assert supplied > stored - 1e-12
            other = (
                before * (moved - phi) if kind == "play" else phi * (after - before)
            )  # the sample before is not enough
            broken += other < (moved**2 - phi**2) / (2 * k) - 1e-9
            phi = moved
    assert broken > 50


@pytest.mark.parametrize(("kind", "theta"), [("play", 1), ("stop", -1)])
def test_what_the_checker_adds_is_at_least_what_is_stored(kind, theta):
    A, B, C = [[0, 1], [Fraction("-0.8"), Fraction("1.7")]], [[0], [1]], [[Fraction("0.3"), Fraction("0.4")]]
    H = Plant(
        [[Fraction(v) for v in row] for row in A], [[Fraction(v) for v in row] for row in B], C, [[Fraction(0)]], True
    )
    asked = channels({"channels": [channel(kind)], "repeated": False}, 1)
    ((a, b),), extra = storages(H, asked, [Fraction(theta)])
    rng, spare = np.random.default_rng(3), []
    for r in 10 ** rng.uniform(-1, 1, 20):
        x, p, before = rng.normal(size=2), 0.0, None
        for _ in range(80):  # the loop of slope 1 oscillates
            sigma = float((np.array(C, dtype=float) @ x)[0])
            p = float(np.clip(p, sigma - r, sigma + r))
            phi = p if kind == "play" else sigma - p
            after = np.array(A, dtype=float) @ x - np.array(B, dtype=float)[:, 0] * phi
            now = np.append(after - x, phi)
            if before is not None:
                z, E = np.append(before[:2], phi - before[2]), np.array(extra, dtype=float)
                supplied = 2 * (np.array(a, dtype=float) @ z) * (np.array(b, dtype=float) @ z)
                spare.append((supplied - now @ E @ now + before @ E @ before) / (1 + now @ now + before @ before))
            x, before = after, now
    assert min(spare) > -1e-12
    assert min(spare) < 1e-9  # where the operator slides or rests nothing is lost


def test_what_is_stored_falls_along_every_solution(sampled):
    """``V = y'P y + S phi^2 + |theta|/u phi^2 + 2 theta phi sigma`` of the certificate, for members of every width."""
    proof, rng = sampled.proof.certificate, np.random.default_rng(7)
    A, B, C = (np.array([[float(Fraction(v)) for v in row] for row in proof["system"][name]]) for name in "ABC")
    half, unit = [[float(int(v)) for v in row] for row in proof["proof"]["P"]], 2.0 ** -proof["proof"]["exponent"]
    P = unit * np.array([[half[max(i, j)][min(i, j)] for j in range(3)] for i in range(3)])
    (theta,), u = map(float, map(Fraction, proof["multiplier"]["theta"])), sampled.largest.low
    assert theta < 0
    for k, r in zip(rng.uniform(0.1, 1, 12) * u, 10 ** rng.uniform(-2, 1, 12), strict=True):
        x, p, values = rng.normal(size=3), 0.0, list[float]()
        for _ in range(300):
            sigma = float((C @ x)[0])
            p = float(np.clip(p, sigma - r, sigma + r))
            phi = k * (sigma - p)
            after = A @ x - B[:, 0] * phi
            y = after - x  # H(1) = 1
            values.append(y @ P @ y + theta * phi**2 + abs(theta) / u * phi**2 + 2 * theta * phi * sigma)
            values[-1] += (1 / k - 1 / u) * abs(theta) * phi**2  # of the slope of the member
            x = after
        assert max(np.diff(values)) < 1e-9 * max(map(abs, values))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("laws", "channels", 0, "memory"), "play"),
        (("laws", "channels", 0), lambda one: {key: value for key, value in one.items() if key != "memory"}),
        (("laws", "channels", 0, "slope"), ["0", "11/2"]),
        (("multiplier", "theta", 0), lambda v: str(-Fraction(v))),
        (("multiplier", "theta", 0), "0"),
        (("multiplier", "lambda", 0), lambda v: str(-Fraction(v))),
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("proof", "exponent"), lambda v: v + 1),
        (("system", "time"), "continuous"),
        (("system", "A", 2, 2), lambda v: str(Fraction(v) + Fraction(1, 50))),
        (("system", "D"), [["1/10"]]),
        (("system", "A"), [["0", "1", "0"], ["0", "0", "1"], ["1", "-3", "3"]]),  # z = 1
    ],
)
def test_neither_accepts_what_was_changed_in_discrete_time(sampled, path, value):
    assert_both_reject(edited(sampled.proof.certificate, *path, value=value))


def test_an_eigenvalue_1_and_a_gain_beside_storage_are_left_open():
    found = max_sector(as_plant([["1/((z - 1)*(2*z - 1))"]], dt=1), [STOP], criterion="storage-circle")
    assert found.proof is None
    assert "eigenvalue 1" in found.reason


@pytest.mark.parametrize("kind", ["play", "stop"])
def test_in_samples_no_operator_lets_the_stored_rise_by_more_than_is_said(kind):
    # V+ - V is at most twice the sum of the products, sample by sample, V of (y, phi), y = x+ - x
    rng, k, sign = np.random.default_rng(8), Fraction(3, 2), 1 if kind == "play" else -1
    asked = channels({"channels": [channel(kind, k)], "repeated": False}, 1)
    for theta in (Fraction(1, 3), Fraction(5, 2)):
        A = np.round(rng.normal(size=(2, 2)) * 2) / 8
        B, C = np.round(rng.normal(size=(2, 1)) * 4) / 8, np.round(rng.normal(size=(1, 2)) * 4) / 4
        rows = [[[Fraction(v) for v in row] for row in side.tolist()] for side in (A, B, C)]
        pairs, extra = storages(Plant(*rows, [[Fraction(0)]], discrete=True), asked, [sign * theta])
        pairs = [[np.array(side, dtype=float) for side in pair] for pair in pairs]
        above = np.tril(np.array([[*row, *[0] * (3 - len(row))] for row in extra], dtype=float))
        V = above + np.tril(above, -1).T
        for _ in range(60):
            x, r = rng.normal(size=2) * 5, 10 ** rng.uniform(-1, 0.5)
            p, seen = (C @ x).item() + r * rng.uniform(-1, 1), []
            for _ in range(20):
                sigma = (C @ x).item()
                p = min(max(p, sigma - r), sigma + r)
                phi = float(k) * (p if kind == "play" else sigma - p)
                after = A @ x - B[:, 0] * phi
                seen.append((after - x, phi))
                x = after
            for (y, phi), (later, moved_to) in pairwise(seen):
                z, w, both = np.array([*y, phi]), np.array([*later, moved_to]), np.array([*y, moved_to - phi])
                slack = 2 * sum((a @ both) * (b @ both) for a, b in pairs) - w @ V @ w + z @ V @ z
                assert slack > -1e-9 * (1 + abs(w @ V @ w) + abs(z @ V @ z))


# H = 3/(s + 2), k = 4/3, theta = +-1/4: theta H(0) + 1/4/k = 3/8 + 3/16, and for a stop 2 theta phi (eta - H(0) phi),
# eta = -y/2, more
@pytest.mark.parametrize(("kind", "theta", "cross"), [("play", "1/4", "0"), ("stop", "-1/4", "1/8")])
def test_what_is_stored_is_that_of_the_formula(kind, theta, cross):
    asked = channels({"channels": [channel(kind, "4/3")], "repeated": False}, 1)
    plant = Plant(*([[Fraction(v)]] for v in (-2, 3, 1, 0)), discrete=False)
    pairs, extra = storages(plant, asked, [Fraction(theta)])
    assert [[*map(list, pair)] for pair in pairs] == [[[-Fraction(theta) / 2, 0], [0, 1]]]
    assert extra == [[0, Fraction(cross)], [Fraction(cross), Fraction(9, 16)]]
