"""One small result of every class that hands itself on, made when it is first asked for."""

import math
from fractions import Fraction
from functools import cache, partial

import control
import numpy as np
import sympy
from motions import unit_rod

import lure
from lure import RationalPlant, Saturation, Sector
from lure.analysis import (
    analyse,
    certify,
    decay_rate,
    l2_gain,
    max_sector,
    max_slope,
    region,
    steady_response,
)
from lure.analysis.describing import describing_hint
from lure.analysis.graphical import nyquist_response, popov_response
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.measured import (
    Measurements,
    example_measurements,
    fit_compliance,
    margin_from_data,
    report_from_data,
    sector_from_data,
)
from lure.analysis.nonlinearity import nonlinearity_bounds, violation
from lure.analysis.questions import tolerances
from lure.analysis.questions.channel_map import Ray, StabilityMap
from lure.analysis.questions.energy import energy_bounds, overshoot
from lure.analysis.report.loop import LoopReport
from lure.analysis.rod.comparison import compare
from lure.analysis.rod.comparison.modes import from_closed_form
from lure.analysis.rod.confirmation import confirmation
from lure.analysis.rod.paper import PaperClaim, PaperTable, Peak
from lure.analysis.rod.paper.settling import scheme_settling
from lure.analysis.rod.report import build_report
from lure.analysis.rod.response import Plan, Sweep, basin, bifurcation, response, resting_place
from lure.analysis.rod.response.seen import separation
from lure.analysis.rod.runs import Request, perform, sampled_motion
from lure.analysis.rod.simulation import simulate
from lure.analysis.rod.spectrum import rod_spectrum
from lure.analysis.sweeps import SweepSummary
from lure.analysis.testing import NonlinearityViolation, assert_in_sector
from lure.analysis.theorems.kernel_limit import multiplier_limit
from lure.analysis.theorems.passivity import passivity_indices
from lure.analysis.verdict import Evidence
from lure.expressions import Expression
from lure.files import find_system
from lure.files.builtin import builtin_loops
from lure.files.system import LoopSystem
from lure.nonlinearities import shifted_nonlinearity
from lure.nonlinearities.shifted import MovedNonlinearity
from lure.rod import Scenario, builtin_system, exact_motion, upwind
from lure.rod.assembly import RodAssembly
from lure.rod.assembly_motion import assembly_motion
from lure.rod.cellular import CellularNetwork, Template, chua_yang, edge_network
from lure.rod.derivation import Step, misprints
from lure.rod.galerkin import convergence, formula_state, galerkin
from lure.rod.scheme import structured_motion
from lure.rod.systems import builtin_systems, paper_rod

# struck once, at 0.156 ms in the scheme of 10 cells
STRUCK = find_system("paper-rod", ["rod.gap=5e-5", "rod.compliance=1e-9", "force.g=0.01*sin(4000*t)"])
FREE = find_system("paper-rod", ["rod.gap=5e-5", "rod.compliance=1e-9"])
UNTIL = 1e-3
RAY = Ray(k1=1.0, k2=2.0, proved_k1=3.0, proved_k2=6.0, refuted_k1=None, refuted_k2=None, criterion="diagonal-popov")
F = Fraction


@cache
def motion():
    return exact_motion(STRUCK.rod, STRUCK.scenario, UNTIL)


def scheme(cells=10):
    return upwind(STRUCK.rod, cells)


@cache
def galerkin_run():
    return galerkin(STRUCK.rod, space="P1", order=5).simulate(STRUCK.scenario, UNTIL, samples=21)


@cache
def family():
    # u = cos(pi x) cos(pi t) on the free rod E = rho = A = L = 1, k = 0, far from the obstacle
    start = Scenario.parse(displacement="cos(3.141592653589793*x)")
    rod = unit_rod(gap=9)
    motion = "cos(3.141592653589793*x)*cos(3.141592653589793*t)"
    known = formula_state(Expression.parse(motion, variables=("t", "x")), 0.5, 1.0)
    return convergence([galerkin(rod, space="P1", order=m) for m in (5, 9)], start, known, until=0.5)


@cache
def cells(shape=(2,)):
    if len(shape) == 1:
        network = CellularNetwork(shape=shape, A=Template.uniform([-1, 2, -1]), boundary="fixed")
        return network.simulate(np.linspace(0.5, -0.5, shape[0]), until=3.0, samples=7)
    template = Template.uniform([[0, 1, 0], [1, 2, 1], [0, 1, 0]])
    start = np.linspace(-1, 1, int(np.prod(shape))).reshape(shape)
    return CellularNetwork(shape=shape, A=template, boundary="zero-flux").simulate(start, until=3.0, samples=7)


@cache
def structured():
    return structured_motion(scheme(40), STRUCK.scenario, UNTIL, samples=21)


@cache
def trajectory():
    return simulate(scheme(), STRUCK.scenario, until=UNTIL, samples=21, frames=3)


@cache
def free_trajectory():
    return simulate(upwind(FREE.rod, 10), FREE.scenario, until=UNTIL, samples=21)


@cache
def sampled(method):
    more = {"scheme": {"cells": 10}, "galerkin": {"space": "P1", "order": 5}, "exact": {}}[method]
    return perform(STRUCK, Request(until=UNTIL, samples=21, method=method, **more)).run


@cache
def comparison():
    return compare(STRUCK.rod, STRUCK.scenario, UNTIL, cells=(10, 20), galerkin=(("P1", 9),), samples=65)


@cache
def confirmed():
    return confirmation(upwind(FREE.rod, 10), FREE.scenario, UNTIL, free_trajectory())


SHAKEN = unit_rod(damping=0.2, compliance=0.01, gap=0)


@cache
def long_run():
    return response(SHAKEN, "0.3 + 0.2*sin(t/2)", plan=Plan(settle=60, run=8, samples=8))


@cache
def swept():
    sweep = Sweep(plan=Plan(settle=60, run=8, samples=8))
    return bifurcation(SHAKEN, "0.3 + F*sin(t/2)", "F", [0.2, 0.7], sweep=sweep)


@cache
def resting():
    rod = unit_rod(damping=0.5, compliance=0.01)
    return basin(rod, [0.0, 0.1], [0.25, 0.5, 1.0])


@cache
def bounds():
    return nonlinearity_bounds("max(x, 0)**1.5", on=(-1, 1))


@cache
def sector():
    return sector_from_data(example_measurements())


@cache
def margin():
    return margin_from_data(sector(), ([1e4], [1, 300, 2e4, 0]), gain=0.005, assume_nonnegative=True)


@cache
def broken():
    try:
        assert_in_sector("2*x", Sector(0, 1))
    except NonlinearityViolation as error:
        return error.violation
    raise AssertionError("2 x lies in no sector [0, 1]")


PAPER = builtin_system("paper-rod")


def paper():
    yes = dict.fromkeys(("key", "where", "claim", "as_printed", "corrected", "rod", "sentence"), "z < 0")
    claim = PaperClaim(**yes, survives=False, evidence=Evidence.COMPUTED)
    told = {"cells": None, "form": None, "amplitude": 1.0, "at": 2.0, "contacts": 3, "evidence": Evidence.COMPUTED}
    peak = Peak(figure=8, variant="rod", largest_z=0.5, **told)
    return PaperTable(claims=(claim,), peaks=(peak,), settling=(scheme_settling(PAPER.rod, PAPER.scenario, 10),))


def memory():
    """A loop: loading and unloading differ by more than noise."""
    up = np.linspace(-2e-4, 1e-3, 120)
    u = np.concatenate([up, up[::-1]])
    bulge = 10 * np.clip(1 - np.abs(u - 5e-4) / 5e-4, 0, 1) * (np.arange(240) >= 120)
    load = 1e5 * np.maximum(u, 0) - bulge + np.random.default_rng(0).standard_normal(240)
    return sector_from_data(Measurements.from_arrays(u, load))


RESULTS = {
    "RateBound": lambda: decay_rate(([1], [1, 2]), Sector(0, 1)),
    "StabilityBound of channels": lambda: lure.max_sector(([1], [1, 3, 3, 1]), [Sector(0, 1)]),
    "ReachableSet": lambda: region(([1], [1, -1]), Saturation(gain=2, limit=1), disturbance=[[1]]).reachable,
    "RegionOfAttraction": lambda: region(([1], [1, -1]), Saturation(gain=2, limit=1)),
    "Overshoot": lambda: overshoot(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], Fraction(1, 2)),
    "EnergyBounds": lambda: energy_bounds(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]}),
    "GainBound": lambda: l2_gain(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]}),
    "Tolerances": lambda: tolerances(
        lure.plants.family.PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)}), Sector(Fraction(-1, 2), 1)
    ),
    "SteadyResponse": cache(lambda: steady_response(([1], [1, 1]), Saturation(), {"amplitude": 1, "omega": [1, 2]})),
    "SweepSummary": lambda: SweepSummary(
        store="study.zarr",
        question="paper-rod, asked for rod: 3 values of rod.damping",
        points=3,
        answers=3,
        done=2,
        failed=1,
        proved=1,
        refuted=0,
        inconclusive=0,
        computed_now=2,
        seconds=0.5,
    ),
    "StabilityMap": lambda: StabilityMap(lower=(F(0), F(0)), asked=(F(1), F(2)), rays=(RAY,)),
    "exact motion": motion,
    "impact": lambda: motion().impacts[0],
    "motion of several rods": cache(
        lambda: assembly_motion(
            RodAssembly(arrangement="across-gap", rods=(STRUCK.rod,) * 2, compliances=(F(1),), gaps=(F(0),)),
            (STRUCK.scenario,) * 2,
            UNTIL,
        ).sampled(5)
    ),
    "Galerkin run": galerkin_run,
    "convergence": family,
    "cells on a line": cells,
    "cells in the plane": partial(cells, (2, 3)),
    "structured motion": structured,
    "trajectory": trajectory,
    "trajectory without load": free_trajectory,
    "sampled scheme": partial(sampled, "scheme"),
    "sampled Galerkin": partial(sampled, "galerkin"),
    "sampled rod": partial(sampled, "exact"),
    "comparison": comparison,
    "confirmation": confirmed,
    "response": long_run,
    "bifurcation": swept,
    "sweep": Sweep,
    "basin": resting,
    "nonlinearity bounds": bounds,
    "extreme": lambda: bounds().sector_upper,
    "violation": lambda: violation("2*x", Sector(0, 1)),
    "measurements": example_measurements,
    "measured sector": sector,
    "compliance fit": cache(lambda: fit_compliance(example_measurements())),
    "measured margin": margin,
    "measured report": cache(lambda: report_from_data(example_measurements(), fit=True)),
    "checked": lambda: assert_in_sector("x/2", Sector(0, 1)),
    "broken": broken,
    "misprint": cache(lambda: misprints()[0]),
    "step": lambda: Step(title="energy", statement="E' = -k v^2", residual=sympy.Symbol("x")),
    "Chua and Yang": lambda: chua_yang(edge_network((3, 3))),
    "spectrum": lambda: rod_spectrum(scheme()),
    "paper": paper,
    "settling": lambda: from_closed_form("scheme", scheme_settling(STRUCK.rod, PAPER.scenario, 10)),
    "sampled fields": lambda: sampled_motion(motion(), 5, places=3),
    "separation": lambda: separation(*np.random.default_rng(0).standard_normal((2, 9, 4)), 1.0),
    "resting place": lambda: resting_place(unit_rod(damping=0.5, compliance=0.01), Scenario.parse(velocity=1)),
    "memory": cache(memory),
    "hint": lambda: describing_hint(RationalPlant([12], [1, 3, 2, 0]), Saturation()),
}


# What is asked about: plants, nonlinearities, classes and loops.

HOSTILE = "<script>alert('\"&')</script>"
THIRD = RationalPlant([1], [1, 3, 2, 0])
FITTS = RationalPlant([1, 0, 0], [1, F("0.12"), F("2.0254"), F("0.121308"), F("0.98191881")])


def loop_named(name):
    return LoopSystem(name=name, title=name, source=name, block=THIRD, nonlinearity=lure.Saturation())


class Odd:
    """A nonlinearity of a stranger, with a hostile name."""

    sector = lure.Sector(0, 1)

    def __call__(self, sigma):
        return 0.5 * np.asarray(sigma)

    def __eq__(self, other):
        return type(other) is type(self)

    def __hash__(self):
        return 0

    def __str__(self):
        return HOSTILE


SYSTEMS = {
    "rational": THIRD,
    "matrices": lure.as_plant(control.ss([[-1, 3], [0, -2]], [[1], [2]], [[1, 1]], 0)),
    "discrete": lure.RationalPlant([2, 1], [1, 2], dt=1),
    "constant": lure.RationalPlant([3], [1]),
    "late": lure.as_plant([["1/(s+1)", "0"], ["0", "exp(-s)/(s+2)"]]),
    "multivariable": lure.as_plant([["1/(s+1)", "0"], ["1/(s+2)", "1/(s+2)"]]),
    "delay": lure.DelayPlant.parse("exp(-s/2)/(s + 1)"),
    "family": lure.plants.family.PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 2), "b": (1, 3)}),
    "channel family": lure.plants.family.PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)}).channels,
    "state space": lure.StateSpace([[0, 1], [-2, -3]], [0, 1], [1, 0]),
    "linear": lure.rod.upwind(paper_rod(), 3).block,
    "data": lure.FrequencyData([0, 2], [complex(math.inf, 0), 1j], error=[0.0, math.inf]),
    "sector": lure.Sector(0, math.inf),
    "sector of a third": lure.Sector(-math.inf, Fraction(1, 3)),
    "slope": lure.SlopeBounds(Fraction(1, 3), 2),
    "class": lure.NonlinearityClass.slope_restricted(0, 2, odd=True),
    "classes": lure.classes.Diagonal((lure.NonlinearityClass.slope_restricted(0, 2),)),
    "rod": lure.rod.RodPlant(paper_rod()),
    "scheme": upwind(paper_rod(), 3),
    "scenario": PAPER.scenario,
    "saturation": lure.Saturation(),
    "dead zone": lure.DeadZone(width=1, gain=2),
    "relu": lure.ReLU(),
    "leaky": lure.LeakyReLU(),
    "points": lure.PiecewiseLinear([(-1, -3), (2, 6)], left_slope=0, right_slope=1),
    "cubic": lure.Cubic(),
    "tanh": lure.Tanh(),
    "quantiser": lure.Quantiser(step=1),
    "network": lure.networks.Network.given([[[2]], [[-3]]], activation="tanh", saturation=1),
    "formula": lure.ExpressionNonlinearity("sigma/(1 + abs(sigma))", sector=lure.Sector(0, 1)),
    "contradicted": lure.ExpressionNonlinearity("2*max(sigma, 0)", sector=lure.Sector(0, 1)),
    "shifted": shifted_nonlinearity(lure.Tanh(), 1),
    "moved": MovedNonlinearity(lure.Tanh(), Fraction(1), Fraction(1, 2**100)),
    "normal compliance": lure.rod.NormalCompliance(Fraction(4), 2),
    "loop": lure.Loop(THIRD, lure.Saturation()),
    "loop of a stranger": lure.Loop(THIRD, Odd()),
    "transformed": lure.loop.sector_shift("1/(s^2+s-1)", lure.NonlinearityClass(sector=lure.Sector(2, 5))),
    "hostile loop": loop_named(HOSTILE),
    **dict(builtin_systems().items()),
    **dict(builtin_loops().items()),
}


# What is answered about them.

SAMPLES = lure.FrequencyData([1, 2], [1, -1])
ROD = cache(lambda: build_report(builtin_systems()["paper-rod"]))
ANALYSED = cache(lambda: analyse(loop_named(HOSTILE)))


def certified(upper, system=THIRD):
    return lambda: certify(system, lure.NonlinearityClass(sector=lure.Sector(0, upper)))


def reported():
    said = {"observed": ("4 motions came to rest",), "hints": ("no balance",)}
    return LoopReport(analysis=ANALYSED(), **said, command="lure", versions={})


def rod_criterion(model):
    return lambda: next(one for one in ROD().criteria if one.model == model)


ANSWERS = {
    "bracket": lambda: lure.analysis.verdict.Bracket(0, 1),
    "largest": lambda: max_sector(THIRD),
    "largest refuted": lambda: max_sector("4/((s-1)*(s/3+1))"),
    "largest observed": lambda: max_sector(SAMPLES),
    "largest slope": lambda: max_slope("1/(s+1)", odd=True, search="linear"),
    "answer": lambda: max_sector(THIRD).answers[0],
    "analysis": ANALYSED,
    "loop report": reported,
    "gains": lambda: gain_intervals(THIRD)[0],
    "gains without end": lambda: gain_intervals(RationalPlant([1], [1, 1]))[0],
    "passivity": lambda: passivity_indices(THIRD),
    "certification": certified(5),
    "certification refuted": certified(7),
    "certification undecided": certified(1, SAMPLES),
    "rod report": ROD,
    "rod spectrum": lambda: ROD().spectrum,
    "rod criterion": rod_criterion("rod"),
    "scheme criterion": rod_criterion("scheme"),
    "popov plot": lambda: popov_response(loop_named(HOSTILE)),
    "nyquist plot": lambda: nyquist_response(THIRD, k=1),
    "measured response": lambda: nyquist_response(SAMPLES),
    "largest, time-varying": lambda: max_sector(([1], [1, 1, 1]), time_varying=True, search="full"),
    "largest, dead time": lambda: max_sector("exp(-s)/(s+1)"),
    "largest, rod": lambda: max_sector(lure.rod.RodPlant(paper_rod())),
    "largest, computed": lambda: max_sector(lure.StateSpace(-np.eye(3) + np.eye(3, k=1), [0, 0, 1], [1, 0, 0])),
    "multiplier limit": lambda: multiplier_limit(FITTS, odd=False, above=0.3247),
    "largest, orbit": lambda: max_slope("(2*z+0.92)/(z^2-0.5*z)", odd=True),
}
RESULTS |= {name: cache(make) for name, make in ANSWERS.items()}
