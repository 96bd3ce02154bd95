"""What the commands pass on, say and refuse, one decision at a time, of answers that are made up."""

import json
from fractions import Fraction as F
from math import inf
from pathlib import Path
from types import SimpleNamespace

import pytest

from lure import InputError, NonlinearityClass, RationalPlant, Sector, StateSpace
from lure.analysis import questions
from lure.analysis.cli import loops, performance
from lure.analysis.cli.loops import block_of, linear, lines, refutation
from lure.analysis.questions import decay, energy, gain, regions, steady
from lure.analysis.theorems import kernel_limit
from lure.analysis.verdict import Bracket, Evidence, Verdict, Witness
from lure.classes import Diagonal
from lure.errors import AssumptionError

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
LAG = '[plant]\ntransfer = "1/(s+1)"\n'


def witness(description="a relay: makes the loop oscillate", kind="periodic orbit", **data):
    return Witness(
        kind=kind,
        k=3.0,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=description,
        data=data,
    )


def bound(**more):
    """An answer about one channel, up to 4."""
    found = {"classes": None, "verdict": PROVED, "witness": None, "refuted_at": None, "lower": F(0), "trivial": None}
    found |= {"hurwitz": Bracket(8, 8), "multiplier": "1", "theta": None, "unfinished": "", "reason": "", "odd": False}
    found |= {"largest": Bracket(4, 4), "about": "phi in", "search_limited": False, "criterion": "popov"}
    found |= {"evidence": Evidence.CERTIFIED, "conclusion": SimpleNamespace(headline="0 attracts."), "closed": False}
    found |= {"refuted_ends": "whatever k > 0", "refuted_text": "5", "witness_text": "7", "proved_text": "4"}
    return SimpleNamespace(**found | more)


ORBIT, GAIN = witness(), witness("phi = 0: the loop is not stable", "linear gain", gain="0")
FIRST, LIMIT = "0 attracts, by popov (certified).", "Linear gains are stable up to 8."
AGAINST = "Refuted from 5 on: a relay: makes the loop oscillate (certified)."
GAP = "Nothing was shown in between."
NEVER = "Not stable for every phi in [0, k], whatever k"


class Stable:
    """An interval of stable linear gains."""

    sample = F(1, 2)

    def __str__(self):
        return "(0.1, 1)"


STABLE = (Stable(), Stable())
BEGIN = "Linear gains in (0.1, 1) and (0.1, 1) are stable; begin the class there, as with --lower=1/2."


# what is refuted is said by its member; beside phi = lower sigma the nonlinear one from its own k on
@pytest.mark.parametrize(
    ("more", "stable", "said"),
    [
        ({"witness": ORBIT, "refuted_at": 5.0}, None, [FIRST, AGAINST, GAP, LIMIT]),
        ({"witness": ORBIT, "refuted_at": 5.0, "closed": True}, None, [FIRST, AGAINST, LIMIT]),
        ({"refuted_at": 5.0}, None, [FIRST, LIMIT]),
        (
            {"witness": ORBIT, "refuted_at": 5.0, "verdict": OPEN, "largest": Bracket(0, 0)},
            None,
            ["Nothing is proved for phi in [0, k].", AGAINST, LIMIT],
        ),
        (
            {"witness": ORBIT, "refuted_at": 5.0, "verdict": REFUTED},
            None,
            [f"{NEVER}: a relay: makes the loop oscillate (certified)."],
        ),
        (
            {"witness": ORBIT, "trivial": GAIN, "refuted_at": 0.0, "verdict": REFUTED},
            (),
            [
                f"{NEVER}: without feedback (phi = 0) the loop is not stable (certified).",
                "From k = 7 on also a relay: makes the loop oscillate (certified).",
                "No linear gain makes the loop stable.",
            ],
        ),
        (
            {"witness": ORBIT, "refuted_at": 5.0, "verdict": REFUTED, "reason": "why"},
            STABLE,
            [f"{NEVER}: a relay: makes the loop oscillate (certified).", "Reason: why.", BEGIN],
        ),
        ({}, STABLE, [FIRST, LIMIT]),
    ],
)
def test_what_is_refuted_is_told_in_lines(more, stable, said):
    assert " ".join(lines(bound(**more), stable=stable)) == " ".join(said)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"verdict": OPEN}, "Nothing is proved for phi in [0, k]; popov holds up to 4, certified only."),
        ({"verdict": OPEN, "lower": F(4)}, "Nothing is proved for phi in [4, k]."),
        ({"verdict": OPEN, "lower": F(1, 3)}, "Nothing is proved for phi in [0.3333334, k]; popov holds up to 4"),
        ({"verdict": REFUTED, "lower": F(1, 3)}, "Not stable for every phi in [0.3333333, k], whatever k."),
        ({"search_limited": True}, "0 attracts, the largest k tried, by popov (certified)."),
    ],
)
def test_the_claim_of_an_answer(more, said):
    assert loops._claim(bound(**more)).startswith(said)


LISTED = Diagonal((NonlinearityClass(sector=Sector(0, 1)),) * 2)
NONE = "No destabilising member was found, which proves nothing."
RELUS = Diagonal((NonlinearityClass.relu(),) * 2)


# with several channels k is a factor, of ReLUs this one alone
@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({}, ["Proved up to k = 4, by popov (certified).", "0 attracts.", NONE]),
        (
            {"search_limited": True},
            ["Proved up to k = 4, the largest tried, by popov (certified).", "0 attracts.", NONE],
        ),
        (
            {"witness": ORBIT},
            [
                "Proved up to k = 4, by popov (certified).",
                "0 attracts.",
                "Refuted from k = 5 on: a relay: makes the loop oscillate (certified).",
                GAP,
            ],
        ),
        (
            {"witness": ORBIT, "closed": True, "unfinished": "So far."},
            [
                "Proved up to k = 4, by popov (certified).",
                "0 attracts.",
                "Refuted from k = 5 on: a relay: makes the loop oscillate (certified).",
                "So far.",
            ],
        ),
        (
            {"witness": ORBIT, "classes": RELUS},
            [
                "Proved for k = 4 alone, by popov (certified).",
                "0 attracts.",
                "Refuted at k = 5: a relay: makes the loop oscillate (certified).",
                GAP,
            ],
        ),
        ({"verdict": OPEN, "reason": "why"}, ["Nothing is proved: why."]),
        (
            {"verdict": REFUTED, "witness": ORBIT},
            ["Not stable whatever k.", "A relay: makes the loop oscillate (certified)."],
        ),
    ],
)
def test_a_largest_factor_is_told_in_lines(more, said):
    found = " ".join(lines(bound(**{"classes": LISTED} | more), stable=None))
    assert found.endswith("; every upper bound times k. " + " ".join(said))
    assert found.startswith("Classes: ")


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (GAIN, "without feedback (phi = 0) the loop is not stable (certified)"),
        (witness("phi: rings", "linear gain", gain="1"), "with phi = sigma rings (certified)"),
        (witness("phi: rings", "linear gain", gain="-1"), "with phi = -sigma rings (certified)"),
        (witness("phi: rings", "linear gain", gain="5/2"), "with phi = 5/2 sigma rings (certified)"),
        (
            witness("phi: rings", "linear gain", gain="2", parameters={"a": "1", "b": "2"}),
            "with phi = 2 sigma, a = 1, b = 2, rings (certified)",
        ),
        (witness("phi rings", "linear gain", gain="2"), "phi rings (certified)"),
        (witness("phi: rings", "switched gain", gain="2"), "phi: rings (certified)"),
        (witness("phi: rings", "linear gain"), "phi: rings (certified)"),
    ],
)
def test_a_linear_member_is_said_in_short(one, said):
    assert refutation(one) == said


# one ten thousandth apart is one number; nothing is said of gains that do not go beyond the lower end
@pytest.mark.parametrize(
    ("limit", "lower", "said"),
    [
        (Bracket(1, 2), 2, "Linear gains at the lower end of the class are not stable."),
        (Bracket(1, inf), 1, ""),
        (Bracket(2, inf), 1, "Linear gains are stable up to 2 at least."),
        (Bracket(10000, 10001), 0, "Linear gains are stable up to 10000."),
        (Bracket(-10000, -9998), -20000, "Linear gains are stable up to -10000 at least, and not beyond -9998."),
        (Bracket(-10000, -9999.5), -20000, "Linear gains are stable up to -10000."),
    ],
)
def test_the_end_of_linear_gains_beyond_the_lower_end(limit, lower, said):
    assert linear(limit, F(lower)) == said


def test_text_is_wrapped_between_words_and_not_inside_an_interval():
    text = "x " * 30 + "the sector [0.123456789, 0.98765432]"
    assert loops._wrapped([text])[-1] == "[0.123456789, 0.98765432]"
    assert loops._wrapped(["x " * 38 + "phi = 2"])[-1] == "phi = 2"
    assert loops._wrapped(["x " * 38 + "k = 2"])[-1] == "k = 2"
    assert loops._wrapped(["x" * 77 + " a-b"]) == ["x" * 77, "a-b"]


# what the options leave out the class of the system says
VARYING = LAG + "[class]\nsector = [0.5, 3]\ntime_varying = true\n"
ODD = LAG + "[class]\nslope = [0.5, 3]\nodd = true\n"


@pytest.mark.parametrize(
    ("command", "text", "options", "asked"),
    [
        ("max-sector", None, (), {"lower": 0, "time_varying": False, "search": "linear", "criterion": "best"}),
        ("max-sector", None, ("--time-varying", "--full"), {"lower": 0, "time_varying": True, "search": "full"}),
        ("max-sector", None, ("--lower=-1/2",), {"lower": F(-1, 2)}),
        ("max-sector", VARYING, (), {"lower": F(1, 2), "time_varying": True}),
        ("max-sector", VARYING, ("--lower=2",), {"lower": 2, "time_varying": True}),
        ("max-sector", LAG + "[class]\nsector = [-inf, 3]\n", (), {"lower": 0, "time_varying": False}),
        ("max-slope", None, (), {"lower": 0, "odd": False, "criterion": "best"}),
        ("max-slope", None, ("--odd", "--criterion=park"), {"odd": True, "criterion": "park"}),
        ("max-slope", ODD, (), {"lower": F(1, 2), "odd": True}),
        ("max-slope", LAG + "[class]\nsector = [0.5, 3]\n", (), {"lower": 0, "odd": False}),
    ],
)
def test_the_class_of_a_system_says_what_options_leave_out(lure, tmp_path, monkeypatch, command, text, options, asked):
    heard = {}

    def run(block, **given):
        heard.update(given, block=block)
        return bound()

    monkeypatch.setattr(questions, command.replace("-", "_"), run)
    if text is None:
        plant = ("--transfer", "1/(s+1)")
    else:
        (tmp_path / "loop.toml").write_text(text)
        plant = (str(tmp_path / "loop.toml"),)
    status, out, err = lure(command, *plant, *options)
    assert (status, err) == (0, "")
    assert {name: heard[name] for name in asked} == asked
    assert isinstance(heard["block"], RationalPlant)
    assert "Every positive" not in out
    assert FIRST in out


# a gain that is constant is asked about as the class of one channel of several are: by the factor of its bounds
@pytest.mark.parametrize(
    ("text", "option", "said"),
    [
        (LAG + "[class]\ngain = [0, 4]\n", "--time-varying", "says of its own that it is"),
        (LAG + "[class]\nslope = [0, 4]\ntime_varying = true\n", "--lower=1", "says of its own that it is"),
        (
            "[plant]\nA = [[-1, 0], [0, -1]]\nB = [[1, 0], [0, 1]]\nC = [[1, 0], [0, 1]]\n"
            "[[class]]\nsector = [0, 1]\n[[class]]\nsector = [0, 1]\n",
            "--full",
            "has 2 channels",
        ),
    ],
)
def test_several_channels_have_no_options_of_one(lure, tmp_path, monkeypatch, text, option, said):
    path = tmp_path / "loop.toml"
    path.write_text(text)
    status, _, err = lure("max-sector", str(path), option)
    assert (status, option.partition("=")[0] + " is for one nonlinearity" in err, said in err) == (2, True, True)
    monkeypatch.setattr(loops, "_largest_factor", lambda system, kind, *_: print(kind, system.several) or 0)
    assert lure("max-sector", str(path))[:2] == (0, f"sector {'2' in said}\n")
    assert lure("max-slope", str(path))[:2] == (0, f"slope {'2' in said}\n")
    assert lure("max-sector", str(path), "--num", "1", "--den", "1 1")[0] == 2


def test_a_block_is_given_once():
    assert block_of("1", "1 1", None, None, None) == RationalPlant([1], [1, 1])
    assert block_of(None, None, "1/(z+2)", None, None).dt is not None
    assert block_of("1", "1 2", None, "1/2", None).dt == F(1, 2)
    assert block_of(None, None, "1/(z+2)", "3", None).dt == 3
    for given, said in (
        (("1", None, "1/(s+1)", None, None), "got --num and --den and --transfer"),
        ((None, None, None, "1", None), "or a built-in system$"),
        ((None, None, None, "1", "dead-zone"), "--dt belongs to"),
        (("1", None, None, None, None), "give --den too"),
        ((None, "1", None, None, None), "give --num too"),
    ):
        with pytest.raises(InputError, match=said):
            block_of(*given)


# no multiplier proves anything from the limit on, which lies above what is proved and below what is refuted
@pytest.mark.parametrize(
    ("more", "above", "below"),
    [
        ({}, 4, 8),
        ({"refuted_at": 6.0}, 4, 6),
        ({"refuted_at": 9.0}, 4, 8),
        ({"closed": True}, None, None),
        ({"verdict": OPEN}, None, None),
    ],
)
def test_where_a_limit_of_multipliers_is_looked_for(more, above, below, monkeypatch):
    monkeypatch.setattr(kernel_limit, "multiplier_limit", lambda block, **given: {"block": block, **given})
    found = loops._limit(bound(**more), "a plant")
    if above is None:
        assert found is None
    else:
        assert found == {"block": "a plant", "above": above, "below": below, "odd": False, "lower": 0}


@pytest.mark.parametrize(("limit", "said"), [(None, "No slope was found from which on"), ("From 9 on.", "From 9 on.")])
def test_a_limit_of_multipliers_is_said_after_the_answer(lure, monkeypatch, limit, said):
    monkeypatch.setattr(questions, "max_slope", lambda _block, **_given: bound(to_dict=lambda: {"verdict": "PROVED"}))
    monkeypatch.setattr(loops, "_limit", lambda *_given: limit if limit is None else Limit())
    status, out, _ = lure("max-slope", "--transfer", "1/(s+1)", "--limits")
    assert status == 0
    assert out.startswith(FIRST)
    assert f"\n{said}" in out
    _, out, _ = lure("max-slope", "--transfer", "1/(s+1)", "--limits", "--json")
    assert json.loads(out) == {"verdict": "PROVED", "multiplier_limit": None if limit is None else {"from": 9}}


class Limit:
    """A limit of multipliers."""

    def to_dict(self):
        """As data."""
        return {"from": 9}

    def __str__(self):
        return "From 9 on."


def test_limits_are_refused_before_anything_is_searched(lure, monkeypatch):
    monkeypatch.setattr(questions, "max_slope", lambda _block, **_given: bound())
    sampled = ("max-slope", "--transfer", "1/(z+0.5)")
    assert "--limits is for rational blocks" in lure(*sampled, "--limits")[2]
    assert lure(*sampled)[0] == 0


def test_limits_are_of_rational_blocks_in_continuous_time():
    loops._check_limits(RationalPlant([1], [1, 1]))
    for block in (RationalPlant([1], [1, 1], 1), StateSpace([[-1]], [1], [1])):
        with pytest.raises(InputError, match="--limits is for rational blocks in continuous time"):
            loops._check_limits(block)


# the gain, the rate and the response ----------------------------------------------------------------------------------


SHOWN, OTHER = SimpleNamespace(certificate={"system": {}}), SimpleNamespace(certificate={"system": {}})


@pytest.mark.parametrize(
    ("shown", "verdict", "factors", "said"),
    [
        (None, PROVED, PROVED, "of this side of the gain"),
        (SHOWN, PROVED, PROVED, "that the gain is at most 0.6666667"),
        (OTHER, PROVED, PROVED, "that a member has a gain above 0.3333333"),
        (OTHER, REFUTED, REFUTED, "that no gain is finite"),
        (OTHER, OPEN, REFUTED, "of the unstable member"),
        (OTHER, REFUTED, PROVED, "that a member has a gain above 0.3333333"),
    ],
)
def test_which_side_of_the_gain_a_certificate_is_of(shown, verdict, factors, said):
    found = SimpleNamespace(proof=SHOWN, verdict=verdict, gain=Bracket(1 / 3, 2 / 3))
    found.factors = SimpleNamespace(verdict=factors)
    assert performance._side(found, shown) == said


@pytest.mark.parametrize(
    ("proof", "against", "verdict", "said"),
    [
        (SHOWN, OTHER, PROVED, (SHOWN, "of the rate that is proved", "The")),
        (SHOWN, OTHER, REFUTED, (OTHER, "of the member that is no faster", "Not every solution decays; the")),
        (SHOWN, OTHER, OPEN, (SHOWN, "of the bound of growth", "No decay is proved; the")),
        (None, OTHER, OPEN, (OTHER, "of the member that is no faster", "No decay is proved; the")),
        (None, None, OPEN, (None, "of a rate", "No decay is proved; the")),
    ],
)
def test_which_certificate_a_rate_has(proof, against, verdict, said):
    found = SimpleNamespace(proof=proof, refutation=against, verdict=verdict)
    assert performance._shown(found) == said


def test_the_state_of_a_transfer_function_is_said():
    assert performance._states(RationalPlant([1, 2], [1, 3, 4])) == [
        "x is the state of the companion form of the transfer function, with C = [2, 1]."
    ]
    assert performance._states(StateSpace([[-1]], [1], [1])) == []


# c at nine tenths of the rate, at half of it or at a tenth; a factor per sample is raised to such a power
@pytest.mark.parametrize(
    ("rate", "fails", "asked", "said"),
    [
        ({}, 0, ["0.18"], "found"),
        ({}, 1, ["0.18", "0.1"], "found"),
        ({"time": "discrete"}, 2, ["0.287175", "0.5", "0.870551"], "found"),
        ({}, 3, ["0.18", "0.1", "0.02"], "No number c is given: no quadratic function shows even 0.1 of the rate."),
        ({"verdict": OPEN}, 0, [], "No number c is given, since no decay is proved."),
        (
            {"proof": SimpleNamespace(certificate={"system": {"late": 1}})},
            0,
            [],
            "No number c is given: beside dead time no quadratic function of x(0) shows the rate.",
        ),
        ({"proof": None}, 0, ["0.18"], "found"),
    ],
)
def test_a_number_c_is_looked_for_at_less_of_the_rate(rate, fails, asked, said, monkeypatch):
    heard = []

    def overshoot(_loop, *, rate):
        heard.append(rate)
        if len(heard) <= fails:
            raise AssumptionError("none")
        return "found"

    monkeypatch.setattr(energy, "overshoot", overshoot)
    made = {"verdict": PROVED, "proof": SHOWN, "time": "continuous", "rate": Bracket(0.2, 0.25)}
    shown, told = performance._constant(None, SimpleNamespace(**made | rate))
    assert (heard, told) == ([F(one) for one in asked], said)
    assert shown == ("found" if said == "found" else None)


def test_responses_are_a_table_with_bounds_that_are_shown_alone():
    row = {"omega": 1.0, "low": 0.5, "high": 0.75, "computed": 0.6, "periods": 1, "alone": True}
    rows = [SimpleNamespace(**row, evidence=one) for one in (Evidence.CERTIFIED, Evidence.COMPUTED)]
    rows.append(SimpleNamespace(**row | {"alone": False}, evidence=Evidence.CERTIFIED))
    head, *body, last = performance._table(SimpleNamespace(response=rows), 'a,"b').split("\n")
    assert head.startswith("omega [rad/s],at least [a;b],at most [a;b],computed [a;b],periods")
    assert body == ["1.0,0.5,0.75,0.6,1,certified,yes", "1.0,,,0.6,1,computed,", "1.0,0.5,0.75,0.6,1,certified,"]
    assert last == ""
    assert performance._table(SimpleNamespace(response=[]), "").startswith("omega [rad/s],at least,at most,")


def test_numbers_and_points_are_read():
    assert performance._numbers("2, 1/3", "--amplitude") == [2, F(1, 3)]
    assert performance._points("1 1; 1/2 -1") == [[1, 1], [F(1, 2), -1]]
    for text in ("", "1;", "a", "1 b; 2"):
        with pytest.raises(InputError, match="--along is"):
            performance._points(text)
    with pytest.raises(InputError, match="--amplitude is 'x'"):
        performance._numbers("x", "--amplitude")


# the commands --------------------------------------------------------------------------------------------------------


class Answer(SimpleNamespace):
    """An answer that says one sentence."""

    def __str__(self):
        return self.said

    def to_dict(self):
        """As data."""
        return {"said": self.said}

    def lines(self):
        """As lines."""
        return [self.said]


OWN = LAG + "[class]\nslope = [0, 1]\n"


@pytest.fixture
def loop_file(tmp_path):
    """A file of a lag with slopes."""
    path = tmp_path / "loop.toml"
    path.write_text(OWN)
    return str(path)


@pytest.mark.parametrize(
    ("proof", "against", "said"),
    [
        (SHOWN, None, "The certificate that the gain is at most 2 is"),
        (None, OTHER, "No bound is proved; the certificate that a member has a gain above 1 is"),
        (None, None, "There is no certificate of this side of the gain; "),
    ],
)
def test_the_certificates_of_a_gain(lure, loop_file, tmp_path, monkeypatch, proof, against, said):
    heard = {}
    found = Answer(said="a gain", proof=proof, refutation=against, verdict=PROVED, gain=Bracket(1, 2))
    found.factors = SimpleNamespace(verdict=PROVED)
    monkeypatch.setattr(gain, "l2_gain", lambda _loop, **ways: heard.update(ways) or found)
    monkeypatch.setattr(energy, "energy_bounds", lambda _loop: Answer(said="an energy"))
    out = lure("gain", loop_file, "-o", str(tmp_path / "a.json"), "--witness", str(tmp_path / "b.json"))[1]
    assert out.startswith("a gain\n")
    assert " ".join(out.split()).find(said) > 0
    assert ("an energy" in out, heard["incremental"], heard["worst"]) == (False, False, False)
    written = [(tmp_path / name).exists() for name in ("a.json", "b.json")]
    assert written == [proof is not None or against is not None, against is not None]
    assert lure("gain", loop_file, "--energy", "--worst", "--incremental")[1] == "a gain\nan energy\n"
    assert (heard["incremental"], heard["worst"]) == (True, True)
    assert json.loads(lure("gain", loop_file, "--energy", "--json")[1]) == {
        "said": "a gain",
        "energy": {"said": "an energy"},
    }
    assert json.loads(lure("gain", loop_file, "--json")[1]) == {"said": "a gain"}


def test_the_number_c_is_said_where_it_is_asked_for(lure, tmp_path, monkeypatch):
    loop_file = str(tmp_path / "matrices.toml")
    Path(loop_file).write_text("[plant]\nA = [[-1]]\nB = [1]\nC = [1]\n[class]\nslope = [0, 1]\n")
    found = Answer(said="a rate", proof=None, refutation=None, verdict=OPEN)
    monkeypatch.setattr(decay, "decay_rate", lambda _loop, **_ways: found)
    assert lure("rate", loop_file)[1] == "a rate\n"
    none = "No number c is given, since no decay is proved."
    assert lure("rate", loop_file, "--constant")[1] == f"a rate\n{none}\n"
    assert json.loads(lure("rate", loop_file, "--constant", "--json")[1]) == {"said": "a rate", "constant": None}
    assert json.loads(lure("rate", loop_file, "--json")[1]) == {"said": "a rate"}


def test_the_number_c_of_a_plant_without_states_is_refused_before_a_rate_is_sought(lure, loop_file, monkeypatch):
    monkeypatch.setattr(decay, "decay_rate", lambda _loop, **_ways: pytest.fail("the rate is computed first"))
    status, _, said = lure("rate", loop_file, "--constant")
    assert (status, "the number c is about states" in said) == (2, True)


@pytest.mark.parametrize("command", ["rate", "steady"])
def test_what_closes_the_loop_is_asked_for(lure, tmp_path, command):
    (tmp_path / "open.toml").write_text(LAG)
    status, _, err = lure(command, str(tmp_path / "open.toml"))
    assert (status, "class of " in err, "give one, such as [class] with" in err) == (2, True, True)


@pytest.mark.parametrize(
    ("verdict", "said"),
    [
        (PROVED, "The certificate of the rate of attraction is"),
        (REFUTED, "The certificate of the member whose differences do not decay is"),
        (OPEN, "There is no certificate of the answer; "),
    ],
)
def test_the_certificate_of_a_steady_response(lure, loop_file, tmp_path, monkeypatch, verdict, said):
    heard = {}
    found = Answer(said="a response", proof=SHOWN, refutation=OTHER, verdict=verdict, response=[])
    monkeypatch.setattr(steady, "steady_response", lambda _loop, **ways: heard.update(ways) or found)
    out = lure("steady", loop_file, "-o", str(tmp_path / "a.json"))[1]
    assert (said in " ".join(out.split()), heard["forcing"]) == (True, None)
    csv = tmp_path / "a.csv"
    assert lure("steady", loop_file, "--csv", str(csv), "--amplitude", "1", "--omega", "1:2:3")[0] != 2
    assert (heard["forcing"]["amplitude"], len(heard["forcing"]["omega"])) == ([1], 3)
    assert csv.read_text().startswith("omega [rad/s]")
    assert "--csv needs an input" in lure("steady", loop_file, "--csv", str(tmp_path / "b.csv"))[2]
    refused = lure("steady", loop_file, "--amplitude", "1", "--omega", "0:1:3")[2]  # it has the form that is shown
    assert "two frequencies above 0, the smaller one first" in " ".join(refused.split())


def test_a_region_says_what_x_is_where_there_is_a_set(lure, loop_file, monkeypatch):
    heard = {}
    found = Answer(said="a region", sets=(), outside=(), verdict=OPEN)
    monkeypatch.setattr(regions, "region", lambda _loop, **ways: heard.update(ways) or found)
    assert lure("region", loop_file)[1] == "a region\n"
    assert heard["along"] is None
    found.outside = (SimpleNamespace(),)
    assert "x is the state of the companion form" in lure("region", loop_file, "--along", "1")[1]
    assert heard["along"] == [[1]]
