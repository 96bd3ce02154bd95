"""The misprint table: every formula of the paper that its own premises contradict, as a difference that is not zero."""

from __future__ import annotations

from lure.derivation.errata_numerics import numerics_misprints
from lure.derivation.errata_theory import theory_misprints
from lure.derivation.vocabulary import Misprint


def misprints() -> tuple[Misprint, ...]:
    """Misprints of the paper in the order of its equations.

    Each ``corrected`` comes out of the derivation, each ``printed`` is copied from the paper, and ``difference`` is
    computed from the two.  A statement about numbers (such as the same results for ``h = 1/10`` and ``h = 1/200``) has
    no symbolic difference and is not here.

    Returns
    -------
    tuple of Misprint
        Sections 2 and 3 of the paper, then 4 and 5.

    Examples
    --------
    >>> print(misprints()[0].difference)
    A*E*u_x**2*(E - 1)/2
    """
    return theory_misprints() + numerics_misprints()
