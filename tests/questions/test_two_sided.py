"""Gain, rate and region: one shape of JSON, as the published schema of reports has it."""

import json
from fractions import Fraction
from importlib import resources

import jsonschema
import pytest

from lure import NonlinearityClass, RationalPlant, Saturation, Sector, SlopeBounds
from lure.analysis import check, decay_rate, l2_gain, region, steady_response
from lure.analysis.certificates import codes
from lure.analysis.questions.answers import answer
from lure.analysis.wording import linear_gain

SCHEMA = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
ANSWER = jsonschema.Draft202012Validator({"$ref": "#/$defs/answer", "$defs": SCHEMA["$defs"]})
FLOW, SAMPLED = ([1], [1, 1]), RationalPlant([1], [2, -1], dt=1)  # 1/(s + 1), 1/(2 z - 1)
BESIDE = {"Bw": [[1]], "Cz": [[1]]}
VARYING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)
ASKED = [
    # x' = -x - phi(x) + w: phi = 0 is slowest and lets most through
    (lambda: l2_gain(([[-1]], [[1]], [[1]], 0), [Sector(0, 1)], BESIDE), "gain", (1, 1), "PROVED", "diagonal-popov"),
    (lambda: l2_gain(([[-1]], [[1]], [[1]], 0), [Sector(-2, 1)], BESIDE), "gain", ("inf", "inf"), "REFUTED", ""),
    (lambda: decay_rate(FLOW, Sector(0, 1)), "rate", (1, 1), "PROVED", "circle"),
    (lambda: decay_rate(FLOW, [VARYING]), "rate", (1, 1), "PROVED", "diagonal-circle"),
    # x+ = (x - phi(x))/2, phi/x in [0, 1/2]
    (lambda: decay_rate(SAMPLED, Sector(0, 0.5)), "rate", (0.5, 0.5), "PROVED", "circle"),
    # two solutions of x' = -x - phi(x) + w approach each other like exp(-t), phi rising
    (lambda: steady_response(FLOW, SlopeBounds(0, 1)), "rate", (1, 1), "PROVED", "circle"),
    (lambda: region(([1], [1, -1]), Saturation(gain=2, limit=1)), "area", (2, 2), "PROVED", "scalar"),
]


@pytest.mark.parametrize(("ask", "number", "ends", "verdict", "criterion"), ASKED)
def test_each_answer_is_one_shape_of_json(ask, number, ends, verdict, criterion):
    found = ask()
    data = json.loads(found.to_json())
    ANSWER.validate(data)
    assert set(ANSWER.schema["$defs"]["answer"]["required"]) <= data.keys()
    assert (data["verdict"], data["criterion"], data["code"]) == (verdict, criterion, None)
    assert data[number] == pytest.approx(ends, rel=1e-3) if verdict == "PROVED" else data[number] == list(ends)
    # each end has the certificate that shows it, and the checker accepts what stands in the JSON
    sides = {"PROVED": "PROVED", "REFUTED": "REFUTED"}
    shown = {end: data["certificates"][end] for end in ("low", "high") if data["certificates"][end]}
    assert all(str(check(one).certificate["verdict"]) in sides for one in shown.values())
    upper = number == "gain" or data.get("time") == "discrete"
    proved = data["certificates"]["high" if upper else "low"]
    assert (proved is not None and proved["verdict"] == "PROVED") is (verdict == "PROVED")


@pytest.mark.parametrize("ask", [ask for ask, *_ in ASKED[1:]])
def test_without_time_each_is_left_open_with_its_code(ask, monkeypatch):
    def none(*_):
        raise TimeoutError

    for where in ("decay._refuted", "regions.sign_interval"):
        monkeypatch.setattr(f"lure.analysis.questions.{where}", none)
    monkeypatch.setattr("lure.analysis.questions.gain.answer", lambda one, **_: answer(one, seconds=1e-9))
    data = json.loads(ask().to_json())
    ANSWER.validate(data)
    assert (data["verdict"], data["code"], data["stopped"]) == ("INCONCLUSIVE", codes.OUT_OF_TIME.identifier, "time")


def test_what_is_missing_from_an_answer_or_of_another_question_is_no_answer():
    data = json.loads(decay_rate(FLOW, Sector(0, 1)).to_json())
    for broken in (
        {**data, "schema": "lure-gain/1"},
        {**data, "verdict": "TRUE"},
        {**data, "certificates": {"low": None}},
        {key: value for key, value in data.items() if key != "classes"},
    ):
        assert not ANSWER.is_valid(broken)


def test_a_gain_that_is_long_is_named_with_about():
    # rounded to the nearest short decimal it could be on the side where the loop is stable
    assert [linear_gain(Fraction(v)) for v in ("0", "1", "-1", "2/3", 0.1)] == [
        "phi = 0", "phi = sigma", "phi = -sigma", "phi = 2/3 sigma", "phi = k sigma with k about 0.1"
    ]  # fmt: skip
