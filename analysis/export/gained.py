"""Loops of gains in states: their matrices, and the values that the gains give, as rows over the state."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF, numbers
from lure.analysis.certificates.arithmetic import number as exact
from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.channels import Plant, channels, closed_loop, plant
from lure.analysis.certificates.states import classes
from lure.analysis.export.loops import of_states
from lure.analysis.export.quadratic import Loop, Matrix, Vector, whole
from lure.analysis.export.words import equations, folded, integers, number, refused, whole_file
from lure.record import described, quantity

Rows = list[list[int]]


@described(frozen=True, kw_only=True)
class Gained:
    """A plant in states, and gains of its channels."""

    plant: Plant = quantity("``A, B, C, D`` of ``mu = -w``")
    loop: Loop = quantity("The same as rows over ``(x, w)``")
    laws: list[Any] = quantity("The class of each nonlinearity, as the certificate has it")
    block: list[int] = quantity("Of each channel its nonlinearity")
    bounds: list[tuple[Any, Any]] = quantity("Of the gains of each nonlinearity; they may be infinite")
    gains: list[Vector] = quantity("One of each nonlinearity, once or in turn")
    matrices: list[Matrix] = quantity("Those of the loops")
    values: list[tuple[int, Rows]] = quantity("Of each loop a whole number and by it the rows of ``w`` over ``x``")

    def outputs(self) -> str:
        """The values, for Coq."""
        given = "; ".join(f"({unit}, {integers(rows)})" for unit, rows in self.values)
        return folded(f"Definition values : list (Z * list (list Z)) := [{given}]%Z.")


@described(frozen=True, kw_only=True)
class Words:
    """The theorem of a file about gains of a plant in states, and its proof."""

    libraries: tuple[str, ...] = quantity("Files beside this one")
    loops: Gained = quantity("The plant and the gains")
    parts: list[str] = quantity("Definitions and lemmas before the theorem")
    kind: str = quantity("The type of a gain")
    gains: list[str] = quantity("What is said of the gains and of the jumps")
    laws: list[str] = quantity("Of each channel what is applied to ``sigma``")
    end: str = quantity("What is said of the solution")
    proof: list[str] = quantity("Lines")
    jumps: bool = quantity("Whether the gains jump in continuous time", default=False)

    @property
    def names(self) -> list[str]:
        """The gains, the solution, and the times of the jumps."""
        return [*(f"g{b}" for b in range(len(self.loops.bounds))), "x", "w", *["jump"] * self.jumps]

    def said(self) -> list[str]:
        """What is said before the end."""
        m, n, found = len(self.loops.block), len(self.loops.plant.A), equations(self.loops.loop, self.laws)
        if self.jumps:
            flows = [text.replace("(forall t, ", "(forall t, (forall j, t <> jump j) -> ", 1) for text in found[m:]]
            found = [*found[:m], f"(forall k t, (k < {n})%nat -> continuity_pt (x k) t)", *flows]
        return [*self.gains, *found]

    def theorem(self) -> str:
        """The theorem and its proof."""
        count, moment = len(self.loops.bounds), "nat" if self.loops.plant.discrete else "R"
        given = f"({' '.join(self.names[:count])} : {self.kind}) (x w : nat -> {moment} -> R)"
        first = f"Theorem moves : exists {given}{' (jump : nat -> R)' * self.jumps},"
        lines = [first, *(f"  {text} /\\" for text in self.said()), f"  {self.end}."]
        return "\n".join([*lines, *self.proof])

    def text(self, claim: str, method: str) -> str:
        """The whole file."""
        return whole_file(claim, f"counterexample, {method}", self.libraries, [*self.parts, self.theorem()])


def state_of(n: int) -> str:
    """The state at a time, for Coq."""
    return "[" + "; ".join(f"x {k}%nat t" for k in range(n)) + "]"


def in_states(data: Mapping[str, Any]) -> dict[str, Any]:
    """A certificate of one channel with a plant that is given by matrices."""
    system, proof = data["system"], data["proof"]
    if system["kind"] != "transfer":
        return dict(data)
    A, b, c, d, _ = realised(system, Fraction(0))
    given = {"b": [*map(str, b)], "c": [*map(str, c)], "d": str(d), "A": [[*map(str, row)] for row in A]}
    own = {**data, "system": {"kind": "state-space", "time": system["time"], **given}}
    if proof["method"] == "crossing":  # the gain is between two
        own["proof"] = {"method": "crossing", "gain": str(sum(numbers(proof["gains"]), Fraction(0)) / 2)}
    return own


def gained_loop(data: Mapping[str, Any]) -> Gained:
    """The loops of a refutation by gains, of a plant in states.

    Raises
    ------
    refused
        An ``InputError``: a channel is no function in a sector, or the plant is of another kind.
    """
    system, proof = data["system"], data["proof"]
    if "rate" in data or system["kind"] not in ("state-space", "multivariable") or {"matrices", "growth"} & {*proof}:
        raise refused("it is about a rate or a growth, or its plant is given neither by polynomials nor by matrices")
    if system["kind"] == "state-space":
        A, b, c, d, discrete = realised(system, Fraction(0))
        H, family = Plant(A, [[v] for v in b], [c], [[d]], discrete=discrete), classes(data["laws"])
        rows = [[g] for g in (numbers(proof["gains"]) if "gains" in proof else [exact(proof["gain"])])]
        laws, block, families = [data["laws"]], [0], [family]
    else:
        H = plant(system)
        asked = channels(data["laws"], len(H.D))
        block = [b for b, channel in enumerate(asked.blocks) for _ in channel]
        families, laws = asked.families, data["laws"]["channels"]
        listed = proof["gains"] if proof["method"] == "switched-gains" else [proof["gains"]]
        rows = [numbers(row, len(H.D)) for row in listed]
    if any(one.operator or one.memory or one.relu or one.rate is not None for one in families):
        raise refused("a channel is no function of sigma in a sector, or its gain has a bounded rate")
    first = [block.index(b) for b in range(block[-1] + 1)]
    ends = [(families[i].sector, families[i].slope) for i in first]
    matrices, values = list[Matrix](), list[tuple[int, Rows]]()
    for row in rows:
        closed = closed_loop(H, [[g * (i == j) for j in range(len(row))] for i, g in enumerate(row)])
        if closed is None:
            raise refused("the loop of some of the gains is not well posed")
        w = [[g * v for v in c] for g, c in zip(row, closed.C, strict=True)]
        unit = math.lcm(*(v.denominator for side in w for v in side))
        matrices.append(closed.A)
        values.append((unit, [whole(side, unit)[0] for side in w]))
    return Gained(
        plant=H, loop=of_states(H.A, H.B, H.C, H.D, discrete=H.discrete), laws=laws, block=block,
        bounds=[(max(low, a), min(high, b)) for (low, high), (a, b) in ends],
        gains=[[row[i] for i in first] for row in rows], matrices=matrices, values=values,
    )  # fmt: skip


def whole_rows(A: Matrix) -> tuple[int, Rows]:
    """A whole number ``d`` and the rows of ``d A``."""
    d = math.lcm(*(v.denominator for row in A for v in row))
    return d, [whole(row, d)[0] for row in A]


def within(name: str, ends: tuple[Any, Any]) -> str:
    """That a gain is one of the class, for Coq; empty where there are no bounds."""
    low, high = (None if abs(v) == INF else number(Fraction(v)) for v in ends)
    return f"{low} <= " * bool(low) + name + f" <= {high}" * bool(high) if low or high else ""


def by_stays(p: int, ends: Sequence[str]) -> list[str]:
    """The rest of a proof for Coq about ``r``, one of ``p`` stays."""
    return [
        f"    assert (small : (r < {p})%nat) by (apply Nat.mod_upper_bound; discriminate); clearbody r.",
        *(f"    destruct r as [|r]; [{end}|]." for end in ends),
        "    exfalso; lia.",
    ]


def within_proof(bounds: Sequence[tuple[Any, Any]]) -> list[str]:
    """For Coq, that the gains ``repeated gains0`` and so on are those of the classes."""
    member = "apply (repeated_all (fun g => {0})); [discriminate|]; unfold gains{1}"
    every = "repeat (apply Forall_cons; [lra|]); apply Forall_nil"
    said = [(i, text) for i, ends in enumerate(bounds) if (text := within("g", ends))]
    return [f"  split; [intro t; {member.format(text, i)}; {every}|]." for i, text in said]
