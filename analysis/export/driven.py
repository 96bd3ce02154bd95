"""Inputs from rest, of which a loop of constant gains lets more through than a gain allows, for Coq: `driven.v`.

``x = adj(s - A) B d xi`` and ``w = d chi xi``, ``chi = det(s - A)``, at ``s = d/dt`` (in discrete time the shift), for
any ``xi``: one that is 0 at first, and later oscillates with a rational frequency, from which the state and ``w`` have
rational amplitudes.  ``|z|^2 - gamma^2 |w|^2`` has a positive mean then.  In continuous time a polynomial leads from
rest to it.  Where ``chi`` is 0 at that frequency, ``w`` is 0 later on, and ``z`` goes on.  With a rational root ``r >
0`` of ``chi`` all signals are ``e^(rt)`` times those of ``A - r``, which has the root 0.  In discrete time an infinite
gain is that of one sample, after which an ``x'P x`` does not fall that the outputs to come bound.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import zip_longest
from typing import Any

from lure.analysis.certificates.arithmetic import eliminated, numbers
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.channels import Plant, Rows, channels, closed_loop, plant
from lure.analysis.certificates.frequencies import transfer
from lure.analysis.export.circle import times
from lure.analysis.export.gained import whole_rows, within
from lure.analysis.export.gaining import with_inputs
from lure.analysis.export.loops import MOST_STATES, of_states
from lure.analysis.export.quadratic import Vector, bilinear, mix, nonnegative
from lure.analysis.export.words import combined, equations, folded, integers, number, reals, refused, whole_file
from lure.arrays import linalg, np

LIBRARIES = ("forms.v", "flow.v", "driven.v")
Complex = tuple[Fraction, Fraction]
ZERO, ONE, SMALL = Fraction(0), Fraction(1), 1e-6
MOST_SAMPLES, DIGITS = 40, (4, 8, 16, 24, 32, 48)


def driven_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a member of a class with constant gains whose gain from ``w`` to ``z`` is larger, or infinite.

    Raises
    ------
    refused
        An ``InputError``: it has operators or memory, or the gain is infinite for another pole than a rational number
        times ``i``, or a positive one; in discrete time for a pole on the circle alone.
    """
    unlimited = "unlimited" in data["proof"] and data["system"]["time"] == "discrete"
    return (_Endless if unlimited else _Driven)(data).text(claim)


def _times(u: Complex, v: Complex) -> Complex:
    """The product of complex numbers."""
    return u[0] * v[0] - u[1] * v[1], u[0] * v[1] + u[1] * v[0]


def _at(p: Sequence[Fraction], point: Complex) -> Complex:
    """A polynomial with ascending coefficients at a complex number."""
    found = ZERO, ZERO
    for c in reversed(p):
        re, im = _times(found, point)
        found = re + c, im
    return found


def _transfer(closed: Plant, own: Sequence[int], way: Vector) -> tuple[Vector, list[Vector]]:
    """``chi``, and what ``x`` and all ``sigma`` are of ``xi``, ascending, for inputs along a vector."""
    (A, B, C, D), n = closed[:4], len(closed.A)
    units = [[Fraction(i == k) for k in range(n)] for i in range(n)]
    along = [[[sum((row[i] * v for i, v in zip(own, way, strict=True)), ZERO)] for row in side] for side in (B, D)]
    chi, rows = transfer(A, along[0], [*units, *C], [*([ZERO] for _ in units), *along[1]])
    return [Fraction(c) for c in chi], [row[0] for row in rows]


@dataclass(frozen=True)
class _Signal:
    """What is at first, coefficients of powers of ``t`` or samples, and an amplitude: ``Re(late e^(i omega t))``."""

    first: Vector
    late: Complex

    def __add__(self, other: _Signal) -> _Signal:
        size = max(len(self.first), len(other.first))
        first, more = ([*one.first, *[ZERO] * (size - len(one.first))] for one in (self, other))
        late = self.late[0] + other.late[0], self.late[1] + other.late[1]
        return _Signal([u + v for u, v in zip(first, more, strict=True)], late)

    def times(self, factor: Fraction) -> _Signal:
        """The signal times a number."""
        return _Signal([factor * v for v in self.first], (factor * self.late[0], factor * self.late[1]))

    def factors(self) -> Complex:
        """Of the cosine and the sine."""
        return self.late[0], -self.late[1]

    def told(self) -> str:
        """The list and the factors, for Coq."""
        a, b = map(number, self.factors())
        return f"[{'; '.join(map(number, self.first))}] {a} {b}"


class _Driven:
    """The words of one file: signals ``x``, ``w`` and ``z``, and what follows each ``x``."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        H, self.shown = plant(data["system"]), data["proof"]
        m, n = len(H.D), len(H.A)
        asked, gains, self.data = channels(data["laws"], m), numbers(self.shown["gains"], m), data
        self.own, families = list(asked.performance or ()), asked.families
        self.block = [b for b, block in enumerate(asked.blocks) for i in block if i not in self.own]
        functions = range(len(self.block))
        if any(families[i].operator or families[i].memory or families[i].rate is not None for i in functions):
            raise refused("a channel is no function of sigma, or its gain has a bounded rate")
        closed = closed_loop(H, [[g * (i == j) for j in range(m)] for i, g in enumerate(gains)])
        if closed is None or self.own != [*range(len(self.block), m)] or not 0 < n <= MOST_STATES:
            raise refused(f"its loop is not well posed, or has no state, or above {MOST_STATES}")
        places = [self.block.index(b) for b in range(len({*self.block}))]
        ends = [(families[i].sector, families[i].slope) for i in places]
        self.bounds = [(max(low, a), min(high, b)) for (low, high), (a, b) in ends]
        self.gains, self.n, self.discrete = [gains[i] for i in places], n, H.discrete
        self.gamma2, self.infinite = 1 / asked.bounds(self.own[0])[1] ** 2, "unlimited" in self.shown
        self.loop = with_inputs(of_states(H.A, H.B, H.C, H.D, discrete=H.discrete), len(self.own))
        ways = [[pair[k] for pair in self.amplitudes()] for k in (0, 1)]
        self.ways = [(way, phase) for way, phase in zip(ways, ((ONE, ZERO), (ZERO, ONE)), strict=True) if any(way)]
        self.closed, self.at = closed, ZERO
        self.shift(ZERO)
        self.x, self.then, self.w, self.z = self.signals(gains)

    def shift(self, rate: Fraction) -> None:
        """Take ``e^(rate t)`` out of all signals."""
        A = [[v - rate * (i == j) for j, v in enumerate(row)] for i, row in enumerate(self.closed.A)]
        self.seen, self.rate = [_transfer(self.closed._replace(A=A), self.own, way) for way, _ in self.ways], rate
        self.chi = self.seen[0][0]

    def amplitudes(self) -> list[Complex]:
        """Of each input."""
        if self.infinite:
            return [(Fraction(k + 1 == self.shown["unlimited"][1]), ZERO) for k in range(len(self.own))]
        return [(re, im) for re, im in (numbers(pair, 2) for pair in self.shown["input"])]

    def point(self) -> Complex:
        """``i omega``; in discrete time ``e^(i theta)``, of which half the angle has the tangent ``at``."""
        q = 1 + self.at**2
        return ((1 - self.at**2) / q, 2 * self.at / q) if self.discrete else (ZERO, self.at)

    def signals(self, gains: Vector) -> tuple[list[_Signal], ...]:
        """At the first frequency of few digits that will do: all signals."""
        for rate, at in self.frequencies():
            self.at = at
            if rate != self.rate:
                self.shift(rate)
            chi = _at(self.chi, self.point())
            if self.infinite != (chi == (ZERO, ZERO)):
                continue
            late = (ONE, ZERO) if self.infinite else (chi[0], -chi[1])
            xi = [self.started(_times(phase, late)) for _, phase in self.ways]
            rows = [*zip(*(own for _, own in self.seen), strict=True)]
            x, sigma = ([self.mixed(row, xi) for row in part] for part in (rows[: self.n], rows[self.n :]))
            then = [
                self.mixed([[ZERO, *p] for p in row], xi) + one.times(rate)
                for row, one in zip(rows[: self.n], x, strict=True)
            ]
            w = [one.times(g) for one, g in zip(sigma, gains, strict=True)][: len(self.block)]
            w += [
                self.mixed([[way[k] * c for c in self.chi] for way, _ in self.ways], xi) for k in range(len(self.own))
            ]
            z = sigma[len(self.block) :]
            if self.mean(z) > (0 if self.infinite else self.gamma2 * self.mean(w[len(self.block) :])):
                every = [v for one in (*x, *then, *w, *z) for v in (*one.first, *one.late)]
                unit = Fraction(math.lcm(*(v.denominator for v in every)))
                return tuple([one.times(unit) for one in part] for part in (x, then, w, z))
        raise refused("no rational frequency was found at which more comes through")

    def frequencies(self) -> Iterator[tuple[Fraction, Fraction]]:
        """Those that are asked, with rates of growth."""
        if not self.infinite:
            yield from ((ZERO, at) for at in self.finite())
        elif not self.discrete:
            roots = np.roots([float(c) for c in reversed(self.chi)])
            near = sorted({round(abs(r.imag), 6) for r in roots if abs(r.real) < SMALL})
            yield from ((ZERO, Fraction(v).limit_denominator(1000)) for v in near)
            right = (float(r.real) for r in roots if abs(r.imag) < SMALL < r.real)
            yield from ((Fraction(v).limit_denominator(1000), ZERO) for v in right)

    def finite(self) -> Iterator[Fraction]:
        """Frequencies at which more comes through than a gain allows."""
        if self.shown["omega"] is None:
            yield from (Fraction(10) ** k for k in range(1, 7))
            return
        at = exact(self.shown["omega"])
        yield from (near for k in range(1, 13) if (near := at.limit_denominator(10**k)) or not (at or self.discrete))
        yield from (at + Fraction(1, 10**k) for k in range(1, 13))

    def started(self, late: Complex) -> _Signal:
        """``xi``: in continuous time the coefficients of ``t^(n+1) q(t)``, with its first ``n`` derivatives at 1."""
        if self.discrete:
            return _Signal([], late)
        n, found, series, turned = self.n, list[Fraction](), list[Fraction](), late
        for k in range(n + 1):
            series.append(turned[0] / math.factorial(k))
            turned = _times(turned, self.point())
        inverse = [Fraction((-1) ** k * math.comb(n + k, k)) for k in range(n + 1)]  # of (1 + u)^(n + 1), t = 1 + u
        for c in reversed(times(series, inverse)[: n + 1]):
            found = [u + v for u, v in zip([c, *found], [*(-v for v in found), ZERO], strict=True)]
        return _Signal([*[ZERO] * (n + 1), *found], late)

    def mixed(self, rows: Sequence[Sequence[Fraction]], xi: list[_Signal]) -> _Signal:
        """``sum p(d/dt) xi``, or of shifts, of polynomials with ascending coefficients."""
        total = _Signal([], (ZERO, ZERO))
        for p, one in zip(rows, xi, strict=True):
            total += _Signal(self.begun(p, one), _times(_at(p, self.point()), one.late))
        return total

    def begun(self, p: Sequence[Fraction], xi: _Signal) -> Vector:
        """What a combination is at first."""
        if not self.discrete:
            found, part = list[Fraction](), xi.first
            for c in p:
                found = [u + c * v for u, v in zip_longest(found, part, fillvalue=ZERO)]
                part = [k * v for k, v in enumerate(part)][1:]
            return found
        samples, late = [ZERO] * self.n, xi.late
        for _ in p:
            samples.append(late[0])
            late = _times(late, self.point())
        return [sum((c * samples[t + j] for j, c in enumerate(p) if t + j < len(samples)), ZERO) for t in range(self.n)]

    def mean(self, given: Sequence[_Signal]) -> Fraction:
        """Twice the mean of the sum of squares; at the frequency 0 the imaginary parts do not count."""
        return sum((one.late[0] ** 2 + one.late[1] ** 2 * bool(self.at) for one in given), ZERO)

    # ---- Words ----

    def text(self, claim: str) -> str:
        """The whole file."""
        parts = ["\n".join(self.definitions()), "\n".join([*self.statement(), *self.proof()])]
        return whole_file(claim, f"counterexample, {self.shown['method']} of a gain", LIBRARIES, parts)

    @property
    def outputs(self) -> list[str]:
        """The names of the outputs."""
        return [f"output{k}" for k in range(len(self.own))]

    @property
    def kind(self) -> str:
        """Of all signals."""
        return "swing" if self.discrete else "surge" if self.rate else "wave"

    def word(self, one: _Signal) -> str:
        """A signal, for Coq."""
        if self.rate:
            return f"surge {number(self.rate)} [{'; '.join(map(number, one.first))}] {number(one.late[0])}"
        return f"{self.kind} {one.told()} {self.last}"

    @property
    def last(self) -> str:
        """What signals of one frequency end with."""
        found = (number(v) for v in (self.point() if self.discrete else (self.at,)))
        return " ".join(found)

    def named(self) -> list[tuple[str, _Signal]]:
        """All signals with their names."""
        lists = (("x", self.x), ("w", self.w), ("z", self.z))
        return [(f"{name}{k}", one) for name, listed in lists for k, one in enumerate(listed)]

    def definitions(self) -> list[str]:
        """The outputs of the plant, the signals, and that those of the state follow one another."""
        moment = "nat" if self.discrete else "R"
        names = [f"x {k}%nat t" for k in range(self.n)] + [f"w {i}%nat t" for i in range(len(self.w))]
        lines = [
            folded(f"Definition {name} (x w : nat -> {moment} -> R) (t : {moment}) : R := {combined(row, names)}.")
            for name, row in zip(self.outputs, self.loop.sigma[len(self.block) :], strict=True)
        ]
        lines += [folded(f"Definition {name} : {moment} -> R := {self.word(one)}.") for name, one in self.named()]
        for k, one in enumerate(self.then):
            after = self.word(one)
            if self.discrete:
                lines.append(folded(f"Lemma next{k} : forall t, x{k} (S t) = {after} t."))
                lines.append("Proof. apply swing_next; [reflexivity|discriminate|lra|lra]. Qed.")
            else:
                lines.append(folded(f"Lemma next{k} : forall t, derivable_pt_lim x{k} t ({after} t)."))
                flow = "surge_flow" if self.rate else "wave_flow"
                lines.append(f"Proof.\n  apply {flow}; cbn [poly dpoly]; [intro s; ring|lra..].\nQed.")
        return lines + ([] if self.discrete else self.energies())

    def energies(self) -> list[str]:
        """The integrals of the squares of inputs and outputs."""
        lines = list[str]()
        for name, one in zip([*self.names("w"), *self.names("z")], [*self.w[len(self.block) :], *self.z], strict=True):
            square = times(one.first, one.first)
            power = [ZERO, *(c / k for k, c in enumerate(square, 1))]
            energy = f"energy P{name} {' '.join(map(number, _mean(one, self.at)))} {self.last}"
            shown = f"energy_flow; unfold P{name}; cbn [poly dpoly];\n    [intro s; field|lra|lra|lra|"
            shown += f"{'right' if self.at else 'left'}; lra|lra|lra]"
            if self.rate:
                power = [ZERO] * len(square)
                for k, c in reversed([*enumerate(square)]):  # q' + 2 r q is the square
                    power[k] = (c - sum(((k + 1) * v for v in power[k + 1 : k + 2]), ZERO)) / (2 * self.rate)
                energy = f"surge_energy {number(self.rate)} P{name} {number(one.late[0] ** 2 / (2 * self.rate))}"
                shown = f"surge_energy_flow; unfold P{name}; cbn [poly dpoly]; [intro s; field|lra|lra|lra]"
            lines += [
                reals(f"P{name}", power),
                folded(f"Definition E{name} : R -> R := {energy}."),
                f"Lemma square_{name} : forall t, derivable_pt_lim E{name} t ({name} t ^ 2).",
                f"Proof.\n  apply {shown}.\nQed.",
            ]
        return lines

    def said(self) -> list[str]:
        """What is said of the loop and its start."""
        moment = "0%nat" if self.discrete else "0"
        return [
            *(text for b, ends in enumerate(self.bounds) if (text := within(f"g{b}", ends))),
            *equations(self.loop, [f"g{b} *" for b in self.block], len(self.own)),
            *(f"x {k}%nat {moment} = 0" for k in range(self.n)),
        ]

    def squares(self) -> tuple[str, str]:
        """The sums of squares of outputs and inputs."""
        m = len(self.block)
        z2 = " + ".join(f"{name} x w t ^ 2" for name in self.outputs)
        return z2, " + ".join(f"w {m + k}%nat t ^ 2" for k in range(len(self.own)))

    def statement(self) -> list[str]:
        """What there is."""
        gains = f"({' '.join(f'g{b}' for b in range(len(self.bounds)))} : R) " * bool(self.bounds)
        moment, (z2, w2) = "nat" if self.discrete else "R", self.squares()
        gamma2, said = "c" if self.infinite else number(self.gamma2), self.said()
        energies = "" if self.discrete else " (Ez Ew : R -> R)"
        if self.discrete:
            end = f"exists k, {gamma2} * sum_f_R0 (fun t => {w2}) k < sum_f_R0 (fun t => {z2}) k"
        else:
            said += [f"(forall t, derivable_pt_lim {name} t ({of}))" for name, of in (("Ez", z2), ("Ew", w2))]
            end = f"exists t, 0 < t /\\ {gamma2} * (Ew t - Ew 0) < Ez t - Ez 0"
        return [
            f"Theorem exceeds : exists {gains}(x w : nat -> {moment} -> R){energies},",
            *(f"  {text} /\\" for text in said),
            f"  {'forall c, ' * self.infinite}{end}.",
        ]

    def proof(self) -> list[str]:
        """Its proof."""
        m, n = len(self.block), self.n
        x, w = ("; ".join(f"{name}{i}" for i in range(size)) for name, size in (("x", n), ("w", m + len(self.own))))
        given = [
            *map(number, self.gains),
            f"(fun k => nth k [{x}] (fun _ => 0))",
            f"(fun i => nth i [{w}] (fun _ => 0))",
        ]
        given += [] if self.discrete else [f"(fun t => {_nested(self.names(v))})" for v in "zw"]
        every = ", ".join(name for name, _ in self.named())
        opened = f"unfold {', '.join([*self.outputs, every])}; cbn [nth]"
        if self.discrete:
            cases = "".join("destruct t as [|t]; [cbn; field|]; " for _ in range(n))
            same = f"{opened}; unfold swing; cbn [length]; destruct (Nat.ltb_spec t {n}) as [L|L]; [{cases}lia|"
            same += f"destruct (turned {self.last} (t - {n})) as [c s]; field]"
        else:
            same = f"{opened}; unfold {self.kind}, glued; destruct (Rle_dec t 0); [|destruct (Rle_dec t 1)]"
            same += "; cbn [poly]; field"
        lines = [
            "Proof.",
            f"  exists {', '.join(given)}; cbn [nth].",
            *["  split; [lra|]."] * sum(bool(within("g", e)) for e in self.bounds),
        ]
        lines += [f"  split; [intro t; {same}|]."] * m
        for k in range(n):
            if self.discrete:
                lines.append(f"  split; [intro t; rewrite next{k}; {same}|].")
            else:
                lines.append(f"  split; [intro t; eapply derivable_same; [reflexivity| |apply next{k}]; {same}|].")
        start = (
            f"unfold {{}}, {self.kind}{'; reflexivity' if self.discrete else ', glued; destruct (Rle_dec 0 0); lra'}"
        )
        lines += [f"  split; [{start.format(f'x{k}')}|]." for k in range(n)]
        return [*lines, *(self.summed(same) if self.discrete else self.integrated(same)), "Qed."]

    def integrated(self, same: str) -> list[str]:
        """The end in continuous time."""
        lines, parts = list[str](), (self.names("z"), self.names("w"))
        for own in parts:
            text = f"apply square_{own[-1]}"
            for k, name in reversed([*enumerate(own[:-1], 1)]):
                rest = f"(fun t => {_nested(own[k:])})"
                text = f"apply (derivable_pt_lim_plus E{name} {rest}); [apply square_{name}|{text}]"
            lines.append(f"  split; [intro t; eapply derivable_same; [intro; reflexivity| |{text}]; {same}|].")
        out, into = (" + ".join(f"poly P{name} 1" for name in own) for own in parts)
        gamma2 = "c" if self.infinite else number(self.gamma2)
        outer, inner = (sum((_mean(v, self.at)[0] for v in part), ZERO) for part in (self.z, self.w[len(self.block) :]))
        every, mean = ", ".join(f"E{name}" for part in parts for name in part), outer - self.gamma2 * inner
        late = f"late {number(self.at)} ({out} - {gamma2} * ({into})) {number(mean)} ltac:(lra) ltac:(lra)"
        if self.rate:
            rate = number(self.rate)
            out, into = (
                " + ".join(f"(exp (2 * {rate} * 1) * poly P{name} 1 - poly P{name} 0)" for name in own) for own in parts
            )
            outer = sum((one.late[0] ** 2 for one in self.z), ZERO) / (2 * self.rate)
            return [
                *lines,
                "  intro c.",
                f"  destruct (surge_late {rate} ({out} - c * ({into}))",
                f"    {number(outer)} ltac:(lra) ltac:(lra)) as [t [T P]].",
                "  exists t; split; [lra|].",
                f"  unfold {every}; rewrite !surge_energy_start, !(surge_energy_end _ _ _ t T); lra.",
            ]
        return [
            *lines,
            *["  intro c."] * self.infinite,
            f"  destruct ({late}) as [t [T [S P]]].",
            "  exists t; split; [lra|].",
            f"  unfold {every}; rewrite !energy_start, !(energy_late _ _ _ _ _ t T S); lra.",
        ]

    def names(self, letter: str) -> list[str]:
        """Those of outputs ``z``, or of inputs ``w``."""
        first = len(self.block) if letter == "w" else 0
        return [f"{letter}{first + k}" for k in range(len(self.own))]

    def summed(self, same: str) -> list[str]:
        """The end in discrete time."""
        (z2, w2), (C, T) = (" + ".join(f"{name} t ^ 2" for name in self.names(v)) for v in "zw"), self.point()
        gamma2 = number(self.gamma2)
        inputs = self.w[len(self.block) :]
        weighed = [(ONE, *one.factors()) for one in self.z] + [(-self.gamma2, *one.factors()) for one in inputs]
        cc, cs, ss = (
            sum((k * v for k, v in part), ZERO)
            for part in zip(*(((k, a * a), (k, 2 * a * b), (k, b * b)) for k, a, b in weighed), strict=True)
        )
        mean = (cc + ss) / 2
        # al c's' + be s's' of the turned c, s, less those before, is what is left
        found = eliminated([[C * T, T * T], [C * C - T * T - 1, 2 * C * T]], [[cc - mean], [cs]])
        assert found is not None, "a rotation by no multiple of pi"
        (al,), (be,) = found
        every = ", ".join(name for name, _ in self.named() if name[0] != "x")
        return [
            f"  destruct (sums_late (fun t => {z2} - {gamma2} * ({w2})) {self.n}",
            f"    {' '.join(map(number, (mean, al, be)))} {self.last}) as [k K]; [field|lra| |].",
            f"  {{ intro k; cbn [turned]; unfold {every}, swing; cbn [length].",
            f"    rewrite (proj2 (Nat.ltb_ge ({self.n} + k) {self.n})) by lia.",
            f"    replace ({self.n} + k - {self.n})%nat with k by lia.",
            f"    destruct (turned {self.last} k) as [c s]; field. }}",
            f"  exists k; rewrite (sum_apart (fun t => {z2}) (fun t => {w2})) in K.",
            f"  apply Rlt_le_trans with (sum_f_R0 (fun t => {z2}) k); [cbn [nth]; lra|].",
            f"  right; apply sum_eq; intros t _; {same}.",
        ]


class _Endless(_Driven):
    """In discrete time: one sample goes in, and the sum of squares of what comes out has no end."""

    def signals(self, gains: Vector) -> tuple[list[_Signal], ...]:
        """None: all signals are those of one sample.  What is said of it is found here."""
        A, self.every = self.closed.A, gains
        self.asked = self.own[self.shown["unlimited"][1] - 1]
        self.ahead = [[self.closed.C[i] for i in self.own]]  # the outputs after so many samples, of the state
        for _ in range(self.n - 1):
            self.ahead.append(_product(self.ahead[-1], A))
        self.into, self.direct = ([row[self.asked] for row in side] for side in (self.closed.B, self.closed.D))
        unit, self.next = whole_rows(A)
        self.now = [[unit * (i == k) for k in range(self.n)] for i in range(self.n)]
        unit, self.later = whole_rows([row for rows in self.ahead for row in rows])
        self.square, (self.P, self.K) = unit**2, self.form()
        self.states = [[ZERO] * self.n, self.into]
        while (x := self.states[-1]) and sum(a * b for a, b in zip(x, mix(x, self.P), strict=True)) <= 0:
            if len(self.states) == MOST_SAMPLES:
                raise refused(f"in {MOST_SAMPLES} samples no state was seen from which the squares have no end")
            self.states.append([row[0] for row in _product(A, [[v] for v in x])])
        return [], [], [], []

    def form(self) -> tuple[list[list[int]], int]:
        """``P`` and ``K`` of few digits."""
        A, seen = (np.array([[float(v) for v in row] for row in side]) for side in (self.closed.A, self.later))
        with suppress(np.linalg.LinAlgError, ValueError, OverflowError):
            near = -linalg.solve_discrete_lyapunov(A.T, np.eye(self.n))
            most = float(np.linalg.eigvals(np.linalg.solve(seen.T @ seen, near)).real.max()) * self.now[0][0] ** 2
            for bits in DIGITS:
                P = [[round(float(v) * 2**bits) for v in row] for row in near + near.T]
                V, K = bilinear(P, self.now, self.now, -1), max(1, math.ceil(4 * most * 2**bits))
                rises = nonnegative([*bilinear(P, self.next, self.next), *V], self.n)
                if rises and nonnegative([*((K, row, row) for row in self.later), *V], self.n):
                    return P, K
        raise refused("no quadratic form was found that does not fall and that the outputs to come bound")

    def seen_of(self, i: int) -> str:
        """``sigma_i``, of the state and the sample."""
        return combined([*self.closed.C[i], self.direct[i]], [*(f"x{k} t" for k in range(self.n)), "impulse t"])

    def definitions(self) -> list[str]:
        """The outputs of the plant, the signals, their samples up to where the form is positive, and the test."""
        n, m, x = self.n, len(self.block), [*(f"x{k} t" for k in range(self.n)), "impulse t"]
        names = [f"x {k}%nat t" for k in range(n)] + [f"w {i}%nat t" for i in range(len(self.every))]
        inside = [*(f"nth {k} x 0" for k in range(n)), "impulse t"]
        moved = [[*row, b] for row, b in zip(self.closed.A, self.into, strict=True)]
        lines = [
            folded(f"Definition {name} (x w : nat -> nat -> R) (t : nat) : R := {combined(row, names)}.")
            for name, row in zip(self.outputs, self.loop.sigma[m:], strict=True)
        ]
        lines += [
            "Fixpoint state (t : nat) : list R :=",
            f"  match t with O => [{'; '.join('0' * n)}] | S t => let x := state t in",
            folded(f"    [{'; '.join(combined(row, inside) for row in moved)}] end."),
        ]
        signals = [(f"x{k}", f"nth {k} (state t) 0") for k in range(n)]
        signals += [(f"w{i}", f"{number(self.every[i])} * ({self.seen_of(i)})") for i in range(m)]
        signals += [(f"w{i}", "impulse t" if i == self.asked else "0") for i in self.own]
        signals += [(name, self.seen_of(i)) for name, i in zip(self.names("z"), self.own, strict=True)]
        lines += [folded(f"Definition {name} (t : nat) : R := {what}.") for name, what in signals]
        for k, row in enumerate(moved):
            lines.append(folded(f"Lemma next{k} : forall t, x{k} (S t) = {combined(row, x)}."))
            lines.append("Proof. reflexivity. Qed.")
        for t, values in enumerate(self.states):
            before = "".join(f", ?at{t - 1}_{k}" for k in range(n))
            for k, v in enumerate(values):
                shown = f"rewrite (next{k} {t - 1}%nat){before}; cbn [impulse]; field" if t else "reflexivity"
                lines.append(f"Lemma at{t}_{k} : x{k} {t}%nat = {number(v)}.\nProof. {shown}. Qed.")
        following = ", ".join(f"?next{k}" for k in range(n))
        for j, rows in enumerate(self.ahead):
            for name, row in zip(self.names("z"), rows, strict=True):
                stated = f"forall t, (1 <= t)%nat -> {name} (t + {j})%nat = {combined(row, x[:-1])}"
                shown = f"rewrite Nat.add_0_r; unfold {name}"
                if j:
                    shown = f"replace (t + {j})%nat with (S t + {j - 1})%nat by lia;\n    "
                    shown += f"rewrite {name}_{j - 1} by lia; rewrite {following}"
                lines.append(folded(f"Lemma {name}_{j} : {stated}."))
                lines.append(f"Proof.\n  intros t L; {shown}; destruct t; [lia|]; cbn [impulse]; field.\nQed.")
        for name, form in (("P", self.P), ("now", self.now), ("next", self.next), ("later", self.later)):
            lines.append(folded(f"Definition {name} : list (list Z) := {integers(form)}%Z."))
        lines.append(f"Lemma on : goes_on {n} P now next later {self.K} = true.")
        return [*lines, "Proof. vm_cast_no_check (eq_refl true). Qed."]

    def proof(self) -> list[str]:
        """Its proof."""
        n, first, outputs = self.n, len(self.states) - 1, self.names("z")
        x, w = ([f"{name}{i}" for i in range(size)] for name, size in (("x", n), ("w", len(self.every))))
        given = [*map(number, self.gains), *(f"(fun k => nth k [{'; '.join(v)}] (fun _ => 0))" for v in (x, w))]
        same = f"unfold {', '.join([*self.outputs, *w, *outputs])}; cbn [nth]; field"
        z2, states = " + ".join(f"{name} t ^ 2" for name in outputs), "; ".join(f"{name} t" for name in x)
        ahead, at = (
            ", ".join(v)
            for v in ([f"{name}_{j}" for j in range(n) for name in outputs], [f"at{first}_{k}" for k in range(n)])
        )
        return [
            "Proof.",
            f"  exists {', '.join(given)}; cbn [nth].",
            *["  split; [lra|]."] * sum(bool(within("g", e)) for e in self.bounds),
            *[f"  split; [intro t; {same}|]."] * len(self.block),
            *(f"  split; [intro t; rewrite next{k}; {same}|]." for k in range(n)),
            *["  split; [reflexivity|]."] * n,
            f"  intro c; destruct (without_end {n} P now next later {self.K} {self.square} {n - 1} {first}",
            f"    (fun t => [{states}]) (fun t => {z2}) on) with (c := c) as [k Q].",
            "  - reflexivity.",
            "  - intro t; nra.",
            "  - lra.",
            f"  - intros t L; unfold now, next, at_; cbn [map dot]; rewrite {', '.join(f'next{k}' for k in range(n))}.",
            "    destruct t; [lia|]; cbn [impulse]; repeat (apply f_equal2; [field|]); reflexivity.",
            f"  - intros t L; cbn [sum_f_R0]; rewrite {ahead} by lia.",
            "    right; unfold later, squares; cbn [map value dot]; field.",
            "  - rewrite value_bilinear; unfold P, now, at_; cbn [map dot sumprod].",
            f"    rewrite {at}; lra.",
            "  - exists k; rewrite impulse_energy, Rmult_1_r.",
            f"    2: {{ intro t; unfold {', '.join(self.names('w'))}; cbn [nth]; destruct t; cbn [impulse]; ring. }}",
            f"    apply Rlt_le_trans with (1 := Q); right; apply sum_eq; intros t _; {same}.",
            "Qed.",
        ]


def _product(left: Rows, right: Rows) -> Rows:
    """Of two matrices."""
    return [
        [sum((a * v for a, v in zip(row, column, strict=True)), ZERO) for column in zip(*right, strict=True)]
        for row in left
    ]


def _nested(names: Sequence[str]) -> str:
    """A sum of energies, the first one and the rest."""
    return f"E{names[0]} t" + (f" + ({_nested(names[1:])})" if len(names) > 1 else "")


def _mean(one: _Signal, at: Fraction) -> tuple[Fraction, Fraction, Fraction]:
    """Of ``(a cos + b sin)^2`` the mean, and its integral's factors of ``cos sin`` and ``sin^2``."""
    a, b = one.factors()
    return ((a * a + b * b) / 2, (a * a - b * b) / 2 / at, a * b / at) if at else (a * a, ZERO, ZERO)
