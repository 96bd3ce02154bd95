"""Gains and several channels for every plant of a box: exact families, refutations by one plant, files."""

import json
from dataclasses import replace
from fractions import Fraction
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import NonlinearityClass, Sector, certify, max_sector
from lure.analysis import l2_gain
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.cli import main
from lure.analysis.questions import tolerances
from lure.analysis.questions.channel_families import BoxSearch
from lure.analysis.verdict import Verdict
from lure.errors import AssumptionError, InputError
from lure.files.loop import loop_to_toml
from lure.files.reading import parse_system
from lure.plants.channel_family import ChannelFamily
from lure.plants.family import PlantFamily
from lure.plants.performance import Performance

positive = st.fractions(Fraction(1, 5), 5, max_denominator=12)
WHOLE = {"Bw": [[1]], "Cz": [[1]]}
VARYING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)


# x' = -a x - b phi + w, z = x, phi in [0, 2]: 1/a with phi = 0, and no more by V = x^2/(2 a): of all 1/min a
@settings(max_examples=3)
@given(a=positive, b=positive, wide=positive, more=positive)
@pytest.mark.slow
def test_the_gain_of_first_order_plants_is_that_of_the_least_damped(a, b, wide, more):
    family = ChannelFamily.of_matrices([["-a"]], [["b"]], [[1]], None, {"a": (a, a + wide), "b": (b, b + more)})
    found, limit = l2_gain(family, [Sector(0, 2)], WHOLE), float(1 / a)
    assert limit * 0.9999 < found.gain.low < limit < found.gain.high < limit * 1.003
    for shown in found.certificates.values():
        assert recheck(shown).accepted


@pytest.mark.slow
def test_the_gain_of_an_unknown_delta_in_discrete_time():
    # x+ = delta x + w, z = x, |delta| <= 9/10: 1/(1 - 9/10) = 10 (iqcToolbox's test); phi is 0 here but for 1/100
    family = PlantFamily.of_matrices([["delta"]], [1], [0], 0, {"delta": (Fraction(-9, 10), Fraction(9, 10))}, dt=1)
    found = l2_gain(family, [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]})
    assert 9.99 < found.gain.low < 10 <= found.gain.high < 10.03


# x' = -3 p x + 2 phi1 - q phi2 + w, z = p^2 x, p = 2 - a: p/3 with the gains 0, least at the least p, but
# p^2/(3 p - 2) with 1, 0, which is largest there, 0.64/0.4 = 1.6 at p = 4/5
@pytest.mark.slow
def test_the_member_of_a_box_has_the_worst_gains_of_all_channels():
    sides = [["-3*(2 - a)"]], [[-2, "q"]], [[1], [1]]
    family = ChannelFamily.of_matrices(*sides, None, {"a": (Fraction(4, 5), Fraction(6, 5)), "q": (1, 2)})
    found = l2_gain(family, [Sector(0, 1)] * 2, {"Bw": [[1]], "Cz": [["(2 - a)^2"]]}, criterion="diagonal-circle")
    assert 1.599 < found.gain.low < 1.6 <= found.gain.high < 1.61


# m x'' + c x' + k x = -phi + m b w, z = x: with phi = 0 the largest of m b |1/(k - m v + i c sqrt(v))|, v >= 0, is
# b m/(c sqrt(k/m - c^2/(4 m^2))), 3.651067 at b = 6/5, m = k = 3/2, c = 1/2.  That is the 13th of 16 corners
@pytest.mark.slow
def test_a_box_of_four_parameters_whose_last_corners_are_the_worst_is_not_cut():
    box = {"m": ("0.5", "1.5"), "k": ("1.5", "2.5"), "c": ("0.5", "1.5")}
    family = PlantFamily.of_matrices([[0, 1], ["-k/m", "-c/m"]], [0, "1/m"], [1, 0], 0, box)
    through = {"Bw": [[0], ["b"]], "Cz": [[1, 0]], "parameters": {"b": ("0.8", "1.2")}}
    found = l2_gain(family, [Sector(0, Fraction(1, 5))], through)
    assert 3.65106 < found.gain.low < 3.651067 < found.gain.high < 3.655
    assert list(found.certificates["high"]["proof"]["boxes"]) == ["multiplier"]  # none at all: no box is cut


def test_no_gain_is_finite_where_one_plant_is_unstable():
    family = ChannelFamily.of_matrices([["-a"]], [[1]], [[1]], None, {"a": (Fraction(-1, 2), 1)})
    found = l2_gain(family, [Sector(0, Fraction(1, 4))], {"Bw": [[1]], "Cz": [[1]]})
    assert (found.verdict, found.gain.low) == (Verdict.REFUTED, inf)
    assert "a = -0.5" in str(found)


# x1' = -a x1 - phi2(x2), x2' = -x2 + phi1(x1) ... of positive systems the linear gains decide: k1 k2 < a: factor 1
@pytest.mark.slow
def test_positive_systems_in_two_channels_reach_the_linear_gains_of_the_worst_plant():
    sides = [["-a", 0], [0, -1]], [[0, -1], [-1, 0]], [[1, 0], [0, 1]]
    family = ChannelFamily.of_matrices(*sides, None, {"a": (1, 2)})
    found = max_sector(family, [Sector(0, 1), Sector(0, 1)])
    assert 0.999 < found.largest.low < 1 <= found.refuted_at < 1 + 1e-6
    assert found.witness.data["parameters"] == {"a": "1"}
    assert "every a in [1, 2]" in str(found)
    assert all(recheck(one.certificate).accepted for one in (found.proof, found.refutation))
    proved, refuted = (certify(family, [Sector(0, k)] * 2) for k in (Fraction(99, 100), Fraction(101, 100)))
    assert (proved.verdict, refuted.verdict) == (Verdict.PROVED, Verdict.REFUTED)


# 1/(m s^2 + c s + k), |d|^2 = (k - m x)^2 + c^2 x: the circle criterion for [0, q] needs q (m x - k) < |d|^2, first
# lost at q = c^2/m + 2 c sqrt(k/m): least at c = 1/2, k = 1, m = 5/4: 0.2 + sqrt(0.8)
@pytest.mark.slow
def test_the_intervals_of_several_channels_grow_up_to_the_plant_that_is_unstable():
    # x' = -a x + phi_1, y' = -2 y - phi_2, phi in [0, 1]: stable for a > 1, a in 5/2 -+ s/2 for s < 3
    sides = [["-a", 0], [0, -2]], [[-1, 0], [0, 1]], [[1, 0], [0, 1]], None
    family = ChannelFamily.of_matrices(*sides, {"a": (2, 3)})
    found = tolerances(family, [Sector(0, 1)] * 2)
    assert found.verdict is Verdict.PROVED
    (margin,) = found.margins
    assert 2.97 < margin.width.low < 3 <= margin.width.high < 3.03
    assert all(recheck(dict(one.certificate)).accepted for one in (margin.proof, margin.refutation))
    assert "a: may be in [1.0" in str(found)
    assert found.assumed == ""
    beside = replace(margin, proof=SimpleNamespace(assumed="y has one sigma"))  # as beside a direct term
    told = str(replace(found, margins=(beside,)))
    assert "phi_2, time-invariant, in the sector [0, 1], for which y has one sigma, and every a in [2, 3]" in told
    with pytest.raises(InputError, match="those of a plant with parameters"):
        tolerances(([[-1]], [[1]], [[1]], 0), [Sector(0, 1)])
    with pytest.raises(InputError, match="no class of nonlinearities"):
        tolerances(family)


@pytest.mark.slow
def test_the_factor_of_a_box_is_sought_far_below_that_of_its_plants(monkeypatch):
    # 1/(100 (s + a)^2) is served up to 800 a^2 by the circle criterion; boxes are said to fail from 50 on
    family = ChannelFamily.of_matrices([["-a", 1], [0, "-a"]], [[0], [1]], [["1/100", 0]], None, {"a": (1, 2)})
    tree = BoxSearch.tree

    def failing(search, alpha, *rest):
        if alpha > 50:
            raise AssumptionError("lost in rounding")
        return tree(search, alpha, *rest)

    monkeypatch.setattr(BoxSearch, "tree", failing)
    assert 5 < max_sector(family, [VARYING]).largest.low <= 50


@pytest.mark.slow
def test_masses_are_divided_by_and_popov_needs_no_bound():
    box = {"m": (Fraction(3, 4), Fraction(5, 4)), "c": (Fraction(1, 2), 1), "k": (1, 2)}
    family = ChannelFamily.of_matrices([[0, 1], ["-k/m", "-c/m"]], [[0], ["1/m"]], [[1, 0]], None, box)
    limit = 0.2 + 0.8**0.5
    found = max_sector(family, [VARYING])
    assert limit * 0.995 < found.largest.low < limit
    popov = certify(family, [Sector(0, 100)])
    assert (popov.verdict, popov.shown.theorem) == (Verdict.PROVED, "diagonal-popov")
    assert recheck(popov.certificate).accepted


SERVO = """
[plant]
A = [[0, 1], ["-k/m", "-c/m"]]
B = [0, "1/m"]
C = [1, 0]
[plant.parameters]
k = [0.9, 1.1]
m = [0.8, 1.2]
c = 1
[class]
sector = [0, 0.2]
[performance]
Bw = [[0], [1]]
Cz = [[1, 0]]
"""


@pytest.mark.slow
def test_a_file_with_parameters_is_asked_for_its_gain(tmp_path, capsys):
    path = tmp_path / "servo.toml"
    path.write_text(SERVO)
    assert main(["gain", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    low, high = found["gain"]
    # with phi = 0: w -> x is m/(m s^2 + c s + k), at most m/(c sqrt(k/m - c^2/(4 m^2))) where that peaks
    peak = 1.2 / np.sqrt(0.9 / 1.2 - 0.25 / 1.44) / 1.2
    assert peak * 0.99 < low < high < 1.4 * peak
    assert "every k in [0.9, 1.1], m in [0.8, 1.2]" in found["sentence"]
    again = parse_system(loop_to_toml(parse_system(SERVO, name="own", source="")), name="own", source="")
    assert l2_gain(again).gain.high == pytest.approx(high, rel=1e-3)


@pytest.mark.slow
def test_a_file_of_several_channels_is_analysed_for_all_plants(tmp_path, capsys):
    path = tmp_path / "pair.toml"
    sides = 'A = [["-a", 0], [0, -1]]\nB = [[0, -1], [-1, 0]]\nC = [[1, 0], [0, 1]]\n'
    classes = "[[class]]\nsector = [0, 0.5]\ntime_varying = true\n" * 2
    path.write_text(f"[plant]\n{sides}[plant.parameters]\na = [1, 2]\n{classes}")
    assert main(["analyse", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "PROVED"
    assert found["block"]["parameters"] == {"a": ["1", "2"]}
    again = parse_system(loop_to_toml(parse_system(path.read_text(), name="own", source="")), name="own", source="")
    assert again.block == parse_system(path.read_text(), name="own", source="").block


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("Bw = [[0], [1]]", "Bw = [[1]]"), "performance.Bw has"),
        (("[class]\nsector = [0, 0.2]", "[class]\ndelay = 1"), "parameters"),
        (('B = [0, "1/m"]', 'B = [0, "1/(m - 1)"]'), "a denominator in the parameters may vanish"),
        (("Bw = [[0], [1]]", 'Bw = [["q"], [1]]'), "performance: "),
    ],
)
def test_what_does_not_fit_is_refused_in_one_sentence(change, said, tmp_path, capsys):
    path = tmp_path / "servo.toml"
    path.write_text(SERVO.replace(*change))
    assert main(["gain", str(path)]) == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="give A"):
        ChannelFamily.of_matrices([["a"]], [[1, 0]], [[1]], [[0, 0], [0, 0]], {"a": (1, 2)})
    with pytest.raises(InputError, match="does not occur"):
        ChannelFamily.of_matrices([["a"]], [[1]], [[1]], None, {"a": (1, 2), "b": (1, 2)})
    with pytest.raises(InputError, match="rows"):
        ChannelFamily.of_matrices("a", [[1]], [[1]], None, {"a": (1, 2)})


# Random plants of random boxes with random constant members: none has a larger gain than is certified.
@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.thorough)])
def test_no_member_of_a_box_has_a_larger_gain(seed):
    rng = np.random.default_rng(seed)
    for _ in range(1 if seed == 1 else 200):
        n, discrete = int(rng.integers(1, 4)), bool(rng.random() < 0.5)
        base = rng.normal(size=(n, n))
        size = np.abs(np.linalg.eigvals(base)).max()
        base = base * 0.5 / size if discrete else base - np.eye(n) * (np.linalg.eigvals(base).real.max() + 0.5)
        slope = np.round(0.2 * rng.normal(size=(n, n)), 2)
        A = [[f"{round(base[i, j], 2)} + ({slope[i, j]})*(p - 1)" for j in range(n)] for i in range(n)]
        B, C = ([[f"{round(v, 1)}*p" for v in row] for row in rng.normal(size=shape)] for shape in ((n, 1), (1, n)))
        seen = {"Bw": [[1]] * n, "Cz": [[1] * n]}
        family = ChannelFamily.of_matrices(
            A, B, C, None, {"p": (Fraction(4, 5), Fraction(6, 5))}, 1 if discrete else None
        )
        found = l2_gain(family, [Sector(Fraction(-1, 5), Fraction(1, 5))], seen, seconds=20)
        if found.verdict is not Verdict.PROVED:
            continue
        for _ in range(100):
            plant = family.at((Fraction(4, 5) + Fraction(rng.random() * 0.4),))
            assert _gain(plant, float(rng.uniform(-0.2, 0.2))) < found.gain.high * (1 + 1e-9)


def _gain(plant, g):
    """The largest gain from ``w`` on every state to their sum with ``mu = -g sigma``, over many frequencies."""
    A, B, C, _ = plant.doubles()
    closed, one = A - g * np.outer(B[:, 0], C[0]), np.ones(len(A))
    s = np.exp(1j * np.linspace(0, np.pi, 200)) if plant.dt is not None else 1j * np.geomspace(1e-2, 1e2, 200)
    return max(abs(one @ np.linalg.solve(v * np.eye(len(A)) - closed, one)) for v in s)


# x' = -a x - phi + a w, z = x/a: a/a^2 with phi = 0, largest at a = 2; Bw and Cz are formulas
PERFORMANCE = """
[plant]
A = [["-a"]]
B = [[1]]
C = [[1]]
[plant.parameters]
a = [2, 3]
[class]
sector = [0, 1]
[performance]
Bw = [["a"]]
Cz = [["1/a"]]
"""


@pytest.mark.slow
def test_the_matrices_of_performance_may_be_formulas_in_the_parameters():
    system = parse_system(PERFORMANCE, name="loop", source="a test")
    found = l2_gain(system)
    assert 0.4999 < found.gain.low < 0.5 <= found.gain.high < 0.5 * 1.003
    assert "a = 2" in str(found)
    for shown in found.certificates.values():
        assert recheck(shown).accepted
    assert parse_system(loop_to_toml(system), name="loop", source="a test").performance == system.performance


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ('["a"]]', '["q"]]', "unknown name 'q'"),
        ('["a"]]', '["1/(a-2)"]]', "may vanish in the box"),
        ('Bw = [["a"]]', 'Bw = [["a"], ["a"]]', "performance.Bw has 2 rows"),
    ],
)
def test_a_formula_of_performance_that_does_not_fit_is_refused(was, now, said):
    with pytest.raises(InputError, match=said):
        parse_system(PERFORMANCE.replace(was, now), name="loop", source="a test")


LAG = """
[plant]
A = [["-T"]]
B = [1]
C = [1]

[plant.parameters]
b = [0.9, 1.1]
T = 2
g = "3"

[class]
sector = [0, 1]

[performance]
Bw = [["b*T"]]
Cz = [["g"]]
"""


# x' = -2 x - phi + 2 b w, z = 3 x: with phi = 0 the gain is 3 b, and no more, by V = x^2: largest 33/10 at b = 11/10
@pytest.mark.slow
def test_a_parameter_and_constants_may_occur_in_the_performance_alone():
    system = parse_system(LAG, name="loop", source="a test")
    found = l2_gain(system)
    assert 3.2999 < found.gain.low < 3.3 <= found.gain.high < 3.31
    assert all(recheck(shown).accepted for shown in found.certificates.values())
    assert parse_system(loop_to_toml(system), name="loop", source="a test").performance == system.performance
    stated = {"Bw": [["2*b"]], "Cz": "g", "parameters": {"b": ("0.9", "1.1"), "g": 3}}
    again = l2_gain(([[-2]], [[1]], [[1]], [[0]]), [Sector(0, 1)], stated)
    assert again.gain == found.gain


def test_texts_of_numbers_are_exact_in_performances():
    stated = Performance.given({"Bw": [["0.1"]], "Cz": "1e-3", "Dzw": [["2/3"]]})
    assert (stated.Bw, stated.Cz, stated.Dzw) == tuple(((Fraction(v),),) for v in ("1/10", "1/1000", "2/3"))


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"Bw": "q", "Cz": 1}, "performance holds 'q', and the plant has no parameters"),
        ({"Bw": 1, "Cz": 1, "parameters": {"b": (1, 2)}}, "parameters.b does not occur in the matrices"),
        ({"Bw": "b", "Cz": 1, "parameters": {"b": (2, 1)}}, "the first must be smaller"),
        ({"Bw": "b", "Cz": 1, "parameters": {"b": (1, 2, 1)}}, "it is constant"),
        ({"Bw": "b", "Cz": 1, "parameters": 3}, "give a mapping"),
        ({"Bw": "1/0", "Cz": 1}, "division by zero"),
    ],
)
def test_parameters_of_a_performance_that_do_not_fit_are_refused(stated, said):
    with pytest.raises(InputError, match=said):
        l2_gain(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], stated)


# With phi = 0 constants have the gain 1, that of a/(s + a) at 0.  For all a in [1, 2] at once V = p x^2 needs
# 2 p a x^2 - 2 p a x w + g w^2 - x^2 >= 0, so (2 p a - 1) g >= p^2 a^2: the roots a = (g -+ sqrt(g^2 - g))/p are to be
# 1 and 2, so that 2 g = 3 p and g = 2 p^2, p = 3/4, g = 9/8
@pytest.mark.slow
def test_a_formula_does_not_make_constants_of_parameters_that_change():
    constant, moved = (
        l2_gain(
            ChannelFamily.of_matrices([["-a"]], [[1]], [[1]], None, {"a": (1, 2, *rate)}),
            [Sector(0, 1)],
            {"Bw": [["a"]], "Cz": [[1]]},
        )
        for rate in ((), (inf,))
    )
    assert constant.gain.high == pytest.approx(1, rel=3e-3)
    assert moved.gain.high == pytest.approx(1.5 / 2**0.5, rel=3e-3)
    assert recheck(moved.certificates["high"]).accepted
