"""A gain from ``w`` to ``z`` in the words of Coq: ``V`` rises by no more than ``w`` lets it: `gains.v`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.export.falling import FallingTheorem
from lure.analysis.export.kernelled import KernelGain
from lure.analysis.export.loops import candidates
from lure.analysis.export.quadratic import Forms, Loop, bilinear, nonnegative, whole_loop
from lure.analysis.export.words import folded, integers, number, refused, terms, whole_file


def has_gain(data: Mapping[str, Any]) -> bool:
    """Whether a certificate is about the gain from ``w`` to ``z``."""
    laws = data["laws"]
    return isinstance(laws, dict) and "channels" in laws and laws["channels"][-1].get("operator") == "performance"


def gaining_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for a certificate of a gain.

    Raises
    ------
    refused
        An ``InputError``: it is of another criterion, or no form of few enough digits was found.
    """
    if data["theorem"] == "matrix-zames-falb":
        return KernelGain(data).text(claim)
    if not data["theorem"].startswith(("diagonal", "full-block")):
        raise refused(f"a gain by {data['theorem']} has no export; by diagonal and full-block multipliers it has one")
    for given in candidates(data):
        loop = with_inputs(given, _outputs(data))
        found = _bounded(loop)
        if found is not None:
            return _Gain(data, loop, found).text(claim)
    raise refused("no quadratic form of few enough digits was found; a slightly larger gain may have one")


def _outputs(data: Mapping[str, Any]) -> int:
    """How many channels lead from ``z`` to ``w``."""
    return sum(one.get("operator") == "performance" for one in data["laws"]["channels"])


def with_inputs(loop: Loop, count: int) -> Loop:
    """The loop with ``w`` in place of ``-mu`` in the last channels, which is ``-phi`` for no class.

    ``loop``: of states and all channels; ``count``: how many of them lead from ``z`` to ``w``.
    """
    first = len(loop.now[0]) - count
    then, sigma = (
        [[-v if j >= first else v for j, v in enumerate(row)] for row in side] for side in (loop.then, loop.sigma)
    )
    return replace(loop, then=then, sigma=sigma)


def _bounded(loop: Loop) -> Forms | None:
    """The forms of a loop, None if they do not pass the test."""
    found = whole_loop(loop)
    if found is None:
        return None
    size, P, now, then = found.size, found.P, found.now, found.then
    S, V = [(-c, u, v) for c, u, v in found.products], bilinear(P, now, now)
    if loop.discrete:
        falls = [*V, *bilinear(P, then, then, -1), *S]
    else:
        turn = [(-c, u, v) for c, u, v in found.turn]
        falls = [*bilinear(P, now, then, -1), *bilinear(P, then, now, -1), *turn, *S]
    return found if nonnegative([*V, *found.low], size) and nonnegative(falls, size) else None


class _Gain(FallingTheorem):
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any], loop: Loop, written: Forms) -> None:
        super().__init__(data, loop)
        self.forms, m, count = written, len(loop.phi), _outputs(data)
        self.first = m - count
        self.own = [str(i + 1) if self.first > 1 else "" for i in range(self.first)]
        self.outputs = [f"output{k + 1 if count > 1 else ''}" for k in range(count)]
        self.ease = Fraction(loop.bounds[-1][1]) ** 2  # 1/gamma^2
        self.share = written.products[-1][0] * written.factors[-1][0] * written.factors[-1][1]

    def definitions(self) -> list[str]:
        """The plant."""
        binder = f"({self.path} : {self.kind}) (t : {self.moment}) : R"
        names = [*(f"sigma{s}" for s in self.own), *self.outputs]
        return [
            f"Definition {name} {binder} :=\n  {self.sum(row)}."
            for name, row in zip(names, self.loop.sigma, strict=True)
        ]

    def text(self, claim: str) -> str:
        """The whole file."""
        origin = f"{self.data['theorem']} of a gain, {self.data['proof']['method']}"
        libraries = ("forms.v", "flow.v", "gains.v", *self.blocked())
        return whole_file(claim, origin, libraries, ["\n".join(self.definitions()), self.witness(), self.theorem()])

    def witness(self) -> str:
        """The numbers of the proof, and the test that they pass."""
        f = self.forms
        lists, sides = (("P", f.P), ("now", f.now), ("next", f.then)), [("supply", f.products[-len(self.outputs) :])]
        sides += [] if f.block else [("products", f.products[: self.first])]
        sides += [] if self.discrete else [("low", f.low), ("turn", f.turn)]
        lines = [
            "(* V = x^T P x, and integrals, rise by less than w lets them, by Lagrange's reduction of two forms. *)"
        ]
        lines += [f"Definition {name} : list (list Z) := {integers(rows)}%Z." for name, rows in lists]
        lines += [f"Definition {name} : list term := {terms(given)}%Z." for name, given in sides]
        lines += self.box()
        inner = "supply products" if self.discrete else "low turn supply products"
        test = f"bounded_{'by_steps' if self.discrete else 'in_time'} {f.size} P now next {inner}"
        lines.append(f"Lemma bounded : {test} = true.\nProof. vm_cast_no_check (eq_refl true). Qed.")
        return "\n".join(one if "\n" in one else folded(one) for one in lines)

    def squares(self, names: Iterator[str]) -> str:
        """A sum of squares."""
        return " + ".join(f"{name} ^ 2" for name in names)

    def theorem(self) -> str:
        """The statement and its proof."""
        binders, names = self.binders()
        gamma2, size = number(1 / self.ease), len(self.loop.now)
        z2 = self.squares(f"{name} {self.path} t" for name in self.outputs)
        w2 = self.squares(f"w {i}%nat t" for i in range(self.first, len(self.loop.phi)))
        start = "0%nat" if self.discrete else "s"
        told = self.hypotheses()
        if not self.discrete:
            told += [
                (f"E{name}_", self.later(f"derivable_pt_lim E{name} t ({of})")) for name, of in (("z", z2), ("w", w2))
            ]
            told += [("after", "0 < s")]
        told += [(f"rest{k}", f"x {k}%nat {start} = 0") for k in range(size)]
        more = "" if self.discrete else " (Ez Ew : R -> R) (s : R)"
        lines = [
            f"Theorem gain : forall{binders} ({self.path} : {self.kind}){more},",
            *(f"  ({text}) ->" for _, text in told),
        ]
        said = (
            f"  forall k, sum_f_R0 (fun t => {z2}) k\n    <= {gamma2} * sum_f_R0 (fun t => {w2}) k."
            if self.discrete
            else f"  forall t, s <= t -> Ez t - Ez s <= {gamma2} * (Ew t - Ew s)."
        )
        free = [self.path, *(["Ez", "Ew", "s"] if not self.discrete else []), *(name for name, _ in told)]
        entries = "; ".join(self.entry(k) for k in range(self.forms.size))
        lines += [said, "Proof.", f"  intros {' '.join([*names, *free])}."]
        lines.append(f"  pose (z := fun t : {self.moment} => [{entries}]).")
        lines += self.still(start, size) + (self.summed(z2, w2) if self.discrete else self.driven(z2, w2))
        return "\n".join([*lines, "Qed."])

    def still(self, start: str, size: int) -> list[str]:
        """That all that ``V`` is a form in is 0 at the start."""
        opened = f"unfold z; cbn [dot]; rewrite {', '.join(f'?rest{k}' for k in range(size))}; ring"
        return [
            f"  assert (still : forall f, In f now -> dot f (z {start}) = 0).",
            f"  {{ unfold now; intros f [{'|['.join(['<-'] * size)}|[]{']' * size};",
            f"    {opened}. }}",
        ]

    def supplied(self, z2: str, w2: str) -> list[str]:
        """What ``supply`` is."""
        opened = f"unfold z, supply, {', '.join(self.outputs)}; cbn [value dot]; field"
        return [
            f"  assert (same : forall t, value supply (z t) = {self.share} * ({number(self.ease)} * ({z2}) - ({w2})))",
            f"    by (intro t; {opened}).",
        ]

    def summed(self, z2: str, w2: str) -> list[str]:
        """Discrete time."""
        f = self.forms
        k, r2 = self.share, number(self.ease)
        lines = self.supplied(z2, w2)
        lines.append("  assert (B : forall k, sum_f_R0 (fun t => value supply (z t)) k <= 0).")
        lines.append(f"  {{ assert (all := gain_by_steps {f.size} P now next supply products z bounded).")
        lines += ["  apply all; clear all.", "  - reflexivity.", *self.stepping()]
        lines += [*self.products()[:-1], "    exact I.", "  - exact still. }"]
        lines += [
            "  intro k; specialize (B k).",
            f"  assert (S : sum_f_R0 (fun t => value supply (z t)) k = {k} * ({r2} * sum_f_R0 (fun t => {z2}) k",
            f"    - sum_f_R0 (fun t => {w2}) k)).",
            "  { clear B; induction k as [|k IH]; cbn [sum_f_R0]; [apply same|]; rewrite IH, same; ring. }",
            f"  rewrite S in B; apply (Rmult_le_reg_l ({k} * {r2})); [lra|]; lra.",
        ]
        return lines

    def driven(self, z2: str, w2: str) -> list[str]:
        """Continuous time."""
        f = self.forms
        k, r2 = self.share, number(self.ease)
        integrals = self.rest(-1)
        energy = f"(fun t => {k} * ({r2} * Ez t - Ew t))"
        lines = [*self.supplied(z2, w2), *self.flowing()]
        lines.append(f"  assert (all := gain_in_time {f.size} P now next low turn supply products z")
        lines.append(f"    (fun t => {integrals}) {energy} bounded).")
        lines.append(f"  assert (B : forall t, s <= t -> {energy} t <= {energy} s).")
        lines += [
            "  { intros u su; apply all; clear all.",
            "  - reflexivity.",
            "  - exact F.",
            *self.below(),
            *self.turning(),
        ]
        lines += [
            f"  - intros t Ht; rewrite same; apply (derivable_pt_lim_scal (fun t => {r2} * Ez t - Ew t)).",
            f"    apply (derivable_pt_lim_minus (fun t => {r2} * Ez t) Ew); [apply (derivable_pt_lim_scal Ez)|]; auto.",
        ]
        lines += [*self.products()[:-1], "    exact I.", "  - exact after.", "  - exact su.", "  - exact still."]
        size = len(self.loop.now)
        zero = f"rewrite {', '.join(f'?rest{j}' for j in range(size))}; ring"
        for i, *_ in f.integrals:
            s, mark = self.own[i], "- " if i == f.integrals[0][0] else "  "
            lines.append(f"  {mark}replace (sigma{s} x w s) with 0 by (unfold sigma{s}; {zero}).")
        if f.integrals:
            lines.append(
                f"    rewrite {', '.join(f'(proj1 integral{self.own[i]})' for i, *_ in f.integrals)}; ring. }}"
            )
        else:
            lines.append("  - reflexivity. }")
        lines += [
            "  intros t st; specialize (B t st); cbv beta in B.",
            f"  apply (Rmult_le_reg_l ({k} * {r2})); [lra|]; lra.",
        ]
        return lines
