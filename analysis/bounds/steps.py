"""The uniform quantiser, whose jumps are infinitely many: bounds in closed form."""

from __future__ import annotations

import math
from fractions import Fraction

from analysis.bounds.extremes import Candidate, largest, least
from analysis.bounds.result import LawBounds, short
from analysis.evidence import Evidence
from lure.laws import Quantiser

_HALF = Fraction(1, 2)


def quantiser_bounds(law: Quantiser, on: tuple[Fraction, Fraction] | None) -> LawBounds:
    """Sector and slope bounds, exact.

    At the jump to level ``n``, at ``(n - 1/2) step``, the chord rises to ``n/(n - 1/2)``; between the jumps it falls,
    before the next one to ``n/(n + 1/2)``.  The first falls with ``n``, the second rises: only the first jumps count.
    """
    chords: list[Candidate] = []
    jump: Fraction | None = None
    flat = False
    for side in (1, -1):
        near, far = (Fraction(0), math.inf) if on is None else sorted((side * on[0], side * on[1]))
        if far <= 0:
            continue
        near = max(Fraction(near), Fraction(0))
        found, first, level = _of_side(law, near, far)
        flat = flat or level
        jump = side * first if first is not None and jump is None else jump
        chords += [
            Candidate(value=v, place=side * x, inside=inside, side=-side * (not inside)) for v, x, inside in found
        ]
    slopes = [Candidate(value=Fraction(0), place="between the jumps", inside=True)]
    if jump is not None:
        slopes.append(Candidate(value=math.inf, place=f"a jump at {short(jump)}", inside=False))
    return LawBounds(
        law=str(law),
        sector_lower=least(chords),
        sector_upper=largest(chords),
        slope_lower=least(slopes),
        slope_upper=largest(slopes),
        evidence=Evidence.CERTIFIED,
        on=on,
    )


def _of_side(
    law: Quantiser, near: Fraction, far: Fraction | float
) -> tuple[list[tuple[Fraction, Fraction, bool]], Fraction | None, bool]:
    """Values, places and whether they are taken, on ``[near, far]``; the first jump in it."""
    n = int(near / law.step + _HALF)  # the level at near
    found = []
    if near > 0:
        found.append((law.exact(near) / near, near, True))
    elif far > 0:
        found.append((Fraction(0), min(law.step / 4, Fraction(far)) if far != math.inf else law.step / 4, True))
    if far != math.inf:
        found.append((law.exact(Fraction(far)) / Fraction(far), Fraction(far), True))
    first = (n + _HALF) * law.step
    if near < first <= far:
        if n:
            found.append((n * law.step / first, first, False))
        found.append(((n + 1) * law.step / first, first, True))
        return found, first, True
    return found, None, True
