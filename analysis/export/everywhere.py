"""That everything tends to 0, of a loop with one nonlinearity and several states, for Coq: `everywhere.v`.

``V = x'P x + 2 theta int phi`` falls while ``phi`` is not 0, and keeps ``sigma'`` bounded: so ``sigma`` tends to 0.
From then on ``phi = k sigma``, and a second form falls along ``x' = (A - k b c) x``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import eliminated, numbers
from lure.analysis.certificates.channels import plant
from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.graphs import cases
from lure.analysis.export.quadratic import (
    Forms,
    Loop,
    Matrix,
    Term,
    bilinear,
    forms,
    less,
    mix,
    nonnegative,
    rounded,
    whole_loop,
)
from lure.analysis.export.regional import Region
from lure.analysis.export.words import folded, integers, number, refused, terms, whole_file

LIBRARIES = ("forms.v", "flow.v", "everywhere.v")
MOST_STATES, MOST_SCALE, BITS = 8, 200, (8, 16, 32, 64)
ZERO = Fraction(0)


def everywhere_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a loop that 0 attracts everywhere, of one nonlinearity in continuous time.

    Raises
    ------
    refused
        An ``InputError``: it has several channels, or its nonlinearity is not of lines, one of them through 0 that is
        followed to the left and to the right, or the linear loop around 0 is not stable.
    """
    return _Everywhere(data).text(claim)


class _Everywhere(Region):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        H, given, n = plant(data["system"]), data["multiplier"], len(plant(data["system"]).A)
        if len(H.D) > 1 or n > MOST_STATES:
            raise refused(f"of what attracts everything, one channel and up to {MOST_STATES} states have an export")
        self.read(data, H, "P")
        self.disturb(data["proof"])
        (theta,), (weight,), (inverse,) = (numbers(given[key]) for key in ("theta", "lambda", "inverse"))
        if 0 not in self.known or not theta or not inverse:
            raise refused("its nonlinearity is not known and below a line, or V has no integral")
        self.near, self.k, self.least = self.around()
        rows = [row[:n] for row in self.loop.now]
        self.loop = replace(self.loop, P=self.P, theta=[theta], bounds=[(ZERO, 1 / inverse)], rows=rows)
        found = whole_loop(replace(self.loop, weights=[2 * weight * inverse]))
        assert found is not None, "the sector has bounds"
        self.forms, (self.N, self.K), self.second = found, self.scaled(found), self.settled(H.A, H.B, H.C)

    def around(self) -> tuple[Fraction, Fraction, Fraction]:
        """``d, k, m``: it is ``k y`` up to ``|y| = d``, and at least ``m`` beyond."""
        one = self.known[0]
        middle = sum(c < 0 for c in one.cuts)
        lines = [[*p, ZERO, ZERO][:2] for p in one.pieces]
        plain = 0 not in one.cuts and not any(v for p in one.pieces for v in p[2:]) and not lines[middle][0]
        d = min((abs(c) for c in one.cuts), default=Fraction(1))
        ends = [(sign * d, self.place(sign * d)) for sign in (-1, 1)]
        ends += [(c, j) for k, c in enumerate(one.cuts) for j in (k, k + 1)]
        m = min((a + b * y) * (1 if y > 0 else -1) for y, k in ends for a, b in (lines[k],))
        if not plain or lines[0][1] < 0 or lines[-1][1] < 0 or m <= 0:
            raise refused("its nonlinearity is not of lines, one through 0, or it comes near 0 elsewhere")
        return d, lines[middle][1], m

    def place(self, y: Fraction) -> int:
        """The piece at a point."""
        return sum(c < y for c in self.known[0].cuts)

    def scaled(self, f: Forms) -> tuple[int, int]:
        """Numbers for which the two tests of ``stills`` hold."""
        (_, _, row, _), psi = f.integrals[0], [int(j == len(f.now)) for j in range(f.size)]
        sight, speed = ([int(v) for v in mix(row, side)] for side in (f.now, f.then))
        falls = [*bilinear(f.P, f.now, f.then, -1), *bilinear(f.P, f.then, f.now, -1)]
        falls += [(-c, u, v) for c, u, v in (*f.turn, *f.products)]
        size = [*bilinear(f.P, f.now, f.now), (1, sight, sight), (1, psi, psi)]

        def enough(side: list[Term], square: list[int]) -> int:
            """The first power of 2 times a form that is above a square."""
            for power in range(MOST_SCALE):
                if nonnegative([*((c << power, u, v) for c, u, v in side), (-1, square, square)], f.size):
                    return int(1 << power)
            raise refused("it is not shown that its function falls with every value of phi and bounds sigma'")

        return enough(falls, psi), enough(size, speed)

    def settled(self, A: Matrix, B: Matrix, C: Matrix) -> Forms:
        """A form that falls where ``phi = k sigma``."""
        n, (b, c) = range(len(A)), ([row[0] for row in B], C[0])
        closed = [[v - self.k * b[i] * c[j] for j, v in enumerate(row)] for i, row in enumerate(A)]
        pairs = [(i, j) for i in n for j in n]
        # entry by entry of A'Q + Q A = -1
        left = [[closed[k][i] * (m == j) + closed[m][j] * (k == i) for k, m in pairs] for i, j in pairs]
        solved = eliminated(left, [[Fraction(-(i == j))] for i, j in pairs])
        g = less(self.loop.phi[0], self.k, self.loop.sigma[0])
        Q = [] if solved is None else [[solved[i * len(A) + j][0] for j in n] for i in n]
        for bits in BITS if Q else ():
            for power in range(0, MOST_SCALE, 8):
                terms_ = [(Fraction(-(1 << power)), g, g)]
                loop: Loop = replace(self.loop, P=rounded(Q, bits), theta=[ZERO], terms=terms_)
                if (found := forms(loop)) is not None:
                    return found
        raise refused("the loop with the line around 0 is not stable, or no form of few digits shows it")

    # ---- Words ----

    def text(self, claim: str) -> str:
        """The whole file."""
        plain = [self.known[0].definition(), *FallingTheorem.definitions(self)]
        parts = ["\n".join(plain), "\n".join(self.lemmas()), self.witness(), self.theorem()]
        origin = f"{self.data['theorem']}, {self.data['proof']['method']}"
        return whole_file(claim, origin, LIBRARIES, parts)

    def by_sides(self, step: Callable[[str], str]) -> list[str]:
        """A proof for each side of 0 of each piece, of what is to be said on the right or on the left."""
        one, cuts = self.known[0], sorted({ZERO, *self.known[0].cuts})
        parts = [*((None, b, self.place(b)) for b in cuts), (None, None, len(one.cuts))]

        def branch(_a: object, b: Fraction | None, k: int) -> list[str]:
            """The proof between two cuts."""
            side = "left" if b is not None and b <= 0 else "right"
            return [f"rewrite {one.on(k, 'y')}; {step(side)}."]

        return [*cases(parts, branch), "Qed."]

    def lemmas(self) -> list[str]:
        """What holds of the nonlinearity."""
        one, (d, k, m) = self.known[0], map(number, (self.near, self.k, self.least))
        (_, u), middle = self.loop.bounds[0], self.place(ZERO)
        return [
            f"Lemma class : in_sector 0 {number(Fraction(u))} phi.",
            f"Proof.\n  split; [rewrite {one.on(middle, '0')}; field|intro y].",
            *self.by_sides(lambda side: f"apply sector_{side}; lra"),
            f"Lemma away : forall y, {d} <= Rabs y -> {m} <= Rabs (phi y).",
            "Proof.\n  intros y A.",
            *self.by_sides(lambda side: f"apply (far_{side} {d} {m} y); [lra|intro; lra|exact A]"),
            f"Lemma line : forall y, Rabs y <= {d} -> phi y = {k} * y.",
            "Proof.",
            "  intros y A; pose proof (Rle_abs y); pose proof (Rle_abs (- y)); rewrite Rabs_Ropp in *.",
            f"  rewrite {one.on(middle, 'y')}; field.\nQed.",
        ]

    def hypotheses(self) -> list[tuple[str, str]]:
        """Names and statements."""
        return [one for one in FallingTheorem.hypotheses(self) if one[1]]

    def witness(self) -> str:
        """The numbers of the proof, and the tests that they pass."""
        f, two = self.forms, self.second
        ((_, _, row, _),), ((M, g, _),) = f.integrals, two.products
        lists = [("P", f.P), ("now", f.now), ("next", f.then), ("rows", f.rows), ("Q", two.P)]
        lines = [folded(f"Definition {name} : list (list Z) := {integers(rows)}%Z.") for name, rows in lists]
        flat = [("sight", row), ("psi", [int(j == self.order) for j in range(f.size)]), ("g", g)]
        lines += [f"Definition {name} : list Z := {integers(v)}%Z." for name, v in flat]
        sides = [("products", f.products), ("turn", f.turn)]
        lines += [folded(f"Definition {name} : list term := {terms(given)}%Z.") for name, given in sides]
        still = f"stills {f.size} P now next turn products sight psi {self.N} {self.K}"
        settles = f"falls_in_time {f.size} Q now next rows [] [] [(({M})%Z, (g, g))] {two.times}"
        tests = (("still", still), ("second", settles))
        shown = "Proof. vm_cast_no_check (eq_refl true). Qed."
        return "\n".join([*lines, *(f"Lemma {name} : {test} = true.\n{shown}" for name, test in tests)])

    def opening(self) -> list[str]:
        """The statement, and the names of what it is about."""
        told, ends = self.hypotheses(), " /\\ ".join(self.conclusions())
        lines = [
            "Theorem region : forall (Phi : R -> R) (x w : nat -> R -> R),",
            *(f"  ({text}) ->" for _, text in told),
        ]
        return [*lines, f"  {ends}.", "Proof.", f"  intros Phi x w {' '.join(name for name, _ in told)}."]

    def theorem(self) -> str:
        """The statement and its proof."""
        f, two, sigma = self.forms, self.second, "sigma x w t"
        ((_, c_, _, q_),), ((M, _, _),) = f.integrals, two.products
        c, q, d, k, m, u = map(number, (c_, q_, self.near, self.k, self.least, Fraction(self.loop.bounds[0][1])))
        entries = "; ".join(self.entry(j) for j in range(f.size))
        *products, last = self.products()
        assert last.endswith(" }"), "the block of another proof ends here"
        limit = f"({d} + b / ({c} * {m}))"
        lines = [
            *self.opening(),
            f"  pose (z := fun t : R => [{entries}]).",
            *self.flowing(),
            f"  assert (seen : forall t, dot sight (at_ now (z t)) = {q} * {sigma})",
            "    by (intro t; unfold sight, now, at_, z, sigma; cbn [map dot]; field).",
            f"  assert (worth : forall t, 0 < t -> dot psi (z t) = phi ({sigma}))",
            "    by (intros t Ht; rewrite <- (graph t Ht); unfold psi, z; cbn [dot]; ring).",
            f"  assert (grow : forall t, 0 <= Phi ({sigma}) /\\ {m} * (Rabs ({sigma}) - {d}) <= Phi ({sigma})).",
            f"  {{ intro t; apply (integral_grows Phi phi {m} {d} integral ltac:(lra) ltac:(lra)); [|exact away].",
            "    intro y; pose proof (proj2 class y); lra. }",
            "  assert (all : forall row, In row rows -> tends_to (fun t => dot row (at_ now (z t))) 0).",
            f"  {{ apply (everywhere_in_time {f.size} P now next turn products sight psi {self.N} {self.K} Q rows g",
            f"      ({M}) {two.times} z (fun t => {self.rest(-1)}) still second).",
            "  - reflexivity.",
            "  - exact F.",
            *self.turning(),
            *products,
            last.removesuffix(" }"),
            "  - intros t Ht; pose proof (grow t); lra.",
            f"  - intro b; exists (({q} * {q} + {u} * {u}) * ({limit} * {limit})).",
            "    intros t Ht B; rewrite seen, (worth t Ht).",
            f"    apply (grows_by Phi phi {m} {d} {u} {c}); [exact class|lra|lra|lra|apply grow|exact B].",
            f"  - intros e epos; destruct (away_by phi {d} {m} {k} {q} line away ltac:(lra) ltac:(lra) ltac:(lra)",
            "      e epos) as [l [L H]].",
            "    exists l; split; [exact L|]; intros t Ht A; rewrite seen in A; rewrite (worth t Ht); now apply H.",
            f"  - exists ({q} * {d}); split; [lra|]; intros t Ht A; rewrite seen in A.",
            f"    pose proof (line _ (small_by {q} {d} _ ltac:(lra) A)) as E; rewrite <- (graph t Ht) in E.",
            "    unfold sigma in E; unfold z, g; cbn [dot]; lra. }",
        ]
        return "\n".join([*lines, *self.ends(len(self.conclusions())), "Qed."])
