"""Periodic motions with a piecewise-linear law: exact in discrete time, proved by Krawczyk's test in continuous."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from analysis.certificates.second.classes import Laws, graph
from analysis.certificates.second.gains import Kind
from analysis.certificates.second.reading import count, flag, listed, number, numbers, record, require
from analysis.certificates.second.systems import Rational
from analysis.polynomial import to_fraction
from analysis.refutation.piecewise import PiecewiseLoop
from analysis.refutation.validated import Itinerary, proved, refined
from lure.laws.graph import Graph

LONGEST = 100_000


def orbit_kind(proof: Mapping[str, object], system: Rational, laws: Laws) -> Kind:
    """An orbit in discrete time, exactly: ``sum d_i sigma[t+i] = sum n_i u[t+i]`` and ``u = -phi(sigma)``.

    The equation is that of the coprime ``n`` and ``d``, whose states follow from ``u`` and ``sigma``; hidden modes do
    not disturb it.

    Raises
    ------
    NotShown
        It is no orbit of the loop, it rests at 0, or the law is not in the class.
    """
    found = record(proof, "method", "points", "left", "right", "u", "sigma")
    require(system.discrete, "exact orbits are for discrete time")
    law = _law(found, laws)
    u, sigma = numbers(found["u"]), numbers(found["sigma"])
    period = len(u)
    require(0 < period == len(sigma) <= LONGEST, "u and sigma have no common period")
    require(all(-law.exact(s) == value for s, value in zip(sigma, u, strict=True)), "u is not -phi(sigma)")
    n, d = system.polynomials
    shared = n.gcd(d) if n.degree() >= 0 else d
    top, bottom = ([to_fraction(c) for c in (side // shared).coeffs()] for side in (n, d))
    for t in range(period):
        left = sum((c * sigma[(t + i) % period] for i, c in enumerate(bottom)), Fraction(0))
        right = sum((c * u[(t + i) % period] for i, c in enumerate(top)), Fraction(0))
        require(left == right, f"the difference equation fails at sample {t}")
    if any(s != sigma[0] for s in sigma) or any(value != u[0] for value in u):
        return "no rest"
    require(sigma[0] != 0 or u[0] != 0, "the orbit rests at 0")
    return "equilibria"


def require_flow_orbit(proof: Mapping[str, object], system: Rational, laws: Laws) -> None:
    """Check that a periodic orbit in continuous time is proved to exist near the approximate one.

    Raises
    ------
    NotShown
        It is not proved, or the law is not in the class.
    """
    found = record(
        proof,
        *("method", "points", "left", "right", "pieces", "durations", "state", "half", "inverse", "radius", "bits"),
    )
    require(not system.discrete, "flows are for continuous time")
    count(found["bits"], least=1)
    number(found["radius"])
    for row in listed(found["inverse"]):
        numbers(row)
    orbit = Itinerary(
        pieces=tuple(count(piece) for piece in listed(found["pieces"])),
        durations=tuple(numbers(found["durations"])),
        state=tuple(numbers(found["state"])),
        half=flag(found["half"]),
    )
    order = system.realisation.order
    require(len(orbit.state) == order > 0 and len(orbit.durations) == len(orbit.pieces) > 1, "the orbit has gaps")
    require(all(duration > 0 for duration in orbit.durations), "a duration is not positive")
    loop = PiecewiseLoop.of(system.realisation, _law(found, laws))
    if not proved(loop, orbit):
        better = refined(loop, orbit)
        require(better is not None and proved(loop, better), "no periodic orbit is proved to exist")


def _law(found: Mapping[str, object], laws: Laws) -> Graph:
    law = graph(found["points"], found["left"], found["right"])
    require(laws.has(law), "the law of the motion is not in the class")
    return law
