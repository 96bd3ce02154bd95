"""The multipliers to try in a certificate for what a criterion proved: those of its answer, and some beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, Literal

from analysis.answer import Answer
from analysis.criteria.popov import popov_criterion
from analysis.evidence import Verdict
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.rational import RationalBlock
from lure.rod import Rod
from lure.sector import Sector, SlopeBounds
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

Upper = Fraction | Literal["finite", "inf"]
Block = RationalBlock | DelayBlock | UpwindScheme | RodBlock
Multiplier = dict[str, Any]

EASE = Fraction(5, 4)
_NEARBY = (Fraction(1), Fraction(9, 8), Fraction(2), Fraction(7, 8), Fraction(1, 2))
_SHRINKING = tuple(1 - Fraction(1, 10**digits) for digits in (24, 18, 15, 12, 9, 6, 4, 3, 2, 1))


def multipliers(block: Block, answer: Answer, upper: Upper) -> Iterator[Multiplier]:
    """The multipliers to try, the likeliest first.

    Parameters
    ----------
    block : RationalBlock, DelayBlock, UpwindScheme or RodBlock
        The block of the answer.
    answer : Answer
        What was proved.
    upper : Fraction or {"finite", "inf"}
        Upper end of the class to certify.

    Yields
    ------
    dict
        ``multiplier`` of a certificate with the theorem of that name.

    Notes
    -----
    Where ``theta`` (``alpha``, ``tau``) grows without bound with ``k``, no one multiplier serves every finite ``k``,
    and for ``"finite"`` there is nothing to try; for one number the criterion is asked again.
    """
    if isinstance(block, UpwindScheme | RodBlock):
        yield {"theta": str(rod_theta(block.rod))} if answer.criterion == "popov" else {}
        return
    yield from _own(answer, upper)
    if isinstance(upper, Fraction) and isinstance(block, RationalBlock) and _boundless(answer):
        again = _asked_again(block, answer, upper)
        if again is not None and again.verdict is Verdict.PROVED:
            yield from _own(again, upper)


def rod_theta(rod: Rod) -> Fraction:
    r"""A multiplier that serves every sector ``[0, k]`` of the rod's scheme: 5/4 of ``L |k^2 - Z^2|/(k A E)``.

    For ``k = Z`` any multiplier does, and the travel time is taken, to three digits.

    Parameters
    ----------
    rod : Rod
        A rod with ``damping > 0``.

    Raises
    ------
    AssumptionError
        The dashpot does not damp.
    """
    E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
    if k <= 0:
        raise AssumptionError(f"rod.damping is {float(k):g}; Popov's criterion needs a positive one")
    return EASE * L * abs(k * k - A * A * rho * E) / (k * A * E) or Fraction(f"{rod.travel_time:.3g}")


def rod_circle_bound(rod: Rod) -> Fraction | None:
    r"""``(E/L) min(k, Z)^2/|k^2 - Z^2|`` [Pa/m], below which the circle criterion covers ``[0, K]`` for every scheme.

    Parameters
    ----------
    rod : Rod
        A rod with ``damping > 0``.

    Returns
    -------
    Fraction or None
        None for ``k = Z``, where there is no bound.
    """
    E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
    squares = k * k, A * A * rho * E
    return E / L * min(squares) / abs(squares[0] - squares[1]) if squares[0] != squares[1] else None


def _own(answer: Answer, upper: Upper) -> Iterator[Multiplier]:
    """The multiplier in the parameters, and its neighbours."""
    given = answer.parameters
    if answer.criterion == "circle":
        lower = answer.law_class.sector.lower
        yield from ({"mirrored": True},) if lower == -math.inf else ({}, {"mirrored": True})
    elif answer.criterion == "hurwitz":
        yield {}
    elif answer.criterion == "popov":
        yield from ({"theta": theta} for theta in _scaled(given, "theta"))
    elif answer.criterion == "off-axis-circle":
        yield from ({"alpha": alpha} for alpha in _scaled(given, "alpha"))
    elif answer.criterion in ("tsypkin", "jury-lee"):
        yield from ({"q": q} for q in _scaled(given, "q"))
    elif answer.criterion == "park":
        yield from _parks(given)
    elif "taps" in given:
        taps = _mapping(given["taps"])
        yield {"taps": [[int(i), str(h)] for i, h in taps.items()]}
    elif "kernels" in given:
        yield from _kernels(given, upper)


def _scaled(given: Mapping[str, object], name: str) -> Iterator[str]:
    """A finite number of the parameters and, should it fail, multiples of it."""
    value = str(given.get(name, "0"))
    if "inf" not in value:
        yield from dict.fromkeys(str(Fraction(value) * factor) for factor in _NEARBY)


def _parks(given: Mapping[str, object]) -> Iterator[Multiplier]:
    theta, tau = str(given.get("theta", "0")), str(given.get("tau", "0"))
    if "inf" not in theta + tau:
        yield {"theta": theta, "tau": tau}


def _kernels(given: Mapping[str, object], upper: Upper) -> Iterator[Multiplier]:
    """Kernels as they are; then with less mass, which can serve every finite ``k`` where a mass of 1 does not."""
    entries = [_mapping(entry) for entry in _list(given["kernels"])]
    theta = str(given["theta"])
    yield {"theta": theta, "kernels": entries}
    for factor in _SHRINKING if entries and (upper == "finite" or _mass(entries) == 1) else ():
        less = [{**entry, "coefficient": str(factor * Fraction(entry["coefficient"]))} for entry in entries]
        yield {"theta": theta, "kernels": less}


def _mass(entries: list[dict[str, Any]]) -> Fraction:
    return sum((abs(Fraction(entry["coefficient"])) for entry in entries), Fraction(0))


def _boundless(answer: Answer) -> bool:
    """Whether the answer is about every finite ``k``, so that its multiplier need not serve any one of them."""
    return answer.largest.low == math.inf


def _asked_again(block: RationalBlock, answer: Answer, upper: Fraction) -> Answer | None:
    """The same criterion, asked about one finite class."""
    lower = Fraction(answer.law_class.sector.lower)
    bounds = SlopeBounds(lower, upper)
    if answer.criterion == "popov":
        return popov_criterion(block, Sector(lower, upper))
    if answer.criterion == "park":
        from analysis.criteria.park import park_criterion

        return park_criterion(block, bounds)
    if answer.criterion == "off-axis-circle":
        from analysis.criteria.off_axis import off_axis_criterion

        return off_axis_criterion(block, bounds)
    if answer.criterion == "zames-falb" and block.dt is None:
        from analysis.criteria.zames_falb import zames_falb_criterion

        return zames_falb_criterion(block, bounds, odd=answer.law_class.odd)
    return None


def _mapping(value: object) -> dict[str, Any]:
    return dict(value) if isinstance(value, Mapping) else {}


def _list(value: object) -> list[object]:
    return list(value) if isinstance(value, list | tuple) else []
