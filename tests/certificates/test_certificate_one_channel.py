"""Which classes each criterion about one nonlinearity serves, for which plants: all others are refused.

What is accepted the second checker accepts as well, with the conclusion and the assumption that are written here.
"""

import pytest
from certificate_family import draft, transfer
from handwritten import nonlinearities

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

ATTRACTS, CONVERGES = "0 attracts every motion", "every motion converges to the set of equilibria"
BOUNDED, LINEAR = "every motion is bounded", "every constant gain of the class makes the loop asymptotically stable"
CLASSES = {
    "sector": nonlinearities(0, 1),
    "slope": nonlinearities(0, 1, slope=True),
    "odd": nonlinearities(0, 1, odd=True),
    "odd slope": nonlinearities(0, 1, slope=True, odd=True),
    "varying": nonlinearities(0, 1, time_varying=True),
    "gain": nonlinearities(0, 1, slope=True, odd=True, linear=True),
    "jumping": nonlinearities(0, 1, regularity="any"),
    "finite": nonlinearities(0, "finite"),
    "unbounded": nonlinearities(0, "inf"),
    "rising": nonlinearities(0, "inf", slope=["0", "inf"]),
    "lower": nonlinearities("-1/8", 1, slope=["-1/8", "1"]),
    "steep": nonlinearities(0, 1, slope=["-1", "2"]),
}
PLANTS = {
    "lag": transfer("1", "2 3 1"),  # with the gain -1, the least slope of "steep", a root is 0
    "up": transfer("1 2", "1 1"),
    "down": transfer("-1/2 2", "1 3"),
    "integrator": transfer("1", "1 1 0"),
    "samples": transfer("1/8", "1 -1/2", "discrete"),
    "direct samples": transfer("1/4 0", "1 -1/2", "discrete"),
    "sampled integrator": transfer("1/8 0", "1 -3/2 1/2", "discrete"),
}
KERNEL = {"coefficient": "1/2", "rate": "1", "order": 1, "side": "causal"}
MULTIPLIERS = {
    "circle": {},
    "circle mirrored": {"mirrored": True},
    "popov": {"theta": "1"},
    "popov below 0": {"theta": "-1/8"},
    "off-axis-circle": {"alpha": "1/8"},
    "park": {"theta": "1/8", "tau": "1"},
    "zames-falb": {"theta": "0", "kernels": [KERNEL]},
    "zames-falb for odd ones": {"theta": "0", "kernels": [KERNEL | {"coefficient": "-1/2"}]},
    "zames-falb in samples": {"taps": [[1, "1/4"]]},
    "zames-falb in samples for odd ones": {"taps": [[1, "-1/4"]]},
    "tsypkin": {"q": "1/8"},
    "tsypkin-odd": {"q": "1/8"},
    "jury-lee": {"q": "1/8"},
    "order-cone": {"taps": [], "window": [["1/100"], ["1/4", "1/100"]], "odd": False},
    "hurwitz": {},
}
SLOPES, ODD, FIXED = (
    {"slope", "odd slope", "gain"},
    {"odd slope", "gain"},
    {"sector", "odd", "slope", "odd slope", "gain"},
)
WIDE, SECTORS = {"finite", "unbounded", "rising"}, FIXED | {"varying", "lower", "steep"}
CONTINUOUS, SAMPLED = ("lag", "up", "down"), ("samples", "direct samples")


def over(plants, classes, **more):
    return dict.fromkeys(plants, classes) | {name.replace("_", " "): served for name, served in more.items()}


OF_SLOPES = over(CONTINUOUS, SLOPES | {"lower"}, lag=SLOPES | {"lower", "steep"}, integrator=SLOPES)
OF_STEPS = over(SAMPLED, SLOPES | {"lower"}, sampled_integrator=SLOPES)
SERVED = {
    "circle": over(
        CONTINUOUS,
        SECTORS,
        up=SECTORS | WIDE,
        samples=SECTORS | {"jumping"},  # H(inf) = 0: the next state is defined whatever phi is
        direct_samples=SECTORS | WIDE,
        sampled_integrator=SECTORS - {"lower"},
    ),
    "circle mirrored": over((*CONTINUOUS, "direct samples"), SECTORS, samples=SECTORS | {"jumping"}),
    "popov": over(
        CONTINUOUS,
        FIXED | {"lower", "steep"},
        lag=FIXED | WIDE | {"lower", "steep"},
        up=FIXED | WIDE | {"lower", "steep"},
        integrator=FIXED | {"finite", "steep"},
    ),
    "popov below 0": over(CONTINUOUS, FIXED | {"lower", "steep"}, up=FIXED | WIDE | {"lower", "steep"}),
    "off-axis-circle": OF_SLOPES,
    "park": OF_SLOPES,
    "zames-falb": OF_SLOPES,
    "zames-falb for odd ones": over(CONTINUOUS, ODD),
    "zames-falb in samples": over(SAMPLED, SLOPES | {"lower", "steep"}, sampled_integrator=SLOPES),
    "zames-falb in samples for odd ones": over((*SAMPLED, "sampled integrator"), ODD),
    "tsypkin": OF_STEPS,
    "tsypkin-odd": over((*SAMPLED, "sampled integrator"), ODD),
    "jury-lee": OF_STEPS,
    "order-cone": over(SAMPLED, SLOPES | {"lower", "steep"}),
    "hurwitz": over((*CONTINUOUS, *SAMPLED), {"gain"}),
}
OF_SECTORS = ("circle", "circle mirrored", "popov", "popov below 0")
UNIQUE = {"sector", "odd", "varying", *WIDE}  # of which it is assumed that the loop has one solution


@pytest.mark.parametrize("name", SERVED)
def test_each_class_is_served_by_its_criteria_alone(name):
    theorem = name.partition(" ")[0]
    for plant, system in PLANTS.items():
        found = {}
        for kind, one in CLASSES.items():
            try:
                found[kind] = complete_and_check(draft(system, one, theorem, MULTIPLIERS[name]))
            except (Rejected, Malformed):
                continue
        assert {*found} == SERVED[name].get(plant, set()), plant
        for kind, shown in found.items():
            critical = "integrator" in plant or (plant == "lag" and kind == "steep" and name not in OF_SECTORS)
            ends = BOUNDED if kind == "varying" else CONVERGES
            ends = ends if critical else LINEAR if name == "hurwitz" else ATTRACTS
            assert shown.certificate["conclusion"] == ends, (plant, kind)
            of_plant = {"up": UNIQUE | {"steep"}, "down": UNIQUE | {"steep"}, "direct samples": UNIQUE}
            assert bool(shown.assumed) is (kind in of_plant.get(plant, ())), (plant, kind)
            assert recheck(dict(shown.certificate)).accepted, (plant, kind)
