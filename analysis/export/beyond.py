"""A set beyond which no solution starts that tends to 0, in the words of Coq: `beyond.v`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.arithmetic import numbers
from lure.analysis.certificates.channels import Plant, plant
from lure.analysis.export.quadratic import Term, bilinear, less, nonnegative, times, whole_loop
from lure.analysis.export.regional import MOST_ENTRIES, Region
from lure.analysis.export.words import folded, integers, number, refused, terms, whole_file


def beyond_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of starts whose solutions do not tend to 0, as ``V > 1`` grows.

    Raises
    ------
    refused
        An ``InputError``: it is too large.
    """
    H = plant(data["system"])
    if len(H.A) + len(H.D) > MOST_ENTRIES:
        raise refused(f"it has {len(H.A)} states and {len(H.D)} channels, together more than {MOST_ENTRIES}")
    return _Beyond(data, H).text(claim)


class _Beyond(Region):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], H: Plant) -> None:
        self.read(data, H, "Q")
        self.integrals, self.count, self.rate = {}, 0, exact(data["proof"]["rate"])
        none = [Fraction(0)] * len(H.D)
        limits = [self.known[i].limits() for i in range(len(H.D))]
        rows = [less(phi, e, s) for phi, s, (e, *_) in zip(self.loop.phi, self.loop.sigma, limits, strict=True)]
        weights = numbers(data["proof"]["weights"])
        loop = replace(
            self.loop,
            P=self.P,
            rows=[row[: len(H.A)] for row in self.loop.rows[: len(H.A)]],
            theta=none,
            bounds=[*zip(none, none, strict=True)],
            terms=[(s, row, row) for s, row in zip(weights, rows, strict=True)],
        )
        found = whole_loop(loop)
        assert found is not None, "no integral lacks a bound"
        more = found.factor.denominator
        self.level = int(found.factor * more)
        P, caps = [[more * v for v in row] for row in found.P], [(more * c, u, v) for c, u, v in found.products]
        self.loop, self.forms = loop, replace(found, P=P, products=caps)
        if not nonnegative(self.growth(), found.size):
            raise refused("its form does not grow by enough")

    def growth(self) -> list[Term]:
        """What is nowhere negative where ``V`` grows at the rate, up to the limits."""
        f, p, q = self.forms, self.rate.numerator, self.rate.denominator
        V = bilinear(f.P, f.now, f.now)
        if self.discrete:
            return [*times(q, [*bilinear(f.P, f.then, f.then), *f.products]), *times(-p - q, V)]
        turn = [*bilinear(f.P, f.now, f.then), *bilinear(f.P, f.then, f.now)]
        return [*times(q, [*turn, *f.products]), *times(-p, V)]

    def hypotheses(self) -> list[tuple[str, str]]:
        """Names and statements."""
        return [*super().hypotheses()[:-1], ("beyond", f"1 < {self.at(self.start)}")]

    def text(self, claim: str) -> str:
        """The whole file."""
        libraries = ("forms.v", "flow.v", "critical.v", "steps.v", "regions.v", "beyond.v")
        parts = ["\n".join(self.definitions()), *(one.clipped() for one in self.known.values())]
        return whole_file(claim, "counterexample, growth", libraries, [*parts, self.witness(), self.theorem()])

    def witness(self) -> str:
        """The numbers of the proof, and the test that they pass."""
        f, p, q = self.forms, self.rate.numerator, self.rate.denominator
        lines = ["(* V = x^T P x grows at a rate where it is above L, by Lagrange's reduction of a quadratic form. *)"]
        for name, rows in (("P", f.P), ("now", f.now), ("next", f.then)):
            lines.append(folded(f"Definition {name} : list (list Z) := {integers(rows)}%Z."))
        lines.append(folded(f"Definition caps : list term := {terms(f.products)}%Z."))
        test = f"grows_{'by_steps' if self.discrete else 'in_time'} {f.size} P now next caps {p} {q}"
        return "\n".join([*lines, f"Lemma grows : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed."])

    def theorem(self) -> str:
        """The statement and its proof."""
        f, p, q = self.forms, self.rate.numerator, self.rate.denominator
        told, at = self.hypotheses(), "t" if self.discrete else "t Ht"
        _, names = self.binders()
        *first, last = (f"T{k}" for k in range(self.order))
        ends = f"{''.join(f'[{name} ' for name in first)}{last}{']' * len(first)}"
        lines = [f"Theorem escapes : forall ({self.path} : {self.kind}),", *(f"  ({text}) ->" for _, text in told)]
        lines += ["  ~ (" + " /\\ ".join(self.conclusions()) + ").", "Proof."]
        lines.append(f"  intros {' '.join([*names, self.path, *(name for name, _ in told), ends])}.")
        entries = "; ".join(self.entry(k) for k in range(f.size))
        lines.append(f"  pose (z := fun t : {self.moment} => [{entries}]).")
        lines.append(f"  assert (same : forall t, value (bilinear P now now) (z t) = {self.level} * {self.at('t')}).")
        lines += [
            "  { intro t; rewrite value_bilinear; unfold z, P, now, at_, level.",
            "    cbn [map dot sumprod]; field. }",
        ]
        lines += [] if self.discrete else [*self.flowing(), *self.continuous()]
        name = "by_steps" if self.discrete else "in_time"
        lines.append(f"  apply (escapes_{name} {f.size} P now next caps {p} {q} {self.level} z grows).")
        lines += ["  - reflexivity.", *(self.stepping() if self.discrete else ["  - exact F.", "  - exact C."])]
        lines += [f"  - intro{'s' * (not self.discrete)} {at}."]
        for i, s in enumerate(self.own):
            e, *_, most = map(number, self.known[i].limits())
            inner = f"(w {i}%nat t - {e} * ({self.sigma(i)}))"
            lines += [
                f"    assert (B{s} : {inner} * {inner} <= {most} * {most}).",
                f"    {{ apply square_below; pose proof (phi{s}_limited ({self.sigma(i)})) as Q.",
                f"      rewrite <- (graph{s} {at}) in Q; lra. }}",
            ]
        opened = "".join(f", sigma{s}" for s in self.own)
        lines.append(f"    unfold caps, z{opened} in *; cbn [value dot]; lra.")
        lines += ["  - lra.", f"  - rewrite (same {self.start}); lra."]
        lines.append(f"  - unfold now; intros f [{'|['.join(['<-'] * self.order)}|[]{']' * self.order}.")
        for k in range(self.order):
            lines += self.vanishing_state(k)
        return "\n".join([*lines, "Qed."])

    def vanishing_state(self, k: int) -> list[str]:
        """That a row of the state tends to 0 with it."""
        unit = self.forms.unit
        shown = "intro; unfold z; cbn [dot]; field"
        if self.discrete:
            return [f"    {{ apply (steps_same _ (fun t => {unit} * x {k}%nat t)); [{shown}|now apply Un_cv_scal]. }}"]
        return [
            f"    {{ apply (tends_same _ (fun t => {unit} * x {k}%nat t)); [{shown}|].",
            f"      replace 0 with ({unit} * 0) by ring; now apply tends_scal. }}",
        ]
