"""The words of the page on a loop: headline, classes, criteria and counterexamples."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

from analysis.answers.largest import rounded_down

Data = dict[str, Any]
_END = re.compile(r", by the criterion |: | \(|; |\. ")


def headline(data: Data) -> str:
    """The statement up to where it begins to explain itself.

    Parameters
    ----------
    data : dict
        The document.
    """
    return _END.split(data["conclusion"]["statement"], maxsplit=1)[0].removesuffix(".") + "."


def explanation(data: Data) -> str:
    """What the statement says after its headline; empty if that is all of it.

    Parameters
    ----------
    data : dict
        The document.
    """
    statement = data["conclusion"]["statement"]
    rest: str = statement[len(headline(data)) - 1 :].lstrip(",:;. ")
    return "by " + rest[1:].replace(")", "", 1) if rest.startswith("(") else rest


def open_questions(data: Data) -> list[str]:
    """What is not decided, and what would decide it.

    Parameters
    ----------
    data : dict
        The document.
    """
    conclusion, rows = data["conclusion"], data["answers"]
    if conclusion["hints"]:
        return list(conclusion["hints"])
    if conclusion["verdict"] == "REFUTED":
        return ["a smaller class: the table says how far each kind is proved"]
    if data["system"]["class"] is not None:
        proved = conclusion["verdict"] == "PROVED"
        return ["nothing: the question asked is decided" if proved else "nothing that these criteria know of"]
    gaps = [f"{class_words(row)}: nothing is known {_gap(row)}" for row in rows if not row["closed"]]
    return gaps or ["nothing: every gap is closed"]


def _gap(row: Data) -> str:
    """Where between its two numbers a row of the table is silent."""
    low, high = row["largest"][0] if row["verdict"] == "PROVED" else row["lower"], row["refuted_at"]
    start = rounded_down(_size(low))
    return f"above {start}" if high is None else f"between {start} and {high:.7g}"


def class_words(row: Data) -> str:
    """The classes of one row of the table, such as ``odd, slope in [0, k]``.

    Parameters
    ----------
    row : dict
        One of the document's ``answers``.
    """
    lower = f"{row['lower']:.6g}"
    if row["question"] == "sector":
        return f"sector [{lower}, k]{', time-varying' if row['time_varying'] else ''}"
    return f"slope in [{lower}, k]{', odd' if row['odd'] else ''}"


def asked_about(row: Data, law_class: Data | None) -> bool:
    """Whether the row is of the kind of the class asked about.

    Parameters
    ----------
    row : dict
        One of the document's ``answers``.
    law_class : dict or None
        The document's class.
    """
    if law_class is None:
        return False
    if law_class["time_varying"] or law_class["slope"] is None:
        return bool(row["question"] == "sector" and row["time_varying"] == law_class["time_varying"])
    return bool(row["question"] == "slope" and row["odd"] == law_class["odd"])


def criteria(data: Data) -> list[Data]:
    """Each criterion once for each kind of class it was asked about with different results, and its key.

    Parameters
    ----------
    data : dict
        The document.
    """
    seen: dict[tuple[str, str], Data] = {}
    for i, row in enumerate(data["answers"]):
        for j, answer in enumerate(row["answers"]):
            odd = row["odd"] and "odd" in answer["needs"]
            name = f"{answer['criterion']}{', odd laws' if odd else ''}"
            same = (name, repr((answer["largest"], answer["multiplier"], answer["reason"])))
            seen.setdefault(same, {"name": name, "key": f"answers.{i}.answers.{j}", **answer})
    return sorted(seen.values(), key=lambda answer: (answer["verdict"] != "PROVED", -_size(answer["largest"][0])))


def counterexamples(data: Data) -> list[Data]:
    """Each destabilising law once, with the classes it belongs to and what there is to see of it.

    Parameters
    ----------
    data : dict
        The document.
    """
    seen: dict[str, Data] = {}
    for row in data["answers"]:
        witness = row["witness"]
        if witness is not None:
            entry = seen.setdefault(
                repr((witness["kind"], witness["description"])),
                {**witness, "classes": [], "details": _details(witness["data"])},
            )
            entry["classes"].append(class_words(row))
    return sorted(seen.values(), key=lambda witness: _size(witness["k"]))


_SHOWN = (
    ("points", "φ through (σ, φ)"),
    ("sigma", "σ repeats"),
    ("u", "μ repeats"),
    ("gains", "gains in turn"),
    ("times", "each for so long [s]"),
)
_LISTED = 12
_LONG = 14


def _details(data: Data) -> list[tuple[str, str]]:
    """What a reader can look at, lists cut after a dozen entries."""
    return [(name, _listed(data[key])) for key, name in _SHOWN if isinstance(data.get(key), list)]


def _listed(values: list[object]) -> str:
    shown = [f"({', '.join(map(_short, entry))})" if isinstance(entry, list) else _short(entry) for entry in values]
    more = f", … ({len(values)} in all)" if len(values) > _LISTED else ""
    return ", ".join(shown[:_LISTED]) + more


def _short(value: object) -> str:
    """A number exactly if that is short, else to nine digits."""
    text = str(value)
    return f"{float(Fraction(text)):.9g}" if len(text) > _LONG else text


def _size(value: float | str) -> float:
    return float(value)
