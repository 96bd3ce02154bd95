"""What is said of a named nonlinearity: several solutions, other equilibria, what is only declared of it."""

from fractions import Fraction
from types import SimpleNamespace

import pytest

from lure import (
    DeadZone,
    ExpressionNonlinearity,
    Loop,
    NonlinearityClass,
    PiecewiseLinear,
    RationalPlant,
    Saturation,
    Sector,
    SlopeBounds,
    Tanh,
    as_plant,
)
from lure.analysis.certificates import codes
from lure.analysis.questions import analyse, max_sector, table
from lure.analysis.questions.certify import ProofOptions, certify
from lure.analysis.questions.conclusion import conclusion_of
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Verdict

THIRD = RationalPlant([1], [1, 3, 2, 0])
ODD = NonlinearityClass.slope_restricted(0, 1, odd=True)
PD = as_plant("4*(1 + s/10)/(s*(s + 1))")  # C = 4 (1 + s/10) on 1/(s (s + 1)): one pole at 0


def sector(low, high, **more):
    return NonlinearityClass(sector=Sector(low, high), **more)


def about(block, nonlinearity_class, nonlinearity=None):
    return analyse(Problem.about(block, nonlinearity_class, nonlinearity=nonlinearity))


@pytest.mark.parametrize(
    ("nonlinearity", "dt"),
    [
        pytest.param(
            ExpressionNonlinearity("sigma*(1 + sin(sigma)**2)", sector=Sector(0, 2)), None, marks=pytest.mark.slow
        ),  # 2 + sin^2 + sigma sin(2 sigma)
        # 3 at sigma = 1, 2 at sigma = 2, and beyond it 1.1 sigma: three solutions for 2 < y < 3
        (PiecewiseLinear([(0, 0), (1, 2), (2, 0)], left_slope=0, right_slope="0.1"), 1),
    ],
)
def test_a_law_with_which_the_loop_has_several_solutions_is_not_proved_by_assuming_one(nonlinearity, dt):
    loop = Loop(as_plant("(s + 2)/(s + 1)" if dt is None else "(z + 1)/(z - 0.5)", dt=dt), nonlinearity)
    found = analyse(loop).conclusion
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.code is codes.SEVERAL_SOLUTIONS
    assert "some y have several" in found.sentence
    assert certify(loop).code is codes.SEVERAL_SOLUTIONS


def test_a_piece_on_which_the_loop_equation_has_one_value_is_several_solutions():
    flat = PiecewiseLinear([(0, 0), (1, 2), (2, 1)], left_slope=0, right_slope=0)  # sigma + phi = 3 on all of [1, 2]
    assert certify(Loop(as_plant("(s + 2)/(s + 1)"), flat)).code is codes.SEVERAL_SOLUTIONS


@pytest.mark.slow
def test_a_saturation_vanishes_at_zero_only_so_that_it_attracts_all():
    found = analyse(Loop(PD, Saturation()))
    assert found.conclusion.headline == "Every solution converges to 0 with saturation min(max(sigma, -1), 1)."
    assert found.conclusion.attracts
    assert found.shown.certificate["conclusion"] == "every motion converges to the set of equilibria"
    assert "converges to the set of equilibria for every odd phi with slope in [0, 1]" in found.statement
    assert "with another phi than saturation" in found.not_shown[0]


@pytest.mark.parametrize("nonlinearity", [DeadZone(), None])
def test_other_equilibria_are_not_talked_away(nonlinearity):
    found = about(PD, ODD, nonlinearity)
    assert found.verdict is Verdict.PROVED
    assert not found.conclusion.attracts
    assert found.conclusion.meaning == "Every solution converges to the set of equilibria"
    assert found.not_shown[0].startswith("that 0 attracts every solution: ")


def test_the_zeros_that_count_are_those_of_the_shifted_loop():
    # -1/(s + 1) with phi >= sigma..: at the gain -1 the loop has a pole at 0, and phi(sigma) = -sigma at its equilibria
    block = RationalPlant([1], [1, 1])
    found = about(block, sector(-1, 1), ExpressionNonlinearity("max(-sigma, min(sigma, 1))", sector=Sector(-1, 1)))
    assert found.verdict is Verdict.PROVED
    assert not found.conclusion.attracts  # phi = -sigma for all sigma < 0


def test_with_a_sector_above_the_critical_gain_0_is_the_only_equilibrium():
    # slopes from 0, where the pole is, but phi(sigma) = 0 at 0 alone for a sector from 1/2
    slopes, rows = SlopeBounds(0, 2), [SimpleNamespace(critical=True)]
    for low, only in ((Fraction(1, 2), True), (Fraction(0), False)):
        asked = NonlinearityClass(sector=Sector(low, 2), slope=slopes)
        found = certify(THIRD, asked, ways=ProofOptions(criterion="park")).conclusion
        says = "converges to 0 for every phi" if only else "converges to the set of equilibria for every phi"
        assert found.sentence.startswith(f"Every solution {says} with slope in [0, 2]")
        assert found.attracts is only
        assert table._not_shown(THIRD, rows, found)[0].startswith("that 0 attracts") is not only


@pytest.mark.slow
def test_a_class_whose_slopes_are_not_its_sector_is_proved_by_the_analysis_as_by_itself():
    # 1/(z^2 - z): Jury and Lee's criterion needs no lower bound of the slope, and reaches the linear limit 1
    block = RationalPlant([1], [1, -1, 0], dt=1)
    steep = NonlinearityClass(sector=Sector(0, Fraction("0.9")), slope=SlopeBounds(-5, Fraction("0.9")))
    assert certify(block, steep).verdict is Verdict.PROVED
    assert analyse(Problem.about(block, steep)).conclusion.shown.theorem == "jury-lee"


@pytest.mark.slow
def test_what_is_only_declared_is_said_to_be_so():
    nonlinearity = ExpressionNonlinearity("sigma*(1 + sin(sigma)**2)", sector=Sector(0, 2))
    found = analyse(Loop(RationalPlant([1], [1, 1]), nonlinearity)).conclusion
    assert found.membership in ("declared", "checked")
    assert ("if phi lies in the sector you declare" in found.headline) == (found.membership == "declared")
    assert analyse(Loop(RationalPlant([1], [1, 1]), Tanh())).conclusion.membership == "checked"


def test_a_law_outside_the_class_is_not_proved_by_it():
    inquiry = Problem.about(THIRD, sector(0, 5), nonlinearity=Saturation(gain=7))
    found = conclusion_of(inquiry, max_sector(THIRD).proof)
    assert (found.verdict, found.code) == (Verdict.INCONCLUSIVE, codes.OUTSIDE_CLASS)
    assert "is none of them" in found.reason
