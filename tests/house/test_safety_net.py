"""The safety net finds what it is there for: each kind of change has its rank, and the same answers have none."""

import copy
import importlib
import json
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
LARGEST = {
    "verdict": "PROVED",
    "evidence": "certified",
    "largest": [2.0, 3.0],
    "refuted_at": 5.0,
    "sentence": "so",
    "answers": [
        {"criterion": "circle", "theorem": "a disk", "largest": [1.0, 1.0]},
        {"criterion": "popov", "largest": [2.0, 3.0]},
    ],
}
CASE = {
    "name": "random/0000",
    "status": 0,
    "out": json.dumps(LARGEST),
    "stderr": "",
    "certificates": {"certificate": "a hash"},
    "checked": {"certificate": "0"},
}


@pytest.fixture
def net(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("safety_net")


def ranks(net, capsys, change, before=CASE):
    """The ranks of the differences that a change of the answer makes, and the exit status."""
    after = copy.deepcopy(before)
    out = json.loads(after["out"])
    change(after, out)
    if json.loads(after["out"]) != out:
        after["out"] = json.dumps(out)
    status = net.compare({before["name"]: before}, {before["name"]: after}, rtol=1e-9, most=5)
    found = [line[1] for line in capsys.readouterr().out.splitlines() if line.startswith("(")]
    return "".join(sorted(set(found))), status


def put(key, value):
    return lambda case, out: out.update({key: value})


CHANGES = {
    "nothing": ("", lambda case, out: None),
    "order of the criteria": ("", lambda case, out: out["answers"].reverse()),
    "verdict": ("a", put("verdict", "INCONCLUSIVE")),
    "exit status": ("a", lambda case, out: case.update(status=10)),
    "no answer in time": ("a", lambda case, out: case.update(status=None)),
    "a certificate is refused": ("a", lambda case, out: case["checked"].update(certificate="11")),
    "proved beyond what no multiplier reached": ("a", put("largest", [3.5, 4.0])),
    "proved beyond a counterexample": ("a", put("largest", [5.5, 6.0])),
    "a counterexample within what was proved": ("a", put("refuted_at", 1.5)),
    "less is proved": ("b", put("largest", [1.9, 3.0])),
    "the bound from above is larger": ("b", put("largest", [2.0, "inf"])),
    "one end better, the other worse": ("b", put("largest", [2.5, 3.5])),
    "nothing is proved": ("b", put("largest", None)),
    "no counterexample": ("b", put("refuted_at", None)),
    "evidence": ("b", put("evidence", "computed")),
    "a key is gone": ("b", lambda case, out: out.pop("sentence")),
    "a criterion is gone": ("b", lambda case, out: out["answers"].pop()),
    "more is proved": ("c", put("largest", [2.5, 3.0])),
    "a smaller counterexample": ("c", put("refuted_at", 4.0)),
    "a new key": ("d", put("unit", "N/m")),
    "words": ("e", put("sentence", "thus")),
    "the words of a theorem": ("e", lambda case, out: out["answers"][0].update(theorem="circle criterion")),
    "another certificate": ("e", lambda case, out: case["certificates"].update(certificate="another")),
    "rounding": ("e", put("largest", [2.0 + 1e-15, 3.0])),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_has_its_rank(net, capsys, name):
    rank, change = CHANGES[name]
    assert ranks(net, capsys, change) == (rank, int(rank in ("a", "b")))


# Computed before and certified now, and a bracket where there was none: both are better.
def test_better_evidence_is_better(net, capsys):
    before = CASE | {"out": json.dumps(LARGEST | {"evidence": "COMPUTED", "largest": None})}
    assert ranks(net, capsys, lambda case, out: out.update(LARGEST), before) == ("c", 0)


def test_the_net_holds_its_own_answers_and_resumes(net, tmp_path, capsys, monkeypatch):
    problems = [net.random_case(place) for place in range(4)]
    certified = net.random_case(0) | {
        "name": "random/certified",
        "argv": ["certify", "--num", "1", "--den", "1 1", "--sector", "0", "1", "-o", "DIR/certificate.json"],
    }
    first = net.run([*problems, certified], tmp_path / "old", store=tmp_path / "old", patience=1)
    assert first["random/certified"]["checked"] == {"certificate": "0"}
    with (tmp_path / "old" / "cases.jsonl").open("a") as file:
        file.write('{"name": "cut o')
    assert net.read(tmp_path / "old") == first
    stored = list(net.stored_cases(tmp_path / "old"))
    assert len(stored) == 1
    old = net.run(stored, tmp_path / "old", store=tmp_path / "old", patience=1)
    assert net.read(tmp_path / "old") == old
    with monkeypatch.context() as patch:
        patch.delattr(net, "answered")  # nothing is asked twice
        assert net.run(stored, tmp_path / "old", store=tmp_path / "old", patience=1) == old
    assert net.compared(tmp_path / "old", tmp_path / "new", lambda case: True, rtol=1e-9, most=5) == 0
    assert "6 cases, 6 the same" in capsys.readouterr().out
    content = next((tmp_path / "old" / "certificates").iterdir())
    content.write_text(content.read_text().replace('"theorem"', '"theorems"'))
    assert net.compared(tmp_path / "old", tmp_path / "tampered", lambda case: True, rtol=1e-9, most=5) == 1
    assert "(a) VERDICT CHANGED: /status" in capsys.readouterr().out
