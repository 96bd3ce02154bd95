"""The nonlinearities of a loop in the words of Coq: full blocks, `blocks.v`, or one in all channels, `coupled.v`."""

from __future__ import annotations

from fractions import Fraction

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.states import Family
from lure.analysis.export.quadratic import Forms, Loop
from lure.analysis.export.words import integers, number


class Laws:
    """Their names, their classes, and what is nonnegative of all of them together."""

    forms: Forms
    loop: Loop
    families: list[Family]
    own: list[str]
    path: str
    order: int
    discrete: bool
    sharp = False  # whether integrals are bounded by what slope bounds say

    def sigma(self, i: int) -> str:
        """The argument of a nonlinearity at ``t``."""
        return f"sigma{self.own[i]} {self.path} t"

    def phi(self, i: int) -> str:
        """A nonlinearity, at the time ``t`` if it depends on it."""
        name = f"phi{self.own[i] * (not self.one_law)}"
        return f"{name} t" if self.families[i].varying else name

    @property
    def one_law(self) -> bool:
        """Whether all channels have one nonlinearity."""
        return self.loop.odds is not None

    def sloped(self) -> list[tuple[str, str, str]]:
        """Of nonlinearities of which slope bounds are used: the end of its name, its class, and its channels' ends."""
        if not (self.one_law or self.sharp):
            return []
        odd = str(bool(self.loop.odds)).lower()
        return [
            (s * (not self.one_law), f"sloped {odd} {number(low)} {number(Fraction(high))} {self.phi(i)}", s)
            for i, (s, (low, high)) in enumerate(zip(self.own, self.loop.bounds, strict=False))
            if self.one_law or self.loop.theta[i]
        ]

    def class_of(self, i: int) -> str:
        """What is said of a nonlinearity."""
        low, high = self.loop.bounds[i]
        if self.loop.each:
            inner = f"in_sector {number(low)} K"
        else:
            inner = f"above {number(low)}" if high == INF else f"in_sector {number(low)} {number(Fraction(high))}"
        return f"forall t, {inner} ({self.phi(i)})" if self.families[i].varying else f"{inner} {self.phi(i)}"

    def box(self) -> list[str]:
        """What the class makes nonnegative of all channels together, and that it is; empty without a block."""
        f = self.forms
        if not f.block:
            return []
        if self.one_law:
            test = f"in_all_orders {str(bool(self.loop.odds)).lower()} block {len(self.own)}"
            return [
                f"Definition block : list (list Z) := {integers(f.block)}%Z.",
                f"Definition pairs : list (list Z) := {integers(f.pairs)}%Z.",
                "Definition products : list term := bilinear block pairs pairs.",
                f"Lemma in_box : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.",
            ]
        ends = "; ".join(f"({_gain(low)}, {_gain(high)})" for low, high in self.loop.bounds[: len(self.own)])
        signs = [f"Definition signs : orthants := {self.orthants()}%Z."] if f.cones else []
        test = "in_orthants block [] box signs" if f.cones else "at_vertices block [] box"
        return [
            f"Definition block : list (list Z) := {integers(f.block)}%Z.",
            f"Definition pairs : list (list Z) := {integers(f.pairs)}%Z.",
            "Definition products : list term := bilinear block pairs pairs.",
            f"Definition box : list (ratio * ratio) := [{ends}]%Z.",
            *signs,
            f"Lemma in_box : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.",
        ]

    def orthants(self, *signs: int) -> str:
        """The parts for the signs of ``sigma_1``, ``sigma_2`` and so on."""
        if len(signs) < len(self.own):
            return f"(Both {self.orthants(*signs, 1)} {self.orthants(*signs, -1)})"
        place = int("0" + "".join(str(int(v != signs[0])) for v in signs[1:]), 2)
        return "(Cone (Leaf [" + "; ".join(f"({a}, {integers(v)})" for a, *v in self.forms.cones[place]) + "]))"

    def blocks(self) -> list[str]:
        """That what is said of all channels together is nowhere negative for the class."""
        at, start = ("t", "intro t") if self.discrete else ("t Ht", "intros t Ht")
        test = "in_block_by_cones block box signs" if self.forms.cones else "in_block block box"
        lines = [f"  - {start}; apply ({test} pairs _ in_box)."]
        lines.append("    unfold pairs, box, at_; cbn [map within_gains].")
        opened = f"unfold z, {', '.join('sigma' + s for s in self.own)}; cbn [dot]"
        for i, s in enumerate(self.own):
            low, high = self.loop.bounds[i][0], Fraction(self.loop.bounds[i][1])
            held = f"(class{s} t)" if self.families[i].varying else f"class{s}"
            value = f"(eq_sym (graph{s} {at}))"
            lines += [
                f"    destruct (gain_of {number(low)} {number(high)} ({self.phi(i)}) _ _ {held} ltac:(lra) {value})",
                f"      as [d{s} [D{s} E{s}]].",
                f"    split; [exists d{s}; split; [lra|]|].",
                f"    {{ apply (scaled_gain {self.forms.pairs[2 * i + 1][self.order + i]} d{s} _ _ _ _ E{s});",
                f"      {opened}; field. }}",
            ]
        return [*lines, "    exact I. }"]

    def coupled(self) -> list[str]:
        """That the form of all channels with one nonlinearity is nowhere negative."""
        at, start = ("t", "intro t") if self.discrete else ("t Ht", "intros t Ht")
        (low, high), m = self.loop.bounds[0], len(self.own)
        args = (
            f"{str(bool(self.loop.odds)).lower()} block {m} {number(low)} {number(Fraction(high))} phi {self.forms.own}"
        )
        samples = "; ".join(self.sigma(i) for i in range(m))
        seen = ", ".join(f"<- (graph{s} {at})" for s in self.own)
        opened = f"unfold pairs, at_, z, {', '.join('sigma' + s for s in self.own)}; cbn [map dot]"
        return [
            f"  - {start}; apply (coupled_sound {args} pairs (z t)",
            f"      [{samples}] in_box slopes eq_refl).",
            f"    unfold window; cbn [map app]; rewrite {seen}.",
            f"    {opened}; repeat (apply (f_equal2 cons); [field|]); reflexivity. }}",
        ]


def _gain(value: Fraction | float) -> str:
    """A gain as two whole numbers."""
    value = Fraction(value)
    return f"({value.denominator}, {value.numerator})"
