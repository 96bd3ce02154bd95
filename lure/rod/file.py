"""Systems as TOML: the commented template to start from, and any system written out."""

from __future__ import annotations

import json
import re
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from importlib.resources import files
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import decimal
from lure.files.kinds import FileKind
from lure.files.values import STRICT, field_key, number_of, one_line, shown
from lure.rod.discretisation import FORMS, Form, checked_cells
from lure.rod.family import Interval, RodFamily, require_varied
from lure.rod.parameters import impedance_multiple
from lure.rod.scenario import Scenario
from lure.rod.systems import RodSystem, builtin_system, builtin_systems, rod_from_exact

# What a system file may hold: one pydantic model for each table, strict, with no keys besides the known ones.
#
# A field's description names the quantity and its unit; error messages and written files show it.

_VARIABLES = {"g": ("t",), "f": ("t", "x"), "u0": ("x",), "u1": ("x",)}


def _number(value: object, info: ValidationInfo) -> Fraction:
    return number_of(value, field_key(info))


def _varied(value: object, info: ValidationInfo) -> Fraction | Interval:
    """A number, or the two ends of an interval."""
    if not isinstance(value, list):
        return _number(value, info)
    if len(value) != 2:
        raise InputError(f"{field_key(info)} is an array of {len(value)}; give a number, or an interval [low, high]")
    low, high = (number_of(end, field_key(info)) for end in value)
    return (low, high)


def _damping(value: object, info: ValidationInfo) -> Fraction | str | Interval:
    return _varied(value, info) if isinstance(value, list) else damping_of(value, info)


def damping_of(value: object, info: ValidationInfo) -> Fraction | str:
    """A number, or a multiple of the impedance as text, which the rod itself reads."""
    name = field_key(info)
    if isinstance(value, str) and impedance_multiple(value, name) is not None:
        return value
    return number_of(value, name)


def _positive(value: object, info: ValidationInfo) -> Fraction:
    number = _number(value, info)
    if number <= 0:
        raise InputError(f"{field_key(info)} is {float(number):g}; give a positive number")
    return number


def _formula(value: object, info: ValidationInfo) -> Expression:
    name = field_key(info)
    if isinstance(value, bool) or not isinstance(value, int | Decimal | Fraction | str):
        raise InputError(f"{name} is {shown(value)}; give a number or a formula in quotes")
    return Expression.parse(value, variables=_VARIABLES[str(info.field_name)], field=name)


def _whole(value: object, info: ValidationInfo) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError(f"{field_key(info)} is {shown(value)}; give a whole number")
    return checked_cells(value, field_key(info))


def _form(value: object, info: ValidationInfo) -> Form:
    if value not in FORMS:
        allowed = " or ".join(f'"{form}"' for form in FORMS)
        raise InputError(f"{field_key(info)} is {shown(value)}; give {allowed}")
    return value


Number: TypeAlias = Annotated[Fraction, BeforeValidator(_number)]
Varied: TypeAlias = Annotated[Fraction | Interval, BeforeValidator(_varied)]
Positive: TypeAlias = Annotated[Fraction, BeforeValidator(_positive)]
Formula: TypeAlias = Annotated[Expression, BeforeValidator(_formula)]
Cells: TypeAlias = Annotated[int, BeforeValidator(_whole)]

ZERO_OF_T = Expression.parse(0, variables=("t",))
_ZERO_OF_TX = Expression.parse(0, variables=("t", "x"))
ZERO_OF_X = Expression.parse(0, variables=("x",))


class RodTable(BaseModel):
    """``[rod]``: the parameters of :class:`lure.rod.parameters.Rod`, which checks their signs."""

    model_config = ConfigDict(**STRICT, title="rod")
    youngs_modulus: Varied = Field(description="E, Young's modulus [Pa]")
    density: Varied = Field(description="rho [kg/m^3]")
    length: Varied = Field(description="L [m]")
    area: Varied = Field(description="A, cross-section [m^2]")
    damping: Annotated[Fraction | str | Interval, BeforeValidator(_damping)] = Field(
        description='k, dashpot at x = 0 [N s/m], or a multiple of A sqrt(rho E) such as "2 Z"'
    )
    compliance: Varied = Field(description="eps, of the contact law p(r) = max(r, 0)^m / eps [m^m/Pa]")
    exponent: Number = Field(default=Fraction(1), description="m of the contact law [-]")
    gap: Number = Field(default=Fraction(0), description="free distance to the obstacle [m]")


class DiscretisationTable(BaseModel):
    """``[discretisation]``: the scheme that is analysed."""

    model_config = ConfigDict(**STRICT, title="discretisation")
    cells: Cells = Field(default=10, description="N of the scheme that is analysed")
    form: Annotated[Form, BeforeValidator(_form)] = Field(
        default="corrected", description='"corrected" or "as-printed"'
    )


class ForceTable(BaseModel):
    """``[force]``: loads."""

    model_config = ConfigDict(**STRICT, title="force")
    g: Formula = Field(default=ZERO_OF_T, description="force on the end x = 0, of t [N]")
    f: Formula = Field(default=_ZERO_OF_TX, description="force along the rod, of t and x [N/m]")


class InitialTable(BaseModel):
    """``[initial]``: the state at ``t = 0``."""

    model_config = ConfigDict(**STRICT, title="initial")
    u0: Formula = Field(default=ZERO_OF_X, description="displacement at t = 0, of x [m]")
    u1: Formula = Field(default=ZERO_OF_X, description="velocity at t = 0, of x [m/s]")


class SimulationTable(BaseModel):
    """``[simulation]``: how long, and with how many cells if not those analysed."""

    model_config = ConfigDict(**STRICT, title="simulation")
    until: Annotated[Fraction | None, BeforeValidator(_positive)] = Field(default=None, description="end [s]")
    cells: Annotated[int | None, BeforeValidator(_whole)] = Field(default=None, description="N that is simulated")


class SystemTables(BaseModel):
    """A whole file."""

    model_config = ConfigDict(**STRICT)
    name: Annotated[str | None, BeforeValidator(one_line)] = Field(default=None, description="name for the report")
    rod: RodTable
    discretisation: DiscretisationTable = DiscretisationTable()
    force: ForceTable = ForceTable()
    initial: InitialTable = InitialTable()
    simulation: SimulationTable = SimulationTable()


TABLES: dict[str, type[BaseModel]] = {
    "rod": RodTable,
    "discretisation": DiscretisationTable,
    "force": ForceTable,
    "initial": InitialTable,
    "simulation": SimulationTable,
}

# From checked tables to a :class:`lure.rod.systems.RodSystem`, with the checks that concern several tables at once.

ROUND_TRIPS = 10
_SAMPLES = 1000


def built_system(tables: SystemTables, *, title: str, source: str) -> RodSystem:
    """The system of a file; without ``simulation.until`` it is simulated for ten round trips of a wave, ``20 L/c``.

    Raises
    ------
    InputError
        The rod refuses its parameters, or a load or an initial value is not finite at one of the sampled points.
    """
    given = {key: getattr(tables.rod, key) for key in type(tables.rod).model_fields}
    intervals = {key: ends for key, ends in given.items() if isinstance(ends, tuple) and ends[0] != ends[1]}
    require_varied(intervals)
    rod = rod_from_exact({key: _middle(one) for key, one in given.items()})
    if intervals:
        _ = RodFamily(rod, intervals)  # refuses what is none
    scenario = Scenario(
        force=tables.force.g,
        body_force=tables.force.f,
        displacement=tables.initial.u0,
        velocity=tables.initial.u1,
    )
    simulation = tables.simulation
    until = 2.0 * ROUND_TRIPS * rod.travel_time if simulation.until is None else float(simulation.until)
    _check_finite(rod.length, scenario, cells=tables.discretisation.cells, until=until)
    return RodSystem(
        name=tables.name or "rod",
        title=title,
        rod=rod,
        scenario=scenario,
        cells=tables.discretisation.cells,
        form=tables.discretisation.form,
        until=until,
        simulation_cells=simulation.cells,
        source=source,
        varied=tuple(intervals.items()),
    )


def _middle(value: Fraction | Interval) -> Fraction:
    return (value[0] + value[1]) / 2 if isinstance(value, tuple) else value


@lru_cache(maxsize=128)  # rods that differ in other things have the same formulas
def _check_finite(length: float, scenario: Scenario, *, cells: int, until: float) -> None:
    """Refuse formulas such as ``1/x`` that a sample shows to be undefined somewhere; a sample proves nothing."""
    count = min(cells, _SAMPLES)
    x = length * np.arange(count + 1) / count
    t = until * np.arange(_SAMPLES + 1) / _SAMPLES
    _refuse_infinite("initial.u0", scenario.displacement(x=x), "x", x)
    _refuse_infinite("the derivative of initial.u0", scenario.slope(x=x), "x", x)
    _refuse_infinite("initial.u1", scenario.velocity(x=x), "x", x)
    _refuse_infinite("force.g", scenario.force(t=t), "t", t)
    few_x, few_t = x[:: max(1, count // 30)], t[::30]
    _refuse_infinite("force.f", scenario.body_force(t=few_t[:, None], x=few_x), "t", few_t)


def _refuse_infinite(name: str, values: ArrayLike, variable: str, points: NDArray[np.float64]) -> None:
    array = np.atleast_1d(np.asarray(values))
    finite = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
    if not finite.all():
        where = points[int(np.argmin(finite))] if len(array) > 1 else points[0]
        raise InputError(f"{name} is not a finite number at {variable} = {where:.6g}; change the formula")


_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?(e[+-]?\d+)?", re.ASCII)


def template(name: str = "rod") -> str:
    """The commented TOML file that ``lure init`` writes: the paper's rod, or rods with several contacts.

    Parameters
    ----------
    name : {"rod", "contact"}
        Which.
    """
    return files("lure").joinpath("rod", f"{name}.toml").read_text(encoding="utf-8")


def system_tables(system: RodSystem) -> dict[str, object]:
    """The tables of the file that means this system, numbers as exact fractions and formulas as text."""
    scenario = system.scenario
    simulation: dict[str, object] = {"until": Fraction(repr(system.until))}
    if system.simulation_cells is not None:
        simulation["cells"] = system.simulation_cells
    return {
        "name": system.name,
        "rod": {**system.rod.exact, **{name: list(ends) for name, ends in system.intervals.items()}},
        "discretisation": {"cells": system.cells, "form": system.form},
        "force": {"g": scenario.force.source, "f": scenario.body_force.source},
        "initial": {"u0": scenario.displacement.source, "u1": scenario.velocity.source},
        "simulation": simulation,
    }


def system_to_toml(system: RodSystem) -> str:
    """A TOML file that reads back as the same system, except for its title and source, which become comments.

    Parameters of the rod keep their exact values where they are decimals of at most 100 digits, as all that come from
    files are; others, such as one third, are written as the nearest double.

    Parameters
    ----------
    system : RodSystem
        The rod and what goes with it.

    Examples
    --------
    >>> from lure.rod.systems import builtin_system
    >>> print(system_to_toml(builtin_system("paper-rod-figure-8")).split("[rod]")[0].strip())
    # force 2 sin 4t as printed: contact
    # Danciu, Matei, Micu and Roventa, section 5; gap 0.02 m and displacement as the printed figures require
    name = "paper-rod-figure-8"
    """
    lines = [f"# {' '.join(text.split())}" for text in (system.title, system.source) if text.strip()]
    tables = system_tables(system)
    lines.append(f"name = {_quoted(system.name)}")
    for table, model in TABLES.items():
        values = tables[table]
        assert isinstance(values, dict)
        lines += ["", f"[{table}]"]
        lines += [
            f"{f'{key} = {_written(value)}':<32}# {model.model_fields[key].description}"
            for key, value in values.items()
        ]
    return "\n".join(lines) + "\n"


def _written(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, Fraction):
        text = decimal(value)
        return text if text is not None and "/" not in text else repr(float(value))
    if isinstance(value, str):
        return value if _NUMBER.fullmatch(value) else _quoted(value)  # a formula may be only a number
    return str(value)


def _quoted(text: str) -> str:
    """A TOML string; JSON's rules for one are TOML's, except that TOML also escapes the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


ROD_FILE = FileKind(
    word="rod",
    tables=TABLES,
    model=SystemTables,
    build=lambda tables, *, title, source, folder: built_system(tables, title=title, source=source),
    written=system_tables,
    names=lambda: tuple(builtin_systems()),
    builtin=builtin_system,
    texts=("name", "discretisation.form"),
    letters={
        "E": "rod.youngs_modulus",
        "rho": "rod.density",
        "L": "rod.length",
        "A": "rod.area",
        "k": "rod.damping",
        "eps": "rod.compliance",
        "m": "rod.exponent",
        "N": "discretisation.cells",
    },
)
"""Files with a ``[rod]``, and the built-in rods."""
