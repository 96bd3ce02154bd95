"""Values of a transfer function at a list of frequencies: all that is known of a measured block."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.rational import time_text
from lure.record import by_value, html_table, plain, xarray_or_refusal

if TYPE_CHECKING:
    import control
    import xarray


@by_value
@dataclass(frozen=True, eq=False, slots=True)
class FrequencyData:
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

    omega: NDArray[np.float64]
    response: NDArray[np.complex128]
    dt: Fraction | None = None
    error: NDArray[np.float64] | None = None

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

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: frequencies [rad/s], real and imaginary parts, and the errors where they are known."""
        return {
            "kind": "frequency data",
            "text": str(self),
            "omega": plain(self.omega),
            "real": plain(self.response.real),
            "imag": plain(self.response.imag),
            "error": plain(self.error),
            "dt": None if self.dt is None else str(self.dt),
        }

    def to_xarray(self) -> xarray.Dataset:
        """The values over ``omega``, as real variables that netCDF can hold.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        xr = xarray_or_refusal("FrequencyData.to_xarray")
        variables = {
            "real": ("omega", self.response.real, {"long_name": "Re H"}),
            "imag": ("omega", self.response.imag, {"long_name": "Im H"}),
        }
        if self.error is not None:
            variables["error"] = ("omega", self.error, {"long_name": "estimate of the error of H"})
        attributes = {"comment": str(self), "time": time_text(self.dt)}
        made: xarray.Dataset = xr.Dataset(
            variables, coords={"omega": ("omega", self.omega, {"units": "rad/s"})}, attrs=attributes
        )
        return made

    def _repr_html_(self) -> str:
        low, high = (f"{self.omega[i]:.6g} rad/s" for i in (0, -1))
        rows = [("time", time_text(self.dt)), ("frequencies", self.omega.size), ("from", low), ("to", high)]
        note = "Nothing is known between and beyond them: what follows is observed, and proves nothing."
        return html_table("H at a list of frequencies", rows, notes=[note])


def _copied(values: ArrayLike, name: str, kind: type) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.array(values, dtype=kind)
    except (TypeError, ValueError) as error:
        raise InputError(f"FrequencyData.{name} is not an array of numbers ({error}); give numbers") from None
    array.setflags(write=False)
    return array
