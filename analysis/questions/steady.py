"""The steady response of a loop to a constant input and to a sine: whether there is one alone, and how large it is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.drawing import drawn
from lure.analysis.forced.balance import Balanced, Wave, balanced, multiplier, solutions
from lure.analysis.forced.band import Band, NotEnclosed, band
from lure.analysis.forced.existence import Existing, existing
from lure.analysis.forced.loop import ForcedLoop
from lure.analysis.forced.samples import Falling, falling, sample_band, settled
from lure.analysis.nonlinearity.membership import Status, examined, membership, require_members
from lure.analysis.numerics.doubles import bound_above, bound_below
from lure.analysis.questions.channel_problem import channel_plant, channel_problem
from lure.analysis.questions.decay import RateBound, difference_rate
from lure.analysis.questions.gain import GainBound, l2_gain
from lure.analysis.questions.largest import UNFINISHED, Stopped
from lure.analysis.questions.problem import class_given
from lure.analysis.questions.two_sided import TwoSided
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.arrays import np
from lure.classes import Diagonal, NonlinearityClass, Sector
from lure.errors import InputError
from lure.files.system import LoopSystem
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.reading import as_nonlinearity
from lure.plants import as_plant
from lure.plants.conversion import rational_if_moderate
from lure.plants.multivariable import MultivariablePlant
from lure.plants.performance import Forcing, Performance
from lure.plants.rational import RationalPlant
from lure.record import Page, Record, derived, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked

_COUNTS, _WIDTH = (8, 16, 32, 64, 128), 1e-4  # harmonics; of the band, relative, where no more are taken
_SHIFTS, _BESIDE = (0.1, 1.0, -0.1, 4.0), 1.2937  # of gains where the loop resonates, by 1/|H| near the input's
_SHARED, _APART, _RESONANT = 6, 1e-3, 1e-9  # periods of all subharmonics; of an eigenvalue from those of the input
_NEUTRAL = 1e-6  # of a multiplier from 1
_NAMED = 12  # responses that are all in the sentence


def _ends(bracket: Bracket) -> list[float | None]:
    """Both ends as JSON data: None where nothing is known, for which ``reason``, or the row's evidence, says why."""
    return [end if math.isfinite(end) else None for end in (bracket.low, bracket.high)]


class SteadyPoint(Record):
    """The steady response at one frequency."""

    omega: float = quantity("Frequency of the input; 0 for a constant one", "rad s-1", dims="", key="omega")
    amplitude: Bracket = quantity(
        "Largest ``|z(t)|`` over a period: of every steady response that is shown to exist", plainly=_ends
    )
    sigma: tuple[Bracket, ...] = quantity(
        "Largest ``|sigma_i(t)|`` over a period", plainly=lambda all_of: [_ends(one) for one in all_of], label=""
    )
    computed: float = quantity("The amplitude by harmonic balance, in floating point", "1", dims="", key="computed")
    error: float = quantity(
        "How far ``z`` is from the balanced one at any time, at most", "1", dims="", key="error", form="above"
    )
    harmonics: int = quantity("How many harmonics were balanced", "1", dims="", key="harmonics")
    residual: float = quantity("Mean square root of what they miss of ``phi(sigma)``", form="above")
    evidence: Evidence = quantity(
        "CERTIFIED: a solution exists with that amplitude; COMPUTED: ``computed`` is all that is known"
    )
    alone: bool = quantity("Whether it is proved to be the only bounded one", default=False)
    periods: int = quantity("How many periods of the input it has: more than 1 for a subharmonic", default=1)
    multiplier: float | None = quantity(
        "Where several were looked for, the largest Floquet multiplier, computed: below 1 it attracts what is near",
        default=None,
    )

    @property
    @derived("1", dims="", key="")
    def low(self) -> float:
        """Lower end of the amplitude."""
        return self.amplitude.low

    @property
    @derived("1", dims="", key="")
    def high(self) -> float:
        """Upper end of the amplitude."""
        return self.amplitude.high

    @property
    def attracts(self) -> bool:
        """Whether what is near seems to approach it."""
        return self.multiplier is None or self.multiplier < 1 - _NEUTRAL

    def __str__(self) -> str:
        at = f"at {self.omega:g} rad/s" if self.omega else "to the constant input"
        if self.evidence is not Evidence.CERTIFIED:
            said = f"is about {self.computed:.4g} (computed)"
        else:
            low, high = bound_below(self.amplitude.low), bound_above(self.amplitude.high)
            said = f"is between {low} and {high} (certified)"
        if self.alone:
            return f"{at} the amplitude of z {said}"
        after = f", repeated after {self.periods} periods of the input," if self.periods > 1 else ""
        neutral = self.multiplier is not None and abs(self.multiplier - 1) <= _NEUTRAL
        word = "attracts" if self.attracts else "neither attracts nor repels" if neutral else "repels"
        near = "" if self.multiplier is None else f", {word} what is near (computed)"
        return f"{at} the amplitude of one steady response{after} {said}{near}"


class SteadyResponse(TwoSided):
    r"""Whether a loop forgets where it began, and how large its steady response to an input is."""

    classes: Diagonal = quantity("The classes of the channels")
    known: tuple[str, ...] = quantity("The nonlinearities in words, if they are known", default=())
    forcing: Forcing | None = quantity("The input, if there is one", default=None)
    response: tuple[SteadyPoint, ...] = quantity(
        "The steady response at each frequency, ascending", dims="omega", each=SteadyPoint, default=()
    )
    several: tuple[str, ...] = quantity(
        "Of each frequency at which no solution attracts all others, why: two that exist, certified", default=()
    )
    differences: RateBound | None = quantity(
        "How fast differences of two solutions decay; None where no finite slopes are known", key="", label=""
    )
    incremental: GainBound | None = quantity(
        "How much of what is added to ``mu`` is seen in ``sigma``, of differences", key="", label="", default=None
    )
    outside: bool = quantity("Whether constant gains of the slopes may not belong to the class", key="", default=False)
    assumed: str = quantity("What is believed of the nonlinearities; empty if nothing", default="")
    open_reason: str = quantity("Why the response is not enclosed; empty if it is", key="", label="", default="")
    stopped: Stopped | None = quantity("What ended the search before it was complete", default=None)
    _schema, _kind, _said = "lure-steady/1", "steady response", "sentence"
    _no_truth = "a steady response has a verdict and no truth value; compare result.verdict"

    @property
    @derived()
    def verdict(self) -> Verdict:
        """PROVED: every loop of the class has one bounded solution, which attracts all.  REFUTED: a member has not."""
        if self.several:
            return Verdict.REFUTED
        found = Verdict.INCONCLUSIVE if self.differences is None else self.differences.verdict
        if found is Verdict.REFUTED and (self.known or self.outside):
            return Verdict.INCONCLUSIVE  # a constant gain is not the nonlinearity that is given
        return found

    @property
    @derived()
    def evidence(self) -> Evidence | None:
        """What the verdict rests on; None where there is none."""
        return Evidence.CERTIFIED if self.verdict is not Verdict.INCONCLUSIVE else None

    @property
    @derived(plainly=_ends)
    def rate(self) -> Bracket:
        """How fast differences decay [1/s; in discrete time a factor]: one end is proved, past the other nothing is."""
        if self.differences is None:
            return Bracket(-math.inf, math.inf)
        found = self.differences.rate
        if not (self.known or self.outside):
            return found
        return Bracket(0.0, found.high) if self.differences.time == "discrete" else Bracket(found.low, math.inf)

    @property
    @derived()
    def criterion(self) -> str:
        """The theorem behind the rate; empty if nothing decays."""
        return "" if self.proof is None or self.verdict is not Verdict.PROVED else self.proof.theorem

    @property
    @derived(key="incremental_gain")
    def gain(self) -> float:
        """An incremental L2 gain from what is added to ``mu`` to ``sigma``; infinite where none is proved."""
        return math.inf if self.incremental is None else self.incremental.gain.high

    @property
    @derived()
    def reason(self) -> str:
        """Why it is not proved that one solution attracts all, or how large it is; empty if both are."""
        if self.verdict is not Verdict.INCONCLUSIVE:
            return self.open_reason
        if self.differences is None:
            return "the slopes of phi are not bounded, and no theorem here is about such differences"
        if self.differences.refutation is not None and self.differences.verdict is Verdict.REFUTED:
            return (
                f"differences decay for no class that contains the slopes: {self.differences.witness} a solution does "
                "not, and multipliers of Popov or Zames and Falb say nothing of differences"
            )
        return "the circle criterion does not prove that differences of solutions decay"

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of the rate."""
        return None if self.differences is None else self.differences.proof

    @property
    def refutation(self) -> Refuted | None:
        """What the checker accepted of a member whose differences do not decay, or no faster."""
        return None if self.known or self.outside or self.differences is None else self.differences.refutation

    @property
    def certificates(self) -> dict[str, Mapping[str, Any] | None]:
        """Those of both ends of the rate, and of the incremental gain; None where there is none."""
        gain = None if self.incremental is None else self.incremental.proof
        return super().certificates | {"gain": None if gain is None else gain.certificate}

    @property
    def _sides(self) -> tuple[Checked | None, Checked | None]:
        sides = self.proof, self.refutation
        return sides[::-1] if self.differences is not None and self.differences.time == "discrete" else sides

    plot = drawn("The amplitude over frequency with its band; see :func:`lure.analysis.plots.plot_steady`.")

    @property
    def drawn(self) -> bool:
        """Whether there is a frequency to draw."""
        return any(row.omega and row.computed > 0 for row in self.response)

    @property
    def _of(self) -> str:
        return " and ".join(self.known) if self.known else str(self.classes)

    def __str__(self) -> str:
        whole = " and ".join(dict.fromkeys(self.known)) if self.known else str(self.classes)
        given = ", ".join(filter(None, (whole, self.assumed)))
        if self.several:
            said = f"No solution attracts all others for {given}: {self.several[0]}."
        elif self.differences is not None and self.verdict is Verdict.PROVED:
            low, high = self.differences.rate.low, self.differences.rate.high
            discrete = self.differences.time == "discrete"
            falls = f"{bound_above(high)}^t (t in samples)" if discrete else f"exp(-{bound_below(low)} t)"
            said = (
                f"One solution is bounded on the whole time axis, and every other approaches it like {falls}, whatever "
            )
            said += f"the bounded input, for {given} ({self.differences.criterion}, certified)."
            said += f" How large it is, is not known: {self.reason}." if self.reason else ""
        elif self.differences is not None and self.verdict is Verdict.REFUTED:
            said = f"Not every loop has a solution that attracts all others for {given}: {self.differences.witness} "
            said += "differences of solutions do not decay."
        else:
            said = f"It is not decided whether one solution attracts all others for {given}: {self.reason}."
        if self.several:
            said += f" {len(self.several) - 1} more frequencies have several." if self.several[1:] else ""
        elif self.response:
            named = self.response
            if len(named) > _NAMED:
                named = tuple(dict.fromkeys([max(named, key=lambda one: one.computed), named[0]]))
            said += "".join(f" {text[0].upper()}{text[1:]}." for text in map(str, named))
            left = len(self.response) - len(named)
            said += f" {left} more responses are in --json alone." if left else ""
        return f"{said} {UNFINISHED[self.stopped] if self.stopped else ''}".rstrip()

    def _page(self) -> Page:
        criterion = "" if self.differences is None else self.differences.criterion
        rows = [("rate of attraction", self.rate), ("proved by", criterion or "-")]
        rows += [("in a sentence", str(self))]
        table = [
            (f"{one.omega:g}", bound_below(one.amplitude.low), bound_above(one.amplitude.high), f"{one.computed:.4g}")
            for one in self.response
        ]
        below = (
            [Page("Amplitude of z", table, head=("omega [rad/s]", "at least", "at most", "computed"))] if table else []
        )
        return Page("Steady response", rows, verdict=str(self.verdict), below=below)


def steady_response(  # noqa: PLR0913  (a loop, what closes it, where w enters, the input and two settings)
    loop: object,
    nonlinearity: object = None,
    forcing: object = None,
    performance: object = None,
    *,
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> SteadyResponse:
    r"""Whether a loop has exactly one bounded solution, which attracts all others, and how large it is.

    .. math:: \dot x = A x + B \mu + B_w w, \quad \sigma = C x + D \mu + D_{\sigma w} w, \quad
        z = C_z x + D_{z\mu} \mu + D_{zw} w, \quad \mu_i = -\phi_i(\sigma_i), \quad w = w_0 + a \sin(\omega t).

    Parameters
    ----------
    loop : LoopSystem, or anything :func:`lure.as_plant` takes
        The loop or its plant, rational.
    nonlinearity : object, optional
        A class with slope bounds or a nonlinearity, a list of them for several channels; those of the system if it is
        not given.
    forcing : mapping or Forcing, optional
        ``amplitude``, ``omega`` [rad/s] and ``constant``; that of the system if it is not given.
    performance : mapping or Performance, optional
        Where ``w`` enters and what ``z`` is, as for :func:`l2_gain`; without one ``w`` is added to ``mu`` and ``z`` is
        ``sigma``.
    seconds : float or None
        Time allowed.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins.

    Returns
    -------
    SteadyResponse
        PROVED is about every nonlinearity with these slopes, and every bounded input.  The amplitudes are about the
        nonlinearity that is given.

    Raises
    ------
    InputError
        No slope bounds are known, the forcing does not fit, or the plant is not rational.

    Notes
    -----
    Differences of two solutions with one input solve the loop with ``phi_1 - phi_2 = g(t) (sigma_1 - sigma_2)``, ``g``
    between the slopes, so that the circle criterion with a rate proves that they decay (Yakubovich 1964; Demidovich
    1961; Pavlov, van de Wouw, Nijmeijer 2006).  The response is that of :mod:`lure.analysis.forced`: harmonics are
    balanced, their residual enclosed in balls, and an incremental gain, certified, makes of it a band.

    Examples
    --------
    >>> from lure import Saturation
    >>> found = steady_response(([1], [1, 1, 1]), Saturation(), {"amplitude": 3, "omega": 1})
    >>> print(found.verdict, round(found.response[0].amplitude.low, 2), round(found.response[0].amplitude.high, 2))
    PROVED 2.69 2.69
    """
    asked = _posed(loop, nonlinearity, forcing, performance)
    tell, stopped = progress or (lambda _step, _done: None), None
    between = _differences(asked.classes, known=bool(asked.known))
    points, several, missing = list[SteadyPoint](), list[str](), list[tuple[str, str]]()
    gain, reason, differences = None, "", None
    began = time.monotonic()
    if between is not None:
        differences = difference_rate(asked.plant, between, seconds=seconds, progress=progress)
    try:
        with time_limit(None if seconds is None else max(1e-3, seconds + began - time.monotonic())):
            if asked.forcing is None or not asked.known:
                pass
            elif between is not None and differences is not None and differences.verdict is Verdict.PROVED:
                tell("the incremental gain", 0.5)
                gain = l2_gain(asked.H, between, _added(asked.H))
                reason = "" if math.isfinite(gain.gain.high) else "no incremental gain is proved"
                factor = differences.rate.high
                for done, point, why in _points(asked, between, gain.gain.high, factor) if not reason else ():
                    points.append(point)
                    missing += [(why, f"{point.omega:g}")] if why else []
                    tell("harmonic balance", 0.6 + 0.4 * done)
            elif asked.H.dt is None:
                for done, found, two in _tried(asked):
                    points += found
                    several += [two] if two else []
                    tell("several solutions", 0.5 + 0.5 * done)
    except TimeoutError:
        stopped = "time"
    return SteadyResponse(
        classes=asked.classes,
        known=tuple(map(str, asked.known)),
        forcing=asked.forcing,
        response=tuple(points),
        several=tuple(several),
        differences=differences,
        incremental=gain,
        outside=any(_narrow(one) for one in asked.classes.classes),
        assumed=asked.assumed,
        open_reason=reason or _missing(missing),
        stopped=cast("Stopped | None", stopped or (None if differences is None else differences.stopped)),
    )


class _Asked(NamedTuple):
    """The question."""

    plant: object
    H: MultivariablePlant
    classes: Diagonal
    known: tuple[Nonlinearity, ...]
    forcing: Forcing | None
    performance: Performance | None
    assumed: str


def _posed(loop: object, given: object, forcing: object, performance: object) -> _Asked:
    plant, known, classes = loop, list[object](), None
    if isinstance(loop, LoopSystem):
        plant = loop.block
        forcing = loop.forcing if forcing is None else forcing
        performance = loop.performance if performance is None else performance
        if given is None:
            if loop.open:
                raise InputError(
                    "no class of nonlinearities is given; give [class] with slope = [l, k], or [nonlinearity]"
                )
            known = [*loop.nonlinearities] or [one for one in (loop.nonlinearity,) if one is not None]
            classes = loop.classes or (
                None if loop.nonlinearity_class is None else Diagonal((loop.nonlinearity_class,))
            )
    if given is not None:
        listed = given if isinstance(given, list | tuple | Diagonal) else [given]
        if isinstance(listed, Diagonal) or all(class_given(one) is not None for one in listed):
            classes = channel_problem(plant, listed).classes
        else:
            known = list(listed)
    H, tested = channel_plant(plant), tuple[Nonlinearity, ...]()
    if known:
        checked = [examined(as_nonlinearity(one)) for one in known]
        tested, own = tuple(one.nonlinearity for one in checked), tuple(one.nonlinearity_class for one in checked)
        if classes is not None and all(one.linear or one.slope is not None for one in classes.classes):
            require_members(tested, classes.classes)
        else:
            classes = Diagonal(own, repeated=tuple(len(list(block)) for _, block in groupby(tested)))
    if classes is None:
        raise InputError("no class of nonlinearities is given; give one with slope bounds, or a nonlinearity")
    if len(classes.classes) != H.inputs or H.inputs != H.outputs:
        given = "1 class is" if len(classes.classes) == 1 else f"{len(classes.classes)} classes are"
        raise InputError(f"{given} given, and the plant has {H.size}; give one for each channel")
    moved = None if forcing is None else Forcing.given(forcing)
    sides = None if performance is None else Performance.given(performance)
    if moved is not None:
        width = H.inputs if sides is None else sides.inputs
        if moved.inputs != width:
            entries = "1 entry" if moved.inputs == 1 else f"{moved.inputs} entries"
            raise InputError(f"forcing has {entries}, and w has {width}; give one for each")
    assumed = _assumed(tested, classes)
    exact = rational_if_moderate(as_plant(plant))
    return _Asked(exact if isinstance(exact, RationalPlant) else H, H, classes, tested, moved, sides, assumed)


def _assumed(known: tuple[Nonlinearity, ...], classes: Diagonal) -> str:
    """What is declared of slopes and not shown."""
    for one, own in zip(known, classes.classes, strict=False):
        if membership(one, own).status is not Status.CHECKED:
            return "whose slopes are as declared"
    return ""


def _narrow(one: NonlinearityClass) -> bool:
    """Whether constant gains between the slopes need not be members of the class."""
    slope, ends_of = one.slope, (one.sector.lower, one.sector.upper)
    return one.rectifier or (not one.linear and slope is not None and (slope.lower, slope.upper) != ends_of)


def _differences(classes: Diagonal, *, known: bool) -> Diagonal | None:
    """What differences of two solutions see: gains between the slopes that vary; None where these are infinite."""
    found = list[NonlinearityClass]()
    for i, one in enumerate(classes.classes, 1):
        slope = one.slope
        if one.linear and not one.operator:
            found.append(one)
            continue
        if one.operator or one.memory or slope is None or math.inf in map(abs, (slope.lower, slope.upper)):
            if known:
                return None
            where = f"channel {i}" if len(classes.classes) > 1 else "the class"
            raise InputError(
                f"{where} is {one}, without finite bounds of its slope, on which steady responses rest; give "
                "slope = [l, k]"
            )
        found.append(NonlinearityClass(sector=Sector(slope.lower, slope.upper), time_varying=True))
    return Diagonal(tuple(found), repeated=classes.repeated)


def _added(H: MultivariablePlant) -> Performance:
    """From what is added to ``mu`` to ``sigma``."""
    return Performance(Bw=H.B, Cz=H.C, Dzw=H.D, Dzmu=H.D, Dsigmaw=H.D)


def _waves(loop: ForcedLoop, forcing: Forcing, dt: Fraction | None = None) -> Iterator[tuple[float, Wave]]:
    """The inputs, one for each frequency, in discrete time its angle, with what share of them is done then."""
    step, zeros = Fraction(dt or 1), (Fraction(0),) * forcing.inputs
    omegas = sorted(set(forcing.omega)) if forcing.omega else [Fraction(0)]
    if any(forcing.amplitude) and not forcing.omega:
        omegas = [one / step for one in loop.frequencies()]
    for i, omega in enumerate(omegas, 1):
        checkpoint()
        yield i / len(omegas), Wave(forcing.constant or zeros, forcing.amplitude or zeros, omega * step)


def _points(asked: _Asked, between: Diagonal, gain: float, factor: float) -> Iterator[tuple[float, SteadyPoint, str]]:
    """The response at each frequency, where one solution attracts all, in discrete time with this factor."""
    slopes = [(Fraction(one.sector.lower), Fraction(one.sector.upper)) for one in between.classes]
    loop = ForcedLoop.around(asked.H, asked.performance, asked.known, slopes)
    waves, V, step = list(_waves(loop, cast("Forcing", asked.forcing), asked.H.dt)), None, Fraction(asked.H.dt or 1)
    if loop.discrete and any(wave.omega for _, wave in waves):
        V = falling(loop, factor)
    for done, wave in waves:
        checkpoint()
        if not (loop.discrete and wave.omega):
            yield done, *_point(loop, wave, gain)
            continue
        point, why = _sampled_point(loop, wave, V)
        yield done, replace(point, omega=float(wave.omega / step)), why


def _tried(asked: _Asked) -> Iterator[tuple[float, list[SteadyPoint], str]]:
    """The solutions that are found at each frequency, and what is said of two of which it is shown that they exist."""
    middle = [_inside(one) for one in asked.known]

    def around(share: Fraction) -> ForcedLoop:
        """The loop around other gains: with those in the middle it may resonate with the input."""
        gains = [(g + share,) * 2 for g in middle]
        return ForcedLoop.around(asked.H, asked.performance, asked.known, gains)

    loops = [around(Fraction(0))]
    for done, wave in _waves(loops[0], cast("Forcing", asked.forcing)):
        if not wave.omega:
            continue
        base = float(wave.omega) / _SHARED
        if loops[0].resonance(base) < _APART and not any(map(any, loops[0].D.tolist())):
            size = loops[0].size(_BESIDE * float(wave.omega))
            loops = [loops[0], *(around(Fraction(f"{share / size:.3g}")) for share in _SHIFTS)]
        loop = max(loops, key=lambda one: min(one.resonance(base), _APART))  # the first of equals
        if loop.resonance(base) < _RESONANT:
            continue
        tried = [(found, existing(loop, found)) for found in solutions(loop, wave)]
        rows = [_row(loop, found, one, multiplier(loop, found)) for found, one in tried]
        shown = [(one, row) for (_, one), row in zip(tried, rows, strict=True) if one is not None]
        said = next((_both(row, None) for one, row in shown if one.subharmonic), "")
        for one, row in reversed(shown[1:]):
            if not said and shown[0][0].apart(one):
                said = _both(shown[0][1], row)
        yield done, rows, said


def _missing(found: list[tuple[str, str]]) -> str:
    """Why there is no band, and at which frequencies; empty if there is one at each."""
    at = [omega for _, omega in found]
    where = f"{', '.join(at)} rad/s" if len(at) <= _NAMED else f"{len(at)} frequencies"
    return f"{found[0][0]} at {where}" if found else ""


def _both(row: SteadyPoint, other: SteadyPoint | None) -> str:
    """Two solutions in words; without the other, one that differs from itself a period of the input later."""
    first = f"{bound_below(row.amplitude.low)} to {bound_above(row.amplitude.high)}"
    at = f"to the input of {row.omega:g} rad/s there is a steady response of amplitude {first}"
    if other is None:
        return f"{at} that repeats after {row.periods} periods of it only, and so another, a period later (certified)"
    return f"{at}, and another of {bound_below(other.amplitude.low)} to {bound_above(other.amplitude.high)} (certified)"


def _row(
    loop: ForcedLoop, found: Balanced, shown: Band | Existing | None, largest: float = math.inf, *, alone: bool = False
) -> SteadyPoint:
    """One solution."""
    nothing = Bracket(0.0, math.inf)
    return SteadyPoint(
        omega=float(found.wave.omega),
        amplitude=nothing if shown is None else shown.z,
        sigma=(nothing,) * loop.channels if shown is None else shown.sigma,
        computed=found.peak,
        error=math.inf if shown is None else shown.error,
        harmonics=found.count,
        residual=found.missed if shown is None else shown.residual,
        evidence=Evidence.COMPUTED if shown is None else Evidence.CERTIFIED,
        alone=alone,
        periods=found.wave.periods,
        multiplier=largest if math.isfinite(largest) else None,
    )


def _inside(phi: Nonlinearity) -> Fraction:
    """A gain to take out of a nonlinearity: the middle of its slopes, or that at 0."""
    bounds = getattr(phi, "slope_bounds", None)
    if bounds is not None and math.inf not in map(abs, (bounds.lower, bounds.upper)):
        return (Fraction(bounds.lower) + Fraction(bounds.upper)) / 2
    slope = float(phi.slope(0.0))  # type: ignore[attr-defined]  # what has an enclosure has one
    return Fraction(slope).limit_denominator(1000) if math.isfinite(slope) else Fraction(0)


def _point(loop: ForcedLoop, wave: Wave, gain: float) -> tuple[SteadyPoint, str]:
    """More and more harmonics, until the band is narrow; and why there is no band, empty if there is one."""
    psi, smooth = np.zeros((loop.channels, 1), complex), loop.smoothing(wave.base)
    whole = np.array([float(one.mid()) for one in smooth])
    slack = (1 + gain * float(max(loop.spread))) * float(whole[loop.channels :].max())
    for count in _COUNTS if wave.omega else (0,):
        found = balanced(loop, wave, psi, count)
        psi = found.psi
        if slack * found.missed * loop.beyond(float(wave.base), count, whole) < _WIDTH * found.peak:
            break
    try:
        shown, why = band(loop, found, Fraction(gain), smooth), ""
    except NotEnclosed as error:
        shown, why = None, str(error)
    return _row(loop, found, shown, alone=True), why


def _sampled_point(loop: ForcedLoop, wave: Wave, V: Falling | None) -> tuple[SteadyPoint, str]:
    """The same of a sampled sine, whose solution goes through all phases."""
    found = settled(loop, wave)
    shown, why = None, "no function of the state is found that falls along differences by so much"
    if V is not None:
        try:
            shown, why = sample_band(loop, found, V), ""
        except NotEnclosed as error:
            why = str(error)
    return _row(loop, found, shown, alone=True), why
