"""Lyapunov functions of degree 4 and more for sectors of time-varying nonlinearities, decided in integers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from types import MappingProxyType
from typing import Any, Literal

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.powers import Monomial, lifted, monomials, require_falling, substituted
from lure.analysis.certificates.states import gained
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.checks import check_plant, require_well_posed
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.numerics.doubles import text_above, text_below, triangle_texts
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.analysis.theorems.circle import circle_largest
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.arrays import NDArray, Reals, balanced, in_doubles, np
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

NAME = "homogeneous-lyapunov"
TITLE = "the criterion of homogeneous Lyapunov functions"
THEOREM = (
    "homogeneous polynomial Lyapunov functions of a polytope of matrices (R. W. Brockett, Lie algebras and Lie groups "
    "in control theory, 1973; A. L. Zelentsovsky, IEEE Trans. Automatic Control 39 (1994) 135-138; G. Chesi et al., "
    "Homogeneous Polynomial Forms for Robustness Analysis of Uncertain Systems, 2009)"
)
CONCLUSIONS = (
    "0 is globally exponentially stable for every phi(t, sigma) of the class, time-varying phi included",
    "every solution is bounded and, for time-invariant phi, converges to an equilibrium; for time-varying phi "
    "boundedness only",
)
ASSUMED = "phi piecewise continuous in t, locally Lipschitz in sigma, in the sector: assumed of the class"
HYPOTHESES = (
    "P > 0, and V' < 0 for x != 0 with the gains at both ends of the sector: checked in integers",
    "P > 0, and V' < 0 with the gains at both ends of the sector, V' = 0 with the lower one where x_1 alone is not 0: "
    "checked in integers",
    "P > 0, and V(x+) < V(x) for x != 0 with the gains at both ends of the sector: checked in integers",
)
HIGHEST = {2: 12, 3: 6, 4: 3, 5: 3}  # half of the degree, by the order of the plant
QUICK = {2: 12, 3: 4, 4: 3, 5: 2}
CRITICAL = 10  # the solver's last with a pole at 0
STEPS, CLOSE, FIRST = 14, 5e-4, 32
ROOM, DIGITS, COORDINATES = 1e-9, 14, 8  # of the inequality; of what is rounded, beyond the room [bits]


def homogeneous_largest(
    block: RationalPlant, *, lower: Fraction = Fraction(0), effort: Literal["quick", "full"] = "quick"
) -> CriterionResult:
    r"""The largest ``k`` for which a form of even degree falls along every loop of the class ``[lower, k]``.

    Let ``A_g`` be the loop with the constant gain ``g`` and ``m`` all products of ``p`` states, ``m' = L_g m`` along
    ``x' = A_g x``.  With symmetric matrices ``P > 0``, ``Z_1`` and ``Z_2``, ``m^T Z_i m = 0`` for every ``x``, and

    .. math:: L_g^\top P + P L_g - Z_i < 0, \qquad g \in \{\mathrm{lower}, k\},

    ``V = m^T P m`` falls along every solution for every ``phi(t, sigma)`` in the sector: ``phi/sigma`` is a gain at
    each time, and ``A_g`` and ``V'`` between both ends are mixtures of those at the ends.  For ``p = 1`` this is the
    circle criterion.  With a pole at 0 with the gain ``lower`` (the critical case) ``V`` does not grow, and falls
    where a state but that of the pole is not 0: every solution is bounded.

    In discrete time ``m+ = M_g m`` along ``x+ = A_g x``, and ``P - M_g^T P M_g + Z_i > 0``.  Between the ends ``V``
    may grow; yet products of both ``A_g`` decay, so that a norm falls with both, and with all mixtures of them.

    Parameters
    ----------
    block : RationalPlant
        Of order 2 to 5, with the gain ``lower`` stable, in continuous time but for at most one simple pole at 0, hidden
        modes included.
    lower : Fraction
        Lower end of the sector.
    effort : {"quick", "full"}
        Whether to go up to the highest degree, which for three and five states takes ten times as long.

    Returns
    -------
    CriterionResult
        ``largest.low`` is certified; ``parameters`` hold ``p``.  ``high`` is where linear gains are unstable: that
        nothing larger was found does not mean that the loop is unstable.

    Raises
    ------
    AssumptionError
        The plant is of another order or has other poles with the gain ``lower``; the circle criterion proves every
        finite ``k``.

    Examples
    --------
    The circle criterion ends at 4; a gain that switches between 0 and 5.8007 destabilises.

    >>> round(homogeneous_largest(RationalPlant([1], [1, 3, 3, 1])).largest.low, 1)
    5.7
    """
    search = _Search.of(block, Fraction(lower))
    power = search.most(QUICK if effort == "quick" else HIGHEST)
    (low, ended), high = search.largest(power), search.top
    proved = low > search.circle
    above = (
        f"linear gains are stable only below {text_above(high)}" if high < math.inf else "all linear gains are stable"
    )
    tried = "" if ended else ", the largest that was tried"
    said = (
        f"a form of degree {2 * power} proves every k up to {text_below(low, 15)}{tried}, {above}; {search.conclusion}"
    )
    found = search.result(
        Sector(search.lower, low if proved else math.inf),
        Bracket(low, max(high, low)),
        power if proved else None,
        said if proved else f"no form of degree {2 * power} was found beyond the circle criterion",
    )
    return replace(found, search_limited=not ended)


def homogeneous_criterion(block: RationalPlant, sector: Sector) -> CriterionResult:
    """Whether a form of even degree falls along every loop of one sector; the lowest degree that serves.

    ``block``: as for :func:`homogeneous_largest`; ``sector``: with finite ends.

    Raises
    ------
    InputError
        ``1 + k H(inf) = 0`` for some ``k`` of the sector.
    AssumptionError
        As there; or an end of the sector is infinite.
    """
    if math.inf in (-sector.lower, sector.upper):
        raise AssumptionError(f"{TITLE} needs a sector with finite ends; got {sector}", code=Reason.NO_LOWER_END)
    require_well_posed(block, sector.upper, lower=Fraction(sector.lower))
    search, upper = _Search.of(block, Fraction(sector.lower)), Fraction(sector.upper)
    for power in range(2, search.most(HIGHEST) + 1):
        if search.proof(upper, power) is not None:
            said = f"a form of degree {2 * power} falls along every solution; {search.conclusion}"
            return search.result(sector, Bracket(float(upper), math.inf), power, said)
    largest = Bracket(float(search.lower), math.inf)
    said = f"no form of degree up to {2 * search.most(HIGHEST)} was found; the circle criterion proves every k up to "
    return search.result(sector, largest, None, said + text_below(search.circle))


def homogeneous_proof(block: RationalPlant, answer: CriterionResult, upper: Fraction) -> dict[str, Any] | None:
    """The proof of a certificate for the class of an answer with this upper end; ``answer``: what was proved.

    Returns
    -------
    dict or None
        None where no form of the degree of the answer was found for this class.
    """
    power = int(str(answer.parameters["power"]))
    return _Search.of(block, Fraction(answer.nonlinearity_class.sector.lower)).proof(upper, power)


@described(frozen=True)
class _Search:
    """The classes ``[lower, k]`` of one plant."""

    block: RationalPlant = quantity("The plant, stable or critical with the gain ``lower``")
    lower: Fraction = quantity("Lower end")
    circle: float = quantity("How far the circle criterion goes")
    top: float = quantity("How far linear gains go")

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction) -> _Search:
        """The search, if the criterion covers the plant."""
        if check_plant(block, lower=lower).case == "critical" and block.dt is not None:
            raise AssumptionError(f"{TITLE} does not cover a pole at z = 1; ask circle", code=Reason.NOT_APPLICABLE)
        if block.order not in HIGHEST:
            raise AssumptionError(
                f"{TITLE} is evaluated for plants of order {min(HIGHEST)} to {max(HIGHEST)}, this one has order "
                f"{block.order}; ask circle",
                code=Reason.NOT_APPLICABLE,
            )
        circle = circle_largest(block, lower=lower).largest.low
        if circle == math.inf:
            raise AssumptionError("the circle criterion proves every finite k here; ask circle")
        return cls(block, lower, circle, hurwitz_limit(block, lower).high)

    @cached_property
    def realised(self) -> tuple[Any, Any, Any, Fraction]:
        """``A, b, c, d`` with the gain ``lower`` closed, as the checker reads the block."""
        top, bottom = ([str(v) for v in side] for side in (self.block.numerator, self.block.denominator))
        time = "continuous" if self.block.dt is None else "discrete"
        system = {"kind": "transfer", "time": time, "numerator": top, "denominator": bottom}
        return realised(system, self.lower)[:4]

    def ends(self, upper: Fraction) -> list[Any]:
        """``x' = A x`` with the gain at either end."""
        (A, b, c, d), width = self.realised, upper - self.lower
        return [A, gained(A, b, [width / (1 + width * d) * v for v in c])]

    @cached_property
    def critical(self) -> bool:
        """Whether there is a pole at 0 with the gain ``lower``: then ``x_1`` alone stays where it is."""
        return self.block.dt is None and not any(row[0] for row in self.realised[0])

    def largest(self, power: int) -> tuple[float, bool]:
        """The largest ``k`` that is proved, and whether a larger one was tried and is not.

        Beyond the quick degree from what that proves on, in steps that grow.
        """
        start, low, high, step = float(self.lower), self.circle, self.top, 0.0
        if power > self.most(QUICK):
            low, ended = self.largest(self.most(QUICK))
            step = (low - start) / FIRST
            if not ended:
                return low, False
        for _ in range(STEPS):
            if high < math.inf and high - low <= CLOSE * (high - start):
                break
            k = _short(min((low + high) / 2, low + (step or low - start)), high - low)
            step *= 2
            low, high = (k, high) if self.proof(Fraction(k), power) is not None else (low, k)
        return low, high < math.inf

    def most(self, degrees: Mapping[int, int]) -> int:
        """Half of the highest degree; ``degrees``: by the order."""
        return min(degrees[self.block.order], CRITICAL if self.critical else max(HIGHEST.values()))

    @cached_property
    def coordinates(self) -> list[list[int]]:
        """``r T`` for ``z = T x`` in which a quadratic form near the circle criterion's is ``|z|^2``.

        In the critical case the first row is a multiple of the one that ``A`` makes 0, exactly.

        Raises
        ------
        AssumptionError
            The solver failed.
        """
        k = self.lower + (Fraction(self.circle) - self.lower) * Fraction(7, 8)
        low, high = (in_doubles(A) for A in self.ends(k))
        still = self._at_rest() if self.critical else None
        first = np.eye(len(low))
        if still:
            first[0] = [float(Fraction(v, still[0])) for v in still]
            low, high = (first @ side @ np.linalg.inv(first) for side in (low, high))
        _, scale = balanced(low + high)
        ends = [side * scale / scale[:, None] for side in (low, high)]
        _, P, _ = self.solved(ends, 1)
        try:
            T = np.linalg.cholesky(P).T / scale
        except np.linalg.LinAlgError:
            failed = "the programme for a quadratic form, which the circle criterion promises, failed"
            raise AssumptionError(f"{TITLE}: {failed}; rescale the plant", code=Reason.SOLVER_FAILED) from None
        rows = [[Fraction(float(v)) for v in row] for row in T @ first]
        size = max(abs(v) for row in rows for v in row)
        bits = COORDINATES - math.frexp(float(size))[1] + math.ceil(math.log2(float(np.linalg.cond(T))))
        unit = Fraction(2) ** bits
        if still:  # of which all rows are so many times as long that the first is whole
            unit *= max(1, math.ceil(still[0] / (unit * rows[0][0])))
            rows[0] = [Fraction(round(unit * rows[0][0] / still[0]) * v) / unit for v in still]
        return [[round(v * unit) for v in row] for row in rows]

    def _at_rest(self) -> list[int]:
        """``w`` in integers, ``w^T A = 0``: ``x_1' = x_2`` and so on, and ``x_n'`` follows from these."""
        row = [*(-v for v in self.realised[0][-1][1:]), Fraction(1)]
        unit = math.lcm(*(v.denominator for v in row))
        whole = [int(v * unit) for v in row]
        return [v // math.gcd(*whole) for v in whole]

    def proof(self, upper: Fraction, power: int) -> dict[str, Any] | None:
        """What the checker accepts for the class ``[lower, upper]``; None if nothing is found."""
        checkpoint()
        if 1 + (upper - self.lower) * self.realised[3] <= 0:
            return None  # 1 + g H(inf) vanishes for a gain of the class
        near = np.array(self.coordinates, dtype=float)
        back = np.linalg.inv(near)
        ends = self.ends(upper)
        turned = [near @ in_doubles(A) @ back for A in ends]
        room, P, lines = self.solved(turned, power)
        if not room > ROOM:
            return None
        slow = min(1.0, self.speed(turned))  # Z is that much smaller than P
        unit = 1 << (DIGITS - math.floor(math.log2(room * slow)))
        proof = {"method": "powers", "power": power, **self.rounded(P, lines, power, unit)}
        try:
            require_falling(ends, proof, discrete=self.block.dt is not None)
        except Rejected:
            return None
        return proof

    def speed(self, ends: Sequence[Reals]) -> float:
        """The larger norm of the matrices of both loops, a frequency; in discrete time 1."""
        return 1.0 if self.block.dt is not None else max(float(np.linalg.norm(A, 2)) for A in ends)

    def solved(self, ends: list[Reals], power: int) -> tuple[float, Reals, list[list[float]]]:
        """``t``, ``P`` and the multiples of the vanishing forms with about the largest ``t`` in ``G_i >= t``.

        ``P >= 0`` has the trace of the identity and is one of the monomials times their weights; time is in units in
        which the loops are of size 1.  In the critical case ``z_1^p`` has no part in the first ``G``.
        """
        m, critical, discrete = monomials(len(ends[0]), power), self.critical, self.block.dt is not None
        size, weights, change = len(m), _weights(m), substituted if discrete else lifted
        speed = self.speed(ends)
        by, forms = weights[:, None] * weights, symmetric_basis(size)
        falling, kept = forms.copy(), np.ones(len(forms), dtype=bool)
        for i, other in (_beside_first(m) if critical else {}).items():
            k = i * (i + 1) // 2
            falling[k], kept[k] = 0, other is not None
            for one in [other, other and other[::-1]] if other else []:
                falling[k][one] += by[0, i] / by[one]
        forms, falling = forms[kept], falling[kept]
        pairs = [_vanishing(m, int(critical)), _vanishing(m)]
        count, each = len(forms), [len(side) for side in pairs]
        total, start = count + sum(each) + 1, count
        slopes = np.zeros((3, total, size, size))
        slopes[0, :count], slopes[:, -1] = forms, -np.eye(size)
        for A, part, basis, side in zip(ends, slopes[1:], (falling, forms), pairs, strict=True):
            L = np.array(change((A / speed).tolist(), m), dtype=float) * weights[:, None] / weights
            part[:count] = basis - L.T @ basis @ L if discrete else -(L.T @ basis + basis @ L)
            for Z, both in zip(part[start:], side, strict=False):
                for one, sign in zip(both, (1.0, -1.0), strict=True):
                    Z[one] += sign / by[one]
                    Z[one[::-1]] += sign / by[one]
            start += len(side)
        trace = np.zeros(total)
        trace[:count] = np.trace(forms, axis1=1, axis2=2)
        cost = np.zeros(total)
        cost[-1] = 1.0
        first = int(critical)
        parts = [slopes[0], slopes[1][:, first:, first:], slopes[2]]
        blocks = [Block(np.zeros(part.shape[1:]), part) for part in parts]
        x = proposed(cost, blocks, np.array([trace, -trace]), np.array([size, -size]))
        if x is None:
            return -math.inf, slopes[0, -1], []
        lines = np.split(speed * x[count:-1], [each[0]])
        return float(x[-1]), np.einsum("i,ipq->pq", x[:count], forms), [line.tolist() for line in lines]

    def rounded(self, P: Reals, lines: Sequence[list[float]], power: int, unit: int) -> dict[str, list[list[str]]]:
        """``P``, ``Z_1`` and ``Z_2`` in integers, in the monomials of ``x`` for ``z = T x``.

        In the critical case ``P - Y`` has ``z_1^p`` alone, ``m^T Y m = 0``, and ``Z_1 + L^T Y + Y L`` belongs to ``P``.
        """
        m = monomials(self.block.order, power)
        by, near = _weights(m), np.zeros((4, len(m), len(m)), dtype=object)
        scaled = P * by[:, None] * by * unit
        near[0] = [[round(float(scaled[max(i, j), min(i, j)])) for j in range(len(m))] for i in range(len(m))]
        for Z, line, pairs in zip(near[1:3], lines, (_vanishing(m, int(self.critical)), _vanishing(m)), strict=True):
            for value, pair in zip(line, pairs, strict=True):
                for (i, j), sign in zip(pair, (1, -1), strict=True):
                    Z[i, j] += sign * round(value * unit)
                    Z[j, i] += sign * round(value * unit)
        for h, other in (_beside_first(m) if self.critical else {}).items():
            for (i, j), sign in (((0, h), 1), (other, -1)) if other is not None else ():
                near[3, i, j] += sign * near[0, 0, h]
                near[3, j, i] += sign * near[0, 0, h]
        S = _substituted(self.coordinates, m)
        forms = [S.T @ form @ S for form in near]
        if self.critical:
            L = lifted(self.realised[0], m)
            whole = math.lcm(*(v.denominator for row in L for v in row))
            slope = forms[3] @ np.array([[int(v * whole) for v in row] for row in L], dtype=object)
            forms = [form * whole for form in forms]
            forms[1] = forms[1] + slope + slope.T
        return {name: triangle_texts(M.tolist()) for name, M in zip(("P", "lower", "upper"), forms, strict=False)}

    @property
    def conclusion(self) -> str:
        """What follows."""
        return CONCLUSIONS[self.critical]

    def result(self, sector: Sector, largest: Bracket, power: int | None, reason: str) -> CriterionResult:
        """The answer about a class, PROVED with a power."""
        holds = power is not None
        parameters = {"power": str(power), "k": str(Fraction(sector.upper))} if holds else {}
        return CriterionResult(
            criterion=NAME,
            theorem=THEOREM,
            largest=largest,
            nonlinearity_class=NonlinearityClass(sector=sector, time_varying=True),
            verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
            evidence=Evidence.CERTIFIED,
            multiplier=f"V of degree {2 * power}" if power is not None else None,
            parameters=MappingProxyType(parameters),
            reason=reason,
            hypotheses=(HYPOTHESES[self.critical if self.block.dt is None else 2], ASSUMED) if holds else (ASSUMED,),
        )


def _short(k: float, width: float) -> float:
    """A number of few digits near ``k``, as far as the width of an interval about it tells."""
    unit = math.ldexp(1.0, math.frexp(width)[1] - 6)
    return round(k / unit) * unit if math.isfinite(width) else k


def _weights(m: list[Monomial]) -> Reals:
    """The roots of the numbers of arrangements: with them ``|m(z)|^2 = |z|^(2 p)``."""
    power = sum(m[0])
    counts = [math.factorial(power) / math.prod(map(math.factorial, e)) for e in m]
    return np.asarray(np.sqrt(np.array(counts)))


def _vanishing(m: list[Monomial], start: int = 0) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Pairs of pairs of monomials with one product: the first of a kind, from ``start`` on, with each other one."""
    first, found = dict[Monomial, tuple[int, int]](), []
    for i, j in product(range(start, len(m)), repeat=2):
        if j <= i:
            both = tuple(a + b for a, b in zip(m[i], m[j], strict=True))
            if both in first:
                found.append((first[both], (i, j)))
            else:
                first[both] = (i, j)
    return found


def _beside_first(m: list[Monomial]) -> dict[int, tuple[int, int] | None]:
    """Two monomials with the product of the first, ``z_1^p``, and each other one; None if there are none but these."""
    place, found = {e: i for i, e in enumerate(m)}, dict[int, tuple[int, int] | None]()
    for i, e in enumerate(m[1:], 1):
        j = next(j for j in range(1, len(e)) if e[j])
        step = [int(k == j) - int(k == 0) for k in range(len(e))]
        pair = [tuple(a + sign * b for a, b in zip(f, step, strict=True)) for f, sign in ((m[0], 1), (e, -1))]
        found[i] = None if pair[1] == m[0] else (place[pair[0]], place[pair[1]])
    return found


def _substituted(T: list[list[int]], m: list[Monomial]) -> NDArray[np.object_]:
    """``S`` with ``m(T x) = S m(x)``, in integers."""
    rows = np.zeros((len(m), len(m)), dtype=object)
    place, units = {e: i for i, e in enumerate(m)}, [tuple(int(i == j) for j in range(len(T))) for i in range(len(T))]
    for row, e in zip(rows, m, strict=True):
        total = {tuple([0] * len(T)): 1}
        for line, times in zip(T, e, strict=True):
            for _ in range(times):
                longer = dict[Monomial, int]()
                for (f, v), (one, t) in product(total.items(), zip(units, line, strict=True)):
                    both = tuple(a + b for a, b in zip(f, one, strict=True))
                    longer[both] = longer.get(both, 0) + v * t
                total = longer
        for f, v in total.items():
            row[place[f]] = v
    return rows
