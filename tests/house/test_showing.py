"""What a notebook shows: every table parses, escapes what it is given and carries its verdict; plain JSON beside it."""

import json
import math
import re
import sys
from dataclasses import replace
from enum import Enum
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pages import Reader, page_with_its_data, read
from results import HOSTILE, RESULTS, SYSTEMS, THIRD

import lure
from lure import Sector
from lure.analysis import check, max_sector, nyquist_response, popov_response
from lure.analysis.measured import Measurements, sector_from_data
from lure.analysis.questions.conclusion import failure_dict, shown_dict, shown_page
from lure.analysis.testing import assert_in_sector
from lure.analysis.verdict import Bracket
from lure.errors import InputError
from lure.files.builtin import builtin_loops
from lure.record import html_table, plain, xarray_or_refusal
from lure.rod.systems import paper_rod


@pytest.mark.parametrize("name", ["hostile loop", "loop of a stranger"])
def test_a_hostile_name_is_text(name):
    page = SYSTEMS[name]._repr_html_()
    assert "<script" not in page
    assert HOSTILE in read(page)[1]


def test_a_declaration_that_the_formula_breaks_is_shown_as_broken():
    page, data = SYSTEMS["contradicted"]._repr_html_(), SYSTEMS["contradicted"].to_dict()
    assert "CONTRADICTED: the nonlinearity" in read(page)[1]
    assert "declare bounds that hold" in data["contradicted"]
    assert SYSTEMS["formula"].to_dict()["contradicted"] is None
    assert SYSTEMS["formula"].to_dict()["sector"]["standing"] == "declared"
    assert SYSTEMS["saturation"].to_dict()["sector"]["standing"] == "checked"


def test_a_block_in_latex():
    block = lure.RationalPlant([1e5, 0, -2.5e-7], [1, *[0] * 10, 3])
    assert block._repr_latex_() == (r"$\displaystyle H(s) = \frac{100000 s^{2} - 2.5\cdot 10^{-7}}{s^{11} + 3}$")
    assert lure.RationalPlant([Fraction(3, 2)], [1], dt=1)._repr_latex_() == r"$\displaystyle H(z) = 1.5$"


def shown(name):
    return RESULTS[name]()


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
    "loop report": ("PROVED", "certified", "observed", "One solution proves nothing about another", "Not shown"),
    "gains": ("certified", "nothing follows for nonlinear phi"),
    "gains without end": ("inf", "nothing follows for nonlinear phi"),
    "passivity": ("REFUTED", "certified", "hidden modes"),
    "hint": ("OBSERVED", "not a verdict", "perhaps attracting"),
    "certification": ("PROVED", "certified", "popov", "Not shown", "lure.analysis.check(certificate)"),
    "certification refuted": ("REFUTED", "certified", "root"),
    "certification undecided": ("INCONCLUSIVE", "nothing about the loop"),
    "rod report": ("PROVED", "paper-rod", "scheme", "rod", "Not shown"),
    "rod spectrum": ("A mode of the scheme is not one of the rod",),
    "rod criterion": ("PROVED", "certified", "for the rod itself", "about the partial differential equation"),
    "scheme criterion": ("PROVED", "certified", "for the N-cell scheme", "not about the rod"),
    "popov plot": ("OBSERVED", "proves nothing", "certified"),
    "nyquist plot": ("OBSERVED", "proves nothing", "certified"),
}


@pytest.mark.parametrize("name", SAYS)
def test_every_result_says_its_verdict_its_evidence_and_what_it_does_not_show(name):
    page = shown(name)._repr_html_()
    tags, text = read(page)
    assert {"table", "caption", "td"} <= set(tags)
    for words in SAYS[name]:
        assert words in text
    if SAYS[name][0].isupper():
        assert f"<b>{SAYS[name][0]}</b>" in page
    if SAYS[name][0] in ("PROVED", "REFUTED", "INCONCLUSIVE") and name != "passivity":
        assert SAYS[name][0].lower() in json.dumps(shown(name).to_dict(), allow_nan=False).lower()


def test_the_numbers_of_a_dataset_are_those_of_the_answer():
    found = shown("largest")
    dataset = found.to_xarray()
    assert dataset.low.sel(criterion="popov").item() == found.largest.low
    assert dataset.attrs["refuted_at"] == 6
    assert dict(shown("analysis").to_xarray().sizes) == {"law_class": 4}
    assert dict(shown("rod report").to_xarray().sizes) == {"criterion": 4, "mode": 11}
    assert "certified" in dataset.attrs["comment"]
    modes = shown("rod spectrum").to_xarray()
    assert modes.rod_real.to_numpy() == pytest.approx([mode.rod.real for mode in shown("rod spectrum").modes])


def test_answers_draw_themselves_on_the_axes_they_are_given():
    from matplotlib.figure import Figure

    for name in ("largest", "analysis", "loop report"):
        axes = Figure().add_subplot()
        assert shown(name).plot(ax=axes) is axes
        assert "upper end k of the class" in axes.get_xlabel()


def test_what_the_checker_accepted_is_shown_without_the_checker_knowing_of_pages():
    accepted = shown("certification").shown
    _, text = read(shown_page(accepted).html())
    assert text.startswith("PROVED every motion converges")
    assert accepted.theorem in text
    data = json.loads(json.dumps(shown_dict(accepted), allow_nan=False))
    assert data["certificate"]["verdict"] == "PROVED"
    undecided = shown("certification undecided")
    for failure in undecided.failures:
        assert set(failure_dict(failure)) == {"search", "code", "title", "detail"}


def test_the_calls_that_a_page_names_work():
    assert type(check(shown("largest").proof.certificate)).__name__ == "Proved"
    assert type(check(shown("largest refuted").refutation.certificate)).__name__ == "Refuted"
    assert "lure.analysis.check(result.shown.certificate)" in read(shown("analysis")._repr_html_())[1]
    assert type(check(shown("analysis").shown.certificate)).__name__ == "Proved"
    assert type(check(shown("certification").certificate)).__name__ == "Proved"


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


@pytest.mark.parametrize("name", [name for name in builtin_loops() if SYSTEMS[name].classes is None])
def test_the_plot_of_every_named_loop_is_a_page_and_plain_data(name):
    response = nyquist_response(SYSTEMS[name].block)
    assert f"at {len(response.omega)} frequencies" in page_with_its_data(response)


def test_the_rod_and_its_scheme_say_which_they_are():
    rod = paper_rod()
    _, text = read(lure.rod.RodPlant(rod)._repr_html_())
    assert "The rod itself, without a grid." in text
    assert "-0.999667" in text  # a = (k - Z)/(k + Z) = (2e-4 - 1.2)/(2e-4 + 1.2)
    _, text = read(lure.rod.upwind(rod, 3)._repr_html_())
    assert "A scheme, not the rod" in text
    assert "18000 1/s" in text  # c N/L = 6000 * 3


# What moved, and on which evidence.

# the word for what moved, and for the evidence
MOVED = {
    "exact motion": ("the rod itself", "COMPUTED"),
    "Galerkin run": ("Galerkin space P1 of dimension 5, not the rod", "OBSERVED"),
    "convergence": ("Galerkin spaces", "OBSERVED"),
    "cells on a line": ("cellular network of 2 cells", "OBSERVED"),
    "cells in the plane": ("cellular network of 2 x 3 cells", "OBSERVED"),
    "structured motion": ("upwind scheme of 40 cells", "OBSERVED"),
    "trajectory": ("upwind scheme of 10 cells", "OBSERVED"),
    "trajectory without load": ("upwind scheme of 10 cells", "OBSERVED"),
    "sampled scheme": ("upwind scheme of 10 cells", "OBSERVED"),
    "sampled Galerkin": ("Galerkin space P1 of dimension 5, not the rod", "OBSERVED"),
    "sampled rod": ("the rod itself", "COMPUTED"),
    "comparison": ("scheme, N = 10", "OBSERVED"),
    "confirmation": ("N-cell scheme", "OBSERVED"),
    "response": ("the rod itself", "OBSERVED"),
    "bifurcation": ("the rod itself", "OBSERVED"),
    "basin": ("the rod itself", "COMPUTED"),
    "nonlinearity bounds": ("sigma in [-1, 1]", "CERTIFIED"),
    "violation": ("a sector bound is passed", "REFUTED"),
    "measurements": ("measurements from", "OBSERVED"),
    "measured sector": ("the mean nonlinearity", "OBSERVED"),
    "compliance fit": ("observed, not proved", "OBSERVED"),
    "measured margin": ("observed with 95 % confidence", "INSIDE"),
    "measured report": ("the mean nonlinearity", "OBSERVED"),
    "checked": ("lies in the sector", "CERTIFIED"),
    "broken": ("phi(sigma)/sigma", "VIOLATED"),
}


@pytest.mark.parametrize("name", MOVED)
def test_a_table_says_what_it_is_about_and_on_which_evidence(name):
    about, evidence = MOVED[name]
    _, text = read(shown(name)._repr_html_())
    assert about in text
    assert text.startswith(evidence)


@pytest.mark.parametrize("name", ["Galerkin run", "structured motion", "trajectory", "sampled scheme"])
def test_a_motion_of_a_discrete_model_is_not_one_of_the_rod(name):
    assert "It is not a motion of the rod." in read(shown(name)._repr_html_())[1]


@pytest.mark.parametrize("name", ["exact motion", "sampled rod"])
def test_a_motion_proves_nothing_of_others(name):
    _, text = read(shown(name)._repr_html_())
    assert "proves nothing of others" in text
    assert "not a motion of the rod" not in text


# at the start the bound of Lemma 3.2 is the energy itself: rounding must not look like a violation
def test_a_sound_run_is_within_its_bound_and_another_is_not():
    run = shown("Galerkin run")
    assert "VIOLATED" not in read(run._repr_html_())[1]
    assert run.to_dict()["energy_within_bound"] is True
    states = run.states.copy()
    states[-1, :10] *= 3.0
    assert "VIOLATED" in read(replace(run, states=states)._repr_html_())[1]


def test_what_is_measured_is_rounded_outwards_and_what_is_proved_inwards():
    found = shown("measured margin")
    _, text = read(found._repr_html_())
    measured, proved = (re.search(rf"{name}\[(.*?), (.*?)\]", text) for name in ("times gain", "proved stable"))
    assert float(measured[2]) >= float(found.sector.upper)
    assert float(proved[2]) <= found.proved.largest.low


def test_hostile_names_are_shown_as_text():
    evil = '<script>alert("x")</script>'
    u = np.linspace(-1.0, 1.0, 40)
    plain = Measurements.from_arrays(u, 3 * u + 0.01 * np.cos(9 * u))
    data = Measurements(
        displacement=u, load=plain.load, unit="N", lines=plain.lines, source=evil, columns=(evil, evil), notes=(evil,)
    )
    for result in (data, sector_from_data(data)):
        tags, text = read(result._repr_html_())
        assert "script" not in tags
        assert evil in text


def test_a_law_with_a_hostile_name_is_shown_as_text():
    def halved(x):
        return x / 2

    halved.__name__ = "<script>alert(1)</script>"
    tags, text = read(assert_in_sector(halved, Sector(0, 1), on=(-1, 1))._repr_html_())
    assert "script" not in tags
    assert halved.__name__ in text
    assert "Nothing is said about the points not looked at." in text


def test_the_table_of_the_paper_has_a_row_for_each_claim():
    from lure.analysis.rod.paper import PaperClaim, PaperTable, Peak
    from lure.analysis.verdict import Evidence

    claim = PaperClaim(
        key="a",
        where="section 4",
        claim="z < 0",
        as_printed="yes",
        corrected="no",
        rod="no",
        survives=False,
        sentence="it is not",
        evidence=Evidence.COMPUTED,
    )
    peak = Peak(
        figure=8,
        variant="rod",
        cells=None,
        form=None,
        amplitude=1.0,
        largest_z=0.5,
        at=2.0,
        contacts=3,
        evidence=Evidence.COMPUTED,
    )
    table = PaperTable(claims=(claim,), peaks=(peak,), settling=())
    _, text = read(table._repr_html_())
    assert text.startswith("0 of 1 claims of the paper survive")
    assert "z < 0" in text
    assert "FAILS" in text
    found = table.to_xarray()
    assert found.largest_z.sel(figure=8).item() == 0.5
    assert found.contacts.item() == 3
