"""Why a question ended INCONCLUSIVE, as a code: found by its name, or by the exception that ended a search."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from types import MappingProxyType

from lure.errors import AssumptionError, InputError, Reason
from lure.record import described, quantity

# Every way in which a question ends INCONCLUSIVE: what happened, what it means, what to try.


@described(frozen=True, kw_only=True, slots=True)
class Code:
    """One way in which a question ends without an answer."""

    reason: Reason = quantity("Its name, ``LURE-I`` and three digits; it keeps its meaning for ever")
    title: str = quantity("What happened, in a few words")
    happened: str = quantity("What happened, in full sentences")
    means: str = quantity("What it does and what it does not mean for the loop")
    tries: tuple[str, ...] = quantity(
        "What to try, each a sentence that ends in a command or names a change of the input"
    )

    @property
    def identifier(self) -> str:
        """The name as text."""
        return self.reason.value

    def __str__(self) -> str:
        return f"{self.identifier}: {self.title}"


_NOTHING = "It means nothing for the loop, which may be stable or not for every nonlinearity of the class."
_OURS = "It says something about the search and nothing about the loop."

CODES = (
    Code(
        reason=Reason.NO_MULTIPLIER,
        title="no multiplier found",
        happened="Every criterion that applies to the class was tried, and none reaches its upper end; the search "
        "for a destabilising nonlinearity of the class found none that could be proved.",
        means="The criteria are sufficient and not necessary: failing them is no sign of instability. The searches "
        "for multipliers and for counterexamples end after a while: another multiplier, or a counterexample, may "
        "exist.",
        tries=(
            "See the largest class that each criterion proves: lure analyse plant.toml",
            "Ask for a smaller upper bound: lure certify plant.toml --sector 0 1",
            "If the nonlinearity has slope bounds, or is odd, say so: lure certify plant.toml --slope 0 1 --odd",
        ),
    ),
    Code(
        reason=Reason.NOT_APPLICABLE,
        title="no criterion applies",
        happened="The criterion asked for, or every one, needs something that the class, the time or the kind of "
        "block does not give: slope bounds, nonlinearities that do not depend on time, continuous or discrete time, a "
        "finite "
        "bound.",
        means=_NOTHING + " Nothing was computed.",
        tries=(
            "Let all criteria try: lure certify plant.toml --criterion best",
            "Give what the criterion needs, such as slope bounds: lure certify plant.toml --slope 0 1",
        ),
    ),
    Code(
        reason=Reason.REJECTED,
        title="the checker rejected the proposal",
        happened="A search proposed a proof, or a counterexample, and the checker, which recomputes everything in "
        "exact arithmetic, did not accept it: rounding spoiled it, or the search was wrong.",
        means=_OURS + " That a proposal is rejected is the checker at work; nothing wrong was reported.",
        tries=(
            "Leave room between the class and the limit: lure certify plant.toml --sector 0 0.99",
            "Take another way to prove it: lure certify plant.toml --method matrix",
        ),
    ),
    Code(
        reason=Reason.SOLVER_FAILED,
        title="a solver failed",
        happened="A numerical solver, a factorisation or an optimiser, stopped with an error: a singular matrix, no "
        "convergence, an infeasible or badly scaled problem.",
        means=_OURS + " An infeasible problem at a solver's tolerance proves nothing either.",
        tries=(
            "Rescale time or gain so that the coefficients are near 1, for instance milliseconds for seconds.",
            "Take the way without a solver: lure certify plant.toml --method polynomial",
        ),
    ),
    Code(
        reason=Reason.NO_NUMBERS,
        title="a solver returned no usable numbers",
        happened="A numerical search returned NaN, infinities or numbers of the wrong shape, whatever status it gave.",
        means=_OURS + " A number that is none proves nothing, and neither does the word optimal beside it.",
        tries=(
            "Rescale time or gain so that the coefficients are near 1.",
            "Take the way without a solver: lure certify plant.toml --method polynomial",
        ),
    ),
    Code(
        reason=Reason.PRECISION,
        title="too few digits",
        happened="The sign of a quantity could not be told at the highest precision the search goes to: the class "
        "ends so close to the criterion's limit that rounding decides.",
        means="At the limit itself a strict inequality fails; this close to it, nothing is known on either side.",
        tries=(
            "Leave room between the class and the limit: lure certify plant.toml --sector 0 0.99",
            "Take the exact way: lure certify plant.toml --method polynomial",
        ),
    ),
    Code(
        reason=Reason.OUT_OF_TIME,
        title="out of time",
        happened="The time allowed ended before the search did.",
        means=_NOTHING,
        tries=(
            "Allow more, in seconds: lure certify plant.toml --seconds 600",
            "Ask one criterion only: lure certify plant.toml --criterion circle",
        ),
    ),
    Code(
        reason=Reason.OUT_OF_MEMORY,
        title="out of memory",
        happened="The search needed more memory than there is, or nested more deeply than Python allows.",
        means=_NOTHING,
        tries=(
            "Give a block of lower order, or a rod of fewer cells: lure certify paper-rod --set "
            "discretisation.cells=10",
        ),
    ),
    Code(
        reason=Reason.SAMPLED,
        title="the block is only sampled",
        happened="The block is a measured frequency response: it is known at some frequencies and nowhere between "
        "them.",
        means="A criterion asks about every frequency, and about the poles; samples, however many, settle neither.",
        tries=("Fit a model and give its coefficients: lure certify --num '1' --den '1 3 2 0' --sector 0 5.9",),
    ),
    Code(
        reason=Reason.COMPUTED,
        title="the block is only computed",
        happened="The block is given by matrices of doubles that are too large for exact polynomials, and the search "
        "in floating point found no matrices that prove the class.",
        means="What is computed in floating point carries an error that nobody bounded; it is a hint and no proof.",
        tries=(
            "Ask for a proof by matrices: lure certify plant.toml --method matrix",
            "Give a smaller class, or coefficients: for these there are more criteria.",
        ),
    ),
    Code(
        reason=Reason.NO_LOWER_END,
        title="the class has no finite lower end",
        happened="The class allows every negative gain: neither its sector nor its slope has a lower bound that a "
        "theorem could start from.",
        means=_NOTHING + " Such a class holds every gain below some number, of which one often destabilises.",
        tries=("Give a lower end: lure certify plant.toml --sector -1 2",),
    ),
    Code(
        reason=Reason.CRITICAL,
        title="critical case, and the theorem needs a stable block",
        happened="The loop with the smallest gain of the class has a pole at 0 (z = 1), and the criteria that remain, "
        "such as order cones, need every pole strictly stable; of several nonlinearities, no weights make the residue "
        "symmetric and positive.",
        means=_NOTHING + " The other criteria have a critical case; they were tried and fall short.",
        tries=(
            "Ask for nonlinearities that are at least a little steep: lure certify plant.toml --slope 0.01 1",
            "Ask Popov's criterion: lure certify plant.toml --criterion popov",
        ),
    ),
    Code(
        reason=Reason.DOUBLE_ZERO,
        title="a double pole at zero",
        happened="The loop with the smallest gain of the class has a multiple pole at 0 (z = 1), and the critical "
        "case of the theorems is that of a simple one.",
        means="Not a formality: for (s + 1)/s^2 every positive linear gain is stable, and phi = sigma exp(-|sigma|) "
        "lets solutions escape to infinity. For a given nonlinearity the loop may still be stable.",
        tries=(
            "If phi(sigma)/sigma stays above a positive number, give the class that lower end: "
            "lure certify plant.toml --sector 0.1 2",
            "A saturation, and any phi whose gain vanishes at infinity, lies in no such class: ask from where "
            "solutions tend to 0, lure region plant.toml, or keep the integrators from winding up (anti-windup).",
        ),
    ),
    Code(
        reason=Reason.RESIDUE,
        title="the residue at zero is not positive",
        happened="The block has a simple pole at 0 whose residue is negative or zero, and the theorems for the "
        "critical case need a positive one.",
        means="With a negative residue small positive gains destabilise, so that the class is not stable for every "
        "nonlinearity; a zero residue means that the pole is hidden. Often the sign of the feedback is turned round.",
        tries=(
            "Here sigma = H mu, mu = -phi(sigma). Give the other sign: lure certify --num '1' --den '1 0' --sector 0 1",
        ),
    ),
    Code(
        reason=Reason.ILL_POSED,
        title="the loop is not well posed",
        happened="For a gain kappa of the class 1 + kappa H(inf) = 0: sigma = H mu, mu = -phi(sigma) has no "
        "solution, or more than one, at that gain.",
        means="It is a property of the model, in which the direct term acts without delay, and no verdict on "
        "stability.",
        tries=(
            "Choose a class without that gain: lure certify plant.toml --sector 0 0.5",
            "Give the block a fast pole, so that H(inf) = 0.",
        ),
    ),
    Code(
        reason=Reason.NOT_LIPSCHITZ,
        title="the nonlinearity is not locally Lipschitz",
        happened="The nonlinearity jumps, or has a vertical tangent, and the theorems for continuous time assume "
        "locally Lipschitz nonlinearities: for others solutions may not exist, or not be unique.",
        means="The class may be proved for all that are locally Lipschitz, and this one is not among them.",
        tries=(
            "Replace the jump by a steep slope, as with the nonlinearity 'relay with slope'.",
            "Ask about the class without the nonlinearity: lure certify plant.toml --sector 0 1",
        ),
    ),
    Code(
        reason=Reason.OUTSIDE_CLASS,
        title="the nonlinearity is not in the class",
        happened="The nonlinearity breaks a bound that the class, or its own declaration, promises.",
        means="A proof for the class would say nothing about this nonlinearity.",
        tries=("Give a class that contains the nonlinearity, or leave the class out: lure certify plant.toml",),
    ),
    Code(
        reason=Reason.UNSTABLE,
        title="the loop is not stable at the lower end of the class",
        happened="With the smallest gain of the class the linear loop has poles that are not stable, and every "
        "theorem here starts from a stable loop at that gain.",
        means="Where the smallest gain belongs to the class, the class is not stable for all of it. A class that "
        "begins at another gain may be.",
        tries=(
            "See which gains are stable: lure analyse plant.toml",
            "Begin the class at such a gain: lure certify --transfer '4/((s-1)*(s/3+1))' --sector 0.3 0.5",
        ),
    ),
    Code(
        reason=Reason.HIDDEN_MODE,
        title="a hidden mode is not stable",
        happened="A mode that is not strictly stable cancels in H: the input does not reach it, or the output does "
        "not see it.",
        means="No feedback moves it, so that it does not come to rest at 0 whatever the nonlinearity; H alone "
        "does not show that.",
        tries=("If the system does not have the mode, cancel the common factor of num and den.",),
    ),
    Code(
        reason=Reason.EVERY_FINITE,
        title="every finite bound is proved, and the class has none",
        happened="The class has no upper bound. For every finite upper bound the criterion holds, in the limit it "
        "does not.",
        means="sigma^3 lies in [0, inf] and in no [0, k]: nonlinearities of unbounded gain are not covered. Each "
        "one with a finite bound, however large, is.",
        tries=("Give the bound that the nonlinearity has: lure certify plant.toml --sector 0 1000000",),
    ),
    Code(
        reason=Reason.SEVERAL_SOLUTIONS,
        title="the loop equation may have several solutions",
        happened="The block has a direct term D, and a nonlinearity of the sector need not make sigma + D phi(sigma) "
        "increasing: Popov's criterion is proved only for nonlinearities for which it is, and no criterion says "
        "anything where "
        "the nonlinearity given is shown to let sigma + D phi(sigma) = y have several solutions.",
        means="For the nonlinearities with slope bounds that keep 1 + D phi' positive the sector is stable.",
        tries=("Give slope bounds: lure certify plant.toml --sector 0 1 --slope -0.5 2",),
    ),
    Code(
        reason=Reason.DEAD_TIME,
        title="dead time that is not covered",
        happened="With dead time the theorems here need a strictly proper block that is stable with the gain of the "
        "class next to 0, or has a simple pole at 0 besides, and a class with two finite bounds.",
        means=_NOTHING,
        tries=(
            "Let the class begin at a gain with which the loop is stable: lure certify --transfer 'exp(-s/5)/(s-1)' "
            "--sector 2 7",
            "Add a fast pole, so that the block is strictly proper: lure certify --transfer 'exp(-s)/(s+1)' --sector "
            "0 1",
        ),
    ),
    Code(
        reason=Reason.UNPROVED_ORBIT,
        title="a counterexample that is not proved",
        happened="A member of the class was found with which the loop seems to oscillate or grow; its orbit could be "
        "followed in floating point, and not proved to exist.",
        means="The class is probably not stable. A simulation shows no orbit, and refutes nothing.",
        tries=(
            "Look at it: lure report plant.toml",
            "Ask for a larger class, in which counterexamples are easier to prove: lure certify plant.toml --slope 0 2",
        ),
    ),
    Code(
        reason=Reason.UNDAMPED,
        title="a rod without damping",
        happened="The rod's dashpot has k = 0: nothing dissipates, and the zero eigenvalue is double.",
        means="The rod keeps its energy, in waves or as a drift; nothing is proved or refuted about how it ends.",
        tries=("Give it some damping: lure certify paper-rod --set rod.damping=2e-4",),
    ),
    Code(
        reason=Reason.RANGE,
        title="numbers beyond the range of doubles",
        happened="A gain, a frequency or a coefficient left the range 1e-308 to 1e308 on the way.",
        means=_OURS,
        tries=("Rescale the units: milliseconds for seconds, or millimetres for metres.",),
    ),
    Code(
        reason=Reason.DISAGREEMENT,
        title="the two checkers disagree",
        happened="The checker accepted a certificate that the second one, independent of it, did not.",
        means="One of the two is wrong. Until it is known which, nothing counts as shown.",
        tries=("Please report it, with the certificate: lure verify cert.json --second",),
    ),
    Code(
        reason=Reason.UNEXPECTED,
        title="an unexpected error inside a search",
        happened="A search stopped with an error that is none of those above.",
        means=_OURS + " It is a bug in lure; nothing wrong was reported.",
        tries=(
            "Ask one criterion at a time: lure certify plant.toml --criterion circle",
            "Please report it with the command and what it prints.",
        ),
    ),
    Code(
        reason=Reason.NO_PACKAGE,
        title="a package is missing",
        happened="The search computes with a package, numpy or scipy, that cannot be imported here.",
        means=_OURS + " It was left out; what was shown without it stands.",
        tries=("Install lure with the packages it asks for: pip install lure",),
    ),
)


REGISTRY: Mapping[str, Code] = MappingProxyType({code.identifier: code for code in CODES})

NO_MULTIPLIER = REGISTRY[Reason.NO_MULTIPLIER]
NOT_APPLICABLE = REGISTRY[Reason.NOT_APPLICABLE]
REJECTED = REGISTRY[Reason.REJECTED]
SOLVER_FAILED = REGISTRY[Reason.SOLVER_FAILED]
NO_NUMBERS = REGISTRY[Reason.NO_NUMBERS]
PRECISION = REGISTRY[Reason.PRECISION]
OUT_OF_TIME = REGISTRY[Reason.OUT_OF_TIME]
OUT_OF_MEMORY = REGISTRY[Reason.OUT_OF_MEMORY]
SAMPLED = REGISTRY[Reason.SAMPLED]
COMPUTED = REGISTRY[Reason.COMPUTED]
NO_LOWER_END = REGISTRY[Reason.NO_LOWER_END]
CRITICAL = REGISTRY[Reason.CRITICAL]
DOUBLE_ZERO = REGISTRY[Reason.DOUBLE_ZERO]
RESIDUE = REGISTRY[Reason.RESIDUE]
ILL_POSED = REGISTRY[Reason.ILL_POSED]
NOT_LIPSCHITZ = REGISTRY[Reason.NOT_LIPSCHITZ]
OUTSIDE_CLASS = REGISTRY[Reason.OUTSIDE_CLASS]
UNSTABLE = REGISTRY[Reason.UNSTABLE]
HIDDEN_MODE = REGISTRY[Reason.HIDDEN_MODE]
EVERY_FINITE = REGISTRY[Reason.EVERY_FINITE]
SEVERAL_SOLUTIONS = REGISTRY[Reason.SEVERAL_SOLUTIONS]
DEAD_TIME = REGISTRY[Reason.DEAD_TIME]
UNPROVED_ORBIT = REGISTRY[Reason.UNPROVED_ORBIT]
UNDAMPED = REGISTRY[Reason.UNDAMPED]
RANGE = REGISTRY[Reason.RANGE]
DISAGREEMENT = REGISTRY[Reason.DISAGREEMENT]
UNEXPECTED = REGISTRY[Reason.UNEXPECTED]
NO_PACKAGE = REGISTRY[Reason.NO_PACKAGE]

# Which failure names the outcome, first to last: what makes the rest doubtful, what may have hidden a proof, what is
# known of the loop, and in the end that nothing was found or nothing applied.
WORST = (
    DISAGREEMENT,
    OUT_OF_TIME,
    OUT_OF_MEMORY,
    UNEXPECTED,
    NO_PACKAGE,
    EVERY_FINITE,
    SEVERAL_SOLUTIONS,
    NOT_LIPSCHITZ,
    OUTSIDE_CLASS,
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
    ("ModuleNotFoundError", NO_PACKAGE),
    ("RecursionError", OUT_OF_MEMORY),
    ("OutOfTime", OUT_OF_TIME),
    ("IllPosed", ILL_POSED),
    ("Critical", CRITICAL),
    ("Rejected", REJECTED),
    ("Malformed", REJECTED),
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
# What solvers say where they raise a bare ValueError or RuntimeError, which has no code to stand on.
_SOLVERS = ("singular", "converge", "infeasible", "unbounded problem", "ill-conditioned")


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


def code_for(error: BaseException) -> Code:
    """The code of the exception that ended a search.

    Every exception has one.  Whoever catches an exception to ask must let ``KeyboardInterrupt`` and ``SystemExit``
    pass: they are the user's, and no result.

    Parameters
    ----------
    error : BaseException
        The exception.

    Returns
    -------
    Code
        The one that an ``AssumptionError`` or ``InputError`` names; else by the type; ``UNEXPECTED`` for an exception
        of no known kind.

    Examples
    --------
    >>> print(code_for(ZeroDivisionError("division by zero")))
    LURE-I005: a solver returned no usable numbers
    >>> print(code_for(AssumptionError("1 + k H(inf) = 0 at k = 1", code=Reason.ILL_POSED)))
    LURE-I015: the loop is not well posed
    """
    if isinstance(error, AssumptionError | InputError):
        return REGISTRY[error.code]
    names = [kind.__name__ for kind in type(error).__mro__]
    for name, code in _TYPES:
        if name in names:
            return code
    failed = type(error) in (ValueError, RuntimeError) and any(word in str(error) for word in _SOLVERS)
    if failed or type(error).__module__.partition(".")[0] in ("clarabel", "cvxpy", "scipy", "numpy", "flint"):
        return SOLVER_FAILED
    return NO_NUMBERS if isinstance(error, ValueError | ArithmeticError) else UNEXPECTED
