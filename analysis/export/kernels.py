"""Multipliers with kernels of several channels in the words of Coq: `kernels.v`.

The inequality on the axis is one quadratic form in ``z``: the states, the inputs, and what the kernels make of ``a``
and ``b``, states too.  A symmetric ``P`` adds nothing there: ``2 Re i w x^* P x = 0`` (Kalman, Yakubovich, Popov).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from itertools import product, zip_longest
from typing import Any, NamedTuple

from flint import arb_mat

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.channels import channels, plant
from lure.analysis.certificates.frequencies import Kernel, multiplier, shifted
from lure.analysis.certificates.riccati import Lyapunov, stabilising
from lure.analysis.export.quadratic import (
    Matrix,
    Term,
    Vector,
    bilinear,
    less,
    mix,
    nonnegative,
    rounded,
    shortest,
    whole,
)
from lure.analysis.export.words import folded, integers, number, refused, whole_file
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import in_doubles, np

ROOMS = (16, 24, 32, 40, 48, 64)  # of which powers of 1/2 the room is that is tried
MOST_SIZE = 96
Rows = list[list[int]]


class _Lag(NamedTuple):
    """One number of ``v``: its derivative is ``scale`` times a row, of which a fact is known, and ``own`` times it."""

    place: int
    scale: int
    src: str
    fact: str
    own: int
    rate: str
    signal: str
    order: int
    factor: str

    @property
    def value(self) -> str:
        """What it is on the axis."""
        return f"cmul (cpow (lag {self.rate} w) {self.order + 1}) {self.signal}"


class Kernels:
    """The words of one file; ``z = (x, mu, v)``, ``v`` what the kernels make of ``a = phi - l sigma`` and ``b``."""

    beyond: tuple[str, ...] = ()
    about = ""

    def __init__(self, data: Mapping[str, Any]) -> None:
        if data["system"]["kind"] != "multivariable":
            raise refused("its plant has dead times, or unknown numbers; with kernels matrices have an export")
        self.H = H = plant(data["system"])
        self.n, self.m = len(H.A), len(H.D)
        asked = channels(data["laws"], self.m)
        functions = asked.blocks[: -1 if asked.performance else None]
        self.first = sum(map(len, functions))  # from which on channels lead from z to w
        families = asked.families[: self.first]
        if any(one.memory or one.varying or one.linear or one.rough or one.operator for one in families):
            raise refused("a channel is no function of sigma with slope bounds: with kernels no other has an export")
        self.of = [next(k for k, block in enumerate(asked.blocks) if i in block) for i in range(self.m)]
        self.ends = [asked.families[block[0]].slope for block in functions]
        self.ends += [asked.bounds(i) for i in (asked.performance or [])[:1]]
        bounds = [self.ends[k] for k in self.of]
        self.low, self.high = [low for low, _ in bounds], [high for _, high in bounds]
        given = multiplier(data["theorem"], data["multiplier"], self.m)
        self.gamma, self.theta = [row[i] for i, row in enumerate(given.gamma)], given.theta
        places = ((i, j) for i in range(self.m) for j in range(self.m) if i != j and given.gamma[i][j])
        self.kernels = [Kernel(i, j, -given.gamma[i][j], Fraction(1), 0, 1) for i, j in places] + given.kernels
        self.odd = any(k.coefficient < 0 for k in self.kernels)
        seen = [*enumerate(H.D)][: self.first]
        if any(any(row[i : self.first]) or (self.theta[i] and any(row)) for i, row in seen):
            raise refused(
                "with kernels sigma_i has to be given by states and the channels before it, beside theta by states"
            )
        if any(bound != asked.bounds(i) or INF in map(abs, bound) for i, bound in enumerate(bounds)):
            raise refused("with kernels the bounds of the sectors have to be those of the slopes, and finite")
        self.filters()
        self.rows()
        self.P, self.lyapunov = self.witness(), self.inside()

    def filters(self) -> None:
        """For each signal and rate the places in ``z`` of what the kernel of each order makes of it."""
        longest = dict[tuple[int, int, Fraction], int]()
        for i, j, _, a, order, side in self.kernels:
            if order:
                key = (side, j if side > 0 else i, a)
                longest[key] = max(order, longest.get(key, 0))
        self.place, at = dict[tuple[int, int, Fraction], list[int]](), self.n + self.m
        for key, order in longest.items():
            self.place[key] = list(range(at, at + order))
            at += order
        self.size = at
        if at > MOST_SIZE:
            raise refused(f"states, channels and what the kernels make of them are {at} numbers, above {MOST_SIZE}")

    def rows(self) -> None:
        """``a``, ``b``, ``s sigma`` and ``s x`` as whole rows, each times its number, and the terms of the form."""
        H, n, m = self.H, self.n, self.m
        inputs = [[Fraction(i == j) for j in range(n + m)] for i in range(n, n + m)]
        sigma, then = ([[*c, *d] for c, d in zip(*side, strict=True)] for side in ((H.C, H.D), (H.A, H.B)))
        a, b = (
            [mix([sign, sign * end], [mu, row]) for mu, row, end in zip(inputs, sigma, ends, strict=True)]
            for sign, ends in ((Fraction(-1), self.low), (Fraction(1), self.high))
        )
        self.a, self.b, self.s = ([whole(row) for row in side] for side in (a, b, [mix(c, then) for c in H.C]))
        feeds = [(self.b if side > 0 else self.a)[i][1] * a.denominator for side, i, a in self.place]
        self.unit = math.lcm(*(v.denominator for row in then for v in row), *feeds)
        self.x = [whole(row, self.unit)[0] for row in then]
        self.then = {k: row for k, row in enumerate(self.x)}
        for (side, i, rate), places in self.place.items():
            src, own = (self.b if side > 0 else self.a)[i], int(self.unit * rate)
            for k in places:
                self.then[k] = added([own // src[1] * v for v in src[0]], spot(k, -own))
                src = (spot(k, 1), 1)
        self.now = [spot(k, 1) for k in self.then]

    def terms(self) -> Iterator[tuple[Fraction, str, str]]:
        """Each product of the form: its factor, and its rows by name, ``a0``, ``b1``, ``s2``, or by place in ``z``."""
        for i, (gamma, theta) in enumerate(zip(self.gamma, self.theta, strict=True)):
            yield gamma, f"a{i}", f"b{i}"
            if theta:
                yield theta, f"a{i}", f"s{i}"
        for i, j, c, a, order, side in self.kernels:
            at = str(self.place[side, j if side > 0 else i, a][order - 1]) if order else ""
            yield -c, (at if at and side < 0 else f"a{i}"), (at if at and side > 0 else f"b{j}")

    def row(self, name: str) -> tuple[list[int], int]:
        """A row, and what it is multiplied by."""
        return (spot(int(name), 1), 1) if name.isdigit() else getattr(self, name[0])[int(name[1:])]

    def long(self, row: list[int]) -> list[int]:
        """A row over all of ``z``."""
        return [*row, *[0] * (self.size - len(row))]

    def witness(self) -> Rows:
        """``P`` as a lower triangle, each entry beside the diagonal twice, by ``scale``; and ``q`` and ``power``."""
        factors = [g / (self.row(u)[1] * self.row(v)[1]) for g, u, v in self.terms()]
        base = math.lcm(*(v.denominator for v in factors), *(alpha**2 for _, alpha in self.a), self.unit)
        now, then = ([self.long(row) for row in side] for side in (self.now, self.then.values()))
        for power in ROOMS:
            if (P := self.riccati(power)) is None:
                continue
            self.power, self.q, self.scale = power + 8, base << power + 16, base // self.unit
            held = [[round(v * 2 ** (power + 16)) for v in row] for row in P]
            scaled = [[v * self.scale for v in row] for row in held]
            terms = [*self.form(), *self.room(), *bilinear(scaled, now, then), *bilinear(scaled, then, now)]
            self.cut = shortest([(-c, u, v) for c, u, v in terms], self.size)
            if self.cut >= 0:
                return [[*(2 * v for v in row[:i]), row[i]] for i, row in enumerate(held)]
        raise refused("its inequality leaves no room that can be told")

    def form(self) -> list[Term]:
        """``q`` times the form."""
        rows = ((g, self.row(u), self.row(v)) for g, u, v in self.terms())
        return [(int(self.q * g / (alpha * beta)), self.long(u), self.long(v)) for g, (u, alpha), (v, beta) in rows]

    def room(self) -> list[Term]:
        """``q eps`` times the squares of ``a``."""
        return [((self.q >> self.power) // alpha**2, self.long(u), self.long(u)) for u, alpha in self.a]

    def riccati(self, power: int) -> Matrix | None:
        """``P`` with the room ``2^-power``; over ``(x, a, v)``: ``mu = -a - l sigma`` after the shift."""
        n, size, inner = self.n, self.size, range(self.n, self.n + self.m)
        _, _, C, D = shifted(self.H, self.low)
        turn = [[Fraction(i == j) for j in range(size)] for i in range(size)]
        for i, (c, d, low) in enumerate(zip(C, D, self.low, strict=True)):
            turn[n + i] = less(
                [*(-low * v for v in c), *(low * v for v in d), *[Fraction(0)] * (size - n - self.m)],
                Fraction(1),
                turn[n + i],
            )
        states = [k for k in range(size) if k not in inner]
        room = Fraction(1, 1 << power)
        Q = [[-(i == j) * room for j in range(size)] for i in range(size)]
        for g, *names in self.terms():
            u, v = (mix([Fraction(c, of) for c in self.long(row)], turn) for row, of in map(self.row, names))
            for i, j in product(*([k for k in range(size) if u[k] or v[k]] for _ in "ij")):
                Q[i][j] -= g * (u[i] * v[j] + u[j] * v[i]) / 2
        then = [mix([Fraction(c, self.unit) for c in self.long(row)], turn) for row in self.then.values()]
        sides = [
            [[row[j] for j in states] for row in then],
            [[-row[j] for j in inner] for row in then],
            [[-Q[i][j] for j in inner] for i in states],
            [[Q[i][j] for j in inner] for i in inner],
            [[-Q[i][j] for j in states] for i in states],
        ]
        with working_precision(max(128, 6 * power)), suppress(ArithmeticError, ValueError):
            lower = stabilising(*(arb_mat([[ball(v) for v in row] for row in side]) for side in sides))
            if lower is not None:
                return [[lower[max(i, j)][min(i, j)] for j in range(len(then))] for i in range(len(then))]
        return None

    def inside(self) -> tuple[Rows, int]:
        """A solution of Lyapunov's equation after the shift, whole, and how often the squares of ``a`` are added."""
        A, *_ = shifted(self.H, self.low)
        near = Lyapunov.of(in_doubles(A), discrete=False).solution(np.eye(self.n))
        size = self.n + self.m
        now, zero = [[*spot(k, 1), *[0] * (size - k - 1)] for k in range(self.n)], [u for u, _ in self.a]
        if np.all(np.isfinite(near)):
            for bits in (16, 32, 64):
                P = [
                    [int(v * 2**bits) for v in row]
                    for row in rounded([[Fraction(float(v)) for v in r] for r in near], bits)
                ]
                base, falls = bilinear(P, now, now), [*bilinear(P, now, self.x, -1), *bilinear(P, self.x, now, -1)]
                for power in range(0, 200, 8) if nonnegative(base, size) else ():
                    beside = [*((1 << power, u, u) for u in zero), *((-1, u, u) for u in now)]
                    if nonnegative([*falls, *beside], size):
                        return P, 1 << power
        raise refused("no solution of Lyapunov's equation of few enough digits was found for its poles")

    def text(self, claim: str) -> str:
        """The whole file."""
        shown = (self.definitions(), self.identities(), self.poles(), self.axis(), self.theorem())
        libraries = ("forms.v", "flow.v", "frequencies.v", "definite.v", "kernels.v", *self.beyond)
        origin = f"matrix-zames-falb{self.about}, determinant"
        return whole_file(claim, origin, libraries, ["\n".join(one) for one in shown])

    def definitions(self) -> list[str]:
        """The plant, the class and the multiplier, then what proves the inequality."""
        n, m = self.n, self.m
        named = dict[str, Rows | list[int]]({"P": self.P, "lyapunov": self.lyapunov[0]})
        for side, found in (("a", self.a), ("b", self.b), ("s", self.s)):
            named |= {f"{side}{i}": row for i, (row, _) in enumerate(found)}
        named |= {f"x{k}": row for k, row in enumerate(self.x)}
        lines = []
        for name, M in (("A", self.H.A), ("B", self.H.B), ("C0", self.H.C), ("D", self.H.D)):
            lines.append(f"Definition {name} : rows := [{'; '.join(reals_of(row) for row in M)}].")
        ends = "; ".join(f"({number(low)}, {number(high)})" for low, high in self.ends)
        lines += [
            f"Definition of : list nat := {integers(self.of)}%nat.",
            f"Definition ends : list (R * R) := [{ends}].",
            "Definition low (i : nat) : R := fst (nth (nth i of O) ends (0, 0)).",
            "Definition high (i : nat) : R := snd (nth (nth i of O) ends (0, 0)).",
            f"Definition gamma : list R := {reals_of(self.gamma)}.",
            f"Definition theta : list R := {reals_of(self.theta)}.",
        ]
        each = (
            f"(({k.row}%nat, {k.column}%nat), ({number(k.coefficient)}, {number(k.rate)}, {k.order}%nat, "
            f"{str(k.side > 0).lower()}))"
            for k in self.kernels
        )
        lines.append(f"Definition multiplier_ : list between := [{'; '.join(each)}].")
        for name, rows in named.items():
            kind = "list (list Z)" if isinstance(rows[0], list) else "list Z"
            value = f"map (scale {self.scale}) {integers(rows)}" if name == "P" else integers(rows)
            lines.append(f"Definition {name} : {kind} := ({value})%Z.")
        lines.append(f"Definition now : list (list Z) := [{'; '.join(f'spot {k} 1' for k in self.then)}].")
        then = [f"x{k}" for k in range(n)] + [
            f"add (scale {v.scale} {v.src}) (spot {v.place} ({v.own}))" for v in self.lags()
        ]
        lines.append(f"Definition next : list (list Z) := [{'; '.join(then)}]%Z.")
        for name, terms, words in (
            ("supply", self.form(), [(spelt(u), spelt(v)) for _, u, v in self.terms()]),
            ("room", self.room(), [(f"a{i}", f"a{i}") for i in range(m)]),
        ):
            listed = "; ".join(f"({c}, ({u}, {v}))" for (c, *_), (u, v) in zip(terms, words, strict=True))
            lines.append(f"Definition {name} : list term := [{listed}]%Z.")
        tests = (
            ("holds", f"on_axis {self.size} {self.cut} P now next supply room"),
            (
                "falls",
                f"inside_test {n + m} lyapunov (firstn {n} now) (firstn {n} next) {self.zero} {self.lyapunov[1]} 1",
            ),
        )
        for name, test in tests:
            lines.append(f"Lemma {name} : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.")
        return [folded(line) for line in lines]

    @property
    def zero(self) -> str:
        """The rows of ``a``."""
        return f"[{'; '.join(f'a{i}' for i in range(self.m))}]"

    def lags(self) -> Iterator[_Lag]:
        """What is known of each number of ``v``."""
        for (side, i, a), places in self.place.items():
            name, own = "b" if side > 0 else "a", int(self.unit * a)
            src, fact, factor = f"{name}{i}", f"{name.upper()}{i}", (self.b if side > 0 else self.a)[i][1]
            for order, k in enumerate(places):
                yield _Lag(k, own // factor, src, fact, -own, number(a), f"({name} {i}%nat)", order, number(factor))
                src, fact, factor = f"(spot {k} 1)", f"V{k}", 1

    @property
    def z(self) -> str:
        """States and inputs."""
        return " :: ".join([f"x {k}%nat" for k in range(self.n)] + [f"mu {i}%nat" for i in range(self.m)])

    def identities(self) -> list[str]:
        """What the rows are of a solution at ``s``, whatever stands after states and inputs."""
        found, opened = list[tuple[str, str]](), "cbn [map dot csum cadd cmul real fst snd nth]"
        for k in range(self.n):
            plain = f"cmul (real {self.unit}) (cmul s (x {k}%nat))"
            shown = f"[rewrite X{k}; apply C_eq; unfold cdot, z, x{k}, row, A, B; {opened}; field|]"
            fact = f"cdot x{k} z = cmul (cmul (real {self.unit}) s) (x {k}%nat)"
            found.append((fact, f"transitivity ({plain}); {shown}; apply C_eq; cbn [cmul real fst snd]; ring"))
        for i, (a, b) in enumerate(zip(self.a, self.b, strict=True)):
            for name, factor, signal in (("a", a[1], "above_low low"), ("b", b[1], "below_high high")):
                names = f"cdot, z, {name}{i}, {signal.replace(' ', ', ')}, of, ends, row, C0, D"
                fact = f"cdot {name}{i} z = cmul (real {factor}) ({signal} mu sigma {i}%nat)"
                found.append((fact, f"unfold {names}; rewrite S{i}; apply C_eq; unfold row, C0, D; {opened}; field"))
            if self.theta[i]:
                by, inner = number(self.s[i][1]), "(0, 0)"
                for k, v in reversed([*enumerate(self.H.C[i])]):
                    inner = f"cadd (cmul (real {number(v)}) (cmul s (x {k}%nat))) ({inner})"
                shown = f"[rewrite {', '.join(f'X{k}' for k in range(self.n))}; apply C_eq; "
                shown += f"unfold cdot, z, s{i}, row, A, B; {opened}; field|]"
                fact = f"cdot s{i} z = cmul (real {by}) (cmul s (sigma {i}%nat))"
                plain = f"transitivity (cmul (real {by}) ({inner})); {shown}"
                found.append((fact, f"{plain}; rewrite S{i}; apply C_eq; unfold row, C0, D; {opened}; ring"))
        return [
            "Lemma rows_are : forall s x mu sigma v, plant_at A B C0 D s x mu sigma ->",
            f"  let z := {self.z} :: v in",
            "  " + " /\\\n  ".join(fact for fact, _ in found) + ".",
            "Proof.",
            "  intros s x mu sigma v [EX ES] z.",
            *(f"  pose proof (EX {k}%nat ltac:(cbn; lia)) as X{k}." for k in range(self.n)),
            *(f"  pose proof (ES {i}%nat ltac:(cbn; lia)) as S{i}." for i in range(self.m)),
            *(f"  apply conj; [{shown}|]." for _, shown in found[:-1]),
            f"  {found[-1][1]}.\nQed.",
        ]

    @property
    def facts(self) -> str:
        """The names of what the rows are."""
        names = [f"X{k}" for k in range(self.n)]
        for i, theta in enumerate(self.theta):
            names += [f"A{i}", f"B{i}", *[f"S{i}"] * bool(theta)]
        return f"[{' ['.join(names[:-1])} {names[-1]}{']' * (len(names) - 1)}"

    def poles(self) -> list[str]:
        """The loop with the gains at the lower ends."""
        lines = [
            "Lemma poles : stable_at A B C0 D low.",
            "Proof.",
            "  intros s x mu sigma E small k K N; cbn [length A] in K.",
            f"  pose (z := {self.z} :: []); pose proof (rows_are s x mu sigma [] E) as F; cbv zeta in F; fold z in F.",
            f"  destruct F as {self.facts}.",
            f"  enough (fst (cmul (real {self.unit}) s) < 0) by (cbn [cmul real fst snd] in *; lra).",
            "  apply (inside_sound _ _ _ _ _ _ _ z _ (spot k 1) falls eq_refl).",
            f"  - cbn [firstn now next]; {self.moving()}.",
            "  - " + self.vanishing() + ".",
            f"  - cbn [firstn now]; {self.one_of(self.n, 'k', '[cbn; tauto|]')}; lia.",
            f"  - {self.one_of(self.n, 'k', '[{}|]')}; lia.\nQed.",
        ]
        nonzero = "rewrite (cdot_unit _ z _ eq_refl); exact N"
        lines[-1] = f"  - {self.one_of(self.n, 'k', '[' + nonzero + '|]')}; lia.\nQed."
        return lines

    def moving(self) -> str:
        """The first rows of ``moves``."""
        one = "apply Forall2_cons; [rewrite (cdot_unit {0} z (x {0}%nat) eq_refl); exact X{0}|]"
        return "; ".join(one.format(k) for k in range(self.n)) + "; try apply Forall2_nil"

    def vanishing(self) -> str:
        """That ``a`` is 0."""
        one = "apply Forall_cons; [rewrite A{0}, (small {0}%nat ltac:(cbn; lia)); exact (C_scaled_0 _)|]"
        return "; ".join(one.format(i) for i in range(self.m)) + "; apply Forall_nil"

    @staticmethod
    def one_of(count: int, name: str, proof: str) -> str:
        """A number below ``count``, one after the other."""
        return "; ".join(f"destruct {name} as [|{name}]; {proof}" for _ in range(count))

    def axis(self) -> list[str]:
        """The inequality on the axis."""
        q, eps, lags = number(self.q), number(Fraction(1, 1 << self.power)), [*self.lags()]
        lines = [
            "Lemma frequencies : negative_on_axis A B C0 D low high gamma theta multiplier_.",
            "Proof.",
            f"  exists {eps}; split; [lra|]; intros w x mu sigma E; cbv zeta.",
            "  pose proof (rows_are (0, w) x mu sigma) as F.",
            "  set (a := above_low low mu sigma) in *; set (b := below_high high mu sigma) in *.",
            f"  pose (v := [{'; '.join(v.value for v in lags)}]); pose (z := {self.z} :: v).",
            f"  specialize (F v E); cbv zeta in F; fold z in F; destruct F as {self.facts}.",
            *(f"  pose proof (cdot_spot {v.place} 1 z ({v.value}) eq_refl) as V{v.place}." for v in lags),
            f"  assert (M : moves (cmul (real {self.unit}) (0, w)) now next z).",
            f"  {{ unfold now, next; {self.moving()}.",
        ]
        for v in lags:
            plain = f"eq_trans {v.fact} (f_equal (cmul (real {v.factor})) (eq_sym (cpow_none _ _)))"
            numbers = f"{self.unit} {v.scale} _ {v.factor} {v.place} ({v.own})"
            lines.append(f"    apply Forall2_cons; [apply (lag_moves {v.rate} w {v.order} {v.signal} z {numbers});")
            lines.append(f"      [lra|exact ({v.fact if v.order else plain})|reflexivity|lra|lra]|].")
        lines += [
            "    apply Forall2_nil. }",
            f"  assert (T : both supply z = {q} * direct 0 gamma theta w a b sigma (through multiplier_ w a b)).",
            "  { unfold supply, gamma, theta, multiplier_; cbn [direct through].",
            *self.steps(),
            "    unfold both; cbn [value]; ring. }",
            f"  assert (U : both room z = {q} * ({eps} * size2 (length D) 0 a)).",
            "  { unfold room, D; cbn [length size2].",
            f"    replace ({q} * ({eps} * ({self.squares()}))) with ({q} * ({self.squares(eps)})) by ring.",
        ]
        for i, (c, *_) in enumerate(self.room()):
            alpha = number(self.a[i][1])
            lines.append(f"    apply (term_at _ {eps} _ z {c} _ _ _ _ _ {alpha} {alpha} A{i} A{i}); [field|].")
        return [
            *lines,
            "    unfold both; cbn [value]; ring. }",
            f"  assert (K : fst (cmul (real {self.unit}) (0, w)) = 0) by (cbn [cmul real fst snd]; ring).",
            "  pose proof (on_axis_sound _ _ P now next supply room z _ holds eq_refl M K) as H.",
            f"  rewrite T, U in H; apply (Rmult_le_reg_l {q}); lra.\nQed.",
        ]

    def squares(self, factor: str = "") -> str:
        """``size2``, each square times a factor."""
        one = "re (cmul (conj_ (a {0}%nat)) (a {0}%nat))"
        parts = [f"{factor} * {one}" if factor else one for _ in range(self.m)]
        return " + (".join(part.format(i) for i, part in enumerate(parts)) + " + 0" + ")" * (self.m - 1)

    def steps(self) -> Iterator[str]:
        """That ``supply`` is the form, term by term."""
        factors = (c for c, *_ in self.form())
        step = "    apply (term_at _ _ _ z {} _ _ _ _ _ {} {} {} {}); [field|].".format
        for i, theta in enumerate(self.theta):
            alpha, beta, by = (number(side[i][1]) for side in (self.a, self.b, self.s))
            yield step(number(next(factors)), alpha, beta, f"A{i}", f"B{i}")
            yield step(number(next(factors)), alpha, by, f"A{i}", f"S{i}") if theta else "    apply no_term_at."
        for i, j, _, rate, order, side in self.kernels:
            a, b = (number(self.a[i][1]), f"A{i}"), (number(self.b[j][1]), f"B{j}")
            if order:
                held = ("1", f"V{self.place[side, j if side > 0 else i, rate][order - 1]}")
                a, b = (a, held) if side > 0 else (held, b)
                if side < 0:
                    yield f"    rewrite ?(adjoint (cpow (lag {number(rate)} w) {order}) (a {i}%nat) (b {j}%nat))."
            else:
                yield f"    rewrite ?(cpow_none (lag {number(rate)} w) (b {j}%nat))."
            yield step(number(next(factors)), a[0], b[0], a[1], b[1])

    @property
    def classes(self) -> str:
        """The class of each nonlinearity."""
        ends = self.ends[: self.of[self.first - 1] + 1]
        held = (self.class_of(k, f"(phi {k}%nat)") for k in range(len(ends)))
        return " -> ".join(held)

    def class_of(self, k: int, name: str) -> str:
        """The class of one."""
        return f"of_class {str(self.odd).lower()} {' '.join(map(number, self.ends[k]))} {name}"

    def theorem(self) -> list[str]:
        """The statement, and what the theorem relied on asks for."""
        n, m, odd = self.n, self.m, str(self.odd).lower()
        held = [f"class{k}" for k in range(len(self.ends))]
        lines = ["Theorem stable : matrix_zames_falb_theorem -> forall (phi : nat -> R -> R) (x w : nat -> R -> R),"]
        lines.append(
            f"  {self.classes} ->\n  loop_of A B C0 D of phi x w -> forall k, (k < {n})%nat -> tends_to (x k) 0."
        )
        lines += [f"Proof.\n  intros relied phi x w {' '.join(held)} solution."]
        lines.append(f"  apply (relied {n}%nat {m}%nat A B C0 D of ends {odd} gamma theta multiplier_ phi x w);")
        lines.append("    try exact poles; try exact frequencies; try exact solution;")
        lines.append("    try (split; [reflexivity|repeat constructor]); try reflexivity.")
        weighed = "unfold multiplier_, mass_if, weight; cbn [fold_right fst snd Nat.eqb nth gamma]"
        lines += [
            *self.in_turn(),
            *self.bounded(),
            f"  - intros i I; {self.one_of(m, 'i', f'[{weighed}; {self.signed()}; split; lra|]')}; lia.",
            self.signs,
            "  - intros i I; " + "; ".join(f"destruct i as [|i]; [exact class{k}|]" for k in self.of) + "; lia.",
        ]
        return [*lines, "Qed."]

    def in_turn(self) -> list[str]:
        """That each ``sigma`` is given by states and the channels before it."""
        return [
            "  - unfold D, theta; cbn [in_turn skipn]; repeat split; repeat constructor;",
            "    try (left; lra); right; repeat constructor.",
        ]

    def bounded(self) -> list[str]:
        """That bounds are in order, and kernels where they may be."""
        listed = "repeat (apply Forall_cons; [cbn; repeat split; try lia; lra|]); apply Forall_nil"
        return [
            f"  - intros i I; {self.one_of(self.first, 'i', '[cbn; lra|]')}; lia.",
            f"  - unfold multiplier_; {listed}.",
        ]

    def signed(self) -> str:
        """What the absolute values of the kernels are."""
        signs = dict.fromkeys(k.coefficient for k in self.kernels)
        return "; ".join(f"rewrite ?(Rabs_{'left' if c < 0 else 'right'} {number(c)}) by lra" for c in signs) or "idtac"

    @property
    def signs(self) -> str:
        """That they are nonnegative, or the nonlinearities odd."""
        return "  - left; reflexivity." if self.odd else "  - right; unfold multiplier_; repeat constructor; cbn; lra."


def spot(place: int, value: int) -> list[int]:
    """``spot`` of the Coq file."""
    return [*[0] * place, value]


def added(u: list[int], v: list[int]) -> list[int]:
    """The sum of two rows, of which one may be shorter."""
    return [a + b for a, b in zip_longest(u, v, fillvalue=0)]


def spelt(name: str) -> str:
    """The name of a row, or a place, in the words of Coq."""
    return f"spot {name} 1" if name.isdigit() else name


def reals_of(row: Vector) -> str:
    """A list of numbers of ``R``."""
    return f"[{'; '.join(map(number, row))}]"
