"""`lure explain`: every code in order, what it means, and commands to try that are understood."""

import json
import shlex

import pytest

from lure import NonlinearityClass, RationalPlant, Sector
from lure.analysis.certificates import codes
from lure.analysis.questions.conclusion import undecided
from lure.analysis.questions.problem import Problem


def test_explain_lists_every_code_in_order(lure):
    status, out, err = lure("explain")
    assert (status, err) == (0, "")
    assert out.splitlines() == [f"{code.identifier}: {code.title}" for code in codes.CODES]
    assert [entry["code"] for entry in json.loads(lure("explain", "--json")[1])] == list(codes.REGISTRY)


@pytest.mark.parametrize("code", codes.CODES, ids=str)
def test_explain_says_what_happened_what_it_means_and_what_to_try(lure, code):
    status, out, err = lure("explain", code.identifier)
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    assert out.startswith(f"{code}\n\nWhat happened\n")
    flat = " ".join(out.split())
    for text in (code.happened, code.means, *code.tries):
        assert " ".join(text.split()) in flat
    data = json.loads(lure("explain", code.identifier[5:].lower(), "--json")[1])
    assert data["code"] == code.identifier
    assert data["tries"] == list(code.tries)


def test_an_unknown_code_is_one_sentence_with_the_nearest(lure):
    assert lure("explain", "LURE-I0133") == (
        2,
        "",
        "lure: there is no code 'LURE-I0133'; did you mean LURE-I013: a double pole at zero? lure explain lists them\n",
    )
    assert lure("explain", "\x1b[31m")[0] == 2
    assert lure("explain", "banana") == (2, "", "lure: there is no code 'banana'; lure explain lists them\n")


@pytest.mark.parametrize("code", codes.CODES, ids=str)
def test_the_commands_of_an_explanation_are_understood(lure, tmp_path, monkeypatch, code):
    from lure.analysis.questions import certify

    asked = Problem.about(RationalPlant([1], [1, 3, 2, 0]), NonlinearityClass(sector=Sector(0, 5)))
    open_ended = certify.Certification(conclusion=undecided(asked, "not asked", code=code), detail="not asked")
    monkeypatch.setattr(certify, "certify", lambda *_arguments, **_options: open_ended)
    (tmp_path / "plant.toml").write_text("[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n[class]\nsector = [0, 5]\n")
    for text in code.tries:
        command = text.rpartition(" lure certify ")[2]
        if command == text:
            continue
        status, out, err = lure("certify", *shlex.split(command))
        assert (status, err) == (10, ""), command
        assert str(code) in out
