"""Numbers, lists and whole files in the words of Coq."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from fractions import Fraction
from importlib.resources import files
from typing import Any

from lure.analysis.export.quadratic import Loop
from lure.analysis.wording import plain
from lure.errors import InputError

WIDTH = 118


def refused(reason: str) -> InputError:
    """The error for a certificate that cannot be exported.

    ``reason``: what there is, and what can be exported.
    """
    return InputError(f"this certificate cannot be exported to Coq: {reason}")


def whole_file(claim: str, origin: str, libraries: Iterable[str], parts: Iterable[str]) -> str:
    """A file: what it shows, the lemmas that it needs, the loop, and what the proof assumes.

    Parameters
    ----------
    claim : str
        The sentence of the checker.
    origin : str
        The theorem and the method of the certificate.
    libraries : iterable of str
        Files beside this one.
    parts : iterable of str
        Definitions and the theorem ``stable`` or ``moves``, which is the last.
    """
    room, parts = files(__package__ or ""), list(parts)
    name = parts[-1].split()[1]
    head = textwrap.wrap(
        f"The certificate ({origin}) says: {plain(claim)}.  What this file proves is the theorem `{name}` at the end, "
        "of the plant's own coefficients, from the hypotheses that stand in it.  Written by lure; check it: "
        "coqc, 8.16 or later.",
        WIDTH - 3,
    )
    library = [room.joinpath(one).read_text("utf-8") for one in dict.fromkeys(libraries)]
    body = [
        "(* " + "\n   ".join(head) + " *)",
        *library,
        "(* ---- This loop ---- *)",
        *parts,
        f"Print Assumptions {name}.",
    ]
    return "\n\n".join(part.strip("\n") for part in body) + "\n"


def folded(text: str) -> str:
    """A line, or several where it is long."""
    return "\n".join(textwrap.wrap(text, WIDTH, break_long_words=False)) if len(text) > WIDTH else text


def number(value: Fraction | int) -> str:
    """A number of ``R``."""
    value = Fraction(value)
    text = str(value.numerator) if value.denominator == 1 else f"{value.numerator} / {value.denominator}"
    return text if value.denominator == 1 and value >= 0 else f"({text})"


def reals(name: str, row: Sequence[Fraction]) -> str:
    """The definition of a list of numbers of ``R``."""
    return folded(f"Definition {name} : list R := [{'; '.join(map(number, row))}].")


def integers(rows: Sequence[Any]) -> str:
    """A list of (lists of) integers."""
    return "[" + "; ".join(integers(v) if isinstance(v, list) else str(v) for v in rows) + "]"


def terms(given: Sequence[tuple[int, list[int], list[int]]]) -> str:
    """A list of products of two linear forms."""
    return "[" + "; ".join(f"({c}, ({integers(u)}, {integers(v)}))" for c, u, v in given) + "]"


def combined(row: Sequence[Fraction], names: Sequence[str]) -> str:
    """A combination of what has names."""
    return " + ".join(f"{number(v)} * {name}" for v, name in zip(row, names, strict=True) if v) or "0"


def equations(loop: Loop, laws: Sequence[str], inputs: int = 0) -> list[str]:
    """The values ``w i t`` of several channels and the flow of the states ``x k t``, of ``loops.of_states``.

    Parameters
    ----------
    loop : Loop
        The plant.
    laws : sequence of str
        Of each channel what is applied to ``sigma``, which follows in brackets.
    inputs : int
        How many channels after these may be anything.
    """
    moved = "x {}%nat (S t) = {}" if loop.discrete else "derivable_pt_lim (x {}%nat) t ({})"
    names = [f"x {k}%nat t" for k in range(len(loop.now))] + [f"w {i}%nat t" for i in range(len(laws) + inputs)]
    values = [f"w {i}%nat t = {law} ({combined(loop.sigma[i], names)})" for i, law in enumerate(laws)]
    flows = [moved.format(k, combined(row, names)) for k, row in enumerate(loop.then)]
    return [f"(forall t, {text})" for text in (*values, *flows)]
