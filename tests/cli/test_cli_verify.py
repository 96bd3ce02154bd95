"""`lure verify`: certificates accepted, rejected and refused, by two checkers that load no solver."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from commands import SECTOR, THIRD, written

from lure.analysis.certificates import arithmetic
from lure.analysis.certificates.checker import main

ROOT = Path(__file__).parents[2]


@pytest.fixture
def proof(lure, tmp_path):
    lure("certify", *THIRD, *SECTOR, "-o", "proof.json")
    return written(tmp_path, "proof.json")


def test_a_false_claim_is_rejected_with_the_reason(lure, tmp_path, proof):
    proof["laws"]["sector"][1] = "6"
    (tmp_path / "false.json").write_text(json.dumps(proof))
    status, out, err = lure("verify", "false.json")
    assert (status, err) == (11, "")
    assert out.startswith("REJECTED: ")
    (answer,) = json.loads(lure("verify", "false.json", "--json")[1])
    assert answer["result"] == "REJECTED"
    assert answer["reason"]
    assert "claim" not in answer


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is no certificate: "),
        (b"not json", "is no certificate: "),
        (b"{}", "is no certificate: "),
        (b"[1, 2]", "is no certificate: "),
        (b"null", "is no certificate: "),
        (b"\xff\xfe\x00", "is no certificate: "),
        (b'{"format": "lure-certificate/1", "format": "lure-certificate/1"}', "twice"),
        (b"[" * 100_000, "is no certificate: "),
        (b"1" * 1_000_000, "is no certificate: "),
        (b" " * 20_000_000, "is no certificate: more than"),
        (b'{"format": 1.5}', "is no certificate: "),
        (b'{"format": NaN}', "is no certificate: "),
    ],
)
def test_what_is_no_certificate_is_one_sentence_and_status_2(lure, tmp_path, content, sentence):
    (tmp_path / "bad.json").write_bytes(content)
    status, out, err = lure("verify", "bad.json")
    assert (status, out) == (2, "")
    assert err.startswith("lure: 'bad.json' is no certificate: ")
    assert err.endswith("; give a file that lure certify wrote\n")
    assert sentence in err
    assert err.count("\n") == 1
    (answer,) = json.loads(lure("verify", "bad.json", "--json")[1])
    assert answer["result"] == "NO CERTIFICATE"


def test_what_is_no_file_is_one_sentence_and_status_2(lure, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for name, sentence in (
        ("missing.json", "does not exist"),
        (".", "is a directory"),
        ("pipe", "is not an ordinary file"),
        ("a\0b", "cannot be read"),
    ):
        status, out, err = lure("verify", name)
        assert (status, out) == (2, "")
        assert sentence in err
        assert err.count("\n") == 1


def test_a_file_of_another_version_is_no_certificate(lure, tmp_path, proof):
    (tmp_path / "next.json").write_text(json.dumps({**proof, "format": "lure-certificate/2"}))
    assert lure("verify", "next.json")[0] == 2
    (tmp_path / "more.json").write_text(json.dumps({**proof, "note": "trust me"}))
    assert lure("verify", "more.json")[0] == 2


def test_several_files_are_each_judged_and_a_rejection_counts_most(lure, tmp_path, proof):
    proof["conclusion"] = "0 attracts every motion"
    (tmp_path / "false.json").write_text(json.dumps(proof))
    status, out, err = lure("verify", "proof.json", "missing.json", "false.json")
    assert status == 11
    assert out.startswith("proof.json:\nACCEPTED: ")
    assert "\nfalse.json:\nREJECTED: " in out
    assert err.count("\n") == 1
    assert lure("verify", "proof.json", "missing.json")[0] == 2
    assert lure("verify", "proof.json", "proof.json")[0] == 0
    assert lure("verify")[0] == 2


@pytest.mark.slow
def test_standard_input_is_read(tmp_path, proof):
    run = subprocess.run(
        [sys.executable, "-m", "lure.analysis.cli", "verify", "-"],
        cwd=ROOT,
        input=json.dumps(proof),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.startswith("ACCEPTED: ")


def test_a_disagreement_of_the_second_checker_is_a_rejection(lure, monkeypatch, proof):
    from lure.analysis.certificates import second

    class No:
        accepted, reason = False, "the residue is not positive"

    assert lure("verify", "proof.json", "--second")[0] == 0
    monkeypatch.setattr(second, "recheck_apart", lambda _certificate, seconds: No)
    status, out, _ = lure("verify", "proof.json", "--second")
    assert status == 11
    assert "REJECTED: the second checker disagrees: the residue is not positive" in " ".join(out.split())
    assert lure("verify", "proof.json")[0] == 0


@pytest.mark.parametrize("error", [MemoryError, RecursionError, TypeError("unhashable"), AssertionError])
def test_a_checker_that_breaks_down_accepts_nothing(lure, monkeypatch, proof, error):
    from lure.analysis.cli import certificates as verifying

    def broken(_data, **_options):
        raise error

    monkeypatch.setattr(verifying, "check", broken)
    status, out, err = lure("verify", "proof.json")
    assert (status, err) == (11, "")
    assert out.startswith("REJECTED: ")


def test_the_time_allowed_to_the_checker_ends_in_a_rejection(lure, monkeypatch, proof):
    monkeypatch.setattr(arithmetic, "DEADLINE", [math.inf])
    status, out, _ = lure("verify", "proof.json", "--seconds", "1e-9")
    assert status == 11
    assert "time allowed" in out
    assert lure("verify", "proof.json", "--seconds", "-1")[0] == 2


DIRECT = ("--num", "1 2", "--den", "1 1")  # H(inf) = 1, and Re H > 0
ASSUMED = "sigma + D phi(sigma) = y, D = 1, has exactly one solution sigma for every y"


def test_what_is_assumed_of_the_equation_of_the_loop_is_said_wherever_it_is_not_shown(lure, tmp_path, capsys):
    # a sector alone lets sigma + phi(sigma) take a value twice; with slopes >= 0 it increases
    for arguments, told in ((SECTOR, [ASSUMED]), (("--slope", "0", "5"), [])):
        (tmp_path / "cert.json").unlink(missing_ok=True)
        status, out, _ = lure("certify", *DIRECT, *arguments, "-o", "cert.json", "--json")
        assert (status, json.loads(out)["assumed"]) == (0, told)
        (tmp_path / "cert.json").unlink()
        said = [lure("certify", *DIRECT, *arguments, "-o", "cert.json")[1], lure("verify", "cert.json", "--second")[1]]
        main([str(tmp_path / "cert.json")])
        for text in (*said, capsys.readouterr().out):
            words = " ".join(text.split())
            assert words.count(ASSUMED) == 2 * len(told)  # in the claim, and by itself
            assert (f" assumed: {ASSUMED}" in words) == bool(told)
        (answer,) = json.loads(lure("verify", "cert.json", "--json")[1])
        assert answer["assumed"] == told
        assert (f", for which {ASSUMED}" in answer["claim"]) == bool(told)


@pytest.mark.slow
def test_the_checker_is_asked_without_numpy_or_a_solver(proof, tmp_path):
    script = (
        "import sys; from lure.analysis.cli import main; status = main(['verify', sys.argv[1]]); "
        "print('LOADED', status, *sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "proof.json")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    status, *loaded = run.stdout.partition("LOADED ")[2].split()
    assert status == "0"
    heavy = {"numpy", "scipy", "sympy", "control", "matplotlib", "flint", "jinja2", "cvxpy"}
    assert not {name.split(".")[0] for name in loaded} & heavy
    assert not [
        name for name in loaded if name.startswith(("lure.plants", "lure.analysis.questions", "lure.analysis.theorems"))
    ]


def test_a_report_is_no_certificate_and_says_where_its_certificates_are(lure, tmp_path):
    listed = [{"file": f"certificates/{name}.json"} for name in ("1-proved-popov", "2-proved-circle")]
    (tmp_path / "out").mkdir()
    report = {"schema": "lure-report/1", "certificates": listed}
    (tmp_path / "out" / "report.json").write_text(json.dumps(report))
    status, out, err = lure("verify", "out/report.json")
    assert (status, out) == (2, "")
    assert err == (
        "lure: 'out/report.json' is a report and no certificate; its certificates are beside it: lure verify "
        "out/certificates/1-proved-popov.json out/certificates/2-proved-circle.json\n"
    )
    (tmp_path / "out" / "report.json").write_text(json.dumps({**report, "certificates": []}))
    assert "nothing in it was certified" in lure("verify", "out/report.json")[2]
