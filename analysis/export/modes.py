"""A constant gain of the class with which a solution of the linear loop has no limit, for Coq: `modes.v`."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.checker import MOVES, UNSOLVABLE
from lure.analysis.certificates.states import classes
from lure.analysis.export.circle import Poly, added, times
from lure.analysis.export.quadratic import whole
from lure.analysis.export.words import folded, integers, number, refused, whole_file
from lure.arrays import np

FINEST = (6, 10, 16, 24, 32, 40)  # widths of the interval for omega, as powers of two
HALVINGS = 160  # of the last one
ROUNDED = (1, 10, 10**3, 10**6, 10**9)
METHODS = ("linear-gain", "crossing", "matrix-gain")


def mode_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by a constant gain of one channel, of a plant that is given by two polynomials.

    The root is not computed: ``d + g n = 0`` at ``s`` where ``Im d(s) conj n(s)`` changes sign along a line or a circle
    of the plane, with ``g = -Re d conj n / |n|^2``, which stays within the class between the two places.  Where it is
    at an end of the class, ``d + g n`` has a factor ``(s - c)^2 + r`` with rational ``c`` and ``r > 0``.

    Raises
    ------
    refused
        An ``InputError``: it has matrices, a dead time or a rate, or no such place was found.
    """
    return Mode(data).text(claim)


@dataclass(frozen=True)
class _Line:
    """Where ``s`` is looked for: ``size + i w``, in discrete time ``size (1 + i w)^2/(1 + w^2)``."""

    size: Fraction
    discrete: bool

    def along(self, p: list[Fraction], order: int) -> tuple[Poly, Poly]:
        """Real and imaginary part of ``p``, the highest coefficient first; times ``(1 + w^2)^order``, so discrete."""
        x, y = ([self.size], [Fraction(0), Fraction(1)])
        unit: Poly = [Fraction(1)]
        if self.discrete:
            x, y = [self.size, Fraction(0), -self.size], [Fraction(0), 2 * self.size]
            unit = [Fraction(1), Fraction(0), Fraction(1)]
        re, im, power = [Fraction(0)], [Fraction(0)], [Fraction(1)]
        for c in p:
            re, im = added(times(re, x), times(im, y), Fraction(-1)), added(times(re, y), times(im, x))
            re, power = added(re, power, c), times(power, unit)
        for _ in range(order + 1 - len(p)):
            re, im = times(re, unit), times(im, unit)
        return re, im

    @property
    def point(self) -> str:
        """``s`` in words."""
        r = number(self.size)
        return f"({r} * (1 - w * w) / (1 + w * w), 2 * {r} * w / (1 + w * w))" if self.discrete else f"({r}, w)"


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Where ``omega`` lies, and polynomials in its place ``y`` from 0 to 1, integers, with the factor of each."""

    line: _Line
    start: Fraction
    end: Fraction
    turn: tuple[list[int], Fraction]
    size: tuple[list[int], Fraction]
    above: tuple[list[int], Fraction]
    below: tuple[list[int], Fraction] | None


class Mode:
    """The words of one file; with ``several`` the class is that of one channel of several."""

    def __init__(self, data: Mapping[str, Any], *, several: bool = False) -> None:
        family, system, proof = classes(data["laws"], several=several), data["system"], data["proof"]
        if "rate" in data or system["kind"] != "transfer":
            raise refused("it is about a rate, or its plant is not given by two polynomials")
        top, self.den, self.discrete = coefficients(system)
        self.num, self.order, self.method = top[0][1], len(self.den) - 1, proof["method"]
        self.low = max(family.sector[0], family.slope[0])
        self.high = min(family.sector[1], family.slope[1])
        self.conclusion = data.get("conclusion", "")
        if abs(self.low) == INF or self.conclusion == UNSOLVABLE:
            raise refused("its class has no lower bound, or its loop is not well posed with the gain")
        gains = [proof["gain"]] if "gain" in proof else proof["gains"]
        self.gain = sum(map(exact, gains), Fraction(0)) / len(gains)

    def value(self, p: list[Fraction], s: Fraction) -> Fraction:
        """A polynomial at a rational point."""
        found = Fraction(0)
        for c in p:
            found = found * s + c
        return found

    def contains(self, g: Fraction) -> bool:
        """Whether a gain is one of the class."""
        return bool(self.low <= g <= self.high)

    def roots(self) -> list[complex]:
        """Roots of ``d + g n`` that are not strictly inside, roughly."""
        padded = [Fraction(0)] * (len(self.den) - len(self.num)) + list(self.num)
        closed = np.array([float(a + self.gain * b) for a, b in zip(self.den, padded, strict=True)])
        found = [complex(v) for v in np.roots(closed)]
        return [v for v in found if (abs(v) > 1 - 1e-6 if self.discrete else v.real > -1e-6 * abs(v))]

    def real_place(self) -> tuple[Fraction, Fraction] | None:
        """A real root that is not inside, and its gain."""
        near = [Fraction(v.real).limit_denominator(k) for v in self.roots() for k in ROUNDED]
        for s in [*[Fraction(-1)] * self.discrete, *near]:
            n = self.value(self.num, s)
            if n and (s != 1 and abs(s) >= 1 if self.discrete else s > 0):
                g = -self.value(self.den, s) / n
                if self.contains(g):
                    return s, g
        return None

    def rest(self) -> Fraction | None:
        """The gain with which constants are solutions, if there is one in the class."""
        s = Fraction(int(self.discrete))
        n, d = self.value(self.num, s), self.value(self.den, s)
        if not n:
            return None if d else self.gain
        return -d / n if self.contains(-d / n) else None

    def drifts(self, g: Fraction) -> bool:
        """Whether the root of constants is a double one: the derivative vanishes there too."""
        place = Fraction(int(self.discrete))
        slopes = ([c * k for c, k in zip(p, range(len(p) - 1, 0, -1), strict=False)] for p in (self.den, self.num))
        d, n = (self.value(p, place) for p in slopes)
        return d + g * n == 0

    def factor(self) -> tuple[Fraction, Fraction, Poly] | None:
        """``c``, ``r > 0`` and ``q`` with ``d + g n = ((s - c)^2 + r) q``, roots that are not inside."""
        padded = [Fraction(0)] * (len(self.den) - len(self.num)) + list(self.num)
        closed = [a + self.gain * b for a, b in zip(self.den, padded, strict=True)]
        for v in self.roots():
            for k in ROUNDED:
                double, size = (Fraction(x).limit_denominator(k) for x in (2 * v.real, abs(v) ** 2))
                c, r, left, q = double / 2, size - double**2 / 4, list(closed), []
                while len(left) > 2:
                    lead, one, two, *rest = left
                    q.append(lead)
                    left = [one + double * lead, two - size * lead, *rest]
                if r > 0 and not any(left) and (size >= 1 if self.discrete else c >= 0):
                    return c, r, q
        return None

    def sizes(self) -> Iterator[Fraction]:
        """Real parts, or moduli, of a root, the least that will do first."""
        yield Fraction(int(self.discrete))
        for v in self.roots():
            size = abs(v) if self.discrete else v.real
            for k in ROUNDED[1:]:
                near = Fraction(size).limit_denominator(k)
                if near > int(self.discrete):
                    yield near

    def place(self) -> _Place | None:
        """A pair of roots that are not inside, with a gain of the class."""
        for size in self.sizes():
            line = _Line(size, self.discrete)
            (n1, n2), (d1, d2) = (line.along(p, self.order) for p in (self.num, self.den))
            turn = added(times(d2, n1), times(d1, n2), Fraction(-1))
            cross = added(times(d1, n1), times(d2, n2))
            modulus = added(times(n1, n1), times(n2, n2))
            above = [-v for v in added(cross, modulus, Fraction(self.low))]
            below = added(cross, modulus, Fraction(self.high)) if self.high != INF else None
            while len(turn) > 1 and not turn[-1]:
                turn.pop()
            near = [complex(v).real for v in np.roots([float(c) for c in turn[::-1]])]
            near += [math.tan(cmath.phase(v) / 2) if self.discrete else v.imag for v in self.roots()]  # where it is 0
            for w in sorted(v for v in near if v > 0):
                for start, end in self.brackets(w, turn):
                    given = [_between(p, start, end) for p in (turn, modulus, above)]
                    last = _between(below, start, end) if below is not None else None
                    inside = [p for p, _ in (*given[1:], *([last] if last is not None else []))]
                    if all(_least(p) > 0 for p in inside):
                        return _Place(
                            line=line, start=start, end=end, turn=given[0], size=given[1], above=given[2], below=last
                        )
        return None

    def brackets(self, w: float, turn: Poly) -> Iterator[tuple[Fraction, Fraction]]:
        """Shorter and shorter intervals around ``w`` at whose ends ``turn`` has different signs."""
        start = end = Fraction(0)
        falling = turn[::-1]
        for bits in FINEST:
            step = Fraction(2) ** (math.frexp(w)[1] - bits)
            near = math.floor(Fraction(w) / step) * step
            if near > 0 and self.value(falling, near) * self.value(falling, near + step) <= 0:
                start, end = near, near + step
                yield start, end
        for _ in range(HALVINGS if end else 0):
            middle = (start + end) / 2
            kept = self.value(falling, start) * self.value(falling, middle) <= 0
            start, end = (start, middle) if kept else (middle, end)
            yield start, end

    def text(self, claim: str) -> str:
        """The whole file."""
        libraries = ("forms.v", "flow.v", "frequencies.v", "modes.v")
        return whole_file(claim, f"counterexample, {self.method}", libraries, self.parts())

    def parts(self) -> list[str]:
        """The plant, and the theorem ``moves``."""
        lists = [
            folded(f"Definition {name} : list R := [{'; '.join(map(number, side))}].")
            for name, side in (("num", self.num), ("den", self.den))
        ]
        bounds = f"{number(self.low)} <= g"
        bounds += "" if self.high == INF else f" <= {number(Fraction(self.high))}"
        if self.discrete:
            solves = "(forall t, shifts den xi t = - (g * shifts num xi t))"
            kind, end = "nat -> R", "forall c, ~ Un_cv xi c"
        else:
            solves = "(forall k t, derivable_pt_lim (xi k) t (xi (S k) t)) /\\\n"
            solves += "  (forall t, along den xi t = - (g * along num xi t))"
            kind, end = "nat -> R -> R", "forall c, ~ tends_to (xi 0%nat) c"
        stated = [f"Theorem moves : exists (g : R) (xi : {kind}),", f"  {bounds} /\\", f"  {solves} /\\", f"  {end}."]
        place, factor, real, rest = self.place(), self.factor(), self.real_place(), self.rest()
        if place is not None:
            lists += self.witness(place)
            proof = self.proof(place)
        elif factor is not None:
            proof = self.factor_proof(*factor)
        elif real is not None:
            proof = self.real_proof(*real)
        elif rest is not None and self.drifts(rest):
            proof = self.drift_proof(rest)
        elif rest is not None and self.conclusion != MOVES:
            stated[-1] = "  ~ Un_cv xi 0." if self.discrete else "  ~ tends_to (xi 0%nat) 0."
            proof = self.real_proof(Fraction(int(self.discrete)), rest)
        else:
            raise refused("no root was found whose place can be told; see its gain")
        return ["\n".join(lists), "\n".join([*stated, "Proof.", *proof, "Qed."])]

    def witness(self, place: _Place) -> list[str]:
        """Polynomials in the place of ``omega`` between two numbers."""
        given = [("turn", place.turn), ("size", place.size), ("over", place.above)]
        given += [("under", place.below)] if place.below is not None else []
        return [folded(f"Definition {name} : list Z := {integers(p)}%Z.") for name, (p, _) in given]

    def ends(self) -> list[str]:
        """That it solves the loop."""
        if self.discrete:
            return ["  split; [now apply mode_closed_in_steps|apply mode_never_settles_in_steps]."]
        return ["  split; [intros; apply mode_flows|split; [now apply mode_closed|apply mode_never_settles]]."]

    def proof(self, place: _Place) -> list[str]:
        """For a pair of roots."""
        power = f" * (1 + w * w) ^ {2 * self.order}" * self.discrete
        factors = [f"({number(q)}{power})" for _, q in (place.turn, place.size, place.above)]
        factors += [f"({number(place.below[1])}{power})"] if place.below is not None else []
        d, n = "(poly den s)", "(poly num s)"
        cross = f"cmul {d} (conj_ {n})"
        told = [
            ("turn", f"snd ({cross})"),
            ("size", f"square {n}"),
            ("over", f"(- fst ({cross}) - {number(self.low)} * square {n})"),
        ]
        if place.below is not None:
            told.append(("under", f"({number(Fraction(self.high))} * square {n} + fst ({cross}))"))
        lines = ["  destruct (a_zero turn eq_refl) as [y [Y E]]."]
        lines += [f"  pose proof (above_0 {name} y eq_refl Y) as P_{name}." for name, _ in told[1:]]
        lines.append(f"  set (w := {number(place.start)} + {number(place.end - place.start)} * y).")
        lines.append("  assert (W : 0 < w) by (unfold w; lra).")
        lines.append("  assert (S1 : 0 < 1 + w * w) by nra.")
        lines.append(f"  pose (s := {place.line.point} : C).")
        back = f"(w - {number(place.start)}) * {number(1 / (place.end - place.start))}"
        lines.append(f"  assert (back : y = {back}) by (unfold w; field).")
        lines.append("  clearbody w.")
        opened = "unfold s, poly, num, den, square, conj_; cbn [horner cadd cmul real peval fst snd]"
        for (name, expression), factor in zip(told, factors, strict=True):
            lines.append(f"  assert (F_{name} : 0 < {factor}).")
            lines.append("  { apply Rmult_lt_0_compat; [lra|now apply pow_lt]. }" if self.discrete else "  { lra. }")
            lines.append(f"  assert (I_{name} : peval {name} y = {factor} * {expression}).")
            lines.append(f"  {{ rewrite back; unfold {name}; {opened}; field{'; lra' * self.discrete}. }}")
        lines.append(f"  assert (pos : 0 < square {n}) by (apply (Rmult_lt_reg_l {factors[1]}); lra).")
        lines.append(f"  assert (flat : snd ({cross}) = 0) by (apply (Rmult_eq_reg_l {factors[0]}); lra).")
        lines.append(f"  assert (root : closed num den (at_root {d} {n}) s = (0, 0)) by (now apply root_with_gain).")
        own = "mode_in_steps s" if self.discrete else "mode s"
        lines.append(f"  exists (at_root {d} {n}), ({own}).")
        sides = [f"apply (gain_above {factors[2]}); [exact F_over|exact pos|rewrite <- I_over; exact P_over]"]
        if place.below is not None:
            shown = "exact F_under|exact pos|rewrite <- I_under; exact P_under"
            sides.append(f"apply (gain_below {factors[3]}); [{shown}]")
        lines.append(f"  split; [{'split; [' * (len(sides) > 1)}{'|'.join(sides)}{']' * (len(sides) > 1)}|].")
        lines += self.ends()
        if self.discrete:
            r = number(place.line.size)
            lines.append(f"  - unfold s, square; cbn [fst snd]; replace (_ + _) with ({r} * {r}) by (field; lra); lra.")
            lines.append("  - left; unfold s; cbn [snd]; apply Rdiv_lt_0_compat; [nra|exact S1].")
        else:
            lines += ["  - unfold s; cbn [fst]; lra.", "  - left; exact W."]
        return lines

    def factor_proof(self, c: Fraction, r: Fraction, q: Poly) -> list[str]:
        """For a factor of degree 2."""
        s, g = f"({number(c)}, w)", number(self.gain)
        sides = _Line(c, discrete=False).along(q, len(q) - 1)
        opened = "unfold closed, poly, num, den; cbn [horner cadd cmul real fst snd]"
        lines = [
            f"  pose (w := sqrt {number(r)}); assert (W : 0 < w) by (apply sqrt_lt_R0; lra).",
            f"  assert (square_w : w * w = {number(r)}) by (apply sqrt_def; lra); clearbody w.",
            f"  assert (root : closed num den {g} {s} = (0, 0)).",
            "  { apply injective_projections; cbn [fst snd].",
        ]
        for side in sides:
            rest = " + ".join(f"{number(v)} * w ^ {i}" for i, v in enumerate(side) if v) or "0"
            lines.append(
                f"    - transitivity (({number(r)} - w * w) * ({rest})); [{opened}; field|rewrite square_w; ring]."
            )
        own = f"{'mode_in_steps' if self.discrete else 'mode'} {s}"
        lines += ["  }", f"  exists {g}, ({own}); split; [lra|].", *self.ends()]
        first = "unfold square; cbn [fst snd]; rewrite square_w; lra" if self.discrete else "cbn [fst]; lra"
        return [*lines, f"  - {first}.", "  - left; exact W."]

    def real_proof(self, s: Fraction, g: Fraction) -> list[str]:
        """For a real root."""
        own = f"{'mode_in_steps' if self.discrete else 'mode'} ({number(s)}, 0)"
        opened = "unfold closed, poly, num, den; cbn [horner cadd cmul real fst snd]; lra"
        lines = [
            f"  assert (root : closed num den {number(g)} ({number(s)}, 0) = (0, 0)).",
            f"  {{ apply injective_projections; {opened}. }}",
            f"  exists {number(g)}, ({own}); split; [lra|].",
        ]
        if s == int(self.discrete):
            ends = [end.replace("never_settles", "rests") for end in self.ends()]
            return [*lines, *ends]
        first = "unfold square; cbn [fst snd]; lra" if self.discrete else "cbn [fst]; lra"
        return [*lines, *self.ends(), f"  - {first}.", "  - right; cbn [fst snd]; split; [reflexivity|lra]."]

    def drift_proof(self, g: Fraction) -> list[str]:
        """For a double root of constants."""
        if self.discrete:
            lines = [f"  exists {number(g)}, INR; split; [lra|split; [|exact line_never_settles_in_steps]]."]
            return [*lines, "  intro t; unfold num, den; cbn [shifts length Nat.add]; rewrite ?S_INR; lra."]
        lines = [
            f"  exists {number(g)}, line; split; [lra|split; [exact line_flows|split; [|exact line_never_settles]]]."
        ]
        return [*lines, "  intro t; unfold num, den; cbn [along length line]; lra."]


def _between(p: Poly, start: Fraction, end: Fraction) -> tuple[list[int], Fraction]:
    """``q p(start + (end - start) y)`` with integers, and ``q > 0``."""
    found: Poly = []
    for c in reversed(p):
        found = added(times(found or [Fraction(0)], [start, end - start]), [c])
    row, q = whole(found)
    shared = math.gcd(*row) or 1
    return [v // shared for v in row], Fraction(q, shared)


def _least(p: list[int]) -> int:
    """A number that ``p`` is not below between 0 and 1."""
    found = 0
    for c in reversed(p):
        found = c + min(0, found)
    return found
