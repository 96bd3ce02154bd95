"""How far a solution may go before it decays: a number ``c`` for ``|x(t)| <= c |x(0)| e^(-rate t)``."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

from flint import fmpq_mat

from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import guarded
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for, searches
from lure.analysis.questions.decay_channels import SeveralChannels, accepted
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Evidence
from lure.analysis.wording import class_words
from lure.arrays import np
from lure.errors import AssumptionError, InputError
from lure.exact import exact_number
from lure.files.system import LoopSystem
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import Record, quantity

if TYPE_CHECKING:
    from lure.analysis.questions.channel_proofs import Criterion

_QUADRATIC = ("diagonal-circle", "coupled-circle", "full-block-circle")  # V is x^T P x, and nothing beside it
_ROOM = (1e-9, 1e-6, 1e-3)  # beside eigenvalues in floating point


class Overshoot(Record):
    """``|x(t)| <= constant |x(0)| e^(-rate t)``, or ``rate^t``, for every solution of every loop of a class."""

    rate: Fraction = quantity("The rate, as for :class:`RateBound`", form="nearest")
    discrete: bool = quantity("Whether time is discrete", default=False)
    constant: float = quantity("The number ``c >= 1``: there may be smaller ones", form="above")
    evidence: Evidence = quantity("of the number", default=Evidence.CERTIFIED)
    proof: Proved = quantity(
        "What the checker accepted of the rate", key="certificate", label="", plainly=lambda p: p.certificate
    )
    _said = "sentence"

    def __str__(self) -> str:
        falls = f"{bound_above(self.rate)}^t" if self.discrete else f"exp({bound_above(-self.rate)} t)"
        about = class_words(self.proof.certificate["laws"])
        return f"|x(t)| <= {bound_above(self.constant)} |x(0)| {falls} for {about} ({self.proof.theorem}, certified)."


def overshoot(loop: object, classes: object = None, rate: float | Fraction = 0) -> Overshoot:
    r"""A number ``c`` with ``|x(t)| <= c |x(0)| e^(-rate t)`` for every solution of every loop of the classes.

    .. math:: V = \xi^\top P\,\xi, \quad \xi = e^{rate\,t} x, \quad m\,1 \le P \le M\,1, \quad c = \sqrt{M/m},

    with a ``P`` for which both checkers show that ``V`` falls; ``m`` and ``M`` are rational and exact.

    Parameters
    ----------
    loop : object
        As for :func:`decay_rate`; given by matrices, whose states are meant.
    classes : object
        A class for each channel, in a list; by default those of the loop.
    rate : float or Fraction
        A rate that is proved, and not the last one: the nearer to that, the larger ``c``.

    Raises
    ------
    InputError
        The loop has no states of its own, or ``rate`` is no number, in discrete time none above 0.
    AssumptionError
        No quadratic function was found that shows this rate.
    """
    block: object = loop.block if isinstance(loop, LoopSystem) else loop
    if isinstance(block, RationalPlant) and block.matrices is None:
        raise InputError("the number c is about states, and the plant is given without; give A, B, C and D")
    source, own = loop, loop.nonlinearity_class if isinstance(loop, LoopSystem) and classes is None else None
    if own is not None:
        source, classes = block, [own]
    asked = channel_problem(source, classes)
    if asked.kind != "class":
        raise InputError("no class of nonlinearities is given; give one for each channel, in order")
    several = SeveralChannels(asked)
    if not several.plant.order:
        raise InputError("the plant has no states; a bound of them needs one at least")
    exact = exact_number(rate, "rate")
    if several.discrete and exact <= 0:
        raise InputError(f"rate is {rate!r:.40}; give a factor above 0, such as 0.9")
    system = paced(several.base["system"], exact)
    A, B, C, D = (tuple(tuple(map(Fraction, row)) for row in system[side]) for side in "ABCD")
    scaled = replace(asked, plant=MultivariablePlant(A, B, C, D, several.plant.dt))
    best: tuple[Fraction, Proved] | None = None
    for criterion in criteria_for(scaled):
        if criterion.name in _QUADRATIC:
            work = partial(_proofs, scaled, criterion, several.base | {"rate": str(exact)})
            tried = guarded(criterion.name, work, passing=(TimeoutError,))
            for shown in tried if isinstance(tried, list) else ():
                found = _spread(shown)
                if found is not None and (best is None or found < best[0]):
                    best = found, shown
    if best is None:
        low = bound_below(exact)
        raise AssumptionError(f"no quadratic function shows the rate {low} for these classes; ask for a slower one")
    square = best[0]
    return Overshoot(rate=exact, discrete=several.discrete, constant=_root_above(square), proof=best[1])


def _proofs(scaled: Problem, criterion: Criterion, base: dict[str, Any]) -> list[Proved]:
    """What is accepted of the proposals that have a matrix."""
    classes, shown = scaled.classes, list[Proved]()
    widths = [high - low for high, low in zip(classes.upper, classes.lower, strict=True)]
    for search in searches(scaled, criterion):
        for one in search.proposals(widths, classes.lower):
            checkpoint()
            if "P" in one.proof and "zero" not in one.proof:  # else V has another term
                draft = {
                    "verdict": "PROVED",
                    "theorem": criterion.name,
                    "multiplier": one.multiplier,
                    "proof": one.proof,
                }
                found = accepted(base | draft)
                if isinstance(found, Proved):
                    shown.append(found)
                    break
    return shown


def _spread(shown: Proved) -> Fraction | None:
    """``M/m`` with ``m 1 < P < M 1``, exactly; None if rounding hides it."""
    rows = [[Fraction(v) for v in row] for row in shown.certificate["proof"]["P"]]
    n = len(rows)
    P = [[rows[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
    values = np.linalg.eigvalsh(np.array([[float(v) for v in row] for row in P]))
    for room in _ROOM:
        low, high = Fraction(float(values[0]) * (1 - room)), Fraction(float(values[-1]) * (1 + room))
        if low > 0 and _above(P, low, 1) and _above(P, high, -1):
            return high / low
    return None


def _above(P: list[list[Fraction]], end: Fraction, sign: int) -> bool:
    """Whether ``sign (P - end 1)`` is positive definite, by its leading minors."""
    turned = [[sign * (v - end * (i == j)) for j, v in enumerate(row)] for i, row in enumerate(P)]
    minors = (fmpq_mat([[to_fmpq(v) for v in row[:k]] for row in turned[:k]]).det() for k in range(1, len(P) + 1))
    return all(minor > 0 for minor in minors)


def _root_above(square: Fraction) -> float:
    """A double at or above the root."""
    root = double_above(Fraction(float(square) ** 0.5))
    while Fraction(root) ** 2 < square:
        root = float(np.nextafter(root, np.inf))
    return root
