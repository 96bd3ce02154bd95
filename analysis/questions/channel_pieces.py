"""Several channels with constant delays: multipliers that are functions of the frequency, as checked certificates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations

from lure.analysis.certificates import channels, pieces
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Channels, Plant
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.piecewise import Channel, Piecewise
from lure.analysis.inequality.shifted_loop import LARGEST, Proposal
from lure.analysis.numerics.doubles import double_below
from lure.analysis.questions.channel_delays import stated
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.dead_time import LoopSearch
from lure.analysis.theorems.kernel_search import TOLERANCE
from lure.analysis.theorems.kernels import Multiplier
from lure.arrays import NDArray, in_doubles, np
from lure.errors import AssumptionError, InputError, Reason

_STEPS_BACK = (0.0, 0.0, 1e-3, 1e-3, 3e-3, 1e-2)
_FAR_BACK = (0.9, 0.99, 0.99)  # where the factor is bounded by numbers alone
# Where what comes late is to be less than what does not.
_NEUTRAL_BACK = (0.0, 0.0, 3e-3, 0.01, 0.03, 0.1, 0.1, 0.1, 0.1, 0.3, 0.5, 0.9)

# What is proved with kernels is this much below what is found in floating point.
_KERNELS_BACK = (1e-6, 1e-4, 1e-3, 0.01, 0.1)
_HALVINGS, _NARROW, _FARTHEST, _MOST_BOXES = 30, 1e-5, 5, 600


def _require_covered(plant: Plant, known: Channels) -> None:
    """Refuse classes that the theorem is not about beside dead times."""
    pairs = [
        (known.bounds(i), one.slope) for i, one in enumerate(known.families) if one.operator not in channels.DELAYS
    ]
    if plant.rates and known.operators:
        raise AssumptionError(
            "a neutral equation is covered with nonlinearities and constant gains alone; give such classes",
            code=Reason.NOT_APPLICABLE,
        )
    if not (channels.ordered(plant.D, known) or all(low <= a and b <= high for (low, high), (a, b) in pairs)):
        fix = "the slopes are not within the bounds; give slope bounds, or a D without a cycle"
        if known.performance:
            fix = "no gain is shown of such; give a D without a cycle, that of w and z included"
        raise AssumptionError(f"beside dead times D has a cycle of channels, and {fix}", code=Reason.NOT_APPLICABLE)


class PiecewiseProofs:
    """What is proposed for the classes of a factor.

    Parameters
    ----------
    asked : Problem
        The question about several channels.
    free : sequence of bool or None
        In which channels Popov's terms are used; None for the circle criterion.
    pace : Fraction
        A rate ``a`` [1/s]: the inequality is that of ``x(t) e^(a t)``.

    Raises
    ------
    AssumptionError
        The theorem is not for this loop.
    """

    def __init__(self, asked: Problem, free: Sequence[bool] | None, pace: Fraction = Fraction(0)) -> None:
        self.asked, self.free, self.pace = asked, free, pace
        plant, known = self._kept(Fraction(1))
        self.late = bool(plant.late)
        if self.late:
            _require_covered(plant, known)
        low = self._lower(known, shifted=False)
        gains, zeros = [*map(float, low)] if plant.inner or (self.late and any(low)) else None, 0
        if gains is not None or (self.late and not pace and not channels.characteristic(plant.A)[-1]):
            try:
                number, zeros, _ = pieces.right_roots(plant, low)
            except Rejected as error:
                raise AssumptionError(f"beside dead times: {error}", code=Reason.DEAD_TIME) from None
            if number:
                shift = f"the loop is shifted by the gains {', '.join(f'{float(v):g}' for v in low)}, with which it"
                raise AssumptionError(
                    f"beside dead times {shift if any(low) else 'the plant'} is not stable", code=Reason.DEAD_TIME
                )
        self.resting, ties = bool(zeros), self._ties(plant, known, low, zeros) if zeros else []
        found = (
            plant
            if self.late
            else channels.closed_loop(plant, [[v * (i == j) for j in range(len(low))] for i, v in enumerate(low)])
        )
        if found is None:
            raise AssumptionError("the loop is not well posed with the gains at the lower bounds and without delay")
        A, B, C, D = (in_doubles(side) for side in found[:4])
        poles = np.linalg.eigvals(A)
        if gains is None and not zeros and (np.abs(poles).max() if plant.discrete else 1 + poles.real.max()) >= 1:
            raise AssumptionError(
                "the loop with the gains at the lower bounds and without delay is not asymptotically stable"
            )
        blocks = [*known.operators, *known.tied]
        up = [math.exp(float(pace * delay)) for delay, _ in plant.late]
        sides = zip(up, plant.late, strict=True)
        late = [(float(delay), by * np.array([[*map(float, row)] for row in rows])) for by, (delay, rows) in sides]
        inner = [by * np.array([[*map(float, row)] for row in rows]) for by, rows in zip(up, plant.inner, strict=False)]
        rates = [(np.array(D_T, dtype=float), np.array(E, dtype=float)) for D_T, E in plant.rates]
        self.search = Piecewise(
            A,
            B,
            C,
            D,
            self._widths(Fraction(1)),
            blocks,
            plant.discrete,
            late,
            gains,
            inner,
            rates,
            float(pace),
            zeros,
            ties,
        )

    def _ties(self, plant: Plant, known: Channels, low: list[Fraction], zeros: int) -> list[tuple[int, int, Fraction]]:
        """Channels ``i`` and ``j`` with the number that ``lambda_j`` is of ``lambda_i``, for poles at 0 as covered."""
        refused = AssumptionError(
            "the plant has an eigenvalue 0 (the critical case), which beside dead times is covered with nonlinearities "
            "alone, with bounds [0, u] and the same at all times where sigma shows it; give such classes, or a plant "
            "without it",
            code=Reason.CRITICAL,
        )
        try:
            R = pieces.residues(plant, low, zeros)
        except Rejected as error:
            raise AssumptionError(f"beside dead times {error}", code=Reason.CRITICAL) from None
        if channels.rank(R) < zeros:
            raise AssumptionError(
                f"beside dead times {zeros} eigenvalues 0 of the plant are realised, and lim s H(s) has the rank "
                f"{channels.rank(R)}: what is not seen in one entry each is not covered",
                code=Reason.CRITICAL,
            )
        kinds, varying = {self._kind(known, i) for i in range(len(R))}, [one.varying for one in known.families]
        shown = [i for i, row in enumerate(R) if any(row)]
        direct = any(varying) and any(plant.direct(i) for i in shown)
        if kinds != {"function"} or plant.rates or direct or any(varying[i] or known.bounds(i)[0] for i in shown):
            raise refused
        widths = [high - low for low, high in map(known.bounds, range(len(R)))]
        pairs = [(i, j) for i, j in combinations(range(len(R)), 2) if R[i][j] or R[j][i]]
        if any(widths[i] * R[i][j] * widths[j] * R[j][i] <= 0 for i, j in pairs):
            raise AssumptionError(
                "beside dead times no weights make Lambda W lim s H(s) symmetric, which poles at 0 ask for",
                code=Reason.CRITICAL,
            )
        return [(i, j, widths[i] * R[i][j] / (widths[j] * R[j][i])) for i, j in pairs]

    def _kept(self, alpha: Fraction) -> tuple[Plant, Channels]:
        """The loop of a factor with its constant delays, operators in place of those that vary."""
        try:
            plant, known = channels.undelayed(*stated(self.asked.scaled(alpha)), kept=True)
            moved = [[v + self.pace * (i == j) for j, v in enumerate(row)] for i, row in enumerate(plant.A)]
            return plant._replace(A=moved, pace=self.pace), known
        except Rejected as error:
            raise AssumptionError(f"not covered by the theorem: {error}", code=Reason.NOT_APPLICABLE) from None

    def _kind(self, known: Channels, i: int) -> str:
        one, alone = known.families[i], range(i, i + 1) in known.blocks
        if "delay" in one.operator:
            return "slow delay" if one.varying else "delay"
        if one.operator:
            return "scaled operator" if one.operator == "linear time-invariant" else "operator"
        return "gain" if one.linear and not one.varying and alone else "function"

    def _lower(self, known: Channels, *, shifted: bool) -> list[Fraction]:
        """What the loop is shifted by; of operators 0, or as in a certificate ``-r``."""
        found = list[Fraction]()
        for i, one in enumerate(known.families):
            apart = Fraction(1) if "delay" in one.operator else None
            if apart is None and one.operator and not shifted:
                apart = Fraction(0)
            if apart is None and self.late:
                apart = pieces.base(*known.bounds(i))
            found.append(known.bounds(i)[0] if apart is None else apart)
        return found

    def _widths(self, alpha: Fraction) -> list[Channel]:
        """The channels of a factor; none where there are no such classes."""
        try:
            plant, known = self._kept(alpha)
        except InputError:  # the upper bounds are below lower ones above 0
            return []
        found = list[Channel]()
        for i, one in enumerate(known.families):
            kind = self._kind(known, i)
            if kind in ("delay", "slow delay"):
                smooth = not plant.discrete and not plant.direct(i)
                found.append(Channel(kind, one.sector[1], smooth, one.rate))
                continue
            low, high = known.bounds(i)
            below = low - pieces.base(low, high) if self.late and not one.operator else Fraction(0)
            free, width = kind == "function" and bool(self.free and self.free[i]), high - low
            free = free and not (self.resting and below)
            found.append(Channel(kind, high if one.operator else width, free, low=below))
        return found if min(one.width for one in found) > 0 else []

    def _exactly(self, alpha: Fraction) -> Callable[[Sequence[Fraction], Sequence[Fraction]], pieces.Axis]:
        plant, known = self._kept(alpha)
        low = self._lower(known, shifted=True)

        def axis(weights: Sequence[Fraction], theta: Sequence[Fraction]) -> pieces.Axis:
            """The loop with these multipliers, as the checker has it."""
            members = list[pieces.Member]()
            for i, one in enumerate(known.families):
                names = {"delay": "delay", "slow delay": "slow", "gain": "scaled", "scaled operator": "scaled"}
                kind, slow = names.get(self._kind(known, i), ""), one.rate or Fraction(0)
                width = slow / (1 - slow)
                if kind not in ("delay", "slow"):
                    width = known.bounds(i)[1] - known.bounds(i)[0]
                below = known.bounds(i)[0] - low[i] if self.late and kind not in ("delay", "slow") else Fraction(0)
                bound = Fraction(one.sector[1])
                members.append(pieces.Member(kind, width, weights[i], theta[i], bound, below))
            return pieces.axis_of(plant, low, members)

        return axis

    def at(self, alpha: Fraction, *, exactly: bool = True) -> Proposal | None:
        """A proposal for the classes of a factor; None if none was found.

        ``exactly``: whether each piece is to pass the test of the checker; else it is looked at in floating point.
        """
        self.search.channels = self._widths(alpha)
        axis = self._exactly(alpha) if exactly else None
        found = self.search.proposal(axis) if self.search.channels else None
        if found is not None and self.free is None:
            del found.multiplier["theta"]
        return found

    def farthest(self, known: Fraction, most: float) -> Iterator[tuple[Fraction, Proposal]]:
        """Proposals for large factors between two, the largest first.

        ``known``: smaller ones are of no interest; ``most``: nor are larger ones.
        """
        most = min(most, LARGEST)
        steps = _NEUTRAL_BACK if self.search.rates else (*_STEPS_BACK, *(_FAR_BACK if self.late else ()))
        for step in steps:  # where a proposal fails its frequencies are looked at from then on
            most = self.search.largest(lambda factor: self._widths(Fraction(f"{factor:.9g}")), most) * (1 - step)
            alpha = Fraction(double_below(Fraction(f"{most:.9g}")))
            if alpha <= known:
                return
            proposal = self.at(alpha)
            if proposal is not None:
                yield alpha, proposal


class LateKernels:
    """Zames-Falb multipliers of one function of a plant with dead times, for slopes within its bounds.

    Parameters
    ----------
    asked : Problem
        The question, with one channel.
    free : bool
        Whether there is a Popov term.

    Raises
    ------
    AssumptionError
        The theorem is not for this loop.
    """

    def __init__(self, asked: Problem, *, free: bool) -> None:
        self.proofs = PiecewiseProofs(asked, None)
        if self.proofs.resting:
            raise AssumptionError(
                "beside dead times kernels of a channel in a list do not cover a pole at 0; ask for the circle "
                "criterion or Popov's",
                code=Reason.CRITICAL,
            )
        self.asked, loop = asked, self.proofs.search
        plant, known = self.proofs._kept(Fraction(1))
        self.low = known.bounds(0)[0]
        self.below = self.low - pieces.base(*known.bounds(0))

        def response(omega: NDArray[np.float64]) -> NDArray[np.complex128]:
            """``H`` after the shift by the lower slope."""
            h = loop._response(omega)[0][:, 0, 0]
            return np.asarray(h / (1 + float(self.below) * h))

        poly, waits, odd = (
            np.asarray(np.poly(loop.A), dtype=np.float64),
            [tau for tau, _ in plant.late],
            known.families[0].odd,
        )
        self.search = LoopSearch(np.ones(1), poly, odd=odd, family="gamma", loop=response, waits=waits, free=free)

    def _found(self, alpha: Fraction) -> Multiplier | None:
        """A multiplier for the classes of a factor, in floating point."""
        checkpoint()
        width = float(self.asked.classes.scaled(alpha).upper[0] - self.low)
        found = self.search.propose(width) if width > 0 else None
        return None if found is None or found.least <= TOLERANCE else found.multiplier

    def at(self, alpha: Fraction) -> Proposal | None:
        """A proposal for the classes of a factor, covered as the checker covers it; None if none was found."""
        found = self._found(alpha)
        if found is None:
            return None
        plant, known = self.proofs._kept(alpha)
        (low, high), entries = known.bounds(0), found.to_parameters()["kernels"]
        theta = found.theta * (high - low)
        one = pieces.Member("", high - low, Fraction(1), theta, Fraction(0), low - pieces.base(low, high))
        axis = pieces.axis_of(
            plant, [pieces.base(low, high)], [pieces.with_kernels(one, entries, known.families[0].odd)]
        )
        ends = _cover(axis, Fraction(f"{self.search.far:.6g}"))
        stated = {"lambda": ["1"], "theta": [str(theta)], "kernels": entries}
        return None if ends is None else Proposal(stated, {"method": "pieces", "ends": [*map(str, ends)]})

    def farthest(self, known: Fraction, most: float) -> Iterator[tuple[Fraction, Proposal]]:
        """Proposals for large factors between two, the largest first.

        ``known``: smaller ones are of no interest; ``most``: nor are larger ones.
        """
        least = max(float(known), float(self.asked.classes.least)) * (1 + _NARROW) + 1 / LARGEST
        low, high = 0.0, min(most * (1 - _NARROW), LARGEST)
        middle = high
        for _ in range(_HALVINGS):
            if high <= least:
                return
            low, high = (middle, high) if self._found(Fraction(f"{middle:.9g}")) is not None else (low, middle)
            if high - low <= _NARROW * high:
                break
            start = max(low, least)
            middle = math.sqrt(start * high) if high > 4 * start else (start + high) / 2
        for step in _KERNELS_BACK:
            alpha = Fraction(f"{low * (1 - step):.9g}")
            if alpha <= known or alpha <= self.asked.classes.least:
                return
            proposal = self.at(alpha)
            if proposal is not None:
                yield alpha, proposal


def _cover(axis: pieces.Axis, far: Fraction) -> list[Fraction] | None:
    """Where pieces end on each of which ``F > 0`` is shown, the last being from there on; None if it is not shown."""
    row = [(Fraction(0), Fraction(0))]
    for _ in range(_FARTHEST):
        checkpoint()
        if not pieces.on_piece(axis, row, far, None):
            break
        far *= 2
    else:
        return None
    stack, ends, least = [(far / 2, far), (Fraction(0), far / 2)], list[Fraction](), far / 2**26
    for _ in range(_MOST_BOXES):
        checkpoint()
        if not stack:
            return ends
        a, b = stack.pop()
        if not pieces.on_piece(axis, row, a, b):
            ends.append(b)
            continue
        if b - a < least:
            return None
        stack += [((a + b) / 2, b), (a, (a + b) / 2)]
    return None
