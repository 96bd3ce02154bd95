"""The answer to "for which sector or slope is this loop stable, and how do you know?"."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from analysis.answer import Answer
from analysis.answers.catalogue import Question
from analysis.doubles import json_number, text_above, text_below
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.witness import Witness
from lure.showing import plain

if TYPE_CHECKING:
    import xarray

    from analysis.certificates.checker import Proved, Refuted
    from analysis.plots.responses import Axes

CLOSED = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class Largest:
    r"""How far the classes ``[lower, k]`` are stable, from both sides, for ``sigma = H mu``, ``mu = -phi(sigma)``.

    Attributes
    ----------
    question : {"sector", "slope"}
        What ``[lower, k]`` bounds: ``phi(sigma)/sigma``, or every difference quotient.
    odd, time_varying : bool
        What else the class assumes of ``phi``, or allows.
    lower : Fraction
        Lower end of the classes.
    critical : bool
        Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): then boundedness is proved for
        time-varying laws, convergence to the set of equilibria for the others; else that 0 attracts every motion.
    proviso : str
        What the theorem assumes of the laws beyond their class; empty if nothing.
    criterion : str
        The criterion asked for, or the one that reached farthest.
    largest : Bracket
        ``low``: every class ``[lower, k]``, ``k <= low`` finite, is stable if ``verdict`` is PROVED.  ``high``: at or
        above it the criterion (asked for by name) or any criterion (``best``) can say nothing.
    hurwitz : Bracket
        Supremum of the ``k`` for which every linear gain in ``[lower, k]`` (without 0 in the critical case) is stable.
    verdict : Verdict
        PROVED: something is, up to ``largest.low``.  REFUTED: the class is never stable, by ``witness``.
    evidence : Evidence
        What ``largest.low`` rests on.
    theta : float or None
        Popov multiplier [s].
    multiplier : str or None
        The multiplier as a formula.
    parameters : Mapping
        Numbers behind it, exact ones as text.
    refuted_at : float or None
        The smallest ``k`` found with a destabilising member of the class.
    witness : Witness or None
        That member.
    answers : tuple of Answer
        Every criterion that was tried, farthest reach first.
    reason : str
        Why nothing was shown, or what would help; empty if the gap is closed.
    subject : str
        What moves, where it is an approximation of something else: ``the scheme with 20 cells``; else empty.
    """

    question: Question
    odd: bool
    time_varying: bool
    lower: Fraction
    critical: bool
    proviso: str
    criterion: str
    largest: Bracket
    hurwitz: Bracket
    verdict: Verdict
    evidence: Evidence
    theta: float | None
    multiplier: str | None
    parameters: Mapping[str, object]
    refuted_at: float | None
    witness: Witness | None
    answers: tuple[Answer, ...]
    reason: str
    subject: str = ""

    @property
    def closed(self) -> bool:
        """Whether what is proved and what is refuted meet, within one part in a million."""
        if self.verdict is Verdict.REFUTED or self.largest.low == math.inf:
            return True
        against = self.refuted_at
        return against is not None and self.largest.low >= against * (1 - CLOSED)

    @property
    def capped(self) -> bool:
        """Whether ``largest.low`` is no end of the criterion, but the largest ``k`` a certificate was tried for."""
        return self.verdict is Verdict.PROVED and bool(self.answers) and self.answers[0].capped

    @property
    def about(self) -> str:
        """The class in words, without its upper end."""
        words = f"{'odd ' if self.odd else ''}phi"
        when = ", time-varying" if self.time_varying else ", time-invariant"
        return f"{words} with slope in" if self.question == "slope" else f"{words}{when}, in the sector"

    def to_dict(self) -> dict[str, Any]:
        """The answer as plain data; infinite numbers are the text ``inf``."""
        witness = self.witness
        return {
            "question": self.question,
            "criterion": self.criterion,
            "odd": self.odd,
            "time_varying": self.time_varying,
            "lower": json_number(float(self.lower)),
            "critical": self.critical,
            "proviso": self.proviso,
            "largest": [json_number(self.largest.low), json_number(self.largest.high)],
            "theta": json_number(self.theta),
            "multiplier": self.multiplier,
            "parameters": plain(self.parameters),
            "verdict": str(self.verdict),
            "evidence": str(self.evidence),
            "hurwitz": [json_number(self.hurwitz.low), json_number(self.hurwitz.high)],
            "refuted_at": json_number(self.refuted_at),
            "witness": None
            if witness is None
            else {
                "kind": witness.kind,
                "k": json_number(witness.k),
                "evidence": str(witness.evidence),
                "description": witness.description,
                "data": plain(witness.data),
            },
            "closed": self.closed,
            "reason": self.reason,
            "answers": [answer_dict(answer) for answer in self.answers],
            "sentence": str(self),
            **({"subject": self.subject} if self.subject else {}),
        }

    def __post_init__(self) -> None:
        if (self.verdict is Verdict.PROVED and self.proof is None) or (
            self.verdict is Verdict.REFUTED and self.refutation is None
        ):
            raise TypeError(f"{self.verdict} needs what the checker accepted; the best answer has no proof")

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of the answer that reaches farthest, with its certificate."""
        return self.answers[0].proof if self.answers else None

    @property
    def refutation(self) -> Refuted | None:
        """What the checker accepted of the witness, with its certificate."""
        return None if self.witness is None else self.witness.refutation

    def __bool__(self) -> bool:
        raise TypeError("an answer has three values; compare result.verdict")

    @property
    def meaning(self) -> str:
        """What is proved of the motions where ``verdict`` is PROVED: the weakest conclusion of the theorems."""
        of = f" of {self.subject}" if self.subject else ""
        if not self.critical:
            return f"The point 0 attracts every motion{of}"
        return f"Every motion{of} {'is bounded' if self.time_varying else 'converges to the set of equilibria'}"

    def __str__(self) -> str:
        start = str(self.lower) if len(str(self.lower)) < 12 else text_above(self.lower, 15)
        span = f"[{start}, {rounded_down(self.largest.low)}{')' if self.largest.low == math.inf else ']'}"
        if self.verdict is Verdict.PROVED:
            proviso = f" {self.proviso}" if self.proviso else ""
            tried = ", the largest k tried" if self.capped else ""
            head = f"{self.meaning} for every {self.about} {span}{tried}{proviso} ({self.criterion}, {self.evidence})"
        elif self.verdict is Verdict.REFUTED:
            head = f"Not stable for {self.about} [{start}, k], whatever k > {start}"
        elif self.largest.low > self.lower:
            head = f"Not proved; the inequality of {self.criterion} holds for {span} ({self.evidence})"
        else:
            head = f"Nothing is proved for {self.about} [{start}, k]"
        tail = f"; {self.witness}" if self.witness is not None and self.refuted_at is not None else ""
        between = "" if self.closed or self.witness is None else "; in between nothing is known"
        cure = f" ({self.reason})" if self.verdict is Verdict.REFUTED and self.reason else ""
        return f"{head}{tail}{between}{cure}."

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar: proved up to its end, refuted from its cross on, unknown in between.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from analysis.answers.text import class_name
        from analysis.plots.loops import plot_reach

        return plot_reach([self], [class_name(self)], ax=ax)

    def to_xarray(self) -> xarray.Dataset:
        """Every criterion that was tried, over the dimension ``criterion``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from analysis.answers.showing import largest_dataset

        return largest_dataset(self)

    def _repr_html_(self) -> str:
        from analysis.answers.showing import largest_html

        return largest_html(self)


def answer_dict(answer: Answer) -> dict[str, Any]:
    """One criterion's answer as plain data.

    Parameters
    ----------
    answer : Answer
        The answer.
    """
    return {
        "criterion": answer.criterion,
        "theorem": answer.theorem,
        "largest": [json_number(answer.largest.low), json_number(answer.largest.high)],
        "class": str(answer.law_class),
        "verdict": str(answer.verdict),
        "evidence": str(answer.evidence),
        "needs": list(answer.needs),
        "theta": json_number(answer.theta),
        "multiplier": answer.multiplier,
        "parameters": plain(answer.parameters),
        "margin": None if answer.margin is None else [json_number(answer.margin.low), json_number(answer.margin.high)],
        "worst_frequency": json_number(answer.worst_frequency),
        "hypotheses": list(answer.hypotheses),
        "reason": answer.reason,
    }


def proved_up_to(row: Largest) -> str:
    """How far a class is proved, for a table; it says so where that is only the largest ``k`` that was tried.

    Parameters
    ----------
    row : Largest
        An answer whose verdict is PROVED.
    """
    end = rounded_down(row.largest.low)
    return f"{end}, the largest k tried" if row.capped else end


def rounded_down(value: float) -> str:
    """Seven digits, or ten just below a short number; never more than the number.

    Parameters
    ----------
    value : float
        The number.

    Examples
    --------
    >>> rounded_down(2 / 3), rounded_down(1e12)
    ('0.6666666', '1e12')
    """
    nearest = f"{value:.7g}"
    short = len(nearest.split("e")[0].replace(".", "").strip("-0")) <= 3
    text = text_below(value, 10 if short and float(nearest) != value else 7)
    if not (text.isdigit() and text.endswith("0" * 7)):
        return text
    digits = text.rstrip("0")
    return f"{digits[0]}{'.' if digits[1:] else ''}{digits[1:]}e{len(text) - 1}"
