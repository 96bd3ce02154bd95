"""Gains with which a solution falls more slowly than at a rate, for Coq: `paces.v`.

What grows, or has no limit, is a solution of the loop at that rate, which is ``e^(at)`` (``r^-t``) times one of the
loop; it is in a module of its own, as without a rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import paced
from lure.analysis.export.gained import Words, gained_loop, in_states, state_of
from lure.analysis.export.jumping import jumping_words
from lure.analysis.export.members import members_words
from lure.analysis.export.switching import turned_words
from lure.analysis.export.words import number, refused

SWITCHED = ("switched-gain", "switched-gains")
CONSTANT = ("linear-gain", "crossing", "matrix-gain", "linear-gains")


def pacing_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation of a rate, by constant gains or gains in turn; of one channel in states too.

    Raises
    ------
    refused
        An ``InputError``: it is of another kind, or no root and no form was found.
    """
    method, kind = data["proof"]["method"], data["system"]["kind"]
    if method not in (*SWITCHED, *CONSTANT) or kind not in ("transfer", "state-space", "multivariable"):
        raise refused(f"it is a refutation of a rate by {method}, of a plant of the kind {kind}; gains have an export")
    own = in_states({key: value for key, value in data.items() if key != "rate"})
    rate, discrete = exact(data["rate"]), data["system"]["time"] == "discrete"
    inner = {**own, "system": paced(own["system"], rate)}
    switched = turned_words if discrete else jumping_words
    found = switched(inner) if method in SWITCHED else members_words(inner)
    return _outer(found, own, number(rate)).text(claim, f"{method} with a rate")


def _outer(found: Words, own: Mapping[str, Any], a: str) -> Words:
    """The theorem about the loop itself."""
    discrete, bounded, n = found.loops.plant.discrete, "forall B" in found.end, len(found.loops.plant.A)
    if discrete:
        weighed = f"norm2 {state_of(n)} / ({a} ^ t) ^ 2 <= B", f"Un_cv (fun t => x k t / {a} ^ t)"
        end = f"forall B, ~ (forall t, {weighed[0]})"
    else:
        weighed = f"B < exp ({a} * t) ^ 2 * norm2 {state_of(n)}", f"tends_to (fun t => exp ({a} * t) * x k t)"
        end = f"forall B, exists t, 0 <= t /\\ {weighed[0]}"
    if not bounded:
        rests = "forall c" not in found.end
        end = f"~ (forall k, (k < {n})%nat -> {weighed[1]} {'0' if rests else '(c k)'})"
        end = end if rests else f"forall c : nat -> R, {end}"
    module = "\n\n".join([*found.parts, found.theorem()])
    outer = replace(
        found, loops=gained_loop(own), end=end, libraries=(*found.libraries, "paces.v"),
        parts=[f"Module Paced.\n\n{module}\n\nEnd Paced.\nImport Paced."],
    )  # fmt: skip
    return replace(outer, proof=_proof(found, a, bounded=bounded))


def _proof(found: Words, a: str, *, bounded: bool) -> list[str]:
    """Its proof, from that of the loop at the rate."""
    discrete, n, said = found.loops.plant.discrete, len(found.loops.plant.A), found.said()
    weight = f"{a} ^ t" if discrete else f"exp (- ({a} * t))"
    held = [f"H{i}" for i in range(len(said) + 1)]
    opened = (
        "".join(f"[{name} " for name in (*found.names, *held[:-1])) + held[-1] + "]" * (len(found.names) + len(said))
    )
    weighed = {"x": f"(fun k t => {weight} * x k t)", "w": f"(fun i t => {weight} * w i t)"}
    lines = [
        "Proof.",
        f"  destruct Paced.moves as {opened}.",
        f"  exists {', '.join(weighed.get(name, name) for name in found.names)}; cbv beta.",
    ]
    first, channels = len(found.gains), len(found.loops.block)
    for i, name in enumerate(held[:-1]):
        if i < first:
            lines.append(f"  split; [exact {name}|].")
        elif i < first + channels:
            lines.append(f"  split; [intro t; pose proof (f_equal (Rmult ({weight})) ({name} t)) as E; lra|].")
        elif "continuity_pt" in said[i]:
            lines.append(f"  split; [intros k t K; apply paced_continuity, {name}, K|].")
        elif discrete:
            lines.append(f"  split; [intro t; rewrite ({name} t); cbn [pow]; lra|].")
        elif found.jumps:
            lines.append(f"  split; [intros t N; refine (paced_flow {a} _ t _ _ ({name} t N) _); lra|].")
        else:
            lines.append(f"  split; [intro t; refine (paced_flow {a} _ t _ _ ({name} t) _); lra|].")
    if bounded:
        return [*lines, *_bounded(held[-1], a, n, discrete=discrete), "Qed."]
    begun = f"intros c lim; apply ({held[-1]} c)" if "forall c" in found.end else f"intro lim; apply {held[-1]}"
    return [*lines, *_limits(begun, a, discrete=discrete), "Qed."]


def _bounded(name: str, a: str, n: int, *, discrete: bool) -> list[str]:
    """That the solution is not bounded by the rate."""
    if discrete:
        return [
            f"  intros B bound; apply ({name} B); intro t; specialize (bound t).",
            f"  assert (P : {a} ^ t <> 0) by (apply pow_nonzero; lra).",
            "  apply Rle_trans with (2 := bound); right; cbn [norm2]; field; exact P.",
        ]
    return [
        f"  intro B; destruct ({name} B) as [t [T K]]; exists t; split; [exact T|].",
        f"  apply Rlt_le_trans with (1 := K); right; pose proof (paced_one {a} t) as P.",
        f"  transitivity ((exp ({a} * t) * exp (- ({a} * t))) ^ 2 * norm2 {state_of(n)}).",
        "  - rewrite P; ring.",
        "  - cbn [norm2]; ring.",
    ]


def _limits(begun: str, a: str, *, discrete: bool) -> list[str]:
    """That the solution has no limit at the rate, or does not tend to 0."""
    lines = [f"  {begun}; intros k K."]
    if discrete:
        same = f"same_in_steps (fun t => {a} ^ t * x k t / {a} ^ t)"
        return [*lines, f"  apply ({same}); [|apply lim, K]; intro t; field; apply pow_nonzero; lra."]
    same = f"tends_to_same (fun t => exp ({a} * t) * (exp (- ({a} * t)) * x k t))"
    return [*lines, f"  apply ({same}); [|apply lim, K]; intro t; rewrite <- Rmult_assoc, paced_one; ring."]
