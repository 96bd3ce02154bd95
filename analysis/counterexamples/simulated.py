"""Closed loops simulated from any state: to confirm a verdict or to contradict it, never to prove one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import cast

from lure.analysis.counterexamples.linear import Realisation, companion, realisation
from lure.analysis.counterexamples.piecewise import Flow, PiecewiseLoop
from lure.analysis.verdict import Witness
from lure.arrays import ArrayLike, Reals, in_doubles, integrate, np, optimize
from lure.errors import InputError, Reason
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# What ``sigma`` does along a periodic orbit of a witness, for figures.

SAMPLES = 1201


def orbit_of(block: Plant, witness: Witness) -> tuple[Reals, Reals]:
    """One period of the orbit of a witness: times and ``sigma``, in doubles.

    Parameters
    ----------
    block : RationalPlant or (A, b, c)
        The block that the witness was found for.
    witness : Witness
        Of kind ``periodic orbit``.

    Returns
    -------
    t, sigma : ndarray
        In continuous time [s], from the first state of the record over one period; in discrete time the numbers of the
        samples, with the first sample once more at the end.

    Raises
    ------
    InputError
        The witness is no periodic orbit, or the block is not the one it was found for.
    """
    if witness.kind != "periodic orbit":
        raise InputError(f"there is no orbit to draw: the witness is a {witness.kind}; give one of a periodic orbit")
    data, discrete = witness.data, isinstance(block, RationalPlant) and block.dt is not None
    if discrete != ("sigma" in data):
        kind = "discrete" if "sigma" in data else "continuous"
        raise InputError(f"the orbit of the witness is in {kind} time; give the block that it was found for")
    if discrete:
        visited = [float(Fraction(value)) for value in cast("Sequence[str]", data["sigma"])]
        return np.arange(len(visited) + 1, dtype=float), np.array([*visited, visited[0]])
    state, period = cast("Sequence[float]", data["state"]), cast("float", data["period"])
    motion = simulate_loop(block, nonlinearity_entry(witness), state, period, samples=SAMPLES)
    miss = float(np.abs(motion.states[-1] - motion.states[0]).max() / np.abs(motion.states[0]).max())
    if not miss < 1e-3:  # far above what rounding does in one period, far below what another block does
        raise InputError("the solution does not close after the period of the witness; give the block it was found for")
    return motion.t, motion.sigma


def orbit_start(block: RationalPlant, witness: Witness) -> tuple[Reals, float]:
    """(n,) a state on the orbit of a witness, in the companion form of the block, and the period [s].

    ``block``: the block that the witness was found for; ``witness``: of kind ``periodic orbit``.
    """
    data = witness.data
    if block.dt is None:
        return np.array(cast("Sequence[float]", data["state"]), dtype=float), cast("float", data["period"])
    system, nonlinearity = companion(block), nonlinearity_entry(witness)
    A, b = in_doubles(system.A), np.array([float(v) for v in system.b])
    driven, period = np.zeros(block.order), np.eye(block.order)
    visited = cast("Sequence[str]", data["sigma"])
    for value in visited:
        driven, period = A @ driven - b * float(nonlinearity.exact(Fraction(value))), A @ period
    state = np.asarray(np.linalg.lstsq(np.eye(block.order) - period, driven, rcond=None)[0])
    return state, len(visited) * float(block.dt)


def nonlinearity_entry(witness: Witness) -> Graph:
    """The piecewise-linear nonlinearity of a periodic orbit.

    ``witness``: with ``points`` in its data, and the slopes beyond them where they are not 0.
    """
    points = [(Fraction(x), Fraction(y)) for x, y in cast("Sequence[Sequence[str]]", witness.data["points"])]
    return Graph.through(points, *(Fraction(str(witness.data.get(side, 0))) for side in ("left_slope", "right_slope")))


Characteristic = Callable[[ArrayLike], Reals] | Graph
Plant = RationalPlant | tuple[ArrayLike, ArrayLike, ArrayLike]

SIMULATED_SAMPLES = 2000
RTOL = 1e-10
RESIDUAL = 1e-9
"""Largest residual of ``sigma + D phi(sigma) = y`` relative to its terms; above it there is no solution."""


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Motion:
    """A simulated solution of ``sigma = H mu``, ``mu = -phi(sigma)``: OBSERVED evidence."""

    t: Reals = quantity("(samples,) instants [s], or steps times ``dt`` in discrete time")
    sigma: Reals = quantity("(samples,)")
    states: Reals = quantity("(samples, n), in the companion form of the block, or in the coordinates given")
    error: float = quantity(
        "Difference of the last state from a less accurate run, relative to the largest state; 0 where the method is "
        "exact up to rounding"
    )
    note: str = quantity("The method and what its accuracy rests on")


def simulate_loop(
    block: Plant, nonlinearity: Characteristic, x0: ArrayLike, until: float, *, samples: int = SIMULATED_SAMPLES
) -> Motion:
    """The solution from ``x0``.

    Parameters
    ----------
    block : RationalPlant or (A, b, c)
        The linear part; matrices without feedthrough.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``, elementwise.  A piecewise-linear nonlinearity (a ``Graph``, or a ``graph`` attribute) is followed
        exactly from kink to kink; any other by an integrator of order 8 with relative tolerance 1e-10.
    x0 : array_like
        (n,) first state.
    until : float
        Last instant [s].
    samples : int
        Number of instants recorded, in continuous time.

    Raises
    ------
    InputError
        The shapes do not fit, ``until`` is not positive, or ``sigma + D phi(sigma)`` does not take a value it has to.

    Examples
    --------
    >>> from lure import RationalPlant, Saturation
    >>> found = simulate_loop(RationalPlant([1], [1, 3, 2, 0]), Saturation(gain=3), [1, 0, 0], until=40.0)
    >>> print(f"sigma({found.t[-1]:.0f}) = {found.sigma[-1]:.5f}, from {found.sigma[0]:.0f}: observed, no proof")
    sigma(40) = -0.00051, from 1: observed, no proof
    """
    dt = float(block.dt) if isinstance(block, RationalPlant) and block.dt is not None else None
    return solution(realisation(block), nonlinearity, x0, until, dt=dt, samples=samples)


def solution(  # noqa: PLR0913  (equations, nonlinearity, from where, how far, and two settings)
    system: Realisation, nonlinearity: Characteristic, x0: ArrayLike, until: float, *, dt: float | None, samples: int
) -> Motion:
    """The same for state equations.

    Parameters
    ----------
    system : Realisation
        The equations.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``.
    x0 : array_like
        (n,) first state.
    until : float
        Last instant [s].
    dt : float or None
        Sampling time [s]; None in continuous time.
    samples : int
        Number of instants recorded, in continuous time.

    Raises
    ------
    InputError
        As for :func:`simulate_loop`.
    """
    start = np.asarray(x0, dtype=float).ravel()
    if start.shape != (system.order,) or not np.isfinite(start).all():
        raise InputError(f"x0 has shape {start.shape}; give {system.order} finite numbers")
    if not 0 < until < math.inf:
        raise InputError(f"until is {until:g}; give a positive time")
    graph = graph_of(nonlinearity)
    if dt is not None:
        return _recursion(system, nonlinearity, start, until, dt)
    instants = np.linspace(0.0, until, samples)
    if graph is not None and not graph.is_line:
        return followed(PiecewiseLoop.of(system, graph), start, instants)
    return _integrated(system, nonlinearity, start, instants)


def graph_of(nonlinearity: Characteristic) -> Graph | None:
    """The piecewise-linear graph of a nonlinearity, if it has one."""
    graph = nonlinearity if isinstance(nonlinearity, Graph) else getattr(nonlinearity, "graph", None)
    return graph if isinstance(graph, Graph) else None


def followed(loop: PiecewiseLoop, start: Reals, instants: Reals) -> Motion:
    """The solution of a loop with a piecewise-linear nonlinearity, followed exactly from kink to kink.

    ``start``: (n,) first state; ``instants``: (samples,) ascending, from 0 [s].
    """
    flow = Flow(loop)
    passages = flow.passages(start, float(instants[-1]))
    states = np.full((len(instants), flow.order), np.nan)
    begins = np.array([p.start for p in passages])
    for i, passage in enumerate(passages):
        end = begins[i + 1] if i + 1 < len(passages) else passage.start + passage.duration
        inside = np.flatnonzero((instants >= passage.start) & (instants <= end))
        if len(inside):
            states[inside] = flow.states_at(passage, instants[inside] - passage.start)
    y = states @ flow.row[:-1]
    note = "piecewise exact flow in doubles, switches located on its Taylor polynomial"
    return Motion(
        t=instants, sigma=_sigma(loop.nonlinearity, float(loop.system.d), y), states=states, error=0.0, note=note
    )


def _integrated(system: Realisation, nonlinearity: Characteristic, start: Reals, instants: Reals) -> Motion:
    A, b, c, d = _floats(system)

    def velocity(_: float, x: Reals) -> Reals:
        """Right-hand side of the closed loop."""
        return A @ x - b * _phi(nonlinearity, d, float(c @ x))[1]

    size = max(float(np.abs(start).max()), 1e-12)
    ends = []
    for rtol in (RTOL, 100 * RTOL):
        span = (0.0, float(instants[-1]))
        run = integrate.solve_ivp(
            velocity, span, start, method="DOP853", t_eval=instants, rtol=rtol, atol=rtol * 1e-3 * size
        )
        ends.append(run)
    fine, rough = ends
    states = np.full((len(instants), len(start)), np.nan)
    states[: fine.y.shape[1]] = fine.y.T
    complete = fine.status == 0 and rough.status == 0
    error = float(np.abs(fine.y[:, -1] - rough.y[:, -1]).max() / np.abs(fine.y).max()) if complete else math.inf
    note = (
        "Dormand-Prince of order 8, relative tolerance 1e-10" if complete else f"the integrator gave up: {fine.message}"
    )
    sigma = np.array([_phi(nonlinearity, d, float(value))[0] for value in states @ c])
    return Motion(t=instants, sigma=sigma, states=states, error=error, note=note)


def _recursion(system: Realisation, nonlinearity: Characteristic, start: Reals, until: float, dt: float) -> Motion:
    A, b, c, d = _floats(system)
    count = int(until / dt) + 1
    states, sigma = np.empty((count, len(start))), np.empty(count)
    x = start
    with np.errstate(over="ignore", invalid="ignore"):
        for i in range(count):
            states[i] = x
            sigma[i], phi = _phi(nonlinearity, d, float(c @ x))
            x = A @ x - b * phi
    note = "recursion in doubles"
    return Motion(t=np.arange(count, dtype=float) * dt, sigma=sigma, states=states, error=0.0, note=note)


def _floats(system: Realisation) -> tuple[Reals, Reals, Reals, float]:
    b, c = (np.array([float(v) for v in side]) for side in (system.b, system.c))
    return in_doubles(system.A), b, c, float(system.d)


def _phi(nonlinearity: Characteristic, d: float, y: float) -> tuple[float, float]:
    """``sigma`` and ``phi(sigma)`` with ``sigma + d phi(sigma) = y``."""
    if d == 0 or not math.isfinite(y) or y == 0:
        return y, float(nonlinearity(y))
    root = bracketed_root(nonlinearity, d, y)
    if math.isnan(root):
        raise InputError(
            f"the loop is not well posed: sigma + {d:g} phi(sigma) = {y:.6g} has no solution", code=Reason.ILL_POSED
        )
    return root, float(nonlinearity(root))


def bracketed_root(nonlinearity: Characteristic, d: float, y: float) -> float:
    """A root of ``sigma + d phi(sigma) = y``, its residual checked; NaN where none is found.

    Parameters
    ----------
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``; where it jumps, the two sides of the equation may pass each other without meeting.
    d : float
        Feedthrough.
    y : float
        Right-hand side.
    """

    def excess(sigma: float) -> float:
        """Left-hand side less the right-hand side."""
        return sigma + d * float(nonlinearity(sigma)) - y

    reach = abs(y) or 1e-300
    with np.errstate(over="ignore", invalid="ignore"):
        while math.isfinite(reach) and excess(reach) * excess(-reach) > 0:
            reach *= 2
        if not (math.isfinite(reach) and excess(reach) * excess(-reach) <= 0):
            return math.nan
    for absolute in (max(1e-15 * abs(y), 5e-324), 5e-324):  # of a steep nonlinearity the root is much smaller than y
        root = float(optimize.brentq(excess, -reach, reach, xtol=absolute, rtol=1e-14, maxiter=2000))
        if abs(excess(root)) <= RESIDUAL * (abs(root) + abs(d * float(nonlinearity(root))) + abs(y)):
            return root
    return math.nan


def _sigma(nonlinearity: Graph, d: float, y: Reals) -> Reals:
    if d == 0:
        return np.asarray(y, dtype=float)
    points = sorted(nonlinearity.knots)
    levels = np.array([float(x + Fraction(d) * nonlinearity.exact(x)) for x in points])
    piece = np.searchsorted(levels, y)
    anchor = np.clip(piece, 0, len(points) - 1)
    slopes = np.array([1 + d * float(s) for s in nonlinearity.slopes])
    return np.asarray(np.array([float(x) for x in points])[anchor] + (y - levels[anchor]) / slopes[piece])
