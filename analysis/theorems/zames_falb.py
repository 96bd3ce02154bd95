"""Zames and Falb's criterion in continuous time, with the Popov term, for bounded slopes: certified."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial, reduce
from typing import Literal

from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.inequality.protocol import Best, Grounds, Proves
from lure.analysis.inequality.protocol import Multiplier as Weights
from lure.analysis.numerics.doubles import double_below, text_above
from lure.analysis.theorems.criterion import Criterion, slope_criterion
from lure.analysis.theorems.kernel_search import TOLERANCE, Family, Proposal, Scaled, Search, seeds
from lure.analysis.theorems.kernels import Multiplier, check, check_every, margin_near, multiplier_of
from lure.analysis.verdict import Bracket, CriterionResult
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# The largest slope that multipliers of Zames and Falb prove: bisection in floating point, every result proved exactly.

BELOW = (0.0, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5)
CAP = 1e6
CLOSE = 2e-8
TRIVIAL = Multiplier(Fraction(0), ())


@dataclass(frozen=True, slots=True)
class ProvedSlope:
    """A certified slope ``k`` (None: every finite one) and the multiplier that proves it."""

    k: Fraction | None
    multiplier: Multiplier


@described(frozen=True, kw_only=True, slots=True)
class Task:
    """The class ``[lower, k]`` and what is known beforehand."""

    plant: TransferPolynomials = quantity(
        "``H / (1 + lower H)``, strictly stable but for a simple pole at 0, in continuous time"
    )
    lower: Fraction = quantity("Lower slope")
    limit: float = quantity(
        "Every ``k`` looked for is strictly below it: the loop with the gain ``limit`` is not stable, or ``inf``"
    )
    odd: bool = quantity("Whether coefficients may be negative")
    full: bool = quantity("Whether to take more time")

    @property
    def families(self) -> tuple[Family, ...]:
        """The kernels to try, in this order."""
        return ("gamma", "delays", "both") if self.full else ("gamma", "delays")


def largest_proved(task: Task) -> ProvedSlope | None:
    """The largest ``k`` proved; None if not even a small one was."""
    if _static(task.plant):
        edge = _rounded_down(Fraction(min(task.limit, 1e300)), task)
        return every(task, TRIVIAL) or (ProvedSlope(edge, TRIVIAL) if edge and proved(task, edge, TRIVIAL) else None)
    best = _known(task)
    scaled = Scaled.of(task.plant)
    cap = _cap(task, scaled)[0]
    if best is not None and (best.k is None or float((best.k - task.lower) * scaled.gain) >= cap * (1 - CLOSE)):
        return best
    searches = [scaled.search(family, odd=task.odd, full=task.full) for family in task.families]
    for search in searches:
        found = next((certify(task, scaled, search, start) for start in _at_cap(task, scaled, search)), None)
        best = _larger(best, found)
        if found is not None and best is found:
            return every(task, found.multiplier) or found
    for search in reversed(searches):
        start = _farthest(task, scaled, search, best)
        if start is not None:
            best = _larger(best, certify(task, scaled, search, start))
    return best


def _known(task: Task) -> ProvedSlope | None:
    """The best of what less work and stricter assumptions give."""
    if task.full or task.odd:
        easier = [replace(task, full=False)] if task.full else []
        easier += [replace(task, odd=False)] if task.odd else []
        return reduce(_larger, map(largest_proved, easier))
    best: ProvedSlope | None = None
    for k, multiplier in seeds(task.plant.block, task.lower):
        if k is None:
            best = _larger(best, every(task, multiplier))
        elif proved(task, k, multiplier):
            best = _larger(best, ProvedSlope(k, multiplier))
    return best


def _larger(one: ProvedSlope | None, two: ProvedSlope | None) -> ProvedSlope | None:
    if one is None or two is None:
        return one or two
    return two if one.k is not None and (two.k is None or two.k > one.k) else one


def every(task: Task, multiplier: Multiplier) -> ProvedSlope | None:
    """Every finite slope, if this multiplier proves them all."""
    legal = task.limit == math.inf and multiplier.admissible(odd=task.odd)
    return ProvedSlope(None, multiplier) if legal and check_every(task.plant, multiplier) else None


def proved(task: Task, k: Fraction, multiplier: Multiplier) -> bool:
    """Whether the multiplier is legal and proves the slopes ``[lower, k]``."""
    legal = task.lower < k < task.limit and multiplier.admissible(odd=task.odd)
    return legal and check(task.plant, k - task.lower, multiplier).holds


def propose_at(task: Task, k: Fraction) -> ProvedSlope | None:
    """A proof for the slopes ``[lower, k]`` of one class; None if none was found."""
    if not task.lower < k < task.limit:
        return None
    if _static(task.plant):
        return ProvedSlope(k, TRIVIAL) if proved(task, k, TRIVIAL) else None
    for known, multiplier in seeds(task.plant.block, task.lower):
        if (known is None or known >= k) and proved(task, k, multiplier):
            return ProvedSlope(k, multiplier)
    scaled = Scaled.of(task.plant)
    for family in task.families:
        found = _attempts(task, scaled, scaled.search(family, odd=task.odd, full=task.full), k)
        if found is not None:
            return found
    return None


def least_sample(plant: TransferPolynomials, width: Fraction, multiplier: Multiplier) -> float:
    """A frequency [rad/s] near which the left-hand side is least, from samples."""
    if _static(plant):
        return 0.0
    scaled = Scaled.of(plant)
    search = scaled.search("none")
    return search.least(multiplier.scaled(1 / scaled.unit), float(width * scaled.gain)) * float(scaled.unit)


def certify(task: Task, scaled: Scaled, search: Search, start: tuple[float, Proposal]) -> ProvedSlope | None:
    """A proof at, or somewhat below, a slope that the search found feasible."""
    for below in BELOW:
        k = _rounded_down(task.lower + Fraction(start[0] * (1 - below)) / scaled.gain, task)
        if k is None:
            continue
        if proved(task, k, start[1].multiplier.scaled(scaled.unit)):
            return ProvedSlope(k, start[1].multiplier.scaled(scaled.unit))
        found = _attempts(task, scaled, search, k)
        if found is not None:
            return found
    return None


def _attempts(task: Task, scaled: Scaled, search: Search, k: Fraction) -> ProvedSlope | None:
    """Propose and check; a frequency at which the check fails becomes a row of the next programme."""
    width = float((k - task.lower) * scaled.gain)
    for _ in range(6 if task.full else 4):
        proposal = search.propose(width)
        if proposal is None or not proposal.least > 0:
            return None
        multiplier = proposal.multiplier.scaled(scaled.unit)
        found = check(task.plant, k - task.lower, multiplier)
        if found.holds and multiplier.admissible(odd=task.odd):
            return ProvedSlope(k, multiplier)
        if found.where is None or not math.isfinite(found.where):
            return None
        search.add_row(found.where / float(scaled.unit))
    return None


def _cap(task: Task, scaled: Scaled) -> tuple[float, float]:
    """The width, scaled, at which the search stops, and the limit, which may be the same."""
    limit = float((Fraction(task.limit) - task.lower) * scaled.gain) if math.isfinite(task.limit) else math.inf
    return min(CAP, limit), limit


def _at_cap(task: Task, scaled: Scaled, search: Search) -> Iterator[tuple[float, Proposal]]:
    """A multiplier just below the limit or at the largest slope asked for, if the search has one."""
    cap, limit = _cap(task, scaled)
    for width in (cap * (1 - 1e-8), cap * (1 - 1e-6)) if cap == limit else (cap,):
        found = _feasible(search, width)
        if found is not None:
            yield found
            return


def _farthest(task: Task, scaled: Scaled, search: Search, best: ProvedSlope | None) -> tuple[float, Proposal] | None:
    """The largest slope, scaled, at which the search has a multiplier on its fine grid, if above the best known."""
    high, _ = _cap(task, scaled)
    known = float((best.k - task.lower) * scaled.gain) if best is not None and best.k is not None else 1e-3
    found = _feasible(search, known * 1.0005)
    if found is None:
        return None
    width, proposal = found
    while high > width * (1 + (1e-6 if task.full else 1e-4)):
        farther = min(search.largest(proposal.multiplier, width), high * (1 - 1e-9))
        width = max(width, width + (farther - width) * (1 - 1e-6))
        middle = min(math.sqrt(width * high), 8 * width)
        found = _feasible(search, middle)
        if found is None:
            high = middle
        else:
            width, proposal = found
    return width, proposal


def _feasible(search: Search, width: float) -> tuple[float, Proposal] | None:
    proposal = search.propose(width)
    return (width, proposal) if proposal is not None and proposal.least > TOLERANCE else None


def _static(plant: TransferPolynomials) -> bool:
    return plant.d.degree() == 0 or plant.n.degree() < 0


def _rounded_down(k: Fraction, task: Task) -> Fraction | None:
    """The slope as a double of nine digits, in the class and not above ``k``; None if there is none."""
    if not math.isfinite(float(k)):
        return None
    for digits in (9, 12, 15, 17):
        value = float(f"{float(k):.{digits}g}")
        step = abs(value) * 10.0 ** (1 - digits)
        for candidate in (value, float(f"{value - step:.{digits}g}")):
            if task.lower < Fraction(candidate) <= k and candidate < task.limit:
                return Fraction(candidate)
    return None


Effort = Literal["quick", "full"]
TITLE = "the criterion of Zames and Falb"
THEOREM = (
    "Zames-Falb multipliers with a Popov term (G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108; U. Jonsson, "
    "Systems & Control Letters 31 (1997) 85-92; J. Carrasco, M. C. Turner and W. P. Heath, European J. Control 28 "
    "(2016) 1-19)"
)


@described(frozen=True, kw_only=True, slots=True)
class KernelInequality:
    """``Re[M (H + 1/(k - lower)) + i w theta H] > 0`` with kernels whose L1 norm is known, searched for from below."""

    base: RationalInequality = quantity("The circle criterion's, ``M = 1``")
    task: Task = quantity("What the search is to know")

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction, *, odd: bool, full: bool = False) -> KernelInequality:
        """The inequality of a plant that is stable, or in the critical case.

        Raises
        ------
        AssumptionError, InputError
            As :func:`lure.analysis.inequality.checks.admitted_plant`.
        """
        base = RationalInequality.of(block, lower, TITLE, critical=True).unweighted
        limit = hurwitz_limit(block, lower).low
        return cls(base=base, task=Task(plant=base.plant, lower=lower, limit=limit, odd=odd, full=full))

    @property
    def grounds(self) -> Grounds:
        """Those of the circle criterion, but for delays."""
        return replace(self.base.grounds, means="polynomials exactly, delays in ball arithmetic")

    def best(self, enough: Fraction | None = None) -> Best:
        """The farthest multiplier found, or one that is enough; nothing goes beyond the stable linear gains."""
        task, high = self.task, hurwitz_limit(self.task.plant.block, self.task.lower).high
        found = largest_proved(task) if enough is None else propose_at(task, enough)
        if found is None:
            gains = enough is not None and enough >= task.limit
            return Best(
                multiplier=None,
                largest=Bracket(double_below(task.lower), high),
                reason=f"a linear gain up to {text_above(task.limit)} in this class is not stable"
                if gains
                else "no multiplier was found; effort='full' searches for longer, and a smaller class may have one",
            )
        written: Weights = {"lower": str(task.lower), "odd": task.odd, **found.multiplier.to_parameters()}
        touching = found.multiplier.mass == 1 and all(c > 0 for c, _ in found.multiplier.terms)
        limit = f"linear gains are stable only below {text_above(high)}"
        if found.k is None:
            limit = "with coefficients as close to these as k asks for" if touching else ""
        low = math.inf if found.k is None else double_below(found.k)
        best = Best(multiplier=written, largest=Bracket(low, high), formula=str(found.multiplier), limit=limit)
        if found.k is None or enough is not None:
            return best
        margin, worst = self.least(written, found.k)
        return replace(best, margin=margin, worst_frequency=worst)

    def serving(self, best: Best, _proves: Proves) -> Weights:
        """The multiplier found: it serves every smaller class too."""
        assert best.multiplier is not None, "else there is a reason"
        return best.multiplier

    def decide(self, multiplier: Weights, upper: Fraction) -> bool:
        """Whether the multiplier proves the slopes ``[lower, upper]``."""
        return proved(self.task, upper, multiplier_of(multiplier))

    def least(self, multiplier: Weights, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum over frequency of the left-hand side, and where it is attained [rad/s]."""
        task, used, width = self.task, multiplier_of(multiplier), Fraction(upper) - self.task.lower
        worst = least_sample(task.plant, width, used)
        return margin_near(task.plant, width, used, Fraction(worst)), worst


def kernel_criterion(*, odd: bool, effort: Effort) -> Criterion:
    """The criterion for monotone nonlinearities, or for odd ones.

    Parameters
    ----------
    odd : bool
        Which of the two.
    effort : {"quick", "full"}
        How long to search.
    """
    return slope_criterion(
        odd=odd,
        name="zames-falb",
        title=TITLE,
        theorem=THEOREM,
        formula="M(s) + theta s",
        inequality=partial(KernelInequality.of, odd=odd, full=effort == "full"),
        legal="sum of |c_j| at most 1, kernels nonnegative of mass 1: checked on the exact numbers",
        kind="multiplier",
    )


def zames_falb_largest(
    block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0), effort: Effort = "quick"
) -> CriterionResult:
    r"""Largest slope that a Zames-Falb multiplier with a Popov term proves, in continuous time.

    For ``sigma = H mu``, ``mu = -phi(sigma)`` with ``H`` stable, ``1 + k H(inf) > 0`` and ``phi`` time-invariant,
    ``phi(0) = 0``, with slope in ``[0, k]``, the origin is globally asymptotically stable if for some ``eps > 0`` and
    every real ``w``

    .. math:: \mathrm{Re}\,[M(i w)\,(H(i w) + 1/k) + i w \theta\, H(i w)] \ge \varepsilon, \\
        M(i w) = 1 - \sum_j c_j\, \hat h_j(i w), \qquad \sum_j |c_j| \le 1,

    with kernels ``h_j >= 0`` of mass 1 (delays of either sign, gamma densities on either side) and ``theta`` of either
    sign.  All ``c_j >= 0``, unless ``phi`` is odd: then they may have either sign.  Without ``h`` this is Popov's
    criterion, without ``theta`` as well the circle criterion.

    Parameters
    ----------
    block : RationalPlant
        In continuous time; with the gain ``lower`` it is strictly stable, hidden modes included.
    odd : bool
        Whether ``phi`` is known to be odd.  An answer for odd nonlinearities says nothing about others.
    lower : Fraction
        Lower slope: the class ``[lower, k]`` is that of ``[0, k - lower]`` for ``H / (1 + lower H)``.
    effort : {"quick", "full"}
        Time to spend on the search: a few seconds, or up to a minute.  The proof is the same.

    Returns
    -------
    CriterionResult
        ``largest.low`` is certified, up to itself; ``parameters`` are exact and suffice for :func:`recheck`.
        That a larger slope is not reached means neither that the loop is unstable nor that no multiplier does it.

    Raises
    ------
    InputError
        The block is in discrete time, or not well posed at ``lower``.
    AssumptionError
        The block is not strictly stable with the gain ``lower``.

    Notes
    -----
    Why it holds.  Let ``v = phi(sigma)`` and ``e = sigma - v/k``: both are nondecreasing functions of ``sigma``, and
    ``P = int phi d(e)`` satisfies ``P(a) - P(b) <= v(a) (e(a) - e(b))``; hence, for signals in L2, the integral of
    ``v(t) e(t - tau)`` is at most that of ``v e`` for every ``tau`` of either sign, and for odd ``phi`` at least its
    negative.  Summed with weights of total at most 1 (point masses are as good as densities) this gives
    ``int v (M e) dt >= 0``.  The integral of ``v dsigma/dt`` is a difference of two values of ``int phi d(sigma)``:
    zero but for the initial state, so that ``theta`` may have either sign.  With ``v = -mu``, ``e = (H + 1/k) mu`` the
    inequality above bounds the energy of ``mu`` by the initial state.  That signals are in L2 follows by continuation
    from ``phi`` replaced by ``t phi``, ``0 <= t <= 1``, for which everything holds alike; it needs ``H`` stable, and
    ``dsigma/dt`` in L2, hence ``H`` strictly proper.  A direct term ``D`` is moved into the nonlinearity first:
    ``phi (1 + D phi)^-1`` has slope in ``[0, k']``, ``1/k' = 1/k + D``, if ``1 + k D > 0``, and the inequality is the
    same, since ``i w theta D`` has no real part.

    The multiplier comes from linear programmes in floating point; whether it satisfies the inequality is then decided
    for all frequencies, by ``lure.analysis.theorems.kernels``.

    Examples
    --------
    >>> block = RationalPlant([1, Fraction("-0.2"), Fraction("-0.1")], [1, 2, 1, 1])
    >>> f"{zames_falb_largest(block, odd=False).largest.low:.5f}"
    '4.58945'
    """
    return kernel_criterion(odd=odd, effort=effort).largest(block, lower=exact_number(lower, "lower"))


def zames_falb_criterion(
    block: RationalPlant, bounds: SlopeBounds, *, odd: bool, effort: Effort = "quick"
) -> CriterionResult:
    r"""Whether a Zames-Falb multiplier with a Popov term proves one class of slopes, in continuous time.

    The theorem is that of :func:`zames_falb_largest`.

    Parameters
    ----------
    block : RationalPlant
        In continuous time; with the gain ``bounds.lower`` it is strictly stable, hidden modes included.
    bounds : SlopeBounds
        Bounds on the slope of ``phi``, finite; whether every finite ``k`` is proved says :func:`zames_falb_largest`.
    odd : bool
        Whether ``phi`` is known to be odd.
    effort : {"quick", "full"}
        Time to spend on the search.

    Returns
    -------
    CriterionResult
        PROVED with a ``margin``, or INCONCLUSIVE: no multiplier was found, which means neither that the loop is
        unstable nor that there is none.

    Raises
    ------
    InputError
        The block is not well posed at ``bounds.lower``.
    AssumptionError
        The block is in discrete time, a bound is infinite, or the block is not strictly stable with the lower gain.
    """
    return kernel_criterion(odd=odd, effort=effort).decide(block, bounds)


def recheck(block: RationalPlant, parameters: Mapping[str, object]) -> bool:
    r"""Verify a proof again from the block and the exact numbers alone, without any search.

    Parameters
    ----------
    block : RationalPlant
        The block of the answer.
    parameters : Mapping
        ``CriterionResult.parameters`` of a proved answer: ``lower``, ``k``, ``odd``, ``theta`` and ``kernels``.

    Returns
    -------
    bool
        True proves that all nonlinearities with slope in ``[lower, k]`` (odd ones only if ``odd``) leave the origin
        globally asymptotically stable.  False: these numbers prove nothing.

    Raises
    ------
    InputError
        The parameters are not complete, or the block is in discrete time.
    AssumptionError
        The block is not strictly stable with the gain ``lower``.
    """
    multiplier = multiplier_of(parameters)
    try:
        lower, k, odd = Fraction(str(parameters["lower"])), str(parameters["k"]), parameters["odd"]
        width = None if k == "inf" else Fraction(k)
    except (KeyError, ValueError, ZeroDivisionError):
        raise InputError(f"parameters are {dict(parameters)!r}; give lower, k and odd besides the multiplier") from None
    task = KernelInequality.of(block, lower, odd=odd is True).task
    return every(task, multiplier) is not None if width is None else proved(task, width, multiplier)
