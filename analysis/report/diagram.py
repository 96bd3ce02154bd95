"""The loop as a picture for the first screen: the linear block above, the nonlinearity with its graph below."""

from __future__ import annotations

import math
import re
from itertools import pairwise

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from lure.classes import NonlinearityClass
from lure.nonlinearities.base import Nonlinearity

Floats = NDArray[np.float64]

_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_LETTER = 0.56  # width of a letter, on the safe side, relative to the size of the type
_ROOM, _LARGEST, _SMALLEST = 292.0, 16.0, 9.5  # width of the upper box and sizes of type [px]
_LONGEST = 52  # letters below the nonlinearity
_LEFT, _TOP, _WIDE, _HIGH = 172.0, 128.0, 96.0, 60.0  # the box of the nonlinearity [px]
_INSET = 7.0
_SAMPLES = 161
_SPANS = np.geomspace(1e-6, 1e6, 97)

_FRAME = """<svg class="diagram" viewBox="0 0 440 218" role="img" aria-label="{label}">
{load}<rect class="box" x="66" y="20" width="308" height="66" rx="3"/>
{linear}<path class="wire" d="M374 53H428"/><path class="tip" d="M427 49v8l9 -4z"/>
<text x="396" y="44">{output}</text>
<path class="wire" d="M402 53V158H276"/><path class="tip" d="M277 154v8l-9 -4z"/>
<rect class="box" x="172" y="128" width="96" height="60" rx="3"/>
{graph}<text class="small" x="220" y="207">{nonlinearity}</text>
<path class="wire" d="M172 158H127"/><path class="tip" d="M128 154v8l-9 -4z"/>
<circle class="box" cx="102" cy="158" r="17"/><text x="102" y="163">−1</text>
<path class="wire" d="M85 158H30V53H58"/><path class="tip" d="M57 49v8l9 -4z"/><text x="34" y="44">{input}</text>
</svg>"""
_LOAD = """<path class="wire" d="M120 0V12"/><path class="tip" d="M116 11h8l-4 9z"/>
<text class="small left" x="130" y="13">{}</text>
"""


def block_diagram(
    formula: str, nonlinearity: str, graph: Markup, *, signals: tuple[str, str] = ("μ", "σ"), load: str = ""
) -> Markup:
    """The loop ``sigma = H mu``, ``mu = -phi(sigma)`` as an SVG picture in the colours of the page.

    Parameters
    ----------
    formula : str
        ``H`` as the block prints itself.  One too long for its box stands as ``H``: see :func:`fits`.
    nonlinearity : str
        What stands below the nonlinearity; its sign alone where it is too long.
    graph : Markup
        What is drawn in its box: from :func:`nonlinearity_graph` or :func:`class_graph`.
    signals : tuple of str
        The input of the linear block, and its output.
    load : str
        What else enters the linear block; empty for nothing.
    """
    return Markup(_FRAME).format(
        label=f"Block diagram: H = {formula} from {signals[0]} to {signals[1]}, "
        f"with {nonlinearity} in negative feedback.",
        linear=_linear(formula),
        load=Markup(_LOAD).format(load) if load else "",
        output=signals[1],
        input=signals[0],
        graph=graph,
        nonlinearity=nonlinearity if len(nonlinearity) <= _LONGEST else "φ",
    )


def fits(formula: str) -> bool:
    """Whether a formula can be read inside its box; ``formula``: ``H`` as the block prints itself."""
    return _size(formula) >= _SMALLEST


def raised(text: str) -> str:
    """Whole powers as raised figures; ``text``: a formula such as ``s^4 + 2 s``.

    Examples
    --------
    >>> raised("s^12 + 0.5 s^2 - 1")
    's¹² + 0.5 s² − 1'
    """
    text = re.sub(r"\^(\d+)", lambda power: power.group(1).translate(_RAISED), text)
    return re.sub(r"(?<![\w.])-(?=\d)|(?<= )-(?= )", "−", text)


def nonlinearity_graph(nonlinearity: Nonlinearity) -> Markup:
    """A small graph of a nonlinearity over the stretch on which it bends, with the ends of its axes."""
    reach = _reach(nonlinearity)
    sigma = np.linspace(-reach, reach, _SAMPLES)
    phi = _values(nonlinearity, sigma)
    height = float(np.max(np.abs(phi[np.isfinite(phi)]), initial=0.0)) or 1.0
    return _axes() + _line(sigma / reach, phi / height) + _ends(reach, height)


def class_graph(nonlinearity_class: NonlinearityClass | None) -> Markup:
    """The sector of a class as a wedge; axes alone without a class."""
    if nonlinearity_class is None:
        return _axes()
    ends = [float(nonlinearity_class.sector.lower), float(nonlinearity_class.sector.upper)]
    steepest = max((abs(end) for end in ends if math.isfinite(end)), default=0.0) or 1.0
    low, high = (_corner(end / steepest) for end in ends)
    half = [(0.0, 0.0), low]
    half += [(1.0, -1.0)] if low[0] < 1 and low[1] < 0 else []
    half += [(1.0, 1.0)] if high[0] < 1 and high[1] > 0 else []
    half += [high]
    wedge = "".join(
        Markup('<path class="wedge" d="M{}z"/>').format(Markup("L").join(_point(sign * x, sign * y) for x, y in half))
        for sign in (1, -1)
    )
    return Markup(wedge) + _axes()


def _linear(formula: str) -> Markup:
    """The text of the upper box: a fraction where it is one that fits."""
    size = min(_size(formula), _LARGEST)
    if size < _SMALLEST:
        return Markup('<text x="220" y="59">H</text>\n')
    sides = _sides(formula)
    if len(sides) == 1:
        return Markup('<text x="220" y="58" style="font-size:{:.4g}px">{}</text>\n').format(size, raised(sides[0]))
    wide = 0.5 * (max(map(len, map(raised, sides))) * _LETTER * size + 8)
    return Markup(
        '<text x="220" y="47" style="font-size:{0:.4g}px">{1}</text><path class="wire" d="M{2:.4g} 53H{3:.4g}"/>'
        '<text x="220" y="{4:.4g}" style="font-size:{0:.4g}px">{5}</text>\n'
    ).format(size, raised(sides[0]), 220 - wide, 220 + wide, 56 + size, raised(sides[1]))


def _sides(formula: str) -> list[str]:
    """Numerator and denominator of a formula that is one fraction, without the brackets around them."""
    sides = formula.split(" / ")
    return [side[1:-1] if _bracketed(side) else side for side in sides] if len(sides) == 2 else [formula]


def _bracketed(text: str) -> bool:
    """Whether the first bracket is closed by the last."""
    depth = np.cumsum([(letter == "(") - (letter == ")") for letter in text])
    return text.startswith("(") and text.endswith(")") and bool((depth[:-1] > 0).all())


def _size(formula: str) -> float:
    """The size of type at which a formula fills its box."""
    return _ROOM / (_LETTER * max(len(raised(side)) for side in _sides(formula)))


def _reach(nonlinearity: Nonlinearity) -> float:
    """Twice the farthest bend of a piecewise-linear graph; else the least stretch that shows half of how it bends."""
    bends = [abs(float(x)) for x in getattr(getattr(nonlinearity, "graph", None), "knots", ()) if x]
    if bends:
        return 2.0 * max(bends)
    bent = np.nan_to_num([_bend(nonlinearity, float(reach)) for reach in _SPANS])
    if np.ptp(bent) < 1e-3:  # a line, or a nonlinearity that looks the same at every size
        return 1.0
    reach = float(_SPANS[int(np.argmax(bent >= 0.5 * bent.max()))])
    return reach if getattr(nonlinearity, "locally_lipschitz", True) else 4.0 * reach  # of jumps more than the first


def _bend(nonlinearity: Nonlinearity, reach: float) -> float:
    """How far a nonlinearity leaves its chord over ``[-reach, reach]``, relative to its values there."""
    sigma = np.linspace(-reach, reach, _SAMPLES)
    phi = _values(nonlinearity, sigma)
    chord = phi[0] + (phi[-1] - phi[0]) * np.linspace(0.0, 1.0, _SAMPLES)
    return float(np.max(np.abs(phi - chord)) / np.max(np.abs(phi))) if np.isfinite(phi).all() and phi.any() else 0.0


def _values(nonlinearity: Nonlinearity, sigma: Floats) -> Floats:
    with np.errstate(all="ignore"):
        return np.asarray(nonlinearity(sigma), dtype=float)


def _corner(slope: float) -> tuple[float, float]:
    """Where the ray of a slope leaves the square."""
    return (1.0, slope) if abs(slope) <= 1 else (1 / abs(slope), math.copysign(1.0, slope))


def _point(x: float, y: float) -> str:
    """Coordinates from -1 to 1 in those of the picture."""
    across, up = _LEFT + _WIDE / 2, _TOP + _HIGH / 2
    return f"{across + x * (_WIDE / 2 - _INSET):.1f} {up - y * (_HIGH / 2 - _INSET):.1f}"


def _axes() -> Markup:
    return Markup('<path class="axis" d="M{}L{}M{}L{}"/>\n').format(
        _point(-1, 0), _point(1, 0), _point(0, -1), _point(0, 1)
    )


def _line(x: Floats, y: Floats) -> Markup:
    good = np.isfinite(y)
    pieces, start = [], 0
    breaks = [i for i, (a, b) in enumerate(pairwise(good), 1) if a != b]
    for end in (*breaks, len(y)):
        if good[start]:
            pieces.append(
                "M" + "L".join(_point(float(a), float(b)) for a, b in zip(x[start:end], y[start:end], strict=True))
            )
        start = end
    return Markup('<path class="graph" d="{}"/>\n').format("".join(pieces))


def _ends(reach: float, height: float) -> Markup:
    """The numbers at the ends of the two axes."""
    return Markup(
        '<text class="tiny" x="274" y="150">{:.3g}</text><text class="tiny" x="226" y="124">{:.3g}</text>\n'
    ).format(reach, height)
