"""Plants with several inputs and outputs and dead time: states whose outputs arrive late."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError, Reason
from lure.plants.delay import DelayPlant, require_pade_order
from lure.plants.multivariable import MultivariablePlant, Rows, plant_of_transfers, polynomial_of
from lure.plants.rational import RationalPlant
from lure.plants.text import descending
from lure.record import Record, derived, quantity

if TYPE_CHECKING:
    import control

MOST_DELAYS = 20


class DelayMatrix(Record, kw_only=False):
    r"""``x' = A x + B mu``, ``sigma(t) = C x(t) + D mu(t) + sum_k C_k x(t - T_k)``, exact entries.

    In a loop ``mu_i = -phi_i(sigma_i)``, one nonlinearity a channel; the transfer matrix is ``H = C (sI - A)^{-1} B +
    D + sum_k exp(-s T_k) C_k (sI - A)^{-1} B``.  With ``inner`` ``x' = A x + sum_k A_k x(t - T_k) + B mu``.  With
    ``rates`` ``D_k x'(t - T_k)`` is added to ``sigma`` and ``E_k x'(t - T_k)`` to ``x'``, an equation of neutral type.

    Parameters
    ----------
    base : MultivariablePlant
        The part without dead time, in continuous time.
    late : tuple
        Pairs of a dead time [s] and the rows of ``C_k``, (p, n); the dead times are above 0 and ascend.
    inner : tuple
        The rows of ``A_k``, (n, n), for each dead time, or nothing: what of the states comes back late.
    rates : tuple
        Pairs of the rows of ``D_k``, (p, n), and of ``E_k``, (n, n), for each dead time, or nothing.

    Raises
    ------
    InputError
        The plant is in discrete time, a dead time is not above 0, or a matrix of one does not fit.

    Examples
    --------
    >>> from lure import as_plant
    >>> plant = as_plant([["1/(s+1)", "0"], ["0", "exp(-s)/(s+2)"]])
    >>> print(plant)
    2 states, 2 inputs and 2 outputs in continuous time, dead time 1 s
    >>> print(plant.channel(1, 1))
    (s + 1) exp(-1 s) / (s^2 + 3 s + 2)
    """

    base: MultivariablePlant = quantity("", label="without dead time", form=str)
    late: tuple[tuple[Fraction, Rows], ...] = quantity(
        "", label="dead times", form=lambda late: ", ".join(f"{float(delay):g} s" for delay, _ in late)
    )
    inner: tuple[Rows, ...] = quantity(
        "", default=(), label="states that come back late", form=lambda inner: "yes" if inner else "none"
    )
    rates: tuple[tuple[Rows, Rows], ...] = quantity(
        "", default=(), label="derivatives that come back late", form=lambda rates: "yes" if rates else "none"
    )
    dt: ClassVar[None] = None
    _kind, _said = "plant with dead times", "text"
    _title = "H(s) = C (sI - A)^-1 B + D + sum exp(-s T) C_T (sI - A)^-1 B"
    _notes = ("In a loop mu_i = -phi_i(sigma_i).",)

    def __post_init__(self) -> None:
        delays = [delay for delay, _ in self.late]
        if self.base.dt is not None:
            raise InputError(
                "a plant with dead times is in continuous time; in discrete time a delay is a state, z**-1"
            )
        if not delays or min(delays) <= 0 or sorted(set(delays)) != delays or len(delays) > MOST_DELAYS:
            raise InputError(
                f"the dead times are {[*map(float, delays)]!r:.80}; give 1 to {MOST_DELAYS}, above 0 and ascending"
            )
        for delay, rows in self.late:
            if len(rows) != self.outputs or any(len(row) != self.order for row in rows):
                raise InputError(f"C of the dead time {float(delay):g} s does not fit; give a row for each output")
        sizes = {(len(rows), *map(len, rows)) for rows in self.inner}
        if self.inner and (len(self.inner) != len(self.late) or sizes != {(self.order,) * (self.order + 1)}):
            raise InputError("inner does not fit; give a square matrix of the order for each dead time, or nothing")
        wide = [len(row) for pair in self.rates for side in pair for row in side]
        tall = {tuple(map(len, pair)) for pair in self.rates}
        if self.rates and (
            len(self.rates) != len(self.late) or tall != {(self.outputs, self.order)} or {*wide} != {self.order}
        ):
            raise InputError("rates do not fit; give D_k, a row for each output, and a square E_k for each dead time")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the channels."""
        return self.base.names

    @property
    @derived(label="states")
    def order(self) -> int:
        """Number of states ``n``."""
        return self.base.order

    @property
    def inputs(self) -> int:
        """Number of inputs ``m``."""
        return self.base.inputs

    @property
    def outputs(self) -> int:
        """Number of outputs ``p``."""
        return self.base.outputs

    @property
    @derived(key="", label="channels")
    def size(self) -> str:
        """Inputs and outputs in words."""
        return self.base.size

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at complex ``s`` in floating point: the shape of ``s``, then (p, m)."""
        points = np.asarray(s, dtype=complex)
        (A, B, C, D), late = self._doubles
        s = points[..., None, None]
        waits = [np.exp(-delay * s) for delay, _ in late]
        back = s * np.eye(self.order) - A
        for wait, own in zip(waits, self.inner, strict=False):
            back = back - wait * np.array(own, dtype=float)
        for wait, (_, own) in zip(waits, self.rates, strict=False):
            back = back - s * wait * np.array(own, dtype=float)
        states = np.linalg.solve(back, B.astype(complex))
        total = C @ states + D
        for wait, (_, rows) in zip(waits, late, strict=True):
            total = total + wait * (rows @ states)
        for wait, (moved, _) in zip(waits, self.rates, strict=False):
            total = total + s * wait * (np.array(moved, dtype=float) @ states)
        return np.asarray(total)

    def opened(self) -> DelayMatrix:
        """The plant without ``inner``, with a channel for each state that has some: with gains 1 there it is this one.

        They follow the other channels: ``mu`` is added to ``x_i'``, and ``sigma = -sum_k A_k x(t - T_k)``, row ``i``.
        Of ``rates`` ``E_k`` is moved likewise.
        """
        n, p = self.order, self.outputs
        fed = [i for i in range(n) if any(any(rows[i]) for rows in (*self.inner, *(E for _, E in self.rates)))]
        zero, width = Fraction(0), self.inputs + len(fed)
        base = replace(
            self.base,
            B=tuple((*row, *(Fraction(int(i == k)) for k in fed)) for i, row in enumerate(self.base.B)),
            C=(*self.base.C, *((zero,) * n for _ in fed)),
            D=(*((*row, *(zero for _ in fed)) for row in self.base.D), *((zero,) * width for _ in fed)),
            names=(),
        )
        inner = self.inner or [((zero,) * n,) * n] * len(self.late)
        late = tuple(
            (delay, (*rows[:p], *(tuple(-v for v in back[i]) for i in fed)))
            for (delay, rows), back in zip(self.late, inner, strict=True)
        )
        none = ((zero,) * n,) * n
        rates = tuple(((*D[:p], *(tuple(-v for v in E[i]) for i in fed)), none) for D, E in self.rates)
        return DelayMatrix(base, late, (), rates)

    @cached_property
    def _doubles(self) -> tuple[tuple[NDArray[np.float64], ...], list[tuple[float, NDArray[np.float64]]]]:
        return self.base.doubles(), [(float(delay), np.array(rows, dtype=float)) for delay, rows in self.late]

    def formulas(self) -> list[list[str]]:
        """``H`` as rows of formulas in ``s``, without the modes that an entry does not have.

        Raises
        ------
        InputError
            A mode is in no entry: formulas do not say it.  Or states come back late.
        """
        self._require_open()
        delays = [(Fraction(0), self.base.C), *self.late]
        found = [[list[str]() for _ in range(self.inputs)] for _ in range(self.outputs)]
        for delay, rows in delays:
            direct = self.base.D if not delay else ((Fraction(0),) * self.inputs,) * self.outputs
            part = replace(self.base, C=rows, D=direct)
            for i, line in enumerate(found):
                for j, terms in enumerate(line):
                    one = part.channel(i, j)
                    top, bottom = polynomial_of(one.numerator), polynomial_of(one.denominator)
                    if top == 0:
                        continue
                    shared = top.gcd(bottom)
                    up, down = (_formula(descending(p // shared)) for p in (top, bottom))
                    terms.append(f"({up})" + f"*exp(-({delay})*s)" * bool(delay) + f"/({down})")
        written = [[" + ".join(terms) or "0" for terms in line] for line in found]
        again = plant_of_delays([[_entry(text) for text in line] for line in written])
        if again.order != self.order:
            raise InputError("the plant has a mode that no entry of H has; a matrix of formulas does not say it")
        return written

    def channel(self, output: int, input_: int) -> DelayPlant | RationalPlant:
        """The exact transfer function from one input to one output.

        Parameters
        ----------
        output, input_ : int
            Counted from 0.
        """
        self._require_open()
        direct = self.base.channel(output, input_)
        found = {Fraction(0): direct.numerator}
        for delay, rows in self.late:
            moved = replace(self.base, C=rows, D=tuple((Fraction(0),) * self.inputs for _ in rows))
            found[delay] = moved.channel(output, input_).numerator
        if not any(map(any, found.values())):
            return direct
        plant = DelayPlant(found, direct.denominator)
        return plant.delayless or plant

    def _require_open(self) -> None:
        if self.inner or self.rates:
            raise InputError("the plant has states that come back late, and no formulas for its entries; keep its own")

    def require_retarded(self, what: str) -> None:
        """Refuse a question that is not answered of neutral equations.

        Parameters
        ----------
        what : str
            What is asked for, in the plural.

        Raises
        ------
        InputError
            A derivative comes back late.
        """
        if self.rates:
            raise InputError(
                f"{what} are not shown of neutral equations, with a direct term that has dead time or the like; "
                "lure certify and lure max-sector decide whether the loop is stable"
            )

    def to_control(self, *, pade: int | None = None) -> control.StateSpace:
        """The plant with each dead time replaced by its Pade approximation: python-control has no dead time.

        Parameters
        ----------
        pade : int
            Order of the approximation, 1 to 20.  The system returned is another one: no answer about this plant is one
            about it, nor the other way round.

        Raises
        ------
        InputError
            No order is given: an approximation is not made unasked.
        """
        require_pade_order(pade, f"the plant has {self}")
        import control

        if self.inner:
            p, opened = self.outputs, self.opened()
            gains = np.diag([0.0] * p + [1.0] * (opened.outputs - p))
            whole = control.feedback(opened.to_control(pade=pade), control.ss([], [], [], gains))
            return whole[:p, : self.inputs]
        total, inner = self.base.to_control(), self.base.to_control()
        for k, (delay, rows) in enumerate(self.late):
            wait = control.tf2ss(control.TransferFunction(*control.pade(float(delay), pade)))
            moved = np.array(self.rates[k][0] if self.rates else 0 * np.array(rows), dtype=float)
            seen = np.array(rows, dtype=float) + moved @ inner.A
            part = control.StateSpace(inner.A, inner.B, seen, moved @ inner.B)
            total = total + control.append(*[wait] * self.outputs) * part
        return total

    def __str__(self) -> str:
        delays = ", ".join(f"{float(delay):g}" for delay, _ in self.late)
        return f"{self.base}, dead time{'s' * (len(self.late) > 1)} {delays} s{', of states too' * bool(self.inner)}"


def one_channel_of(plant: DelayPlant) -> DelayMatrix:
    """A realisation of a block with dead time, exactly, of the order of ``d``: all its modes stay, hidden ones too.

    ``x_i' = x_(i+1)``, ``x_n' = mu`` less what ``d`` and the late terms of the denominator say of ``x`` and ``x_n'``.

    Raises
    ------
    InputError
        It has no states.
    """
    n, terms, feedback = len(plant.denominator) - 1, dict(plant.terms), dict(plant.feedback)

    def row(p: Sequence[Fraction]) -> tuple[Fraction, ...]:
        """The coefficients below ``s^n``, ascending."""
        return (*reversed(p), *(Fraction(0),) * n)[:n]

    direct, swift = ({delay: top[0] for delay, top in side.items() if len(top) == n + 1} for side in (terms, feedback))
    if not n:
        raise InputError(
            f"the block {plant} with dead time has no states; add a fast pole to the model", code=Reason.DEAD_TIME
        )
    D = direct.get(Fraction(0), Fraction(0))
    shift = tuple(tuple(Fraction(int(j == i + 1)) for j in range(n)) for i in range(n - 1))
    base = MultivariablePlant(
        (*shift, tuple(-c for c in row(plant.denominator))),
        tuple((Fraction(int(i == n - 1)),) for i in range(n)),
        (tuple(a - D * b for a, b in zip(row(terms.get(Fraction(0), ())), row(plant.denominator), strict=True)),),
        ((D,),),
    )
    late, inner, rates = list[tuple[Fraction, Rows]](), list[Rows](), list[tuple[Rows, Rows]]()
    nothing = (Fraction(0),) * n
    for delay in sorted({*terms, *feedback} - {Fraction(0)}):
        back = row(feedback.get(delay, ()))
        late.append((delay, (tuple(a - D * b for a, b in zip(row(terms.get(delay, ())), back, strict=True)),)))
        inner.append((*(nothing,) * (n - 1), tuple(-b for b in back)))
        a, c = swift.get(delay, Fraction(0)), direct.get(delay, Fraction(0))
        rates.append((((*nothing[1:], c - D * a),), (*(nothing,) * (n - 1), (*nothing[1:], -a))))
    neutral = bool(swift or any(direct))
    return DelayMatrix(base, tuple(late), tuple(inner) if feedback or neutral else (), tuple(rates) if neutral else ())


def plant_of_delays(entries: Sequence[Sequence[RationalPlant | DelayPlant]]) -> DelayMatrix | MultivariablePlant:
    """A realisation, exactly, of a matrix of transfer functions with dead times.

    The parts of all dead times, one below the other, are a matrix without any, of which a minimal one is taken.  Beside
    it stand the entries with dead time in the denominator, those of a column with the same denominator together.

    ``entries``: ``H``, row by row, outputs down.

    Raises
    ------
    InputError
        :func:`lure.plants.multivariable.plant_of_transfers` refuses them, a part with dead time is not strictly proper
        (a neutral equation), or all parts of an entry share a factor with its denominator, a hidden mode; or two
        columns have entries of one row with the same dead times in the denominator, which a minimal one may share.
    """
    inside = [(i, j) for i, row in enumerate(entries) for j, one in enumerate(row) if getattr(one, "feedback", ())]
    if inside:
        return _beside(entries, inside)
    parts = [[_parts(one, f"transfer[{i}][{j}]") for j, one in enumerate(row)] for i, row in enumerate(entries)]
    delays = sorted({delay for row in parts for one in row for delay in one if delay})
    if not delays:
        return plant_of_transfers([[one.get(Fraction(0), _ZERO) for one in row] for row in parts])
    for i, row in enumerate(parts):
        for j, one in enumerate(row):
            if any(delay and part.feedthrough for delay, part in one.items()):
                raise InputError(_NEUTRAL.format(f"transfer[{i}][{j}]"), code=Reason.DEAD_TIME)
    stacked = [[one.get(delay, _ZERO) for one in row] for delay in (Fraction(0), *delays) for row in parts]
    whole, p = plant_of_transfers(stacked), len(entries)
    base = replace(whole, C=whole.C[:p], D=whole.D[:p])
    return DelayMatrix(base, tuple((delay, whole.C[(k + 1) * p : (k + 2) * p]) for k, delay in enumerate(delays)))


def _beside(entries: Sequence[Sequence[RationalPlant | DelayPlant]], inside: list[tuple[int, int]]) -> DelayMatrix:
    """The realisation of the entries without dead time in the denominator, and beside it those of the others."""
    alike = dict[tuple[object, int], dict[int, DelayMatrix]]()
    for i, j in inside:
        one = entries[i][j]
        assert isinstance(one, DelayPlant), "it has dead time in its denominator"
        if any(delay and len(top) == len(one.denominator) for delay, top in (*one.terms, *one.feedback)):
            raise InputError(_NEUTRAL.format(f"transfer[{i}][{j}]"), code=Reason.DEAD_TIME)
        key = (one.denominator, one.feedback)
        if any(other == key and column != j and i in rows for (other, column), rows in alike.items()):
            raise InputError(
                f"row {i} of transfer has the denominator of transfer[{i}][{j}], with dead time, in two columns: how "
                "many states that takes is not decided; give the states, DelayMatrix(base, late, inner)"
            )
        alike.setdefault((key, j), {})[i] = one_channel_of(one)
    rest = [[_ZERO if (i, j) in inside else one for j, one in enumerate(row)] for i, row in enumerate(entries)]
    p, m = len(entries), len(entries[0])
    blocks = list[tuple[DelayMatrix | MultivariablePlant, dict[int, int], list[int]]]()
    if any(any(one.numerator if isinstance(one, RationalPlant) else one.terms) for row in rest for one in row):
        blocks.append((plant_of_delays(rest), {i: i for i in range(p)}, [*range(m)]))
    for (_, j), rows in alike.items():
        blocks += [(_together(rows), {i: k for k, i in enumerate(rows)}, [j])]
    return _side_by_side(blocks, p, m)


def _together(rows: dict[int, DelayMatrix]) -> DelayMatrix:
    """Outputs of the same states, which differ in their dead times too."""
    first = next(iter(rows.values()))
    times = sorted({delay for one in rows.values() for delay, _ in one.late})
    nothing, zero = (Fraction(0),) * first.order, ((Fraction(0),) * first.order,) * first.order
    base = replace(
        first.base,
        C=tuple(one.base.C[0] for one in rows.values()),
        D=tuple(one.base.D[0] for one in rows.values()),
        names=(),
    )
    back = dict(zip((delay for delay, _ in first.late), first.inner, strict=True))
    late = [(T, tuple(dict(one.late).get(T, (nothing,))[0] for one in rows.values())) for T in times]
    return DelayMatrix(base, tuple(late), tuple(back.get(T, zero) for T in times))


def _side_by_side(
    blocks: Sequence[tuple[DelayMatrix | MultivariablePlant, dict[int, int], list[int]]], p: int, m: int
) -> DelayMatrix:
    """The sum of plants, of each the output for every row that it has, and the columns of its inputs."""
    n = sum(one.order for one, _, _ in blocks)
    times = sorted({delay for one, _, _ in blocks if isinstance(one, DelayMatrix) for delay, _ in one.late})
    A, B, C, D = ([[Fraction(0)] * width for _ in range(height)] for height, width in ((n, n), (n, m), (p, n), (p, m)))
    late, inner = ({T: [[Fraction(0)] * n for _ in range(height)] for T in times} for height in (p, n))
    start = 0
    for one, rows, columns in blocks:
        part, own = (one.base, one) if isinstance(one, DelayMatrix) else (one, None)
        span = slice(start, start + one.order)
        for k in range(one.order):
            A[start + k][span] = part.A[k]
            for at, j in enumerate(columns):
                B[start + k][j] = part.B[k][at]
        for i, k in rows.items():
            C[i][span] = part.C[k]
            for at, j in enumerate(columns):
                D[i][j] += part.D[k][at]
        for number, (T, seen) in enumerate(own.late if own else ()):
            for i, k in rows.items():
                late[T][i][span] = seen[k]
            for k, row in enumerate(own.inner[number] if own and own.inner else ()):
                inner[T][start + k][span] = row
        start += one.order

    def kept(side: list[list[Fraction]]) -> Rows:
        """Rows that stay as they are."""
        return tuple(map(tuple, side))

    base = MultivariablePlant(kept(A), kept(B), kept(C), kept(D))
    return DelayMatrix(base, tuple((T, kept(late[T])) for T in times), tuple(kept(inner[T]) for T in times))


_ZERO = RationalPlant([0], [1])
_NEUTRAL = (
    "{} has dead time and is not strictly proper; that is a neutral equation, which is covered in one channel alone: "
    "add a fast pole to the model"
)


def _parts(entry: RationalPlant | DelayPlant, name: str) -> dict[Fraction, RationalPlant]:
    """The transfer function of each dead time, without the poles that only others of the entry have."""
    if isinstance(entry, RationalPlant):
        if entry.dt is not None and entry.order:
            raise InputError(f"{name} is in discrete time, and another entry has dead time; write z**-n for a delay")
        return {Fraction(0): entry}
    bottom = polynomial_of(entry.denominator)
    tops = {delay: polynomial_of(top) for delay, top in entry.terms}
    shared = bottom
    for top in tops.values():
        shared = shared.gcd(top)
    if shared.degree() > 0:
        raise InputError(f"{name} has a factor common to numerator and denominator; cancel it")
    found = {}
    for delay, top in tops.items():
        common = bottom.gcd(top)
        found[delay] = RationalPlant(descending(top // common), descending(bottom // common))
    return found


def _formula(coefficients: Sequence[Fraction]) -> str:
    top = len(coefficients) - 1
    return " + ".join(f"({c})*s**{top - k}" for k, c in enumerate(coefficients) if c)


def _entry(text: str) -> RationalPlant | DelayPlant:
    found = DelayPlant.parse(text) if text != "0" else None
    return _ZERO if found is None else found.delayless or found
