"""The first screen of the report on a loop: verdict, diagram and bar, with one rounding of one number."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from sketches import sketches

from lure import DeadZone, Saturation, Sector, Tanh
from lure.analysis.plots.loops import plot_largest
from lure.analysis.report.diagram import block_diagram, class_graph, fits, nonlinearity_graph, raised
from lure.analysis.report.loop import build_loop_report, write_loop_report
from lure.analysis.report.loop.observed import _sentence
from lure.analysis.report.loop.write import bar, criteria
from lure.classes import NonlinearityClass
from lure.files import parse_system
from lure.rod import NormalCompliance

# C = 0.8 (1 + 1/(0.5 s)), P = 10/(s (0.1 s + 1)(0.02 s + 1)): a double pole at 0, so that phi = 0 refutes every class
PI_SERVO = """
[plant]
transfer = "0.8*(1+1/(0.5*s))*10/(s*(0.1*s+1)*(0.02*s+1))"
[nonlinearity]
kind = "saturation"
gain = 1
limit = 1
"""


# 1/(s^3 + 3 s^2 + 19/10 s) with the gain g: Routh's array is positive for 0 < g < 3 * 19/10 = 57/10
LAG = """
[plant]
num = [1]
den = [1, 3, "19/10", 0]
[nonlinearity]
kind = "saturation"
gain = 6
limit = 1
"""


@pytest.fixture(scope="module")
def lag():
    return build_loop_report(parse_system(LAG, name="lag", source="a file"))


@pytest.fixture(scope="module")
def lag_page(lag, tmp_path_factory):
    with sketches():
        return write_loop_report(lag, tmp_path_factory.mktemp("lag")).read_text("utf-8")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    servo = build_loop_report(parse_system(PI_SERVO, name="pi-servo", source="a file"))
    with sketches():
        return write_loop_report(servo, tmp_path_factory.mktemp("servo")).read_text("utf-8")


def words(text):
    """What a reader sees of a page, figures aside."""
    return " ".join(re.sub(r"<[^>]+>", " ", re.sub(r"<(style|defs)\b.*?</\1>", "", text, flags=re.DOTALL)).split())


@pytest.mark.slow
def test_the_first_screen_has_the_verdict_the_diagram_and_the_bar(page):
    first = page[page.index("<header>") : page.index("</header>")]
    assert first.index('class="badge REFUTED"') < first.index("<h1")
    assert '<svg class="diagram"' in first
    assert "4000 s + 8000" in first
    assert "s⁴ + 60 s³ + 500 s²" in first
    assert re.findall(r'<span class="(\w+)" style="width:', first) == ["refuted"]


def test_a_reason_is_said_once_and_first(page):
    seen = words(page)
    assert seen.count("has multiplicity 2") == 1
    assert seen.index("has multiplicity 2") < seen.index("How far, for which classes")
    assert seen.count("nothing proved") == 1  # five criteria, one reason, one entry


# a criterion that a closed gap makes needless in some classes, and that has its say in another, is listed once
def test_a_criterion_that_some_classes_do_not_need_is_not_said_to_prove_nothing():
    def said(criterion, theorem, high, reason=""):
        proved = {"theorem": theorem} if high else {"theorem": theorem, "reason": reason}
        verdict = "PROVED" if high else "INCONCLUSIVE"
        return {
            "reason": "",
            "criterion": criterion,
            "needs": [],
            "verdict": verdict,
            "largest": [high, high],
            **proved,
        }

    first = [said("popov", "Popov", 5.0), *(said(name, "not needed", 0.0, "they meet") for name in ("circle", "park"))]
    varying = [said("circle", "Sandberg", 4.0), said("park", "does not apply", 0.0, "phi depends on time")]
    listed = criteria({"answers": [{"odd": False, "answers": answers} for answers in (first, varying, first)]})
    assert [(one["names"], one["theorem"]) for one in listed] == [
        (["popov"], "Popov"),
        (["circle"], "Sandberg"),
        (["park"], "does not apply"),
    ]


# a headline by diagonal-popov above "diagonal-popov: nothing proved" contradicted itself: only the factor was no larger
def test_a_criterion_that_proves_no_larger_factor_is_not_said_to_prove_nothing():
    told = {"odd": False, "needs": [], "verdict": "INCONCLUSIVE", "largest": [0.0, 0.0], "theorem": ""}
    reasons = {
        "diagonal-popov": "no multiplier was found that proves more than the factor 9, which is proved",
        "full-block-popov": "no multiplier was found",
    }
    answers = [{**told, "criterion": name, "reason": reason} for name, reason in reasons.items()]
    listed = criteria({"answers": [{"odd": False, "answers": answers}]})
    assert [one["unproved"] for one in listed] == ["nothing more proved", "nothing proved"]


@pytest.mark.slow
def test_one_number_is_rounded_once_on_the_whole_page(lag, lag_page):
    seen = words(re.sub(r"<details.*?</details>", "", lag_page, flags=re.DOTALL))  # where a criterion gives its bracket
    assert seen.count("5.7 ") >= 4  # the bar and three rows; the double 5.7 is above 57/10, and that does not show
    assert not re.findall(r"5\.70\d+", seen)
    rows = lag.to_dict()["answers"]
    assert {row["refuted_text"] for row in rows if not row["time_varying"]} == {"5.7"}


@pytest.mark.slow
def test_the_chart_says_the_same_numbers(lag):
    from matplotlib import pyplot

    texts = [text.get_text() for text in plot_largest(lag.analysis.rows, ["a class"] * 4).texts]
    pyplot.close("all")
    assert sum(text.endswith("refuted at 5.7") for text in texts) == 3


SERVO = PI_SERVO.replace("0.8*(1+1/(0.5*s))", "(1+0.1*s)")


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(
    ("text", "first"),
    [
        # the nonlinearity is checked to belong to the class proved: it stands first, and what is proved of it
        (SERVO, ["Your nonlinearity: saturation", "PROVED", "Every solution converges to 0"]),
        # the class is refuted, which says nothing of the nonlinearity: the class first, then what was observed of the
        # nonlinearity
        (PI_SERVO, ["REFUTED", "Some odd φ with slope in [0, 1] ", "Certified. What the loop does with",
                    "Your nonlinearity, saturation", "observed, no proof"]),
        # without a nonlinearity: the class
        (SERVO.partition("[nonlinearity]")[0] + "[class]\nsector=[0,1]\n", ["PROVED", "Every solution converges"]),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("sketched")
def test_the_page_begins_with_what_was_decided_about_the_nonlinearity_given(text, first, tmp_path):
    report = build_loop_report(parse_system(text, name="servo", source="a file"))
    seen = words(write_loop_report(report, tmp_path).read_text("utf-8").partition("<header>")[2])
    places = [seen.index(each) for each in first]
    assert places == sorted(places)
    assert ("Your nonlinearity" in seen) is (report.analysis.problem.nonlinearity is not None)
    assert "by certified" not in seen.lower()


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(
    ("each", "whose"),
    [
        ("[[class]]\nsector = [0, 1]\n", "Some members of the classes"),  # drawn by the report, not given
        ('[[nonlinearity]]\nkind = "saturation"\ngain = 1\nlimit = 1\n', "Your nonlinearities"),
    ],
)
def test_what_is_simulated_in_several_channels_is_yours_only_if_you_gave_it(each, whose, tmp_path):
    text = '[plant]\ntransfer = [["1/(s+1)", "0"], ["0", "1/(s+2)"]]\n' + 2 * each
    report = build_loop_report(parse_system(text, name="two", source="a file"))
    seen = words(write_loop_report(report, tmp_path).read_text("utf-8"))
    assert re.findall("(Your nonlinearities|Some members of the classes): observed, no proof", seen) == [whose]


def test_a_law_that_no_run_could_follow_is_not_said_to_be_simulated(lag):
    (run, *_) = lag.trajectories
    assert "simulated solutions over up to" in _sentence((run,))
    assert _sentence((replace(run, until=0.0),)).startswith("the nonlinearity was not simulated: ")


def row(proved=None, refuted=None, *, lower=0.0, verdict=None, closed=False):
    found = verdict or ("INCONCLUSIVE" if proved is None else "PROVED")
    low = lower if proved is None else proved
    gap = "closed" if closed else "open"
    return {"lower": lower, "verdict": found, "largest": [low, "inf"], "refuted_at": refuted, "gap": gap}


# linear up to 5/4 of the largest number: 2 of 5 proved, 4 of 5 not refuted, asked at 1 of 5
def test_the_pieces_of_a_bar_are_in_proportion():
    made = bar("a class", "answers.0", row(2.0, 4.0), 1.0)
    assert made.pieces == (("proved", 40.0), ("open", 40.0), ("refuted", 20.0))
    assert (made.asked, made.logarithmic) == (20.0, False)


@pytest.mark.parametrize(
    ("given", "kinds"),
    [
        (row("inf"), ["proved"]),
        (row(None, 0.0, verdict="REFUTED"), ["refuted"]),
        (row(None), ["open"]),
        (row(1e-3, 40.0), ["proved", "open", "refuted"]),
        (row(3.0, 3.000001, closed=True), ["proved", "refuted"]),
        (row(0.75, 2.0, lower=0.5), ["proved", "open", "refuted"]),
    ],
)
@pytest.mark.parametrize("asked", [None, 1.0, float("inf")])
def test_a_bar_is_full_and_what_is_not_decided_is_open(given, kinds, asked):
    made = bar("a class", "answers.0", given, asked)
    assert [kind for kind, _ in made.pieces] == kinds
    assert sum(width for _, width in made.pieces) == pytest.approx(100.0)
    assert all(width > 0 for _, width in made.pieces)
    assert (made.asked is None) == (asked is None)
    assert made.asked is None or 0 <= made.asked <= 100


def test_the_diagram_shows_the_formula_where_it_can_be_read():
    short, long = "(s + 1) / (s^12 + 0.5 s^2)", f"1 / ({' + '.join(f'0.123456 s^{i}' for i in range(20, 1, -1))})"
    assert fits(short)
    assert not fits(long)
    assert raised(short) == "(s + 1) / (s¹² + 0.5 s²)"
    made = block_diagram(short, "<b>", class_graph(None))
    assert ">s + 1</text>" in made
    assert ">s¹² + 0.5 s²</text>" in made
    assert "<b>" not in made
    assert "0.123456" not in re.sub(r'aria-label="[^"]*"', "", block_diagram(long, "phi", class_graph(None)))


# a stretch on which the nonlinearity is seen to bend: twice the farthest kink, or of the size at which tanh(sigma/0.01)
# bends
@pytest.mark.parametrize(
    ("nonlinearity", "low", "high"),
    [
        (Saturation(gain=1, limit=1), 2.0, 2.0),
        (DeadZone(width=3), 6.0, 6.0),
        (Tanh(scale=Fraction(1, 100), gain=1), 0.01, 0.1),
        (NormalCompliance(stiffness=4), 1.0, 1.0),
        (NormalCompliance(stiffness=4, exponent=2), 1.0, 1.0),
    ],
)
def test_the_graph_of_a_law_covers_its_bends(nonlinearity, low, high):
    made = nonlinearity_graph(nonlinearity)
    (reach,) = re.findall(r'x="274"[^>]*>([^<]+)<', made)
    assert low <= float(reach) <= high
    points = np.array([float(number) for number in re.findall(r"[-\d.]+", re.findall(r'graph" d="([^"]+)', made)[0])])
    assert points.size == 322
    assert (points[::2] >= 172).all()
    assert (points[1::2] <= 188).all()


@pytest.mark.parametrize("ends", [(0, 2), (Fraction(1, 2), 3), (-1, 2), (-3, 1), (0, float("inf")), (2, float("inf"))])
def test_the_wedge_of_a_sector_stays_in_its_box(ends):
    made = class_graph(NonlinearityClass(sector=Sector(*ends)))
    points = [float(x) for path in re.findall(r'wedge" d="M([^z]+)z', made) for x in re.split("[L ]", path)]
    assert len(points) >= 12
    assert all(172 <= x <= 268 for x in points[::2])
    assert all(128 <= y <= 188 for y in points[1::2])
