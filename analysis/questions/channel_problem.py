"""The question about several nonlinearities, in whatever form the plant and the classes are given."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

from lure.analysis.nonlinearity.membership import examined
from lure.analysis.questions.problem import Kind, Problem, class_given, is_rough
from lure.analysis.theorems.table import BEST
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.files.system import LoopSystem
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.reading import as_nonlinearity
from lure.plants import as_plant
from lure.plants.channel_family import ChannelFamily
from lure.plants.conversion import rational_if_moderate
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, one_channel_of
from lure.plants.family import PlantFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant


def channel_plant(source: object) -> MultivariablePlant:
    """The plant of several channels that a source means.

    ``source``: whatever :func:`lure.as_plant` takes; one channel may be given as a transfer function.  Or a system of a
    file.

    Raises
    ------
    InputError
        It is not rational, or has parameters in intervals.
    """
    found = source.block if isinstance(source, LoopSystem) else rational_if_moderate(as_plant(source))
    if isinstance(found, RationalPlant):
        found = MultivariablePlant.of_one_channel(found)
    if isinstance(found, PlantFamily | ChannelFamily):
        raise InputError("this is not asked for plants with parameters yet; give each parameter one number")
    if isinstance(found, DelayMatrix | DelayPlant):
        raise InputError(
            f"the plant has {found if isinstance(found, DelayMatrix) else 'dead time'}; with dead time the largest "
            "classes, one class, the L2 gain and the decay rate are asked about (max_sector, max_slope, certify, "
            "analyse, l2_gain, decay_rate), nothing else yet; leave the dead time out, or put a rational factor in its "
            "place"
        )
    if not isinstance(found, MultivariablePlant):
        raise InputError(
            f"several nonlinearities need a rational plant with exact entries; this is a {type(found).__name__}"
        )
    return found


def channel_plants(source: object) -> MultivariablePlant | ChannelFamily:
    """The same, or the plants with parameters, for the questions that are asked of these.

    ``source``: as for :func:`channel_plant`.

    Raises
    ------
    InputError
        It is not rational.
    """
    found = source.block if isinstance(source, LoopSystem) else source
    if isinstance(found, PlantFamily):
        return found.channels
    return found if isinstance(found, ChannelFamily) else channel_plant(source)


def loop_plant(source: object) -> MultivariablePlant | DelayMatrix:
    """The same without parameters, or a plant with dead times.

    ``source``: as for :func:`channel_plant`.

    Raises
    ------
    InputError
        It is neither.
    """
    found = late_plant(source)
    return channel_plant(source) if found is None else found


def late_plant(source: object) -> DelayMatrix | None:
    """The plant with dead times that a source means, one with a single channel too; None if it has none.

    ``source``: as for :func:`channel_plant`.
    """
    found = source.block if isinstance(source, LoopSystem) else as_plant(source)
    if isinstance(found, DelayPlant):
        found = one_channel_of(found)
    return found if isinstance(found, DelayMatrix) else None


def channel_problem(
    source: object, given: object, *, kind: Kind = "class", criterion: str = BEST, late: bool = False
) -> Problem:
    """The question about a plant and what closes its channels.

    Parameters
    ----------
    source : object
        Anything :func:`lure.as_plant` takes.
    given : object
        A ``Diagonal``; a list of ``Sector``, ``SlopeBounds`` or ``NonlinearityClass`` in channel order, of
        nonlinearities (objects or formulas), or of both, the class of a nonlinearity standing for it; a mapping of the
        names of the channels to these; None for what the system of a file says, and without that for slopes (sectors)
        ``[0, 1]``: their largest factor is the largest slope.
    kind : {"sector", "slope", "class"}
        What is asked.
    criterion : str
        The criterion asked for, or ``best``.
    late : bool
        Whether the question may be asked of plants with dead times.

    Raises
    ------
    InputError
        The plant is not rational, what is given is neither, or not for each channel, or a declaration is false.
    """
    plant: MultivariablePlant | ChannelFamily | DelayMatrix | None = late_plant(source) if late else None
    plant = channel_plants(source) if plant is None else plant
    named: dict[str, Any] = {}
    if isinstance(source, LoopSystem):
        source = source.everywhere()
        named = {"name": source.name, "title": source.title, "source": source.source}
        if given is None:
            given = _mixture(source.in_order) if source.mixed else _said(source)
    if given is None:
        kind = "slope" if kind == "class" else kind
        given = [Sector(0, 1) if kind == "sector" else SlopeBounds(0, 1)] * plant.inputs
    if isinstance(given, Sector | SlopeBounds | NonlinearityClass):
        given = [given]
    if isinstance(given, Mapping):
        given = _in_order(plant, given)
    if isinstance(given, NonlinearityClass):
        given = [given]
    settings: dict[str, Any] = {"plant": plant, "kind": kind, "criterion": criterion, **named}
    if isinstance(given, Diagonal):
        return _sloped(Problem(classes=given, **settings))
    if isinstance(given, _Known):
        return _about(given, settings)
    listed = list(given) if isinstance(given, list | tuple) else []
    found = [class_given(one) for one in listed]
    classes = tuple(one for one in found if one is not None)
    if classes and len(classes) == len(listed):
        return _sloped(Problem(classes=Diagonal(classes), **settings))
    if classes:
        return _sloped(Problem(classes=_mixture([(one, 1) for one in listed]), **settings))
    if not listed:
        raise InputError(
            f"the classes are {given!r:.80}; give a Sector, SlopeBounds or NonlinearityClass a channel, in order, or a "
            "nonlinearity a channel"
        )
    nonlinearities = [as_nonlinearity(one) for one in listed]
    return _about(_Known(nonlinearities, None), settings)


def _sloped(problem: Problem) -> Problem:
    """The problem, if it does not ask for slopes of classes that bound none."""
    lacking = [i for i, one in enumerate(problem.classes.classes, 1) if one.slope is None and not one.operator]
    if problem.kind == "slope" and lacking:
        raise InputError(
            f"the class of channel {lacking[0]} has no slope bounds; give SlopeBounds, or ask for the largest "
            "factor of sectors (max_sector, lure max-sector)"
        )
    return problem


def _mixture(blocks: Sequence[tuple[object, int]]) -> Diagonal:
    """The classes where some nonlinearities are known, with the smallest class of each; equal ones in turn are one."""
    found, before = list[tuple[NonlinearityClass, int]](), None
    for i, (one, size) in enumerate(blocks, 1):
        asked, known = class_given(one), None
        if asked is None:
            try:
                seen = examined(as_nonlinearity(one))
            except InputError as error:
                raise InputError(f"number {i} of what closes the channels: {error}") from None
            known, asked = seen.nonlinearity, seen.nonlinearity_class
            _require_lipschitz(i, known, asked)
        if known is not None and known == before:
            size += found.pop()[1]
        found.append((asked, size))
        before = known
    classes = tuple(one for one, size in found for _ in range(size))
    return Diagonal(classes, repeated=tuple(size for _, size in found))


def _require_lipschitz(i: int, nonlinearity: Nonlinearity, asked: NonlinearityClass) -> None:
    """Refuse a nonlinearity that is not known to be locally Lipschitz."""
    if is_rough(nonlinearity, asked):
        raise InputError(
            f"channel {i}: {nonlinearity} is not known to be locally Lipschitz, which the theorems on several "
            "nonlinearities assume; give one that is, or declare it"
        )


class _Known:
    """Nonlinearities of all channels, and the classes asked about if there are such."""

    def __init__(self, nonlinearities: Sequence[Nonlinearity], classes: Diagonal | None) -> None:
        self.nonlinearities, self.classes = nonlinearities, classes


def _said(system: LoopSystem) -> object:
    return _Known(system.nonlinearities, system.classes) if system.nonlinearities else system.classes


def _in_order(plant: MultivariablePlant | ChannelFamily | DelayMatrix, given: Mapping[str, object]) -> list[object]:
    """What is given by the names of the channels, in their order."""
    names = () if isinstance(plant, ChannelFamily) else plant.names
    if set(given) != set(names):
        listed = ", ".join(names) or "no names"
        raise InputError(
            f"the channels are given as {', '.join(map(str, given))}, and the plant has {listed}; give each"
        )
    return [given[name] for name in names]


def _about(known: _Known, settings: Mapping[str, Any]) -> Problem:
    """The question whether the loop with these nonlinearities is stable: for every member of their classes."""
    classes, tested = list[NonlinearityClass](), list[Nonlinearity]()
    asked: Iterable[NonlinearityClass | None] = (
        [None] * len(known.nonlinearities) if known.classes is None else known.classes.classes
    )
    for i, (one, own) in enumerate(zip(known.nonlinearities, asked, strict=True), 1):
        if own is not None and (own.memory or own.operator):
            raise InputError(f"channel {i}: {own} is no function of sigma; give classes alone")
        try:
            found = examined(one, own)
        except InputError as error:
            raise InputError(f"channel {i}: {error}") from None
        _require_lipschitz(i, found.nonlinearity, found.nonlinearity_class)
        classes.append(found.nonlinearity_class)
        tested.append(found.nonlinearity)
    sizes = tuple(len(list(block)) for _, block in groupby(tested))  # equal ones in turn are one nonlinearity
    diagonal = known.classes or Diagonal(tuple(classes), repeated=sizes)
    return replace(Problem(classes=diagonal, **settings), known=tuple(tested))
