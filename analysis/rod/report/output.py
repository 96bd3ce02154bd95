"""The report on a rod as files: the page, its figures and the JSON."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import get_args

from markupsafe import Markup

from lure.analysis.plots.style import number
from lure.analysis.report.diagram import block_diagram, nonlinearity_graph
from lure.analysis.report.html import glyphs, inline, shown, template
from lure.analysis.report.parts import LADDER, Figure, Json, Section, write_files
from lure.analysis.report.pdf import embedded, printed_diagram
from lure.analysis.rod.report.document import document
from lure.analysis.rod.report.figures import figures
from lure.analysis.rod.report.model import Claim, StabilityReport, claims, merged
from lure.nonlinearities.base import NormalCompliance

# The report on a rod as one page of HTML: offline, without scripts, its numbers those of the JSON.

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


def page(data: Json, claims: tuple[Claim, ...], figures: tuple[Figure, ...], *, paper: bool = False) -> str:
    """The page for a document.

    Every number on it that the JSON has too is a ``<data>`` element with the key in the document and the full value;
    what is printed is rounded, margins downwards and multipliers upwards.

    ``data``: from :func:`lure.analysis.rod.report.document.document`; ``claims``, ``figures``: in order; ``paper``:
    whether the page is for :func:`lure.analysis.report.pdf.pdf_of`, where figures are images.
    """
    diagram = rod_diagram(data)
    return template("report.html.j2", __package__).render(
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

    ``data``: from :func:`lure.analysis.rod.report.document.document`.
    """
    given, derived = data["system"]["parameters"], data["system"]["derived"]
    size, signs = number(abs(derived["a"])), ("−", "+") if derived["a"] >= 0 else ("+", "−")
    formula = f"{number(derived['d'])} (1 {signs[0]} {size} e) / (s (1 {signs[1]} {size} e))"
    nonlinearity = NormalCompliance(stiffness=1 / given["compliance"], exponent=given["exponent"])
    power = "" if given["exponent"] == 1 else f" to the power {given['exponent']:g}"
    text = f"p(z) = max(z, 0){power} / {number(given['compliance'])}"
    return block_diagram(
        formula, text, nonlinearity_graph(nonlinearity), signals=("μ", "z"), load="g(t), f(t, x), u₀, u₁"
    )


def _present(data: Json, part: str) -> bool:
    """Whether a part of the page that hangs on something found is there; one of no name always is."""
    found = {"certificates": data["certificates"], "proofs": data["conclusion"]["proofs"]}
    found["confirmation"] = data["confirmation"]["rod"] or data["confirmation"]["scheme"]
    return part not in found or bool(found[part])


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


def write_report(report: StabilityReport, directory: str | os.PathLike[str], *, pdf: bool = False) -> Path:
    """Write ``report.html``, ``report.json``, ``certificates/`` and ``figures/`` into a directory, made if missing.

    Everything is computed and drawn before the first file is written.  For a directory that changes in one step, and
    never loses what is not a report, write into that of :func:`lure.analysis.output.replaced`, as the command does.

    Parameters
    ----------
    report : StabilityReport
        The report.
    directory : path
        Where to write; files of the same names are overwritten.
    pdf : bool
        Whether to write ``report.pdf`` too.

    Returns
    -------
    Path
        The page, ``report.html``.

    Raises
    ------
    InputError
        A PDF is asked for, and weasyprint is not installed.
    """
    data, drawn = document(report), figures(report)
    return write_files(data, partial(page, data, claims(report), drawn), drawn, report.certificates, directory, pdf=pdf)
