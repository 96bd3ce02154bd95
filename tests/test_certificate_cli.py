"""The commands about certificates: what they accept, reject and refuse, what they write, and what they load."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from analysis.certificates import codes
from analysis.cli import main

ROOT = Path(__file__).parents[1]
THIRD = ("--num", "1", "--den", "1 3 2 0")


@pytest.fixture
def lure(capsys, tmp_path, monkeypatch):
    """Run a command in an empty directory; its exit status, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = main(arguments)
        out, err = capsys.readouterr()
        return status, out, err

    return run


def names(folder):
    return sorted(path.name for path in folder.iterdir())


# explain --------------------------------------------------------------------------------------------------------------


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


# certify: refusals ----------------------------------------------------------------------------------------------------

SECTOR = ("--sector", "0", "5")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "give the block once, by --num and --den, by --transfer or by a TOML file or a built-in system"),
        (THIRD, "no class of laws is given; give one, such as --sector 0 5.9 or --slope 0 1"),
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
        (("ct-1",), "no class of laws is given"),
        (("missing.toml",), "missing.toml does not exist"),
        (("--num", "1", *SECTOR), "--num and --den go together; give --den too"),
        (("--num", "1 0 0", "--den", "1 3", *SECTOR), "improper"),
        ((*THIRD, *SECTOR, "-o", "."), "'.' is a directory; give the name of a file"),
        ((*THIRD, *SECTOR, "-o", "no/cert.json"), "'no' is no directory"),
        ((*THIRD, *SECTOR, "-o", "there.json"), "'there.json' exists; give another name with -o, or --force"),
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
