"""The answer to "for which sector or slope is this loop stable, and how do you know?"."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from lure.analysis.certificates.arithmetic import extended
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.systems import class_entries
from lure.analysis.drawing import drawing
from lure.analysis.numerics.doubles import bound_above, bound_below, double_above, double_below
from lure.analysis.numerics.evidence import ends
from lure.analysis.questions.conclusion import Conclusion, MismatchError
from lure.analysis.theorems.table import Question
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict, Witness
from lure.analysis.wording import BEYOND, kind_words
from lure.classes import Diagonal
from lure.record import Column, Page, Record, derived, described, plain, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.drawing import Axes
    from lure.analysis.questions.problem import Problem

# Answers as tables for a notebook and as datasets: the verdict, what it rests on, and what it does not say.

CHECK = "Check it again: lure.analysis.check(result.{}.certificate), in exact arithmetic."


def number_or_nan(value: float | None) -> float:
    """The number, nan where there is none."""
    return math.nan if value is None else value


CLOSED, SMALL = 1e-6, 1e-3
Stopped = Literal["time", "interrupt"]


@described(slots=True)
class SoFar:
    """What was found about one question so far: true at any moment, complete if ``stopped`` is None at the end."""

    asked: Problem = quantity("The question")
    answers: list[CriterionResult] = quantity("Of the criteria asked so far", default_factory=list)
    complete: bool = quantity("Whether every step was made that could have found more", default=False)
    stopped: Stopped | None = quantity("What ended the search early", default=None)
    left_out: str = quantity("The steps that could not be made, because a package is missing, and which", default="")


UNFINISHED: Mapping[Stopped, str] = {
    "time": "The time allowed ended the search (LURE-I007): these are the best bounds so far.",
    "interrupt": "The search was interrupted: these are the best bounds so far.",
}


class StabilityBound(Record):
    r"""How far the classes ``[lower, k]`` are stable, from both sides, for ``sigma = H mu``, ``mu = -phi(sigma)``."""

    question: Question = quantity("What ``[lower, k]`` bounds: ``phi(sigma)/sigma``, or every difference quotient")
    criterion: str = quantity("The criterion asked for, or the one with the largest class")
    odd: bool = quantity("Whether the class assumes that ``phi`` is odd")
    time_varying: bool = quantity("Whether the class allows that ``phi`` depends on time")
    lower: Fraction = quantity("Lower end of the classes", plainly=lambda lower: plain(float(lower)))
    critical: bool = quantity(
        "Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): then boundedness is proved for "
        "time-varying nonlinearities (beside dead times what is said of the others too), convergence to the set of "
        "equilibria for the others; else that 0 attracts every solution"
    )
    proviso: str = quantity("What the theorem assumes of the nonlinearities beyond their class; empty if nothing")
    largest: Bracket = quantity(
        "``low``: every class ``[lower, k]``, ``k <= low`` finite, is stable if ``verdict`` is PROVED.  ``high``: at "
        "or above it the criterion (asked for by name) or any criterion (``best``) can say nothing",
        plainly=ends,
    )
    theta: float | None = quantity("Popov multiplier", "s")
    multiplier: str | None = quantity("The multiplier as a formula")
    parameters: Mapping[str, object] = quantity("Numbers behind it, exact ones as text")
    verdict: Verdict = quantity(
        "PROVED: something is, up to ``largest.low``.  REFUTED: the class is never stable, by ``witness``"
    )
    evidence: Evidence = quantity("What ``largest.low`` rests on")
    hurwitz: Bracket = quantity(
        "Supremum of the ``k`` for which every linear gain in ``[lower, k]`` (without 0 in the critical case) is "
        "stable",
        plainly=ends,
    )
    refuted_at: float | None = quantity("The smallest ``k`` found with a destabilising member of the class")
    witness: Witness | None = quantity(
        "That member; where it is ``phi = lower sigma`` and a nonlinear one was found as well, the nonlinear one, "
        "which refutes the classes from its own ``k`` on"
    )
    trivial: Witness | None = quantity(
        "``phi = lower sigma``, which refutes every class, where ``witness`` is a nonlinear member; else None",
        default=None,
    )
    reason: str = quantity("Why nothing was shown, or what would help; empty if the gap is closed")
    stopped: Stopped | None = quantity(
        "What ended the search before it was complete; what is claimed was shown all the same", default=None
    )
    answers: tuple[CriterionResult, ...] = quantity("Every criterion that was tried, the largest class first")
    conclusion: Conclusion = quantity(
        "What follows from what the checker accepted of the proof or, for REFUTED, of the witness", key=""
    )
    subject: str = quantity(
        "What moves, where it has a name: ``the rod``, ``the scheme with 20 cells``; else empty",
        default="",
    )
    classes: Diagonal | None = quantity(
        "With several channels, the classes at the factor 1; then ``k`` is a factor of every upper bound, and "
        "``lower`` is 0",
        default=None,
    )
    _said = "sentence"
    _no_truth = "an answer has three values; compare result.verdict"

    @property
    @derived()
    def closed(self) -> bool:
        """Whether what is proved and what is refuted meet, within one part in a million."""
        if self.verdict is Verdict.REFUTED:
            return self.refuted_at is not None and self.refuted_at <= double_above(self.lower)
        if self.largest.low == math.inf:
            return True
        return self.refuted_at is not None and meet(self.largest.low, self.refuted_at, self.lower)

    @property
    def search_limited(self) -> bool:
        """Whether ``largest.low`` is no end of the criterion, but the largest ``k`` a certificate was tried for."""
        return self.verdict is Verdict.PROVED and bool(self.answers) and self.answers[0].search_limited

    @property
    def unfinished(self) -> str:
        """That the search was ended early, as a sentence; empty if it was not."""
        return "" if self.stopped is None else UNFINISHED[self.stopped]

    @property
    def about(self) -> str:
        """The kind of classes asked about in words, without their bounds; with several channels the classes."""
        if self.classes is not None:
            return f"every upper bound times k: {self.classes}; k in"
        kind = {"odd": self.odd, "time_varying": self.time_varying, "linear": False}
        return kind_words({**kind, "slope": None if self.question == "sector" else ()})

    @property
    @derived()
    def proved_text(self) -> str:
        """The largest ``k`` proved, rounded down, as it is printed everywhere; empty unless PROVED."""
        if self.verdict is not Verdict.PROVED or self.proof is None:
            return ""
        if self.classes is not None:
            return bound_below(self.largest.low)
        end = only_class(self.proof)["sector"][1]
        return _exactly(end, self.largest.low, double_below, bound_below)

    @property
    def proved_up_to(self) -> str:
        """How far a proved class is proved, for a table; it says so where that is only the largest ``k`` tried."""
        if self.classes is not None and self.classes.rectified:  # ReLUs of a smaller factor are other nonlinearities
            return f"{self.proved_text} alone"
        return f"{self.proved_text}, the largest k tried" if self.search_limited else self.proved_text

    @property
    def class_name(self) -> str:
        """The class in a few words."""
        from lure.analysis.questions.channel_kinds import kind_name

        if self.classes is not None:
            return kind_name(self.classes)
        if self.question == "sector":
            return "sector, time-varying" if self.time_varying else "sector"
        return "slope, odd" if self.odd else "slope"

    @property
    @derived()
    def refuted_text(self) -> str:
        """``refuted_at`` rounded up, as it is printed everywhere; empty if nothing is refuted."""
        if self.refuted_at is None:
            return ""
        if self.classes is not None:
            return bound_above(self.refuted_at)
        return _end_text(self.trivial or self.witness, self.refuted_at)

    @property
    def refuted_ends(self) -> str:
        """For which ``k`` a class is refuted where ``verdict`` is REFUTED: for all, or those the certificate is of."""
        start = bound_above(self.lower)
        above = self.refuted_at is not None and self.refuted_at > double_above(self.lower)
        return f"whatever k >= {self.refuted_text}" if above else f"whatever k > {start}"

    @property
    def witness_text(self) -> str:
        """The ``k`` from which ``witness`` refutes, rounded up as it is printed; empty without one."""
        return "" if self.witness is None else _end_text(self.witness, self.witness.k)

    @property
    @derived()
    def gap(self) -> str:
        """``closed`` where what is proved and what is refuted meet, else ``open``; a small gap with its size."""
        low, high = self.largest.low, self.refuted_at
        if self.closed:
            return "closed"
        if self.verdict is not Verdict.PROVED or high is None or not 0 < high - low < SMALL * abs(high):
            return "open"
        return f"closed to {(high - low) / abs(high):.1g}"

    def __post_init__(self) -> None:
        if self.verdict is not self.conclusion.verdict:
            raise TypeError(f"{self.verdict} is not what follows: {self.conclusion}")
        if self.classes is not None:
            self._compare_factors(self.classes)
            return
        shown = self.proof if self.verdict is Verdict.PROVED else None
        if shown is not None and not all(low <= self.lower <= self.largest.low <= high for low, high in _ends(shown)):
            raise MismatchError(f"[{self.lower}, {self.largest.low!r}] is more than its certificate proves")
        first = self.trivial or self.witness
        if self.refuted_at != (None if first is None else first.k):
            raise MismatchError(f"{self.refuted_at!r} is not the end of the class that is refuted")
        for one in (self.witness, self.trivial):
            never = one is not None and one.k <= self.lower and self.verdict is Verdict.REFUTED
            if one is not None and one.refutation is not None and not never and one.k < _needed(one.refutation):
                raise MismatchError(f"[{self.lower}, {one.k!r}] is less than its certificate refutes")

    def _compare_factors(self, classes: Diagonal) -> None:
        """With several channels: the classes of the certificates are those of the factors."""
        proved, refuted = self.proof if self.verdict is Verdict.PROVED else None, self.refutation
        low, high = Fraction(self.largest.low), self.refuted_at
        if proved is not None and not contains(proved.certificate["laws"], class_entries(classes.scaled(low))):
            raise MismatchError(f"the factor {self.largest.low!r} is more than its certificate proves")
        if (high is None) != (refuted is None):
            raise MismatchError(f"{high!r} is not the factor of the classes that are refuted")
        whole = classes if not high else classes.scaled(Fraction(high))
        if refuted is not None and not contains(class_entries(whole), refuted.certificate["laws"]):
            raise MismatchError(f"the factor {high!r} is less than its certificate refutes")

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are made as the answer was: what arrives has been compared with its certificates."""
        return _made, ({part.name: getattr(self, part.name) for part in fields(self)},)

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of the answer with the largest class, with its certificate."""
        return self.answers[0].proof if self.answers else None

    @property
    def refutation(self) -> Refuted | None:
        """What the checker accepted of the witness, with its certificate."""
        return None if self.witness is None else self.witness.refutation

    @property
    def refutations(self) -> tuple[Refuted, ...]:
        """What the checker accepted of ``witness`` and of ``trivial``, in that order."""
        both = (one.refutation for one in (self.witness, self.trivial) if one is not None)
        return tuple(one for one in both if one is not None)

    @property
    def meaning(self) -> str:
        """What is proved of the solutions where ``verdict`` is PROVED; empty else."""
        return self.conclusion.meaning if self.verdict is Verdict.PROVED else ""

    def __str__(self) -> str:
        if self.classes is not None:
            return " ".join(filter(None, (self._factors, self.unfinished)))
        start = bound_above(self.lower)
        span = f"[{start}, {bound_below(self.largest.low)}{')' if self.largest.low == math.inf else ']'}"
        if self.verdict is Verdict.PROVED:
            tried = ", the largest k tried" if self.search_limited else ""
            head = f"{self.conclusion.headline[:-1]}{tried} ({self.criterion}, {self.evidence})"
        elif self.verdict is Verdict.REFUTED:
            head = f"Not stable for {self.about} [{bound_below(self.lower)}, k], {self.refuted_ends}"
        elif self.largest.low > self.lower:
            head = f"Not proved; the inequality of {self.criterion} holds for {span} ({self.evidence})"
        else:
            head = f"Nothing is proved for {self.about} [{start}, k]"
        tail = f"; {self.witness}" if self.witness is not None else ""
        if self.trivial is not None:
            tail = f"; {self.trivial}; from k = {self.witness_text} on also {self.witness}"
        told = self.closed or self.witness is None or self.verdict is Verdict.REFUTED
        between = "" if told else "; in between nothing was shown"
        cure = f" ({self.reason})" if self.verdict is not Verdict.PROVED and self.reason else ""
        return " ".join(filter(None, (f"{head}{tail}{between}{cure}.", self.unfinished)))

    @property
    def _factors(self) -> str:
        """With several channels: both sides in a sentence."""
        parts = []
        if self.verdict is Verdict.PROVED:
            tried = ", the largest factor tried" if self.search_limited else ""
            parts.append(
                f"{self.conclusion.headline[:-1]}: the upper bounds times {self.proved_text}{tried} ({self.criterion}, "
                f"{self.evidence})"
            )
        elif self.verdict is Verdict.INCONCLUSIVE:
            parts.append(f"Nothing is proved for any factor ({self.reason})")
        if self.witness is not None:
            alone = self.classes is not None and self.classes.rectified
            at = f"{'at' if alone else 'within'} {self.refuted_text} times"
            whole = "members whatever the factor" if self.refuted_at == 0 else at
            said, _, does = self.witness.description.partition(" destabil")
            words = f"{said}, {whole}, destabil{does}" if does else f"{said} ({whole})"
            parts.append(f"{words} ({self.witness.evidence})")
        text = "; ".join(parts)
        return f"{text[0].upper()}{text[1:]}."

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar: proved up to its end, refuted from its cross on, unknown in between.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)([self], [self.class_name], ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``, and ``subject`` stands there if it is not empty."""
        found = super().to_dict()
        left_out = [*["subject"] * (not self.subject), *["classes"] * (self.classes is None)]
        return {key: value for key, value in found.items() if key not in left_out}

    def _columns(self) -> dict[str, Column]:
        """Every criterion that was tried, over the dimension ``criterion``."""
        along, answers = ("criterion",), self.answers
        return {
            "criterion": Column(along, [one.criterion for one in answers], "1", "criterion that was tried"),
            "low": Column(along, [one.largest.low for one in answers], "1", "every class up to it, if PROVED"),
            "high": Column(along, [one.largest.high for one in answers], "1", "nothing can be said from it on"),
            "theta": Column(along, [number_or_nan(one.theta) for one in answers], "s", "Popov multiplier"),
            "verdict": Column(along, [str(one.verdict) for one in answers], "1", "verdict of the criterion"),
            "evidence": Column(along, [str(one.evidence) for one in answers], "1", "what it rests on"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "question": self.question,
            "lower": float(self.lower),
            "verdict": str(self.verdict),
            "evidence": str(self.evidence),
            "refuted_at": number_or_nan(self.refuted_at),
            "comment": str(self),
        }

    def _page(self) -> Page:
        """Both sides of the answer, and every criterion that was tried."""
        proved = self.verdict is Verdict.PROVED
        theta = "" if self.theta is None else f", theta = {self.theta:.7g} s"
        rows = [
            ("proved up to k =", self.proved_up_to if proved else "nothing is proved"),
            ("proved by", f"{self.criterion}{theta}") if proved else ("why", self.reason or "-"),
            ("evidence", self.evidence),
            ("refuted from k =", self.refuted_text or "-"),
            ("refuted by", "; ".join(str(one) for one in (self.trivial, self.witness) if one is not None) or "-"),
            ("linear gains", f"stable up to {bound_below(low)}" if (low := self.hurwitz.low) > self.lower else "-"),
            ("in a sentence", str(self)),
        ]
        notes = [BEYOND]
        notes += [CHECK.format("proof")] if proved else []
        notes += [CHECK.format("refutation")] if self.refutation is not None else []
        tried = [
            (one.criterion, one.verdict, one.evidence, bound_below(one.largest.low), one.reason)
            if one.largest.low > self.lower
            else (one.criterion, one.verdict, "-", "-", one.reason)
            for one in self.answers
        ]
        title = str(self.classes or f"{self.about} [{self.lower}, k]") + (f", {self.subject}" if self.subject else "")
        every = Page("Every criterion that was tried", tried, ("criterion", "verdict", "evidence", "largest k", "why"))
        return Page(title, rows, verdict=str(self.verdict), notes=notes, below=[every])


def _made(parts: Mapping[str, Any]) -> StabilityBound:
    return StabilityBound(**parts)


def only_class(shown: Proved | Refuted) -> Mapping[str, Any]:
    """The class of a certificate about one nonlinearity, which may stand in a list of one."""
    laws: Mapping[str, Any] = shown.certificate["laws"]
    found: Mapping[str, Any] = laws["channels"][0] if "channels" in laws else laws
    return found


def _ends(shown: Proved | Refuted) -> list[tuple[Fraction | float, Fraction | float]]:
    """The bounds of the class of a certificate: of the sector, and of the slopes where there are such."""
    nonlinearities = only_class(shown)
    return [
        (extended(low), extended(high))
        for low, high in filter(None, (nonlinearities["sector"], nonlinearities["slope"]))
    ]


def _needed(shown: Refuted) -> Fraction | float:
    """The upper end of the least class with the nonlinearity of a certificate: that of its own, or a constant gain."""
    proof = shown.certificate["proof"]
    proof = proof["proof"] if proof["method"] == "member" else proof  # of one plant of a box
    gain = proof["gains"][0] if proof["method"] in ("late-gains", "late-turns") else proof.get("gain")
    return max(high for _, high in _ends(shown)) if gain is None else Fraction(gain)


def meet(proved: float, refuted: float, lower: float | Fraction = 0) -> bool:
    """Whether what is proved reaches what is refuted, within one part in a million, of ``lower`` where that is about 0.

    ``proved``, ``refuted``: the ends of the two; infinite for every class proved, and for none refuted.
    """
    far = abs(float(lower))
    size = abs(refuted) if abs(refuted) > far / 10**12 else far
    return proved == math.inf or (refuted < math.inf and proved >= refuted - CLOSED * size)


def _end_text(witness: Witness | None, k: float) -> str:
    """The ``k`` of a counterexample as text, from its certificate where it has one."""
    refutation = None if witness is None else witness.refutation
    end = "inf" if refutation is None else only_class(refutation)["sector"][1]
    return _exactly(end, k, double_above, bound_above)


def _exactly(
    end: str, value: float, rounded: Callable[[Fraction], float], text: Callable[[float | Fraction], str]
) -> str:
    """The bound of a certificate as text where the number is that bound, rounded to a double; else the number."""
    exact = Fraction(end) if end not in ("finite", "inf") else None
    return text(exact if exact is not None and rounded(exact) == value else value)
