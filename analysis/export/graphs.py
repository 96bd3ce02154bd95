"""A nonlinearity that is a polynomial between cuts, and what holds of it on an interval, in the words of Coq.

Each statement is one about polynomials on intervals: `pieces.v`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

from lure.analysis.export.circle import added, times
from lure.analysis.export.quadratic import whole
from lure.analysis.export.words import integers, number, refused
from lure.record import described, quantity

Part = tuple[Fraction, Fraction, int]  # an interval, and the place of the polynomial there
DEEPEST = 60


@described(frozen=True, kw_only=True)
class Known:
    """A nonlinearity by its graph."""

    name: str = quantity("In the file")
    cuts: list[Fraction] = quantity("Ascending")
    pieces: list[list[Fraction]] = quantity("One more, the lowest coefficient first")

    def definition(self) -> str:
        """The function, and one lemma for each piece."""
        steps = [
            f"if Rle_dec s {number(c)} then {written(p)} else" for c, p in zip(self.cuts, self.pieces, strict=False)
        ]
        lines = [f"Definition {self.name} (s : R) : R :=", *(f"  {step}" for step in steps)]
        lines.append(f"  {written(self.pieces[-1])}.")
        for k, p in enumerate(self.pieces):
            ends = [f"{number(c)} <= s -> " for c in self.cuts[:k][-1:]]
            ends += [f"s <= {number(c)} -> " for c in self.cuts[k : k + 1]]
            lines.append(f"Lemma {self.name}_on{k} : forall s, {''.join(ends)}{self.name} s = {written(p)}.")
            lines += [f"Proof.\n  intros s{' A' * (k > 0)}{' B' * (k < len(self.cuts))}; unfold {self.name}."]
            for j, c in enumerate(self.cuts[:k]):
                same = f"replace s with {number(c)} by lra; field" if j == k - 1 else "exfalso; lra"
                lines.append(f"  destruct (Rle_dec s {number(c)}) as [H|_]; [{same}|].")
            if k < len(self.cuts):
                lines.append(f"  destruct (Rle_dec s {number(self.cuts[k])}) as [_|H]; [reflexivity|contradiction].")
            else:
                lines.append("  reflexivity.")
            lines.append("Qed.")
        return "\n".join(lines)

    def on(self, k: int, y: str) -> str:
        """The equation of a piece at a point of it."""
        return f"({self.name}_on{k} {y}{' ltac:(lra)' * ((k > 0) + (k < len(self.cuts)))})"

    def parts(self, reach: Fraction) -> list[Part]:
        """The pieces within ``|s| <= reach``, cut at 0."""
        ends = sorted({-reach, Fraction(0), reach, *(c for c in self.cuts if abs(c) < reach)})
        return [(a, b, sum(c < (a + b) / 2 for c in self.cuts)) for a, b in pairwise(ends)]

    def local(self, name: str, low: Fraction, high: Fraction, reach: Fraction) -> str:
        """That it lies in a sector on an interval."""

        def branch(a: Fraction, b: Fraction, k: int) -> list[str]:
            """The proof between two cuts."""
            sides = [[0, *self.pieces[k]], [0, 0, low]], [[0, 0, high], [0, *self.pieces[k]]]
            shown = [_never_negative(added(p, q, -1), a, b, side) for side, (p, q) in zip("AB", sides, strict=True)]
            return [f"rewrite {self.on(k, 'y')}.", *shown, "cbn [peval] in A, B; split; lra."]

        parts = self.parts(reach)
        middle = next(k for a, _, k in parts if not a)
        lines = [f"Lemma {name} : in_sector_up_to {number(reach)} {number(low)} {number(high)} {self.name}."]
        lines.append(f"Proof.\n  split; [rewrite {self.on(middle, '0')}; field|].")
        return "\n".join([*lines, "  intros y Y; apply abs_within in Y.", *cases(parts, branch), "Qed."])

    def has_limits(self) -> bool:
        """Whether it is a line with limits on both sides."""
        if len(self.pieces) != 3 or max(map(len, self.pieces)) > 2 or not self.cuts[0] < 0 < self.cuts[1]:
            return False
        (c, e), _, (d, f) = ([*p, Fraction(0), Fraction(0)][:2] for p in self.pieces)
        return e == f and c * d < 0

    def limits(self) -> tuple[Fraction, Fraction, Fraction, Fraction]:
        """Of a line with limits: ``e, u``, and the smaller and the larger limit of ``phi - e sigma``."""
        (c, e), (_, u), (d, _) = ([*p, Fraction(0), Fraction(0)][:2] for p in self.pieces)
        return e, u, min(abs(c), abs(d)), max(abs(c), abs(d))

    def clipped(self) -> str:
        """The generalised sector condition, and a bound of what is beside the outer slope."""
        e, u, m, most = self.limits()
        P, inner = f"{self.name} y", f"{number(e)} * y + r"

        def branch(_a: object, _b: object, k: int) -> list[str]:
            """The proof between two cuts."""
            lines = [f"rewrite {self.on(k, 'y')}."]
            if k == 1:
                zero = f"{number(u)} * y - ({written(self.pieces[1], 'y')})"
                return [*lines, f"replace ({zero}) with 0 by field; lra."]
            return [*lines, "first [apply Rmult_le_pos; lra|apply same_sign; lra]."]

        parts = [(None, c, k) for k, c in enumerate([*self.cuts, None])]
        lines = [f"Lemma {self.name}_clipped : forall y r, Rabs r <= {number(m)} ->"]
        lines.append(f"  0 <= ({number(u)} * y - {P}) * ({P} - ({inner})).")
        lines += ["Proof.\n  intros y r R_; apply abs_within in R_.", *cases(parts, branch), "Qed."]
        lines.append(
            f"Lemma {self.name}_limited : forall y, - {number(most)} <= {P} - {number(e)} * y <= {number(most)}."
        )
        lines.append("Proof.\n  intro y.")
        lines += cases(parts, lambda _a, _b, k: [f"rewrite {self.on(k, 'y')}; lra."])
        return "\n".join([*lines, "Qed."])

    def bounded(self, least: Fraction, reach: Fraction, sign: int) -> str:
        """A bound of its integral on an interval, from below or, with the sign -1, from above."""
        parts, bound = self.parts(reach), f"{number(least / 2)} * (y * y)"
        said = f"{bound} <= Phi y" if sign > 0 else f"Phi y <= {bound}"
        lines = [f"Lemma {self.name}_integral : forall Phi, integral_of Phi {self.name} ->"]
        lines += [f"  forall y, Rabs y <= {number(reach)} -> {said}.", "Proof.\n  intros Phi I."]
        found: dict[Part, tuple[list[int], int]] = {}
        for side in (1, -1):
            before, at, total = "", Fraction(0), Fraction(0)
            for part in [one for one in parts if (one[0] >= 0) == (side > 0)][::side]:
                a, b, k = part
                Q = [Fraction(0), *(c / (j + 1) for j, c in enumerate(self.pieces[k]))]
                Q[0] = total - _value(Q, at)
                q, common = whole(Q)
                name = f"I{parts.index(part)}"
                start = f"pose proof ({before} {number(at)} ltac:(lra)) as E; cbn [peval] in *; lra"
                if not before:
                    start = "rewrite (proj1 I); cbn [peval]; lra"
                ends, listed = f"{number(a)} {number(b)} {number(at)}", f"{integers(q)}%Z"
                span = f"{number(a)} <= y <= {number(b)}"
                lines += [
                    f"  assert ({name} : forall y, {span} -> {common} * Phi y = peval {listed} y).",
                    f"  {{ apply (primitive_piece Phi {self.name} {listed} {common} {ends} I);",
                    f"    [|lra|{start}].",
                    f"    intros y Y; rewrite {self.on(k, 'y')}.",
                    f"    let d := eval vm_compute in (pderiv {listed}) in change (pderiv {listed}) with d.",
                    "    cbn [peval]; field. }",
                ]
                found[part] = (q, common)
                before, at = name, (b if side > 0 else a)
                total = _value(Q, at)

        def branch(a: Fraction, b: Fraction, k: int) -> list[str]:
            """The proof between two cuts."""
            q, common = found[a, b, k]
            room = added([Fraction(2 * sign * v, common) for v in q], [0, 0, least], -sign)
            return [
                f"pose proof (I{parts.index((a, b, k))} y ltac:(lra)) as E.",
                _never_negative(room, a, b, "A"),
                "cbn [peval] in E, A; lra.",
            ]

        return "\n".join([*lines, "  intros y Y; apply abs_within in Y.", *cases(parts, branch), "Qed."])


def written(p: Sequence[Fraction], s: str = "s") -> str:
    """A polynomial."""
    powers = ["", f" * {s}", *(f" * {s} ^ {k}" for k in range(2, len(p)))]
    return " + ".join(f"{number(c)}{power}" for c, power in zip(p, powers, strict=False) if c) or "0"


def _value(p: Sequence[Fraction], x: Fraction) -> Fraction:
    """Its value."""
    return sum((c * x**k for k, c in enumerate(p)), Fraction(0))


def cases(parts: Sequence[tuple[object, Fraction | None, int]], branch: Callable[..., list[str]]) -> list[str]:
    """One proof for each of the intervals that follow each other."""
    lines = []
    for j, (a, b, k) in enumerate(parts):
        own = " ".join(branch(a, b, k)) if len(parts) == 1 else "\n    ".join(branch(a, b, k))
        if j < len(parts) - 1:
            assert b is not None, "only the last interval is without an end"
            lines.append(f"  destruct (Rle_or_lt y {number(b)}) as [H{j}|H{j}].")
            lines.append(f"  {{ {own} }}")
        else:
            lines.append(f"  {own}")
    return lines


def _never_negative(p: list[Fraction | int], a: Fraction, b: Fraction, name: str) -> str:
    """That a polynomial is nowhere negative on an interval, as a step of a proof."""
    q, _ = whole([Fraction(v) for v in p])
    cuts = [*_cuts(q, a, b)]
    ends, d = whole([a, *cuts, b])
    first, *inner, last = ends
    listed = f"{integers(q)}%Z ({first}) {integers(inner)}%Z ({last})"
    return f"pose proof (nonneg_along_sound {d} {listed} y\n      ltac:(vm_compute; reflexivity) ltac:(lra)) as {name}."


def _cuts(q: list[int], a: Fraction, b: Fraction, depth: int = 0) -> Iterator[Fraction]:
    """Where an interval is to be cut so that the coefficients of ``q`` on each part are not negative.

    Raises
    ------
    refused
        An ``InputError``: it leaves too little room.
    """
    if depth > DEEPEST:
        raise refused("a bound of its nonlinearity leaves too little room")
    if min(_spread(q, a, b)) >= 0:
        return
    middle = (a + b) / 2
    yield from _cuts(q, a, middle, depth + 1)
    yield middle
    yield from _cuts(q, middle, b, depth + 1)


def _spread(q: list[int], a: Fraction, b: Fraction) -> list[Fraction]:
    """``(1 + x)^n q((a + b x)/(1 + x))``."""
    h, w = list[Fraction](), [Fraction(1)]
    for c in reversed(q):
        h, w = added([c * v for v in w], times([a, b], h)), times([Fraction(1), Fraction(1)], w)
    return h or [Fraction(0)]
