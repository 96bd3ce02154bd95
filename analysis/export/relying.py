"""A frequency inequality, proved in Coq, and what follows by a theorem relied on: `frequencies.v`, `cones.v`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from typing import Any

from lure.analysis.certificates import arithmetic as exact
from lure.analysis.certificates.arithmetic import INF, Form, number, real
from lure.analysis.certificates.blocks import block, coefficients, multiplier, realised, shifted
from lure.analysis.certificates.channels import triangle
from lure.analysis.certificates.checker import SLOPED, inequality
from lure.analysis.certificates.riccati import Lyapunov
from lure.analysis.certificates.states import Family, classes
from lure.analysis.export.circle import FINEST, Circle, tree
from lure.analysis.export.quadratic import bilinear, nonnegative, rounded, semidefinite, whole
from lure.analysis.export.waves import GRID, Waves
from lure.analysis.export.words import folded, integers, reals, refused, whole_file
from lure.analysis.export.words import number as written
from lure.arrays import in_doubles, np

THEOREMS = {
    "off-axis-circle": "off_axis_circle_criterion",
    "park": "park_criterion",
    "zames-falb": "zames_falb_theorem",
    "order-cone": "order_cone_criterion",
    "tsypkin": "tsypkin_criterion",
    "tsypkin-odd": "tsypkin_criterion_for_odd",
    "jury-lee": "jury_lee_criterion",
}
MOST_ORDER = 12
MOST_REACH = 14  # complex powers are written out: 20 s of Coq


def relying_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of a criterion with a multiplier.

    Raises
    ------
    refused
        An ``InputError``: it is not covered.
    """
    if data["multiplier"].get("window") == []:  # taps alone
        data = {**data, "theorem": "zames-falb", "multiplier": {"taps": data["multiplier"]["taps"]}}
    return Relying(data).text(claim)


class Relying:
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.name, self.data, self.given = data["theorem"], data, data["multiplier"]
        self.before: list[str] = []
        self.beyond: list[str] = []
        self.family: Family = classes(data["laws"])
        top, self.den, self.discrete = coefficients(data["system"])
        self.num, self.order = top[0][1], len(self.den) - 1
        self.low, self.high = self.family.slope if self.name in SLOPED else self.family.sector
        if INF in (abs(self.low), abs(self.high)) or self.family.rough:
            raise refused("its class has infinite bounds, or nonlinearities that jump; certify one with finite bounds")
        if not 0 < self.order <= MOST_ORDER:
            raise refused(f"its plant has the order {self.order}, not within 1 and {MOST_ORDER}")
        kernels = self.given.get("kernels", [])
        self.delayed = any("delay" in one for one in kernels)
        if self.delayed and not all("delay" in one for one in kernels):
            raise refused("its multiplier has kernels that are delays and others")
        reach = sum(k.get("order", 0) for k in kernels)
        if self.order + reach > MOST_REACH:
            raise refused(f"order and kernels of its multiplier add up to {self.order + reach}, above {MOST_REACH}")
        stepped = (
            self.name in ("tsypkin", "tsypkin-odd", "jury-lee", "order-cone")
            or Fraction(self.given.get("theta", "0")) != 0
        )
        if stepped and len(self.num) == len(self.den):
            raise refused("its block has a feedthrough, which the export of this criterion does not cover")

    def text(self, claim: str) -> str:
        """The whole file."""
        first = "\n".join([*self.plant(), *self.cones(), *self.witness(), *self.lemmas()])
        libraries = ["forms.v", "flow.v", "frequencies.v", *["pieces.v", "waves.v"] * self.delayed]
        libraries += ["cones.v", "orders.v", "circle.v"] * self.by_circle + self.beyond
        return whole_file(claim, self.origin, libraries, [first, "\n".join(self.theorem())])

    @property
    def by_circle(self) -> bool:
        """Whether the inequality is shown on the unit circle, of a polynomial that Coq computes."""
        return self.discrete and self.name in ("zames-falb", "order-cone")

    @property
    def origin(self) -> str:
        """The theorem and the method of the certificate."""
        return f"{self.name}, {self.data['proof']['method']}"

    def plant(self) -> list[str]:
        """The plant."""
        return [reals("num", self.num), reals("den", self.den)]

    def lemmas(self) -> list[str]:
        """What is proved: where the poles are, and the inequality."""
        low, high = written(self.low), written(self.high)
        poles = f"in_{'unit_disc' if self.discrete else 'left_half_plane'} (closed num den {low})"
        point = "circle" if self.discrete else "axis"
        shown = self.on_circle if self.by_circle else self.frequencies
        proof = (self.by_intervals if self.delayed else shown)()
        lines = [f"Lemma poles : {poles}.", *self.poles(), "", *self.before]
        return [*lines, f"Lemma frequencies : over_frequencies {point} {self.E} num den {low} {high}.", *proof]

    def theorem(self) -> list[str]:
        """What follows by the criterion."""
        low, high = written(self.low), written(self.high)
        kind = "nat -> R" if self.discrete else "nat -> R -> R"
        loop, end = ("steps_of", "Un_cv xi 0") if self.discrete else ("flow_of", "all_tend_to_0 den xi")
        class_ = self.classes()
        theorem = THEOREMS[self.name] + "_in_steps" * (self.name == "zames-falb" and self.discrete)
        theorem += "_for_delays" * self.delayed
        lines = [f"Theorem stable : {theorem} -> forall (phi : R -> R) (xi : {kind}),"]
        lines += [f"  {' -> '.join(class_)} -> {loop} num den phi xi -> {end}.", "Proof."]
        names = [f"class{i}" for i in range(len(class_))]
        lines.append(f"  intros relied phi xi {' '.join(names)} solution.")
        more = [str(self.odd).lower()] * bool(self.cones())
        arguments = " ".join([*self.parameters, *more, "phi xi"])
        known = "try exact poles; try exact frequencies;" + " try exact cones;" * len(more)
        lines += [f"  apply (relied num den {low} {high} {arguments});", f"    {known}"]
        lines += ["    try assumption; unfold proper, num, den, rates, mass; simpl; repeat split; try lra; try lia."]
        return [*lines, *self.rest(), "Qed."]

    @property
    def odd(self) -> bool:
        """Whether odd nonlinearities are needed."""
        return bool(self.given.get("odd")) or any(v < 0 for v in self.masses)

    def cones(self) -> list[str]:
        """That the form of an order cone is nonnegative on all samples of the class."""
        if self.name != "order-cone":
            return []
        M, _ = window_of(self.given["window"])
        low, high, odd = written(self.low), written(self.high), bool(self.given["odd"])
        count, held = len(M) // 2, f"slope_class {str(self.odd).lower()} {low} {high} f"
        stated = f"forall f, {held} -> nonneg_on_samples M {count} {low} {high} f"
        ends = "[exact orders_hold|exact Z|exact S" + "|exact (O eq_refl)]" * odd + "]" * (not odd)
        return [
            folded(f"Definition M : list (list Z) := {integers(M)}%Z."),
            folded(f"Definition parts : list halves := {witnesses(M, odd=odd)}%Z."),
            f"Lemma orders_hold : all_positive M {count} (cases {str(odd).lower()} {count}) parts = true.",
            "Proof. vm_cast_no_check (eq_refl true). Qed.",
            f"Lemma cones : {stated}.",
            f"Proof. intros f [Z [S O]]; apply ({'odd_' * odd}orders_sound M {count} parts); {ends}. Qed.",
        ]

    @property
    def parameters(self) -> list[str]:
        """The numbers of the multiplier."""
        keys = {"off-axis-circle": ("alpha",), "park": ("theta", "tau")}.get(self.name, ("q",))
        if self.name not in ("zames-falb", "order-cone"):
            return [written(number(self.given[key])) for key in keys]
        if self.discrete:
            taps = [(number(c), abs(i), i > 0) for i, c in self.given["taps"]]
            listed = "[" + "; ".join(f"({written(c)}, {i}%nat, {str(k).lower()})" for c, i, k in taps) + "]"
            if self.name == "zames-falb":
                return [listed]
            M, q = window_of(self.given["window"])
            return [written(q), "M", f"{len(M) // 2}%nat", listed]
        if self.delayed:
            pairs = (
                f"({written(number(k['coefficient']))}, {written(number(k['delay']))})" for k in self.given["kernels"]
            )
            return [written(number(self.given["theta"])), f"[{'; '.join(pairs)}]"]
        found = [(number(k["coefficient"]), number(k["rate"]), k["order"], k["side"]) for k in self.given["kernels"]]
        words = (f"({written(c)}, {written(a)}, {n}%nat, {str(side == 'causal').lower()})" for c, a, n, side in found)
        return [written(number(self.given["theta"])), f"[{'; '.join(words)}]"]

    @property
    def E(self) -> str:
        """What is to be positive."""
        words = " ".join(self.parameters)
        if self.name in ("off-axis-circle", "park"):
            return f"(with_multiplier ({'park' if self.name == 'park' else 'off_axis'} {words}))"
        if self.name == "zames-falb":
            return f"(with_multiplier (zames_falb{'_steps' * self.discrete}{'_delays' * self.delayed} {words}))"
        return f"({self.name.replace('-', '_')} {words})"

    def classes(self) -> list[str]:
        """What the theorem says of the nonlinearities."""
        low, high = written(self.low), written(self.high)
        if self.name == "order-cone":
            return [f"slope_class {str(self.odd).lower()} {low} {high} phi"]
        if self.name in SLOPED:
            odd = self.name == "zames-falb" and any(v < 0 for v in self.masses)
            return ["phi 0 = 0", f"slopes_in {low} {high} phi", *["odd phi"] * odd]
        class_ = {"tsypkin": "rises", "tsypkin-odd": "rises_and_odd"}.get(self.name, "rises_less")
        return [f"in_sector {low} {high} phi", "locally_lipschitz phi", f"{class_} {low} {high} phi"]

    @property
    def masses(self) -> list[Fraction]:
        """Of the kernels."""
        if self.discrete:
            return [number(c) for _, c in self.given.get("taps", [])]
        return [number(k["coefficient"]) for k in self.given.get("kernels", [])]

    def rest(self) -> list[str]:
        """What is left to say of the kernels."""
        lines = []
        if self.name == "park":
            lines.append("  all: try (left; lia).")
        if self.name in ("zames-falb", "order-cone"):
            signed = ((written(v), "Rabs_left" if v < 0 else "Rabs_right") for v in self.masses)
            signs = "".join(f"rewrite ({rule} {v}) by lra; " for v, rule in signed)
            lines += [
                f"  all: try (left; lia); try (right; lra); try ({signs}lra).",
                "  all: try (right; assumption); try (left; repeat constructor; simpl; lra).",
                "  all: repeat constructor; simpl; try lra; try lia; try discriminate.",
            ]
        return lines

    def witness(self) -> list[str]:
        """``P`` of Lyapunov's equation, and its test."""
        n, padded = self.order, [Fraction(0)] * (len(self.den) - len(self.num)) + self.num
        d, _ = whole([u + self.low * v for u, v in zip(self.den, padded, strict=True)][::-1])
        units = [[int(i == j) for j in range(n + 1)] for i in range(n + 1)]
        now, then = units[:-1], units[1:]
        for P in self._lyapunov():
            base = bilinear(P, now, now)
            falls = [*bilinear(P, now, then, -1), *bilinear(P, then, now, -1)]
            if self.discrete:
                falls = [*base, *bilinear(P, then, then, -1)]
            if not nonnegative(base, n + 1):
                continue
            for power in range(0, 400, 4):
                terms = [*falls, (1 << power, d, d), *((-1, f, f) for f in now)]
                if nonnegative(terms, n + 1):
                    self.d = d
                    lists = [("P", P), ("now", now), ("next", then)]
                    test = f"stable_test {str(self.discrete).lower()} {n + 1} P now next bottom {1 << power} 1"
                    return [
                        *(folded(f"Definition {name} : list (list Z) := {integers(rows)}%Z.") for name, rows in lists),
                        folded(f"Definition bottom : list Z := {integers(d)}%Z."),
                        f"Lemma falls : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.",
                    ]
        raise refused("no solution of Lyapunov's equation of few enough digits was found for its poles")

    def _lyapunov(self) -> Iterator[list[list[int]]]:
        """Solutions with integers, from doubles."""
        A, *_ = realised(self.data["system"], self.low)
        matrix = in_doubles(A)
        found = Lyapunov.of(matrix, discrete=self.discrete).solution(np.eye(len(A)))
        if not np.all(np.isfinite(found)):
            return
        P = [[Fraction(float(v)) for v in row] for row in found]
        for bits in (16, 32, 64):
            near = rounded(P, bits)
            unit = math.lcm(*(v.denominator for row in near for v in row))
            for more in (1, 1 << 8, 1 << 16):
                yield [[int(v * unit * more) for v in row] for row in near]

    def poles(self) -> list[str]:
        """The proof that all roots are inside."""
        n = self.order
        opened = "cbn [map cpow cmul cadd real horner poly closed dot at_ lcomb fst snd now next bottom num den]"
        powers = "; ".join(f"cpow (x, y) {k}" for k in range(n + 1))
        q = Fraction(self.d[-1]) / (self.den[0] + (self.low * self.num[0] if len(self.num) == len(self.den) else 0))
        lines = ["Proof.", f"  intros [x y] H; set (s := (x, y)); set (pw := [{powers}])."]
        for part, name in (("fst", "H1"), ("snd", "H2")):
            value = f"{part} (closed num den {written(self.low)} (x, y))"
            lines.append(f"  assert ({name} : {value} = 0) by (rewrite H; reflexivity).")
        sides = f"{str(self.discrete).lower()} {n + 1} P now next bottom _ _ (map fst pw) (map snd pw)"
        lines.append(f"  apply (roots {sides} s falls);")
        lines.append("    try reflexivity; unfold s, pw, closed, poly, num, den, bottom, now, next, at_ in *.")
        for name in ("H1", "H2"):
            lines.append(f"  - apply Rmult_eq_compat_l with (r := {written(q)}) in {name}.")
            lines.append(f"    rewrite Rmult_0_r in {name}; rewrite <- {name}; {opened}; field.")
        lines.append(f"  - exists ({integers([1] + [0] * n)}%Z); split; [left; reflexivity|{opened}; ring].")
        lines += [f"  - {opened}; repeat (apply (f_equal2 cons); [ring|]); reflexivity."] * 2
        return [*lines, "Qed."]

    def frequencies(self) -> list[str]:
        """The proof that the inequality holds with some room."""
        F, p, square = self._form()
        for power in range(4, FINEST, 2):
            room = Fraction(1, 1 << power)
            left = F + real(-room) * p * square
            P = left.part()
            full = len(P) == len(F.part())
            if full and exact.positive(P):
                break
        else:
            raise refused("its inequality leaves no room that can be told")
        even = not any(P[1::2])
        whole_, q = whole(P[::2] if even else P)
        grown = tree(whole_)
        x = "(w * w)" if even else "w"
        below = [*p.part()] if not self.discrete else (p * (real(1, 0, 1) ** self.order)).part()
        bottom = " + ".join(f"{written(c)} * w ^ {i}" for i, c in enumerate(below) if c)
        opened = (
            "unfold over_frequencies, with_multiplier, tsypkin, tsypkin_odd, jury_lee, off_axis, park, zames_falb, "
            "closed, poly, square, axis, circle, num, den"
        )
        cbn = "cbn [kernels lag cpow cmul cadd conj_ real re horner peval fst snd circle]"
        lines = [
            "Proof.",
            f"  exists {written(room)}; split; [lra|]; intros w Hw.",
            "  assert (W : 0 <= w * w) by nra.",
        ]
        lines.append(f"  pose proof (positive_sound {grown} {integers(whole_)}%Z {x} (eq_refl true) ltac:(lra)) as p.")
        lines.append(f"  assert (B : 0 < {bottom}) by (simpl; nra).")
        lines.append("  apply Rminus_le; apply Ropp_le_cancel; rewrite Ropp_0.")
        lines.append("  match goal with |- 0 <= ?g =>")
        lines.append(f"    replace g with (peval {integers(whole_)}%Z {x} / ({written(q)} * ({bottom}))) end.")
        lines.append("  { left; apply Rdiv_lt_0_compat; [exact p|apply Rmult_lt_0_compat; [lra|exact B]]. }")
        lines.append(f"  {opened}; {cbn}.")
        lines.append("  field; repeat split; simpl; nra.")
        return [*lines, "Qed."]

    def by_intervals(self) -> list[str]:
        """The same beside delays, on intervals and beyond."""
        F, p, square = self._form()
        for power in range(16, FINEST, 16):
            room = Fraction(1, 1 << power)
            found = Waves.of(F + real(-room) * p * square)
            if (witness := found.found()) is not None:
                break
        else:
            raise refused("its inequality leaves no room that can be told")
        self.before = [*found.definitions(*witness)]
        factor = found.factor * Fraction(p.part()[0])
        lines = [
            "Proof.",
            f"  exists {written(room)}; split; [lra|]; intros w Hw.",
            f"  pose proof (everywhere_sound _ {found.q} _ _ _ _ 0 ltac:(lra) inside ({GRID} * w) ltac:(lra)) as B.",
            "  unfold still, waves_ in B; cbn [waves peval] in B.",
        ]
        for (k, *_), tau in zip(found.terms, found.delays, strict=True):
            lines.append(f"  replace ({k} / {found.q} * ({GRID} * w)) with ({written(tau)} * w) in B by field.")
        lines.append("  apply Rminus_le; apply Ropp_le_cancel; rewrite Ropp_0.")
        lines.append(
            "  unfold over_frequencies, with_multiplier, zames_falb_delays, closed, poly, square, axis, num, den."
        )
        lines.append("  cbn [delays cmul cadd conj_ real re horner fst snd].")
        for tau in sorted({number(k["delay"]) for k in self.given["kernels"]}):
            if tau < 0:
                lines.append(f"  replace ({written(tau)} * w) with (- ({written(-tau)} * w)) by field.")
        lines += [
            "  rewrite ?cos_neg, ?sin_neg; match type of B with 0 <= ?b =>",
            f"    match goal with |- 0 <= ?g => replace g with (/ {written(factor)} * b) end end.",
            "  { apply Rmult_le_pos; [lra|exact B]. }",
            "  field.",
        ]
        return [*lines, "Qed."]

    def on_circle(self) -> list[str]:
        """The same by a polynomial that Coq computes."""
        padded = [Fraction(0)] * (len(self.den) - len(self.num)) + self.num
        X, D = ([u + g * v for u, v in zip(self.den, padded, strict=True)] for g in (self.high, self.low))
        taps = [(number(c), abs(i), i > 0) for i, c in self.given["taps"]]
        window = window_of(self.given["window"]) if self.name == "order-cone" else ([], 1)
        found = Circle.of(X, D, taps, window)
        opened = "unfold closed, poly, num, den, closed_k, closed_l; intros [x y]"
        opened += "; apply injective_projections; cbn [power_sum horner length cpow cadd cmul real fst snd]; field"
        tap = "unfold kernel_; cbn [map tap_of]"
        self.before = found.definitions()
        return [
            "Proof.",
            *(["  apply (taps_alone 1)."] if self.name == "zames-falb" else []),
            f"  replace {self.parameters[-1]} with (map (tap_of {found.h}) kernel_)",
            f"    by ({tap}; repeat (apply same_tap; [field|]); reflexivity).",
            f"  refine (circle_sound {found.test()} num den _ _ {written(found.factor)} _ _ _ _).",
            "  - vm_cast_no_check (eq_refl true).",
            "  - lra.",
            f"  - {opened}.",
            f"  - {opened}.",
            "Qed.",
        ]

    def _form(self) -> tuple[Form, Form, Form]:
        """``F``, ``p`` and ``|D|^2``: ``F/(p |D|^2)`` is what is positive."""
        B = block(self.data["system"])
        F, *_ = inequality(self.name, self.given, B, self.family)
        d, critical, _ = shifted(B, Fraction(self.low))
        if critical:
            raise refused("its loop has a pole at 0 with the smallest gain")
        _, p, *_ = multiplier(self.name, self.given, B, unbounded=False)
        return F, p, d * d.conjugate()


# That a form of samples is nonnegative for all orders of the samples, in the words of Coq: `cones.v`, `orders.v`.

Whole = list[list[int]]
DEEPEST = 40


def window_of(given: list[list[str]]) -> tuple[Whole, int]:
    """The form of a certificate, a lower triangle, with integers, and what it was multiplied by."""
    M = triangle(given, len(given))
    entries, q = whole([v for row in M for v in row])
    return [entries[i : i + len(M)] for i in range(0, len(entries), len(M))], q


def witnesses(M: Whole, *, odd: bool) -> str:
    """For each order a subdivision of its cone, on the parts of which ``M`` is ``N + S``: a list of ``halves``.

    Raises
    ------
    refused
        An ``InputError``: ``M`` leaves too little room.
    """
    count = len(M) // 2
    found = []
    for signs, order in _cases(count, odd=odd):
        at = {i: order.index(i) for i in range(count + 1)}
        rows = [[signs[i - 1] * ((h < at[i]) - (h < at[0])) for h in range(count)] for i in range(1, count + 1)]
        rows = [[*row, *[0] * count] for row in rows] + [[*[0] * count, *row] for row in rows]
        found.append(halves(_seen(M, rows)))
    return f"[{'; '.join(found)}]"


def _seen(M: Whole, rows: Whole) -> Whole:
    """``rows' M rows``."""
    left = [[sum(v * row[j] for v, row in zip(line, rows, strict=True)) for j in range(len(rows[0]))] for line in M]
    size = range(len(rows[0]))
    return [[sum(row[i] * other[j] for row, other in zip(rows, left, strict=True)) for j in size] for i in size]


def halves(C: Whole, depth: int = 0) -> str:
    """A subdivision of ``x >= 0`` into cones on which ``x'Cx`` is seen to be nonnegative, as Coq's ``halves``.

    ``C``: symmetric, copositive; ``depth``: how often a cone was halved.

    Raises
    ------
    refused
        An ``InputError``: ``C`` leaves too little room.
    """
    size = range(len(C))
    upper = [[2 * v for v in row[i:]] for i, row in enumerate(C)]
    if semidefinite([[a, *(min(v, 0) for v in rest)] for a, *rest in upper]):
        return "(Leaf [" + "; ".join(f"(0, {integers([max(v, 0) for v in rest])})" for _, *rest in upper) + "])"
    if depth == DEEPEST or min(C[i][i] for i in size) < 0:
        raise refused("its form of several samples leaves too little room")
    i, j = min(
        ((i, j) for i in size for j in range(i)),
        key=lambda pair: Fraction(
            C[pair[0]][pair[1]] * abs(C[pair[0]][pair[1]]), 1 + C[pair[0]][pair[0]] * C[pair[1]][pair[1]]
        ),
    )
    parts = []
    for kept, moved in ((i, j), (j, i)):  # e_moved gives way to e_kept + e_moved
        rows = [[int(a == b) + int(a == kept and b == moved) for b in size] for a in size]
        parts.append(halves(_seen(C, rows), depth + 1))
    return f"(Halve {i} {j} {' '.join(parts)})"


def _cases(count: int, *, odd: bool) -> Iterator[tuple[list[int], list[int]]]:
    """Signs and orders, one after the other as ``cases`` of the Coq files has them."""
    if not odd:
        yield from (([1] * count, p) for q in _orders(count) for p in _insertions(0, q))
        return
    for signs in product((1, -1), repeat=count):
        yield from (([*signs], [0, *p]) for p in _orders(count))


def _orders(count: int) -> list[list[int]]:
    """All orders of 1 to ``count``."""
    return [q for p in _orders(count - 1) for q in _insertions(count, p)] if count else [[]]


def _insertions(i: int, p: list[int]) -> list[list[int]]:
    """``p`` with ``i`` at each place."""
    return [[*p[:j], i, *p[j:]] for j in range(len(p) + 1)]
