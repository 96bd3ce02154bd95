"""Several nonlinearities: which multipliers the plant and the classes permit, and poles at 0 (z = 1) of the loop."""

from __future__ import annotations

import math

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.frequencies import shifted
from lure.analysis.inequality.coupled_forms import Group, Kind
from lure.analysis.inequality.zero_modes import ZeroModes, zero_modes
from lure.analysis.questions.channel_problem import channel_plant, loop_plant
from lure.analysis.questions.problem import Problem
from lure.classes import NonlinearityClass
from lure.errors import AssumptionError, Reason
from lure.plants.delay_matrix import DelayMatrix


def free_channels(asked: Problem) -> list[bool]:
    """In which channels Popov's terms are possible: the output has no direct term, and nothing depends on time."""
    plant = loop_plant(asked.plant)
    lines = [list(line) for line in (plant.base if isinstance(plant, DelayMatrix) else plant).D]
    for moved, _ in plant.rates if isinstance(plant, DelayMatrix) else ():
        lines = [[*line, *more] for line, more in zip(lines, moved, strict=True)]
    static = [not any(line) for line in lines]
    functions = [not (one.time_varying or one.operator) for one in asked.classes.classes]
    return [alone and one for alone, one in zip(static, functions, strict=True)]


def modes_of(asked: Problem) -> ZeroModes | None:
    """The eigenvalues 0 (z = 1) of the loop with the gains at the lower bounds; None if there are none.

    Raises
    ------
    AssumptionError
        No theorem covers them.
    """
    H = channel_plant(asked.plant)
    A, B, C, D = ([list(row) for row in side] for side in (H.A, H.B, H.C, H.D))
    A, B, C, _ = shifted(Plant(A, B, C, D, H.dt is not None), list(asked.classes.lower))
    return zero_modes(A, B, C, discrete=H.dt is not None)


def is_critical(asked: Problem) -> bool:
    """Whether with the gains at the lower bounds there are eigenvalues 0 (z = 1), covered by a theorem or not."""
    try:
        return modes_of(asked) is not None
    except (AssumptionError, Rejected):
        return True


def require_no_zero(asked: Problem) -> None:
    """Refuse a loop with such eigenvalues, for the theorems that need it stable.

    Raises
    ------
    AssumptionError
        It has some: LURE-I012.
    """
    if modes_of(asked) is not None:
        raise AssumptionError(
            "the loop with the gains at the lower bounds has an eigenvalue 0, or z = 1 (the critical case), left to "
            "the circle criterion and Popov's, to kernels (in discrete time taps) where all slopes are bounded, and to "
            "forms for ReLUs; give lower bounds above these",
            code=Reason.CRITICAL,
        )


def rising(asked: Problem) -> bool:
    """Whether each channel has slope bounds from the lower end on, always the same: kernels beside integrators."""
    functions = [one for one in asked.classes.classes if one.operator != "performance"]
    slopes = [one.slope.lower for one in functions if one.slope is not None and not one.time_varying]
    finite = all(one.slope is not None and math.inf not in (-one.slope.lower, one.slope.upper) for one in functions)
    return finite and slopes == [one.gains[0] for one in functions]


def sloped_channels(asked: Problem) -> list[bool]:
    """In which channels kernels are possible: the slope is bounded on both sides, and nothing depends on time."""
    return [
        one.slope is not None and not one.time_varying and math.inf not in (-one.slope.lower, one.slope.upper)
        for one in asked.classes.classes
    ]


def groups_of(asked: Problem) -> list[Group]:
    """The channels that one form is about: the ReLUs; those of one nonlinearity with slope bounds; each other one."""
    classes, sloped, found = asked.classes.classes, sloped_channels(asked), list[Group]()
    rectifiers = tuple(i for i, one in enumerate(classes) if one.rectifier)
    if rectifiers:
        found.append(Group("relu", rectifiers))
    found += [Group("operator", tuple(block)) for block in asked.classes.operators]
    for block in asked.classes.blocks:
        one = classes[block[0]]
        if one.rectifier or one.operator:
            continue
        slope = one.slope
        if sloped[block[0]] and slope is not None and (slope.lower, slope.upper) == one.gains:
            found.append(Group("odd" if one.odd else "monotone", tuple(block)))
            continue
        found += [Group("sector", (i,)) for i in block]
        kinds: list[Kind] = ["odd rising" if one.odd else "rising", "odd falling" if one.odd else "falling"]
        found += [Group(kind, tuple(block)) for kind, fits in zip(kinds, sides_of(one), strict=True) if fits]
    return found


def sides_of(one: NonlinearityClass) -> tuple[bool, bool]:
    """Whether the slope is at least the lower bound of the sector, and at most the upper one, at all times the same."""
    if one.slope is None or one.time_varying or one.operator:
        return False, False
    return one.slope.lower >= one.gains[0], one.slope.upper <= one.gains[1]


def fixed_operators(asked: Problem) -> list[range]:
    """The channels of each operator that does not depend on time."""
    return [block for block in asked.classes.operators if not asked.classes.classes[block[0]].time_varying]


def constant_gains_of(asked: Problem) -> list[range]:
    """The channels of each constant gain."""
    classes = asked.classes.classes
    return [block for block in asked.classes.blocks if classes[block[0]].linear and classes[block[0]].rate is None]
