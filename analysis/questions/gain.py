"""The L2 gain from a disturbance ``w`` to an output ``z`` over all members of the classes: a view of ``answer``."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, cast

from lure.analysis.certificates.checker import UNLIMITED
from lure.analysis.drawing import drawn
from lure.analysis.nonlinearity.membership import require_members
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above, double_below
from lure.analysis.questions.answers import answer
from lure.analysis.questions.channel_problem import channel_plants, channel_problem, late_plant
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.problem import Problem, class_given
from lure.analysis.questions.two_sided import TwoSided
from lure.analysis.theorems.table import BEST
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.arrays import linalg, np
from lure.classes import DELAYS, OPERATORS, Diagonal, NonlinearityClass
from lure.errors import InputError
from lure.files.system import LoopSystem
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.family import PlantFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.performance import Performance
from lure.record import Page, derived, plain, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked, Proved, Refuted

Whole = MultivariablePlant | ChannelFamily | DelayMatrix
_FREQUENCIES = 200
LONGEST = 12  # samples in a window


class GainBound(TwoSided):
    r"""Bounds of the least ``gamma`` with :math:`\int |z|^2 \le \gamma^2 \int |w|^2`, ``x(0) = 0``, for all members."""

    gain: Bracket = quantity(
        "``low``: some member has a gain above it; ``high``: none has.  Infinite both where with a linear "
        "member ``z`` has a pole from ``w`` that is not strictly stable",
        plainly=lambda bounds: [plain(bounds.low), plain(bounds.high)],
    )
    classes: Diagonal = quantity("The classes of the channels, without that from ``z`` to ``w``")
    performance: Performance = quantity("Where ``w`` enters and what ``z`` is")
    incremental: bool = quantity("Whether it is the gain of differences of solutions", default=False)
    at_input: bool = quantity(
        "Whether ``w`` is added to ``mu`` and ``z`` is ``sigma``", key="", label="", default=False
    )
    plant: Whole = quantity("The plant, ``w`` and ``z`` its last channels", key="", label="")
    factors: StabilityBound = quantity(
        "The answer about the loop with a channel from ``z`` to ``w`` of norm ``1/gamma``", key="", label=""
    )
    _schema, _kind, _said = "lure-gain/1", "L2 gain", "sentence"
    _no_truth = "a gain has bounds and no truth value; compare result.verdict"

    @property
    @derived()
    def verdict(self) -> Verdict:
        """PROVED: ``gain.high`` is finite.  REFUTED: a member's gain is infinite.  INCONCLUSIVE: neither is shown."""
        if self.factors.verdict is Verdict.REFUTED and self.gain.low < math.inf:
            return Verdict.INCONCLUSIVE
        return self.factors.verdict

    @property
    @derived()
    def evidence(self) -> Evidence:
        """What the bounds rest on."""
        return self.factors.evidence

    @property
    @derived()
    def criterion(self) -> str:
        """The criterion that proves ``gain.high``; empty if none does."""
        return self.factors.criterion

    @property
    @derived()
    def closed(self) -> bool:
        """Whether both bounds meet within one part in a thousand."""
        low, high = self.gain.low, self.gain.high
        return low == high or (high < math.inf and high - low <= 1e-3 * high)

    @property
    @derived()
    def reason(self) -> str:
        """Why nothing was proved; empty if something was."""
        if self.factors.verdict is Verdict.REFUTED and self.gain.low < math.inf:
            return (
                f"{self.witness}, and it is not shown that w moves what grows and z sees it: the gain may be finite, "
                "and no theorem here proves one of an unstable loop"
            )
        return self.factors.reason

    @property
    @derived()
    def stopped(self) -> str | None:
        """What ended the search before it was complete; what is claimed was shown all the same."""
        return self.factors.stopped

    @property
    @derived()
    def witness(self) -> str:
        """The member with a gain above ``gain.low``, or that is unstable; empty if none was found."""
        return "" if self.factors.witness is None else self.factors.witness.description

    @property
    @derived()
    def assumed(self) -> str:
        """What the theorem assumes of the nonlinearities beyond their class; empty if nothing."""
        return self.factors.proviso

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of ``gain.high``, with its certificate."""
        return self.factors.proof

    @property
    def refutation(self) -> Refuted | None:
        """What the checker accepted of the member, with its certificate: of ``gain.low``, or of instability."""
        return self.factors.refutation

    @property
    def _sides(self) -> tuple[Checked | None, Checked | None]:
        return self.refutation, self.proof

    @property
    def _about(self) -> str:
        """The classes, and the box of parameters where there is one."""
        ranges = f" and every {self.plant.ranges}" if isinstance(self.plant, ChannelFamily) else ""
        return f"{self.classes}{ranges}"

    @property
    def _name(self) -> str:
        sides = "w, added to mu, to z = sigma" if self.at_input else "w to z"
        return f"{'incremental ' if self.incremental else ''}L2 gain from {sides}"

    def _widths(self) -> str:
        """Which plays and stops come near to the gains of the member: no gain is one of them."""
        shown = {} if self.refutation is None else self.refutation.certificate
        kinds = [one.get("memory") for one in shown.get("laws", {}).get("channels", ())]
        gains = shown.get("proof", {}).get("gains", ())
        members = [(kind, Fraction(gain)) for kind, gain in zip(kinds, gains, strict=False) if kind]
        large = [(kind, (kind == "stop") is (gain > 0)) for kind, gain in members]
        return ", ".join(f"a {kind} of {'large' if wide else 'small'} width" for kind, wide in large)

    def __str__(self) -> str:
        low, high = self.gain.low, self.gain.high
        if self.verdict is Verdict.REFUTED:
            return f"No {self._name} is finite for all members of the class ({self._about}): {self.witness}."
        above = ""
        if low > 0:
            member = self.witness.partition(" give")[0].rstrip(",")
            joined = ", with" if member.startswith(("phi = ", "the constant gains ")) else ":"
            widths = self._widths()
            joined, member = (", near", f"{member} ({widths})") if widths else (joined, member)
            above = f"; a member has a gain above {bound_below(low)}{joined} {member}"
        if self.verdict is Verdict.PROVED:
            given = ", ".join(filter(None, (self._about, self.assumed)))
            said = f"The {self._name} is at most {bound_above(high)} for {given}"
            return f"{said} ({self.criterion}, {self.evidence}){above}. {self.factors.unfinished}".rstrip()
        return f"No bound of the {self._name} is proved for {self._about} ({self.reason}){above}."

    plot = drawn("The gain of linear members over the frequencies, and the bound for all members.")

    def _page(self) -> Page:
        rows = [
            ("at most", bound_above(self.gain.high) if self.gain.high < math.inf else "no bound"),
            ("proved by", self.criterion or "-"),
            ("above", bound_below(self.gain.low) if self.gain.low < math.inf else "every bound"),
            ("by the member", self.witness or "-"),
            ("in a sentence", str(self)),
        ]
        notes = ["Not shown: a bound on the size of z at a time, on its gain for classes other than these."]
        notes += ["Check it again: lure.analysis.check(result.certificates['high']), in exact arithmetic."]
        return Page(f"{self._name}: {self._about}", rows, verdict=str(self.verdict), notes=notes)


def l2_gain(  # noqa: PLR0913  (a plant, classes, a performance and three settings with defaults)
    plant: object,
    classes: object = None,
    performance: object = None,
    *,
    criterion: str = BEST,
    window: int | None = None,
    incremental: bool = False,
    worst: bool = False,
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> GainBound:
    r"""The L2 gain from ``w`` to ``z`` over all members of the classes, from both sides.

    .. math:: \dot x = A x + B \mu + B_w w, \quad \sigma = C x + D \mu + D_{\sigma w} w, \quad
        z = C_z x + D_{z\mu} \mu + D_{zw} w, \quad \mu_i = -\phi_i(\sigma_i), \quad x(0) = 0,

    in discrete time with ``x+`` and sums.

    Parameters
    ----------
    plant : LoopSystem, or anything :func:`lure.as_plant` takes
        The linear part; the state is that of its matrices.
    classes : sequence, Diagonal or a single class, optional
        The class of each channel, without a list if it is one; that of the system if it is not given.
    performance : mapping or Performance, optional
        ``Bw`` (n, p), ``Cz`` (q, n), ``Dzw`` (q, p), ``Dzmu`` (q, m) and ``Dsigmaw`` (m, p), row by row, 0 where they
        are left out; that of the system if it is not given.  Or none where the plant has more inputs and outputs than
        there are classes: then the last inputs are ``w`` and the last outputs ``z``.  Or none at all: then ``w`` is
        added to ``mu`` where it enters the plant, and ``z`` is ``sigma``.
    criterion : str
        A criterion for several nonlinearities, or ``best``.
    window : int, optional
        In discrete time, over how many consecutive samples the constraints of slopes and ReLUs reach; by default two,
        three and four are tried.
    incremental : bool
        Whether the gain of differences is asked for, ``|z_1 - z_2|`` over ``|w_1 - w_2|`` of any two solutions of one
        loop that begin together.  Then each class needs slope bounds, and only their time-varying gains are used:
        Popov's terms, kernels and forms of several samples hold for solutions, not for differences (Kulkarni, Safonov
        2002).
    worst : bool
        Whether disturbances are looked for too beside which the gains jump, by power iteration, for a larger
        ``low``: of classes that depend on time, in discrete time of sectors too.  That takes some seconds.
    seconds : float or None
        Time allowed; when it is over the best bounds so far are returned.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins.

    Returns
    -------
    GainBound
        ``gain.high`` is certified for every member; ``gain.low`` by a linear member at a frequency, of ReLUs and
        with ``worst`` by a disturbance of some steps.

    Raises
    ------
    InputError
        A matrix does not fit, there are no classes, parameters and no ``w`` and ``z``, or the plant is not rational.
    AssumptionError
        The loop with the gains at the lower bounds is no such that a theorem on gains covers it.

    Notes
    -----
    One operator more, from ``z`` to ``w``, of norm ``1/gamma`` and with a constant weight (Willems 1972; Megretski,
    Rantzer 1997): the same programmes, certificates and checkers.  Nothing follows for the difference of two solutions.

    Examples
    --------
    >>> from lure import Sector
    >>> found = l2_gain(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]})
    >>> print(found.verdict, round(found.gain.low, 5), round(found.gain.high, 5))
    PROVED 1.0 1.0
    """
    ways: dict[str, Any] = {"criterion": criterion, "incremental": incremental}
    problem, stated, asked, beside = gain_problem(plant, classes, performance, **ways)
    problem = replace(problem, window=_window(window, problem), worst=bool(worst))
    found = cast("StabilityBound", answer(problem, seconds=seconds, progress=progress))
    unit, H = Fraction(problem.classes.classes[-1].sector.upper), cast("Whole", problem.plant)
    endless = found.refutation is not None and found.refutation.certificate["conclusion"] == UNLIMITED
    low = math.inf if endless else 0.0
    if found.refuted_at:
        low = double_below(1 / (unit * Fraction(found.refuted_at)))
    proved = found.verdict is Verdict.PROVED and found.largest.low > 0
    high = double_above(1 / (unit * Fraction(found.largest.low))) if proved else math.inf
    return GainBound(
        gain=Bracket(low, high),
        classes=asked,
        performance=stated,
        incremental=incremental,
        at_input=beside,
        plant=H,
        factors=found,
    )


def gain_problem(
    plant: object, classes: object, performance: object, *, criterion: str = BEST, incremental: bool = False
) -> tuple[Problem, Performance, Diagonal, bool]:
    """The question about the loop with a channel from ``z`` to ``w``, the performance, and the classes asked about.

    And whether nothing was said of ``w`` and ``z``: then they are at the input and the output of the plant.

    ``plant``, ``classes``, ``performance``: as for :func:`l2_gain`; ``criterion``: the criterion asked for;
    ``incremental``: whether the question is about differences.

    Raises
    ------
    InputError
        As there.
    """
    if classes is None:
        classes = classes_said(plant)
    elif class_given(classes) is not None:
        classes = [classes]
    stated = performance if performance is not None or not isinstance(plant, LoopSystem) else plant.performance
    source: object = plant
    if stated is None and isinstance(classes, list | tuple | Diagonal):
        source, stated = _last_channels(plant, len(classes.classes if isinstance(classes, Diagonal) else classes))
    beside = stated is None
    found = _at_the_input(plant) if stated is None else Performance.given(stated)
    if isinstance(plant, LoopSystem) and isinstance(classes, list) and source is plant:
        source = plant.block
    listed = classes.classes if isinstance(classes, Diagonal) else classes if isinstance(classes, list | tuple) else ()
    for one in filter(None, map(class_given, listed)):
        if math.inf in map(abs, one.gains):
            raise InputError(
                f"an L2 gain needs finite bounds, and a class is {one}; give two numbers, such as sector = [0, 10]"
            )
    asked = channel_problem(source, classes, kind="sector", criterion=criterion, late=True)
    own = asked.classes
    if incremental:
        asked = replace(asked, classes=_differences(asked.classes))
    H = cast("Whole", asked.plant)
    if not beside and (found.Bw or found.Cz) and _without_states(plant):
        raise InputError("performance.Bw and Cz are about states, and the plant is given without; give A, B, C and D")
    if isinstance(H, DelayMatrix):
        H.require_retarded("L2 gains")
    whole, size = found.beside(H), max(found.inputs, found.outputs)
    alone = whole.central if isinstance(whole, ChannelFamily) else whole
    channel = NonlinearityClass.performance(_unit(alone, asked.classes, size))
    sizes = (*(len(block) for block in asked.classes.blocks), size)
    both = Diagonal((*asked.classes.classes, *[channel] * size), repeated=sizes)
    return replace(asked, plant=whole, classes=both, known=()), found, own, beside


def _differences(classes: Diagonal) -> Diagonal:
    """What differences are: ``phi_1 - phi_2 = g(t) (sigma_1 - sigma_2)``, ``g`` between the slopes."""
    found = list[NonlinearityClass]()
    for i, one in enumerate(classes.classes, 1):
        ends, slope = (one.sector.lower, one.sector.upper), one.slope
        if one.linear or one.operator in (*OPERATORS[1:], *DELAYS):
            found.append(one)
            continue
        if slope is None or (slope.lower, slope.upper) != ends or one.rectifier or one.memory:
            raise InputError(
                f"channel {i} is {one}, of whose differences nothing is known that both sides could use; give slope = "
                "[l, k] alone for an incremental gain"
            )
        found.append(NonlinearityClass(sector=one.sector, time_varying=True))
    return Diagonal(tuple(found), repeated=classes.repeated)


def _window(window: object, problem: Problem) -> int:
    """The number of samples that is asked for; 0 if none is."""
    if window is None:
        return 0
    if isinstance(window, bool) or not isinstance(window, int) or not 1 <= window <= LONGEST:
        raise InputError(f"window is {window!r:.40}; give a number of samples from 1 to {LONGEST}")
    if isinstance(problem.plant, ChannelFamily):
        raise InputError("window is not asked for plants with parameters; leave it out")
    if cast("MultivariablePlant", problem.plant).dt is None:
        raise InputError(f"window is {window}, and the plant is in continuous time, without samples; leave it out")
    return window


def classes_said(plant: object) -> object:
    """The classes that a system states; of one channel, whose nonlinearity stands for its class, as a list.

    ``plant``: a system, which is asked for where it is none.

    Raises
    ------
    InputError
        Nothing is said of its nonlinearities, or one is not in its class.
    """
    if not isinstance(plant, LoopSystem) or plant.open:
        raise InputError("no class of nonlinearities is given; give [class] or [nonlinearity], one for each channel")
    one = plant.nonlinearity_class or plant.nonlinearity
    if plant.nonlinearity is not None and plant.nonlinearity_class is not None:
        require_members([plant.nonlinearity], [plant.nonlinearity_class])
    return None if one is None else [one]


def _without_states(plant: object) -> bool:
    """Whether the plant is one transfer function, whose states nobody named."""
    from lure.plants import as_plant
    from lure.plants.rational import RationalPlant

    block = plant.block if isinstance(plant, LoopSystem) else as_plant(plant)
    if isinstance(block, PlantFamily):
        return block.states is None
    return isinstance(block, DelayPlant) or (
        isinstance(block, RationalPlant) and block.matrices is None and block.order > 0
    )


def _at_the_input(plant: object) -> Performance:
    """``w`` added to ``mu`` where it enters the plant, and ``z = sigma``."""
    late = late_plant(plant)
    H = channel_plants(plant) if late is None else late.base
    if isinstance(H, ChannelFamily):
        raise InputError(
            "the L2 gain is asked of w and z, which are not given beside parameters; give [performance] with Bw and Cz"
        )
    sides: dict[str, Any] = {"Dzw": H.D, "Dzmu": H.D, "Dsigmaw": H.D} | ({"Bw": H.B, "Cz": H.C} if H.order else {})
    found = Performance(**sides)
    return found if late is None else replace(found, late=late.late)


def _last_channels(plant: object, m: int) -> tuple[object, Performance | None]:
    """The plant of the first channels, and what its last inputs and outputs are as a performance."""
    late = late_plant(plant)
    if late is not None and late.inputs > m < late.outputs:
        base, stated = _last_channels(late.base, m)
        assert isinstance(base, MultivariablePlant), "as that of the plant is"
        assert stated is not None, "there are more channels than m"
        first, last = (tuple((delay, rows[side]) for delay, rows in late.late) for side in (slice(m), slice(m, None)))
        return replace(late, base=base, late=first), replace(stated, late=last)
    H = plant if late is not None else channel_plants(plant)
    if not isinstance(H, MultivariablePlant) or H.inputs <= m or H.outputs <= m:
        return plant, None
    own = replace(H, B=tuple(row[:m] for row in H.B), C=H.C[:m], D=tuple(row[:m] for row in H.D[:m]), names=H.names[:m])
    sides: dict[str, Any] = {"Dzw": tuple(row[m:] for row in H.D[m:]), "Dzmu": tuple(row[:m] for row in H.D[m:])}
    sides |= {"Dsigmaw": tuple(row[m:] for row in H.D[:m])}
    sides |= {"Bw": tuple(row[m:] for row in H.B), "Cz": H.C[m:]} if H.order else {}
    return own, Performance(**sides)


def _unit(H: MultivariablePlant | DelayMatrix, classes: Diagonal, size: int) -> Fraction:
    """About the inverse of the gain of the loop at the lower bounds, a power of two: searches are begun there."""
    A, B, C, D = (H.base if isinstance(H, DelayMatrix) else H).doubles()
    gains = np.diag([float(v) for v in classes.lower] + [0.0] * size)
    whole = np.eye(len(D)) + D @ gains
    if abs(np.linalg.det(whole)) < 1e-12:
        return Fraction(1)
    closed = np.linalg.solve(whole, C)
    Ac, Bc, Dc = A - B @ gains @ closed, B - B @ gains @ np.linalg.solve(whole, D), np.linalg.solve(whole, D)
    poles = linalg.eigvals(Ac) if len(A) else np.ones(1)
    spread = np.abs(poles[np.abs(poles) > 1e-12]) if len(A) else np.ones(1)
    top, least = (float(spread.max()), float(spread.min())) if len(spread) else (1.0, 1.0)
    points = 1j * np.geomspace(least / 100, top * 100, _FREQUENCIES)
    if H.dt is not None:
        points = np.exp(1j * np.linspace(0, np.pi, _FREQUENCIES))
    pencil = points[:, None, None] * np.eye(len(A)) - Ac
    try:
        if isinstance(H, DelayMatrix):
            response = np.linalg.solve(np.eye(len(D)) + (through := H.transfer(points)) @ gains, through)
        else:
            response = closed @ np.linalg.solve(pencil, Bc.astype(complex)) + Dc
    except np.linalg.LinAlgError:
        return Fraction(1)
    largest = float(np.linalg.norm(response[:, -size:, -size:], 2, axis=(1, 2)).max())
    return Fraction(2) ** round(-math.log2(largest)) if 1e-30 < largest < 1e30 else Fraction(1)
