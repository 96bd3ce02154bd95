"""State equations with exact entries: the matrices a block was given by, or the companion form of its coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

from lure.arrays import NDArray, np
from lure.errors import InputError, Reason
from lure.record import Record, quantity

if TYPE_CHECKING:
    import control

    from lure.plants.rational import RationalPlant

Row = tuple[Fraction, ...]
Doubles: TypeAlias = "tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]"


class Names(Record, kw_only=False):
    """What the author of a system calls its parts."""

    states: tuple[str, ...] = quantity("(n,)")
    input: str = quantity("The signal ``mu``")
    output: str = quantity("The signal ``sigma``")
    system: str = quantity("The whole")


class Realisation(Record, kw_only=False):
    r"""``x' = A x + b mu``, ``sigma = c x + d mu`` (in discrete time ``x+``), every entry a Fraction."""

    A: tuple[Row, ...] = quantity("(n, n), row by row")
    b: Row = quantity("(n,)", key="B")
    c: Row = quantity("(n,)", key="C")
    d: Fraction = quantity("Feedthrough ``H(infinity)``", key="D")
    names: Names | None = quantity("Those of states and signals, where the source has any", default=None)

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.b)

    def closed(self, k: Fraction) -> tuple[Row, ...]:
        """``A - b c k/(1 + k d)``: the loop with ``mu = -k sigma``; needs ``1 + k d != 0``."""
        gain = k / (1 + k * self.d)
        fed = [gain * cj for cj in self.c]
        return tuple(
            tuple(a - bi * cj for a, cj in zip(row, fed, strict=True)) if bi else row
            for row, bi in zip(self.A, self.b, strict=True)
        )

    def doubles(self) -> Doubles:
        """``A`` (n, n), ``b`` (n,), ``c`` (n,) and ``d``, each entry the nearest double.

        Raises
        ------
        InputError
            An entry exceeds the largest double.
        """
        try:
            A, b, c = (np.array([float(v) for v in side]) for side in (sum(self.A, ()), self.b, self.c))
        except OverflowError:
            raise InputError(
                "an entry exceeds the largest double, 1.8e308; rescale the unit of time", code=Reason.RANGE
            ) from None
        return A.reshape(self.order, self.order), b, c, float(self.d)

    def to_control(self, *, dt: float | bool) -> control.StateSpace:
        """The matrices as a ``control.StateSpace`` with their names.

        Parameters
        ----------
        dt : float or bool
            As python-control has it: 0 is continuous, True discrete of unspecified period.
        """
        return control_system(self.doubles(), self.names, dt=dt)


def companion(block: RationalPlant) -> Realisation:
    """The controllable companion form: ``x = (y, y', ..., y^(n-1))`` with ``d(p) y = mu``, ``sigma = n(p) y``.

    Hidden modes are kept: they are unobservable in this form.

    ``block``: the block; matrices that it was given by are not looked at.
    """
    n, d = block.order, block.feedthrough
    low = tuple(reversed(block.denominator))[:n]
    top = (*reversed(block.numerator), *[Fraction(0)] * (n + 1 - len(block.numerator)))
    rows = [tuple(Fraction(int(j == i + 1)) for j in range(n)) for i in range(n - 1)]
    last = [tuple(-a for a in low)] if n else []
    b = tuple(Fraction(int(i == n - 1)) for i in range(n))
    return Realisation((*rows, *last), b, tuple(t - d * a for t, a in zip(top[:n], low, strict=True)), d)


def control_system(matrices: Doubles, names: Names | None, *, dt: float | bool) -> control.StateSpace:
    """A ``control.StateSpace`` of one input and one output.

    Parameters
    ----------
    matrices : tuple
        ``A`` (n, n), ``B`` (n,), ``C`` (n,) and ``D``.
    names : Names or None
        Those of states and signals; python-control's own where there are none.
    dt : float or bool
        As python-control has it.
    """
    import control

    said: dict[str, Any] = {}
    if names is not None:
        said = {"states": list(names.states), "inputs": [names.input], "outputs": [names.output], "name": names.system}
    A, B, C, D = matrices
    n = B.size
    return control.StateSpace(A, B.reshape(n, 1), C.reshape(1, n), [[D]], dt, **said)


def names_of(system: control.StateSpace) -> Names:
    """The names of a system of python-control with one input and one output."""

    def listed(labels: Sequence[object]) -> list[str]:
        """The labels as text."""
        return [str(label) for label in labels]

    inputs, outputs = listed(system.input_labels), listed(system.output_labels)
    return Names(tuple(listed(system.state_labels)), inputs[0], outputs[0], str(system.name))
