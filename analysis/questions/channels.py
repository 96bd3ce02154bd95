"""Several nonlinearities, one a channel: the largest factor of their classes that is proved, and one that is refuted.

Searches propose; what is said stands in a certificate that the checker accepted, about the plant and the classes asked
about, which are compared here before anything is worded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from lure.analysis.certificates import codes
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import OTHERS, Proved, Refuted
from lure.analysis.certificates.sealing import Failure, checked, guarded
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.channel_gains import GainSearch
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.inequality.channels import ChannelInequality
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above, double_below
from lure.analysis.numerics.evidence import ends
from lure.analysis.questions.channel_problem import ChannelProblem
from lure.analysis.questions.conclusion import Certification, Conclusion, MismatchError
from lure.analysis.theorems.table import BEST, TABLE, Theorem, time_of
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.analysis.wording import class_words, destroys, meaning
from lure.arrays import np
from lure.errors import InputError
from lure.record import Record, quantity
from lure.record.base import Page

if TYPE_CHECKING:
    from lure.analysis.certificates.proposals import Numbers

Tell = Callable[[str, float], None]
_STEPS_DOWN = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 0.9)
_PRECISION, _LARGEST = 1e-7, 1e6


class ChannelBound(Record):
    """How far the classes of several nonlinearities can be enlarged, from both sides."""

    question: Literal["sector", "slope"] = quantity("what the classes bound")
    verdict: Verdict = quantity("PROVED: stable up to the factor `largest.low`; REFUTED: for no factor")
    evidence: Evidence = quantity("what the verdict rests on")
    criterion: str = quantity("the theorem that reaches farthest")
    largest: Bracket = quantity(
        "`low`: the classes with every upper bound times it are proved; `high`: from there on nothing is",
        "1",
        plainly=ends,
    )
    refuted_at: float | None = quantity("the smallest factor found with a destabilising member", "1", form="above")
    proof: Proved | None = quantity("what the checker accepted, with its certificate", key="", label="")
    refutation: Refuted | None = quantity("what the checker accepted of the counterexample", key="", label="")
    search_limited: bool = quantity("whether `largest.low` is only the largest factor that was tried")
    reason: str = quantity("why nothing more was shown")
    sentence: str = quantity("the answer in a sentence, from the certificates")

    def __bool__(self) -> bool:
        raise TypeError("an answer has three values; compare result.verdict")

    def __str__(self) -> str:
        return self.sentence

    @property
    def closed(self) -> bool:
        """Whether what is proved and what is refuted meet, within one part in a million."""
        if self.refuted_at is None or self.verdict is Verdict.INCONCLUSIVE:
            return False
        return self.verdict is Verdict.REFUTED or self.largest.low >= self.refuted_at * (1 - 1e-6)

    @property
    def meaning(self) -> str:
        """What is proved of the motions; empty unless PROVED."""
        return meaning(self.proof) if self.proof is not None else ""

    def _page(self) -> Page:
        return super()._page()._replace(title=self.sentence, verdict=str(self.verdict))


# Proofs and counterexamples, each through the checker.


def _rows(asked: ChannelProblem) -> list[Theorem]:
    """The criteria for several nonlinearities in this time, the farthest first."""
    wanted = asked.criterion.replace("_", "-").lower()
    found = [row for row in reversed(TABLE) if row.channels and time_of(asked.plant) in row.times]
    if wanted == BEST:
        return found
    named = [row for row in found if wanted in (row.name, row.channels)]
    if not named:
        names = ", ".join(row.name for row in found)
        raise InputError(
            f"the criterion {asked.criterion!r:.40} is not for several nonlinearities in {time_of(asked.plant)} time; "
            f"choose from {BEST}, {names}"
        )
    return named


def _inequality(asked: ChannelProblem, row: Theorem) -> ChannelInequality:
    A, B, C, D = asked.plant.doubles()
    static = [not any(line) for line in asked.plant.D]
    free = [
        not row.time_varying and alone and not one.time_varying
        for alone, one in zip(static, asked.classes.classes, strict=True)
    ]
    lower = np.array([float(v) for v in asked.lower])
    return ChannelInequality(A, B, C, D, lower, free, not row.time_varying, asked.plant.dt is not None)


def proved_at(asked: ChannelProblem, row: Theorem, inequality: ChannelInequality, alpha: Fraction) -> Proved | None:
    """What the checker accepts for the classes of a factor; None if nothing.

    Parameters
    ----------
    asked : ChannelProblem
        The question.
    row : Theorem
        The criterion.
    inequality : ChannelInequality
        Its inequality.
    alpha : Fraction
        The factor.
    """
    widths = [high - low for high, low in zip(asked.upper(alpha), asked.lower, strict=True)]
    if min(widths) <= 0:
        return None
    for one in inequality.proposals(widths, asked.lower):
        draft = {
            "verdict": "PROVED",
            "system": asked.system,
            "laws": asked.class_entries(alpha),
            "theorem": row.channels,
            "multiplier": one.multiplier,
            "proof": {"method": "matrix", "P": [texts(line) for line in one.rows], "exponent": one.exponent},
        }
        try:
            shown = checked(draft)
        except Rejected:
            continue
        if isinstance(shown, Proved):
            return shown
    return None


def _farthest(asked: ChannelProblem, row: Theorem, most: float) -> tuple[Fraction, Proved] | None:
    """The largest factor that is proved, below ``most``."""
    inequality = _inequality(asked, row)

    def serves(alpha: float) -> bool:
        if alpha <= asked.least:
            return False
        widths = [float(high - low) for high, low in zip(asked.upper(Fraction(alpha)), asked.lower, strict=True)]
        return min(widths) > 0 and inequality.serves(np.array(widths))

    low, high = _between(asked, serves, most)
    while high - low > _PRECISION * high:
        checkpoint()
        middle = (low + high) / 2 if low > high / 8 else math.sqrt(low * high) if low else high / 8
        if middle * _LARGEST < min(most, 1.0) / _LARGEST:
            return None
        low, high = (middle, high) if serves(middle) else (low, middle)
    for step in _STEPS_DOWN:
        checkpoint()
        alpha = Fraction(double_below(Fraction(low) * (1 - Fraction(step))))
        shown = proved_at(asked, row, inequality, alpha) if alpha > asked.least else None
        if shown is not None:
            return alpha, shown
    return None


def _between(asked: ChannelProblem, serves: Callable[[float], bool], most: float) -> tuple[float, float]:
    """A factor that serves, or 0, and one that does not; just below ``most``, where what is refuted begins, first."""
    if most < math.inf:
        near = [most * (1 - step) for step in (1e-7, 1e-4)]
        served = next((alpha for alpha in near if serves(alpha)), None)
        return (served, served * (1 + 1e-16)) if served == near[0] else (served or 0.0, most)
    low, high = 0.0, max(1.0, 2 * double_above(asked.least))
    while high < _LARGEST and serves(high):
        low, high = high, 4 * high
    return (low, low) if high >= _LARGEST else (low, high)


def _refuted(asked: ChannelProblem, *, most: float) -> tuple[Fraction, Refuted] | None:
    """The smallest factor with destabilising gains that the checker accepts; 0 if they lie in the classes of each."""
    A, B, C, D = asked.plant.doubles()
    one = asked.upper(Fraction(1))
    lower, upper = (np.array([float(v) for v in side]) for side in (asked.lower, one))
    if asked.classes.repeated and len(set(asked.lower)) > 1:
        return None
    search = GainSearch(A, B, C, D, lower, upper, asked.classes.repeated, asked.plant.dt is not None)
    found = search.found(double_above(asked.least), most)
    for gains in search.proposals(*found, most=most) if found is not None else ():
        least = max((g / u for g, u in zip(gains, one, strict=True) if u > 0), default=Fraction(0))
        if math.isinf(most) and least <= 0:  # no gain is positive: they lie in the classes of every factor
            alpha, of = Fraction(0), Fraction(1)
        else:
            alpha = of = Fraction(double_above(least)) if math.isinf(most) else Fraction(most)
        shown = _refutation(asked, gains, of)
        if shown is not None:
            return alpha, shown
    return None


def _refutation(asked: ChannelProblem, gains: Sequence[Fraction], alpha: Fraction) -> Refuted | None:
    draft = {
        "verdict": "REFUTED",
        "system": asked.system,
        "laws": asked.class_entries(alpha),
        "theorem": "counterexample",
        "proof": {"method": "linear-gains", "gains": texts(gains)},
    }
    try:
        shown = checked(draft)
    except (Rejected, InputError):
        return None
    other = shown.certificate["conclusion"] == OTHERS  # refutes nothing where an end of the classes is a critical case
    return shown if isinstance(shown, Refuted) and not other else None


# Answers.


def largest_factor(
    asked: ChannelProblem,
    question: Literal["sector", "slope"],
    *,
    seconds: float | None = None,
    progress: Tell | None = None,
) -> ChannelBound:
    """The largest factor of the classes that is proved, and the smallest found that is refuted.

    Parameters
    ----------
    asked : ChannelProblem
        The question.
    question : {"sector", "slope"}
        What the classes bound.
    seconds : float or None
        Time allowed; what was found until then is said.
    progress : callable, optional
        Told each step and the share done.

    Raises
    ------
    InputError
        There is no such criterion, or an upper bound is not positive, so that no factor enlarges its class.
    """
    if min(asked.upper(Fraction(1))) <= 0:
        raise InputError("an upper bound is not positive; the largest factor is asked of classes with upper bounds > 0")
    rows, tell = _rows(asked), progress or (lambda _step, _done: None)
    against: tuple[Fraction, Refuted] | None = None
    proofs: list[tuple[Fraction, Proved]] = []
    reason, told = "", list[Failure]()

    def searched() -> None:
        nonlocal against
        tell("constant gains", 0.0)
        never = _refutation(asked, asked.lower, Fraction(1)) if _alike(asked) else None
        against = (Fraction(0), never) if never is not None else _refuted(asked, most=math.inf)
        for i, row in enumerate(rows if against is None or against[0] > 0 else ()):
            tell(row.channels, (i + 1) / (len(rows) + 1))
            most = math.inf if against is None else float(against[0])
            found = guarded(row.channels, partial(_farthest, asked, row, most))
            if isinstance(found, Failure):
                told.append(found)
            elif found is not None:
                proofs.append(found)
                break

    def limited() -> None:
        with time_limit(seconds):
            searched()

    ended = guarded("the search", limited)
    if isinstance(ended, Failure):
        told.append(ended)
    reason = str(told[-1]) if told else ("" if proofs else "no diagonal multiplier was found")
    return channel_bound(asked, question, max(proofs, key=lambda one: one[0], default=None), against, reason)


def _alike(asked: ChannelProblem) -> bool:
    return not asked.classes.repeated or len(set(asked.lower)) == 1


def require_same(asked: ChannelProblem, shown: Proved | Refuted, alpha: Fraction) -> None:
    """Compare what the checker accepted with the plant and the classes asked about.

    Parameters
    ----------
    asked : ChannelProblem
        The question.
    shown : Proved or Refuted
        What was accepted.
    alpha : Fraction
        The factor of the classes.

    Raises
    ------
    MismatchError
        They differ: a bug, and nothing is said.
    """
    if shown.certificate["system"] != asked.system or shown.certificate["laws"] != asked.class_entries(alpha):
        raise MismatchError("the certificate is about another plant or other classes than those asked about")


def channel_bound(
    asked: ChannelProblem,
    question: Literal["sector", "slope"],
    proof: tuple[Fraction, Proved] | None,
    against: tuple[Fraction, Refuted] | None,
    reason: str,
) -> ChannelBound:
    """The answer, from what the checker accepted, after it was compared with what was asked.

    Parameters
    ----------
    asked : ChannelProblem
        The question.
    question : {"sector", "slope"}
        What the classes bound.
    proof, against : (Fraction, Proved) and (Fraction, Refuted), or None
        Factors, and what was accepted for the classes of those factors; 0 for gains in the classes of every factor.
    reason : str
        Why nothing more was shown.

    Raises
    ------
    MismatchError
        A certificate is about another plant or other classes: a bug.
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    """
    from lure.analysis.questions.answers import ContradictionError

    for pair, kind in ((proof, Proved), (against, Refuted)):
        if pair is not None:
            require_same(asked, pair[1], pair[0] or Fraction(1))
            if not isinstance(pair[1], kind):
                raise MismatchError(f"a {type(pair[1]).__name__} is offered as a {kind.__name__}")
    if proof is not None and against is not None and proof[0] >= against[0]:
        raise ContradictionError(f"the factor {proof[0]} is proved and {against[0]} refuted; please report the plant")
    never = against is not None and against[0] == 0
    verdict = Verdict.PROVED if proof is not None else Verdict.REFUTED if never else Verdict.INCONCLUSIVE
    low = 0.0 if proof is None else double_below(proof[0])
    refuted_at = None if against is None else double_above(against[0])
    limited = proof is not None and refuted_at is None and low > _LARGEST / 8
    return ChannelBound(
        question=question,
        verdict=verdict,
        evidence=Evidence.CERTIFIED,
        criterion="" if proof is None else proof[1].theorem,
        largest=Bracket(low, math.inf if refuted_at is None else refuted_at),
        refuted_at=refuted_at,
        proof=None if proof is None else proof[1],
        refutation=None if against is None else against[1],
        search_limited=limited,
        reason=reason,
        sentence=_sentence(proof, against, reason, limited=limited),
    )


def _sentence(
    proof: tuple[Fraction, Proved] | None, against: tuple[Fraction, Refuted] | None, reason: str, *, limited: bool
) -> str:
    """The answer in words, all of them from the certificates."""
    parts = []
    if proof is not None:
        shown, tried = proof[1], ", the largest factor tried" if limited else ""
        proviso = f", for which {shown.assumed}" if shown.assumed else ""
        about = classes_words(shown.certificate["laws"])
        parts.append(
            f"{meaning(shown)} for every {about}{proviso}: the upper bounds times {bound_below(proof[0])}{tried} "
            f"({shown.theorem}, certified)"
        )
    elif against is None or against[0] > 0:
        parts.append(f"Nothing is proved for any factor ({reason})")
    if against is not None:
        gains = ", ".join(f"{float(Fraction(g)):.6g}" for g in against[1].certificate["proof"]["gains"])
        whole = "members whatever the factor" if against[0] == 0 else f"within {bound_above(against[0])} times"
        parts.append(f"the gains {gains}, {whole}, {_does(against[1])} (certified)")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def _does(shown: Refuted) -> str:
    """What several gains do."""
    return destroys(shown).replace("destabilises", "destabilise").replace("gives", "give").replace("leaves", "leave")


def classes_words(nonlinearities: Mapping[str, Any], *, inwards: bool = True) -> str:
    """The classes of a certificate in words, channel by channel.

    Parameters
    ----------
    nonlinearities : Mapping
        ``laws`` of a certificate about several nonlinearities.
    inwards : bool
        Whether bounds are rounded into the classes.
    """
    words = [
        class_words(one, inwards=inwards).replace("phi", f"phi_{i}")
        for i, one in enumerate(nonlinearities["channels"], 1)
    ]
    return f"{'; '.join(words)}{', all the same' if nonlinearities['repeated'] else ''}"


def _proved_whole(asked: ChannelProblem, row: Theorem) -> Proved | None:
    return proved_at(asked, row, _inequality(asked, row), Fraction(1))


def certified_channels(
    asked: ChannelProblem, *, seconds: float | None = None, numbers: Numbers = "rationals", progress: Tell | None = None
) -> Certification:
    """A proof or a refutation of exactly these classes, or a code.

    Parameters
    ----------
    asked : ChannelProblem
        The question.
    seconds : float or None
        Time allowed.
    numbers : {"rationals", "decimals as written", "doubles, exactly"}
        Where the numbers came from; not used in the search.
    progress : callable, optional
        Told each search as it begins.
    """
    failures, one, tell = list[Failure](), Fraction(1), progress or (lambda _step, _done: None)

    def attempts() -> Iterator[tuple[str, Callable[[], Proved | Refuted | None]]]:
        def gains() -> Refuted | None:
            found = _refuted(asked, most=1.0)
            return None if found is None else found[1]

        yield "constant gains", gains
        for row in _rows(asked):
            yield row.channels, partial(_proved_whole, asked, row)

    def limited() -> Proved | Refuted | None:
        with time_limit(seconds):
            for name, work in attempts():
                tell(name, 0.0)
                found = guarded(name, work)
                if isinstance(found, Proved | Refuted):
                    return found
                detail = "no diagonal multiplier was found" if name != "constant gains" else "none was found"
                missed = Failure(search=name, code=codes.NO_MULTIPLIER, detail=detail)
                failures.append(found if isinstance(found, Failure) else missed)
        return None

    found = guarded("the search", limited)
    if isinstance(found, Failure):
        failures.append(found)
    elif found is not None:
        require_same(asked, found, one)
        return Certification(conclusion=_concluded(found), detail=found.claim, failures=tuple(failures))
    worst = min(reversed(failures), key=lambda failure: codes.WORST.index(failure.code))
    detail = f"{worst.search}: {worst.detail}"
    head = f"Nothing is decided for {classes_words(asked.class_entries(one))}"
    nothing = Conclusion(
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        headline=f"{head}.",
        sentence=f"{head}: {detail} ({worst.code.identifier}).",
        reason=detail,
        code=worst.code,
    )
    return Certification(conclusion=nothing, detail=detail, failures=tuple(failures))


def _concluded(shown: Proved | Refuted) -> Conclusion:
    """The verdict on the classes of a certificate, which are those asked about."""
    proved = isinstance(shown, Proved)
    about = classes_words(shown.certificate["laws"], inwards=proved)
    says = meaning(shown) if isinstance(shown, Proved) else _does(shown)
    proviso = f", for which {shown.assumed}" if shown.assumed else ""
    head = f"{says} for every {about}{proviso}" if proved else f"Some gains of {about} {says}"
    return Conclusion(
        verdict=Verdict.PROVED if proved else Verdict.REFUTED,
        evidence=Evidence.CERTIFIED,
        meaning=says,
        nonlinearity_class=about,
        headline=f"{head}.",
        sentence=f"{head} ({shown.theorem}, certified).",
        shown=shown,
        attracts=proved,
        assumed=(shown.assumed,) if shown.assumed else (),
    )
