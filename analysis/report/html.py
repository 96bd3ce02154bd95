"""The report as one page of HTML: offline, without scripts, its numbers those of the JSON."""

from __future__ import annotations

import decimal
import math
import re
from functools import partial
from importlib import resources
from typing import TYPE_CHECKING, Literal, get_args

from markupsafe import Markup

from lure.analysis.plots.style import BLUE, GREEN, GREY, INK, PURPLE, VERMILLION, number
from lure.analysis.report.claims import LADDER, Claim, merged
from lure.analysis.report.diagram import block_diagram, law_graph
from lure.analysis.report.document import Json
from lure.analysis.report.figures import Figure, Section
from lure.analysis.report.pdf import embedded, printed_diagram
from lure.nonlinearities.protocol import NormalCompliance

if TYPE_CHECKING:
    from jinja2 import Template

Rounding = Literal["nearest", "down", "up"]
_ROUNDING = {
    "nearest": decimal.ROUND_HALF_EVEN,
    "down": decimal.ROUND_FLOOR,
    "up": decimal.ROUND_CEILING,
}
_PARAMETERS = (
    ("youngs_modulus", "E", "Young's modulus", "Pa"),
    ("density", "ρ", "density", "kg/m³"),
    ("length", "L", "length", "m"),
    ("area", "A", "cross-section", "m²"),
    ("damping", "k", "dashpot at x = 0", "N s/m"),
    ("compliance", "ε", "compliance of the obstacle", "mᵐ/Pa"),
    ("exponent", "m", "exponent of the contact law", ""),
    ("gap", "gap", "free distance to the obstacle", "m"),
)
_DERIVED = (
    ("wave_speed", "c = √(E/ρ)", "wave speed", "m/s"),
    ("impedance", "Z = A√(ρE)", "impedance", "N s/m"),
    ("travel_time", "T = L/c", "one transit of the rod", "s"),
    ("a", "a = (k − Z)/(k + Z)", "a wave returns from the dashpot as −a times itself", ""),
    ("b", "b = 1/(k + Z)", "input gain of the force", "m/(N s)"),
    ("d", "d = 1/√(ρE)", "end velocity per contact stress", "m/(Pa s)"),
)
_CONTENTS = (
    ("shown", "What is shown, and what is not", ""),
    ("frequency", "Popov and Nyquist", ""),
    ("motion", "Motion", ""),
    ("assumed", "Assumed", ""),
    ("reproduce", "Reproduce", ""),
    ("criteria", "Criteria in numbers", ""),
    ("proofs", "Proofs", "proofs"),
    ("checked", "Hypotheses checked", ""),
    ("block", "Parameters and formulas", ""),
    ("spectrum", "Spectrum", ""),
    ("confirmation", "Motions in numbers", "confirmation"),
    ("simulation", "Simulation", ""),
    ("certificates", "Certificates", "certificates"),
)
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
_IDENTIFIER = re.compile(r'(id="|href="#|url\(#)(?!DejaVu)')
_GLYPH = re.compile(r'<path id="(DejaVu[^"]*)"[^>]*/>\s*')


def page(data: Json, claims: tuple[Claim, ...], figures: tuple[Figure, ...], *, paper: bool = False) -> str:
    """The page for a document.

    Every number on it that the JSON has too is a ``<data>`` element with the key in the document and the full value;
    what is printed is rounded, margins downwards and multipliers upwards.

    Parameters
    ----------
    data : dict
        From :func:`lure.analysis.report.document.document`.
    claims : tuple of Claim
        Rows of the table of claims, in order.
    figures : tuple of Figure
        Figures, in order.
    paper : bool
        Whether the page is for :func:`lure.analysis.report.pdf.pdf_of`: figures are images then.
    """
    diagram = rod_diagram(data)
    return template("report.html.j2").render(
        d=data,
        n=partial(shown, data),
        diagram=printed_diagram(diagram) if paper else diagram,
        transit=number(2 * data["system"]["derived"]["travel_time"]),
        contents=[(ident, title) for ident, title, part in _CONTENTS if _present(data, part)],
        claims=claims,
        listed=merged(claims),
        ladder=LADDER,
        parameters=_parameters(data),
        derived=_DERIVED,
        figures={
            section: [figure for figure in figures if figure.spec.section == section] for section in get_args(Section)
        },
        inline=embedded if paper else inline,
        glyphs="" if paper else glyphs(figures),
        assumptions=_assumptions(data),
        reasons=_reasons(data),
    )


def rod_diagram(data: Json) -> Markup:
    """The block diagram of a rod: ``H`` without a grid, with ``e`` for one round trip, and the contact law.

    Parameters
    ----------
    data : dict
        From :func:`lure.analysis.report.document.document`.
    """
    given, derived = data["system"]["parameters"], data["system"]["derived"]
    size, signs = number(abs(derived["a"])), ("−", "+") if derived["a"] >= 0 else ("+", "−")
    formula = f"{number(derived['d'])} (1 {signs[0]} {size} e) / (s (1 {signs[1]} {size} e))"
    law = NormalCompliance(stiffness=1 / given["compliance"], exponent=given["exponent"])
    power = "" if given["exponent"] == 1 else f" to the power {given['exponent']:g}"
    text = f"p(z) = max(z, 0){power} / {number(given['compliance'])}"
    return block_diagram(formula, text, law_graph(law), signals=("μ", "z"), load="g(t), f(t, x), u₀, u₁")


def _present(data: Json, part: str) -> bool:
    """Whether a part of the page that hangs on something found is there; one of no name always is."""
    found = {"certificates": data["certificates"], "proofs": data["conclusion"]["proofs"]}
    found["confirmation"] = data["confirmation"]["rod"] or data["confirmation"]["scheme"]
    return part not in found or bool(found[part])


def template(name: str) -> Template:
    """A page template of this package, everything put into it escaped, with the style sheet as ``css``.

    Parameters
    ----------
    name : str
        Its path below this package.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"prose": prose, "sentence": _sentence, "unbroken": _unbroken}
    files = resources.files("lure.analysis.report")
    environment.globals["css"] = Markup(files.joinpath("style.css").read_text("utf-8"))
    return environment.from_string(files.joinpath(name).read_text("utf-8"))


def prose(text: str) -> str:
    """Plain-text formulas in the signs of print: ``z <= 0`` as ``z ≤ 0``, ``zeta`` as ``ζ``.

    Parameters
    ----------
    text : str
        A sentence from a result.

    Examples
    --------
    >>> prose("zeta <= 0 on [0, inf), v^2")
    'ζ ≤ 0 on [0, ∞), v²'
    """
    for plain, sign in _SIGNS:
        text = re.sub(plain, sign, text)
    return text


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
    """A number that is already rounded, in the signs of print.

    Parameters
    ----------
    text : str
        Such as ``0.25``, ``1.5e-07`` or ``inf``.

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
    value: object = data
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]  # type: ignore[index]  # plain JSON data
    if value is None:
        return Markup('<span class="none">—</span>')
    size = float(value)  # type: ignore[arg-type]  # a number, or "inf"
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


def _reasons(data: Json) -> dict[str, str]:
    """Why a criterion did not prove anything: who says so, by what is said."""
    said: dict[str, list[Json]] = {}
    for result in data["criteria"]:
        if result["verdict"] != "PROVED":
            said.setdefault(result["reason"], []).append(result)
    return {
        reason: ", ".join(" and ".join(dict.fromkeys(result[key] for result in results)) for key in ("name", "model"))
        for reason, results in said.items()
    }


def _parameters(data: Json) -> list[tuple[str, str, str, str]]:
    """The parameters with their units; that of the compliance follows from the exponent."""
    linear = data["system"]["parameters"]["exponent"] == 1
    return [(*row[:3], "m/Pa" if linear and row[0] == "compliance" else row[3]) for row in _PARAMETERS]


def _assumptions(data: Json) -> list[tuple[str, str]]:
    """Hypotheses as (status, text): those of the conclusion, then those of the criteria, each once."""
    rows = [*data["conclusion"]["assumptions"]]
    for result in data["criteria"]:
        if result["name"] == "popov":
            model = "scheme" if result["model"] == "scheme" else "rod"
            rows += [f"Popov, {model}: {text}" if "inequality" in text else text for text in result["hypotheses"]]
    return [(_status(text), text) for text in dict.fromkeys(rows)]


def _status(text: str) -> str:
    if "fails" in text or "not established" in text:
        return "fails"
    return "assumed" if "assumed" in text or "theorem is about" in text else "checked"
