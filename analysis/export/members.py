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
from lure.analysis.export.gained import Gained, gained_loop, within
from lure.analysis.export.jumping import DROP, growth, told
from lure.analysis.export.jumping import LIBRARIES as CONTINUOUS
from lure.analysis.export.modes import Mode
from lure.analysis.export.switching import LIBRARIES as DISCRETE
from lure.analysis.export.switching import falling_forms, turned_ends, turned_proof
from lure.analysis.export.words import equations, folded, integers, number, refused, whole_file
from lure.arrays import np
from lure.errors import InputError


def members_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by constant gains of a plant in states.

    Where no channel alone moves all states, or its class has infinite bounds, a form shows that a solution grows:
    ``x'Qx`` falls, and is negative at the start.

    Parameters
    ----------
    data : Mapping
        The certificate.
    claim : str
        The sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: it has operators, memory or a rate, or no root and no form was found.
    """
    if "unlimited" in data["proof"]:
        raise refused("it is about a gain from w to z")
    loops = gained_loop(data)
    if len(loops.bounds) == len(loops.block):
        for j in range(len(loops.block)):
            with suppress(InputError):
                return _Members(data, loops, j).text(claim)
    return _Growing(data, loops).text(claim)


class _Members:
    """The words of one file, channel ``j`` being that whose gain is found."""

    def __init__(self, data: Mapping[str, Any], loops: Gained, j: int) -> None:
        H, self.loops, self.j, self.bounds = loops.plant, loops, j, loops.bounds
        self.method, (self.gains,), self.discrete = data["proof"]["method"], loops.gains, H.discrete
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
        inner = {"kind": "transfer", "time": data["system"]["time"], "denominator": [str(c) for c in self.den[::-1]]}
        inner["numerator"] = [str(c) for c in self.sigma[j][::-1]]
        proof = {"method": "linear-gain", "gain": str(self.gains[j])}
        self.mode = Mode({"laws": loops.laws[j], "system": inner, "proof": proof}, several=len(loops.laws) > 1)

    def text(self, claim: str) -> str:
        """The whole file."""
        n, m = len(self.loops.plant.A), len(self.bounds)
        lists = [(f"p{k}", p) for k, p in enumerate(self.states)]
        lists += [(f"q{i}", [g * c for c in self.sigma[i]]) for i, g in enumerate(self.gains) if i != self.j]
        lists.append(("mixture", self.weights[::-1]))
        told = [folded(f"Definition {name} : list R := [{'; '.join(map(number, p[::-1]))}].") for name, p in lists]
        own = self.mode.parts()
        if "forall c" not in own[-1]:
            raise refused("its gains have constant solutions alone, which have a limit")
        inner = f"Module Inner.\n{chr(10).join(own)}\nEnd Inner."
        libraries = ("forms.v", "flow.v", "frequencies.v", "modes.v", "members.v")
        last = "\n".join([*self.statement(n), *self.proof(n, m)])
        return whole_file(claim, f"counterexample, {self.method}", libraries, [inner, "\n".join(told), last])

    def statement(self, n: int) -> list[str]:
        """What there is."""
        limit = "Un_cv" if self.discrete else "tends_to"
        return [*_stated(self.loops), f"  forall c : nat -> R, ~ (forall k, (k < {n})%nat -> {limit} (x k) (c k))."]

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
        lines += [
            "  intros c lim; apply (never (limit_of mixture c 0)).",
            f"  apply ({same} (blend mixture (fun k => nth k [{x}] (fun _ => 0)) 0)).",
            f"  - intro t; unfold mixture, {opened}; cbn [blend nth {name} length Nat.add]; lra.",
            f"  - apply {lemma}; intros j J; apply lim; unfold mixture in J; cbn [length] in J; lia.",
            "Qed.",
        ]
        return lines


def _stated(loops: Gained) -> list[str]:
    """That there are constant gains of the classes and a solution."""
    names = [f"g{b}" for b in range(len(loops.bounds))]
    inside = [text for name, ends in zip(names, loops.bounds, strict=True) if (text := within(name, ends))]
    moment = "nat" if loops.plant.discrete else "R"
    return [
        f"Theorem moves : exists ({' '.join(names)} : R) (x w : nat -> {moment} -> R),",
        *(f"  {text} /\\" for text in (*inside, *equations(loops.loop, [f"g{b} *" for b in loops.block]))),
    ]


class _Growing:
    """The words of one file, by a form."""

    def __init__(self, data: Mapping[str, Any], loops: Gained) -> None:
        self.loops, self.method, self.n = loops, data["proof"]["method"], len(loops.plant.A)
        (gains,) = loops.gains
        self.gains = [number(g) for g in gains]
        self.bounded = ["  split; [lra|]." for ends in loops.bounds if within("g", ends)]

    def text(self, claim: str) -> str:
        """The whole file."""
        libraries, parts = self.in_steps() if self.loops.plant.discrete else self.in_time()
        return whole_file(claim, f"counterexample, {self.method}", libraries, parts)

    @property
    def state(self) -> str:
        """The state at a time."""
        return "[" + "; ".join(f"x {k}%nat t" for k in range(self.n)) + "]"

    def in_steps(self) -> tuple[tuple[str, ...], list[str]]:
        """In discrete time."""
        found = falling_forms(self.loops.matrices)
        lists = [*found.told([integers(rows) for _, rows in found.next]), self.loops.outputs()]
        lines = [*_stated(self.loops), f"  forall B, ~ (forall t, norm2 {self.state} <= B)."]
        lines += [*turned_proof(found, self.loops, self.gains), *self.bounded, *turned_ends(self.loops, [])]
        return DISCRETE, ["\n".join(lists), "\n".join(lines)]

    def in_time(self) -> tuple[tuple[str, ...], list[str]]:
        """In continuous time."""
        (A,), ((unit, rows),), n = self.loops.matrices, self.loops.values, self.n
        fast = max(abs(np.linalg.eigvals(np.array([[float(v) for v in row] for row in A]))))
        if not fast > 0:
            raise refused("no channel alone moves all states, and no solution grows exponentially")
        found = growth([A], [Fraction(2) ** -math.ceil(math.log2(float(fast)))])
        forms, stay = told(found.stays[0], 0, found.stays[0].rows)
        test = f"{n} {found.terms} {found.room} {DROP}"
        lists = [
            folded(f"Definition start : list R := {integers(found.start)}."),
            folded(f"Definition outputs : list (list Z) := {integers(rows)}%Z."),
            forms,
            folded(f"Definition only : stay := {stay}%Z."),
            f"Lemma grow : stays_ok {test} [only] = true.",
            "Proof. vm_cast_no_check (eq_refl true). Qed.",
        ]
        opened = "unfold at_once, listed, rows_of, only, outputs; cbn [seq map nth fst snd dot]; lra"
        lines = [
            *_stated(self.loops),
            f"  forall B, exists t, 0 <= t /\\ B < norm2 {self.state}.",
            "Proof.",
            "  assert (neg : qf (first_of only) start < 0).",
            "  { unfold first_of, only, forms0, start; cbn [fst snd hd qf dot]; lra. }",
            f"  destruct (kept {test} only start grow eq_refl neg) as [x [F U]].",
            f"  exists {', '.join(self.gains)}, x,",
            f"    (fun i t => dot (nth i outputs []) (at_once {n} x t) / {unit}).",
            *self.bounded,
            *[f"  split; [intro t; {opened}|]."] * len(self.loops.block),
        ]
        for k in range(n):
            same = f"refine (derivable_same _ _ t _ _ (fun s => eq_refl) _ (F {k}%nat t ltac:(lia)))"
            lines.append(f"  split; [intro t; {same}; {opened}|].")
        return CONTINUOUS, ["\n".join(lists), "\n".join([*lines, "  exact U.", "Qed."])]
