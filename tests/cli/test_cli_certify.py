"""`lure certify`: what it refuses, what it writes, and the code that an open question ends with."""

import json
from importlib import resources

import jsonschema
import pytest
from commands import SECTOR, THIRD, names, written

from lure.analysis.certificates import codes
from lure.analysis.wording import plain

SCHEMA = jsonschema.Draft202012Validator(
    json.loads(resources.files("lure.analysis.certificates").joinpath("schema.json").read_text("utf-8"))
)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "give the block once, by --num and --den, by --transfer or by a TOML file or a built-in system"),
        (THIRD, "no class of nonlinearities is given; give one, such as --sector 0 5.9 or --slope 0 1"),
        ((*THIRD, "--sector", "5", "0"), "--sector is 5 0; the first number must be smaller than the second"),
        ((*THIRD, "--sector", "1", "1"), "the first number must be smaller"),
        ((*THIRD, "--sector", "x", "1"), "--sector is 'x'; give one number such as"),
        ((*THIRD, "--sector", "0", "nan"), "--sector is 'nan'; give one number such as"),
        ((*THIRD, "--slope", "0", "1e999"), "--slope is '1e999'"),
        ((*THIRD, "--sector", "0", "2", "--slope", "0", "1"), "give a sector inside the slope bounds"),
        ((*THIRD, "--odd"), "--odd belongs to a class; give --sector or --slope too"),
        ((*THIRD, "--time-varying"), "--time-varying belongs to a class"),
        ((*THIRD, *SECTOR, "--method", "matrx"), "--method is 'matrx'; did you mean 'matrix'? choose from best,"),
        ((*THIRD, *SECTOR, "--criterion", "popof"), "did you mean 'popov'? choose from best, hurwitz"),
        ((*THIRD, *SECTOR, "--seconds", "0"), "--seconds is 0; give a positive number of seconds"),
        ((*THIRD, *SECTOR, "--seconds", "nan"), "--seconds is nan; give a positive number of seconds"),
        ((*THIRD, *SECTOR, "--set", "plant.num=[2]"), "--set changes a system"),
        (("third-order", *THIRD, *SECTOR), "give the block once: by the system third-order or by --num and --den"),
        (("third-order", "--dt", "1", *SECTOR), "give the block once"),
        (("third-ordr", *SECTOR), "did you mean 'third-order'?"),
        (("ct-1",), "no class of nonlinearities is given"),
        (("missing.toml",), "missing.toml does not exist"),
        (("--num", "1", *SECTOR), "--num and --den go together; give --den too"),
        (("--num", "1 0 0", "--den", "1 3", *SECTOR), "improper"),
        ((*THIRD, *SECTOR, "-o", "."), "'.' is a directory; give the name of a file"),
        ((*THIRD, *SECTOR, "-o", "no/cert.json"), "'no' is no directory"),
        ((*THIRD, *SECTOR, "-o", "there.json"), "'there.json' exists; give another name, or --force"),
    ],
)
def test_bad_questions_are_one_sentence_and_nothing_is_written(lure, tmp_path, arguments, sentence):
    (tmp_path / "there.json").write_text("mine")
    status, out, err = lure("certify", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith("lure: ")
    assert sentence in err
    assert err.count("\n") == 1
    assert names(tmp_path) == ["there.json"]
    assert (tmp_path / "there.json").read_text() == "mine"


PLANT = "[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n"


def test_the_command_of_the_issue_writes_a_certificate_that_verifies(lure, tmp_path):
    # 1/(s(s+1)(s+2)): Popov with theta = 3/2 reaches 6, and 5.9 is 59/10 exactly
    status, out, err = lure("certify", *THIRD, "--sector", "0", "5.9", "-o", "cert.json")
    assert (status, err) == (0, "")
    assert out.startswith("PROVED: every solution converges to the set of equilibria")
    assert out.endswith("\n\nThe certificate is cert.json; check it: lure verify cert.json\n")
    assert names(tmp_path) == ["cert.json"]
    data = written(tmp_path, "cert.json")
    assert list(data)[:3] == ["format", "verdict", "convention"]
    assert data["laws"] == {
        "sector": ["0", "59/10"],
        "slope": None,
        "odd": False,
        "time_varying": False,
        "linear": False,
    }
    assert (data["verdict"], data["theorem"], data["numbers"]) == ("PROVED", "popov", "decimals as written")
    status, out, err = lure("verify", "cert.json")
    assert (status, err) == (0, "")
    assert out.startswith("ACCEPTED: every solution converges to the set of equilibria")
    flat = " ".join(out.split())
    assert "theorem: popov" in flat
    for name, fact in data["hypotheses"].items():
        assert f"{name}: {plain(fact)}" in flat


@pytest.mark.parametrize("k", ["6.1", "7"])
def test_beyond_the_limit_the_certificate_is_a_refutation(lure, tmp_path, k):
    # Routh: 1/(s(s+1)(s+2)) is unstable for gains above 6
    status, out, err = lure("certify", *THIRD, "--sector", "0", k)
    assert (status, err) == (11, "")
    assert out.startswith("REFUTED: a loop of the class has a solution that does not converge")
    assert written(tmp_path)["verdict"] == "REFUTED"
    assert lure("verify", "certificate.json")[0] == 0


@pytest.mark.slow
def test_what_stays_open_has_a_code_and_no_file(lure, tmp_path):
    # between what forms of degree 8 prove, 2.844, and what switching refutes, 3.007
    question = (*THIRD, "--sector", "0", "2.95", "--time-varying")
    status, out, err = lure("certify", *question)
    assert (status, err) == (10, "")
    assert out.startswith("INCONCLUSIVE: ")
    assert "LURE-I001: no multiplier found\n" in out
    assert out.endswith("lure explain LURE-I001\n")
    assert names(tmp_path) == []
    data = json.loads(lure("certify", *question, "--json")[1])
    assert (data["verdict"], data["code"], data["file"]) == ("INCONCLUSIVE", "LURE-I001", None)
    assert {each["code"] for each in data["searches"]} == {"LURE-I001"}


@pytest.mark.slow_for("arguments9-PROVED-zames-falb-polynomial", "arguments10-REFUTED-counterexample-orbit")
@pytest.mark.parametrize(
    ("arguments", "verdict", "theorem", "method"),
    [
        (("third-order", "--sector", "0", "5.9", "--method", "matrix"), "PROVED", "popov", "matrix"),
        (("third-order", "--sector", "0", "5.9", "--method", "cover"), "PROVED", "popov", "cover"),
        (("third-order", "--sector", "0", "1.3", "--time-varying"), "PROVED", "circle", "polynomial"),
        (("ct-1", "--slope", "0", "4.5"), "PROVED", "park", "polynomial"),
        (("ct-1", "--slope", "0", "1.7", "--criterion", "popov"), "PROVED", "popov", "polynomial"),
        (("ct-1", "--slope", "0", "3.7", "--criterion", "park"), "PROVED", "park", "polynomial"),
        (("ct-1", "--slope", "0", "3.7", "--criterion", "off-axis"), "PROVED", "off-axis-circle", "polynomial"),
        (("dt-1", "--slope", "0", "3.7", "--criterion", "tsypkin"), "PROVED", "tsypkin", "polynomial"),
        (("dt-6", "--slope", "0", "0.68", "--criterion", "jury-lee"), "PROVED", "jury-lee", "polynomial"),
        (("dt-6", "--slope", "0", "1.08", "--odd"), "PROVED", "zames-falb", "polynomial"),
        (("dt-6", "--slope", "0", "0.92"), "REFUTED", "counterexample", "orbit"),
        (("triple-lag", "--sector", "0", "7.9", "--criterion", "hurwitz"), "PROVED", "hurwitz", "polynomial"),
        (("second-order",), "PROVED", "popov", "polynomial"),
        (("contact",), "PROVED", "circle", "polynomial"),
        (("--transfer", "exp(-s)/(s+1)", "--sector", "0", "1"), "PROVED", "circle", "cover"),
        (("--transfer", "exp(-s)/(s+1)", "--sector", "0", "3"), "REFUTED", "counterexample", "crossing"),
        (("unstable-lag", "--sector", "0", "1"), "REFUTED", "counterexample", "linear-gain"),
        (("--transfer", "1/((s+1)*(s+2))", "--sector", "-inf", "-3"), "REFUTED", "counterexample", "linear-gain"),
        (("--transfer", "1/((s+1)*(s+2))", "--sector", "0", "finite"), "PROVED", "popov", "polynomial"),
        (("paper-rod",), "PROVED", "rod-energy", "structure"),
        (("paper-rod", "--criterion", "popov"), "PROVED", "rod-popov", "structure"),
        (("paper-rod", "--criterion", "circle", "--sector", "0", "7.9"), "PROVED", "rod-circle", "structure"),
        (("--num=-1", "--den", "1 1", "--sector", "-inf", "0.5"), "PROVED", "circle", "polynomial"),
        (("paper-rod", "--set", "rod.damping=-1e-4"), "REFUTED", "counterexample", "structure"),
        (("dt-6", "--sector", "0", "1.05", "--time-varying"), "REFUTED", "counterexample", "switched-gain"),
        pytest.param(
            ("ct-3", "--slope", "0", "2", "--criterion", "zames-falb"),
            *("PROVED", "zames-falb", "cover"),
            marks=pytest.mark.slow,
        ),
        (("double-zero",), "REFUTED", "counterexample", "linear-gain"),
        (("leonov-bragin-kuznetsov",), "REFUTED", "counterexample", "linear-gain"),
        pytest.param(("kalman-fitts",), *("REFUTED", "counterexample", "flow-orbit"), marks=pytest.mark.thorough),
    ],
)
def test_every_kind_of_certificate_is_written_accepted_and_keeps_the_schema(
    lure, tmp_path, arguments, verdict, theorem, method
):
    status, out, err = lure("certify", *arguments)
    assert (status, err) == ({"PROVED": 0, "REFUTED": 11}[verdict], "")
    assert out.startswith(f"{verdict}: ")
    data = written(tmp_path)
    assert (data["verdict"], data["theorem"], data["proof"]["method"]) == (verdict, theorem, method)
    assert SCHEMA.is_valid(data), [error.message for error in SCHEMA.iter_errors(data)]
    status, out, err = lure("verify", "certificate.json", "--second")
    assert (status, err) == (0, "")
    assert out.endswith("the second checker, on python-flint, agrees\n")


@pytest.mark.slow_for("arguments0-code0")
@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("third-order", "--sector", "0", "2", "--time-varying", "--criterion", "circle"), codes.NO_MULTIPLIER),
        (
            ("--num", "1", "--den", "1 -1 0.5 -0.5", "--dt", "1", "--slope", "0", "0.85", "--criterion", "order-cone"),
            codes.CRITICAL,
        ),
        (("third-order", "--sector", "0", "1", "--criterion", "park"), codes.NOT_APPLICABLE),
        (("third-order", "--sector", "0", "1", "--method", "structure"), codes.NOT_APPLICABLE),
        (("biproper", "--sector", "0", "0.9", "--criterion", "popov"), codes.SEVERAL_SOLUTIONS),
        (("--transfer", "exp(-s)*s/(s+1)", "--sector", "0", "inf"), codes.DEAD_TIME),
        # (s+1) is a hidden mode: every finite k is proved, and without a bound the proof needs a minimal realisation
        (("--num", "1 1", "--den", "1 4 5 2", "--sector", "0", "inf", "--criterion", "popov"), codes.EVERY_FINITE),
        (("paper-rod", "--set", "rod.damping=0"), codes.UNDAMPED),
        (("paper-rod", "--set", "rod.exponent=0.5"), codes.NOT_LIPSCHITZ),
        (("paper-rod", "--method", "polynomial"), codes.NOT_APPLICABLE),
        (("paper-rod", "--criterion", "circle", "--sector", "0", "8.1"), codes.NO_MULTIPLIER),
    ],
)
def test_open_questions_end_with_the_code_that_fits(lure, tmp_path, arguments, code):
    status, out, err = lure("certify", *arguments)
    assert (status, err) == (10, "")
    assert f"  {code}\n" in out
    assert names(tmp_path) == []


def test_the_scheme_of_the_rod_has_a_certificate_by_matrices(lure, tmp_path):
    # N = 10: order 21, one state split off
    assert lure("certify", "paper-rod", "--method", "matrix")[0] == 0
    data = written(tmp_path)
    assert (data["system"]["kind"], data["system"]["cells"], len(data["proof"]["P"])) == ("rod-scheme", 10, 20)
    assert SCHEMA.is_valid(data)
    assert lure("verify", "certificate.json")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "about", "loop"),
    [
        # figure 8 is driven by 2 sin 4t and never rests; what is proved is of the rod left to itself
        (("paper-rod-figure-8",), "the rod without load", "kind rod, E 288000000, rho 8, L 1,"),
        (
            ("paper-rod", "--method", "matrix"),
            "the upwind scheme, without load, and not the rod that it approximates",
            "kind rod-scheme, E 288000000,",
        ),
        (
            ("contact.toml",),
            "the upwind scheme with 1 cell a rod of a rod between two obstacles, without load, and not what it "
            "approximates",
            "kind multivariable, time continuous, A [[-1, 1/3, 0], [1, -1, 0], [1, 0, 0]],",
        ),
        (("disturbance.toml",), "the loop without input, w = 0", "kind transfer, time continuous, numerator [1],"),
        ((*THIRD, "--sector", "0", "5"), None, "numerator [1], denominator [1, 3, 2, 0] theorem"),
    ],
)
def test_what_is_proved_is_said_of_the_loop_that_it_is_proved_of(lure, arguments, about, loop):
    if arguments[0].endswith(".toml"):
        kind = arguments[0].removesuffix(".toml")
        assert lure("init", "--kind", kind)[0] == 0
        arguments += ("--set", "discretisation.cells=1") if kind == "contact" else ()
    out = " ".join(lure("certify", *arguments, "-o", "cert.json")[1].split())
    assert (f" about: {about} loop: sigma = H mu, mu = -phi(sigma); kind" in out) is bool(about)
    assert loop in out
    again = " ".join(lure("verify", "cert.json")[1].split())
    assert loop in again
    assert " about:" not in again
    assert json.loads(lure("certify", *arguments, "-o", "new.json", "--json")[1])["about"] == about


def test_a_law_of_a_file_is_checked_to_be_in_its_class(lure, tmp_path):
    (tmp_path / "plant.toml").write_text(PLANT + '[nonlinearity]\nkind = "saturation"\ngain = 5.5\nlimit = 1\n')
    assert lure("certify", "plant.toml")[0] == 0
    data = written(tmp_path)
    assert data["law"]["kind"] == "piecewise-linear"
    assert data["laws"]["slope"] == ["0", "11/2"]
    assert "law" in data["hypotheses"]
    assert lure("certify", "plant.toml", "--set", "nonlinearity.gain=5.9", "-o", "other.json")[0] == 0
    assert written(tmp_path, "other.json")["laws"]["sector"] == ["0", "59/10"]
    (tmp_path / "tanh.toml").write_text(PLANT + '[nonlinearity]\nkind = "tanh"\nscale = 0.2\ngain = 1\n')
    assert lure("certify", "tanh.toml", "--force")[0] == 0
    assert written(tmp_path)["law"] == {"kind": "tanh", "height": "1", "rate": "5"}
    assert lure("certify", "tanh.toml", "--sector", "0", "5", "--force")[0] == 0
    assert written(tmp_path)["law"] is None  # a class of its own leaves the nonlinearity out


def test_a_law_that_is_not_locally_lipschitz_is_not_proved(lure, tmp_path):
    (tmp_path / "plant.toml").write_text(
        '[plant]\nnum = [1]\nden = [1, 1]\n[nonlinearity]\nkind = "quantiser"\nstep = 1\n'
    )
    status, out, _ = lure("certify", "plant.toml")
    assert status == 10
    assert str(codes.NOT_LIPSCHITZ) in out
    assert names(tmp_path) == ["plant.toml"]


@pytest.mark.slow
def test_an_existing_file_is_replaced_only_with_force(lure, tmp_path):
    (tmp_path / "cert.json").write_text("mine")
    assert lure("certify", *THIRD, *SECTOR, "-o", "cert.json")[0] == 2
    assert (tmp_path / "cert.json").read_text() == "mine"
    still_open = (*THIRD, "--sector", "0", "2", "--time-varying", "--criterion", "circle")
    assert lure("certify", *still_open, "-o", "cert.json", "--force")[0] == 10
    assert (tmp_path / "cert.json").read_text() == "mine"  # nothing was found, so nothing is replaced
    assert lure("certify", *THIRD, *SECTOR, "-o", "cert.json", "--force")[0] == 0
    assert names(tmp_path) == ["cert.json"]
    assert written(tmp_path, "cert.json")["verdict"] == "PROVED"


def test_json_and_standard_output(lure, tmp_path):
    status, out, err = lure("certify", *THIRD, *SECTOR, "--json")
    data = json.loads(out)
    assert (status, err) == (0, "")
    assert (data["verdict"], data["theorem"], data["file"], data["code"]) == (
        "PROVED",
        "popov",
        "certificate.json",
        None,
    )
    assert data["facts"] == written(tmp_path)["hypotheses"]
    status, out, err = lure("certify", *THIRD, *SECTOR, "-o", "-")
    assert status == 0
    assert json.loads(out) == written(tmp_path)
    assert err.startswith("PROVED: ")
    assert lure("certify", *THIRD, *SECTOR, "-o", "-", "-q")[2] == ""
    assert names(tmp_path) == ["certificate.json"]


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ("tanh(sigma)", []),
        pytest.param(
            "sigma*(1 + (sin(5*sigma) + cos(5*sigma))/1.42)",
            ["phi lies in the sector you declare"],
            marks=pytest.mark.slow,
        ),  # for ever: not decided
    ],
)
def test_what_is_only_declared_of_the_nonlinearity_is_said(lure, tmp_path, formula, told):
    nonlinearity = f'[nonlinearity]\nkind = "expression"\nexpression = "{formula}"\nsector = [0, 2]\n'
    (tmp_path / "loop.toml").write_text("[plant]\nnum = [1]\nden = [1, 1]\n" + nonlinearity)
    status, out, _ = lure("certify", "loop.toml")
    assert status == 0
    assert [line for line in out.splitlines() if "assumed" in line] == [f"  assumed: {each}" for each in told]
    assert json.loads(lure("certify", "loop.toml", "--force", "--json")[1])["assumed"] == told


def test_the_time_allowed_ends_a_search(lure, tmp_path):
    # the full search for multipliers and orbits of Fitts' loop takes many seconds
    status, out, _ = lure("certify", "kalman-fitts", "--seconds", "0.2")
    assert status == 10
    assert str(codes.OUT_OF_TIME) in out
    assert names(tmp_path) == []
