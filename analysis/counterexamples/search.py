"""All ways to refute a class of laws for one block, smallest class first."""

from __future__ import annotations

from fractions import Fraction

from lure.analysis.counterexamples.linear import linear_witness, refutes_lower
from lure.analysis.counterexamples.periodic_discrete import periodic_witness_discrete, sector_witness_discrete
from lure.analysis.counterexamples.switched import switched_witness_discrete
from lure.analysis.verdict import Witness
from lure.plants.rational import RationalPlant


def refute(
    block: RationalPlant, *, slope: bool, odd: bool, time_varying: bool, lower: Fraction = Fraction(0)
) -> tuple[Witness, ...]:
    r"""Destabilising members of a class of laws ``mu = -phi(sigma)``, ``sigma = H mu``, in ascending order of ``k``.

    Each refutes the class ``[lower, k']`` for every ``k' >= k``.  Nothing follows from what is not found.

    Parameters
    ----------
    block : RationalPlant
        The block, in continuous or discrete time.
    slope : bool
        Whether the laws have slope in ``[lower, k]``; else they lie in that sector only.
    odd : bool
        Whether the laws are odd.
    time_varying : bool
        Whether the laws may vary with time.
    lower : Fraction
        Lower bound of slope or sector.  Where the loop is only marginal there, the class is that of ``(lower, k]``.

    Returns
    -------
    tuple of Witness
        At most one of each kind; a nonlinear one only if its ``k`` is below that of the linear gain.  In continuous
        time it is looked for too where the gain ``lower`` itself refutes every class, with poles on the axis.

    Examples
    --------
    >>> block = RationalPlant([1], [1, 2, 2, 1])
    >>> for found in refute(block, slope=False, odd=False, time_varying=True):
    ...     print(f"{found.kind} from {found.k:.3f} on ({found.evidence})")
    switched gain from 2.502 on (certified)
    linear gain from 3.000 on (certified)
    """
    lower = Fraction(lower)
    found = [linear_witness(block, lower=lower)]
    if block.dt is None:
        if 1 + lower * block.feedthrough != 0:
            found += _continuous(block, lower, odd=odd, time_varying=time_varying)
    elif not refutes_lower(found[0]):
        found += _discrete(block, lower, slope=slope, odd=odd, time_varying=time_varying)
    return tuple(sorted((witness for witness in found if witness is not None), key=lambda witness: witness.k))


def _discrete(
    block: RationalPlant, lower: Fraction, *, slope: bool, odd: bool, time_varying: bool
) -> list[Witness | None]:
    if time_varying:
        return [switched_witness_discrete(block, lower=lower)]
    if slope:
        return [periodic_witness_discrete(block, odd=odd, lower=lower)]
    return [sector_witness_discrete(block, odd=odd, lower=lower)]


def _continuous(block: RationalPlant, lower: Fraction, *, odd: bool, time_varying: bool) -> list[Witness | None]:
    from lure.analysis.counterexamples.oscillation import oscillation_witness
    from lure.analysis.counterexamples.switched import switched_witness

    if time_varying:
        return [switched_witness(block, lower=lower)]
    return [oscillation_witness(block, odd=odd, lower=lower)]
