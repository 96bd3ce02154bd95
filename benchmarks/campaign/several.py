"""Loops with several channels, with gains and rates asked of them, and with play and stop."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import attacked_gains_and_rates as known
import numpy as np
from attacks import attacked  # tests/support
from campaign.members import LANES, STAYS, lasting
from campaign.single import Counts, checked
from scipy.linalg import expm

from lure import AssumptionError, Diagonal, InputError, NonlinearityClass, Sector, as_plant, certify
from lure.analysis import decay_rate, l2_gain
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.verdict import Verdict

Reals = np.ndarray
SECONDS = 4.0
ONE = NonlinearityClass
MAKE: dict[str, Callable[[Fraction, np.random.Generator], NonlinearityClass]] = {
    "sector": lambda top, rng: ONE(sector=Sector(_low(top, rng), top)),
    "varying": lambda top, rng: ONE(sector=Sector(_low(top, rng), top), time_varying=True),
    "slope": lambda top, rng: ONE.slope_restricted(_low(top, rng), top, odd=bool(rng.random() < 0.5)),
    "relu": lambda top, rng: ONE.relu(_low(top, rng), top),
    "gain": lambda top, rng: ONE.constant_gain(_low(top, rng), top),
    "slow": lambda top, rng: ONE.varying_gain(0, top, rate=top / int(rng.integers(1, 100))),
    "operator": lambda top, rng: ONE.norm_bounded(
        top, dynamics=str(rng.choice(["any", "linear time-invariant", "scalar linear time-invariant"]))
    ),
    "delay": lambda top, rng: ONE.delayed(
        int(rng.integers(1, 4)) if rng.random() < 0.5 else top, varying=bool(rng.random() < 0.4)
    ),
}


def _low(top: Fraction, rng: np.random.Generator) -> Fraction:
    return Fraction(0) if rng.random() < 0.7 else top * Fraction(int(rng.integers(-4, 7)), 8)


@dataclass(frozen=True)
class Channels:
    """A plant with several channels, all entries exact, and the classes."""

    A: list[list[Fraction]]
    B: list[list[Fraction]]
    C: list[list[Fraction]]
    D: list[list[Fraction]]
    classes: Diagonal
    discrete: bool

    def source(self) -> object:
        """The plant as the library takes it."""
        return as_plant((self.A, self.B, self.C, self.D), dt=1 if self.discrete else None)

    def floats(self) -> tuple[Reals, ...]:
        """The matrices as arrays."""
        return tuple(np.array([[float(v) for v in row] for row in side]) for side in (self.A, self.B, self.C, self.D))


def channels_drawn(rng: np.random.Generator, kinds: list[str] | None = None) -> Channels:
    """A stable plant in eighths with two or three channels, in blocks that share a nonlinearity or do not."""
    discrete = bool(rng.integers(2))
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    A = np.round(8 * rng.normal(size=(n, n))) / 8
    values = np.linalg.eigvals(A)
    room = rng.uniform(0.05, 0.6)
    if discrete:
        A = np.round(A * (1 - room) / max(np.abs(values).max(), 0.01) * 64) / 64
    else:
        A = A - np.round(8 * (values.real.max() + room + 0.1)) / 8 * np.eye(n)
    B, C = (np.round(8 * rng.normal(size=shape)) / 8 for shape in ((n, m), (m, n)))
    D = np.round(2 * rng.normal(size=(m, m))) / 8 * (rng.random((m, m)) < 0.5) * (rng.random() < 0.3)
    blocks: list[int] = []
    while sum(blocks) < m:
        blocks.append(int(rng.integers(1, m - sum(blocks) + 1)) if rng.random() < 0.3 else 1)
    wanted = Fraction(max(1, round(8 * 10 ** rng.uniform(-1, 1))), 8)
    own = [MAKE[str(rng.choice(kinds or list(MAKE)))](wanted, rng) for _ in blocks]
    classes = tuple(one for one, size in zip(own, blocks, strict=True) for _ in range(size))
    exact = ([[Fraction(str(v)) for v in row] for row in side.tolist()] for side in (A, B, C, D))
    return Channels(*exact, Diagonal(classes, repeated=tuple(blocks) if m > 1 else False), discrete)


def permuted(case: Channels, rng: np.random.Generator) -> Channels:
    """The blocks in another order, the states scaled and mixed: the same loop."""
    blocks = case.classes.blocks
    order = [int(i) for i in rng.permutation(len(blocks))]
    places = [i for k in order for i in blocks[k]]
    A, B, C, D = ([list(row) for row in side] for side in (case.A, case.B, case.C, case.D))
    i, j = (int(v) for v in rng.integers(0, len(A), 2))
    if i != j:
        t = Fraction(int(rng.integers(-3, 4)), 2)
        A[i] = [u + t * v for u, v in zip(A[i], A[j], strict=True)]
        B[i] = [u + t * v for u, v in zip(B[i], B[j], strict=True)]
        for row in itertools.chain(A, C):
            row[j] -= t * row[i]
    repeated = tuple(len(blocks[k]) for k in order) if len(places) > 1 else False
    return Channels(
        A,
        [[row[p] for p in places] for row in B],
        [C[p] for p in places],
        [[D[p][q] for q in places] for p in places],
        Diagonal(tuple(case.classes.classes[p] for p in places), repeated=repeated),
        case.discrete,
    )


def gains_fit(case: Channels, gains: list[Fraction]) -> bool:
    """Whether constant gains belong to the classes, the same in each block."""
    same = all(len({gains[i] for i in block}) == 1 for block in case.classes.blocks)
    fits = all(
        one.gains[0] <= g <= one.gains[1]
        for one, g in zip(case.classes.classes, gains, strict=True)
        if not one.operator
    )
    return same and fits and not any(one.rectifier for one in case.classes.classes)


def channels_replayed(case: Channels, proof: dict[str, object]) -> str:
    """Whether gains that refute belong to the classes and the loop with them does not decay; "-" for other kinds."""
    A, B, C, D = case.floats()
    if proof["method"] not in ("linear-gains", "switched-gains"):
        return "-"
    rows = [proof["gains"]] if proof["method"] == "linear-gains" else proof["gains"]
    gains = [[Fraction(g) for g in row] for row in rows]  # type: ignore[union-attr, attr-defined]  # data of JSON
    if case.classes.operators or any(one.memory for one in case.classes.classes):
        return "-"
    if not all(gains_fit(case, row) for row in gains):
        return f"the gains {gains} are no members"
    if len(gains) > 1 and not all(
        one.time_varying or len({row[i] for row in gains}) == 1 for i, one in enumerate(case.classes.classes)
    ):
        return f"the gains {gains} vary"
    whole = np.eye(len(A))
    durations = proof.get("times") or ["1"] * len(gains)
    for row, time in zip(gains, durations, strict=True):  # type: ignore[call-overload]  # data of JSON
        G = np.diag([float(g) for g in row])
        inner = np.eye(len(G)) + D @ G
        if abs(np.linalg.det(inner)) < 1e-9:
            return ""
        closed = A - B @ G @ np.linalg.solve(inner, C)
        if len(gains) == 1:
            values = np.linalg.eigvals(closed)
            size = np.abs(values).max() - 1 if case.discrete else values.real.max()
            return "" if size > -1e-7 else f"the gains {gains} are stable by {size:.3g}"
        whole = (closed if case.discrete else expm(closed * float(Fraction(time)))) @ whole
    radius = np.abs(np.linalg.eigvals(whole)).max()
    return "" if radius > 1 - 1e-7 else f"a period has the multiplier {radius!r}"


def several(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """One class for each channel, in two orders."""
    case, counts = channels_drawn(rng), Counter[str]()
    verdicts, faults = [], []
    for each in (case, permuted(case, rng)):
        try:
            found = certify(each.source(), each.classes, ways=ProofOptions(seconds=SECONDS))
        except (InputError, AssumptionError) as error:
            counts[f"refused: {type(error).__name__}"] += 1
            return counts, [], case
        counts[str(found.verdict)] += 1
        verdicts.append(found.verdict)
        if found.certificate is None:
            continue
        counts["certificates"] += 1
        faults += [said] if (said := checked(found.certificate)) else []
        if found.verdict is Verdict.REFUTED:
            counts["replayed"] += 1
            said = channels_replayed(each, found.certificate["proof"])
            counts["not replayed"] += said == "-"
            faults += [f"REFUTED: {said}"] if said not in ("", "-") else []
    if set(verdicts) >= {Verdict.PROVED, Verdict.REFUTED}:
        faults.append("PROVED, and REFUTED in another order")
    counts["forms that differ in strength"] += len(set(verdicts)) > 1
    late = any(one.operator in ("delay", "varying delay") for one in case.classes.classes)
    through = any(v for row in case.D for v in row)
    if verdicts[0] is Verdict.PROVED and not late and not through:
        counts["attack: extreme members"] += 1
        said = attacked(case.floats()[:3], case.classes, rng, case.discrete, rounds=1, count=16, windows=4)
        if said.startswith("a solution"):  # it may only decay slowly
            said = attacked(case.floats()[:3], case.classes, rng, case.discrete, rounds=1, count=16, windows=9)
        faults += [f"PROVED against {said}"] if said else []
    return counts, faults, case


def memory(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """Play and stop in each channel, of the width 1, simulated exactly in discrete time and in short steps else."""
    counts = Counter[str]()
    case = channels_drawn(rng, ["gain"])
    kinds = [str(rng.choice(["play", "stop"])) for _ in case.classes.classes]
    tops = [Fraction(one.gains[1]) for one in case.classes.classes]
    if any(top <= 0 for top in tops) or any(v for row in case.D for v in row):
        return counts, [], case
    classes = Diagonal(tuple(ONE.hysteretic(k, top) for k, top in zip(kinds, tops, strict=True)))
    case = Channels(case.A, case.B, case.C, case.D, classes, case.discrete)
    try:
        found = certify(case.source(), classes, ways=ProofOptions(seconds=SECONDS))
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return counts, [], case
    counts[str(found.verdict)] += 1
    if found.certificate is None:
        return counts, [], case
    counts["certificates"] += 1
    faults = [said] if (said := checked(found.certificate)) else []
    if found.verdict is Verdict.PROVED:
        counts["attack: play and stop"] += 1
        ratio = hysteresis(case, kinds, str(found.certificate["conclusion"]), rng)
        faults += [f"PROVED against play and stop: a ratio of {ratio:.8g}"] if ratio > STAYS else []
    return counts, faults, case


def hysteresis(case: Channels, kinds: list[str], conclusion: str, rng: np.random.Generator) -> float:
    """How much of the increments is left in a late window, for slopes at their ends or inside."""
    A, B, C, _ = case.floats()
    m, n = len(C), len(A)
    tops = np.array([float(one.gains[1]) for one in case.classes.classes])
    slopes = tops * np.where(rng.random((LANES, m)) < 0.7, 1.0, rng.random((LANES, m)))
    play = np.array([kind == "play" for kind in kinds])
    width = 10 ** rng.uniform(-1, 1, (LANES, m))
    fast = np.linalg.norm(A, 2) + tops.max() * np.linalg.norm(B, 2) * np.linalg.norm(C, 2)
    h = 0.2 / fast
    flow = np.block([[A, B], [np.zeros((m, n + m))]])
    whole, half = (flow,) * 2 if case.discrete else (expm(flow * h), expm(flow * h / 2))

    def held(x: Reals, p: Reals) -> tuple[Reals, Reals]:
        sigma = x @ C.T
        p = np.clip(p, sigma - width, sigma + width)
        return -slopes * np.where(play, p, sigma - p), p

    def step(state: Reals, _t: int) -> Reals:
        x, p = state[:, :n], state[:, n:]
        mu, p = held(x, p)
        if not case.discrete:  # what is held is that of the middle: else it comes half a step late
            mu, _ = held(np.hstack([x, mu]) @ half[:n].T, p)
        return np.hstack([np.hstack([x, mu]) @ whole[:n].T, p])

    x = rng.normal(size=(LANES, n)) * np.geomspace(0.1, 1e3, LANES)[:, None]
    return lasting(
        step, np.hstack([x, rng.normal(size=(LANES, m))]), conclusion + " converges to the set of equilibria"
    )


def gain(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """The L2 gain, in two units; constant gains at many frequencies, other members and inputs in discrete time."""
    counts = Counter[str]()
    discrete, kind = bool(rng.integers(2)), str(rng.choice(["varying", "sector", "slope"]))
    parts, upper = known.loop(rng, discrete=discrete), float(np.round(rng.uniform(0.02, 0.9), 3))
    A, B, C = parts
    Bw, Cz = np.round(rng.normal(size=(len(A), 1)), 3), np.round(rng.normal(size=(1, len(A))), 3)
    unit = Fraction(10) ** int(rng.integers(-5, 6))
    ends = []
    for factor in (Fraction(1), unit):
        scaled = [[Fraction(str(v)) * factor for v in row] for row in Bw.tolist()]
        plant = known.given(parts, discrete=discrete)
        found = l2_gain(plant, [known.classes(kind, upper)], {"Bw": scaled, "Cz": Cz.tolist()}, seconds=SECONDS)
        counts[str(found.verdict)] += 1
        shown = [one for one in (found.proof, found.refutation) if one is not None]
        counts["certificates"] += len(shown)
        faults = [said for one in shown if (said := checked(one.certificate))]
        low = found.gain.low if found.verdict is Verdict.PROVED or found.refutation is not None else 0.0
        ends.append((low / float(factor), found.gain.high / float(factor), found.verdict))
    case = (parts, kind, upper, Bw.tolist(), Cz.tolist(), discrete, str(unit))
    if max(low for low, _, _ in ends) > min(high for _, high, _ in ends) * (1 + 1e-9):
        faults.append(f"the gains {ends}")
    best = min(high for _, high, _ in ends)
    if ends[0][2] is Verdict.PROVED and best < math.inf:
        counts["attack: members and inputs"] += 1
        constant = rng.uniform(0, upper, 60)
        constant[:2] = 0, upper
        closed = A - constant[:, None, None] * (B @ C)
        points = np.exp(1j * np.linspace(0, math.pi, 60)) if discrete else 1j * np.geomspace(1e-3, 1e3, 120)
        pencil = points[:, None, None, None] * np.eye(len(A)) - closed
        seen = np.abs(Cz @ np.linalg.solve(pencil, np.broadcast_to(Bw + 0j, (*pencil.shape[:2], *Bw.shape))))
        worst = float(seen.max())
        if discrete and rng.random() < 0.1:
            omega = float(np.angle(points[int(seen.max(axis=(1, 2, 3)).argmax())]))
            worst = max(worst, known.simulated((A, B, C, Bw, Cz), kind, upper, omega, rng))
        faults += [f"a gain of {worst!r} against {ends}"] if worst > best * (1 + 1e-9) else []
    return counts, faults, case


def rate(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """The rate of decay; constant gains and gains that jump, and in discrete time functions that look alike."""
    counts = Counter[str]()
    discrete, kind = bool(rng.integers(2)), str(rng.choice(["varying", "sector", "slope"]))
    parts, upper = known.loop(rng, discrete=discrete), float(np.round(rng.uniform(0.02, 0.9), 3))
    case = (parts, kind, upper, discrete)
    found = decay_rate(known.given(parts, discrete=discrete), known.classes(kind, upper), seconds=SECONDS)
    counts[str(found.verdict)] += 1
    shown = [one for one in (found.proof, found.refutation) if one is not None]
    counts["certificates"] += len(shown)
    faults = [said for one in shown if (said := checked(one.certificate))]
    if found.verdict is Verdict.PROVED:
        counts["attack: members that decay slowly"] += 1
        proved = math.log(found.rate.high) if discrete else -found.rate.low
        constant = kind != "varying"
        slowest = float(known.jumping(parts, upper, rng, discrete=discrete, constant=constant).max())
        if slowest > proved + 1e-9 * abs(proved):
            faults.append(f"an exponent of {slowest!r} against {proved!r}")
        if discrete and kind == "slope" and rng.random() < 0.2:
            slack = math.log(known.LARGEST_C) / (0.75 * known.STEPS)
            followed = float(known.followed(parts, *known.graphs(rng, upper), rng).max())
            faults += [f"an exponent of {followed!r} against {proved!r}"] if followed > proved + slack else []
    return counts, faults, case
