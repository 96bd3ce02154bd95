"""What the page asks is answered as the commands answer, without a package that a browser does not have."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from explored import LOOPS, WITHOUT

from lure.analysis import max_sector, max_slope
from lure.analysis.certificates.checker import check
from lure.analysis.explore import respond
from lure.files import find_system
from lure.files.builtin import builtin_loop

ROOT = Path(__file__).parents[2]
THIRD = {"num": "1", "den": "1,3,2,0"}  # 1/(s (s + 1)(s + 2))


def ask(kind, **fields):
    return json.loads(respond(json.dumps({"ask": kind, **fields})))


@pytest.mark.slow
def test_without_other_packages_a_largest_sector_is_that_of_the_command():
    script = f"from explored import LOOPS, answers\nimport json\nprint(json.dumps(answers(LOOPS[:{len(LOOPS) // 10}])))"
    head = f"import sys\nsys.path.insert(0, 'tests/support')\nfor name in {WITHOUT}:\n    sys.modules[name] = None\n"
    run = subprocess.run([sys.executable, "-c", head + script], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    served = json.loads(run.stdout)
    assert served == [
        json.loads(json.dumps(max_sector((num.split(), den.split())).to_dict()))
        for num, den in LOOPS[: len(LOOPS) // 10]
    ]
    assert {found["verdict"] for found in served} == {"PROVED", "REFUTED"}


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "odd"), [("slope", False), ("odd", True)])
def test_a_largest_slope_is_that_of_the_command(kind, odd):
    found = ask("largest", system="dt-6", **{"class": kind})
    assert found["report"] == json.loads(
        json.dumps(max_slope(builtin_loop("dt-6").block, odd=odd, search="linear").to_dict())
    )
    assert all(found["second"])


@pytest.mark.parametrize(
    ("num", "den", "names"),
    [
        ("1", "1 0", ""),
        ("0 1", "1 2", "numerator"),
        ("1", "0, 1 2", "denominator"),
        ("0 1", "0 1 2", "numerator and the denominator"),
    ],
)
def test_coefficients_that_begin_with_0_are_said_to_be_left_out(num, den, names):
    found = ask("plant", num=num, den=den)
    assert found["dropped"] == (
        names and f"Leading zeros of the {names} were left out: the highest power stands first."
    )
    assert ask("plant", num="0", den="0 1 2", transfer="1/s")["dropped"] == ""


# With theta = 3/2, Re[(1 + i w theta) H] >= -1/6, attained at w^2 = 2: this line proves k < 6 and not k = 6.  With
# theta = 0, Re H = -3/((1 + w^2)(4 + w^2)) > -3/4: k up to 4/3.
@pytest.mark.parametrize(
    ("k", "theta", "accepted"),
    [("5.999999", "3/2", True), ("6", "3/2", False), ("1.333", "0", True), ("1.334", "0", False), ("5", "-1", False)],
)
def test_a_line_is_accepted_up_to_where_it_touches_the_curve(k, theta, accepted):
    found = ask("line", **THIRD, k=k, theta=theta)
    assert found["accepted"] is accepted
    if accepted:
        assert check(json.loads(found["certificate"])).certificate["laws"]["sector"] == ["0", str(k_of(found))]


def k_of(found):
    return json.loads(found["certificate"])["laws"]["sector"][1]


# Park's multiplier 1 + theta s - tau s^2 is none of a line; theta = 3/2 is one of Popov's for 1/(s (s + 1)(s + 2)).
@pytest.mark.slow
def test_only_the_multiplier_1_plus_theta_s_is_a_line():
    park = {"num": "1.57,-1.0,-0.15", "den": "1.0,6.434,16.907,25.875,19.258", "class": "odd", "lower": "0.1"}
    for kind, name in [("largest", "criterion"), ("class", "theorem")]:
        found = ask(kind, **park, k="24")
        assert (found[name], found["line"]) == ("park", None)
        found = ask(kind, **THIRD, k="5.999")
        assert (found[name], found["line"]) == ("popov", pytest.approx(1.5, rel=1e-2))
    assert ask("class", **THIRD, k="1")["line"] is not None


def test_a_class_that_depends_on_time_has_the_multiplier_1_whatever_theta_is():
    varying = {"class": "time-varying", "theta": "3/2"}  # the circle criterion reaches 4/3
    assert ask("line", **THIRD, k="1.333", **varying)["accepted"]
    assert not ask("line", **THIRD, k="5", **varying)["accepted"]


@pytest.mark.parametrize(("k", "verdict"), [("5", "PROVED"), ("7", "REFUTED"), ("inf", "REFUTED")])
def test_the_verdict_on_a_class_has_a_certificate_that_both_checkers_accept(k, verdict):
    found = ask("class", **THIRD, k=k)
    assert (found["verdict"], found["second"]) == (verdict, True)
    assert type(check(json.loads(found["certificate"]))).__name__.upper() == verdict


@pytest.mark.parametrize("kind", ["sector", "time-varying", "slope", "odd"])
def test_the_file_of_a_loop_reads_back_as_that_loop(kind, tmp_path):
    fields = {"transfer": "(z/3)/(z^2 - z/2 + 0.1)", "dt": "0.1", "k": "1/7", "lower": "-0.25", "class": kind}
    (tmp_path / "plant.toml").write_text(ask("class", **fields)["toml"], encoding="utf-8")
    read = find_system(str(tmp_path / "plant.toml"))
    assert [str(value) for value in read.block.denominator] == ["1", "-1/2", "1/10"]
    assert str(read.block.dt) == "1/10"
    bounds = read.nonlinearity_class.slope or read.nonlinearity_class.sector
    assert (str(bounds.lower), str(bounds.upper)) == ("-1/4", "1/7")
    assert read.nonlinearity_class.time_varying is (kind == "time-varying")
    assert read.nonlinearity_class.odd is (kind == "odd")


@pytest.mark.parametrize(
    ("fields", "field", "said"),
    [
        ({"den": "1 3 2 x"}, "den", "den[3] is 'x'; give a number"),
        ({"num": ""}, "num", "num is empty"),
        ({"num": "1 2 3", "den": "1 2"}, "den", "the transfer function is improper"),
        ({"den": "0"}, "den", "the denominator is zero"),
        ({"dt": "-1"}, "dt", "positive period"),
        ({"dt": "a"}, "dt", "give a number"),
        ({"transfer": "1/(s+"}, "transfer", "column 6"),
        ({"transfer": "exp(-s)/(s+1)"}, "transfer", "one rational transfer function"),
        ({"system": "secant-ring"}, "system", "one rational transfer function"),
        ({"system": "nothing"}, "system", "no built-in loop"),
        ({"k": "-1"}, "k", "above its lower end 0"),
        ({"k": ""}, "k", "give a number"),
        ({"lower": "7"}, "k", "above its lower end 7"),
        ({"lower": "q"}, "lower", "give a number"),
        ({"theta": "q"}, "theta", "give a number"),
        ({"theta": " "}, "theta", "give a number"),
        ({"class": "any"}, "class", "choose from sector"),
        ({"num": "1e400", "den": "1 1"}, "num", "double precision"),
    ],
)
def test_bad_input_is_one_sentence_beside_its_field(fields, field, said):
    found = ask("line", **{**THIRD, "k": "5", "theta": "1", **fields})
    assert found["field"] == field
    assert said in found["error"]
    assert "\n" not in found["error"]


@pytest.mark.parametrize(
    ("fields", "field", "sentence"),
    [
        ({"num": "1", "den": "s^2+1"}, "den", "den takes coefficients, such as 1, 3, 2, 0; choose Formula above"),
        ({"transfer": "exp(-s)/(s+1)"}, "transfer", "a dead time, or several channels, are for the commands"),
        ({"system": "nope"}, "system", "there is no built-in loop 'nope'; choose one from the list"),
    ],
)
def test_what_the_page_does_not_take_is_said_beside_its_field_with_the_way_out(fields, field, sentence):
    refused = ask("plant", **fields)
    assert refused["field"] == field
    assert sentence in refused["error"]


# 4/((s - 1)(s/3 + 1)): d + g n = s^2 + 2 s - 3 + 12 g is Hurwitz from g = 1/4 on
def test_a_block_that_is_not_stable_says_from_which_lower_end_on_it_would_be():
    found = ask("largest", transfer="4/((s-1)*(s/3+1))")
    assert found["reason"] == "the block has 1 pole in the right half-plane; give a lower gain in (0.25, inf)"
    assert ask("largest", transfer="4/((s-1)*(s/3+1))", lower="1/2")["reason"] == ""
