"""Linear blocks with a control input, a load and one measured output."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, ClassVar, Protocol

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.record import Record, derived, plain, quantity

if TYPE_CHECKING:
    import control
    from scipy.sparse import csr_array


class Plant(Protocol):
    """Anything with a scalar transfer function from ``mu`` to ``sigma``."""

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)`` at complex ``s`` [1/s], elementwise."""


class StructuredPlant(ABC):
    """A plant in continuous time of whose structure more is known than of its transfer function, such as a rod.

    What can be said of it is registered for its type as ``theory``, see
    ``lure.analysis.certificates.theory``; of the plant itself everybody may use what stands here.
    """

    dt: ClassVar[None] = None

    @property
    @abstractmethod
    def name(self) -> str:
        """What it is, for people, with its article."""

    @property
    @abstractmethod
    def order(self) -> int | None:
        """Number of states; None for infinitely many."""

    @abstractmethod
    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)`` at complex ``s`` [1/s], elementwise."""

    @abstractmethod
    def certificate_system(self) -> Mapping[str, object]:
        """The plant as a certificate states it: its kind and its exact parameters, as text ``p/q``."""


class LinearBlock(Record, kw_only=False):
    r"""A finite block ``y' = A y + b1 mu + b2 g``, ``sigma = c^T y``, with ``H(s) = c^T (sI - A)^{-1} b1``.

    In a loop ``mu = -phi(sigma)``: the sign is in :class:`lure.loop.Loop` and nowhere else.

    Parameters
    ----------
    A : array_like or scipy.sparse array
        (n, n) [1/s]; kept as an array or as a ``csr_array``.  Like the vectors it is copied and cannot be written to.
    b1 : ndarray
        (n,) input of the nonlinearity.
    b2 : ndarray
        (n,) input of the load.
    c : ndarray
        (n,) output.

    Raises
    ------
    InputError
        Shapes do not fit, or an entry is not a finite real number.
    """

    A: NDArray[np.float64] | csr_array = quantity(
        "",
        plainly=lambda A: plain(_dense(A)),
        form=lambda A: f"sparse, {A.nnz} entries" if hasattr(A, "nnz") else "dense",
    )
    b1: NDArray[np.float64] = quantity("", label="")
    b2: NDArray[np.float64] = quantity("", label="")
    c: NDArray[np.float64] = quantity("", label="")
    _kind = "linear block"
    _title = "y' = A y + b1 mu + b2 g, sigma = c^T y"
    _notes = ("In a loop mu = -phi(sigma).",)

    def __post_init__(self) -> None:
        for name in ("A", "b1", "b2", "c"):
            object.__setattr__(self, name, frozen(getattr(self, name), f"LinearBlock.{name}", sparse=name == "A"))
        n = self.b1.shape[0] if self.b1.ndim == 1 else -1
        if self.A.shape != (n, n) or self.b2.shape != (n,) or self.c.shape != (n,) or n == 0:
            shapes = f"A {self.A.shape}, b1 {self.b1.shape}, b2 {self.b2.shape}, c {self.c.shape}"
            raise InputError(f"LinearBlock needs A (n, n), b1 (n,), b2 (n,), c (n,) with n >= 1; got {shapes}")

    @property
    @derived(label="states")
    def order(self) -> int:
        """Number of states ``n``."""
        return int(self.b1.shape[0])

    def dense(self) -> NDArray[np.float64]:
        """``A`` as an (n, n) array [1/s]."""
        return _dense(self.A)

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)`` by one sparse solve a point; not finite where a pivot of ``sI - A`` is exactly zero."""
        from scipy.sparse import csc_array, eye_array
        from scipy.sparse.linalg import splu

        points = np.asarray(s, dtype=complex)
        values = np.empty(points.size, dtype=complex)
        A, identity = csc_array(self.A), eye_array(self.order, format="csc")
        for i, point in enumerate(points.ravel()):
            try:
                values[i] = self.c @ splu((point * identity - A).tocsc()).solve(self.b1.astype(complex))
            except RuntimeError:  # splu: the factor is exactly singular
                values[i] = complex(np.inf, np.nan)
        return values.reshape(points.shape)

    def to_control(self) -> control.StateSpace:
        """The block from ``mu`` to ``sigma`` as a ``control.StateSpace`` (dense)."""
        import control

        return control.StateSpace(self.dense(), self.b1[:, None], self.c[None, :], 0.0)

    def frequency_response(self, omega: ArrayLike) -> control.FrequencyResponseData:
        """``H(i omega)`` at ``omega`` [rad/s], computed by python-control from the matrices."""
        import control

        return control.frequency_response(self.to_control(), np.atleast_1d(np.asarray(omega, dtype=float)))

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield from super()._rows()
        yield "time", "continuous"


def _dense(A: NDArray[np.float64] | csr_array) -> NDArray[np.float64]:
    return np.asarray(A.toarray() if hasattr(A, "toarray") else A)


def frozen(values: ArrayLike | csr_array, name: str, *, sparse: bool = False) -> NDArray[np.float64] | csr_array:
    """A copy in double precision that cannot be written to; one that is sparse may stay so.

    Raises
    ------
    InputError
        It is no array of finite real numbers; the sentence begins with its name.
    """
    try:
        if sparse and hasattr(values, "tocsr"):
            from scipy.sparse import csr_array

            matrix = csr_array(values)
            matrix = csr_array((_real(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape, copy=True)
            matrix.sum_duplicates()
            entries = matrix.data
        else:
            entries = matrix = _real(values).copy()
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} is not an array of real numbers ({error}); give numbers") from None
    if not np.isfinite(entries).all():
        raise InputError(f"{name} has an entry that is not finite; give finite numbers")
    entries.setflags(write=False)
    return matrix


def _real(values: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(values)
    if array.dtype.kind not in "iufO":
        raise TypeError(f"its entries are {array.dtype}")
    return array.astype(float)
