"""Popov and Nyquist responses: what is drawn is what is asked about, and a drawing never says that it proves."""

import json
import math
import re
from fractions import Fraction

import control
import numpy as np
import pytest
from depth import rarely
from hypothesis import given
from hypothesis import strategies as st

from lure import Loop, Saturation, as_plant
from lure.analysis import Verdict, nyquist_response, popov_response
from lure.analysis.graphical.supporting_proof import searched_theta
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.files.builtin import builtin_loops
from lure.rod import RodPlant, upwind
from lure.rod.systems import paper_rod

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

THIRD = "1/(s*(s+1)*(s+2))"
UNSTABLE = "12/((s-1)*(s+3))"
BLUE = "#0072b2"
LOOPS = builtin_loops()
LARGE = (-np.diag(np.arange(1.0, 81.0)), np.ones(80), np.ones(80) - 1.5)


# H = 1/(s(s+1)(s+2)), u = omega^2: Re H = -3/((u+1)(u+4)), omega Im H = (u-2)/((u+1)(u+4)), so that with theta = 3/2
# the expression is 1/k - 1.5 u/((u+1)(u+4)), least at u = 2 and equal to 1/k - 1/6 there
@pytest.mark.parametrize(("k", "verdict"), [(5, Verdict.PROVED), (7, Verdict.INCONCLUSIVE)])
def test_the_least_distance_seen_is_that_of_the_formula_and_the_verdict_is_the_criterions(k, verdict):
    response = popov_response(THIRD, k=k, theta=1.5)
    u = response.omega**2
    assert response.expression == pytest.approx(1 / k - 1.5 * u / ((u + 1) * (u + 4)), abs=1e-14)
    assert response.margin_seen == pytest.approx(1 / k - 1 / 6, abs=1e-5)
    assert response.margin_seen >= 1 / k - 1 / 6 - 1e-14
    assert response.omega[response.worst] == pytest.approx(math.sqrt(2), rel=0.01)
    assert response.answer.verdict is verdict
    assert response.evidence is Evidence.OBSERVED


def test_without_k_the_line_is_that_of_the_largest_sector_proved():
    response = popov_response(THIRD)
    assert response.k == response.found.largest.low
    assert response.theta == response.found.theta == pytest.approx(1.5, rel=1e-6)
    assert 0 <= response.margin_seen < 1e-4
    assert "The drawing proves nothing; what does: Every solution converges" in str(response)
    assert "(popov, certified)" in str(response)


def test_a_line_that_is_crossed_refutes_nothing_and_says_so():
    said = str(popov_response(THIRD, k=7))
    assert "on the wrong side of the line through -0.142857" in said
    assert "proves nothing; nor does anything here" in said
    assert "from which nothing follows for the loop" in said


def test_without_theta_one_is_searched_that_the_criterion_accepts():
    for k in (1, 4, 5.99):
        response = popov_response(THIRD, k=k)
        assert response.answer.verdict is Verdict.PROVED
        assert response.margin_seen > 0


def test_theta_alone_gets_the_largest_k_for_it():
    # 1/(s+1)^3 and theta = 0 is the circle criterion: inf Re H = inf (1 - 3u)/(1+u)^3 = -1/4 at u = 1
    response = popov_response("1/(s+1)^3", theta=0)
    assert response.k == pytest.approx(4, rel=1e-8)
    assert response.answer.verdict is Verdict.PROVED


@pytest.mark.slow
def test_with_dead_time_the_multiplier_of_the_largest_sector_serves_the_smaller_ones():
    largest, smaller, larger = (popov_response("exp(-s)/(s+1)", k=k) for k in (None, 1, 3))
    assert smaller.theta == largest.theta
    assert smaller.found.verdict is Verdict.PROVED
    assert smaller.margin_seen > largest.margin_seen >= 0
    assert larger.margin_seen < 0  # beyond the gain 2.26 of the linear loop
    assert "this line was not decided" in str(larger)


@pytest.mark.parametrize("make", [control.tf, lambda n, d: control.tf2ss(control.tf(n, d))], ids=["tf", "ss"])
def test_systems_of_python_control_give_the_same_curve_and_go_back_as_data(make):
    omega = np.geomspace(0.1, 10, 50)
    response = popov_response(make([1], [1, 3, 3, 1]), omega=omega)
    assert response.values == pytest.approx(1 / (1j * omega + 1) ** 3, rel=1e-12)
    data = response.to_control()
    assert isinstance(data, control.FrequencyResponseData)
    assert data.frdata[0, 0] == pytest.approx(response.values)
    again = popov_response(data)  # measured now: nothing is proved any more
    assert again.found.verdict is Verdict.INCONCLUSIVE
    assert "fit a model to certify a sector" in str(again)


@pytest.mark.slow
def test_large_matrices_are_drawn_with_the_line_that_matrices_certify():
    response = popov_response(LARGE)
    assert response.k == response.found.largest.low
    assert response.margin_seen == pytest.approx(0, abs=1e-3)
    assert "popov, certified" in str(response)
    # Re H is least at omega -> 0: H(0) = -0.5 sum 1/j
    seen = nyquist_response(LARGE)
    assert seen.k == pytest.approx(2 / sum(1 / j for j in range(1, 81)), rel=1e-3)
    assert seen.found.verdict is Verdict.PROVED


def test_the_rod_and_its_scheme_are_told_apart():
    rod, scheme = popov_response(RodPlant(paper_rod())), popov_response(upwind(paper_rod(), 10))
    assert scheme.found.verdict is Verdict.PROVED
    assert "the scheme with 10 cells" in str(scheme)
    assert rod.found.verdict is Verdict.PROVED
    assert "motion of the rod of finite energy comes to rest" in str(rod)


def test_a_loop_stands_for_its_block():
    assert popov_response(Loop(as_plant(THIRD), Saturation()), k=5).block == as_plant(THIRD)
    assert nyquist_response(LOOPS["third-order"], k=1).block == LOOPS["third-order"].block


def test_discrete_time_has_no_popov_plot_and_the_refusal_names_the_call_that_is_right():
    with pytest.raises(AssumptionError, match=r"nyquist_response\(system\).*tsypkin"):
        popov_response(control.tf([1], [1, -0.5], 0.1))


# H = 1/(z - 1/2) on the circle: Re H is least at z = -1, where H = -2/3
def test_in_discrete_time_the_curve_ends_at_the_nyquist_frequency():
    response = nyquist_response(control.tf([1], [1, -0.5], 0.1))
    assert response.omega[-1] == pytest.approx(math.pi / 0.1)
    assert response.values[-1] == pytest.approx(-2 / 3)
    assert response.k == pytest.approx(1.5, rel=1e-8)
    assert response.to_control().dt == pytest.approx(0.1)
    theirs = control.frequency_response(control.tf([1], [1, -0.5], 0.1), response.omega)
    assert response.values == pytest.approx(theirs.frdata[0, 0], rel=1e-9)


# the disc of [1/2, 1] is [-2, -1], and H(0) = -4 is 2 away from it; that of [-1/2, 1] is [-1, 2], and 1 is 1 inside it
def test_distances_from_a_disc_outside_and_inside():
    outside = nyquist_response(UNSTABLE, lower=0.5, k=1)
    assert outside.disc == (-2, -1)
    assert outside.distance[0] == pytest.approx(2, abs=1e-3)
    assert outside.answer.verdict is Verdict.PROVED
    inside = nyquist_response("1/(s^2+s+1)", lower=-0.5, k=1)
    assert inside.disc == (-1, 2)
    assert inside.distance[0] == pytest.approx(1, abs=1e-3)
    assert inside.answer.verdict is Verdict.PROVED


@given(
    lower=st.fractions(-5, 5, max_denominator=20),
    width=st.fractions("1/20", 8, max_denominator=20),
    endless=st.booleans(),
)
def test_a_point_is_at_a_positive_distance_exactly_where_the_circle_inequality_holds(lower, width, endless):
    k = math.inf if endless else lower + width
    response = nyquist_response("2/(s^2+s+1)", lower=lower, k=k, omega=np.geomspace(0.1, 10, 60))
    h = response.values
    bracket = (h if endless else 1 + float(k) * h) * np.conj(1 + float(lower) * h)
    clear = np.abs(bracket.real) > 1e-9
    assert ((response.distance > 0) == (bracket.real > 0))[clear].all()


def test_encirclements_cannot_be_seen_and_are_not_claimed():
    # no stable gain in [2, 3] for 1/(s - 10), although its curve stays far from the disc on [-1/2, -1/3]
    response = nyquist_response("1/(s-10)", lower=2, k=3)
    assert response.margin_seen > 0
    assert response.answer is None or response.answer.verdict is not Verdict.PROVED
    assert "nor does anything here" in str(response)


def test_where_nothing_is_reached_there_is_no_line_to_draw():
    for response in (popov_response(UNSTABLE), nyquist_response(UNSTABLE), popov_response("1/s^2")):
        assert response.k is None
        assert response.margin_seen is None
        assert "A drawing proves nothing" in str(response)
        response.plot(ax=figure_axes())
        json.dumps(response.to_dict(), allow_nan=False)


def test_a_pole_among_the_measured_frequencies_is_left_out():
    # 1/s at omega = 0, 1, 2
    data = control.frd([complex(math.inf, 0), -1j, -0.5j], [0, 1, 2])
    for call in (popov_response, nyquist_response):
        assert call(data).omega.tolist() == [1, 2]
    with pytest.raises(InputError, match="none of them is finite"):
        nyquist_response(control.frd([complex(math.inf, 0)], [1]))


def test_a_block_that_no_criterion_covers_is_drawn_all_the_same():
    for keywords in ({}, {"k": 2}, {"k": 2, "theta": 1}):
        response = popov_response("exp(-s)/(s-1)", **keywords)
        assert "begin where the plant is stable" in str(response)
        assert response.found.verdict is not Verdict.PROVED
        response.plot(ax=figure_axes())


# the curve of kalman-fitts comes back to 0 just right of the boundary, above the axis
@pytest.mark.parametrize(("response", "k"), [(popov_response, "0.0658571"), (nyquist_response, "0.0591693")])
def test_the_name_of_the_boundary_is_on_its_forbidden_side_in_no_colour_of_a_verdict(response, k):
    axes = response(LOOPS["kalman-fitts"].block, k=Fraction(k)).plot(ax=figure_axes())
    (name,) = (text for text in axes.texts if text.get_text() == "−1/k")
    assert (name.get_ha(), name.xyann[0] < 0) == ("right", True)
    assert "#d55e00" not in {matplotlib.colors.to_hex(one.get_color()) for one in (name, *axes.get_lines())}


@given(
    x=st.lists(st.floats(-3, 3), min_size=3, max_size=12),
    y=st.lists(st.floats(-3, 3), min_size=12, max_size=12),
    k=st.sampled_from([0.2, 1.0, 5.0]),
)
def test_the_line_searched_has_half_of_the_best_room(x, y, k):
    x, y = np.array(x), np.array(y)[: len(x)]

    def room(theta):
        return float(np.min(1 / k + x - theta * y))

    found = room(searched_theta(x, y, k))
    best = max(room(theta) for theta in np.linspace(-20, 20, 801))
    assert found >= min(0.5 * min(best, 1 / k), best) - 1e-9 if best > 0 else found >= best - 1e-6


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"k": 0}, "k is 0; give the upper end of a sector"),
        ({"k": "5"}, "k is '5'; give a number"),
        ({"theta": math.inf}, "theta is inf; give a finite number"),
        ({"omega": [1.0]}, "omega must be at least two positive, increasing frequencies"),
        ({"omega": [2.0, 1.0]}, "omega must be at least two"),
        ({"omega": "fast"}, "omega is no list of numbers"),
    ],
)
def test_numbers_that_are_no_good_are_refused_in_one_sentence(keywords, message):
    with pytest.raises(InputError, match=re.escape(message)):
        popov_response(THIRD, **keywords)


def test_frequencies_above_the_nyquist_frequency_and_beside_a_measurement_are_refused():
    with pytest.raises(InputError, match=r"up to pi/dt = 3.14"):
        nyquist_response(control.tf([1], [1, -0.5], 1), omega=[1, 4])
    with pytest.raises(InputError, match="their own frequencies; leave omega out"):
        nyquist_response(control.frd([1, 1j], [1, 2]), omega=[1, 2])


def figure_axes():
    from matplotlib.figure import Figure

    return Figure(figsize=(5.4, 3.8), layout="constrained").add_subplot()


def covered(axes):
    """Points of the curve under the legend."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(axes.figure).draw()
    box, count = axes.get_legend().get_window_extent(), 0
    for line in axes.lines:
        if line.get_color() == BLUE:
            points = axes.transData.transform(np.column_stack(line.get_data()))
            count += int(sum(box.contains(*point) for point in points if np.isfinite(point).all()))
    return count


@pytest.mark.slow_for("third-order", "kalman-fitts")
@pytest.mark.slow_for("unstable-lag", "dt-6")
@pytest.mark.parametrize(
    "name",
    rarely(
        ["third-order", "ct-1", "ct-5", "biproper", "kalman-fitts", "unstable-lag", "dt-6"], "ct-1", "ct-5", "biproper"
    ),
)
def test_the_legend_does_not_cover_the_curve_and_only_the_given_axes_are_drawn_on(name):
    from matplotlib import pyplot

    calls = [nyquist_response] if LOOPS[name].block.dt is not None else [popov_response, nyquist_response]
    for call in calls:
        axes = figure_axes()
        assert call(LOOPS[name]).plot(ax=axes) is axes
        assert covered(axes) == 0
    assert pyplot.get_fignums() == []


def test_the_title_never_names_a_larger_sector_than_the_proof():
    title = popov_response(THIRD).plot(ax=figure_axes()).get_title()
    assert title.startswith("sector [0, 5.999999]")


@pytest.mark.parametrize("k", [1.2, 0.3, 2.3])  # doubles just below what they are written as
def test_the_title_names_the_sector_asked_about(k):
    assert nyquist_response("1/(s + 1)", k=k).plot(ax=figure_axes()).get_title() == f"sector [0, {k}]"


# 1/(s - 1) with k = 1/2: the curve keeps off the line, and every gain below 1 leaves the pole on the right
@pytest.mark.slow_for("exp(-s)/(s*(s+1)) + 1/(s+1)-0.1-said5")
@pytest.mark.parametrize(
    ("block", "k", "said"),
    [
        ("1/(s-1)", 0.5, ["the plant is not stable: this picture shows nothing"]),
        ("1/s^2", 0.5, ["the plant is not stable: this picture shows nothing"]),
        ("1/(s*(s+1))", 0.5, []),
        ("exp(-s)/(s-1)", 0.1, ["the plant is not stable: this picture shows nothing"]),
        ("-exp(-s)/s^2", 0.1, ["the plant is not stable: this picture shows nothing"]),
        ("exp(-s)/(s*(s+1)) + 1/(s+1)", 0.1, []),
        ("1/(s+2+exp(-s))", 0.1, []),
    ],
)
def test_the_title_says_where_the_picture_shows_nothing(block, k, said):
    for response in (popov_response(block, k=k), nyquist_response(block, k=k)):
        assert response.plot(ax=figure_axes()).get_title().split("\n")[1:] == said
    if not said:
        return
    shifted = nyquist_response("1/(s-1)", lower=0.5, k=2).plot(ax=figure_axes()).get_title()
    assert shifted.endswith("\nthe loop with the gain 0.5 is not stable: this picture shows nothing")
    assert "\n" not in nyquist_response("1/(s-1)", lower=1.5, k=2).plot(ax=figure_axes()).get_title()


@pytest.mark.slow
def test_a_page_has_its_own_figure_its_evidence_and_what_proves_it():
    first, second = popov_response(THIRD)._repr_html_(), popov_response(THIRD, k=5)._repr_html_()
    for page in (first, second):
        assert page.count("<svg") == page.count("</svg>") == 1
        assert "<b>OBSERVED</b> Popov plot" in page
        assert "A drawing proves nothing between and beyond its points" in page
        assert "<script" not in page
    clips = [set(re.findall(r'id="([pm][0-9a-f]{10})"', page)) for page in (first, second)]
    assert min(map(len, clips)) > 0
    assert not clips[0] & clips[1]  # two figures on one page do not share their clip paths
    assert popov_response(THIRD)._repr_html_() == first


@pytest.mark.slow
def test_the_numbers_go_to_json_and_to_xarray():
    pytest.importorskip("xarray")
    for response in (popov_response(THIRD), nyquist_response(LARGE), popov_response("1/(s*(s+1))")):
        data = json.loads(json.dumps(response.to_dict(), allow_nan=False))
        assert data["evidence"] == "observed"
        assert len(data["omega"]) == len(data["real"]) == response.omega.size
        dataset = response.to_xarray()
        assert dataset.omega.attrs["units"] == "rad/s"
        assert dataset["real"].to_numpy() == pytest.approx(response.values.real)
        assert "proves nothing" in dataset.attrs["comment"]


def test_a_drawing_is_no_truth_value():
    for response in (popov_response(THIRD), nyquist_response(THIRD)):
        with pytest.raises(TypeError, match="a drawing proves nothing"):
            bool(response)


def test_a_sector_is_never_shown_larger_than_it_is():
    # phi = 6 sigma destabilises 1/(s(s+1)(s+2)), phi = sigma leaves 1/(s-1) with a pole at 0: 6 and 1 are not proved
    tiny = Fraction(1, 10**20)
    popov = popov_response("1/(s*(s+1)*(s+2))", k=6 - tiny)
    assert popov.answer.verdict is Verdict.PROVED
    assert popov.k < 6
    assert "[0, 6]" not in str(popov)
    assert "the sector [0, 5.99" in str(popov)
    for nyquist in (nyquist_response("1/(s-1)", lower=1 + tiny, k=2), nyquist_response("1/(s-1)", lower=1 + tiny)):
        assert nyquist.lower > 1
        assert "[1, " not in str(nyquist)
        assert "what does: " in str(nyquist)


def test_the_curve_of_a_slow_block_is_drawn_where_it_bends():
    slow = popov_response("1/(1e30*s+1)**3")
    assert slow.omega[0] < 1e-30 < slow.omega[-1]
    assert slow.values.real.min() < -0.1
