"""An interval of starts of a loop with one state, from which all solutions tend to 0, for Coq: `interval.v`.

``x' = f(x)`` with a continuous ``f``, a line between cuts, and ``y f(y) < 0`` on the interval but at 0: no solution
moves away from 0, and none can stay away, as ``f`` is at a distance from 0 where ``y`` is.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lure.analysis.certificates.arithmetic import INF, extended, numbers
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.channels import plant
from lure.analysis.export.graphs import Known, cases, written
from lure.analysis.export.loops import of_states
from lure.analysis.export.words import equations, number, refused, whole_file

LIBRARIES = ("forms.v", "flow.v", "regions.v", "interval.v")


def interval_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for an interval that 0 attracts, of a loop with one state in continuous time.

    Raises
    ------
    refused
        An ``InputError``: it is in discrete time, or a nonlinearity is more than lines.
    """
    if plant(data["system"]).discrete:
        raise refused("of intervals those in continuous time have an export")
    return _Interval(data).text(claim)


class _Interval:
    """The words of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        H, self.given = plant(data["system"]), data["laws"]["graphs"]
        self.a, self.loop = H.A[0][0], of_states(H.A, H.B, H.C, H.D, discrete=False)
        names = [f"phi{i + 1 if len(self.given) > 1 else ''}" for i in range(len(self.given))]
        pieces = [[numbers(p) for p in one["pieces"]] for one in self.given]
        if any(v for one in pieces for p in one for v in p[2:]):
            raise refused("of intervals those of nonlinearities that are lines between cuts have an export")
        cuts = [[*map(exact, one["cuts"])] for one in self.given]
        self.known = [Known(name=n, cuts=c, pieces=p) for n, c, p in zip(names, cuts, pieces, strict=True)]
        self.into, self.seen = H.B[0], [row[0] for row in H.C]
        self.low, self.high = map(extended, data["proof"]["interval"])
        self.origin = f"{data['theorem']}, {data['proof']['method']}"

    def text(self, claim: str) -> str:
        """The whole file."""
        parts = ["\n".join([one.definition(), *_continuous(one)]) for one in self.known]
        return whole_file(claim, self.origin, LIBRARIES, [*parts, self.theorem()])

    def within(self, t: str) -> list[str]:
        """That the state is in the interval; nothing of an end that is infinite."""
        return [self.bound(end, f"x 0%nat {t}") for end in (self.low, self.high) if abs(end) != INF]

    def bound(self, end: Fraction | float, name: str) -> str:
        """That something is on the inner side of a finite end."""
        text = number(Fraction(end))
        return f"{text} < {name}" if end < 0 else f"{name} < {text}"

    def right(self, count: int) -> str:
        """``f`` at ``y``, with so many of the nonlinearities."""
        if not count:
            return f"{number(self.a)} * y"
        k, c = number(-self.into[count - 1]), number(self.seen[count - 1])
        return f"{self.right(count - 1)} + {k} * {self.known[count - 1].name} ({c} * y)"

    def theorem(self) -> str:
        """The statement and its proof."""
        m, started = len(self.known), self.within("0")
        told = [one.replace("(forall t, ", "(forall t, 0 < t -> ") for one in equations(self.loop, self.names)]
        told += ["(continuity_pt (x 0%nat) 0)", *(f"({text})" for text in started)]
        names = [*(f"graph{i}" for i in range(m)), "flow", "start", *(f"side{i}" for i in range(len(started)))]
        kept = " /\\ ".join(self.within("t"))
        held = f"(forall t, 0 <= t -> {kept}) /\\ " * bool(started)
        low = "(Rmin 0 (x 0%nat 0) - 1)" if self.low == -INF else number(Fraction(self.low))
        high = "(Rmax 0 (x 0%nat 0) + 1)" if self.high == INF else number(Fraction(self.high))
        graphs = ", ".join(f"<- (graph{i} t Ht)" for i in range(m))
        steps = [
            f"apply (more_continuous (fun y => {self.right(k)}) {self.known[k].name});" for k in reversed(range(m))
        ]
        inner = " [clear y; intro y|exact {0}_continuous].".format
        return "\n".join([
            "Theorem region : forall (x w : nat -> R -> R),",
            *(f"  {text} ->" for text in told),
            f"  {held}tends_to (x 0%nat) 0.",
            "Proof.",
            f"  intros x w {' '.join(names)}.",
            f"  pose (f := fun y => {self.right(m)}).",
            "  assert (cont : forall y, continuity_pt f y).",
            "  { intro y; unfold f.",
            *(f"    {step}{inner(one.name)}" for step, one in zip(steps, reversed(self.known), strict=True)),
            "    reg. }",
            f"  assert (zero : f 0 = 0) by (unfold f; {self.at_zero()}lra).",
            "  assert (D : forall t, 0 < t -> derivable_pt_lim (x 0%nat) t (f (x 0%nat t))).",
            "  { intros t Ht; eapply derivable_same; [intro; reflexivity| |exact (flow t Ht)].",
            f"    unfold f; rewrite {graphs}; ring. }}",
            *self.sign(),
            "  pose proof (Rmin_l 0 (x 0%nat 0)); pose proof (Rmin_r 0 (x 0%nat 0)).",
            "  pose proof (Rmax_l 0 (x 0%nat 0)); pose proof (Rmax_r 0 (x 0%nat 0)).",
            f"  destruct (one_state (x 0%nat) f {low} {high} cont zero start D) as [inside lim]; [|lra|lra|].",
            "  { intros y Y n; apply sign; first [exact n|lra]. }",
            "  split; [intros t Ht; destruct (inside t Ht); lra|exact lim]." if started else "  exact lim.",
            "Qed.",
        ])  # fmt: skip

    @property
    def names(self) -> list[str]:
        """Those of the nonlinearities."""
        return [one.name for one in self.known]

    def at_zero(self) -> str:
        """What the nonlinearities are at 0."""
        found = [(one, one.on(sum(x < 0 for x in one.cuts), "0")) for one in self.known]
        zero = "".join(f"replace ({number(c)} * 0) with 0 by ring; " for c in self.seen)
        return zero + "".join(f"rewrite {text}; " for _, text in found)

    def sign(self) -> list[str]:
        """That ``y f(y) < 0``, from one cut to the next."""
        ends = {Fraction(0), *(x / c for one, c in zip(self.known, self.seen, strict=True) if c for x in one.cuts)}
        inner = sorted(x for x in ends if self.low < x < self.high)

        def branch(a: Fraction | None, b: Fraction | None, _k: int) -> list[str]:
            """The proof between two cuts."""
            left, right = (end if abs(end) != INF else None for end in (self.low, self.high))
            left, right = left if a is None else a, right if b is None else b
            if left is None or right is None:  # beyond the last cut on one side
                y = Fraction(right) - 1 if right is not None else Fraction(left or 0) + 1
            else:
                y = Fraction(left + right) / 2
            lines = []
            for one, c in zip(self.known, self.seen, strict=True):
                place = sum(x < c * y for x in one.cuts)
                lines.append(f"rewrite {one.on(place, f'({number(c)} * y)')}.")
            lines += ["assert (y < 0) by (apply Rnot_le_lt; intro; apply n; lra)."] * (b == 0)
            return [*lines, f"apply {'falls_right' if y > 0 else 'falls_left'}; [lra|exact n|lra]."]

        parts = [(a, b, 0) for a, b in pairwise([None, *inner, None])]
        kept = [self.bound(end, "y") for end in (self.low, self.high) if abs(end) != INF]
        told, names = "".join(f"{text} -> " for text in kept), "".join(f" B{i}" for i in range(len(kept)))
        lines = [f"  assert (sign : forall y, {told}y <> 0 -> y * f y < 0).", f"  {{ intros y{names} n; unfold f."]
        lines += cases(parts, branch)
        return [*lines[:-1], f"{lines[-1]} }}"]


def _continuous(one: Known) -> list[str]:
    """That a function between cuts is continuous."""

    def rest(k: int) -> str:
        """The function from the cut ``k`` on."""
        if k == len(one.cuts):
            return written(one.pieces[k])
        return f"if Rle_dec s {number(one.cuts[k])} then {written(one.pieces[k])} else {rest(k + 1)}"

    lines = [f"Lemma {one.name}_continuous : forall y, continuity_pt {one.name} y.", f"Proof.\n  unfold {one.name}."]
    for k, c in enumerate(one.cuts):
        same = f"destruct (Rle_dec {number(c)} {number(one.cuts[k + 1])}); lra" if k + 1 < len(one.cuts) else "lra"
        lines.append(
            f"  apply (cut_continuous (fun s => {written(one.pieces[k])}) (fun s => {rest(k + 1)}) {number(c)});"
        )
        lines.append(f"    [intro y; reg| |{same}].")
    return [*lines, "  intro y; reg.", "Qed."]
