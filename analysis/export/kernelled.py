"""Rates and gains by kernels of several channels in the words of Coq: `kernels.v` and `kernelled.v`."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.channels import plant
from lure.analysis.export.kernels import Kernels, reals_of
from lure.analysis.export.words import number


class KernelRate(Kernels):
    """The words of one file: ``A`` is that of the plant plus the rate, and ``A0`` its own."""

    beyond = ("slopes.v", "slower.v", "kernelled.v")
    about = " with a rate"

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.rate = exact(data["rate"])
        super().__init__({**data, "system": paced(data["system"], self.rate)})
        self.own = plant(data["system"]).A

    def definitions(self) -> list[str]:
        """The plant itself, and what is computed."""
        opened = "unfold plus_on_diagonal, row, A0, A; cbn [map seq length nth Nat.eqb]"
        return [
            f"Definition A0 : rows := [{'; '.join(map(reals_of, self.own))}].",
            *super().definitions(),
            f"Lemma moved : plus_on_diagonal {number(self.rate)} A0 = A.",
            f"Proof.\n  {opened}.",
            "  repeat (apply (f_equal2 cons); [repeat (apply (f_equal2 cons); [field|])|]); reflexivity.\nQed.",
        ]

    def theorem(self) -> list[str]:
        """The statement, and what the theorem relied on asks for."""
        n, m, odd, rate = self.n, self.m, str(self.odd).lower(), number(self.rate)
        held = [f"class{k}" for k in range(len(self.ends))]
        return [
            "Theorem decays : matrix_zames_falb_theorem_at_rate -> exists c, forall (phi : nat -> R -> R)",
            f"  (x w : nat -> R -> R), {self.classes} ->",
            f"  loop_of A0 B C0 D of phi x w -> decays_in_time c {rate} {n} x.",
            "Proof.\n  intro relied; eapply with_one.",
            f"  {'{'} apply (relied {n}%nat {m}%nat A0 B C0 D of ends {odd} gamma theta multiplier_ {rate});",
            "    try (rewrite moved; (exact poles || exact frequencies));",
            "    try (split; [reflexivity|repeat constructor]); try reflexivity.",
            *self.in_turn(),
            *self.bounded(),
            "  - unfold multiplier_; repeat (apply Forall_cons;",
            "      [cbn; try (left; reflexivity); right; apply Rabs_def1; lra|]); apply Forall_nil.",
            *self.weighed(),
            f"{self.signs} {'}'}",
            f"  intros c all phi x w {' '.join(held)} solution; apply (all phi x w); [|exact solution].",
            "  intros i I; " + "; ".join(f"destruct i as [|i]; [exact class{k}|]" for k in self.of) + "; lia.",
            "Qed.",
        ]

    def weighed(self) -> list[str]:
        """That the kernels of a row and of a column weigh no more than they may."""
        lines, a = ["  - intros i I."], number(self.rate)
        for j, (*_, c, rate, order, side) in enumerate(self.kernels):
            one = f"({number(c)}, {number(rate)}, {order}%nat, {str(side > 0).lower()})"
            sign = "left" if c < 0 else "right"
            for name, shift, moved in (("R", a, self.rate), ("C", f"(- {a})", -self.rate)):
                weight = abs(c) * (rate / (rate + side * moved) if order else 1) ** order
                lines.append(f"    assert ({name}{j} : kernel_at {shift} {one} = {number(weight)})")
                lines.append(f"      by (unfold kernel_at; rewrite Rabs_{sign} by lra; cbn [pow]; field).")
        named = "unfold weigh_if, weigh, multiplier_; cbn [fold_right fst snd Nat.eqb nth gamma theta ends of]"
        for i in range(self.m):
            row = "".join(f"rewrite ?R{j}; " for j, k in enumerate(self.kernels) if k.row == i)
            column = "".join(f"rewrite ?C{j}; " for j, k in enumerate(self.kernels) if k.column == i)
            lines.append("    destruct i as [|i].")
            lines.append(f"    {{ {named}; split; [{row}lra|{column}lra]. }}")
        return [*lines, "    lia."]


class KernelGain(Kernels):
    """The words of one file; the last channels lead from ``z`` to ``w``."""

    beyond = ("slopes.v", "slower.v", "kernelled.v")
    about = " of a gain"

    def theorem(self) -> list[str]:
        """The statement, and what the theorem relied on asks for."""
        n, m, p, odd, end = self.n, self.first, self.m, str(self.odd).lower(), Fraction(self.high[-1])
        r, gamma2, g = map(number, (end, 1 / end**2, self.gamma[-1]))
        outputs = range(m, p)
        held = [f"class{k}" for k in range(len(self.ends) - 1)]
        inputs = " -> ".join(f"continuity (w {i}%nat)" for i in outputs)
        rest = " -> ".join(f"x {k}%nat s = 0" for k in range(n))
        weighed = "unfold multiplier_, mass_if, weight; cbn [fold_right fst snd Nat.eqb nth gamma]"
        names = [*held, "solution", *(f"input{i}" for i in outputs), "out into after", *(f"rest{k}" for k in range(n))]
        return [
            "Theorem gain : matrix_zames_falb_theorem_of_gain -> forall (phi : nat -> R -> R) (x w : nat -> R -> R)",
            f"  (Ez Ew : R -> R) (s : R), {self.classes} ->",
            f"  driven_by {m} A B C0 D of phi x w -> {inputs} ->",
            f"  energy {m} {p} (sigma_at C0 D x w) Ez -> energy {m} {p} w Ew -> 0 < s -> {rest} ->",
            f"  forall t, s <= t -> Ez t - Ez s <= {gamma2} * (Ew t - Ew s).",
            f"Proof.\n  intros relied phi x w Ez Ew s {' '.join(names)} t st.",
            f"  apply (Rmult_le_reg_l ({r} * {r})); [lra|].",
            f"  replace ({r} * {r} * ({gamma2} * (Ew t - Ew s))) with (Ew t - Ew s) by field.",
            f"  apply (relied {n}%nat {m}%nat {p}%nat A B C0 D of ends {odd} gamma theta multiplier_ {g}",
            f"    {r} phi x w Ez Ew s); try assumption; try exact poles; try exact frequencies;",
            "    try (split; [reflexivity|repeat constructor]); try reflexivity.",
            *self.in_turn(),
            *self.bounded()[:1],
            "  - lia.",
            *["  - lra."] * 2,
            f"  - intros i I; do {m} (destruct i as [|i]; [lia|]).",
            f"    {self.one_of(p - m, 'i', '[cbn; repeat split; lra|]')}; lia.",
            *self.bounded()[1:],
            f"  - intros i I; {self.one_of(m, 'i', f'[{weighed}; {self.signed()}; split; lra|]')}; lia.",
            self.signs,
            "  - intros i I; " + "; ".join(f"destruct i as [|i]; [exact class{k}|]" for k in self.of[:m]) + "; lia.",
            f"  - intros i I; do {m} (destruct i as [|i]; [lia|]).",
            "    " + "; ".join(f"destruct i as [|i]; [exact input{i}|]" for i in outputs) + "; lia.",
            "  - intros j J; " + "; ".join(f"destruct j as [|j]; [exact rest{k}|]" for k in range(n)) + "; lia.",
            "Qed.",
        ]

    def in_turn(self) -> list[str]:
        """That each ``sigma`` of a nonlinearity is given by states, inputs and the channels before it."""
        opened = "unfold D, theta; cbn [in_turn_before skipn firstn Nat.ltb Nat.leb]"
        return [f"  - {opened}; repeat split; repeat constructor;", *super().in_turn()[1:]]
