"""What a question is about: a block with a law or a class of laws, in whatever form it was given."""

from __future__ import annotations

from dataclasses import dataclass

from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.inputs import as_block
from lure.law_class import LawClass
from lure.loop import Loop
from lure.nonlinearity import Nonlinearity
from lure.rational import RationalBlock
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
    """

    name: str
    title: str = ""
    source: str = ""
    block: RationalBlock | DelayBlock
    law: Nonlinearity | None = None
    law_class: LawClass | None = None


def subject(loop: object) -> Subject:
    """The subject of a loop, a system from a file, or a block alone.

    Parameters
    ----------
    loop : LoopSystem, Loop, or anything :func:`lure.inputs.as_block` takes
        The loop.

    Raises
    ------
    InputError
        It is none of these.
    AssumptionError
        The block is of a kind that can be computed with but not certified: too large, or measured; or a sample breaks
        what is declared of the law.
    """
    if isinstance(loop, Subject):
        return loop
    if isinstance(loop, LoopSystem):
        law, law_class = loop.nonlinearity, loop.law_class
        return Subject(
            name=loop.name,
            title=loop.title,
            source=loop.source,
            block=certifiable(loop.block),
            law=law,
            law_class=law_class if law_class is not None else _class_of(law),
        )
    if isinstance(loop, Loop):
        block = certifiable(as_block(loop.block))
        return Subject(name="loop", block=block, law=loop.nonlinearity, law_class=_class_of(loop.nonlinearity))
    return Subject(name="loop", block=certifiable(as_block(loop)))


def certifiable(block: object) -> RationalBlock | DelayBlock:
    """The block, if there is exact data behind it.

    Parameters
    ----------
    block : object
        A block.

    Raises
    ------
    AssumptionError
        There is not.
    """
    if isinstance(block, RationalBlock | DelayBlock):
        return block
    raise AssumptionError(
        f"a {type(block).__name__} gives computed numbers, and nothing certified can be said of it; give coefficients, "
        "matrices of order up to 60, or a formula"
    )


def _class_of(law: Nonlinearity | None) -> LawClass | None:
    if law is None:
        return None
    from lure.laws import check_declared, law_class

    check_declared(law)  # a declaration that a sample breaks is refused; one that survives is still a declaration
    return law_class(law)
