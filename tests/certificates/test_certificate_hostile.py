"""Files made to break the checker: each ends soon, in little memory, with one line and status 2 or 11."""

import copy
import json
import math
import os
import resource
import signal
import subprocess
import sys
import threading
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
from certificate_family import (
    DRAFTS,
    FAR_KERNEL,
    POLYNOMIAL,
    SCHEME,
    STRUCTURE,
    THIRD,
    certificate,
    draft,
    nonlinearities,
    refutation,
)
from counting import counted
from depth import sampled
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lure.analysis.certificates import arithmetic
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second import recheck

CHECKER = Path(__file__).parents[2] / "analysis" / "certificates" / "checker.py"
HANGS, BYTES = 300, 500 * 2**20
CALLS, LOOKS, ORDER = 10**6, sampled(700, of=2000), sampled(200, of=400)
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are set as linux does")


def limited():
    """In the new process: half as much again as the limit, so that what exceeds it is measured and not killed."""
    resource.setrlimit(resource.RLIMIT_AS, (BYTES * 3 // 2,) * 2)


# A process begins with the peak of the one that starts it, here a worker with all its modules: hence one in between.
START = """
import os, sys
child = os.spawnv(os.P_NOWAIT, sys.executable, [sys.executable, "-I", *sys.argv[2:]])
_, status, used = os.wait4(child, 0)
os.write(int(sys.argv[1]), str(used.ru_maxrss).encode())
sys.exit(os.waitstatus_to_exitcode(status))
"""


def verdict(*paths):
    """Status, stdout and stderr of the checker as a script for some files, within the limit of memory."""
    said, say = os.pipe()
    run = subprocess.Popen(
        [sys.executable, "-I", "-c", START, str(say), str(CHECKER), *map(str, paths)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=limited,
        pass_fds=(say,),
        start_new_session=True,
    )
    os.close(say)
    alarm = threading.Timer(HANGS, os.killpg, (run.pid, signal.SIGKILL))
    alarm.start()
    out, err = run.communicate()
    alarm.cancel()
    used = int(os.read(said, 32))
    os.close(said)
    assert used * 1024 < BYTES
    return run.returncode, out, err


SAID = {2: "NOT A CERTIFICATE", 11: "REJECTED"}


def assert_refused(*paths, statuses=None):
    """Each by one line; all in one process, which so needs at least as much memory as any of them."""
    status, out, err = verdict(*paths)
    said = [line.split(":")[0] for line in out.splitlines()]
    assert (err, len(said), set(said) - {*SAID.values()}) == ("", len(paths), set())
    assert SAID[status] in said
    assert statuses is None or said == [SAID[one] for one in statuses]


def filled(pattern, first=b"[", last=b"[]]"):
    """As much of a pattern as a file may hold."""
    return first + pattern * ((arithmetic.LARGEST_FILE - len(first + last)) // len(pattern)) + last


def changed(name, **parts):
    """A certificate of the family with some of its parts replaced."""
    return {**certificate(name), **parts}


# Each fills memory in its own way: 24 to 60 bytes for every byte of the file, were it read without a look at it before.
WHOLE_FILES = {
    "empty": lambda: b"",
    "zeros": lambda: b"\0" * 1000,
    "no text": lambda: bytes(range(256)),
    "half a character": lambda: b'{"format": "\xff"}',
    "mark of another encoding": lambda: b"\xff\xfe\x00\xd8",
    "a long number": lambda: b'{"format": ' + b"7" * 10_000_000 + b"}",
    "a long number as text": lambda: b'{"format": "' + b"7" * 10_000_000 + b'"}',
    "an exponent": lambda: b'{"format": 1e999999999}',
    "an exponent below": lambda: b"1e-999999999",
    "NaN": lambda: b'{"format": NaN}',
    "infinity": lambda: b"-Infinity",
    "deep lists": lambda: b"[" * 1_000_000 + b"]" * 1_000_000,
    "lists without an end": lambda: b"[" * 1_000_000,
    "deep objects": lambda: b'{"a":' * 1_000_000 + b"0" + b"}" * 1_000_000,
    "deep, but not too many": lambda: b"[" * 90_000 + b"]" * 90_000,
    "empty lists": lambda: filled(b"[],"),
    "lists in lists": lambda: filled(b"[[[[]]]],"),
    "empty objects": lambda: filled(b'{"":{}},'),
    "strings": lambda: filled(b'"ab",'),
    "long characters": lambda: filled('"\U0001f600",'.encode()),
    "integers": lambda: filled(b"999,"),
    "many keys": lambda: b"{" + b",".join(b'"%x":0' % i for i in range(1_000_000)) + b"}",
    "one key many times": lambda: filled(b'"a":0,', b"{", b'"a":0}'),
    "two formats": lambda: b'{"format": "lure-certificate/1", "format": "lure-certificate/1"}',
    "half a pair": lambda: rb'{"format": "\ud800"}',
}


@pytest.mark.parametrize("name", WHOLE_FILES)
def test_what_is_no_certificate_is_refused_soon(name):
    whole = WHOLE_FILES[name]()
    with counted() as work, pytest.raises(Malformed):
        check(whole)
    assert work.calls < CALLS


def test_a_process_refuses_what_is_no_certificate_within_its_memory(tmp_path):
    for name, made in WHOLE_FILES.items():
        (tmp_path / name).write_bytes(made())
    assert_refused(*(tmp_path / name for name in WHOLE_FILES), statuses=[2] * len(WHOLE_FILES))


def test_a_gigabyte_is_not_read(tmp_path):
    (tmp_path / "file").touch()
    os.truncate(tmp_path / "file", 2**30)
    assert_refused(tmp_path / "file", statuses=[2])


def test_what_is_no_ordinary_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "endless").symlink_to("/dev/zero")
    paths = [tmp_path / path for path in ("", "pipe", "loop", "endless", "missing", "missing\nline")]
    assert_refused(*paths, statuses=[2] * len(paths))


def test_a_mark_of_the_encoding_changes_nothing(tmp_path):
    text = json.dumps(certificate("popov"))
    for name in ("utf-8-sig", "utf-16", "utf-32"):
        (tmp_path / "file").write_bytes(text.encode(name))
        assert verdict(tmp_path / "file")[0] == 0


# Parts out of all proportion, in certificates that are otherwise good.
HUGE = {
    "cells": (2, lambda: changed("rod-energy", system={**SCHEME, "cells": 10**9})),
    "taps": (2, lambda: changed("zames-falb, discrete", multiplier={"taps": [[10**9, "1/2"]]})),
    "order of a kernel": (
        2,
        lambda: changed("zames-falb", multiplier={"theta": "0", "kernels": [{**FAR_KERNEL, "order": 10**9}]}),
    ),
    "rate of a kernel": (
        11,
        lambda: changed("zames-falb", multiplier={"theta": "0", "kernels": [{**FAR_KERNEL, "rate": "9" * 4000}]}),
    ),
    "degree": (2, lambda: changed("popov", system={**THIRD, "numerator": ["1"] * 100_000})),
    "degrees": (2, lambda: changed("popov", system={**THIRD, "denominator": ["1"] * 2000})),
    "delays": (2, lambda: changed("circle, dead time", system=delays(20_000))),
    "order of a cover": (
        2,
        lambda: changed("circle, dead time", proof={**certificate("circle, dead time")["proof"], "order": 10**9}),
    ),
    "boxes": (
        2,
        lambda: changed("circle, dead time", proof={"method": "cover", "boxes": [["0", "1"]] * 50_000, "order": 9}),
    ),
    "a far box": (
        11,
        lambda: changed("circle, dead time", proof={"method": "cover", "boxes": [["0", "9" * 4000]], "order": 60}),
    ),
    "exponent": (2, lambda: matrix_proof(exponent=10**9)),
    "largest exponent": (11, lambda: matrix_proof(exponent=10**5)),
    "order of P": (2, lambda: matrix_proof(P=[["1"] * (i + 1) for i in range(600)])),
    "squarings": (2, lambda: switched(squarings=10**9)),
    "bits": (2, lambda: switched(bits=10**9)),
    "bits below": (2, lambda: switched(bits=-(10**9))),
    "long times": (11, lambda: switched(times=["9" * 4000, "1"])),
    "large gains": (11, lambda: switched(gains=["9" * 4000, "1"])),
    "radius": (11, lambda: flow(radius="1/" + "9" * 4000)),
    "bits of an orbit": (2, lambda: flow(bits=10**9)),
    "pieces": (2, lambda: flow(pieces=[0, 1] * 40_000)),
    "piece": (2, lambda: flow(pieces=[10**9, 1])),
    "bound of a class": (11, lambda: changed("popov", laws=nonlinearities(0, "9" * 3999 + "/1234567891"))),
    "name of a theorem": (2, lambda: changed("popov", theorem="\ud800")),
    "theorem of two lines": (2, lambda: changed("popov", theorem="popov\nACCEPTED: everything")),
    "a true sentence": (11, lambda: changed("popov", conclusion="0 attracts every motion\n" * 1000)),
}


def delays(count):
    return {"kind": "delay", "terms": [[str(i), ["1"]] for i in range(count)], "denominator": ["1", "1"]}


def matrix_proof(**parts):
    return changed("popov, matrix", proof={**certificate("popov, matrix")["proof"], **parts})


def switched(**parts):
    return changed("switched gain", proof={**certificate("switched gain")["proof"], **parts})


def flow(**parts):
    return changed("flow-orbit", proof={**certificate("flow-orbit")["proof"], **parts})


@pytest.mark.parametrize("name", HUGE)
def test_parts_out_of_proportion_are_refused_soon(name):
    status, made = HUGE[name]
    text = json.dumps(made())
    with counted() as work, pytest.raises(Malformed if status == 2 else Rejected):
        check(text)
    assert work.calls < CALLS


def test_a_process_refuses_parts_out_of_proportion_within_its_memory(tmp_path):
    for name, (_, made) in HUGE.items():
        (tmp_path / name).write_text(json.dumps(made()))
    assert_refused(*(tmp_path / name for name in HUGE), statuses=[status for status, _ in HUGE.values()])


# Legal, and too much work for the time allowed.  Coefficients with 4000 digits, orders to ORDER.
def long_number(seed):
    return str(seed + 7**4733)[:4000]


def wide(time_, denominator, digits=4000):
    numerator = [long_number(i)[:digits] for i in range(len(denominator) - 1)]
    return {"kind": "transfer", "time": time_, "numerator": numerator, "denominator": denominator}


ROWS = [long_number(i)[:40] for i in range(120)]
POWER = [str(math.comb(ORDER, i)) for i in range(ORDER + 1)]  # (s + 1)^ORDER
EXPENSIVE = {
    "Routh's array": lambda: draft(
        wide("continuous", [str(math.comb(ORDER, i) * 3**i) for i in range(ORDER + 1)]),
        nonlinearities(0, 1),
        "circle",
        {},
    ),
    "a chain of Sturm": lambda: draft(wide("continuous", POWER), nonlinearities(0, 1), "circle", {}),
    "powers": lambda: draft(wide("discrete", ["1"] + ["0"] * ORDER, 300), nonlinearities(0, 1), "circle", {}),
    "constant gains": lambda: draft(wide("continuous", POWER), nonlinearities(0, 1, linear=True), "hurwitz", {}),
    "kernels": lambda: draft(
        THIRD | {"denominator": ["1", "6", "11", "6"]},
        nonlinearities(0, 1, slope=True),
        "zames-falb",
        {
            "theta": "0",
            "kernels": [
                {**FAR_KERNEL, "coefficient": "1/1000", "rate": str(9**99 + i), "order": 20} for i in range(400)
            ],
        },
    ),
    "a sparse order of 700": lambda: draft(
        {
            "kind": "state-space",
            "time": "continuous",
            "A": [["-1" if i == j else "0" for j in range(700)] for i in range(700)],
            "b": ["1"] * 700,
            "c": ["1"] * 700,
            "d": "0",
        },
        nonlinearities(0, 1),
        "circle",
        {},
        {"method": "matrix", "P": [["0"] * i + ["1"] for i in range(700)], "exponent": 0, "zero": None},
    ),
    "a dense order of 120": lambda: draft(
        {"kind": "state-space", "time": "continuous", "A": [ROWS] * 120, "b": ROWS, "c": ROWS, "d": "0"},
        nonlinearities(0, 1),
        "circle",
        {},
        {"method": "matrix", "P": [ROWS[: i + 1] for i in range(120)], "exponent": 0, "zero": None},
    ),
    "cells": lambda: draft({**SCHEME, "cells": 10**6}, nonlinearities(0, "inf"), "rod-energy", {}, STRUCTURE),
    "a crossing": lambda: refutation(
        wide("continuous", [long_number(i) for i in range(sampled(51, of=201))]),
        nonlinearities(0, 1),
        {"method": "crossing", "gains": ["0", "1"], "frequencies": ["1", "2"]},
    ),
    "switches": lambda: refutation(
        {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1"] * 61},
        nonlinearities(0, 1, time_varying=True),
        {"method": "switched-gain", "gains": ["1"] * 2000, "times": ["1"] * 2000, "squarings": 64, "bits": 4096},
    ),
    "pieces": lambda: flow(
        pieces=[0, 1] * 190,
        durations=["1"] * 380,
        inverse=[["1"] * 382] * 382,
        radius="1/1" + "0" * 900,
        bits=4096,
    ),
}
FORM = {"format": "lure-certificate/1", "convention": "sigma = H mu, mu = -phi(sigma)", "numbers": "rationals"}


@pytest.mark.parametrize("name", EXPENSIVE)
def test_what_takes_too_long_ends_in_the_time_allowed(name, monkeypatch):
    text = json.dumps({**FORM, "law": None, **EXPENSIVE[name](), "conclusion": "", "hypotheses": {}})
    looks = [0]

    def clock():
        """A clock that every look at it moves on by a second."""
        looks.append(work.calls)
        return len(looks)

    monkeypatch.setattr(arithmetic, "time", SimpleNamespace(monotonic=clock))
    with counted() as work, pytest.raises(Rejected, match="the time allowed for checking is over"):
        check(text, seconds=LOOKS)
    assert max(after - before for before, after in pairwise(looks)) < CALLS
    assert [math.inf] == arithmetic.DEADLINE


def nodes(tree, path=()):
    """Every part of a certificate, and the path to it."""
    if path:
        yield path, tree
    parts = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, part in parts:
        yield from nodes(part, (*path, key))


def replaced(tree, path, value):
    tree = copy.deepcopy(tree)
    *above, last = path
    place = tree
    for key in above:
        place = place[key]
    place[last] = value
    return tree


WRONG = [None, True, 0, -1, 10**30, "", "x", "0", "-1", "1/0", "inf", "finite", [], {}, [[]], [None], {"kind": []}]
ANYTHING = st.sampled_from(WRONG) | st.recursive(
    st.none() | st.booleans() | st.integers() | st.sampled_from(["0", "1", "1/2", "-inf", "popov", "tanh"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["kind", "method"]), inner),
    max_leaves=5,
)


def answer(data):
    """Whether it is accepted; anything but the two refusals, of one line each, is an error of the test."""
    try:
        check(data, seconds=20)
    except (Rejected, Malformed) as refusal:
        reason = str(refusal)
    else:
        return True
    assert reason
    assert "\n" not in reason
    return False


@pytest.mark.parametrize("name", DRAFTS)
def test_a_wrong_type_anywhere_is_a_refusal(name):
    whole = json.loads(json.dumps(certificate(name)))
    parts = [(path, part) for path, part in nodes(whole) if len(path) <= 5]
    for path, part in parts[:: 1 + len(parts) // sampled(12, of=60)]:
        for value in (None, [], {}, "x", [[None]], 7.5, True, 7):
            same = type(value) is type(part) and (part == value or value in (7, True))  # another count or flag may do
            spare = path in (("law",), ("multiplier", "kernels")) and value in (None, [])  # it may do without
            assert same or spare or not answer(replaced(whole, path, value)), (path, value)


@given(name=st.sampled_from([n for n in DRAFTS if not n.startswith("flow-orbit")]), data=st.data())
@settings(max_examples=sampled(100, of=200))
def test_any_value_in_place_of_any_part_is_answered(name, data):
    whole = json.loads(json.dumps(certificate(name)))
    path = data.draw(st.sampled_from([path for path, _ in nodes(whole)]))
    made = replaced(whole, path, data.draw(ANYTHING))
    assert not answer(made) or recheck(made).accepted


@given(value=ANYTHING)
@example(value={"format": float("nan")})
@example(value={"format": b"bytes"})
@example(value={1: 2})
def test_anything_in_place_of_a_certificate_is_refused(value):
    assert not answer(json.dumps(value, default=str))
    assert not answer(value)


@given(cut=st.integers(0, 2**16), byte=st.binary(max_size=2))
def test_bytes_lost_or_replaced_are_answered(cut, byte):
    text = json.dumps(certificate("popov")).encode()
    cut %= len(text)
    assert not answer(text[:cut] + byte)
    answer(text[:cut] + byte + text[cut + len(byte) :])


def test_the_polynomial_method_needs_nothing_but_its_name_in_a_proof_about_gains():
    assert not answer({**certificate("hurwitz"), "proof": {**POLYNOMIAL, "coefficients": []}})
    assert answer(certificate("hurwitz"))
