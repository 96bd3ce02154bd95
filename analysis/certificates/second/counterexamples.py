"""Refutations: a law of the class and a motion of its loop that does not come to rest, or does at another place."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from flint import arb_mat

from analysis.certificates.second import claims, structure
from analysis.certificates.second.classes import Laws
from analysis.certificates.second.gains import Kind, critical_end, positive_root, require_crossing, unstable_kind
from analysis.certificates.second.matrix import require_growth
from analysis.certificates.second.orbits import orbit_kind, require_flow_orbit
from analysis.certificates.second.reading import Document, NotShown, count, listed, number, numbers, record, require
from analysis.certificates.second.systems import Rational, RodData, System
from analysis.precision import ball, working_precision
from analysis.refutation.realisation import balls

BITS = (512, 2048)
SQUARINGS = 80
LONGEST = 10_000
LARGEST_COUNT = 100_000


def refuted(document: Document, system: System, laws: Laws) -> str:
    """The sentence that a counterexample shows.

    Raises
    ------
    NotShown
        The law is not in the class, or the motion is not shown.
    """
    require(document.theorem == "counterexample", "a refutation is a counterexample")
    require(document.law is None, "a refutation names no law")
    record(document.multiplier)
    proof, method = document.proof, document.proof.get("method")
    if isinstance(system, RodData):
        return structure.refuted(document, system, laws)
    if method == "crossing":
        found = record(proof, "method", "gains", "frequencies")
        low, high = _pair(found["gains"])
        require(laws.has_gain(low) and laws.has_gain(high), "the gains are not in the class")
        require_crossing(system, (low, high), _pair(found["frequencies"]))
        return claims.NO_REST
    if method == "linear-gain":
        gain = number(record(proof, "method", "gain")["gain"])
        require(laws.has_gain(gain), "the gain is not in the class")
        if not isinstance(system, Rational):
            return claims.NO_REST if positive_root(system, gain) == "no rest" else claims.OTHER_EQUILIBRIA
        if 1 + gain * system.feedthrough == 0:
            return claims.NO_SOLUTION
        return _sentence(unstable_kind(system, gain), system, laws)
    if not isinstance(system, Rational):
        raise NotShown("with dead time only gains are shown")
    if method == "matrix-gain":
        require_growth(system, laws, proof)
        return claims.NO_REST
    if method == "switched-gain":
        _require_switched(proof, system, laws)
        return claims.NO_REST
    if method == "orbit":
        return _sentence(orbit_kind(proof, system, laws), system, laws)
    require(method == "flow-orbit", "the method is unknown")
    require_flow_orbit(proof, system, laws)
    return claims.NO_REST


def _sentence(kind: Kind, system: Rational, laws: Laws) -> str:
    """Other equilibria refute only a class in which 0 would have to attract every motion."""
    if kind == "no rest":
        return claims.NO_REST
    require(not critical_end(system, laws), "the loop has a pole at 0 anyway: other equilibria refute nothing")
    return claims.OTHER_EQUILIBRIA


def _require_switched(proof: Mapping[str, object], system: Rational, laws: Laws) -> None:
    """Check ``|tr M^N| > n`` for the matrix ``M`` of one period: it has an eigenvalue outside the unit disc."""
    names = ["method", "gains", "squarings", "bits"] + ([] if system.discrete else ["times"])
    found = record(proof, *names)
    count(found["squarings"])
    require(count(found["bits"], least=2) <= LARGEST_COUNT, "bits is too large")
    gains, n = numbers(found["gains"]), system.realisation.order
    times = [Fraction(1)] * len(gains) if system.discrete else numbers(found["times"])
    require(0 < len(gains) == len(times) <= LONGEST and n > 0, "gains and times do not fit")
    require(all(time > 0 for time in times), "a time is not positive")
    require(all(laws.has_gain(gain) for gain in gains), "a gain is not in the class")
    require(len(set(gains)) == 1 or (laws.time_varying and not laws.linear), "the class has no gains that vary in time")
    require(all(1 + gain * system.feedthrough != 0 for gain in gains), "with one of the gains the loop has no solution")
    for bits in BITS:
        with working_precision(bits):
            product = balls([[Fraction(int(i == j)) for j in range(n)] for i in range(n)])
            steps: dict[tuple[Fraction, Fraction], arb_mat] = {}
            for gain, time in zip(gains, times, strict=True):
                if (gain, time) not in steps:
                    closed = balls(system.realisation.closed(gain))
                    steps[gain, time] = closed if system.discrete else (closed * ball(time)).exp()
                product = steps[gain, time] * product
            for _ in range(SQUARINGS):
                if abs(product.trace()) > n:
                    return
                product = product * product
    raise NotShown("no eigenvalue outside the unit disc is shown")


def _pair(value: object) -> tuple[Fraction, Fraction]:
    ends = [number(end) for end in listed(value)]
    require(len(ends) == 2, "a pair of numbers is missing")
    return ends[0], ends[1]
