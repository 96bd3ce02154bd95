"""The report on any loop: its JSON keeps the published schema, its page says the same, what is typed in stays text."""

import json
import math
import re
from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from importlib import resources
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from markupsafe import Markup
from sketches import sketches

from lure import DelayPlant, InputError, RationalPlant
from lure.analysis import analyse, max_sector, nyquist_response, popov_response
from lure.analysis.graphical.axis import OnAxis
from lure.analysis.plots.loops import plot_largest, plot_solutions
from lure.analysis.report.loop import LoopReport, build_loop_report, figures, write_loop_report
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.model import balance_hints, inputs_sha256, nonlinearity_text
from lure.analysis.report.loop.write import (
    asked_about,
    class_words,
    counterexamples,
    explanation,
    headline,
    loop_page,
    open_questions,
    own,
)
from lure.analysis.verdict import Verdict
from lure.files import parse_system
from lure.files.builtin import builtin_loop
from lure.plants.family import PlantFamily
from lure.record import plain

SCHEMA = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
CHECK = jsonschema.Draft202012Validator(SCHEMA)
HOSTILE = "<script>alert('x')</script> & \"q\" {{ 7 * 7 }} ]]>"
FILES = {
    "proved": "[plant]\nnum=[1]\nden=[1,1]\n[class]\nsector=[0,5]\n",
    "shifted": '[plant]\nnum=[12]\nden=[1,2,-3]\n[class]\nsector=["1/2",3]\n',
    "discrete": '[plant]\ntransfer="1/(z*(z-0.5))"\ndt=0.1\n[class]\nsector=[0,0.5]\nslope=[0,0.5]\n',
    "samples": '[plant]\ntransfer="1/(z-0.5)"\n[class]\nsector=[0,0.2]\n',
    "dead time": '[plant]\ntransfer="exp(-s)/(s+1)"\n',
    "dead time and nonlinearity": (
        '[plant]\ntransfer="exp(-s)/(s+1)"\n[nonlinearity]\nkind="saturation"\ngain=1\nlimit=1\n'
    ),
    "law": '[plant]\nnum=[1]\nden=[1,2,1]\n[nonlinearity]\nkind="tanh"\nscale=1\ngain=2\n',
    "discrete nonlinearity": '[plant]\ntransfer="1/(z-0.5)"\ndt=1\n[nonlinearity]\nkind="relu"\ngain=1\n',
    "not Lipschitz": '[plant]\nnum=[1]\nden=[1,2,1]\n[nonlinearity]\nkind="quantiser"\nstep=1\n',
    "time-varying": "[plant]\nnum=[1]\nden=[1,1,1]\n[class]\nsector=[0,10]\ntime_varying=true\n",
    "parameters": (
        '[plant]\ntransfer="1/(s+a)"\n[plant.parameters]\na=[1,2]\n[class]\nsector=[-0.5,1]\n'
        '[report]\nask=["tolerances"]\n'
    ),
    "hostile": f"name='''{HOSTILE}'''\n[plant]\nnum=[1]\nden=[1,1]\n[nonlinearity]\nkind=\"relu\"\ngain=1\n",
}
BUILT_IN = ("unstable-lag", "double-zero", "contact", "positive-real", "lurie-hidden-zero")
NAMES = (*FILES, *BUILT_IN)
SKETCHED = ("shifted", "discrete", "unstable-lag")


def loop(name):
    return parse_system(FILES[name], name=name, source="a file") if name in FILES else builtin_loop(name)


@pytest.fixture(scope="module")
def reports():
    return {name: build_loop_report(loop(name)) for name in NAMES}


@pytest.fixture(scope="module")
def documents(reports):
    return {name: report.to_dict() for name, report in reports.items()}


@pytest.fixture(scope="module")
def pages(reports, tmp_path_factory):
    folder = tmp_path_factory.mktemp("loops")
    found = {"hostile": write_loop_report(reports["hostile"], folder / "hostile")}
    with sketches():
        return found | {name: write_loop_report(reports[name], folder / name) for name in SKETCHED}


class Page(HTMLParser):
    """What a browser would find: elements, the numbers with their keys, and the text."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.numbers, self.words, self.identifiers = [], [], [], []
        self.heading, self.inside = "", False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.elements.append((tag, given))
        self.identifiers += [given["id"]] if "id" in given else []
        self.inside = tag == "h1"
        if tag == "data":
            self.numbers.append((given["data-key"], given["value"]))

    def handle_endtag(self, tag):
        self.inside = self.inside and tag != "h1"

    def handle_data(self, data):
        self.words.append(data)
        self.heading += data if self.inside else ""


# schema ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_json_keeps_the_published_schema(documents, name):
    text = json.dumps(documents[name], allow_nan=False)
    CHECK.validate(json.loads(text))
    assert documents[name]["system"]["kind"] == "loop"
    assert SCHEMA["$id"] == "urn:lure:report:1"


def test_a_curve_of_one_plant_of_many_is_said_to_be_that(reports):
    for name, middle in (("parameters", True), ("proved", False)):
        specs = [figures._nyquist(reports[name]), *figures._popov(reports[name]), *figures._response(reports[name])]
        assert len(specs) >= 2
        for spec in specs:
            assert spec.caption.endswith(" Of the plant in the middle of the intervals alone.") is middle


def test_the_cases_differ(documents):
    verdicts = {name: data["conclusion"]["verdict"] for name, data in documents.items()}
    assert set(verdicts.values()) == {"PROVED", "REFUTED", "INCONCLUSIVE"}
    assert verdicts["unstable-lag"] == verdicts["time-varying"] == verdicts["double-zero"] == "REFUTED"
    assert verdicts["not Lipschitz"] == "INCONCLUSIVE"
    assert {data["system"]["case"] for data in documents.values()} == {"stable", "critical", "unstable"}
    # with gains from -1/2 on: no class begins at 0, and yet phi = 0 is a member, so that all plants are stable
    assert documents["parameters"]["system"]["case"] == "stable"
    assert documents["parameters"]["system"]["block"]["parameters"] == {"a": ["1", "2"]}
    assert documents["parameters"]["asked"]["tolerances"]["margins"][0]["parameters"] == ["a"]
    assert documents["samples"]["system"]["block"]["any_period"] is True
    assert "any_period" not in documents["discrete"]["system"]["block"]
    page = loop_page(documents["samples"], (), Markup(""))
    assert "sampled: no period is stated, and 1 s stands for it" in page
    assert "sampled every 1/10 s" in loop_page(documents["discrete"], (), Markup(""))
    assert documents["dead time"]["gains"] is None
    assert documents["lurie-hidden-zero"]["gains"] == []
    assert documents["discrete"]["system"]["block"]["dt"] == "1/10"


@pytest.mark.usefixtures("sketched")
@pytest.mark.slow
def test_a_nonlinear_counterexample_is_named_before_the_gain_that_refutes_every_class():
    # Leonov, Bragin, Kuznetsov: under phi = 0 the poles +-i remain, and that nonlinearity lies in the time-varying
    # sector too; their hidden oscillation begins at a saturation of slope 0.39598
    report = build_loop_report(builtin_loop("leonov-bragin-kuznetsov"))
    found = report.analysis
    assert {row.refuted_at for row in found.rows} == {found.asked.refuted_at} == {0}
    assert {row.trivial.data["gain"] for row in found.rows} == {"0"}
    assert {row.witness.kind for row in found.rows} == {"periodic orbit"}
    assert found.verdict is Verdict.REFUTED
    for said in (str(found), found.asked.to_dict()["sentence"]):
        assert all(words in " ".join(said.split()) for words in ("0.39598", "10.52706 s", "phi = 0"))
    assert {shown.certificate["proof"]["method"] for shown in found.certificates} == {"flow-orbit", "linear-gain"}
    document = report.to_dict()
    CHECK.validate(document)
    entries = [(entry["kind"], entry["quoted"]) for entry in counterexamples(document)]
    assert entries == [("linear gain", "0"), ("periodic orbit", "0.3959826")]
    assert {"orbit-1", "nonlinearity-1"} <= {figure.spec.name for figure in loop_figures(report)}


@pytest.mark.parametrize(
    ("where", "value"),
    [
        ((), {"surprise": 1}),
        (("system",), {"kind": "rod"}),
        (("system",), {"surprise": 1}),
        (("system", "law"), {"text": 1}),
        (("conclusion",), {"verdict": "TRUE"}),
        (("answers", 0), {"largest": [0.0, math.nan]}),
        (("answers", 0), {"largest": [0.0, None]}),
        (("answers", 0), {"surprise": 1}),
        (("answers", 0, "answers", 0), {"evidence": "sure"}),
        (("versions",), {"numpy": 2}),
    ],
)
def test_the_schema_refuses_what_it_does_not_describe(documents, where, value):
    data = json.loads(json.dumps(documents["law"]))
    place = data
    for key in where:
        place = place[key]
    place.update(value)
    if value == {"largest": [0.0, math.nan]}:
        with pytest.raises(ValueError, match="not JSON compliant"):
            json.dumps(data, allow_nan=False)
    else:
        assert not CHECK.is_valid(data)


def test_every_field_of_the_schema_is_described_or_plain():
    loop_parts = ("criterion_answer", "largest_answer", "law_class", "law", "block", "witness")
    for part in loop_parts:
        for name, field in SCHEMA["$defs"][part]["properties"].items():
            assert "description" in field or "enum" in field or "$ref" in field, (part, name)
        assert SCHEMA["$defs"][part]["additionalProperties"] is False


def test_plain_data_has_no_number_that_json_lacks():
    odd = {
        "a": (math.inf, -math.inf, math.nan),
        1: Fraction(2, 3),
        "n": np.float64(1.5),
        "e": Verdict.PROVED,
        "b": True,
    }
    assert plain(odd) == {"a": ["inf", "-inf", None], "1": "2/3", "n": 1.5, "e": "PROVED", "b": True}


# content --------------------------------------------------------------------------------------------------------------


def test_the_shift_of_an_unstable_plant_is_shown_step_by_step(documents):
    # H = 12/(s^2 + 2 s - 3), 1/2 moved into it: 12/(s^2 + 2 s + 3)
    steps = documents["shifted"]["transformation"]
    assert "H/(1 + 0.5 H) = 12 / (s^2 + 2 s + 3)" in steps[1]
    assert "gain k + 0.5 of phi" in steps[2]
    assert documents["proved"]["transformation"] == documents["unstable-lag"]["transformation"] == []


def test_properties_are_checked_or_declared(documents):
    known, word = documents["law"]["system"]["law"], documents["double-zero"]["system"]["law"]
    assert {known[key]["standing"] for key in ("sector", "slope", "odd", "regularity")} == {"checked"}
    assert {word[key]["standing"] for key in ("sector", "odd", "regularity")} == {"checked"}  # declared, then certified
    assert word["slope"]["standing"] == "declared"  # nothing is
    assert documents["proved"]["system"]["law"] is None


def test_the_fingerprint_is_that_of_the_inputs(reports, documents):
    sums = {data["reproduce"]["inputs_sha256"] for data in documents.values()}
    assert len(sums) == len(documents)
    again = build_loop_report(loop("proved"))
    assert again.to_dict() == documents["proved"]
    nearly = parse_system(FILES["law"].replace("gain=2", "gain=2.00000000000000000001"), name="law", source="a file")
    about = replace(reports["law"].analysis.problem, nonlinearity=nearly.nonlinearity)
    assert inputs_sha256(about, documents["law"]["system"]) != inputs_sha256(
        reports["law"].analysis.problem, documents["law"]["system"]
    )


class Silent:
    """A nonlinearity of a user that does not print."""


def test_a_law_that_does_not_print_is_named_after_its_class():
    assert nonlinearity_text(Silent()) == "Silent"
    assert nonlinearity_text(builtin_loop("dead-zone").nonlinearity).startswith("dead zone")


def test_counterexamples_are_listed_once_with_all_their_classes(documents):
    # phi = 0 is odd, has slope 0 and does not depend on time: it belongs to all four kinds of class
    (only,) = counterexamples(documents["unstable-lag"])
    assert (only["kind"], len(only["classes"])) == ("linear gain", 4)
    found = counterexamples(documents["discrete"])
    assert len({json.dumps(witness["data"]) for witness in found}) == len(found) > 1
    assert [witness["k"] for witness in found] == sorted(witness["k"] for witness in found)
    orbit = next(witness for witness in found if witness["kind"] == "periodic orbit")
    assert {"φ through (σ, φ)", "σ repeats", "μ repeats"} <= {name for name, _ in orbit["details"]}


def test_the_row_asked_about_is_the_one_of_the_class(documents):
    for name, words in {
        "proved": "sector [0, k]",
        "time-varying": "sector [0, k], time-varying",
        "discrete": "slope in [0, k]",
        "law": "slope in [0, k], odd",
        "shifted": "sector [0.5, k]",
    }.items():
        data = documents[name]
        assert [class_words(row) for row in data["answers"] if asked_about(row, data["system"])] == [words]
    assert not any(asked_about(row, {"class": None}) for row in documents["unstable-lag"]["answers"])


def test_what_is_open_is_said(documents):
    assert "(0.25, inf)" in open_questions(documents["unstable-lag"])[0]  # 12/((s-1)(s+3)) needs a gain above 1/4
    assert open_questions(documents["proved"]) == ["nothing: the question asked is decided"]
    gaps = open_questions(documents["dead time"])
    assert all(re.match(r"s[^:]+: nothing is known (above|between) ", gap) for gap in gaps)
    data = json.loads(json.dumps(documents["positive-real"]))
    data["system"]["class"] = None
    assert open_questions(data) == ["nothing: every gap is closed"]
    data["answers"][0] |= {"gap": "open", "proved_text": "0.1378895", "refuted_text": "0.194"}
    assert open_questions(data) == [f"{class_words(data['answers'][0])}: nothing is known between 0.1378895 and 0.194"]


@pytest.mark.parametrize("name", NAMES)
def test_headline_and_explanation_are_the_statement(documents, name):
    data = documents[name]
    conclusion, first = data["conclusion"], headline(data)
    rest = re.sub(r"^by (?!the criterion)", "", explanation(data))
    assert len(first) <= 160
    assert first == conclusion["headline"] or (own(data) and conclusion["headline"].startswith(first))
    checked = conclusion["verdict"] == "PROVED" and conclusion["membership"] == "checked"
    assert own(data) is (checked and conclusion["assumed"] == [])
    assert letters(conclusion["statement"]) == letters(conclusion["headline"]) + letters(rest)


# H(inf) = 1: that sigma + phi(sigma) = y has one solution is assumed, as the slopes of sigma^3 have no bound
def test_what_is_assumed_of_a_given_nonlinearity_is_part_of_the_headline():
    text = '[plant]\ntransfer = "(s+2)/(s+1)"\n[nonlinearity]\nkind = "expression"\nexpression = "sigma^3"\n'
    system = parse_system(text, name="x", source="")
    data = LoopReport(analysis=analyse(system), observed=(), hints=(), command="", versions={}).to_dict()
    assert (data["conclusion"]["verdict"], data["conclusion"]["membership"]) == ("PROVED", "checked")
    assert not own(data)
    end = "with sigma^3, if sigma + D phi(sigma) = y, D = 1, has exactly one solution sigma for every y."
    assert headline(data).endswith(end)


def letters(text):
    return re.sub(r"[^a-z0-9]", "", text.lower())


# simulation -----------------------------------------------------------------------------------------------------------


def test_a_law_is_simulated_and_of_a_class_only_members(reports):
    for name in ("law", "discrete nonlinearity", "contact"):
        (sentence,) = reports[name].observed
        assert re.match(r"\d+ simulated solutions over up to ", sentence)
    assert "came to rest at equilibria other than 0" in reports["contact"].observed[0]
    assert "all converged to 0" in reports["law"].observed[0]
    assert reports["proved"].observed == reports["dead time and nonlinearity"].observed == ()
    assert "not locally Lipschitz" in reports["not Lipschitz"].observed[0]
    assert {run.nonlinearity.split()[1] for run in reports["proved"].trajectories} >= {"saturation", "dead"}
    for run in reports["law"].trajectories:
        assert run.t.shape == run.sigma.shape == run.mu.shape
        assert np.allclose(run.mu, -2 * np.tanh(run.sigma))


def test_the_describing_function_is_a_hint_for_odd_laws_in_continuous_time(reports):
    assert "describing function" in balance_hints(reports["law"].analysis.problem)[0]
    assert "odd nonlinearities" in balance_hints(reports["contact"].analysis.problem)[0]
    assert balance_hints(reports["discrete nonlinearity"].analysis.problem) == ()
    assert balance_hints(reports["proved"].analysis.problem) == ()


@pytest.mark.parametrize(("number", "said"), [(1, "b0; it"), (4, "b0; b1; b2; b3; it"), (6, "b3; and 2 more; it")])
def test_of_many_balances_four_are_listed_and_the_others_counted(reports, monkeypatch, number, said):
    found = SimpleNamespace(balances=tuple(f"b{i}" for i in range(number)))
    monkeypatch.setattr("lure.analysis.report.loop.model.describing_hint", lambda block, nonlinearity: found)
    assert said in balance_hints(reports["law"].analysis.problem)[0]


# page -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["hostile", *SKETCHED])
def test_the_page_says_what_the_json_says(pages, documents, name):
    page = Page(pages[name].read_text("utf-8"))
    data = json.loads((pages[name].parent / "report.json").read_text("utf-8"))
    assert data == documents[name]
    assert page.numbers
    for key, value in page.numbers:
        found = data
        for part in key.split("."):
            found = found[int(part)] if isinstance(found, list) else found[part]
        assert str(found) == value
    assert data["conclusion"]["verdict"] in "".join(page.words)
    assert len(page.heading) <= 140
    for row in data["answers"]:
        assert class_words(row) in "".join(page.words)


@pytest.mark.parametrize("name", ["hostile", *SKETCHED])
def test_the_page_is_one_file_without_scripts(pages, name):
    text = pages[name].read_text("utf-8")
    page = Page(text)
    assert len(set(page.identifiers)) == len(page.identifiers)
    assert not [tag for tag, _ in page.elements if tag in ("script", "link", "iframe", "object", "img")]
    assert not [given for _, given in page.elements if any(key.startswith("on") for key in given)]
    assert "://" not in re.sub(r'xmlns(:xlink)?="[^"]*"', "", text)
    assert len(text) < 300_000


def test_what_a_user_types_is_text_on_the_page_and_in_no_figure(pages):
    text = pages["hostile"].read_text("utf-8")
    assert "<script" not in text
    assert HOSTILE in "".join(Page(text).words)
    figures = sorted((pages["hostile"].parent / "figures").glob("*.svg"))
    assert figures
    for figure in figures:
        assert "script" not in figure.read_text("utf-8")
        assert figure.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("name", NAMES)
def test_both_plots_are_drawn_whether_or_not_anything_is_proved(reports, name):
    specs = {figure.spec.name: figure.spec for figure in loop_figures(reports[name])}
    discrete = getattr(reports[name].analysis.problem.plant, "dt", None) is not None
    assert ("nyquist" in specs, "popov" in specs) == (True, not discrete)
    for kind, criterion in (("nyquist", "circle"), ("popov", "popov")):
        if kind in specs:
            proved = any(
                answer.verdict is Verdict.PROVED and answer.criterion == criterion and answer.largest.low > row.lower
                for row in reports[name].analysis.rows
                for answer in row.answers
            )
            assert ("proves nothing here" in specs[kind].caption) is not proved


# H = -1/(s - 1): Re H = 1/(1 + omega^2) > 0 keeps clear of Re H <= -1 and of every Popov line of k = 1 with theta = 0
@pytest.mark.usefixtures("sketched")
def test_a_curve_that_keeps_clear_is_not_said_to_cross():
    file = "[plant]\nnum=[-1]\nden=[1,-1]\n[class]\nsector=[0,1]\n"
    report = build_loop_report(parse_system(file, name="clear", source="clear.toml"))
    said = [figure.spec.caption for figure in loop_figures(report) if figure.spec.name in ("nyquist", "popov")]
    clear = (
        "proves nothing here, though the drawn curve keeps to its side: the poles of H count too, and every frequency."
    )
    assert said == [f"The circle criterion {clear}", f"Popov's criterion {clear}"]


@pytest.mark.usefixtures("sketched")
def test_the_response_of_the_given_law_is_drawn_to_the_same_height(reports):
    from matplotlib import pyplot

    for name in ("law", "discrete nonlinearity"):
        spec = next(figure.spec for figure in loop_figures(reports[name]) if figure.spec.name == "response")
        assert "observed, no proof" in spec.caption
        runs = spec.draw.args[0]
        faint = replace(runs[0], sigma=1e-12 * runs[0].sigma)  # what sigma does not show is not blown up to be seen
        axes = plot_solutions([faint, *runs])
        curves = [line.get_ydata() for line in axes.get_lines() if not line.get_label().startswith("_")]
        assert len(curves) == min(len(runs), 4)
        assert [float(np.abs(curve).max()) for curve in curves] == pytest.approx([1.0] * len(curves))
        assert str(runs[0].finding) in axes.get_legend().get_texts()[0].get_text()
        assert axes.get_xlabel() == "t [s]"
        untimed = plot_solutions([replace(one, unit="samples") for one in runs])
        assert untimed.get_xlabel() == "t [samples]"
        pyplot.close("all")
    with pytest.raises(InputError, match="no trajectory"):
        plot_solutions([])


@pytest.mark.usefixtures("sketched")
def test_the_line_of_a_shifted_loop_is_that_of_the_shifted_class(reports):
    # [1/2, k]: 12/(s^2 + 2 s + 3) and [0, k - 1/2]; Popov's criterion reaches every finite k, the line goes through 0
    spec = next(figure.spec for figure in loop_figures(reports["shifted"]) if figure.spec.name == "popov")
    (line,) = spec.draw.args
    assert line.block == RationalPlant([12], [1, 2, 3])
    assert line.k == math.inf
    assert "φ(σ) − 0.5 σ" in spec.caption


def test_the_line_of_many_plants_is_one_that_the_drawn_plant_keeps_from():
    # 1/(s (s + 1)(s + a)), a in [1, 2]: up to the least a (a + 1) = 2; each box of plants has a multiplier
    plants = PlantFamily.of_formula("1/(s*(s + 1)*(s + a))", {"a": (1, 2)})
    row = max_sector(plants, criterion="popov")
    problem = SimpleNamespace(block=plants, plant=plants, given=None)
    (spec,) = figures._popov(SimpleNamespace(analysis=SimpleNamespace(problem=problem, rows=(row,))))
    (line,) = spec.draw.args
    assert (1 / line.k + line.values.real - line.theta * line.omega * line.values.imag).min() > 0


# figures --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_bracket_of_every_class_fits_the_chart(reports, name):
    from matplotlib import pyplot

    rows = reports[name].analysis.rows
    axes = plot_largest(rows, ["a class"] * len(rows))
    left, right = axes.get_xlim()
    assert left < right
    assert all(math.isfinite(end) for end in (left, right))
    assert [text.get_bbox_patch() is not None for text in axes.texts] == [True] * len(rows)  # no line through words
    for row in rows:
        if row.refuted_at is not None:
            assert left <= row.refuted_at <= right
        if row.verdict is Verdict.PROVED and math.isfinite(row.largest.low):
            assert left <= row.largest.low <= right
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert len(labels) == len(set(labels))
    pyplot.close("all")


@pytest.mark.slow
def test_curves_of_every_kind_of_block_are_drawn():
    from matplotlib import pyplot

    for block in (
        RationalPlant([1], [1, 0]),
        RationalPlant([1, 0, 0], [1, Fraction("0.0003"), 10, Fraction("0.0021"), 9]),
        RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1),
        DelayPlant.parse("exp(-10*s)/(s+1)"),
        RationalPlant([1], [1]),
    ):
        omega = OnAxis(block).frequencies()
        assert (np.diff(omega) > 0).all()
        assert (np.isfinite(OnAxis(block).transfer(1j * omega))).all()
        axes = nyquist_response(block, k=1).plot()
        assert ("exp iω" in axes.get_xlabel()) == OnAxis(block).discrete
        if not OnAxis(block).discrete:
            popov_response(block, k=math.inf, theta=-0.5).plot()
        pyplot.close("all")


def test_a_report_is_no_truth_value_and_prints_what_was_observed(reports):
    assert isinstance(reports["law"], LoopReport)
    with pytest.raises(TypeError, match="three answers"):
        bool(reports["law"])
    assert "simulated solutions" in str(reports["law"])
