"""A function ``V`` that falls, and all tends to 0, in the words of Coq: `forms.v`, `flow.v` in continuous time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.states import Family, classes
from lure.analysis.export.laws import Laws
from lure.analysis.export.loops import candidates
from lure.analysis.export.quadratic import Forms, Loop, Vector, forms, less, mix, whole
from lure.analysis.export.words import folded, integers, number, refused, terms, whole_file


def falling_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate that a quadratic form with integrals shows.

    Raises
    ------
    refused
        An ``InputError``: it has no such form, or none of few enough digits was found.
    """
    return fallen(data).text(claim)


def fallen(data: Mapping[str, Any]) -> FallingTheorem:
    """The theorem of a certificate that a quadratic form with integrals shows, and that form.

    Raises
    ------
    refused
        An ``InputError``: it has no such form, or none of few enough digits was found.
    """
    for loop, written in passing(candidates(data)):
        theorem = FallingTheorem(data, loop)
        theorem.forms = written
        return theorem
    raise refused("no quadratic form of few enough digits was found; a slightly smaller sector may have one")


class FallingTheorem(Laws):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], loop: Loop) -> None:
        self.data, self.loop = data, loop
        several = isinstance(data["laws"], dict) and "channels" in data["laws"]
        given = data["laws"]["channels"] if several else [data["laws"]]
        self.families: list[Family] = [classes(one, several=several) for one in given]
        self.transfer, self.discrete = data["system"]["kind"] == "transfer", loop.discrete
        m, self.order = len(loop.phi), len(loop.now)
        self.own = [str(i + 1) if m > 1 else "" for i in range(m)]
        self.moment = "nat" if self.discrete else "R"
        self.path = "xi" if self.transfer else "x w"
        self.kind = "nat -> R" if self.transfer and self.discrete else f"nat -> {self.moment} -> R"

    def entry(self, k: int) -> str:
        """A number of ``z``."""
        if self.transfer:
            return (f"xi ({k} + t)%nat" if k else "xi t") if self.discrete else f"xi {k}%nat t"
        return f"x {k}%nat t" if k < self.order else f"w {k - self.order}%nat t"

    def sum(self, row: Sequence[Fraction | int]) -> str:
        """A linear combination of the numbers of ``z``, the highest derivative first."""
        places = range(len(row))
        found = [
            f"{number(row[k])} * {self.entry(k)}" for k in (reversed(places) if self.transfer else places) if row[k]
        ]
        return " + ".join(found) or "0"

    def value(self, i: int) -> str:
        """What stands for its value."""
        return f"(- den {self.path} t)" if self.transfer else f"(w {i}%nat t)"

    def later(self, text: str) -> str:
        """For all times."""
        return f"forall t, {text}" if self.discrete else f"forall t, 0 < t -> {text}"

    def definitions(self) -> list[str]:
        """The plant."""
        binder = f"({self.path} : {self.kind}) (t : {self.moment}) : R"
        found = []
        if self.transfer:
            found.append(f"Definition den {binder} :=\n  {self.sum([-v for v in self.loop.phi[0]])}.")
        for i, row in enumerate(self.loop.sigma):
            found.append(f"Definition sigma{self.own[i]} {binder} :=\n  {self.sum(row)}.")
        return found

    def hypotheses(self) -> list[tuple[str, str]]:
        """Names and statements."""
        found = [("bound", f"{number(self.loop.bounds[0][0])} < K")] * self.loop.each
        slopes = dict.fromkeys((f"slopes{end}", text) for end, text, _ in self.sloped())
        rest = {s for *_, s in self.sloped()}
        found += [*slopes, *((f"class{s}", self.class_of(i)) for i, s in enumerate(self.own) if s not in rest)]
        for i, s in enumerate(self.own):
            if self.loop.theta[i]:
                found.append((f"integral{s}", f"integral_of Phi{s} {self.phi(i)}"))
        if not self.transfer:
            found += [
                (f"graph{s}", self.later(f"w {i}%nat t = {self.phi(i)} ({self.sigma(i)})"))
                for i, s in enumerate(self.own)
            ]
            for k, row in enumerate(self.loop.then):
                if self.discrete:
                    found.append((f"step{k}", f"forall t, x {k}%nat (S t) = {self.sum(row)}"))
                else:
                    found.append((f"flow{k}", self.later(f"derivable_pt_lim (x {k}%nat) t ({self.sum(row)})")))
            return found
        if not self.discrete:
            text = f"(k < {self.order})%nat -> 0 < t -> derivable_pt_lim (xi k) t (xi (S k) t)"
            found.append(("derivatives", f"forall k t, {text}"))
        found.append(("closed", self.later(f"den xi t = - {self.phi(0)} ({self.sigma(0)})")))
        return found

    def conclusions(self) -> list[str]:
        """What tends to 0."""
        found = []
        for row in self.loop.rows[: 1 if self.transfer and self.discrete else None]:
            places = [k for k, v in enumerate(row) if v]
            if places == [k for k in places if row[k] == 1] and len(places) == 1:
                text = self.entry(places[0]).removesuffix(" t")
                text = text if text == "xi" else f"({text})"
            else:
                text = f"(fun t => {self.sum([*row, *[Fraction(0)] * (len(self.loop.now[0]) - self.order)])})"
            found.append(f"Un_cv {text} 0" if self.discrete else f"tends_to {text} 0")
        return found

    def text(self, claim: str) -> str:
        """The whole file."""
        origin = f"{self.data['theorem']}, {self.data['proof']['method']}"
        return whole_file(claim, origin, self.libraries(), self.parts())

    def libraries(self) -> tuple[str, ...]:
        """The files with what the proof uses."""
        more = ["flow.v"] * (not self.discrete) + ["steps.v" if self.discrete else "critical.v"] * (
            self.loop.rest is not None
        )
        return ("forms.v", *more, *self.blocked())

    def blocked(self) -> list[str]:
        """The files that a block needs."""
        if self.one_law:
            return ["flow.v", "frequencies.v", "cones.v", "orders.v", "slopes.v", "coupled.v"]
        return ["cones.v", "blocks.v"] * bool(self.forms.block) + ["slopes.v"] * self.sharp

    def parts(self) -> list[str]:
        """The plant, the witness and the theorem."""
        return ["\n".join(self.definitions()), self.witness(), self.theorem()]

    def witness(self) -> str:
        """The numbers of the proof, and the test that they pass."""
        f = self.forms
        lists = [("P", f.P), ("now", f.now), ("next", f.then)] + [("rows", f.rows)] * (not self.discrete)
        lists += [("small", f.small)] * (self.discrete and self.small == "small")
        found = [f"Definition {name} : list (list Z) := {integers(rows)}%Z." for name, rows in lists]
        sides = [("products", f.products)] * (not f.block) + [("low", f.low), ("turn", f.turn)] * (not self.discrete)
        found += [f"Definition {name} : list term := {terms(given)}%Z." for name, given in sides]
        found += self.box()
        test = (
            f"falls_by_steps {f.size} P now next products {f.times} {self.small}"
            if self.discrete
            else f"falls_in_time {f.size} P now next rows low turn products {f.times}"
        )
        if self.loop.each:
            ((c, psi, argument),) = f.products
            found[-3:] = [one for one in found[-3:] if not one.startswith("Definition products")]
            found += [
                f"Definition {name} : list Z := {integers(row)}%Z."
                for name, row in (("psi", psi), ("argument", argument))
            ]
            test = f"falls_for_each_bound {f.size} P now next rows low turn {c} psi argument {f.times} {f.beside}"
        lines = ["(* V = x^T P x, and integrals, falls: by Lagrange's reduction of two quadratic forms. *)", *found]
        lines.append(f"Lemma falls : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.")
        return "\n".join(one if "\n" in one else folded(one) for one in lines)

    def binders(self) -> tuple[str, list[str]]:
        """The nonlinearities and their integrals, with their types, and their names alone."""
        named = range(1 if self.one_law else len(self.own))
        phis = [self.phi(i) for i in named if not self.families[i].varying]
        phis += [f"Phi{s}" for i, s in enumerate(self.own) if self.loop.theta[i]]
        varying = [f"phi{s}" for i, s in enumerate(self.own) if self.families[i].varying]
        found = f" ({' '.join(phis)} : R -> R)" * bool(phis)
        found += f" ({' '.join(varying)} : {self.moment} -> R -> R)" * bool(varying)
        return " (K : R)" * self.loop.each + found, ["K"] * self.loop.each + phis + varying

    def opening(self) -> list[str]:
        """The statement, and the names of what it is about."""
        binders, names = self.binders()
        told = [f"  ({text}) ->" for _, text in self.hypotheses()]
        ends = [" /\\ ".join(self.conclusions())] * bool(self.conclusions()) + self.resting()
        lines = [f"Theorem stable : forall{binders} ({self.path} : {self.kind}),", *told]
        lines += ["  " + " /\\\n  ".join(ends) + ".", "Proof."]
        return [*lines, *self.introduced([*names, self.path])]

    def introduced(self, names: list[str]) -> list[str]:
        """The names of all that is given, and the sectors of slope bounds."""
        lines = [f"  intros {' '.join([*names, *(name for name, _ in self.hypotheses())])}."]
        return lines + [f"  pose proof (slopes_sector _ _ _ _ slopes{end}) as class{s}." for end, _, s in self.sloped()]

    def theorem(self) -> str:
        """The statement and its proof."""
        lines = self.opening()
        entries = "; ".join(self.entry(k) for k in range(self.forms.size))
        lines.append(f"  pose (z := fun t : {self.moment} => [{entries}]).")
        lines += self.by_steps() if self.discrete else self.in_time()
        lines += self.ends(len(self.conclusions()))
        return "\n".join([*lines, *self.rested(), "Qed."])

    def products(self) -> list[str]:
        """That the factors of the class have the sign they should have."""
        if self.one_law:
            return self.coupled()
        if self.forms.block:
            return self.blocks()
        opened = (
            "unfold z, den, sigma; cbn [dot]"
            if self.transfer
            else f"unfold z, {', '.join('sigma' + s for s in self.own)}; cbn [dot]"
        )
        lines = [
            f"  - {'intro t' if self.discrete else 'intros t Ht'}; apply class_nonneg; [reflexivity|].",
            "    unfold products; cbn [products_hold].",
        ]
        at = "t" if self.discrete else "t Ht"
        for i, s in enumerate(self.own):
            (low, high), (a, b), value = self.loop.bounds[i], self.forms.factors[i], self.value(i)
            shown = f"rewrite (closed {at}); ring" if self.transfer else f"symmetry; apply (graph{s} {at})"
            lines.append(f"    assert (E{s} : {self.phi(i)} ({self.sigma(i)}) = {value}) by ({shown}).")
            name = "half_line" if high == INF else "sector"
            bounds = number(low) if high == INF else f"{number(low)} {number(Fraction(high))}"
            held = f"(class{s} t)" if self.families[i].varying else f"class{s}"
            lines.append(
                f"    pose proof ({name} {bounds} ({self.phi(i)}) ({self.sigma(i)}) {value} {held} E{s}) as C{s}."
            )
            right = f"({self.sigma(i)})" if high == INF else f"({number(Fraction(high))} * ({self.sigma(i)}) - {value})"
            left = f"({value} - {number(low)} * ({self.sigma(i)}))"
            lines.append(f"    split; [apply (part {a} {b} {left} {right});")
            lines.append(f"      [{opened}; field|{opened}; field|lra|lra|exact C{s}]|].")
        return [*lines, "    exact I. }"]

    def by_steps(self) -> list[str]:
        """Discrete time."""
        f, small = self.forms, self.small
        lines = [f"  assert (lim := by_steps {f.size} P now next products {f.times} {small} z falls)."]
        lines.append(f"  assert (all : forall f, In f {small} -> Un_cv (fun t => dot f (z t)) 0).")
        lines.append("  { apply lim; clear lim.")
        return [*lines, "  - reflexivity.", *self.stepping(), *self.products()]

    @property
    def small(self) -> str:
        """The name of what tends to 0 in discrete time."""
        return "now" if len(self.loop.rows) == self.order else "small"

    def stepping(self) -> list[str]:
        """That the next state is what it should be."""
        lines = ["  - intro t; unfold z, now, next, at_; cbn [map dot Nat.add]."]
        for k in range(self.order):
            use = "" if self.transfer else f"rewrite step{k}; "
            lines.append(f"    apply (f_equal2 cons); [{use}field|].")
        return [*lines, "    reflexivity."]

    def flowing(self) -> list[str]:
        """That the state has the derivative that it should have."""
        f = self.forms
        lines = ["  assert (F : flows z now next).", "  { unfold flows, now, next."]
        for k in range(self.order):
            use = "apply derivatives; [lia|exact Ht]" if self.transfer else f"apply (flow{k} t Ht)"
            name = f"(xi {k}%nat)" if self.transfer else f"(x {k}%nat)"
            end = f"(xi {k + 1}%nat t)" if self.transfer else f"({self.sum(self.loop.then[k])})"
            lines.append("    apply Forall2_cons; [intros t Ht|].")
            lines.append(f"    {{ apply (derivable_same (fun t => {f.unit} * {name} t) _ t ({f.unit} * {end}));")
            lines.append("      [intro; unfold z; cbn [dot]; field|unfold z; cbn [dot]; field|].")
            lines.append(f"      apply (derivable_pt_lim_scal {name}); {use}. }}")
        return [*lines, "    apply Forall2_nil. }"]

    def in_time(self) -> list[str]:
        """Continuous time."""
        f = self.forms
        integrals = self.rest(-1)
        lines = self.flowing()
        name, more = f"in_time {f.size} P now next rows low turn products {f.times} z", ""
        if self.loop.each:
            (a, b), low = f.factors[0], number(self.loop.bounds[0][0])
            name = f"in_time_for_each_bound {f.size} P now next rows low turn {f.products[0][0]} psi argument {f.times}"
            name, more = f"{name} {f.beside} z", f" ({b} / ({a} * (K - {low})))"
        lines.append(f"  assert (lim := {name}\n    (fun t => {integrals}){more} falls).")
        lines.append("  assert (all : forall row, In row rows -> tends_to (fun t => dot row (at_ now (z t))) 0).")
        lines.append("  { apply lim; clear lim.")
        lines += ["  - reflexivity.", "  - exact F.", *self.below(), *self.turning()]
        return lines + (self.for_each() if self.loop.each else self.products())

    def for_each(self) -> list[str]:
        """That the product of the class has the sign it should have for each upper bound."""
        (a, b), low, value = self.forms.factors[0], number(self.loop.bounds[0][0]), self.value(0)
        opened = (
            "unfold z, psi, argument, den, sigma; cbn [dot]"
            if self.transfer
            else "unfold z, psi, argument, sigma; cbn [dot]"
        )
        shown = "rewrite (closed t Ht); ring" if self.transfer else "symmetry; apply (graph t Ht)"
        held = "(class t)" if self.families[0].varying else "class"
        return [
            "  - apply Rdiv_lt_0_compat; [lra|apply Rmult_lt_0_compat; lra].",
            "  - intros t Ht.",
            f"    assert (E : {self.phi(0)} ({self.sigma(0)}) = {value}) by ({shown}).",
            f"    apply (each_bound {low} K ({self.phi(0)}) ({self.sigma(0)}) {value} {a} {b} _ _ bound {held} E);",
            "      [lra|lra| |];",
            f"      {opened}; field. }}",
        ]

    def below(self) -> list[str]:
        """The bound below the integrals."""
        return self.beside("low")

    def beside(self, name: str) -> list[str]:
        """The bound below the integrals, ``low``, or above them, ``high``."""
        if not self.forms.integrals:
            return ["  - intros; simpl; lra."]
        lines, parts, sign = ["  - intros t Ht."], [], 1 if name == "low" else -1
        for i, c, *_ in self.forms.integrals:
            low, high = self.loop.bounds[i]
            end = number(low if sign * c > 0 else Fraction(high))
            at = f"({self.sigma(i)} * {self.sigma(i)})"
            if self.sharp:
                high, psi = Fraction(high), f"({self.value(i)} - {number(low)} * {self.sigma(i)})"
                square, more = f"{number(1 / (2 * (high - low)))} * ({psi} * {psi})", ""
                more = f"{psi} * {self.sigma(i)} - {square}" if sign * c < 0 else square
                parts.append(f"({number(c)} * ({number(low)} / 2 * {at} + {more})")
                continue
            parts.append(f"({number(c)} * ({end} / 2 * {at})")
        sigmas = ", ".join(f"sigma{s}" for s in self.own)
        lines.append(f"    replace (value {name} (z t)) with ({' + '.join(parts)} + 0{')' * len(parts)})")
        lines.append(f"      by (unfold z, {name}, {sigmas}; cbn [value dot]; field).")
        for i, c, *_ in self.forms.integrals:
            if self.sharp:
                given = f"slopes{self.own[i] * (not self.one_law)} ltac:(lra) integral{self.own[i]}"
                value = f"(eq_sym (graph{self.own[i]} t Ht))"
                lines.append(f"    pose proof (integral_between _ _ _ _ _ _ _ {given} {value}) as B{self.own[i]}.")
                continue
            lines.append(f"    pose proof {self.integral_bound(i, sign * c)} as B{self.own[i]}.")
        return [*lines, "    lra."]

    def integral_bound(self, i: int, c: Fraction) -> str:
        """The bound of an integral by a square."""
        s, name = self.own[i], "primitive_above" if c > 0 else "primitive_below"
        bound = number(self.loop.bounds[i][0] if c > 0 else Fraction(self.loop.bounds[i][1]))
        return (
            f"({name} Phi{s} {self.phi(i)} {bound} integral{s} (fun y => {self.side(i, c)})\n      ({self.sigma(i)}))"
        )

    def side(self, i: int, c: Fraction) -> str:
        """The half of the class that bounds an integral."""
        s = self.own[i]
        if self.loop.bounds[i][1] == INF and not self.loop.each:
            return f"proj2 class{s} y"
        return f"proj{1 if c > 0 else 2} (proj2 class{s} y)"

    def turning(self) -> list[str]:
        """Their derivative."""
        if not self.forms.integrals:
            return ["  - intros; simpl; apply derivable_pt_lim_const."]
        lines, parts, steps = ["  - intros t Ht."], [], []
        for i, c, row, q in self.forms.integrals:
            s = self.own[i]
            slope = f"(dot {integers(row)}%Z (at_ next (z t)) / {number(q)})"
            parts.append(f"({number(c)} * ({self.value(i)} * {slope})")
            at = "t Ht"
            shown = f"rewrite (closed {at}); ring" if self.transfer else f"symmetry; apply (graph{s} {at})"
            lines.append(f"    assert (E{s} : {self.phi(i)} ({self.sigma(i)}) = {self.value(i)}) by ({shown}).")
            steps.append(
                f"    apply (derivable_pt_lim_plus (fun t => {number(c)} * Phi{s} ({self.sigma(i)}))\n"
                f"      (fun t => {self.rest(i)}))."
            )
            steps.append(f"    {{ apply (derivable_pt_lim_scal (fun t => Phi{s} ({self.sigma(i)}))); rewrite <- E{s}.")
            steps.append(
                f"      apply (chain Phi{s} {self.phi(i)} (fun t => {self.sigma(i)}) z now next {integers(row)}%Z\n"
                f"        {number(q)} F (proj2 integral{s}));"
            )
            steps.append(f"        [intro; unfold z, now, at_, sigma{s}; cbn [map dot]; field|lra|exact Ht]. }}")
        opened = "unfold z, turn, next, at_" + ", den" * self.transfer
        lines.append(f"    replace (value turn (z t)) with ({' + '.join(parts)} + 0{')' * len(parts)})")
        lines.append(f"      by ({opened}; cbn [value map dot]; field).")
        return [*lines, *steps, "    apply derivable_pt_lim_const."]

    def rest(self, i: int) -> str:
        """The integrals after one."""
        after = [(j, c) for j, c, *_ in self.forms.integrals if j > i]
        return " + ".join(f"({number(c)} * Phi{self.own[j]} ({self.sigma(j)})" for j, c in after) + (
            " + 0" + ")" * len(after) if after else "0"
        )

    def ends(self, count: int) -> list[str]:
        """Each conclusion from that of a row."""
        lines, unit = [], self.forms.unit
        for k in range(count):
            if k < count - 1 or self.loop.rest:
                lines.append("  apply conj.")
            row = self.forms.rows[k] if not self.discrete else self.forms.small[k]
            size = unit * max(1, self.scale(k))
            of = f"dot {integers(row)}%Z (z t)" if self.discrete else f"dot {integers(row)}%Z (at_ now (z t))"
            name, member = ("Un_cv_part", self.small) if self.discrete else ("tends_to_part", "rows")
            opened = f"unfold z{', now, at_' * (not self.discrete)}; cbn [map dot Nat.add]; field"
            lines.append(f"  {{ apply ({name} {size} _ (fun t => {of})); [lra|intro; {opened}|].")
            lines.append(
                f"    apply all; unfold {member}; {'do ' + str(k) + ' right; ' if k else ''}left; reflexivity. }}"
            )
        return lines

    def scale(self, k: int) -> int:
        """By which a row of ``rows`` is multiplied to be one of integers."""
        one, own = self.forms.rows[k], self.loop.rows[k]
        return next(int(v / u) for v, u in zip(one, own, strict=True) if u)

    # An eigenvalue 0, or 1: the state converges to a multiple of one vector, an equilibrium.

    def resting(self) -> list[str]:
        """That the state converges, and where to."""
        if self.loop.rest is None:
            return []
        right, *_ = self.loop.rest
        size = number(_dot(self.loop.sigma[0], right))
        if self.transfer:
            whole_den = -sum(self.loop.phi[0], Fraction(0)) if self.discrete else -self.loop.phi[0][0]
            found = ["Un_cv xi c" if self.discrete else "tends_to (xi 0%nat) c"]
            told = [f"{number(whole_den)} * c = - phi ({size} * c)"]
        else:
            found = [f"tends_to (x {k}%nat) ({number(v)} * c)" for k, v in enumerate(right)]
            at = [(number(_dot(row, right)), number(-row[self.order])) for row in self.loop.then]
            told = [f"{a} * c = {b} * phi ({size} * c)" for a, b in at if (a, b) != ("0", "0")]
        count = len(found)
        if not self.families[0].varying:
            found.append("((forall y, continuity_pt phi y) -> " + " /\\ ".join(told) + ")")
        return ["exists c, " + " /\\\n    ".join([" /\\ ".join(found[:count]), *found[count:]])]

    def rested(self) -> list[str]:
        """The proof: ``zeta = g y x`` changes by ``-r (phi - l sigma)``, and ``sigma - zeta`` tends to 0."""
        if self.loop.rest is None:
            return []
        right, left, _ = self.loop.rest
        sigma, low = self.loop.sigma[0][: self.order], self.loop.bounds[0][0]
        size, said = _dot(sigma, right), f"(fun t => {self.sigma(0)})"
        zeta = [size / _dot(left, right) * v for v in left]
        change = mix(zeta, self.loop.then)
        if self.discrete:
            change = less(change, Fraction(1), [*zeta, *[Fraction(0)] * (len(change) - self.order)])
        psi = less(self.loop.phi[0], low, self.loop.sigma[0])
        r = next(-a / b for a, b in zip(change, psi, strict=True) if b)
        opened = f"sigma{', den' * self.transfer}"
        near, m = self.vanishing(less(sigma, Fraction(1), zeta))
        at, always, by, name = "t Ht", "0 < t -> ", "tends_by", "converges_to_rest"
        if self.discrete:
            at, always, by, name = "t", "", "steps_by", "rests_by_steps"
        shown = f"rewrite (closed {at}); ring" if self.transfer else f"symmetry; apply (graph {at})"
        side = "(class t)" if self.families[0].varying else "class"
        side = f"(proj2 {side} ({self.sigma(0)}))"
        if self.loop.bounds[0][1] != INF or self.loop.each:
            side = f"(proj1 {side})"
        seen, held = self.seen()
        lines = [
            f"  pose proof ({held}) as vanish.",
            f"  assert (G : forall t, {always}{self.phi(0)} ({self.sigma(0)}) = {self.value(0)})",
            f"    by (intros {at}; {shown}).",
            f"  destruct ({name} (fun t => {self.sum(zeta)}) {said}",
            f"    (fun t => {self.value(0)}) {number(low)} {number(r)} ltac:(lra)) as [c [limit rest]].",
            *self.changing(zeta),
            f"  {{ intros {at}; pose proof {side} as B; rewrite (G {at}) in B; lra. }}",
            f"  {{ apply ({by} 0 {m} {near} {near} _ 0 0); [|ring|apply vanish|apply vanish].",
            f"    intro; unfold {seen}, at_, {opened}; cbn [map dot Nat.add]; field. }}",
            f"  exists (/ {number(size)} * c).",
        ]
        count = 1 if self.transfer else self.order
        for k, v in enumerate(right[:count]):
            unit = [Fraction(j == k) for j in range(self.order)]
            near, m = self.vanishing(less(unit, v / size, sigma))
            lines += ["  apply conj."] * (k < count - 1 or not self.families[0].varying)
            lines += [
                f"  {{ apply ({by} {number(v / size)} {m} {said} {near} _ c _); [|field|exact limit|apply vanish].",
                f"    intro; unfold {seen}, at_, {opened}; cbn [map dot Nat.add]; field. }}",
            ]
        if self.families[0].varying:
            return lines
        lines.append("  intro continuous; pose proof (rest phi G continuous) as R.")
        lines.append(f"  replace ({number(size)} * (/ {number(size)} * c)) with c by field; rewrite R.")
        return [*lines, "  repeat apply conj; field."]

    def seen(self) -> tuple[str, str]:
        """What the combinations that tend to 0 are made of, and the proof that all of them do."""
        if self.discrete:
            return "z, small", "steps_vanish z small all"
        return "z, now, rows", "rows_vanish (fun t => at_ now (z t)) rows all"

    def changing(self, zeta: Vector) -> list[str]:
        """How ``zeta`` changes; in discrete time, of a transfer function, also that ``phi - l sigma`` tends to 0."""
        opened = f"sigma{', den' * self.transfer}"
        if self.discrete:
            (_, psi, _), (a, _) = self.forms.products[0], self.forms.factors[0]
            of, last = f"(fun t => dot {integers(psi)}%Z (z t))", len(self.forms.small) - 1
            place = f"unfold small; {f'do {last} right; ' * bool(last)}left; reflexivity"
            return [
                f"  {{ intro t; unfold {opened}; cbn [Nat.add]; field. }}",
                f"  {{ apply (steps_by 0 (/ {a}) {of} {of} _ 0 0); [|ring|apply all; {place}|apply all; {place}].",
                f"    intro; unfold z, {opened}; cbn [dot Nat.add]; field. }}",
            ]
        row, q = whole(zeta)
        of, q = f"dot {integers(row)}%Z", q * self.forms.unit
        return [
            f"  {{ intros t Ht; apply (derivable_same (fun t => / {q} * {of} (at_ now (z t))) _ t",
            f"      (/ {q} * {of} (at_ next (z t))));",
            "      [intro; unfold z, now, at_; cbn [map dot]; field",
            f"      |unfold z, next, at_, {opened}; cbn [map dot]; field|].",
            f"    apply (derivable_pt_lim_scal (fun t => {of} (at_ now (z t)))).",
            "    apply (flow_row z now next); [exact F|exact Ht]. }",
        ]

    def vanishing(self, form: Vector) -> tuple[str, str]:
        """A combination of the state that tends to 0: of ``rows`` with integers, and by what it is multiplied."""
        assert self.loop.rest is not None, "there is an eigenvalue 0"
        others = [v for j, v in enumerate(form) if j != self.loop.rest[2]]
        row, q = whole(v / self.scale(k) for k, v in enumerate(others))
        of = "at_ small (z t)" if self.discrete else "at_ rows (at_ now (z t))"
        return f"(fun t => dot {integers(row)}%Z ({of}))", number(Fraction(1, q * self.forms.unit))


def passing(loops: Iterator[Loop]) -> Iterator[tuple[Loop, Forms]]:
    """Those whose ``V`` passes the test."""
    for loop in loops:
        written = forms(loop)
        if written is not None:
            yield loop, written


def _dot(u: Vector, v: Vector) -> Fraction:
    """``u . v`` for as many entries as both have."""
    return sum((a * b for a, b in zip(u, v, strict=False)), Fraction(0))
