"""Why a question stays open: every exception and refusal has a code, and every code says what to try."""

import os
import pickle
import re
import shlex
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from lure import DelayPlant, ExpressionNonlinearity, FrequencyData, RationalPlant, Sector, SlopeBounds
from lure.analysis.certificates import codes
from lure.analysis.certificates.arithmetic import Critical, IllPosed, OutOfTime, Rejected
from lure.analysis.certificates.codes import CODES, REGISTRY, code_for, find, nearest
from lure.analysis.certificates.covers import Uncovered
from lure.analysis.certificates.drafts import Failure, guarded
from lure.analysis.deadline import time_limit
from lure.analysis.theorems.circle import circle_criterion
from lure.analysis.theorems.order_cone import order_cone_criterion
from lure.analysis.theorems.popov import popov_criterion
from lure.errors import AssumptionError, InputError, Reason

COMMANDS = ("certify", "verify", "explain", "analyse", "report", "systems", "max-sector", "max-slope", "init")


class PanicException(BaseException):
    """What a solver written in Rust raises when it panics: no Exception."""


def test_the_codes_are_numbered_without_a_gap_and_say_everything():
    assert list(REGISTRY) == [f"LURE-I{i:03d}" for i in range(1, len(CODES) + 1)] == list(Reason)
    assert len({code.title for code in CODES}) == len(CODES)
    for code in CODES:
        assert len(code.title) <= 60
        assert code.happened.endswith(".")
        assert code.means.endswith(".")
        assert code.tries


@pytest.mark.parametrize("code", CODES, ids=str)
def test_what_to_try_is_a_command_that_exists(code):
    for text in code.tries:
        _, _, command = text.partition("lure ")
        if command and command.split()[0] in COMMANDS:
            words = shlex.split(command)
            assert all(re.fullmatch(r"-?-?[\w./=:()*+^ -]+", word) for word in words)


def test_the_advice_for_a_double_pole_asks_for_nothing_that_a_saturation_cannot_have():
    # its gain vanishes at infinity: no class with a positive lower end contains it
    conditional, local = codes.DOUBLE_ZERO.tries
    assert conditional.startswith("If phi(sigma)/sigma stays above a positive number, ")
    assert local.startswith("A saturation, ")
    with pytest.raises(AssumptionError, match="a class with a positive lower gain, if phi lies in one"):
        popov_criterion(RationalPlant([1, 1], [1, 0, 0]), Sector(0, 1))


@pytest.mark.parametrize("text", ["LURE-I013", "lure-i013", "I013", "i13", "13", " 013 "])
def test_a_code_is_found_by_any_spelling_of_its_name(text):
    assert find(text) is codes.DOUBLE_ZERO


@pytest.mark.parametrize("text", ["", "LURE", "I", "-1", "1.5", "LURE-I999", "I0", "0", "LURE-I0131", "13a", "𝟙", "\n"])
def test_what_is_no_code_is_not_found(text):
    assert find(text) is None
    assert nearest(text) is None or nearest(text) in CODES


def test_the_nearest_code_is_named():
    assert nearest("LURE-I0133") is codes.DOUBLE_ZERO
    assert nearest("lure-1013") is codes.DOUBLE_ZERO


# exceptions -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (np.linalg.LinAlgError("Singular matrix"), codes.SOLVER_FAILED),
        (type("SolverError", (Exception,), {})("Solver 'CLARABEL' failed."), codes.SOLVER_FAILED),
        (PanicException("called unwrap on a None value"), codes.SOLVER_FAILED),
        (ValueError("array must not contain infs or NaNs"), codes.NO_NUMBERS),
        (ValueError("cannot convert float NaN to integer"), codes.NO_NUMBERS),
        (ValueError("operands could not be broadcast together with shapes (2,) (3,)"), codes.NO_NUMBERS),
        (ValueError("something else"), codes.NO_NUMBERS),
        (ZeroDivisionError("division by zero"), codes.NO_NUMBERS),
        (FloatingPointError("invalid value encountered in divide"), codes.NO_NUMBERS),
        (OverflowError("cannot convert float infinity to integer"), codes.RANGE),
        (MemoryError(), codes.OUT_OF_MEMORY),
        (RecursionError("maximum recursion depth exceeded"), codes.OUT_OF_MEMORY),
        (TimeoutError("the time allowed, 1 s, is over"), codes.OUT_OF_TIME),
        (RuntimeError("the iteration did not converge"), codes.SOLVER_FAILED),
        (KeyError("taps"), codes.UNEXPECTED),
        (AssertionError(), codes.UNEXPECTED),
        (AttributeError("'NoneType' object has no attribute 'value'"), codes.UNEXPECTED),
        (AssumptionError("the criterion park is for continuous time, this block is in discrete"), codes.NOT_APPLICABLE),
        (ValueError("the matrix is singular"), codes.SOLVER_FAILED),
        (RuntimeError("anything else"), codes.UNEXPECTED),
        (InputError("a gain exceeds the range of doubles", code=Reason.RANGE), codes.RANGE),
        (AssumptionError("what is said decides nothing: nan, singular, residue"), codes.NOT_APPLICABLE),
        (IllPosed("1 + g H(inf) vanishes in the class"), codes.ILL_POSED),
        (Critical("d + l n has a root at 0"), codes.CRITICAL),
        (OutOfTime("the time allowed for checking is over"), codes.OUT_OF_TIME),
        (Rejected("1 + g H(inf) = 0"), codes.REJECTED),
        (Uncovered("the inequality does not pass at 1 rad/s"), codes.PRECISION),
    ],
)
def test_every_exception_has_its_code(error, code):
    assert code_for(error) is code


def raised(work, *arguments, **options):
    with pytest.raises((AssumptionError, InputError)) as caught:
        work(*arguments, **options)
    return caught.value


TWO = SlopeBounds(0, 2)


# Refusals provoked from the functions that make them.
@pytest.mark.parametrize(
    ("refusal", "code"),
    [
        # (s+1)/s^2: a double zero; -1/s: residue -1; s/(s(s+1)): a mode at 0 that cancels; 1/(s-1): unstable
        (lambda: raised(popov_criterion, RationalPlant([1, 1], [1, 0, 0]), Sector(0, 1)), codes.DOUBLE_ZERO),
        (lambda: raised(popov_criterion, RationalPlant([-1], [1, 0]), Sector(0, 1)), codes.RESIDUE),
        (lambda: raised(popov_criterion, RationalPlant([1, 0], [1, 1, 0]), Sector(0, 1)), codes.HIDDEN_MODE),
        (lambda: raised(circle_criterion, RationalPlant([1], [1, -1]), Sector(0, 2)), codes.UNSTABLE),
        (lambda: raised(circle_criterion, RationalPlant([1], [1, 0, 1]), Sector(0, 2)), codes.UNSTABLE),
        # H = -1/2 + ...: 1 + 2 H(inf) = 0
        (lambda: raised(circle_criterion, RationalPlant([-1, 0], [2, 1]), Sector(0, 2)), codes.ILL_POSED),
        (
            lambda: raised(circle_criterion, RationalPlant([1], [1, 1]), Sector(-float("inf"), float("inf"))),
            codes.NO_LOWER_END,
        ),
        (lambda: raised(popov_criterion, RationalPlant([1], [1, 1]), Sector(-float("inf"), 0)), codes.NO_LOWER_END),
        (lambda: raised(order_cone_criterion, RationalPlant([1], [1, -1], 1), TWO, odd=False), codes.CRITICAL),
        (lambda: raised(popov_criterion, RationalPlant([1], [1, 0.5], 1), Sector(0, 1)), codes.NOT_APPLICABLE),
        (lambda: raised(delayed, "exp(-s)*s/(s+1)"), codes.DEAD_TIME),
        (lambda: raised(delayed, "exp(-s)/(s-1)"), codes.DEAD_TIME),
        (lambda: raised(delayed, "-exp(-s)/(s*(s+1))"), codes.RESIDUE),
        (lambda: raised(delayed, "(1-exp(-s))/(s*(s+1))"), codes.HIDDEN_MODE),
        (lambda: raised(declared), codes.OUTSIDE_CLASS),
        (lambda: raised(sampled), codes.SAMPLED),
    ],
)
def test_every_refusal_has_its_code(refusal, code):
    error = refusal()
    assert code_for(error) is code
    assert code_for(pickle.loads(pickle.dumps(error))) is code  # a sweep over processes sends it back


def delayed(text):
    from lure.analysis.theorems.other_plants import largest

    largest(DelayPlant.parse(text), "popov")


def declared():
    from lure.nonlinearities import check_declared

    check_declared(ExpressionNonlinearity(text="sigma**3", sector=Sector(0, 2)))


def sampled():
    from lure.analysis.questions.problem import certifiable

    certifiable(FrequencyData([1.0, 2.0], [1.0, 0.5], None))


# guard ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("error", [ValueError("nan"), KeyError("x"), MemoryError(), PanicException("boom")])
def test_a_guarded_failure_is_a_value(error):
    def work():
        raise error

    found = guarded("a search", work)
    assert isinstance(found, Failure)
    assert found.search == "a search"
    assert found.code is code_for(error)
    assert guarded("a search", lambda: 7) == 7


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit])
def test_the_users_interrupt_passes(error):
    def work():
        raise error

    with pytest.raises(error):
        guarded("a search", work)


def test_a_refusal_keeps_its_sentence_and_a_fault_its_type():
    def refuse():
        raise AssumptionError("the residue is -1")

    def fail():
        raise KeyError("taps")

    assert guarded("x", refuse).detail == "the residue is -1"
    assert guarded("x", fail).detail == "KeyError: 'taps'"


def test_the_time_ends_a_search_that_swallows_exceptions():
    alarms = []

    def stubborn():
        for _ in range(3):
            try:
                time.sleep(10)
            except Exception as alarm:
                alarms.append(alarm)
                if len(alarms) == 2:
                    raise

    def limited():
        with time_limit(0.1) as over:
            assert not over()
            stubborn()

    found = guarded("slow", limited)
    assert (found.code, found.detail) == (codes.OUT_OF_TIME, "the time allowed is over")
    assert len(alarms) == 2
    time.sleep(0.6)  # the alarm is off: nothing interrupts this


def test_outside_the_main_thread_the_search_is_asked_to_stop():
    seen = []

    def work():
        with time_limit(0.05) as over:
            seen.append(over())
            time.sleep(0.1)
            seen.append(over())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [False, True]
    with time_limit(None) as over:
        assert not over()


def test_the_codes_need_no_numerical_package():
    script = "import sys, lure.analysis.certificates.codes; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=os.environ)
    assert not {"numpy", "flint", "scipy", "control"} & set(run.stdout.split())
