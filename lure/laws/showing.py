"""A law as a table for a notebook and as plain data: what is known of it, and whether it was checked or declared."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from lure.errors import AssumptionError
from lure.laws.properties import Property, properties
from lure.nonlinearity import Nonlinearity
from lure.showing import html_table, plain


def law_dict(law: Nonlinearity) -> dict[str, Any]:
    """A law as plain JSON data: its kind, parameters and properties, each with its standing.

    Parameters
    ----------
    law : Nonlinearity
        The law.  A declared property that its own formula contradicts is reported as ``contradicted``.
    """
    data: dict[str, Any] = {"kind": type(law).__name__, "text": law_text(law), "parameters": _parameters(law)}
    known, against = _known(law)
    for name, found in known.items():
        value, standing, how = found
        data[name] = {"value": value, "standing": standing, "how": how}
    return {**data, "contradicted": against}


def law_html(law: Nonlinearity) -> str:
    """A law as a table.

    Parameters
    ----------
    law : Nonlinearity
        The law.
    """
    known, against = _known(law)
    rows = [(name.replace("_", " "), value, standing, how) for name, (value, standing, how) in known.items()]
    notes = ["It enters the loop as mu = -phi(sigma)."] if against is None else [f"CONTRADICTED: {against}"]
    return html_table(f"phi: {law_text(law)}", rows, head=("", "value", "standing", "how it is known"), notes=notes)


def law_text(law: Nonlinearity) -> str:
    """A law in words: what it prints, or the name of its class with its parameters.

    Parameters
    ----------
    law : Nonlinearity
        Any law.
    """
    if type(law).__str__ is not object.__str__:
        return str(law)
    given = ", ".join(f"{name} = {value}" for name, value in _parameters(law).items())
    return f"{type(law).__name__}({given})" if given else type(law).__name__


def _known(law: Nonlinearity) -> tuple[dict[str, tuple[str, str, str]], str | None]:
    """Each property as text with its standing; and what contradicts it, if anything does."""
    try:
        found = properties(law)
    except AssumptionError as error:
        return {"sector": (str(law.sector), "declared", "the word of the law's author")}, str(error)
    slope, odd = found.slope_bounds, found.odd
    return {
        "sector": _row(found.sector, str(found.sector.value)),
        "slope": _row(slope, "not known to be bounded" if slope.value is None else str(slope.value)),
        "odd": _row(odd, "yes" if odd.value else "not known to be"),
        "regularity": _row(found.regularity, found.regularity.value),
    }, None


def _row(known: Property[Any], value: str) -> tuple[str, str, str]:
    return value, str(known.standing), known.how


def _parameters(law: Nonlinearity) -> dict[str, Any]:
    if not is_dataclass(law):
        return {}
    return {field.name: plain(getattr(law, field.name)) for field in fields(law) if field.init and field.repr}
