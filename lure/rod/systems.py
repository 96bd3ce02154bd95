"""Named systems: the paper's rod and the cases behind its figures."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import cast

from lure.errors import InputError, did_you_mean
from lure.loop import LoopModel
from lure.nonlinearities.base import Nonlinearity
from lure.plants.block import StructuredPlant
from lure.record import Page, Record, quantity
from lure.rod.discretisation import Form, upwind
from lure.rod.family import Interval, RodFamily
from lure.rod.parameters import PARAMETERS, Rod
from lure.rod.scenario import Scenario
from lure.rod.transfer import RodPlant

_UNITS = {
    "youngs_modulus": "Pa",
    "density": "kg/m^3",
    "length": "m",
    "area": "m^2",
    "damping": "N s/m",
    "compliance": "m^m/Pa",
    "exponent": "",
    "gap": "m",
}


class RodSystem(Record, LoopModel):
    """A rod with its scenario and the discretisation and simulation asked for."""

    name: str = quantity("Name for the report")
    title: str = quantity("One line that says what it is")
    source: str = quantity("Where the numbers come from", default="")
    rod: Rod = quantity(
        "The rod",
        key="parameters",
        plainly=lambda rod: {name: str(rod.exact[name]) for name in PARAMETERS},
    )
    scenario: Scenario = quantity("Loads and initial data", key="force", plainly=lambda scenario: str(scenario.force))
    cells: int = quantity("``N`` of the scheme that is analysed")
    form: Form = quantity("See :class:`lure.rod.discretisation.UpwindScheme`", default="corrected")
    until: float = quantity("End of the simulation", "s", plainly=float)
    simulation_cells: int | None = quantity(
        "``N`` of the scheme that is simulated; None for the ``cells`` analysed", default=None
    )
    varied: tuple[tuple[str, Interval], ...] = quantity(
        "Parameters that are known only to lie in intervals; the rod has the middle of each", hidden=True, default=()
    )
    _kind = "rod system"

    @property
    def intervals(self) -> dict[str, Interval]:
        """The intervals of parameters that have one."""
        return dict(self.varied)

    @property
    def single(self) -> RodSystem:
        """The system, of one rod.

        Raises
        ------
        InputError
            There are intervals.
        """
        if self.intervals:
            raise InputError(
                f"{self.name} has intervals for {', '.join(self.intervals)}, which are asked by lure certify and lure "
                "report alone; give each one number"
            )
        return self

    def family(self, *, discretised: bool) -> RodFamily:
        """The rods of the intervals, or their schemes.

        Parameters
        ----------
        discretised : bool
            Whether the schemes.

        Raises
        ------
        InputError
            There are no intervals.
        """
        return RodFamily(self.rod, self.intervals, self.cells if discretised else None)

    def parts(self, *, discretised: bool) -> tuple[StructuredPlant, Nonlinearity | None]:
        """The rod, or its scheme, and the contact law; with intervals all of them, and no law if it is not one."""
        if self.intervals:
            law = None if "compliance" in self.intervals else self.rod.nonlinearity
            return self.family(discretised=discretised), law
        return upwind(self.rod, self.cells) if discretised else RodPlant(self.rod), self.rod.nonlinearity

    def _page(self) -> Page:
        units = {**_UNITS, "compliance": "m/Pa"} if self.rod.exponent == 1 else _UNITS
        shown = {name: f"{getattr(self.rod, name):g}" for name in PARAMETERS}
        shown |= {name: f"[{float(low):g}, {float(high):g}]" for name, (low, high) in self.intervals.items()}
        rows = [(name.replace("_", " "), shown[name], units[name]) for name in PARAMETERS]
        rows += [("force g", str(self.scenario.force), "N"), ("cells of the scheme", str(self.cells), "")]
        notes = [f"Source: {self.source}"] if self.source else []
        notes.append(
            "lure.analysis.rod.report.build.build_report(system) decides; the scheme and the rod are told apart there."
        )
        return Page(f"{self.name}: {self.title}", rows, head=("", "value", "unit"), notes=notes)


_PAPER = "Danciu, Matei, Micu and Roventa, section 5; gap 0.02 m and displacement as the printed figures require"


def paper_rod(damping: str = "2e-4") -> Rod:
    """The rod of the paper's section 5, with exact decimals; ``damping`` is 2e-4 or 8e-4 N s/m there."""
    return _written("288e6", "8", "1", "0.25e-4", damping, "1", "1", "0.02")


def _written(*values: str) -> Rod:
    """A rod from decimals, in the order of the parameters."""
    return rod_from_exact({name: Fraction(text) for name, text in zip(PARAMETERS, values, strict=True)})


def rod_from_exact(values: Mapping[str, Fraction]) -> Rod:
    """A rod from exact rationals, one for each parameter."""
    return Rod(**cast("dict[str, float]", dict(values)))


# name, title, damping k [N s/m], force g [N], end of the simulation [s], form
_FIGURES: tuple[tuple[str, str, str, str, float, Form], ...] = (
    (
        "paper-rod",
        "the paper's rod, compressed and released at t = 0 (figures 3-7)",
        "2e-4",
        "0",
        2.5e-3,
        "corrected",
    ),
    ("paper-rod-figure-8", "force 2 sin 4t as printed: contact", "2e-4", "2*sin(4*t)", 5.0, "as-printed"),
    (
        "paper-rod-figure-9",
        "force 5 sin 4t as printed, stronger dashpot: contact",
        "8e-4",
        "5*sin(4*t)",
        5.0,
        "as-printed",
    ),
    (
        "paper-rod-figure-10",
        "force 2 sin 4t as printed, stronger dashpot: no contact",
        "8e-4",
        "2*sin(4*t)",
        5.0,
        "as-printed",
    ),
)


def _steel_rod() -> RodSystem:
    """A bar of steel against a stop: its response to the force repeats every second period of it."""
    return RodSystem(
        name="steel-rod",
        title="a steel bar pressed against a stiff stop and shaken",
        rod=_written("210e9", "7850", "1", "1e-4", "800", "5e-14", "1", "0"),
        scenario=Scenario.parse(force="300 + 700*sin(2600*t)"),
        cells=10,
        form="corrected",
        until=0.05,
        source="an example of lure's own",
    )


def _builtin() -> dict[str, RodSystem]:
    figures = {
        name: RodSystem(
            name=name,
            title=title,
            rod=paper_rod(damping),
            scenario=Scenario.parse(force=force, displacement="0.0001 - 0.0002*x"),
            cells=10,
            form=form,
            until=until,
            source=_PAPER,
        )
        for name, title, damping, force, until, form in _FIGURES
    }
    return {**figures, "steel-rod": _steel_rod()}


def builtin_systems() -> Mapping[str, RodSystem]:
    """The named systems: those of the paper in the order of its figures, then the steel rod."""
    return MappingProxyType(_builtin())


def builtin_system(name: str) -> RodSystem:
    """The named system.

    Parameters
    ----------
    name : str
        One of :func:`builtin_systems`.

    Raises
    ------
    InputError
        There is no such name; the message offers the nearest.

    Examples
    --------
    >>> builtin_system("paper-rod").rod.length
    1.0
    """
    systems = _builtin()
    if name not in systems:
        hint = did_you_mean(name, systems)
        raise InputError(f"there is no built-in system {name!r}; {hint}choose from {', '.join(systems)}")
    return systems[name]
