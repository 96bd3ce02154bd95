"""What a question is about: a block with a law or a class of laws, in whatever form it was given."""

from __future__ import annotations

from dataclasses import dataclass

from lure.analysis.nonlinearity.membership import Membership, examined
from lure.analysis.questions.state_space import by_matrices
from lure.classes import LawClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.files.system import LoopSystem
from lure.loop import Loop
from lure.nonlinearities import ExpressionLaw
from lure.nonlinearities.protocol import Nonlinearity
from lure.nonlinearities.reading import as_law
from lure.plants import as_block
from lure.plants.delay import DelayBlock
from lure.plants.rational import RationalBlock
from lure.plants.state_space import StateSpaceBlock
from lure.rod.systems import RodSystem

# A plant and a nonlinearity, each in whatever form a user has it, as one loop.


def class_given(nonlinearity: object) -> LawClass | None:
    """The class that somebody means by a class, a sector or slope bounds; None for anything else.

    Parameters
    ----------
    nonlinearity : object
        ``Sector(0, 5)`` is every time-invariant ``phi`` in it, ``SlopeBounds(0, 1)`` every one with such slopes.

    Examples
    --------
    >>> print(class_given(Sector(0, 5)), "|", class_given(SlopeBounds(0, 1)))
    phi in the sector [0, 5] | phi with slope in [0, 1]
    """
    if isinstance(nonlinearity, LawClass):
        return nonlinearity
    if isinstance(nonlinearity, Sector):
        return LawClass(sector=nonlinearity)
    if isinstance(nonlinearity, SlopeBounds):
        return LawClass.slope_restricted(nonlinearity.lower, nonlinearity.upper)
    return None


def loop_given(plant: object, nonlinearity: object = None) -> object:
    """The plant with the nonlinearity, for every question that takes a loop; the plant itself if none is given.

    Parameters
    ----------
    plant : object
        Anything :func:`lure.as_block` takes, or a named plant without a nonlinearity.
    nonlinearity : object
        A law of :mod:`lure.nonlinearities` or any object with a sector, a formula as text,
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
    closed = isinstance(plant, Loop | RodSystem)
    if closed or (isinstance(plant, LoopSystem) and not (plant.nonlinearity is None and plant.law_class is None)):
        raise InputError(
            f"a {type(plant).__name__} closes the loop itself and a nonlinearity is given beside it; leave one of the "
            "two out, or give the block alone, loop.block"
        )
    law_class = class_given(nonlinearity)
    law = None
    if law_class is None:
        law = ExpressionLaw(nonlinearity) if isinstance(nonlinearity, str) else as_law(nonlinearity)
    named = plant if isinstance(plant, LoopSystem) else None
    block = as_block(plant) if named is None else named.block
    return LoopSystem(
        name="loop" if named is None else named.name,
        title="" if named is None else named.title,
        source="" if named is None else named.source,
        block=block,  # type: ignore[arg-type]  # measured data is refused where it cannot serve, with its reason
        nonlinearity=law,
        law_class=law_class,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Subject:
    """A loop to analyse.

    Attributes
    ----------
    name : str
        Name for the report.
    title : str
        One line that says what it is; may be empty.
    source : str
        Where it comes from; may be empty.
    block : RationalBlock or DelayBlock
        The linear block.
    law : Nonlinearity or None
        A law, if one was given.
    law_class : LawClass or None
        The class to decide: the one given, or the tightest the law is known to belong to.
    membership : Membership or None
        What is known of the law as a member of the class, if there is a law.
    """

    name: str
    title: str = ""
    source: str = ""
    block: RationalBlock | DelayBlock | StateSpaceBlock
    law: Nonlinearity | None = None
    law_class: LawClass | None = None
    membership: Membership | None = None


def subject(loop: object) -> Subject:
    """The subject of a loop, a system from a file, or a block alone.

    Parameters
    ----------
    loop : LoopSystem, Loop, or anything :func:`lure.plants.as_block` takes
        The loop.

    Raises
    ------
    InputError
        It is none of these, or what is declared of the law is false.
    AssumptionError
        The block is of a kind that can be computed with but not certified: too large, or measured; or a sample breaks
        what is declared of a law known by its values alone.
    """
    if isinstance(loop, Subject):
        return loop
    if isinstance(loop, LoopSystem):
        block = certifiable(loop.block)
        given = None if loop.nonlinearity is None else examined(loop.nonlinearity, loop.law_class)
        return Subject(
            name=loop.name,
            title=loop.title,
            source=loop.source,
            block=block,
            law=None if given is None else given.nonlinearity,
            law_class=loop.law_class if given is None else given.law_class,
            membership=None if given is None else given.membership,
        )
    if isinstance(loop, Loop):
        block, given = certifiable(as_block(loop.block)), examined(loop.nonlinearity)
        return Subject(
            name="loop",
            block=block,
            law=given.nonlinearity,
            law_class=given.law_class,
            membership=given.membership,
        )
    return Subject(name="loop", block=certifiable(as_block(loop)))


def certifiable(block: object) -> RationalBlock | DelayBlock | StateSpaceBlock:
    """The block, if there is exact data behind it; by its matrices where these are doubles and polynomials too long.

    Parameters
    ----------
    block : object
        A block.

    Raises
    ------
    AssumptionError
        There is not.
    """
    if isinstance(block, RationalBlock):
        return by_matrices(block) or block
    if isinstance(block, DelayBlock | StateSpaceBlock):
        return block
    raise AssumptionError(
        f"a {type(block).__name__} gives computed numbers, and nothing certified can be said of it; give coefficients, "
        "matrices, or a formula"
    )
