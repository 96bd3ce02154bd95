r"""The rod: inequalities proved once for all parameters, evaluated in exact arithmetic.

With ``a = (k - Z)/(k + Z)`` and the travel time ``T``, ``1/k_s + Re[(1 + i w theta) H] > 0`` follows for every number
of cells from ``theta (1 - a^2)/T >= 4 |a|``, that is ``theta >= L |k^2 - Z^2|/(k A E)``; the circle criterion reaches
``(1 - |a|)^2/(4 |a| d T) = (E/L) min(k, Z)^2/|k^2 - Z^2|``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channels import read_classes
from lure.analysis.certificates.second.classes import Nonlinearities, at_least, at_most
from lure.analysis.certificates.second.reading import (
    Document,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    tick,
)
from lure.analysis.certificates.second.systems import RodData

LARGEST_SCHEME = 2_000_000
MOST_RODS = 8


def proved(document: Document, rod: RodData, nonlinearities: Nonlinearities) -> str:
    """The sentence that is proved about the rod or its scheme.

    Raises
    ------
    NotShown
        A hypothesis fails.
    """
    require(record(document.proof, "method")["method"] == "structure", "the rod is proved by its structure")
    require(rod.k > 0, "the dashpot must be positive")
    require(at_least(nonlinearities.lower, Fraction(0)), "the sector must start at 0")
    theorem = document.theorem
    require(not nonlinearities.rough, "the rod is proved for locally Lipschitz nonlinearities")
    if theorem == "rod-energy":
        record(document.multiplier)
        require(not nonlinearities.time_varying, "the energy theorem needs nonlinearities fixed in time")
        if rod.cells is not None:
            _require_dissipation(rod.cells)
        return claims.AT_REST
    defect = abs(rod.k**2 - rod.squared_impedance)
    if theorem == "rod-popov":
        require(not nonlinearities.time_varying, "Popov's criterion needs nonlinearities fixed in time")
        theta = number(record(document.multiplier, "theta")["theta"])
        least = rod.length * defect / (rod.k * rod.area * rod.E)
        if nonlinearities.upper == "inf":  # strictly; the hidden modes for k = Z do no harm, by the energy theorem
            require(theta > least, "theta is too small for nonlinearities without upper bound")
        require(theta >= least, "theta is too small")
        return claims.EQUILIBRIA if rod.cells is not None else claims.AT_REST
    require(theorem == "rod-circle", "the theorem is unknown for the rod")
    record(document.multiplier)
    if defect > 0:
        limit = rod.E / rod.length * min(rod.k**2, rod.squared_impedance) / defect
        require(
            isinstance(nonlinearities.upper, Fraction) and nonlinearities.upper < limit,
            "the sector exceeds what the circle reaches",
        )
    require(nonlinearities.upper != "inf", "the circle criterion needs an upper bound")
    if rod.cells is None:  # square integrable pressures by Parseval's formula, whatever the number of states
        return claims.SQUARE_INTEGRABLE if nonlinearities.time_varying else claims.AT_REST
    return claims.BOUNDED if nonlinearities.time_varying else claims.EQUILIBRIA


FAMILIES = {"rod-family": "rod", "rod-scheme-family": "rod-scheme"}


def within_bounds(document: Document) -> list[Document]:
    """The documents of single rods that stand for those whose parameters lie within bounds.

    Of a proof those of all corners: each of ``L |k/(A E) - rho A/k|``, ``L (k^2/(A^2 rho E^2) - 1/E)`` and ``L (rho
    A^2/k^2 - 1/E)``, where it is positive, is monotone in each parameter, and so the larger of the last two is largest
    at an end of each.  Of a refutation that of the rod it names.

    Raises
    ------
    NotShown
        The bounds are none, or the rod is outside of them.
    """
    kind = str(document.system["kind"])
    found = record(document.system, "kind", "parameters", *(("cells",) if kind == "rod-scheme-family" else ()))
    names, ends = list[str](), list[tuple[Fraction, Fraction]]()
    for entry in listed(found["parameters"]):
        name, low, high = listed(entry)
        names.append(str(name))
        ends.append((number(low), number(high)))
    require(names == ["E", "rho", "L", "A", "k"], "the parameters are not those of a rod")
    require(all(low <= high for low, high in ends), "a parameter has no interval")
    require(all(low > 0 for low, _ in ends[:4]), "E, rho, L and A of the rods must be positive")
    more = {"cells": found["cells"]} if "cells" in found else {}

    def rod(point: Sequence[Fraction]) -> dict[str, object]:
        """The rod with these parameters."""
        return {"kind": FAMILIES[kind], **dict(zip(names, map(str, point), strict=True)), **more}

    if document.verdict == "PROVED":
        return [replace(document, system=rod(corner)) for corner in dict.fromkeys(product(*ends))]
    proof = record(document.proof, "method", "at", "proof")
    require(proof["method"] == "member", "a refutation names one rod")
    point = numbers(proof["at"])
    require(len(point) == len(ends), "a rod has five parameters")
    require(all(low <= v <= high for v, (low, high) in zip(point, ends, strict=True)), "a parameter is out of bounds")
    return [replace(document, system=rod(point), proof=mapping(proof["proof"]))]


def rods(document: Document) -> str:
    """The sentence that is proved about rods with several contacts: energy is lost at each dashpot, or by the circle.

    Virtual work leaves no pressure at rest where every pressure has the sign of ``sigma``, see the first checker's
    reference; here the classes are looked at by their least gain, and each dashpot by its sign.

    Raises
    ------
    NotShown
        A hypothesis fails, or it is another theorem.
    """
    circle = document.theorem == "rods-circle"
    require(document.verdict == "PROVED" and (circle or document.theorem == "rods-energy"), "no theorem about rods")
    require(record(document.proof, "method")["method"] == "structure", "rods are proved by their structure")
    record(document.multiplier)
    require(document.nonlinearity is None, "no nonlinearity is given beside several classes")
    found = record(document.system, "kind", "arrangement", "rods", "obstacle")
    bars = [record(mapping(bar), "E", "rho", "L", "A", "k") for bar in listed(found["rods"])]
    require(all(number(value) > 0 for bar in bars for value in bar.values()), "a parameter of a rod is not positive")
    plate, arrangement = found["obstacle"], found["arrangement"]
    require(plate is None or (arrangement == "one-obstacle" and number(plate) > 0), "the obstacle cannot move so")
    if arrangement == "both-ends":
        require(len(bars) == 1, "one rod has two ends")
        m = 2
    elif arrangement == "across-gap":
        require(len(bars) == 2, "two rods meet")
        m = 1
    else:
        require(arrangement == "one-obstacle" and 0 < len(bars) <= MOST_RODS, "the arrangement is unknown")
        m = len(bars)
    reach = _reach(arrangement, bars) if circle else []
    for i, one in enumerate(read_classes(document, m)[0]):
        low, high = one.ends
        require(low is not None and low >= 0, "a pressure may have the sign against its contact")
        require(not one.rough and (circle or not one.time_varying), "a pressure jumps or depends on time")
        if circle:
            most = reach[i]
            require(high is not None, "a pressure has no upper bound")
            require(most is None or (high is not None and high < most), "a pressure exceeds what is reached")
    return claims.SQUARE_INTEGRABLE if circle else claims.PRESSURELESS


def _reach(arrangement: object, bars: Sequence[Mapping[str, object]]) -> list[Fraction | None]:
    """Below which slope of each contact the circle criterion covers rods; None where any finite one is covered.

    With ``q`` the larger of ``(k/Z)^2`` and its inverse and the compliance ``L/E`` of a rod: ``(E/L)/(q - 1)`` at one
    end, at both ``(E/L)/max(2, q)`` for ``k >= Z`` and ``(E/L)/(2 q)`` below; across a gap the compliances add up.
    """
    ends: list[tuple[Fraction, Fraction]] = []
    for bar in bars:
        E, rho, L, A, k = (number(bar[key]) for key in ("E", "rho", "L", "A", "k"))
        share = k**2 / (A**2 * rho * E)
        q = max(share, 1 / share)
        excess = q - 1 if arrangement != "both-ends" else max(Fraction(2), q) if share >= 1 else 2 * q
        ends.append((A, excess * L / E))
    if arrangement == "both-ends":
        softness = [ends[0][1]] * 2
    elif arrangement == "across-gap":
        smaller = min(ends[0][0], ends[1][0])
        softness = [smaller * ends[0][1] / ends[0][0] + smaller * ends[1][1] / ends[1][0]]
    else:
        softness = [one for _, one in ends]
    return [None if one == 0 else 1 / one for one in softness]


def refuted(document: Document, rod: RodData, nonlinearities: Nonlinearities) -> str:
    """The sentence that is refuted: a dashpot that drives, ``k < 0``.

    For ``-Z < k < 0`` the mode ``s ((-a)^(1/2N) - 1) > 0`` (rod: ``ln(-a)/2T``) grows with ``phi = 0``.  For ``k < -Z``
    the residue ``A/k`` is negative and ``H`` has no positive pole, so that ``1 + g H`` has a positive root for every
    gain ``g > 0``.

    Raises
    ------
    NotShown
        ``k >= 0`` or ``k = -Z``, or no such gain is in the class.
    """
    require(record(document.proof, "method")["method"] == "structure", "the rod is refuted by its structure")
    require(rod.k < 0 and rod.k**2 != rod.squared_impedance, "the dashpot is not negative, or minus the impedance")
    if rod.k**2 < rod.squared_impedance:
        require(nonlinearities.has_gain(Fraction(0)), "phi = 0 is not in the class")
        return claims.NO_REST
    gain = Fraction(1)
    uppers = [nonlinearities.upper] if nonlinearities.slope is None else [nonlinearities.upper, nonlinearities.slope[1]]
    for upper in uppers:
        if isinstance(upper, Fraction):
            gain = min(gain, upper)
    lowers = [nonlinearities.lower] if nonlinearities.slope is None else [nonlinearities.lower, nonlinearities.slope[0]]
    for lower in lowers:
        if isinstance(lower, Fraction):
            gain = max(gain, lower)
    require(gain > 0 and nonlinearities.has_gain(gain), "no positive gain is in the class")
    require(all(at_most(gain, upper) for upper in uppers), "no positive gain is in the class")
    return claims.NO_REST


def _require_dissipation(cells: int) -> None:
    r"""Check row by row that ``(1/2s) sum y_i^2 + 2 d P(z)`` falls at the rate ``D``.

    .. math:: D = \tfrac12 \sum_i (prev_i - y_i)^2 + \tfrac{1 - a^2}{2} y_{2N}^2, \qquad y_i'/s = prev_i - y_i,

    with ``prev_1 = -a y_2N``, ``prev_{N+1} = y_N - 2 d p``, else ``y_{i-1}``, and ``z' = y_N - d p``.  Both sides are
    quadratic forms in ``(y, p)`` whose coefficients are polynomials in ``a`` and ``d``, of degree at most 2 and with
    integers below 100, so that equality at ``a = 10^3``, ``d = 10^9`` is equality.  ``D`` is definite for
    ``|a| < 1``, ``d > 0``: the jumps and ``y_2N`` determine ``y`` and ``p``.
    """
    require(cells <= LARGEST_SCHEME, "the scheme is too large")
    a, d, last, p = 10**3, 10**9, 2 * cells, 0
    twice: dict[tuple[int, int], int] = defaultdict(int)  # 2 (V' + D), as coefficients of products
    for i in range(1, last + 1):
        tick()
        before = {last: -a} if i == 1 else {i - 1: 1, p: -2 * d} if i == cells + 1 else {i - 1: 1}
        jump = defaultdict(int, before)
        jump[i] -= 1
        for j, u in jump.items():
            twice[min(i, j), max(i, j)] += 2 * u  # 2 y_i (prev_i - y_i)
            for m, v in jump.items():
                twice[min(j, m), max(j, m)] += u * v
    twice[last, last] += 1 - a * a
    twice[p, cells] += 4 * d  # 2 . 2 d p z'
    twice[p, p] -= 4 * d * d
    require(not any(twice.values()), "the dissipation identity does not hold")
