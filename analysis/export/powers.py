"""Lyapunov functions of higher degree in the words of Coq: products of powers of the state, `powers.v`."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.powers import lifted, monomials
from lure.analysis.certificates.states import classes
from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.loops import of_transfer
from lure.analysis.export.quadratic import Loop, Term, bilinear, nonnegative, rounded, whole
from lure.analysis.export.words import folded, integers, number, refused, whole_file

MOST_PRODUCTS = 15  # more take Coq minutes
MOST_SCALE, BITS = 400, (12, 16, 20, 24, 32, 48, 64, 96)
Rows = list[list[int]]


def powers_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of a homogeneous form that falls with the gains at both ends.

    Parameters
    ----------
    data : Mapping
        The certificate.
    claim : str
        The sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: its plant has matrices or a feedthrough, it has many products, or it leaves too little room.
    """
    top, den, _ = coefficients(data["system"]) if data["system"]["kind"] == "transfer" else ([], [], False)
    if not top or len(top[0][1]) == len(den):
        raise refused("a form of higher degree has an export for a plant of two polynomials without feedthrough")
    loop = of_transfer(data["system"])
    low, high = (Fraction(v) for v in classes(data["laws"]).sector)
    return _Powers(data, replace(loop, bounds=[(low, high)], theta=[Fraction(0)]), low, high).text(claim)


class _Powers(FallingTheorem):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], loop: Loop, low: Fraction, high: Fraction) -> None:
        super().__init__(data, loop)
        self.low, self.high, proof = low, high, data["proof"]
        self.exponents = monomials(self.order, proof["power"])
        if len(self.exponents) > MOST_PRODUCTS:
            raise refused(
                f"a form in {len(self.exponents)} products of powers takes Coq minutes; those in up to {MOST_PRODUCTS} "
                "have an export"
            )
        self.last = [[v / loop.phi[0][-1] for v in self._closed(g)] for g in (low, high)]
        units = [[Fraction(j == i + 1) for j in range(self.order)] for i in range(self.order - 1)]
        given = [lifted([*units, row], self.exponents) for row in self.last]
        _, self.unit = whole([v for rows in given for row in rows for v in row])
        self.rows = [[whole(row, self.unit)[0] for row in rows] for rows in given]
        for bits in (*BITS, 0):
            self.P, self.zero = self._near(proof, bits)
            self.times = self._times()
            if self.times:
                return
        raise refused("its form of higher degree leaves too little room")

    def _near(self, proof: Mapping[str, Any], bits: int) -> tuple[Rows, list[Rows]]:
        """``P`` and the forms that vanish, to so many bits (0: as they are), by one number to be whole."""
        size = range(len(self.exponents))
        P, *Z = (
            [[Fraction(proof[key][max(i, j)][min(i, j)]) for j in size] for i in size]
            for key in ("P", "lower", "upper")
        )
        if bits:
            scale = [row[i].numerator.bit_length() // 2 for i, row in enumerate(P)]
            P = rounded(P, bits)
            for rows in Z:
                for group in self.alike():
                    for i, j in group[1:]:
                        step = Fraction(2) ** (scale[i] + scale[j] - bits)
                        rows[i][j] = rows[j][i] = round(rows[i][j] / step) * step
                    (i, j), *rest = group
                    beside = sum((rows[h][k] * (1 + (h != k)) for h, k in rest), Fraction(0))
                    rows[i][j] = rows[j][i] = -beside / (1 + (i != j))
        entries, _ = whole([v for rows in (P, *Z) for row in rows for v in row])
        shared, n = math.gcd(*entries), len(size)
        flat = [[v // shared for v in entries[i : i + n]] for i in range(0, len(entries), n)]
        forms = [flat[i : i + n] for i in range(0, 3 * n, n)]
        return forms[0], [[[self.unit * v for v in row] for row in M] for M in forms[1:]]

    def alike(self) -> list[list[tuple[int, int]]]:
        """The places of a form, product by product of the monomials."""
        found = defaultdict[tuple[int, ...], list[tuple[int, int]]](list)
        for i, e in enumerate(self.exponents):
            for j, f in enumerate(self.exponents[: i + 1]):
                found[tuple(a + b for a, b in zip(e, f, strict=True))].append((i, j))
        return list(found.values())

    def _closed(self, gain: Fraction) -> list[Fraction]:
        """``den + g num`` but for its leading coefficient, with the sign of ``phi``, the lowest coefficient first."""
        return [gain * s - v for s, v in zip(self.loop.sigma[0][:-1], self.loop.phi[0][:-1], strict=True)]

    def _times(self) -> int:
        """By which the fall of ``V`` is above the squares; 0 if that is not shown."""
        n = len(self.exponents)
        places = [[int(i == j) for j in range(n)] for i in range(n)]
        sides = list[tuple[list[Term], list[Term]]]()
        for rows, Z in zip(self.rows, self.zero, strict=True):
            falls = [
                *bilinear(self.P, places, rows, -1),
                *bilinear(self.P, rows, places, -1),
                *bilinear(Z, places, places),
            ]
            sides.append((falls, [(-1, row, row) for row in (*places, *rows)]))
        if not nonnegative(bilinear(self.P, places, places), n) or not all(nonnegative(V, n) for V, _ in sides):
            return 0
        for power in range(0, MOST_SCALE, 4):
            if all(nonnegative([*((c << power, u, v) for c, u, v in V), *less], n) for V, less in sides):
                return 1 << power
        return 0

    def groups(self, Z: Rows) -> str:
        """The entries of a form that vanishes, product by product."""
        listed = (
            "; ".join(f"({Z[i][j] * (1 + (i != j))}, ({i}%nat, {j}%nat))" for i, j in group if Z[i][j])
            for group in self.alike()
        )
        return "[" + "; ".join(f"[{group}]" for group in listed if group) + "]"

    def text(self, claim: str) -> str:
        """The whole file."""
        n, N = self.order, len(self.exponents)
        listed = "; ".join("[" + "; ".join(f"{v}%nat" for v in e) + "]" for e in self.exponents)
        lines = [*self.definitions(), folded(f"Definition exponents : list (list nat) := [{listed}].")]
        lists = [("P", self.P), ("lower", self.rows[0]), ("upper", self.rows[1])]
        lines += [folded(f"Definition {name} : list (list Z) := {integers(rows)}%Z.") for name, rows in lists]
        for name, Z in zip(("zero_l", "zero_k"), self.zero, strict=True):
            lines.append(folded(f"Definition {name} : list (list pair_) := {self.groups(Z)}%Z."))
            lines.append(f"Lemma {name}_vanishes : forallb (vanishing exponents) {name} = true.")
            lines.append("Proof. vm_cast_no_check (eq_refl true). Qed.")
        test = (
            f"powers_fall {N} P lower upper (vanishing_terms zero_l) (vanishing_terms zero_k) {self.unit} {self.times}"
        )
        lines.append(f"Lemma falls : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.")
        names = [f"x{k}" for k in range(n)]
        state = f"[{'; '.join(names)}]"
        for name, side in zip(("lower", "upper"), (0, 1), strict=True):
            lines += [
                f"Lemma {name}_is : forall {' '.join(names)},",
                f"  at_ {name} (map (fun e => mono e {state}) exponents)",
                f"  = map (fun e => {self.unit} * dmono e {state} {self.derivative(side, names)}) exponents.",
                "Proof.",
                f"  intros; unfold at_, {name}, exponents; cbn [map dot mono dmono INR Nat.pred].",
                "  repeat (apply (f_equal2 cons); [field|]); reflexivity.",
                "Qed.",
            ]
        origin = f"{self.data['theorem']}, {self.data['proof']['method']}"
        libraries = ("forms.v", "flow.v", "powers.v")
        return whole_file(claim, origin, libraries, ["\n".join(lines), "\n".join(self.statement())])

    def derivative(self, side: int, names: list[str]) -> str:
        """The state's derivative with the gain at one end, of numbers with these names."""
        last = " + ".join(f"{number(v)} * {name}" for v, name in zip(self.last[side], names, strict=True) if v) or "0"
        return f"[{'; '.join([*names[1:], last])}]"

    def statement(self) -> list[str]:
        """The theorem and its proof."""
        n, N, told = self.order, len(self.exponents), self.hypotheses()
        binders, names = self.binders()
        entries = [f"xi {k}%nat t" for k in range(n + 1)]
        xs, dxs = ([f"xi {k}%nat" for k in range(a, a + n)] for a in (0, 1))
        low, high = number(self.low), number(self.high)
        held = "(class t)" if self.families[0].varying else "class"
        lines = [f"Theorem stable : forall{binders} (xi : {self.kind}),", *(f"  ({text}) ->" for _, text in told)]
        lines += ["  " + " /\\ ".join(f"tends_to (xi {k}%nat) 0" for k in range(n)) + ".", "Proof."]
        lines += [f"  intros {' '.join([*names, 'xi', *(name for name, _ in told)])}."]
        for name, side in (("X", xs), ("X'", dxs)):
            lines.append(f"  pose ({name} := fun t : R => map (fun f : R -> R => f t) [{'; '.join(side)}]).")
        test = f"{N} P lower upper (vanishing_terms zero_l) (vanishing_terms zero_k) {self.unit} {self.times}"
        ends = [self.derivative(side, [f"({v})" for v in entries[:n]]) for side in (1, 0)]
        lines += [
            f"  assert (lim := powers_in_time {test}",
            "    (fun t => map (fun e => mono e (X t)) exponents)",
            "    (fun t => map (fun e => dmono e (X t) (X' t)) exponents) falls).",
            f"  assert (all : forall i, (i < {N})%nat ->",
            "    tends_to (fun t => nth i (map (fun e => mono e (X t)) exponents) 0) 0).",
            "  { apply lim; clear lim.",
            "  - intro t; rewrite map_length; reflexivity.",
            "  - intro t; rewrite map_length; reflexivity.",
            f"  - apply (monos_derivable exponents [{'; '.join(xs)}] [{'; '.join(dxs)}]); intros t Ht.",
            "    repeat (apply Forall2_cons; [apply derivatives; [lia|exact Ht]|]); apply Forall2_nil.",
            "  - intro t; split; apply vanishing_sound; [exact zero_l_vanishes|exact zero_k_vanishes].",
            "  - intros t Ht.",
            "    assert (E : phi_ (sigma xi t) = - den xi t) by (rewrite (closed t Ht); ring).".replace(
                "phi_", self.phi(0)
            ),
            f"    destruct (gain_of {low} {high} ({self.phi(0)}) _ _ {held} ltac:(lra) E) as [d [D F]]; clear E.",
            f"    destruct (between_ends {low} {high} d D) as [r [R01 ->]]; exists r; split; [exact R01|].",
            f"    apply (mixed_ends exponents (X t) {ends[1]}",
            f"      {ends[0]}); [reflexivity| |apply lower_is|apply upper_is].",
            "    unfold X'; cbn [map lcomb]; unfold den, sigma in F.",
            "    repeat (apply (f_equal2 cons); [lra|]); reflexivity. }",
        ]
        for k in range(n):
            power = self.data["proof"]["power"]
            i = self.exponents.index(tuple(power * (j == k) for j in range(n)))
            lines += ["  apply conj."] * (k < n - 1)
            lines += [
                f"  {{ apply (tends_to_power (xi {k}%nat) {power}); [lia|].",
                f"    apply (tends_to_part 1 _ (fun t => nth {i} (map (fun e => mono e (X t)) exponents) 0));",
                "      [lra| |].",
                "    - intro t; unfold X, exponents; cbn [map nth mono]; ring.",
                "    - apply all; lia. }",
            ]
        return [*lines, "Qed."]
