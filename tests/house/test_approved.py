"""What is said of some loops and rods, kept as text: a change of a verdict, class, number or word shows as a diff.

The kept texts were read before they were approved.  After a wanted change write them anew and read the difference:

    LURE_APPROVE=1 make test ARGS=tests/house/test_approved.py; git diff tests/house/approved
"""

import json
import os
import re
import textwrap
from fractions import Fraction
from pathlib import Path

import pytest
from markupsafe import Markup
from reports import loop_report, rod_report

from lure.analysis import analyse, max_sector, max_slope
from lure.analysis.report.loop.write import loop_page
from lure.analysis.report.parts import certificate_files
from lure.analysis.rod.report import claims
from lure.analysis.rod.report.document import document
from lure.analysis.rod.report.output import page
from lure.files import parse_system

APPROVED = Path(__file__).parent / "approved"
PLANT = '[plant]\ntransfer = "{}"\n{}'
LOOPS = {
    "checked": PLANT.format("3/((s+1)*(s+2)*(s+3))", '[nonlinearity]\nkind = "tanh"\ngain = 2\nscale = 1\n'),
    "declared": PLANT.format(
        "(s+3)/(s+1)", '[nonlinearity]\nkind = "expression"\nexpression = "sin(sigma)/2"\nsector = [-0.25, 1]\n'
    ),
    "sampled": PLANT.format("0.4/(z-0.6)", 'dt = 0.1\n[nonlinearity]\nkind = "quantiser"\nstep = 0.5\n'),
    "odd": PLANT.format("1/(s+1)^4", "[class]\nsector = [0.25, 2]\nslope = [0.25, 2]\nodd = true\n"),
    "beyond": PLANT.format("1/(s*(s+1)*(s+3))", "[class]\nsector = [0, 13]\n"),
    "varying": PLANT.format("1/(s+1)^3", "[class]\nsector = [0, 5.78]\ntime_varying = true\n"),
    "late": PLANT.format("exp(-s/2)/(s+2)", "[class]\nsector = [0, 2]\n"),
    "endless": PLANT.format("(s+2)/(s*(s+3))", "[class]\nsector = [0, inf]\n"),
    "unstable": PLANT.format("4/((s-1)*(s+4))", '[nonlinearity]\nkind = "saturation"\ngain = 2\nlimit = 1\n'),
}
RODS = {"rod": {"damping": "1e-3"}, "pushed-rod": {"damping": "-1e-3"}, "free-rod": {"damping": "0"}}
RODS |= {"bent-rod": {"exponent": "2"}}
PASSING = re.compile(
    r"versions|seconds|command|sha256|residual|difference|simulation|confirmation|time_series|witness\.data\.times"
)
# What doubles leave open differs between processors: rounding errors, and where a flat maximum is taken.
LOOSE = re.compile(r"(?<=relative difference )\S+|(?<=with period )[\d.]+|(?<=each for so long \[s\]\n)\S+, \S+")
LONG = re.compile(r"(?<![\w.^/])[-+]?(?=[\d.]{11})\d+\.\d+(?:e[-+]?\d+)?|[0-9a-f]{64}|[-+]?\d[\d.]*e-1[3-9]")


def short(text):
    """A text with its long decimal numbers to six digits; ``12-`` is just below 12, and ``~0`` a rounding error."""

    def six(match):
        if len(match[0]) == 64:
            return "SHA"
        value, said = float(match[0]), f"{float(match[0]):.6g}"
        if 0 < abs(value) < 1e-9:
            return "~0"
        off = value - float(said)
        return said + ("" if abs(off) > 1e-9 * abs(value) or off == 0 else "+" if off > 0 else "-")

    return LONG.sub(six, text)


def rough(match):
    """Numbers to two digits, and ``~0`` for a rounding error."""
    values = [float(Fraction(number)) for number in match[0].split(", ")]
    return ", ".join(f"{value:.2g}" if value > 1e-9 else "~0" for value in values)


def words(html):
    """The words of a page, wrapped."""
    html = re.sub(r"<(style|svg|script)\b.*?</\1>", "", html, flags=re.DOTALL)
    html = re.sub(r"</?(?:p|h\d|tr|li|details|summary|table|dt)\b[^>]*>", "\n", html)
    lines = re.sub(r"<[^>]+>", "", re.sub(r" × 10<sup>(.*?)</sup>", r"e\1", html).replace("\N{MINUS SIGN}", "-"))
    found = (" ".join(str(Markup(line).unescape()).split()) for line in lines.splitlines())
    return "\n".join(textwrap.fill(line, 116, break_on_hyphens=False, break_long_words=False) for line in found if line)


def leaves(data, key=""):
    """Key and value of everything in a document, but for what changes from run to run."""
    if PASSING.search(key):
        return
    if isinstance(data, dict | list) and data:
        for name, value in sorted(data.items()) if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, f"{key}.{name}".lstrip("."))
    else:
        yield f"{key}: {short(json.dumps(data, default=str))}"


def proofs(shown):
    """The files of the certificates, in order, with the claim and the class of each."""
    return "\n".join(
        f"{file}: {one.claim}; {json.dumps(one.certificate['laws'])}"
        for file, one in zip(certificate_files(shown), shown, strict=True)
    )


def of_loop(text):
    loop = parse_system(text, name="kept", source="a file")
    found = analyse(loop)
    report = loop_report(found)
    data = report.to_dict()
    largest = (max_slope if "slope" in text else max_sector)(loop.block)
    return {
        "text": str(report),
        "json": "\n".join(leaves(data)),
        "page": words(loop_page(data, (), Markup(""))),
        "notebook": words(found._repr_html_()),
        "dataset": "\n".join(leaves(found.to_xarray().to_dict())),
        "question": f"{largest}\n{words(largest._repr_html_())}",
        "certificates": proofs(found.certificates),
    }


def of_rod(changes):
    report = rod_report(changes, cells=8)
    data = document(report)
    return {
        "text": str(report),
        "json": "\n".join(leaves(data)),
        "page": words(page(data, claims(report), ())),
        "notebook": words(report._repr_html_()),
        "dataset": "\n".join(leaves(report.to_xarray().to_dict())),
        "certificates": proofs(report.certificates),
    }


@pytest.mark.slow_for("odd", "late", "checked", "varying")
@pytest.mark.parametrize("name", [*LOOPS, *RODS])
def test_what_is_said_is_what_was_approved(name):
    found = of_loop(LOOPS[name]) if name in LOOPS else of_rod(RODS[name])
    said = "".join(f"---- {part}\n{short(LOOSE.sub(rough, text)).rstrip()}\n" for part, text in found.items())
    kept = APPROVED / f"{name}.txt"
    if os.environ.get("LURE_APPROVE"):
        kept.write_text(said, encoding="utf-8")
    assert said == kept.read_text("utf-8")
