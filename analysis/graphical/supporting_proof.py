"""What the drawings share: the figure inside a page, the words for a range of frequencies, a number of the caller's."""

from __future__ import annotations

import hashlib
import html
import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.analysis.certificates.theory import theory_of
from lure.analysis.drawing import drawing
from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.theorems.circle import circle_criterion
from lure.analysis.theorems.popov import popov_criterion
from lure.analysis.verdict import Answer, Evidence, Verdict
from lure.classes import Sector
from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.record import Column, dataset, plain

if TYPE_CHECKING:
    from lure.analysis.drawing import Draw
    from lure.analysis.graphical.axis import Drawable

# What the two responses share: the least value drawn, what stands behind the drawing, and its plain forms.

if TYPE_CHECKING:
    import xarray

    from lure.analysis.graphical.nyquist import NyquistResponse
    from lure.analysis.graphical.popov import PopovResponse

    Drawn: TypeAlias = PopovResponse | NyquistResponse

ROUNDING = 1e-11  # of the size of a curve: closer than this it touches


def least(distances: NDArray[np.float64]) -> int | None:
    """Where the least finite distance stands; None where there is none.

    Parameters
    ----------
    distances : ndarray
        (m,) distances, nan or infinite where there is nothing to see.
    """
    seen = np.where(np.isfinite(distances), distances, np.inf)
    return int(np.argmin(seen)) if np.isfinite(seen).any() else None


def support(response: Drawn, criterion: str) -> tuple[bool, str]:
    """Whether something proves the sector of a drawing, and what it is, or why nothing does.

    Parameters
    ----------
    response : PopovResponse or NyquistResponse
        The drawing.
    criterion : str
        The criterion it shows, in words.
    """
    answer, found = response.answer, response.found
    if answer is not None and answer.verdict is Verdict.PROVED and not response.reason:
        said = answer.reason if isinstance(answer, Answer) else str(answer)
        return True, f"{criterion} for the sector {response.sector_text} ({answer.evidence}): {said}"
    if found is not None and found.verdict is Verdict.PROVED and not response.reason:
        return True, str(found).removesuffix(".")
    return False, response.reason.removesuffix(".")


def supporting_proof(response: Drawn, criterion: str) -> str:
    """The end of a sentence that begins with "a drawing proves nothing".

    Parameters
    ----------
    response : PopovResponse or NyquistResponse
        The drawing.
    criterion : str
        The criterion it shows, in words.
    """
    proved, words = support(response, criterion)
    return f"what does: {words}" if proved else f"nor does anything here: {words}"


def proof_row(response: Drawn, criterion: str) -> tuple[str, str]:
    """The row of a table that says what proves the sector.

    Parameters
    ----------
    response : PopovResponse or NyquistResponse
        The drawing.
    criterion : str
        The criterion it shows, in words.
    """
    proved, words = support(response, criterion)
    return "what proves it", words if proved else f"nothing here: {words}"


def drawn_dict(response: Drawn, kind: str, own: dict[str, object]) -> dict[str, Any]:
    """Plain JSON data of a drawing.

    Parameters
    ----------
    response : PopovResponse or NyquistResponse
        The drawing.
    kind : str
        What it is.
    own : dict
        The numbers of its line or region, by name.
    """
    answer = response.answer.to_dict() if isinstance(response.answer, Answer) else response.answer
    return {
        "kind": kind,
        "block": block_text(response.block),
        "evidence": str(Evidence.OBSERVED),
        **{name: plain(value) for name, value in own.items()},
        "margin_seen": plain(response.margin_seen),
        "worst_seen": None if response.worst is None else float(response.omega[response.worst]),
        "found": plain(response.found),
        "answer": plain(answer),
        "reason": response.reason,
        "sentence": str(response),
        "omega": plain(response.omega),
        "real": plain(response.values.real),
        "imag": plain(response.values.imag),
    }


def drawn_dataset(
    response: Drawn, variables: dict[str, tuple[NDArray[np.float64], str]], own: dict[str, object]
) -> xarray.Dataset:
    """The ``xarray.Dataset`` of a drawing over ``omega``.

    Parameters
    ----------
    response : PopovResponse or NyquistResponse
        The drawing.
    variables : dict
        (m,) values and what they are, by name.
    own : dict
        The numbers of its line or region, by name; those that are None are left out.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    known = {name: value for name, value in (*own.items(), ("margin_seen", response.margin_seen)) if value is not None}
    return dataset(
        {name: Column(("omega",), values, "1", words) for name, (values, words) in variables.items()},
        {"omega": Column(("omega",), response.omega, "rad/s", "frequency")},
        {**known, "evidence": str(Evidence.OBSERVED), "comment": str(response)},
    )


# A Popov multiplier for a curve that is only drawn: the line with the most room, of those the simplest.

_HALVINGS = 60
_ANY = 1e-4  # of the size of the curve: where 1/k = 0, all room vanishes at infinity
Floats = NDArray[np.float64]


def searched_theta(x: Floats, y: Floats, k: float) -> float:
    r"""The ``theta`` nearest to 0 for which the points keep half of the best room from the line, or the best there is.

    The room is ``min_i (1/k + x_i - theta y_i)``, concave and piecewise linear in ``theta``; its maximum is found by
    halving, to about twice the rounding error.  Where some ``theta`` leaves room, the line returned leaves at least
    half of the most (for ``k = inf`` any); where none does, it falls short by the least.

    Parameters
    ----------
    x, y : ndarray
        (m,) ``Re H`` and ``omega Im H`` at the points drawn, finite.
    k : float
        Upper end of the sector, positive or ``inf``.

    Returns
    -------
    float
        ``theta`` [s], of either sign; for ``k = inf`` not negative, as Popov's theorem asks.
    """
    inverse_gain = 0.0 if np.isinf(k) else 1.0 / k
    start = float(np.min(x)) + inverse_gain  # theta = 0 leaves that much
    low, high = start, max(start, inverse_gain or float(np.max(np.abs(x))))
    if start < high and _window(x, y, inverse_gain - high, k) is None:
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if _window(x, y, inverse_gain - middle, k) is None:
                high = middle
            else:
                low = middle
        best = low
    else:
        best = high
    level = max(start, (_ANY if np.isinf(k) else 0.5) * best) if best > 0 else best
    left, right = _window(x, y, inverse_gain - level, k) or (0.0, 0.0)
    return min(max(0.0, left), right)


def _window(x: Floats, y: Floats, inverse_gain: float, k: float) -> tuple[float, float] | None:
    """All ``theta`` with ``inverse_gain + x - theta y >= 0`` at every point, None if there are none."""
    room = x + inverse_gain
    if bool((room[y == 0] < 0).any()):
        return None
    up, down = y > 0, y < 0
    with np.errstate(over="ignore"):  # a point with y next to nothing asks for nothing that doubles could say
        right = float(np.min(room[up] / y[up])) if up.any() else np.inf
        left = float(np.max(room[down] / y[down])) if down.any() else -np.inf
    left = max(left, 0.0) if np.isinf(k) else left
    return (left, right) if left <= right and np.isfinite(min(max(0.0, left), right)) else None


_LONGEST = 160


def criterion_asked(
    block: RationalPlant | StructuredPlant, criterion: str, sector: Sector, theta: Fraction | None = None
) -> tuple[Answer | CriterionResult, str]:
    """What a criterion says of one sector, and why nothing rests on that; empty where something does.

    Parameters
    ----------
    block : RationalPlant or StructuredPlant
        The block.
    criterion : {"popov", "circle"}
        The criterion.
    sector : Sector
        The sector.
    theta : Fraction, optional
        Popov's multiplier [s]; None for the best one.

    Raises
    ------
    AssumptionError, InputError
        As the criterion.
    """
    if isinstance(block, RationalPlant):
        asked = (
            circle_criterion(block, sector) if criterion == "circle" else popov_criterion(block, sector, theta=theta)
        )
        return asked, "" if asked.verdict is Verdict.PROVED else asked.reason
    theory = theory_of(block)
    answer = theory.inequality(criterion, sector, None if theta is None else float(theta))
    shown = "" if answer.verdict is Verdict.PROVED else answer.reason
    return answer, theory.elsewhere("this drawing") or shown


def with_figure(draw: Draw, table: str, *, alt: str) -> str:
    """A figure as inline SVG, on white, above a table.

    Parameters
    ----------
    draw : callable
        Draws on the axes it is given as ``ax``.
    table : str
        HTML.
    alt : str
        What the figure shows, for who cannot see it; also what its identifiers are salted with.
    """
    name = "figure-" + hashlib.sha256((alt + table).encode()).hexdigest()[:12]
    svg: str = drawing(draw, task="file")(draw, name=name, size=(5.4, 3.8)).svg
    label = f'role="img" aria-label="{html.escape(alt)}" style="max-width:100%;height:auto"'
    svg = svg[svg.index("<svg") :].replace("<svg", f"<svg {label}", 1)
    return f'<figure style="margin:0;max-width:40em">{svg}</figure>{table}'


def block_text(block: Drawable) -> str:
    """The block in a few words: its formula if that is short.

    Parameters
    ----------
    block : Drawable
        The block.
    """
    if isinstance(block, RationalPlant | DelayPlant):
        text = str(block)
        return f"H = {text}" if len(text) <= _LONGEST else f"H of order {len(block.denominator) - 1}"
    if isinstance(block, FrequencyData):
        return "a measured response"
    return block.name if isinstance(block, StructuredPlant) else str(block)


def span_text(omega: NDArray[np.float64]) -> str:
    """Where a curve was evaluated.

    Parameters
    ----------
    omega : ndarray
        (m,) frequencies [rad/s].
    """
    return f"at {omega.size} frequencies from {omega[0]:.4g} to {omega[-1]:.4g} rad/s"


def bound(value: object, name: str) -> float | Fraction:
    """A bound of a sector as it is given, exact unless it is ``inf``.

    Parameters
    ----------
    value : object
        A number.
    name : str
        What it is, for the error.

    Raises
    ------
    InputError
        It is no number.
    """
    if isinstance(value, float) and value == math.inf:
        return value
    return exact_number(value, name)


def upper_end(k: object, lower: Fraction) -> float | Fraction:
    """The upper end of a sector, which lies above the lower one.

    Parameters
    ----------
    k : object
        A number.
    lower : Fraction
        The lower end.

    Raises
    ------
    InputError
        It is no number, or does not lie above.
    """
    end = bound(k, "k")
    if end <= lower:
        raise InputError(f"k is {float(end):g}; give the upper end of a sector, above its lower end {float(lower):g}")
    return end
