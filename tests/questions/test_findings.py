"""The order of the work: cheap steps first, dear ones only in a gap, and what is found before the time is over."""

import contextlib
import importlib
import json
import math
import signal
import sys
import threading
import time
from contextlib import suppress
from fractions import Fraction

import numpy as np
import pytest

from lure import InputError, NonlinearityClass, RationalPlant, as_plant
from lure.analysis import deadline
from lure.analysis.certificates import codes
from lure.analysis.counterexamples.oscillation import _smallest
from lure.analysis.deadline import checkpoint, time_left, time_limit
from lure.analysis.questions import analyse, max_sector, max_slope, search
from lure.analysis.questions.answers import answers
from lure.analysis.questions.largest import meet
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Verdict

# d + k n = s^3 + (2 + 2k) s^2 + (2 - k) s + 1 is Hurwitz up to 2k^2 - 2k = 3, k = (1 + sqrt 7)/2; Popov ends at 1.49,
# Park's criterion reaches it.
PARK = RationalPlant([2, -1, 0], [1, 2, 2, 1])
HURWITZ = (1 + math.sqrt(7)) / 2
OPEN = as_plant("-s^2/(s^4 + 0.2*s^3 + 6*s^2 + 0.1*s + 1)")  # ct-4: nothing closes it


def said(found):
    """Which criteria said something, and which were not needed."""
    needless = {each.criterion for each in found.answers if each.theorem == "not needed"}
    return {each.criterion for each in found.answers} - needless, needless


@pytest.fixture
def steps(monkeypatch):
    """The criteria asked and the searches made, in order."""
    made = []
    ask, look = search.criterion_answer, search.nonlinear_witnesses
    monkeypatch.setattr(search, "criterion_answer", lambda entry, asked: made.append(entry.name) or ask(entry, asked))
    monkeypatch.setattr(search, "nonlinear_witnesses", lambda asked: made.append("search") or look(asked))
    return made


def test_dear_steps_are_not_made_once_both_sides_meet(steps):
    found = max_slope(PARK)
    assert steps == ["circle", "popov", "park"]
    assert (found.verdict, found.criterion, found.closed) == (Verdict.PROVED, "park", True)
    assert HURWITZ * (1 - 1e-9) < found.largest.low < HURWITZ < found.refuted_at * (1 + 1e-12)
    assert said(found) == ({"circle", "popov", "park"}, {"off-axis-circle", "zames-falb"})
    assert found.answers[-1].reason == "what is proved and what is refuted meet without it"


def test_what_popov_closes_needs_no_criterion_of_slopes(steps):
    assert max_slope(as_plant("1/(s+1)^3"), odd=True).closed  # Hurwitz: 8
    assert steps == ["circle", "popov"]


def test_a_criterion_asked_for_by_name_is_asked(steps):
    found = max_slope(PARK, criterion="zames-falb", search="linear")
    assert steps == ["zames-falb"]
    assert found.criterion == "zames-falb"


@pytest.mark.slow
def test_the_rows_of_an_analysis_share_their_work(steps):
    found = analyse(PARK)
    # the search is for time-varying nonlinearities, the Lyapunov functions for all sectors
    assert sorted(steps) == ["circle", "homogeneous-lyapunov", "park", "popov", "search"]
    assert {row.criterion for row in found.rows} == {"homogeneous-lyapunov", "park"}


@pytest.mark.slow
def test_no_orbit_is_looked_for_where_it_would_contradict_a_proof(monkeypatch):
    # the sector is open above 1.49, but the orbits looked for belong to odd nonlinearities of restricted slope: Park's
    # class
    def refuse(*_arguments, **_options):
        raise AssertionError("an orbit of a class that is proved")

    _smallest.cache_clear()
    monkeypatch.setattr("lure.analysis.counterexamples.oscillation.OrbitSearch", refuse)
    rows = {(row.question, row.odd, row.time_varying): row for row in analyse(PARK).rows}
    assert not rows["sector", False, False].closed
    assert rows["slope", True, False].closed


def test_two_ends_meet_within_a_millionth_on_either_side_of_zero():
    assert meet(1 - 0.9e-6, 1.0)
    assert not meet(1 - 1.1e-6, 1.0)
    assert meet(-1 - 0.9e-6, -1.0)
    assert not meet(-1 - 1.1e-6, -1.0)
    assert meet(math.inf, math.inf)
    assert not meet(1e300, math.inf)
    assert meet(-0.9e-6, 0.0, -1)
    assert not meet(-1.1e-6, 0.0, -1)
    assert not meet(-1e-9, 0.0)


# what is found before the end


def ending(monkeypatch, name, error):
    """The search ends when that criterion is asked."""
    ask = search.criterion_answer

    def asked(entry, question):
        if entry.name == name:
            raise error
        return ask(entry, question)

    monkeypatch.setattr(search, "criterion_answer", asked)


@pytest.mark.parametrize(
    ("error", "why", "words"),
    [
        (TimeoutError("over"), "time", "The time allowed ended the search (LURE-I007)"),
        (KeyboardInterrupt(), "interrupt", "The search was interrupted"),
    ],
)
def test_what_was_found_before_the_end_is_returned_and_said_to_be_that(monkeypatch, error, why, words):
    ending(monkeypatch, "park", error)
    found = max_slope(PARK)
    assert (found.verdict, found.criterion, found.stopped) == (Verdict.PROVED, "popov", why)
    assert found.proof is not None
    assert found.refuted_at == pytest.approx(HURWITZ)
    assert words in str(found)
    assert json.loads(json.dumps(found.to_dict()))["stopped"] == why


def test_an_analysis_keeps_its_finished_rows(monkeypatch):
    ending(monkeypatch, "park", TimeoutError("over"))
    found = analyse(PARK)
    assert found.stopped == "time"
    assert "LURE-I007" in str(found)
    assert all(row.verdict is Verdict.PROVED for row in found.rows)  # circle and Popov in each
    assert found.to_dict()["stopped"] == "time"


def test_an_interrupt_before_anything_was_found_passes(monkeypatch):
    def interrupted(_asked):
        raise KeyboardInterrupt

    monkeypatch.setattr(search, "hurwitz", interrupted)
    with pytest.raises(KeyboardInterrupt):
        max_sector(PARK)


def test_one_class_is_decided_by_what_was_accepted_for_largest_ones_even_when_the_time_is_over(monkeypatch):
    def refuse(*_):
        raise AssertionError("a search of its own")

    monkeypatch.setattr(search, "_own", refuse)
    monkeypatch.setattr(search, "GRACE", 60.0)  # a busy machine
    ending(monkeypatch, "park", TimeoutError("over"))
    inside = Problem.about(PARK, NonlinearityClass.slope_restricted(0, 1))  # Popov's ends at 1.49
    beyond = Problem.about(PARK, NonlinearityClass.slope_restricted(0, Fraction(8, 5)))
    row, proved, open_ = answers([Problem.largest(PARK, "slope", lower=Fraction(0)), inside, beyond])
    assert (row.stopped, row.criterion) == ("time", "popov")
    assert (proved.verdict, proved.shown.theorem) == (Verdict.PROVED, "popov")
    assert (open_.verdict, open_.code) == (Verdict.INCONCLUSIVE, codes.OUT_OF_TIME)


def test_no_time_at_all_shows_nothing_and_says_why():
    found = max_sector(PARK, seconds=1e-9)
    assert (found.verdict, found.stopped, found.answers) == (Verdict.INCONCLUSIVE, "time", ())
    assert found.hurwitz.high == math.inf
    assert "LURE-I007" in found.reason
    rows = analyse(OPEN, seconds=1e-9)
    assert (rows.verdict, rows.stopped) == (Verdict.INCONCLUSIVE, "time")
    assert rows.gains  # there is a second to say what is known


def test_the_steps_are_told_with_the_share_behind_them():
    told = []
    max_slope(PARK, progress=lambda step, done: told.append((step, done)))
    assert [step for step, _ in told] == ["slope: linear gains", "slope: circle", "slope: popov", "slope: park"]
    assert [done for _, done in told] == sorted(done for _, done in told)
    assert told[0][1] == 0
    assert told[-1][1] < 1


@pytest.mark.parametrize("seconds", [0, -1, math.inf, math.nan, "3", True])
def test_a_time_that_is_none_is_refused(seconds):
    for question in (max_sector, max_slope, analyse):
        with pytest.raises(InputError, match="seconds is"):
            question(PARK, seconds=seconds)


# the limit itself


def test_in_another_thread_the_limit_holds_inside_the_searches():
    ended = []

    def work():
        ended.append(max_slope(OPEN, seconds=0.2).stopped)  # takes seconds on any machine

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert ended == ["time"]
    assert time_left() == math.inf


def test_an_inner_limit_never_prolongs_the_outer_one_and_gives_its_alarm_back():
    with time_limit(1000):
        with time_limit(2000):
            assert time_left() <= 1000
        with time_limit(1) as over:
            assert time_left() <= 1
            assert not over()
        assert 1 < time_left() <= 1000
        assert 1 < signal.getitimer(signal.ITIMER_REAL)[0] <= 1000
        with time_limit(None):
            assert time_left() <= 1000
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0


# A package with compiled parts that is imported by half cannot be imported again: the campaign of attacks
# (benchmarks/attacks.py) lost scipy.optimize to an alarm, and each question that needed it from then on.
def test_the_alarm_waits_for_an_import(tmp_path, monkeypatch):
    text = "import signal\nsignal.raise_signal(signal.SIGALRM)\nwhole = True\n"
    (tmp_path / "interrupted_import.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    with time_limit(1000):
        assert importlib.import_module("interrupted_import").whole
        with pytest.raises(TimeoutError):
            signal.raise_signal(signal.SIGALRM)


# The same campaign met alarms that were left on: one between the end of a search and the line that turns them off was
# raised there, and the repeated one from then on wherever the program was.
def test_no_line_on_the_way_in_or_out_of_a_limit_is_broken_off():
    before = signal.getsignal(signal.SIGALRM)
    places = (deadline.__file__, contextlib.__file__)
    lines = set()

    def alarming(frame, event, _):
        if event == "line" and frame.f_code.co_filename in places and callable(signal.getsignal(signal.SIGALRM)):
            lines.add(frame.f_lineno)
            signal.raise_signal(signal.SIGALRM)
        return alarming

    tracing = sys.gettrace()
    sys.settrace(alarming)
    try:
        with time_limit(1000):
            pass
    finally:
        sys.settrace(tracing)
    assert len(lines) > 8
    assert signal.getsignal(signal.SIGALRM) is before
    assert (signal.getitimer(signal.ITIMER_REAL)[0], time_left()) == (0, math.inf)


# And one that left numpy's handler of an eigenvalue routine on: later a division of the caller's raised LinAlgError.
def test_what_numpy_does_with_floating_point_errors_is_reset_whenever_the_alarm_goes_off():
    before, place, lines = np.geterr(), np.errstate.__enter__.__code__.co_filename, set()

    def alarming(frame, event, _):
        if event == "line" and frame.f_code.co_filename == place:
            lines.add(frame.f_lineno)
            signal.raise_signal(signal.SIGALRM)
        return alarming

    tracing = sys.gettrace()
    with time_limit(1000):
        sys.settrace(alarming)
        try:
            with suppress(TimeoutError), np.errstate(all="raise"):
                pass
            with suppress(TimeoutError):
                np.errstate(all="raise")(tuple)()
        finally:
            sys.settrace(tracing)
    assert len(lines) > 8
    assert np.geterr() == before


def test_a_checkpoint_raises_once_the_time_is_over():
    checkpoint()

    def late():
        with time_limit(1e-9):
            while True:
                checkpoint()

    with pytest.raises(TimeoutError):
        late()
    for _ in range(50):  # the alarm may come at any place of the way in or out, and is off in the end
        with suppress(TimeoutError):
            late()
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0


# Fuzzing (benchmarks/fuzzing) met a "bug in lure": the alarm went off where numpy turns every exception into its own.
def test_what_a_library_makes_of_the_alarm_is_the_end_of_the_time(monkeypatch):
    monkeypatch.setattr(np, "common_type", lambda *_: time.sleep(5))
    with pytest.raises(TimeoutError), time_limit(0.01):
        np.polynomial.polyutils.as_series([[1.0, 2.0]])

    def other():
        with suppress(TimeoutError):
            time.sleep(5)
        raise ValueError("of its own")

    with pytest.raises(ValueError, match="of its own"), time_limit(0.01):
        other()


def test_numbers_in_the_report_of_a_stopped_search_are_bounds():
    found = max_sector(RationalPlant([1], [1, 3, 2, 0]), lower=Fraction(1, 3), seconds=1e-9)
    assert found.largest.low <= Fraction(1, 3)
    assert found.critical  # the weaker conclusion, until it is known
