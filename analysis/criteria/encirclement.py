"""Encirclements of the Nyquist plot, counted from exact root counts and from no plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from analysis.plant import Plant, closed_loop_poles
from lure.errors import AssumptionError, InputError
from lure.rational import RationalBlock
from lure.sector import Sector


@dataclass(frozen=True, kw_only=True, slots=True)
class Encirclements:
    """How often the Nyquist plot of ``H`` winds round ``-1/kappa``.

    Attributes
    ----------
    counterclockwise : int
        ``open_loop - closed_loop``; negative for clockwise turns.
    open_loop, closed_loop : int
        Poles of ``H`` and roots of ``d + kappa n`` in the right half-plane (outside the circle), hidden modes too.
    """

    counterclockwise: int
    open_loop: int
    closed_loop: int


def encirclements(block: RationalBlock, kappa: Fraction) -> Encirclements:
    r"""The number of encirclements of ``-1/kappa`` by the Nyquist plot of ``H``.

    By the principle of the argument for ``1 + kappa H = (d + kappa n)/d`` on the axis from ``-i inf`` to ``i inf``
    (the unit circle from ``-pi`` to ``pi``), closed on the right and indented to the right of poles on it, the plot
    encircles the point ``P_open - P_closed`` times counterclockwise.

    Parameters
    ----------
    block : RationalBlock
        The block.
    kappa : Fraction
        A gain that is not zero.

    Raises
    ------
    InputError
        ``kappa`` is zero: the point lies at infinity.
    AssumptionError
        The plot runs through ``-1/kappa``, so that nothing can be counted.

    Examples
    --------
    >>> encirclements(RationalBlock([12], [1, 2, -3]), Fraction(1)).counterclockwise
    1
    """
    if kappa == 0:
        raise InputError("encirclements needs a gain kappa that is not zero: -1/kappa lies at infinity")
    plant = Plant.of(block)
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

    Parameters
    ----------
    sector : Sector
        ``k1 < k2``, either of them infinite.
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


def encirclement_condition(block: RationalBlock, sector: Sector, inside: Fraction) -> str:
    """The encirclement condition of the circle criterion for a sector, with the counts that were found.

    Parameters
    ----------
    block : RationalBlock
        The block.
    sector : Sector
        The sector.
    inside : Fraction
        A gain of the sector, not zero and with no closed-loop pole on the axis.

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
