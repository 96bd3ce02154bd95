"""Questions about every plant of a box of parameters: exact families, refutations by one plant, the command."""

import json
import re
from fractions import Fraction
from math import inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import NonlinearityClass, Sector, analyse, certify, max_sector, max_slope
from lure.analysis import decay_rate
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.cli import main
from lure.analysis.questions import margins, tolerances
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.report.loop.asked import accepted, answers, pictures
from lure.analysis.verdict import Verdict
from lure.errors import InputError
from lure.files.reading import parse_system
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from tests.support.tampering import assert_both_reject, edited

positive = st.fractions(Fraction(1, 10), 10, max_denominator=20)


# H = -b/(s + a): the gain k puts the pole at b k - a, so that k < a/b is needed of linear gains; the circle criterion
# proves as much, 1 + k Re H > 0 being 1 > k b/a.  Of all of the box: k < min a / max b.
@pytest.mark.slow
@settings(max_examples=3)
@given(a=positive, b=positive, wide=positive, high=positive)
def test_first_order_plants_reach_the_least_ratio_and_no_farther(a, b, wide, high):
    family = PlantFamily.of_coefficients(["-b"], [1, "a"], {"a": (a, a + wide), "b": (b, b + high)})
    found, limit = max_sector(family, time_varying=True), a / (b + high)
    assert float(limit) * (1 - 1e-6) < found.largest.low < limit
    assert limit <= found.refuted_at < float(limit) * (1 + 1e-6)
    assert recheck(found.proof.certificate).accepted
    assert recheck(found.refutation.certificate).accepted


# H = 1/(s + a): the gain -33/10, no double, leaves a pole at 33/10 - a > 0, and so no class that holds it is stable
def test_a_lower_bound_that_is_no_double_and_destabilises_refutes_every_class():
    found = max_sector(PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)}), lower=Fraction(-33, 10))
    assert found.verdict is Verdict.REFUTED
    assert found.refuted_at == -3.3
    assert found.refutation.certificate["proof"]["proof"]["gain"] == "-33/10"


# H = b/(s (s + a) (s + 2)): Routh, k < 2 a (a + 2)/b; Popov's criterion reaches it, and it is least at a corner
@pytest.mark.slow
def test_third_order_plants_reach_rouths_limit_at_a_corner():
    box = {"a": (Fraction("0.9"), Fraction("1.1")), "b": (1, Fraction("1.2"))}
    found = max_sector(PlantFamily.of_formula("b/(s*(s+a)*(s+2))", box))
    limit = 0.9 * 2 * 2.9 / 1.2
    assert found.criterion == "popov"
    assert found.critical
    assert limit * (1 - 1e-5) < found.largest.low < limit <= found.refuted_at < limit * (1 + 1e-9)
    assert "every a in [0.9, 1.1], b in [1, 1.2]" in str(found)
    assert found.refutation.facts["parameters"] == "a = 9/10, b = 6/5"


@pytest.mark.slow
def test_second_order_plants_are_proved_for_every_finite_bound():
    # b/(s^2 + 2 zeta s + a): Re[(1 + theta s) H] |d|^2 = b (a - x + 2 zeta theta x) >= 0 for theta >= 1/(2 zeta)
    family = PlantFamily.of_coefficients(["b"], [1, "2*zeta", "a"], {"a": (2, 3), "zeta": (0.125, 0.25), "b": (1, 2)})
    found = max_sector(family)
    assert (found.verdict, found.criterion, found.largest.low) == (Verdict.PROVED, "popov", inf)


def test_an_interval_of_one_point_is_a_number():
    text = '[plant]\nnum = [1]\nden = [1, "a", 2, 0]\n[plant.parameters]\na = [3, 3]\n'
    block = parse_system(text, name="own", source="here").block
    assert block == RationalPlant([1], [1, 3, 2, 0])


@pytest.mark.slow
def test_a_class_given_whole_is_decided_for_all_plants_or_refuted_by_one():
    family = PlantFamily.of_formula("b/((s+1)*(s+a)*(s+2))", {"a": (1, 2), "b": (1, 2)})
    # at a = 1, b = 2, Routh: (s+1)^2 (s+2) + 2 k is stable for k < 9
    proved = certify(family, Sector(0, 8))
    assert proved.verdict is Verdict.PROVED
    assert "for all constant a in [1, 2], b in [1, 2]" in str(proved)
    refuted = certify(family, NonlinearityClass(sector=Sector(0, 10)))
    assert refuted.verdict is Verdict.REFUTED
    assert "at a = 1, b = 2" in refuted.conclusion.headline


# 1/(s^2 + c s + k): the circle criterion proves [0, q] for q < c^2 + 2 c sqrt(k), so not for q = 2 where c = 0.5 and k
# = 1, nor anywhere below c = 0.586, k = 2; and for every c >= 0.733
@pytest.mark.slow
@pytest.mark.parametrize("several", [False, True])
def test_the_part_of_the_box_that_stays_open_is_said(several):
    box = {"c": (Fraction(1, 2), 2), "k": (1, 2)}
    family = PlantFamily.of_coefficients([1], [1, "c", "k"], box)
    asked = NonlinearityClass(sector=Sector(0, 2), time_varying=True)
    found = certify(family.channels, [asked]) if several else certify(family, asked)
    assert found.verdict is Verdict.INCONCLUSIVE
    told = found.failures[-1].detail
    assert "% of the box: c in [0.5, " in told
    assert "k in [1, " in told
    assert "the rest is covered" in told
    assert all(float(end) < 0.9 for end in re.findall(r"c in \[\S+, ([\d.]+)\]", told) if "/" not in end)


def test_what_is_proved_is_of_every_nonlinearity_and_every_plant():
    family = PlantFamily.of_coefficients(["b"], [1, "a"], {"a": (1, 2), "b": (1, 2)})  # b > 0 and a > 0: passive
    said = certify(family, Sector(0, 1)).conclusion.headline
    assert said.endswith("in the sector [0, 1] and every a in [1, 2], b in [1, 2].")


def test_an_order_that_changes_in_the_box_is_said():
    family = PlantFamily.of_formula("1/((T*s + 1)*(s + 1))", {"T": (0, Fraction(1, 10))})
    found = certify(family, Sector(0, 3), ways=ProofOptions(criterion="popov"))
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "the order of the plants changes in the box, where T = 0" in found.failures[0].detail


# x' = 3/2 x - phi grows with phi = 0, and so does every plant of the box: the width was halved for ever
def test_where_the_plant_in_the_middle_is_refuted_the_least_width_looked_at_is():
    (margin,) = tolerances(PlantFamily.of_formula("1/(s - a)", {"a": (1, 2)}), Sector(0, 1), seconds=9).margins
    assert (margin.proved, margin.refuted) == (None, ((Fraction(191, 128), Fraction(193, 128)),))


# 1/(s + a) has a pole at 0 where a = 0, which no multiplier for a > 0 serves: halves of halves went on until Python
# ended the recursion, and the answer spoke of memory.
def test_a_critical_plant_at_the_end_of_the_box_ends_the_cuts():
    reason = max_sector(PlantFamily.of_formula("1/(s + a)", {"a": (0, 1)}), criterion="circle").reason
    assert reason == "however small the boxes, one multiplier serves none of those beside a in [0, 1/2251799813685248]"


def test_discrete_time_plants_by_the_circle_criterion():
    # b/(z - a): |z - a| >= 1 - a at z = 1 and 1 + a at z = -1; H is least at z = -1: -b/(1 + a): k < (1 + a)/b
    family = PlantFamily.of_coefficients(["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (1, 2)}, dt=1)
    found = max_sector(family)
    assert 0.625 * (1 - 1e-6) < found.largest.low < 0.625 <= found.refuted_at < 0.625 * (1 + 1e-6)


def test_where_one_plant_is_unstable_every_class_is_refuted():
    family = PlantFamily.of_coefficients([1], [1, "a", 1], {"a": (-1, 1)})
    found = max_sector(family)
    assert found.verdict is Verdict.REFUTED
    assert Fraction(found.refutation.facts["parameters"].removeprefix("a = ")) <= 0


@pytest.mark.thorough
@pytest.mark.parametrize("odd", [False, True])
def test_no_member_of_a_proved_box_destabilises(odd):
    family = PlantFamily.of_formula("(s + b)/(s^3 + a*s^2 + 2*s + b)", {"a": (1, 1.5), "b": (0.25, 0.5)})
    found, dice = max_slope(family, odd=odd, seconds=3), np.random.default_rng(1)
    assert found.verdict is Verdict.PROVED
    for _ in range(2000):
        plant = family.at([low + (high - low) * Fraction(dice.random()) for low, high in family.box])
        k = min(found.largest.low, 1e3) * dice.random()
        n, d = ([float(c) for c in side] for side in (plant.numerator, plant.denominator))
        assert max(np.roots(np.polyadd(d, k * np.array(n))).real) < 0


@pytest.mark.slow
def test_the_commands_take_the_file_and_the_json_has_the_parameters(tmp_path, capsys):
    path = tmp_path / "mass.toml"
    path.write_text('[plant]\nnum = ["-b"]\nden = [1, "a"]\n[plant.parameters]\na = [1, 2]\nb = [0.5, 1]\n')
    assert main(["max-sector", "--system", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parameters"] == {"a": ["1", "2"], "b": ["1/2", "1"]}
    assert main(["max-sector", "--system", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "every a in [1, 2], b in [0.5, 1], by circle (certified)" in said


@pytest.mark.thorough
def test_an_analysis_has_a_row_for_each_class():
    family = PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 2), "b": (0.5, 1)})
    found = analyse(family, seconds=20)
    assert {row.verdict for row in found.rows} == {Verdict.PROVED}
    assert found.to_dict()["block"]["parameters"] == {"a": ["1", "2"], "b": ["1/2", "1"]}
    # time-varying: the circle criterion, 3 at a = b = 1
    assert next(row for row in found.rows if row.time_varying).largest.low == pytest.approx(3, rel=1e-5)


# x+ = x - h phi(x): the gain g multiplies by 1 - h g, the most with h = 1/20, g = 1: 19/20; the least is 1 - 10/10 = 0
def test_the_rate_of_the_gradient_method_whose_step_is_not_known_is_that_of_the_least_step():
    family = PlantFamily.of_coefficients(["h"], [1, -1], {"h": (Fraction(1, 20), Fraction(1, 10))}, dt=1)
    found = decay_rate(family, Sector(1, 10))
    assert found.rate.low == pytest.approx(0.95, abs=1e-9)
    assert found.rate.high == pytest.approx(0.95, abs=1e-6)
    assert "and every h in [0.05, 0.1]" in str(found)
    for shown in (found.proof, found.refutation):
        assert recheck(shown.certificate).accepted
    assert_both_reject(edited(found.proof.certificate, "rate", value="94/100"))
    assert_both_reject(edited(found.refutation.certificate, "rate", value="96/100"))


# b/(s + a), 0 <= g <= 1: poles -a - b g, the slowest -1 with a = 1, g = 0
def test_the_rate_in_continuous_time():
    family = PlantFamily.of_coefficients(["b"], [1, "a"], {"a": (1, 2), "b": (1, 2)})
    found = decay_rate(family, Sector(0, 1))
    assert 1 - 2e-4 < found.rate.low <= 1 <= found.rate.high < 1 + 1e-6


# 1/(s + a) and gains from -1/2 on: a > 1/2 is needed, and enough by the circle criterion: [1.5 - s/2, 1.5 + s/2], s < 2
def test_a_margin_ends_where_a_plant_refutes():
    found = tolerances(PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)}), Sector(Fraction(-1, 2), 1))
    (margin,) = found.margins
    assert found.verdict is Verdict.PROVED
    assert 1.97 < margin.width.low < 2 <= margin.width.high < 2.03
    (low, high) = margin.proved[0]
    assert 0.5 < low < 0.51
    assert high == 3 - low
    assert recheck(margin.proof.certificate).accepted
    assert margin.refutation.certificate["laws"]["sector"] == ["-1/2", "1"]
    assert "wider" in str(found)


def test_shares_of_a_margin_are_rounded_to_the_safe_side():
    # widths of 2.9889 and 3.0039 about [1, 2]: 198.89 and 200.39 % wider; of 0.99991 and 0.99999: narrower by a trace
    family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)})
    for proved, refuted, said in (
        ("2.9889", "3.0039", ("198 % wider", "201 % wider")),
        ("0.99991", "0.99999", ("0.009 % narrower", "0.001 % narrower")),
        ("1", "1.23456", ("as given", "23.5 % wider")),
        ("0.500001", "0.500004", ("50 % narrower", "49.9 % narrower")),
    ):
        boxes = [((Fraction(3, 2) - w / 2, Fraction(3, 2) + w / 2),) for w in map(Fraction, (proved, refuted))]
        width = margins.Bracket(float(proved), float(refuted))
        words = margins.Margin(parameters=("a",), width=width, proved=boxes[0], refuted=boxes[1]).words(family)
        assert re.findall(r"\(([^)]*)\)", words) == list(said)


def test_a_box_too_wide_is_made_narrower_until_it_is_proved():
    found = tolerances(PlantFamily.of_coefficients([1], [1, "a"], {"a": (0, 3)}), Sector(Fraction(-1, 2), 1))
    (margin,) = found.margins
    assert found.verdict is Verdict.REFUTED
    assert 0.65 < margin.width.low < 2 / 3 <= margin.width.high < 0.68
    assert "narrower" in str(found)


@pytest.mark.slow
def test_a_report_is_asked_for_tolerances_and_draws_them(tmp_path):
    plant = '[plant]\nnum = [1]\nden = [1, "a + b"]\n[plant.parameters]\na = [1, 2]\nb = [1, 2]\n'
    text = f'{plant}[class]\nsector = [-1, 1]\n[report]\nask = ["tolerances"]\n'
    found = answers(parse_system(text, name="own", source="here"), None)
    assert [margin.parameters for margin in found["tolerances"].margins] == [("a",), ("b",), ("a", "b")]
    (figure,) = pictures(found)
    assert figure.caption.startswith("Blue: the class is certified for every plant.")
    assert found["tolerances"].plot().get_xlabel() == "a"
    assert len(list(accepted(found))) == 2


def test_questions_without_an_answer_for_a_box_are_refused_in_one_sentence(tmp_path, capsys):
    plant = '[plant]\nnum = [1]\nden = [1, "a"]\n[plant.parameters]\na = [1, 2]\n[class]\nsector = [0, 1]\n'
    path = tmp_path / "plant.toml"
    path.write_text(f"{plant}[performance]\nCz = [[1]]\nBw = [[1]]\n")
    assert main(["gain", str(path)]) == 2
    assert "the plant is given without; give it by A, B and C" in " ".join(capsys.readouterr().err.split())
    with pytest.raises(InputError, match=r"\[plant.parameters\]"):
        tolerances(RationalPlant([1], [1, 1]), Sector(0, 1))


@pytest.mark.parametrize("command", ["steady", "region"])
def test_what_is_not_asked_of_plants_with_parameters_is_refused_as_that(command, tmp_path, capsys):
    file = tmp_path / "loop.toml"
    plant = '[plant]\ntransfer = "1/(s + a)"\n[plant.parameters]\na = [1, 2]\n'
    file.write_text(plant + "[class]\nslope = [0, 0.2]\n", encoding="utf-8")
    assert main([command, str(file)]) == 2
    assert "this is not asked for plants with parameters yet; give each parameter one number" in " ".join(
        capsys.readouterr().err.split()
    )


# exp(-T s)/s with phi in [0, 1] is stable for T < pi/2 (Popov reaches the Hurwitz sector): 1 + w/2 < pi/2, w < 1.1416
@pytest.mark.slow
def test_a_dead_time_may_grow_as_far_as_linear_gains_allow():
    family = PlantFamily.of_formula("exp(-T*s)/s", {"T": (0.5, 1.5)})
    (margin,) = tolerances(family, Sector(0, 1)).margins
    assert pi - 2 - 0.02 < margin.width.low < pi - 2 < margin.width.high < pi - 2 + 0.02
    assert all(recheck(one.certificate).accepted for one in (margin.proof, margin.refutation))


def test_beside_a_dead_time_intervals_that_hold_an_unstable_plant_are_not_refuted_and_no_error(monkeypatch):
    # a up to 5/4 + 4 (3/4) and down to 5/4 - 3, where exp(-s/10)/(s + a) has a pole to the right
    monkeypatch.setattr(margins._Growth, "_proved", lambda *_: None)
    family = PlantFamily.of_formula("exp(-s/10)/(s + a)", {"a": (Fraction(1, 2), 2)})
    (margin,) = tolerances(family, Sector(0, Fraction(1, 2))).margins
    assert margin.refuted is None
    assert margin.words(family) == "a: nothing is shown"


@pytest.mark.slow
def test_an_interval_of_a_dead_time_grows_down_to_0_and_no_farther():
    family = PlantFamily.of_formula("exp(-T*s)/(s + 1)", {"T": (Fraction(1, 2), Fraction(3, 2))})
    (margin,) = tolerances(family, Sector(0, Fraction(1, 2))).margins  # a small gain: any T
    assert 1.95 < margin.width.low <= 2
    assert margin.refuted is None
    assert margin.proved[0][0] >= 0
