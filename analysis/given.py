"""A plant and a nonlinearity, each in whatever form a user has it, as one loop."""

from __future__ import annotations

from lure.errors import InputError
from lure.inputs import as_block
from lure.law_class import LawClass
from lure.laws import ExpressionLaw
from lure.laws.accepting import as_law
from lure.loop import Loop
from lure.sector import Sector, SlopeBounds
from lure.systems import RodSystem
from lure.systems_loop import LoopSystem


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
        A law of :mod:`lure.laws` or any object with a sector, a formula as text, ``control.saturation_nonlinearity``,
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
