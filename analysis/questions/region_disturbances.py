"""What a loop that is stable near 0 survives: the energy of a disturbance, and the set that the state stays in."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.checker import Proved
from lure.analysis.inequality.ellipsoids import Disturbance
from lure.analysis.numerics.doubles import double_below, text_below
from lure.analysis.questions.region_proofs import MOST_DISTURBED, proved_ellipsoid
from lure.analysis.questions.region_sets import Shape, matrix_of
from lure.arrays import in_doubles
from lure.errors import InputError
from lure.exact import exact_number
from lure.files.system import LoopSystem
from lure.plants.multivariable import MultivariablePlant
from lure.record import Record, quantity


class ReachableSet(Record):
    """Where a loop that starts at 0 stays under disturbances of bounded energy; afterwards it returns to 0."""

    energy: float = quantity("``int |w|^2`` (in discrete time the sum) up to which this is proved", form="below")
    P: tuple[tuple[Fraction, ...], ...] = quantity("(n, n), exactly: ``x'P x <= 1`` is not left", label="")
    Bw: tuple[tuple[Fraction, ...], ...] = quantity("(n, p), ``x' = A x + B mu + Bw w``", label="")
    Dsigmaw: tuple[tuple[Fraction, ...], ...] = quantity("(m, p), ``sigma = C x + D mu + Dsigmaw w``", label="")
    proof: Proved = quantity("what the checker accepted", key="certificate", label="", plainly=lambda p: p.certificate)
    _said = "sentence"

    def __str__(self) -> str:
        return (
            f"From rest every disturbance of energy up to {text_below(self.energy, 7)} leaves the state in an "
            "ellipsoid, in which it returns to 0 (certified)."
        )


def disturbance_of(plant: object, given: Any, sizes: tuple[int, int]) -> Disturbance | None:  # noqa: ANN401  (rows)
    """How ``w`` moves the loop: as given, or as the performance of a system says; None where it does not.

    Parameters
    ----------
    plant : object
        A system may have a performance.
    given : sequence of sequences or None
        (n, p).
    sizes : pair of int
        Numbers of states and of channels.

    Raises
    ------
    InputError
        It is no matrix with a row for each state.
    """
    n, m = sizes
    if given is None:
        stated = plant.performance if isinstance(plant, LoopSystem) else None
        if stated is None or not stated.Bw:
            return None
        if stated.parameters:
            raise InputError("performance holds parameters, and regions are of one plant; give numbers")
        exact, seen = stated.Bw, stated.Dsigmaw
        if len(seen) not in (0, m):  # of limits that are moved there are two channels each
            return None
    else:
        rows = [list(row) if isinstance(row, list | tuple) else [row] for row in given]
        if len(rows) != n or len({len(row) for row in rows}) != 1 or not rows[0]:
            raise InputError(f"disturbance has {len(rows)} rows; give {n} of equal length, one for each state")
        exact = tuple(
            tuple(exact_number(v, f"disturbance[{i}][{j}]") for j, v in enumerate(row)) for i, row in enumerate(rows)
        )
        seen = ()
    seen = seen or ((Fraction(0),) * len(exact[0]),) * m
    B, D = (in_doubles(side) for side in (exact, seen))
    return Disturbance(B, D, (exact, seen)) if B.any() or D.any() else None


def reachable_set(plant: MultivariablePlant, shapes: Sequence[Shape], moved: Disturbance) -> ReachableSet | None:
    """The largest energy of a disturbance that is proved to be survived, and the ellipsoid; None where none is found.

    ``moved``: how ``w`` moves the state.
    """
    if _beyond(moved, shapes):
        return None
    shown = proved_ellipsoid(plant, shapes, moved)
    if shown is None:
        return None
    energy = double_below(Fraction(shown.certificate["proof"]["energy"]))
    into, seen = moved.exact
    return ReachableSet(energy=energy, P=matrix_of(shown.certificate), Bw=into, Dsigmaw=seen, proof=shown)


def _beyond(moved: Disturbance, shapes: Sequence[Shape]) -> int:
    """The first channel whose ``sigma`` is moved by ``w``, and whose bounds hold on an interval alone; 0 if none.

    An energy bounds no value of ``w``; lines with limits need no interval of ``sigma``.
    """
    found = (i for i, shape in enumerate(shapes) if moved.D[i].any() and shape.clip is None)
    return next(found, -1) + 1


def unanswered(found: ReachableSet | None, shapes: Sequence[Shape], moved: Disturbance) -> str:
    """Why no energy of a disturbance is proved to be survived; empty if one is.

    ``moved``: how ``w`` moves the loop.
    """
    if found is not None:
        return ""
    beyond = _beyond(moved, shapes)
    if beyond:
        return f"w moves sigma of channel {beyond} beyond every interval, and of lines with limits alone more is known"
    if len(shapes) >= MOST_DISTURBED:
        return f"disturbances are asked about with fewer than {MOST_DISTURBED} channels, and the loop has {len(shapes)}"
    return "no energy of a disturbance is proved to be survived"
