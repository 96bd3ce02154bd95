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
from lure.arrays import np
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
    proof: Proved = quantity("what the checker accepted", key="certificate", label="", plainly=lambda p: p.certificate)
    _said = "sentence"

    def __str__(self) -> str:
        return (
            f"From rest every disturbance of energy up to {text_below(self.energy, 7)} leaves the state in an "
            "ellipsoid, in which it returns to 0 (certified)."
        )


def disturbance_of(plant: object, given: Any, n: int) -> Disturbance | None:  # noqa: ANN401  (rows of numbers)
    """How ``w`` moves the state: as given, or as the performance of a system says; None where it does not.

    Parameters
    ----------
    plant : object
        A system may have a performance.
    given : sequence of sequences or None
        (n, p).
    n : int
        Number of states.

    Raises
    ------
    InputError
        It is no matrix with a row for each state.
    """
    if given is None:
        stated = plant.performance if isinstance(plant, LoopSystem) else None
        if stated is None or not stated.Bw or any(map(any, stated.Dsigmaw)):
            return None
        if stated.parameters:
            raise InputError("performance holds parameters, and regions are of one plant; give numbers")
        exact = stated.Bw
    else:
        rows = [list(row) if isinstance(row, list | tuple) else [row] for row in given]
        if len(rows) != n or len({len(row) for row in rows}) != 1 or not rows[0]:
            raise InputError(f"disturbance has {len(rows)} rows; give {n} of equal length, one for each state")
        exact = tuple(
            tuple(exact_number(v, f"disturbance[{i}][{j}]") for j, v in enumerate(row)) for i, row in enumerate(rows)
        )
    moves = any(map(any, exact))
    return Disturbance(np.array([[float(v) for v in row] for row in exact]), exact) if moves else None


def reachable_set(plant: MultivariablePlant, shapes: Sequence[Shape], moved: Disturbance) -> ReachableSet | None:
    """The largest energy of a disturbance that is proved to be survived, and the ellipsoid; None where none is found.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part.
    shapes : sequence of Shape
        What is known of each nonlinearity.
    moved : Disturbance
        How ``w`` moves the state.
    """
    shown = proved_ellipsoid(plant, shapes, moved)
    if shown is None:
        return None
    energy = double_below(Fraction(shown.certificate["proof"]["energy"]))
    return ReachableSet(energy=energy, P=matrix_of(shown.certificate), Bw=moved.exact, proof=shown)


def unanswered(found: ReachableSet | None, shapes: Sequence[Shape]) -> str:
    """Why no energy of a disturbance is proved to be survived; empty if one is.

    Parameters
    ----------
    found : ReachableSet or None
        What was found.
    shapes : sequence of Shape
        What is known of each nonlinearity.
    """
    if found is not None:
        return ""
    if len(shapes) >= MOST_DISTURBED:
        return f"disturbances are asked about with fewer than {MOST_DISTURBED} channels, and the loop has {len(shapes)}"
    return "no energy of a disturbance is proved to be survived"
