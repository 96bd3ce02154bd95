"""Blocks and classes of nonlinearities as they stand in a certificate: exact numbers as text ``p`` or ``p/q``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.nonlinearities import ExpressionNonlinearity, GraphNonlinearity, Tanh
from lure.nonlinearities.base import NormalCompliance
from lure.plants.block import StructuredPlant
from lure.plants.channel_family import ChannelFamily, Term
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, one_channel_of
from lure.plants.family import PlantFamily
from lure.plants.multivariable import MultivariablePlant, Rows
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

# Nonlinearities whose membership in a class the checker can decide: piecewise linear ones and the hyperbolic tangent.


def nonlinearity_entry(nonlinearity: object) -> dict[str, Any] | None:
    """``LAW`` of a certificate, all numbers exact; None for one that can only be declared to be in its class.

    ``nonlinearity``: a nonlinearity of the library, or None.

    Examples
    --------
    >>> from lure import Tanh
    >>> nonlinearity_entry(Tanh(scale=2, gain=3))
    {'kind': 'tanh', 'height': '3', 'rate': '1/2'}
    """
    if isinstance(nonlinearity, Tanh):
        return {"kind": "tanh", "height": str(nonlinearity.gain), "rate": str(1 / nonlinearity.scale)}
    if isinstance(nonlinearity, NormalCompliance) and nonlinearity.exact_exponent == 1:
        return {
            "kind": "piecewise-linear",
            "points": [["0", "0"]],
            "left": "0",
            "right": str(nonlinearity.exact_stiffness),
        }
    graph = nonlinearity.graph if isinstance(nonlinearity, GraphNonlinearity | ExpressionNonlinearity) else None
    if graph is None:
        return None
    points = [[str(x), str(y)] for x, y in zip(graph.knots, graph.values, strict=True)]
    return {
        "kind": "piecewise-linear",
        "points": points,
        "left": str(graph.slopes[0]),
        "right": str(graph.slopes[-1]),
    }


def system_of(block: object) -> dict[str, Any]:
    r"""The system of a certificate for a block, in ``sigma = H mu``, ``mu = -phi(sigma)``.

    ``block``: a plant, a family of plants, or matrices, rational or with dead times.  Common factors of a transfer
    function are kept: they are hidden modes.  Entries of matrices mean the doubles they are.

    Returns
    -------
    dict
        ``SYSTEM`` of ``notebooks/notes/0008-certificates.md``.

    Raises
    ------
    InputError
        It is no such block.

    Examples
    --------
    >>> system_of(RationalPlant([1, Fraction("-0.2")], [1, 3, 2]))["numerator"]
    ['1', '-1/5']
    """
    if isinstance(block, RationalPlant):
        time = "continuous" if block.dt is None else "discrete"
        top, bottom = texts(block.numerator), texts(block.denominator)
        return {"kind": "transfer", "time": time, "numerator": top, "denominator": bottom}
    if isinstance(block, PlantFamily | ChannelFamily):
        bounds = [[name, str(low), str(high)] for name, (low, high) in zip(block.names, block.box, strict=True)]
        time = "continuous" if block.dt is None else "discrete"
        kind, sums = ("family", "channel-family")[isinstance(block, ChannelFamily)], list[dict[str, Any]]()
        for one in block.terms:
            if isinstance(one, Term):
                rows = {name: [texts(row) for row in side] for name, side in zip("ABCD", one.sides, strict=True)}
                sums.append({"powers": list(one.powers), "common": str(one.common), **rows})
            else:
                sums.append({"powers": list(one[0]), "numerator": texts(one[1]), "denominator": texts(one[2])})
        found = {"kind": kind, "time": time, "parameters": bounds, "terms": sums}
        if isinstance(block, PlantFamily):
            return {**found, "kind": "delay-family", "delay": texts(block.delay)} if block.delay else found
        return {**found, "kind": "varying-family", "rates": texts(block.rates)} if block.rates else found
    if isinstance(block, DelayPlant) and block.feedback and not block.strictly_proper:
        return system_of(one_channel_of(block))
    if isinstance(block, DelayPlant):
        terms, inner = ([[str(delay), texts(top)] for delay, top in side] for side in (block.terms, block.feedback))
        more = {"feedback": inner} if inner else {}
        return {"kind": "delay", "terms": terms, "denominator": texts(block.denominator), **more}
    if isinstance(block, StateSpace):
        return {
            "kind": "state-space",
            "time": "continuous" if block.dt is None else "discrete",
            "A": [texts(row) for row in block.A.tolist()],
            "b": texts(block.B.tolist()),
            "c": texts(block.C.tolist()),
            "d": text(block.D),
        }
    if isinstance(block, MultivariablePlant):
        time = "continuous" if block.dt is None else "discrete"
        sides = {name: [texts(row) for row in getattr(block, name)] for name in "ABCD"}
        return {"kind": "multivariable", "time": time, **sides}
    if isinstance(block, DelayMatrix):
        sides = {name: [texts(row) for row in getattr(block.base, name)] for name in "ABCD"}
        back: list[tuple[Rows, ...]] = [(rows,) for rows in block.inner] or [()] * len(block.late)
        if block.rates:
            back = [(*one, *pair) for one, pair in zip(back, block.rates, strict=True)]
        late = [
            [str(delay), *([texts(row) for row in side] for side in (rows, *more))]
            for (delay, rows), more in zip(block.late, back, strict=True)
        ]
        return {"kind": "multivariable delay", "time": "continuous", **sides, "late": late}
    if isinstance(block, StructuredPlant):
        return dict(block.certificate_system())
    raise InputError(
        f"a {type(block).__name__} has no exact data to write in a certificate; give coefficients, matrices, a formula "
        "with dead time, or a rod"
    )


def class_entry(
    nonlinearity_class: NonlinearityClass, *, unbounded: bool, linear: bool = False, rough: bool = False
) -> dict[str, Any]:
    """The class of nonlinearities of a certificate.

    Parameters
    ----------
    nonlinearity_class : NonlinearityClass
        The class.
    unbounded : bool
        What an infinite upper end means: that no gain bounds the nonlinearities (``"inf"``), or that each nonlinearity
        has some finite bound (``"finite"``).  An infinite slope above a finite sector is no bound at all in either
        case.
    linear : bool
        Whether only constant gains are meant, whatever the class says.
    rough : bool
        Whether nonlinearities are meant that need not be locally Lipschitz, nor continuous.

    Returns
    -------
    dict
        ``laws`` of ``notebooks/notes/0008-certificates.md``.

    Examples
    --------
    >>> from lure import NonlinearityClass, Sector
    >>> class_entry(NonlinearityClass(sector=Sector(0, math.inf)), unbounded=False)["sector"]
    ['0', 'finite']
    """
    sector, slope = nonlinearity_class.sector, nonlinearity_class.slope
    endless = "inf" if unbounded else "finite"
    bounds = None
    if slope is not None:
        top = endless if slope.upper == math.inf == sector.upper else text(slope.upper)
        bounds = [text(slope.lower), top]
    return {
        "sector": [text(sector.lower), endless if sector.upper == math.inf else text(sector.upper)],
        "slope": bounds,
        "odd": nonlinearity_class.odd,
        "time_varying": nonlinearity_class.time_varying,
        "linear": linear or nonlinearity_class.linear,
        **({"regularity": "any"} if rough else {}),
        **({"relu": True} if nonlinearity_class.rectifier else {}),
        **({} if nonlinearity_class.rate is None else {"rate": str(nonlinearity_class.rate)}),
        **({"memory": nonlinearity_class.memory} if nonlinearity_class.memory else {}),
        **({"operator": nonlinearity_class.operator} if nonlinearity_class.operator else {}),
    }


def class_entries(classes: Diagonal) -> dict[str, Any]:
    """The classes of several nonlinearities of a certificate, all bounds finite.

    ``classes``: the class of each channel.
    """
    repeated = classes.repeated if isinstance(classes.repeated, bool) else list(classes.repeated)
    return {"channels": [class_entry(one, unbounded=False) for one in classes.classes], "repeated": repeated}


def nonlinearity_class_of(nonlinearities: Mapping[str, Any]) -> NonlinearityClass:
    """The class of nonlinearities of a certificate; every finite bound and none at all are the same infinite one.

    ``nonlinearities``: ``laws`` of a certificate.
    """

    def bounds(ends: list[str]) -> tuple[float | Fraction, float | Fraction]:
        """The ends as numbers."""
        low, high = ends
        return (-math.inf if low == "-inf" else Fraction(low)), (
            math.inf if high in ("finite", "inf") else Fraction(high)
        )

    if "operator" in nonlinearities:
        slow = Fraction(nonlinearities["rate"]) if "rate" in nonlinearities else None
        sector = Sector(*bounds(nonlinearities["sector"]))
        own = {"operator": nonlinearities["operator"], "time_varying": nonlinearities["time_varying"]}
        return NonlinearityClass(sector=sector, rate=slow, **own)
    sector, slope = Sector(*bounds(nonlinearities["sector"])), nonlinearities["slope"]
    within = None if slope is None else SlopeBounds(*bounds(slope))
    if within is not None:  # nonlinearities with these slopes lie in the sector of the same bounds
        sector = Sector(max(sector.lower, within.lower), min(sector.upper, within.upper))
    return NonlinearityClass(
        sector=sector,
        slope=within,
        odd=nonlinearities["odd"],
        time_varying=nonlinearities["time_varying"],
        rectifier="relu" in nonlinearities,
        memory=nonlinearities.get("memory", ""),
    )


def text(value: Fraction | float) -> str:
    """A number as text: ``p`` or ``p/q``, a double as the rational it is; ``inf`` and ``-inf``.

    ``value``: the number, not NaN.
    """
    if isinstance(value, float):
        return str(Fraction(value)) if math.isfinite(value) else "inf" if value > 0 else "-inf"
    return str(value)


def texts(values: Iterable[Fraction | float]) -> list[str]:
    """Each number as text."""
    return [text(value) for value in values]
