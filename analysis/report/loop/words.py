"""The words of the page on a loop: headline, classes, criteria and counterexamples."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from lure.analysis.numerics.doubles import bound_above, bound_below
from lure.analysis.questions.proofs import NOT_NEEDED, REFUSED

Data = dict[str, Any]


def own(data: Data) -> bool:
    """Whether the verdict is on the nonlinearity that was given, without a condition: PROVED, and its class checked.

    Parameters
    ----------
    data : dict
        The document.
    """
    conclusion = data["conclusion"]
    return (
        data["system"]["law"] is not None
        and conclusion["verdict"] == "PROVED"
        and conclusion["membership"] == "checked"
    )


def headline(data: Data) -> str:
    """The verdict in one sentence, without how it was found; after the name of the nonlinearity what is proved of it.

    Parameters
    ----------
    data : dict
        The document.
    """
    conclusion = data["conclusion"]
    return str(conclusion["meaning"] if own(data) else conclusion["headline"])


def explanation(data: Data) -> str:
    """What the statement says after its headline; empty if that is all of it.

    Parameters
    ----------
    data : dict
        The document.
    """
    conclusion = data["conclusion"]
    rest: str = conclusion["statement"][len(conclusion["headline"]) - 1 :].lstrip(",:;. ")
    if rest.startswith("(certified)"):
        return rest.replace("(certified)", "Certified", 1)
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
    if data["system"]["class"] is not None or "classes" in data["system"]:
        proved = conclusion["verdict"] == "PROVED"
        return ["nothing: the question asked is decided" if proved else "nothing that these criteria know of"]
    gaps = [f"{class_words(row)}: nothing is known {_gap(row)}" for row in rows if row["gap"] == "open"]
    return gaps or ["nothing: every gap is closed"]


def _gap(row: Data) -> str:
    """Where between its two numbers a row of the table is silent."""
    start, end = row["proved_text"] or bound_below(_size(row["lower"])), row["refuted_text"]
    return f"between {start} and {end}" if end else f"above {start}"


def class_words(row: Data) -> str:
    """The classes of one row of the table, such as ``odd, slope in [0, k]``.

    Parameters
    ----------
    row : dict
        One of the document's ``answers``.
    """
    if "classes" in row:
        return f"{row['classes']['text']}; upper bounds times k"
    lower = f"{row['lower']:.6g}"
    if row["question"] == "sector":
        return f"sector [{lower}, k]{', time-varying' if row['time_varying'] else ''}"
    return f"slope in [{lower}, k]{', odd' if row['odd'] else ''}"


def asked_about(row: Data, system: Data) -> bool:
    """Whether the row is of the kind of the class asked about, with several channels about these classes.

    Parameters
    ----------
    row : dict
        One of the document's ``answers``.
    system : dict
        The document's ``system``.
    """
    if "classes" in system:
        return bool(row["classes"] == system["classes"])
    nonlinearity_class = system["class"]
    if nonlinearity_class is None:
        return False
    if nonlinearity_class["time_varying"] or nonlinearity_class["slope"] is None:
        return bool(row["question"] == "sector" and row["time_varying"] == nonlinearity_class["time_varying"])
    return bool(row["question"] == "slope" and row["odd"] == nonlinearity_class["odd"])


def reason(data: Data) -> str:
    """Why nothing was proved of the class asked about, where the statement does not say it; empty elsewhere.

    Parameters
    ----------
    data : dict
        The document.
    """
    conclusion, rows = data["conclusion"], data["answers"]
    if conclusion["verdict"] == "PROVED":
        return ""
    asked = [row for row in rows if asked_about(row, data["system"])] or rows
    why: str = asked[0]["reason"]
    if data["system"]["law"] is not None:  # what can be done for it stands among the hints
        why = why.partition("; give ")[0]
    return why if why and why not in conclusion["statement"] and asked[0]["verdict"] != "PROVED" else ""


def criteria(data: Data) -> list[Data]:
    """Each criterion once for each kind of class it was asked about with different results, and its key.

    Criteria that proved nothing for one and the same reason are one entry.

    Parameters
    ----------
    data : dict
        The document.
    """
    seen: dict[str, Data] = {}
    for i, row in enumerate(data["answers"]):
        for j, answer in enumerate(row["answers"]):
            odd = row["odd"] and "odd" in answer["needs"]
            name = f"{answer['criterion']}{', odd nonlinearities' if odd else ''}"
            proved = answer["verdict"] == "PROVED"
            same = repr(
                (
                    name if proved or answer["theorem"] not in (REFUSED, NOT_NEEDED) else "",
                    answer["largest"],
                    answer["reason"],
                )
            )
            entry = seen.setdefault(same, {"names": [], "key": f"answers.{i}.answers.{j}", **answer})
            entry["names"] += [] if name in entry["names"] else [name]
    return sorted(seen.values(), key=lambda answer: (answer["verdict"] != "PROVED", -_size(answer["largest"][0])))


def counterexamples(data: Data) -> list[Data]:
    """Each destabilising nonlinearity once, with the classes it belongs to and what there is to see of it.

    Parameters
    ----------
    data : dict
        The document.
    """
    seen: dict[str, Data] = {}
    for row in data["answers"]:
        both = [one for one in (row["trivial"], row["witness"]) if one is not None]
        for witness in both:
            quoted = row["refuted_text"] if witness is both[0] else bound_above(float(witness["k"]))
            entry = seen.setdefault(
                repr((witness["kind"], witness["description"])),
                {**witness, "quoted": quoted, "classes": [], "details": _details(witness["data"])},
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
