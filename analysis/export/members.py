"""Constant gains of several channels with which a solution has no limit, for Coq: `members.v`.

One gain is found and the others stay: that channel sees ``num/den``, ``den = det(s - A_0)``, and ``x = adj(s - A_0) b
xi`` at ``s = d/dt`` (in discrete time the shift), ``den xi = -g num xi`` as of one channel.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF, eliminated
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.channels import Channels, Plant, channels, closed_loop, plant
from lure.analysis.certificates.frequencies import transfer
from lure.analysis.export.loops import of_states
from lure.analysis.export.modes import Mode
from lure.analysis.export.words import equations, folded, number, refused, whole_file
from lure.errors import InputError


def members_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by constant gains of several channels.

    Parameters
    ----------
    data : Mapping
        The certificate.
    claim : str
        The sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: it has operators, memory or a rate, no channel moves all states, or no root was found.
    """
    if "rate" in data or set(data["proof"]) != {"method", "gains"} or data["system"]["kind"] != "multivariable":
        raise refused("it is about a rate, a growth, a gain from w to z or a box of parameters")
    H, asked = plant(data["system"]), channels(data["laws"], len(data["system"]["D"]))
    if any(one.operator or one.memory or one.relu for one in asked.families) or len(asked.blocks) < len(H.D):
        raise refused("a channel is no function of sigma in a sector, or has the nonlinearity of another")
    last = len(H.D) - 1
    for j in range(last):
        with suppress(InputError):
            return _Members(data, H, asked, j).text(claim)
    return _Members(data, H, asked, last).text(claim)


class _Members:
    """The words of one file, channel ``j`` being that whose gain is found."""

    def __init__(self, data: Mapping[str, Any], H: Plant, asked: Channels, j: int) -> None:
        self.H, self.j, self.bounds = H, j, [asked.bounds(i) for i in range(len(H.D))]
        self.gains, self.discrete = [exact(v) for v in data["proof"]["gains"]], H.discrete
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
        self.mode = Mode({"laws": data["laws"]["channels"][j], "system": inner, "proof": proof}, several=True)

    def text(self, claim: str) -> str:
        """The whole file."""
        n, m = len(self.H.A), len(self.H.D)
        lists = [(f"p{k}", p) for k, p in enumerate(self.states)]
        lists += [(f"q{i}", [g * c for c in self.sigma[i]]) for i, g in enumerate(self.gains) if i != self.j]
        lists.append(("mixture", self.weights[::-1]))
        told = [folded(f"Definition {name} : list R := [{'; '.join(map(number, p[::-1]))}].") for name, p in lists]
        own = self.mode.parts()
        if "forall c" not in own[-1]:
            raise refused("its gains have constant solutions alone, which have a limit")
        inner = f"Module Inner.\n{chr(10).join(own)}\nEnd Inner."
        libraries = ("forms.v", "flow.v", "frequencies.v", "modes.v", "members.v")
        last = "\n".join([*self.statement(n, m), *self.proof(n, m)])
        return whole_file(claim, "counterexample, linear-gains", libraries, [inner, "\n".join(told), last])

    def statement(self, n: int, m: int) -> list[str]:
        """What there is."""
        moment, limit = ("nat", "Un_cv") if self.discrete else ("R", "tends_to")
        loop = of_states(self.H.A, self.H.B, self.H.C, self.H.D, discrete=self.discrete)
        inside = [
            f"{number(low)} <= g{i}" + ("" if high == INF else f" <= {number(Fraction(high))}")
            for i, (low, high) in enumerate(self.bounds)
        ]
        return [
            f"Theorem moves : exists ({' '.join(f'g{i}' for i in range(m))} : R) (x w : nat -> {moment} -> R),",
            *(f"  {text} /\\" for text in (*inside, *equations(loop, [f"g{i} *" for i in range(m)]))),
            f"  forall c : nat -> R, ~ (forall k, (k < {n})%nat -> {limit} (x k) (c k)).",
        ]

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
