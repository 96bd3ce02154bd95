"""What the pages of reports are made of: offline, without scripts, their numbers those of the JSON."""

from __future__ import annotations

import decimal
import math
import re
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, Literal

from markupsafe import Markup

from lure.analysis.plots.style import BLUE, GREEN, GREY, INK, PURPLE, VERMILLION
from lure.analysis.report.parts import Figure, Json
from lure.analysis.wording import plain

if TYPE_CHECKING:
    from jinja2 import Template

Rounding = Literal["nearest", "down", "up"]
_ROUNDING = {
    "nearest": decimal.ROUND_HALF_EVEN,
    "down": decimal.ROUND_FLOOR,
    "up": decimal.ROUND_CEILING,
}
_COLOURS = {
    INK: "currentColor",
    "#ffffff": "var(--card)",
    BLUE: "var(--blue)",
    VERMILLION: "var(--vermillion)",
    GREEN: "var(--green)",
    PURPLE: "var(--purple)",
    GREY: "var(--grey)",
}
_SIGNS = (
    (r"\+-(?=[\d.])", "±"),
    ("<=", "≤"),
    (">=", "≥"),
    (r"\bsum y_i\b", "∑ yᵢ"),
    (r"\by_i\b", "yᵢ"),
    (r"\brho_0\b", "ρ₀"),
    (r"\binf\b", "∞"),
    (r"\bint (?=p\b)", "∫ "),
    (r"\bzeta\b", "ζ"),
    (r"\btheta\b", "θ"),
    (r"\bomega\b", "ω"),
    (r"\bsigma\b", "σ"),
    (r"\bphi\b", "φ"),
    (r"\beps\b", "ε"),
    (r"\^2", "²"),
    (r"(?<![\w.])-(?=\d)|(?<= )-(?= )", "−"),
)
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_IDENTIFIER = re.compile(r'(id="|href="#|url\(#)(?!DejaVu)')
_GLYPH = re.compile(r'<path id="(DejaVu[^"]*)"[^>]*/>\s*')


@cache
def template(name: str, package: str) -> Template:
    """A page template of a package, everything put into it escaped, with the style sheet as ``css``.

    ``package``: where it stands.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"plain": plain, "prose": prose, "sentence": _sentence, "unbroken": _unbroken}
    style = resources.files("lure.analysis.report").joinpath("style.css")
    environment.globals["css"] = Markup(style.read_text("utf-8"))
    return environment.from_string(resources.files(package).joinpath(name).read_text("utf-8"))


def prose(text: str) -> str:
    """Plain-text formulas in the signs of print: ``z <= 0`` as ``z ≤ 0``, ``zeta`` as ``ζ``.

    ``text``: a sentence from a result.

    Examples
    --------
    >>> prose("zeta <= 0 on [0, inf), v^2")
    'ζ ≤ 0 on [0, ∞), v²'
    """
    for typed, sign in _SIGNS:
        text = re.sub(typed, sign, text)
    return re.sub(r"\bphi_(\d+)\b", lambda found: f"φ{lowered(found[1])}", text)


def lowered(figures: str) -> str:
    """Figures as an index."""
    return figures.translate(_LOWERED)


def _unbroken(text: str) -> str:
    """With no line break inside an interval."""
    return re.sub(r"(\[[^\s\]]+,) (?=[^\s\]]+[\])])", "\\1\N{NO-BREAK SPACE}", text)


def _sentence(text: str) -> str:
    """With a full stop, and a capital letter unless it begins with a symbol."""
    word = text.split(" ", 1)[0]
    text = text[:1].upper() + text[1:] if word.isascii() and word.isalpha() else text
    return f"{text.removesuffix('.')}."


def format_number(value: float, digits: int = 4, rounding: Rounding = "nearest") -> Markup:
    """A number as people write it, ``digits`` significant, with a raised power of ten where it is long.

    Parameters
    ----------
    value : float
        Finite or infinite.
    digits : int
        Significant digits.
    rounding : {"nearest", "down", "up"}
        Direction; ``"down"`` is towards minus infinity.

    Examples
    --------
    >>> print(format_number(2.0 / 3.0, 3, "down"), format_number(-1.25e-7))
    0.666 −1.25 × 10<sup>−7</sup>
    """
    if math.isinf(value):
        return Markup("∞" if value > 0 else "−∞")
    if value == 0:
        return Markup("0")
    exact = decimal.Decimal(value)
    context = decimal.Context(prec=digits, rounding=_ROUNDING[rounding])
    rounded = context.plus(exact).normalize(context)
    exponent = rounded.adjusted()
    if -3 <= exponent < 6:
        return Markup(f"{rounded:f}".replace("-", "−"))
    mantissa = f"{rounded.scaleb(-exponent, decimal.Context(prec=50)):f}".replace("-", "−")
    raised = str(exponent).replace("-", "−")
    return Markup(f"{mantissa} × 10<sup>{raised}</sup>")


def quoted_number(text: str) -> Markup:
    """A number that is already rounded, in the signs of print; ``text``: such as ``0.25``, ``1.5e-07`` or ``inf``.

    Examples
    --------
    >>> print(quoted_number("-0.25"), quoted_number("1.5e-07"))
    −0.25 1.5 × 10<sup>−7</sup>
    """
    if text in ("inf", "-inf"):
        return format_number(float(text))
    mantissa, _, exponent = text.replace("-", "−").partition("e")
    power = exponent.replace("+", "").replace("−0", "−").removeprefix("0")
    return Markup("{} × 10<sup>{}</sup>" if exponent else "{}").format(mantissa, power)


def shown(  # noqa: PLR0913  (a template's options)
    data: Json, key: str, unit: str = "", digits: int = 4, rounding: Rounding = "nearest", quoted: str | None = None
) -> Markup:
    """The number at a dotted key of the document, rounded, with its unit; a dash where it is missing.

    Parameters
    ----------
    data : dict
        The document.
    key : str
        Where the number stands in it.
    unit : str
        Printed behind it.
    digits : int
        Significant digits.
    rounding : {"nearest", "down", "up"}
        Direction.
    quoted : str, optional
        The number as the document itself quotes it, instead of ``digits`` and ``rounding``.
    """
    value: Any = data  # plain JSON data
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    if value is None:
        return Markup('<span class="none">—</span>')
    size = float(value)  # a number, or "inf"
    text = format_number(size, digits, rounding) if quoted is None else quoted_number(quoted)
    suffix = Markup(" {}").format(unit.replace(" ", "\N{NO-BREAK SPACE}")) if unit else Markup("")
    return Markup('<data value="{}" data-key="{}" title="{}">{}</data>{}').format(
        repr(value) if not isinstance(value, str) else value, key, repr(size), text, suffix
    )


def glyphs(figures: tuple[Figure, ...]) -> Markup:
    """The letters of all figures, once: they are most of a small figure's size."""
    found = {match.group(1): match.group() for figure in figures for match in _GLYPH.finditer(figure.picture.svg)}
    return Markup("".join(found[name] for name in sorted(found)))  # drawn by us


def inline(figure: Figure) -> Markup:
    """A figure for the page: in the colours of the page, with identifiers of its own and letters from the page."""
    svg = figure.picture.svg
    svg = svg[svg.index("<svg ") :]
    svg = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", svg, count=1, flags=re.DOTALL)
    svg = re.sub(r"<!--.*?-->", "", _GLYPH.sub("", svg), flags=re.DOTALL)
    svg = re.sub(r"<defs>\s*</defs>|\n\s+", lambda match: "\n" if match.group().isspace() else "", svg)
    svg = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', "", svg, count=1)
    for colour, variable in _COLOURS.items():
        svg = svg.replace(colour, variable)
    svg = _IDENTIFIER.sub(rf"\g<1>{figure.spec.name}-", svg)
    label = Markup('<svg class="figure" role="img" aria-label="{}" ').format(
        f"{figure.spec.title}. {figure.spec.caption}"
    )
    return label + Markup(svg.removeprefix("<svg "))  # our own figure: no text of a user is in it
