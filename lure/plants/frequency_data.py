"""Values of a transfer function at a list of frequencies: all that is known of a measured block."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.rational import time_text
from lure.record import Record, derived, quantity

if TYPE_CHECKING:
    import control


class FrequencyData(Record, kw_only=False):
    r"""``H(i omega)``, in discrete time ``H(e^{i omega dt})``, at finitely many frequencies and nowhere else.

    Between and beyond the frequencies ``H`` is unknown, and so are its poles: a criterion evaluated on such data is
    observed or computed at these frequencies and certifies nothing.  The type has no ``transfer`` for that reason.

    Parameters
    ----------
    omega : array_like
        (m,) frequencies [rad/s], nonnegative and increasing.
    response : array_like
        (m,) complex values [unit of sigma / unit of mu].
    dt : Fraction or None
        Sampling time [s]; None for continuous time.
    error : array_like or None
        (m,) estimate of the error of ``response``; None where nothing is known of it.

    Raises
    ------
    InputError
        Shapes do not fit, a frequency is negative, not finite or not larger than the one before, or a value is nan.

    Examples
    --------
    >>> import numpy as np
    >>> omega = np.geomspace(0.1, 10, 5)
    >>> measured = FrequencyData(omega=omega, response=1 / (1 + 1j * omega))
    >>> print(measured.dt)
    None
    """

    omega: NDArray[np.float64] = quantity("frequency", "rad/s", dims="omega", key="omega")
    response: NDArray[np.complex128] = quantity("", key="")
    dt: Fraction | None = None
    error: NDArray[np.float64] | None = quantity(
        "estimate of the error of H", "1", dims="omega", key="error", default=None
    )
    _kind, _said = "frequency data", "text"
    _title = "H at a list of frequencies"
    _notes = ("Nothing is known between and beyond them: what follows is observed, and proves nothing.",)

    def __post_init__(self) -> None:
        omega, response = _copied(self.omega, "omega", float), _copied(self.response, "response", complex)
        if omega.ndim != 1 or response.shape != omega.shape or not omega.size:
            raise InputError(
                f"FrequencyData needs omega (m,) and response (m,) with m >= 1; got {omega.shape} and {response.shape}"
            )
        if not (np.isfinite(omega).all() and omega[0] >= 0 and (np.diff(omega) > 0).all()):
            raise InputError("FrequencyData.omega must be finite, nonnegative and increasing; sort the frequencies")
        if np.isnan(response).any():
            raise InputError("FrequencyData.response has an entry that is nan; leave that frequency out")
        object.__setattr__(self, "omega", omega)
        object.__setattr__(self, "response", response)
        if self.error is not None:
            error = _copied(self.error, "error", float)
            if error.shape != omega.shape:
                raise InputError(f"FrequencyData.error has the shape {error.shape}; give one value for each frequency")
            object.__setattr__(self, "error", error)

    def to_control(self) -> control.FrequencyResponseData:
        """The same data as a ``control.FrequencyResponseData``."""
        import control

        return control.FrequencyResponseData(self.response, self.omega, dt=0 if self.dt is None else float(self.dt))

    def __str__(self) -> str:
        low, high = self.omega[0], self.omega[-1]
        return f"{self.omega.size} values of H from {low:.6g} to {high:.6g} rad/s"

    @property
    @derived("1", dims="omega", key="real")
    def real(self) -> NDArray[np.float64]:
        """Re H."""
        return self.response.real

    @property
    @derived("1", dims="omega", key="imag")
    def imag(self) -> NDArray[np.float64]:
        """Im H."""
        return self.response.imag

    def _attributes(self) -> dict[str, object]:
        return {"comment": str(self), "time": time_text(self.dt)}

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "time", time_text(self.dt)
        yield "frequencies", self.omega.size
        yield "from", f"{self.omega[0]:.6g} rad/s"
        yield "to", f"{self.omega[-1]:.6g} rad/s"


def _copied(values: ArrayLike, name: str, kind: type) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.array(values, dtype=kind)
    except (TypeError, ValueError) as error:
        raise InputError(f"FrequencyData.{name} is not an array of numbers ({error}); give numbers") from None
    array.setflags(write=False)
    return array
