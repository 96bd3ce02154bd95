"""lure.rod.motion against references to 30 digits and more that share no code with it: the error it reports is true."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from depth import rarely
from motions import other_rod, unit_rod
from mpmath import mpf
from reference_motion import derivative, reference, sine, term, total

from lure.rod import Scenario, builtin_system
from lure.rod.motion import Boundary, Numerics, exact_motion

LOADED = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
ROUNDING = 1e-15


def loaded_waves():
    """The initial waves of LOADED on the other rod (c = 2, L = 2)."""
    slope = total(term(mpf("0.2")), term(mpf("-0.2"), 1))
    speed = sine("0.2", 1, mpmath.pi / 2)
    return {
        "forward": [(0, 2, total(speed, slope, weights=[1, -2]))],
        "backward": [(0, 2, total(speed, slope, weights=[1, 2]))],
        "force": [(0, 1000, sine("0.4", "1.3"))],
    }


def compared(motion, exact, until):
    """Errors of ``z``, of the events and of the impulse against the reference."""
    t = np.linspace(0, until, 83)[1:]
    z = max(abs(float(exact(s) - mpf(float(value)))) for s, value in zip(t, motion.z(t), strict=True))
    ours = [s for impact in motion.impacts for s in (impact.start, impact.end)][: len(exact.events)]
    assert len(exact.events) == motion.crossings
    instants = max(abs(float(at - mpf(s))) for (at, _), s in zip(exact.events, ours, strict=False))
    return z, instants, abs(float(exact.impulse()) - math.fsum(i.impulse for i in motion.impacts))


@pytest.mark.slow
@pytest.mark.parametrize(
    "eps", rarely(["1e6", "0.2", "1e-3", "1e-6", "1e-9", "1e-12", "rigid"], "1e6", "1e-3", "1e-6", "1e-9", "1e-12")
)
def test_every_stiffness_agrees_with_forty_digits_within_the_error_it_reports(eps):
    rigid = eps == "rigid"
    rod = other_rod(compliance=Fraction(1 if rigid else eps), damping=Fraction("0.3"), gap=Fraction("0.1"))
    exact = reference(rod, 10, **loaded_waves(), boundary={"z": "-0.1", "rigid": rigid})
    motion = exact_motion(rod, LOADED, 10.0, boundary=Boundary(rigid=rigid))
    z, instants, impulse = compared(motion, exact, 10.0)
    assert z <= motion.error + ROUNDING
    assert motion.error < 1e-13
    assert instants < 1e-14
    assert impulse < 3e-15


@pytest.mark.slow_for("case1")
@pytest.mark.parametrize(
    "case",
    [
        {"end_damping": 0.7},
        {"clamped": True},
        pytest.param({"rigid": True, "end_damping": 0.2}, marks=pytest.mark.thorough),
        {"rigid": True, "damping": Fraction(0)},
        pytest.param({"damping": Fraction(1)}, marks=pytest.mark.thorough),
        pytest.param({"gap": Fraction("-0.05")}, marks=pytest.mark.thorough),
    ],
)
def test_every_boundary_agrees_with_forty_digits_at_every_degree(case):
    rod = other_rod(
        compliance=Fraction("0.01"), damping=case.get("damping", Fraction("0.3")), gap=case.get("gap", Fraction("0.1"))
    )
    options = {name: case[name] for name in ("end_damping", "clamped", "rigid") if name in case}
    exact = reference(rod, 8, **loaded_waves(), boundary={"z": -rod.exact["gap"], **options})
    t = np.linspace(0, 8, 53)[1:]
    truth = [exact(s) for s in t]
    for degree in (12, 24, 32):
        motion = exact_motion(rod, LOADED, 8.0, boundary=Boundary(**options), numerics=Numerics(degree=degree))
        error = max(abs(float(true - mpf(float(z)))) for true, z in zip(truth, motion.z(t), strict=True))
        assert error <= motion.error + ROUNDING, degree
        assert len(exact.events) == motion.crossings > 0


# A force that jumps at 0.37 and at 2 (a window edge is at 2), ramps, then decays; an initial velocity with a jump and a
# strain with one, at x = 0.7 and x = 1.3.  The same data as formulas and as closed pieces.
@pytest.mark.slow
def test_jumps_and_kinks_of_all_data_agree_with_forty_digits():
    late = {mu: [value * mpmath.exp(2) for value in c] for mu, c in term(mpf("0.5"), 0, -1).items()}
    force = [(0, mpf("0.37"), term(mpf("0.3"))), (mpf("0.37"), 2, term(mpf("0.2"), 1)), (2, 1000, late)]
    low, high = term(mpf("0.6")), term(mpf("-0.2"))
    bent = {False: term(mpf("-0.4")), True: term(mpf("0.4"))}

    def waves(sign):
        parts = ((0, "0.7", low, False), ("0.7", "1.3", high, False), ("1.3", 2, high, True))
        return [(mpf(a), mpf(b), total(v, bent[w], weights=[1, 2 * sign])) for a, b, v, w in parts]

    scenario = Scenario.parse(
        force="where(t < 0.37, 0.3, where(t < 2, 0.2*t, 0.5*exp(2 - t)))",
        velocity="where(x < 0.7, 0.6, -0.2)",
        displacement="0.4*abs(x - 1.3) - 0.28",
    )
    rod = other_rod(compliance=Fraction("0.05"), damping=Fraction("0.3"), gap=Fraction("0.1"))
    exact = reference(rod, 12, forward=waves(-1), backward=waves(1), force=force, boundary={"z": "-0.1"})
    motion = exact_motion(rod, scenario, 12.0)
    z, instants, impulse = compared(motion, exact, 12.0)
    assert z <= motion.error + ROUNDING
    assert instants < 1e-14
    assert impulse < 3e-15


# Figure 6 in exact arithmetic: w(0, x) = -e, v = 0.  a = (k - Z)/(k + Z) is rational, (2e-4 - 1.2)/(2e-4 + 1.2), so the
# corners of the triangle wave are rational: u(n) = -e/2 + e (1 + q + .. + q^(n-1)) (1 - 1) .. by transits, q = -a.
def test_the_thousandth_round_trip_of_the_released_rod_in_rational_arithmetic():
    system = builtin_system("paper-rod")
    rod, e, T = system.rod, Fraction(2, 10000), Fraction(1, 6000)
    k, Z = rod.exact["damping"], Fraction(6, 5)
    q = (Z - k) / (Z + k)
    assert (
        rod.exact["area"] ** 2 * rod.exact["density"] * rod.exact["youngs_modulus"],
        rod.exact["density"] / rod.exact["youngs_modulus"],
    ) == (Z**2, T**2)
    motion = exact_motion(rod, system.scenario, float(2000 * T), numerics=Numerics(keep=3))
    with mpmath.workdps(40):
        for trip in (998, 999):
            power = mpf(q.numerator) ** trip / mpf(q.denominator) ** trip
            # each round trip rises by e q^n in its first transit and falls by q e q^n in its second
            start = -mpf(1) / 2 + (1 - mpf(q.numerator) / q.denominator) * (1 - power) / (1 - _mp(q))
            for share in (Fraction(0), Fraction(1, 7), Fraction(1, 2), Fraction(6, 7)):
                t = float((2 * trip + share) * T)
                place = (Fraction(t) / T) - 2 * trip
                first, second = min(max(place, 0), 1), max(place - 1, 0)
                expected = _mp(e) * (start + power * (_mp(first) - _mp(q) * _mp(second)))
                assert abs(float(mpf(float(motion.end_displacement(t))) - expected)) < 1e-12 * float(e) / 2


def _mp(fraction):
    return mpf(Fraction(fraction).numerator) / Fraction(fraction).denominator


# Thrown at v = 1 against p = z^m/eps with no gap: W = 1 until 2T, so t = int_0^z dy/(1 - y^m/eps)
# = z F(1, 1/m; 1 + 1/m; z^m/eps), for any m > 0.  dz = z' dt turns the miss in t into one in z.
@pytest.mark.parametrize("eps", ["1", "0.1"])
@pytest.mark.parametrize("exponent", ["0.1", "0.3", "0.5", "0.9", "1.5", "2", "3", "10", "40"])
def test_power_laws_agree_with_the_hypergeometric_function_within_the_error_they_report(exponent, eps):
    rod = unit_rod(gap=0, compliance=Fraction(eps), exponent=Fraction(exponent))
    motion = exact_motion(rod, Scenario.parse(velocity="1"), 2.0)
    m, compliance = mpf(exponent), mpf(eps)
    times = np.array([0.003, 0.03, 0.1, 0.3, 0.6, 0.9, 1.3]) * min(1.0, float(compliance ** (1 / m)))
    assert motion.error < 1e-12
    with mpmath.workdps(30):
        for t, z in zip(times, motion.z(times), strict=True):
            x = mpf(float(z)) ** m / compliance
            if x >= 1 - mpf(10) ** -6:  # at rest to rounding: z is eps^(1/m)
                assert float(z) == pytest.approx(float(compliance ** (1 / m)), rel=1e-6)
                continue
            reached = mpf(float(z)) * mpmath.hyp2f1(1, 1 / m, 1 + 1 / m, x)
            assert abs(float((reached - mpf(t)) * (1 - x))) <= motion.error + ROUNDING


@pytest.mark.slow
def test_the_reference_itself_satisfies_its_equation():
    rod = other_rod(compliance=Fraction("0.2"), damping=Fraction("0.3"), gap=Fraction("0.1"))
    exact = reference(rod, 6, **loaded_waves(), boundary={"z": "-0.1"})
    for low, high, z, push, V in exact.pieces:
        s = (high - low) / 3
        # V = 2 z' - W and z' = W - d p, hence V = z' - d p; d/eps = 2.5
        assert abs(sum_value(V, s) - (sum_value(derivative(z), s) - sum_value(push, s))) < 1e-30
        assert abs(sum_value(push, s) - 2.5 * max(sum_value(z, s), 0)) < 1e-30
    assert {up for _, up in exact.events} == {True, False}


def sum_value(f, s):
    """A value; of nothing, zero."""
    return mpmath.fsum(mpmath.exp(mu * s) * mpmath.polyval(c[::-1], s) for mu, c in f.items()).real if f else mpf(0)
