"""Systems as TOML: the commented template to start from, and any system written out."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from importlib.resources import files

from lure.expressions.tree import decimal
from lure.system_file.schema import TABLES
from lure.systems import RodSystem

_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?(e[+-]?\d+)?", re.ASCII)


def template() -> str:
    """The commented TOML file that ``lure init`` writes: the paper's rod."""
    return files("lure").joinpath("templates/rod.toml").read_text(encoding="utf-8")


def system_tables(system: RodSystem) -> dict[str, object]:
    """The tables of the file that means this system, numbers as exact fractions and formulas as text."""
    scenario = system.scenario
    simulation: dict[str, object] = {"until": Fraction(repr(system.until))}
    if system.simulation_cells is not None:
        simulation["cells"] = system.simulation_cells
    return {
        "name": system.name,
        "rod": dict(system.rod.exact),
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
    >>> from lure.systems import builtin_system
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
    if isinstance(value, Fraction):
        text = decimal(value)
        return text if text is not None and "/" not in text else repr(float(value))
    if isinstance(value, str):
        return value if _NUMBER.fullmatch(value) else _quoted(value)  # a formula may be only a number
    return str(value)


def _quoted(text: str) -> str:
    """A TOML string; JSON's rules for one are TOML's, except that TOML also escapes the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
