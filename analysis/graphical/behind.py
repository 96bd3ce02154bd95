"""What the two responses share: the least value drawn, what stands behind the drawing, and its plain forms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from analysis.answer import Answer
from analysis.evidence import Evidence, Verdict
from analysis.graphical.page import block_text
from lure.showing import plain, xarray_or_refusal

if TYPE_CHECKING:
    import xarray

    from analysis.graphical.nyquist_result import NyquistResponse
    from analysis.graphical.popov_result import PopovResponse

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


def behind(response: Drawn, criterion: str) -> str:
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
    from analysis.answers.largest import answer_dict

    answer = answer_dict(response.answer) if isinstance(response.answer, Answer) else response.answer
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
    xr = xarray_or_refusal("to_xarray")
    known = {name: value for name, value in (*own.items(), ("margin_seen", response.margin_seen)) if value is not None}
    made: xarray.Dataset = xr.Dataset(
        {name: ("omega", values, {"long_name": words}) for name, (values, words) in variables.items()},
        coords={"omega": ("omega", response.omega, {"units": "rad/s"})},
        attrs={**known, "evidence": str(Evidence.OBSERVED), "comment": str(response)},
    )
    return made
