"""The commands about loops: objects and sentences they print, exit statuses, and what they refuse."""

import json
import math
import re
from dataclasses import replace
from fractions import Fraction
from functools import partial

import pytest
from commands import THIRD, names

from lure import RationalPlant
from lure.analysis import questions
from lure.analysis.cli.loops import linear, lines
from lure.analysis.questions import max_sector, max_slope, search
from lure.analysis.theorems import kernel_limit
from lure.analysis.verdict import Bracket
from lure.files import parse_system, plant_template, read_system
from lure.files.builtin import builtin_loop, loop_names
from lure.files.loop import TEMPLATES

KEYS = {"criterion", "largest", "theta", "multiplier", "verdict", "evidence", "hurwitz", "refuted_at", "witness"}
EXAMPLE_6 = ("--num", "2 0.92", "--den", "1 -0.5 0", "--dt", "1")


# max-sector, max-slope ------------------------------------------------------------------------------------------------


def test_the_sector_of_the_issue(lure):
    # 1/(s(s+1)(s+2)): Routh's limit 6, and Popov with theta = 3/2 reaches it
    status, out, err = lure("max-sector", *THIRD, "--criterion", "popov", "--json")
    data = json.loads(out)
    assert (status, err) == (0, "")
    assert data.keys() >= KEYS
    assert data["criterion"] == "popov"
    assert data["verdict"] == "PROVED"
    assert data["evidence"] == "certified"
    low, high = data["largest"]
    assert 6 * (1 - 1e-8) < low < 6 <= high <= 6 * (1 + 1e-12)
    assert data["theta"] == pytest.approx(1.5, rel=1e-3)
    assert data["hurwitz"] == [6, 6]


def test_a_lyapunov_function_is_not_called_a_multiplier():
    found = max_sector(RationalPlant([1], [1, 1]), criterion="popov")
    for multiplier, kind in (("1 + theta s", "Multiplier"), ("V of degree 4", "Lyapunov function")):
        assert f"{kind}: {multiplier}" in lines(replace(found, multiplier=multiplier), stable=None)[-1]


@pytest.mark.slow
def test_the_slope_of_a_published_example_with_its_counterexample(lure):
    # Carrasco et al., example 6: a monotone nonlinearity of slope 175/192 has an orbit of period 3
    status, out, _ = lure("max-slope", *EXAMPLE_6, "--json")
    data = json.loads(out)
    assert status == 0
    assert data.keys() >= KEYS
    assert 0.9114 < data["largest"][0] < 175 / 192
    assert data["refuted_at"] == pytest.approx(175 / 192, rel=1e-15)
    assert data["witness"]["kind"] == "periodic orbit"
    assert data["witness"]["evidence"] == "certified"
    assert data["odd"] is False
    odd = json.loads(lure("max-slope", "--odd", *EXAMPLE_6, "--json")[1])
    assert 1.0869 < odd["largest"][0] < 25 / 23 == pytest.approx(odd["hurwitz"][1])
    assert odd["odd"] is True


@pytest.mark.slow
def test_a_slope_that_no_multiplier_reaches(lure, monkeypatch):
    # Kalman and Fitts, b = .03: see tests/theorems/test_multiplier_limit.py
    monkeypatch.setattr(kernel_limit, "STEPS", (4,))
    fitts = "s^2/(((s+0.03)^2+0.81)*((s+0.03)^2+1.21))"
    monkeypatch.setattr(questions, "max_slope", partial(max_slope, search="linear"))
    status, out, _ = lure("max-slope", "--transfer", fitts, "--criterion", "circle", "--limits")
    assert status == 0
    assert "No multiplier of Zames and Falb with a Popov term proves monotone" in " ".join(out.split())
    data = json.loads(lure("max-slope", "--transfer", fitts, "--criterion", "circle", "--limits", "--json")[1])
    assert data["largest"][0] < Fraction(data["multiplier_limit"]["k"]) < 0.4
    status, out, _ = lure("max-slope", "--transfer", "1/(s+1)", "--limits")
    assert "No slope was found from which on no multiplier" in " ".join(out.split())
    status, _, err = lure("max-slope", *EXAMPLE_6, "--limits")
    assert (status, "--limits is for rational blocks in continuous time" in err) == (2, True)


def test_an_infinite_reach_is_the_text_inf(lure):
    # 1/(s(s+1)) is stable for every sector [0, k]
    data = json.loads(lure("max-sector", "--transfer", "1/(s*(s+1))", "--json")[1])
    assert data["largest"] == ["inf", "inf"]
    assert data["hurwitz"] == ["inf", "inf"]
    assert data["refuted_at"] is data["witness"] is None


@pytest.mark.parametrize(
    ("command", "found"),
    [
        (
            ("max-sector", "--num", "-1 0 0", "--den", "1 0.2 6 0.1 1", "--criterion", "circle"),
            lambda block: max_sector(block, criterion="circle"),
        ),
        (("max-slope", "--num", "-1", "--den", "1 2 1", "--lower=-0.5"), lambda block: max_slope(block, lower=-0.5)),
        (
            ("max-sector", "--num", "-1", "--den", "1 2 1", "--lower", "-1/2"),
            lambda block: max_sector(block, lower=-0.5),
        ),
        (
            ("max-sector", "--num", "-1", "--den", "1 2 1", "--time-varying"),
            lambda block: max_sector(block, time_varying=True),
        ),
    ],
)
def test_negative_numbers_are_values_and_the_answer_is_that_of_python(lure, command, found):
    numerator = [int(c) for c in command[2].split()]
    block = RationalPlant(numerator, [Fraction(c) for c in command[4].split()])
    status, out, err = lure(*command, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out) == json.loads(json.dumps(found(block).to_dict()))


def test_a_system_gives_its_block(lure, tmp_path):
    data = json.loads(lure("max-sector", "--system", "third-order", "--json")[1])
    assert data["largest"][0] == pytest.approx(6)
    (tmp_path / "plant.toml").write_text("[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n")
    assert json.loads(lure("max-sector", "--system", "plant.toml", "--json")[1]) == data


@pytest.mark.slow_for("command3-0-said3")
@pytest.mark.parametrize(
    ("command", "status", "said"),
    [
        (
            ("max-sector", *THIRD, "--criterion", "popov"),
            0,
            "Every solution converges to the set of equilibria for every phi, time-invariant,\n"
            "in the sector [0, 5.999999999], by popov (certified).\n"
            "Refuted from 6 on: with phi = 6 sigma the loop is not asymptotically stable\n"
            "(certified).\n"
            "Linear gains are stable up to 6.\n",
        ),
        (
            ("max-sector", "--transfer", "12/((s-1)*(s+3))"),
            11,
            "Not stable for every phi, time-invariant, in the sector [0, k], whatever k:\n"
            "without feedback (phi = 0) the loop is not asymptotically stable (certified).\n",
        ),
        (
            ("max-sector", "--transfer", "1/((s+1)*(s+2))"),
            0,
            "The point 0 attracts every solution for every phi, time-invariant, in the sector\n"
            "[0, inf), by popov (certified).\n"
            "Every positive linear gain is stable.\n",
        ),
        (
            ("max-slope", "--transfer", "1/(s+1)^3", "--criterion", "circle"),
            0,
            "The point 0 attracts every solution for every phi, time-varying, in the sector\n"
            "[0, 3.999999999], by circle (certified).\n",
        ),
        *(  # a double pole at 0 under phi = 0, whatever the numerator and the form
            (
                ("max-sector", *plant),
                11,
                "Not stable for every phi, time-invariant, in the sector [0, k], whatever k:\n"
                "without feedback (phi = 0) the loop is not asymptotically stable (certified).\n",
            )
            for plant in (("--transfer", "(s+1)/s^2"), ("--num", "1 1", "--den", "1 0 0"), ("--transfer", "1/s^2"))
        ),
    ],
)
def test_the_answer_reads_as_sentences(lure, command, status, said):
    found, out, err = lure(*command)
    assert (found, err) == (status, "")
    assert out.startswith(said)
    assert max(map(len, out.splitlines())) <= 80
    assert not re.search(r"0 sigma|\.\.|phi = 1 sigma", out)


def test_an_unstable_plant_is_told_a_lower_gain_that_works(lure):
    # 12/((s-1)(s+3)) is stable for gains above 1/4
    out = lure("max-sector", "--transfer", "12/((s-1)*(s+3))")[1]
    (lower,) = re.findall(r"--lower=(\S+)\.", out.replace("\n", " "))
    assert Fraction(lower) > Fraction(1, 4)
    assert lure("max-sector", "--transfer", "12/((s-1)*(s+3))", f"--lower={lower}")[0] == 0


def test_a_plant_that_no_gain_stabilises_is_told_so(lure):
    out = lure("max-sector", "--transfer", "(s-1)/(s^2-1)")[1]
    assert "No linear gain makes the loop stable." in out
    assert "--lower" not in out


@pytest.mark.parametrize(
    ("limit", "lower", "said"),
    [
        (Bracket(6, 6), 0, "Linear gains are stable up to 6."),
        (Bracket(2.2618263337, 2.2618263341), 0, "Linear gains are stable up to 2.261826."),
        (Bracket(math.inf, math.inf), 0, "Every positive linear gain is stable."),
        (Bracket(math.inf, math.inf), Fraction(1, 2), "Every larger linear gain is stable."),
        (Bracket(5, math.inf), 0, "Linear gains are stable up to 5 at least."),
        (Bracket(2 / 3, math.inf), 0, "Linear gains are stable up to 0.6666666 at least."),
        (Bracket(2 / 3, 1), 0, "Linear gains are stable up to 0.6666666 at least, and not beyond 1."),
        (Bracket(1, 4 / 3 - 1e-9), 0, "Linear gains are stable up to 1 at least, and not beyond 1.333334."),
        (Bracket(0, 0), 0, "Linear gains at the lower end of the class are not stable."),
    ],
)
def test_the_linear_limit_is_one_number(limit, lower, said):
    assert linear(limit, Fraction(lower)) == said


def test_a_gap_is_called_a_gap():
    found = max_sector(builtin_loop("triple-lag").block, criterion="circle")
    assert "Nothing was shown in between." in lines(found, stable=())
    closed = max_sector(builtin_loop("triple-lag").block, criterion="popov")
    assert "Nothing was shown in between." not in lines(closed, stable=())


# refusals -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--num", "1 0 0", "--den", "1 3"), "improper: the numerator has degree 2, the denominator 1; give"),
        (("--num", "", "--den", "1 3"), "numerator is empty; give at least one number"),
        (("--num", "1", "--den", ""), "denominator is empty; give at least one number"),
        (("--num", "1", "--den", "0"), "denominator is zero; give its coefficients, highest power first"),
        (("--num", "nan", "--den", "1 1"), "numerator[0] is 'nan'; give a number such as"),
        (("--num", "1", "--den", "1 x"), "denominator[1] is 'x'; give a number such as"),
        (("--num", "-1 0", "--den", "1 1", "--lower", "1"), "not well posed: 1 + k H(inf) = 0 at the lower gain k = 1"),
        (("--num", "1", "--den", "1 1", "--lower", "x"), "--lower is 'x'; give one number such as 2, -0.5"),
        (("--num", "1", "--den", "1 1", "--lower", "1 2"), "--lower is '1 2'; give one number"),
        (("--num", "1", "--den", "1 1", "--lower=inf"), "--lower is 'inf'; give one number"),
        (("--num", "1", "--den", "1 1", "--dt", "0"), "--dt is '0'; give a positive sampling time"),
        (("--num", "1", "--den", "1 1", "--dt=-1"), "--dt is '-1'; give a positive sampling time"),
        (("--num", "1"), "--num and --den go together; give --den too"),
        (("--den", "1 1"), "--num and --den go together; give --num too"),
        ((), "give the block once, by --num and --den, by --transfer or by a TOML file or a built-in system"),
        (("--num", "1", "--den", "1 1", "--system", "ct-1"), "got --num and --den and the system"),
        (("ct-1", "--num", "1", "--den", "1 1"), "got --num and --den and the system"),
        (("ct-1", "--system", "ct-1"), "the system is given twice, ct-1 and --system ct-1; give one of them"),
        (("--transfer", "1/(s+1)", "--dt", "1"), "the formula is in s but dt asks for discrete time"),
        (("--transfer", "1/(s+1) + 1/(z-2)"), "both s and z occur"),
        (("--transfer", "s"), "improper"),
        (("--transfer", "__import__('os')"), "transfer"),
        (("--system", "dt-1", "--dt", "1"), "--dt belongs to --num and --den or --transfer"),
        (("--system", "paper-rod"), "paper-rod is a rod; run: lure report paper-rod"),
        (("--system", "third-ordr"), "did you mean 'third-order'?"),
        (("--num", "1", "--den", "1 1", "--criterion", "popof"), "did you mean 'popov'? choose from best, hurwitz"),
        (
            ("--num", "1", "--den", "1 1", "--criterion", "tsypkin"),
            "tsypkin is for discrete time, this block is in cont",
        ),
        (
            ("--transfer", "1/(z-0.5)", "--criterion", "popov"),
            "popov is for continuous time, this block is in discrete",
        ),
    ],
)
@pytest.mark.parametrize("command", ["max-sector", "max-slope"])
def test_bad_flags_are_one_sentence_and_status_2(lure, tmp_path, command, arguments, sentence):
    status, out, err = lure(command, *arguments)
    assert (status, out) == (2, "")
    assert err.startswith("lure: ")
    assert sentence in err
    assert err.count("\n") == 1
    assert names(tmp_path) == []


@pytest.mark.parametrize("command", ["max-sector", "max-slope"])
def test_a_system_is_named_with_or_without_its_flag(lure, command):
    assert lure(command, "third-order") == lure(command, "--system", "third-order")


def test_a_criterion_that_the_class_cannot_use_is_refused(lure):
    status, _, err = lure("max-sector", "--num", "1", "--den", "1 1", "--criterion", "park")
    assert status == 2
    assert "needs slope bounds" in err
    status, _, err = lure("max-sector", "--num", "1", "--den", "1 1", "--criterion", "popov", "--time-varying")
    assert status == 2
    assert "time-invariant nonlinearities" in err


PLANT = "[plant]\nnum = [1]\nden = [1, 1]\n"
EXPRESSION = '[nonlinearity]\nkind = "expression"\nexpression = "{}"\nsector = [0, 2]\n'
BAD = {
    "improper": ("[plant]\nnum = [1, 0, 0]\nden = [1, 1]\n", "improper: the numerator has degree 2"),
    "no numerator": ("[plant]\nnum = []\nden = [1, 1]\n", "plant.num is empty; give at least one number"),
    "no denominator": ("[plant]\nnum = [1]\nden = []\n", "plant.den is empty; give at least one number"),
    "no plant": ("[plant]\n", "the block is given by num and den, or A, B and C, or transfer; got none"),
    "two plants": (PLANT + "A = [[1]]\n", "the block is given by num and den, or A, B and C, or transfer; got A, "),
    "phi(0) of a formula": (PLANT + EXPRESSION.format("sigma + 1"), "phi(0) = 1; a nonlinearity must vanish at 0"),
    "phi(0) of points": (
        PLANT
        + '[nonlinearity]\nkind = "piecewise linear"\npoints = [[-1, 1], [1, 1]]\nleft_slope = 0\nright_slope = 0\n',
        "phi(0) = 1; a nonlinearity must vanish at 0",
    ),
    "false sector": (PLANT + EXPRESSION.format("sigma**3"), "declared to have the sector [0, 2], but phi(sigma)/sigma"),
    "k1 > k2": (PLANT + "[class]\nsector = [2, 1]\n", "class.sector is [2, 1]; the first must be smaller"),
    "k1 = k2": (PLANT + "[class]\nsector = [1, 1]\n", "class.sector is [1, 1]; the first must be smaller"),
    "slopes": (
        PLANT + "[class]\nsector = [0, 1]\nslope = [1, 0]\n",
        "class.slope is [1, 0]; the first must be smaller",
    ),
    "mixed times": ('[plant]\ntransfer = "1/(s+1)"\ndt = 0.1\n', "the formula is in s but dt asks for discrete time"),
    "s and z": ('[plant]\ntransfer = "1/(s+1) + 1/(z-2)"\n', "both s and z occur"),
    "dt = 0": (PLANT + "dt = 0\n", "plant.dt is 0; give a positive time, or leave dt out"),
    "NaN in A": ("[plant]\nA = [[nan, 1], [0, -1]]\nB = [0, 1]\nC = [1, 0]\n", "plant.A[0][0] is NaN; give a finite"),
    "NaN in num": ("[plant]\nnum = [nan]\nden = [1, 1]\n", "plant.num[0] is NaN; give a finite number"),
    "shapes": ("[plant]\nA = [[0, 1], [0, -1]]\nB = [0, 1, 2]\nC = [1, 0]\n", "B is 1 x 3 and A is 2 x 2"),
    "two inputs": ("[plant]\nA = [[0, 1], [0, -1]]\nB = [[0, 1], [1, 0]]\nC = [1, 0]\n", "need as many of both"),
    "no such nonlinearity": (PLANT + '[nonlinearity]\nkind = "satration"\n', "did you mean 'saturation'?"),
    "nonlinearity outside class": (
        PLANT + '[nonlinearity]\nkind = "saturation"\ngain = 5\nlimit = 1\n[class]\nsector = [0, 3]\n',
        "the class is phi in the sector [0, 3] but the nonlinearity is only known to be among odd phi with slope in "
        "[0, 5]",
    ),
}


@pytest.mark.parametrize("command", ["report", "analyse", "max-sector"])
@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_one_sentence_and_nothing_is_written(lure, tmp_path, name, command):
    text, sentence = BAD[name]
    (tmp_path / "plant.toml").write_text(text)
    if command == "max-sector" and name == "false sector":
        pytest.skip("max-sector asks about the block alone")
    system = ("--system", "plant.toml") if command == "max-sector" else ("plant.toml",)
    status, out, err = lure(command, *system)
    assert (status, out) == (2, "")
    assert err.startswith("lure: ")
    assert sentence in err
    assert err.count("\n") == 1
    assert names(tmp_path) == ["plant.toml"]


@pytest.mark.slow_for('max-slope-transfer = "1/(s+1)^3"-slope = [0, 1]\\nt')
@pytest.mark.parametrize(
    ("command", "plant", "said", "words", "largest"),
    [
        # z + 1/2 + 2 k/5 has its root inside up to k = 5/4
        (
            "max-sector",
            'transfer = "2/5/(z+1/2)"\ndt = 1',
            "sector = [-1, 1]\ntime_varying = true",
            "[-1, ",
            (1.25,) * 2,
        ),
        # Re 1/(s+1)^3 >= -1/4, so that the circle criterion ends at 4, Popov's at 8
        ("max-slope", 'transfer = "1/(s+1)^3"', "slope = [0, 1]\ntime_varying = true", "time-varying", (4, 4)),
        ("max-slope", 'transfer = "1/(s+1)^3"', "slope = [0, 1]\nodd = true", "time-invariant", (8, 8)),
        # stable with every gain, while the sector is destabilised
        ("max-sector", 'transfer = "s^2/(s^4+0.0003*s^3+10*s^2+0.0021*s+9)"', "gain = [0, 1]", "linear", (1e5, 1e6)),
    ],
)
def test_what_the_class_of_a_file_says_holds(lure, tmp_path, command, plant, said, words, largest):
    (tmp_path / "plant.toml").write_text(f"[plant]\n{plant}\n[class]\n{said}\n")
    found = json.loads(lure(command, "--system", "plant.toml", "--json")[1])
    assert largest[0] * (1 - 1e-6) <= found["largest"][0] <= largest[1]
    assert words in found["sentence"]
    assert found["time_varying"] == ("time_varying" in said)


def test_a_mode_that_no_feedback_reaches_is_named(lure, tmp_path):
    # A = diag(1, -1), the unstable mode neither driven nor seen
    (tmp_path / "plant.toml").write_text("[plant]\nA = [[1, 0], [0, -1]]\nB = [0, 1]\nC = [0, 1]\n")
    status, out, _ = lure("max-sector", "--system", "plant.toml")
    assert status == 11
    assert "it cancels in H" in out.replace("\n", " ")


# analyse, report, systems, init ---------------------------------------------------------------------------------------


def test_analyse_takes_settings_and_prints_a_table_or_json(lure, tmp_path):
    (tmp_path / "plant.toml").write_text(PLANT + "[class]\nsector = [0, 5]\n")
    status, out, err = lure("analyse", "plant.toml")
    assert (status, err) == (0, "")
    assert out.startswith("PROVED  plant: H = 1 / (s + 1)\n")
    data = json.loads(lure("analyse", "plant.toml", "--json", "--set", "class.sector=[0, 7]")[1])
    assert data["class"]["sector"] == [0, 7]
    assert data["verdict"] == "PROVED"
    assert lure("analyse", "unstable-lag")[0] == 11
    assert lure("analyse", "double-zero")[0] == 11
    assert lure("analyse", "paper-rod")[2] == "lure: paper-rod is a rod; run: lure report paper-rod\n"
    assert names(tmp_path) == ["plant.toml"]


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
def test_report_writes_the_page_on_a_loop(lure, tmp_path):
    (tmp_path / "plant.toml").write_text(PLANT + "[class]\nsector = [0, 5]\n")
    status, out, err = lure("report", "plant.toml", "--set", "plant.num=[2]")
    assert (status, err) == (0, "")
    assert out.endswith("The report is lure-report/report.html\n")
    found = {path.name for path in (tmp_path / "lure-report").iterdir()}
    assert found == {"certificates", "figures", "report.html", "report.json"}
    certificates = sorted((tmp_path / "lure-report" / "certificates").iterdir())
    assert certificates
    assert lure("verify", *map(str, certificates))[0] == 0
    data = json.loads((tmp_path / "lure-report" / "report.json").read_text("utf-8"))
    assert data["system"]["block"]["numerator"] == ["2"]
    assert data["reproduce"]["command"] == "lure report plant.toml --set 'plant.num=[2]'"
    assert lure("report", "unstable-lag", "--json", "-q")[0] == 11
    data = json.loads((tmp_path / "lure-report" / "report.json").read_text("utf-8"))
    assert data["system"]["name"] == "unstable-lag"


def test_systems_shows_loops_and_writes_them_as_files(lure, tmp_path):
    assert lure("systems", "kalman-fitts")[1].splitlines()[2:5] == [
        "H = s^2 / (s^4 + 0.12 s^3 + 2.0254 s^2 + 0.121308 s + 0.981919)",
        "Nonlinearity: tanh(sigma / 0.01)",
        "Report: lure report kalman-fitts",
    ]
    assert "Class: phi in the sector [0, 1]\n" in lure("systems", "iqc-resonance")[1]
    assert "Class: none, every class is looked at\n" in lure("systems", "ct-1")[1]
    for name in loop_names():
        status, out, _ = lure("systems", name, "--toml")
        assert status == 0
        read, built = parse_system(out, name=name, source="a file"), builtin_loop(name)
        assert (read.block, read.nonlinearity_class, read.name) == (built.block, built.nonlinearity_class, name)
    status, _, err = lure("systems", "kalman-fits")
    assert (status, err) == (
        2,
        "lure: there is no built-in system 'kalman-fits'; did you mean 'kalman-fitts'? lure systems lists them\n",
    )


def test_init_writes_the_template_of_a_loop(lure, tmp_path):
    assert lure("init", "--loop") == (0, "plant.toml is written; edit it, then run: lure report plant.toml\n", "")
    assert (tmp_path / "plant.toml").read_text("utf-8") == plant_template()
    assert lure("init", "--loop")[0] == 2
    assert lure("init", "--loop", "--force")[0] == 0
    assert lure("init", "--loop", "other.toml")[0] == 0
    assert read_system(tmp_path / "other.toml").nonlinearity is not None
    written = (tmp_path / "other.toml").read_text("utf-8")
    assert "run:   lure analyse other.toml\n" in written
    assert "plant.toml" not in written
    assert lure("init")[1].startswith("rod.toml is written")
    assert lure("init", "--kind", "memroy")[2] == (
        "lure: --kind is 'memroy'; did you mean 'memory'? give one of contact, delay, disturbance, memory, operator\n"
    )


@pytest.mark.slow_for("operator", "disturbance")
@pytest.mark.parametrize("kind", [*TEMPLATES, "contact"])
def test_each_short_template_is_a_system_about_which_something_is_proved(lure, kind):
    said = f"{kind}.toml is written; edit it, then run: lure report {kind}.toml\n"
    assert lure("init", "--kind", kind) == (0, said, "")
    # all that is known of a delay takes 9 s, of the contact 2 s; what is built in as `contact` is analysed by others
    brief = kind in ("delay", "contact")
    assert lure(*(("certify", f"{kind}.toml") if brief else ("analyse", f"{kind}.toml", "--json")))[0] == 0


# the time allowed, and the steps --------------------------------------------------------------------------------------


def test_time_over_prints_the_best_bounds_and_says_so(lure, monkeypatch):
    ask = search.criterion_answer

    def asked(entry, question):
        if entry.name == "popov":
            raise TimeoutError
        return ask(entry, question)

    monkeypatch.setattr(search, "criterion_answer", asked)
    for command in ("max-sector", "max-slope"):
        status, out, err = lure(command, *THIRD)
        assert (status, err) == (0, "")  # the circle criterion had proved something
        assert "by circle (certified)" in " ".join(out.split())
        assert "The time allowed ended the search (LURE-I007)" in " ".join(out.split())
    status, out, _ = lure("analyse", "third-order", "--json")
    assert status == 0
    assert json.loads(out)["stopped"] == "time"


@pytest.mark.parametrize("command", [("max-sector", *THIRD), ("max-slope", *THIRD), ("analyse", "ct-4")])
def test_hardly_any_time_is_inconclusive(lure, command):
    status, out, err = lure(*command, "--seconds", "1e-6")
    assert (status, err) == (10, "")
    assert "LURE-I007" in out
    status, _, err = lure(*command, "--seconds", "0")
    assert (status, err) == (2, "lure: --seconds is 0; give a positive number of seconds, or leave it out\n")


def test_an_interrupt_prints_what_was_found_or_ends_the_command(lure, monkeypatch):
    def interrupted(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(search, "nonlinear_witnesses", interrupted)
    status, out, _ = lure("max-sector", *THIRD, "--time-varying", "--full")
    assert status == 0
    assert "The search was interrupted" in out
    monkeypatch.setattr(search, "hurwitz", interrupted)
    assert lure("max-sector", *THIRD) == (130, "", "lure: interrupted\n")


@pytest.mark.parametrize("option", ["-v", "--verbose"])
def test_verbose_shows_every_step_and_its_time(lure, option):
    _, quiet, _ = lure("max-slope", *THIRD)
    status, out, err = lure("max-slope", *THIRD, option)
    assert (status, out) == (0, quiet)
    steps = [re.fullmatch(r" +\d+\.\d{3} s  (.+)", line) for line in err.splitlines()]
    assert [step[1] for step in steps] == ["slope: linear gains", "slope: circle", "slope: popov"]
    assert lure("max-slope", *THIRD, option, "--quiet")[2] == ""
    assert "criteria" not in lure("certify", *THIRD, "--sector", "0", "5", "-o", "-", option)[1].partition("{")[0]


@pytest.mark.slow
def test_a_report_in_limited_time_says_so_on_its_page(lure, here):
    status, out, _ = lure("report", "ct-4", "--seconds", "1e-6", "-o", "r", "-q")
    assert status == 10
    assert "LURE-I007" in out
    assert json.loads((here / "r" / "report.json").read_text())["conclusion"]["stopped"] == "time"
    assert "The time allowed ended the search" in (here / "r" / "report.html").read_text()
    assert "--seconds limits the searches" in lure("report", "paper-rod", "--seconds", "5")[2]
