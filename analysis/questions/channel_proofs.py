"""Several nonlinearities: what a criterion proves of a factor of the classes, and what gains refute, as checked."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from flint import fmpq_mat

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Plant, ordered
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.frequencies import shifted
from lure.analysis.certificates.memory import from_rest, remembered
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channel_windows import ChannelWindows
from lure.analysis.inequality.channels import MOST_STATES, ChannelInequality, ManyChannels
from lure.analysis.inequality.coupled_forms import CoupledForms
from lure.analysis.inequality.critical_block import CriticalBlock
from lure.analysis.inequality.critical_forms import CriticalForms
from lure.analysis.inequality.full_block import FullBlockInequality
from lure.analysis.inequality.gain_box import GainBox
from lure.analysis.inequality.gain_splines import SPLINES, GainSplines
from lure.analysis.inequality.semidefinite_forms import RestingGain
from lure.analysis.inequality.shifted_loop import LARGEST, ChannelSearch, Proposal
from lure.analysis.inequality.storage import MovedByStops, SampledStorage, StorageInequality
from lure.analysis.inequality.zero_modes import diagonal, doubles, exact
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.questions import channel_families
from lure.analysis.questions.channel_delays import (
    delays_of,
    increments,
    sectors_beside_memory,
    stated,
    wide_channels,
    without_delays,
)
from lure.analysis.questions.channel_hypotheses import (
    constant_gains_of,
    fixed_operators,
    free_channels,
    groups_of,
    is_critical,
    modes_of,
    require_no_zero,
    rising,
    sides_of,
    sloped_channels,
)
from lure.analysis.questions.channel_kernels import KernelSearch, between
from lure.analysis.questions.channel_pieces import LateKernels, PiecewiseProofs
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import BEST, LAST, TABLE, Theorem, time_of
from lure.arrays import NDArray, np
from lure.classes import DELAYS
from lure.errors import AssumptionError, InputError, Reason, did_you_mean
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay_matrix import DelayMatrix

_STEPS_DOWN = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 2e-5, 4e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999)
SCALINGS = "matrix-scalings"
_MEETING = (1e-5, 2e-3)  # relative: how near the ends of a search are that asks for proofs at each step; of kernels
_WORTH = 1e-5  # relative: a criterion that does not prove so much more is left

KINDS = (  # how the names begin, the multipliers in words, and their letter
    ("diagonal", "a multiplier for each channel", "Lambda"),
    ("matrix", "kernels for the channels", "M"),
    ("coupled-windows", "forms of several samples", "M"),
    ("coupled", "forms that couple the channels", "M"),
    ("full-block", "one multiplier for all channels", "Pi"),
    ("order", "a form for each nonlinearity", "M"),
    ("parameter", "a matrix that depends on the gains", "Lambda"),
    ("piecewise", "functions of the frequency for delays", "M"),
    ("storage", "storage functions of play and stop", "Lambda + Theta/s"),
    ("late", "kernels beside dead times", "M"),
)
_KERNELS, _WINDOWS, _COUPLED, _FULL, _ORDERS, PARAMETRIC, _PIECES, STORED, _LATE = range(1, 10)
_SAMPLES, _MANY = (2, 3, 4), 20
_FIRST_OF_MEMORY = "diagonal-circle"


class Criterion(NamedTuple):
    """A row of the table with one kind of multipliers: its name in a certificate.

    ``wide``: of the question with :func:`sectors_beside_memory`.
    """

    name: str
    row: Theorem
    wide: bool = False

    @property
    def kind(self) -> int:
        """Its place among the :data:`KINDS`; those after the first are asked while a gap is left."""
        return next((k for k, (name, _, _) in enumerate(KINDS) if self.name.startswith(name)), 0)


def criteria_for(asked: Problem) -> list[Criterion]:
    """The criteria for several nonlinearities in this time: kind after kind, in each the farthest first.

    Raises
    ------
    InputError
        There is no such criterion.
    """
    wider = sectors_beside_memory(asked)
    ahead = [] if wider is None else [one._replace(wide=True) for one in _criteria_for(wider)]
    return ahead + _criteria_for(asked)


def _criteria_for(asked: Problem) -> list[Criterion]:
    if isinstance(asked.plant, ChannelFamily):
        shown = {name: row for row in TABLE for name in row.channels}
        return [Criterion(name, shown[name]) for name in channel_families.criteria(asked)]
    wanted = asked.criterion.replace("_", "-").lower()
    if isinstance(asked.plant, DelayMatrix):
        return _late_criteria(asked, wanted)
    stored = _stored(asked)
    try:
        asked = increments(asked)
    except AssumptionError:  # which the first of them then says
        return [Criterion(name, row) for row in TABLE for name in row.channels if name == _FIRST_OF_MEMORY]
    cheap = asked.kind == "class" and len(asked.classes.classes) > _MANY  # then the first proof will do
    rows = [row for row in (TABLE if cheap else reversed(TABLE)) if row.channels and time_of(asked.plant) in row.times]
    if not all(one.linear and one.rate is None for one in asked.classes.classes):
        rows = [row for row in rows if not row.linear]
    if not all(map(bool.__or__, sloped_channels(asked), (bool(one.operator) for one in asked.classes.classes))):
        rows = [row for row in rows if row.stage != LAST]
    found = [Criterion(name, row) for row in rows for name in row.channels if wanted in (BEST, row.name, name)]
    scaled = channel_plant(asked.plant).dt is not None and bool(fixed_operators(asked) or constant_gains_of(asked))
    late = [asked.classes.classes[i] for i in delays_of(asked)]
    delayed = any(one.operator == DELAYS[0] or one.rate is not None for one in late)
    rational = time_of(asked.plant) == "continuous" and asked.classes.performance is not None
    rational = rational and bool(fixed_operators(asked) or constant_gains_of(asked))
    served = {PARAMETRIC: _parametric(asked), STORED: stored, _PIECES: delayed or rational}
    found = [x for x in found if served.get(x.kind, True) and (scaled or x.name != SCALINGS)]
    if wanted == BEST:  # one channel needs no full block
        constant, functions = not any(free_channels(asked)), [one for one in asked.classes.classes if not one.operator]
        left = {_FULL, _ORDERS} if asked.classes.rectified else set() if _shared(asked) else {_COUPLED}
        left |= {_FULL} if len(functions) <= 1 else set()
        moving = time_of(asked.plant) == "discrete" and any(any(sides_of(one)) for one in asked.classes.classes)
        sloped = any(sloped_channels(asked)) or moving
        found = [
            x
            for x in found
            if (x.row.time_varying or x.row.linear or x.row.slope or not constant)
            and x.kind not in left
            and (sloped or not x.row.slope or (x.kind == _KERNELS and bool(fixed_operators(asked))))
        ]
        if is_critical(asked):
            kinds = {0, STORED, _COUPLED, _FULL}
            kinds |= {_KERNELS} if rising(asked) and channel_plant(asked.plant).dt is None else set()
            ascending = all(sides_of(one)[0] for one in asked.classes.classes)
            kinds |= {_WINDOWS} if ascending or asked.classes.rectified else set()
            found = [x for x in found if x.kind in kinds and not x.row.linear] or found
    if not found:
        names = [name for row in rows for name in (row.name, *row.channels)]
        raise InputError(
            f"the criterion {asked.criterion!r:.40} does not answer this question in {time_of(asked.plant)} time; "
            f"{did_you_mean(asked.criterion, names, cutoff=0.7)}choose from {BEST}, {', '.join(names)}"
        )
    places = {_PIECES: -1.0 if delayed else 0.7, STORED: 0.5}
    return sorted(found, key=lambda one: (not one.row.linear, places.get(one.kind, one.kind)))


def _stored(asked: Problem) -> bool:
    """Whether there are storage functions: of play and stop, slopes from 0 on; of samples without a gain."""
    classes, flowing = asked.classes, channel_plant(asked.plant).dt is None
    covered = (flowing or not classes.operators) and any(one.memory for one in classes.classes)
    return covered and not any(classes.lower[i] for i in remembered(stated(asked)[1]))


def _late_criteria(asked: Problem, wanted: str) -> list[Criterion]:
    """The criteria for a plant with dead times; Popov's where a channel has such terms, and then alone; kernels."""
    rows = [row for row in reversed(TABLE) if row.channels and "continuous" in row.times]
    every = [Criterion(name, row) for row in rows for name in row.channels]
    named = [x for x in every if x.kind == _PIECES or (x.kind == _LATE and _one_sloped(asked))]
    found = [x for x in named if x.row.time_varying or x.kind == _LATE or any(free_channels(asked))]
    found.sort(key=lambda x: x.kind)
    kernels = [x for x in found if x.kind == _LATE]
    found = [x for x in found if wanted in (x.row.name, x.name)] if wanted != BEST else [*found[:1], *kernels]
    if not found:
        names = ", ".join(name for one in named for name in (one.row.name, one.name))
        raise InputError(
            f"the criterion {asked.criterion!r:.40} is not for these classes beside dead times; choose from {BEST}, "
            f"{names}"
        )
    return found


def _one_sloped(asked: Problem) -> bool:
    """Whether there is one function of which the slopes are within its bounds, at all times the same."""
    one, *others = asked.classes.classes
    alone = not (others or one.linear or one.operator or one.memory)
    return alone and sloped_channels(asked) == [True] and one.slope is not None and sides_of(one) == (True, True)


def _shared(asked: Problem) -> bool:
    """Whether a nonlinearity stands in several channels, so that forms may couple these."""
    return any(len(block) > 1 and not asked.classes.classes[block[0]].operator for block in asked.classes.blocks)


def _parametric(asked: Problem) -> bool:
    """Whether there are unknown gains beside anything but constant ones, none of which ``D`` connects."""
    D, linear = channel_plant(asked.plant).D, [i for i, one in enumerate(asked.classes.classes) if one.linear]
    more = len(linear) < len(D) or any(asked.classes.classes[i].rate is not None for i in linear)
    gains = sum(asked.classes.classes[block[0]].linear for block in asked.classes.blocks)
    more = more and not asked.classes.operators
    return more and 0 < gains <= max(SPLINES) and not any(D[i][j] for i in linear for j in linear)


def searches(asked: Problem, criterion: Criterion) -> Iterator[ChannelSearch]:
    """What searches for proofs by a criterion, the cheapest first.

    Raises
    ------
    AssumptionError
        The loop with the gains at the lower bounds has eigenvalues 0 (z = 1) that no theorem covers.
    """
    before, asked = asked, without_delays(asked)
    H, popov = channel_plant(asked.plant), not criterion.row.time_varying
    if criterion.row.linear or criterion.kind not in (0, STORED, _COUPLED, _WINDOWS, _FULL):
        require_no_zero(asked)
    free, lower = [one and popov for one in free_channels(asked)], np.array([float(v) for v in asked.classes.lower])
    if criterion.row.linear:
        yield GainBox(*H.doubles(), lower, asked.classes.blocks, H.dt is not None)
        return
    if criterion.kind == PARAMETRIC:
        classes = asked.classes
        gains = [block for block in classes.blocks if classes.classes[block[0]].linear]
        rates = [float(classes.classes[block[0]].rate or 0) for block in gains]
        for degree, pieces in SPLINES[len(gains)]:
            loop = (*H.doubles(), lower, gains, rates, free_channels(asked), H.dt is not None)
            yield GainSplines(*loop, degree=degree, pieces=pieces)
        return
    operators = asked.classes.operators
    if criterion.kind == STORED:
        yield _by_storage(before, asked)
        return
    given = (*H.doubles(), lower, free, popov, H.dt is not None, operators)
    if criterion.kind in (_COUPLED, _WINDOWS):
        windows = (asked.window,) if asked.window else _SAMPLES
        for samples in windows if criterion.kind == _WINDOWS else (1,):
            theta = free if criterion.kind == _COUPLED else [False] * len(free)
            coupled = _coupled(asked, (*H.doubles(), lower, groups_of(asked), samples, theta, popov, H.dt is not None))
            if coupled.possible:
                yield coupled
        return
    if criterion.kind == _ORDERS:
        blocks = [block for block in asked.classes.blocks if block not in operators]
        odd = [asked.classes.classes[block[0]].odd for block in blocks]
        most = 4 // max(map(len, blocks))  # a form is about up to 4 samples
        if most > 0:
            yield ChannelWindows(*given, blocks=blocks, odd=odd, samples=min(asked.window or 2, most))
        return
    if criterion.kind == 0 and len(H.D) > _MANY:
        require_no_zero(asked)
        if not operators:
            yield ManyChannels(*given)
        return
    if criterion.kind == 0:
        try:
            modes = modes_of(asked)
        except AssumptionError:
            loose = _resting_gain(before, asked, free, popov=popov)
            if loose is None:
                raise
            yield loose
            return
        yield ChannelInequality(*given, modes=modes)
        return
    modes = modes_of(asked)
    if modes is None:
        for orthants in (False, True):
            yield FullBlockInequality(*given, orthants=orthants)
    elif not operators:
        plant = _exactly(asked)
        exactly = shifted(plant, list(asked.classes.lower))
        yield CriticalBlock(*given[:5], exactly, plant.C, modes, free, popov, H.dt is not None)


def _resting_gain(before: Problem, asked: Problem, free: list[bool], *, popov: bool) -> RestingGain | None:
    """The search for a gain beside eigenvalues 0 that no other theorem covers; None where none is asked for."""
    out, (plant, known) = asked.classes.performance, stated(before)
    memory = any(family.memory for family in known.families)
    if out is None or len(known.operators) > 1 or memory or not ordered(plant.D, known):
        return None
    lower = np.array([float(v) for v in asked.classes.lower])
    sides = channel_plant(asked.plant).doubles()
    loop = shifted(plant, list(asked.classes.lower))
    search = RestingGain(*sides, lower, loop, plant.C, out, free, popov, plant.discrete)
    return search if search.possible else None


def _coupled(asked: Problem, given: tuple[Any, ...]) -> CoupledForms:
    """The search for forms, beside eigenvalues 0 (1) that which solves for them in fractions."""
    modes = modes_of(asked)
    if modes is None:
        return CoupledForms(*given)
    return CriticalForms(*given, plant=_exactly(asked), least=asked.classes.lower, modes=modes)


def _exactly(asked: Problem) -> Plant:
    """The plant as the checkers have it."""
    H = channel_plant(asked.plant)
    A, B, C, D = ([list(row) for row in side] for side in (H.A, H.B, H.C, H.D))
    return Plant(A, B, C, D, H.dt is not None)


def _moved_by_stops(asked: Problem, moved: Problem) -> MovedByStops:
    """The search where the stops move an eigenvalue 0."""
    (before, known), H = stated(asked), channel_plant(moved.plant)
    own = remembered(known)
    columns, n, m = [*zip(*before.B, strict=True)], len(before.A), len(before.D)
    rows = np.zeros((m, n))
    for i in own:
        row = [*[Fraction(0)] * n, *(Fraction(-(i == j)) for j in own)]
        stops = asked.classes.classes[i].memory == "stop" and not any(before.D[i])
        found = from_rest(before.A, [columns[j] for j in own], [row]) if stops else None
        rows[i] = 0.0 if found is None else [float(v) for v in found[0]]
    if not rows.any() or any(not known.families[i].memory for i in own) or n > MOST_STATES:
        raise AssumptionError(
            "the plant has an eigenvalue 0 that no stop moves, or functions beside it", code=Reason.CRITICAL
        )
    lower = np.array([float(v) for v in moved.classes.lower])
    return MovedByStops(*H.doubles(), lower, moved=rows, operators=moved.classes.operators)


def _by_storage(asked: Problem, moved: Problem) -> ChannelSearch:
    """The search with storage functions, for the loop of the derivatives."""
    before, H, own = channel_plant(asked.plant), channel_plant(moved.plant), remembered(stated(asked)[1])
    A, B, C, D = (exact(side) for side in (before.A, before.B, before.C, before.D))
    T = A - diagonal([Fraction(int(before.dt is not None))] * len(before.A))
    if T.det() == 0 and before.dt is not None:
        raise AssumptionError("the plant has an eigenvalue 1 beside play and stop", code=Reason.CRITICAL)
    if T.det() == 0:
        return _moved_by_stops(asked, moved)
    E, m = C * T.inv(), len(asked.classes.classes)
    still = D - E * B
    free = [not any(before.D[i]) if i in own else popov for i, popov in enumerate(free_channels(moved))]
    shown = fmpq_mat([[still[i, j] if i in own and j in own else 0 for j in range(m)] for i in range(m)])
    signs = [{"play": 1, "stop": -1, "": 0}[one.memory] for one in asked.classes.classes]
    resting = doubles(E) * np.array([[i in own] for i in range(m)])
    lower = np.array([float(v) for v in moved.classes.lower])
    if before.dt is not None:
        stored = [one and i in own for i, one in enumerate(free)]
        return SampledStorage(*H.doubles(), lower, stored, signs, shown, resting)
    loop = (*H.doubles(), lower, free, True, False, moved.classes.operators)
    return StorageInequality(*loop, signs=signs, still=shown, resting=resting)


def proved_at(asked: Problem, name: str, search: ChannelSearch, alpha: Fraction) -> Proved | None:
    """What the checker accepts for the classes of a factor; None if nothing.

    ``name``: the theorem.
    """
    classes = without_delays(asked).classes
    widths = [high - low for high, low in zip(classes.scaled(alpha).upper, classes.lower, strict=True)]
    if min(widths) <= 0:
        return None
    tried = (_accepted(asked, name, alpha, one) for one in search.proposals(widths, classes.lower))
    return next((shown for shown in tried if shown is not None), None)


def _accepted(asked: Problem, name: str, alpha: Fraction, one: Proposal) -> Proved | None:
    """What the checker accepts of a proposal for the classes of a factor; None if nothing."""
    draft = {
        "verdict": "PROVED",
        "system": asked.system,
        "laws": asked.scaled(alpha).class_entry,
        "theorem": name,
        "multiplier": one.multiplier,
        "proof": one.proof,
    }
    try:
        shown = checked(draft)
    except Rejected:
        return None
    return shown if isinstance(shown, Proved) else None


def proved_whole(asked: Problem, criterion: Criterion) -> Proved | None:
    """What a criterion proves of the classes as they are given; None if nothing."""
    asked = _widened(asked, criterion)
    one = Fraction(1)
    if isinstance(asked.plant, ChannelFamily):
        return channel_families.BoxSearch(asked, criterion.name).whole()
    if criterion.kind == _PIECES:
        asked = _gains_as_functions(asked)
        proposal = _by_pieces(asked, criterion).at(one)
        return None if proposal is None else _accepted(asked, criterion.name, one, proposal)
    if criterion.kind == _LATE:
        proposal = LateKernels(asked, free=free_channels(asked)[0]).at(one)
        return None if proposal is None else _accepted(asked, criterion.name, one, proposal)
    if criterion.kind != _KERNELS:
        tried = (proved_at(asked, criterion.name, search, one) for search in searches(asked, criterion))
        return next((shown for shown in tried if shown is not None), None)
    kernels = KernelSearch.of(asked)
    return None if kernels is None else kernels.whole(partial(_accepted, asked, criterion.name))


def farthest(asked: Problem, criterion: Criterion, known: Fraction, most: float) -> tuple[Fraction, Proved] | None:
    """The largest factor that is proved, above what is known and below ``most``.

    ``known``: a factor that is proved, or 0; ``most``: the smallest factor that is refuted, or infinity.
    """
    asked = _widened(asked, criterion)
    if isinstance(asked.plant, ChannelFamily):
        return channel_families.BoxSearch(asked, criterion.name).farthest(known, most)
    if criterion.kind in (_PIECES, _LATE):
        moved = criterion.kind == _LATE
        asked = asked if moved else _gains_as_functions(asked)
        late = LateKernels(asked, free=free_channels(asked)[0]) if moved else _by_pieces(asked, criterion)
        for alpha, proposal in late.farthest(max(known, asked.classes.least), most):
            shown = _accepted(asked, criterion.name, alpha, proposal)
            if shown is not None:
                return alpha, shown
        return None
    if any(asked.classes.classes[i].operator == DELAYS[0] for i in delays_of(asked)) or wide_channels(asked):
        return _farthest_delayed(asked, criterion, known, most)
    if criterion.kind == _KERNELS:
        kernels = KernelSearch.of(asked)
        return None if kernels is None else kernels.farthest(partial(_accepted, asked, criterion.name), known, most)
    best: tuple[Fraction, Proved] | None = None
    for search in searches(asked, criterion):
        found = _farthest_by(asked, criterion.name, search, known if best is None else best[0], most)
        best = best if found is None else found
    return best


def _widened(asked: Problem, criterion: Criterion) -> Problem:
    return (sectors_beside_memory(asked) if criterion.wide else None) or asked


def _gains_as_functions(asked: Problem) -> Problem:
    """The question with functions in place of constant gains, of the same bounds: beside dead times and a pole at 0."""
    plant, classes = asked.plant, asked.classes
    if not isinstance(plant, DelayMatrix) or exact(plant.base.A).det() != 0:
        return asked
    wider = [replace(one, linear=False) if one.linear and one.rate is None else one for one in classes.classes]
    return replace(asked, classes=replace(classes, classes=tuple(wider)))


def _by_pieces(asked: Problem, criterion: Criterion) -> PiecewiseProofs:
    return PiecewiseProofs(asked, None if criterion.row.time_varying else free_channels(asked))


def _farthest_delayed(
    asked: Problem, criterion: Criterion, known: Fraction, most: float
) -> tuple[Fraction, Proved] | None:
    """The same where a constant delay or a full block is bounded: the plant in its place changes with the factor."""
    best: tuple[Fraction, Proved] | None = None

    def proved(factor: float) -> bool:
        """Whether a factor is, which is then the best so far."""
        nonlocal best
        checkpoint()
        alpha = Fraction(double_below(Fraction(f"{factor:.9g}")))
        shown = proved_whole(asked.scaled(alpha), criterion) if alpha > asked.classes.least else None
        best = best if shown is None else (alpha, shown)
        return shown is not None

    meeting = _MEETING[criterion.kind == _KERNELS]
    low = max(float(known) * (1 + meeting), double_above(asked.classes.least))
    if 4 * low > LARGEST or (known and not proved(low)):
        return None
    high = most if most < math.inf else max(2 * low, 1.0)
    while most == math.inf and high < LARGEST and proved(high):
        low, high = high, 4 * high
    while high - low > meeting * high and high > 1 / LARGEST:
        middle = (low + high) / 2 if low > high / 8 else math.sqrt(low * high) if low else high / 8
        low, high = (middle, high) if proved(middle) else (low, middle)
    return best


def _farthest_by(
    asked: Problem, name: str, search: ChannelSearch, known: Fraction, most: float
) -> tuple[Fraction, Proved] | None:
    least, classes = asked.classes.least, without_delays(asked).classes
    lower, upper = (np.array([float(v) for v in side]) for side in (classes.lower, classes.upper))
    scaled = np.zeros(len(upper))
    scaled[[*(asked.classes.performance or range(len(upper)))]] = 1.0  # of a gain: its channel alone

    def widths(alpha: float) -> NDArray[np.float64]:
        """Of the classes with this factor, a number a channel."""
        return np.asarray(np.where(scaled, alpha, 1.0) * upper - lower)

    begin = float(known) * (1 + _WORTH)
    margin = search.margin(widths(begin)) if known else math.inf
    if margin <= 0:
        return None
    begin = begin if margin < math.inf else max(float(known), double_above(least))  # its margin is looked at again
    low = search.largest(widths, begin, most)
    steps = [step for step in _STEPS_DOWN if step == _STEPS_DOWN[0] or 10 * step >= search.precision]
    above = Fraction(low)
    for step in steps if low > known else ():
        checkpoint()
        alpha = Fraction(double_below(Fraction(low) * (1 - Fraction(step))))
        shown = proved_at(asked, name, search, alpha) if alpha > max(least, known) else None
        if shown is not None:
            return between(partial(proved_at, asked, name, search), (alpha, shown), above)
        above = alpha
    return None
