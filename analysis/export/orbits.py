"""A solution in discrete time that repeats, and a nonlinearity through its samples, for Coq: `orbits.v`."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF, numbers
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.states import classes
from lure.analysis.export.words import folded, number, refused, whole_file

Point = tuple[Fraction, Fraction]
Vector = list[Fraction]


def orbit_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by an orbit.

    Parameters
    ----------
    data : Mapping
        The certificate.
    claim : str
        The sentence of the checker.

    Raises
    ------
    refused
        An ``InputError``: it is a refutation of another kind, or of a class that is not covered.
    """
    method = data["proof"]["method"]
    if method != "orbit":
        raise refused(f"it is a refutation by {method}; of these, orbits in discrete time have an export")
    return _Orbit(data).text(claim)


class _Orbit:
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        family, proof = classes(data["laws"]), data["proof"]
        self.data, self.odd, self.steep = data, family.odd, family.slope != (-INF, INF)
        low, high = family.slope if self.steep else family.sector
        if INF in (abs(low), abs(high)) or not family.sector[0] <= low < high <= family.sector[1]:
            raise refused("its class has infinite bounds, or slope bounds beyond those of the sector")
        self.samples, self.values = numbers(proof["sigma"]), [-v for v in numbers(proof["u"])]
        given = {(Fraction(0), Fraction(0)), *zip(self.samples, self.values, strict=True)}
        if self.odd:
            given |= {(-x, -y) for x, y in given}
        if not self.steep:  # rays along the lower bound
            far = 1 + max(abs(x) for x, _ in given)
            given |= {(-far, -low * far), (far, low * far)}
        self.points, self.low, self.high = sorted(given), number(low), number(high)
        self.pairs = [(number(x), number(y)) for x, y in self.points]
        self.start = " ".join(self.pairs[0])
        self.f = f"({'through' if self.steep else 'with_ray'} {self.low} {self.start} points)"
        self.phi = f"(oddly {self.f})" if self.odd else self.f

    def text(self, claim: str) -> str:
        """The whole file."""
        found = [
            f"Definition {name} : list R := [{'; '.join(map(number, side))}]."
            for name, side in (("samples", self.samples), ("values", self.values))
        ]
        found.append(f"Definition points : list (R * R) := [{'; '.join(f'({x}, {y})' for x, y in self.pairs[1:])}].")
        parts = ["\n".join(map(folded, found)), "\n".join([*self.statement(), *self.proof()])]
        return whole_file(claim, "counterexample, orbit", ("forms.v", "orbits.v"), parts)

    def statement(self) -> list[str]:
        """What there is."""
        top, d, _ = coefficients(self.data["system"])
        said = [f"in_sector {self.low} {self.high} phi"]
        said += [f"slopes_in {self.low} {self.high} phi"] * self.steep + ["odd phi"] * self.odd
        left, right = _sum(d, "sigma {}"), _sum(top[0][1], "- phi (sigma {})")
        return [
            "Theorem moves : exists (phi : R -> R) (sigma : nat -> R),",
            "  " + " /\\ ".join(said) + " /\\",
            f"  (forall t : nat, {left}",
            f"    = {right}) /\\",
            "  (forall c, ~ Un_cv sigma c)." if self.moves else "  ~ Un_cv sigma 0.",
        ]

    @property
    def moves(self) -> bool:
        """Whether it is no equilibrium."""
        return len(set(self.samples)) > 1

    def at(self, point: Point) -> str:
        """That a point is one of those that ``f`` goes through."""
        k = self.points.index(point)
        name = f"({number(point[0])}, {number(point[1])})"
        return f"apply (on {name}); unfold points; {f'do {k} right; ' * bool(k)}left; reflexivity"

    def through(self, x: Fraction, y: Fraction) -> str:
        """That ``phi x = y``."""
        if not self.odd:
            return self.at((x, y))
        other = "; ".join(f"replace (- {number(v)}) with {number(-v)} by field" for v in (x, y))
        return f"apply (oddly_point {self.f}); [{self.at((x, y))}|{other}; {self.at((-x, -y))}]"

    def member(self) -> list[str]:
        """That it is in the class."""
        low, high = self.low, self.high
        if self.steep:
            slopes = "apply oddly_steep; exact S" if self.odd else "exact S"
            return [
                f"  assert (S : slopes_in {low} {high} {self.f}).",
                "  { apply through_steep; [lra|exact up|unfold points; simpl; repeat split; lra]. }",
                f"  assert (steep_phi : slopes_in {low} {high} {self.phi}) by ({slopes}).",
                f"  assert (class : in_sector {low} {high} {self.phi}).",
                f"  {{ apply in_sector_of_slopes; [exact steep_phi|{self.through(Fraction(0), Fraction(0))}]. }}",
            ]
        cones = []
        for (x, _), (before, _) in zip(self.points[1:], self.points, strict=False):
            side, apart = ("left" if x >= 0 else "right"), ("left" if before >= 0 else "right")
            cones.append(f"    split; [{side}; repeat split; lra|split; [{apart}; lra|]].")
        return [
            f"  assert (C : forall s, cone {low} {high} s ({self.f} s)).",
            "  { apply with_ray_cone; [lra|lra|exact up|right; repeat split; lra|]; unfold points; simpl.",
            *cones,
            "    split; lra. }",
            f"  assert (class : in_sector {low} {high} {self.phi}).",
            f"  {{ apply in_sector_of_cone; {'apply oddly_cone; ' * self.odd}exact C. }}",
        ]

    def proof(self) -> list[str]:
        """The proof."""
        p, count = len(self.samples), len(self.data["system"]["denominator"])
        shown = f"exact (proj2 (through_points {self.low} points {self.start} up p I))"
        if not self.steep:
            shown = f"exact (with_ray_points {self.low} points {self.start} up p I)"
        lines = [
            "Proof.",
            f"  assert (up : ascending {self.pairs[0][0]} points) by (unfold points; simpl; repeat split; lra).",
            f"  assert (on : forall p, In p (({self.pairs[0][0]}, {self.pairs[0][1]}) :: points) ->",
            f"    {self.f} (fst p) = snd p).",
            f"  {{ intros p I; {shown}. }}",
            *self.member(),
            f"  assert (value : forall t, {self.phi} (repeated samples t) = repeated values t).",
            "  { intro t; unfold repeated; change (length values) with (length samples).",
            "    set (r := (t mod length samples)%nat).",
            f"    assert (small : (r < {p})%nat) by (apply Nat.mod_upper_bound; discriminate).",
            "    clearbody r; unfold samples, values.",
        ]
        for x, y in zip(self.samples, self.values, strict=True):
            lines.append(f"    destruct r as [|r]; [cbn [nth]; {self.through(x, y)}|].")
        lines += [
            "    exfalso; lia. }",
            f"  exists {self.phi}, (repeated samples); split; [exact class|].",
            *["  split; [exact steep_phi|]."] * self.steep,
            *["  split; [apply oddly_odd|]."] * self.odd,
            "  split.",
            "  - intro t; rewrite !value.",
            *(
                f"    rewrite ?(repeated_on samples {i} t), ?(repeated_on values {i} t) by discriminate."
                for i in range(count)
            ),
            "    change (length values) with (length samples); set (r := (t mod length samples)%nat).",
            f"    assert (small : (r < {p})%nat) by (apply Nat.mod_upper_bound; discriminate).",
            "    clearbody r.",
            f"    do {p} (destruct r as [|r];",
            "      [cbv [repeated samples values nth length Nat.add Nat.modulo Nat.divmod Nat.sub fst snd]; lra|]).",
            "    exfalso; lia.",
        ]
        if not self.moves:
            return [
                *lines,
                "  - apply (repeated_stays samples 0); unfold samples; cbn [length nth]; [lia|lra].",
                "Qed.",
            ]
        other = next(i for i, v in enumerate(self.samples) if v != self.samples[0])
        sides = "unfold samples; cbn [length nth]; [lia|lia|lra]"
        return [*lines, f"  - apply (repeated_moves samples 0 {other}); {sides}.", "Qed."]


def _sum(row: list[Fraction], text: str) -> str:
    """``sum c_k text(k + t)`` of coefficients in descending order, the latest sample first."""
    places = [(len(row) - 1 - i, c) for i, c in enumerate(row) if c]
    return " + ".join(f"{number(c)} * ({text.format(f'({k} + t)%nat')})" for k, c in places) or "0"
