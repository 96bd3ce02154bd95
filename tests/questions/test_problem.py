"""A problem is plain data: one text and one digest for one question, and every view gives the answer of the problem."""

import hashlib
import json
import pickle
from dataclasses import replace
from fractions import Fraction as F

import control
import numpy as np
import pytest

from lure.analysis import certify, max_sector, max_slope
from lure.analysis.questions import Problem, answer
from lure.analysis.questions.problem import posed
from lure.analysis.verdict import Verdict
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.loop import Loop
from lure.nonlinearities import Saturation
from lure.plants import as_plant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

THIRD = RationalPlant([1], [1, 3, 2, 0])
SAMPLES = FrequencyData([0.1, 1.0, 10.0], [1 - 0.1j, 0.5 - 0.5j, 0.01 - 0.1j])
MATRICES = StateSpace(np.array([[-1.0, 1.0], [0.0, -2.0]]), np.array([0.0, 1.0]), np.array([1.0, 0.0]), 0.0)


def sector_of(plant, lower=0, **options):
    return Problem.largest(as_plant(plant), "sector", lower=F(lower), **options)


PROBLEMS = [
    sector_of(THIRD),
    sector_of("exp(-s)/(s+1)"),
    sector_of(SAMPLES),
    sector_of(MATRICES),
    Problem.largest(THIRD, "slope", lower=F(1, 3), odd=True),
    Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 5)), nonlinearity=Saturation(gain=2)),
]


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: type(problem.plant).__name__)
def test_a_problem_survives_a_pickle(problem):
    again = pickle.loads(pickle.dumps(problem))
    assert again == problem
    assert (hash(again), again.digest) == (hash(problem), problem.digest)


def test_all_these_problems_differ():
    assert len(set(PROBLEMS)) == len({problem.digest for problem in PROBLEMS}) == len(PROBLEMS)


# 1/(s (s+1) (s+2)) in three forms: the same question, so the same text
@pytest.mark.parametrize("plant", ["1/(s*(s+1)*(s+2))", ([1], [1, 3, 2, 0]), control.tf([1], [1, 3, 2, 0])])
def test_the_text_does_not_depend_on_how_the_plant_was_given(plant):
    assert sector_of(plant).text == sector_of(THIRD).text


def test_the_digest_is_sha256_of_the_text_which_is_json():
    problem = sector_of(THIRD)
    whole = json.loads(problem.text)
    assert whole["plant"]["denominator"] == ["1", "3", "2", "0"]
    assert whole["classes"] == [
        {"sector": ["0", "finite"], "slope": None, "odd": False, "time_varying": False, "linear": False}
    ]
    assert problem.digest == hashlib.sha256(problem.text.encode()).hexdigest()


@pytest.mark.parametrize(
    "other",
    [
        sector_of(THIRD, lower=F(1, 10**30)),
        sector_of(THIRD, time_varying=True),
        sector_of(THIRD, criterion="circle"),
        sector_of(THIRD, search="linear"),
        sector_of(RationalPlant([1], [1, 3, 2, 0], dt=1)),
        sector_of(RationalPlant([1], [1, 3, 2, F(1, 10**30)])),
        Problem.largest(THIRD, "slope", lower=F(0)),
        replace(sector_of(THIRD), finite=False),
    ],
)
def test_another_question_has_another_digest(other):
    assert other != sector_of(THIRD)
    assert other.digest != sector_of(THIRD).digest


def test_the_views_give_the_answer_of_the_problem():
    problem = sector_of(THIRD, search="linear")
    assert answer(problem).to_dict() == max_sector(THIRD).to_dict()
    slope = Problem.largest(THIRD, "slope", lower=F(0), odd=True, search="linear")
    assert answer(slope).to_dict() == max_slope(THIRD, odd=True, search="linear").to_dict()
    about = posed(THIRD, NonlinearityClass(sector=Sector(0, 5)), criterion="best", finite=False)
    assert answer(about).to_dict() == certify(THIRD, Sector(0, 5)).to_dict()


def test_what_a_diagonal_refuses():
    narrow, wide = NonlinearityClass(sector=Sector(0, 1)), NonlinearityClass(sector=Sector(0, 2))
    assert str(Diagonal((narrow, wide))) == "phi_1 in the sector [0, 1]; phi_2 in the sector [0, 2]"
    assert Diagonal((narrow, narrow), repeated=True).repeated
    mixed = Diagonal((wide, narrow, narrow), repeated=(1, 2))
    assert str(mixed) == "phi_1 in the sector [0, 2]; phi_2 = phi_3 in the sector [0, 1]"
    assert mixed.blocks == (range(1), range(1, 3))
    assert Diagonal((narrow,) * 3, repeated=(1, 1, 1)) == Diagonal((narrow,) * 3)
    assert Diagonal((narrow,) * 3, repeated=(3,)) == Diagonal((narrow,) * 3, repeated=True)
    with pytest.raises(InputError, match="add up"):
        Diagonal((narrow,) * 3, repeated=(1, 1))
    with pytest.raises(InputError, match="its classes differ: channel 1"):
        Diagonal((narrow, wide, wide), repeated=(2, 1))
    with pytest.raises(InputError, match="one for each channel"):
        Diagonal(())
    with pytest.raises(InputError, match="its classes differ"):
        Diagonal((narrow, wide), repeated=True)
    with pytest.raises(InputError, match=r"^Diagonal\.classes\[1\] is SlopeBounds\(.*; give NonlinearityClass\("):
        Diagonal((narrow, SlopeBounds(0, 1)))  # was taken, and a question about it ended with an AttributeError


# The lower end of a slope question is that of the slope: the sector may lie inside.
def test_the_lower_end_is_that_of_the_narrowest_statement_of_the_class():
    tight = NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(-1, 2))
    assert Problem.about(THIRD, tight).lower == -1
    assert Problem.about(THIRD, NonlinearityClass(sector=Sector(F(1, 2), 1))).lower == F(1, 2)


# Constant gains alone are asked about: the saturation plays no part, and s^2 + 3 s + 2 + g is stable for g >= 0.
def test_a_question_about_constant_gains_leaves_the_nonlinearity_out():
    about = posed(Loop(RationalPlant([1], [1, 3, 2]), Saturation(gain=5)), None, criterion="hurwitz", finite=False)
    assert about.linear
    assert answer(about).verdict is Verdict.PROVED
    assert (about.nonlinearity, about.nonlinearity_entry) == (None, None)
