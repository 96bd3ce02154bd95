"""The format of certificates as its JSON schema says it, and what is held against it."""

import json
from importlib import resources

import jsonschema

SCHEMA = json.loads(resources.files("lure.analysis.certificates").joinpath("schema.json").read_text("utf-8"))
FORMAT = jsonschema.Draft202012Validator(SCHEMA)
