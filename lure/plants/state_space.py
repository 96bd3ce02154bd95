"""Dense state-space blocks in floating point, for orders at which exact polynomials are too large."""

from __future__ import annotations

import sys
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from lure.arrays import ArrayLike, NDArray, balanced, np
from lure.errors import InputError
from lure.plants.block import frozen
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import sampling_period, time_text
from lure.plants.realisation import Names, control_system
from lure.record import Record, derived, described, quantity

if TYPE_CHECKING:
    import control

# Solutions of ``(s I - A) x = b`` at many points ``s``: one orthogonal reduction, then order ``n^2`` a point.

_ROWS = 32  # of a block of the substitution: the rest is matrix products
_LARGE = 1e100
_NEGLIGIBLE = 1e-100  # below this share of the matrix a subdiagonal entry is zero


@described(frozen=True, eq=False, slots=True)
class ControllerForm:
    r"""``A = S Q H Q^T S^{-1}``, ``b = beta S Q e_1`` with ``S`` diagonal, ``Q`` orthogonal, ``H`` upper Hessenberg."""

    H: NDArray[np.float64] = quantity(
        "(r, r), ``r <= n``: states past a vanishing subdiagonal entry cannot be reached from ``b`` and are left out"
    )
    basis: NDArray[np.float64] = quantity("(n, r), the leading columns of ``S Q``")
    beta: float = quantity("Length of ``b`` in the balanced coordinates")

    @classmethod
    def of(cls, A: NDArray[np.float64], b: NDArray[np.float64]) -> ControllerForm:
        """The form of ``A`` (n, n) and ``b`` (n,), balanced first.

        The Hessenberg form of the bordered matrix ``[0, 0; b, A]`` is that of ``A`` with ``b`` along ``e_1``.
        """
        from scipy.linalg import hessenberg

        n = b.size
        even, scale = balanced(A)
        bordered = np.zeros((n + 1, n + 1))
        bordered[1:, 0], bordered[1:, 1:] = b / scale, even
        H, Q = hessenberg(bordered, calc_q=True, overwrite_a=True)
        beta, H = float(H[1, 0]), np.ascontiguousarray(H[1:, 1:])
        small = np.flatnonzero(np.abs(np.diag(H, -1)) <= _NEGLIGIBLE * np.abs(H).max())
        reached = int(small[0]) + 1 if small.size else n
        basis = scale[:, None] * Q[1:, 1 : reached + 1]
        return cls(np.ascontiguousarray(H[:reached, :reached]), np.ascontiguousarray(basis), beta)

    def solutions(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """``(s I - A)^{-1} b`` at each of the points, (n, m); not finite where ``s`` is an eigenvalue to rounding.

        Hyman's substitution: with the last entry set to one, the rows from the last to the second give the entries
        above it, and the first row their common factor.  It solves a system whose entries differ from those of
        ``s I - H`` by rounding errors.
        """
        H, r = self.H, self.H.shape[0]
        X = np.empty((r, points.size), dtype=complex)
        X[-1] = 1.0
        with np.errstate(all="ignore"):
            for high in range(r, 1, -_ROWS):
                low = max(high - _ROWS, 1)
                _block(H, X, points, (low, high))
            factor = points * X[0] - _product(H[:1], X)[0]
            X *= self.beta / factor
            return _product(self.basis, X)


def _block(
    H: NDArray[np.float64], X: NDArray[np.complex128], points: NDArray[np.complex128], rows: tuple[int, int]
) -> None:
    """Entries ``low - 1`` to ``high - 2`` of the solution, from the rows ``low`` to ``high - 1`` of the matrix."""
    low, high = rows
    known = _product(H[low:high, high:], X[high:])
    flat = known.view(np.float64)
    for i in range(high - 1, low - 1, -1):
        flat[: i - low + 1] += H[low : i + 1, i : i + 1] * X[i].view(np.float64)
        X[i - 1] = (points * X[i] - known[i - low]) / H[i, i - 1]
        if not np.abs(X[i - 1].view(np.float64)).max() <= _LARGE:
            shrink = np.exp2(-np.floor(np.log2(np.maximum(np.abs(X[i - 1]), 1.0))))
            X[i - 1 :] *= shrink
            known *= shrink


def _product(real: NDArray[np.float64], values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """A real matrix times a complex one, as one real product of twice as many columns."""
    flat = np.ascontiguousarray(values).view(np.float64)
    return np.asarray((np.ascontiguousarray(real) @ flat).view(np.complex128))


MAX_STATES = 5000
_BATCH_ENTRIES = 1 << 19  # of the solutions held at once, n for each point
_UNIT = sys.float_info.epsilon


class StateSpace(Record, kw_only=False):
    r"""A block ``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x[k+1] = ...``) with ``H(s) = C (sI - A)^{-1} B + D``.

    In a loop ``mu = -phi(sigma)``, see :class:`lure.loop.Loop`.  The entries are doubles, each an exact number in a
    certificate: classes are certified by matrix inequalities.  Up to order 60 :func:`lure.plants.as_plant` gives the
    exact :class:`lure.plants.rational.RationalPlant` instead.

    Parameters
    ----------
    A : array_like
        (n, n), ``1 <= n <= 5000`` [1/s].  Like the others it is copied and cannot be written to.
    B, C : array_like
        (n,) input and output.
    D : float
        Feedthrough [unit of sigma / unit of mu].
    dt : int, float, Fraction, True or None
        Sampling time [s]; True where its period is not stated, which counts as 1; None for continuous time.
    names : Names or None
        What states and signals are called, for python-control.

    Raises
    ------
    InputError
        Shapes do not fit, an entry is not a finite real number, there are too many states, or ``dt`` is not positive.

    Examples
    --------
    >>> block = StateSpace([[0, 1], [-2, -3]], [0, 1], [1, 0])
    >>> block.transfer(1j)
    array(0.1-0.3j)
    """

    A: NDArray[np.float64] = quantity("", label="")
    B: NDArray[np.float64] = quantity("", label="")
    C: NDArray[np.float64] = quantity("", label="")
    D: float = quantity("", form="g", default=0.0)
    dt: Fraction | None = quantity("", label="time", form=time_text, default=None)
    names: Names | None = quantity("", key="", label="", default=None)
    any_period: bool = quantity("", hidden=True, init=False, default=False)
    _kind, _said = "state-space block", "text"
    _title = "H(s) = C (sI - A)^-1 B + D"
    _notes = ("Kept as doubles, for which classes are certified by matrices. In a loop mu = -phi(sigma).",)

    def __post_init__(self) -> None:
        for name in ("A", "B", "C", "D"):
            object.__setattr__(self, name, frozen(getattr(self, name), f"StateSpace.{name}"))
        n = self.B.size
        if self.A.shape != (n, n) or self.B.shape != (n,) or self.C.shape != (n,) or np.ndim(self.D) or n == 0:
            shapes = f"A {self.A.shape}, B {self.B.shape}, C {self.C.shape}, D {np.shape(self.D)}"
            raise InputError(f"StateSpace needs A (n, n), B (n,), C (n,) and a number D with n >= 1; got {shapes}")
        if n > MAX_STATES:
            raise InputError(f"StateSpace has {n} states; dense matrices stop at {MAX_STATES}")
        object.__setattr__(self, "D", float(self.D))
        given: object = self.dt
        object.__setattr__(self, "any_period", given is True)
        object.__setattr__(self, "dt", sampling_period(self.dt, "StateSpace.dt"))

    @property
    @derived()
    def order(self) -> int:
        """Number of states ``n``."""
        return int(self.B.size)

    @property
    def period(self) -> float | Literal[True]:
        """The sampling time as python-control has it: 0 in continuous time, True where none is stated."""
        return True if self.any_period else float(self.dt or 0)

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at complex ``s`` (or ``z``), elementwise, in floating point; not finite at a pole."""
        points = np.asarray(s, dtype=complex)
        return self._values(points.ravel())[0].reshape(points.shape)

    def frequency_response(self, omega: ArrayLike) -> FrequencyData:
        """``H(i omega)``, in discrete time ``H(e^{i omega dt})``, with an estimate of the error at each frequency.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s], nonnegative and increasing, none of them at a pole.

        Returns
        -------
        FrequencyData
            ``error`` is the first-order effect of the rounding errors, by the solutions of the system and of its
            transpose: an estimate and not a bound.  It grows towards lightly damped poles.

        Raises
        ------
        InputError
            The frequencies are not increasing, or one of them is at a pole.

        Notes
        -----
        ``A`` is reduced to Hessenberg form twice, for ``B`` and for ``C``; after that a frequency costs order ``n^2``.
        With ``x = (sI - A)^{-1} B`` and ``y = (sI - A)^{-T} C`` as computed, ``C x + y^T (B - (sI - A) x)`` is in error
        by the product of the errors of ``x`` and ``y`` and by the rounding of the residual.
        """
        frequencies = np.atleast_1d(np.asarray(omega, dtype=float))
        points = 1j * frequencies if self.dt is None else np.exp(1j * frequencies * float(self.dt))
        values, error = self._values(points.ravel())
        if not np.isfinite(values).all():
            at = frequencies.ravel()[np.argmin(np.isfinite(values))]
            raise InputError(f"omega = {at:g} rad/s is at a pole of the block; leave that frequency out")
        return FrequencyData(frequencies, values, self.dt, error)

    def to_control(self) -> control.StateSpace:
        """The block as a ``control.StateSpace``."""
        return control_system((self.A, self.B, self.C, self.D), self.names, dt=self.period)

    def __str__(self) -> str:
        time = "continuous time" if self.dt is None else f"discrete time, dt = {float(self.dt):g}"
        return f"state space of order {self.order} in {time}"

    @cached_property
    def _forms(self) -> tuple[ControllerForm, ControllerForm]:
        return ControllerForm.of(self.A, self.B), ControllerForm.of(self.A.T, self.C)

    def _values(self, points: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """``H`` at the points (m,) and the estimate of its error (m,)."""
        values, errors = np.empty(points.size, dtype=complex), np.empty(points.size)
        size, step = np.abs(self.A), max(_BATCH_ENTRIES // self.order, 1)
        for first in range(0, points.size, step):
            batch = slice(first, first + step)
            values[batch], errors[batch] = self._batch(points[batch], size)
        return values, errors

    def _batch(
        self, s: NDArray[np.complex128], size: NDArray[np.float64]
    ) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        forward, adjoint = self._forms
        x, y = forward.solutions(s), adjoint.solutions(s)
        known = np.isfinite(y).all(
            axis=0
        )  # else s is an eigenvalue to rounding: one of a state out of reach, if x is finite
        y = np.where(known, y, 0)
        with np.errstate(all="ignore"):
            moved = (self.A @ x.view(np.float64)).view(np.complex128)
            residual = self.B[:, None] - s * x + moved
            correction = np.einsum("ij,ij->j", y, residual)
            magnitude = np.abs(x)
            scale = size @ magnitude + np.abs(s) * magnitude + np.abs(self.B)[:, None]
            rounding = 4 * _UNIT * np.einsum("ij,ij->j", np.abs(y), scale)
            values = self.C @ x + correction + self.D
        return values, np.where(known, rounding + _UNIT * np.abs(values), np.inf)
