"""Solvers that return NaN, nonsense or two digits, that always say optimal, or that raise: nothing false is proved."""

import dataclasses
import sys
from fractions import Fraction

import flint
import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from depth import sampled, thorough
from scipy.optimize import OptimizeResult

from lure import NonlinearityClass, RationalPlant, Sector, StateSpace
from lure.analysis import max_sector, max_slope
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.second import recheck
from lure.analysis.numerics import precision
from lure.analysis.questions.certify import ProofOptions, certify
from lure.analysis.verdict import Verdict
from lure.errors import AssumptionError, InputError

# loaded here, so that their names can be replaced below
from lure.analysis.certificates import matrix, refutations, riccati, multipliers as slack  # noqa: F401  # isort: skip
from lure.analysis.questions import counterexample_search, proofs  # noqa: F401  # isort: skip
from lure.analysis.theorems import phase_limit  # noqa: F401  # isort: skip

THIRD = RationalPlant([1], [1, 3, 2, 0])
MASS = RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], 1)
NOTCH = RationalPlant([1, Fraction("-0.2"), Fraction("-0.1")], [1, 2, 1, 1])
LAGS = StateSpace([[0.0, 1.0], [-2.0, -3.0]], [0.0, 1.0], [1.0, 0.0])

NUMPY = ("solve", "eig", "eigvals", "eigh", "eigvalsh", "inv", "pinv", "svd", "lstsq", "det", "norm", "qr", "cholesky")
SCIPY = ("schur", "eigvals", "solve_triangular", "matrix_balance", "expm", "solve_continuous_are", "solve")


def each_array(found, change):
    """A result with every array and number in it changed."""
    if isinstance(found, OptimizeResult):
        return OptimizeResult({key: each_array(value, change) for key, value in found.items()})
    if isinstance(found, tuple):
        parts = [each_array(part, change) for part in found]
        return type(found)(*parts) if hasattr(found, "_fields") else tuple(parts)
    if isinstance(found, np.ndarray) and found.dtype.kind in "fc":
        return change(found)
    return found.dtype.type(change(np.asarray(found))) if isinstance(found, np.floating | np.complexfloating) else found


def two_digits(array):
    if array.dtype.kind == "c":
        return two_digits(array.real) + 1j * two_digits(array.imag)
    return np.array([float(f"{v:.1e}") for v in array.ravel()]).reshape(array.shape)


CHANCE = np.random.default_rng(4)
CHANGES = {
    "NaN": lambda array: np.full_like(array, np.nan),
    "infinite": lambda array: np.full_like(array, np.inf),
    "zero": np.zeros_like,
    "negative": np.negative,
    "two digits": two_digits,
    "nonsense": lambda array: CHANCE.standard_normal(array.shape).astype(array.dtype),
}
ERRORS = (
    *(np.linalg.LinAlgError("Singular matrix"), ValueError("array must not contain infs or NaNs"), MemoryError()),
    *(ZeroDivisionError("division by zero"), OverflowError("too large"), FloatingPointError("underflow")),
)


def wrapped(solver, fault):
    """A solver that fails in one way."""

    def failing(*arguments, **options):
        if isinstance(fault, Exception):
            raise fault
        if fault == "optimal":
            found = solver(*arguments, **options)
            size = len(np.atleast_1d(arguments[0]))
            if isinstance(found, OptimizeResult):
                found.update(x=np.full(size, 0.25), fun=-1.0, status=0, success=True, message="optimal")
            return found
        return each_array(solver(*arguments, **options), CHANGES[fault])

    return failing


@pytest.fixture
def broken(monkeypatch):
    """Replace the solvers wherever a search has their names."""

    def replace(fault):
        solvers = {getattr(np.linalg, name): (np.linalg, name) for name in NUMPY}
        solvers |= {getattr(scipy.linalg, name): (scipy.linalg, name) for name in SCIPY}
        solvers[scipy.optimize.linprog] = (scipy.optimize, "linprog")
        failing = {id(solver): wrapped(solver, fault) for solver in solvers}
        for solver, (module, name) in solvers.items():
            monkeypatch.setattr(module, name, failing[id(solver)])
        for other in [m for key, m in sys.modules.items() if key.startswith("lure.analysis.")]:
            for at, value in list(vars(other).items()):
                if id(value) in failing:
                    monkeypatch.setattr(other, at, failing[id(value)])

    yield replace
    for module in [module for key, module in sys.modules.items() if key.startswith("lure.analysis.")]:
        for kept in [value for value in vars(module).values() if hasattr(value, "cache_clear")]:
            kept.cache_clear()  # what was found, or not, with broken solvers


def sector(lower, upper, **words):
    return NonlinearityClass(sector=Sector(lower, upper), **words)


# Question, the truth about the class (None: a verdict either way would be wrong or is unknown), and how to look.
# 1/(s(s+1)(s+2)): Routh and Popov 6.  (2 z + 0.92)/(z^2 - z/2): monotone nonlinearities are stable to 0.9114 and have
# an orbit from 175/192 = 0.91146 on.  s/(..) of NOTCH: slopes to 4.5894.  1/((s+1)(s+2)) is stable for every positive
# nonlinearity.
QUESTIONS = {
    "popov": (THIRD, sector(0, Fraction("5.9")), Verdict.PROVED, {"method": "matrix"}),
    "beyond popov": (THIRD, sector(0, Fraction("6.1")), Verdict.REFUTED, {"method": "matrix"}),
    "circle": (LAGS, sector(0, 17), Verdict.PROVED, {}),
    "without an answer": (LAGS, sector(-3, 0), Verdict.REFUTED, {}),  # gains below -2 are unstable, and not looked for
    "taps": (
        MASS,
        NonlinearityClass.slope_restricted(0, Fraction("0.91")),
        Verdict.PROVED,
        {"criterion": "zames-falb"},
    ),
    "beyond taps": (
        MASS,
        NonlinearityClass.slope_restricted(0, Fraction("0.92")),
        Verdict.REFUTED,
        {"criterion": "zames-falb"},
    ),
    "orbit": (MASS, NonlinearityClass.slope_restricted(0, Fraction("0.92")), Verdict.REFUTED, {"seconds": 6}),
    "kernels": (
        NOTCH,
        NonlinearityClass.slope_restricted(0, Fraction("4.5")),
        Verdict.PROVED,
        {"criterion": "zames-falb"},
    ),
    "switching": (
        RationalPlant([1], [1, Fraction("0.1"), 1]),
        sector(0, 3, time_varying=True),
        Verdict.REFUTED,
        {"seconds": 4},
    ),
}
FAULTS = [*CHANGES, "optimal", *ERRORS]
LONG = ("orbit", "switching", "beyond taps")
NAMES = [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in QUESTIONS]
PAIRS = [
    pytest.param(
        *(fault, name),
        marks=[pytest.mark.slow] * (name in LONG)
        + [pytest.mark.thorough] * (fault == "nonsense" and name in ("taps", "beyond taps")),
    )
    for row, fault in enumerate(FAULTS)
    for column, name in enumerate(QUESTIONS)
    if thorough() or (row + column) % 2 == 0  # each solver's failure with half of the questions, as on a chessboard
]


def assert_honest(found, truth):
    """A verdict is the true one, with a certificate that both checkers accept; or there is a code."""
    if found.verdict is Verdict.INCONCLUSIVE:
        assert (found.shown, found.certificate) == (None, None)
        assert found.code is not None
        return
    assert found.verdict is truth
    assert isinstance(found.shown, Proved if truth is Verdict.PROVED else Refuted)
    assert check(found.certificate).claim == found.shown.claim
    assert recheck(found.certificate).accepted


@pytest.mark.slow_for("two digits-taps", "optimal-taps")
@pytest.mark.parametrize(("fault", "name"), PAIRS, ids=lambda f: f if isinstance(f, str) else type(f).__name__)
def test_whatever_the_solvers_return_nothing_false_is_certified(monkeypatch, broken, fault, name):
    block, nonlinearity_class, truth, ways = QUESTIONS[name]
    broken(fault)
    found = certify(block, nonlinearity_class, ways=ProofOptions(**ways))
    monkeypatch.undo()
    assert_honest(found, truth)


@pytest.mark.parametrize("name", NAMES)
def test_with_sound_solvers_the_same_questions_have_their_answers(name):
    block, nonlinearity_class, truth, ways = QUESTIONS[name]
    found = certify(block, nonlinearity_class, ways=ProofOptions(**{**ways, "seconds": None}))
    assert_honest(found, truth)
    assert found.verdict is truth or name in ("beyond taps", "without an answer")


@pytest.mark.parametrize(
    ("bits", "name"),
    [
        *((2, name) for name in ("popov", "beyond popov", "circle", "taps")),
        (8, "circle"),
        *(pytest.param(8, name, marks=pytest.mark.thorough) for name in ("popov", "beyond popov", "taps")),
    ],
)
@pytest.mark.slow
def test_with_two_bits_nothing_false_is_certified(monkeypatch, name, bits):
    block, nonlinearity_class, truth, ways = QUESTIONS[name]
    usual, before = precision.working_precision, flint.ctx.prec

    def coarse(_bits):
        return usual(bits)

    for key, module in list(sys.modules.items()):
        if key.startswith("lure.analysis.") and vars(module).get("working_precision") is usual:
            monkeypatch.setattr(module, "working_precision", coarse)
    flint.ctx.prec = bits
    try:
        found = certify(block, nonlinearity_class, ways=ProofOptions(**ways, seconds=sampled(1, of=5)))
    finally:
        flint.ctx.prec = before
        monkeypatch.undo()
    assert_honest(found, truth)


LARGEST = {
    "sector": (lambda: max_sector(THIRD, criterion="popov"), 6),
    "slope": (lambda: max_slope(MASS, criterion="zames-falb", search="linear"), Fraction(175, 192)),
    "doubles": (lambda: max_sector(LAGS, criterion="circle"), 18),
}


@pytest.mark.slow_for("two digits-slope")
@pytest.mark.parametrize(
    ("fault", "name"),
    [
        pytest.param(fault, name, marks=[pytest.mark.thorough] * ((fault, name) == ("nonsense", "slope")))
        for fault in FAULTS
        for name in LARGEST
    ],
    ids=lambda part: part if isinstance(part, str) else type(part).__name__,
)
def test_the_largest_class_is_never_too_large(monkeypatch, broken, fault, name):
    ask, limit = LARGEST[name]
    broken(fault)
    try:
        found = ask()
    except (AssumptionError, InputError):
        return
    finally:
        monkeypatch.undo()
    if found.verdict is Verdict.PROVED:
        assert found.largest.low <= limit
    assert dataclasses.is_dataclass(found)
