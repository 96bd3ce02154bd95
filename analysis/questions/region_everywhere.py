"""Proofs that 0 attracts every solution of a loop with known nonlinearities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import ATTRACTS, CONVERGES, Proved
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import system_of
from lure.analysis.deadline import time_left
from lure.analysis.inequality.semidefinite_forms import everywhere
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.numerics.polynomial import to_fraction
from lure.analysis.questions.certify import ProofOptions, certify
from lure.analysis.questions.region_sets import Shape, rests_at_0
from lure.bounds import Sector
from lure.classes import NonlinearityClass
from lure.errors import AssumptionError, InputError
from lure.plants.multivariable import MultivariablePlant

_GLOBAL = 5.0  # [s] for the criteria
_NEAR = Fraction(1, 4)  # an interval around 0 on which phi ascends


def proved_everywhere(plant: MultivariablePlant, shapes: Sequence[Shape]) -> Proved | None:
    """A proof that 0 attracts every solution; None where none is found in a few seconds.

    In the critical case solutions are proved to converge to the set of equilibria, which has to be 0 alone.  With a
    double pole no class is stable, but what is known of the nonlinearities may do.

    ``shapes``: what is known of the nonlinearity of each channel.
    """
    single, nonlinearities = plant.inputs == 1, [_around_line(shape) or shape.nonlinearity for shape in shapes]
    block, given = (plant.channel(0, 0), nonlinearities[0]) if single else (plant, list(nonlinearities))
    with suppress(InputError, AssumptionError):
        found = certify(block, given, ways=ProofOptions(seconds=max(1e-3, min(_GLOBAL, time_left()))))
        shown = found.shown
        if isinstance(shown, Proved) and not found.assumed and not shown.assumed:
            conclusion = shown.certificate["conclusion"]
            if conclusion == ATTRACTS or (conclusion == CONVERGES and rests_at_0(plant, shapes)):
                return shown
    if plant.dt is not None:
        return None
    tops, graphs = list[Fraction | None](), list[dict[str, Any]]()
    for shape in shapes:
        known = _of_one_sign(shape)
        if known is None:
            return None
        tops.append(known[0])
        graphs.append(known[1])
    draft = {"verdict": "PROVED", "system": system_of(plant), "theorem": "global-popov", "laws": {"graphs": graphs}}
    for one in everywhere([plant.A, plant.B, plant.C, plant.D], tops):
        with suppress(Rejected, Malformed):
            shown = checked(draft | {"multiplier": one.multiplier, "proof": one.proof})
            return shown if isinstance(shown, Proved) else None
    return None


def _around_line(shape: Shape) -> NonlinearityClass | None:
    """A narrow sector about a line, which the criteria take as a class and not as a nonlinearity; None of others."""
    if len(shape.pieces) != 1 or shape.pieces[0].degree() > 1 or shape.pieces[0][0] != 0:
        return None
    gain = to_fraction(shape.pieces[0][1])
    wide = max(abs(gain), Fraction(1)) / 2**10
    return NonlinearityClass(sector=Sector(gain - wide, gain + wide))


def _of_one_sign(shape: Shape) -> tuple[Fraction | None, dict[str, Any]] | None:
    """The largest ``phi/sigma``, and what a certificate says of ``phi``, whose integrals go to infinity; None if not.

    That is of polynomials between cuts for the checker to decide; one that ascends, and does so at 0, has limits on
    both sides that are not 0.
    """
    try:
        bounds = nonlinearity_bounds(shape.nonlinearity)
        top, least = bounds.sector_upper.outer, bounds.slope_lower
        end = Fraction(top) if math.isfinite(top) and top > 0 else None
        if shape.pieces:
            return end, shape.entry(None)
        if end is None or least is None or least.outer < 0:
            return None
        slope = nonlinearity_bounds(shape.nonlinearity, on=(-_NEAR, _NEAR)).slope_lower
    except InputError:
        return None
    return None if slope is None or slope.outer <= 0 else (end, {"kind": "signed", "top": str(end)})
