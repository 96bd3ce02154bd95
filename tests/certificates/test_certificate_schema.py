"""The published schema of certificates: generated ones keep it, others do not, and it says what the note says."""

import re
from pathlib import Path

import jsonschema
import pytest
from certificate_format import FORMAT, SCHEMA

from lure import NonlinearityClass, RationalPlant, Sector
from lure.analysis.questions.certify import ProofOptions, certify

NOTE = (Path(__file__).parents[2] / "notebooks" / "notes" / "0008-certificates.md").read_text("utf-8")


@pytest.mark.slow
def test_the_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert SCHEMA["$schema"] == "https://json-schema.org/draft/2020-12/schema"


# the note -------------------------------------------------------------------------------------------------------------


def test_the_table_of_the_note_and_the_schema_name_the_same_theorems():
    rows = [line.split("|")[1] for line in NOTE.splitlines() if line.startswith("| `")]
    named = {name for row in rows for name in re.findall(r"`([a-z-]+)`", row)}
    assert {*SCHEMA["properties"]["theorem"]["enum"]} == named | {"counterexample"}


def test_the_note_and_the_schema_name_the_same_methods():
    named = set(re.findall(r'"method": "([a-z-]+)"', NOTE))
    assert set(SCHEMA["properties"]["proof"]["properties"]["method"]["enum"]) == named


def test_the_note_and_the_schema_have_the_same_keys():
    block = NOTE.split("```")[1]
    keys = re.findall(r'^[ {]"(\w+)":', block, re.MULTILINE)
    assert keys == list(SCHEMA["properties"])
    assert [key for key in keys if key != "rate"] == SCHEMA["required"]
    assert SCHEMA["additionalProperties"] is False


def test_every_object_of_the_schema_is_closed():
    def objects(node):
        if isinstance(node, dict):
            if node.get("type") == "object":
                yield node
            for value in node.values():
                yield from objects(value)
        elif isinstance(node, list):
            for value in node:
                yield from objects(value)

    open_ones = [node for node in objects(SCHEMA) if "additionalProperties" not in node]
    # the multiplier and the proof are closed by the variant that the theorem chooses
    assert all(node in (SCHEMA["properties"]["multiplier"], SCHEMA["properties"]["proof"]) for node in open_ones)


# certificates ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def proof():
    """Popov's criterion for 1/(s(s+1)(s+2)) and the sector [0, 5], by a polynomial."""
    found = certify(
        RationalPlant([1], [1, 3, 2, 0]), NonlinearityClass(sector=Sector(0, 5)), ways=ProofOptions(criterion="popov")
    )
    return dict(found.certificate)


CIRCLE, TSYPKIN = {"theorem": "circle", "multiplier": {}}, {"theorem": "tsypkin", "multiplier": {"q": "1"}}
KERNEL = {"coefficient": "1/2", "rate": "3", "order": 1, "side": "causal"}
FALB = {"theorem": "zames-falb", "multiplier": {"theta": "0", "kernels": [KERNEL, {"coefficient": "1", "delay": "-2"}]}}
DISCRETE = {"kind": "transfer", "time": "discrete", "numerator": ["1"], "denominator": ["2", "1"]}
MATRIX = {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 3, "zero": None}
SPACE = {"kind": "state-space", "time": "continuous", "A": [["-1"]], "b": ["1"], "c": ["1"], "d": "0"}
DELAY = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
COVER = {"method": "cover", "boxes": [["0", "1"], ["1", "2"]], "order": 8}
COUNTER = {"verdict": "REFUTED", "theorem": "counterexample", "multiplier": {}}
GROWTH = {"method": "matrix-gain", "gain": "5/2", "P": [["0"], ["-1", "0"]], "start": ["1", "1"]}
ROD = {"kind": "rod", "E": "1", "rho": "1", "L": "1", "A": "1", "k": "-1"}


@pytest.mark.parametrize(
    "change",
    [
        {},
        CIRCLE,
        {**CIRCLE, "multiplier": {"mirrored": True}},
        {"proof": MATRIX},
        {"proof": COVER},
        {"system": SPACE, "proof": MATRIX},
        {"system": DELAY, "proof": COVER},
        {**COUNTER, "system": SPACE, "proof": GROWTH},
        FALB,
        {**TSYPKIN, "system": DISCRETE},
        {"theorem": "zames-falb", "multiplier": {"taps": [[1, "1/2"], [-2, "1/4"]]}, "system": DISCRETE},
        {"law": {"kind": "tanh", "height": "1", "rate": "2"}},
        {"law": {"kind": "piecewise-linear", "points": [["0", "0"]], "left": "0", "right": "1"}},
    ],
)
def test_what_the_format_allows_keeps_the_schema(proof, change):
    assert [error.message for error in FORMAT.iter_errors({**proof, **change})] == []


@pytest.mark.parametrize(
    "change",
    [
        {"format": "lure-certificate/2"},
        {"verdict": "INCONCLUSIVE"},
        {"verdict": "REFUTED"},
        {"convention": "sigma = -H mu, mu = phi(sigma)"},
        {"numbers": "floats"},
        {"note": "trust me"},
        {"theorem": "aizerman"},
        {"multiplier": {}},
        {"multiplier": {"theta": 1.5}},
        {"multiplier": {"theta": "1.5"}},
        {"multiplier": {"theta": "3/0"}},
        {"multiplier": {"theta": "+1"}},
        {"multiplier": {"theta": "1", "tau": "1"}},
        {**CIRCLE, "multiplier": {"mirrored": False}},
        {**FALB, "multiplier": {"theta": "0", "kernels": [{**KERNEL, "side": "left"}]}},
        {**FALB, "multiplier": {"theta": "0", "kernels": [{**KERNEL, "rate": "-3"}]}},
        {**FALB, "multiplier": {"taps": [[1, "1/2"]]}},
        {**FALB, "proof": MATRIX},
        TSYPKIN,
        {**TSYPKIN, "system": DISCRETE, "multiplier": {"theta": "1"}},
        {"system": DISCRETE},
        {"system": SPACE},
        {"system": DELAY, "proof": MATRIX},
        {"system": ROD},
        {"system": {**SPACE, "kind": "transfer"}, "proof": MATRIX},
        {"laws": {"sector": ["0", "5"]}},
        {"proof": {"method": "structure"}},
        {"proof": {**COVER, "boxes": []}},
        {"proof": {**COVER, "boxes": [["0"]]}},
        {"proof": {**COVER, "boxes": [["0", "1", "2"]]}},
        {"proof": {**COVER, "order": 8.5}},
        {"proof": {**MATRIX, "P": [["1/2"]]}},
        {"proof": GROWTH},
        {**COUNTER, "system": SPACE, "proof": {**GROWTH, "P": [["1/2"]]}},
        {**COUNTER, "system": SPACE, "proof": {**GROWTH, "exponent": 0}},
        {"proof": {**MATRIX, "zero": {"right": ["1"], "left": ["1"]}}},
        {"law": {"kind": "cubic"}},
        {"law": {"kind": "tanh", "height": "0", "rate": "2"}},
        {"conclusion": ""},
        {"hypotheses": {}},
        {"hypotheses": {"stable": True}},
    ],
)
def test_what_the_format_forbids_breaks_the_schema(proof, change):
    assert not FORMAT.is_valid({**proof, **change})


def test_every_key_is_needed(proof):
    for key in proof:
        assert not FORMAT.is_valid({other: value for other, value in proof.items() if other != key})
