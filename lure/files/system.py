"""Lur'e loops as named systems: a block, what is said of the nonlinearity, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from lure.classes import Diagonal, NonlinearityClass
from lure.errors import InputError
from lure.loop import Loop, loop_rows
from lure.nonlinearities.base import LocalSector, Nonlinearity
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.family import PlantFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.performance import Forcing, Performance
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import Record, quantity

if TYPE_CHECKING:
    import control


ManyChannels = MultivariablePlant | ChannelFamily | DelayMatrix
Block = RationalPlant | DelayPlant | StateSpace | MultivariablePlant | DelayMatrix | PlantFamily | ChannelFamily


class LoopSystem(Record):
    """A linear block in a loop ``sigma = H mu``, ``mu = -phi(sigma)``, and what is said of ``phi``.

    With several channels, ``mu_i = -phi_i(sigma_i)``, the block is a ``MultivariablePlant`` and ``classes`` and
    ``nonlinearities`` say it of each.
    """

    name: str = quantity("Name for the report")
    title: str = quantity("One line that says what it is")
    source: str = quantity("Where the numbers come from", default="")
    block: Block = quantity("The linear block")
    nonlinearity: Nonlinearity | None = quantity("The nonlinearity, if there is one", key="law", default=None)
    nonlinearity_class: NonlinearityClass | None = quantity(
        "The class of nonlinearities asked about, if there is one; it contains the nonlinearity",
        key="class",
        default=None,
    )
    nonlinearity_table: Mapping[str, object] | None = quantity(
        "The entries of the table ``[nonlinearity]`` that mean the nonlinearity", key="", default=None
    )
    classes: Diagonal | None = quantity(
        "With several channels, the classes asked about, if there are such", default=None
    )
    nonlinearities: tuple[Nonlinearity, ...] = quantity(
        "With several channels, the nonlinearity of each, if they are known; or of those that ``classes`` leaves out",
        default=(),
    )
    nonlinearity_tables: tuple[Mapping[str, object], ...] = quantity(
        "The tables ``[[nonlinearity]]`` that mean them", key="", default=()
    )
    local: tuple[LocalSector, ...] = quantity(
        "What is known of each nonlinearity on an interval alone, if that is all", default=()
    )
    performance: Performance | None = quantity(
        "The disturbance and the output of which the gain is asked, if there are such", default=None
    )
    forcing: Forcing | None = quantity("The input to which the steady response is asked, if there is one", default=None)
    ask: tuple[str, ...] = quantity("What a report is asked beside stability", key="", label="", default=())
    approximates: object = quantity(
        "What the block is an approximation of, if that is known", hidden=True, default=None
    )
    _kind = "loop system"
    _notes = ("sigma = H mu, mu = -phi(sigma); lure.analysis.analyse(system) decides.",)

    def __post_init__(self) -> None:
        if self.nonlinearity is not None and self.nonlinearity_class is not None:
            from lure.nonlinearities.properties import require_given_alone

            require_given_alone(self.nonlinearity_class)

    def to_control(self, *, pade: int | None = None) -> control.NonlinearIOSystem:
        """The closed loop with the nonlinearity; see :meth:`lure.Loop.to_control`.

        Parameters
        ----------
        pade : int, optional
            Order of the approximation that stands for a dead time.

        Raises
        ------
        InputError
            There is no nonlinearity to close the loop with, or the loop cannot be simulated there.
        """
        if self.nonlinearity is None:
            raise InputError(
                f"the system {self.name!r:.60} has no nonlinearity to close the loop with; Loop(system.block, "
                "phi) has one"
            )
        if isinstance(self.block, PlantFamily | ChannelFamily):
            raise InputError("a plant with parameters is many; give Loop(system.block.at(point), phi) one of them")
        return Loop(self.block, self.nonlinearity).to_control(pade=pade)

    @property
    def _title(self) -> str:
        return f"{self.name}: {self.title}" if self.title else self.name

    @property
    def open(self) -> bool:
        """Whether nothing is said of what closes the loop."""
        closed = self.nonlinearity or self.nonlinearity_class or self.classes or self.nonlinearities or self.local
        return not closed

    def everywhere(self) -> LoopSystem:
        """The system, of whose nonlinearities more is known than what they are on an interval.

        Raises
        ------
        InputError
            Nothing more is.
        """
        if self.local:
            raise InputError(
                "the classes of the system hold on an interval alone; from where its loop recovers is told by lure "
                "region and lure.analysis.region, and this question needs classes without on"
            )
        return self

    @property
    def mixed(self) -> bool:
        """Whether nonlinearities of some channels are known, and ``classes`` are about the others."""
        return any("channel" in table for table in self.nonlinearity_tables)

    @property
    def in_order(self) -> list[tuple[Nonlinearity | NonlinearityClass, int]]:
        """What stands in each block of channels of a mixed system, and in how many.

        Raises
        ------
        InputError
            The channels of the nonlinearities and those of the classes are not all channels, each once.
        """
        known, at = dict[int, tuple[Nonlinearity, int]](), 0
        for table in self.nonlinearity_tables:
            size, first = int(str(table.get("repeated", 1))), int(str(table.get("channel", 0)))
            if not first or first in known:
                raise InputError(
                    "nonlinearity: some of the tables have a channel, and each needs one of its own where [[class]] "
                    "tables are about the others; give channel = n, the first of its channels, in each"
                )
            known[first] = self.nonlinearities[at], size
            at += size
        others = [] if self.classes is None else [(self.classes.classes[b[0]], len(b)) for b in self.classes.blocks]
        found = list[tuple[Nonlinearity | NonlinearityClass, int]]()
        m = self.channels
        blocks, channel, taken = iter(others), 1, 0
        while channel <= m:
            one = known.get(channel) or next(blocks, None)
            if one is None:
                break
            taken += channel in known
            found.append(one)
            channel += one[1]
        if channel != m + 1 or taken != len(known) or next(blocks, None) is not None:
            raise InputError(
                f"nonlinearity: the tables with a channel and the tables [[class]] for the others do not fill the {m} "
                "channels one after the other; give for each channel one of the two"
            )
        return found

    @property
    def several(self) -> bool:
        """Whether the block is one of matrices, with a class for each channel, be it one."""
        return isinstance(self.block, ManyChannels)

    @property
    def channels(self) -> int:
        """How many nonlinearities close the loop."""
        return self.block.inputs if isinstance(self.block, ManyChannels) else 1

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; ``classes`` and ``nonlinearities`` stand there for several channels."""
        found = super().to_dict()
        left_out = [] if self.several else ["classes", "nonlinearities"]
        left_out += [name for name in ("performance", "forcing") if getattr(self, name) is None]
        left_out += [] if self.local else ["local"]
        return {key: value for key, value in found.items() if key not in left_out}

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield from loop_rows(self.block, self.nonlinearity)
        if self.mixed:
            yield from (("in order", str(one) + f" ({size} channels)" * (size > 1)) for one, size in self.in_order)
            return
        for i, one in enumerate(self.nonlinearities, 1):
            yield f"phi_{i}", str(one)
        asked = self.nonlinearity_class or self.classes
        if asked is not None:
            yield "class asked about", str(asked)
        for i, local in enumerate(self.local, 1):
            yield f"class of channel {i}", str(local)
        if self.performance is not None:
            yield "performance", str(self.performance)
        if self.forcing is not None:
            yield "forcing", str(self.forcing)
        if self.source:
            yield "source", self.source


def loop_system(
    identity: tuple[str, str, str],
    block: Block,
    *,
    nonlinearity_table: Mapping[str, object] | None = None,
    nonlinearity_class: NonlinearityClass | None = None,
) -> LoopSystem:
    """A loop from its block and the table of its nonlinearity.

    Parameters
    ----------
    identity : tuple of str
        Name, title and source.
    block : RationalPlant, DelayPlant, StateSpace or MultivariablePlant
        The linear block.
    nonlinearity_table : Mapping of str to object, or None
        ``kind`` and parameters of the nonlinearity, as :func:`lure.nonlinearities.nonlinearity_from_table` takes them.
    nonlinearity_class : NonlinearityClass or None
        The class asked about.

    Raises
    ------
    InputError
        The nonlinearity is refused, or it is not known to belong to the class: the class would promise what the
        nonlinearity breaks.
    """
    nonlinearity = None
    if nonlinearity_table is not None:
        nonlinearity = nonlinearity_of(nonlinearity_table)
        if nonlinearity_class is not None:
            _check_member(nonlinearity, nonlinearity_class)
    name, title, source = identity
    return LoopSystem(
        name=name,
        title=title,
        block=block,
        nonlinearity=nonlinearity,
        nonlinearity_class=nonlinearity_class,
        source=source,
        nonlinearity_table=None if nonlinearity_table is None else MappingProxyType(dict(nonlinearity_table)),
    )


def channel_system(
    identity: tuple[str, str, str],
    plant: ManyChannels,
    *,
    classes: Diagonal | None = None,
    nonlinearity_tables: Sequence[Mapping[str, object]] = (),
) -> LoopSystem:
    """A loop of several channels from its plant and the tables of its nonlinearities.

    Parameters
    ----------
    identity : tuple of str
        Name, title and source.
    plant : MultivariablePlant, ChannelFamily or DelayMatrix
        The linear part.
    classes : Diagonal or None
        The class of each channel.
    nonlinearity_tables : sequence of Mapping of str to object
        As for :func:`loop_system`, in the order of the channels; with ``repeated`` where one acts in several in turn.
        With ``channel``, the first of its channels, ``classes`` are about the others, in their order.

    Raises
    ------
    InputError
        Inputs and outputs, the classes or the nonlinearities differ in number, a nonlinearity is refused, or is not
        known to belong to its class; or one nonlinearity is said to act in channels that have several.
    """
    m = plant.inputs
    if m != plant.outputs:
        raise InputError(f"plant: it has {plant.size}; nonlinearities mu_i = -phi_i(sigma_i) need as many of both")
    found: list[Nonlinearity] = []
    for table in nonlinearity_tables:
        each = single(table)
        found += [nonlinearity_of(each[0])] * len(each)
    name, title, source = identity
    made = LoopSystem(
        name=name,
        title=title,
        source=source,
        block=plant,
        classes=classes,
        nonlinearities=tuple(found),
        nonlinearity_tables=tuple(MappingProxyType(dict(table)) for table in nonlinearity_tables),
    )
    if made.mixed:
        _ = made.in_order  # refuses what does not fit
        return made
    for number, word in ((len(found), "nonlinearity"), (0 if classes is None else len(classes.classes), "class")):
        if number not in (0, m):
            raise InputError(
                f"{word}: the tables [[{word}]] are about {number} channel{'s' * (number != 1)}, and the plant has {m} "
                f"of them; give one for each channel, in order, with repeated = n for one that acts in n, "
                "or channel = n in each [[nonlinearity]] where [[class]] is about the others"
            )
    for one, own in zip(found, () if classes is None else classes.classes, strict=False):
        _check_member(one, own)
    for block in () if classes is None or not found else classes.blocks:
        if any(found[i] != found[block[0]] for i in block):
            raise InputError(
                f"class: one nonlinearity acts in the channels {block[0] + 1} to {block[-1] + 1}, and those of "
                "[[nonlinearity]] differ there; leave repeated out of the class, or give one nonlinearity"
            )
    return made


def single(table: Mapping[str, object]) -> list[Mapping[str, object]]:
    """The table of a nonlinearity once for each of its channels."""
    rest = {key: value for key, value in table.items() if key not in ("repeated", "channel")}
    return [rest] * int(str(table.get("repeated", 1)))


def nonlinearity_of(table: Mapping[str, object]) -> Nonlinearity:
    """The nonlinearity of a table."""
    from lure.nonlinearities import nonlinearity_from_table

    values = dict(table)
    return nonlinearity_from_table(str(values.pop("kind")), values)


def _check_member(nonlinearity: Nonlinearity, asked: NonlinearityClass) -> None:
    from lure.nonlinearities import ExpressionNonlinearity, nonlinearity_class
    from lure.nonlinearities.properties import require_given_alone

    require_given_alone(asked)
    if isinstance(nonlinearity, ExpressionNonlinearity) and not nonlinearity.sector_declared:
        return  # it declares nothing that could be compared: the analysis certifies it, or says that it was given so
    known = nonlinearity_class(nonlinearity)
    inside = asked.sector.lower <= known.sector.lower and known.sector.upper <= asked.sector.upper
    slope = asked.slope is None or (
        known.slope is not None and asked.slope.lower <= known.slope.lower and known.slope.upper <= asked.slope.upper
    )
    if not (inside and slope and (known.odd or not asked.odd)):
        raise InputError(
            f"the class is {asked} but the nonlinearity is only known to be among {known}; give a class that "
            "contains the nonlinearity, or leave one of the two out"
        )
