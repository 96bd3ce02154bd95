"""A disturbance ``w`` and an output ``z`` beside the channels of a plant: the matrices with which they come in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from typing import cast, overload

from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.channel_family import ChannelFamily
from lure.plants.multivariable import MultivariablePlant, counted
from lure.record import Record, quantity

Rows = tuple[tuple[Fraction, ...], ...]


class Performance(Record):
    r"""Where a disturbance ``w`` enters a loop and which output ``z`` is looked at.

    .. math:: \dot x = A x + B \mu + B_w w, \quad \sigma = C x + D \mu + D_{\sigma w} w, \quad
        z = C_z x + D_{z\mu} \mu + D_{zw} w, \qquad \mu_i = -\phi_i(\sigma_i).

    A matrix that is left out is 0.  As ``mu = -phi(sigma)``, what is written ``z = ... + M phi(sigma)`` has ``Dzmu =
    -M``.

    Beside plants with parameters an entry may be a formula in these.

    Raises
    ------
    InputError
        There is no ``w`` or no ``z``.

    Examples
    --------
    >>> print(Performance.given({"Bw": [[1], [0]], "Cz": [[0, 1]]}))
    1 disturbance w (Bw), 1 output z (Cz)
    """

    Bw: Rows = quantity("(n, p) how ``w`` moves the state", default=())
    Cz: Rows = quantity("(q, n) how ``z`` sees the state", default=())
    Dzw: Rows = quantity("(q, p) from ``w`` to ``z``", default=())
    Dzmu: Rows = quantity("(q, m) from ``mu`` to ``z``", default=())
    Dsigmaw: Rows = quantity("(m, p) from ``w`` to ``sigma``", default=())
    _kind, _said = "performance", "text"

    def __post_init__(self) -> None:
        if not self.inputs or not self.outputs:
            raise InputError("performance has no w or no z; give Bw (or Dzw, Dsigmaw) and Cz (or Dzw, Dzmu)")

    @classmethod
    def given(cls, stated: object, *, formulas: bool = False) -> Performance:
        """The performance that a mapping of matrices means, or one as it is.

        Parameters
        ----------
        stated : Performance or mapping
            ``Bw``, ``Cz``, ``Dzw``, ``Dzmu``, ``Dsigmaw``: each a list of rows or an array; a number for 1 x 1.
        formulas : bool
            Whether entries may be formulas, which are read together with plants.

        Raises
        ------
        InputError
            It is neither, a name is none of these, or a matrix is none.
        """
        if isinstance(stated, Performance):
            return stated
        if not isinstance(stated, Mapping):
            raise InputError(
                f"performance is {stated!r:.60}; give a mapping such as {{'Bw': [[1], [0]], 'Cz': [[0, 1]]}}"
            )
        unknown = next((name for name in stated if name not in _NAMES), None)
        if unknown is not None:
            raise InputError(f"performance has {unknown!r:.40}; choose from {', '.join(_NAMES)}")
        return cls(**{str(name): _matrix(str(name), value, formulas=formulas) for name, value in stated.items()})

    @property
    def inputs(self) -> int:
        """Length ``p`` of ``w``."""
        return next((len(side[0]) for side in (self.Bw, self.Dzw, self.Dsigmaw) if side), 0)

    @property
    def outputs(self) -> int:
        """Length ``q`` of ``z``."""
        return next((len(side) for side in (self.Cz, self.Dzw, self.Dzmu) if side), 0)

    @property
    def stated(self) -> dict[str, Rows]:
        """The matrices that are not left out."""
        return {name: side for name in _NAMES if (side := getattr(self, name))}

    @overload
    def beside(self, H: MultivariablePlant) -> MultivariablePlant: ...

    @overload
    def beside(self, H: ChannelFamily) -> ChannelFamily: ...

    def beside(self, H: MultivariablePlant | ChannelFamily) -> MultivariablePlant | ChannelFamily:
        """The plant with ``w`` as last inputs and ``z`` as last outputs, filled up with zeros to as many of both.

        Parameters
        ----------
        H : MultivariablePlant or ChannelFamily
            The plant, or those with parameters: the matrices are the same for all of them, but for formulas.

        Raises
        ------
        InputError
            A matrix does not fit, or has a formula in what is no parameter.
        """
        n, m, p, q = H.order, H.inputs, self.inputs, self.outputs
        shapes = {"Bw": (n, p), "Cz": (q, n), "Dzw": (q, p), "Dzmu": (q, m), "Dsigmaw": (m, p)}
        for name, rows in self.stated.items():
            shape = (len(rows), len(rows[0]))
            if shape != shapes[name]:
                raise InputError(
                    f"performance.{name} has {_size(*shape)}; with {counted(n, 'state')}, {counted(m, 'channel')}, "
                    f"{counted(p, 'input')} w and {counted(q, 'output')} z give {_size(*shapes[name])}"
                )
        size = max(p, q)

        into, seen = _filled(self.Bw, n, size), _filled(self.Cz, size, n)
        right, below = _filled(self.Dsigmaw, m, size), _filled(self.Dzmu, size, m)
        last = _filled(self.Dzw, size, size)
        formulas = [v for side in (into, seen, right, below, last) for row in side for v in row if isinstance(v, str)]
        if formulas and isinstance(H, ChannelFamily):
            own, bounds = H.sides, dict(zip(H.names, H.box, strict=True))
            wide = [[*a, *b] for a, b in zip([*own["B"], *own["D"]], [*into, *right], strict=True)]
            whole = own["A"], wide[:n], [*own["C"], *seen], [*wide[n:], *_joined(below, last)]
            try:
                found = ChannelFamily.of_matrices(*whole, bounds, True if H.any_period else H.dt)
            except InputError as error:
                raise InputError(f"performance: beside the plant, {error}") from None
            assert isinstance(found, ChannelFamily), "there are parameters"
            return found
        if formulas:
            raise InputError(f"performance holds {formulas[0]!r:.40}, and the plant has no parameters; give numbers")
        if isinstance(H, ChannelFamily):
            return H.beside(into, seen, (*_joined(_filled((), m, m), right), *_joined(below, last)))
        D = (*_joined(H.D, right), *_joined(below, last))
        return replace(H, B=_joined(H.B, into), C=(*H.C, *seen), D=D, names=())

    def __str__(self) -> str:
        sides = {"disturbance": ("Bw", "Dsigmaw"), "output": ("Cz", "Dzmu")}
        said = []
        for (word, names), number, sign in zip(sides.items(), (self.inputs, self.outputs), "wz", strict=True):
            given = ", ".join(name for name in (*names, "Dzw") if getattr(self, name))
            said.append(f"{number} {word}{'s' * (number != 1)} {sign} ({given})")
        return ", ".join(said)


_NAMES = tuple(part.name for part in fields(Performance))


def _joined(left: Rows, right: Rows) -> Rows:
    return tuple((*a, *b) for a, b in zip(left, right, strict=True))


def _filled(rows: Rows, high: int, wide: int) -> Rows:
    """The matrix, filled up with zeros."""
    zero = Fraction(0)
    return tuple(
        tuple(rows[i][j] if i < len(rows) and j < len(rows[i]) else zero for j in range(wide)) for i in range(high)
    )


def _size(high: int, wide: int) -> str:
    return f"{counted(high, 'row')} of {counted(wide, 'number')}"


def _plainly(value: object) -> str:
    """A value in a message: lists in brackets, exact numbers as they are written."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_plainly, value))}]"
    return repr(value) if isinstance(value, str) else str(value)


def _matrix(name: str, value: object, *, formulas: bool) -> Rows:
    rows = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(rows, int | float | Fraction) and not isinstance(rows, bool):
        rows = [[rows]]
    listed = isinstance(rows, list | tuple) and all(isinstance(row, list | tuple) and row for row in rows)
    if not listed or not rows or len({len(row) for row in cast("Sequence[Sequence[object]]", rows)}) != 1:
        raise InputError(
            f"performance.{name} is {_plainly(rows):.60}; give rows of numbers of equal length, such as [[1, 0]]"
        )

    def read(entry: object, where: str) -> Fraction:
        if formulas and isinstance(entry, str):
            return cast("Fraction", entry)  # which beside() reads with the plants
        return exact_number(entry, where)

    return tuple(
        tuple(read(entry, f"performance.{name}[{i}][{j}]") for j, entry in enumerate(row))
        for i, row in enumerate(cast("Sequence[Sequence[object]]", rows))
    )
