"""How fast every loop of a class decays, from both sides: a rate with a certificate, and a member that is slower."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, TypeAlias

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.drawing import drawn
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above, double_below
from lure.analysis.numerics.evidence import Bracket, ends
from lure.analysis.questions.channel_kinds import has_channels
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.decay_channels import LateChannels, SeveralChannels, about_words, accepted
from lure.analysis.questions.decay_families import CLOSE, BoxOfChannels, BoxOfPlants, OneChannel, require_known
from lure.analysis.questions.largest import UNFINISHED, Stopped
from lure.analysis.questions.problem import class_given, loop_given, posed
from lure.analysis.questions.two_sided import TwoSided
from lure.analysis.theorems.table import BEST
from lure.analysis.verdict import Evidence, Verdict
from lure.analysis.wording import counterexample as counterexample_in_words
from lure.analysis.wording import proviso
from lure.classes import Diagonal
from lure.errors import InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, one_channel_of
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from lure.record import Page, derived, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked

Time = Literal["continuous", "discrete"]
_FAR, _AT_REST = 1e-4, 1e-12
_LARGEST = Fraction(sys.float_info.max)
_GROWTHS = (1, 16, 256, 4096)  # by what a bound of a growth exceeds a limit, over that
_BESIDE = tuple(Fraction(1, 10**digits) for digits in (8, 6, 4))
_NEAR = tuple(Fraction(1, 10**digits) for digits in (15, 12, 9, 7))
_SNAP = 10**6  # denominators of rates that may be exact


class RateBound(TwoSided):
    r"""How fast every solution of every loop of a class decays: ``|x(t)| <= c |x(0)| e^(-rate t)``, or ``rate^t``.

    With dead time the greatest ``|x|`` before ``t = 0`` stands for ``|x(0)|``.

    In continuous time the largest such rate [1/s], in discrete time the smallest factor per sample, with one ``c`` for
    the class.
    """

    time: Time = quantity("In which time: what the rate means")
    rate: Bracket = quantity(
        "Continuous time: ``low`` is proved, ``-inf`` for nothing, and no rate above ``high`` is true.  Discrete time: "
        "``high`` is proved, ``inf`` for nothing, and no factor below ``low`` is true",
        plainly=ends,
    )
    classes: Diagonal = quantity("The class of each channel")
    nonlinearity_class: str = quantity("The classes in words, as the certificates have them", key="")
    proof: Proved | None = quantity(
        "What the checker accepted of the rate that is proved, with its certificate", key="", label="", default=None
    )
    refutation: Refuted | None = quantity(
        "What the checker accepted of a slower member, with its certificate", key="", label="", default=None
    )
    reason: str = quantity("Why no decay is proved; empty if it is", default="")
    stopped: Stopped | None = quantity(
        "What ended the search before it was complete; what is claimed was shown all the same", default=None
    )
    _schema, _kind, _said = "lure-rate/1", "decay rate", "sentence"
    _no_truth = "a rate has bounds and no truth value; compare result.verdict"

    @property
    @derived()
    def verdict(self) -> Verdict:
        """PROVED: every solution decays exponentially.  REFUTED: one of a member does not.  INCONCLUSIVE: neither."""
        low, high, discrete = self.rate.low, self.rate.high, self.time == "discrete"
        if (high < 1) if discrete else (low > 0):
            return Verdict.PROVED
        return Verdict.REFUTED if ((low >= 1) if discrete else (high <= 0)) else Verdict.INCONCLUSIVE

    @property
    @derived()
    def criterion(self) -> str:
        """The theorem behind the rate that is proved; empty if none is."""
        return "" if self.proof is None else self.proof.theorem

    @property
    @derived()
    def evidence(self) -> Evidence | None:
        """What the bounds rest on; None where there is none."""
        return Evidence.CERTIFIED if self.proof is not None or self.refutation is not None else None

    @property
    @derived()
    def witness(self) -> str:
        """The member that is no faster than the other end says; empty if none was found."""
        return "" if self.refutation is None else _member(self.refutation)

    @property
    @derived()
    def assumed(self) -> str:
        """What the proof assumes of the nonlinearities beyond their class; empty if nothing."""
        return "" if self.proof is None else proviso(self.proof)

    @property
    def _sides(self) -> tuple[Checked | None, Checked | None]:
        return (self.refutation, self.proof) if self.time == "discrete" else (self.proof, self.refutation)

    @property
    @derived()
    def closed(self) -> bool:
        """Whether what is proved and what is refuted meet, within one part in a million."""
        size = max(abs(self.rate.low), abs(self.rate.high))
        return math.isfinite(size) and self.rate.width <= 2e-6 * size

    plot = drawn(
        "The eigenvalues with constant gains of the class, and both rates; see :func:`lure.analysis.plots.plot_rate`."
    )

    def __str__(self) -> str:
        against = "" if self.refutation is None else f"{self.witness} a solution {self._slow(self.refutation)}"
        said = f"No rate is proved for {self.nonlinearity_class}"
        if self.refutation is not None and self.verdict is Verdict.REFUTED:
            about = about_words(self.refutation.certificate, inwards=False)
            said, against = f"Not every solution decays for all members of the class ({about}): {against}", ""
        if self.proof is not None:
            said = "No decay is proved" if self.verdict is Verdict.INCONCLUSIVE else said
            said = "Every" if self.verdict is Verdict.PROVED else f"{said}; every"
            like, late = self._like(rate_of(self.proof), proved=True), "late" in self.proof.certificate["system"]
            whole = ", ".join(filter(None, (self.nonlinearity_class, self.assumed)))
            start, told = ("m", ", m the greatest |x| before t = 0,") if late else ("|x(0)|", "")
            said += f" solution satisfies |x(t)| <= c {start} {like}{self._unit}{told} with one c for {whole}"
            said += f" ({self.criterion}, certified)"
        said += f"; {against}" if against else ""
        return f"{said}. {UNFINISHED[self.stopped] if self.stopped else ''}".rstrip()

    def _like(self, rate: Fraction, *, proved: bool = False) -> str:
        """How fast that is, rounded to the slower side for a proof, to the faster for a member."""
        if self.time == "discrete":
            return f"{(bound_above if proved else bound_below)(rate)}^t"
        return f"exp({(bound_above if proved else bound_below)(-rate)} t)"

    def _slow(self, shown: Refuted) -> str:
        """What a solution of a member does."""
        rate = rate_of(shown)
        still = 1 if self.time == "discrete" else 0
        if rate == still:
            return "does not decay"
        grows = rate > 1 if self.time == "discrete" else rate < 0
        unit = "" if self.proof else self._unit  # said once
        return f"{'grows at least like' if grows else 'decays no faster than'} {self._like(rate)}{unit}"

    @property
    def _unit(self) -> str:
        """What ``t`` counts, where a reader could take it for a time."""
        return " (t in samples)" if self.time == "discrete" else ""

    def _page(self) -> Page:
        unit = "per sample" if self.time == "discrete" else "1/s"
        rows = [
            (f"rate [{unit}]", self.rate),
            ("proved by", self.criterion or "-"),
            ("slower member", self.witness or "-"),
            ("in a sentence", str(self)),
        ]
        return Page(f"Decay rate: {self.nonlinearity_class}", rows, verdict=str(self.verdict))


def decay_rate(
    loop: object,
    nonlinearity: object = None,
    *,
    worst: bool = False,
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> RateBound:
    r"""The exponential rate at which every solution of every loop of a class decays, from both sides.

    For ``x' = A x + B mu``, ``sigma = C x + D mu``, ``mu = -phi(sigma)`` the supremum of the ``a`` with

    .. math:: |x(t)| \le c\, e^{-a t}\, |x(0)| \qquad (t \ge 0)

    for one ``c`` and every ``phi`` of the class; in discrete time, ``x+`` for ``x'``, the infimum of the ``r`` with
    ``|x(t)| <= c r^t |x(0)|``.

    Parameters
    ----------
    loop : LoopSystem, Loop, or anything :func:`lure.plants.as_plant` takes
        The loop, with a rational plant or one with dead time, which may come back late inside.
    nonlinearity : object
        The class of nonlinearities, as for :func:`lure.analysis.certify`; by default that of the loop.
    worst : bool
        Whether slower solutions than those with constant gains are looked for in discrete time, of one function with
        bounds of its slope: such that repeat on another scale.  That takes some ten seconds.
    seconds : float or None
        Time allowed; when it is over the best bounds so far are returned.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins.

    Returns
    -------
    RateBound
        Continuous time: ``rate.low`` is certified for the class, and no larger rate than ``rate.high`` is true.
        Discrete time: ``rate.high`` is certified, and no smaller factor than ``rate.low`` is true.

    Raises
    ------
    InputError
        The loop or the class is no good, no class is given, a bound is infinite, or the plant is of another kind.

    Notes
    -----
    ``xi = x e^(a t)`` solves the loop with ``A + a`` and a nonlinearity in the same sector that depends on time (in
    discrete time ``A/r`` and ``B/r``), so that the circle criterion decides; Zames-Falb multipliers, weighed by
    powers of ``r``, go farther for bounds of the slope; see ``docs/theory/rates.md``.  A constant gain of the class,
    found among the eigenvalues, bounds the rate from the other side, for time-varying classes one that jumps; or a
    periodic orbit shows that nothing decays.  Beside dead time the circle criterion, Popov's terms of slope
    bounds, and gains that are constant or jump are all.

    Examples
    --------
    A step of length 1/10 down the gradient of a function with slopes in [1, 10]:

    >>> from lure import SlopeBounds
    >>> found = decay_rate(RationalPlant([Fraction(1, 10)], [1, -1], dt=1), SlopeBounds(1, 10))
    >>> round(found.rate.low, 12), round(found.rate.high, 12)
    (0.9, 0.9)
    """
    if has_channels(loop, nonlinearity):
        problem = channel_problem(loop, nonlinearity, late=True)
        if problem.kind != "class":
            raise InputError("no class of nonlinearities is given; give one for each channel, in order")
        if isinstance(problem.plant, ChannelFamily):
            return _answered(BoxOfChannels(problem), seconds, progress)
        several = LateChannels if isinstance(problem.plant, DelayMatrix) else SeveralChannels
        return _answered(several(problem), seconds, progress)
    given = class_given(nonlinearity)
    asked = posed(loop if given else loop_given(loop, nonlinearity), given, criterion=BEST, finite=False)
    if isinstance(asked.plant, DelayPlant):
        require_known(asked)
        listed = channel_problem(one_channel_of(asked.plant), [asked.nonlinearity_class], late=True)
        return _answered(LateChannels(listed), seconds, progress)
    of_one = BoxOfPlants if isinstance(asked.plant, PlantFamily) else OneChannel
    return _answered(of_one(asked), seconds, progress, worst=worst)


_Loop: TypeAlias = OneChannel | BoxOfPlants | BoxOfChannels | SeveralChannels


def _answered(
    loop: _Loop,
    seconds: float | None,
    progress: Callable[[str, float], None] | None,
    *,
    jumping: bool = True,
    worst: bool = False,
) -> RateBound:
    """Both sides, the slowest gain first; without ``jumping`` constant gains are all that is looked at."""
    tell = progress or (lambda _step, _done: None)
    discrete, stopped = loop.discrete, None
    proof: tuple[Fraction, Proved] | None = None
    refuted: tuple[Fraction, Refuted] | None = None
    try:
        with time_limit(seconds):
            tell("constant gains", 0.0)
            refuted = _refuted(loop)
            tell("the circle criterion", 0.2)
            end = None if refuted is None else refuted[0]
            for better in loop.proofs(end) if isinstance(loop, BoxOfChannels) else _proofs(loop, end):
                proof = better
            if proof is None or end is None or abs(proof[0] - end) > 2 * loop.close * abs(proof[0]):
                tell("Zames-Falb multipliers", 0.4)
                for better in loop.by_multipliers(end, None if proof is None else proof[0]):
                    proof = better
                if jumping:
                    tell("gains that jump", 0.7)
                    refuted = _slower(loop, refuted)
                if worst:
                    tell("solutions that repeat on another scale", 0.75)
                    for slower in _rescaled(loop, refuted, proof):
                        refuted = slower
            if jumping and not _decays(loop, proof) and not (refuted is not None and _lasting(loop, refuted[0])):
                tell("counterexamples", 0.8)
                lasting = loop.lasting()
                refuted = refuted if lasting is None else (Fraction(int(discrete)), lasting)
    except TimeoutError:
        stopped = "time"
    except KeyboardInterrupt:
        if proof is None and refuted is None:
            raise
        stopped = "interrupt"
    found, against = (None if one is None else one[0] for one in (proof, refuted))
    if discrete:
        bounds = Bracket(
            0.0 if against is None else double_below(against), math.inf if found is None else double_above(found)
        )
    else:
        bounds = Bracket(
            -math.inf if found is None else double_below(found), math.inf if against is None else double_above(against)
        )
    reason = "" if _decays(loop, proof) else "no proof was found that every solution decays exponentially"
    return RateBound(
        time="discrete" if discrete else "continuous",
        rate=bounds,
        classes=loop.asked.classes,
        nonlinearity_class=loop.words,
        proof=None if proof is None else proof[1],
        refutation=None if refuted is None else refuted[1],
        reason=reason,
        stopped=stopped,  # type: ignore[arg-type]  # one of the two
    )


def difference_rate(
    plant: object,
    classes: Diagonal,
    *,
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> RateBound:
    """The rate at which any two solutions of one loop with one input approach each other, from both sides.

    Their difference solves the loop with gains ``g_i(t)`` between the slopes.  Against a rate speak constant gains
    alone: those that jump belong to no ``phi`` of ``sigma``.

    Parameters
    ----------
    plant : object
        As for :func:`decay_rate`, of one channel as a rational function.
    classes : Diagonal
        Of the differences: constant gains, or time-varying sectors.
    seconds, progress : optional
        As for :func:`decay_rate`.
    """
    if isinstance(plant, RationalPlant):
        loop = OneChannel(posed(plant, classes.classes[0], criterion=BEST, finite=False))
        return _answered(loop, seconds, progress, jumping=False)
    return _answered(SeveralChannels(channel_problem(plant, classes)), seconds, progress, jumping=False)


def _decays(loop: _Loop, proof: tuple[Fraction, Proved] | None) -> bool:
    """Whether what is proved is a decay, and not a bound of a growth."""
    return proof is not None and not _lasting(loop, proof[0])


def _lasting(loop: _Loop, rate: Fraction) -> bool:
    """Whether a member of that rate has a solution that does not decay."""
    return rate >= 1 if loop.discrete else rate <= 0


def _refuted(loop: _Loop) -> tuple[Fraction, Refuted] | None:
    """The slowest constant gain with the best rate that the checker accepts of it."""
    slowest, _ = loop.slowest
    if not math.isfinite(slowest):
        return None
    value, slack = Fraction(slowest), -1 if loop.discrete else 1
    if not loop.discrete and abs(slowest) <= _AT_REST:
        shown = loop.refute(Fraction(0))
        return None if shown is None else (Fraction(0), shown)
    short = ((value.limit_denominator(most), within) for most, within in ((_SNAP, _NEAR[2]), (1000, CLOSE)))
    tried = [near for near, within in short if abs(near - value) <= within * abs(value)]
    tried += [value + slack * step * abs(value) for step in (*_NEAR, Fraction(1, 10**5), Fraction(1, 10**3))]
    for rate in tried:
        checkpoint()
        if rate and (rate > 0 or not loop.discrete) and (shown := loop.refute(rate)) is not None:
            return rate, shown
    if not loop.discrete and value <= 0 and (shown := loop.refute(Fraction(0))) is not None:
        return Fraction(0), shown  # a gain that does not decay: the loop itself refutes
    return None


def _slower(loop: _Loop, known: tuple[Fraction, Refuted] | None) -> tuple[Fraction, Refuted] | None:
    """Gains that jump, where they may and are slower than the constant ones known."""
    for rate, proof in loop.patterns:
        if known is not None and (rate <= known[0] if loop.discrete else rate >= known[0]):
            return known
        draft = {"verdict": "REFUTED", **loop.base, "theorem": "counterexample", "proof": proof}
        shown = accepted({**draft, "rate": str(rate)})
        if isinstance(shown, Refuted):
            return rate, shown
    return known


def _rescaled(
    loop: _Loop, known: tuple[Fraction, Refuted] | None, proof: tuple[Fraction, Proved] | None
) -> Iterator[tuple[Fraction, Refuted]]:
    """Solutions that repeat on another scale and are slower than what is known, each slower than the last."""
    between = float(known[0]) if known is not None else 1e-3, float(proof[0]) if proof is not None else 1.0
    for rate, found in loop.rescaled(*between):
        shown = loop.refuted_by(rate, found)
        if shown is not None:
            yield rate, shown


def _proofs(
    loop: OneChannel | BoxOfPlants | SeveralChannels, refuted: Fraction | None
) -> Iterator[tuple[Fraction, Proved]]:
    """Rates that are proved, each better than the one before, by halving; none is beyond what is refuted."""
    one, discrete = Fraction(1), loop.discrete
    best = refuted if refuted is not None else Fraction(0 if discrete else loop.fastest)  # what cannot be improved
    lasting = _lasting(loop, best)
    scale = max(abs(best), Fraction(1, 1000))
    outward = scale if discrete else -scale
    limit = best if lasting else one if discrete else Fraction(0)  # of a decay; beyond it only a growth is bounded
    easier = [] if lasting else [(one - (one - best) * loop.close) if discrete else best * loop.close]
    easier += [limit + part * outward for part in (0, *_GROWTHS)]
    easier = [max(min(rate, _LARGEST), -_LARGEST) for rate in easier]
    guess = loop.expected(easier[1 if lasting else 0], best)
    if abs(guess - float(best)) <= _FAR * float(scale):
        for step in (Fraction(0), *_NEAR, CLOSE):
            rate = best + step * outward
            if (rate > 0 or not discrete) and (shown := loop.prove(rate)) is not None:
                yield rate, shown
                return
    worst = None
    for easy in easier:
        end = Fraction(loop.expected(easy, best))
        steps = [step for step in _BESIDE if end not in (best, easy)]
        beside = [simplest_between(*sorted(end + (easy - end) * step * part for part in (1, 2))) for step in steps]
        for rate in (*beside, easy):
            if (shown := loop.prove(rate)) is not None:
                yield rate, shown
                if abs(rate - end) <= loop.close * scale:
                    return
                worst = rate
                break
        if worst is not None:
            break
        best = easy
    if worst is None:
        return
    scale = max(scale, abs(worst))
    while abs(worst - best) > loop.close * scale:
        middle = _between(*sorted((worst, best)))
        shown = loop.prove(middle)
        if shown is None:
            best = middle
        else:
            worst = middle
            yield middle, shown


def _between(low: Fraction, high: Fraction) -> Fraction:
    """A rational with few digits about the middle."""
    width = (high - low) / 8
    return simplest_between((low + high) / 2 - width, (low + high) / 2 + width)


def rate_of(shown: Proved | Refuted) -> Fraction:
    """The rate of a certificate; one without is about stability."""
    neutral = 1 if shown.certificate["system"]["time"] == "discrete" else 0
    return Fraction(shown.certificate.get("rate", neutral))


def _member(shown: Refuted) -> str:
    """The member of a refutation in words."""
    return (
        "with gains that jump"
        if "switch" in shown.certificate["proof"]["method"]
        else f"with {counterexample_in_words(shown)}"
    )
