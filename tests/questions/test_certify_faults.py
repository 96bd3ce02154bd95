"""Whatever the searches do, only what the checker accepts is a verdict."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from asking import THIRD, asked, sector

from lure import NonlinearityClass, RationalPlant, Sector, SlopeBounds
from lure.analysis.certificates import by_matrices, codes
from lure.analysis.theorems import circle, park, popov, zames_falb_discrete
from lure.analysis.verdict import Bracket, Evidence, Verdict, Witness

# s^2/(s^3 + 2 s^2 + 2 s + 1): stable for every linear gain, Popov reaches 8.89898 and the circle 8.12086
SEVENTH = RationalPlant([1, 0, 0], [1, 2, 2, 1])
MASS = RationalPlant(
    [Fraction(2), Fraction("0.92")], [1, Fraction("-0.5"), 0], 1
)  # slopes from 175/192 on have an orbit


class PanicException(BaseException):
    """What a compiled solver raises when it panics: no Exception."""


FAULTS = [
    (np.linalg.LinAlgError("Singular matrix"), codes.SOLVER_FAILED),
    (ValueError("array must not contain infs or NaNs"), codes.NO_NUMBERS),
    (ZeroDivisionError("division by zero"), codes.NO_NUMBERS),
    (OverflowError("int too large to convert to float"), codes.RANGE),
    (FloatingPointError("underflow"), codes.NO_NUMBERS),
    (MemoryError(), codes.OUT_OF_MEMORY),
    (RecursionError("maximum recursion depth exceeded"), codes.OUT_OF_MEMORY),
    (TimeoutError("slow"), codes.OUT_OF_TIME),
    (PanicException("unwrap on None"), codes.SOLVER_FAILED),
    (KeyError("x"), codes.UNEXPECTED),
    (AssertionError("never"), codes.UNEXPECTED),
]


@pytest.mark.parametrize(("error", "code"), FAULTS, ids=lambda each: type(each).__name__)
def test_a_criterion_that_raises_ends_inconclusive(monkeypatch, error, code):
    def broken(*_arguments, **_options):
        raise error

    monkeypatch.setattr(popov, "popov_criterion", broken)
    found = asked(THIRD, sector(0, 5), "popov")
    assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, code)


@pytest.mark.parametrize(("error", "code"), FAULTS, ids=lambda each: type(each).__name__)
def test_a_refutation_that_raises_refutes_nothing_and_hides_no_proof(monkeypatch, error, code):
    def broken(*_arguments, **_options):
        raise error

    monkeypatch.setattr("lure.analysis.certificates.refutations.refutation_draft", broken)
    against = asked(THIRD, sector(0, 7), "popov")  # Routh refutes it from 6 on, and nothing else does
    assert against.verdict is Verdict.INCONCLUSIVE
    assert code in {failure.code for failure in against.failures}
    found = asked(THIRD, sector(0, 5), "popov")  # there is nothing to refute
    assert found.verdict is Verdict.PROVED


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, SystemExit])
def test_the_users_interrupt_is_no_result(monkeypatch, interrupt):
    def stopped(*_arguments, **_options):
        raise interrupt

    monkeypatch.setattr(popov, "popov_criterion", stopped)
    with pytest.raises(interrupt):
        asked(THIRD, sector(0, 5), "popov")


@pytest.mark.parametrize("theta", ["nan", "inf", "-inf", "0", "1", "-1", "1e400", "1/0", "", "x", None, "7/3", 0.25])
def test_a_criterion_that_always_says_proved_proves_nothing_false(monkeypatch, theta):
    honest = popov.popov_criterion(SEVENTH, Sector(0, 8))

    def always(_block, bounds, **_options):
        parameters = {**honest.parameters, "theta": theta}
        nonlinearity_class = NonlinearityClass(sector=bounds)
        return replace(honest, verdict=Verdict.PROVED, parameters=parameters, nonlinearity_class=nonlinearity_class)

    monkeypatch.setattr(popov, "popov_criterion", always)
    found = asked(SEVENTH, sector(0, 9), "popov")  # beyond Popov's reach, 8.89898, with whatever multiplier
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.code in (codes.REJECTED, codes.NO_NUMBERS, codes.PRECISION)


def test_a_circle_criterion_that_always_says_proved_proves_nothing_false(monkeypatch):
    honest = circle.circle_criterion(THIRD, Sector(0, 1))
    lie = replace(honest, largest=Bracket(math.inf, math.inf))
    monkeypatch.setattr(
        circle, "circle_criterion", lambda _b, s: replace(lie, nonlinearity_class=sector(s.lower, s.upper))
    )
    # the circle criterion reaches 4/3 and not 4/3 itself: there a class smaller by 1e-15 is accepted, at 2 none
    for k, code in ((Fraction(4, 3), codes.PRECISION), (Fraction(2), codes.REJECTED)):
        found = asked(THIRD, sector(0, k), "circle")
        assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, code)
    assert asked(THIRD, sector(0, Fraction(133, 100)), "circle").verdict is Verdict.PROVED


@pytest.fixture(scope="module")
def honest():
    return zames_falb_discrete.zames_falb_discrete_criterion(MASS, SlopeBounds(0, Fraction(1, 2)), odd=False)


@pytest.mark.parametrize(
    "taps",
    [{}, {"1": "nan"}, {"1": "2"}, {"0": "1/2"}, {"x": "1"}, {"-1": "-1/2"}, [["1", "2"]], {"1": "1/2", "-1": "1/2"}],
)
def test_multipliers_out_of_thin_air_prove_nothing(monkeypatch, honest, taps):
    # slopes in [0, 0.95] of example 6 have an orbit of period 3
    def always(_block, bounds, **_options):
        nonlinearity_class = NonlinearityClass.slope_restricted(bounds.lower, bounds.upper)
        return replace(honest, verdict=Verdict.PROVED, parameters={"taps": taps}, nonlinearity_class=nonlinearity_class)

    monkeypatch.setattr(zames_falb_discrete, "zames_falb_discrete_criterion", always)
    found = asked(MASS, NonlinearityClass.slope_restricted(0, Fraction("0.95")), "zames-falb")
    assert found.verdict is Verdict.INCONCLUSIVE


def test_two_digits_of_a_multiplier_prove_nothing_false(monkeypatch):
    exact = park.park_criterion

    def rounded(block, bounds, **options):
        found = exact(block, bounds, **options)
        coarse = {key: f"{float(Fraction(v)):.1g}" for key, v in found.parameters.items() if key in ("theta", "tau")}
        fractions = {key: str(Fraction(v)) for key, v in coarse.items()}
        return replace(found, verdict=Verdict.PROVED, parameters={**found.parameters, **fractions})

    monkeypatch.setattr(park, "park_criterion", rounded)
    block = RationalPlant([1, Fraction("-0.2"), Fraction("-0.1")], [1, 2, 1, 1])  # Hurwitz limit 4.58945
    for k in ("3.7", "4.58", "4.5894", "4.5895", "5"):
        found = asked(block, NonlinearityClass.slope_restricted(0, Fraction(k)), "park")
        if Fraction(k) > Fraction("4.58946"):
            assert found.verdict is Verdict.REFUTED
        elif found.verdict is not Verdict.PROVED:
            assert found.code is codes.REJECTED


@pytest.mark.parametrize("gain", ["5", "1/2", "-1", "0", "nan", "1/0", ""])
def test_a_gain_that_is_stable_or_outside_the_class_refutes_nothing(monkeypatch, gain):
    lie = Witness(
        kind="linear gain",
        k=1.0,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description="phi = k sigma: said to destabilise",
        data={"gain": gain, "lower": "0"},
    )
    monkeypatch.setattr("lure.analysis.counterexamples.linear.linear_witness", lambda *_a, **_o: lie)
    found = asked(THIRD, sector(0, 2, time_varying=True), "circle")
    assert found.verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    "P",
    [
        [["nan"], ["nan", "nan"]],
        [["1"], ["0", "1"]],
        [["-1"], ["0", "1"]],
        [["1e9"], ["0", "1"]],
        [[1], [0, 1]],
        [["1"]],
        [],
        "P",
    ],
)
def test_a_matrix_out_of_thin_air_proves_nothing(monkeypatch, P):
    # Popov reaches 6 and the class ends at 5.99: neither 1 nor -1 will do
    honest = by_matrices.matrix_draft
    proof = {
        "method": "matrix",
        "P": P,
        "exponent": 0,
        "zero": {"right": ["1", "0", "0"], "left": ["2", "3", "1"], "pivot": 0},
    }

    def lie(block, upper, **options):
        return {**honest(block, upper, **options), "proof": proof}

    monkeypatch.setattr(by_matrices, "matrix_draft", lie)
    found = asked(THIRD, sector(0, Fraction("5.99")), "popov", method="matrix")
    assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, codes.REJECTED)


def test_the_end_of_the_time_ends_all_searches(monkeypatch):
    def slow(*_arguments, **_options):
        raise TimeoutError("the time allowed, 1 s, is over")

    monkeypatch.setattr(popov, "popov_criterion", slow)
    found = asked(THIRD, NonlinearityClass.slope_restricted(0, 5))  # four more criteria would follow
    assert [failure.search for failure in found.failures] == ["circle", "popov"]
    assert found.code is codes.OUT_OF_TIME


@pytest.mark.parametrize("evidence", [Evidence.OBSERVED, Evidence.COMPUTED])
def test_an_orbit_that_is_not_proved_refutes_nothing(monkeypatch, evidence):
    seen = Witness(
        kind="periodic orbit",
        k=3.0,
        evidence=evidence,
        slope_restricted=True,
        odd=True,
        description="phi piecewise linear: seems to oscillate",
    )
    monkeypatch.setattr("lure.analysis.counterexamples.search.refute", lambda *_a, **_o: (seen,))
    found = asked(THIRD, sector(0, 4, time_varying=True))
    assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, codes.UNPROVED_ORBIT)
    assert "seems to oscillate" in found.detail
    smaller = asked(THIRD, sector(0, 2.95, time_varying=True))  # the nonlinearity is outside this class
    assert smaller.code is codes.NO_MULTIPLIER


def test_the_time_allowed_is_kept():
    found = asked(MASS, NonlinearityClass.slope_restricted(0, Fraction("0.9")), seconds=0.01)
    assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, codes.OUT_OF_TIME)
