"""What a question is about: a block with a law or a class of laws, in whatever form it was given."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.answers.state_space import by_matrices
from analysis.membership import Membership, examined
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.inputs import as_block
from lure.law_class import LawClass
from lure.loop import Loop
from lure.nonlinearity import Nonlinearity
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.systems_loop import LoopSystem


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
    loop : LoopSystem, Loop, or anything :func:`lure.inputs.as_block` takes
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
