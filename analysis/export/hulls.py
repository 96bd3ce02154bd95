"""Lyapunov functions of higher degree in discrete time in the words of Coq: a solution stays in a hull, `hulls.v`.

With the gains of both ends ``b V(x+) <= a V(x)``, ``a < b``.  Between them ``V`` may grow; yet a solution is a mixture
of what products of both ends make of its start, of which all parts tend to 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lure.analysis.certificates.powers import substituted
from lure.analysis.export.powers import PoweredTheorem, Rows
from lure.analysis.export.quadratic import Matrix, bilinear, definite, whole
from lure.analysis.export.words import integers

MOST_CLOSE, MOST_TIMES = 60, 400  # powers of 2


class SteppedTheorem(PoweredTheorem):
    """The words of one file."""

    def libraries(self) -> tuple[str, ...]:
        """The files with what the proof uses."""
        return (*super().libraries(), "hulls.v")

    def lift(self, A: Matrix) -> Matrix:
        """The products of the next states by those of the states."""
        return substituted(A, self.exponents)

    def near(self, proof: Mapping[str, Any], bits: int) -> tuple[Rows, list[Rows]]:
        """As in continuous time, the forms that vanish by the square of ``unit``."""
        P, zero = super().near(proof, bits)
        return P, [[[self.unit * v for v in row] for row in Z] for Z in zero]

    def room(self) -> tuple[int, ...]:
        """``a``, ``b`` and a multiple of ``V`` that is above the squares; nothing if they are not found."""
        n = len(self.exponents)
        places = [[int(i == j) for j in range(n)] for i in range(n)]
        V = bilinear(self.P, places, places)
        squares = [(-1, e, e) for e in places]
        above = (i for i in range(MOST_TIMES) if definite([*((c << i, u, v) for c, u, v in V), *squares], n))
        times = next(above, None)
        for k in range(1, MOST_CLOSE if times is not None else 0):
            a, b = (1 << k) - 1, 1 << k
            if all(
                definite(
                    [
                        *((a * self.unit**2 * c, u, v) for c, u, v in V),
                        *((-b * c, u, v) for c, u, v in bilinear(self.P, rows, rows)),
                        *((b * c, u, v) for c, u, v in bilinear(Z, places, places)),
                    ],
                    n,
                )
                for rows, Z in zip(self.rows, self.zero, strict=True)
            ):
                return a, b, 1 << (times or 0)
        return ()

    def falls(self) -> str:
        """The test."""
        forms = "P lower upper (vanishing_terms zero_l) (vanishing_terms zero_k)"
        return f"powers_contract {len(self.exponents)} {forms} {self.unit} {' '.join(map(str, self.margin))}"

    def matrices(self) -> list[str]:
        """The loops with both ends, by a whole number, and what they make of the products."""
        ends = [self.end(side) for side in (0, 1)]
        _, self.by = whole([v for rows in ends for row in rows for v in row])
        names, lines = [f"x{k}" for k in range(self.order)], list[str]()
        state = f"[{'; '.join(names)}]"
        for name, rows in zip(("lower", "upper"), ends, strict=True):
            lines += [
                f"Definition {name}_loop : list (list Z) := {integers([whole(row, self.by)[0] for row in rows])}%Z.",
                f"Lemma {name}_is : forall {' '.join(names)},",
                f"  at_ {name} (map (fun e => mono e {state}) exponents)",
                f"  = map (fun e => {self.unit} * mono e (carried {self.by} {name}_loop {state})) exponents.",
                "Proof.",
                f"  intros; unfold at_, {name}, exponents, carried, {name}_loop; cbn [map dot mono].",
                "  repeat (apply (f_equal2 cons); [field|]); reflexivity.",
                "Qed.",
            ]
        return lines

    def statement(self) -> list[str]:
        """The theorem and its proof."""
        n, power = self.order, self.data["proof"]["power"]
        some = "[|? ?]"
        for k in reversed(range(n)):
            some = f"[|y{k} {some}]"
        split = f"intros y L; destruct y as {some}; try discriminate;"
        steps = "" if self.transfer else f"rewrite {', '.join(f'step{k}' for k in range(n))}; "
        lines = [
            *self.opening(),
            f"  pose (X := fun t : nat => [{'; '.join(self.entry(k) for k in range(n))}]).",
            f"  assert (all : forall i j, (forall y, length y = {n}%nat ->",
            f"      nth j (map (fun e => mono e y) exponents) 0 = nth i y 0 ^ {power}) ->",
            "    Un_cv (fun t => nth i (X t) 0) 0).",
            f"  {{ apply (powers_by_steps {self.falls().partition(' ')[2]} exponents {power} {self.by} lower_loop",
            f"      upper_loop {n} X falls eq_refl ltac:(lia) eq_refl eq_refl).",
            f"  - {split} apply lower_is.",
            f"  - {split} apply upper_is.",
            "  - intro y; split; apply vanishing_sound; [exact zero_l_vanishes|exact zero_k_vanishes].",
            "  - reflexivity.",
            "  - intro t.",
            *self.between(),
            f"    unfold X, carried, lower_loop, upper_loop; {steps}cbn [map dot lcomb Nat.add] in *.",
            "    repeat (apply (f_equal2 cons); [lra|]); reflexivity. }",
        ]
        for k in range(len(self.conclusions())):
            j = self.exponents.index(tuple(power * (i == k) for i in range(n)))
            lines += ["  apply conj."] * (k < len(self.conclusions()) - 1)
            lines.append(f"  {{ apply (all {k}%nat {j}%nat); {split} unfold exponents; cbn [map nth mono]; ring. }}")
        return [*lines, "Qed."]
