"""Numbers, lists and whole files in the words of Coq."""

from __future__ import annotations

import re
import textwrap
from collections import defaultdict
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cache
from importlib.resources import files
from typing import Any

from lure.analysis.export.quadratic import Loop
from lure.analysis.wording import plain
from lure.errors import InputError

WIDTH, HEADING = 118, "(* ----"
NAME, COMMENT = re.compile(r"[A-Za-z_][\w']*"), re.compile(r"\(\*.*?\*\)", re.DOTALL)
SENTENCE = r"Definition|Fixpoint|Inductive|Lemma|Record|Theorem"
FIRST = re.compile(rf"^(?=\(\*|(?:{SENTENCE}|Open|Require|Section)\b)", re.MULTILINE)
GIVEN = re.compile(rf"^(?:{SENTENCE}) ([\w']+)", re.MULTILINE)
TYPE = re.compile(r"^(?:Inductive|Record) [^.]*", re.MULTILINE)
OF_TYPE = re.compile(r"(?:[|{;]|:=) *([\w']+)")


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
        Files beside this one, of which the file holds what it uses.
    parts : iterable of str
        Definitions and the theorem ``stable`` or ``moves``, which is the last.
    """
    parts = list(parts)
    name = parts[-1].split()[1]
    head = textwrap.wrap(
        f"The certificate ({origin}) says: {plain(claim)}.  What this file proves is the theorem `{name}` at the end, "
        "of the plant's own coefficients, from the hypotheses that stand in it.  Written by lure; check it: "
        "coqc, 8.16 or later.",
        WIDTH - 3,
    )
    body = [
        "(* " + "\n   ".join(head) + " *)",
        needed(dict.fromkeys(libraries), "\n".join(parts)),
        "(* ---- This loop ---- *)",
        *parts,
        f"Print Assumptions {name}.",
    ]
    return "\n\n".join(part.strip("\n") for part in body) + "\n"


def words(text: str) -> list[str]:
    """The names in a text of Coq, without comments."""
    return NAME.findall(COMMENT.sub("", text))


@cache
def sentences(library: str) -> list[tuple[str, list[str], list[str]]]:
    """What a file of lemmas consists of: each sentence with its proof, or a whole section; what it names, what it uses.

    A comment belongs to the sentence after it; a heading stands alone.
    """
    text = files(__package__ or "").joinpath(library).read_text("utf-8")
    found, held = list[tuple[str, list[str], list[str]]](), ""
    for part in filter(None, FIRST.split(text)):
        held += part
        section = re.search(r"^Section (\w+)\.", held, re.MULTILINE)
        if not part.startswith(HEADING) and (part.startswith("(*") or (section and f"\nEnd {section[1]}." not in held)):
            continue
        names = [*GIVEN.findall(held), *(name for one in TYPE.findall(held) for name in OF_TYPE.findall(one))]
        found.append((held, names, words(held)))
        held = ""
    return found


def needed(libraries: Iterable[str], text: str) -> str:
    """Of files of lemmas what a text uses, and what that uses, in their order and beneath their headings."""
    parts = [one for library in libraries for one in sentences(library)]
    places = defaultdict[str, list[int]](list)
    for i, (_, names, _) in enumerate(parts):
        for name in names:
            places[name].append(i)
    kept, used = {i for i, (_, names, _) in enumerate(parts) if not names}, words(text)
    while used:
        new = {i for name in used if name in places for i in places[name]} - kept
        kept |= new
        used = [name for i in new for name in parts[i][2]]
    shown = [parts[i][0] for i in sorted(kept)]
    under = zip(shown, [*shown[1:], HEADING], strict=True)
    shown = [one for one, after in under if not (one.startswith(HEADING) and after.startswith(HEADING))]
    return re.sub(r"\n{3,}", "\n\n", "".join("\n" * one.startswith(HEADING) + one for one in shown))


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
