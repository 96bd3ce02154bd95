"""The report: its JSON keeps the published schema, its page says the same, and a contradiction stops it."""

import json
import math
import re
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from importlib import resources

import jsonschema
import pytest
from depth import rarely
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from sketches import sketches

from lure.analysis.report import ContradictionError
from lure.analysis.report.html import format_number, prose
from lure.analysis.report.parts import to_json
from lure.analysis.rod.report import build, build_report, document, write_report
from lure.analysis.rod.report.document import exact_text
from lure.analysis.rod.report.figures import specs as figure_specs
from lure.analysis.rod.report.model import claims
from lure.analysis.rod.report.output import page
from lure.analysis.verdict import Verdict
from lure.rod import Scenario, builtin_system, builtin_systems
from lure.rod.systems import rod_from_exact

SCHEMA = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
CHECK = jsonschema.Draft202012Validator(SCHEMA)
PAPER = builtin_system("paper-rod")
HOSTILE = "<script>alert('x')</script> & \"q\" $\\frac{1}{0}$ {{ 7 * 7 }} ]]> [red]"


def with_damping(share):
    """The paper's system with a dashpot of `share` impedances (Z = 1.2 N s/m exactly)."""
    return with_rod(damping=share * Fraction(6, 5))


def with_rod(**changes):
    return replace(PAPER, rod=rod_from_exact({**PAPER.rod.exact, **changes}))


SYSTEMS = {
    # the forced runs to a twentieth of their length: what is tested is the report, not the motion
    **{name: replace(system, until=max(system.until / 20, PAPER.until)) for name, system in builtin_systems().items()},
    "touching": replace(with_rod(gap=Fraction(1, 10000)), scenario=Scenario.parse(velocity=1), until=2e-3),
    "matched dashpot": with_damping(1),
    "strong dashpot": with_damping(3),
    "no dashpot": with_damping(0),
    "negative dashpot": with_damping(Fraction(-1, 2)),
    "very negative dashpot": with_damping(-3),
    "curved nonlinearity": with_rod(exponent=Fraction(3, 2)),
    "one cell": replace(PAPER, cells=1),
    "many cells": replace(PAPER, cells=100_000),
    "simulated more coarsely": replace(PAPER, cells=100_000, simulation_cells=5),
}
SKETCHED = ("paper-rod", "negative dashpot")
ONE_SIDED = [name for name in SYSTEMS if "negative" not in name and name != "no dashpot"]


@pytest.fixture(scope="module")
def reports():
    return {name: build_report(system) for name, system in SYSTEMS.items()}


@pytest.fixture(scope="module")
def pages(reports, tmp_path_factory):
    """The pages as written of a rod that touches, with its figures, of the paper's rod and of a refuted one."""
    folder = tmp_path_factory.mktemp("reports")
    found = {"touching": write_report(reports["touching"], folder / "touching")}
    with sketches():
        return found | {name: write_report(reports[name], folder / name.replace(" ", "-")) for name in SKETCHED}


def page_of(report):
    """The page without its figures, which take most of the time."""
    return Page(page(document(report), claims(report), ()))


class Page(HTMLParser):
    """What a browser would find: elements, the numbers with their keys, and the text."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.numbers, self.words, self.identifiers, self.headings = [], [], [], [], []
        self.inside, self.heading = None, False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.elements.append((tag, given))
        if "id" in given:
            self.identifiers.append(given["id"])
        self.heading = tag in ("h1", "h2")
        if tag == "data":
            self.inside = [given["data-key"], given["value"], ""]

    def handle_endtag(self, tag):
        if tag == "data":
            self.numbers.append(tuple(self.inside))
            self.inside = None

    def handle_data(self, data):
        self.words.append(data)
        if self.heading and data.strip():
            self.headings.append(data)
        if self.inside:
            self.inside[2] += data

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def read(path):
    return Page(path.read_text("utf-8"))


def test_the_schema_is_a_schema():
    assert jsonschema.validators.validator_for(SCHEMA, default=None) is jsonschema.Draft202012Validator
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_json_keeps_the_published_schema(reports, name):
    assert not list(CHECK.iter_errors(json.loads(to_json(document(reports[name])))))


# The list of the issue, written out: the schema itself could have lost a field.
def test_the_json_has_every_field_that_was_promised(reports):
    data = document(reports["touching"])
    assert data["schema"] == "lure-report/1"
    assert {"name", "kind", "parameters", "derived", "cells", "form"} <= data["system"].keys()
    assert {"wave_speed", "impedance", "travel_time", "a", "b", "d"} == data["system"]["derived"].keys()
    assert {"zero_multiplicity", "residue_at_zero", "slowest_decay_rate", "first_elastic_mode"} <= data[
        "spectrum"
    ].keys()
    assert (
        {"scheme", "rod"}
        == data["spectrum"]["slowest_decay_rate"].keys()
        == data["spectrum"]["first_elastic_mode"].keys()
    )
    criterion = {
        "name",
        "model",
        "sector",
        "verdict",
        "evidence",
        "theta",
        "smallest_theta",
        "margin",
        "worst_frequency",
    }
    assert all(criterion | {"largest_sector"} <= result.keys() for result in data["criteria"])
    assert {(result["name"], result["model"]) for result in data["criteria"]} == {
        (name, model) for name in ("popov", "circle") for model in ("scheme", "rod")
    }
    assert {"verdict", "statement", "stationary_set", "assumptions"} <= data["conclusion"].keys()
    motion = {"until", "energy", "lyapunov", "zeta", "rest", "energy_residual", "momentum_residual", "open_end"}
    assert motion <= data["confirmation"]["rod"].keys() == data["confirmation"]["scheme"].keys()
    simulation = {"cells", "t_end", "max_gap_coordinate", "contact", "rest_position", "energy_residual", "agrees"}
    assert simulation <= data["simulation"].keys()
    assert {"lure", "python", "numpy", "scipy", "control", "python-flint"} <= data["versions"].keys()


# E = 288e6, rho = 8, L = 1, A = 0.25e-4, k = 2e-4: c = 6000, Z = 1.2, T = 1/6000, rho_0 = A/k = 0.125.
# Circle criterion: expand (1 - a Q)/(1 + a Q) about Q = exp(-2sT) = 1 gives Re H -> 4 a T d/(1 + a)^2 = -0.125 at 0,
# the least value; so the margin is 1 - 0.125 and the sector reaches 8.
def test_the_numbers_of_the_papers_rod(reports):
    data = document(reports["paper-rod"])
    derived, spectrum = data["system"]["derived"], data["spectrum"]
    assert derived["wave_speed"] == pytest.approx(6000)
    assert derived["impedance"] == pytest.approx(1.2)
    assert derived["a"] == pytest.approx((2e-4 - 1.2) / (2e-4 + 1.2))
    assert spectrum["zero_multiplicity"] == 1
    assert spectrum["residue_at_zero"] == pytest.approx(0.125)
    assert spectrum["slowest_decay_rate"]["rod"] == pytest.approx(1.0, rel=1e-6)
    found = {(result["name"], result["model"]): result for result in data["criteria"]}
    assert found["popov", "rod"]["largest_sector"] == ["inf", "inf"]
    assert found["circle", "rod"]["margin"] == pytest.approx(0.875, rel=1e-6)
    assert found["circle", "rod"]["largest_sector"] == pytest.approx([8, 8], rel=1e-6)
    assert data["conclusion"]["verdict"] == "PROVED"
    assert data["simulation"]["agrees"] is True
    assert data["system"]["parameters_exact"]["damping"] == "0.0002"


@pytest.mark.parametrize("name", SYSTEMS)
def test_no_number_is_nan_and_infinite_ones_are_words(reports, name):
    text = to_json(document(reports[name]))
    assert not re.search(r"\bNaN\b|\bInfinity\b", text)


@pytest.mark.parametrize(
    ("name", "verdict"),
    [("matched dashpot", "PROVED"), ("no dashpot", "INCONCLUSIVE"), ("negative dashpot", "REFUTED")],
)
def test_the_verdict_of_the_report_is_that_of_the_conclusion(reports, name, verdict):
    assert reports[name].verdict is Verdict[verdict]
    assert document(reports[name])["conclusion"]["verdict"] == verdict
    with pytest.raises(TypeError, match="three answers"):
        bool(reports[name])


@pytest.mark.parametrize("name", SYSTEMS)
def test_bounds_are_quoted_at_their_safe_end(reports, name):
    for result, found in zip(document(reports[name])["criteria"], reports[name].criteria, strict=True):
        if found.margin is not None:
            assert result["margin"] == found.margin.low
        if found.smallest_theta is not None:
            assert result["smallest_theta"] == found.smallest_theta.high


@pytest.mark.parametrize("name", ONE_SIDED)
def test_a_one_sided_law_is_never_called_asymptotically_stable(reports, name):
    report = reports[name]
    said = to_json(document(report)) + str(report) + " ".join(claim.text for claim in claims(report))
    assert "asymptotically stable" not in said
    assert "half-line" in document(report)["conclusion"]["stationary_set"]


@pytest.mark.parametrize("name", ONE_SIDED)
def test_the_page_of_a_one_sided_law_does_not_say_so_either(reports, name):
    assert "asymptotic" not in page_of(reports[name]).text
    assert "half-line" in page_of(reports[name]).text


def test_claims_stand_in_order_of_strength(reports):
    for report in reports.values():
        ranks = [["certified", "computed", "observed", "None"].index(str(claim.evidence)) for claim in claims(report)]
        assert ranks == sorted(ranks)


def test_no_evidence_is_named_where_nothing_was_shown(reports):
    # with k = 0 no theorem applies: no criterion decides anything or has a number
    report = reports["no dashpot"]
    silent = [result for result in report.criteria if result.margin is None]
    assert len(silent) == len(report.criteria) == 4
    for result in silent:
        assert result.evidence_shown is None
        assert "certified" not in str(result)
        assert "certified" not in result._repr_html_()
    undecided = [claim for claim in claims(report) if claim.answer == "INCONCLUSIVE"]
    assert len(undecided) == 5  # four criteria, and that motions come to rest
    assert all(claim.evidence is None for claim in undecided)
    assert "INCONCLUSIVE  certified" not in str(report)
    assert re.search(r"^popov +scheme +INCONCLUSIVE +-$", str(report), re.MULTILINE)
    assert "<td>certified</td>" not in report._repr_html_()
    # where a number is shown, its evidence is too
    assert all(result.evidence_shown is result.evidence for result in reports["paper-rod"].criteria)


def test_a_simulation_too_large_is_skipped_and_said_so(reports):
    run = document(reports["many cells"])["simulation"]
    assert "100000 cells" in run["skipped"]
    assert {key for key, value in run.items() if value not in (None, [])} == {"skipped"}
    assert "Skipped: a simulation of 100000 cells was not attempted" in page_of(reports["many cells"]).text
    coarse = document(reports["simulated more coarsely"])["simulation"]
    assert coarse["cells"] == 5
    assert coarse["skipped"] is None


def test_a_contradiction_stops_the_report_and_names_each(monkeypatch):
    monkeypatch.setattr(build, "contradictions", lambda _: ("energy rose at t = 1 s", "zeta rose at t = 2 s"))
    with pytest.raises(
        ContradictionError, match=r"paper-rod contradicts.*energy rose at t = 1 s; zeta rose at t = 2 s"
    ):
        build_report(PAPER)


def test_progress_is_told_in_order():
    told = []
    build_report(PAPER, progress=lambda stage, done: told.append((stage, done)))
    shares = [done for _, done in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1
    assert all(stage for stage, _ in told)


@pytest.mark.slow
@pytest.mark.parametrize("name", rarely(["paper-rod", "touching"], "touching"))
def test_two_runs_write_the_same_bytes(name, pages, tmp_path):
    with sketches() if name in SKETCHED else nullcontext():
        again = write_report(build_report(SYSTEMS[name]), tmp_path).parent
    first, second = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in (pages[name].parent, again)
    )
    assert first == second
    assert {path.suffix for path in first} == {".html", ".json", ".svg", ".png"}


def test_the_fingerprint_covers_the_inputs_and_not_the_name(reports):
    def fingerprint(system):
        return document(replace(reports["paper-rod"], system=system))["reproduce"]["inputs_sha256"]

    original = fingerprint(PAPER)
    assert re.fullmatch("[0-9a-f]{64}", original)
    assert fingerprint(replace(PAPER, name="other", title="other", source="other")) == original
    nearly = Fraction("0.0002") + Fraction(1, 10**40)  # the same double
    changed = [
        with_rod(damping=nearly),
        with_rod(gap=Fraction(0)),
        replace(PAPER, cells=11),
        replace(PAPER, form="as-printed"),
        replace(PAPER, until=1.0),
        replace(PAPER, simulation_cells=7),
        replace(PAPER, scenario=Scenario.parse(force="t")),
    ]
    assert len({original, *map(fingerprint, changed)}) == 1 + len(changed)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_number_on_the_page_is_the_one_in_the_json(reports, name):
    data = json.loads(to_json(document(reports[name])))
    numbers = page_of(reports[name]).numbers
    assert len(numbers) > 15
    for key, value, shown in numbers:
        expected = data
        for part in key.split("."):
            expected = expected[int(part)] if isinstance(expected, list) else expected[part]
        assert value == (expected if isinstance(expected, str) else repr(expected))
        assert spoken(shown) == pytest.approx(
            float(value), rel=0.05 if "difference" in key or "residual" in key else 1e-3
        )


def test_each_column_of_the_claims_shows_its_own_number(reports):
    text = page(document(reports["paper-rod"]), claims(reports["paper-rod"]), ())
    cells = re.findall(
        r'data-label="([^"]+)"><span>\[?(?:0, )?<data value="[^"]*" data-key="criteria\.(\d)\.([^"]+)"', text
    )
    expected = {
        "Margin, at least": "margin",
        "attained at": "worst_frequency",
        "θ": "theta",
        "Smallest θ": "smallest_theta",
        "Largest sector": "largest_sector.0",
    }
    assert {(label, key) for label, _, key in cells} == set(expected.items())
    assert {number for _, number, _ in cells} == {"0", "1", "2", "3"}


def spoken(shown):
    """The number a reader sees: `1.5 × 10−7` (its exponent raised), `−0.125` or `∞`."""
    plain = shown.replace("−", "-").replace("∞", "inf")
    mantissa, _, exponent = plain.partition(" × 10")
    return float(mantissa) * 10.0 ** int(exponent or 0)


@pytest.mark.parametrize("name", ["touching", *SKETCHED])
def test_the_page_works_offline_without_scripts_and_is_small(pages, name):
    text = pages[name].read_text("utf-8")
    found = Page(text)
    tags = {tag for tag, _ in found.elements}
    assert not tags & {"script", "link", "iframe", "object", "embed", "base", "form"}
    for _, attributes in found.elements:
        assert not any(key.startswith("on") for key in attributes)
        for key in ("src", "href", "xlink:href"):
            assert (attributes.get(key) or "#").startswith(("#", "data:image/png;base64,"))
    # namespaces are names, not addresses
    links = set(re.findall(r"https?://[^\s\"'<>)]+", text))
    assert links <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}
    policy = next(
        given["content"] for tag, given in found.elements if given.get("http-equiv") == "Content-Security-Policy"
    )
    assert policy == "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    assert "url(http" not in text
    assert len(text.encode()) < 700_000
    assert "{{" not in found.text
    assert "{%" not in found.text


def test_identifiers_on_the_page_are_unique_and_every_reference_has_its_target(pages):
    for path in pages.values():
        found = read(path)
        assert len(set(found.identifiers)) == len(found.identifiers)
        references = re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', path.read_text("utf-8"))
        assert {first or second for first, second in references} <= set(found.identifiers)


def test_figures_take_the_colours_of_the_page(pages):
    text = pages["touching"].read_text("utf-8")
    figures = "".join(re.findall(r'<svg class="figure".*?</svg>', text, flags=re.DOTALL))
    assert "currentColor" in figures
    assert "var(--blue)" in figures
    assert not re.findall(r"(?:fill|stroke): #(?:20242a|ffffff|0072b2)", figures)


def test_hostile_names_are_text_and_nothing_else(reports):
    system = replace(PAPER, name=HOSTILE, title=HOSTILE, source=HOSTILE)
    report = replace(reports["paper-rod"], system=system, command=f"lure report {HOSTILE}")
    found = page_of(report)
    assert "script" not in {tag for tag, _ in found.elements}
    assert found.text.count(" ".join(HOSTILE.split())) >= 4
    assert json.loads(to_json(document(report)))["system"]["name"] == HOSTILE
    assert HOSTILE in str(report)


def test_the_page_goes_from_the_verdict_to_how_to_repeat_it(reports):
    found = page_of(reports["paper-rod"])
    assert found.headings == [
        "Without load, every motion of the rod of finite energy comes to rest, its end at a zero of the nonlinearity.",
        "What is shown, and what is not",
        "Popov and Nyquist",
        "Motion: the rod and its scheme, side by side",
        "Assumed, not checked",
        "Reproduce",
        "Details",
    ]
    assert "lure report paper-rod" in found.text
    assert "not matched" in found.text  # the paper's data are not: u0'(0) = -2e-4 is held by no force


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_contents_lead_to_every_part_and_the_details_are_folded(reports, name):
    found = page_of(reports[name])
    wanted = [given["href"].removeprefix("#") for tag, given in found.elements if tag == "a"]
    parts = [given["id"] for tag, given in found.elements if tag in ("h2", "details") and "id" in given]
    assert [ident for ident in parts if ident != "details"] == wanted
    assert ("certificates" in wanted) is bool(reports[name].certificates)
    assert not [given for tag, given in found.elements if tag == "details" and "open" in given]
    assert wanted.index("reproduce") < wanted.index("criteria")


# at 1280 px the text before the details is set about 44 rem wide: 900 words and four figures fill four screens
def test_what_stands_before_the_details_is_short(pages):
    for path in pages.values():
        before, _, after = path.read_text("utf-8").partition('id="details"')
        assert before.count("<figure>") <= 4
        body = re.sub(r"<(style|defs|svg)\b.*?</\1>", "", before, flags=re.DOTALL)
        assert len(re.sub(r"<[^>]+>", " ", body).split()) < 1000
        assert after.count("<figure>") >= 10


@pytest.mark.parametrize("name", ["paper-rod", "no dashpot", "negative dashpot", "curved nonlinearity"])
def test_rod_and_scheme_stand_in_one_popov_and_one_nyquist_plot(reports, name):
    for spec in figure_specs(reports[name]):
        if spec.name in ("popov", "nyquist"):
            axes = Figure().add_subplot()
            spec.draw(ax=axes)
            labels = [text.get_text() for text in axes.get_legend().get_texts()]
            assert {"rod, ω > 0", "scheme, N = 10"} <= set(labels)


@pytest.mark.parametrize("name", SYSTEMS)
def test_no_missing_evidence_is_printed(reports, name):
    found = page_of(reports[name])
    assert "None)" not in found.text
    fails = any(status == "fails" for status in re.findall(r"class=.tag (\w+)", page_text(reports[name])))
    assert ("Assumed, and what fails" in found.headings) is fails


def page_text(report):
    return page(document(report), claims(report), ())


def test_as_printed_is_said_on_the_page(reports):
    assert "Form as printed" in page_of(reports["paper-rod-figure-8"]).text
    assert "Form as printed" not in page_of(reports["paper-rod"]).text


def test_every_figure_is_written_as_svg_and_png(pages):
    folder = pages["touching"].with_name("figures")
    names = {path.stem for path in folder.iterdir()}
    assert names == {
        "spectrum",
        "damping",
        "both-ends",
        "both-decays",
        "end-motion",
        "resting-place",
        "decay",
        *(f"surface-{which}" for which in ("r1", "r2", "v")),
        "popov",
        "nyquist",
        *(f"popov-expression-{model}" for model in ("scheme", "rod")),
        *(f"nyquist-{model}-resonances" for model in ("scheme", "rod")),
    }
    for name in names:
        assert (folder / f"{name}.svg").read_text("utf-8").startswith("<?xml")
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_terminal_gets_the_same_in_eighty_columns(reports):
    for report in reports.values():
        text = str(report)
        assert max(map(len, text.splitlines())) <= 80
        assert text.startswith(str(report.verdict))
    assert "contact interval" in str(reports["touching"])
    assert "double" in str(reports["no dashpot"])


@given(value=st.floats(-1e300, 1e300, allow_subnormal=False), digits=st.integers(2, 8))
def test_a_rounded_number_stays_on_its_side_and_close(value, digits):
    down, near, up = (spoken(plain(format_number(value, digits, mode))) for mode in ("down", "nearest", "up"))
    slack = 4e-16 * abs(value)  # reading the printed number back rounds once more
    assert down - slack <= value <= up + slack
    assert near == pytest.approx(value, rel=10.0 ** (1 - digits))
    assert up - down <= 10.0 ** (2 - digits) * abs(value)


def plain(markup):
    return re.sub(r"</?sup>", "", str(markup))


@pytest.mark.parametrize(
    ("value", "mode", "text"),
    [
        (0.99999, "down", "0.9999"),
        (0.99999, "up", "1"),
        (-0.00012345, "down", "−1.235 × 10<sup>−4</sup>"),
        (123456.7, "nearest", "123500"),
        (math.inf, "up", "∞"),
        (0.0, "down", "0"),
    ],
)
def test_numbers_are_rounded_in_the_direction_asked_for(value, mode, text):
    assert str(format_number(value, 4, mode)) == text


def test_prose_gets_the_signs_of_print():
    assert (
        prose("zeta >= 0, z <= -1, (h/2c) sum y_i^2, sector [0, inf)") == "ζ ≥ 0, z ≤ −1, (h/2c) ∑ yᵢ², sector [0, ∞)"
    )
    assert prose("a dead zone of +-1 with slope 1.4994") == "a dead zone of ±1 with slope 1.4994"
    assert prose("information, well-known, 1e-05, beta") == "information, well-known, 1e-05, beta"


@pytest.mark.parametrize(("value", "text"), [("1/8", "0.125"), ("1/3", "1/3"), ("288e6", "288000000")])
def test_exact_numbers_are_written_exactly(value, text):
    assert exact_text(Fraction(value)) == text


def test_the_page_says_where_the_simulated_motion_comes_to_rest(reports):
    # without momentum at the start and at the end, the dashpot has not moved: the rod rests displaced by u0(0) = 1e-4
    report = reports["paper-rod"]
    assert document(report)["simulation"]["rest_position"] == pytest.approx(1e-4 - 0.02, rel=1e-5)
    assert "no contact can follow, so this is the z at which it comes to rest" in page_of(report).text
    # pushed at 1 m/s, k = 2e-4: free, the end would travel m v/k = 1 m, so contact is still to come after 2 ms
    assert "inside the obstacle, so contact is still to come" in page_of(reports["touching"]).text
    assert "Resting place" not in page_of(reports["negative dashpot"]).text


def test_a_run_that_ended_early_says_why(tmp_path):
    report = build_report(replace(with_damping(Fraction(-1, 2)), until=1.0))
    assert "Ended early: The motion has grown" in page_of(report).text
