"""Solutions that repeat or stay, and nonlinearities through their values, for Coq: `orbits.v`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lure.analysis.certificates.arithmetic import INF, numbers
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.channels import channels, plant
from lure.analysis.certificates.states import Family, classes
from lure.analysis.export.loops import of_states
from lure.analysis.export.words import equations, folded, number, reals, refused, whole_file
from lure.analysis.numerics.exact_matrix import dot

Point = tuple[Fraction, Fraction]
Vector = list[Fraction]
Bound = Fraction | float
LIBRARIES = ("forms.v", "flow.v", "orbits.v")


def orbit_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a refutation by an orbit in discrete time, or in either by a state at which a loop stays.

    Raises
    ------
    refused
        An ``InputError``: it is a refutation of another kind, or of a class that is not covered.
    """
    method = data["proof"]["method"]
    if method not in ("orbit", "sampled-orbit", "equilibrium") or "rate" in data:
        paced = " with a rate" * ("rate" in data)
        raise refused(f"it is a refutation by {method}{paced}; orbits without memory and equilibria have an export")
    return _Orbit(data).text(claim) if method == "orbit" else _Several(data).text(claim)


class Graph:
    """Lemmas about one nonlinearity of a class, piecewise linear through given points; names end with ``mark``."""

    def __init__(self, family: Family, given: Iterable[Point], mark: str = "") -> None:
        self.odd, self.steep, self.mark = family.odd, family.slope != (-INF, INF), mark
        low, high = family.slope if self.steep else family.sector
        points = {(Fraction(0), Fraction(0)), *given}
        if self.odd:
            points |= {(-x, -y) for x, y in points}
        if INF in (abs(low), abs(high)):  # a smaller class with finite bounds
            low, high = self.finite(sorted(points), low, high)
        if family.relu or family.linear or not family.sector[0] <= low < high <= family.sector[1]:
            raise refused("its class is of ReLUs or of constant gains, or has slope bounds beyond those of the sector")
        if not self.steep:  # rays along the lower bound
            far = 1 + max(abs(x) for x, _ in points)
            points |= {(-far, -low * far), (far, low * far)}
        self.points, self.low, self.high = sorted(points), number(low), number(high)
        self.pairs = [(number(x), number(y)) for x, y in self.points]
        self.start = " ".join(self.pairs[0])
        self.f = f"({'through' if self.steep else 'with_ray'} {self.low} {self.start} points{mark})"

    def finite(self, points: list[Point], low: Bound, high: Bound) -> tuple[Bound, Bound]:
        """Bounds of the slopes between the points, or of the quotients, in place of infinite ones."""
        found = [(y - v) / (x - u) for (u, v), (x, y) in pairwise(points)] if self.steep else []
        found = found or [y / x for x, y in points if x]
        low = min([*found, min(high, Fraction(1)) - 1]) if low == -INF else low
        return low, max([*found, low + 1]) if high == INF else high

    def said(self, name: str) -> str:
        """That ``name`` is in the class."""
        bounds = f"{self.low} {self.high} {name}"
        said = [f"in_sector {bounds}", f"slopes_in {bounds}" if self.steep else f"(exists a b, slopes_in a b {name})"]
        said += [f"odd {name}"] * self.odd
        return " /\\ ".join(said)

    def lemmas(self) -> list[str]:
        """The graph, that it is in the class, and its values."""
        m, points = self.mark, "; ".join(f"({x}, {y})" for x, y in self.pairs[1:])
        values = f"(through_points {self.low} points{m} {self.start} in_order{m} p I)"
        shown = f"proj2 {values}" if self.steep else values.replace("through_points", "with_ray_points")
        lines = [
            folded(f"Definition points{m} : list (R * R) := [{points}]."),
            f"Definition graph{m} : R -> R := {f'oddly {self.f}' if self.odd else self.f}.",
            f"Lemma in_order{m} : ascending {self.pairs[0][0]} points{m}.",
            f"Proof. unfold points{m}; simpl; repeat split; lra. Qed.",
            f"Definition corners{m} : list (R * R) := ({self.pairs[0][0]}, {self.pairs[0][1]}) :: points{m}.",
            f"Lemma on{m} : forall p, In p corners{m} -> {self.f} (fst p) = snd p.",
            f"Proof. intros p I; exact ({shown}). Qed.",
            *self.mirrored(),
            f"Lemma graph_at{m} : forall i, (i <? length corners{m})%nat = true ->"
            f" graph{m} (fst (nth i corners{m} (0, 0))) = snd (nth i corners{m} (0, 0)).",
            f"Proof. intros i I; apply {'oddly_on' if self.odd else 'on'}{m}, nth_In, Nat.ltb_lt, I. Qed.",
        ]
        return [*lines, *(self.by_slopes() if self.steep else self.by_cones())]

    def mirrored(self) -> list[str]:
        """That an odd graph goes through the points: with each of them its opposite is one."""
        m, step = self.mark, "apply (f_equal2 cons); [apply (f_equal2 pair); lra|]"
        return [
            f"Lemma oddly_on{m} : forall p, In p corners{m} -> graph{m} (fst p) = snd p.",
            f"Proof.\n  apply (oddly_points {self.f} corners{m} on{m}).",
            f"  unfold corners{m}, points{m}; cbn [map rev app fst snd]; repeat ({step}); reflexivity.\nQed.",
        ] * self.odd

    def named(self, x: Fraction) -> str:
        """That the graph goes through a given point."""
        return f"(graph_at{self.mark} {[u for u, _ in self.points].index(x)}%nat eq_refl)"

    def by_slopes(self) -> list[str]:
        """That the slopes of the graph are those of the class."""
        m, bounds = self.mark, f"{self.low} {self.high}"
        return [
            f"Lemma class{m} : {self.said(f'graph{m}')}.",
            "Proof.",
            f"  assert (S : slopes_in {bounds} {self.f}).",
            f"  {{ apply through_steep; [lra|exact in_order{m}|unfold points{m}; simpl; repeat split; lra]. }}",
            f"  assert (T : slopes_in {bounds} graph{m}) by ({'apply oddly_steep; ' * self.odd}exact S).",
            f"  split; [apply in_sector_of_slopes; [exact T|exact {self.named(Fraction(0))}]|].",
            f"  {'split; [exact T|apply oddly_odd]' if self.odd else 'exact T'}.",
            "Qed.",
        ]

    def by_cones(self) -> list[str]:
        """That the points are in the sector."""
        m, cones = self.mark, []
        for (x, _), (before, _) in zip(self.points[1:], self.points, strict=False):
            side, apart = ("left" if x >= 0 else "right"), ("left" if before >= 0 else "right")
            cones.append(f"    split; [{side}; repeat split; lra|split; [{apart}; lra|]].")
        steep = f"exists a, b; {'apply oddly_steep; ' * self.odd}exact S"
        return [
            f"Lemma class{m} : {self.said(f'graph{m}')}.",
            "Proof.",
            f"  destruct (with_ray_steep {self.low} points{m} {self.start} ltac:(lra) in_order{m}) as [a [b S]].",
            f"  assert (C : forall s, cone {self.low} {self.high} s ({self.f} s)).",
            f"  {{ apply with_ray_cone; [lra|lra|exact in_order{m}|right; repeat split; lra|].",
            f"    unfold points{m}; simpl.",
            *cones,
            "    split; lra. }",
            f"  split; [apply in_sector_of_cone; {'apply oddly_cone; ' * self.odd}exact C|].",
            f"  {f'split; [{steep}|apply oddly_odd]' if self.odd else steep}.",
            "Qed.",
        ]


class _Orbit:
    """The words of one file, of one channel."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        family, proof = classes(data["laws"]), data["proof"]
        self.data, self.samples, self.values = data, numbers(proof["sigma"]), [-v for v in numbers(proof["u"])]
        self.graph = Graph(family, zip(self.samples, self.values, strict=True))

    def text(self, claim: str) -> str:
        """The whole file."""
        found = [reals("samples", self.samples), reals("values", self.values), *self.graph.lemmas()]
        found.append("Lemma value_at : forall t, graph (repeated samples t) = repeated values t.")
        ends = [f"exact {self.graph.named(x)}" for x in self.samples]
        found += _by_samples(len(self.samples), ["samples", "values"], ends)
        parts = ["\n".join(found), "\n".join([*self.statement(), *self.proof()])]
        return whole_file(claim, "counterexample, orbit", LIBRARIES, parts)

    def statement(self) -> list[str]:
        """What there is."""
        top, d, _ = coefficients(self.data["system"])
        left, right = _sum(d, "sigma {}"), _sum(top[0][1], "- phi (sigma {})")
        return [
            "Theorem moves : exists (phi : R -> R) (sigma : nat -> R),",
            f"  ({self.graph.said('phi')}) /\\",
            f"  (forall t : nat, {left}",
            f"    = {right}) /\\",
            "  (forall c, ~ Un_cv sigma c)." if self.moves else "  ~ Un_cv sigma 0.",
        ]

    @property
    def moves(self) -> bool:
        """Whether it is no equilibrium."""
        return len(set(self.samples)) > 1

    def proof(self) -> list[str]:
        """The proof."""
        p, count = len(self.samples), len(self.data["system"]["denominator"])
        lines = [
            "Proof.",
            "  exists graph, (repeated samples); split; [exact class|]; split.",
            "  - intro t; rewrite !value_at.",
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
        return [*lines, f"  - {_apart('samples', self.samples)}.", "Qed."]


class _Several:
    """The words of one file, of several channels: states ``x``, values ``w`` of the nonlinearities."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        H, proof = plant(data["system"]), data["proof"]
        asked, self.discrete, self.rests = (
            channels(data["laws"], len(H.D)),
            H.discrete,
            proof["method"] == "equilibrium",
        )
        self.loop, self.n = of_states(H.A, H.B, H.C, H.D, discrete=H.discrete), len(H.A)
        x, self.z, self.origin = numbers(proof["state"]), list[Vector](), proof["method"]
        self.rests = self.origin == "equilibrium"
        for row in [proof["inputs"]] if self.rests else proof["inputs"]:
            self.z.append([*x, *numbers(row)])
            x = [dot(v, self.z[-1]) for v in self.loop.then]
        if not self.rests and proof["half"]:
            self.z += [[-v for v in z] for z in self.z]
        self.block = [b for b, block in enumerate(asked.blocks) for _ in block]
        self.sigma = [[dot(row, z) for z in self.z] for row in self.loop.sigma]
        self.columns = [list(column) for column in zip(*self.z, strict=True)]
        points = [set[Point]() for _ in asked.blocks]
        for b, sigma, w in zip(self.block, self.sigma, self.columns[self.n :], strict=True):
            points[b] |= set(zip(sigma, w, strict=True))
        self.graphs = [Graph(asked.families[block[0]], points[b], str(b)) for b, block in enumerate(asked.blocks)]

    def text(self, claim: str) -> str:
        """The whole file."""
        parts = ["\n".join(graph.lemmas()) for graph in self.graphs]
        parts += [] if self.rests else ["\n".join(self.lemmas())]
        parts.append("\n".join([*self.statement(), *self.proof()]))
        return whole_file(claim, f"counterexample, {self.origin}", LIBRARIES, parts)

    def moved(self) -> int:
        """A state that changes, or of one that stays a part that is not 0."""
        return next(k for k, v in enumerate(self.columns[: self.n]) if any(v) and (self.rests or len(set(v)) > 1))

    def statement(self) -> list[str]:
        """What there is."""
        names = [f"phi{b}" for b in range(len(self.graphs))]
        k, moment, limit = self.moved(), *(("nat", "Un_cv") if self.discrete else ("R", "tends_to"))
        return [
            f"Theorem moves : exists ({' '.join(names)} : R -> R) (x w : nat -> {moment} -> R),",
            *(f"  ({graph.said(name)}) /\\" for graph, name in zip(self.graphs, names, strict=True)),
            *(f"  {text} /\\" for text in equations(self.loop, [names[b] for b in self.block])),
            f"  ~ {limit} (x {k}%nat) 0." if self.rests else f"  forall c, ~ Un_cv (x {k}%nat) c.",
        ]

    def proof(self) -> list[str]:
        """Its proof."""
        graphs, k = range(len(self.graphs)), self.moved()
        x, w = ("; ".join(f"{name}{i}" for i in range(size)) for name, size in (("x", self.n), ("w", len(self.block))))
        given = f"(fun k => repeated (nth k [{x}] [])), (fun i => repeated (nth i [{w}] []))"
        lines = ["Proof.", f"  exists {', '.join(f'graph{b}' for b in graphs)}, {given}; cbn [nth]."]
        if self.rests:
            z = [[number(v) for v in part] for part in (self.z[0][: self.n], self.z[0][self.n :])]
            given = ", ".join(f"(fun k _ => nth k [{'; '.join(part)}] 0)" for part in z)
            lines[-1] = f"  exists {', '.join(f'graph{b}' for b in graphs)}, {given}; cbn [nth]."
        lines += [f"  split; [exact class{b}|]." for b in graphs]
        for i, b in enumerate(self.block):
            if self.rests:
                s = self.sigma[i][0]
                ends = f"(graph{b} {number(s)}); [symmetry; exact {self.graphs[b].named(s)}|f_equal; lra]"
            else:
                ends = f"(graph{b} (repeated s{i} t)); [symmetry; apply values{i}|f_equal; apply sums{i}]"
            lines.append(f"  split; [intro t; transitivity {ends}|].")
        for j in range(self.n):
            if not self.rests:
                lines.append(f"  split; [exact next{j}|].")
            elif self.discrete:
                lines.append("  split; [intro t; lra|].")
            else:
                same = f"derivable_same (fun _ => {number(self.z[0][j])}) _ t 0"
                lines.append(f"  split; [intro t; apply ({same}); [reflexivity|lra|apply derivable_pt_lim_const]|].")
        if not self.rests:
            return [*lines, f"  {_apart(f'x{k}', self.columns[k])}.", "Qed."]
        half = number(abs(self.z[0][k]) / 2)
        return [
            *lines,
            f"  intro lim; destruct (lim {half} ltac:(lra)) as [T H].",
            f"  specialize (H T ltac:({'lia' if self.discrete else 'lra'})); {'unfold R_dist in H; ' * self.discrete}"
            "apply Rabs_def2 in H; lra.",
            "Qed.",
        ]

    def lemmas(self) -> list[str]:
        """The samples, that the values are those of the nonlinearities, and what follows on them."""
        p, n, sides = len(self.z), self.n, []
        lists = [*((f"x{j}", self.columns[j]) for j in range(n)), *((f"s{i}", v) for i, v in enumerate(self.sigma))]
        lists += [(f"w{i}", column) for i, column in enumerate(self.columns[n:])]
        names = [name for name, _ in lists if name[0] != "s"]
        lines = [reals(name, column) for name, column in lists]
        for i, b in enumerate(self.block):
            values = [f"exact {self.graphs[b].named(v)}" for v in self.sigma[i]]
            lines.append(f"Lemma values{i} : forall t, graph{b} (repeated s{i} t) = repeated w{i} t.")
            lines += _by_samples(p, [f"s{i}", f"w{i}"], values)
        sides += [(f"sums{i}", f"s{i}", "t", row) for i, row in enumerate(self.loop.sigma)]
        sides += [(f"next{j}", f"x{j}", "(S t)", row) for j, row in enumerate(self.loop.then)]
        for name, letter, time, row in sides:
            parts = [f"{number(v)} * repeated {one} t" for v, one in zip(row, names, strict=True) if v]
            lines.append(folded(f"Lemma {name} : forall t, repeated {letter} {time} = {' + '.join(parts) or '0'}."))
            lines += _by_samples(p, list({letter: 0} | dict.fromkeys(names)), ["lra"] * p)
        return lines


def _by_samples(p: int, names: list[str], ends: list[str]) -> list[str]:
    """The proof of what holds at all times, from one period."""
    return [
        "Proof.",
        "  intro t; try change (S t) with (1 + t)%nat.",
        *(f"  rewrite ?(repeated_on {name} 1 t) by discriminate." for name in names),
        "  unfold repeated.",
        *(f"  change (length {name}) with {p}%nat." for name in names),
        f"  set (r := (t mod {p})%nat); assert (small : (r < {p})%nat) by (apply Nat.mod_upper_bound; discriminate).",
        f"  clearbody r; unfold {', '.join(names)}.",
        *(f"  destruct r as [|r]; [cbv [nth Nat.add Nat.modulo Nat.divmod Nat.sub fst snd]; {end}|]." for end in ends),
        "  exfalso; lia.",
        "Qed.",
    ]


def _apart(name: str, column: Vector) -> str:
    """That a list of samples has no limit when it repeats."""
    other = next(i for i, v in enumerate(column) if v != column[0])
    return f"apply (repeated_moves {name} 0 {other}); unfold {name}; cbn [length nth]; [lia|lia|lra]"


def _sum(row: Vector, text: str) -> str:
    """``sum c_k text(k + t)`` of coefficients in descending order, the latest sample first."""
    places = [(len(row) - 1 - i, c) for i, c in enumerate(row) if c]
    return " + ".join(f"{number(c)} * ({text.format(f'({k} + t)%nat')})" for k, c in places) or "0"
