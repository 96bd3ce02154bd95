"""What the checker reads: text, counts and JSON of one form each, and nothing else; what goes wrong is a refusal."""

import json
import math
from fractions import Fraction as F

import pytest
from certificate_family import certificate

from lure.analysis.certificates import arithmetic as exact
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import main


@pytest.mark.parametrize("text", ["0", "-0", "1", "-12/5", "007", "1/" + "9" * 4000, "9" * 4000, "-" + "9" * 4000])
def test_numbers_are_text_p_or_p_over_q(text):
    assert exact.number(text) == F(text)


@pytest.mark.parametrize(
    "text",
    [
        *(
            "",
            " 1",
            "1 ",
            "1\n",
            "+1",
            "1/0",
            "1/01",
            "1/-2",
            "1//2",
            "/2",
            "1/",
            "1.0",
            "1e3",
            "inf",
            "nan",
            "١",
            "1_0",
        ),
        *("9" * 4001, "1/" + "9" * 4001, 1, 1.0, True, None, ["1"], {"1": "1"}, b"1"),
    ],
)
def test_nothing_else_is_a_number(text):
    with pytest.raises(Malformed, match="not a number of the form p/q"):
        exact.number(text)


def test_lists_of_numbers_have_a_length():
    assert exact.numbers(["1"] * 2000) == [1] * 2000
    assert exact.numbers(["1", "2"], 2) == [1, 2]
    for data, length in (([], None), (["1"] * 2001, None), ("11", None), (("1",), None), (["1"], 2), (["1", "2"], 1)):
        with pytest.raises(Malformed, match="a list"):
            exact.numbers(data, length)


def test_counts_are_integers_within_bounds():
    assert [exact.integer(i, 2, 5) for i in (2, 3, 5)] == [2, 3, 5]
    for data in (1, 6, True, "3", 3.0, None, F(3)):
        with pytest.raises(Malformed, match="a count is"):
            exact.integer(data, 2, 5)


def test_bounds_of_a_class_may_be_infinite():
    assert [exact.extended(x) for x in ("inf", "finite", "-inf", "1/2")] == [math.inf, math.inf, -math.inf, F(1, 2)]
    for data in ("-finite", "Inf", ["inf"], None, math.inf):
        with pytest.raises(Malformed):
            exact.extended(data)


def test_objects_have_exactly_their_keys():
    assert exact.fields({"a": 1, "b": 2}, "b", "a") == [2, 1]
    assert exact.fields({}) == []
    for data in ({"a": 1}, {"a": 1, "b": 2, "c": 3}, ["a", "b"], "ab", None):
        with pytest.raises(Malformed, match="needs the keys a, b, and no other"):
            exact.fields(data, "a", "b")


def test_json_has_no_floats_no_double_keys_and_not_too_many_parts():
    most = exact.MOST_PARTS - 1
    assert exact.parsed(b'{"a": [1, "x", null, true]}') == {"a": [1, "x", None, True]}
    assert len(exact.parsed("[" + "[]," * (most - 1) + "[]]")) == most
    assert exact.parsed(" " * (exact.LARGEST_FILE - 1) + "1") == 1
    for text, reason in (
        ('{"a": 1, "a": 1}', "twice"),
        ('[{"b": {"a": 1, "a": 1}}]', "twice"),
        ("1.0", "1.0"),
        ("1e3", "1e3"),
        ("NaN", "NaN"),
        ("[-Infinity]", "-Infinity"),
        ("", "no JSON"),
        ("[1", "no JSON"),
        ("\ud800", "no JSON"),
        ("[" * 5000 + "]" * 5000, "no JSON"),
        (b"\xff", "no JSON"),
        ("[" + "[]," * most + "[]]", "lists and keys"),
        ("[" + "{}," * most + "{}]", "lists and keys"),
        ("{" + ",".join(f'"{i}":0' for i in range(most + 1)) + "}", "lists and keys"),
        (" " * exact.LARGEST_FILE + "1", "bytes"),
    ):
        with pytest.raises(Malformed, match=reason):
            exact.parsed(text)


def test_the_time_allowed_is_over_when_it_is(monkeypatch):
    monkeypatch.setattr(exact.time, "monotonic", lambda: 100.0)
    with exact.checking(1.0):
        assert exact.DEADLINE == [101.0]
        exact.tick()
        exact.DEADLINE[0] = 100.0
        with pytest.raises(Rejected, match="time allowed"):
            exact.tick()
    assert [math.inf] == exact.DEADLINE


@pytest.mark.parametrize("error", [KeyError, TypeError, AttributeError, IndexError, RecursionError])
def test_a_wrong_form_is_no_certificate(error):
    with pytest.raises(Malformed, match=f"{error.__name__} x"), exact.checking(9.0):
        raise error("x") if error is not KeyError else type("KeyError", (KeyError,), {"__str__": lambda _: "x"})
    assert [math.inf] == exact.DEADLINE


@pytest.mark.parametrize("error", [ZeroDivisionError, OverflowError, MemoryError, ValueError, FloatingPointError])
def test_what_exceeds_all_bounds_is_rejected(error):
    with pytest.raises(Rejected, match=f"{error.__name__} x"), exact.checking(9.0):
        raise error("x")
    for refusal in (Malformed, Rejected):
        with pytest.raises(refusal, match=r"^y$"), exact.checking(9.0):
            raise refusal("y")


def test_the_checker_as_a_script_says_what_it_found_and_the_worst_status_counts(tmp_path, capsys):
    files = {"good": certificate("popov"), "false": {**certificate("popov"), "conclusion": ""}, "none": {}}
    for name, content in files.items():
        (tmp_path / name).write_text(json.dumps(content))
    good, false, none = (str(tmp_path / name) for name in files)
    assert main([good]) == 0
    first, *facts = capsys.readouterr().out.splitlines()
    assert first.startswith("ACCEPTED: every motion converges to the set of equilibria: all time-invariant laws")
    assert first.endswith("(Proved, popov)")
    shown = certificate("popov")
    loop = [f"  {name}: {json.dumps(shown[name])}" for name in ("convention", "system", "law")]
    assert facts == loop + [f"  {name}: {fact}" for name, fact in shown["hypotheses"].items()]
    assert (main([good, good]), main([false]), main([none]), main([]), main([good, none])) == (0, 11, 2, 2, 2)
    assert (main([none, false]), main([false, none]), main([false, good])) == (11, 11, 11)
    starts = [line.split(":")[0] for line in capsys.readouterr().out.splitlines() if not line.startswith("  ")]
    assert starts == [
        *("ACCEPTED", "ACCEPTED", "REJECTED", "NOT A CERTIFICATE", "ACCEPTED", "NOT A CERTIFICATE"),
        *("NOT A CERTIFICATE", "REJECTED", "REJECTED", "NOT A CERTIFICATE", "REJECTED", "ACCEPTED"),
    ]
    (tmp_path / "long").write_text(" " * 12_000_001)
    assert main([str(tmp_path), str(tmp_path / "absent"), str(tmp_path / "long")]) == 2
    assert "more than 12000000 bytes" in capsys.readouterr().out
