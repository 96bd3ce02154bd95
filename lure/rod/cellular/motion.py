"""Motions of cellular networks through scipy, with the detection of rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, demand_whole
from lure.record import Column, Page, Record, described, plain, quantity
from lure.rod import datasets
from lure.rod.cellular.network import CellularNetwork, Signal
from lure.rod.datasets import SampledMotion

if TYPE_CHECKING:
    import control

# What Chua and Yang's energy says about a network, and under which hypotheses.


class ChuaYang(Record):
    r"""Whether the hypotheses of Chua and Yang's convergence theorem hold.

    With the saturating output (41), constant bias and input, ``T^C`` diagonal and positive and ``T^A``, laid over the
    grid with its boundary, symmetric,

    .. math:: V(x) = -\tfrac12 f^T T^A f + \tfrac12 \sum_i C_i f_i^2 - w^T f, \qquad f = f(x), \quad w = B u + I,

    satisfies ``V' = - sum over |x_i| < 1 of (x_i')^2 <= 0`` and is bounded.  Every motion is bounded, and it converges
    to an equilibrium if the equilibria are isolated.  If moreover ``T^A_ii > C_i``, no cell of a stable equilibrium has
    ``|x_i| < 1``: the outputs are -1 or +1.  Nothing follows where a hypothesis fails; such a network may oscillate.


    References
    ----------
    L. O. Chua, L. Yang, "Cellular neural networks: theory", IEEE Trans. Circuits Syst. 35 (1988) 1257-1272, Theorems
    3-5.
    """

    obstacle: str | None = quantity("The first hypothesis that fails, in words; None if all hold")
    binary: bool = quantity("Whether ``T^A_ii > C_i`` for all cells. Says something only where ``obstacle`` is None")

    @property
    def holds(self) -> bool:
        """Whether the hypotheses that were checked hold; that equilibria are isolated is not checked."""
        return self.obstacle is None

    def require(self) -> ChuaYang:
        """Itself if :attr:`holds`.

        Raises
        ------
        AssumptionError
            It does not; the message is the hypothesis that fails.
        """
        if self.obstacle is not None:
            raise AssumptionError(f"Chua and Yang's theorem does not apply: {self.obstacle}")
        return self

    def __str__(self) -> str:
        if self.obstacle is not None:
            return f"Chua and Yang's theorem says nothing: {self.obstacle}."
        outputs = "; at a stable one every output is -1 or +1" if self.binary else ""
        return (
            "Templates are symmetric and the decay positive: the energy of Chua and Yang falls, and every motion under "
            f"constant input converges to an equilibrium if the equilibria are isolated{outputs}."
        )


def chua_yang(network: CellularNetwork) -> ChuaYang:
    """Check the hypotheses of Chua and Yang's theorem on the interconnections of a network.

    Parameters
    ----------
    network : CellularNetwork
        The network; inputs are taken to be constant.

    Examples
    --------
    >>> from lure.rod.cellular import edge_network
    >>> chua_yang(edge_network((3, 3))).holds
    True
    """
    n = network.size
    feedback, decay = network.feedback[:, :n].tocsr(), network.decay[:, :n].tocsr()
    own, difference = decay.diagonal(), abs(feedback - feedback.T)
    binary = bool((feedback.diagonal() > own).all())
    obstacle = None
    if network.output != "saturation":
        obstacle = "the output is not the saturation (41)"
    elif not network.autonomous:
        obstacle = "the bias changes in time"
    elif (network.decay.tocoo().coords[0] != network.decay.tocoo().coords[1]).any() or not (own > 0.0).all():
        obstacle = "the decay of a cell must be a positive multiple of its own state"
    elif difference.max() > 0.0:
        obstacle = f"the feedback is not symmetric; two of its weights differ by {difference.max():.6g}"
    return ChuaYang(obstacle=obstacle, binary=binary)


def chua_yang_energy(network: CellularNetwork, x: ArrayLike, u: Signal = 0.0) -> float:
    """The energy ``V`` of :class:`ChuaYang` at the states ``x`` under the constant inputs ``u``.

    Parameters
    ----------
    network : CellularNetwork
        A network to which the theorem applies.
    x : array_like
        States, an array of the shape of the grid.
    u : float or array_like
        Inputs.

    Raises
    ------
    AssumptionError
        A hypothesis fails, or the inputs are a function of time.
    """
    chua_yang(network).require()
    if callable(u):
        raise AssumptionError("Chua and Yang's theorem does not apply: the input changes in time")
    n, f = network.size, network.outputs(x).ravel()
    quadratic = network.decay[:, :n].diagonal() @ f**2 - f @ (network.feedback[:, :n] @ f)
    return float(0.5 * quadratic - network.drive(0.0, u) @ f)


STATE, TIME = "unit of the states of the network", "unit of time in which the templates are rates"
_SOURCE = (
    'L. O. Chua, L. Yang, "Cellular neural networks: theory", IEEE Trans. Circuits Syst. 35 (1988) 1257-1272; '
    "as equation (40) of Danciu, Matei, Micu, Roventa has it"
)
_METHOD = "integrated by scipy, relative tolerance 1e-10 a step"
_RELATIVE, _ABSOLUTE = 1e-10, 1e-13
_STIFF = 2e4  # fastest rate times span, beyond which an implicit method is used


class CellularMotion(SampledMotion):
    """A computed motion of a cellular network: OBSERVED evidence."""

    _subject: ClassVar[str] = "cellular network"
    _heading: ClassVar[str] = "Motion of a cellular network"

    t: Array = quantity(
        "time since the start; the last is the end of the run, earlier than asked for if the network came to rest",
        TIME,
        dims="t",
    )
    x: Array = quantity("``(k, *shape)`` states", key="state_end", plainly=lambda x: plain(x[-1]))
    output: Array = quantity("``(k, *shape)`` outputs ``f(x)``", key="output_end", plainly=lambda f: plain(f[-1]))
    rate: float = quantity("largest ``|x'|`` at the end", f"{STATE} / {TIME}", dims="", key="rate")
    steady: bool | None = quantity(
        "Whether the run ended because ``rate`` fell to the level asked for; None where bias or input change in "
        "time and rest was not looked for. It does not prove convergence: a state that passes a saddle slowly "
        "enough, or was placed on an unstable equilibrium, looks the same"
    )

    @property
    def about(self) -> str:
        """Which object moves, in words."""
        return f"the cellular network of {' x '.join(map(str, self.x.shape[1:]))} cells"

    @property
    def how(self) -> str:
        """How the motion was computed."""
        return _METHOD

    @property
    def rest(self) -> str:
        """Whether the network looks at rest at the end, in words."""
        if self.steady is None:
            return "not looked for: bias or input change in time"
        return "looks at rest, which does not prove convergence" if self.steady else "still moving"

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion, with the last states, as plain JSON data; the curves are in :meth:`to_xarray`."""
        return super().to_dict() | {"shape": list(self.x.shape[1:])}

    def _columns(self) -> dict[str, Column]:
        """States and outputs along ``t`` and ``cell``, or ``row`` and ``column``."""
        cells = ("cell",) if self.x.ndim == 2 else ("row", "column")
        numbers = zip(cells, self.x.shape[1:], strict=True)
        return super()._columns() | {
            "x": Column(("t", *cells), self.x, STATE, "state x of each cell"),
            "output": Column(("t", *cells), self.output, STATE, "output f(x) of each cell"),
            **{name: Column((name,), np.arange(n), "1", f"number of the {name}, from 0") for name, n in numbers},
        }

    def _attributes(self) -> dict[str, object]:
        return {**super()._attributes(), "references": _SOURCE, "rest": self.rest}

    def to_control(self) -> control.TimeResponseData:
        """The outputs of all cells, row by row, as python-control has them; no inputs."""
        labels = [f"f(x[{', '.join(map(str, index))}])" for index in np.ndindex(self.x.shape[1:])]
        flat = self.output.reshape(self.t.size, -1).T
        return datasets.time_response(self.about, self.t, dict(zip(labels, flat, strict=True)), {})

    def _page(self) -> Page:
        last = self.output[-1]
        rows = [
            ("what moved", self.about),
            ("time", f"0 to {self.t[-1]:g} ({TIME}), {self.t.size} samples"),
            ("outputs at the end", f"{last.min():.6g} to {last.max():.6g}"),
            ("largest |x'| at the end", f"{self.rate:.2g}"),
            ("rest", self.rest),
        ]
        return Page("motion of a cellular network", rows, verdict="OBSERVED", notes=(self.comment,))


@described(frozen=True, kw_only=True, slots=True)
class Request:
    """How long to follow a network, at how many instants, and how slow is rest; see :meth:`CellularNetwork.simulate`.

    Raises
    ------
    InputError
        The time or the rate is not a positive number, or there are fewer than two samples.
    """

    until: float = quantity("Longest time")
    samples: int = quantity("Number of instants kept")
    at_rest: float = quantity("Largest rate of change at rest")

    def __post_init__(self) -> None:
        if not 0.0 < self.until < math.inf:
            raise InputError(f"simulate: until is {self.until!r}; give a positive number")
        demand_whole("simulate: samples", self.samples, 2)
        if not 0.0 < self.at_rest < math.inf:
            raise InputError(f"simulate: at_rest is {self.at_rest!r}; give a positive rate")


def motion(network: CellularNetwork, x0: ArrayLike, u: Signal, request: Request) -> CellularMotion:
    """The motion of a network; see :meth:`CellularNetwork.simulate`.

    ``x0``: initial states; ``u``: inputs; ``request``: how long to follow it.

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
