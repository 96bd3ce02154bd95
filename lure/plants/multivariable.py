"""Plants with several inputs and outputs: state equations with exact entries, from matrices or transfer functions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, cast

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError, Reason
from lure.exact import Exact
from lure.plants.matrices import checked_matrices, rational_block, rows_of
from lure.plants.rational import RationalPlant, sampling_period, time_text
from lure.plants.realisation import Row, companion
from lure.plants.text import exact_coefficient
from lure.record import Record, derived, quantity

if TYPE_CHECKING:
    import control
    from flint import fmpq_mat

Rows = tuple[Row, ...]
MOST_STATES, MOST_CHANNELS = 200, 100
_SHAPES = "give A (n, n), B (n, m), C (p, n) and D (p, m)"


class MultivariablePlant(Record, kw_only=False):
    r"""``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x[k+1] = ...``), ``m`` inputs, ``p`` outputs, exact entries.

    In a loop ``mu_i = -phi_i(sigma_i)``, one nonlinearity a channel; the transfer matrix is ``H = C (sI - A)^{-1} B +
    D``.  With one input and one output :func:`lure.as_plant` gives a :class:`lure.plants.rational.RationalPlant`.

    Parameters
    ----------
    A : tuple of tuples
        (n, n) Fractions [1/s], row by row.
    B, C, D : tuple of tuples
        (n, m), (p, n) and (p, m).
    dt : int, float, Fraction, True or None
        Sampling time [s]; True where its period is not stated, which counts as 1; None for continuous time.
    names : tuple of str
        Of the channels, as :func:`lure.lft` is told them; empty if they have none.

    Raises
    ------
    InputError
        Shapes do not fit, there are more than 200 states or 100 channels, ``dt`` is not positive, or the names are not
        one for each of as many inputs as outputs.

    Examples
    --------
    >>> from lure import as_plant
    >>> plant = as_plant([["1/(s+1)", "0"], ["1/(s+2)", "1/(s+2)"]])
    >>> print(plant, "|", plant.channel(1, 0))
    2 states, 2 inputs and 2 outputs in continuous time | (s + 1) / (s^2 + 3 s + 2)
    """

    A: Rows = quantity("", label="")
    B: Rows = quantity("", label="")
    C: Rows = quantity("", label="")
    D: Rows = quantity("", label="")
    dt: Fraction | None = quantity("", label="time", form=time_text, default=None)
    names: tuple[str, ...] = quantity("", label="", default=())
    _kind, _said = "multivariable plant", "text"
    _title = "H(s) = C (sI - A)^-1 B + D"
    _notes = ("In a loop mu_i = -phi_i(sigma_i).",)

    def __post_init__(self) -> None:
        n, m, p = self.order, self.inputs, self.outputs
        shapes = ((self.A, n, n), (self.B, n, m), (self.C, p, n), (self.D, p, m))
        if not all(len(side) == rows and all(len(row) == width for row in side) for side, rows, width in shapes):
            raise InputError(f"the matrices of a plant with {m} inputs and {p} outputs do not fit; {_SHAPES}")
        if n > MOST_STATES or max(m, p) > MOST_CHANNELS or not min(m, p):
            raise InputError(
                f"the plant has {n} states, {m} inputs and {p} outputs; exact matrices stop at {MOST_STATES} states "
                f"and {MOST_CHANNELS} channels, and need one"
            )
        if self.names and not (len(set(self.names)) == len(self.names) == m == p):
            raise InputError(f"the channels have the names {list(self.names)!r:.80}; give one for each of {m}, or none")
        object.__setattr__(self, "dt", sampling_period(self.dt, "MultivariablePlant.dt"))

    @classmethod
    def of_one_channel(cls, block: RationalPlant) -> MultivariablePlant:
        """A plant with one input and one output, with the matrices it was given by, or in companion form.

        Parameters
        ----------
        block : RationalPlant
            The plant.
        """
        r = block.matrices or companion(block)
        return cls(r.A, tuple((v,) for v in r.b), (r.c,), ((r.d,),), block.dt)

    @property
    @derived(label="states")
    def order(self) -> int:
        """Number of states ``n``."""
        return len(self.A)

    @property
    def inputs(self) -> int:
        """Number of inputs ``m``."""
        return len(self.D[0]) if self.D else 0

    @property
    def outputs(self) -> int:
        """Number of outputs ``p``."""
        return len(self.D)

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at complex ``s`` (or ``z``) in floating point: the shape of ``s``, then (p, m)."""
        points = np.asarray(s, dtype=complex)
        A, B, C, D = self.doubles()
        if not self.order:
            return np.broadcast_to(D.astype(complex), (*points.shape, *D.shape))
        states = np.linalg.solve(points[..., None, None] * np.eye(self.order) - A, B.astype(complex))
        return np.asarray(C @ states + D)

    def channel(self, output: int, input_: int) -> RationalPlant:
        """The exact transfer function from one input to one output, with the modes that the two do not share.

        Parameters
        ----------
        output, input_ : int
            Counted from 0.
        """
        column = [row[input_] for row in self.B]
        return rational_block(self.A, column, self.C[output], self.D[output][input_], dt=self.dt)

    def doubles(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """``A``, ``B``, ``C`` and ``D``, each entry the nearest double.

        Raises
        ------
        InputError
            An entry exceeds the largest double.
        """
        n, m, p = self.order, self.inputs, self.outputs
        try:
            found = [
                np.array([[float(v) for v in row] for row in side], dtype=float).reshape(shape)
                for side, shape in ((self.A, (n, n)), (self.B, (n, m)), (self.C, (p, n)), (self.D, (p, m)))
            ]
        except OverflowError:
            raise InputError(
                "an entry exceeds the largest double, 1.8e308; rescale the unit of time", code=Reason.RANGE
            ) from None
        return found[0], found[1], found[2], found[3]

    def to_control(self) -> control.StateSpace:
        """The plant as a ``control.StateSpace``."""
        import control

        return control.StateSpace(*self.doubles(), 0 if self.dt is None else float(self.dt))

    def __str__(self) -> str:
        time = "continuous time" if self.dt is None else f"discrete time, dt = {float(self.dt):g}"
        return f"{counted(self.order, 'state')}, {self.size} in {time}"

    @property
    @derived(key="", label="channels")
    def size(self) -> str:
        """Inputs and outputs in words."""
        return f"{counted(self.inputs, 'input')} and {counted(self.outputs, 'output')}"


def counted(number: int, what: str) -> str:
    """A number of things in words: ``1 state``, ``2 states``."""
    return f"{number} {what}{'s' * (number != 1)}"


# From matrices, and from a matrix of transfer functions.


def plant_of_matrices(
    A: object, B: object, C: object, D: object, *, dt: Fraction | Literal[True] | None
) -> MultivariablePlant | None:
    """The plant of the matrices, None if they have one input and one output, or no shape for which it could be told.

    ``A``, ``B``, ``C``, ``D``: nested lists, arrays or sparse matrices; ``D`` may be None or 0.  ``dt``: sampling time
    [s].

    Raises
    ------
    InputError
        Shapes do not fit, or an entry is not a finite real number.
    """
    n = 0 if A is None else len(rows_of(A, "A"))
    direct = [[0]] if D is None else rows_of(D, "D")
    if not n:
        through = _exact(direct, "D")
        many = len(through) > 1 or len(through[0]) > 1
        return MultivariablePlant((), (), ((),) * len(through), through, _step(dt)) if many else None
    inward, outward = _side(B, "B", n), _side(C, "C", n)
    if inward is None or outward is None:
        several = (inward is not None and len(inward[0]) > 1) or (outward is not None and len(outward) > 1)
        name, given = ("B", B) if inward is None else ("C", C)
        rows = cast("list[Sequence[object]]", rows_of(given, name))
        square = {len(cast("Sequence[object]", row)) for row in rows_of(A, "A")} == {n}
        if square and several and len({len(row) for row in rows}) == 1:
            raise InputError(f"{name} is {len(rows)} x {len(rows[0])}, and A has {n} rows; {_SHAPES}")
        return None
    if len(inward[0]) == len(outward) == 1:
        return None
    left, right, through = _exact(inward, "B"), _exact(outward, "C"), _exact(direct, "D")
    if through == ((Fraction(0),),):
        through = ((Fraction(0),) * len(left[0]),) * len(right)
    if (len(through), *{len(row) for row in through}) != (len(right), len(left[0])):
        size = f"{len(through)} x {'/'.join(str(width) for width in {len(row) for row in through})}"
        raise InputError(f"D is {size}, and the plant has {len(left[0])} inputs and {len(right)} outputs; {_SHAPES}")
    state = checked_matrices(A, [0] * n, [0] * n, 0)[0]
    return MultivariablePlant(tuple(state), left, right, through, _step(dt))


def _side(given: object, name: str, n: int) -> list[Sequence[object]] | None:
    """Rows of ``B`` (n, m) or ``C`` (p, n); a vector of ``n`` entries is one channel.  None for what is neither."""
    rows = cast("list[Sequence[object]]", rows_of(given, name))
    widths, entries = {len(row) for row in rows}, [entry for row in rows for entry in row]
    if len(entries) == n:
        return [[entry] for entry in entries] if name == "B" else [entries]
    return rows if len(widths) == 1 and n == (len(rows) if name == "B" else widths.pop()) else None


def _exact(rows: Sequence[object], name: str) -> Rows:
    return tuple(
        tuple(exact_coefficient(v, f"{name}[{i}][{j}]") for j, v in enumerate(cast("Sequence[object]", row)))
        for i, row in enumerate(rows)
    )


def _step(dt: Fraction | Literal[True] | None) -> Fraction | None:
    return cast("Fraction | None", dt)  # True is taken too, and kept as a Fraction


def plant_of_transfers(entries: Sequence[Sequence[RationalPlant]]) -> MultivariablePlant:
    """A minimal realisation, exactly, of a matrix of transfer functions.

    Each column over its common denominator is a companion form, controllable; the rows ``c_i A^k`` that are independent
    are the states of its observable part.

    ``entries``: ``H``, row by row, outputs down.

    Raises
    ------
    InputError
        The rows differ in length, the times differ, or a transfer function has a factor common to numerator and
        denominator, a hidden mode of which nothing tells where it belongs.

    Examples
    --------
    >>> one = RationalPlant([1], [1, 1])
    >>> plant_of_transfers([[one, one], [one, one]]).order
    1
    """
    if len({len(row) for row in entries}) != 1 or not entries[0]:
        raise InputError("the rows of the matrix of transfer functions differ in length, or are empty")
    times = {plant.dt for row in entries for plant in row if plant.order}
    if len(times) > 1:
        raise InputError("the transfer functions are partly in continuous and partly in discrete time, or differ in dt")
    parts = [_column([row[j] for row in entries], j) for j in range(len(entries[0]))]
    sizes = [len(part[0]) for part in parts]
    n, p = sum(sizes), len(entries)
    A, B, C = ([[Fraction(0)] * width for _ in range(rows)] for rows, width in ((n, n), (n, len(parts)), (p, n)))
    for j, (state, output) in enumerate(parts):
        at = sum(sizes[:j])
        for i, row in enumerate(state):
            A[at + i][at : at + sizes[j]] = row
        for i, row in enumerate(output):
            C[i][at : at + sizes[j]] = row
        if sizes[j]:
            B[at + sizes[j] - 1][j] = Fraction(1)
    D = tuple(tuple(plant.feedthrough for plant in row) for row in entries)
    dt = times.pop() if times else entries[0][0].dt
    if not n:
        return MultivariablePlant((), (), ((),) * p, D, dt)
    whole, seen = _flint(A), _flint(C)
    basis = _observed(whole, seen)
    right = basis.transpose() * (basis * basis.transpose()).inv()  # basis * right = 1
    small = [rational_rows(part) for part in (basis * whole * right, basis * _flint(B), seen * right)]
    return MultivariablePlant(small[0], small[1], small[2], D, dt)


def _column(plants: Sequence[RationalPlant], j: int) -> tuple[list[Row], list[Row]]:
    """``A`` of the companion form of a column over its common denominator, and a row ``c`` for each entry."""
    from flint import fmpq_poly

    tops, bottoms = ([polynomial_of(getattr(p, side)) for p in plants] for side in ("numerator", "denominator"))
    for i, (top, bottom) in enumerate(zip(tops, bottoms, strict=True)):
        if top.gcd(bottom).degree() > 0 and top != 0:
            raise InputError(
                f"transfer[{i}][{j}] has a factor common to numerator and denominator; cancel it, or give A, B, C and D"
            )
    common = fmpq_poly([1])
    for top, bottom in zip(tops, bottoms, strict=True):
        if top != 0:
            common = common * bottom // common.gcd(bottom)
    if not common.degree():
        return [], [() for _ in plants]
    raised = [top * (common // bottom) if top != 0 else top for top, bottom in zip(tops, bottoms, strict=True)]
    forms = [companion(_lifted(top, common)) for top in raised]
    return list(forms[0].A), [form.c for form in forms]


def _lifted(top: object, bottom: object) -> RationalPlant:
    """The quotient of two polynomials, common factors kept."""
    sides = [[Fraction(int(c.p), int(c.q)) for c in reversed(side.coeffs())] for side in (top, bottom)]  # type: ignore[attr-defined]  # flint has no types
    return RationalPlant(cast("Sequence[Exact]", sides[0] or [0]), cast("Sequence[Exact]", sides[1]))


def polynomial_of(descending: Sequence[Fraction]) -> Any:  # noqa: ANN401  (fmpq_poly, whose stubs lack its methods)
    """A polynomial of coefficients with the highest power first."""
    from flint import fmpq, fmpq_poly

    return fmpq_poly([fmpq(c.numerator, c.denominator) for c in reversed(descending)])


def _observed(A: fmpq_mat, C: fmpq_mat) -> fmpq_mat:
    """Independent rows ``c_i A^k`` that span all of them."""
    from flint import fmpq_mat

    kept: list[list[Any]] = []
    for i in range(C.nrows()):
        row = fmpq_mat([[C[i, j] for j in range(C.ncols())]])
        while fmpq_mat([*kept, *row.tolist()]).rank() > len(kept):
            kept += row.tolist()
            row = row * A
    return fmpq_mat(kept)


def _flint(rows: Sequence[Sequence[Fraction]]) -> fmpq_mat:
    from flint import fmpq, fmpq_mat

    return fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in rows])


def rational_rows(matrix: fmpq_mat) -> Rows:
    """The rows of an exact matrix."""
    return tuple(tuple(Fraction(int(v.p), int(v.q)) for v in row) for row in matrix.tolist())
