"""The question about several nonlinearities: a plant, and the class of each channel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.systems import class_entry, texts
from lure.analysis.questions.problem import class_given
from lure.analysis.theorems.table import BEST, time_of
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.plants import as_plant
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.plants.realisation import companion


@dataclass(frozen=True, kw_only=True, slots=True)
class ChannelProblem:
    """A question about ``sigma = H mu``, ``mu_i = -phi_i(sigma_i)``; plain data.

    Attributes
    ----------
    plant : MultivariablePlant
        The linear part, with as many outputs as inputs.
    classes : Diagonal
        The class of each nonlinearity, all bounds finite.
    criterion : str
        The criterion asked for, or ``best``.

    Raises
    ------
    InputError
        Inputs, outputs and classes differ in number, or a bound is infinite.
    """

    plant: MultivariablePlant
    classes: Diagonal
    criterion: str = BEST

    def __post_init__(self) -> None:
        H, given = self.plant, self.classes.classes
        if H.inputs != H.outputs:
            raise InputError(f"the plant has {H.size}; nonlinearities mu_i = -phi_i(sigma_i) need as many of both")
        if len(given) != H.inputs:
            raise InputError(
                f"{len(given)} classes are given for the {H.inputs} channels of the plant; give one for each, in order"
            )
        for i, (low, high) in enumerate(map(_bounds, given), 1):
            if not (-math.inf < low <= high < math.inf):
                raise InputError(f"channel {i} has the bounds [{low}, {high}]; with several channels they are finite")

    @property
    def system(self) -> dict[str, Any]:
        """The system of a certificate."""
        sides = {name: [texts(row) for row in getattr(self.plant, name)] for name in "ABCD"}
        return {"kind": "multivariable", "time": time_of(self.plant), **sides}

    @property
    def lower(self) -> list[Fraction]:
        """Lower bounds of ``phi_i(sigma)/sigma``."""
        return [Fraction(_bounds(one)[0]) for one in self.classes.classes]

    @property
    def least(self) -> Fraction:
        """Factors beyond it leave every upper bound above the lower one."""
        ends = [(Fraction(low), Fraction(high)) for low, high in map(_bounds, self.classes.classes)]
        return max(Fraction(0), *(low / high for low, high in ends if high > 0))

    def class_entries(self, alpha: Fraction) -> dict[str, Any]:
        """The classes of a certificate, every upper bound times ``alpha``."""
        scaled = [scaled_class(one, alpha) for one in self.classes.classes]
        return {"channels": [class_entry(one, unbounded=False) for one in scaled], "repeated": self.classes.repeated}

    def upper(self, alpha: Fraction) -> list[Fraction]:
        """Upper bounds of ``phi_i(sigma)/sigma``, times ``alpha``."""
        return [Fraction(_bounds(scaled_class(one, alpha))[1]) for one in self.classes.classes]


def _bounds(given: NonlinearityClass) -> tuple[float | Fraction, float | Fraction]:
    slope = given.slope or SlopeBounds(-math.inf, math.inf)
    return max(given.sector.lower, slope.lower), min(given.sector.upper, slope.upper)


def scaled_class(given: NonlinearityClass, alpha: Fraction) -> NonlinearityClass:
    """The class with its upper bounds times ``alpha``; lower bounds stay.

    Parameters
    ----------
    given : NonlinearityClass
        A class with finite bounds of the sector.
    alpha : Fraction
        The factor.
    """

    def top(value: float | Fraction) -> float | Fraction:
        return value if value in (math.inf, -math.inf) else alpha * Fraction(value)

    slope = given.slope and SlopeBounds(given.slope.lower, top(given.slope.upper))
    return NonlinearityClass(
        sector=Sector(given.sector.lower, top(given.sector.upper)),
        slope=slope,
        odd=given.odd,
        time_varying=given.time_varying,
    )


def channel_problem(source: object, classes: object, *, criterion: str = BEST) -> ChannelProblem:
    """The question about a plant and the classes of its channels, in whatever form they are given.

    Parameters
    ----------
    source : object
        Whatever :func:`lure.as_plant` takes; one channel may be given as a transfer function.
    classes : object
        A ``Diagonal``, or a list of ``Sector``, ``SlopeBounds`` or ``NonlinearityClass`` in channel order.
    criterion : str
        The criterion asked for, or ``best``.

    Raises
    ------
    InputError
        The plant is not rational, or the classes are no classes or not one for each channel.
    """
    found = as_plant(source)
    if isinstance(found, RationalPlant):
        r = found.matrices or companion(found)
        found = MultivariablePlant(r.A, tuple((v,) for v in r.b), (r.c,), ((r.d,),), found.dt)
    if not isinstance(found, MultivariablePlant):
        raise InputError(
            f"several nonlinearities need a rational plant with exact entries; this is a {type(found).__name__}"
        )
    if isinstance(classes, Diagonal):
        return ChannelProblem(plant=found, classes=classes, criterion=criterion)
    listed = [class_given(one) for one in classes] if isinstance(classes, list | tuple) else []
    known = tuple(one for one in listed if one is not None)
    if not known or len(known) < len(listed):
        raise InputError(
            f"the classes are {classes!r:.80}; give a Sector, SlopeBounds or NonlinearityClass a channel, in order"
        )
    return ChannelProblem(plant=found, classes=Diagonal(known), criterion=criterion)
