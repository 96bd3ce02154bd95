"""What a report is asked beside stability: a gain, a rate, a region; one row each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from lure.analysis.certificates.checker import Checked
from lure.analysis.questions import decay_rate, l2_gain
from lure.analysis.questions.regions import region
from lure.analysis.report.parts import FigureSpec
from lure.errors import AssumptionError, InputError
from lure.extensions import extension
from lure.files.system import LoopSystem

_GAIN = (
    "Grey and black: linear members, in floating point. Blue: what the gain of no member exceeds, linear or not, for "
    "any disturbance of finite energy."
)
_REGION = (
    "Blue: every solution that starts there tends to 0. Hatched: none that starts there does. White: nothing is known. "
    "Grey: the field, black: some solutions, both in floating point."
)

_RATE = (
    "Grey: eigenvalues with constant gains of the class, in floating point. Blue: what every solution of every member "
    "decays at least as fast as, certified. Red: a member that is no faster."
)


class Row(NamedTuple):
    """A question: its title, who answers it about a system, and the caption of the figure."""

    title: str
    answer: Callable[..., Any]
    caption: str = ""


ASKED: Mapping[str, Row] = {
    "gain": Row("How much of a disturbance comes through", l2_gain, _GAIN),
    "rate": Row("How fast every solution decays", decay_rate, _RATE),
    "region": Row("From where the loop recovers", region, _REGION),
}


_SHOWN = {
    "rate": ("a rate of decay, ", ""),
    "gain": ("anything about external inputs", "more about external inputs than the gain"),
}


def answers(system: LoopSystem, seconds: float | None) -> dict[str, Any]:
    """The answers to what a system asks, by name.

    Parameters
    ----------
    system : LoopSystem
        The system.
    seconds : float or None
        Time allowed to each.

    Raises
    ------
    InputError, AssumptionError
        A question cannot be asked of this system.
    """
    found: dict[str, Any] = {}
    for name in system.ask:
        try:
            found[name] = ASKED[name].answer(system, seconds=seconds)
        except (InputError, AssumptionError) as error:
            message = f"report.ask has {name!r}, which this system does not answer: {error}"
            raise type(error)(message, code=error.code) from error
    return found


def not_answered(text: str, found: Mapping[str, Any]) -> str:
    """What a verdict does not show, without what the answers beside it show.

    Parameters
    ----------
    text : str
        What the verdict does not show.
    found : Mapping
        From :func:`answers`.
    """
    for name in found:
        text = text.replace(*_SHOWN.get(name, ("", "")))
    return text


def accepted(found: Mapping[str, Any]) -> Iterator[Checked]:
    """What the checker accepted of the answers.

    Parameters
    ----------
    found : Mapping
        From :func:`answers`.
    """
    for one in found.values():
        sides = (getattr(one, "proof", None), getattr(one, "refutation", None))
        yield from (side for side in sides if side is not None)


def pictures(found: Mapping[str, Any]) -> Iterator[FigureSpec]:
    """The figures of the answers that have one.

    Parameters
    ----------
    found : Mapping
        From :func:`answers`.
    """
    for name, one in found.items():
        draw = extension("drawing", one)
        if draw is not None:
            title, _, caption = ASKED[name]
            yield FigureSpec(name=name, section="asked", title=title, caption=caption, draw=partial(draw, one))
