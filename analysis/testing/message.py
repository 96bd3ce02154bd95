"""The text of a failed assertion: one sentence, the numbers, and a plot, within 76 columns."""

from __future__ import annotations

import math
import textwrap
from fractions import Fraction

from analysis.testing.ascii_plot import ascii_plot
from analysis.testing.result import Violation

_WIDTH = 76


def message(violation: Violation) -> str:
    """The message of a violation.

    Parameters
    ----------
    violation : Violation
        What was found.

    Returns
    -------
    str
        A sentence that stands alone in pytest's summary, a table, and the plot.
    """
    return "\n".join(
        [
            textwrap.fill(_sentence(violation), _WIDTH),
            "",
            *_table(violation),
            "",
            ascii_plot(violation),
            "",
            *_how(violation),
        ]
    )


def _sentence(violation: Violation) -> str:
    places = list(map(number, violation.sigma))
    if violation.kind == "odd":
        found = f"phi({places[0]}) + phi({number(-violation.sigma[0])}) = {violation.found:.6g}"
    elif violation.kind == "slope":
        found = f"slope {measured(violation)} from sigma = {places[0]} to {places[1]}"
    elif violation.sigma == (0.0,):
        found = f"phi(0) = {number(violation.phi[0])}"
    else:
        found = f"phi(sigma)/sigma = {measured(violation)} at sigma = {places[0]}"
    return f"{violation.denial}: {found}"


def _table(violation: Violation) -> list[str]:
    rows = [("sigma", ", ".join(map(number, violation.sigma)))]
    rows.append(("phi(sigma)", ", ".join(f"{value:.8g}" for value in violation.phi)))
    if math.isfinite(violation.found) and violation.sigma != (0.0,):
        rows.append((violation.quantity, measured(violation)))
    slack = f", tolerance {violation.tolerance:g}" if violation.tolerance else ""
    if violation.kind != "odd":
        rows.append(("allowed", f"[{number(violation.lower)}, {number(violation.upper)}]{slack}"))
    if math.isfinite(violation.excess):
        rows.append(("excess", f"{violation.excess:.6g}"))
    if math.isfinite(violation.slope):
        rows.append(("slope there", f"{violation.slope:.6g}"))
    width = max(len(name) for name, _ in rows)
    return [f"  {name:<{width}}  {value}" for name, value in rows]


def _how(violation: Violation) -> list[str]:
    return textwrap.wrap(violation.how, _WIDTH)


def measured(violation: Violation) -> str:
    """What was found, with digits enough to tell it from the bound.

    Parameters
    ----------
    violation : Violation
        What was found.
    """
    for digits in (6, 9, 12):
        text = f"{violation.found:.{digits}g}"
        if violation.excess > 10.0 ** (1 - digits) * abs(violation.found):
            return text
    return repr(violation.found)


def number(value: float | Fraction) -> str:
    """A number for people: short where it is exact, else of up to 12 digits."""
    if isinstance(value, Fraction) and value.denominator != 1:
        text = str(value)
        return text if len(text) <= 15 else f"{float(value):.12g}"
    short = f"{float(value):.6g}"
    return short if float(short) == float(value) else f"{float(value):.12g}"
