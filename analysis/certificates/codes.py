"""Why a question ended INCONCLUSIVE, as a code: found by its name, or from the exception that ended a search."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from types import MappingProxyType

from analysis.certificates.code_texts import CODES as CODES
from analysis.certificates.code_texts import Code as Code

REGISTRY: Mapping[str, Code] = MappingProxyType({code.identifier: code for code in CODES})

NO_MULTIPLIER = REGISTRY["LURE-I001"]
NOT_APPLICABLE = REGISTRY["LURE-I002"]
REJECTED = REGISTRY["LURE-I003"]
SOLVER_FAILED = REGISTRY["LURE-I004"]
NO_NUMBERS = REGISTRY["LURE-I005"]
PRECISION = REGISTRY["LURE-I006"]
OUT_OF_TIME = REGISTRY["LURE-I007"]
OUT_OF_MEMORY = REGISTRY["LURE-I008"]
SAMPLED = REGISTRY["LURE-I009"]
COMPUTED = REGISTRY["LURE-I010"]
NO_LOWER_END = REGISTRY["LURE-I011"]
CRITICAL = REGISTRY["LURE-I012"]
DOUBLE_ZERO = REGISTRY["LURE-I013"]
RESIDUE = REGISTRY["LURE-I014"]
ILL_POSED = REGISTRY["LURE-I015"]
ROUGH_LAW = REGISTRY["LURE-I016"]
FOREIGN_LAW = REGISTRY["LURE-I017"]
UNSTABLE = REGISTRY["LURE-I018"]
HIDDEN_MODE = REGISTRY["LURE-I019"]
EVERY_FINITE = REGISTRY["LURE-I020"]
SEVERAL_SOLUTIONS = REGISTRY["LURE-I021"]
DEAD_TIME = REGISTRY["LURE-I022"]
UNPROVED_ORBIT = REGISTRY["LURE-I023"]
UNDAMPED = REGISTRY["LURE-I024"]
RANGE = REGISTRY["LURE-I025"]
DISAGREEMENT = REGISTRY["LURE-I026"]
UNEXPECTED = REGISTRY["LURE-I027"]

# Which failure names the outcome, first to last: what makes the rest doubtful, what may have hidden a proof, what is
# known of the loop, and in the end that nothing was found or nothing applied.
WORST = (
    DISAGREEMENT,
    OUT_OF_TIME,
    OUT_OF_MEMORY,
    UNEXPECTED,
    EVERY_FINITE,
    SEVERAL_SOLUTIONS,
    ROUGH_LAW,
    FOREIGN_LAW,
    ILL_POSED,
    HIDDEN_MODE,
    DOUBLE_ZERO,
    RESIDUE,
    UNSTABLE,
    UNDAMPED,
    SAMPLED,
    NO_LOWER_END,
    DEAD_TIME,
    RANGE,
    PRECISION,
    UNPROVED_ORBIT,
    REJECTED,
    SOLVER_FAILED,
    NO_NUMBERS,
    CRITICAL,
    COMPUTED,
    NO_MULTIPLIER,
    NOT_APPLICABLE,
)

# By the name of the type: numpy, flint and the solvers are not imported to ask about their exceptions.
_TYPES: tuple[tuple[str, Code], ...] = (
    ("TimeoutError", OUT_OF_TIME),
    ("MemoryError", OUT_OF_MEMORY),
    ("RecursionError", OUT_OF_MEMORY),
    ("Rejected", REJECTED),
    ("Malformed", REJECTED),
    ("Uncovered", PRECISION),
    ("LinAlgError", SOLVER_FAILED),
    ("LinAlgWarning", SOLVER_FAILED),
    ("SolverError", SOLVER_FAILED),
    ("DCPError", SOLVER_FAILED),
    ("DGPError", SOLVER_FAILED),
    ("PanicException", SOLVER_FAILED),
    ("NoConvergence", SOLVER_FAILED),
    ("ArpackError", SOLVER_FAILED),
    ("FloatingPointError", NO_NUMBERS),
    ("ZeroDivisionError", NO_NUMBERS),
    ("OverflowError", RANGE),
    ("InvalidOperation", NO_NUMBERS),
)
# By the words of a refusal, the first that occurs: AssumptionError and InputError name the hypothesis that fails.
_WORDS: tuple[tuple[str, Code], ...] = (
    (r"time allowed|timed? ?out|time limit", OUT_OF_TIME),
    (r"out of memory|not enough memory", OUT_OF_MEMORY),
    (r"not well posed|1 \+ k H\(inf\) = 0|1 \+ kappa H\(inf\)", ILL_POSED),
    (r"cancels in H|hidden mode|not seen by input or output", HIDDEN_MODE),
    (r"has multiplicity \d|double (zero|pole)", DOUBLE_ZERO),
    (r"residue", RESIDUE),
    (r"range of double|largest double", RANGE),
    (r"no lower end|finite lower (end|slope|bound)|sector with a finite end", NO_LOWER_END),
    (r"declared (to have|odd)|must vanish at 0|has no value at|known to be among", FOREIGN_LAW),
    (r"locally Lipschitz", ROUGH_LAW),
    (r"with dead time|neutral equation|for dead time|For a DelayBlock|for a DelayBlock", DEAD_TIME),
    (r"pole at (s = )?0|one at z = 1|pole with z\^|critical case cannot", CRITICAL),
    (r"samples|sampled|FrequencyData", SAMPLED),
    (r"computed numbers|given by matrices|StateSpaceBlock", COMPUTED),
    (r"\bpoles? (on|in|outside|that are not stable)|no linear gain stabilises|must be stable|not Hurwitz", UNSTABLE),
    (r"damping|dashpot", UNDAMPED),
    (r"\bnan\b|\binf(inite|s)?\b|not finite|non-finite|infinities|could not be (converted|cast)|shape", NO_NUMBERS),
    (r"singular|infeasible|unbounded problem|did not converge|no convergence|ill-conditioned", SOLVER_FAILED),
    (r"precision|too few digits|digits", PRECISION),
    (r"needs|is for (discrete|continuous) time|is about|does not apply|applies|there are|is evaluated", NOT_APPLICABLE),
)
# What the checker's refusals can say of the loop, and not of the proposal.
_OF_THE_CHECKER = (
    (r"time allowed", OUT_OF_TIME),
    (r"1 \+ [gkl] H\(inf\)", ILL_POSED),
    (r"has a root at 0", CRITICAL),
)
# Which of the words a bare ValueError or a reason may be read by; what a theorem refuses comes as a lure.errors type.
_OF_SOLVERS = frozenset({OUT_OF_TIME, OUT_OF_MEMORY, NO_NUMBERS, SOLVER_FAILED, PRECISION, RANGE})


def find(identifier: str) -> Code | None:
    """The code of that name; small letters, and the number alone, will do.

    Parameters
    ----------
    identifier : str
        ``LURE-I003``, ``I003`` or ``3``.

    Examples
    --------
    >>> print(find("i003"))
    LURE-I003: the checker rejected the proposal
    """
    read = re.fullmatch(r"(?:(?:LURE-)?I)?0*([0-9]{1,3})", identifier.strip().upper())
    return REGISTRY.get(f"LURE-I{int(read[1]):03d}") if read else None


def nearest(identifier: str) -> Code | None:
    """The code whose name is like this text, None if none is.

    Parameters
    ----------
    identifier : str
        What was asked for.
    """
    near = difflib.get_close_matches(identifier.strip().upper()[:40], list(REGISTRY), n=1, cutoff=0.5)
    return REGISTRY[near[0]] if near else None


def code_for(reason: BaseException | str) -> Code:
    """The code of what ended a search: an exception, or the reason in words.

    Every exception has one.  Whoever catches an exception to ask must let ``KeyboardInterrupt`` and ``SystemExit``
    pass: they are the user's, and no result.

    Parameters
    ----------
    reason : BaseException or str
        The exception, or the sentence of a refusal.

    Returns
    -------
    Code
        By the type of the exception, then by its words; ``UNEXPECTED`` for an exception of no known kind, and for a
        sentence of no known words ``NO_MULTIPLIER``.

    Examples
    --------
    >>> print(code_for(ZeroDivisionError("division by zero")))
    LURE-I005: a solver returned no usable numbers
    >>> print(code_for("the loop is not well posed: 1 + k H(inf) = 0 at k = 1"))
    LURE-I015: the loop is not well posed
    """
    if isinstance(reason, str):
        return _by_words(reason) or NO_MULTIPLIER
    names = [kind.__name__ for kind in type(reason).__mro__]
    if "AssumptionError" in names or "InputError" in names:
        return _by_words(str(reason)) or NOT_APPLICABLE
    for name, code in _TYPES:
        if name in names:
            return next((c for words, c in _OF_THE_CHECKER if code is REJECTED and re.search(words, str(reason))), code)
    found = _by_words(str(reason)) if {"ValueError", "ArithmeticError", "RuntimeError"} & set(names) else None
    return found if found in _OF_SOLVERS and found is not None else _by_module(type(reason), names)


def _by_words(text: str) -> Code | None:
    return next((code for words, code in _WORDS if re.search(words, text)), None)


def _by_module(kind: type, names: list[str]) -> Code:
    """What is left: an error of a solver's own, an unusable value, or a bug."""
    if kind.__module__.partition(".")[0] in ("clarabel", "cvxpy", "scipy", "numpy", "flint", "pyo3_runtime"):
        return SOLVER_FAILED
    return NO_NUMBERS if "ValueError" in names or "ArithmeticError" in names else UNEXPECTED
