"""Certificates for the rod and its scheme by their structure, and the energy of the scheme as a matrix P."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.riccati import Rounded
from lure.analysis.certificates.systems import class_entry, system_of, text
from lure.analysis.rod.energy import energy_theta as least_theta
from lure.analysis.theorems.table import Upper
from lure.analysis.verdict import CriterionResult
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.rod.discretisation import UpwindScheme
from lure.rod.family import RodFamily
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant

# Certificates for the rod and its scheme by their structure: energy, Popov, circle, refutation of ``k < 0``.

EASE = Fraction(5, 4)
SLACK = Fraction(1, 10**12)
STRUCTURE = {"method": "structure"}


def energy_theorem_draft(block: UpwindScheme | RodPlant | RodFamily) -> dict[str, Any]:
    """The energy theorem in the sector ``[0, inf]``, the contact law a member where it is one and piecewise linear."""
    nonlinearities = class_entry(NonlinearityClass(sector=Sector(0, math.inf)), unbounded=True)
    draft = draft_of(block, "rod-energy", {}, nonlinearities)
    rod, varied = block.rod.exact, block.intervals if isinstance(block, RodFamily) else {}
    if rod["exponent"] == 1 and "compliance" not in varied:
        kink = {"points": [["0", "0"]], "left": "0", "right": text(1 / rod["compliance"])}
        draft["law"] = {"kind": "piecewise-linear", **kink}
    return draft


def inequality_draft(block: UpwindScheme | RodPlant, result: CriterionResult) -> dict[str, Any]:
    """Popov's inequality or the circle criterion in the sector of a result, with a multiplier of closed form.

    Any ``theta >= L |k^2 - Z^2|/(k A E)`` serves every sector; it need not be that of the result.

    ``result``: a result for ``k > 0``.
    """
    nonlinearity_class = NonlinearityClass(sector=result.sector, time_varying=result.criterion == "circle")
    multiplier = _multiplier(block, popov=result.criterion == "popov")
    return draft_of(block, f"rod-{result.criterion}", multiplier, class_entry(nonlinearity_class, unbounded=True))


def criterion_drafts(
    block: UpwindScheme | RodPlant, answer: CriterionResult, upper: Upper | None
) -> Iterator[tuple[Upper, dict[str, Any]]]:
    """Popov's or the circle criterion for the class of an answer; of the latter for the largest class there is, too.

    ``answer``: PROVED, of one of the two; ``upper``: upper end of the class, None for that of the answer.
    """
    popov, own = bool(answer.theta), answer.nonlinearity_class.sector.upper
    whole: Upper = Fraction(own) if own != math.inf else "inf" if popov else "finite"
    bound = None if popov else circle_bound(block.rod)
    ends = [whole if upper is None else upper] + ([] if bound is None else [(1 - SLACK) * bound])
    for end in ends:
        nonlinearities = class_entry(answer.nonlinearity_class, unbounded=False)
        nonlinearities["sector"][1] = end if isinstance(end, str) else text(end)
        yield end, draft_of(block, f"rod-{answer.criterion}", _multiplier(block, popov=popov), nonlinearities)


def negative_damping_draft(block: UpwindScheme | RodPlant, sector: Sector) -> dict[str, Any]:
    """The refutation of a rod with ``k < 0`` in a sector."""
    nonlinearities = class_entry(NonlinearityClass(sector=sector), unbounded=True)
    return {**draft_of(block, "counterexample", {}, nonlinearities), "verdict": "REFUTED"}


def popov_theta(rod: Rod) -> Fraction:
    """A multiplier [s] that serves every sector ``[0, k]``: 5/4 of ``4 |a| T/(1 - a^2) = L |k^2 - Z^2|/(k A E)``.

    For ``k = Z``, where any multiplier does, 5/4 of the travel time ``T``.

    ``rod``: a rod with ``damping > 0``.

    Raises
    ------
    AssumptionError
        The dashpot does not damp.
    """
    E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
    if k <= 0:
        raise AssumptionError(
            f"rod.damping is {float(k):g}; Popov's criterion needs a positive one", code=Reason.UNDAMPED
        )
    return EASE * (L * abs(k * k - A * A * rho * E) / (k * A * E) or L * A * rho / k)


def circle_bound(rod: Rod) -> Fraction | None:
    r"""``(E/L) min(k, Z)^2/|k^2 - Z^2|`` [Pa/m], below which the circle criterion covers ``[0, K]`` for every scheme.

    ``rod``: a rod with ``damping > 0``.

    Returns
    -------
    Fraction or None
        None for ``k = Z``, where there is no bound.
    """
    E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
    squares = k * k, A * A * rho * E
    return E / L * min(squares) / abs(squares[0] - squares[1]) if squares[0] != squares[1] else None


def _multiplier(block: UpwindScheme | RodPlant, *, popov: bool) -> dict[str, str]:
    """Of the circle criterion there is none."""
    return {"theta": text(popov_theta(block.rod))} if popov else {}


def draft_of(
    block: UpwindScheme | RodPlant | RodFamily,
    theorem: str,
    multiplier: dict[str, str],
    nonlinearities: dict[str, Any],
) -> dict[str, Any]:
    """The draft of a certificate that rests on the structure of a rod, of rods or of a scheme.

    ``multiplier``: the numbers of the theorem; ``nonlinearities``: the class, as certificates have it.
    """
    return {
        "verdict": "PROVED",
        "numbers": "decimals as written",
        "system": system_of(block),
        "laws": nonlinearities,
        "theorem": theorem,
        "multiplier": multiplier,
        "proof": STRUCTURE,
    }


SCHEME_ENERGY_EASE = 1.25
BITS = 60
PLACES = 4


def energy_theta(scheme: UpwindScheme) -> Fraction:
    r"""A ``theta`` [s] for which the energy of the scheme proves Popov's inequality on ``[0, inf]``.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme of a rod with ``k > 0``.

    Returns
    -------
    Fraction
        About a quarter above the least, a multiple of ``2 s d`` by a number of four binary places.

    Raises
    ------
    AssumptionError
        ``k <= 0``: the energy does not fall.

    Notes
    -----
    With the dissipation ``D`` of ``notebooks/notes/0005-energy-theorem.md``, ``V' <= -2 sigma phi`` as soon as
    ``(theta/d) D + 2 (w'y) phi >= 0`` for all ``(y, phi)``.  The ``2N`` jumps and the last wave are coordinates ``eta``
    in which ``D = |eta|^2/2``; with ``w'y = alpha.eta`` and ``phi = beta.eta`` that is
    ``theta >= 2 d (|alpha||beta| - alpha.beta)``.  It grows like ``sqrt(N)``, while the frequency inequality itself
    needs a bounded ``theta``.

    Examples
    --------
    >>> from lure.rod import builtin_system, upwind
    >>> energy_theta(upwind(builtin_system("paper-rod").rod, 10))
    Fraction(220, 1)
    """
    if not scheme.rod.damping > 0:
        raise AssumptionError(
            f"rod.damping is {scheme.rod.damping:g}, and the energy falls only for a positive one; give one",
            code=Reason.UNDAMPED,
        )
    size = Fraction(SCHEME_ENERGY_EASE * least_theta(scheme)) / _unit(scheme)
    step = Fraction(2) ** (math.floor(math.log2(size)) + 1 - PLACES)
    return _unit(scheme) * step * math.ceil(size / step)


def energy_matrix(scheme: UpwindScheme, theta: Fraction) -> Rounded | None:
    """``P = theta/(2 s d)`` times 1, to 60 bits; None where ``theta`` is not large enough.

    ``theta``: Popov's multiplier.
    """
    if not (scheme.rod.damping > 0 and theta > least_theta(scheme)):
        return None
    size = theta / _unit(scheme)
    exponent = max(0, BITS + math.floor(1 / size).bit_length() - math.floor(size).bit_length())
    whole = round(size * 2**exponent)
    while exponent and whole % 2 == 0:
        whole, exponent = whole // 2, exponent - 1
    return Rounded(rows=[[0] * i + [whole] for i in range(2 * scheme.cells)], exponent=exponent)


def _unit(scheme: UpwindScheme) -> Fraction:
    """``2 s d = 2 N/(rho L)``, whether or not the impedance is rational."""
    return 2 * scheme.cells / (scheme.rod.exact["density"] * scheme.rod.exact["length"])
