"""Refutations: a member of the class and a solution that does not come to rest, or does at another place."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from flint import arb_mat

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second import structure
from lure.analysis.certificates.second.classes import Graph, Nonlinearities, graph
from lure.analysis.certificates.second.gains import Kind, critical_end, positive_root, require_crossing, unstable_kind
from lure.analysis.certificates.second.late_loops import late_companion, require_returning
from lure.analysis.certificates.second.matrix import require_growth
from lure.analysis.certificates.second.numerics import ball, balls, to_fraction, working_precision
from lure.analysis.certificates.second.orbits import orbit_numbers, require_periodic, stays_of
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    number,
    numbers,
    record,
    require,
    tick,
)
from lure.analysis.certificates.second.systems import Delayed, Rational, RodData, System

# Periodic solutions with a piecewise-linear nonlinearity: exact in discrete time, proved by Krawczyk's test in
# continuous.

LONGEST = 100_000


def orbit_kind(proof: Mapping[str, object], system: Rational, nonlinearities: Nonlinearities) -> Kind:
    """An orbit in discrete time, exactly: ``sum d_i sigma[t+i] = sum n_i u[t+i]`` and ``u = -phi(sigma)``.

    The equation is that of the coprime ``n`` and ``d``, whose states follow from ``u`` and ``sigma``; hidden modes do
    not disturb it.

    Raises
    ------
    NotShown
        It is no orbit of the loop, it rests at 0, or the nonlinearity is not in the class.
    """
    found = record(proof, "method", "points", "left", "right", "u", "sigma")
    require(system.discrete, "exact orbits are for discrete time")
    nonlinearity = _nonlinearity(found, nonlinearities)
    u, sigma = numbers(found["u"]), numbers(found["sigma"])
    period = len(u)
    require(0 < period == len(sigma) <= LONGEST, "u and sigma have no common period")
    require(all(-nonlinearity.at(s) == value for s, value in zip(sigma, u, strict=True)), "u is not -phi(sigma)")
    top, bottom = _coprime(system)
    for t in range(period):
        left = sum((c * sigma[(t + i) % period] for i, c in enumerate(bottom)), Fraction(0))
        right = sum((c * u[(t + i) % period] for i, c in enumerate(top)), Fraction(0))
        require(left == right, f"the difference equation fails at sample {t}")
    if any(s != sigma[0] for s in sigma):
        return "no rest"
    require(sigma[0] != 0, "the orbit rests at 0")
    return "equilibria"


def _require_scaled(
    proof: Mapping[str, object], system: Rational, nonlinearities: Nonlinearities, rate: Fraction
) -> None:
    """Check a solution that is ``s`` times as large after ``p`` samples, ``|s| >= r^p``, of one ``phi`` of the class.

    Chords between any two of its points, one of them times ``|s|^k``, are means of those between neighbours, and
    neighbours are at most one power apart in size: all chords are looked at for three ``k``.

    Raises
    ------
    NotShown
        It is none, or no such ``phi`` is in the class.
    """
    found = record(proof, "method", "scale", "u", "sigma")
    s, u, sigma = number(found["scale"]), numbers(found["u"]), numbers(found["sigma"])
    p, size = len(u), abs(s)
    require(0 < p == len(sigma) <= COUNTEREXAMPLES_LONGEST and size not in (0, 1), "u, sigma and the scale do not fit")
    require(rate**p <= size and any(v != 0 for v in sigma), "it falls faster than the rate, or rests")
    require(not nonlinearities.linear and system.feedthrough == 0, "phi is linear, or D is not 0")
    top, bottom = _coprime(system)
    later = [[v * s**k for k in range(1 + len(bottom) // p + 1) for v in side] for side in (u, sigma)]
    for t in range(p):
        left = sum((c * later[1][t + i] for i, c in enumerate(bottom)), Fraction(0))
        require(left == sum((c * later[0][t + i] for i, c in enumerate(top)), Fraction(0)), "it is no solution")
    require(all(w == 0 for x, w in zip(sigma, u, strict=True) if x == 0), "phi(0) is not 0")
    points = [(x, -w) for x, w in zip(sigma, u, strict=True) if x != 0]
    if s < 0 or nonlinearities.odd:
        points = [(x, w) if x > 0 else (-x, -w) for x, w in points]
    for x, w in points:
        require(
            claims.at_least(w / x, nonlinearities.lower) and claims.at_most(w / x, nonlinearities.upper),
            "not in the sector",
        )
    for x, w in points:
        for y, v in points:
            tick()
            if (x > 0) is not (y > 0):
                continue
            near = _power(y / x, size)
            for k in (near - 1, near, near + 1):
                a, b = x * size**k, w * size**k
                if a == y:
                    require(b == v, "phi has two values")
                elif nonlinearities.slope is not None:
                    low, high = nonlinearities.slope
                    slope = (v - b) / (y - a)
                    require(claims.at_least(slope, low) and claims.at_most(slope, high), "a slope is not in the class")


def _coprime(system: Rational) -> list[list[Fraction]]:
    """The coefficients of ``n`` and ``d``, lowest power first, without what they share."""
    n, d = system.polynomials
    return [[to_fraction(c) for c in (side // n.gcd(d)).coeffs()] for side in (n, d)]


def _power(ratio: Fraction, size: Fraction) -> int:
    """The ``k`` with ``size^k <= ratio < size^(k + 1)``, or with the signs turned where ``size < 1``."""
    k, step = 0, max(size, 1 / size)
    while not step**k <= ratio < step ** (k + 1):
        tick()
        k += 1 if ratio >= step ** (k + 1) else -1
    return k if size > 1 else -k


def require_flow_orbit(proof: Mapping[str, object], system: Rational, nonlinearities: Nonlinearities) -> None:
    """Check that a periodic orbit in continuous time is proved to exist near the approximate one.

    Raises
    ------
    NotShown
        It is not proved, or the nonlinearity is not in the class.
    """
    found = record(
        proof,
        *("method", "points", "left", "right", "pieces", "durations", "state", "half", "inverse", "radius", "bits"),
    )
    require(not system.discrete, "flows are for continuous time")
    pieces = [count(piece) for piece in listed(found["pieces"])]
    state, durations, half = orbit_numbers(found)
    require(len(state) == system.states.order > 0 and len(durations) == len(pieces) > 1, "the orbit has gaps")
    stays = stays_of(system.states, _nonlinearity(found, nonlinearities), pieces, half=half)
    require_periodic(stays, state, durations, half=half)


def _nonlinearity(found: Mapping[str, object], nonlinearities: Nonlinearities) -> Graph:
    nonlinearity = graph(found["points"], found["left"], found["right"])
    require(nonlinearities.has(nonlinearity), "the nonlinearity of the solution is not in the class")
    return nonlinearity


BITS = (512, 2048)
SQUARINGS = 80
COUNTEREXAMPLES_LONGEST = 10_000
LARGEST_COUNT = 100_000


def refuted(document: Document, system: System, nonlinearities: Nonlinearities) -> str:
    """The sentence that a counterexample shows.

    Raises
    ------
    NotShown
        The nonlinearity is not in the class, or the solution is not shown.
    """
    require(document.theorem == "counterexample", "a refutation is a counterexample")
    require(document.nonlinearity is None, "a refutation names no nonlinearity")
    record(document.multiplier)
    proof, method = document.proof, document.proof.get("method")
    if isinstance(system, RodData):
        return structure.refuted(document, system, nonlinearities)
    if method == "crossing":
        found = record(proof, "method", "gains", "frequencies")
        low, high = _pair(found["gains"])
        require(nonlinearities.has_gain(low) and nonlinearities.has_gain(high), "the gains are not in the class")
        require_crossing(system, (low, high), _pair(found["frequencies"]))
        return claims.NO_REST
    if method == "linear-gain":
        gain = number(record(proof, "method", "gain")["gain"])
        require(nonlinearities.has_gain(gain), "the gain is not in the class")
        if not isinstance(system, Rational):
            return (
                claims.NO_REST
                if positive_root(system, gain, nonlinearities.ends[0]) == "no rest"
                else claims.OTHER_EQUILIBRIA
            )
        if 1 + gain * system.feedthrough == 0:
            return claims.NO_SOLUTION
        return _sentence(unstable_kind(system, gain), system, nonlinearities, paced=document.rate is not None)
    if not isinstance(system, Rational):
        require(method == "switched-gain", "with dead time only gains are shown")
        _require_jumps(proof, system, nonlinearities)
        return claims.NO_REST
    if method == "matrix-gain":
        require_growth(system, nonlinearities, proof)
        return claims.NO_REST
    if method == "switched-gain":
        _require_switched(proof, system, nonlinearities)
        return claims.NO_REST
    if method == "orbit" and document.rate is not None:
        _require_scaled(proof, system, nonlinearities, document.rate)
        return claims.NO_REST
    if method == "orbit":
        return _sentence(orbit_kind(proof, system, nonlinearities), system, nonlinearities, paced=False)
    require(method == "flow-orbit", "the method is unknown")
    require_flow_orbit(proof, system, nonlinearities)
    return claims.NO_REST


def _sentence(kind: Kind, system: Rational, nonlinearities: Nonlinearities, *, paced: bool) -> str:
    """Other equilibria refute only a class in which 0 would have to attract every solution."""
    if kind == "no rest":
        return claims.NO_REST
    require(
        paced or not critical_end(system, nonlinearities),
        "the loop has a pole at 0 anyway: other equilibria refute nothing",
    )
    return claims.OTHER_EQUILIBRIA


def _require_switched(proof: Mapping[str, object], system: Rational, nonlinearities: Nonlinearities) -> None:
    """Check ``|tr M^N| > n`` for the matrix ``M`` of one period: it has an eigenvalue outside the unit disc."""
    names = ["method", "gains", "squarings", "bits"] + ([] if system.discrete else ["times"])
    found = record(proof, *names)
    count(found["squarings"])
    require(count(found["bits"], least=2) <= LARGEST_COUNT, "bits is too large")
    gains, n = numbers(found["gains"]), system.states.order
    times = [Fraction(1)] * len(gains) if system.discrete else numbers(found["times"])
    require(0 < len(gains) == len(times) <= COUNTEREXAMPLES_LONGEST and n > 0, "gains and times do not fit")
    require(all(time > 0 for time in times), "a time is not positive")
    require(all(nonlinearities.has_gain(gain) for gain in gains), "a gain is not in the class")
    require(
        len(set(gains)) == 1 or (nonlinearities.time_varying and not nonlinearities.linear),
        "the class has no gains that vary in time",
    )
    require(all(1 + gain * system.feedthrough != 0 for gain in gains), "with one of the gains the loop has no solution")
    for bits in BITS:
        with working_precision(bits):
            product = balls([[Fraction(int(i == j)) for j in range(n)] for i in range(n)])
            steps: dict[tuple[Fraction, Fraction], arb_mat] = {}
            for gain, time in zip(gains, times, strict=True):
                if (gain, time) not in steps:
                    closed = balls(system.states.closed(gain))
                    steps[gain, time] = closed if system.discrete else (closed * ball(time)).exp()
                product = steps[gain, time] * product
            for _ in range(SQUARINGS):
                if abs(product.trace()) > n:
                    return
                product = product * product
    raise NotShown("no eigenvalue outside the unit disc is shown")


def _require_jumps(proof: Mapping[str, object], system: Delayed, nonlinearities: Nonlinearities) -> None:
    """Check that gains which jump beside dead time let a solution grow, of ``(d + g n_0) y + sum (q + g n) y(t - T)``.

    ``n y`` is ``sigma`` and the rest ``mu = -g sigma``, with ``x = (y, y', ..)``.
    """
    found = record(proof, "method", "gains", "times", "multiplier", "bits")
    count(found["bits"], least=2)
    gains, times = numbers(found["gains"]), numbers(found["times"])
    require(0 < len(gains) == len(times) <= COUNTEREXAMPLES_LONGEST, "gains and times do not fit")
    require(all(time > 0 for time in times), "a time is not positive")
    require(all(nonlinearities.has_gain(gain) for gain in gains), "a gain is not in the class")
    free = nonlinearities.time_varying and not nonlinearities.linear
    require(len(set(gains)) == 1 or free, "the class has no gains that vary in time")
    with working_precision(BITS[0]):
        require_returning([late_companion(system, gain) for gain in gains], times, numbers(found["multiplier"]))


def _pair(value: object) -> tuple[Fraction, Fraction]:
    ends = [number(end) for end in listed(value)]
    require(len(ends) == 2, "a pair of numbers is missing")
    return ends[0], ends[1]
