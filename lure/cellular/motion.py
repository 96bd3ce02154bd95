"""Motions of cellular networks through scipy, with the detection of rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.cellular.network import CellularNetwork, Signal
from lure.errors import InputError

if TYPE_CHECKING:
    import control
    import xarray

Array: TypeAlias = NDArray[np.float64]

_RELATIVE, _ABSOLUTE = 1e-10, 1e-13
_STIFF = 2e4  # fastest rate times span, beyond which an implicit method is used


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class CellularMotion:
    """A computed motion of a cellular network: OBSERVED evidence.

    Attributes
    ----------
    t : ndarray
        (k,) instants; the last is the end of the run, earlier than asked for if the network came to rest.
    x : ndarray
        ``(k, *shape)`` states.
    output : ndarray
        ``(k, *shape)`` outputs ``f(x)``.
    rate : float
        Largest ``|x'|`` at the end.
    steady : bool or None
        Whether the run ended because ``rate`` fell to the level asked for; None where bias or input change in time and
        rest was not looked for.  It does not prove convergence: a state that passes a saddle slowly enough, or was
        placed on an unstable equilibrium, looks the same.
    """

    t: Array
    x: Array
    output: Array
    rate: float
    steady: bool | None

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion, with the last states, as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.cellular.export import motion_dict

        return motion_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """States and outputs as an ``xarray.Dataset`` along ``t`` and ``cell``, or ``row`` and ``column``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.cellular.export import motion_dataset

        return motion_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The outputs of all cells, row by row, as python-control has them; no inputs."""
        from lure.cellular.export import motion_response

        return motion_response(self)

    def _repr_html_(self) -> str:
        from lure.cellular.export import motion_html

        return motion_html(self)


@dataclass(frozen=True, kw_only=True, slots=True)
class Request:
    """How long to follow a network, at how many instants, and how slow is rest; see :meth:`CellularNetwork.simulate`.

    Attributes
    ----------
    until : float
        Longest time.
    samples : int
        Number of instants kept.
    at_rest : float
        Largest rate of change at rest.

    Raises
    ------
    InputError
        The time or the rate is not a positive number, or there are fewer than two samples.
    """

    until: float
    samples: int
    at_rest: float

    def __post_init__(self) -> None:
        if not 0.0 < self.until < math.inf:
            raise InputError(f"simulate: until is {self.until!r}; give a positive number")
        if isinstance(self.samples, bool) or not isinstance(self.samples, int) or self.samples < 2:
            raise InputError(f"simulate: samples is {self.samples!r}; give a whole number of at least 2")
        if not 0.0 < self.at_rest < math.inf:
            raise InputError(f"simulate: at_rest is {self.at_rest!r}; give a positive rate")


def motion(network: CellularNetwork, x0: ArrayLike, u: Signal, request: Request) -> CellularMotion:
    """The motion of a network; see :meth:`CellularNetwork.simulate`.

    Parameters
    ----------
    network : CellularNetwork
        The network.
    x0 : array_like
        Initial states.
    u : float, array_like or function of t
        Inputs.
    request : Request
        How long to follow it.

    Raises
    ------
    InputError
        The initial states do not fit the grid, or the integration fails.

    Notes
    -----
    Dormand and Prince's method of order 8, or Radau's of order 5 with the sparse Jacobian where the span holds more
    than 20 000 of the shortest time constants and the output is a named one.  Relative tolerance 1e-10 a step.
    """
    from scipy.integrate import solve_ivp

    start = network.signal(x0, 0.0, "x0").ravel().copy()
    still = network.autonomous and not callable(u)
    rates = _rates(network, u, still=still)

    def unrest(t: float, x: Array) -> float:
        """How far the fastest cell is from rest."""
        return float(np.abs(rates(t, x)).max()) - request.at_rest

    unrest.terminal, unrest.direction = True, -1.0  # type: ignore[attr-defined]  # how scipy is told of an event
    times = np.linspace(0.0, request.until, request.samples)
    if still and unrest(0.0, start) <= 0.0:
        return _result(network, np.zeros(1), start[:, None], rates, steady=True)
    found = solve_ivp(
        rates,
        (0.0, request.until),
        start,
        t_eval=times,
        events=unrest if still else None,
        rtol=_RELATIVE,
        atol=_ABSOLUTE * max(1.0, float(np.abs(start).max())),
        **_method(network, request.until),
    )
    if found.status < 0 or not np.isfinite(found.y).all():
        raise InputError(f"simulate: the integration failed ({found.message}); give a shorter span or finite templates")
    t, x = found.t, found.y
    if found.status == 1 and found.t_events[0][-1] > t[-1]:
        t, x = np.append(t, found.t_events[0][-1]), np.column_stack((x, found.y_events[0][-1]))
    return _result(network, t, x, rates, steady=found.status == 1 if still else None)


def _rates(network: CellularNetwork, u: Signal, *, still: bool) -> Callable[[float, Array], Array]:
    """The right-hand side on flat states; what is constant in it is computed once."""
    n = network.size
    feedback, decay = network.feedback[:, :n].tocsr(), network.decay[:, :n].tocsr()
    constant = network.drive(0.0, u) if still else None

    def rates(t: float, x: Array) -> Array:
        """``x'``."""
        outputs = network.outputs(x.reshape(network.shape)).ravel()
        return np.asarray(feedback @ outputs - decay @ x + (network.drive(t, u) if constant is None else constant))

    return rates


def _method(network: CellularNetwork, until: float) -> dict[str, Any]:
    """Options of the integrator."""
    from scipy.sparse import diags_array

    n = network.size
    feedback, decay = network.feedback[:, :n].tocsr(), network.decay[:, :n].tocsr()
    fastest = float((abs(feedback).sum(axis=1) + abs(decay).sum(axis=1)).max())
    if callable(network.output) or fastest * until <= _STIFF:
        return {"method": "DOP853"}
    if network.output == "linear":
        return {"method": "Radau", "jac": network.matrix()}
    return {"method": "Radau", "jac": lambda t, x: feedback @ diags_array((np.abs(x) < 1.0).astype(float)) - decay}


def _result(
    network: CellularNetwork, t: Array, x: Array, rates: Callable[[float, Array], Array], *, steady: bool | None
) -> CellularMotion:
    states = x.T.reshape(t.size, *network.shape)
    outputs = np.stack([network.outputs(state) for state in states])
    rate = float(np.abs(rates(float(t[-1]), x[:, -1])).max())
    return CellularMotion(t=t, x=states, output=outputs, rate=rate, steady=steady)
