"""The channels of a larger plant, by the names of its inputs and outputs."""

from fractions import Fraction

import control
import numpy as np
import pytest

from lure import InputError, Sector, as_plant, certify, lft, max_sector
from lure.analysis.verdict import Verdict
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant

# x1' = -x1 + u + d, x2' = x1 - 2 x2 + v; y1 = x1, y2 = x2, z = x1 + x2 + v
PLANT = control.ss(
    [[-1, 0], [1, -2]],
    [[1, 0, 1], [0, 1, 0]],
    [[1, 0], [0, 1], [1, 1]],
    [[0, 0, 0], [0, 0, 0], [0, 1, 0]],
    inputs=["u", "v", "d"],
    outputs=["y1", "y2", "z"],
)


def test_the_columns_and_rows_of_the_channels_in_order():
    found = lft(PLANT, {"lower": ("z", "v"), "upper": ("y1", "u")})
    assert found.names == ("lower", "upper")
    assert (found.B, found.C) == (((0, 1), (1, 0)), ((1, 1), (1, 0)))
    assert found.D == ((1, 0), (0, 0))
    assert lft(PLANT, [(2, 1), (0, 0)]) == MultivariablePlant(found.A, found.B, found.C, found.D)
    s = 0.3 + 0.7j
    assert found.transfer(s) == pytest.approx(PLANT(s)[np.ix_([2, 0], [1, 0])])


def test_positive_feedback_has_the_other_sign():
    names = {"inputs": ["a", "b"], "outputs": ["c", "d"]}
    H = [["1/(s+1)", "1"], ["0", "1/(s+2)"]]
    plus, minus = (lft(H, [("c", "b"), ("d", "a")], feedback=how, **names) for how in ("positive", "negative"))
    assert plus.transfer(2.0) == pytest.approx(-minus.transfer(2.0))
    assert minus.D == ((1, 0), (0, 0))


def test_one_channel_is_a_plant_of_one_channel_and_keeps_its_hidden_modes():
    found = lft(PLANT, [("y1", "u")])
    assert found.denominator == (1, 3, 2)  # the pole -2 is not seen in y1
    assert found == as_plant(([[-1, 0], [1, -2]], [1, 0], [1, 0]))


def test_states_that_come_back_late_stay():
    # x' = -x + 2 x(t - 1) + mu is unstable; without what comes back it would be stable
    base = MultivariablePlant(((Fraction(-1),),), ((1, 1),), ((1,), (1,)), ((0, 0), (0, 0)))
    whole = DelayMatrix(base, ((Fraction(1), ((0,), (0,))),), ((((Fraction(2),),)),))
    s = 0.3 + 0.7j
    for pairs in ([(1, 0), (0, 1)], [(1, 0)]):
        found = lft(whole, pairs)
        assert found.inner == whole.inner
        assert found.transfer(s) == pytest.approx(1 / (s + 1 - 2 * np.exp(-s)))
        assert certify(found, [Sector(0, Fraction(1, 2))] * len(pairs)).verdict is Verdict.REFUTED


@pytest.mark.slow
def test_classes_by_the_names_of_the_channels():
    plant = lft(PLANT, {"a": ("y1", "u"), "b": ("y2", "v")})
    by_name = max_sector(plant, {"b": Sector(0, 2), "a": Sector(0, 1)}, criterion="circle")
    assert by_name.classes == max_sector(plant, [Sector(0, 1), Sector(0, 2)], criterion="circle").classes
    with pytest.raises(InputError, match="the plant has a, b; give each"):
        max_sector(plant, {"a": Sector(0, 1), "c": Sector(0, 1)})


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: lft(PLANT, {"a": ("y3", "u")}), "there is no output 'y3'; did you mean 'y2'"),
        (lambda: lft(PLANT, {"a": ("y1", 7)}), "there is no input 7; choose from u, v, d"),
        (lambda: lft(PLANT, {}), "give at least one"),
        (lambda: lft(PLANT, ["y1"]), "pairs"),
        (lambda: lft(PLANT, [("y1", "u")], feedback="both"), "feedback is 'both'"),
        (lambda: lft(PLANT, [("y1", "u")], inputs=["u"]), "the plant has 3, give each a name"),
        (lambda: lft("exp(-s)/(s+1)", [(0, 0)]), "this is a DelayPlant"),
        (lambda: MultivariablePlant((), (), ((),), ((Fraction(1),),), None, ("a", "b")), "one for each of 1"),
    ],
)
def test_what_is_refused(ask, said):
    with pytest.raises(InputError, match=said):
        ask()
