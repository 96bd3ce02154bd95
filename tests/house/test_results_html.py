"""What results show in a notebook: well-formed tables that say what moved and on which evidence, and run nothing."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from results import RESULTS

from lure import Sector
from lure.analysis.measured import Measurements, sector_from_data
from lure.analysis.testing import assert_in_sector

VOID = {"br", "hr", "img"}
# the word for what moved, and for the evidence
SAYS = {
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
    "law bounds": ("sigma in [-1, 1]", "CERTIFIED"),
    "violation": ("a sector bound is passed", "REFUTED"),
    "measurements": ("measurements from", "OBSERVED"),
    "measured sector": ("the mean law", "OBSERVED"),
    "compliance fit": ("observed, not proved", "OBSERVED"),
    "measured margin": ("observed with 95 % confidence", "INSIDE"),
    "measured report": ("the mean law", "OBSERVED"),
    "checked": ("lies in the sector", "CERTIFIED"),
    "broken": ("phi(sigma)/sigma", "VIOLATED"),
}


class Reader(HTMLParser):
    """Tags that do not match, and the text between them."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.text = [], set(), []

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def read(result):
    reader = Reader()
    reader.feed(result._repr_html_())
    reader.close()
    assert reader.open == []
    return reader, "".join(reader.text)


@pytest.mark.parametrize("name", SAYS)
def test_a_table_says_what_it_is_about_and_on_which_evidence(name):
    about, evidence = SAYS[name]
    _, text = read(RESULTS[name]())
    assert about in text
    assert text.startswith(evidence)


@pytest.mark.parametrize("name", ["Galerkin run", "structured motion", "trajectory", "sampled scheme"])
def test_a_motion_of_a_discrete_model_is_not_one_of_the_rod(name):
    assert "It is not a motion of the rod." in read(RESULTS[name]())[1]


@pytest.mark.parametrize("name", ["exact motion", "sampled rod"])
def test_a_motion_proves_nothing_of_others(name):
    _, text = read(RESULTS[name]())
    assert "proves nothing of others" in text
    assert "not a motion of the rod" not in text


# at the start the bound of Lemma 3.2 is the energy itself: rounding must not look like a violation
def test_a_sound_run_is_within_its_bound_and_another_is_not():
    run = RESULTS["Galerkin run"]()
    assert "VIOLATED" not in read(run)[1]
    assert run.to_dict()["energy_within_bound"] is True
    states = run.states.copy()
    states[-1, :10] *= 3.0
    assert "VIOLATED" in read(replace(run, states=states))[1]


def test_what_is_measured_is_rounded_outwards_and_what_is_proved_inwards():
    found = RESULTS["measured margin"]()
    _, text = read(found)
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
        reader, text = read(result)
        assert "script" not in reader.tags
        assert evil in text


def test_a_law_with_a_hostile_name_is_shown_as_text():
    def halved(x):
        return x / 2

    halved.__name__ = "<script>alert(1)</script>"
    reader, text = read(assert_in_sector(halved, Sector(0, 1), on=(-1, 1)))
    assert "script" not in reader.tags
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
    _, text = read(table)
    assert text.startswith("0 of 1 claims of the paper survive")
    assert "z < 0" in text
    assert "FAILS" in text
    found = table.to_xarray()
    assert found.largest_z.sel(figure=8).item() == 0.5
    assert found.contacts.item() == 3
