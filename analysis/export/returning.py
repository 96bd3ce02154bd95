"""Periodic solutions in continuous time of a piecewise linear nonlinearity, for Coq: `returns.v`.

The starts of all stays and their durations are ``z + Y y``; a contraction of ``y`` has a fixed point where each stay
ends at the start of the next one, on a kink, or on a plane at which a long stay is cut, as bounds of errors double in
each step.  Solutions are enclosed step by step by Taylor's polynomials in integers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from flint import arb_mat

from lure.analysis.certificates.arithmetic import numbers
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.states import classes, piecewise
from lure.analysis.counterexamples.linear import balls
from lure.analysis.export.gained import Rows, whole_rows
from lure.analysis.export.jumping import Steps
from lure.analysis.export.orbits import Graph
from lure.analysis.export.quadratic import Matrix, Vector
from lure.analysis.export.words import combined, folded, integers, number, reals, refused, whole_file
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import np

LIBRARIES = (
    "forms.v",
    "flow.v",
    "frequencies.v",
    "modes.v",
    "orbits.v",
    "stays.v",
    "jumps.v",
    "enclosures.v",
    "contraction.v",
    "returns.v",
)
GROWTHS, DIGITS, ROUNDS, FEWER = range(5), 10, 6, 8
LONGEST, FINE = (16, 12, 10, 8, 6), 48  # steps of a stay, beyond which it is cut; bits of the plane at which it is
BESIDE, FAR, PRECISION, MOST_TERMS, MOST_WORK = (52, 58), 16, 1024, 80, 10**9
Cut = tuple[list[int], Vector, list[Vector], Rows]  # pieces, durations, starts, and the forms that are 0 there


@dataclass(frozen=True, kw_only=True)
class Stay(Steps):
    """One stay: how many steps, where it starts, a form that is 0 there, and forms that stay >= 0."""

    steps: int
    start: list[int]
    entry: list[int]
    sides: list[list[int]]


def _dot(u: Sequence[int], v: Sequence[int]) -> int:
    return sum(a * x for a, x in zip(u, v, strict=False))


def _combine_forms(u: Sequence[int], rows: Sequence[Sequence[int]]) -> list[int]:
    """``combine_forms`` of the Coq file: ``u . rows``."""
    return [sum(a * row[j] for a, row in zip(u, rows, strict=False)) for j in range(len(rows[0]))]


def in_binary(value: Fraction, bits: int) -> Fraction:
    """A positive number rounded to so many bits: Coq divides by powers of 2 without a division."""
    places = bits - value.numerator.bit_length() + value.denominator.bit_length()
    return Fraction(round(value * 2**places), 2**places)


def returning_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by a periodic solution in continuous time.

    ``claim``: the sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: its plant is of another kind, or no steps of few enough digits enclose it.
    """
    return _Orbit(data).text(claim)


class _Numbers:
    """What `orbit_ok` of the Coq file is given, and tests."""

    def __init__(self, stays: list[Stay], weights: list[int], bits: int) -> None:
        self.stays, self.W, self.S, self.n = stays, weights, 1 << bits, len(weights) - 1
        self.wrong = [*range(len(stays))]  # of which the test does not hold
        for self.m in range(8, MOST_TERMS):
            if all(self.fits(s.start, bits) for s in stays) and self.fits([self.S], bits):
                break
        n, spots = self.n, [[self.S * (k == j) for k in range(self.n + 1)] for j in range(self.n)]
        traces = [self.trace(s, s.start, s.steps + 1) for s in stays]
        ends = [[sum(v) for v in zip(*trace[-2], strict=True)] for trace in traces]
        columns = [[[sum(v) for v in zip(*self.trace(s, v, s.steps)[-1], strict=True)] for v in spots] for s in stays]
        D, N = len(stays) * (n + 1), n + 1
        J = np.zeros((D, D))
        for i, (s, w, cols) in enumerate(zip(stays, ends, columns, strict=True)):
            then = (i + 1) % len(stays)
            for k in range(n):
                J[i * N + k, i * N : i * N + n] = [float(Fraction(c[k], self.S)) for c in cols]
                J[i * N + k, i * N + n] = float(Fraction(s.p * _dot(s.rows[k], w) // s.q, self.S))
                J[i * N + k, then * N + k] -= 1
            J[i * N + n, i * N : i * N + n] = [float(v / max(map(abs, s.entry[:n]))) for v in s.entry[:n]]
        mu = 1 << DIGITS
        try:
            self.Y = [[round(float(v) * mu) for v in row] for row in np.linalg.inv(J)]
        except np.linalg.LinAlgError:
            return
        self.mus = [mu * (max(map(abs, s.entry[:n])) if k == n else 1) for s in stays for k in range(N)]
        self.largest = max(sum(map(abs, row)) for row in self.Y)
        misses = []
        for i, (s, w) in enumerate(zip(stays, ends, strict=True)):
            after, worst = stays[(i + 1) % len(stays)].start, self.worst(s.steps, 0)
            misses += [abs(w[k] - after[k]) + weights[k] * worst for k in range(n)] + [abs(_dot(s.entry, s.start))]
        self.rho = max(-(-2 * f // mu) for f, mu in zip(misses, self.mus, strict=True))
        self.reach = self.largest * self.rho
        if 2 * self.reach <= self.S:
            given = enumerate(zip(ends, columns, traces, strict=True))
            self.wrong = [i for i, (w, cols, trace) in given if not self.stay_holds(i, w, cols, trace)]

    @property
    def divisor(self) -> int:
        """``divisor``."""
        return math.factorial(self.m + 1) << self.m + 1

    def fits(self, v: Sequence[int], e: int) -> bool:
        """``fits`` of the Coq file."""
        return 2 * (sum(map(abs, v)) + e) <= self.divisor

    def worse(self, e: int) -> int:
        """``worse``."""
        return 2 * e + 2 * self.m + 1

    def worst(self, steps: int, e: int) -> int:
        """``worst``."""
        return (e + 2 * self.m + 1 << steps) - 2 * self.m - 1

    def trace(self, s: Stay, v: list[int], steps: int) -> list[list[list[int]]]:
        """``trace``."""
        found = []
        for _ in range(steps):
            terms = [v]
            for j in range(1, self.m + 1):
                terms.append([s.p * _dot(r, terms[-1]) // (s.q * j) for r in s.rows])
            found.append(terms)
            v = [sum(w) for w in zip(*terms, strict=True)]
        return found

    def stay_holds(self, i: int, w: list[int], cols: Rows, trace: list[list[list[int]]]) -> bool:
        """``leg_ok``."""
        s, N, error = self.stays[i], self.n + 1, self.reach
        for terms in trace:
            if not self.fits(terms[0], error):
                return False
            error = self.worse(error)
        return all(self.keeps(i, g, trace) for g in s.sides) and all(self.short(i, k, w, cols) for k in range(N))

    def short(self, i: int, k: int, w: list[int], cols: Rows) -> bool:
        """``short``."""
        s, n, N = self.stays[i], self.n, self.n + 1
        own, mu, place = self.Y[i * N : i * N + N], self.mus[i * N + k], i * N + k
        if k == n:
            row, rest = _combine_forms([self.S * v for v in s.entry[:n]], own), 0
        else:
            row = _combine_forms([*(c[k] for c in cols), s.p * _dot(s.rows[k], w) // s.q], own)
            after = self.Y[(i + 1) % len(self.stays) * N + k]
            row = [a - self.S * b for a, b in zip(row, after, strict=True)]
            more = self.divisor * self.reach // self.S + 1
            errors = [self.worst(s.steps, e) + more for e in (0, self.reach)]
            rest = self.largest * (n * self.W[k] * errors[0] + self.W[k] * errors[1] + 1)
        row[place] -= self.S * mu
        return 4 * sum(map(abs, row)) <= self.S * mu and 4 * rest <= self.S * mu

    def keeps(self, i: int, g: list[int], trace: list[list[list[int]]]) -> bool:
        """``keeps``."""
        s, after = self.stays[i], self.stays[(i + 1) % len(self.stays)].entry
        known, ends = (g in (e, [-v for v in e]) for e in (s.entry, after))
        up, error, falls = _combine_forms(g, s.rows), self.reach, False
        for terms in trace:
            bounds = self.worse(error)
            if not falls and (self.steady(g, bounds, terms) or (known and self.steady(up, bounds, terms))):
                known = True
            elif ends and self.steady([-v for v in up], bounds, terms):
                falls = True
            else:
                return False
            error = bounds
        return True

    def steady(self, g: list[int], error: int, terms: list[list[int]]) -> bool:
        """``steady``."""
        (a, b, c, *rest), least = (_dot(g, v) for v in terms), 0
        for v in reversed(rest):
            least = v + min(0, least)
        k = c + min(0, least)
        if k <= 0:
            least = min(a, a + b + k)
        elif b >= 0:
            least = a
        else:
            least = a + b + k if 2 * k <= -b else a - b * b // (4 * k) - 1
        return sum(abs(a) * w for a, w in zip(g, self.W, strict=True)) * error <= least


class _Orbit:
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        top, self.den, _ = coefficients(data["system"])
        self.num, self.n = top[0][1], len(self.den) - 1
        if data["system"]["kind"] != "transfer" or not 0 < len(self.num) <= self.n:
            raise refused(
                "its plant is not one of two polynomials without a feedthrough, for which orbits have an export"
            )
        proof = data["proof"]
        phi, pieces, times = (
            piecewise(proof["points"], proof["left"], proof["right"]),
            proof["pieces"],
            numbers(proof["durations"]),
        )
        state = [v / self.den[0] for v in numbers(proof["state"])]
        self.lines, last = phi.lines, len(phi.lines) - 1
        if proof["half"]:
            pieces, times = [*pieces, *(last - p for p in pieces)], times * 2
        c = [Fraction(0)] * (self.n - len(self.num)) + self.num
        self.c, self.pieces, self.used = c[::-1], pieces, sorted({*pieces})
        matrices = {p: self.matrix(*self.lines[p]) for p in self.used}
        starts = self.around([matrices[p] for p in pieces], times, state)
        most = max(abs(x * a) for start in starts for a, x in zip(self.c, start, strict=False))
        far = Fraction(FAR * (1 + math.ceil(most)))
        self.levels = [-far, *(x for x, _, _ in self.lines[1:]), far]
        points = {(x, phi.at(x)) for x in self.levels}
        self.graph = Graph(classes(data["laws"]), points)
        self.scale = math.lcm(*(v.denominator for v in (*self.c, *self.levels)))
        levels = [self.levels[max(p, q)] for p, q in pairwise([pieces[-1], *pieces])]
        self.found = self.numbers(matrices, times, starts, [self.side(level) for level in levels])
        z = [s.start for s in self.found.stays]
        self.apart = max(
            (abs(a - b), i, j, k)
            for i, u in enumerate(z)
            for j, v in enumerate(z)
            for k, (a, b) in enumerate(zip(u, v, strict=True))
            if k < self.n
        )

    def matrix(self, x: Fraction, w: Fraction, k: Fraction) -> Matrix:
        """Of ``(xi, .., 1)`` on a piece."""
        n, d = self.n, self.den
        last = [-(a + k * v) / d[0] for a, v in zip(d[:0:-1], self.c, strict=True)]
        shifts = [[Fraction(j == i + 1) for j in range(n + 1)] for i in range(n - 1)]
        return [*shifts, [*last, (k * x - w) / d[0]], [Fraction(0)] * (n + 1)]

    def around(self, matrices: Sequence[Matrix], times: Sequence[Fraction], state: Vector) -> list[Vector]:
        """The starts of all stays."""
        found = [[*state, Fraction(1)]]
        with working_precision(PRECISION):
            for A, t in zip(matrices[:-1], times, strict=False):
                moved = (balls(A) * ball(t)).exp() * arb_mat([[ball(v)] for v in found[-1]])
                found.append([exact_midpoint(moved[i, 0]) for i in range(self.n + 1)])
        return found

    def side(self, level: Fraction, sign: int = 1) -> list[int]:
        """``sign (sigma - level)``, in integers."""
        return [int(sign * v * self.scale) for v in (*self.c, -level)]

    def cut(
        self, matrices: Mapping[int, Matrix], times: Vector, parts: list[int], starts: list[Vector], entries: Rows
    ) -> Cut:
        """Each stay in so many of equal durations: after the first they start where a plane is crossed."""
        found, more = list[Vector](), Rows()
        for p, t, k, start, entry in zip(self.pieces, times, parts, starts, entries, strict=True):
            own = self.around([matrices[p]] * k, [t / k] * k, start[:-1])
            found += own
            more.append(entry)
            for x in own[1:]:
                flow = [sum((a * v for a, v in zip(row, x, strict=True)), Fraction(0)) for row in matrices[p][:-1]]
                plane = [round(v / max(map(abs, flow)) * 2**8) << FINE for v in flow]
                more.append([*plane, -round(sum(a * v for a, v in zip(plane, x, strict=False)))])
        pieces = [p for p, k in zip(self.pieces, parts, strict=True) for _ in range(k)]
        return pieces, [t / k for t, k in zip(times, parts, strict=True) for _ in range(k)], found, more

    def stays_of(
        self, whole: Mapping[int, tuple[int, Rows]], given: Cut, counts: list[int], beside: int
    ) -> tuple[list[Stay], int]:
        """The stays in so many steps each, and the bits of their numbers."""
        bits, fine, found = 2 * max(counts) + beside, max(counts) + beside - FEWER, list[Stay]()
        for p, t, x, entry, k in zip(*given, counts, strict=True):
            d, rows = whole[p]
            h = in_binary(t / (k * d), fine)
            sides = [self.side(self.levels[p]), self.side(self.levels[p + 1], -1)]
            z = [*(round(v * 2**bits) for v in x[:-1]), 1 << bits]
            own = Stay(d=d, rows=rows, p=h.numerator, q=h.denominator, steps=k, start=z, entry=entry, sides=sides)
            found.append(own)
        return found, bits

    def numbers(self, matrices: Mapping[int, Matrix], times: Vector, starts: list[Vector], entries: Rows) -> _Numbers:
        """Those that hold with the least work, of stays that are cut less often or more."""
        whole = {p: whole_rows(A) for p, A in matrices.items()}

        def fewest(weights: list[int], pieces: Sequence[int], times: Vector) -> list[int]:
            """Steps of each stay, by the larger of which the flow moves by half of a weight."""
            sizes = [
                max(
                    sum(abs(a) * w for a, w in zip(r, weights, strict=True)) / Fraction(d * own)
                    for r, own in zip(rows, weights, strict=True)
                )
                for d, rows in (whole[p] for p in pieces)
            ]
            return [math.ceil(2 * size * t * Fraction(65, 64)) for size, t in zip(sizes, times, strict=True)]

        def cost(weights: list[int]) -> int:
            """Steps in all."""
            return sum(fewest(weights, self.pieces, times))

        weights = min(([*(1 << g * k for k in range(self.n)), 1] for g in GROWTHS), key=cost)
        tried = list[tuple[int, int, Cut, int]]()
        for longest, beside in product(LONGEST, BESIDE):
            parts = [-(-k // longest) for k in fewest(weights, self.pieces, times)]
            given = self.cut(matrices, times, parts, starts, entries)
            work = self.work(*self.stays_of(whole, given, fewest(weights, *given[:2]), beside))
            tried.append((work, len(tried), given, beside))
        best, least = None, MOST_WORK
        for work, _, given, beside in sorted(tried):
            counts = fewest(weights, *given[:2])
            for _ in range(ROUNDS if work < least else 0):
                stays, bits = self.stays_of(whole, given, counts, beside)
                if (work := self.work(stays, bits)) >= least:
                    break
                found = _Numbers(stays, weights, bits)
                if not found.wrong:
                    best, least = (given[0], found), work
                    break
                counts = [k + (k + 1) // 2 * (i in found.wrong) for i, k in enumerate(counts)]
        if best is not None:
            self.pieces, found = best
            return found
        raise refused("its orbit takes steps of so many digits that Coq would take minutes")

    def work(self, stays: Sequence[Stay], bits: int) -> int:
        """Of the digits of all products, of which Coq does some twenty million in a second."""
        terms = sum(((self.n + 2) * s.steps + 1) * (s.p.bit_length() + 12) for s in stays) * bits // 4 * self.n
        return bits * (terms + (len(stays) * (self.n + 1)) ** 2 * (self.n + 1) * 20)

    def text(self, claim: str) -> str:
        """The whole file."""
        parts = [
            self.graph.lemmas(),
            self.on_pieces(),
            self.given(),
            self.on_stays(),
            [*self.statement(), *self.proof()],
        ]
        return whole_file(claim, "counterexample, flow-orbit", LIBRARIES, ["\n".join(lines) for lines in parts])

    def on_pieces(self) -> list[str]:
        """That the graph is a line on each piece."""
        graph, lines, points = self.graph, list[str](), [x for x, _ in self.graph.points]
        ray = f"unfold with_ray; destruct (Rle_dec {number(points[0])} s) as [_|N]; [|exfalso; lra]; " * (
            not graph.steep
        )

        def between(a: Fraction, b: Fraction) -> str:
            """That ``s`` lies there."""
            return f"{number(a)} <= s <= {number(b)}"

        for i, ((x, y), (u, v)) in enumerate(pairwise(graph.points)):
            slope = number((v - y) / (u - x))
            lines += [
                f"Lemma segment{i} : forall s, {between(x, u)} ->",
                f"  {graph.f} s = {number(y)} + {slope} * (s - {number(x)}).",
                f"Proof. intros s I; {ray}rewrite (through_segment {graph.low} {i} points {graph.start} s in_order"
                " ltac:(cbn; lia) I); cbn [points nth fst snd]; field. Qed.",
            ]
        for p in self.used:
            low, high = self.levels[p : p + 2]
            cuts = [x for x in points if low <= x <= high]
            lines.append(f"Lemma on{p} : forall s, {between(low, high)} -> graph s = {self.line(p, 's')}.")
            lines.append(f"Proof.\n  intros s I; unfold graph{', oddly' * graph.odd}.")
            for a, b in pairwise(cuts):
                own, other = points.index(a), points.index(-b) if graph.odd else 0
                used = f"(segment{own} s)" + f", (segment{other} (- s))" * graph.odd
                shown = f"rewrite {used} by lra; lra"
                lines.append(f"  {shown}." if b == high else f"  destruct (Rle_dec s {number(b)}); [{shown}|].")
            lines.append("Qed.")
        return lines

    def line(self, p: int, s: str) -> str:
        """A piece."""
        x, w, k = self.lines[p]
        return f"{number(w)} + {number(k)} * ({s} - {number(x)})"

    def given(self) -> list[str]:
        """What the test is given."""
        found, lines = self.found, list[str]()
        for p in self.used:
            one = found.stays[self.pieces.index(p)]
            lines.append(folded(f"Definition matrix{p} : list (list Z) := {integers(one.rows)}%Z."))
            lines.append(folded(f"Definition sides{p} : list (list Z) := {integers(one.sides)}%Z."))
        for i, (p, s) in enumerate(zip(self.pieces, found.stays, strict=True)):
            given = f"{s.d} matrix{p} {s.p} {s.q} {s.steps} {integers(s.start)}%Z {integers(s.entry)}%Z sides{p}"
            lines.append(folded(f"Definition stay{i} : leg := Leg {given}."))
        lines.append(
            folded(f"Definition stays : list leg := [{'; '.join(f'stay{i}' for i in range(len(found.stays)))}].")
        )
        lines.append(folded(f"Definition inverse : list (list Z) := {integers(found.Y)}%Z."))
        lines.append(folded(f"Definition scales : list Z := {integers(found.mus)}%Z."))
        lines.append(f"Lemma orbit : orbit_ok {self.test} = true.")
        return [*lines, "Proof. vm_cast_no_check (eq_refl true). Qed."]

    @property
    def test(self) -> str:
        """The arguments of `orbit_ok`."""
        f = self.found
        return f"{self.n} {f.m} {f.S} {integers(f.W)}%Z inverse scales {f.rho} stays"

    def on_stays(self) -> list[str]:
        """The loop, and that it is linear on each stay."""
        n, S, z = self.n, self.found.S, [f"nth {k} z 0" for k in range(self.n)]
        names = " ".join(f"z{k}" for k in range(n))
        state = f"[{names.replace(' ', '; ')}; {S}]"
        lines = [
            reals("num", self.num),
            reals("den", self.den),
            "Definition field (z : list R) (k : nat) : R :=",
            f"  if (k =? {n - 1})%nat then (- ({combined(self.den[:0:-1], z)})",
            f"    - {S} * graph (({combined(self.c, z)}) / {S})) / {number(self.den[0])} else nth (S k) z 0.",
        ]
        for p in self.used:
            d = self.found.stays[self.pieces.index(p)].d
            lines += [
                f"Lemma drive{p} : forall {names}, (forall g, In g sides{p} -> 0 <= dot g {state}) ->",
                f"  forall k, (k < {n})%nat -> dot (nth k matrix{p} []) {state} / {d} = field {state} k.",
                "Proof.",
                f"  intros {names} H k K; pose proof (H _ (or_introl eq_refl)) as A.",
                f"  pose proof (H _ (or_intror (or_introl eq_refl))) as B; cbn [dot] in A, B; unfold matrix{p}, field.",
                f"  do {n - 1} (destruct k as [|k]; [cbn [Nat.eqb nth dot]; lra|]); destruct k as [|k]; [|lia].",
                f"  cbn [Nat.eqb nth dot]; rewrite on{p} by lra; lra.",
                "Qed.",
            ]
        lines += [
            "Lemma field_on : forall i, (i < length stays)%nat -> forall z,",
            f"  length z = {n + 1}%nat -> nth {n} z 0 = {S} ->",
            "  (forall g, In g (lrows (leg_at stays i)) -> 0 <= dot g z) ->",
            f"  forall k, (k < {n})%nat ->",
            "  dot (nth k (lA (leg_at stays i)) []) z / IZR (ld (leg_at stays i)) = field z k.",
            "Proof.",
            f"  intros i I z L E; do {n} (destruct z as [|? z]; [discriminate L|]).",
            "  destruct z as [|e [|]]; [discriminate L| |discriminate L]; cbn [nth] in E; subst e; clear L.",
            "  unfold leg_at; rewrite Nat.mod_small by exact I.",
        ]
        lines += [f"  destruct i as [|i]; [exact (drive{p} {' '.join('_' * n)})|]." for p in self.pieces]
        return [*lines, "  cbn in I; lia.", "Qed."]

    def statement(self) -> list[str]:
        """What there is."""
        return [
            "Theorem moves : exists (phi : R -> R) (xi : nat -> R -> R),",
            f"  ({self.graph.said('phi')}) /\\",
            "  flow_of num den phi xi /\\",
            f"  forall c, ~ tends_to (xi {self.apart[-1]}%nat) c.",
        ]

    def proof(self) -> list[str]:
        """Its proof."""
        n, S, (_, i, j, k) = self.n, self.found.S, self.apart
        z = [self.found.stays[r].start[k] for r in (i, j)]
        back = "exists t; split; [exact T1|exact (T2 {}%nat ltac:(lia))]"
        back = "intro T; destruct (often {}%nat T ltac:(cbn; lia)) as [t [T1 T2]]; " + back
        last = f"field (at_once {n + 1} x t) {n - 1} / {S}"
        return [
            "Proof.",
            f"  destruct (returns {self.test} orbit field field_on) as [x [_ [flows often]]].",
            f"  exists graph, (fun k t => if (k <? {n})%nat then x k t / {S} else {last}).",
            "  split; [exact class|split; [split|]].",
            f"  - intros k t K T; change (length den) with {n + 1}%nat in K.",
            f"    pose proof (flows k t ltac:(lia) T) as D; apply (derivable_pt_lim_scal _ (/ {S})) in D.",
            f"    do {n - 1} (destruct k as [|k]; [refine (derivable_same _ _ t _ _ _ _ D);",
            "      [intro; cbn; unfold mult_real_fct, Rdiv; ring|unfold field; cbn; unfold Rdiv; ring]|]).",
            "    destruct k as [|k]; [|lia].",
            "    refine (derivable_same _ _ t _ _ _ _ D); [intro; cbn; unfold mult_real_fct, Rdiv; ring|].",
            "    cbn [Nat.ltb Nat.leb]; unfold Rdiv; ring.",
            "  - intros t T; unfold num, den, field.",
            "    cbn [along length Nat.ltb Nat.leb Nat.eqb at_once listed seq map nth].",
            "    match goal with |- context [graph (?a / _)] => match goal with |- _ = - graph ?b =>",
            f"      replace b with (a / {S}) by (unfold Rdiv; ring) end end; lra.",
            f"  - apply (never_settles (x {k}%nat) ({z[0]}) ({z[1]})",
            f"      (reach inverse {self.found.rho}) {S})%Z; [reflexivity|vm_compute; reflexivity| |].",
            f"    + {back.format(i, k)}.",
            f"    + {back.format(j, k)}.",
            "Qed.",
        ]
