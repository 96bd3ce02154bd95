"""A rate by a multiplier of Zames and Falb in the words of Coq: the same of the plant at ``s - a``: `slower.v`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import coefficients, masses, paced
from lure.analysis.export.relying import Relying
from lure.analysis.export.words import number, reals


def slowing_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a rate by a multiplier of Zames and Falb.

    Raises
    ------
    refused
        An ``InputError``: it is not covered.
    """
    return _Slowing(data).text(claim)


class _Slowing(Relying):
    """The words of one file: ``num`` and ``den`` are those of the plant, ``numerator`` and ``denominator``, moved."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.rate = exact(data["rate"])
        super().__init__({**data, "system": paced(data["system"], self.rate)})
        top, self.own, _ = coefficients(data["system"])
        self.top, self.beyond = top[0][1], ["slopes.v", "slower.v"]
        self.move = f"{'wider' if self.discrete else 'earlier'} {number(self.rate)}"

    @property
    def origin(self) -> str:
        """The theorem and the method of the certificate."""
        return f"{self.name} with a rate, {self.data['proof']['method']}"

    def plant(self) -> list[str]:
        """The plant, and what it is at ``s - a``, or at ``r z``."""
        opened = f"unfold {self.move.split()[0]}, closed, poly, num, den, numerator, denominator"
        return [
            reals("numerator", self.top),
            reals("denominator", self.own),
            *super().plant(),
            f"Lemma moved : forall g s, closed num den g s = closed numerator denominator g ({self.move} s).",
            f"Proof.\n  intros g [x y]; {opened}.",
            "  apply injective_projections; cbn [horner cadd cmul real fst snd]; field.\nQed.",
        ]

    def theorem(self) -> list[str]:
        """What follows by the criterion, with one ``c`` for all solutions of all loops of the class."""
        low, high, rate = map(number, (self.low, self.high, self.rate))
        kind, loop, time = ("nat -> R -> R", "flow_of", "time")
        if self.discrete:
            kind, loop, time = ("nat -> R", "steps_of", "steps")
        odd = str(self.odd).lower()
        given = " ".join([*self.parameters, odd, rate])
        sums = masses(self.given, self.discrete, self.rate)
        signs = {f"rewrite ?(Rabs_{'left' if v < 0 else 'right'} {number(v)}) by lra" for v in self.masses}
        opened = "; ".join(["  - apply Rminus_le; cbn [weigh fold_right tap_at kernel_at pow]", *sorted(signs)])
        weighed = [
            opened + f".\n    match goal with |- ?x <= 0 => replace x with {number(v - 1)} by field end; lra."
            for v in sums
        ]
        listed = "repeat (apply Forall_cons; [{}|]); apply Forall_nil"
        decaying = "apply Rabs_def1; lra"
        return [
            f"Theorem decays : zames_falb_theorem_at_rate{'_in_steps' * self.discrete} -> "
            f"exists c, forall (phi : R -> R) (xi : {kind}),",
            f"  sloped {odd} {low} {high} phi -> {loop} numerator denominator phi xi -> "
            f"decays_in_{time} c {rate} {self.order} xi.",
            "Proof.",
            f"  intro relied; apply (relied numerator denominator {low} {high} {given}).",
            "  - unfold proper, numerator, denominator; simpl; repeat split; try lra; try lia.",
            *["  - unfold numerator, denominator; simpl; try (left; lia); right; lra."] * (not self.discrete),
            "  - lra.",
            *["  - lra."] * self.discrete,
            "  - " + listed.format("discriminate" if self.discrete else decaying) + ".",
            *weighed,
            "  - " + ("left; reflexivity." if self.odd else "right; " + listed.format("cbn; lra") + "."),
            "  - intros s E; apply (poles s); rewrite moved; exact E.",
            "  - exact (moved_frequencies _ _ _ _ _ _ _ _ _ moved frequencies).",
            "Qed.",
        ]
