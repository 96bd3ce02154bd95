"""What every criterion asks of a block before it looks at a frequency: one sentence for each refusal."""

from __future__ import annotations

import math
from fractions import Fraction

from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.inequality.plant import TransferPolynomials, closed_loop_poles
from lure.analysis.numerics.polynomial import is_hurwitz
from lure.classes import Sector
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# Encirclements of the Nyquist plot, counted from exact root counts and from no plot.


@described(frozen=True, kw_only=True, slots=True)
class Encirclements:
    """How often the Nyquist plot of ``H`` winds round ``-1/kappa``."""

    counterclockwise: int = quantity("``open_loop - closed_loop``; negative for clockwise turns")
    open_loop: int = quantity("Poles of ``H`` in the right half-plane (outside the circle), hidden modes too")
    closed_loop: int = quantity("Roots of ``d + kappa n`` there, hidden modes too")


def encirclements(block: RationalPlant, kappa: Fraction) -> Encirclements:
    r"""The number of encirclements of ``-1/kappa`` by the Nyquist plot of ``H``.

    By the principle of the argument for ``1 + kappa H = (d + kappa n)/d`` on the axis from ``-i inf`` to ``i inf``
    (the unit circle from ``-pi`` to ``pi``), closed on the right and indented to the right of poles on it, the plot
    encircles the point ``P_open - P_closed`` times counterclockwise.

    ``kappa``: a gain that is not zero.

    Raises
    ------
    InputError
        ``kappa`` is zero: the point lies at infinity.
    AssumptionError
        The plot runs through ``-1/kappa``, so that nothing can be counted.

    Examples
    --------
    >>> encirclements(RationalPlant([12], [1, 2, -3]), Fraction(1)).counterclockwise
    1
    """
    if kappa == 0:
        raise InputError("encirclements needs a gain kappa that is not zero: -1/kappa lies at infinity")
    plant = TransferPolynomials.of(block)
    closed = closed_loop_poles(plant, kappa)
    if closed.axis:
        raise AssumptionError(
            f"the Nyquist plot runs through -1/kappa for kappa = {kappa}: {closed.axis} closed-loop poles lie on the "
            "axis; choose another gain"
        )
    return Encirclements(
        counterclockwise=plant.poles.right - closed.right, open_loop=plant.poles.right, closed_loop=closed.right
    )


def region(sector: Sector) -> str:
    """Where the Nyquist plot of ``H`` has to stay for a sector ``[k1, k2]``, by the signs of its ends.

    ``sector``: ``k1 < k2``, either of them infinite.
    """
    k1, k2 = float(sector.lower), float(sector.upper)
    if k1 == 0 or k2 == 0:
        k = k2 if k1 == 0 else k1
        if abs(k) == math.inf:
            return f"{'right' if k > 0 else 'left'} of the imaginary axis"
        return f"{'right' if k > 0 else 'left'} of the line Re H = {-1 / k:.6g}"
    ends = sorted(-1 / k if abs(k) != math.inf else 0.0 for k in (k1, k2))
    place = "inside" if k1 < 0 < k2 else "outside"
    return f"{place} the disc with the diameter [{ends[0]:.6g}, {ends[1]:.6g}]"


def encirclement_condition(block: RationalPlant, sector: Sector, inside: Fraction) -> str:
    """The encirclement condition of the circle criterion for a sector, with the counts that were found.

    ``inside``: a gain of the sector, not zero and with no closed-loop pole on the axis.

    Notes
    -----
    A plot that does not touch the disc winds equally often round all of its points, and ``-1/inside`` is one of them.
    For ``k1 < 0 < k2`` the plot lies inside the disc and the condition is that ``H`` itself be stable.
    """
    count = encirclements(block, inside)
    where = "outside the unit circle" if block.dt is not None else "in the right half-plane"
    if sector.lower < 0 < sector.upper:
        return f"no pole of H {where}: checked by exact root counts, {count.open_loop}"
    return (
        f"counterclockwise encirclements by the Nyquist plot of H: {count.counterclockwise}, its poles {where}: "
        f"{count.open_loop}; equal if and only if the loop is stable for a gain of the sector: checked by exact root "
        f"counts at the gain {inside}, {count.closed_loop} closed-loop poles there"
    )


def check_plant(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> TransferPolynomials:
    r"""The plant of the loop shifted by the gain ``lower``, admitted as stable or critical.

    With ``phi = lower sigma + phi'`` the loop ``mu = -phi(sigma)``, ``sigma = H mu`` is the loop of ``phi'`` and
    ``H / (1 + lower H)``: the sector ``[lower, k]`` turns into ``[0, k - lower]``.  The shifted block must have all its
    poles strictly inside, hidden modes too (the principal case), or one simple pole at ``s = 0`` (``z = 1``) with a
    positive residue besides (the critical case).

    Parameters
    ----------
    block : RationalPlant
        The block as given.
    lower : Fraction
        Lower end of the sector or slope bounds, of either sign.

    Returns
    -------
    TransferPolynomials
        The shifted plant; its ``case`` is ``stable`` or ``critical``.

    Raises
    ------
    InputError
        ``block`` is not a RationalPlant, or ``1 + lower H(inf) = 0``: the loop has no solution.
    AssumptionError
        A hidden mode is not strictly stable; the pole at 0 is multiple or has a residue that is not positive; another
        pole lies on the axis or right of it (circle: on the circle or outside).

    Examples
    --------
    >>> check_plant(RationalPlant([1], [1, 3, 2, 0])).case
    'critical'
    """
    if not isinstance(block, RationalPlant):
        raise InputError(f"block is a {type(block).__name__}; give a RationalPlant")
    require_solution(block, lower)
    plant = TransferPolynomials.of(block).shifted(lower)
    _check_hidden(plant)
    if plant.case != "stable":
        _check_zero(plant, lower)
    if plant.case == "unstable":
        raise AssumptionError(_unstable(plant, lower), code=Reason.UNSTABLE)
    return plant


def admitted_plant(
    block: RationalPlant, lower: Fraction, criterion: str, *, discrete: bool = False, critical: bool = False
) -> TransferPolynomials:
    """The plant of :func:`check_plant`, for a criterion that is about one time domain.

    Parameters
    ----------
    block : RationalPlant
        The block as given.
    lower : Fraction
        Lower end of the class.
    criterion : str
        Who asks, for the messages.
    discrete, critical : bool
        Whether the criterion is for discrete time, and whether it covers the critical case.

    Raises
    ------
    InputError
        As :func:`check_plant`; the block is in continuous time and should not be.
    AssumptionError
        As :func:`check_plant`; the block is in discrete time, or has a pole at 0 (``z = 1``), and should not.
    """
    if isinstance(block, RationalPlant) and block.dt is not None and not discrete:
        raise AssumptionError(
            f"{criterion} is about continuous time, and the block has dt = {float(block.dt):g} s; ask for "
            "circle, tsypkin or zames-falb instead"
        )
    if isinstance(block, RationalPlant) and block.dt is None and discrete:
        raise InputError(f"{criterion} is for discrete time; RationalPlant.dt is None: give the sampling time")
    plant = check_plant(block, lower=lower)
    if plant.case == "stable" or critical:
        return plant
    raise AssumptionError(
        f"{criterion} needs every pole inside the unit circle; with the lower slope {float(lower):g} the loop "
        "has one at z = 1: give a larger lower slope, which shifts it inside",
        code=Reason.CRITICAL,
    )


def require_solution(block: RationalPlant, lower: Fraction) -> None:
    """Refuse a lower gain with which the loop has no solution.

    Raises
    ------
    InputError
        ``1 + lower H(inf) = 0``.
    """
    if 1 + lower * block.feedthrough == 0:
        raise InputError(
            f"the loop is not well posed: 1 + k H(inf) = 0 at the lower gain k = {lower}; choose another lower gain",
            code=Reason.ILL_POSED,
        )


def well_posed(block: RationalPlant, upper: Fraction | float, *, lower: Fraction = Fraction(0)) -> bool:
    """Whether ``1 + kappa H(inf)`` keeps its sign, without zero, for every ``kappa`` in ``[lower, upper]``.

    For ``lower = 0`` that is ``1 + kappa D > 0``; for ``upper = inf`` every finite ``kappa`` is meant.  It makes the
    loop equation solvable for every continuous ``phi`` in the sector, uniquely for slope bounds.

    ``upper``: upper gain, ``inf`` allowed; ``lower``: lower gain.
    """
    direct = block.feedthrough
    start = 1 + lower * direct
    if upper == math.inf:
        return start != 0 and direct * start >= 0
    return start * (1 + Fraction(upper) * direct) > 0


def require_well_posed(block: RationalPlant, upper: Fraction | float, *, lower: Fraction = Fraction(0)) -> None:
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
            f"sector [{float(lower):g}, {float(upper):g}]; choose a sector without that gain",
            code=Reason.ILL_POSED,
        )


def _check_hidden(plant: TransferPolynomials) -> None:
    at_infinity = plant.n.degree() < plant.degree and plant.d.degree() < plant.degree and plant.discrete
    if not at_infinity and is_hurwitz(plant.hidden):
        return
    zero, region = ("z = 1", "inside the unit circle") if plant.discrete else ("s = 0", "in the left half-plane")
    at_zero = plant.hidden[0] == 0
    where = f"at {zero}" if at_zero else "at z = -1" if at_infinity else f"not strictly {region}"
    raise AssumptionError(
        f"a mode {where} is not seen by input or output (it cancels in H): no feedback moves it and no criterion on H "
        "covers it; leave it out only if the system does not have it",
        code=Reason.HIDDEN_MODE,
    )


def _check_zero(plant: TransferPolynomials, lower: Fraction) -> None:
    zero = "z = 1" if plant.discrete else "s = 0"
    shift = f" at the lower gain {float(lower):g}" if lower else ""
    multiplicity = 0
    while plant.d[multiplicity] == 0 and multiplicity <= plant.d.degree():
        multiplicity += 1
    if multiplicity > 1:
        raise AssumptionError(
            f"the pole at {zero}{shift} has multiplicity {multiplicity}; the critical case needs a simple one: for "
            "(s + 1)/s^2 every linear gain is stable, yet with phi = sigma exp(-|sigma|) solutions escape to infinity; "
            "a class with a positive lower gain, if phi lies in one, has no such pole",
            code=Reason.DOUBLE_ZERO,
        )
    if multiplicity == 1 and not plant.residue > 0:
        raise AssumptionError(
            f"the residue at the pole {zero}{shift} is {float(plant.residue):.6g}; it must be positive: with this sign "
            "small positive gains are unstable; check the sign of the feedback",
            code=Reason.RESIDUE,
        )


def _unstable(plant: TransferPolynomials, lower: Fraction) -> str:
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
