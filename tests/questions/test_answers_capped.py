"""A class that is proved as far as a certificate was tried says so, wherever its end is named."""

import math

import pytest
from markupsafe import Markup
from matplotlib.figure import Figure

from lure.analysis import max_sector, max_slope
from lure.analysis.numerics.doubles import bound_below
from lure.analysis.plots import plot_largest
from lure.analysis.report.loop import build_loop_report
from lure.analysis.report.loop.write import loop_page
from lure.files.builtin import builtin_loop

# Park's inequality holds for ct-7 in the limit k -> inf, with no one multiplier for all k: a certificate is written for
# the first of the k tried that the checker accepts, 1e12
SEVENTH = builtin_loop("ct-7")


@pytest.mark.slow
def test_the_largest_k_tried_is_called_so():
    found = max_slope(SEVENTH.block)
    assert found.search_limited
    assert (found.largest.low, found.largest.high) == (1e12, math.inf)
    assert found.proved_up_to == "1e12, the largest k tried"
    assert "slope in [0, 1e12], the largest k tried (park, certified)" in str(found)
    assert "1e12, the largest k tried" in found._repr_html_()
    assert "1000000000000" not in str(found)
    assert found.answers[0].reason == "1e12 is the largest k for which a certificate was tried"


@pytest.mark.slow
def test_tables_pages_and_figures_say_so_too():
    report = build_loop_report(SEVENTH)
    said = str(report.analysis)
    assert "1e12, the largest k tried" in said
    assert "1000000000000" not in said
    assert "</data>, the largest k tried</td>" in loop_page(report.to_dict(), (), Markup(""))
    axes = plot_largest(report.analysis.rows, ["a", "b", "c", "d"], ax=Figure().add_subplot())
    words = [text.get_text() for text in axes.texts] + [text.get_text() for text in axes.get_yticklabels()]
    assert sum("proved to 1e12, the largest k tried" in text for text in words) == 2
    assert axes.get_xlim()[1] < 1e3  # the axis is that of the numbers that mean something: 8 to 13


# where nothing is refuted and no proof ends, the axis is that of what was tried: bars to 1 that say 1e12 mislead
def test_the_axis_reaches_what_was_tried_where_no_other_number_means_something():
    axes = plot_largest([max_slope(SEVENTH.block)], ["slope"], ax=Figure().add_subplot())
    assert axes.get_xlim()[1] > 1e12
    axes = plot_largest([max_sector("1/(s + 1)")], ["sector"], ax=Figure().add_subplot())
    assert axes.get_xticks().tolist() == [0]  # a bar without an end


# Re 1/(s + 1 + exp(-s)/2) > 0: every linear gain is stable, and with dead time k is looked for up to 10^6
@pytest.mark.parametrize("criterion", ["circle", "popov"])
def test_where_nothing_ends_a_criterion_beside_dead_time_k_is_the_largest_tried(criterion):
    found = max_sector("1/(s + 1 + exp(-s)/2)", criterion=criterion)
    assert "in the sector [0, 999999.9999], the largest k tried" in str(found)
    assert not max_sector("exp(-s)/(s + 1)", criterion=criterion).search_limited


def test_an_end_of_a_criterion_is_not():
    for found in (max_sector(SEVENTH.block), max_sector("1/(s^2 + s + 1)"), max_slope(builtin_loop("dt-6").block)):
        assert not found.search_limited
        assert "largest k tried" not in str(found)
    assert max_sector("1/(s^2 + s + 1)").proved_up_to == "inf"


def test_a_long_round_number_is_written_with_an_exponent():
    # 1e8 = 100000000; a long number that is not round, and a short one, stay as they are
    assert [bound_below(value) for value in (1e8, 1.5e9, 1e12, 1e6, 123456789012.0, -1e9)] == [
        "1e8", "1.5e9", "1e12", "1000000", "123456700000", "-1000000000",
    ]  # fmt: skip
