"""What a report is asked beside stability: a gain, a rate, a region, a steady response; one row each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from lure.analysis.certificates.checker import Checked
from lure.analysis.plots.performance import gain_curves
from lure.analysis.plots.regions import flow_drawn
from lure.analysis.questions import decay_rate, l2_gain, steady_response, tolerances
from lure.analysis.questions.decay import RateBound
from lure.analysis.questions.gain import GainBound
from lure.analysis.questions.margins import Tolerances
from lure.analysis.questions.regions import RegionOfAttraction, region
from lure.analysis.questions.steady import SteadyResponse
from lure.analysis.report.parts import FigureSpec
from lure.analysis.verdict import Evidence, Verdict
from lure.errors import AssumptionError, InputError
from lure.extensions import extension
from lure.files.system import LoopSystem


def _gain(found: GainBound) -> str:
    """What the figure of a gain shows."""
    extremes, largest = gain_curves(found)
    colours = [name for name, drawn in (("grey", extremes), ("the colour of the text", largest is not None)) if drawn]
    words = []
    if colours:
        words.append(f"{' and '.join(colours).capitalize()}: stable linear members, in floating point.")
    if math.isfinite(found.gain.high):
        words.append("Blue: what the gain of no member exceeds, linear or not, for any disturbance of finite energy.")
    return " ".join(words)


def _rate(found: RateBound) -> str:
    """What the figure of a rate shows."""
    words = []
    if found.proof is not None or found.refutation is not None:
        words.append("Grey: eigenvalues with constant gains of the class, in floating point.")
    sides = (found.rate.high, found.rate.low) if found.time == "discrete" else (found.rate.low, found.rate.high)
    proved, shown = (rate > 1 if found.time == "discrete" else rate < 0 for rate in sides)  # whether it may grow
    if found.proof is not None:
        slowest = "every solution of every member decays at least as fast as"
        words.append(f"Blue: what {'no solution of any member grows faster than' if proved else slowest}, certified.")
    if found.refutation is not None:
        words.append("Orange: a member that grows as fast." if shown else "Orange: a member that is no faster.")
    return " ".join(words)


def _region(found: RegionOfAttraction) -> str:
    """What the figure of a region shows."""
    whole = any(one.P is None and one.interval is None for one in found.sets)
    words = ["Blue: every solution that starts there tends to 0."] if found.sets else []
    if found.outside:
        words.append("Hatched: none that starts there does.")
    if not whole:
        words.append("White: nothing is known." if found.linear is None else "White: almost no start is attracted.")
    field, solutions = flow_drawn(found)
    parts = ("grey: the field", field), ("in the colour of the text: some solutions", solutions)
    drawn = [text for text, seen in parts if seen]
    if drawn:
        text = ", ".join(drawn)
        words.append(f"{text[0].upper()}{text[1:]}, {'both ' * (len(drawn) > 1)}in floating point.")
    return " ".join(words)


def _steady(found: SteadyResponse) -> str:
    """What the figure of a steady response shows."""
    words = list[str]()
    if any(row.alone for row in found.response):
        words.append("Blue bars: certified at that frequency, from whatever start; between them nothing is.")
    if any(not row.alone and row.evidence is Evidence.CERTIFIED for row in found.response):
        words.append("Orange and grey bars: steady responses that exist, certified, where others may.")
    if any(row.evidence is not Evidence.CERTIFIED for row in found.response):
        words.append("Crosses: harmonic balance, in floating point.")
    return " ".join(words)


def _tolerances(found: Tolerances) -> str:
    """What the figure of tolerances shows."""
    words = ["Blue: the class is certified for every plant."] if found.proof is not None else []
    if found.refutation is not None:
        words.append("Orange crosses: a plant with which a constant gain of the class refutes it.")
    return " ".join([*words, "White: open."])


class Row(NamedTuple):
    """A question: its title, who answers it about a system, and the caption of what its figure shows."""

    title: str
    answer: Callable[..., Any]
    caption: Callable[[Any], str]


ASKED: Mapping[str, Row] = {
    "gain": Row("How much of a disturbance comes through", l2_gain, _gain),
    "rate": Row("How fast every solution decays", decay_rate, _rate),
    "region": Row("From where the loop recovers", region, _region),
    "steady": Row("What a steady input leads to", steady_response, _steady),
    "tolerances": Row("How much farther the parameters may vary", tolerances, _tolerances),
}


_MOMENT = 0.01  # [s]
_SHOWN = {
    "rate": ("a rate of decay, ", ""),
    "gain": ("anything about external inputs", "more about external inputs than the gain"),
    "steady": ("anything about external inputs", "more about external inputs than the steady response"),
}


def answers(system: LoopSystem, seconds: float | None) -> dict[str, Any]:
    """The answers to what a system asks, by name; ``seconds``: time allowed to each.

    Raises
    ------
    InputError, AssumptionError
        A question cannot be asked of this system.
    """

    def answered(name: str, seconds: float | None) -> Any:  # noqa: ANN401  (any answer)
        """One of them."""
        try:
            return ASKED[name].answer(system, seconds=seconds)
        except (InputError, AssumptionError) as error:
            message = f"report.ask has {name!r}, which this system does not answer: {error}"
            raise type(error)(message, code=error.code) from error

    for later in system.ask[1:]:  # a question without an answer is refused before time is spent on those before it
        answered(later, _MOMENT)
    return {name: answered(name, seconds) for name in system.ask}


def not_answered(text: str, found: Mapping[str, Any]) -> str:
    """What a verdict does not show, without what answers beside it prove; ``found``: from :func:`answers`."""
    for name, answer in found.items():
        if answer.verdict is Verdict.PROVED:
            text = text.replace(*_SHOWN.get(name, ("", "")))
    return text


def accepted(found: Mapping[str, Any]) -> Iterator[Checked]:
    """What the checker accepted of the answers; ``found``: from :func:`answers`."""
    for one in found.values():
        sides = (getattr(one, "proof", None), getattr(one, "refutation", None))
        yield from (side for side in sides if side is not None)


def pictures(found: Mapping[str, Any]) -> Iterator[FigureSpec]:
    """The figures of the answers that have one; ``found``: from :func:`answers`."""
    for name, one in found.items():
        draw = extension("drawing", one)
        if draw is not None and getattr(one, "drawn", True):
            title, _, caption = ASKED[name]
            yield FigureSpec(name=name, section="asked", title=title, caption=caption(one), draw=partial(draw, one))
