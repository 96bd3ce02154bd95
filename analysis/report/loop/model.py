"""The report on a loop, as an object and as plain data."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lure.analysis.certificates.checker import Checked, Proved
from lure.analysis.describing import describing_hint
from lure.analysis.nonlinearity.membership import certified_properties
from lure.analysis.questions import LoopAnalysis
from lure.analysis.questions.problem import Problem
from lure.analysis.report.loop.asked import not_answered
from lure.analysis.report.parts import SCHEMA, certificate_list
from lure.analysis.verdict import Verdict
from lure.errors import AssumptionError, InputError
from lure.loop import sector_shift
from lure.nonlinearities import Property
from lure.nonlinearities.base import Nonlinearity
from lure.plants.rational import RationalPlant
from lure.record import Column, Page, Record, quantity

if TYPE_CHECKING:
    from lure.analysis.counterexamples.trajectories import Trajectory
    from lure.analysis.plots.responses import Axes
    from lure.analysis.report.parts import FigureSpec


class LoopReport(Record):
    """What was found about a loop; :func:`lure.analysis.report.write_loop_report` turns it into files."""

    analysis: LoopAnalysis = quantity("Every criterion, every counterexample, and the verdict", label="")
    observed: tuple[str, ...] = quantity(
        "What simulations of the given nonlinearity showed, one sentence each; empty without a nonlinearity",
        form="rows",
    )
    hints: tuple[str, ...] = quantity(
        "What the describing function suggests: hints, not verdicts", label="hint, not a verdict", form="rows"
    )
    command: str = quantity("The command that makes this report again", label="")
    versions: Mapping[str, str] = quantity("Versions of lure, Python and the packages the numbers come from", label="")
    beyond: str = quantity(
        "What is proved of that which the block approximates, such as a rod by its scheme; empty if of nothing",
        label="",
        default="",
    )
    beyond_shown: tuple[Proved, ...] = quantity("What the checker accepted of it", label="", default=())
    asked: Mapping[str, Any] = quantity(
        "The answers to what ``[report]`` asks beside stability, by name: gain, rate, region",
        label="",
        default_factory=dict,
    )
    beyond_observed: tuple[str, ...] = quantity(
        "What one motion of that which the block approximates showed, one sentence each", label="", default=()
    )
    beyond_figures: tuple[FigureSpec, ...] = quantity("Figures of that motion", label="", default=())
    trajectories: tuple[Trajectory, ...] = quantity(
        "A few simulated solutions, ``sigma`` and ``mu`` over time: of the given nonlinearity, or of members of the "
        "class "
        "proved",
        label="",
        default=(),
    )
    _no_truth = "a report has three answers; compare report.verdict"

    @property
    def verdict(self) -> Verdict:
        """Verdict of the analysis, which decides the exit status of the command."""
        return self.analysis.verdict

    def __str__(self) -> str:
        lines = [f"Observed: {text}" for text in self.observed] + [f"Hint: {text}" for text in self.hints]
        followed = [f"Computed: {text}" for text in self.beyond_observed]
        beyond = [*[self.beyond] * bool(self.beyond), *followed]
        from lure.analysis.report.loop.asked import not_answered

        analysis = not_answered(str(self.analysis), self.asked)
        return "\n\n".join([analysis, *beyond, *map(str, self.asked.values()), *lines])

    @property
    def certificates(self) -> tuple[Checked, ...]:
        """What the checker accepted, of the loop, of that which it approximates and of what is asked beside."""
        from lure.analysis.report.loop.asked import accepted

        return (*self.analysis.certificates, *self.beyond_shown, *accepted(self.asked))

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar a class; see :meth:`lure.analysis.questions.LoopAnalysis.plot`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        return self.analysis.plot(ax)

    def to_dict(self) -> dict[str, Any]:
        """``report.json`` as plain data, described by ``schema.json`` of :mod:`lure.analysis.report`."""
        about = self.analysis.problem
        found = self.analysis.to_dict()
        keys: tuple[str, ...] = ("name", "title", "source", "block", "case", "class")
        keys += tuple(key for key in ("channels", "repeated", "classes", "map") if key in found)
        system = {"kind": "loop", **{key: found[key] for key in keys}, "law": _nonlinearity(about.nonlinearity)}
        found["not_shown"] = [not_answered(text, self.asked) for text in found["not_shown"]]
        beyond = {"beyond": self.beyond, "beyond_observed": list(self.beyond_observed)}
        more: dict[str, Any] = {key: said for key, said in beyond.items() if said}
        if self.asked:
            more["asked"] = {name: answer.to_dict() for name, answer in self.asked.items()}
        return more | {
            "schema": SCHEMA,
            "system": system,
            "conclusion": {key: found[key] for key in _KEYS.split()},
            "transformation": list(transformation(about)),
            "gains": found["gains"] if isinstance(about.plant, RationalPlant) else None,
            "answers": found["answers"],
            "certificates": certificate_list(self.certificates),
            "observed": list(self.observed),
            "hints": list(self.hints),
            "reproduce": {"command": self.command, "inputs_sha256": inputs_sha256(about, found)},
            "versions": dict(self.versions),
        }

    def _columns(self) -> dict[str, Column]:
        """The table of classes; see :meth:`lure.analysis.questions.LoopAnalysis.to_xarray`."""
        return self.analysis._columns()

    def _attributes(self) -> dict[str, object]:
        return self.analysis._attributes()

    def _page(self) -> Page:
        rows = tuple(self._rows())
        note = "One solution proves nothing about another, and a hint proves nothing at all."
        below = [Page("Simulations and hints", rows, verdict="OBSERVED", notes=[note])] if rows else []
        return self.analysis._page()._replace(below=below)


# What the describing function suggests for the nonlinearity of a report: a hint, never a verdict.


def balance_hints(about: Problem) -> tuple[str, ...]:
    """A sentence on harmonic balance; empty for blocks with dead time, in discrete time, or without a nonlinearity."""
    block, nonlinearity = about.plant, about.nonlinearity
    if nonlinearity is None or not isinstance(block, RationalPlant) or block.dt is not None:
        return ()
    if not getattr(nonlinearity, "odd", False):
        return (
            "there is no describing function to look at: it is for odd nonlinearities, and this one is not known to be "
            "odd",
        )
    try:
        hint = describing_hint(block, nonlinearity)
    except (AssumptionError, InputError) as refused:
        return (f"no describing function: {refused}",)
    if not hint.balances:
        return ("the describing function shows no harmonic balance, which alone excludes no oscillation",)
    listed = "; ".join(map(str, hint.balances[:4]))
    more = f"; and {len(hint.balances) - 4} more" if len(hint.balances) > 4 else ""
    return (f"the describing function suggests an oscillation of {listed}{more}; it neglects all harmonics",)


_KEYS = (
    "verdict evidence statement headline meaning law_class membership assumed attracts reason code hints not_shown "
    "stopped"
)


def transformation(about: Problem) -> tuple[str, ...]:
    """The sector shift behind the answers, step by step; empty if the class begins at 0 or nothing was shifted."""
    block, asked = about.plant, about.given
    if not isinstance(block, RationalPlant) or asked is None or asked.sector.lower in (0, -math.inf):
        return ()
    return sector_shift(block, asked).steps


def inputs_sha256(about: Problem, found: dict[str, Any]) -> str:
    """Fingerprint of everything that was put in: the block to the last digit, the nonlinearity, the class.

    ``found``: its analysis as plain data.
    """
    nonlinearity = about.nonlinearity
    exact = (
        repr(nonlinearity)
        if dataclasses.is_dataclass(nonlinearity)
        else None
        if nonlinearity is None
        else nonlinearity_text(nonlinearity)
    )
    inputs = {"kind": "loop", "block": found["block"], "class": found["class"], "law": exact}
    inputs |= {key: found[key] for key in ("channels", "repeated") if key in found}
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def nonlinearity_text(nonlinearity: Nonlinearity) -> str:
    """A nonlinearity in words: what it prints, or the name of its class if it prints nothing of use."""
    own = type(nonlinearity).__str__ is not object.__str__ or type(nonlinearity).__repr__ is not object.__repr__
    return str(nonlinearity) if own else type(nonlinearity).__name__


def _nonlinearity(nonlinearity: Nonlinearity | None) -> dict[str, Any] | None:
    if nonlinearity is None:
        return None
    known = certified_properties(nonlinearity)
    slope = known.slope_bounds
    return {
        "text": nonlinearity_text(nonlinearity),
        "sector": _property(known.sector, str(known.sector.value)),
        "slope": _property(slope, "not known to be bounded" if slope.value is None else str(slope.value)),
        "odd": _property(known.odd, "yes" if known.odd.value else "not known to be"),
        "regularity": _property(known.regularity, known.regularity.value),
    }


def _property(known: Property[Any], value: str) -> dict[str, str]:
    return {"value": value, "standing": str(known.provenance), "how": known.how}
