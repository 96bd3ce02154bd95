"""Constant gains of a plant in states with which a solution has no limit, for Coq: `members.v`.

One gain is found and the others stay: that channel sees ``num/den``, ``den = det(s - A_0)``, and ``x = adj(s - A_0) b
xi`` at ``s = d/dt`` (in discrete time the shift), ``den xi = -g num xi`` as of one channel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF, eliminated
from lure.analysis.certificates.channels import closed_loop
from lure.analysis.certificates.frequencies import transfer
from lure.analysis.export.gained import Gained, Words, gained_loop, state_of, within
from lure.analysis.export.jumping import LIBRARIES as CONTINUOUS
from lure.analysis.export.jumping import growth, told
from lure.analysis.export.modes import Mode
from lure.analysis.export.switching import LIBRARIES as DISCRETE
from lure.analysis.export.switching import falling_forms, turned_ends, turned_proof
from lure.analysis.export.words import folded, integers, number, reals, refused
from lure.arrays import in_doubles, np
from lure.errors import InputError


def members_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by constant gains of a plant in states.

    Where no channel alone moves all states, or its class has infinite bounds, a form shows that a solution grows:
    ``x'Qx`` falls, and is negative at the start.

    Raises
    ------
    refused
        An ``InputError``: it has operators, memory or a rate, or no root and no form was found.
    """
    return members_words(data).text(claim, data["proof"]["method"])


def members_words(data: Mapping[str, Any]) -> Words:
    """The theorem and its proof.

    Raises
    ------
    refused
        An ``InputError``: see above.
    """
    if "unlimited" in data["proof"]:
        raise refused("it is about a gain from w to z")
    loops = gained_loop(data)
    if len(loops.bounds) == len(loops.block):
        for j in range(len(loops.block)):
            with suppress(InputError):
                return _Members(loops, j, data["conclusion"]).words()
    return _in_steps(loops) if loops.plant.discrete else _in_time(loops)


class _Members:
    """The words of one file, channel ``j`` being that whose gain is found."""

    def __init__(self, loops: Gained, j: int, conclusion: str) -> None:
        H, self.loops, self.j, self.bounds = loops.plant, loops, j, loops.bounds
        (self.gains,), self.discrete = loops.gains, H.discrete
        n, m = len(H.A), len(H.D)
        closed = closed_loop(H, [[g * (i == k != j) for k in range(m)] for i, g in enumerate(self.gains)])
        if closed is None or any(low == -INF for low, _ in self.bounds):
            raise refused("the loop of the other gains is not well posed, or a class has no lower bound")
        A, B, C, D = closed[:4]
        units = [[Fraction(i == k) for k in range(n)] for i in range(n)]
        den, seen = transfer(
            A, [[row[j]] for row in B], [*units, *C], [*([Fraction(0)] for _ in units), *([row[j]] for row in D)]
        )
        self.den, own = [Fraction(c) for c in den], [row[0] for row in seen]
        for p in own:
            while len(p) > 1 and not p[-1]:
                p.pop()
        self.states, self.sigma = own[:n], own[n:]
        rows = [[p[i] if i < len(p) else Fraction(0) for p in self.states] for i in range(n)]
        found = eliminated(rows, [[Fraction(i == 0)] for i in range(n)])
        if found is None:
            raise refused("no channel alone moves all states")
        self.weights = [row[0] for row in found]
        time = "discrete" if H.discrete else "continuous"
        inner = {"kind": "transfer", "time": time, "denominator": [str(c) for c in self.den[::-1]]}
        inner["numerator"] = [str(c) for c in self.sigma[j][::-1]]
        proof = {"method": "linear-gain", "gain": str(self.gains[j])}
        inner_data = {"laws": loops.laws[j], "system": inner, "proof": proof, "conclusion": conclusion}
        self.mode = Mode(inner_data, several=len(loops.laws) > 1)

    def words(self) -> Words:
        """The theorem and its proof."""
        n, m = len(self.loops.plant.A), len(self.bounds)
        lists = [(f"p{k}", p) for k, p in enumerate(self.states)]
        lists += [(f"q{i}", [g * c for c in self.sigma[i]]) for i, g in enumerate(self.gains) if i != self.j]
        lists.append(("mixture", self.weights[::-1]))
        told = "\n".join(reals(name, p[::-1]) for name, p in lists)
        own = self.mode.parts()
        self.rests = "forall c" not in own[-1]  # constant solutions alone, which have a limit, other than 0
        inner, limit = f"Module Inner.\n{chr(10).join(own)}\nEnd Inner.", "Un_cv" if self.discrete else "tends_to"
        end = f"~ (forall k, (k < {n})%nat -> {limit} (x k) {'0' if self.rests else '(c k)'})"
        end = end if self.rests else f"forall c : nat -> R, {end}"
        libraries = ("forms.v", "flow.v", "frequencies.v", "modes.v", "members.v")
        return Words(libraries=libraries, parts=[inner, told], end=end, proof=self.proof(n, m), **_said(self.loops))

    def proof(self, n: int, m: int) -> list[str]:
        """Its proof."""
        name = "shifts" if self.discrete else "along"
        opened = ", ".join(["Inner.num", "Inner.den", *(f"p{k}" for k in range(n))])
        opened += "".join(f", q{i}" for i in range(m) if i != self.j)
        lemma, same = ("blend_limit_in_steps", "same_in_steps") if self.discrete else ("blend_limit", "tends_to_same")
        x = "; ".join(f"{name} p{k} xi" for k in range(n))
        w = "; ".join(f"fun t => g * {name} Inner.num xi t" if i == self.j else f"{name} q{i} xi" for i in range(m))
        chosen = ", ".join("g" if i == self.j else number(g) for i, g in enumerate(self.gains))
        simple = f"unfold {opened}; cbn [{name} length Nat.add]"
        flow = "closed" if self.discrete else "flow [closed"
        lines = [
            "Proof.",
            f"  destruct Inner.moves as [g [xi [bounds [{flow} never]]]]{']' * (not self.discrete)}.",
            f"  assert (E : forall t, {name} Inner.den xi t = - (g * {name} Inner.num xi t)) by exact closed.",
            f"  unfold {opened} in *; cbn [{name} length Nat.add] in E.",
            f"  exists {chosen}, (fun k => nth k [{x}] (fun _ => 0)), (fun i => nth i [{w}] (fun _ => 0)); cbn [nth].",
            *("  split; [lra|]." for _ in range(m)),
        ]
        lines += [f"  split; [intro t; specialize (E t); {simple}; nra|]." for _ in range(m)]
        for k in range(n):
            if self.discrete:
                lines.append(f"  split; [intro t; specialize (E t); {simple}; lra|].")
                continue
            lines += [
                "  split; [intro t; specialize (E t)|].",
                f"  {{ apply (derivable_same (along p{k} xi) _ t (along p{k} (fun k => xi (S k)) t));",
                "      [reflexivity| |].",
                f"    - {simple}; lra.",
                "    - apply along_flows; exact flow. }",
            ]
        zero = "replace 0 with (limit_of mixture (fun _ => 0) 0) by (unfold mixture; cbn [limit_of]; ring)"
        lines += [
            f"  intro lim; apply never; {zero}."
            if self.rests
            else "  intros c lim; apply (never (limit_of mixture c 0)).",
            f"  apply ({same} (blend mixture (fun k => nth k [{x}] (fun _ => 0)) 0)).",
            f"  - intro t; unfold mixture, {opened}; cbn [blend nth {name} length Nat.add]; lra.",
            f"  - apply {lemma}; intros j J; apply lim; unfold mixture in J; cbn [length] in J; lia.",
            "Qed.",
        ]
        return lines


def _said(loops: Gained) -> dict[str, Any]:
    """What is said of constant gains."""
    inside = [text for b, ends in enumerate(loops.bounds) if (text := within(f"g{b}", ends))]
    return {"loops": loops, "kind": "R", "gains": inside, "laws": [f"g{b} *" for b in loops.block]}


def _in_steps(loops: Gained) -> Words:
    """By a form, in discrete time."""
    found, (gains,) = falling_forms(loops.matrices), loops.gains
    lists, said = [*found.told([integers(rows) for _, rows in found.next]), loops.outputs()], _said(loops)
    proof = [*turned_proof(found, [*map(number, gains)]), *["  split; [lra|]."] * len(said["gains"])]
    end = f"forall B, ~ (forall t, norm2 {state_of(len(found.start))} <= B)"
    proof += turned_ends(loops, [])
    return Words(libraries=DISCRETE, parts=["\n".join(lists)], end=end, proof=proof, **said)


def _in_time(loops: Gained) -> Words:
    """By a form, in continuous time."""
    (A,), ((unit, rows),), (gains,), n = loops.matrices, loops.values, loops.gains, len(loops.plant.A)
    fast = max(abs(np.linalg.eigvals(in_doubles(A))))
    if not fast > 0:
        raise refused("no channel alone moves all states, and no solution grows exponentially")
    found, said = growth([A], [Fraction(2) ** -math.ceil(math.log2(float(fast)))]), _said(loops)
    forms, stay = told(found.stays[0], 0, found.stays[0].rows)
    lists = [
        folded(f"Definition start : list R := {integers(found.start)}."),
        folded(f"Definition outputs : list (list Z) := {integers(rows)}%Z."),
        forms,
        folded(f"Definition only : stay := {stay}%Z."),
        f"Lemma grow : stays_ok {found.test} [only] = true.",
        "Proof. vm_cast_no_check (eq_refl true). Qed.",
    ]
    opened = "unfold at_once, listed, rows_of, only, outputs; cbn [seq map nth fst snd dot]; lra"
    same = "refine (derivable_same _ _ t _ _ (fun s => eq_refl) _ (F {0}%nat t ltac:(lia)))"
    proof = [
        "Proof.",
        "  assert (neg : qf (first_of only) start < 0).",
        "  { unfold first_of, only, forms0, start; cbn [fst snd hd qf dot]; lra. }",
        f"  destruct (kept {number(found.slower)} {found.test} only start ltac:(lra) grow eq_refl neg) as [x [F U]].",
        f"  exists {', '.join(map(number, gains))}, x,",
        f"    (fun i t => dot (nth i outputs []) (at_once {n} x t) / {unit}).",
        *["  split; [lra|]."] * len(said["gains"]),
        *[f"  split; [intro t; {opened}|]."] * len(loops.block),
        *(f"  split; [intro t; {same.format(k)}; {opened}|]." for k in range(n)),
        "  exact U.",
        "Qed.",
    ]
    end = f"forall B, exists t, 0 <= t /\\ B < norm2 {state_of(n)}"
    return Words(libraries=CONTINUOUS, parts=["\n".join(lists)], end=end, proof=proof, **said)
