"""A disturbance ``w`` and an output ``z`` beside the channels of a plant, and the input to which it is asked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any, cast

from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant, counted
from lure.plants.parameters import Constants, Rate, interval, names_in
from lure.plants.text import descending, parsed_quotient
from lure.record import Record, quantity

Rows = tuple[tuple[Fraction, ...], ...]
Bounded = tuple[tuple[str, Fraction, Fraction], ...]
_WORD = re.compile(r"(?<![\w.])[A-Za-z]\w*")


class Performance(Record):
    r"""Where a disturbance ``w`` enters a loop and which output ``z`` is looked at.

    .. math:: \dot x = A x + B \mu + B_w w, \quad \sigma = C x + D \mu + D_{\sigma w} w, \quad
        z = C_z x + D_{z\mu} \mu + D_{zw} w, \qquad \mu_i = -\phi_i(\sigma_i).

    A matrix that is left out is 0.  As ``mu = -phi(sigma)``, what is written ``z = ... + M phi(sigma)`` has ``Dzmu =
    -M``.

    An entry may be a formula in the parameters of the plant, or in ``parameters`` of its own.

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
    late: tuple[tuple[Fraction, Rows], ...] = quantity(
        "pairs of a dead time [s] and how ``z`` sees the state of that time, (q, n)", label="", default=()
    )
    parameters: Bounded = quantity("bounds of the parameters that occur in these alone", label="", default=())
    _kind, _said = "performance", "text"

    def __post_init__(self) -> None:
        if not self.inputs or not self.outputs:
            raise InputError("performance has no w or no z; give Bw (or Dzw, Dsigmaw) and Cz (or Dzw, Dzmu)")

    @classmethod
    def given(cls, stated: object) -> Performance:
        """The performance that a mapping of matrices means, or one as it is.

        Parameters
        ----------
        stated : Performance or mapping
            ``Bw``, ``Cz``, ``Dzw``, ``Dzmu``, ``Dsigmaw``: each a list of rows or an array; a number for 1 x 1, a
            list of numbers for the column of one ``w`` or the row of one ``z``.  A text is the decimal or the quotient
            that it says, exactly, or a formula in parameters: those of the plant, and the ``parameters`` that are
            stated here, each with its bounds or its value.

        Raises
        ------
        InputError
            It is neither, a name is none of these, a matrix is none, a parameter has no name or no interval, or ``w``
            enters nowhere, or ``z`` sees nothing.
        """
        if isinstance(stated, Performance):
            return stated
        if not isinstance(stated, Mapping):
            raise InputError(
                f"performance is {stated!r:.60}; give a mapping such as {{'Bw': [[1], [0]], 'Cz': [[0, 1]]}}"
            )
        unknown = next((name for name in stated if name not in (*_NAMES, _OWN)), None)
        if unknown is not None:
            raise InputError(f"performance has {unknown!r:.40}; choose from {', '.join((*_NAMES, _OWN))}")
        bounds = stated.get(_OWN, {})
        if not isinstance(bounds, Mapping):
            raise InputError(f"performance.{_OWN} is {bounds!r:.60}; give a mapping such as {{'k': (1, 2)}}")
        known, ranges = Constants(bounds), list[tuple[str, Fraction, Fraction]]()
        for name, ends in bounds.items():
            if name not in known.constants:
                if len(ends) != 2:
                    raise InputError(f"performance.{_OWN}.{name} is {ends!r:.40}; give two bounds: it is constant")
                ranges.append((name, *interval(name, ends)))
        sides = {str(name): _matrix(str(name), value, known) for name, value in stated.items() if name != _OWN}
        found = cls(**sides, late=(), parameters=tuple(ranges))
        unused = next((name for name in bounds if name not in names_in([*stated.values()])), None)
        if unused is not None:
            raise InputError(f"performance.{_OWN}.{unused} does not occur in the matrices; leave it out, or use it")
        ways = ("w enters nowhere", ("Bw", "Dzw", "Dsigmaw")), ("z sees nothing", ("Cz", "Dzw", "Dzmu"))
        for what, names in ways:
            if not any(v for name in names for row in getattr(found, name) for v in row):
                raise InputError(
                    f"performance: {what}, as all entries of {', '.join(names)} are 0, and the gain is 0 wherever the "
                    "loop is stable; give one that is not 0, or ask lure certify whether it is"
                )
        return found

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

    @property
    def formulas(self) -> list[str]:
        """The entries that are formulas."""
        entries: list[object] = [v for side in self.stated.values() for row in side for v in row]
        return [v for v in entries if isinstance(v, str)]

    def beside(
        self, H: MultivariablePlant | ChannelFamily | DelayMatrix
    ) -> MultivariablePlant | ChannelFamily | DelayMatrix:
        """The plant with ``w`` as last inputs and ``z`` as last outputs, filled up with zeros to as many of both.

        Parameters
        ----------
        H : MultivariablePlant, ChannelFamily or DelayMatrix
            The plant, or those with parameters: the matrices are the same for all of them, but for formulas.

        Returns
        -------
        MultivariablePlant, ChannelFamily or DelayMatrix
            The second too where there are parameters in the performance alone.

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
        if isinstance(H, DelayMatrix):
            base = self.beside(H.base)
            if not isinstance(base, MultivariablePlant):
                raise InputError("performance has parameters, and the plant has dead time; give numbers")
            known = dict(self.late)
            late = tuple((delay, (*rows, *_filled(known.get(delay, ()), size, n))) for delay, rows in H.late)
            return replace(H, base=base, late=late)

        into, seen = _filled(self.Bw, n, size), _filled(self.Cz, size, n)
        right, below = _filled(self.Dsigmaw, m, size), _filled(self.Dzmu, size, m)
        last = _filled(self.Dzw, size, size)
        formulas = self.formulas
        if formulas and (self.parameters or isinstance(H, ChannelFamily)):
            own = H.sides if isinstance(H, ChannelFamily) else {name: getattr(H, name) for name in "ABCD"}
            bounds: dict[str, tuple[Rate, ...]] = {name: (low, high) for name, low, high in self.parameters}
            if isinstance(H, ChannelFamily):
                both = next((name for name in H.names if name in bounds), None)
                if both is not None:
                    raise InputError(f"performance.{_OWN}.{both} is a parameter of the plant too; leave it out here")
                rates = H.rates or (0,) * len(H.names)
                bounds |= {
                    name: (*ends, *[rate] * bool(rate)) for name, ends, rate in zip(H.names, H.box, rates, strict=True)
                }
            wide = [[*a, *b] for a, b in zip([*own["B"], *own["D"]], [*into, *right], strict=True)]
            whole = own["A"], wide[:n], [*own["C"], *seen], [*wide[n:], *_joined(below, last)]
            try:
                found = ChannelFamily.of_matrices(*whole, bounds, _time(H))
            except InputError as error:
                raise InputError(f"performance: beside the plant, {error}") from None
            assert isinstance(found, ChannelFamily), "there are parameters"
            return found
        if formulas:
            raise InputError(
                f"performance holds {formulas[0]!r:.40}, and the plant has no parameters; give numbers, or bounds in "
                f"performance.{_OWN}"
            )
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


_NAMES, _OWN = tuple(part.name for part in fields(Performance))[:-2], "parameters"


def _time(H: MultivariablePlant | ChannelFamily) -> Fraction | bool | None:
    """Its sampling time."""
    return True if isinstance(H, ChannelFamily) and H.any_period else H.dt


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


def _matrix(name: str, value: object, known: Constants) -> Rows:
    rows: Any = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(rows, int | float | Fraction | str) and not isinstance(rows, bool):
        rows = [rows]
    flat = isinstance(rows, list | tuple) and rows and not any(isinstance(entry, list | tuple) for entry in rows)
    if flat and (name != "Dzw" or len(rows) == 1):  # of one w a column, of one z a row
        rows = [[entry] for entry in rows] if name in ("Bw", "Dsigmaw") else [rows]
    listed = isinstance(rows, list | tuple) and all(isinstance(row, list | tuple) and row for row in rows)
    if not listed or not rows or len({len(row) for row in rows}) != 1:
        raise InputError(
            f"performance.{name} is {_plainly(rows):.60}; give rows of numbers of equal length, such as [[1, 0]]"
        )

    def read(entry: object, where: str) -> Fraction:
        """An entry as a number; a formula in parameters as its text."""
        text = known.put_in(entry) if isinstance(entry, str) else ""
        if _WORD.search(text):
            return cast("Fraction", text)  # which beside() reads with the plants
        if not text:
            return exact_number(entry, where)
        found, _ = parsed_quotient(text, known, where)
        top, bottom = descending(found.top), descending(found.bottom)
        return exact_number(top[0] / bottom[0] if top else Fraction(0), where)

    return tuple(
        tuple(read(entry, f"performance.{name}[{i}][{j}]") for j, entry in enumerate(row)) for i, row in enumerate(rows)
    )


# An input of a loop, to which its steady response is asked.

MOST_FREQUENCIES = 1000
_KEYS = ("amplitude", "omega", "constant", "unit")


class Forcing(Record):
    r"""An input of a loop.

    .. math:: w(t) = w_0 + a \sin(\omega t)

    Raises
    ------
    InputError
        Nothing moves the loop; ``constant`` and ``amplitude`` differ in length; a frequency is not positive, or has no
        amplitude; or there are more than 1000.

    Examples
    --------
    >>> print(Forcing.given({"amplitude": 2, "omega": [1, 3]}))
    w = 2 sin(omega t), omega = 1 to 3 rad/s
    """

    amplitude: tuple[Fraction, ...] = quantity("(p,) ``a`` [unit of w]", default=())
    omega: tuple[Fraction, ...] = quantity("The frequencies asked about [rad/s]; empty for some chosen", default=())
    constant: tuple[Fraction, ...] = quantity("(p,) ``w_0`` [unit of w]", default=())
    unit: str = quantity("The unit of ``z``, for figures", default="")
    _kind, _said = "forcing", "text"

    def __post_init__(self) -> None:
        moving = any(self.amplitude)
        if not moving and not any(self.constant):
            raise InputError("forcing has neither amplitude nor constant; give one, such as amplitude = 1")
        if len({len(side) for side in (self.amplitude, self.constant) if side}) > 1:
            raise InputError(
                f"forcing.amplitude has {len(self.amplitude)} entries and forcing.constant {len(self.constant)}; give "
                "one for each input w in both"
            )
        if self.omega and not moving:
            raise InputError("forcing.omega is given without amplitude; give forcing.amplitude, or leave omega out")
        low = min(self.omega, default=Fraction(1))
        if low <= 0:
            raise InputError(f"forcing.omega is {float(low):g}; give positive frequencies in rad/s")
        if len(self.omega) > MOST_FREQUENCIES:
            raise InputError(f"forcing.omega has {len(self.omega)} entries; give up to {MOST_FREQUENCIES}")

    @classmethod
    def given(cls, stated: object) -> Forcing:
        """The input that a mapping of numbers means, or one as it is.

        Parameters
        ----------
        stated : Forcing or mapping
            ``amplitude``, ``omega``, ``constant``: each a number or a list; ``unit``.

        Raises
        ------
        InputError
            It is neither, or as above.
        """
        if isinstance(stated, Forcing):
            return stated
        if not isinstance(stated, Mapping):
            raise InputError(f"forcing is {stated!r:.60}; give a mapping such as {{'amplitude': 1, 'omega': 2}}")
        unknown = next((name for name in stated if name not in _KEYS), None)
        if unknown is not None:
            raise InputError(f"forcing has {unknown!r:.40}; choose from {', '.join(_KEYS)}")
        sides = {name: exact_numbers(stated[name], f"forcing.{name}") for name in _KEYS[:3] if name in stated}
        return cls(**sides, unit=str(stated.get("unit", "")))

    @property
    def stated(self) -> dict[str, object]:
        """What is not left out."""
        return {name: side for name in _KEYS if (side := getattr(self, name))}

    @property
    def inputs(self) -> int:
        """Length of ``w``."""
        return max(len(self.amplitude), len(self.constant))

    def __str__(self) -> str:
        parts = [", ".join(f"{float(v):g}" for v in side) for side in (self.constant, self.amplitude)]
        parts = [f"({part})" if "," in part else part for part in parts]
        said = [parts[0]] if any(self.constant) else []
        said += [f"{parts[1]} sin(omega t)"] if any(self.amplitude) else []
        low, high = (f"{float(end(self.omega)):g}" for end in (min, max)) if self.omega else ("", "")
        where = (
            "" if not self.omega else f", omega = {low} rad/s" if low == high else f", omega = {low} to {high} rad/s"
        )
        return f"w = {' + '.join(said)}{where}"


def exact_numbers(value: object, name: str) -> tuple[Fraction, ...]:
    """A number, or a list or an array of them, exactly; ``name``: what they are, for the message.

    Raises
    ------
    InputError
        One is no finite number.
    """
    listed: object = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, list | tuple):
        return (exact_number(listed, name),)
    return tuple(exact_number(one, f"{name}[{i}]") for i, one in enumerate(listed))
