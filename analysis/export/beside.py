"""Loops side by side for Coq: a module for each part, and a theorem about the whole plant that applies them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.channels import Plant, channels, plant
from lure.analysis.certificates.parts import PLACE, part
from lure.analysis.export.falling import FallingTheorem, fallen
from lure.analysis.export.loops import of_states
from lure.analysis.export.words import refused, whole_file


@dataclass(frozen=True, kw_only=True)
class _Part:
    """A part, its theorem, and the places of its channels and states, from 0."""

    theorem: FallingTheorem
    channels: list[int]
    states: list[int]


def beside_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of parts, each of which a quadratic form with integrals shows, in its own states.

    The states of a part satisfy the equations of the part, entry by entry, so that its theorem is applied to them.

    Parameters
    ----------
    data : Mapping
        The certificate.
    claim : str
        The sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: the parts drive each other or are in other states, or one has no form.
    """
    proof = data["proof"]
    if data["theorem"] != "parts" or "basis" in proof:
        raise refused(
            "parts that drive others, or are in other states than the plant, have none; parts by themselves do"
        )
    H = plant(data["system"], late=True)
    asked, parts = channels(data["laws"], len(H.D)), list[_Part]()
    for entry in proof["parts"]:
        alone = entry["kind"] in ("transfer", "state-space")
        where = (entry["channels"], entry["states"], "state-space" if alone else entry["kind"])
        system, laws, _ = part(H, asked, data["laws"], *where)
        inner = {key: value for key, value in entry.items() if key not in PLACE}
        if entry["kind"] == "transfer":  # its P is of other states
            inner["proof"] = {"method": "polynomial"}
        own = [[i - 1 for i in places] for places in where[:2]]
        theorem = fallen({**data, "system": system, "laws": laws, **inner})
        theorem.loop = replace(theorem.loop, rest=None)
        parts.append(_Part(theorem=theorem, channels=own[0], states=own[1]))
    return _text(data, claim, H, parts)


def _text(data: Mapping[str, Any], claim: str, H: Plant, parts: list[_Part]) -> str:
    """The whole file."""
    m, n = len(H.D), len(H.A)
    bounds: list[tuple[Fraction, Fraction | float]] = [(Fraction(0), Fraction(0))] * m
    theta, rows = [Fraction(0)] * m, []
    for one in parts:
        loop = one.theorem.loop
        for i, own, turn in zip(one.channels, loop.bounds, loop.theta, strict=True):
            bounds[i], theta[i] = own, turn
        for row in loop.rows:
            values = dict(zip(one.states, row, strict=True))
            rows.append([values.get(j, Fraction(0)) for j in range(n)])
    loop = of_states(H.A, H.B, H.C, H.D, discrete=H.discrete)
    whole = FallingTheorem(data, replace(loop, bounds=bounds, theta=theta, rows=rows))
    lines = whole.opening()
    for k, one in enumerate(parts):
        lines.append(f"  assert (E{k} := {_applied(k, one, whole)}).")
    ends = [f"E{k}_{p}" for k, one in enumerate(parts) for p in range(len(one.theorem.loop.rows))]
    for k, one in enumerate(parts):
        *first, last = (f"E{k}_{p}" for p in range(len(one.theorem.loop.rows)))
        names = f"{''.join(f'[{name} ' for name in first)}{last}{']' * len(first)}"
        lines.append(f"  destruct E{k} as {names}." if first else f"  pose proof E{k} as {last}.")
    *first, last = ends
    lines.append(f"  exact {''.join(f'(conj {name} ' for name in first)}{last}{')' * len(first)}.")
    modules = [f"Module Part{k}.\n{chr(10).join(one.theorem.parts())}\nEnd Part{k}." for k, one in enumerate(parts)]
    libraries = dict.fromkeys(library for one in parts for library in one.theorem.libraries())
    inside = "\n".join(whole.definitions())
    return whole_file(claim, "parts", libraries, [*modules, inside, "\n".join([*lines, "Qed."])])


def _applied(k: int, one: _Part, whole: FallingTheorem) -> str:
    """The theorem of a part, of what the whole does in its channels and states."""
    own = one.theorem
    names = {f"{name}{s}": f"{name}{whole.own[i]}" for s, i in zip(own.own, one.channels, strict=True)
             for name in ("phi", "Phi", "class", "integral", "graph")}  # fmt: skip
    names |= {f"{name}{a}": f"{name}{b}" for a, b in enumerate(one.states) for name in ("flow", "step")}
    x, w = (
        f"(fun k => nth k [{'; '.join(f'{name} {i}%nat' for i in places)}] ({name} 0%nat))"
        for name, places in (("x", one.states), ("w", one.channels))
    )
    given = [*own.binders()[1], x, w, *(name for name, _ in own.hypotheses())]
    return f"Part{k}.stable {' '.join(names.get(name, name) for name in given)}"
