"""A question in the form a certificate has: a block, a class of laws, perhaps one law, in exact numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from lure.analysis.certificates import codes
from lure.analysis.certificates.sealing import Failure, guarded
from lure.analysis.certificates.systems import law_of, laws_of
from lure.analysis.nonlinearity.membership import Membership, examined
from lure.analysis.questions.conclusion import is_rough
from lure.analysis.questions.state_space import by_matrices
from lure.analysis.theorems.table import BEST, TABLE, theorems_for
from lure.classes import LawClass, Sector
from lure.errors import AssumptionError, InputError
from lure.files.system import LoopSystem
from lure.loop import Loop
from lure.nonlinearities.protocol import Nonlinearity
from lure.plants import as_block
from lure.plants.delay import DelayBlock
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalBlock
from lure.plants.state_space import StateSpaceBlock
from lure.rod.systems import RodSystem
from lure.rod.transfer import RodBlock
from lure.rod.upwind import UpwindScheme, upwind

AnyBlock = RationalBlock | DelayBlock | StateSpaceBlock | FrequencyData | UpwindScheme | RodBlock
_EVERY = LawClass(sector=Sector(0, math.inf))


@dataclass(frozen=True, kw_only=True, slots=True)
class Question:
    """A loop and a class of laws: is the loop stable for every one of them.

    Attributes
    ----------
    block : RationalBlock, DelayBlock, StateSpaceBlock, FrequencyData, UpwindScheme or RodBlock
        The linear block.
    law_class : LawClass
        The class.
    laws : Mapping
        The class as it stands in a certificate.
    law : Mapping or None
        The law as it stands in a certificate, where its membership can be checked.
    nonlinearity : Nonlinearity or None
        The law, if one is given and the question is not about linear gains alone.
    criterion : str
        The criterion asked for, or ``best``.
    finite : bool
        Whether an infinite upper end means every law with some finite bound.
    rough : bool
        Whether there is a law that lacks the regularity every theorem here assumes, so that nothing is proved for it.
    refusals : tuple of Failure
        What is known to stand in the way before any search.
    membership : Membership or None
        What is known of the law as a member of the class, if there is a law.
    """

    block: AnyBlock
    law_class: LawClass
    laws: Mapping[str, Any]
    law: Mapping[str, Any] | None
    nonlinearity: Nonlinearity | None
    criterion: str
    finite: bool
    rough: bool
    refusals: tuple[Failure, ...] = ()
    membership: Membership | None = None


def posed(
    loop: object,
    law_class: LawClass | None,
    *,
    criterion: str,
    finite: bool,
    method: str = "best",
) -> Question:
    """The question about a loop.

    Parameters
    ----------
    loop : LoopSystem, RodSystem, Loop, or anything :func:`lure.plants.as_block` takes
        The loop.  A ``RodSystem`` means the rod itself, for a named criterion or a proof by matrices its scheme.
    law_class : LawClass or None
        The class; None for the class of the loop, or the smallest its law is known to belong to.  A class given here
        leaves the law of the loop out.
    criterion : str
        The criterion asked for; ``hurwitz`` is about linear gains alone.
    finite : bool
        Whether an infinite upper end means every law with some finite bound.
    method : str
        The kind of proof asked for, or ``best``.

    Raises
    ------
    InputError
        The loop is none, there is no class, or no such criterion.
    """
    named = [row for row in TABLE if row.name == criterion]
    linear = any(row.linear for row in named)
    block, law, own = _parts(loop, scheme=criterion != BEST or method == "matrix")
    if isinstance(block, RationalBlock) and (criterion == BEST or any(row.matrix for row in named)):
        block = by_matrices(block) or block
    refusals, member, untested = list[Failure](), None, False
    if law_class is not None:
        law = None
    elif law is not None:
        known = guarded("the law", lambda: examined(law, own), passing=(InputError,))
        if isinstance(known, Failure):
            refusals, law_class, untested = [known], own or LawClass(sector=law.sector), True
        else:
            law, law_class, member = known.nonlinearity, known.law_class, known.membership
    else:
        law_class = own
    if law_class is None:
        raise InputError("no class of laws is given; give one such as a sector [0, 5.9], or a law")
    with suppress(AssumptionError):  # what does not apply is a result; a name that does not exist is a mistake
        theorems_for(block, "sector" if law_class.slope is None else "slope", criterion)
    rough = law is not None and not untested and is_rough(law, law_class)
    hopeless = rough and not _next_state_is_defined(block)
    if hopeless:
        words = str(getattr(law, "regularity", "unknown"))
        known_as = "not known to be locally Lipschitz" if words == "unknown" else words
        detail = f"it is {known_as}; in continuous time, or with H(inf) != 0, the theorems assume that it is locally "
        detail += "Lipschitz"
        refusals.append(Failure(search="the law", code=codes.ROUGH_LAW, detail=detail))
    if isinstance(block, FrequencyData):
        detail = f"H is known at {len(block.omega)} frequencies, and nothing is known between them"
        refusals.append(Failure(search="the block", code=codes.SAMPLED, detail=detail))
    return Question(
        block=block,
        law_class=law_class,
        laws=laws_of(law_class, unbounded=not finite, linear=linear, rough=rough),
        law=law_of(law),
        nonlinearity=None if linear else law,
        criterion=criterion,
        finite=finite,
        rough=hopeless or untested,
        refusals=tuple(refusals),
        membership=member,
    )


def _parts(loop: object, *, scheme: bool) -> tuple[AnyBlock, Nonlinearity | None, LawClass | None]:
    """Block, law and class of whatever describes a loop."""
    if isinstance(loop, RodSystem):
        return upwind(loop.rod, loop.cells) if scheme else RodBlock(loop.rod), loop.rod.law, _EVERY
    if isinstance(loop, UpwindScheme | RodBlock):
        return loop, None, _EVERY
    if isinstance(loop, LoopSystem):
        return loop.block, loop.nonlinearity, loop.law_class
    if isinstance(loop, Loop):
        return as_block(loop.block), loop.nonlinearity, None
    return as_block(loop), None, None


def _next_state_is_defined(block: AnyBlock) -> bool:
    """Whether the loop has exactly one solution whatever the law is: in discrete time, without a direct term."""
    direct = block.feedthrough if isinstance(block, RationalBlock) else getattr(block, "D", None)
    return getattr(block, "dt", None) is not None and direct == 0
