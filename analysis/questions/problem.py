"""What a question is about: a block with a nonlinearity or a class of nonlinearities, in whatever form it was given."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure, guarded
from lure.analysis.certificates.systems import class_entries, class_entry, nonlinearity_entry, system_of
from lure.analysis.nonlinearity.membership import Membership, Status, examined, membership
from lure.analysis.theorems.table import BEST, TABLE, Question, theorems_for
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds, in_channels
from lure.errors import AssumptionError, InputError, Reason
from lure.files.system import LoopSystem, ManyChannels
from lure.loop import Loop, LoopModel
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.reading import as_nonlinearity
from lure.plants.block import StructuredPlant
from lure.plants.conversion import one_channel
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

Kind = Literal["sector", "slope", "class"]
Search = Literal["linear", "full"]
OneChannel = RationalPlant | PlantFamily | DelayPlant | StateSpace | FrequencyData | StructuredPlant
Plant = OneChannel | ManyChannels
LONG = 30_000  # binary digits of the characteristic polynomial from which on matrices are faster
_EVERY = NonlinearityClass(sector=Sector(0, math.inf))


@described(frozen=True, kw_only=True, eq=False)
class Problem:
    r"""A question about the loop ``sigma = H mu``, ``mu = -phi(sigma)``; plain data, which pickles and compares.

    Raises
    ------
    InputError
        With several nonlinearities: inputs, outputs and classes differ in number, no state, or an infinite bound.
    """

    plant: Plant = quantity(
        "The linear part ``H``: RationalPlant, DelayPlant, StateSpace, FrequencyData or StructuredPlant; "
        "MultivariablePlant and others for several nonlinearities, ``mu_i = -phi_i(sigma_i)``"
    )
    classes: Diagonal = quantity(
        "The class of each nonlinearity; for a largest upper end with the end ``inf``, of several those of the factor 1"
    )
    kind: Kind = quantity(
        "The largest ``k`` with a stable class ``[lower, k]``, of several the largest factor; or if this one is stable"
    )
    nonlinearity: Nonlinearity | None = quantity(
        "The one in the loop, if one was given; it belongs to the class", default=None
    )
    membership: Membership | None = quantity("What is known of it as a member of the class", default=None)
    untested: bool = quantity(
        "Whether an attempt to test what is declared of it failed: then nothing is proved for it", default=False
    )
    refusals: tuple[Failure, ...] = quantity("What is known to stand in the way before any search", default=())
    criterion: str = quantity("The criterion asked for, or ``best``", default=BEST)
    method: str = quantity("The kind of proof asked for, or ``best``", default=BEST)
    search: Search = quantity("Where to look for destabilising members", default="full")
    finite: bool = quantity(
        "Whether an infinite upper end means every nonlinearity with some finite bound", default=False
    )
    known: tuple[Nonlinearity, ...] = quantity(
        "With several channels, the nonlinearity of each if they are known; they belong to the classes", default=()
    )
    window: int = quantity("Samples of forms in discrete time, 0 for two to four", default=0)
    worst: bool = quantity("Of a gain, whether gains that jump are looked for", default=False)
    name: str = quantity(
        "How the loop is called; no part of the question, nor are ``title`` and ``source``", default="loop"
    )
    title: str = quantity("What it is", default="")
    source: str = quantity("Where it comes from", default="")

    def __post_init__(self) -> None:
        H, given = self.plant, self.classes.classes
        if not isinstance(H, ManyChannels):
            return self.classes.require_no_rectifier()
        if H.inputs != H.outputs:
            raise InputError(f"the plant has {H.size}; nonlinearities mu_i = -phi_i(sigma_i) need as many of both")
        if not H.order:
            raise InputError("the plant has no state, so that nothing moves; give one with dynamics")
        if len(given) != H.inputs:
            listed = f"{len(given)} classes are" if given[1:] else "one class is"
            each = f"{H.inputs} channels" if H.inputs > 1 else "one channel"
            raise InputError(f"{listed} given for {each}; give one for each, in order")
        for i, (low, high) in enumerate((one.gains for one in given), 1):
            if not (-math.inf < low <= high < math.inf) and (where := f"channel {i}" if given[1:] else "the class"):
                raise InputError(f"{where} has the bounds [{low}, {high}]; give finite ones, such as [0, 10]")

    @property
    def several(self) -> bool:
        """Whether it is about several nonlinearities."""
        return isinstance(self.plant, ManyChannels)

    @property
    def block(self) -> OneChannel:
        """The plant of the only channel."""
        assert not isinstance(self.plant, ManyChannels), "asked of one channel"
        return self.plant

    def scaled(self, alpha: Fraction) -> Problem:
        """The question about several classes, every upper bound times ``alpha``.

        Parameters
        ----------
        alpha : Fraction
            The factor.
        """
        return self if alpha == 1 else replace(self, classes=self.classes.scaled(alpha))

    @classmethod
    def largest(  # noqa: PLR0913  (a plant and six settings of a question)
        cls,
        plant: Plant,
        kind: Question,
        *,
        lower: Fraction,
        odd: bool = False,
        time_varying: bool = False,
        criterion: str = BEST,
        search: Search = "full",
    ) -> Problem:
        """The question for the largest ``k`` of the classes ``[lower, k]``.

        Parameters
        ----------
        plant : RationalPlant, DelayPlant, StateSpace, FrequencyData or StructuredPlant
            The linear part.
        kind : {"sector", "slope"}
            What ``[lower, k]`` bounds.
        lower : Fraction
            Lower end of the classes.
        odd, time_varying : bool
            What else the class assumes, or allows.
        criterion : str
            The criterion asked for, or ``best``.
        search : {"linear", "full"}
            Where to look for destabilising members.
        """
        slope = SlopeBounds(lower, math.inf) if kind == "slope" else None
        nonlinearity_class = NonlinearityClass(
            sector=Sector(lower, math.inf), slope=slope, odd=odd, time_varying=time_varying
        )
        classes = Diagonal((nonlinearity_class,))
        return cls(plant=plant, classes=classes, kind=kind, criterion=criterion, search=search, finite=True)

    @property
    def nonlinearity_class(self) -> NonlinearityClass:
        """The class of the only channel."""
        (found,) = self.classes.classes
        return found

    @classmethod
    def about(
        cls,
        plant: Plant,
        nonlinearity_class: NonlinearityClass | None,
        *,
        nonlinearity: Nonlinearity | None = None,
        membership: Membership | None = None,
        name: str = "loop",
    ) -> Problem:
        """The question whether the loop is stable for every member of a class, or with the one that was given.

        Parameters
        ----------
        plant : RationalPlant, DelayPlant, StateSpace, FrequencyData or StructuredPlant
            The linear part.
        nonlinearity_class : NonlinearityClass or None
            The class; None for the largest ``[0, k]`` that is stable.
        nonlinearity : Nonlinearity, optional
            The one in the loop.  One that is not known to be locally Lipschitz widens the class to nonlinearities of
            any regularity.
        membership : Membership, optional
            What is known of it as a member of the class.
        name : str
            What the loop is called.
        """
        if nonlinearity_class is None:
            return replace(cls.largest(plant, "sector", lower=Fraction(0)), name=name)
        criterion = "hurwitz" if nonlinearity_class.linear and isinstance(plant, RationalPlant) else BEST
        given = {"nonlinearity": nonlinearity, "membership": membership, "name": name, "criterion": criterion}
        return cls(plant=plant, classes=Diagonal((nonlinearity_class,)), kind="class", **given)  # type: ignore[arg-type]  # fields by name

    @property
    def given(self) -> NonlinearityClass | None:
        """The class to decide; None where the largest one is asked for, or with several channels."""
        return self.nonlinearity_class if self.kind == "class" and not self.several else None

    @property
    def question(self) -> Question:
        """What bounds the class: a sector alone, or the slope too; with several channels of all."""
        return "sector" if any(one.slope is None for one in self.classes.classes) else "slope"

    @cached_property
    def lower(self) -> Fraction:
        """The lower end of the class, where it is finite; with several channels the factor 0."""
        if self.several:
            return Fraction(0)
        low = (self.nonlinearity_class.slope or self.nonlinearity_class.sector).lower
        return low if isinstance(low, Fraction) else Fraction(low)

    @property
    def endless_below(self) -> bool:
        """Whether a bound of the class has no finite lower end."""
        slope = self.nonlinearity_class.slope
        return -math.inf in (self.nonlinearity_class.sector.lower, 0 if slope is None else slope.lower)

    @property
    def odd(self) -> bool:
        """Whether the class assumes ``phi(-sigma) = -phi(sigma)``, with several channels of all."""
        return all(one.odd for one in self.classes.classes)

    @property
    def time_varying(self) -> bool:
        """Whether the class allows ``phi`` to depend on time, with several channels in one."""
        return any(one.time_varying for one in self.classes.classes)

    @property
    def linear(self) -> bool:
        """Whether constant gains alone are asked about, by the criterion."""
        return any(row.linear for row in TABLE if row.name == self.criterion)

    @property
    def assuming(self) -> bool:
        """Whether the answer may assume of the nonlinearities what a theorem needs beyond their class, and say so."""
        return self.kind != "class"

    @cached_property
    def rough(self) -> bool:
        """Whether the nonlinearity is not known to be locally Lipschitz."""
        return not self.untested and not self.several and is_rough(self.nonlinearity, self.nonlinearity_class)

    @property
    def provable(self) -> bool:
        """Whether the nonlinearity has the regularity that the theorems assume; it is known, or none was given."""
        return not self.untested and (not self.rough or _next_state_is_defined(self.plant))

    @cached_property
    def system(self) -> Mapping[str, Any]:
        """The plant as it stands in a certificate; empty for measured data, of which no certificate speaks."""
        return {} if isinstance(self.plant, FrequencyData) else system_of(self.plant)

    @cached_property
    def class_entry(self) -> Mapping[str, Any]:
        """The class as it stands in a certificate; of several channels, each."""
        if self.several:
            return class_entries(self.classes)
        return class_entry(self.nonlinearity_class, unbounded=not self.finite, linear=self.linear, rough=self.rough)

    @cached_property
    def nonlinearity_entry(self) -> Mapping[str, Any] | None:
        """The nonlinearity as it stands in a certificate, where its membership can be checked."""
        return nonlinearity_entry(self.nonlinearity)

    @property
    def nonlinearity_words(self) -> str:
        """The nonlinearity in words; empty if there is none."""
        from lure.nonlinearities.properties import nonlinearity_text

        if self.known:
            return in_channels([f"phi = {nonlinearity_text(one)}" for one in self.known], self.classes.blocks)
        return "" if self.nonlinearity is None else nonlinearity_text(self.nonlinearity)

    @property
    def subject(self) -> str:
        """What moves, where the plant has a name: a rod, or its scheme, which is not the rod; else empty."""
        return self.plant.name if isinstance(self.plant, StructuredPlant) else ""

    @property
    def spelled(self) -> Mapping[Fraction, str]:
        """Bounds of the class with the text that the reader gave them."""
        bounds = [each for one in self.classes.classes for each in (one.sector, one.slope) if each is not None]
        ends = [end for each in bounds for end in (each.lower, each.upper)]
        doubles = {Fraction(end): f"{end:.7g}" for end in ends if isinstance(end, float) and math.isfinite(end)}
        return {end: text for end, text in doubles.items() if "e" not in text and float(text) == end}

    @cached_property
    def text(self) -> str:
        """The question as JSON with sorted keys: the same text for the same question, whatever object holds it."""
        dt = str(self.plant.dt)
        plant: object = {**self.system, "dt": dt}
        if isinstance(self.plant, FrequencyData):
            response = [[value.real.hex(), value.imag.hex()] for value in self.plant.response.tolist()]
            plant = {"omega": [w.hex() for w in self.plant.omega.tolist()], "response": response, "dt": dt}
        given: object = None if self.nonlinearity is None else self.nonlinearity_entry or repr(self.nonlinearity)
        given = [repr(one) for one in self.known] or given
        options = {name: getattr(self, name) for name in ("kind", "criterion", "method", "search", "finite")}
        classes = [class_entry(each, unbounded=not self.finite) for each in self.classes.classes]
        whole = {**options, "plant": plant, "classes": classes, "repeated": self.classes.repeated, "given": given}
        return json.dumps(whole, sort_keys=True)

    @property
    def digest(self) -> str:
        """SHA-256 of ``text``, 64 hexadecimal digits."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Problem) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)


def is_rough(nonlinearity: Nonlinearity | None, nonlinearity_class: NonlinearityClass) -> bool:
    """Whether the nonlinearity is not known to be locally Lipschitz; one that says nothing of it is taken to be.

    ``nonlinearity_class``: a class that contains it.
    """
    if nonlinearity is None:
        return False
    return membership(nonlinearity, nonlinearity_class).regular("locally Lipschitz") is Status.VIOLATED


def _next_state_is_defined(block: Plant) -> bool:
    """Whether the loop has exactly one solution whatever phi is: in discrete time, without a direct term."""
    direct = block.feedthrough if isinstance(block, RationalPlant) else getattr(block, "D", None)
    return block.dt is not None and direct == 0


# A plant and a nonlinearity, each in whatever form a user has it, as one loop.


def plant_given(source: object) -> OneChannel:
    """The plant that a source describes: what :func:`lure.as_plant` makes of it, or the ``StructuredPlant`` it is.

    Raises
    ------
    InputError
        It is no linear block.
    """
    return source if isinstance(source, StructuredPlant) else one_channel(source)


def class_given(nonlinearity: object) -> NonlinearityClass | None:
    """The class that somebody means by a class, a sector or slope bounds; None for anything else.

    ``nonlinearity``: ``Sector(0, 5)`` is every time-invariant ``phi`` in it, ``SlopeBounds(0, 1)`` every one with such
    slopes.

    Examples
    --------
    >>> print(class_given(Sector(0, 5)), "|", class_given(SlopeBounds(0, 1)))
    phi in the sector [0, 5] | phi with slope in [0, 1]
    """
    if isinstance(nonlinearity, NonlinearityClass):
        return nonlinearity
    if isinstance(nonlinearity, Sector):
        return NonlinearityClass(sector=nonlinearity)
    if isinstance(nonlinearity, SlopeBounds):
        return NonlinearityClass.slope_restricted(nonlinearity.lower, nonlinearity.upper)
    return None


def loop_given(plant: object, nonlinearity: object = None) -> object:
    """The plant with the nonlinearity, for every question that takes a loop; the plant itself if none is given.

    Parameters
    ----------
    plant : object
        Anything :func:`lure.as_plant` takes, or a named plant without a nonlinearity.
    nonlinearity : object
        A nonlinearity of :mod:`lure.nonlinearities` or any object with a sector, a formula as text,
        ``control.saturation_nonlinearity``,
        or what :func:`class_given` takes.

    Raises
    ------
    InputError
        The plant has a nonlinearity already, or one of the two is none.

    Examples
    --------
    >>> print(loop_given("1/(s+1)", "tanh(2*sigma)").nonlinearity)
    tanh(2*sigma)
    """
    if nonlinearity is None:
        return plant
    closed = isinstance(plant, Loop | LoopModel)
    if closed or (isinstance(plant, LoopSystem) and not plant.open):
        raise InputError(
            f"a {type(plant).__name__} closes the loop itself and a nonlinearity is given beside it; leave one of the "
            "two out, or give the block alone, loop.block"
        )
    nonlinearity_class = class_given(nonlinearity)
    given = None
    if nonlinearity_class is None:
        given = as_nonlinearity(nonlinearity)
    named = plant if isinstance(plant, LoopSystem) else None
    block = one_channel(plant) if named is None else named.block
    return LoopSystem(
        name="loop" if named is None else named.name,
        title="" if named is None else named.title,
        source="" if named is None else named.source,
        block=block,  # type: ignore[arg-type]  # measured data is refused where it cannot serve, with its reason
        nonlinearity=given,
        nonlinearity_class=nonlinearity_class,
    )


def problem_of(loop: object) -> Problem:
    """The question about a loop: whether its class is stable, or without one how large a class may be.

    ``loop``: a ``Problem``, a ``LoopSystem``, a ``Loop``, or anything that :func:`lure.plants.as_plant` takes.

    Raises
    ------
    InputError
        It is none of these, or what is declared of the nonlinearity is false.
    AssumptionError
        The block is of a kind that can be computed with but not certified: too large, or measured; or a sample breaks
        what is declared of a nonlinearity known by its values alone.
    """
    if isinstance(loop, Problem):
        return loop
    structured = isinstance(loop, LoopModel | StructuredPlant)
    plant, nonlinearity, nonlinearity_class = (
        (one_channel(loop), None, None) if structured else _parts(loop, discretised=False)
    )
    plant, known = certifiable(plant), None if nonlinearity is None else examined(nonlinearity, nonlinearity_class)
    if known is None:
        problem = Problem.about(plant, nonlinearity_class)
    else:
        own, phi = known.nonlinearity_class, known.nonlinearity
        problem = Problem.about(plant, own, nonlinearity=phi, membership=known.membership)
    named = {field: getattr(loop, field) for field in ("name", "title", "source") if isinstance(loop, LoopSystem)}
    return replace(problem, **named)


def by_matrices(block: RationalPlant) -> StateSpace | None:
    """The matrices that a block was given by, where its polynomials are too long to work with; else None.

    ``block``: the block.  Its entries have to be doubles, so that both are the same system.
    """
    given = block.matrices
    if given is None or sum(c.numerator.bit_length() + c.denominator.bit_length() for c in block.denominator) < LONG:
        return None
    entries = [v for row in (*given.A, given.b, given.c, (given.d,)) for v in row]
    if any(Fraction(float(v)) != v for v in entries):
        return None
    return StateSpace(*given.doubles(), block.dt)


def certifiable(block: object) -> RationalPlant | PlantFamily | DelayPlant | StateSpace:
    """The block, if there is exact data behind it; by its matrices where these are doubles and polynomials too long.

    Raises
    ------
    AssumptionError
        There is not.
    """
    if isinstance(block, RationalPlant):
        return by_matrices(block) or block
    if isinstance(block, DelayPlant | StateSpace | PlantFamily):
        return block
    raise AssumptionError(
        f"a {type(block).__name__} gives computed numbers, and nothing certified can be said of it; give coefficients, "
        "matrices, or a formula",
        code=Reason.SAMPLED if isinstance(block, FrequencyData) else Reason.COMPUTED,
    )


def posed(
    loop: object,
    nonlinearity_class: NonlinearityClass | None,
    *,
    criterion: str,
    finite: bool,
    method: str = BEST,
) -> Problem:
    """The question whether a loop is stable for every nonlinearity of a class.

    Parameters
    ----------
    loop : LoopSystem, LoopModel, Loop, or anything :func:`lure.plants.as_plant` takes
        The loop.  A model such as a rod means itself, for a proof by matrices its approximation.
    nonlinearity_class : NonlinearityClass or None
        The class; None for the class of the loop, or the smallest its nonlinearity is known to belong to.  A class
        given here leaves the nonlinearity of the loop out.
    criterion : str
        The criterion asked for; ``hurwitz`` is about linear gains alone.
    finite : bool
        Whether an infinite upper end means every nonlinearity with some finite bound.
    method : str
        The kind of proof asked for, or ``best``.

    Raises
    ------
    InputError
        The loop is none, there is no class, or no such criterion.
    """
    block, nonlinearity, own = _parts(loop, discretised=method == "matrix")
    gains = (nonlinearity_class or own or _EVERY).linear and isinstance(block, RationalPlant)
    criterion = "hurwitz" if gains and criterion == BEST else criterion
    named = [row for row in TABLE if row.name == criterion]
    if isinstance(block, RationalPlant) and (criterion == BEST or any(row.matrix for row in named)):
        block = by_matrices(block) or block
    refusals, member, untested = list[Failure](), None, False
    if nonlinearity_class is not None:
        nonlinearity = None
    elif nonlinearity is not None:
        known = guarded("the nonlinearity", lambda: examined(nonlinearity, own), passing=(InputError,))
        if isinstance(known, Failure):
            refusals, nonlinearity_class, untested = [known], own or NonlinearityClass(sector=nonlinearity.sector), True
        else:
            nonlinearity, nonlinearity_class, member = known.nonlinearity, known.nonlinearity_class, known.membership
    else:
        nonlinearity_class = own
    if nonlinearity_class is None:
        raise InputError("no class of nonlinearities is given; give one such as a sector [0, 5.9], or a nonlinearity")
    with suppress(AssumptionError):  # what does not apply is a result; a name that does not exist is a mistake
        theorems_for(block, "sector" if nonlinearity_class.slope is None else "slope", criterion)
    if any(row.linear for row in named):  # the nonlinearity plays no part
        nonlinearity, member, untested = None, None, False
    if not untested and is_rough(nonlinearity, nonlinearity_class) and not _next_state_is_defined(block):
        words = str(getattr(nonlinearity, "regularity", "unknown"))
        known_as = "not known to be locally Lipschitz" if words == "unknown" else words
        detail = f"it is {known_as}; in continuous time, or with H(inf) != 0, the theorems assume that it is locally "
        detail += "Lipschitz"
        refusals.append(Failure(search="the nonlinearity", code=codes.NOT_LIPSCHITZ, detail=detail))
    if isinstance(block, FrequencyData):
        detail = f"H is known at {len(block.omega)} frequencies, and nothing is known between them"
        refusals.append(Failure(search="the block", code=codes.SAMPLED, detail=detail))
    return Problem(
        plant=block,
        classes=Diagonal((nonlinearity_class,)),
        kind="class",
        nonlinearity=nonlinearity,
        membership=member,
        untested=untested,
        refusals=tuple(refusals),
        criterion=criterion,
        method=method,
        finite=finite,
    )


def _parts(loop: object, *, discretised: bool) -> tuple[Plant, Nonlinearity | None, NonlinearityClass | None]:
    """Block, nonlinearity and class of whatever describes a loop."""
    if isinstance(loop, LoopModel):
        return *loop.parts(discretised=discretised), _EVERY
    if isinstance(loop, StructuredPlant):
        return loop, None, _EVERY
    if isinstance(loop, LoopSystem):
        return loop.block, loop.everywhere().nonlinearity, loop.nonlinearity_class
    if isinstance(loop, Loop):
        return one_channel(loop.block), loop.nonlinearity, None
    return one_channel(loop), None, None
