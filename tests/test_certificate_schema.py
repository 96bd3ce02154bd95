"""The published schema of certificates: generated ones keep it, others do not, and it says what the note says."""

import json
import re
from importlib import resources
from pathlib import Path

import jsonschema

SCHEMA = json.loads(resources.files("analysis.certificates").joinpath("schema.json").read_text("utf-8"))
CHECK = jsonschema.Draft202012Validator(SCHEMA)
NOTE = (Path(__file__).parents[1] / "notebooks" / "notes" / "0008-certificates.md").read_text("utf-8")


def refused(data):
    return [error.message for error in CHECK.iter_errors(data)]


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
    assert re.findall(r'^[ {]"(\w+)":', block, re.MULTILINE) == SCHEMA["required"] == list(SCHEMA["properties"])
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
