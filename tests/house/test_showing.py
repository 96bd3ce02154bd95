"""What a notebook shows: every table parses, escapes what it is given and carries its verdict; plain JSON beside it."""

import json
import math
import sys
from enum import Enum
from fractions import Fraction
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from results import HOSTILE, SYSTEMS, THIRD, loop_named

import lure
from lure.analysis import analyse, certify, check, max_sector, max_slope, nyquist_response, popov_response
from lure.analysis.certificates.representation import failure_dict, shown_dict, shown_html
from lure.analysis.describing import describing_hint
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.report.loop import LoopReport
from lure.analysis.rod.report import build_report
from lure.analysis.theorems.passivity import passivity_indices
from lure.analysis.verdict import Bracket
from lure.errors import InputError
from lure.files.builtin import builtin_loops
from lure.record import html_table, plain, xarray_or_refusal
from lure.rod.systems import builtin_systems, paper_rod

SAMPLES = lure.FrequencyData([1, 2], [1, -1])
VOID = {"br", "hr", "img", "path", "use", "rect", "stop", "circle", "metadata"}


class Reader(HTMLParser):
    """The text and tags of a page; fails on a tag that does not close."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.words = [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(page):
    """Tags and text of a page, which must parse, close everything and run nothing."""
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    assert "script" not in reader.tags
    assert not {"#000", "#fff", "color:", "background"} & set(page.split("<svg")[0].split())
    return reader.tags, "".join(reader.words)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_is_a_table_that_parses_and_plain_data(name):
    system = SYSTEMS[name]
    tags, _ = read(system._repr_html_())
    assert {"table", "caption", "tbody", "th", "td"} <= set(tags)
    data = json.loads(json.dumps(system.to_dict(), allow_nan=False))
    assert data["kind"]


@pytest.mark.parametrize("name", ["hostile loop", "loop of a stranger"])
def test_a_hostile_name_is_text(name):
    page = SYSTEMS[name]._repr_html_()
    assert "<script" not in page
    assert HOSTILE in read(page)[1]


def test_a_declaration_that_the_formula_breaks_is_shown_as_broken():
    page, data = SYSTEMS["contradicted"]._repr_html_(), SYSTEMS["contradicted"].to_dict()
    assert "CONTRADICTED: the law" in read(page)[1]
    assert "declare bounds that hold" in data["contradicted"]
    assert SYSTEMS["formula"].to_dict()["contradicted"] is None
    assert SYSTEMS["formula"].to_dict()["sector"]["standing"] == "declared"
    assert SYSTEMS["saturation"].to_dict()["sector"]["standing"] == "checked"


def test_a_block_in_latex():
    block = lure.RationalPlant([1e5, 0, -2.5e-7], [1, *[0] * 10, 3])
    assert block._repr_latex_() == (r"$\displaystyle H(s) = \frac{100000 s^{2} - 2.5\cdot 10^{-7}}{s^{11} + 3}$")
    assert lure.RationalPlant([Fraction(3, 2)], [1], dt=1)._repr_latex_() == r"$\displaystyle H(z) = 1.5$"


@pytest.fixture(scope="module")
def results():
    rod = build_report(builtin_systems()["paper-rod"])
    proved = certify(THIRD, lure.NonlinearityClass(sector=lure.Sector(0, 5)))
    analysis = analyse(loop_named(HOSTILE))
    return {
        "largest": max_sector(THIRD),
        "largest refuted": max_sector("4/((s-1)*(s/3+1))"),
        "largest observed": max_sector(SAMPLES),
        "largest slope": max_slope("1/(s+1)", odd=True, search="linear"),
        "answer": max_sector(THIRD).answers[0],
        "analysis": analysis,
        "loop report": LoopReport(
            analysis=analysis, observed=("4 motions came to rest",), hints=("no balance",), command="lure", versions={}
        ),
        "gains": gain_intervals(THIRD)[0],
        "gains without end": gain_intervals(lure.RationalPlant([1], [1, 1]))[0],
        "passivity": passivity_indices(THIRD),
        "hint": describing_hint(lure.RationalPlant([12], [1, 3, 2, 0]), lure.Saturation()),
        "certification": proved,
        "certification refuted": certify(THIRD, lure.NonlinearityClass(sector=lure.Sector(0, 7))),
        "certification undecided": certify(SAMPLES, lure.NonlinearityClass(sector=lure.Sector(0, 1))),
        "rod report": rod,
        "spectrum": rod.spectrum,
        "rod criterion": next(one for one in rod.criteria if one.model == "rod"),
        "scheme criterion": next(one for one in rod.criteria if one.model == "scheme"),
        "popov": popov_response(loop_named(HOSTILE)),
        "nyquist": nyquist_response(THIRD, k=1),
    }


# what each page must say: the verdict, the evidence, what it is about, and what it does not say
SAYS = {
    "largest": (
        "PROVED",
        "certified",
        "in the sector [0, k]",
        "Not shown",
        "lure.analysis.check(result.proof.certificate)",
    ),
    "largest refuted": ("REFUTED", "certified", "Not shown", "lure.analysis.check(result.refutation.certificate)"),
    "largest observed": ("INCONCLUSIVE", "nothing is proved", "observed"),
    "largest slope": ("PROVED", "certified", "odd phi with slope in"),
    "answer": ("PROVED", "certified", "popov criterion", "hypothesis", "Not shown"),
    "analysis": ("PROVED", "Evidence: certified", HOSTILE, "Not shown"),
    "loop report": ("PROVED", "certified", "observed", "One motion proves nothing about another", "Not shown"),
    "gains": ("certified", "nothing follows for nonlinear phi"),
    "gains without end": ("inf", "nothing follows for nonlinear phi"),
    "passivity": ("REFUTED", "certified", "hidden modes"),
    "hint": ("OBSERVED", "not a verdict", "perhaps attracting"),
    "certification": ("PROVED", "certified", "popov", "Not shown", "lure.analysis.check(certificate)"),
    "certification refuted": ("REFUTED", "certified", "root"),
    "certification undecided": ("INCONCLUSIVE", "nothing about the loop"),
    "rod report": ("PROVED", "paper-rod", "scheme", "rod", "Not shown"),
    "spectrum": ("A mode of the scheme is not one of the rod",),
    "rod criterion": ("PROVED", "certified", "for the rod itself", "rests on its energy theorem"),
    "scheme criterion": ("PROVED", "certified", "for the N-cell scheme", "not about the rod"),
    "popov": ("OBSERVED", "proves nothing", "certified"),
    "nyquist": ("OBSERVED", "proves nothing", "certified"),
}


@pytest.mark.parametrize("name", SAYS)
def test_every_result_says_its_verdict_its_evidence_and_what_it_does_not_show(results, name):
    page = results[name]._repr_html_()
    tags, text = read(page)
    assert {"table", "caption", "td"} <= set(tags)
    for words in SAYS[name]:
        assert words in text
    if SAYS[name][0].isupper():
        assert f"<b>{SAYS[name][0]}</b>" in page


@pytest.mark.parametrize("name", SAYS)
def test_every_result_is_plain_json_without_nan_or_infinity(results, name):
    data = json.dumps(results[name].to_dict(), allow_nan=False)
    if SAYS[name][0].isupper() and name not in ("rod report", "loop report", "hint", "passivity"):
        assert SAYS[name][0].lower() in data.lower()


@pytest.mark.parametrize(
    ("name", "dimension", "size"),
    [
        ("largest", "criterion", 2),
        ("analysis", "law_class", 4),
        ("loop report", "law_class", 4),
        ("hint", "balance", 1),
        ("rod report", "criterion", 4),
        ("rod report", "mode", 11),
        ("spectrum", "mode", 11),
    ],
)
def test_tables_are_datasets_that_netcdf_can_hold(results, name, dimension, size, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    dataset = results[name].to_xarray()
    assert dataset.sizes[dimension] == size
    dataset.to_netcdf(tmp_path / "result.nc")
    with xarray.open_dataset(tmp_path / "result.nc") as again:
        assert again.sizes[dimension] == size


def test_the_numbers_of_a_dataset_are_those_of_the_answer(results):
    pytest.importorskip("xarray")
    found = results["largest"]
    dataset = found.to_xarray()
    assert dataset.low.sel(criterion="popov").item() == found.largest.low
    assert dataset.attrs["refuted_at"] == 6
    assert "certified" in dataset.attrs["comment"]
    modes = results["spectrum"].to_xarray()
    assert modes.rod_real.to_numpy() == pytest.approx([mode.rod.real for mode in results["spectrum"].modes])


def test_answers_draw_themselves_on_the_axes_they_are_given(results):
    from matplotlib.figure import Figure

    for name in ("largest", "analysis", "loop report"):
        axes = Figure().add_subplot()
        assert results[name].plot(ax=axes) is axes
        assert "upper end k of the class" in axes.get_xlabel()


def test_what_the_checker_accepted_is_shown_without_the_checker_knowing_of_pages(results):
    shown = results["certification"].shown
    _, text = read(shown_html(shown))
    assert text.startswith("PROVED every motion converges")
    assert shown.theorem in text
    data = json.loads(json.dumps(shown_dict(shown), allow_nan=False))
    assert data["certificate"]["verdict"] == "PROVED"
    undecided = results["certification undecided"]
    for failure in undecided.failures:
        assert set(failure_dict(failure)) == {"search", "code", "title", "detail"}


def test_the_calls_that_a_page_names_work(results):
    assert type(check(results["largest"].proof.certificate)).__name__ == "Proved"
    assert type(check(results["largest refuted"].refutation.certificate)).__name__ == "Refuted"
    assert "lure.analysis.check(result.shown.certificate)" in read(results["analysis"]._repr_html_())[1]
    assert type(check(results["analysis"].shown.certificate)).__name__ == "Proved"
    assert type(check(results["certification"].certificate)).__name__ == "Proved"


def test_without_xarray_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    for call in (max_sector(THIRD).to_xarray, SYSTEMS["data"].to_xarray, popov_response(THIRD).to_xarray):
        with pytest.raises(InputError, match=r'needs xarray: pip install "lure\[netcdf\]"'):
            call()
    with pytest.raises(InputError, match=r"^a table needs xarray"):
        xarray_or_refusal("a table")


@given(
    title=st.text(max_size=40),
    rows=st.lists(st.lists(st.text(max_size=20), min_size=1, max_size=4), max_size=4),
    verdict=st.text(max_size=10),
    notes=st.lists(st.text(max_size=30), max_size=3),
)
def test_whatever_a_table_is_given_comes_out_as_text(title, rows, verdict, notes):
    clean = str.maketrans({"\r": "\n", "\x00": "", "\x0c": ""})
    title, verdict = title.translate(clean), verdict.translate(clean)
    page = html_table(title, rows, verdict=verdict, notes=notes)
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    assert set(reader.tags) <= {"div", "table", "caption", "b", "tbody", "tr", "th", "td", "p", "em"}
    assert reader.tags.count("tr") == len(rows)
    assert reader.tags.count("em") == len(notes)


def test_a_long_cell_is_cut_and_says_so():
    _, text = read(html_table("t", [("a", "x" * 1000)]))
    assert "x" * 400 + "... (1000 characters)" in text


class Colour(Enum):
    RED = "red"

    def __str__(self):
        return self.value


SCALARS = [
    st.none() | st.booleans() | st.integers() | st.floats() | st.fractions() | st.text(max_size=5),
    st.complex_numbers(),
    st.sampled_from([Colour.RED, Bracket(0.0, math.inf), np.float64("nan"), np.array([1.5, np.inf])]),
]
PLAIN = st.recursive(
    st.one_of(SCALARS),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=8,
)


@given(PLAIN)
def test_plain_data_is_json_and_stays_what_it_is(value):
    once = plain(value)
    json.dumps(once, allow_nan=False)
    assert plain(once) == once


@pytest.mark.parametrize("name", builtin_loops())
def test_the_answer_about_every_named_loop_is_a_page_and_plain_data(name):
    block = SYSTEMS[name].block
    for found in (max_sector(block), nyquist_response(block)):
        _, text = read(found._repr_html_())
        assert "Not shown" in text or "proves nothing" in text
        data = json.loads(json.dumps(found.to_dict(), allow_nan=False))
        assert data["sentence"] == str(found)


def test_the_rod_and_its_scheme_say_which_they_are():
    rod = paper_rod()
    _, text = read(lure.rod.RodPlant(rod)._repr_html_())
    assert "The rod itself, without a grid." in text
    assert "-0.999667" in text  # a = (k - Z)/(k + Z) = (2e-4 - 1.2)/(2e-4 + 1.2)
    _, text = read(lure.rod.upwind(rod, 3)._repr_html_())
    assert "A scheme, not the rod" in text
    assert "18000 1/s" in text  # c N/L = 6000 * 3
