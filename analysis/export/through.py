"""Popov's criterion with a feedthrough, in the words of Coq: by the loop without it, `feedthrough.v`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import INF
from lure.analysis.certificates.blocks import coefficients
from lure.analysis.certificates.states import classes
from lure.analysis.export.falling import FallingTheorem, passing
from lure.analysis.export.loops import candidates
from lure.analysis.export.quadratic import Forms, Loop
from lure.analysis.export.words import number, refused, whole_file


def through_text(data: Mapping[str, Any], claim: str) -> str:
    """The file for Popov's criterion where ``H(inf) = D`` is not 0, of a plant given by two polynomials.

    ``y = sigma + D phi(sigma)`` is a function of the state, and ``phi(sigma) = psi(y)`` with ``psi`` in the sector
    ``[l/(1 + D l), u/(1 + D u)]``: the loop of ``H - D`` and ``psi`` has no feedthrough and the same inequality.

    Raises
    ------
    refused
        An ``InputError``: its sector has no upper bound, or no form of few enough digits was found.
    """
    top, den, _ = coefficients(data["system"])
    num, (low, high) = top[0][1], classes(data["laws"]).sector
    D = num[0] / den[0]
    if high == INF or min(1 + D * low, 1 + D * high) <= 0:
        raise refused("with a feedthrough Popov's criterion has an export for finite bounds and 1 + D phi/sigma > 0")
    rest = [n - D * d for n, d in zip(num, den, strict=True)][1:]
    system = {**data["system"], "numerator": [str(v) for v in rest]}
    laws = {**data["laws"], "sector": [str(v / (1 + D * v)) for v in (low, high)], "slope": None}
    inner = {**data, "system": system, "laws": laws, "proof": {"method": "polynomial"}}
    for loop, written in passing(candidates(inner)):
        return _Through(inner, replace(loop, rest=None), written, (num, D, low, high)).text(claim)
    raise refused("no quadratic form of few enough digits was found; a slightly smaller sector may have one")


class _Through(FallingTheorem):
    """The words of one file."""

    def __init__(
        self,
        data: Mapping[str, Any],
        loop: Loop,
        written: Forms,
        own: tuple[list[Fraction], Fraction, Fraction, Fraction],
    ) -> None:
        super().__init__(data, loop)
        self.forms = written
        self.num, self.D, self.low, self.high = own

    def text(self, claim: str) -> str:
        """The whole file."""
        inner = self.theorem().replace("Theorem stable", "Lemma without_feedthrough", 1)
        parts = ["\n".join(self.definitions()), self.witness(), inner, "\n".join(self.statement())]
        libraries = ("forms.v", "flow.v", "feedthrough.v")
        return whole_file(claim, f"popov, {self.data['proof']['method']}", libraries, parts)

    def statement(self) -> list[str]:
        """The theorem about the plant itself, and its proof."""
        low, high, D = number(self.low), number(self.high), number(self.D)
        told = {name: text for name, text in self.hypotheses() if name != "closed"}
        told["class"] = f"in_sector {low} {high} phi"
        told["integral"] = told["integral"].replace("phi", "psi")
        first, *rest = told.items()
        new = [
            ("inverse", f"forall s, psi (s + {D} * phi s) = phi s"),
            ("onto", f"forall y, exists s, y = s + {D} * phi s"),
        ]
        given = [first, *new, *rest, ("closed", "forall t, 0 < t -> den xi t = - phi (output xi t)")]
        row = [*self.num[::-1], *[Fraction(0)] * (self.order + 1 - len(self.num))]
        bounds = [number(Fraction(v)) for v in self.loop.bounds[0]]
        return [
            f"Definition output (xi : {self.kind}) (t : R) : R :=\n  {self.sum(row)}.",
            "Theorem stable : forall (phi psi Phi : R -> R) (xi : nat -> R -> R),",
            *(f"  ({text}) ->" for _, text in given),
            "  " + " /\\ ".join(self.conclusions()) + ".",
            "Proof.",
            f"  intros phi psi Phi xi {' '.join(name for name, _ in given)}.",
            "  apply (without_feedthrough psi Phi xi); [|exact integral|exact derivatives|].",
            f"  - assert (S := sector_through {D} {low} {high} phi psi",
            "      ltac:(lra) ltac:(lra) ltac:(lra) class inverse onto).",
            f"    replace ({low} / (1 + {D} * {low})) with {bounds[0]} in S by field.",
            f"    replace ({high} / (1 + {D} * {high})) with {bounds[1]} in S by field; exact S.",
            "  - intros t Ht; pose proof (closed t Ht) as E.",
            f"    replace (sigma xi t) with (output xi t + {D} * phi (output xi t)); [rewrite inverse; exact E|].",
            "    replace (phi (output xi t)) with (- den xi t) by lra; unfold output, sigma, den; field.",
            "Qed.",
        ]
