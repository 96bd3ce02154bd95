"""What `make quick` runs: tests of what is changed first, then some of every floor."""

from quick import FLOORS, MOST, ROOT, TESTS, chosen, touched

TEXTS = {path: path.read_text("utf-8") for path in sorted(TESTS.rglob("test_*.py"))}


def test_each_floor_has_its_file():
    assert {f"test_{name}" for name in FLOORS} <= {path.stem for path in TEXTS}


def test_tests_that_name_a_changed_module_come_first():
    first = touched(["analysis/theorems/park.py", "README.md"], TEXTS)
    assert "test_park" in {path.stem for path in first}
    assert all("lure.analysis.theorems.park" in TEXTS[path] for path in first)
    assert chosen(["analysis/theorems/park.py"])[: len(first)] == first
    assert touched(["README.md"], TEXTS) == []


def test_a_changed_test_is_run_and_no_change_brings_all():
    own = next(path for path in TEXTS if path.stem == "test_sector")
    assert touched([own.relative_to(ROOT).as_posix()], TEXTS) == [own]
    everything = [path.relative_to(ROOT).as_posix() for path in (ROOT / "lure" / "plants").rglob("*.py")]
    assert len(touched(everything, TEXTS)) == MOST
