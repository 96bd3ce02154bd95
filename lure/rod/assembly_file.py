"""Files with a ``[contact]``: several rods or contacts, which are read as the loop of their upwind scheme."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from lure.errors import InputError
from lure.files.kinds import FileKind
from lure.files.system import LoopSystem, channel_system, loop_system
from lure.files.values import STRICT, array_of_tables, field_key, number_of, one_line, shown
from lure.plants.multivariable import MultivariablePlant
from lure.rod.assembly import ARRANGEMENTS, MOST_CELLS, Arrangement, RodAssembly
from lure.rod.file import ZERO_OF_T, ZERO_OF_X, Cells, Formula, Positive, damping_of
from lure.rod.parameters import PARAMETERS, Rod
from lure.rod.scenario import Scenario


def _arrangement(value: object, info: ValidationInfo) -> object:
    if value not in ARRANGEMENTS:
        raise InputError(f"{field_key(info)} is {shown(value)}; give one of {', '.join(map(repr, ARRANGEMENTS))}")
    return value


def _values(value: object, info: ValidationInfo) -> tuple[Fraction, ...]:
    name = field_key(info)
    listed = value if isinstance(value, list) else [value]
    if not listed:
        raise InputError(f"{name} is an empty list; give a number, or one for each contact")
    return tuple(number_of(one, name) for one in listed)


class BarTable(BaseModel):
    """``[[rod]]``: a rod with a dashpot at its end ``x = 0``."""

    model_config = ConfigDict(**STRICT, title="rod")
    youngs_modulus: Positive = Field(description="E, Young's modulus [Pa]")
    density: Positive = Field(description="rho [kg/m^3]")
    length: Positive = Field(description="L [m]")
    area: Positive = Field(description="A, cross-section [m^2]")
    damping: Annotated[Fraction | str, BeforeValidator(damping_of)] = Field(
        description='k, dashpot at x = 0 [N s/m], or a multiple of A sqrt(rho E) such as "2 Z"'
    )
    u0: Formula = Field(default=ZERO_OF_X, description="displacement at t = 0, of x [m]")
    u1: Formula = Field(default=ZERO_OF_X, description="velocity at t = 0, of x [m/s]")
    g: Formula = Field(default=ZERO_OF_T, description="force on the end x = 0, of t [N]")


class ContactTable(BaseModel):
    """``[contact]``: which ends touch what."""

    model_config = ConfigDict(**STRICT, title="contact")
    arrangement: Annotated[Arrangement, BeforeValidator(_arrangement)] = Field(
        description='"both-ends", "across-gap" or "one-obstacle"'
    )
    compliance: Annotated[tuple[Fraction, ...], BeforeValidator(_values)] = Field(
        description="eps of p(r) = max(r, 0)/eps [m/Pa], one or a list with one for each contact"
    )
    gap: Annotated[tuple[Fraction, ...], BeforeValidator(_values)] = Field(
        default=(Fraction(0),), description="free distance [m], one or a list with one for each contact"
    )
    obstacle_damping: Positive | None = Field(
        default=None, description="k_o of an obstacle that moves [N s/m], for one-obstacle"
    )


class SchemeTable(BaseModel):
    """``[discretisation]``: the scheme that is analysed."""

    model_config = ConfigDict(**STRICT, title="discretisation")
    cells: Cells = Field(default=3, description=f"N of the scheme that is analysed, 1 to {MOST_CELLS}")


class MotionTable(BaseModel):
    """``[simulation]``: how long the rods are followed."""

    model_config = ConfigDict(**STRICT, title="simulation")
    until: Positive | None = Field(default=None, description="end [s]; else 20 passages of a wave")


class AssemblyTables(BaseModel):
    """A whole file."""

    model_config = ConfigDict(**STRICT)
    name: Annotated[str | None, BeforeValidator(one_line)] = Field(default=None, description="name for the report")
    contact: ContactTable
    rod: Annotated[list[BarTable], BeforeValidator(array_of_tables)]
    discretisation: SchemeTable = SchemeTable()
    simulation: MotionTable = MotionTable()


def assembly_of(tables: AssemblyTables) -> RodAssembly:
    """The rods of a file; ``tables``: its checked tables.

    Raises
    ------
    InputError
        A rod or the assembly refuses its parameters.
    """
    given = tables.contact
    own = [key for key in BarTable.model_fields if key in PARAMETERS]
    rods = tuple(Rod(**{key: getattr(one, key) for key in own}, compliance=1) for one in tables.rod)
    scenarios = tuple(Scenario(force=one.g, displacement=one.u0, velocity=one.u1) for one in tables.rod)
    still = all(one.g.is_zero and one.u0.is_zero and one.u1.is_zero for one in tables.rod)
    contacts = {"both-ends": 2, "across-gap": 1}.get(given.arrangement, len(rods))
    compliances, gaps = (values * contacts if len(values) == 1 else values for values in (given.compliance, given.gap))
    return RodAssembly(
        arrangement=given.arrangement,
        rods=rods,
        compliances=compliances,
        gaps=gaps,
        obstacle_damping=given.obstacle_damping,
        scenarios=() if still else scenarios,
        until=None if tables.simulation.until is None else float(tables.simulation.until),
    )


def assembly_loop(assembly: RodAssembly, cells: int, *, name: str = "rods", source: str = "") -> LoopSystem:
    """The upwind scheme of some rods with their contact laws, as a loop of as many channels as there are contacts.

    What is shown of it is about the scheme; what is shown of the rods themselves is
    :func:`lure.analysis.rod.assembly.rods_at_rest`, and stands in the report.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.
    cells : int
        ``N``, of each rod.
    name, source : str
        For the report.

    Raises
    ------
    InputError
        There is no such scheme.
    """
    scheme = f"upwind scheme with {cells} cell{'s' * (cells > 1)} a rod"
    rounded = ", with the wave speed of rod {} rounded to a double".format(" and ".join(map(str, assembly.rounded)))
    title = f"the {scheme} of {assembly.words}{rounded if assembly.rounded else ''}"
    identity = (f"{name}, {scheme}", title, source)
    plant, tables = assembly.scheme(cells), assembly.nonlinearity_tables()
    if isinstance(plant, MultivariablePlant):
        found = channel_system(identity, plant, nonlinearity_tables=tables)
    else:
        found = loop_system(identity, plant, nonlinearity_table=tables[0])
    return replace(found, approximates=assembly)


def _built(tables: AssemblyTables, *, title: str, source: str, folder: object) -> LoopSystem:
    return assembly_loop(assembly_of(tables), tables.discretisation.cells, name=tables.name or "rods", source=source)


def _none(name: str) -> LoopSystem:
    raise AssertionError(f"there are no built-in rods, and none called {name}")


ASSEMBLY_FILE = FileKind(
    word="rods",
    tables={"contact": ContactTable, "rod": BarTable, "discretisation": SchemeTable, "simulation": MotionTable},
    model=AssemblyTables,
    build=_built,
    written=lambda system: {"name": system.name},
    names=tuple,
    builtin=_none,
    texts=("name", "contact.arrangement", "rod.u0", "rod.u1", "rod.g"),
    beside=("rod",),
)
"""Files with a ``[contact]``."""
