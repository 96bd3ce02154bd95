"""Known dead times in several channels: certificates by hand, and what neither checker accepts."""

import cmath
import copy
from fractions import Fraction
from functools import cache

import pytest
from certificate_format import FORMAT
from late_loops import INTEGRATOR, LAG, NO, ONE, draft, late, sector, value
from tampering import assert_both_reject, edited

from lure.analysis.certificates import pieces
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.channels import plant
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

CLASS = ("laws", "channels", 0)
UNIT = [["1", "0"], ["0", "1"]]
# [[g, exp(-s) g], [0, g]], g = 1/(s + 1): with x = |g|^2 = Re g the determinant of F is 4 (1 + k x)^2 - k^2 x, positive
# for all x if k < 16
COUPLED = late([["-1", "0"], ["0", "-1"]], UNIT, UNIT, [["0", "0"]] * 2, ("1", [["0", "1"], ["0", "0"]]))
CIRCLE = draft(
    COUPLED,
    [sector("0", "15")] * 2,
    "piecewise-circle",
    {"method": "pieces", "ends": ["1/4", "1/2", "3/4", "1", "2", "4", "8", "16"]},
    {"lambda": ["1", "1"], "pieces": [[None, None]] * 9},
)
# F/2 = 1 + 2.2 Re (1 + theta s) H, theta = 4/11 over 2.2 = .1653: Popov's criterion reaches 2.2618 with .1635
POPOV = draft(
    LAG,
    [sector("0", "11/5", time_varying=False)],
    "piecewise-popov",
    {"method": "pieces", "ends": [str(end) for end in range(1, 17)]},
    {"lambda": ["1"], "theta": ["4/11"], "pieces": [[None]] * 17},
)
# |H| <= 1, so that [-9/10, 9/10] is proved without a shift: F/2 = 1 - .81 |H|^2
BOTH = draft(
    LAG,
    [sector("-9/10", "9/10")],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1"]},
    {"lambda": ["1"], "pieces": [[None], [None]]},
)
# i w + g exp(-i w) = 0 for w = g = pi/2 = 1.570796...; there its derivatives are -i in g and i - pi/2 in w
CROSSING = draft(
    late([["0"]], ONE, NO, NO, ("1", ONE)),
    [sector("0", "1572/1000")],
    "counterexample",
    {
        "method": "late-crossing",
        "gains": [["157/100"], ["15716/10000"]],
        "frequencies": ["15706/10000", "15710/10000"],
        "turn": ["0", "1"],
    },
)
# diag(exp(-s)/s, exp(-s)/(s + 1)): F_11/2 = 1 + cos(w)/4 - sin(w)/(2 w), F_22/2 = 1 + Re (3/2 + s/4) H_22
REST = draft(
    late([["0", "0"], ["0", "-1"]], UNIT, [["0", "0"]] * 2, [["0", "0"]] * 2, ("1", UNIT)),
    [sector("0", "1/2", time_varying=False), sector("0", "3/2", time_varying=False)],
    "piecewise-popov",
    {"method": "pieces", "ends": [str(end) for end in range(1, 17)]},
    {"lambda": ["1", "1"], "theta": ["1/4", "1/4"], "pieces": [[None, None]] * 17},
)
# 1 - 11/10 H(0) < 0
STILL = draft(LAG, [sector("-11/10", "0")], "counterexample", {"method": "late-gains", "gains": ["-11/10"]})
# s = .01 exp(-s) has a root s > 0, as s - .01 exp(-s) is -.01 at 0
GROWS = edited(edited(STILL, "system", "A", value=NO), "proof", "gains", value=["-1/100"])
# s + g exp(-s) has roots Re s > 0 from g = pi/2 on: none with 1/2, two with 3
LOWER = draft(
    INTEGRATOR,
    [sector("1/2", "1", time_varying=False)],
    "piecewise-popov",
    {"method": "pieces", "ends": [str(end) for end in range(1, 17)]},
    {"lambda": ["1"], "theta": ["1/2"], "pieces": [[None]] * 17},
)
TURNS = draft(INTEGRATOR, [sector("2", "4")], "counterexample", {"method": "late-turns", "gains": ["3"]})


def unknown(bound, theorem, proof, multiplier=None):
    delay = {**sector(f"-{bound}", bound, time_varying=False), "operator": "delay"}
    return draft(INTEGRATOR, [delay], theorem, proof, multiplier)


# x' = -x(t - 1 - tau): stable for tau < pi/2 - 1 = .5708; there |h| = 1 at w = 1, and w (1 + tau) = pi/2
UNKNOWN = unknown(
    "1/4",
    "piecewise-circle",
    {"method": "pieces", "ends": ["15/8", "15/4", "15/2", "15", "30"]},
    {"lambda": ["0"], "pieces": [[[x, y]] for x, y in zip("111111", ("1", "1", "9/10", "0", "0", "0"), strict=True)]},
)
LONGER = unknown(
    "3/5",
    "counterexample",
    {
        "method": "delayed-gains",
        "gains": ["1"],
        "channel": 1,
        "delays": ["569/1000", "573/1000"],
        "frequencies": ["99999/100000", "100001/100000"],
    },
)
# 1/(s + 1 + exp(-s)/2): Re 1/H = 1 + cos(w)/2 > 0, so that the circle criterion holds for every k
BACK = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, [["-1/2"]])),
    [sector("0", "10")],
    "piecewise-circle",
    {"method": "pieces", "ends": [str(end) for end in (1, 2, 3, 4, 6, 8, 12, 16)]},
    {"lambda": ["1"], "pieces": [[None]] * 9},
)
# s + 1 + 3 exp(-s): roots Re s > 0 where the delay is above arccos(-1/3)/sqrt(8) = .676; s + 3/2 - 2 < 0 at 0
COMES = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, [["-3"]])),
    [sector("0", "1/2")],
    "counterexample",
    {"method": "late-turns", "gains": ["1/4"]},
)
AWAY = draft(
    late([["-1"]], [["-1"]], ONE, NO, ("1", NO, [["-1/2"]])),
    [sector("0", "2")],
    "counterexample",
    {"method": "late-gains", "gains": ["2"]},
)
# s + a exp(-s) + g has the root i w, w = 2 pi/3 = 2.0944, for a = w/sin w = 2.4184, g = a/2 = 1.2092; there its
# derivatives are 1 in g and i - i a exp(-i w) = -2.094 + 2.209 i in w, times s in the checker, which opens the feedback
RETURNS = draft(
    late([["0"]], ONE, ONE, NO, ("1", NO, [["-24184/10000"]])),
    [sector("0", "2")],
    "counterexample",
    {
        "method": "late-crossing",
        "gains": [["12/10"], ["122/100"]],
        "frequencies": ["2089/1000", "21/10"],
        "turn": ["-2094/1000", "-2209/1000"],
    },
)
# -1/2 - exp(-s)/(s + 3): 1 + Re H >= 1 - 1/2 - 1/3; sigma - phi(sigma)/2 = y has one solution, for slopes up to 1
DIRECT = draft(
    late([["-3"]], ONE, NO, [["-1/2"]], ("1", [["-1"]])),
    [sector("0", "1", slope=["0", "1"], time_varying=False)],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1", "2", "4", "8", "16"]},
    {"lambda": ["1"], "pieces": [[None]] * 6},
)
# z = exp(-s)/(s + 1) (w - phi): |phi| <= |z|/2 leaves |z| <= |w| + |z|/2.  With weights 2 and 1 F is at least the form
# 2 |mu|^2 + |w|^2 - (2/4 + 4/25) |mu + w|^2, and |mu + w|^2 <= 3/2 (2 |mu|^2 + |w|^2): positive, as .66 3/2 = .99
BESIDE = late([["-1"]], [["1", "1"]], NO * 2, [["0", "0"]] * 2, ("1", ONE * 2))
THROUGH = sector("-2/5", "2/5", operator="performance")
GAIN = draft(
    BESIDE,
    [sector("-1/2", "1/2"), THROUGH],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1"]},
    {"lambda": ["2", "1"], "pieces": [[None, None]] * 2},
)
# phi = -sigma/2: 1/T = (1 + i/10) exp(i/10) - 1/2 = .48502 + .19933 i at w = 1/10, of modulus .52439 = 1/1.9070
ABOVE = draft(
    BESIDE,
    [sector("-1/2", "1/2"), sector("-10/19", "10/19", operator="performance")],
    "counterexample",
    {"method": "delayed-members", "gains": ["-1/2", "0"], "delays": [], "omega": "1/10", "input": [["1", "0"]]},
)
# s + 1 + s exp(-s)/2: |1/H|^2 + 3 Re 1/H = a^2 + 3 a + w^2 (1 + cos(w)/2)^2 with a = 1 + w sin(w)/2; a^2 + 3 a >= -9/4,
# and a < 0 only from w = pi on, where the rest is above 9/4.  At w = 4.2 14 a is less than minus the rest
NEUTRAL = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, NO, NO, [["-1/2"]])),
    [sector("0", "3")],
    "piecewise-circle",
    {"method": "pieces", "ends": [str(end) for end in (1, 2, 3, 4, 5, 6, 8, 12, 16)]},
    {"lambda": ["1"], "pieces": [[None]] * 10},
)
# 1/(s + 1) + exp(-s)/2: Re H >= -1/2
ECHO = draft(
    late([["-1"]], ONE, ONE, NO, ("1", [["1/2"]], NO, [["1/2"]], NO)),
    [sector("0", "3/2")],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1", "2", "4", "8", "16"]},
    {"lambda": ["1"], "pieces": [[None]] * 6},
)
# (1 + s z/2)/(s + 1 + s z^3/3), z = exp(-s/3): far out Re (z/2)/(1 + z^3/3) >= -3/4, so that every k < 4/3 has F > 0
PHASES = draft(
    late([["-1"]], ONE, ONE, NO, ("1/3", NO, NO, [["1/2"]], NO), ("1", NO, NO, NO, [["-1/3"]])),
    [sector("0", "13/10")],
    "piecewise-circle",
    {"method": "pieces", "ends": [str(2 * i) for i in range(1, 13)]},
    {"lambda": ["1"], "pieces": [[None]] * 13},
)
# s + 1 - s exp(-s)/2 - exp(-s)/2 - 2 < 0 at 0
NEUTRAL_AWAY = draft(
    late([["-1"]], [["-1"]], ONE, NO, ("1", NO, [["1/2"]], NO, [["1/2"]])),
    [sector("0", "2")],
    "counterexample",
    {"method": "late-gains", "gains": ["2"]},
)
# s + (s/4 + 2) exp(-s): |i w| = |i w/4 + 2| at w = 2.0656, where w T = pi/2 + arctan(w/8) for T = .883: roots beyond
NEUTRAL_TURNS = draft(
    late([["0"]], ONE, ONE, NO, ("1", NO, [["-2"]], NO, [["-1/4"]])),
    [sector("0", "1")],
    "counterexample",
    {"method": "late-turns", "gains": ["0"]},
)
# s + 1 + (s/2 + g) exp(-s) has the root i w, where 3 w^2/4 + 1 = g^2 and w cos(w) + sin(w) + w/2 = 0: w = 2.44066,
# g = 2.33830
NEUTRAL_RETURNS = draft(
    late([["-1"]], ONE, NO, NO, ("1", ONE, NO, NO, [["-1/2"]])),
    [sector("0", "3")],
    "counterexample",
    {
        "method": "late-crossing",
        "gains": [["2336/1000"], ["234/100"]],
        "frequencies": ["24402/10000", "24411/10000"],
        "turn": ["307/1000", "952/1000"],
    },
)
# 1/(s^2 + 4) beside a dead time that is none of a feedback: +-2 i with the gain 0
SWINGS = draft(
    late([["0", "1"], ["-4", "0"]], [["0"], ["1"]], [["0", "0"]], NO, ("1", [["1", "0"]])),
    [sector("0", "1")],
    "counterexample",
    {"method": "late-turns", "gains": ["0"]},
)
ALL = {
    "gain": GAIN,
    "above": ABOVE,
    "neutral": NEUTRAL,
    "echo": ECHO,
    "phases": PHASES,
    "neutral-away": NEUTRAL_AWAY,
    "neutral-turns": NEUTRAL_TURNS,
    "neutral-returns": NEUTRAL_RETURNS,
    "swings": SWINGS,
    "direct": DIRECT,
    "back": BACK,
    "comes": COMES,
    "away": AWAY,
    "returns": RETURNS,
    "lower": LOWER,
    "turns": TURNS,
    "unknown": UNKNOWN,
    "longer": LONGER,
    "grows": GROWS,
    "circle": CIRCLE,
    "popov": POPOV,
    "both": BOTH,
    "rest": REST,
    "crossing": CROSSING,
    "still": STILL,
}
ATTRACTS = "0 attracts every motion with inputs to the block and initial functions of finite energy"


@cache
def certificate(name):
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.slow_for("phases", "lower", "rest")
@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    assert recheck(found).accepted, recheck(found).reason
    said = {"rest": "every motion converges to the set of equilibria"} | dict.fromkeys(
        ("circle", "popov", "both", "lower", "unknown", "back", "direct", "neutral", "echo", "phases"), ATTRACTS
    )
    said |= {"gain": "the L2 gain from w to z is at most gamma in every loop of the class"}
    said |= {"above": "the L2 gain from w to z is above gamma in a loop of the class"}
    moves = "a loop of the class has a motion that does not converge to an equilibrium"
    assert check(found).certificate["conclusion"] == said.get(name, moves)


def test_a_gain_with_a_constant_solution_shows_other_equilibria_alone():
    found = edited(edited(STILL, "proof", "gains", value=["-1"]), *CLASS, "sector", value=["-1", "0"])
    assert "equilibria other than 0" in complete_and_check(found).claim


@pytest.mark.slow_for("phases-laws-channels-0-sector", "rest-laws-channels-0-sector0", "rest-laws-channels-0-sector1")
@pytest.mark.parametrize(
    "change",
    [
        ("circle", *CLASS, "sector", ["0", "17"]),
        (
            "circle",
            *CLASS,
            {
                "sector": ["-1", "1"],
                "slope": None,
                "odd": False,
                "linear": False,
                "time_varying": False,
                "operator": "delay",
            },
        ),
        ("circle", "system", "late", [["1", [["0", "3"], ["0", "0"]]]]),
        ("circle", "system", "late", []),
        ("circle", "system", "late", [["0", [["0", "1"], ["0", "0"]]]]),
        ("circle", "system", "late", [["1", UNIT], ["1", UNIT]]),
        ("circle", "system", "late", [["1", UNIT[:1]]]),
        ("circle", "system", "late", [["1", [["0", "1", "0"], ["0", "0", "0"]]]]),
        ("circle", "system", "time", "discrete"),
        ("circle", "system", "kind", "multivariable"),
        ("circle", "system", "A", [["1", "0"], ["0", "-1"]]),
        ("circle", "system", "A", [["0", "0"], ["0", "-1"]]),
        ("circle", "system", "D", [["-1/10", "0"], ["0", "0"]]),
        ("circle", "multiplier", "lambda", ["1", "-1"]),
        ("circle", "multiplier", "lambda", ["100", "1"]),
        ("circle", "multiplier", "pieces", [[["1", "0"], None]] * 9),
        ("circle", "proof", "ends", ["1/4", "1/2", "3/4", "1", "2", "4", "16", "8"]),
        ("circle", "theorem", "diagonal-circle"),
        ("popov", *CLASS, "sector", ["0", "57/25"]),
        ("popov", *CLASS, "time_varying", True),
        ("popov", "system", "late", [["11/10", ONE]]),
        ("popov", "system", "D", [["1/10"]]),
        ("popov", "multiplier", "theta", ["3"]),
        ("popov", "multiplier", "theta", ["-4/11"]),
        ("both", *CLASS, "sector", ["-11/10", "9/10"]),
        ("both", *CLASS, "sector", ["-9/10", "5/2"]),
        ("both", "system", "B", [["2"]]),
        ("rest", *CLASS, "sector", ["0", "8/5"]),
        ("rest", *CLASS, "sector", ["0", "13/10"]),  # F_11(0)/2 = 5/4 - 13/10, and above 0 from .7 on
        ("rest", *CLASS, "sector", ["-1/10", "1/2"]),
        ("rest", *CLASS, "time_varying", True),
        ("rest", "multiplier", "lambda", ["0", "1"]),
        ("rest", "multiplier", "theta", ["-1/10", "1/4"]),
        ("rest", "multiplier", "theta", ["1/4", "-1/100"]),
        ("rest", "system", "B", [["-1", "0"], ["0", "1"]]),
        ("rest", "system", "B", [["1", "1"], ["0", "1"]]),  # Lambda W R is not symmetric
        ("rest", "system", "late", [["1", [["0", "0"], ["0", "1"]]]]),  # the integrator is not seen
        ("rest", "system", "A", [["0", "1"], ["0", "0"]]),
        ("rest", "system", "A", [["0", "0"], ["0", "1"]]),
        ("crossing", "proof", "gains", [["157/100"], ["1573/1000"]]),  # outside the class
        ("crossing", "proof", "gains", [["157/100"], ["15705/10000"]]),
        ("crossing", "proof", "frequencies", ["15708/10000", "15712/10000"]),
        ("crossing", "proof", "frequencies", ["15710/10000", "15706/10000"]),
        ("crossing", "system", "late", [["101/100", ONE]]),
        ("crossing", "system", "B", [["-1"]]),
        ("still", "proof", "gains", ["-9/10"]),
        ("still", "proof", "gains", ["-12/10"]),
        ("still", "system", "late", [["1", [["4/5"]]]]),
        ("still", "system", "A", [["-2"]]),
        ("still", "system", "D", [["2"]]),
        ("lower", *CLASS, "sector", ["1/2", "8/5"]),
        ("lower", *CLASS, "sector", ["-1/2", "1"]),
        ("lower", "system", "late", [["7/2", ONE]]),  # unstable with 1/2, as pi/2 < 7/4
        ("lower", "system", "B", [["-1"]]),
        ("lower", "system", "D", [["-3"]]),
        ("lower", "system", "A", [["1"]]),
        ("lower", "multiplier", "lambda", ["0"]),
        ("lower", "multiplier", "theta", ["4"]),
        ("turns", "proof", "gains", ["3/2"]),
        ("turns", "proof", "gains", ["5"]),  # not of the class
        ("turns", "system", "late", [["1/2", ONE]]),
        ("turns", "system", "A", [["-3"]]),
        ("turns", "system", "D", [["-1"]]),
        ("unknown", *CLASS, "sector", ["-3/5", "3/5"]),
        ("unknown", *CLASS, "time_varying", True),
        ("unknown", "system", "late", [["3/2", ONE]]),
        ("unknown", "system", "late", [["8/5", ONE]]),
        ("unknown", "multiplier", "pieces", [[["1", "0"]]] * 6),
        ("unknown", "multiplier", "pieces", [[["1", "1"]]] * 6),
        ("longer", *CLASS, "sector", ["-1/2", "1/2"]),
        ("longer", "proof", "delays", ["569/1000", "57/100"]),
        ("longer", "proof", "delays", ["572/1000", "573/1000"]),
        ("longer", "proof", "frequencies", ["1001/1000", "1002/1000"]),
        ("longer", "proof", "gains", ["0"]),
        ("longer", "system", "late", [["11/10", ONE]]),
        ("direct", *CLASS, "slope", None),
        ("direct", *CLASS, "slope", ["0", "3/2"]),
        ("direct", *CLASS, "slope", ["-1", "1"]),
        ("direct", "system", "D", [["-1"]]),
        ("direct", "system", "D", [["-7/10"]]),
        ("neutral", *CLASS, "sector", ["0", "14"]),
        ("phases", *CLASS, "sector", ["0", "27/20"]),
        ("neutral", "system", "late", [["1", NO, NO, NO, [["-1"]]]]),  # not less than 1
        ("neutral", "system", "late", [["1", NO, NO, NO, [["5/4"]]]]),
        ("neutral", "system", "late", [["1", NO, NO, [["1/2"]], [["-1/2"]]]]),  # F < 0 far out
        ("neutral", "system", "late", [["1", NO, [["2"]], NO, [["-1/2"]]]]),  # -1 at 0
        ("neutral", "system", "late", [["1", NO, NO, NO]]),
        ("neutral", "system", "late", [["1", NO, NO, NO, [["-1/2", "0"]]]]),
        ("neutral", "system", "A", [["1"]]),
        ("echo", *CLASS, "sector", ["0", "2001/1000"]),
        ("echo", "system", "late", [["1", [["1/2"]], NO, [["7/10"]], NO]]),
        ("echo", "system", "late", [["1", [["1/2"]], NO, [["1/2"]], [["1"]]]]),
        (
            "echo",
            *CLASS,
            {**sector("-1/2", "1/2", time_varying=False), "operator": "linear time-invariant"},
        ),
        ("neutral-away", "proof", "gains", ["1/2"]),
        ("neutral-away", "system", "late", [["1", NO, [["-3/2"]], NO, [["1/2"]]]]),
        ("neutral-turns", "system", "late", [["1/2", NO, [["-2"]], NO, [["-1/4"]]]]),
        ("neutral-turns", "system", "late", [["1", NO, [["-2"]], NO, [["-1"]]]]),  # whatever the rest: not less than 1
        ("neutral-returns", "system", "late", [["1", ONE, NO, NO, [["1/2"]]]]),
        ("neutral-returns", "system", "late", [["1", ONE, NO, [["1/100"]], [["-1/2"]]]]),
        ("swings", "system", "A", [["0", "1"], ["-4", "-1"]]),
        ("swings", "system", "A", [["0", "1"], ["0", "-1"]]),  # a pole at 0, which is at rest
        ("swings", "system", "A", [["0", "1"], ["0", "0"]]),
        ("swings", *CLASS, "sector", ["1/100", "1"]),
        ("back", "system", "late", [["1", NO, [["-3"]]]]),  # as in "comes"
        ("back", "system", "late", [["1", NO, [["1"]]]]),  # s + 1 - exp(-s) is 0 at 0
        ("back", "system", "late", [["1", NO, [["3/2"]]]]),
        ("back", "system", "late", [["1", NO, [["-1/2", "0"]]]]),
        ("back", "system", "late", [["1", NO, []]]),
        ("back", "system", "late", [["1", NO, [["-1/2"]], NO]]),
        ("back", "system", "late", [["1", NO, [["-1/2"]]], ["2", NO]]),
        ("back", "system", "late", [["0", NO, [["-1/2"]]]]),
        ("back", "system", "A", [["1"]]),
        ("back", "system", "B", [["-1"]]),
        ("back", "system", "D", [["-1/5"]]),
        ("back", "multiplier", "lambda", ["0"]),
        ("comes", "system", "late", [["1/2", NO, [["-3"]]]]),
        ("comes", "proof", "gains", ["1"]),  # not of the class
        ("comes", "system", "A", [["-4"]]),
        ("away", "proof", "gains", ["1"]),
        ("away", "multiplier", {"lambda": ["1"]}),
        ("away", "theorem", "piecewise-circle"),
        ("away", "system", "late", [["1", NO, [["-3/2"]]]]),
        ("away", "system", "B", ONE),
        ("returns", "system", "late", [["1", NO, [["-23/10"]]]]),
        ("returns", "system", "late", [["11/10", NO, [["-24184/10000"]]]]),
        ("returns", "proof", "gains", [["1"], ["11/10"]]),
        ("returns", "proof", "gains", [["12/10"], ["21/10"]]),  # not of the class
        ("returns", "proof", "frequencies", ["21/10", "211/100"]),
        ("gain", "laws", "channels", 1, "sector", ["-9/20", "9/20"]),  # true, but not by these weights
        ("gain", "laws", "channels", 1, "sector", ["-3/5", "3/5"]),  # false: the gain is 2
        ("gain", *CLASS, "sector", ["-11/20", "11/20"]),
        ("gain", "multiplier", "lambda", ["2", "0"]),
        ("gain", "multiplier", "lambda", ["1", "1/8"]),
        ("gain", "system", "A", [["-9/10"]]),
        ("gain", "system", "A", [["0"]]),
        ("gain", "system", "late", [["1", [["1"], ["11/10"]]]]),
        ("gain", "system", "late", [["1", ONE * 2, [["-3"]]]]),  # as in "comes"
        ("above", "laws", "channels", 1, "sector", ["-1/2", "1/2"]),
        ("above", "proof", "gains", ["-3/5", "0"]),  # not of the class
        ("above", "proof", "gains", ["-1/2", "1/2"]),
        ("above", "proof", "gains", ["0", "0"]),
        ("above", "proof", "delays", ["1"]),
        ("above", "proof", "omega", "1/5"),
        ("above", "proof", "omega", "0"),
        ("above", "proof", "input", [["0", "0"]]),
        ("above", "proof", "input", [["1", "0"]] * 2),
        ("above", "system", "late", [["3", ONE * 2]]),
        ("above", "system", "late", [["1", [["1"], ["9/10"]]]]),
        ("grows", "proof", "at", "1/100"),
        ("grows", "proof", "gains", ["1/100"]),
        ("grows", "proof", "gains", ["0"]),
        ("grows", "system", "A", [["-1/50"]]),
        ("grows", "system", "B", [["-1"]]),
        ("grows", "system", "late", [["1", [["-1"]]]]),
        ("grows", "system", "D", [["101"]]),
    ],
    ids=lambda change: "-".join(map(str, change[:-1])),
)
def test_neither_checker_accepts_what_is_tampered_with(change):
    name, *path, value = change
    assert_both_reject(edited(certificate(name), *path, value=value))


def test_one_gain_that_is_not_0_makes_another_loop():
    # x_1' = -x_1, seen late, and x_2' = x_2/2 - g x_2: all gains 0 leave a root 1/2, and from g = 1 on there is none
    system = late(
        [["-1", "0"], ["0", "1/2"]], UNIT, [["0", "0"], ["0", "1"]], [["0", "0"]] * 2, ("1", [["1", "0"], ["0", "0"]])
    )
    proof = {"method": "late-turns", "gains": ["0", "0"]}
    found = complete_and_check(draft(system, [sector("0", "1"), sector("0", "2")], "counterexample", proof)).certificate
    assert recheck(found).accepted
    above = edited(found, "laws", "channels", 1, value=sector("1", "2"))
    assert_both_reject(edited(above, "proof", "gains", value=["0", "1"]))


def test_sigma_that_echoes_phi_has_no_term_of_popov():
    found = edited(certificate("neutral"), "theorem", value="piecewise-popov")
    found = edited(edited(found, *CLASS, "time_varying", value=False), "multiplier", "theta", value=["1/100"])
    assert recheck(complete_and_check(found).certificate).accepted
    echo = found | {"system": certificate("echo")["system"]}
    echo = edited(edited(echo, *CLASS, "sector", value=["0", "1"]), "proof", value=ECHO["proof"])
    assert_both_reject(edited(echo, "multiplier", "pieces", value=[[None]] * 6))


def test_the_first_piece_beside_a_pole_at_0_may_be_wide():
    # diag(exp(-s/8)/s, 1/((s + 1) (s + 2))): on [0, 8] the ball of (s + 1) (s + 2) contains 0
    A, B = [["0", "0", "0"], ["0", "-1", "0"], ["0", "1", "-2"]], [["1", "0"], ["0", "1"], ["0", "0"]]
    C, after = [["0", "0", "0"], ["0", "0", "1"]], [["1", "0", "0"], ["0", "0", "0"]]
    ends = [str(end) for end in range(8, 24)]
    multiplier = {**REST["multiplier"], "pieces": [[None, None]] * (len(ends) + 1)}
    wide = {**REST, "system": late(A, B, C, [["0", "0"]] * 2, ("1/8", after)), "multiplier": multiplier}
    found = dict(complete_and_check({**wide, "proof": {"method": "pieces", "ends": ends}}).certificate)
    assert recheck(found).accepted, recheck(found).reason


@pytest.mark.slow_for("11/10-False")
@pytest.mark.parametrize(("theta", "holds"), [("1/2", True), ("11/10", False)])
def test_what_fails_beyond_the_last_piece_alone_is_rejected(theta, holds):
    # F_22/2 = 1 + Re [(1/2 + theta i w) exp(-i w/50)/(1 + i w)]: the modulus tends to theta, the real part is positive
    # up to w = 16, where the pieces end, and about -theta at 50 pi
    short = edited(REST, "system", "late", value=[["1/50", UNIT]])
    short = edited(short, "multiplier", "theta", value=["1/4", theta])
    short = edited(short, "laws", "channels", 1, "sector", value=["0", "1/2"])
    if holds:
        assert recheck(complete_and_check(short).certificate).accepted
    else:
        assert_both_reject({**certificate("rest"), **short})


def test_a_turn_that_does_not_show_the_signs_is_refused_by_the_first_checker():
    # the second encloses the root by derivatives, and needs no turn
    with pytest.raises(Rejected):
        check(edited(certificate("crossing"), "proof", "turn", value=["1", "0"]))


def test_readers_that_do_not_know_dead_times_refuse_the_plant():
    with pytest.raises(Malformed):
        plant(COUPLED)
    for theorem, multiplier in (("diagonal-circle", {"lambda": ["1", "1"]}), ("constant-gains", {})):
        other = {**certificate("circle"), "theorem": theorem, "multiplier": multiplier}
        for proof in ({"method": "determinant"}, {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0}):
            assert_both_reject({**other, "proof": proof})
    rate = {**certificate("circle"), "rate": "1/10"}
    assert_both_reject(rate)


def test_popovs_term_far_out_is_that_of_s_times_h():
    # 1/(s + 1), theta = -2: F/2 = 1 + (1 - 2 w^2)/(1 + w^2) is negative from w = 1.42 on; without the i of s = i w
    # it would be 1 + (1 - 2 w)/(1 + w^2) > 0
    system = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": ONE, "C": ONE, "D": NO}
    proof = {"method": "pieces", "ends": ["1/2"]}
    multiplier = {"lambda": ["1"], "theta": ["-2"], "pieces": [[None], [None]]}
    wrong = draft(system, [sector("0", "1", time_varying=False)], "piecewise-popov", proof, multiplier)
    right = edited(wrong, "multiplier", "theta", value=["2"])
    found = dict(complete_and_check(right).certificate)
    assert recheck(found).accepted
    assert_both_reject(edited(found, "multiplier", "theta", value=["-2"]))


# |s exp(-s)/(8 (s + 1))| < 1/8, the limit far out at all phases: F/2 = (1 - u/8)(1 - 4/8) there in the sector [-4, u]
def test_far_out_the_size_of_what_is_fed_through_late_is_that_of_its_parts():
    echo = late([["-1"]], ONE, NO, NO, ("1", NO, NO, [["1/8"]], NO))
    proof = {"method": "pieces", "ends": [str(end) for end in range(1, 65)]}
    multiplier = {"lambda": ["1"], "pieces": [[None]] * 65}
    found = draft(echo, [sector("-4", "799999/100000")], "piecewise-circle", proof, multiplier)
    shown = complete_and_check(found).certificate
    assert recheck(shown).accepted
    assert_both_reject(edited(shown, "laws", "channels", 0, "sector", value=["-4", "800001/100000"]))


# .9 exp(-s)/(s + 1): with x = 1 .81 |H|^2 < .9 for delays with |tau'| <= 1/10, and without that bound nothing follows;
# operators of the norm 1/2 have real multipliers, of which F > 0 all the same for 1 + i/100
@pytest.mark.parametrize(
    ("bound", "operator", "path", "value"),
    [
        ("2", {"operator": "varying delay", "rate": "1/10"}, ("laws", "channels", 0, "rate"), None),
        (
            "1/2",
            {"operator": "linear time-invariant", "time_varying": False},
            ("multiplier", "pieces", 0, 0, 1),
            "1/100",
        ),
    ],
)
def test_beside_dead_times_multipliers_by_pieces_are_those_of_the_class(bound, operator, path, value):
    system, proof = edited(LAG, "B", value=[["9/10"]]), {"method": "pieces", "ends": ["1", "2", "4", "8"]}
    multiplier = {"lambda": ["0"], "pieces": [[["1", "0"]]] * 5}
    found = draft(system, [sector(f"-{bound}", bound) | operator], "piecewise-circle", proof, multiplier)
    shown = complete_and_check(found).certificate
    assert recheck(shown).accepted
    wrong = edited(shown, *path, value=value)
    if value is None:
        del wrong["laws"]["channels"][0]["rate"]
    assert_both_reject(wrong)


@pytest.mark.slow
def test_many_dead_times_are_not_multiplied_out_far_out(monkeypatch):
    # diag(1/(s + 1 + exp(-s)/4 + exp(-s/3)/5), 1/(s + 1 - exp(-2 s)/4 + exp(-s/5)/6)): Re 1/H >= .55, so that Re H > 0
    back = [("1/5", "0", "-1/6"), ("1/3", "-1/5", "0"), ("1", "-1/4", "0"), ("2", "0", "1/4")]
    parts = [(tau, [["0", "0"]] * 2, [[a, "0"], ["0", b]]) for tau, a, b in back]
    system = late([["-1", "0"], ["0", "-1"]], UNIT, UNIT, [["0", "0"]] * 2, *parts)
    multiplier = {"lambda": ["1", "1"], "pieces": [[None, None]] * 6}
    proof = {"method": "pieces", "ends": ["1", "2", "4", "8", "16"]}
    monkeypatch.setattr(pieces, "tail", None)
    found = complete_and_check(draft(system, [sector("0", "1")] * 2, "piecewise-circle", proof, multiplier)).certificate
    assert recheck(found).accepted


# H = [[g, e g], [0, g]], e = exp(-s): with the gains 0 and l it is [[g, e g/(1 + l g)], [0, g/(1 + l g)]]
@pytest.mark.parametrize("low", [(0, 0), (0, Fraction(1, 2)), (Fraction(1, 2), 0), (Fraction(1, 2), Fraction(-1, 3))])
def test_the_plant_is_shifted_by_every_lower_bound(low):
    d, N = pieces.quotients(plant(COUPLED, late=True), [Fraction(v) for v in low])
    for omega in (0.0, 0.7, 3.0):
        g, e = 1 / (1j * omega + 1), cmath.exp(-1j * omega)
        first, second = (1 + float(v) * g for v in low)
        wanted = [[g / first, e * g / (first * second)], [0, g / second]]
        for row, right in zip(N, wanted, strict=True):
            assert [value(f, omega) / value(d, omega) for f in row] == pytest.approx(right, abs=1e-12)
