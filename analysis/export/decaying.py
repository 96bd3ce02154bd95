"""A rate of decay in the words of Coq: ``V`` falls as fast as it, and lies between two squares: `rates.v`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import paced, realised
from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.kernelled import KernelRate
from lure.analysis.export.loops import candidates, of_states, of_transfer
from lure.analysis.export.quadratic import Forms, Loop, Term, bilinear, less, mix, nonnegative, times, whole, whole_loop
from lure.analysis.export.relying import THEOREMS
from lure.analysis.export.slowing import slowing_text
from lure.analysis.export.words import folded, integers, refused, terms, whole_file

MOST = 400


def decaying_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of the circle criterion, or of Popov's by a matrix, with a rate.

    Raises
    ------
    refused
        An ``InputError``: it is of another criterion, or no form of few enough digits was found.
    """
    rate = exact(data["rate"])
    if THEOREMS.get(data["theorem"]) == "zames_falb_theorem":
        return slowing_text(data, claim)
    if data["theorem"] == "matrix-zames-falb":
        return KernelRate(data).text(claim)
    if not data["theorem"].endswith(("circle", "popov")):
        raise refused(f"{data['theorem']} with a rate has no export; the circle criterion has one, and Popov's")
    apart = {key: value for key, value in data.items() if key != "rate"} | {"system": paced(data["system"], rate)}
    for sharp in (False, True):
        for scaled in candidates(apart):
            loop = _in_time(scaled, data["system"], rate)
            theorem = _Decay(data, loop, rate)
            if sharp and not theorem.sharpened():
                break
            found = _decays(loop, rate, sharp=sharp)
            if found is not None:
                return theorem.with_forms(found).text(claim)
    raise refused("no quadratic form of few enough digits was found; a slightly slower rate may have one")


def _in_time(scaled: Loop, system: Mapping[str, Any], rate: Fraction) -> Loop:
    """The loop itself, with ``V`` of the solutions times ``e^(a t)`` or ``r^-t``.

    ``(d/dt)^k e^(a t) xi = e^(a t) sum_j binom(k, j) a^(k - j) xi_j``; in discrete time ``xi(t + k) r^-(t + k)``.
    """
    n = len(scaled.now)
    if system["kind"] != "transfer":
        if system["kind"] == "state-space":
            A, b, c, d, discrete = realised(system, Fraction(0))
            own = of_states(A, [[v] for v in b], [c], [[d]], discrete=discrete)
            return replace(scaled, then=own.then, rows=own.rows)
        share = rate if scaled.discrete else Fraction(1)
        then = [[share * v for v in row] for row in scaled.then]
        if not scaled.discrete:
            then = [[v - rate * (i == j) for j, v in enumerate(row)] for i, row in enumerate(then)]
        return replace(scaled, then=then)
    own = of_transfer(system)
    T = [[_binomial(k, j, rate, discrete=scaled.discrete) for j in range(n)] for k in range(n)]
    turned = [*zip(*T, strict=True)]
    P = [mix(row, [mix(line, T) for line in scaled.P]) for row in turned]
    return replace(scaled, now=own.now, then=own.then, phi=own.phi, sigma=own.sigma, P=P)


def _binomial(k: int, j: int, rate: Fraction, *, discrete: bool) -> Fraction:
    """An entry of the change of coordinates."""
    if discrete:
        return rate**-k * (j == k)
    return math.comb(k, j) * rate ** (k - j) if j <= k else Fraction(0)


@dataclass(frozen=True, kw_only=True)
class _Rate:
    """The forms with integers, one above the integrals, and the two numbers that bound ``V`` by squares."""

    forms: Forms
    high: list[Term]
    inner: int
    outer: int


def _scaled(found: Forms, k: int) -> Forms:
    """``V`` times a whole number."""
    return replace(
        found, P=[[k * v for v in row] for row in found.P], products=times(k, found.products), factor=k * found.factor,
        low=times(k, found.low), turn=times(k, found.turn),
        integrals=[(i, k * c, row, q) for i, c, row, q in found.integrals],
        block=[[k * v for v in row] for row in found.block],
        cones=[[[k * v for v in row] for row in M] for M in found.cones],
    )  # fmt: skip


def _bounds(found: Forms, loop: Loop, side: int, *, sharp: bool) -> list[tuple[Fraction, list[int], list[int]]]:
    """A form below the integrals, ``side = 1``, or above them, ``-1``: by the sectors, or by slope bounds.

    With ``psi = phi - l sigma``, whose slopes are from 0 to ``w``, ``int psi`` is between ``psi^2/2w`` and
    ``psi sigma - psi^2/2w``.
    """
    form = list[tuple[Fraction, list[int], list[int]]]()
    for i, c, *_ in found.integrals:
        low, high = (Fraction(end) for end in loop.bounds[i])
        sigma, q = whole(loop.sigma[i])
        if not sharp:
            form.append((c * (low if c * side > 0 else high) / 2 / q**2, sigma, sigma))
            continue
        psi, r = whole(less(loop.phi[i], low, loop.sigma[i]))
        square = c / (2 * (high - low) * r**2)
        form += [(c * low / 2 / q**2, sigma, sigma)] * bool(low)
        form += [(square, psi, psi)] if c * side > 0 else [(c / (q * r), psi, sigma), (-square, psi, psi)]
    return form


def _decays(loop: Loop, rate: Fraction, *, sharp: bool) -> _Rate | None:
    """The forms of a loop, None if they do not pass the test."""
    p, q, n = rate.numerator, rate.denominator, len(loop.now[0])
    found = whole_loop(loop)
    if found is None or any(t and INF in map(abs, ends) for t, ends in zip(loop.theta, loop.bounds, strict=True)):
        return None
    below, above = (_bounds(found, loop, side, sharp=sharp) for side in (1, -1))
    k = math.lcm(*(c.denominator for c, *_ in (*below, *above)))
    found = _scaled(found, k)
    low, high = ([(int(k * c), u, v) for c, u, v in form] for form in (below, above))
    found = replace(found, low=low)
    V, S = bilinear(found.P, found.now, found.now), [(-c, u, v) for c, u, v in found.products]
    if loop.discrete:
        less = [*times(p * p, V), *times(-q * q, bilinear(found.P, found.then, found.then)), *times(p * p, S)]
    else:
        turn = [*bilinear(found.P, found.now, found.then), *bilinear(found.P, found.then, found.now), *found.turn]
        less = [*times(-q, turn), *times(-2 * p, [*V, *(high if p >= 0 else found.low)]), *times(q, S)]
    if not nonnegative(less, n):
        return None
    squares, power = [(1, f, f) for f in found.now], 1
    while not nonnegative([*times(power, [*V, *found.low]), *times(-16, squares)], n):
        power *= 2  # until whole numbers tell enough
        if power * V[0][0] > 1 << MOST:
            return None
    found, high = _scaled(found, power), times(power, high)
    V = bilinear(found.P, found.now, found.now)
    inner = _largest(lambda k: nonnegative([*V, *found.low, *times(-k, squares)], n))
    outer = 1 + _largest(lambda k: not nonnegative([*times(k, squares), *times(-1, [*V, *high])], n))
    return _Rate(forms=found, high=high, inner=inner, outer=outer)


def _largest(holds: Callable[[int], bool]) -> int:
    """The largest whole number for which something holds that holds for all below it, 0 included."""
    top = 1
    while holds(top):
        top *= 2
    low = top // 2
    while top - low > 1:
        middle = (low + top) // 2
        low, top = (middle, top) if holds(middle) else (low, middle)
    return low


class _Decay(FallingTheorem):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], loop: Loop, rate: Fraction) -> None:
        super().__init__(data, loop)
        self.rate = rate

    def sharpened(self) -> bool:
        """Let slope bounds bound the integrals; False where there are none within the bounds, or no integrals."""
        ends = [
            low <= family.slope[0] and family.slope[1] <= high
            for theta, family, (low, high) in zip(self.loop.theta, self.families, self.loop.bounds, strict=True)
            if theta
        ]
        self.sharp = bool(ends) and all(ends) and not self.transfer
        return self.sharp

    def with_forms(self, found: _Rate) -> _Decay:
        """The same with what was found."""
        self.forms, self.high = found.forms, found.high
        self.squares = f"{found.inner} {found.outer}"
        self.factor = f"({found.outer} / {found.inner})"
        return self

    def text(self, claim: str) -> str:
        """The whole file."""
        entries = "; ".join(self.entry(k) for k in range(self.order))
        state = f"Definition state ({self.path} : {self.kind}) (t : {self.moment}) : list R :=\n  [{entries}]."
        parts = ["\n".join([*self.definitions(), state]), self.witness(), self.theorem()]
        origin = f"{self.data['theorem']} with a rate, {self.data['proof']['method']}"
        return whole_file(claim, origin, ("forms.v", "flow.v", "rates.v", *self.blocked()), parts)

    def witness(self) -> str:
        """The numbers of the proof, and the test that they pass."""
        f, p, q = self.forms, self.rate.numerator, self.rate.denominator
        lists = (("P", f.P), ("now", f.now), ("next", f.then))
        sides = [] if f.block else [("products", f.products)]
        sides += [] if self.discrete else [("low", f.low), ("high", self.high), ("turn", f.turn)]
        lines = [
            "(* V = x^T P x, and integrals, falls as fast as it should: by Lagrange's reduction of three forms. *)"
        ]
        lines += [f"Definition {name} : list (list Z) := {integers(rows)}%Z." for name, rows in lists]
        lines += [f"Definition {name} : list term := {terms(given)}%Z." for name, given in sides]
        lines += self.box()
        lines.append(f"Lemma decays_ : decays_{self.test()} ({p}) {q} {self.squares} = true.")
        lines = [one if "\n" in one else folded(one) for one in lines]
        return "\n".join([*lines, "Proof. vm_cast_no_check (eq_refl true). Qed."])

    def test(self, at: str = "") -> str:
        """What is computed, and its lists."""
        lists = "products" if self.discrete else "low high turn products"
        return f"{'by_steps' if self.discrete else 'in_time'}{at} {self.forms.size} P now next {lists}"

    def theorem(self) -> str:
        """The statement and its proof."""
        f, p, q = self.forms, self.rate.numerator, self.rate.denominator
        binders, names = self.binders()
        lines = [f"Theorem decays : forall{binders} ({self.path} : {self.kind}),"]
        lines += [f"  ({text}) ->" for _, text in self.hypotheses()]
        at = f"state {self.path}"
        share = f"({p} / {q})"
        first, other, places = ("(k + t)%nat", "t", "k t") if self.discrete else ("t", "s", "s t")
        moved = f"{share} ^ (2 * k)" if self.discrete else f"exp (- (2 * {share} * (t - s)))"
        held = f"forall {places}, " + "0 < s -> s <= t -> " * (not self.discrete)
        lines.append(f"  {held}norm2 ({at} {first}) <= {self.factor} * {moved} * norm2 ({at} {other}).")
        lines += ["Proof.", *self.introduced([*names, self.path])]
        entries = "; ".join(self.entry(k) for k in range(f.size))
        lines.append(f"  pose (z := fun t : {self.moment} => [{entries}]).")
        opened = "unfold z, now, state; cbn [square_sum dot norm2 Nat.add]; ring"
        lines.append(f"  assert (same : forall t, square_sum now (z t) = {f.unit**2} * norm2 ({at} t))")
        lines.append(f"    by (intro t; {opened}).")
        lines += [] if self.discrete else self.flowing()
        said = f"{self.factor} * {moved} * square_sum now (z {other})"
        lines.append(f"  assert (B : {held}square_sum now (z {first})\n    <= {said}).")
        integrals = "" if self.discrete else f"(fun t => {self.rest(-1)}) "
        lines.append(f"  {{ apply ({self.test('_at_rate')} ({p}) {q} {self.squares} z {integrals}decays_).")
        lines.append("  - reflexivity.")
        inner = [*self.below(), *self.beside("high"), *self.turning()]
        lines += self.stepping() if self.discrete else ["  - exact F.", *inner]
        more = places + " Hs st" * (not self.discrete)
        lines += [*self.products(), f"  intros {more}; specialize (B {more}); rewrite !same in B."]
        lines.append(f"  apply (Rmult_le_reg_l {f.unit**2}); lra.")
        return "\n".join([*lines, "Qed."])
