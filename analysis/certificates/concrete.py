"""Laws whose membership in a class the checker can decide: piecewise linear ones and the hyperbolic tangent."""

from __future__ import annotations

from typing import Any

from lure.laws import ExpressionLaw, GraphLaw, Tanh
from lure.nonlinearity import NormalCompliance


def law_of(law: object) -> dict[str, Any] | None:
    """``LAW`` of a certificate, all numbers exact; None for a law that can only be declared to be in its class.

    Parameters
    ----------
    law : object
        A law of the library, or None.

    Examples
    --------
    >>> from lure import Tanh
    >>> law_of(Tanh(scale=2, gain=3))
    {'kind': 'tanh', 'height': '3', 'rate': '1/2'}
    """
    if isinstance(law, Tanh):
        return {"kind": "tanh", "height": str(law.gain), "rate": str(1 / law.scale)}
    if isinstance(law, NormalCompliance) and law.exact_exponent == 1:
        return {"kind": "piecewise-linear", "points": [["0", "0"]], "left": "0", "right": str(law.exact_stiffness)}
    graph = law.graph if isinstance(law, GraphLaw | ExpressionLaw) else None
    if graph is None:
        return None
    points = [[str(x), str(y)] for x, y in zip(graph.knots, graph.values, strict=True)]
    return {
        "kind": "piecewise-linear",
        "points": points,
        "left": str(graph.slopes[0]),
        "right": str(graph.slopes[-1]),
    }
