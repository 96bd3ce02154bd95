"""The loop: a block in negative feedback with a nonlinearity."""

from __future__ import annotations

from dataclasses import dataclass

from lure.block import Block
from lure.nonlinearity import Nonlinearity


@dataclass(frozen=True, eq=False)
class Loop:
    r"""A Lur'e loop ``sigma = H mu``, ``mu = -phi(sigma)``.

    The minus sign stands here and nowhere else: blocks carry ``H`` from ``mu`` to ``sigma``, laws return ``phi``.

    Parameters
    ----------
    block : Block
        The linear part.
    nonlinearity : Nonlinearity
        The law, with the sector its author vouches for.
    """

    block: Block
    nonlinearity: Nonlinearity
