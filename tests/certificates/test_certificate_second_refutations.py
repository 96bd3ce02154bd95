"""The second checker on counterexamples: gains, switchings and orbits that do as claimed, and those that do not."""

from fractions import Fraction as F

import pytest
from handwritten import NO_REST, OTHERS, THIRD, accepted, nonlinearities, refuted, state_space, transfer

from lure.analysis.counterexamples.linear import companion
from lure.analysis.counterexamples.piecewise import Flow, PiecewiseLoop, returns
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant


# (s + 1)^3 + g has the roots +- i sqrt(3) at g = 8.
@pytest.mark.parametrize(("gain", "good"), [("8", True), ("9", True), ("7999/1000", False), ("11", False)])
def test_a_linear_gain(gain, good):
    assert accepted(refuted(THIRD, nonlinearities(0, 10), {"method": "linear-gain", "gain": gain})) is good


# s + 1 - g: a root 0 at g = 1 is a line of equilibria; two of them, s^2 for g = 1, are a ramp.
def test_a_linear_gain_with_a_root_at_zero():
    proof = {"method": "linear-gain", "gain": "1"}
    single = refuted(transfer([-1], [1, 1]), nonlinearities(0, 2), proof, OTHERS)
    assert accepted(single)
    # at the upper end it is the critical case of -H, in which convergence to the equilibria can be proved
    assert not accepted(refuted(transfer([-1], [1, 1]), nonlinearities(0, 1), proof, OTHERS))
    assert not accepted({**single, "conclusion": NO_REST})
    assert accepted(refuted(transfer([-1, -1], [1, 1, 1]), nonlinearities(0, 1), proof, NO_REST))
    # the class of an integrator has other equilibria anyway
    critical = refuted(transfer([1], [1, 0]), nonlinearities(0, 1), {"method": "linear-gain", "gain": "0"}, OTHERS)
    assert not accepted(critical)
    # of -1/s no class is a critical case: small gains are unstable
    assert accepted({**critical, "system": transfer([-1], [1, 0])})
    # two equal states at rest, x' = 0, are equilibria, not a ramp
    resting = state_space([[-1, 0], [0, -1]], [1, 0], [-1, 0])
    assert accepted(refuted(resting, nonlinearities(0, 2), proof, OTHERS))


def test_a_linear_gain_in_discrete_time():
    system = transfer([1], [1, "-1/2"], "discrete")
    assert accepted(refuted(system, nonlinearities(0, 2), {"method": "linear-gain", "gain": "3/2"}))  # root -1
    assert not accepted(refuted(system, nonlinearities(0, 2), {"method": "linear-gain", "gain": "149/100"}))
    assert accepted(refuted(system, nonlinearities(-1, 2), {"method": "linear-gain", "gain": "-1/2"}, OTHERS))  # root 1


# s + 1 + g exp(-s) is 1 + g at 0 and positive far out: a real root s >= 0 for g <= -1, which is 0 for g = -1
@pytest.mark.parametrize(("gain", "conclusion"), [("-2", NO_REST), ("-1", OTHERS), ("-1/2", None), ("1/2", None)])
def test_a_linear_gain_with_dead_time(gain, conclusion):
    late = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
    for end in (NO_REST, OTHERS):
        certificate = refuted(late, nonlinearities(-3, 1), {"method": "linear-gain", "gain": gain}, end)
        assert accepted(certificate) is (end == conclusion)


# (s + 1)^3 + 8 at i sqrt(3) = 1.732..; exp(-s)/(s + 1): w + atan w = pi at w = 2.0288, gain sqrt(1 + w^2) = 2.2618.
def test_a_crossing():
    def proof(gains, band):
        return {"method": "crossing", "gains": list(gains), "frequencies": list(band)}

    assert accepted(refuted(THIRD, nonlinearities(0, 9), proof(("79/10", "81/10"), ("17/10", "9/5"))))
    assert not accepted(refuted(THIRD, nonlinearities(0, 9), proof(("79/10", "799/100"), ("17/10", "9/5"))))
    assert not accepted(refuted(THIRD, nonlinearities(0, 9), proof(("79/10", "81/10"), ("9/5", "2"))))
    assert not accepted(refuted(THIRD, nonlinearities(0, 8), proof(("79/10", "81/10"), ("17/10", "9/5"))))
    dead = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
    assert accepted(refuted(dead, nonlinearities(0, 3), proof(("2261/1000", "2262/1000"), ("2", "21/10"))))
    assert not accepted(refuted(dead, nonlinearities(0, 3), proof(("2262/1000", "2263/1000"), ("2", "21/10"))))


# x'' + x'/50 + (1 + g) x = 0: a stiff spring on the way in (a quarter period pi/(2 sqrt 3) = 0.907), a soft one on the
# way out (pi/2 = 1.571) makes a swing grow by sqrt(3) each time.
def test_switched_gains():
    system = transfer([1], [1, "1/50", 1])
    proof = {
        "method": "switched-gain",
        "gains": ["2", "0"],
        "times": ["907/1000", "1571/1000"],
        "squarings": 5,
        "bits": 256,
    }
    varying = nonlinearities(0, 2, time_varying=True)
    assert accepted(refuted(system, varying, proof))
    assert not accepted(refuted(system, nonlinearities(0, 2), proof))
    assert not accepted(refuted(system, nonlinearities(0, 1, time_varying=True), proof))
    assert not accepted(refuted(system, varying, {**proof, "gains": ["0", "0"]}))
    # z+ = (1/2 - g) z: -3/2 and 1/2 in turn shrink by 3/4, -3/2 and -3/2 grow
    lag = transfer([1], [1, "-1/2"], "discrete")
    pattern = {"method": "switched-gain", "gains": ["2", "0"], "squarings": 5, "bits": 256}
    assert not accepted(refuted(lag, varying, pattern))
    assert accepted(refuted(lag, varying, {**pattern, "gains": ["2", "2", "2", "0"]}))


# Period 3 of y+ = y/2 + 2 u + (23/25) u_prev with a monotone nonlinearity of slope 175/192 (Carrasco et al. 2019,
# example 6).
ORBIT = {
    "method": "orbit",
    "points": [["-36864/72625", "-192/415"], ["0", "0"], ["192/175", "1"]],
    "left": "0",
    "right": "0",
    "u": ["192/415", "192/415", "-1"],
    "sigma": ["-36864/72625", "-74498/72625", "192/175"],
}


def test_an_orbit_in_discrete_time():
    system = transfer([2, "23/25"], [1, "-1/2", 0], "discrete")
    sigma = ORBIT["sigma"]
    found = [{**ORBIT, "sigma": list(order)} for order in (sigma, [sigma[1], sigma[0], sigma[2]])]
    slopes = nonlinearities(0, "175/192", slope=True)
    assert sorted(accepted(refuted(system, slopes, proof)) for proof in found) == [False, True]
    right = next(proof for proof in found if accepted(refuted(system, slopes, proof)))
    assert not accepted(refuted(system, nonlinearities(0, "175/192", slope=True, odd=True), right))
    assert not accepted(refuted(system, nonlinearities(0, "174/192", slope=True), right))
    assert not accepted(refuted(system, slopes, {**right, "u": ["192/415", "192/415", "-2"]}))
    assert not accepted(refuted(system, slopes, right, OTHERS))
    # hidden modes do not matter: (z - 1/2) z times z - 2
    hidden = transfer([2, "-77/25", "-46/25"], [1, "-5/2", 1, 0], "discrete")
    assert accepted(refuted(hidden, slopes, right))


# -1/2/(z - 1/2): sigma = -(1/2) u/(1/2) = -u at rest: with phi(1) = 1 the state stays; the origin does not count.
def test_a_constant_orbit_is_an_equilibrium():
    system = transfer(["-1/2"], [1, "-1/2"], "discrete")
    proof = {"method": "orbit", "points": [["1", "1"]], "left": "1", "right": "0", "u": ["-1"], "sigma": ["1"]}
    assert accepted(refuted(system, nonlinearities(0, 2), proof, OTHERS))
    assert not accepted(refuted(system, nonlinearities(0, 2), proof, NO_REST))
    assert not accepted(refuted(system, nonlinearities(0, 2), {**proof, "u": ["0"], "sigma": ["0"]}, OTHERS))


def flow_orbit():
    """x'' - x'/5 + x + phi(x') = 0 with a dead zone: Van der Pol's oscillator in pieces, from a simulation."""
    block = RationalPlant([1, 0], [1, F(-1, 5), 1])
    nonlinearity = Graph.through([(F(-1), F(0)), (F(1), F(0))], F(1), F(1))
    passages = Flow(PiecewiseLoop.of(companion(block), nonlinearity)).passages([2.0, 0.0], 400.0)
    first, last = returns(passages)
    stays = passages[first:last]
    return {
        "method": "flow-orbit",
        "points": [["-1", "0"], ["1", "0"]],
        "left": "1",
        "right": "1",
        "pieces": [stay.piece for stay in stays],
        "durations": [str(F(stay.duration)) for stay in stays],
        "state": [str(F(value)) for value in stays[0].state],
        "half": False,
        "inverse": [["1"]],
        "radius": "1/1000000",
        "bits": 256,
    }


def test_an_orbit_in_continuous_time():
    system, proof = transfer([1, 0], [1, "-1/5", 1]), flow_orbit()
    assert accepted(refuted(system, nonlinearities(0, 1, slope=True, odd=True), proof))
    assert not accepted(refuted(system, nonlinearities(0, "1/2", slope=True), proof))
    assert not accepted(refuted(system, nonlinearities(0, 1), {**proof, "pieces": proof["pieces"][:-1]}))
    # with a damper instead nothing can go round
    damped = transfer([1, 0], [1, "1/5", 1])
    assert not accepted(refuted(damped, nonlinearities(0, 1), proof))


def test_a_stable_gain_has_no_other_equilibria():
    assert not accepted(refuted(THIRD, nonlinearities(0, 10), {"method": "linear-gain", "gain": "7"}, OTHERS))
