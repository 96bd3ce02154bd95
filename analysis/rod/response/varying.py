"""A family of rods and forces with one parameter: a field of the rod, or a symbol in the formula of the force."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from lure.analysis.rod.response.period import load_period
from lure.errors import InputError
from lure.exact import exact_number
from lure.expressions import Expression
from lure.expressions.tree import Apply, Node, Number, Variable
from lure.rod.parameters import PARAMETERS, Rod
from lure.rod.scenario import Scenario
from lure.rod.systems import rod_from_exact

_MOST_STEPS = 400


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """One member of a family.

    Attributes
    ----------
    value : float
        Of the parameter.
    rod : Rod
        The rod.
    scenario : Scenario
        Its loads and initial data.
    period : float
        Of the loads [s].
    """

    value: float
    rod: Rod
    scenario: Scenario
    period: float


def cases(
    rod: Rod, scenario: Scenario, force: str, varied: tuple[str, Sequence[float]], period: float | None
) -> tuple[Case, ...]:
    """The members of a family, all of them checked before any is followed.

    Parameters
    ----------
    rod : Rod
        The rod; a field that is the parameter is replaced.
    scenario : Scenario
        Initial data and body force; its own force is replaced.
    force : str
        Formula of ``g``; it may contain the parameter as a symbol beside ``t``.
    varied : (str, sequence of float)
        Name of the parameter and its values.
    period : float or None
        Of the loads, if the user gives it [s].

    Raises
    ------
    InputError
        The parameter is neither a field of the rod nor a symbol of the force, or both; a value is not possible; a
        force has no period; or no load changes with time.
    """
    name, values = varied
    in_force = re.search(rf"\b{re.escape(name)}\b", force) is not None
    if in_force and name in PARAMETERS:
        raise InputError(f"{name} is a field of the rod and a symbol of the force; use another symbol")
    if name == "t" or not (in_force or name in PARAMETERS):
        raise InputError(
            f"there is no parameter {name!r:.40}; give one of {', '.join(PARAMETERS)}, or write a symbol in the force "
            "and give its name, such as F in F*sin(4*t)"
        )
    if not len(values):
        raise InputError("there are no values of the parameter; give one at least")
    found = []
    for value in values:
        exact = exact_number(value, name)
        text = re.sub(rf"\b{re.escape(name)}\b", f"({float(exact)!r})", force)
        member = rod if in_force else rod_from_exact({**rod.exact, name: exact})
        load = Scenario(
            force=Expression.parse(text, variables=("t",), field="force.g"),
            body_force=scenario.body_force,
            displacement=scenario.displacement,
            velocity=scenario.velocity,
        )
        found.append(
            Case(
                value=float(exact),
                rod=member,
                scenario=load,
                period=load_period(load, period, 2.0 * member.travel_time)[0],
            )
        )
    if all(member.scenario.force.is_constant and member.scenario.body_force.is_constant for member in found):
        raise InputError(
            f"the force is {force}, which does not change with time: the rod only comes to rest, and there is no "
            "response to follow; give a periodic force such as 0.3+F*sin(3000*t) (--force on the command line)"
        )
    return tuple(found)


def staircase(family: Sequence[Case], starts: Sequence[float]) -> Scenario:
    r"""One scenario in which the force goes from one member of the family to the next.

    .. math:: g(t) = g_j(t - t_j) \quad (t_j \le t < t_{j+1}),

    so that each member begins where the one before has ended, with its own force at its beginning.

    Parameters
    ----------
    family : sequence of Case
        Members that differ in the force only.
    starts : sequence of float
        ``t_j`` [s], ascending, the first of them 0.

    Raises
    ------
    InputError
        The rods differ, there is a body force that depends on ``t``, or there are more than 400 members.
    """
    first = family[0]
    if any(member.rod != first.rod for member in family):
        raise InputError(
            "a sweep up or down carries the motion from one value to the next, which needs the same rod throughout: "
            "the parameter must be a symbol of the force; give order 'separate' for a field of the rod"
        )
    if not first.scenario.body_force.is_constant:
        raise InputError("a sweep up or down takes no body force that varies; give 0, or order 'separate'")
    if len(family) > _MOST_STEPS:
        raise InputError(f"a sweep up or down has at most {_MOST_STEPS} values; there are {len(family)}")
    parts = [_later(member.scenario.force.tree, start) for member, start in zip(family, starts, strict=True)]
    tree = _tree(parts, [Fraction(start) for start in starts])
    source = f"{first.scenario.force} and {len(family) - 1} more, one after the other"
    return Scenario(
        force=Expression(source=source, variables=("t",), tree=tree),
        body_force=first.scenario.body_force,
        displacement=first.scenario.displacement,
        velocity=first.scenario.velocity,
    )


def _tree(parts: Sequence[Node], starts: Sequence[Fraction]) -> Node:
    """A balanced choice between the parts."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    early = Apply("<", (Variable("t"), Number(starts[half])))
    return Apply("where", (early, _tree(parts[:half], starts[:half]), _tree(parts[half:], starts[half:])))


def _later(node: Node, start: float) -> Node:
    """The node with ``t - start`` in place of ``t``."""
    if isinstance(node, Variable) and start:
        return Apply("-", (node, Number(Fraction(start))))
    if isinstance(node, Apply):
        return Apply(node.operation, tuple(_later(part, start) for part in node.arguments))
    return node


def checked_values(values: Sequence[float]) -> tuple[float, ...]:
    """The values as floats.

    Parameters
    ----------
    values : sequence of float
        Of a parameter.

    Raises
    ------
    InputError
        One of them is not a finite number.
    """
    found = tuple(float(value) for value in np.asarray(values, dtype=float).ravel())
    wrong = [value for value in found if not math.isfinite(value)]
    if wrong:
        raise InputError(f"a value asked for is {wrong[0]}; give finite numbers")
    return found
