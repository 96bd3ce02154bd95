"""A loop tried by simulation: many solutions of a nonlinearity or of a class, judged, and held against what is proved.

The protocol.  Solutions start along the modes of the loop, where harmonic balance points and at random, at sizes chosen
by the scales of the nonlinearity, and on orbits that a search has found.  All are followed together, over stretches
that double in length, until each is decided or the evaluations granted are used up; what is then open stays open.  What
disagrees with a proof is computed again, more accurately or in exact arithmetic, and an oscillation must close under
Newton's method before it is called a contradiction: a slow decay never does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Literal

from lure.analysis.counterexamples.recheck import Run, closes, confirmed, judge, lasts, periodic, steadiness
from lure.analysis.counterexamples.simulated import Characteristic, graph_of
from lure.analysis.counterexamples.trajectories import BatchLoop, Finding, OutOfBudget, Trajectory
from lure.arrays import Reals, linalg, np
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# First states for simulations: along modes of the loop, where harmonic balance points, at scales of the nonlinearity.

DECADES = (-9.0, 9.0)
_RANDOM = 4
_AMPLITUDES = 72
_PHASES = 32


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Starts:
    """First states of a batch of solutions."""

    states: Reals = quantity(
        "(runs, n), in the coordinates of the :class:`~lure.analysis.counterexamples.trajectories.BatchLoop`"
    )
    texts: tuple[str, ...] = quantity("Each of them in words")
    large: tuple[bool, ...] = quantity(
        "Whether ``|sigma|`` is far beyond the scales of the nonlinearity, which then switches quickly and takes "
        "small steps"
    )


_SPREAD = 10.0


def scales(nonlinearity: Characteristic) -> tuple[float, ...]:
    """Values of ``|sigma|`` at which the gain ``phi(sigma)/sigma`` changes, ascending, at most three; 1 if nowhere.

    ``nonlinearity``: ``phi``; the kinks of a piecewise-linear one are exact, any other is sampled from 1e-9 to 1e9.
    """
    graph = graph_of(nonlinearity)
    if graph is not None:
        found = sorted({abs(float(x)) for x in graph.kinks if x})
    else:
        sizes = 10.0 ** np.linspace(*DECADES, 181)
        with np.errstate(all="ignore"):
            gains = np.array([np.asarray(nonlinearity(s * sizes), dtype=float) / (s * sizes) for s in (1.0, -1.0)])
            gains = np.arcsinh(np.nan_to_num(gains) / max(float(np.nan_to_num(np.abs(gains[:, 0])).min()), 1e-12))
        steps = np.abs(np.diff(gains, axis=1)).max(axis=0)
        total = np.cumsum(steps)
        if total[-1] <= 1e-9:
            return (1.0,)
        found = [float(sizes[int(np.searchsorted(total, share * total[-1]))]) for share in (0.05, 0.5, 0.95)]
        found = [min(one, _SPREAD * found[0]) for one in found]  # a gain that swings for ever has no last bend
    found = [one for one in dict.fromkeys(found) if one > 0] or [1.0]
    return tuple(dict.fromkeys((found[0], found[len(found) // 2], found[-1])))


def starts(loop: BatchLoop, knees: tuple[float, ...], gain: float, *, seed: int = 0) -> Starts:
    """States along the modes of the loop with a medium gain, where harmonic balance points, and at random.

    Each is scaled so that the linear loop with the gain ``gain`` would reach ``|sigma|`` of a chosen size: small and
    large against the scales of the nonlinearity, and near them.

    ``knees``: the scales of the nonlinearity; ``gain``: a gain of the class; ``seed``: of the random directions.
    """
    sizes = _sizes(knees)
    directions = [*_modes(loop.closed(gain)), *np.random.default_rng(seed).standard_normal((_RANDOM, loop.order))]
    response = _peaks(loop, gain)
    few = loop.order <= 3
    states, texts, large = [], [], []
    for i, direction in enumerate(directions):
        length = float(np.abs(direction).max())
        peak = float(np.abs(response @ direction).max())
        unit = direction / (peak if peak > 1e-9 * length * float(np.abs(response).max()) else length)
        for size in (sizes[i % len(sizes)], -sizes[(i + 2) % len(sizes)])[: 2 if few else 1]:
            states.append(size * unit)
            texts.append(f"|sigma| of about {abs(size):.3g}")
            large.append(abs(size) > 10 * knees[-1])
    return Starts(states=np.array(states).reshape(len(states), loop.order), texts=tuple(texts), large=tuple(large))


def balanced_starts(loop: BatchLoop, low: float, high: float) -> Starts:
    """States on the oscillations that harmonic balance suggests, or comes closest to; empty where no mode oscillates.

    For ``sigma = A sin(theta)`` the nonlinearity acts as the gain ``N(A)``; where the least damped oscillating mode of
    the loop with that gain stops to decay, or decays least, its eigenvector of amplitude ``A`` is taken.  A hint and no
    more.

    ``low``, ``high``: least and largest scale of the nonlinearity.
    """
    amplitudes = np.geomspace(0.3 * low, 300 * high, _AMPLITUDES)
    sines = np.sin((np.arange(_PHASES) + 0.5) * 2 * math.pi / _PHASES)
    with np.errstate(all="ignore"):
        values = np.asarray(loop.values((amplitudes[:, None] * sines).ravel()), dtype=float).reshape(_AMPLITUDES, -1)
        gains = 2 * (values * sines).mean(axis=1) / amplitudes
    rates, modes = np.full(_AMPLITUDES, -math.inf), np.zeros((_AMPLITUDES, loop.order), dtype=complex)
    for i, gain in enumerate(gains):
        if not math.isfinite(gain) or 1 + gain * loop.d <= 0:
            continue
        roots, vectors = np.linalg.eig(loop.closed(float(gain)))
        growth = np.log(np.maximum(np.abs(roots), 1e-300)) if loop.discrete else roots.real
        swing = np.where(np.abs(roots.imag) > 1e-6 * np.abs(roots).max(initial=0.0), growth, -math.inf)
        best = int(swing.argmax())
        rates[i], modes[i] = swing[best], vectors[:, best]
    signs = np.flatnonzero(np.sign(rates[1:]) * np.sign(rates[:-1]) < 0)
    chosen = [*signs[:3], int(rates.argmax())] if np.isfinite(rates).any() else []
    states, texts = [], []
    for i in dict.fromkeys(chosen):
        output = abs(complex(loop.c @ modes[i]) / (1 + gains[i] * loop.d))
        if output > 1e-12 * float(np.abs(modes[i]).max()):
            states.append(amplitudes[i] / output * modes[i].real)
            suggested = "an oscillation that harmonic balance suggests"
            texts.append(f"near {suggested if i in signs else 'the least damped oscillation of one harmonic'}")
    return Starts(
        states=np.array(states).reshape(len(states), loop.order),
        texts=tuple(texts),
        large=tuple(False for _ in states),
    )


def _sizes(knees: tuple[float, ...]) -> tuple[float, ...]:
    """Sizes of ``|sigma|``: below the least scale of the nonlinearity, at each, above the largest."""
    low, high = knees[0], knees[-1]
    return (0.03 * low, 1e3 * high, *(3.0 * knee for knee in knees), 30.0 * high, 0.9 * low)


def _modes(matrix: Reals) -> list[Reals]:
    """Real and imaginary parts of the eigenvectors, at most eight: slowest and fastest first."""
    roots, vectors = np.linalg.eig(matrix)
    order = np.argsort(-roots.real)
    found = [vectors[:, i] for i in order if roots[i].imag >= 0]
    parts = [part for v in found for part in ((v.real,) if np.abs(v.imag).max() < 1e-12 else (v.real, v.imag))]
    return [*parts[:4], *parts[4:][-4:]]


def _peaks(loop: BatchLoop, gain: float) -> Reals:
    """(instants, n): its product with a first state is ``sigma`` of the linear loop with this gain."""
    matrix, row = loop.closed(gain), loop.c / (1 + gain * loop.d)
    if loop.discrete:
        powers = [row]
        for _ in range(40):
            powers.append(powers[-1] @ matrix)
        return np.array(powers)
    return np.array([row @ linalg.expm(matrix * t) for t in (0.0, *np.geomspace(1e-3, 20.0, 40))])


Conclusion = Literal["0 attracts", "converges to equilibria", "bounded", ""]
BUDGET = 60000
"""Evaluations of the nonlinearity, each for all solutions at once."""
SAMPLES = 400
MOST_SAMPLES = 3200
STEPS = 64
PERIODS = 6
_RTOL = 1e-6
SEEN = 1e3
"""Growth over its median, or the square of that over its start, up to which a solution that grows is kept."""
EVEN = 0.97
"""Least over largest swing of an oscillation that Newton's method is tried on."""
ATTEMPTS = 2
SEARCHES = 4
CHECKED = 4
"""Findings that are computed again, at most."""

_ADVERSE: dict[Conclusion, frozenset[Finding]] = {
    "0 attracts": frozenset({Finding.RESTS, Finding.OSCILLATES, Finding.GROWS, Finding.UNSOLVABLE}),
    "converges to equilibria": frozenset({Finding.OSCILLATES, Finding.GROWS, Finding.UNSOLVABLE}),
    "bounded": frozenset({Finding.GROWS, Finding.UNSOLVABLE}),
    "": frozenset(),
}


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Trial:
    """Simulated solutions of one loop, and whether they disagree with what is proved: OBSERVED evidence."""

    trajectories: tuple[Trajectory, ...] = quantity("One a solution, those that disagree first")
    contradiction: Trajectory | None = quantity(
        "A solution that disagrees with the conclusion given, and did so again when it was computed more accurately"
    )

    def count(self, finding: Finding) -> int:
        """How many solutions show it."""
        return sum(one.finding is finding for one in self.trajectories)


def tried(
    block: RationalPlant,
    nonlinearity: Characteristic,
    *,
    conclusion: Conclusion = "",
    orbits: Sequence[tuple[Reals, float]] = (),
    budget: int = BUDGET,
) -> Trial:
    """Simulated solutions of ``sigma = H mu``, ``mu = -phi(sigma)``.

    Parameters
    ----------
    block : RationalPlant
        The block, of order 1 at least.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``, elementwise.
    conclusion : {"0 attracts", "converges to equilibria", "bounded", ""}
        What is proved of every solution; empty if nothing is.
    orbits : sequence of (ndarray, float)
        (n,) states near periodic solutions, in the companion form of the block, and their periods [s]; not used for a
        block that keeps other matrices.
    budget : int
        Evaluations of the nonlinearity, each for all solutions at once.

    Raises
    ------
    InputError
        A coefficient leaves the range of doubles.
    """
    known = orbits if block.matrices is None else ()
    knees = scales(nonlinearity)
    gains = _chords(nonlinearity, knees)
    loop = BatchLoop(block, nonlinearity, gain=Fraction(float(np.median(gains))), budget=budget)
    medium, slow, first = _rates(loop, gains)
    groups = [starts(loop, knees, medium), balanced_starts(loop, knees[0], knees[-1])]
    runs = [Run(start=state / loop.weights, text="on an orbit found by search") for state, _ in known]
    for run, (_, period) in zip(runs, known, strict=True):
        run.closed = periodic(loop, run.start, period / loop.seconds)
    large: list[Run] = []
    for begun in reversed(groups):
        for state, text, far in zip(begun.states, begun.texts, begun.large, strict=True):
            (large if far else runs).append(Run(start=state, text=text))
    for part in (runs, large):
        loop.used, loop.budget = 0, budget // 2
        _follow(loop, part, first, until_closed=Finding.OSCILLATES in _ADVERSE[conclusion])
    runs += large
    for run in runs:
        if run.finding is Finding.OSCILLATES and not run.closed and not lasts(run, slow):
            run.finding = Finding.OPEN
    adverse = [run for run in runs if run.finding in _ADVERSE[conclusion]]
    if conclusion == "bounded":
        adverse = [run for run in adverse if run.ended]  # growth that may end is no contradiction
    against = None
    for run in adverse[:CHECKED]:
        loop.used, loop.budget = 0, budget
        if confirmed(block, loop, run, slow):
            against = run
            break
    order = sorted(runs, key=lambda run: (run is not against, run not in adverse))
    shown = [_trajectory(loop, run) for run in order]
    return Trial(trajectories=tuple(shown), contradiction=shown[0] if against is not None else None)


def _chords(nonlinearity: Characteristic, knees: tuple[float, ...]) -> Reals:
    """Gains ``phi(sigma)/sigma`` of the nonlinearity from its least to its largest scale, and well beyond."""
    sizes = np.geomspace(0.03 * knees[0], 1e3 * knees[-1], 25)
    sizes = np.concatenate([sizes, -sizes])
    with np.errstate(all="ignore"):
        gains = np.asarray(nonlinearity(sizes), dtype=float) / sizes
    gains = gains[np.isfinite(gains)]
    return gains if gains.size else np.zeros(1)


def _rates(loop: BatchLoop, gains: Reals) -> tuple[float, float, float]:
    """The gain of the quickest decay; slowest decay over all, modes at 0 left out; length of the first stretch."""
    slowest, quickest, sizes, tried_gains = [], [], [], []
    for gain in np.unique(gains)[:: max(1, len(gains) // 20)]:
        if 1 + gain * loop.d <= 0:
            continue
        roots = np.linalg.eigvals(loop.closed(float(gain))).astype(complex)
        roots = np.log(np.where(np.abs(roots) < 1e-12, 1e-12, roots)) if loop.discrete else roots
        roots = roots[np.abs(roots) > 1e-9]
        if roots.size:
            tried_gains.append(float(gain))
            slowest.append(float(-roots.real.max()))
            quickest.append(float(np.abs(roots.imag).max()))
            sizes.append(float(np.abs(roots).max()))
    if not slowest:
        return 0.0, 0.0, 10.0
    middle = float(np.median(slowest))
    fast = float(np.median(quickest))
    few = PERIODS * 2 * math.pi / fast if fast > 1e-9 else math.inf
    usual = 12 / middle if middle > 0 else 12 / float(np.median(sizes))
    return tried_gains[int(np.argmax(slowest))], min(slowest), min(usual, few)


def _follow(loop: BatchLoop, runs: list[Run], first: float, *, until_closed: bool) -> None:
    """Follow every run until it is decided, or the evaluations granted do not last for another stretch.

    ``until_closed``: or one of them is found to be periodic, which is all that a contradiction needs.
    """
    length, samples = first, STEPS if loop.discrete else SAMPLES
    while open_runs := [run for run in runs if not run.ended]:
        before = loop.used
        now = np.array([run.states[-1][-1] if run.states else run.start for run in open_runs])
        try:
            times, path = loop.advance(now, length, samples, _RTOL)
            sigma = loop.sigma_of(path.reshape(-1, loop.order))[0].reshape(len(open_runs), -1)
        except OutOfBudget:
            if length < first or open_runs[0].states:
                return
            length, loop.used = length / 16, before  # the first stretch was too long: once more, with a shorter one
            continue
        for run, states, values in zip(open_runs, path, sigma, strict=True):
            run.t.append(run.until + times)
            run.states.append(states)
            run.sigma.append(values)
            judge(run, loop.rests_at)
            if run.closed:
                run.ended, run.finding = True, Finding.OSCILLATES
            _close(loop, run, runs)
        closed = until_closed and any(run.closed for run in runs)
        if closed or loop.used + 2 * (loop.used - before) > loop.budget:
            return
        length, samples = 2 * length, 2 * samples if loop.discrete else min(2 * samples, MOST_SAMPLES)


def _close(loop: BatchLoop, run: Run, others: Sequence[Run]) -> None:
    """End a run that swings evenly, if it is found to be periodic, or ends on an oscillation that was."""
    if run.finding is not Finding.OSCILLATES or run.attempts >= ATTEMPTS or steadiness(run) < EVEN:
        return
    if sum(other.attempts for other in others if not other.closed) >= SEARCHES:
        return
    if any(other.closed and _alike(run, other) for other in others):
        run.closed = run.ended = True
        return
    run.attempts += 1
    run.closed = run.ended = closes(loop, run)


def _alike(one: Run, other: Run) -> bool:
    """Whether two runs end on the same oscillation, by its extremes."""
    ends = [np.array([run.sigma[-1][-1 - len(run.sigma[-1]) // 2 :]]) for run in (one, other)]
    spans = [np.array([float(part.min()), float(part.max())]) for part in ends]
    return bool(np.abs(spans[0] - spans[1]).max() <= 0.03 * np.ptp(spans[1]))


def _trajectory(loop: BatchLoop, run: Run) -> Trajectory:
    t, sigma = (run.t[0], run.sigma[0]) if run.t else (np.zeros(1), np.zeros(1))
    if run.finding is Finding.GROWS:  # an escape would hide what was before it
        sizes = np.abs(sigma)
        end = int((sizes <= SEEN * min(float(np.nanmedian(sizes)), SEEN * sizes[0] or math.inf)).argmin()) or len(sigma)
        t, sigma = t[:end], sigma[:end]
    with np.errstate(all="ignore"):  # a solution that grows may end beyond the range of doubles
        mu = -np.asarray(loop.values(sigma), dtype=float)
    return Trajectory(
        t=t * loop.seconds,
        sigma=sigma,
        mu=mu,
        nonlinearity=str(loop.nonlinearity),
        start=run.text,
        finding=run.finding,
        until=run.until * loop.seconds,
        discrete=loop.discrete,
        unit=loop.unit,
    )
