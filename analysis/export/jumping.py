"""Gains that jump, in turn, with which a solution in continuous time is not bounded, for Coq: `stays.v`, `jumps.v`.

No matrix exponential is enclosed.  In steps ``h`` a form ``V = x'Q(t) x`` goes with the flow, ``Q' = -A'Q - QA - w`` by
Taylor's series, each term rounded; what is missing is less than ``w``, so that ``V' <= 0``; at the end of each step
``Q`` is above that of the next one, and in the end above the first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from flint import arb, arb_mat

from lure.analysis.certificates.arithmetic import numbers
from lure.analysis.certificates.blocks import coefficients, realised
from lure.analysis.certificates.states import classes, gained
from lure.analysis.export.gained import Rows, Words, by_stays, gained_loop, state_of, whole_rows, within, within_proof
from lure.analysis.export.quadratic import Matrix, Vector
from lure.analysis.export.switching import negative
from lure.analysis.export.words import folded, integers, number, reals, refused, whole_file
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import in_doubles, np

LIBRARIES = ("forms.v", "flow.v", "frequencies.v", "orbits.v", "stays.v", "jumps.v")
MARGINS = (128, 512)  # bits beside those that the exponentials take
TERMS = range(6, 41, 2)
SLOWER = (0, 4, 7, 10, 14, 20, 28)  # how much slower than the fastest, as powers of two; 0: not at all
STEP = 1.0  # times the largest eigenvalue
DROPS = (1 << 14, 1 << 24)
MOST_ORDER, MOST_STAYS, MOST_STEPS, MOST_WORK = 6, 24, 400, 6 * 10**8


@dataclass(frozen=True, kw_only=True)
class Steps:
    """A linear flow in steps: ``d``, the rows of ``d x'``, and the step ``h = d p/q``."""

    d: int
    rows: Rows
    p: int
    q: int


@dataclass(frozen=True, kw_only=True)
class Stay(Steps):
    """One stay, with the forms at the beginning of each step."""

    Q: list[Rows]


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Stays of ``A - slower``, how many terms, a third of what ``Q`` drops by in a step, once by ``w h``; a start."""

    stays: list[Stay]
    terms: int
    drop: int
    start: list[int]
    slower: Fraction

    @property
    def test(self) -> str:
        """The arguments of `stays_ok` before the stays."""
        return f"{len(self.start)} {self.terms} {self.drop}"


def growth(matrices: Sequence[Matrix], times: Sequence[Fraction]) -> Growth:
    """Forms that fall around the period.

    Raises
    ------
    refused
        An ``InputError``: none of few enough steps and digits was found.
    """
    n = len(matrices[0])
    if not (0 < n <= MOST_ORDER and len(times) <= MOST_STAYS):
        raise refused(f"it has {n} states and {len(times)} stays; up to {MOST_ORDER} and {MOST_STAYS} have an export")
    fast = [max(abs(np.linalg.eigvals(in_doubles(A)))) for A in matrices]
    counts = [max(1, math.ceil(float(v) * float(T) / STEP)) for v, T in zip(fast, times, strict=True)]
    if sum(counts) > MOST_STEPS:
        raise refused(f"its period is {sum(counts)} steps long; up to {MOST_STEPS} have an export")
    steps = [T / k for T, k in zip(times, counts, strict=True)]
    taken = math.ceil(8 * sum(float(v) * float(T) for v, T in zip(fast, times, strict=True)) / math.log(2))
    for power in SLOWER:
        slower = Fraction(2) ** (math.frexp(float(max(fast)))[1] - power) if power else Fraction(0)
        own = [[[v - slower * (i == j) for j, v in enumerate(row)] for i, row in enumerate(A)] for A in matrices]
        for margin, drop in product(MARGINS, DROPS):
            with working_precision(taken + margin):
                found = _around(own, steps, counts, drop)
            start = negative(found[0][0]) if found else []
            if not start:
                break
            stays = list[Stay]()
            for A, h, Q in zip(own, steps, found, strict=True):
                d, rows = whole_rows(A)
                stays.append(Stay(d=d, rows=rows, p=(h / d).numerator, q=(h / d).denominator, Q=Q))
            if terms := _terms(stays, drop):
                # products of numbers of so many digits, which take Coq half a minute at most
                work = sum(len(stay.Q) * n**3 * terms * stay.q.bit_length() ** 2 for stay in stays)
                if work > MOST_WORK:
                    raise refused(
                        "its numbers have too many digits for the steps of its period: Coq would take minutes"
                    )
                return Growth(stays=stays, terms=terms, drop=drop, start=start, slower=slower)
    raise refused("no forms of few enough digits were found that fall around the period of its gains")


def _around(
    matrices: Sequence[Matrix], steps: Sequence[Fraction], counts: Sequence[int], drop: int
) -> list[list[Rows]]:
    """The forms at the beginning of each step, twice the drop less than the flow gives; none if they are not found.

    ``Q(h) = E'QE - w G``, ``w = drop/h``, with ``E = e^(-Ah)`` and ``G`` the integral of ``E'E``; with ``F = e^(Mh)``,
    ``M = (A', 1; 0, -A)``, that is ``E'F_12``.
    """
    n, moves = len(matrices[0]), []
    unit = arb_mat([[arb(int(i == j)) for j in range(n)] for i in range(n)])
    for A, h in zip(matrices, steps, strict=True):
        top = [[ball(h * A[j][i]) for j in range(n)] + [ball(h) * (i == j) for j in range(n)] for i in range(n)]
        low = [[arb(0)] * n + [ball(-h * v) for v in row] for row in A]
        F = arb_mat([*top, *low]).exp()
        E = arb_mat([[F[n + i, n + j] for j in range(n)] for i in range(n)])
        G = E.transpose() * arb_mat([[F[i, n + j] for j in range(n)] for i in range(n)])
        moves.append((E, G * ball(drop / h) + unit * arb(2 * drop)))
    N, less = unit, arb_mat([[arb(0)] * n for _ in range(n)])
    for (E, G), count in zip(moves, counts, strict=True):
        for _ in range(count):
            N, less = N * E, E.transpose() * less * E + G
    # Q = N'QN - less, entry by entry
    places = [(i, j) for i in range(n) for j in range(n)]
    left = arb_mat([[int((i, j) == (k, m)) - N[k, i] * N[m, j] for k, m in places] for i, j in places])
    try:
        solved = left.solve(arb_mat([[-less[i, j]] for i, j in places]))
    except ZeroDivisionError:
        return []
    if not all(solved[i, 0].rad() < 1 for i in range(n * n)):
        return []
    Q, found = arb_mat([[solved[i * n + j, 0].mid() for j in range(n)] for i in range(n)]), list[list[Rows]]()
    for (E, G), count in zip(moves, counts, strict=True):
        found.append([])
        for _ in range(count):
            if not all(Q[i, j].rad() < 1 for i, j in places):
                return []
            near = [[_whole((Q[i, j] + Q[j, i]) / 2) for j in range(n)] for i in range(n)]
            found[-1].append(near)
            Q = E.transpose() * Q * E - G
    return found


def _whole(x: arb) -> int:
    """The whole number next to a ball."""
    mantissa, exponent = x.mid().man_exp()
    return round(Fraction(int(mantissa)) * Fraction(2) ** int(exponent))


def _terms(stays: list[Stay], drop: int) -> int:
    """How many terms are enough for `stays_ok` of the Coq file; 0 if none are."""
    pairs = [(stay, Q) for stay in stays for Q in stay.Q]
    after = [Q for _, Q in (*pairs[1:], pairs[0])]
    for m in TERMS:
        if all(_piece_holds(stay, (Q, then), m, drop) for (stay, Q), then in zip(pairs, after, strict=True)):
            return m
    return 0


def _lie(Q: Rows, A: Rows) -> Rows:
    """``A'Q + QA``."""
    n = range(len(A))
    half = [[sum(Q[i][k] * A[k][j] for k in n) for j in n] for i in n]
    return [[half[i][j] + half[j][i] for j in n] for i in n]


def _size(Q: Rows) -> int:
    """``size_of`` of the Coq file."""
    return sum(abs(v) for i, row in enumerate(Q) for v in row[i:])


def _piece_holds(stay: Stay, forms: tuple[Rows, Rows], m: int, drop: int) -> bool:
    """``piece_ok`` of the Coq file, of the forms before and after a step."""
    (Q, after), p, q = forms, stay.p, stay.q
    n, series, errors = range(len(Q)), [Q], 0
    for k in range(1, m + 2):
        moved = [[p * v for v in row] for row in _lie(series[-1], stay.rows)]
        series.append(
            [[-v // (q * k) - drop * (i == j and k == 1) for j, v in enumerate(row)] for i, row in enumerate(moved)]
        )
        errors += _size([[v % -(q * k) for v in row] for row in moved])
    errors += _size([[p * v for v in row] for row in _lie(series[-1], stay.rows)])
    rest = [[sum(R[i][j] for R in series) - after[i][j] - 2 * drop * (i == j) for j in n] for i in n]
    return errors <= q * drop and _size(rest) <= drop


def jumping_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by gains that jump and repeat, in continuous time.

    Raises
    ------
    refused
        An ``InputError``: it is about a rate or a plant of another kind, or no forms of few enough steps were found.
    """
    if data["system"]["kind"] == "transfer":
        return _Polynomials(data).text(claim)
    return jumping_words(data).text(claim, data["proof"]["method"])


def jumping_words(data: Mapping[str, Any]) -> Words:
    """The same of a plant in states."""
    return _States(data).words()


class _Jumps:
    """The words of one file: what both kinds of plant have in common."""

    rows: list[Vector]  # gains of each stay, one for each channel
    bounds: list[tuple[Any, Any]]

    def __init__(self, data: Mapping[str, Any], matrices: Sequence[Matrix]) -> None:
        self.times, self.method = numbers(data["proof"]["times"]), data["proof"]["method"]
        self.growth, self.n, self.p = growth(matrices, self.times), len(matrices[0]), len(self.times)

    def lists(self) -> list[str]:
        """Times, gains, stays and the start."""
        found, channels_of = [reals("durations", self.times)], zip(*self.rows, strict=True)
        found += [reals(f"gains{i}", list(gains)) for i, gains in enumerate(channels_of)]
        found.append(folded(f"Definition start : list R := {integers(self.growth.start)}."))
        names = []
        for j, stay in enumerate(self.growth.stays):
            forms, name = told(stay, j, self.trimmed(stay))
            found.append(forms)
            names.append(name)
        return [*found, folded(f"Definition stays : list stay := [{'; '.join(names)}]%Z.")]

    def trimmed(self, stay: Stay) -> Rows:
        """The rows of ``d x'``."""
        return stay.rows

    def lemmas(self) -> list[str]:
        """The test, and how long the stays are."""
        growth = self.growth
        counts = [
            f"cbv [nth lasts]; replace (Z.of_nat (length forms{j})) with {len(stay.Q)}%Z by reflexivity; lra"
            for j, stay in enumerate(growth.stays)
        ]
        return [
            f"Lemma grow : stays_ok {growth.test} stays = true.",
            "Proof. vm_cast_no_check (eq_refl true). Qed.",
            "Lemma negative : qf (first_of (stay_at stays 0)) start < 0.",
            "Proof.",
            "  unfold first_of, stay_at, stays, forms0, start.",
            "  cbn [length Nat.modulo Nat.divmod Nat.sub nth fst snd hd qf dot]; lra.",
            "Qed.",
            "Lemma stay_times : forall j, lasts (stay_at stays j) = repeated durations j.",
            "Proof.",
            f"    intro j; unfold stay_at, repeated; change (length stays) with {self.p}%nat.",
            f"    change (length durations) with {self.p}%nat; set (r := (j mod {self.p})%nat).",
            "    unfold stays, durations.",
            *by_stays(self.p, counts),
            "Qed.",
        ]

    def opened(self) -> str:
        """The solution."""
        sides = f"{number(self.growth.slower)} {self.growth.test} start stays ltac:(lra) ltac:(discriminate) eq_refl"
        found = "[x [jump [index [J0 [J [I [C [D U]]]]]]]]"
        return f"  destruct (in_turn {sides} grow negative) as {found}."

    def timed(self) -> list[str]:
        """What is said of jumps and gains."""
        return [
            "jump O = 0",
            "(forall j, jump (S j) = jump j + repeated durations j)",
            *(f"(forall t, {text})" for i, ends in enumerate(self.bounds) if (text := within(f"g{i} t", ends))),
            *(
                f"(forall j t, jump j <= t < jump (S j) -> g{i} t = repeated gains{i} j)"
                for i in range(len(self.bounds))
            ),
        ]

    def timed_proof(self) -> list[str]:
        """Its proof."""
        lines = ["  split; [exact J0|split; [intro j; rewrite J; f_equal; apply stay_times|]]."]
        alike = ["  split; [intros j t T; now rewrite (I j t T)|]."] * len(self.bounds)
        return [*lines, *within_proof(self.bounds), *alike]


def told(stay: Stay, j: int, rows: Rows) -> tuple[str, str]:
    """The definition of the forms of a stay, and the stay."""
    forms = ("[" + "; ".join(f"({row[i]}, {integers(row[i + 1 :])})" for i, row in enumerate(Q)) + "]" for Q in stay.Q)
    said = f"({stay.d}, ({integers(rows)}, (({stay.p}, {stay.q}), forms{j})))"
    return folded(f"Definition forms{j} : list triangle := [{'; '.join(forms)}]%Z."), said


class _Polynomials(_Jumps):
    """Of a plant that is given by two polynomials."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        family = classes(data["laws"])
        A, b, c, d, _ = realised(data["system"], Fraction(0))
        gains = numbers(data["proof"]["gains"])
        self.bounds = [(max(family.sector[0], family.slope[0]), min(family.sector[1], family.slope[1]))]
        self.rows, self.data = [[g] for g in gains], data
        super().__init__(data, [gained(A, b, [g * v / (1 + g * d) for v in c]) for g in gains])

    def text(self, claim: str) -> str:
        """The whole file."""
        parts = ["\n".join(lines) for lines in (self.lists(), self.lemmas(), [*self.statement(), *self.proof()])]
        return whole_file(claim, f"counterexample, {self.method}", LIBRARIES, parts)

    def trimmed(self, stay: Stay) -> Rows:
        """Rows of a companion matrix, without the zeros at the end."""
        return [*(row[: k + 2] for k, row in enumerate(stay.rows[:-1])), stay.rows[-1]]

    def lists(self) -> list[str]:
        """The plant beside the rest."""
        top, den, _ = coefficients(self.data["system"])
        return [reals("num", top[0][1]), reals("den", den), *super().lists()]

    def statement(self) -> list[str]:
        """What there is."""
        n, state = self.n, "; ".join(f"xi {k}%nat t" for k in range(self.n))
        said = [
            *self.timed(),
            f"(forall k t, (k < {n})%nat -> continuity_pt (xi k) t)",
            f"(forall k t, (k < {n})%nat -> (forall j, t <> jump j) -> derivable_pt_lim (xi k) t (xi (S k) t))",
            "(forall t, along den xi t = - (g0 t * along num xi t))",
        ]
        return [
            "Theorem moves : exists (g0 : R -> R) (xi : nat -> R -> R) (jump : nat -> R),",
            *(f"  {text} /\\" for text in said),
            f"  forall B, exists t, 0 <= t /\\ B < norm2 [{state}].",
        ]

    def proof(self) -> list[str]:
        """Its proof."""
        n, slow = self.n, self.growth.slower
        return [
            "Proof.",
            self.opened(),
            f"  set (last := fun t => let s := stay_at stays (index t) in dot (nth {n - 1} (rows_of s) [])"
            f" (at_once {n} x t) / IZR (fst s) + {number(self.growth.slower)} * x {n - 1}%nat t).",
            f"  exists (fun t => repeated gains0 (index t)), (fun k => if (k <? {n})%nat then x k else last), jump.",
            *self.timed_proof(),
            "  split; [intros k t K; rewrite (proj2 (Nat.ltb_lt _ _) K); apply C|].",
            "  split; [intros k t K N; pose proof (D k t K N) as E; cbv zeta in E|].",
            f"  {{ rewrite (proj2 (Nat.ltb_lt _ _) K); destruct (Nat.eq_dec k {n - 1}) as [->|ne]; [exact E|].",
            f"    rewrite (proj2 (Nat.ltb_lt (S k) {n})) by lia.",
            "    refine (derivable_same _ _ t _ _ (fun s => eq_refl) _ E).",
            f"    pose proof (companion_row {n} {slow.numerator} {slow.denominator} stays (index t) k (at_once {n} x t)"
            " ltac:(discriminate) eq_refl ltac:(lia)",
            "      ltac:(unfold at_once; rewrite listed_length; lia)) as S0.",
            "    unfold at_once, listed in S0 |- *; rewrite !nth_listed in S0 by lia; rewrite <- S0; lra. }",
            "  split; [|exact U].",
            "  intro t; unfold num, den; cbn [along length Nat.add Nat.ltb Nat.leb]; unfold last; cbv zeta.",
            "    unfold stay_at, repeated, at_once, listed.",
            f"    change (length stays) with {self.p}%nat; change (length gains0) with {self.p}%nat.",
            f"    set (r := (index t mod {self.p})%nat); unfold stays, gains0; cbn [seq map].",
            *by_stays(self.p, ["cbn [nth rows_of fst snd dot map]; lra"] * self.p),
            "Qed.",
        ]


class _States(_Jumps):
    """Of a plant that is given by matrices, of one channel or several."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.loops = gained_loop(data)
        self.rows, self.bounds = self.loops.gains, self.loops.bounds
        super().__init__(data, self.loops.matrices)

    def words(self) -> Words:
        """The theorem and its proof."""
        return Words(
            libraries=LIBRARIES, loops=self.loops, parts=["\n".join(self.lists()), "\n".join(self.lemmas())],
            kind="R -> R", gains=self.timed(), laws=[f"g{b} t *" for b in self.loops.block],
            end=f"forall B, exists t, 0 <= t /\\ B < norm2 {state_of(self.n)}", proof=self.proof(), jumps=True,
        )  # fmt: skip

    def lists(self) -> list[str]:
        """Values ``w`` of each stay beside the rest."""
        return [*super().lists(), self.loops.outputs()]

    def proof(self) -> list[str]:
        """Its proof."""
        n, m, p = self.n, len(self.bounds), self.p
        lengths = ["stays", "values", *(f"gains{i}" for i in range(m))]
        opened = [
            "unfold repeated, stay_at, at_once, listed.",
            *(f"change (length {name}) with {p}%nat." for name in lengths),
            f"set (r := (index t mod {p})%nat); unfold {', '.join(lengths)}; cbn [seq map].",
        ]
        lines = [
            "Proof.",
            self.opened(),
            f"  set (w := fun i t => let v := nth (index t mod {p})%nat values (1%Z, []) in"
            f" dot (nth i (snd v) []) (at_once {n} x t) / IZR (fst v)).",
            f"  exists {', '.join(f'(fun t => repeated gains{i} (index t))' for i in range(m))}, x, w, jump.",
            *self.timed_proof(),
        ]
        own = "cbn [nth rows_of fst snd dot map]; lra"
        for _ in self.loops.block:
            lines += ["  split; [intro t; unfold w; cbv zeta|].", "  {", *(f"    {line}" for line in opened)]
            lines += [*by_stays(self.p, [own] * p), "  }"]
        lines.append("  split; [intros k t K; apply C|].")
        for k in range(n):
            lines += [
                f"  split; [intros t N; pose proof (D {k}%nat t ltac:(lia) N) as E; cbv zeta in E|].",
                "  { refine (derivable_same _ _ t _ _ (fun s => eq_refl) _ E); clear E; unfold w; cbv zeta.",
                *(f"    {line}" for line in opened),
                *by_stays(self.p, [own] * p),
                "  }",
            ]
        return [*lines, "  exact U.", "Qed."]
