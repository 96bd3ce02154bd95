"""Every record: its fields say what they are, and plain data, page, text, Dataset, copies and pickles follow."""

import copy
import dataclasses
import importlib
import inspect
import json
import pickle
import pkgutil
import re
from functools import cache
from pathlib import Path

import pytest
import xarray
from pages import read
from results import HOSTILE, RESULTS, SYSTEMS

import lure
from lure.errors import InputError
from lure.record import Record, plain


def record_types():
    """Every subclass of Record in the packages."""
    for module in pkgutil.walk_packages(lure.__path__, "lure."):
        home = Path(importlib.util.find_spec(module.name).origin)
        if not module.ispkg and re.search(r"\bRecord\b", home.read_text(encoding="utf-8")):
            importlib.import_module(module.name)
    return sorted({f"{kind.__module__}.{kind.__qualname__}": kind for kind in descendants(Record)}.items())


def descendants(kind):
    for child in kind.__subclasses__():
        if child.__module__.startswith("lure."):
            yield child
        yield from descendants(child)


def inside(value):
    """The records in a value: itself, and those in its fields."""
    if isinstance(value, tuple | list):
        for each in value:
            yield from inside(each)
    elif isinstance(value, dict):
        yield from inside(list(value.values()))
    elif dataclasses.is_dataclass(value):
        yield from [value] if isinstance(value, Record) else []
        for each in dataclasses.fields(value):
            yield from inside(getattr(value, each.name))


@cache
def samples():
    found = {}
    for result in [*(make() for make in RESULTS.values()), *SYSTEMS.values()]:
        for record in inside([result, *getattr(result, "branches", ())]):
            found.setdefault(type(record), record)
    return found


TYPES = {name: kind for name, kind in record_types() if not list(descendants(kind))}


@pytest.fixture(params=TYPES)
def sample(request):
    return samples()[TYPES[request.param]]


@pytest.fixture(params=[*TYPES, *RESULTS, *SYSTEMS])
def result(request):
    """One of each type, and everything that is tested anywhere, what is no record among it."""
    if request.param in RESULTS:
        return RESULTS[request.param]()
    return samples()[TYPES[request.param]] if request.param in TYPES else SYSTEMS[request.param]


def test_no_type_is_left_out():
    assert {name for name, kind in TYPES.items() if kind not in samples()} == set()


@pytest.mark.parametrize("name", TYPES)
def test_every_field_says_what_it_is_in_the_docstring(name):
    said = inspect.cleandoc(TYPES[name].__doc__)
    for each in dataclasses.fields(TYPES[name]):
        assert not each.repr or re.search(rf"^(\w+, )*{each.name}(, \w+)* : ", said, re.MULTILINE), each.name


def test_plain_data_are_json_without_nan_and_infinity(result):
    found = result.to_dict()
    assert json.loads(json.dumps(found, allow_nan=False)) == plain(found)
    if result in SYSTEMS.values():
        assert found["kind"]
    if isinstance(result, Record):
        assert json.loads(result.to_json()) == json.loads(json.dumps(found))


def test_a_page_is_well_formed_and_runs_nothing(result):
    figure, _, table = result._repr_html_().rpartition("</figure>")
    tags, text = read(table)
    assert {"table", "caption", "tbody", "th", "td"} <= {*tags, *(() if "<td" in table else ("td", "th"))}
    assert not {"style", "iframe", "a", "svg"} & {*tags}
    assert not {"iframe", "a"} & {*read(figure and f"{figure}</figure>")[0]}
    assert "object at 0x" not in text
    assert " nan" not in text


def test_texts_from_outside_are_escaped(sample):
    for each in dataclasses.fields(sample):
        if isinstance(getattr(sample, each.name), str):
            try:
                page = dataclasses.replace(sample, **{each.name: HOSTILE})._repr_html_()
            except (InputError, LookupError):  # it takes some words only
                continue
            assert "<script" not in page, each.name
            read(page)


def test_copies_and_pickles_are_equal_and_others_are_not(result):
    for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert type(again) is type(result)
        assert (again == result) is True
        assert not isinstance(result, Record) or hash(again) == hash(result)
        assert repr(again.to_dict()) == repr(result.to_dict())
    assert (result == object()) is False
    assert (result != copy.copy(result)) is False
    assert "object at 0x" not in str(result)


def test_a_dataset_has_units_meanings_and_coordinates_and_comes_back(result, tmp_path):
    if not hasattr(result, "to_xarray"):
        pytest.skip("a part of another result")
    found = result.to_xarray()
    for label, variable in found.variables.items():
        assert variable.attrs["units"], label
        assert variable.attrs["long_name"], label
    assert set(found.sizes) <= set(found.coords)
    xarray.testing.assert_identical(xarray.Dataset.from_dict(found.to_dict()), found)
    found.to_netcdf(tmp_path / "result.nc")
    with xarray.open_dataset(tmp_path / "result.nc", decode_times=False) as again:
        xarray.testing.assert_equal(again.load(), found)
        assert again.attrs.get("comment") == found.attrs.get("comment")
