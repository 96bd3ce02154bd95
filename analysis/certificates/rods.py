"""Certificates for the rod and its scheme by their structure: energy, Popov, circle, refutation of ``k < 0``."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from analysis.certificates.systems import laws_of, system_of, text
from analysis.criteria.result import CriterionResult
from lure.law_class import LawClass
from lure.rod import Rod
from lure.sector import Sector
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

EASE = Fraction(5, 4)
STRUCTURE = {"method": "structure"}


def energy_theorem_draft(block: UpwindScheme | RodBlock) -> dict[str, Any]:
    """The energy theorem in the sector ``[0, inf]``, with the rod's own law as a member where it is piecewise linear.

    Parameters
    ----------
    block : UpwindScheme or RodBlock
        The scheme, or the rod itself.
    """
    draft = _draft(block, "rod-energy", {}, Sector(0, math.inf), varying=False)
    rod = block.rod.exact
    if rod["exponent"] == 1:
        kink = {"points": [["0", "0"]], "left": "0", "right": text(1 / rod["compliance"])}
        draft["law"] = {"kind": "piecewise-linear", **kink}
    return draft


def inequality_draft(block: UpwindScheme | RodBlock, result: CriterionResult) -> dict[str, Any]:
    """Popov's inequality or the circle criterion in the sector of a result, with a multiplier of closed form.

    Any ``theta >= L |k^2 - Z^2|/(k A E)`` serves every sector; it need not be that of the result.

    Parameters
    ----------
    block : UpwindScheme or RodBlock
        The scheme, or the rod itself, about which the inequality alone proves nothing.
    result : CriterionResult
        A result for ``k > 0``.
    """
    multiplier = {"theta": text(EASE * popov_theta(block.rod))} if result.name == "popov" else {}
    return _draft(block, f"rod-{result.name}", multiplier, result.sector, varying=result.name == "circle")


def negative_damping_draft(block: UpwindScheme | RodBlock, sector: Sector) -> dict[str, Any]:
    """The refutation of a rod with ``k < 0`` in a sector.

    Parameters
    ----------
    block : UpwindScheme or RodBlock
        The scheme, or the rod itself.
    sector : Sector
        The sector.
    """
    return {**_draft(block, "counterexample", {}, sector, varying=False), "verdict": "REFUTED"}


def popov_theta(rod: Rod) -> Fraction:
    """``4 |a| T/(1 - a^2) = L |k^2 - Z^2|/(k A E)`` [s], the travel time ``T`` at least in proportion; never 0.

    Parameters
    ----------
    rod : Rod
        A rod with ``damping > 0``.
    """
    E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
    return L * abs(k * k - A * A * rho * E) / (k * A * E) or L * A * rho / k


def _draft(
    block: UpwindScheme | RodBlock, theorem: str, multiplier: dict[str, str], sector: Sector, *, varying: bool
) -> dict[str, Any]:
    laws = laws_of(LawClass(sector=sector, time_varying=varying), unbounded=True)
    return {
        "verdict": "PROVED",
        "numbers": "decimals as written",
        "system": system_of(block),
        "laws": laws,
        "theorem": theorem,
        "multiplier": multiplier,
        "proof": STRUCTURE,
    }
