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
from lure.analysis.export.loops import candidates, of_states, of_transfer
from lure.analysis.export.quadratic import Forms, Loop, Term, bilinear, mix, nonnegative, times, whole, whole_loop
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
    if not data["theorem"].endswith(("circle", "popov")):
        raise refused(f"{data['theorem']} with a rate has no export; the circle criterion has one, and Popov's")
    apart = {key: value for key, value in data.items() if key != "rate"} | {"system": paced(data["system"], rate)}
    for scaled in candidates(apart):
        loop = _in_time(scaled, data["system"], rate)
        found = _decays(loop, rate)
        if found is not None:
            return _Decay(data, loop, rate, found).text(claim)
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


def _decays(loop: Loop, rate: Fraction) -> _Rate | None:
    """The forms of a loop, None if they do not pass the test."""
    p, q, n = rate.numerator, rate.denominator, len(loop.now[0])
    found = whole_loop(loop)
    if found is None or any(t and INF in map(abs, ends) for t, ends in zip(loop.theta, loop.bounds, strict=True)):
        return None
    above = list[tuple[Fraction, list[int]]]()
    for (i, c, *_), (_, sigma, _) in zip(found.integrals, found.low, strict=True):
        end, (_, unit) = Fraction(loop.bounds[i][c > 0]), whole(loop.sigma[i])
        above.append((c * end / 2 / unit**2, sigma))
    k = math.lcm(*(c.denominator for c, _ in above))
    found, high = _scaled(found, k), [(int(k * c), sigma, sigma) for c, sigma in above]
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

    def __init__(self, data: Mapping[str, Any], loop: Loop, rate: Fraction, found: _Rate) -> None:
        super().__init__(data, loop)
        self.forms, self.high, self.rate = found.forms, found.high, rate
        self.squares = f"{found.inner} {found.outer}"
        self.factor = f"({found.outer} / {found.inner})"

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
        lines += ["Proof.", f"  intros {' '.join([*names, self.path, *(name for name, _ in self.hypotheses())])}."]
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
