"""What every criterion asks of a block before it looks at a frequency: one sentence for each refusal."""

from __future__ import annotations

import math
from fractions import Fraction

from analysis.criteria.hurwitz import gain_intervals
from analysis.plant import Plant
from analysis.polynomial import is_hurwitz
from lure.errors import AssumptionError, InputError
from lure.rational import RationalBlock
from lure.sector import SlopeBounds


def check_plant(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Plant:
    r"""The plant of the loop shifted by the gain ``lower``, admitted as stable or critical.

    With ``phi = lower sigma + phi'`` the loop ``mu = -phi(sigma)``, ``sigma = H mu`` is the loop of ``phi'`` and
    ``H / (1 + lower H)``: the sector ``[lower, k]`` turns into ``[0, k - lower]``.  The shifted block must have all its
    poles strictly inside, hidden modes too (the principal case), or one simple pole at ``s = 0`` (``z = 1``) with a
    positive residue besides (the critical case).

    Parameters
    ----------
    block : RationalBlock
        The block as given.
    lower : Fraction
        Lower end of the sector or slope bounds, of either sign.

    Returns
    -------
    Plant
        The shifted plant; its ``case`` is ``stable`` or ``critical``.

    Raises
    ------
    InputError
        ``block`` is not a RationalBlock, or ``1 + lower H(inf) = 0``: the loop has no solution.
    AssumptionError
        A hidden mode is not strictly stable; the pole at 0 is multiple or has a residue that is not positive; another
        pole lies on the axis or right of it (circle: on the circle or outside).

    Examples
    --------
    >>> check_plant(RationalBlock([1], [1, 3, 2, 0])).case
    'critical'
    """
    if not isinstance(block, RationalBlock):
        raise InputError(f"block is a {type(block).__name__}; give a RationalBlock")
    require_solution(block, lower)
    plant = Plant.of(block).shifted(lower)
    _check_hidden(plant)
    if plant.case != "stable":
        _check_zero(plant, lower)
    if plant.case == "unstable":
        raise AssumptionError(_unstable(plant, lower))
    return plant


def require_solution(block: RationalBlock, lower: Fraction) -> None:
    """Refuse a lower gain with which the loop has no solution.

    Raises
    ------
    InputError
        ``1 + lower H(inf) = 0``.
    """
    if 1 + lower * block.feedthrough == 0:
        raise InputError(
            f"the loop is not well posed: 1 + k H(inf) = 0 at the lower gain k = {lower}; choose another lower gain"
        )


def well_posed(block: RationalBlock, upper: Fraction | float, *, lower: Fraction = Fraction(0)) -> bool:
    """Whether ``1 + kappa H(inf)`` keeps its sign, without zero, for every ``kappa`` in ``[lower, upper]``.

    For ``lower = 0`` that is ``1 + kappa D > 0``; for ``upper = inf`` every finite ``kappa`` is meant.  It makes the
    loop equation solvable for every continuous ``phi`` in the sector, uniquely for slope bounds.

    Parameters
    ----------
    block : RationalBlock
        The block.
    upper : Fraction or float
        Upper gain, ``inf`` allowed.
    lower : Fraction
        Lower gain.
    """
    direct = block.feedthrough
    start = 1 + lower * direct
    if upper == math.inf:
        return start != 0 and direct * start >= 0
    return start * (1 + Fraction(upper) * direct) > 0


def require_well_posed(block: RationalBlock, upper: Fraction | float, *, lower: Fraction = Fraction(0)) -> None:
    """Refuse a sector in which the loop equation need not have a solution.

    Raises
    ------
    InputError
        ``1 + kappa H(inf)`` vanishes for some ``kappa`` in ``[lower, upper]``, or the two ends coincide.
    """
    if lower == upper:
        raise InputError(
            f"the sector [{float(lower):g}, {float(upper):g}] holds one straight line; a linear gain belongs into the "
            "block"
        )
    if not well_posed(block, upper, lower=lower):
        raise InputError(
            f"the loop is not well posed: 1 + k H(inf) = 0 at k = {float(-1 / block.feedthrough):.6g}, inside the "
            f"sector [{float(lower):g}, {float(upper):g}]; choose a sector without that gain"
        )


def finite_bounds(bounds: SlopeBounds, criterion: str) -> tuple[Fraction, Fraction]:
    """Both slope bounds as exact numbers.

    Raises
    ------
    AssumptionError
        A bound is infinite.
    """
    if math.inf in (-bounds.lower, bounds.upper):
        raise AssumptionError(f"{criterion} needs finite slope bounds, and they are {bounds}; give numbers")
    return Fraction(bounds.lower), Fraction(bounds.upper)


def _check_hidden(plant: Plant) -> None:
    at_infinity = plant.n.degree() < plant.degree and plant.d.degree() < plant.degree and plant.discrete
    if not at_infinity and is_hurwitz(plant.hidden):
        return
    zero, region = ("z = 1", "inside the unit circle") if plant.discrete else ("s = 0", "in the left half-plane")
    at_zero = plant.hidden[0] == 0
    where = f"at {zero}" if at_zero else "at z = -1" if at_infinity else f"not strictly {region}"
    raise AssumptionError(
        f"a mode {where} is not seen by input or output (it cancels in H): no feedback moves it and no criterion on H "
        "covers it; leave it out only if the system does not have it"
    )


def _check_zero(plant: Plant, lower: Fraction) -> None:
    zero = "z = 1" if plant.discrete else "s = 0"
    shift = f" at the lower gain {float(lower):g}" if lower else ""
    multiplicity = 0
    while plant.d[multiplicity] == 0 and multiplicity <= plant.d.degree():
        multiplicity += 1
    if multiplicity > 1:
        raise AssumptionError(
            f"the pole at {zero}{shift} has multiplicity {multiplicity}; the critical case needs a simple one: for "
            "(s + 1)/s^2 every linear gain is stable, yet with phi = sigma exp(-|sigma|) motions escape to infinity; "
            "give a positive lower gain"
        )
    if multiplicity == 1 and not plant.residue > 0:
        raise AssumptionError(
            f"the residue at the pole {zero}{shift} is {float(plant.residue):.6g}; it must be positive: with this sign "
            "small positive gains are unstable; check the sign of the feedback"
        )


def _unstable(plant: Plant, lower: Fraction) -> str:
    poles = plant.poles
    region = (
        ("on the unit circle", "outside the unit circle")
        if plant.discrete
        else ("on the imaginary axis", "in the right half-plane")
    )
    on_axis = poles.axis - (1 if plant.d.degree() >= 0 and plant.d[0] == 0 else 0)
    parts = [
        f"{count} {'pole' if count == 1 else 'poles'} {place}"
        for count, place in ((on_axis, region[0]), (poles.right, region[1]))
        if count
    ]
    shift = f"with the lower gain {float(lower):g} the loop" if lower else "the block"
    stable = gain_intervals(plant.block)
    advice = (
        "give a lower gain in " + " or ".join(str(interval) for interval in stable)
        if stable
        else "no linear gain stabilises it"
    )
    return f"{shift} has {' and '.join(parts)}; {advice}"
