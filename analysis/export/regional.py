"""A set from which every solution tends to 0, in the words of Coq: `regions.v`, and `pieces.v` for a known graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.arithmetic import numbers
from lure.analysis.certificates.channels import Plant, plant, triangle
from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.graphs import Known
from lure.analysis.export.interval import interval_text
from lure.analysis.export.loops import of_states
from lure.analysis.export.quadratic import Forms, Vector, bilinear, forms, less, mix, nonnegative, whole
from lure.analysis.export.words import folded, integers, number, refused, terms, whole_file
from lure.record import described, quantity

MOST_ENTRIES = 20  # states and channels
MOST_DOUBLINGS = 300


@described(frozen=True, kw_only=True)
class _Term:
    """A product ``(u sigma - phi)(phi - v)`` that is not negative on the set."""

    channel: int = quantity("From 0")
    sector: tuple[Fraction, Fraction] | None = quantity(
        "``v = l sigma``, with ``u``; None for a line with limits", default=None
    )
    reach: Fraction = quantity("Up to which ``|sigma|`` the sector holds", default=Fraction(0))
    row: Vector = quantity("``v = e sigma + row x``, for a line with limits")


def regional_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of a region: an ellipsoid, a level set with integrals, or an interval of one state.

    Raises
    ------
    refused
        An ``InputError``: it is a set of another kind, or too large.
    """
    if data["proof"]["method"] == "signs":
        return interval_text(data, claim)
    if data["proof"]["method"] not in ("ellipsoid", "level-set"):
        raise refused(
            "of regions of attraction ellipsoids, level sets, intervals and what attracts everything have an export; "
            "curves have none"
        )
    H = plant(data["system"])
    if len(H.A) + len(H.D) > MOST_ENTRIES:
        raise refused(f"it has {len(H.A)} states and {len(H.D)} channels, together more than {MOST_ENTRIES}")
    return Region(data, H).text(claim)


class Region(FallingTheorem):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], H: Plant) -> None:
        self.read(data, H, "P")
        self.disturb(data["proof"])
        n, m = len(H.A), len(H.D)
        listed = data["proof"].get("integrals", [])
        self.integrals = {one["channel"] - 1: [exact(one[k]) for k in ("theta", "reach", "least")] for one in listed}
        self.terms = [self.term(one) for one in data["multiplier"]["terms"]]
        if len(self.integrals) < len(listed) or not self.terms:
            raise refused("a channel has several integrals, or no channel has a term")
        self.reach: dict[int, Fraction] = {}
        for one in self.terms:
            if one.sector:
                self.reach[one.channel] = min(one.reach, self.reach.get(one.channel, one.reach))
        self.strips = [(H.C[i], reach) for i, (_, reach, _) in self.integrals.items()]
        self.strips += [(one.row, self.known[one.channel].limits()[2]) for one in self.terms if not one.sector]
        for i, reach in self.reach.items():
            self.strips.append(
                (H.C[i], reach - sum((abs(d) * self.most(j)[0] for j, d in enumerate(H.D[i]) if d), Fraction(0)))
            )
        whole_ = [self.integrals.get(i, [Fraction(0)] * 3) for i in range(m)]
        weights = [2 * exact(one["weight"]) for one in data["multiplier"]["terms"]]
        loop = replace(
            self.loop,
            P=self.P,
            rows=[row[:n] for row in self.loop.rows[:n]],
            theta=[theta for theta, *_ in whole_],
            bounds=[(least, least) for *_, least in whole_],
            terms=[(w, *self.factors(one)) for w, one in zip(weights, self.terms, strict=True)],
        )
        units = [[Fraction(j == k) for j in range(n + m + self.count)] for k in range(n + m, n + m + self.count)]
        found = forms(replace(loop, terms=[*loop.terms, *((-1 / self.energy, unit, unit) for unit in units)]))
        if found is not None and self.count:  # the energy is no product of the class
            first = len(self.terms)
            found = replace(found, products=found.products[:first], turn=found.products[first:])
        scaled = None if found is None else _scaled(found, self.strips)
        if scaled is None:
            raise refused("its form does not fall by enough on the set; a slightly smaller set may have an export")
        self.loop, (self.forms, self.level) = loop, scaled

    def read(self, data: Mapping[str, Any], H: Plant, form: str) -> None:
        """Take in plant, nonlinearities, and the form of this name."""
        self.H, self.given = H, data["laws"]["graphs"]
        law = {"sector": ["0", "1"], "slope": None, "odd": False, "linear": False}
        laws = {"channels": [law | {"time_varying": one["kind"] == "sector"} for one in self.given]}
        super().__init__({**data, "laws": laws}, of_states(H.A, H.B, H.C, H.D, discrete=H.discrete))
        self.known = {
            i: Known(name=f"phi{s}", cuts=[*map(exact, one["cuts"])], pieces=[numbers(p) for p in one["pieces"]])
            for i, (s, one) in enumerate(zip(self.own, self.given, strict=True))
            if one["kind"] != "sector"
        }
        self.P = triangle(data["proof"][form], len(H.A))

    def disturb(self, proof: Mapping[str, Any]) -> None:
        """Take disturbances in, of an energy up to a bound, which enter the state and the arguments."""
        self.energy, rows = exact(proof.get("energy", "1")), [numbers(row) for row in proof.get("Bw", [])]
        self.count = len(rows[0]) if rows else 0
        if not rows:
            return
        none = [Fraction(0)] * self.count
        pushed = [numbers(row) for row in proof["Dsigmaw"]] if "Dsigmaw" in proof else [none for _ in self.own]
        then, sigma = (
            [[*row, *more] for row, more in zip(side, given, strict=True)]
            for side, given in ((self.loop.then, rows), (self.loop.sigma, pushed))
        )
        now, phi, units = ([[*row, *none] for row in side] for side in (self.loop.now, self.loop.phi, self.loop.rows))
        self.loop = replace(self.loop, now=now, then=then, phi=phi, sigma=sigma, rows=units)
        self.path = "x w d"

    def entry(self, k: int) -> str:
        """A number of ``z``, of which disturbances are the last."""
        first = self.order + len(self.own)
        return super().entry(k) if k < first else f"d {k - first}%nat t"

    def term(self, one: Mapping[str, Any]) -> _Term:
        """A term of the certificate."""
        i = one["channel"] - 1
        if "sector" in one:
            low, high = numbers(one["sector"])
            return _Term(channel=i, sector=(low, high), reach=exact(one["reach"]), row=[])
        return _Term(channel=i, row=numbers(one["row"]))

    def most(self, i: int) -> tuple[Fraction, str]:
        """A bound of ``|phi|`` on the set, and why it holds."""
        found, s = list[tuple[Fraction, str]](), self.own[i]
        for k, one in enumerate(self.terms):
            if one.channel == i and one.sector is not None:
                size = max(map(abs, one.sector))
                bounds = " ".join(map(number, (one.reach, *one.sector, size)))
                told = f"local{k} E{s}" + " ltac:(lra)" * 4
                found.append((size * one.reach, f"pose proof (local_size {bounds} _ _ _ {told}); lra"))
        if i in self.known and self.known[i].has_limits() and not self.known[i].limits()[0]:
            told = f"pose proof (phi{s}_limited ({self.sigma(i)})) as Q; rewrite E{s} in Q; lra"
            found.append((self.known[i].limits()[3], told))
        return min(found)

    def factors(self, one: _Term) -> tuple[Vector, Vector]:
        """``u sigma - phi`` and ``phi - v`` as rows over ``z``."""
        sigma, phi = self.loop.sigma[one.channel], self.loop.phi[one.channel]
        low, high = one.sector or self.known[one.channel].limits()[:2]
        more = [*one.row, *[Fraction(0)] * (len(sigma) - len(one.row))]
        return less([high * v for v in sigma], Fraction(1), phi), less(less(phi, low, sigma), Fraction(1), more)

    # The statement.

    def definitions(self) -> list[str]:
        """The nonlinearities that are known, the plant, and the function whose set it is."""
        found = [one.definition() for one in self.known.values()]
        found += super().definitions()
        squares = [
            f"{number(v if i == j else 2 * v)} * (x {i}%nat t * x {j}%nat t)"
            for i, row in enumerate(self.P)
            for j, v in enumerate(row[: i + 1])
            if v
        ]
        squares += [f"{number(2 * self.loop.theta[i])} * Phi{self.own[i]} ({self.sigma(i)})" for i in self.turned]
        names = f"({' '.join(f'Phi{self.own[i]}' for i in self.turned)} : R -> R) " * bool(self.turned)
        found.append(f"Definition level {names}({self.path} : {self.kind}) (t : {self.moment}) : R :=")
        return [*found[:-1], found[-1] + "\n  " + folded(" + ".join(squares)).replace("\n", "\n  ") + "."]

    @property
    def turned(self) -> list[int]:
        """The channels with an integral."""
        return [i for i, theta in enumerate(self.loop.theta) if theta]

    def at(self, t: str) -> str:
        """The function at a time."""
        return f"level {''.join(f'Phi{self.own[i]} ' for i in self.turned)}{self.path} {t}"

    def class_of(self, i: int) -> str:
        """What is said of a nonlinearity that is not known."""
        if i in self.known:
            return ""
        (low, high), reach = numbers(self.given[i]["sector"]), exact(self.given[i]["reach"])
        return f"forall t, in_sector_up_to {number(reach)} {number(low)} {number(high)} ({self.phi(i)})"

    def binders(self) -> tuple[str, list[str]]:
        """The nonlinearities that are not known, and integrals."""
        turned = [f"Phi{self.own[i]}" for i in self.turned]
        others = [f"phi{s}" for i, s in enumerate(self.own) if i not in self.known]
        found = f" ({' '.join(turned)} : R -> R)" * bool(turned)
        return found + f" ({' '.join(others)} : {self.moment} -> R -> R)" * bool(others), turned + others

    def hypotheses(self) -> list[tuple[str, str]]:
        """Names and statements."""
        found = [one for one in super().hypotheses() if one[1]]
        start = self.start
        if not self.discrete:
            found += [(f"start{k}", f"continuity_pt (x {k}%nat) 0") for k in range(self.order)]
        for i, (_, reach, _) in self.integrals.items():
            found.append((f"kept{self.own[i]}", f"Rabs (sigma{self.own[i]} {self.path} 0) <= {number(reach)}"))
        if not self.count:
            return [*found, ("within", f"{self.at(start)} <= 1")]
        found += [(f"rest{k}", f"x {k}%nat {start} = 0") for k in range(self.order)]
        bound = f"Ed t - Ed {start} <= {number(self.energy)}"
        if self.discrete:
            return [
                *found,
                ("driven", f"forall t, Ed (S t) = Ed t + ({self.square})"),
                ("energy", f"forall t, {bound}"),
            ]
        found += [("driven", f"forall t, 0 < t -> derivable_pt_lim Ed t ({self.square})")]
        return [*found, ("steady", "continuity_pt Ed 0"), ("energy", f"forall t, 0 <= t -> {bound}")]

    @property
    def start(self) -> str:
        """The time at which solutions start."""
        return "0%nat" if self.discrete else "0"

    @property
    def square(self) -> str:
        """The square of the disturbance."""
        return " + ".join(f"d {k}%nat t ^ 2" for k in range(self.count))

    @property
    def unspent(self) -> tuple[Fraction, str]:
        """A factor, and what the energy that is left adds to ``V`` at a time."""
        factor = self.level / self.energy
        return factor, f"({self.level} - {number(factor)} * (Ed t - Ed {self.start}))"

    def kept(self, t: str) -> str:
        """That a solution is in the set."""
        sides = [f"Rabs (sigma{self.own[i]} {self.path} {t}) <= {number(one[1])}" for i, one in self.integrals.items()]
        return " /\\ ".join([f"{self.at(t)} <= 1", *sides])

    def opening(self) -> list[str]:
        """The statement, and the names of what it is about."""
        binders, names = self.binders()
        told, ends = [f"  ({text}) ->" for _, text in self.hypotheses()], self.conclusions()
        moment = "forall t, " if self.discrete else "forall t, 0 <= t -> "
        more = f" (Ed : {self.moment} -> R)" * bool(self.count)
        lines = [f"Theorem region : forall{binders} ({self.path} : {self.kind}){more},", *told]
        lines += [f"  ({moment}{self.kept('t')}) /\\", "  " + " /\\ ".join(ends) + ".", "Proof."]
        free = [*names, self.path, *["Ed"] * bool(self.count), *(name for name, _ in self.hypotheses())]
        return [*lines, f"  intros {' '.join(free)}."]

    # The proof.

    def text(self, claim: str) -> str:
        """The whole file."""
        libraries = [
            "forms.v",
            "flow.v",
            *["frequencies.v"] * bool(self.known),
            "regions.v",
            *["pieces.v"] * bool(self.known),
        ]
        parts = ["\n".join(self.definitions()), *self.bounds(), self.witness(), self.theorem()]
        return whole_file(claim, f"{self.data['theorem']}, {self.data['proof']['method']}", libraries, parts)

    def bounds(self) -> list[str]:
        """What holds of the nonlinearities that are known."""
        found = []
        for i, one in self.known.items():
            own = [term for term in self.terms if term.channel == i]
            found += [one.local(self.sector_name(term), *term.sector, term.reach) for term in own if term.sector]
            if one.has_limits():
                found.append(one.clipped())
            if i in self.turned:
                theta, reach, least = self.integrals[i]
                found.append(one.bounded(least, reach, 1 if theta > 0 else -1))
        return found

    def sector_name(self, one: _Term) -> str:
        """The name of what is said of a nonlinearity by a term."""
        return f"local{self.terms.index(one)}"

    def witness(self) -> str:
        """The numbers of the proof, and the tests that they pass."""
        lines, f, own = [super().witness()], self.forms, len(self.integrals)
        if self.discrete:
            test = f"Lemma falls : falls_by_steps {f.size} P now next "
            beside = folded(f"Definition turn : list term := {terms(f.turn)}%Z.")
            lines[0] = lines[0].replace(f"{test}products", f"{beside}\n{test}(turn ++ products)")
        rows = [_strip(row, bound, f.unit) for row, bound in self.strips]
        for name, side in (("own", rows[:own]), ("more", rows[own:])):
            listed = "; ".join(f"({integers(row)}, {bound})" for row, bound in side)
            lines.append(folded(f"Definition {name} : list strip := [{listed}]%Z."))
        low = "" if self.discrete else " ++ low"
        test = f"between_strips {f.size} now (bilinear P now now{low}) {self.level} (own ++ more)"
        return "\n".join([*lines, f"Lemma between : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed."])

    def theorem(self) -> str:
        """The statement and its proof."""
        f, V = self.forms, "value (bilinear P now now) (z t)"
        J = self.unspent[1] if self.count else self.rest(-1)
        entries = "; ".join(self.entry(k) for k in range(f.size))
        lines = [*self.opening(), f"  pose (z := fun t : {self.moment} => [{entries}])."]
        sigmas = "".join(f", sigma{s}" for s in self.own) * bool(f.integrals)
        known = V if self.count or self.discrete else f"{V} + {J}"
        lines.append(f"  assert (same : forall t, {known} = {self.level} * {self.at('t')}).")
        lines.append(f"  {{ intro t; rewrite value_bilinear; unfold z, P, now, at_, level{sigmas}.")
        lines.append("    cbn [map dot sumprod]; field. }")
        held, end = f"(forall t, {V} + {J} <= {self.level})", "forall f, In f now -> Un_cv (fun t => dot f (z t)) 0"
        name, inner, strips = "by_steps", "turn", "(own ++ more) z"
        if not self.discrete:
            held = f"(forall t, 0 <= t -> {V} + {J} <= {self.level} /\\ Forall (touched now (z t)) own)"
            end = "forall row, In row rows -> tends_to (fun t => dot row (at_ now (z t))) 0"
            name, inner, strips = "in_time", "rows low turn", "own more z"
            lines += [*self.flowing(), *self.continuous()]
        lines.append(f"  assert (both : {held} /\\\n    ({end})).")
        lines.append(f"  {{ apply (attracted_{name} {f.size} P now next {inner} products {f.times} {self.level}")
        lines += [f"      {strips} (fun t => {J}) falls between).", "  - reflexivity."]
        lines += [*self.stepping(), *self.left()] if self.discrete else ["  - exact F.", "  - exact C.", *self.steady()]
        lines += [] if self.discrete else [*self.below(), *self.turning()]
        lines += [*self.on_the_set(), *self.starting(), "  destruct both as [held all]; split.", *self.staying()]
        return "\n".join([*lines, *self.ends(len(self.conclusions())), "Qed."])

    def left(self) -> list[str]:
        """That the energy that is left, if there are disturbances, is not negative, and what it loses at a step."""
        if not self.count:
            return ["  - intro t; cbv beta; lra.", "  - intro t; cbv beta; unfold turn; simpl; lra."]
        lines = ["  - intro t; cbv beta; pose proof (energy t); lra."]
        return [*lines, "  - intro t; cbv beta; rewrite (driven t); unfold turn, z; cbn [value dot]; field."]

    def continuous(self) -> list[str]:
        """That the state is continuous at the start."""
        lines, unit = ["  assert (C : forall f, In f now -> continuity_pt (fun t => dot f (z t)) 0)."], self.forms.unit
        lines.append(f"  {{ unfold now; intros f [{'|['.join(['<-'] * self.order)}|[]{']' * self.order}.")
        for k in range(self.order):
            lines.append(f"    {{ apply (continuous_same _ (x {k}%nat) {unit}); [|exact start{k}].")
            lines.append("      intro; unfold z; cbn [dot]; field. }")
        return [*lines[:-1], lines[-1] + " }"]

    def steady(self) -> list[str]:
        """That the integrals, or the energy that is left, are."""
        if self.count:
            factor = number(self.unspent[0])
            return [
                f"  - apply (continuity_pt_minus (fun _ => {self.level}) (fun t => {factor} * (Ed t - Ed 0)));",
                "      [apply continuity_pt_const; intros ? ?; reflexivity|].",
                "    apply (continuity_pt_scal (fun t => Ed t - Ed 0)), (continuity_pt_minus Ed (fun _ => Ed 0));",
                "      [exact steady|apply continuity_pt_const; intros ? ?; reflexivity].",
            ]
        lines, mark = [], "  - "
        for i, c, row, q in self.forms.integrals:
            s = self.own[i]
            lines.append(f"{mark}apply (continuity_pt_plus (fun t => {number(c)} * Phi{s} ({self.sigma(i)}))")
            lines.append(f"      (fun t => {self.rest(i)})).")
            lines.append(f"    {{ apply (continuity_pt_scal (fun t => Phi{s} ({self.sigma(i)}))).")
            lines.append(f"      apply (integral_continuous Phi{s} phi{s} (fun t => {self.sigma(i)}) 0 integral{s}).")
            lines.append(
                f"      apply (continuous_same _ (fun t => dot {integers(row)}%Z (at_ now (z t))) (/ {number(q)}));"
            )
            lines.append("        [|now apply row_continuous].")
            lines.append(f"      intro; unfold z, now, at_, sigma{s}; cbn [map dot]; field. }}")
            mark = "    "
        return [*lines, f"{mark}apply continuity_pt_const; intros ? ?; reflexivity."]

    def below(self) -> list[str]:
        """The bound below the integrals, where the strips are kept to."""
        if self.count:
            return ["  - intros t Ht O; simpl; pose proof (energy t Ht); lra."]
        first, *lines = super().below()
        if not lines:
            return [first]
        return ["  - intros t Ht O; unfold own in O.", *self.own_strips(), *lines]

    def turning(self) -> list[str]:
        """The derivative of the integrals, or of the energy that is left."""
        if not self.count:
            return super().turning()
        factor = number(self.unspent[0])
        return [
            "  - intros t Ht.",
            f"    replace (value turn (z t)) with (0 - {factor} * (({self.square}) - 0))",
            "      by (unfold z, turn; cbn [value dot]; field).",
            f"    apply (derivable_pt_lim_minus (fun _ => {self.level}) (fun t => {factor} * (Ed t - Ed 0)));",
            "      [apply derivable_pt_lim_const|].",
            "    apply (derivable_pt_lim_scal (fun t => Ed t - Ed 0)), (derivable_pt_lim_minus Ed (fun _ => Ed 0));",
            "      [now apply driven|apply derivable_pt_lim_const].",
        ]

    def integral_bound(self, i: int, c: Fraction) -> str:
        """The bound of an integral by a square."""
        s = self.own[i]
        return f"(phi{s}_integral Phi{s} integral{s} ({self.sigma(i)}) A{s})"

    def own_strips(self) -> list[str]:
        """The arguments of the integrals, from the list ``O``."""
        lines = []
        for i, (_, reach, _) in self.integrals.items():
            s = self.own[i]
            lines += [
                "    pose proof (Forall_inv O) as Q; apply Forall_inv_tail in O.",
                "    unfold touched, now, z, at_ in Q; cbn [fst snd map dot] in Q; apply abs_within in Q.",
                f"    assert (A{s} : Rabs ({self.sigma(i)}) <= {number(reach)})",
                f"      by (apply Rabs_le; unfold sigma{s}; lra).",
                "    clear Q.",
            ]
        return lines

    def ordered(self) -> list[int]:
        """The channels, each after those that it sees."""
        left, found = set(range(len(self.H.D))), list[int]()
        while left:
            free = [i for i in sorted(left) if not any(self.H.D[i][j] for j in left)]
            found, left = found + free, left - set(free)
        return found

    def combined(self, row: Vector) -> str:
        """A combination of the states."""
        return self.sum(row)

    def on_the_set(self) -> list[str]:
        """That the factors of the terms have the sign they should have between the strips."""
        at, opened = ("t", "  - intros t H;") if self.discrete else ("t Ht", "  - intros t Ht H;")
        lines = [f"{opened} unfold own, more in H; cbn [app] in H."]
        for k, (row, bound) in enumerate(self.strips):
            lines += [
                "    pose proof (Forall_inv H) as Q; apply Forall_inv_tail in H.",
                "    unfold inside, now, z, at_ in Q; cbn [fst snd map dot] in Q; apply Rabs_def2 in Q.",
                f"    assert (T{k} : - {number(bound)} <= {self.combined(row)} <= {number(bound)}) by lra; clear Q.",
            ]
        for i, s in enumerate(self.own):
            lines.append(f"    assert (E{s} : {self.phi(i)} ({self.sigma(i)}) = w {i}%nat t)")
            lines.append(f"      by (symmetry; apply (graph{s} {at})).")
        for k, one in enumerate(self.terms):
            lines += self.sector_held(k, one)
        for i in self.ordered():
            lines += self.sizes(i)
        lines.append("    apply class_nonneg; [reflexivity|]; unfold products; cbn [products_hold].")
        for k, one in enumerate(self.terms):
            lines += self.product(k, one)
        return [*lines, "    exact I."]

    def sector_held(self, k: int, one: _Term) -> list[str]:
        """What the class says of a term."""
        i = one.channel
        if i in self.known or one.sector is None:
            return []
        bounds = " ".join(map(number, (one.reach, *one.sector)))
        own = " ".join(number(exact(v)) for v in (self.given[i]["reach"], *self.given[i]["sector"]))
        lines = [f"    assert (local{k} : in_sector_up_to {bounds} ({self.phi(i)}))"]
        return [*lines, f"      by (apply (wider {own}); [exact (class{self.own[i]} t)|lra|lra|lra])."]

    def sizes(self, i: int) -> list[str]:
        """The bounds of ``sigma`` and ``phi``, which others see."""
        s, lines = self.own[i], []
        if i in self.reach:
            bound = f"Rabs ({self.sigma(i)}) <= {number(self.reach[i])}"
            lines.append(f"    assert (S{s} : {bound}) by (apply Rabs_le; unfold sigma{s}; lra).")
        if any(row[i] for row in self.H.D):
            most, shown = self.most(i)
            lines.append(f"    assert (M{s} : - {number(most)} <= w {i}%nat t <= {number(most)}) by ({shown}).")
        return lines

    def product(self, k: int, one: _Term) -> list[str]:
        """A product that is not negative."""
        i, (a, b) = one.channel, self.forms.factors[k]
        s, w, sigma = self.own[i], f"w {i}%nat t", f"({self.sigma(i)})"
        if one.sector:
            low, high = map(number, one.sector)
            right = f"{w} - {low} * {sigma}"
            shown = f"exact (local_term {number(one.reach)} {low} {high} _ _ _ local{k} E{s} ltac:(lra))"
        else:
            low, high, *_ = map(number, self.known[i].limits())
            row = f"({self.combined(one.row)})"
            right = f"{w} - ({low} * {sigma} + {row})"
            shown = (
                f"pose proof (phi{s}_clipped {sigma} {row} ltac:(apply Rabs_le; lra)) as Q; rewrite E{s} in Q; exact Q"
            )
        opened = f"unfold z, sigma{s}; cbn [dot]; field"
        return [
            f"    split; [apply (part {a} {b} ({high} * {sigma} - {w}) ({right}));",
            f"      [{opened}|{opened}|lra|lra|{shown}]|].",
        ]

    def starting(self) -> list[str]:
        """That the solution starts in the set."""
        lines = [f"  - cbv beta; rewrite (same {self.start}); lra."]
        if self.count:
            rests = ", ".join(f"?rest{k}" for k in range(self.order))
            lines = [f"  - cbv beta; rewrite (same {self.start}).", f"    replace ({self.at(self.start)}) with 0"]
            lines[-1] += f" by (unfold level; rewrite {rests}; field); lra."
        if not self.discrete:
            lines.append("  - unfold own.")
            for i in self.integrals:
                s = self.own[i]
                lines.append(
                    "    apply Forall_cons; [unfold touched, now, z, at_; cbn [fst snd map dot]; apply Rabs_le;"
                )
                lines.append(f"      apply abs_within in kept{s}; unfold sigma{s} in kept{s}; lra|].")
            lines.append("    apply Forall_nil.")
        return [*lines[:-1], lines[-1] + " }"]

    def staying(self) -> list[str]:
        """That it stays there."""
        spent = f"pose proof (energy t{' Ht' * (not self.discrete)}); " * bool(self.count)
        if self.discrete:
            return [f"  {{ intro t; pose proof (held t) as B; {spent}rewrite same in B; lra. }}"]
        lines = [f"  {{ intros t Ht; destruct (held t Ht) as [B O]; {spent}rewrite same in B; unfold own in O."]
        lines += self.own_strips()
        names = [f"O{self.own[i]}" for i in self.integrals]
        return [
            *lines,
            *(f"    split; [lra|]; {'repeat split; '}assumption. }}" for _ in names[:1]),
            *["    lra. }"] * (not names),
        ]


def _strip(row: Vector, bound: Fraction, unit: int) -> tuple[list[int], int]:
    """A strip with integers, of the state times a whole number."""
    *found, last = whole([*row, bound])[0]
    return found, last * unit


def _scaled(found: Forms, strips: list[tuple[Vector, Fraction]]) -> tuple[Forms, int] | None:
    """``V``, and ``L``, times so much that ``V < L + 1`` lies between the strips; None if there is no such number."""
    more = found.factor.denominator
    for _ in range(MOST_DOUBLINGS):
        level = int(found.factor * more)
        P = [[more * v for v in row] for row in found.P]
        products, low, turn = (
            [(more * c, u, v) for c, u, v in side] for side in (found.products, found.low, found.turn)
        )
        V = [*bilinear(P, found.now, found.now), *low]
        sides = [(mix(row, found.now), bound) for row, bound in (_strip(*one, found.unit) for one in strips)]
        if all(
            nonnegative([*((b * b * c, u, v) for c, u, v in V), (-level - 1, f, f)], found.size)
            for f, b in (([int(v) for v in row], bound) for row, bound in sides)
        ):
            integrals = [(i, more * c, row, q) for i, c, row, q in found.integrals]
            return replace(found, P=P, products=products, low=low, turn=turn, integrals=integrals), level
        more *= 2
    return None
