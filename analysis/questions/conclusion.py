"""From what was asked and what the checker accepted to a verdict, a class and a sentence: nowhere else.

The class and the numbers in a sentence are those of the certificate.  Before anything is said, the system and the class
of the certificate are compared with those asked about, and a given nonlinearity with the class of the certificate.

What the checker accepted is put into tables and plain data here: it stays short enough to be read, and knows no pages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from lure import record
from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.states import classes, keeps
from lure.analysis.certificates.systems import nonlinearity_class_of
from lure.analysis.numerics.doubles import bound_below
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import TABLE
from lure.analysis.verdict import Evidence, Verdict
from lure.analysis.wording import (
    class_words,
    counterexample,
    destroys,
    direct_term,
    meaning,
    plain,
    plants_words,
    proviso,
)
from lure.nonlinearities.base import Nonlinearity
from lure.record import Page, Record, derived, described, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked, Proved, Refuted
    from lure.analysis.certificates.codes import Code
    from lure.analysis.certificates.drafts import Failure
    from lure.analysis.nonlinearity import NonlinearityBounds

_CLAIM = "Not shown is anything beyond the claim: a rate of decay, a bound on a solution, external inputs."
_AGAIN = "Check it again with lure.analysis.check(certificate), or with checker.py and nothing but Python."
CHECKED, DECLARED = "checked", "declared"
_NEAR = (-100, 100)


def shown_dict(shown: Checked) -> dict[str, Any]:
    """A ``Proved`` or ``Refuted`` as plain JSON data, its certificate with it."""
    return {
        "verdict": str(shown.certificate["verdict"]),
        "evidence": "certified",
        "theorem": shown.theorem,
        "claim": shown.claim,
        "facts": record.plain(shown.facts),
        "assumed": [shown.assumed] if shown.assumed else [],
        "certificate": record.plain(shown.certificate),
    }


def shown_page(shown: Checked, assumed: tuple[str, ...] | None = None) -> Page:
    """A ``Proved`` or ``Refuted`` as a table: the claim, the theorem and the hypotheses that were found to hold.

    ``assumed``: what is assumed beside it, in clauses; by default what it says itself.
    """
    own = (shown.assumed,) if shown.assumed else ()
    rows = [("theorem", shown.theorem), ("evidence", "certified"), *shown.facts.items()]
    rows += [("assumed", clause) for clause in (own if assumed is None else assumed)]
    return Page(shown.claim, rows, verdict=str(shown.certificate["verdict"]), notes=[_CLAIM, _AGAIN])


def failure_dict(failure: Failure) -> dict[str, Any]:
    """A search that showed nothing, as plain JSON data."""
    return {
        "search": failure.search,
        "code": failure.code.identifier,
        "title": failure.code.title,
        "detail": failure.detail,
    }


class MismatchError(RuntimeError):
    """A certificate about another system was offered as an answer: a bug, and nothing is said."""


@described(frozen=True, kw_only=True, slots=True)
class Conclusion:
    """What follows from what the checker accepted."""

    verdict: Verdict = quantity(
        "PROVED or REFUTED only where the certificate is about the system asked about, and its class fits"
    )
    evidence: Evidence = quantity("CERTIFIED with a verdict of these two")
    meaning: str = quantity(
        "What is proved of the solutions, or what the counterexample does; empty for INCONCLUSIVE", default=""
    )
    nonlinearity_class: str = quantity("The class of the certificate in words; empty for INCONCLUSIVE", default="")
    nonlinearity: str = quantity("The given nonlinearity in words; empty if there is none", default="")
    membership: str = quantity(
        "``checked``: it is shown to belong to the class; ``declared``: its author says so; empty if there is none",
        default="",
    )
    headline: str = quantity("The verdict in one sentence, without how it was found")
    sentence: str = quantity("The whole of it")
    reason: str = quantity("Why nothing follows from what was accepted; empty for PROVED and REFUTED", default="")
    code: Code | None = quantity("The code of the reason; None for PROVED and REFUTED", default=None)
    shown: Proved | Refuted | None = quantity("What the checker accepted; None for INCONCLUSIVE", default=None)
    attracts: bool = quantity(
        "Whether 0 is proved to attract every solution with the given nonlinearity, or without one for every "
        "nonlinearity",
        default=False,
    )
    assumed: tuple[str, ...] = quantity(
        "What is assumed and not shown, of the given nonlinearity or of every nonlinearity of the class, in clauses",
        default=(),
    )

    def __post_init__(self) -> None:
        if (self.shown is None) != (self.verdict is Verdict.INCONCLUSIVE):
            raise TypeError(f"{self.verdict} and what the checker accepted do not fit together")

    def __bool__(self) -> bool:
        raise TypeError("a conclusion has three values; compare conclusion.verdict")

    def __str__(self) -> str:
        return self.sentence


class Certification(Record):
    """The answer about one class: what follows from the first proposal accepted by the checker, or why nothing does."""

    conclusion: Conclusion = quantity(
        "The verdict, PROVED or REFUTED only with a certificate that the checker accepted", key=""
    )
    detail: str = quantity("One sentence: the claim, or what stood in the way")
    failures: tuple[Failure, ...] = quantity(
        "Every search that showed nothing, in the order they were made",
        plainly=lambda failures: [failure_dict(failure) for failure in failures],
        default=(),
    )
    _said = "sentence"
    _no_truth = "a certification has three outcomes; compare certification.verdict"

    @property
    @derived()
    def verdict(self) -> Verdict:
        """PROVED, REFUTED or INCONCLUSIVE."""
        return self.conclusion.verdict

    @property
    @derived(plainly=lambda shown: None if shown is None else shown_dict(shown))
    def shown(self) -> Proved | Refuted | None:
        """What the checker accepted; ``shown.certificate`` is the certificate."""
        return self.conclusion.shown

    @property
    @derived(plainly=lambda code: None if code is None else code.identifier)
    def code(self) -> Code | None:
        """Why it is INCONCLUSIVE; None otherwise."""
        return self.conclusion.code

    @property
    @derived()
    def assumed(self) -> tuple[str, ...]:
        """What the verdict assumes and nothing shows, in clauses; see ``Conclusion``."""
        return self.conclusion.assumed

    @property
    def certificate(self) -> Mapping[str, Any] | None:
        """The certificate, ready to be written as JSON; None if there is none."""
        return None if self.shown is None else self.shown.certificate

    def __str__(self) -> str:
        said, kind = plain(self.detail), "" if self.shown is None else str(self.shown.certificate["system"]["kind"])
        if kind.startswith("rod"):  # a force that the system has is not part of the claim
            said = f"{'of the upwind scheme ' if kind.startswith('rod-scheme') else ''}without load, {said}"
        return f"{self.verdict}: {said}" if self.code is None else f"{self.verdict} ({self.code}): {said}"

    def _page(self) -> Page:
        tried = [(one.search, f"{one.code.title} ({one.code.identifier})", one.detail) for one in self.failures]
        failed = [Page("Searches that showed nothing", tried, ("search", "how it ended", "why"))] if tried else []
        if self.shown is not None:
            return shown_page(self.shown, self.assumed)._replace(below=failed)
        rows = [] if self.code is None else [("code", f"{self.code.identifier}, {self.code.title}")]
        rows.append(("why", self.detail))
        notes = ["That nothing was shown says nothing about the loop: it may be stable or not."]
        return Page("No certificate was found", rows, verdict=str(self.verdict), notes=notes, below=failed)


def conclusion_of(
    asked: Problem,
    accepted: Proved | Refuted | None,
    *,
    larger: Proved | None = None,
    beside: Refuted | None = None,
) -> Conclusion:
    """The verdict, the class and the sentence that follow from what the checker accepted.

    Parameters
    ----------
    asked : Problem
        What was asked.
    accepted : Proved, Refuted or None
        What the checker accepted; None for nothing.
    larger : Proved, optional
        What was accepted of a larger class, named with its upper end.
    beside : Refuted, optional
        Another counterexample, named after the first where the class asked about contains it.

    Returns
    -------
    Conclusion
        PROVED if the class of the certificate contains the class asked about, and a given nonlinearity belongs to it
        with every property that the theorem needs.  REFUTED if the class asked about contains that of the certificate.
        Else INCONCLUSIVE.

    Raises
    ------
    MismatchError
        The certificate is about another system, or says neither.
    """
    from lure.analysis.certificates.checker import Proved, Refuted

    if accepted is None:
        return undecided(asked, "nothing was accepted by the checker")
    if dict(accepted.certificate["system"]) != dict(asked.system):
        raise MismatchError("the certificate is about another system than the one asked about")
    if isinstance(accepted, Proved):
        return _proved(asked, accepted, larger)
    if not isinstance(accepted, Refuted):
        raise MismatchError(f"a {type(accepted).__name__} is no proof and no refutation")
    return _refuted(asked, accepted, beside)


def _proved(asked: Problem, shown: Proved, larger: Proved | None) -> Conclusion:
    nonlinearities = shown.certificate["laws"]
    about = class_words(nonlinearities, spelled=asked.spelled)
    nonlinearity, name, standing, words, assumed = asked.nonlinearity, asked.nonlinearity_words, "", "", proviso(shown)
    composed = next((row.title for row in TABLE if row.composed and row.name == shown.theorem), None)
    if not contains(nonlinearities, asked.class_entry):
        if contains({**nonlinearities, "regularity": "any"}, asked.class_entry):
            reason = f"what is proved is about {about}, and {name} is not known to be locally Lipschitz"
            return undecided(asked, reason, code=codes.NOT_LIPSCHITZ)
        return undecided(asked, f"what is proved is about {about}, which does not contain the class asked about")
    if nonlinearity is not None:
        standing, words = _member(nonlinearity, nonlinearities)
        if not standing:
            return undecided(asked, f"what is proved is about {about}, and {words}", code=codes.OUTSIDE_CLASS)
        if assumed and _solvable_with(nonlinearity, shown):
            assumed = ""
        elif assumed and _takes_a_value_twice(nonlinearity, shown):
            reason = f"what is proved is about {about} {assumed}, and with {name} some y have several"
            return undecided(asked, reason, code=codes.SEVERAL_SOLUTIONS)
        elif assumed and composed is not None:
            reason = f"what is proved is about {about} {assumed}, which is not shown of {name}"
            return undecided(asked, reason, code=codes.SEVERAL_SOLUTIONS)
    elif asked.known:
        each = [_member(one, laws) for one, laws in zip(asked.known, nonlinearities["channels"], strict=True)]
        for i, (found_to_be, why) in enumerate(each, 1):
            if not found_to_be:
                return undecided(
                    asked, f"what is proved is about {about}, and channel {i}: {why}", code=codes.OUTSIDE_CLASS
                )
        standing = CHECKED if all(found_to_be == CHECKED for found_to_be, _ in each) else DECLARED
        told = [why.replace("phi", f"phi_{i}", 1).removeprefix("if ") for i, (_, why) in enumerate(each, 1) if why]
        words = f"if {' and '.join(told)}" if told else ""
    elif assumed and composed is not None and not asked.assuming:
        reason = f"{composed} proves it for {about} {assumed}, which the class does not promise; slope bounds would"
        return undecided(asked, reason, code=codes.SEVERAL_SOLUTIONS)
    says, attracts = meaning(shown, asked.subject), shown.certificate["conclusion"].startswith("0 attracts")
    if _above_the_critical_gain(shown):
        says, attracts = says.partition(" converges")[0] + " converges to 0", True
    whole = f"{about} {assumed}" if assumed else about
    plants = plants_words(shown.certificate["system"])
    head = f"{says} for every {whole}{plants and ' and' + plants.removeprefix(' for')}"
    found = head
    if name:
        member = f"(the nonlinearity is {'declared' if words else 'checked'} to be one)"
        if asked.several:
            member = f"(each nonlinearity is {'declared' if words else 'checked'} to be one)"
        found = f", as for every {about} {member}"
        given = asked.known if nonlinearity is None else (nonlinearity,)
        if not attracts and given and _rests_at_zero_only(given, shown):
            only = "each meets its critical gain at 0 only" if asked.several else "it vanishes at 0 only"
            found = f": {head[0].lower()}{head[1:]} {member}, and {only}"
            says, attracts = says.partition(" converges")[0] + " converges to 0", True
        provisos = [words, f"if {assumed.removeprefix('for which ')}" if assumed else ""]
        head = f"{says} with {name}{plants}" + "".join(f", {said}" for said in provisos if said)
        found = head + found
    proves = "" if larger is None or asked.several else f", which proves {_end(larger)}"
    return Conclusion(
        verdict=Verdict.PROVED,
        evidence=Evidence.CERTIFIED,
        meaning=says,
        nonlinearity_class=whole,
        nonlinearity=asked.nonlinearity_words,
        membership=standing,
        headline=f"{head}.",
        sentence=f"{found}, by the criterion {shown.theorem} (certified){proves}.",
        shown=shown,
        attracts=attracts,
        assumed=tuple(filter(None, (words.removeprefix("if "), assumed.removeprefix("for which ")))),
    )


def _refuted(asked: Problem, shown: Refuted, beside: Refuted | None) -> Conclusion:
    nonlinearities = shown.certificate["laws"]
    about = class_words(nonlinearities, inwards=False, spelled=asked.spelled)
    if not contains(asked.class_entry, nonlinearities):
        return undecided(asked, f"what is refuted is {about}, which the class asked about does not contain")
    if "equilibria other than 0" in shown.certificate["conclusion"] and _critical_end(asked, shown):
        return undecided(asked, "other equilibria refute nothing where an end of the class leaves a pole at 0")
    does = destroys(shown)
    head = f"Some {about} {does}: {counterexample(shown)}"
    other = f"with {asked.nonlinearity_words}" if asked.nonlinearity_words else "with another one of the class"
    too = ""
    if beside is not None and contains(asked.class_entry, beside.certificate["laws"]):
        too = f"; {counterexample(beside)} {destroys(beside)} too"
    return Conclusion(
        verdict=Verdict.REFUTED,
        evidence=Evidence.CERTIFIED,
        meaning=does,
        nonlinearity_class=about,
        nonlinearity=asked.nonlinearity_words,
        headline=f"{head}.",
        sentence=f"{head} (certified){too}. What the loop does {other} is another question.",
        shown=shown,
    )


def undecided(
    asked: Problem, reason: str, *, code: Code = codes.NO_MULTIPLIER, evidence: Evidence = Evidence.CERTIFIED
) -> Conclusion:
    """That nothing is decided, and why.

    Parameters
    ----------
    asked : Problem
        What was asked.
    reason : str
        Why, in words that follow a colon.
    code : Code
        The same as a code.
    evidence : Evidence
        What that rests on.
    """
    head = f"Nothing is decided for {class_words(asked.class_entry, spelled=asked.spelled)}"
    head += plants_words(asked.system)
    head += f", nor for {asked.nonlinearity_words}" if asked.nonlinearity_words else ""
    return Conclusion(
        verdict=Verdict.INCONCLUSIVE,
        evidence=evidence,
        nonlinearity=asked.nonlinearity_words,
        headline=f"{head}.",
        sentence=f"{head}: {reason} ({code.identifier}).",
        reason=reason,
        code=code,
    )


def _critical_end(asked: Problem, shown: Refuted) -> bool:
    """Whether a gain at an end of the class leaves a pole at 0 (``z = 1``) and otherwise stable ones, or may do so."""
    from lure.analysis.certificates.arithmetic import extended
    from lure.analysis.certificates.blocks import block, critical_end
    from lure.analysis.certificates.boxes import plants

    system = asked.system
    proof = shown.certificate["proof"]
    if proof.get("proof", proof)["method"] == "equilibrium":  # refused there
        return False
    if system["kind"] in ("family", "delay-family"):  # of the plant at which it is refuted
        system = plants(dict(system)).at([Fraction(v) for v in shown.certificate["proof"]["at"]])
    if system["kind"] not in ("transfer", "delay"):
        return True
    ends = [asked.class_entry["sector"], *([asked.class_entry["slope"]] if asked.class_entry["slope"] else [])]
    low, high = max(extended(end[0]) for end in ends), min(extended(end[1]) for end in ends)
    return critical_end(block(system), low, high)


def _end(larger: Proved) -> str:
    """The upper end of a larger class."""
    top = larger.certificate["laws"]["sector"][1]  # of slope bounds the same, if not beyond it
    return "every finite bound" if top == "finite" else f"up to {bound_below(Fraction(top)) if top != 'inf' else 'inf'}"


def _member(nonlinearity: Nonlinearity, nonlinearities: Mapping[str, Any]) -> tuple[str, str]:
    """Whether the nonlinearity is checked or declared to be in the class, and what is declared; empty and why if not.

    One that says nothing of its regularity is taken to be locally Lipschitz, and the words say so.
    """
    from lure.analysis.nonlinearity.membership import Status, membership

    found = membership(nonlinearity, nonlinearity_class_of(nonlinearities))
    if nonlinearities["linear"]:
        return "", f"{found.nonlinearity} is not known to be a constant gain"
    needed: Literal["none", "locally Lipschitz"] = (
        "none" if nonlinearities.get("regularity") == "any" else "locally Lipschitz"
    )
    regular = found.regular(needed)
    if found.status is Status.VIOLATED and found.violated is not None:
        return "", f"{found.nonlinearity} is none of them: {found.violated.how}"
    if regular is Status.VIOLATED:
        return "", f"{found.nonlinearity} is not known to be {needed}"
    if found.status is regular is Status.CHECKED:
        return CHECKED, ""
    verbs = {
        "sector": "lies in the sector",
        "slope": "has the slopes",
        "odd": "is odd as",
        "regularity": "is as regular as",
    }
    names = [known.name for known in found.declared]
    assumed = regular is Status.DECLARED and needed != "none" and nonlinearities["slope"] is None
    silent = assumed and not hasattr(nonlinearity, "locally_lipschitz")
    names += ["regularity"] if assumed and not silent else []
    said = " and ".join(verbs[name] for name in verbs if name in names)
    parts = [f"{said or 'is as'} you declare"] if said or not silent else []
    parts += ["is locally Lipschitz, of which nothing is declared"] if silent else []
    return DECLARED, "if phi " + " and ".join(parts)


def _solvable_with(nonlinearity: Nonlinearity, shown: Proved) -> bool:
    """Whether ``sigma + D phi(sigma) = y`` has one solution with this nonlinearity, by its slope bounds."""
    certificate, slope = shown.certificate, getattr(nonlinearity, "slope_bounds", None)
    if slope is None:
        return False
    ends = [end if math.isinf(end) else Fraction(end) for end in (slope.lower, slope.upper)]
    return keeps(direct_term(certificate["system"]), classes(certificate["laws"]), ends)


def _takes_a_value_twice(nonlinearity: Nonlinearity, shown: Proved) -> bool:
    """Whether ``sigma + D phi(sigma)`` is shown to take a value twice with this nonlinearity.

    Where its difference quotients ``1 + D q`` have both signs, as a continuous function it is not one to one; a graph
    with a piece of slope ``-1/D`` has one value on the whole of it.
    """
    from lure.analysis.nonlinearity import nonlinearity_bounds
    from lure.analysis.nonlinearity.membership import certified_bounds
    from lure.nonlinearities import ExpressionNonlinearity, GraphNonlinearity

    direct = direct_term(shown.certificate["system"])
    graph = nonlinearity.graph if isinstance(nonlinearity, GraphNonlinearity | ExpressionNonlinearity) else None
    if graph is not None:
        quotients = [1 + direct * slope for slope in graph.slopes]
        return min(quotients) <= 0 <= max(quotients)

    def both_signs(found: NonlinearityBounds | None) -> bool:
        """Whether the quotients that were found are of both signs."""
        if found is None or found.slope_lower is None or found.slope_upper is None:
            return False
        signs = [1 + direct * end.inner for end in (found.slope_lower, found.slope_upper)]
        return min(signs) < 0 < max(signs)

    if both_signs(certified_bounds(nonlinearity)):
        return True  # of slopes that grow without end an interval shows more than the line does
    return isinstance(nonlinearity, ExpressionNonlinearity) and both_signs(nonlinearity_bounds(nonlinearity, on=_NEAR))


def _critical_gain(shown: Proved) -> Fraction:
    """The gain ``l`` by which a proof about one nonlinearity has shifted the loop."""
    from lure.analysis.certificates.checker import SLOPED

    laws, mirrored = shown.certificate["laws"], shown.certificate["multiplier"] == {"mirrored": True}
    return Fraction(laws["slope"][0] if shown.theorem in SLOPED else laws["sector"][mirrored])


def _above_the_critical_gain(shown: Proved) -> bool:
    """Whether all solutions converge to equilibria, ``phi(sigma) = l sigma``, and the sector begins above ``l``.

    The slopes begin at ``l`` then, and 0 is the only equilibrium of every loop of the class.
    """
    from lure.analysis.certificates.checker import CONVERGES, SLOPED

    laws = shown.certificate["laws"]
    if shown.certificate["conclusion"] != CONVERGES or shown.theorem not in SLOPED or "channels" in laws:
        return False
    return bool(classes(laws).sector[0] > classes(laws).slope[0])


def _rests_at_zero_only(given: Sequence[Nonlinearity], shown: Proved) -> bool:
    """Whether 0 is the only equilibrium of a loop whose solutions converge to the set of equilibria.

    With the gain ``l`` at the critical end the loop has one simple pole at 0 (``z = 1``), and a residue that is not 0:
    an equilibrium then has ``phi(sigma) = l sigma``, and ``sigma`` determines its state; so it is with several
    nonlinearities, where ``sigma`` sees every eigenvector for 0.  See
    ``notebooks/notes/0012-one-nonlinearity.md``.
    """
    from lure.analysis.nonlinearity.shape import zero_set
    from lure.nonlinearities import shifted_nonlinearity

    certificate = shown.certificate
    if certificate["conclusion"] != "every motion converges to the set of equilibria":
        return False
    kind, laws = certificate["system"]["kind"], certificate["laws"]
    if kind not in ("transfer", "state-space", "delay", "multivariable", "family", "delay-family"):
        return False
    if kind == "multivariable":
        gains = [max(Fraction(end[0]) for end in (one["sector"], one["slope"]) if end) for one in laws["channels"]]
    else:
        gains = [_critical_gain(shown)]
    moved = [shifted_nonlinearity(one, gain) if gain else one for one, gain in zip(given, gains, strict=True)]
    return all(zeros is not None and zeros.only_zero for zeros in map(zero_set, moved))
