"""Gains of the class, in turn, with which a solution has no limit, for Coq: in discrete time `switching.v`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import fmpq, fmpq_mat

from lure.analysis.certificates.arithmetic import INF, numbers
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.states import classes
from lure.analysis.export.gained import (
    Gained,
    Rows,
    Words,
    by_stays,
    gained_loop,
    state_of,
    whole_rows,
    within,
    within_proof,
)
from lure.analysis.export.quadratic import Matrix, bilinear, nonnegative
from lure.analysis.export.words import folded, integers, number, reals, refused, whole_file
from lure.arrays import in_doubles, np

BITS = (24, 40, 64, 96, 128, 192)
MOST_ORDER, MOST_SCALE = 6, 256
LIBRARIES = ("forms.v", "flow.v", "frequencies.v", "orbits.v", "switching.v")


def switched_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by gains that repeat, in discrete time.

    ``x'Q_i x`` with ``Q_i = A_i'Q_(i+1) A_i + 1`` around the period falls at each step; it is negative somewhere, since
    an eigenvalue of the period is outside the unit circle.

    Raises
    ------
    refused
        An ``InputError``: it is of matrices or a rate, or no ``Q`` of few enough digits was found.
    """
    system = data["system"]
    if system["kind"] != "transfer":
        return turned_words(data).text(claim, data["proof"]["method"])
    family = classes(data["laws"])
    low, high = max(family.sector[0], family.slope[0]), min(family.sector[1], family.slope[1])
    if INF in (abs(low), abs(high)):
        raise refused("its class has infinite bounds")
    top, den, _ = coefficients(system)
    num = [Fraction(0)] * (len(den) - len(top[0][1])) + top[0][1]
    gains = numbers(data["proof"]["gains"])
    found = falling_forms([_companion(num, den, g) for g in gains])
    bounds, distinct, n, p = f"{number(low)} <= g t <= {number(high)}", sorted(set(gains)), len(found.start), len(gains)
    each, number_of = bounds.replace("g t", "g"), "change (length gains) with"
    lines = [
        "Theorem moves : exists (g : nat -> R) (xi : nat -> R),",
        f"  (forall t, {bounds}) /\\",
        "  (forall t, shifts den xi t = - (g t * shifts num xi t)) /\\",
        "  forall c, ~ Un_cv xi c.",
        "Proof.",
        "  exists (repeated gains), (sampled num den (repeated gains) start); split; [|split].",
        f"  - intro t; apply (repeated_all (fun g => {each})); [discriminate|].",
        "    unfold gains; repeat (apply Forall_cons; [lra|]); apply Forall_nil.",
        "  - intro t; apply run_solves; try discriminate; try reflexivity.",
        "    apply (repeated_all (fun g => hd 0 den + g * hd 0 num <> 0)); [discriminate|].",
        "    unfold gains, num, den; cbn [hd]; repeat (apply Forall_cons; [lra|]); apply Forall_nil.",
        f"  - apply (switched num den (repeated gains) start {found.N} {found.K} phases);",
        "      try discriminate; try exact grow.",
        f"    + intros t s L; unfold repeated, phase_at; {number_of} {p}%nat; change (length phases) with {p}%nat.",
        f"      set (r := (t mod {p})%nat).",
        f"      assert (small : (r < {p})%nat) by (apply Nat.mod_upper_bound; discriminate).",
        "      clearbody r; unfold phases, gains.",
        *(f"      destruct r as [|r]; [cbn [nth]; exact (step{distinct.index(g)} s L)|]." for g in gains),
        "      exfalso; lia.",
        "    + unfold V, start, phase_at, phases.",
        "      cbn [length Nat.modulo Nat.divmod Nat.sub nth fst snd map dot sumprod]; lra.",
        "Qed.",
    ]
    parts = [reals(name, side) for name, side in (("num", num), ("den", den), ("gains", gains))]
    for j, g in enumerate(distinct):
        parts += _one_step(j, g, found.next[gains.index(g)], n)
    parts += found.told([f"next{distinct.index(g)}" for g in gains])
    return whole_file(claim, "counterexample, switched-gain", LIBRARIES, ["\n".join(parts), "\n".join(lines)])


def _one_step(j: int, gain: Fraction, rows: tuple[int, Rows], n: int) -> list[str]:
    """The lemma that its rows are one step with this gain."""
    return [
        folded(f"Definition next{j} : list (list Z) := {integers(rows[1])}%Z."),
        f"Lemma step{j} : forall s, length s = {n}%nat ->",
        f"  at_ next{j} s = map (Rmult {rows[0]}) (step num den {number(gain)} s).",
        "Proof.",
        f"  intros s L; do {n} (destruct s as [|? s]; [discriminate|]); destruct s; [|discriminate].",
        f"  unfold at_, next{j}, step, num, den; cbn [map dot tl app last_dot length nth hd].",
        "  repeat (apply (f_equal2 cons); [field|]); reflexivity.",
        "Qed.",
    ]


def _companion(num: list[Fraction], den: list[Fraction], g: Fraction) -> Matrix:
    """The next samples of ``den xi = -g num xi``."""
    closed = [a + g * b for a, b in zip(den, num, strict=True)]
    n = len(den) - 1
    shifted = [[Fraction(j == i + 1) for j in range(n)] for i in range(n - 1)]
    return [*shifted, [-v / closed[0] for v in closed[:0:-1]]]


@dataclass(frozen=True, kw_only=True)
class Falling:
    """Of each step ``d`` and the rows of ``d`` times what follows; ``Q`` of each, where the first is negative."""

    next: list[tuple[int, Rows]]
    Q: list[Rows]
    start: list[int]
    N: int
    K: int

    def told(self, rows: Sequence[str]) -> list[str]:
        """The start and the steps, the rows of each being told, and that the forms fall."""
        places = (f"({d}, ({row}, {integers(Q)}))" for (d, _), row, Q in zip(self.next, rows, self.Q, strict=True))
        return [
            folded(f"Definition start : list R := {integers(self.start)}."),
            folded(f"Definition phases : list phase := [{'; '.join(places)}]%Z."),
            f"Lemma grow : grows {len(self.start)} {self.N} {self.K} phases = true.",
            "Proof. vm_cast_no_check (eq_refl true). Qed.",
        ]


def falling_forms(steps: Sequence[Matrix]) -> Falling:
    """Forms that fall around the period of some matrices in turn.

    Raises
    ------
    refused
        An ``InputError``: none of few enough digits was found.
    """
    n = len(steps[0])
    if not 0 < n <= MOST_ORDER:
        raise refused(f"its plant has the order {n}, not within 1 and {MOST_ORDER}")
    rows = [whole_rows(A) for A in steps]
    matrices = [fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in A]) for A in steps]
    exact = _around(matrices, n)
    size = max(abs(v) for Q in exact for row in Q for v in row)
    for bits in BITS:
        found = [[[round(v * 2**bits / size) for v in row] for row in Q] for Q in exact]
        start, scales = negative(found[0]), _scales(found, rows, n)
        if start and scales:
            return Falling(next=rows, Q=found, start=start, N=scales[0], K=scales[1])
    raise refused("no forms of few enough digits were found that fall around the period of its gains")


def _around(steps: list[fmpq_mat], n: int) -> list[list[list[Fraction]]]:
    """``Q_i = A_i'Q_(i+1) A_i + 1`` of each step, the first again after the last.

    Raises
    ------
    refused
        An ``InputError``: there is none, as two eigenvalues of the period have the product 1.
    """
    unit = fmpq_mat([[fmpq(int(i == j)) for j in range(n)] for i in range(n)])
    M, rest = unit, fmpq_mat(n, n)
    for A in steps:
        rest += M.transpose() * M
        M = A * M
    # Q = M'QM + rest, entry by entry
    places = [(i, j) for i in range(n) for j in range(n)]
    left = fmpq_mat([[int((i, j) == (k, m)) - M[k, i] * M[m, j] for k, m in places] for i, j in places])
    if not left.det():
        raise refused("two eigenvalues of the period of its gains have the product 1")
    solved = left.solve(fmpq_mat([[rest[i, j]] for i, j in places]))
    Q, found = fmpq_mat([[solved[i * n + j, 0] for j in range(n)] for i in range(n)]), list[fmpq_mat]()
    for A in reversed(steps):
        Q = A.transpose() * Q * A + unit
        found.append(Q)
    return [[[Fraction(int(Q[i, j].p), int(Q[i, j].q)) for j in range(n)] for i in range(n)] for Q in reversed(found)]


def negative(Q: Rows) -> list[int]:
    """Whole numbers where a form is negative, none if they were not found."""
    _, vectors = np.linalg.eigh(in_doubles(Q))
    for digits in (2, 4, 8, 12, 15):
        v = [round(float(x) * 10**digits) for x in vectors[:, 0]]
        if sum(a * b * q for a, row in zip(v, Q, strict=True) for b, q in zip(v, row, strict=True)) < 0:
            return v
    return []


def _scales(Q: list[Rows], steps: list[tuple[int, Rows]], n: int) -> tuple[int, int] | None:
    """``N`` and ``K``: ``N`` times each fall is above the squares, and each form above ``-K`` times them."""
    falls, least = [], []
    for i, (d, rows) in enumerate(steps):
        now = [[d * (a == b) for b in range(n)] for a in range(n)]
        squares = [(1, row, row) for row in now]
        falls.append(([*bilinear(Q[i], now, now), *bilinear(Q[(i + 1) % len(Q)], rows, rows, -1)], squares))
        least.append((bilinear(Q[i], now, now), squares))
    scales = [1 << power for power in range(0, MOST_SCALE, 4)]
    N = (
        s
        for s in scales
        if all(nonnegative([*((s * c, u, v) for c, u, v in V), *((-c, u, v) for c, u, v in S)], n) for V, S in falls)
    )
    K = (s for s in scales if all(nonnegative([*V, *((s * c, u, v) for c, u, v in S)], n) for V, S in least))
    first, second = next(N, 0), next(K, 0)
    return (first, second) if first and second else None


# The same of a plant in states.


def turned_words(data: Mapping[str, Any]) -> Words:
    """The file of a plant that is given by matrices."""
    loops = gained_loop(data)
    found, lists = falling_forms(loops.matrices), [f"gains{i}" for i in range(len(loops.bounds))]
    parts = [reals(name, list(side)) for name, side in zip(lists, zip(*loops.gains, strict=True), strict=True)]
    parts += [*found.told([integers(rows) for _, rows in found.next]), loops.outputs()]
    first = turned_proof(found, [f"(repeated {name})" for name in lists])
    return Words(
        libraries=LIBRARIES, loops=loops, parts=["\n".join(parts)], kind="nat -> R",
        gains=[f"(forall t, {text})" for i, ends in enumerate(loops.bounds) if (text := within(f"g{i} t", ends))],
        laws=[f"g{b} t *" for b in loops.block], end=f"forall B, ~ (forall t, norm2 {state_of(len(found.start))} <= B)",
        proof=[*first, *within_proof(loops.bounds), *turned_ends(loops, lists)],
    )  # fmt: skip


def turned_proof(found: Falling, gains: Sequence[str]) -> list[str]:
    """The beginning of a proof by forms that fall, in discrete time: the gains, the states and the values."""
    n = len(found.start)
    row = f"nth (t mod {len(found.Q)})%nat values (1%Z, [])"
    return [
        "Proof.",
        "  assert (neg : V (snd (snd (phase_at phases 0))) start < 0).",
        "  { unfold V, start, phase_at, phases.",
        "    cbn [length Nat.modulo Nat.divmod Nat.sub nth fst snd map dot sumprod]; lra. }",
        f"  destruct (turned {n} {found.N} {found.K} phases start ltac:(discriminate) eq_refl grow eq_refl neg)"
        " as [x [F U]].",
        f"  exists {', '.join(gains)}, x, (fun i t => let v := {row} in"
        f" dot (nth i (snd v) []) (listed {n} (fun i => x i t)) / IZR (fst v)).",
    ]


def turned_ends(loops: Gained, lists: Sequence[str]) -> list[str]:
    """The end of that proof: values, states, and that these are not bounded."""
    p, own = len(loops.matrices), ["phases", "values", *lists]
    opened = [
        "unfold phase_at, repeated, listed.",
        *(f"change (length {name}) with {p}%nat." for name in own),
        f"set (r := (t mod {p})%nat); unfold {', '.join(own)}; cbn [seq map].",
        *by_stays(p, ["cbn [nth fst snd dot]; lra"] * p),
    ]
    starts = ["cbv zeta"] * len(loops.block) + [
        f"rewrite (F {k}%nat t) by lia; cbv zeta" for k in range(len(loops.plant.A))
    ]
    lines = []
    for start in starts:
        lines += [f"  split; [intro t; {start}|].", "  {", *(f"    {line.strip()}" for line in opened), "  }"]
    return [*lines, "  exact U.", "Qed."]
