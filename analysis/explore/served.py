"""What the page asks, answered: one loop, one class of nonlinearities, in exact arithmetic, as plain JSON data.

The page runs this module in the browser, where nothing but the standard library and python-flint is at hand.  A
verdict is that of :func:`lure.analysis.certify`, a largest sector
that of :func:`lure.analysis.max_sector` or :func:`lure.analysis.max_slope`, and each comes with its certificate, which
both checkers have read.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck
from lure.analysis.certificates.systems import class_entry, system_of, text
from lure.analysis.questions.answers import max_sector, max_slope
from lure.analysis.questions.certify import ProofOptions, certify, text_of
from lure.analysis.questions.conclusion import Certification
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.verdict import Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, InputError
from lure.extensions import extensions
from lure.files.builtin import builtin_loop, loop_names
from lure.files.system import LoopSystem
from lure.plants.conversion import one_channel
from lure.plants.rational import RationalPlant
from lure.plants.text import coefficients, exact_coefficient, stated

SECONDS = 20.0  # [s] for one question
CLASSES = {
    "sector": "in the sector",
    "time-varying": "in the sector, depending on time",
    "slope": "with slope in the bounds",
    "odd": "odd, with slope in the bounds",
}
Given = Mapping[str, str]


class _RefusedError(Exception):
    """Bad input, with the field that it stands in."""

    def __init__(self, field: str, refusal: ValueError) -> None:
        named = str(refusal).replace("RationalPlant.denominator", field).replace("RationalPlant", f"{field}: H")
        super().__init__(named)
        self.field = field


def respond(question: str) -> str:
    """The answer to a question of the page.

    Parameters
    ----------
    question : str
        JSON: ``ask`` is ``plant``, ``largest``, ``class`` or ``line``, or what an extension answers; the other entries
        are the fields of the page, each the text that its reader wrote: ``num`` and ``den``, or ``transfer``, or
        ``system``; ``dt``, ``class``, ``lower``, ``k``, ``theta``.

    Returns
    -------
    str
        JSON: the answer; or ``error``, one sentence, with the ``field`` it is about.
    """
    given = json.loads(question)
    answers: dict[str, Callable[[Given], dict[str, Any]]] = {
        "plant": plant_answer,
        "largest": largest_answer,
        "class": class_answer,
        "line": line_answer,
    }
    if given["ask"] not in answers:
        for more in extensions("explored"):
            answers.update(more)
    try:
        found = answers[given["ask"]](given)
    except _RefusedError as refusal:
        found = {"error": str(refusal), "field": refusal.field}
    except (InputError, AssumptionError) as refusal:
        found = {"error": str(refusal), "field": "plant"}
    return json.dumps(found, allow_nan=False)


def field(name: str, work: Callable[[], Any]) -> Any:  # noqa: ANN401  (what the work returns)
    """What the work returns; what it refuses is about the field of this name.

    ``name``: the field of the page; ``work``: called without arguments.

    Raises
    ------
    _RefusedError
        The work refused.
    """
    try:
        return work()
    except (InputError, AssumptionError) as refusal:
        raise _RefusedError(name, refusal) from None


def plant_of(given: Given) -> tuple[RationalPlant, LoopSystem | None]:
    """The block that the fields describe, and the built-in loop if it is one.

    ``given``: ``system``, or ``transfer``, or ``num`` and ``den``; ``dt``, empty for continuous time.

    Raises
    ------
    _RefusedError
        It is none of a page: with several channels, with a dead time, not rational.
    """
    step = given.get("dt", "").strip()
    dt = field("dt", lambda: stated(exact_coefficient(step, "dt"))) if step else None
    if given.get("system"):
        if given["system"] not in loop_names():
            refusal = InputError(f"there is no built-in loop {given['system']!r:.40}; choose one from the list")
            raise _RefusedError("system", refusal)
        loop = builtin_loop(given["system"])
        block, name = loop.block, "system"
    elif given.get("transfer"):
        loop, name = None, "transfer"
        block = field(name, lambda: one_channel(given["transfer"], dt=dt))
    else:
        loop, name = None, "den"
        for one in ("num", "den"):
            if set(given.get(one, "")) & set("sz^*("):
                refusal = InputError(
                    f"{one} takes coefficients, such as 1, 3, 2, 0; choose Formula above to write H in s"
                )
                raise _RefusedError(one, refusal)
        num = field("num", lambda: coefficients(given.get("num", ""), "num"))
        den = field("den", lambda: coefficients(given.get("den", ""), "den"))
        block = field(name, lambda: one_channel((num, den), dt=dt))
    if not isinstance(block, RationalPlant):
        refusal = InputError(
            "the page takes one rational transfer function, such as 1/(s*(s+1)); a dead time, or several channels, are "
            "for the commands, such as lure max-sector"
        )
        raise _RefusedError(name, refusal)
    return block, loop


def plant_answer(given: Given) -> dict[str, Any]:
    """The block in words and in doubles, to be drawn; ``given``: the fields of the page.

    Raises
    ------
    InputError
        A coefficient is no double.
    """
    block, loop = plant_of(given)
    try:
        num, den = ([float(value) for value in each] for each in (block.numerator, block.denominator))
    except OverflowError:
        raise InputError("a coefficient exceeds the largest double, 1.8e308; rescale the unit of time") from None
    return {
        "num": num,
        "den": den,
        "formula": str(block),
        "dropped": _dropped(given),
        "discrete": block.dt is not None,
        "period": None if block.dt is None else float(block.dt),
        "order": len(den) - 1,
        "title": "" if loop is None else loop.title,
        "source": "" if loop is None else loop.source,
    }


def _dropped(given: Given) -> str:
    """A sentence where coefficients begin with 0, as those in ascending order do; empty elsewhere."""
    if given.get("system") or given.get("transfer"):
        return ""
    names = {"num": "numerator", "den": "denominator"}
    read = {word: coefficients(given.get(name, ""), name) for name, word in names.items()}
    found = " and the ".join(word for word, values in read.items() if values[0] == 0 and any(values))
    return f"Leading zeros of the {found} were left out: the highest power stands first." if found else ""


def largest_answer(given: Given) -> dict[str, Any]:
    """How far the classes are stable, from both sides: what ``lure max-sector --json`` and ``max-slope`` print.

    ``given``: the fields of the page.
    """
    block, _ = plant_of(given)
    kind, lower = _kind(given), _lower(given)
    found: StabilityBound
    if kind in ("sector", "time-varying"):
        found = max_sector(block, lower=lower, time_varying=kind == "time-varying", seconds=SECONDS)
    else:
        found = max_slope(block, lower=lower, odd=kind == "odd", search="linear", seconds=SECONDS)
    witness = found.witness
    gain = None if witness is None else witness.data.get("gain")
    return {
        "verdict": str(found.verdict),
        "sentence": str(found),
        "reason": found.reason if found.verdict is Verdict.REFUTED else "",
        "reach": found.proved_text,
        "proved": _end(found.largest.low) if found.verdict is Verdict.PROVED else None,
        "refuted": None if found.refuted_at is None else _end(found.refuted_at),
        "refuted_text": found.refuted_text,
        "closed": found.closed,
        "criterion": found.criterion,
        "multiplier": found.multiplier,
        "theta": found.theta if found.theta is not None and math.isfinite(found.theta) else None,
        "line": _line(found.criterion, found.theta),
        "worst": _frequency(found),
        "gain": float(Fraction(str(gain))) if isinstance(gain, str) else None if witness is None else witness.k,
        "witness": "" if witness is None else str(witness),
        "left_out": _left_out(one.reason for one in found.answers),
        "report": found.to_dict(),
        "certificate": "" if found.proof is None else text_of(found.proof.certificate),
        "refutation": "" if found.refutation is None else text_of(found.refutation.certificate),
        "second": [recheck(one.certificate).accepted for one in (found.proof, found.refutation) if one is not None],
    }


def class_answer(given: Given) -> dict[str, Any]:
    """The verdict on exactly the class asked about: what ``lure certify`` says.

    ``given``: the fields of the page.
    """
    block, _ = plant_of(given)
    asked = _class(given)
    found = certify(block, asked, ways=ProofOptions(seconds=SECONDS))
    return _verdict(found, system_toml(block, asked))


def line_answer(given: Given) -> dict[str, Any]:
    r"""Whether the line of one ``theta`` proves the class: the checkers' word on ``1/k + Re[(1 + i w theta) H] > 0``.

    For a class that depends on time, and in discrete time, the multiplier is 1, and ``theta`` is not looked at.

    ``given``: the fields of the page.
    """
    block, _ = plant_of(given)
    asked = _class(given)
    circle = asked.time_varying or block.dt is not None
    theta = (
        Fraction(0) if circle else field("theta", lambda: exact_coefficient(given.get("theta", "").strip(), "theta"))
    )
    proposal = {
        "verdict": "PROVED",
        "system": system_of(block),
        "laws": class_entry(asked, unbounded=False),
        "theorem": "circle" if circle else "popov",
        "multiplier": {} if circle else {"theta": text(theta)},
        "proof": {"method": "polynomial"},
    }
    try:
        shown = complete_and_check(proposal)
    except (Rejected, Malformed, InputError, AssumptionError) as refusal:
        return {"accepted": False, "reason": str(refusal), "theta": float(theta), "certificate": ""}
    both = recheck(shown.certificate)
    return {
        "accepted": bool(both.accepted),
        "reason": "" if both.accepted else both.reason,
        "theta": float(theta),
        "certificate": text_of(shown.certificate),
    }


def system_toml(block: RationalPlant, asked: NonlinearityClass) -> str:
    """The loop and its class as a file for ``lure report`` and ``lure certify``, every number exact."""
    bounds = asked.slope or asked.sector
    flags = [f"{name} = true" for name in ("odd", "time_varying") if getattr(asked, name)]
    return "\n".join(
        [
            "[plant]",
            f"num = {_list(block.numerator)}",
            f"den = {_list(block.denominator)}",
            *([] if block.dt is None else [f"dt = {_written(block.dt)}"]),
            "",
            "[class]",
            f"{'sector' if asked.slope is None else 'slope'} = {_list((bounds.lower, bounds.upper))}",
            *flags,
            "",
        ]
    )


def _list(values: Iterable[Fraction | float]) -> str:
    return f"[{', '.join(map(_written, values))}]"


def _written(value: Fraction | float) -> str:
    if value == math.inf:
        return "inf"
    return str(value) if Fraction(value).denominator == 1 else f'"{Fraction(value)}"'


def _verdict(found: Certification, toml: str) -> dict[str, Any]:
    certificate = found.certificate
    multiplier = {} if certificate is None else certificate["multiplier"]
    theta = multiplier.get("theta") if isinstance(multiplier, Mapping) else None
    theorem = "" if certificate is None else certificate["theorem"]
    left_out = _left_out(one.detail for one in found.failures)
    sentence = str(found.conclusion)
    if left_out and found.verdict is Verdict.INCONCLUSIVE:  # the reason is the browser's: the page says it in its note
        sentence = f"{sentence.partition(': ')[0]}."
    return {
        "verdict": str(found.verdict),
        "sentence": sentence,
        "detail": found.detail,
        "code": "" if found.code is None else found.code.identifier,
        "theorem": theorem,
        "line": _line(theorem, None if theta is None else float(Fraction(theta))),
        "certificate": "" if certificate is None else text_of(certificate),
        "second": None if certificate is None else recheck(certificate).accepted,
        "left_out": left_out,
        "report": found.to_dict(),
        "toml": toml,
    }


def _kind(given: Given) -> str:
    kind = given.get("class") or "sector"
    if kind not in CLASSES:
        raise _RefusedError("class", InputError(f"class is {kind!r:.40}; choose from {', '.join(CLASSES)}"))
    return kind


def _lower(given: Given) -> Fraction:
    found: Fraction = field("lower", lambda: exact_coefficient(given.get("lower", "").strip() or "0", "lower"))
    return found


def _class(given: Given) -> NonlinearityClass:
    kind, lower = _kind(given), _lower(given)
    written = given.get("k", "").strip()
    k = math.inf if written in ("inf", "infinity") else field("k", lambda: exact_coefficient(written, "k"))
    if not lower < k:
        refusal = InputError(f"k is {written}; give the upper end of the class, above its lower end {float(lower):g}")
        raise _RefusedError("k", refusal)
    if kind in ("sector", "time-varying"):
        sector = field("k", lambda: Sector(lower, k))
        return NonlinearityClass(sector=sector, time_varying=kind == "time-varying")
    found: NonlinearityClass = field("k", lambda: NonlinearityClass.slope_restricted(lower, k, odd=kind == "odd"))
    return found


def _line(criterion: str, theta: float | None) -> float | None:
    """The ``theta`` [s] of the line by which the criterion proves; None where its multiplier is not ``1 + theta s``."""
    if criterion == "circle":
        return 0.0
    return theta if criterion == "popov" and theta is not None and math.isfinite(theta) else None


def _frequency(found: StabilityBound) -> float | None:
    """Where the inequality of the best criterion is tight [rad/s]; None where that is no finite number."""
    worst = found.answers[0].worst_frequency if found.answers else None
    return worst if worst is not None and math.isfinite(worst) else None


def _left_out(reasons: Iterable[str]) -> bool:
    """Whether a step was left out that needs numpy, which a browser does not have."""
    return any("needs numpy" in reason or "needs scipy" in reason for reason in reasons)


def _end(value: Fraction | float) -> float | str:
    found = float(value)
    return found if math.isfinite(found) else "inf" if found > 0 else "-inf"
