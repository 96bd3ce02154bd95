"""The readers of files under fuzzing: a seeded sample of each, and what it has found."""

import importlib.util
import json
import sys
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from depth import sampled

from lure import InputError
from lure.analysis.certificates.second import recheck
from lure.analysis.cli import main
from lure.analysis.measured.reading import read_measurements
from lure.analysis.measured.table import _NUMBER
from lure.analysis.sweeps.reading import read_study
from lure.exact import exact_number
from lure.files import parse_system
from lure.networks.reading import read_network
from lure.nonlinearities.points_file import points_from_csv

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
CERTIFICATES = Path(__file__).parents[1] / "support" / "certificates.json"


READERS = (
    *("systems", "studies", "certificates", "networks", "tables", "formulas", "weights", "points"),
    *("transfer functions", "commands"),
)


@pytest.fixture(scope="module")
def fuzzing():
    sys.path.append(str(BENCHMARKS))
    spec = importlib.util.spec_from_file_location("fuzz_readers", BENCHMARKS / "fuzz_readers.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path.remove(str(BENCHMARKS))


@pytest.mark.parametrize("name", READERS)
def test_whatever_a_file_holds_its_reader_answers_or_says_why_not(fuzzing, name, monkeypatch):
    monkeypatch.setattr(fuzzing.signal, "setitimer", lambda *_: None)
    fuzz, corpus = fuzzing.readers()[name]
    counts = Counter()
    for i in range(sampled(8, of=2000)):
        fuzzing.FAULT.clear()
        fuzzing.fuzzed(fuzz, np.random.default_rng([1, i]), counts, corpus)
        assert fuzzing.FAULT == []
    assert counts["read"] > 0


def test_a_fault_of_a_reader_is_kept(fuzzing, monkeypatch):
    monkeypatch.setattr(fuzzing.signal, "setitimer", lambda *_: None)
    monkeypatch.setattr(fuzzing, "read_measurements", lambda text: {}["no sentence"])
    fuzz, corpus = fuzzing.readers()["tables"]
    fuzzing.FAULT.clear()
    fuzzing.fuzzed(fuzz, np.random.default_rng(1), Counter(), corpus)
    assert "KeyError" in fuzzing.FAULT[0]


# A cell of ten thousand digits and a letter took seconds: the expression tried every place for the missing point.
def test_many_digits_are_seen_to_be_no_number_at_once():
    assert not _NUMBER.fullmatch("9" * 400_000 + "x")
    assert all(_NUMBER.fullmatch(text) for text in ("12.", "-1.5e-3", ".5", "7"))
    assert not _NUMBER.fullmatch(".")


@pytest.mark.parametrize(
    "heading", ["depth [um" + "(" * 3000 + ", force (mN)", ",".join(f"column {i}" for i in range(500))]
)
def test_a_long_heading_is_not_told_at_length(heading):
    rows = "\n".join(",".join(["1"] * (heading.count(",") + 1)) for _ in range(4))
    with pytest.raises(InputError) as caught:
        read_measurements(f"{heading}\n{rows}\n")
    assert len(str(caught.value)) < 700


def test_a_parameter_that_is_no_word_is_escaped():
    text = '[plant]\ntransfer = "1/(s+1)"\n[plant.parameters]\n"a\\u0000" = [2, 1]\n'
    with pytest.raises(InputError, match="must not be the larger") as caught:
        parse_system(text, name="loop", source="loop.toml")
    assert str(caught.value).isprintable()


def test_a_row_that_is_a_number_beside_parameters_is_refused():
    text = '[plant]\nA = [0, ["k"]]\nB = [0, 1]\nC = [1, 0]\n[plant.parameters]\nk = [1, 2]\n'
    with pytest.raises(InputError, match="A is square"):
        parse_system(text, name="loop", source="loop.toml")


def test_what_is_no_number_is_told_in_short():
    with pytest.raises(InputError) as caught:
        exact_number([["a" * 30] * 9] * 9, "entry")
    assert len(str(caught.value)) < 160


# A header may ask for terabytes, and the compressed bytes be none: numpy and zlib then raise errors of their own.
@pytest.mark.parametrize("count", [4, 2**40])
def test_an_archive_that_cannot_be_unpacked_is_refused(tmp_path, count):
    path = tmp_path / "network.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as held, held.open("W1.npy", "w") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (count,)})
        file.write(bytes(32))
    data = bytearray(path.read_bytes())
    if count == 4:
        data[40:44] = b"\xff\xff\xff\xff"
    path.write_bytes(data)
    with pytest.raises(InputError, match="is no archive of arrays"):
        read_network(path, activation="tanh")


def test_an_archive_that_unpacks_to_too_much_is_not_unpacked(tmp_path):
    np.savez_compressed(tmp_path / "network.npz", W1=np.zeros((1500, 1500)), W2=np.zeros((1, 1500)))  # 18 MB
    with pytest.raises(InputError, match="unpacks to more than 16 MiB"):
        read_network(tmp_path / "network.npz", activation="tanh")


def test_names_of_arrays_are_told_in_printable_signs(tmp_path):
    np.savez(tmp_path / "network.npz", **{"a\n1": np.eye(2), "b\x002": np.eye(2)})
    with pytest.raises(InputError, match="are not told apart by numbers alone") as caught:
        read_network(tmp_path / "network.npz", activation="tanh")
    assert str(caught.value).isprintable()


def test_too_few_rows_are_counted_and_of_no_branch(tmp_path, capsys):
    path = tmp_path / "table.csv"
    path.write_text("depth [um], force (mN)\n0, 0\n2, 8\n4, 16\n")
    assert main(["sector", str(path), "--fit"]) == 2
    assert "there are 3 rows; give at least 12" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["2e400", "9" * 400, "0." + "1" * 100_000])
def test_a_point_beyond_the_doubles_is_refused(tmp_path, word):
    path = tmp_path / "points.csv"
    path.write_text(f"0 0\n{word} 1\n1 2\n")
    with pytest.raises(InputError, match=r"points\.csv, line 2: .* is beyond the largest double") as caught:
        points_from_csv(path)
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "No such command '999"),
        (["verify"], "'999"),
        (["report"], "there is no built-in system"),
        (["report", "third-order", "-o"], "'999"),
        (["certify", "third-order", "--sector", "0", "2", "-o"], "'999"),  # ended in a traceback, as does the next
        (["init", "--loop"], "'999"),
    ],
)
def test_arguments_are_not_quoted_at_length(capsys, words, sentence):
    assert main([*words, "9" * 10_000]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"lure: {sentence}")
    assert len(said) < 600


def test_an_exponent_beyond_those_of_decimals_is_refused(tmp_path):
    path = tmp_path / "network.json"
    path.write_text('{"weights": [[[1e99999999999999999999]]]}')
    with pytest.raises(InputError, match="is no JSON"):
        read_network(path)


@pytest.mark.parametrize("text", ["9" * 5000, "[" * 100_000, "{", '{"a": 1.5}'])
def test_what_is_no_json_is_refused_in_words_by_the_second_checker(text):
    opinion = recheck(text)
    assert not opinion.accepted
    assert "Error" not in opinion.reason


def test_a_saturation_that_bends_beyond_the_doubles_is_refused():
    text = '[plant]\nnum = [1]\nden = [1, 2]\n[nonlinearity]\nkind = "saturation"\ngain = 1e-300\nlimit = 1e200\n'
    with pytest.raises(InputError, match="beyond the largest double"):
        parse_system(text, name="loop", source="loop.toml")


def test_a_kind_that_is_a_list_is_refused_in_words():
    certificate = json.loads(CERTIFICATES.read_text())["popov"]
    certificate["system"]["kind"] = ["transfer"]
    assert not (opinion := recheck(certificate)).accepted
    assert "Error" not in opinion.reason


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('system = "' + 5000 * "9" + '"\nask = "rod"\n[over]\n"rod.damping" = [1, 2]\n', "no built-in system '999"),
        ('system = "paper-rod"\nask = "rod"\n[over]\n"a\\n" = [1, 2]\n', "is no key"),
        ('system = "paper-rod"\nask = "rod"\n[over]\n' + "a." * 900 + "b = [1, 2]\n", "is no key"),
        ('system = "paper-rod"\nask = "rod"\n[over."rod.gap"]\n[draw]\ncount = 2\n', "over are empty"),
        (f"chunk = {'9' * 5000}\n", "a whole number has more than 4300 digits"),
        ("a." * 1001 + "b = 1\n", "more than 1000 points"),
        ("#" * 70_000, "at most 64 KiB"),
    ],
)
def test_a_study_is_refused_in_one_sentence(tmp_path, text, sentence):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=sentence) as caught:
        read_study(path)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400
    with pytest.raises(InputError, match="cannot be read"):
        read_study(tmp_path / ("9" * 5000))
