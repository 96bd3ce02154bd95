"""Lyapunov functions of higher degree in the words of Coq: products of powers of the state, `powers.v`."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import numbers
from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.matrix import Claim, zero_of
from lure.analysis.certificates.powers import lifted, monomials
from lure.analysis.certificates.states import classes
from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.loops import of_one
from lure.analysis.export.quadratic import (
    Loop,
    Matrix,
    Term,
    Vector,
    apart,
    bilinear,
    definite,
    less,
    rounded,
    whole,
)
from lure.analysis.export.words import combined, folded, integers, number, refused, whole_file

MOST_PRODUCTS = 24  # more take Coq minutes
MOST_SCALE, BITS = 400, (12, 16, 20, 24, 32, 48, 64, 96)
Rows = list[list[int]]


def powers_text(data: Mapping[str, Any], claim: str, kind: type[PoweredTheorem]) -> str:
    """The file for a certificate of a homogeneous form that falls with the gains at both ends.

    ``kind``: that of its time.

    Raises
    ------
    refused
        An ``InputError``: it has many products, or it leaves too little room.
    """
    loop = of_one(data["system"])
    low, high = (Fraction(v) for v in classes(data["laws"]).sector)
    rows = [row[: len(loop.now)] for row in loop.now]
    A, b, c, d, discrete = realised(data["system"], low)
    critical, rest = not (discrete or any(row[0] for row in A)), None
    if critical:
        zero = zero_of(Claim(A=A, b=b, c=c, d=d, discrete=False, width=high - low, theta=Fraction(0)))
        if d or zero is None:
            raise refused("its pole at 0 is beside a direct term")
        rest = numbers(zero["right"]), numbers(zero["left"]), 0
    loop = replace(loop, bounds=[(low, high)], theta=[Fraction(0)], rows=rows[int(critical) :], rest=rest)
    return kind(data, loop, low, high).text(claim)


class PoweredTheorem(FallingTheorem):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], loop: Loop, low: Fraction, high: Fraction) -> None:
        super().__init__(data, loop)
        self.low, self.high, proof = low, high, data["proof"]
        self.skipped = int(loop.rest is not None)  # the power of the state that stays where it is
        self.exponents = monomials(self.order, proof["power"])
        if len(self.exponents) > MOST_PRODUCTS:
            raise refused(
                f"a form in {len(self.exponents)} products of powers takes Coq minutes; those in up to {MOST_PRODUCTS} "
                "have an export"
            )
        self.closed = [self._closed(g) for g in (low, high)]
        given = [self.lift(self.end(side)) for side in (0, 1)]
        _, self.unit = whole([v for rows in given for row in rows for v in row])
        self.rows = [[whole(row, self.unit)[0] for row in rows] for rows in given]
        for bits in (*BITS[: 0 if self.skipped else None], 0):
            self.P, self.zero = self.near(proof, bits)
            self.margin = self.room()
            if self.margin:
                return
        raise refused("its form of higher degree leaves too little room")

    def libraries(self) -> tuple[str, ...]:
        """The files with what the proof uses."""
        return "forms.v", "flow.v", "critical.v", "definite.v", "powers.v"

    def lift(self, A: Matrix) -> Matrix:
        """How the products change."""
        return lifted(A, self.exponents)

    def near(self, proof: Mapping[str, Any], bits: int) -> tuple[Rows, list[Rows]]:
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

    def _closed(self, gain: Fraction) -> tuple[Vector, Fraction]:
        """``p`` and ``q > 0`` with ``q u = p x``, where ``u`` is the last number of ``z``."""
        *p, q = less(self.loop.phi[0], gain, self.loop.sigma[0])
        return ([-v for v in p], q) if q > 0 else (p, -q)

    def end(self, side: int) -> Matrix:
        """The matrix of the loop with the gain at one end."""
        p, q = self.closed[side]
        return [less(row[:-1], -row[-1] / q, p) for row in self.loop.then]

    def room(self) -> tuple[int, ...]:
        """By which the fall of ``V`` is above the squares; nothing if that is not shown."""
        n = len(self.exponents)
        places = [[int(i == j) for j in range(n)] for i in range(n)]
        sides = [(bilinear(self.P, places, places), list[Term](), definite)]
        for rows, Z in zip(self.rows, self.zero, strict=True):
            falls = [
                *bilinear(self.P, places, rows, -1),
                *bilinear(self.P, rows, places, -1),
                *bilinear(Z, places, places),
            ]
            squares = [(-1, row, row) for row in (*places[self.skipped :], *rows)]
            sides.append((falls, squares, apart if self.skipped and rows is self.rows[0] else definite))
        for power in (MOST_SCALE, *range(0, MOST_SCALE, 4)):
            if all(shown([*((c << power, u, v) for c, u, v in V), *less], n) for V, less, shown in sides):
                if power < MOST_SCALE:
                    return (1 << power,)
            elif power == MOST_SCALE:
                break
        return ()

    def groups(self, Z: Rows) -> str:
        """The entries of a form that vanishes, product by product."""
        listed = (
            "; ".join(f"({Z[i][j] * (1 + (i != j))}, ({i}%nat, {j}%nat))" for i, j in group if Z[i][j])
            for group in self.alike()
        )
        return "[" + "; ".join(f"[{group}]" for group in listed if group) + "]"

    def text(self, claim: str) -> str:
        """The whole file."""
        listed = "; ".join("[" + "; ".join(f"{v}%nat" for v in e) + "]" for e in self.exponents)
        lines = [*self.definitions(), folded(f"Definition exponents : list (list nat) := [{listed}].")]
        lists = [("P", self.P), ("lower", self.rows[0]), ("upper", self.rows[1])]
        lines += [folded(f"Definition {name} : list (list Z) := {integers(rows)}%Z.") for name, rows in lists]
        for name, Z in zip(("zero_l", "zero_k"), self.zero, strict=True):
            lines.append(folded(f"Definition {name} : list (list pair_) := {self.groups(Z)}%Z."))
            lines.append(f"Lemma {name}_vanishes : forallb (vanishing exponents) {name} = true.")
            lines.append("Proof. vm_cast_no_check (eq_refl true). Qed.")
        lines.append(f"Lemma falls : {self.falls()} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.")
        lines += self.matrices()
        origin = f"{self.data['theorem']}, {self.data['proof']['method']}"
        return whole_file(claim, origin, self.libraries(), ["\n".join(lines), "\n".join(self.statement())])

    def falls(self) -> str:
        """The test."""
        return f"powers_fall {self.test()}"

    def matrices(self) -> list[str]:
        """How the products change with the gains at both ends."""
        names, lines = [f"x{k}" for k in range(self.order)], list[str]()
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
        return lines

    def test(self) -> str:
        """What the test is of."""
        forms = "P lower upper (vanishing_terms zero_l) (vanishing_terms zero_k)"
        return f"{self.skipped} {len(self.exponents)} {forms} {self.unit} {self.margin[0]}"

    def derivative(self, side: int, names: list[str]) -> str:
        """The state's derivative with the gain at one end, of numbers with these names."""
        return f"[{'; '.join(combined(row, names) for row in self.end(side))}]"

    def between(self) -> list[str]:
        """That the loop is a mixture, of shares ``s`` and ``1 - s``, of those with the gains at both ends."""
        *entries, last = (f"({self.entry(k)})" for k in range(self.order + 1))
        low, high = number(self.low), number(self.high)
        held = "(class t)" if self.families[0].varying else "class"
        (p, q), (p_, q_) = self.closed
        at = "t" if self.discrete else "t Ht"
        shown = f"rewrite (closed {at}); ring" if self.transfer else f"symmetry; apply (graph {at})"
        return [
            f"    assert (E : {self.phi(0)} ({self.sigma(0)}) = {self.value(0)}) by ({shown}).",
            f"    destruct (gain_of {low} {high} ({self.phi(0)}) _ _ {held} ltac:(lra) E) as [d [D F]]; clear E.",
            f"    destruct (between_ends {low} {high} d D) as [r [R01 ->]].",
            f"    destruct (mean_of_ends r {number(q)} {number(q_)} ({combined(p, entries)})",
            f"      ({combined(p_, entries)}) {last} R01 ltac:(lra) ltac:(lra)) as [s [S01 U]];",
            f"      [unfold {'den, ' * self.transfer}sigma in F; lra|]; exists s; split; [exact S01|].",
        ]

    def statement(self) -> list[str]:
        """The theorem and its proof."""
        n, N = self.order, len(self.exponents)
        entries = [f"({self.entry(k)})" for k in range(n)]
        xs = [self.entry(k).removesuffix(" t") for k in range(n)]
        dxs = [f"fun t => {self.sum(row)}" for row in self.loop.then]
        ends = [self.derivative(side, entries) for side in (1, 0)]
        lines = self.opening()
        for name, side in (("X", xs), ("X'", dxs)):
            lines.append(f"  pose ({name} := fun t : R => map (fun f : R -> R => f t) [{'; '.join(side)}]).")
        lines += [
            f"  assert (lim := powers_in_time {self.test()}",
            "    (fun t => map (fun e => mono e (X t)) exponents)",
            "    (fun t => map (fun e => dmono e (X t) (X' t)) exponents) falls).",
            f"  assert (all : forall i, ({self.skipped} <= i < {N})%nat ->",
            "    tends_to (fun t => nth i (map (fun e => mono e (X t)) exponents) 0) 0).",
            "  { apply lim; clear lim.",
            "  - intro t; rewrite map_length; reflexivity.",
            "  - intro t; rewrite map_length; reflexivity.",
            f"  - apply (monos_derivable exponents [{'; '.join(xs)}] [{'; '.join(dxs)}]); intros t Ht.",
            *(f"    apply Forall2_cons; [{self.derived(k)}|]." for k in range(n)),
            "    apply Forall2_nil.",
            "  - intro t; split; apply vanishing_sound; [exact zero_l_vanishes|exact zero_k_vanishes].",
            "  - intros t Ht.",
            *self.between(),
            f"    apply (mixed_ends exponents (X t) {ends[1]}",
            f"      {ends[0]}); [reflexivity| |apply lower_is|apply upper_is].",
            "    unfold X'; cbn [map lcomb].",
            "    repeat (apply (f_equal2 cons); [lra|]); reflexivity. }",
        ]
        power, kept = self.data["proof"]["power"], range(self.skipped, n)
        for k in kept:
            i = self.exponents.index(tuple(power * (j == k) for j in range(n)))
            lines += [
                f"  assert (near{k} : tends_to ({xs[k]}) 0).",
                f"  {{ apply (tends_to_power ({xs[k]}) {power}); [lia|].",
                f"    apply (tends_to_part 1 _ (fun t => nth {i} (map (fun e => mono e (X t)) exponents) 0));",
                "      [lra| |].",
                "    - intro t; unfold X, exponents; cbn [map nth mono]; ring.",
                "    - apply all; lia. }",
            ]
        if self.skipped:
            others = "; ".join(xs[k] for k in kept)
            lines += [
                f"  pose (z := fun t => map (fun f : R -> R => f t) [{others}]).",
                f"  pose (now := [{'; '.join(xs)}]); pose (next := [{'; '.join(dxs)}]).",
                f"  assert (small : Forall (fun f => tends_to f 0) [{others}]) by (repeat constructor; assumption).",
                *["  split; [assumption|]."] * len(kept),
                *self.rested(),
            ]
        return [*lines, *["  repeat apply conj; assumption."] * (not self.skipped), "Qed."]

    def seen(self) -> tuple[str, str]:
        """The states that tend to 0."""
        return "z", "sums_vanish _ small"

    def vanishing(self, form: Vector) -> tuple[str, str]:
        """A combination of these, in integers, and by what it is multiplied."""
        row, q = whole(form[1:])
        return f"(fun t => dot {integers(row)}%Z (z t))", number(Fraction(1, q))

    def changing(self, zeta: Vector) -> list[str]:
        """How ``zeta`` changes."""
        row, q = whole(zeta)
        of = f"dot {integers(row)}%Z"
        return [
            f"  {{ intros t Ht; apply (derivable_same (fun s => / {q} * {of} (map (fun f : R -> R => f s) now)) _ t",
            f"      (/ {q} * {of} (map (fun f : R -> R => f t) next)));",
            "      [intro; unfold now; cbn [map dot]; field",
            f"      |unfold next, sigma{', den' * bool(self.transfer)}; cbn [map dot]; field|].",
            f"    apply (derivable_pt_lim_scal (fun s => {of} (map (fun f : R -> R => f s) now))), sums_derivable.",
            *(f"    apply Forall2_cons; [{self.derived(k)}|]." for k in range(self.order)),
            "    apply Forall2_nil. }",
        ]

    def derived(self, k: int) -> str:
        """That a state has the derivative that it should have."""
        if not self.transfer:
            return f"exact (flow{k} t Ht)"
        same = f"apply (derivable_same (xi {k}%nat) _ t (xi {k + 1}%nat t))"
        return f"{same}; [reflexivity|cbv beta; ring|apply derivatives; [lia|exact Ht]]"
