"""Periodic solutions with a play or a stop: found, enclosed by both checkers, and followed in floating point."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, as_plant, certify, max_sector
from lure.analysis.certificates.checker import MOVES, check
from lure.analysis.certificates.second.opinion import recheck


@cache
def found(kind):
    return max_sector(as_plant("1/(s+1)^3"), [NonlinearityClass.hysteretic(kind)])


# the elastic part of a stop oscillates from the slope 8 on.  Of a play: 1 + g (1 - N(a)) H(i w) = 0 with the describing
# function N of the stop is first met at g = 5.883, a = 2.55; the linear loop of slope 8 is where large solutions grow
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "low", "high"), [("stop", 8, 8.01), ("play", 5.5, 5.9)])
def test_both_checkers_accept_the_orbit_found(kind, low, high):
    shown = found(kind)
    assert low < shown.refuted_at < high
    assert shown.largest.low < low
    certificate = dict(shown.refutation.certificate)
    assert certificate["proof"]["method"] == "memory-orbit"
    assert certificate["conclusion"] == MOVES
    FORMAT.validate(certificate)
    check(certificate)
    assert recheck(certificate).accepted
    assert f"a {kind} of slope" in shown.witness.description
    assert "makes the loop oscillate" in shown.witness.description
    assert shown.witness.kind == "periodic orbit"


@pytest.mark.parametrize(
    ("kind", "path", "value"),
    [
        ("stop", ("laws", "channels", 0, "memory"), "play"),
        ("play", ("laws", "channels", 0, "memory"), "stop"),
        ("play", ("laws", "channels", 0, "slope"), ["0", "5"]),
        ("play", ("proof", "gains", 0), lambda g: str(Fraction(g) * Fraction(999, 1000))),
        ("play", ("proof", "gains", 0), lambda g: "-" + g),
        ("play", ("proof", "gains", 0), "9"),
        ("play", ("proof", "half"), False),
        ("play", ("proof", "durations", 1), lambda t: "-" + t),
        ("stop", ("proof", "durations", 0), "1"),
        ("stop", ("system", "A", 0, 0), "-2"),
        ("stop", ("system", "D"), [["1"]]),
        ("stop", ("system", "time"), "discrete"),
        ("stop", ("conclusion",), lambda _: "0 attracts every motion"),
    ],
)
def test_neither_accepts_what_was_changed(kind, path, value):
    certificate = found(kind).refutation.certificate
    assert_both_reject(edited(certificate, *path, value=value), stored=path == ("conclusion",))


def test_another_class_has_no_such_orbit():
    certificate = dict(found("stop").refutation.certificate)
    plain = {key: value for key, value in certificate["laws"]["channels"][0].items() if key != "memory"}
    assert_both_reject(edited(certificate, "laws", "channels", 0, value=plain))


@pytest.mark.parametrize("kind", ["stop", "play"])
def test_the_orbit_is_a_solution_of_the_loop_followed_in_small_steps(kind):
    shown = found(kind).refutation.certificate
    proof, system = shown["proof"], shown["system"]
    A, B, C = (np.array([[float(Fraction(v)) for v in row] for row in system[name]]) for name in "ABC")
    g, (*x, xi) = float(Fraction(proof["gains"][0])), (float(Fraction(v)) for v in proof["state"])
    x, half = np.array(x), sum(float(Fraction(t)) for t in proof["durations"])
    first, steps = x.copy(), 8_000
    dt = half / steps
    for _ in range(steps):  # the midpoint rule; p moves when sigma pushes it

        def velocity(x, xi):
            return A @ x - B[:, 0] * g * (xi if kind == "stop" else float(C[0] @ x) - xi)

        middle = x + dt / 2 * velocity(x, xi)
        between = np.clip(xi + float(C[0] @ (middle - x)), -1, 1)
        new = x + dt * velocity(middle, between)
        xi, x = float(np.clip(xi + float(C[0] @ (new - x)), -1, 1)), new
    assert x == pytest.approx(-first, abs=1e-4 * np.abs(first).max())
    assert xi == pytest.approx(-1)


@pytest.mark.slow
def test_one_class_is_refuted_as_it_stands_and_beside_a_function():
    play = NonlinearityClass.hysteretic("play", 6)
    assert certify(as_plant("1/(s+1)^3"), [play]).verdict.name == "REFUTED"
    plant = as_plant([["1/(s+1)^3", "0"], ["1/(s+1)", "1/(s+1)"]])
    shown = certify(plant, [play, NonlinearityClass.slope_restricted(0, 1)])
    assert shown.verdict.name == "REFUTED"
    assert shown.shown.certificate["proof"]["gains"][1] == "0"
    assert recheck(shown.shown.certificate).accepted


@pytest.mark.slow
def test_a_solution_that_is_not_isolated_is_no_error_of_the_search():
    # -3/(s + 2), the mode -2 twice: it rests where a stop holds it, and what closes is found beside others of the kind
    plant = as_plant(([[-2, 0], [0, -2]], [[-1], ["3/2"]], [["-3/2", -3]], 0))
    assert "no multiplier" in certify(plant, [NonlinearityClass.hysteretic("stop")]).conclusion.reason
