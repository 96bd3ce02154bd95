"""Loops side by side for Coq: a module for each part, and a theorem about the whole plant that applies them.

Where parts drive others, or are in other states, one function for all of them: a sum of those of the parts, each times
so much that the whole falls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import eliminated, numbers
from lure.analysis.certificates.channels import Plant, channels, plant
from lure.analysis.certificates.parts import PLACE, driven, part, turned
from lure.analysis.export.falling import FallingTheorem, fallen
from lure.analysis.export.loops import MOST_STATES, carried, of_states
from lure.analysis.export.quadratic import Vector, forms, mix
from lure.analysis.export.words import refused, whole_file

MOST_GAP = 120


@dataclass(frozen=True, kw_only=True)
class _Part:
    """A part, its theorem, and the places of its channels and states, from 0."""

    theorem: FallingTheorem
    channels: list[int]
    states: list[int]


def beside_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of parts, each of which a quadratic form with integrals shows, in its own states.

    The states of a part satisfy the equations of the part, entry by entry, so that its theorem is applied to them.

    Raises
    ------
    refused
        An ``InputError``: a part has no form, or no sum of them falls.
    """
    proof = data["proof"]
    whole_plant = plant(data["system"], late=True)
    asked, parts = channels(data["laws"], len(whole_plant.D)), list[_Part]()
    H = turned(whole_plant, proof["basis"]) if "basis" in proof else whole_plant
    if data["theorem"] == "cascade":
        H = driven(H, [(entry["channels"], entry["states"]) for entry in proof["parts"]])
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
    if data["theorem"] == "cascade" or "basis" in proof:
        return _joined(data, whole_plant, parts).text(claim)
    return _text(data, claim, H, parts)


def _joined(data: Mapping[str, Any], H: Plant, parts: list[_Part]) -> FallingTheorem:
    """One theorem about all parts, of ``sum M_k V_k`` where those before count for more.

    Raises
    ------
    refused
        An ``InputError``: a part is of another kind, or no sum falls.
    """
    n, m = len(H.A), len(H.D)
    if n > MOST_STATES or any(one.theorem.loop.block or one.theorem.loop.each for one in parts):
        raise refused(f"parts in one form have up to {MOST_STATES} states, finite bounds and no full blocks")
    units = [[Fraction(i == j) for j in range(n)] for i in range(n)]
    basis = [numbers(row) for row in data["proof"]["basis"]] if "basis" in data["proof"] else units
    back = eliminated(basis, units)
    assert back is not None, "the checker found it to be a basis"
    own = of_states(H.A, H.B, H.C, H.D, discrete=H.discrete)
    for gap in range(0, MOST_GAP, 4):
        bounds: list[tuple[Fraction, Fraction | float]] = [(Fraction(0), Fraction(0))] * m
        weights, theta, rows = [Fraction(0)] * m, [Fraction(0)] * m, list[Vector]()
        P = [[Fraction(0)] * n for _ in range(n)]
        for k, one in enumerate(parts):
            loop, factor = one.theorem.loop, Fraction(1 << gap * (len(parts) - 1 - k))
            states = [back[j] for j in one.states]
            inner = carried([[factor * v for v in row] for row in loop.P], states, [])
            P = [[a + b for a, b in zip(*pair, strict=True)] for pair in zip(P, inner, strict=True)]
            rows += [mix(row[: len(states)], states) for row in loop.rows]
            for i, own_bounds, weight, turn in zip(one.channels, loop.bounds, loop.weights, loop.theta, strict=True):
                bounds[i], weights[i], theta[i] = own_bounds, factor * weight, factor * turn
        joined = replace(own, bounds=bounds, weights=weights, theta=theta, P=P, rows=units if len(rows) == n else rows)
        found = forms(joined)
        if found is not None:
            theorem = FallingTheorem(data, joined)
            theorem.forms = found
            return theorem
    raise refused("no sum of the functions of its parts was found that falls")


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
