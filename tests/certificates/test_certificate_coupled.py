"""Forms that couple channels and samples: exact limits, what both checkers reject, and that no member breaks a form."""

import json
import math
import random
from fractions import Fraction as F
from itertools import product
from typing import NamedTuple

import pytest
from certificate_format import FORMAT
from depth import rarely
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, SlopeBounds, as_plant
from lure.analysis import certify, max_sector
from lure.analysis.certificates import windows
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import channels
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.channels import read
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.windows import read_forms
from lure.analysis.inequality.coupled_forms import cone_of
from lure.analysis.questions.certify import ProofOptions
from lure.classes import Diagonal
from lure.plants.multivariable import MultivariablePlant

RELU = NonlinearityClass.relu()
# A recurrent network (Vahedi Noori, Hu, Dullerud, Seiler 2024): x+ = A x + B w, w = max(C x, 0), here with mu = -w
NETWORK = MultivariablePlant(
    [
        [F(v) for v in row.split()]
        for row in (".84 -.17 .10 -.04", ".17 .80 -.11 -.04", ".05 -.11 .90 -.08", "-.04 .18 .01 .74")
    ],
    [[F(v) for v in row.split()] for row in (".08 .18", ".11 -.11", ".01 .05", ".04 -.03")],
    [[F(v) for v in row.split()] for row in ("-.35 -.40 -1.04 1.36", ".90 .55 1.13 -.46")],
    [[0, 0], [0, 0]],
    dt=1,
)
# x+ = -x/2 - k max(x, 0): from x = 1 to -(1/2 + k), to (1/2 + k)/2; stable exactly for k < 3/2, a gain for k < 1/2
TURNING = MultivariablePlant([[F(-1, 2)]], [[1]], [[1]], [[0]], dt=1)
# x_1' = -x_1 - k max(x_2, 0), x_2' = -x_2 - k max(x_1, 0): where one is negative the other decays by itself, where both
# are positive each does; stable for every k, and with gains, -1 - k and -1 + k, for k < 1
INHIBITION = MultivariablePlant([[-1, 0], [0, -1]], [[0, 1], [1, 0]], [[1, 0], [0, 1]], [[0, 0], [0, 0]])


@pytest.fixture(scope="module")
def turning():
    return max_sector(TURNING, classes=[RELU], criterion="coupled-windows")


@pytest.fixture(scope="module")
def inhibition():
    return certify(INHIBITION, [NonlinearityClass.relu(0, 20)] * 2).shown


@pytest.fixture(scope="module")
def network():
    """The network with slopes [0, 1] instead of ReLUs, one nonlinearity in both channels."""
    slope = NonlinearityClass.slope_restricted(0, 1)
    return certify(NETWORK, Diagonal((slope, slope), repeated=True)).shown


def accepted_by_both(shown):
    certificate = json.loads(json.dumps(dict(shown.certificate)))
    FORMAT.validate(certificate)
    assert isinstance(check(certificate), Proved)
    assert recheck(certificate).accepted
    return certificate


def test_a_rectifier_is_proved_up_to_its_exact_limit_where_gains_fail_earlier(turning):
    assert turning.largest.low == pytest.approx(1.5, abs=1e-5)
    assert turning.largest.low < 1.5
    assert 1.5 < turning.refuted_at == pytest.approx(1.5, abs=1e-5)  # by a solution along a ray; no gain is a ReLU
    accepted_by_both(turning.proof)


def test_mutual_inhibition_is_stable_beyond_every_gain(inhibition):
    certificate = accepted_by_both(inhibition)
    assert certificate["theorem"] in ("coupled-circle", "coupled-popov")
    assert inhibition.claim.endswith("channel 2: phi = 20 max(sigma, 0) + 0 min(sigma, 0)")


def test_zames_falb_taps_of_a_repeated_nonlinearity_prove_the_network(network):
    certificate = accepted_by_both(network)
    assert certificate["theorem"] == "coupled-windows"
    assert certificate["multiplier"]["start"] is None


# Example 6, (2 z + 0.92)/(z^2 - z/2): 175/192 is the limit (a periodic solution), 0.87648 that of a form on the order
# cones of two samples, 0.65104 the circle criterion's.
def test_taps_reach_the_limit_of_a_known_loop():
    plant = MultivariablePlant([[F(1, 2), 0], [1, 0]], [[1], [0]], [[2, F("0.92")]], [[0]], dt=1)
    found = max_sector(plant, classes=[SlopeBounds(0, 1)], criterion="coupled-windows")
    assert 175 / 192 * (1 - 1e-5) < found.largest.low < 175 / 192


# Two loops beside each other, in other units: 0.1 z/(z - 0.9)^2 is proved up to 3.8 by Tsypkin's criterion for
# nonlinearities that ascend, as steeply as they like, and by Jury and Lee's for slopes of at most k
def beside_each_other(one, k):
    ends = (0, math.inf) if one == "rising" else (-math.inf, k)
    family = NonlinearityClass(sector=Sector(0, k), slope=SlopeBounds(*ends))
    plant = MultivariablePlant(
        [[0, 1, 0], [F(-81, 100), F(9, 5), 0], [0, 0, F(1, 2)]],
        [[0, 0], [0, F(3, 70)], [1, 0]],
        [[0, 0, F(1, 9)], [0, F(7, 3), 0]],
        [[0, 0], [0, 0]],
        dt=1,
    )
    return certify(plant, [family] * 2, ways=ProofOptions(criterion="coupled-windows")).shown


@pytest.fixture(scope="module")
def rising():
    return beside_each_other("rising", F("3.799"))


@pytest.mark.parametrize("one", ["rising", "falling"])
def test_tsypkins_and_the_jury_lee_criterion_beside_another_loop(one, rising):
    certificate = accepted_by_both(rising if one == "rising" else beside_each_other(one, F("3.799")))
    assert one in {each["kind"] for each in certificate["multiplier"]["forms"]}
    assert beside_each_other(one, F("3.801")) is None


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("laws", "channels", 1, "slope"), ["-1/100", "inf"]),
        (("laws", "channels", 1, "slope"), None),
        (("laws", "channels", 1, "sector"), ["0", "4"]),
        (("laws", "channels", 1, "time_varying"), True),
        (("multiplier", "forms", 3, "kind"), "falling"),
        (("multiplier", "forms", 3, "kind"), "odd rising"),
        (("multiplier", "forms", 3, "kind"), "monotone"),
        (("multiplier", "forms", 3, "channels"), [1]),
        (("multiplier", "forms", 3), lambda one: {**one, "channels": [2, 2]}),
        (("multiplier", "forms", 3, "rows", 0, 0), "0"),
    ],
)
def test_a_form_of_one_side_that_was_tampered_with_is_rejected_by_both(rising, path, value):
    assert [one["channels"] for one in rising.certificate["multiplier"]["forms"]] == [[1], [1], [2], [2]]
    assert_both_reject(edited(rising.certificate, *path, value=value))


def negated(text):
    return str(-abs(F(text)) - F(1, 1000))


FORM = ("multiplier", "forms", 0)
START = ("multiplier", "start", 0)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ((*FORM, "rows", 0, 0), negated),  # u_1 u_1
        ((*FORM, "rows", 2, 1), "1/1000"),  # v_1 u_2: at most 0
        ((*FORM, "rows", 3, 0), "1"),
        ((*FORM, "kind"), "monotone"),
        ((*FORM, "channels"), [1, 1]),
        ((*FORM, "channels"), [2]),
        ((*START, "rows", 0, 0), negated),
        (("multiplier", "start"), None),  # forms for ReLUs say nothing summed over time: tau phi is no ReLU
        (("multiplier", "samples"), 3),
        (("laws", "channels", 0), lambda one: {key: value for key, value in one.items() if key != "relu"}),
        (("laws", "channels", 0, "relu"), False),
        (("laws", "channels", 0, "odd"), True),
        (("laws", "channels", 0, "time_varying"), True),
        (("laws", "channels", 0, "sector"), ["-1", "5/4"]),
        (("laws", "channels", 0, "slope"), ["0", "2"]),
        (("laws", "channels", 0), lambda one: {**one, "sector": ["0", "8/5"], "slope": ["0", "8/5"]}),  # beyond 3/2
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("proof", "exponent"), lambda v: v + 2),
        (("system", "time"), "continuous"),
        (("system", "A", 0, 0), "-3/5"),
        (("theorem",), "order-cones"),
    ],
)
def test_a_proof_for_a_rectifier_that_was_tampered_with_is_rejected_by_both(turning, path, value):
    assert_both_reject(edited(turning.proof.certificate, *path, value=value))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ((*FORM, "rows", 0, 0), lambda v: str(F(v) / 2)),  # no longer dominant
        ((*FORM, "rows", 0, 1), "1"),  # above 0 beside the diagonal
        ((*FORM, "kind"), "odd"),
        ((*FORM, "kind"), "relu"),
        ((*FORM, "kind"), "sector"),
        (("laws", "repeated"), False),  # couples different nonlinearities
        (("laws", "channels"), lambda both: [{**one, "time_varying": True} for one in both]),
        (("laws", "channels"), lambda both: [{**one, "slope": None} for one in both]),
        (("multiplier", "start"), []),
        (("proof", "P"), lambda rows: rows[:-1]),
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("system", "D"), [["0", "1/100"], ["1/100", "0"]]),
    ],
)
def test_taps_that_were_tampered_with_are_rejected_by_both(network, path, value):
    assert_both_reject(edited(network.certificate, *path, value=value))


# Two gains 20 give the eigenvalue 19: without relu the class is refuted.
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("laws", "channels", 1), lambda one: {key: value for key, value in one.items() if key != "relu"}),
        ((*FORM, "rows", 0, 0), negated),
        ((*FORM, "rows", 3, 0), "1"),
        (("system", "D"), [["0", "1"], ["1", "0"]]),  # det(1 + D G) = 1 - g h vanishes within the slopes
        (("proof", "P", 1, 1), lambda v: str(-int(v))),
    ],
)
def test_a_static_form_that_was_tampered_with_is_rejected_by_both(inhibition, path, value):
    assert_both_reject(edited(inhibition.certificate, *path, value=value))


# Mutual inhibition beside an integrator with a ReLU: x' = -k max(x/100, 0) and faster states, which come to rest
def test_a_static_form_beside_an_integrator():
    rows = [["0", "1/(s+1)", "0"], ["1/(s+1)", "0", "0"], ["0", "0", "1/(s*(s+100))"]]
    one = ProofOptions(criterion="coupled-popov")
    shown = certify(as_plant(rows), [NonlinearityClass.relu(0, 20)] * 3, ways=one).shown
    certificate = accepted_by_both(shown)
    assert certificate["theorem"] == "coupled-popov"
    assert certificate["conclusion"] == "every motion converges to the set of equilibria"
    for path, value in [
        (("proof", "zero"), lambda rows: [*rows, rows[0]]),
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("multiplier", "forms", 0, "rows", 5, 5), "1"),  # v_3 v_3: not 0 where the integrator rests
        (("multiplier", "forms", 0, "rows", 5, 2), lambda v: str(2 * F(v))),
    ]:
        assert_both_reject(edited(certificate, *path, value=value))


def test_gains_do_not_refute_rectifiers(inhibition):
    draft = {
        "verdict": "REFUTED",
        "theorem": "counterexample",
        "multiplier": {},
        "proof": {"method": "linear-gains", "gains": ["20", "20"]},
    }
    refuting = json.loads(json.dumps({**inhibition.certificate, **draft}))
    refuting["conclusion"] = "a loop of the class has a motion that does not converge to an equilibrium"
    assert_both_reject(refuting)
    for one in refuting["laws"]["channels"]:
        del one["relu"]
    check(refuting, draft=True)  # as slopes they do


# The network with w = B2 d, z = C2 x: with samples end to end 7.556, 5.530, 3.932, 3.466 are published for ReLUs and
# one to four samples, for one slope in both channels 34.379, 13.450, 7.992, 5.844; a linear member has 3.395473.
INTO = ("-.04 .11 .14", "-.06 .03 -.02", ".02 -.03 .01", ".04 -.08 .20")
OUT_OF = (".79 -.62 -1.87 -.09", "-.67 -1.05 1.80 -.06", "2.25 -1.08 -.36 1.08")


def gain_certificate(one, theorem, gamma):
    """What the checker accepts of a bound on the L2 gain of the network."""
    entries = [[F(v) for v in row.split()] for row in INTO]
    B = [[*row, *more] for row, more in zip(NETWORK.B, entries, strict=True)]
    C = [*NETWORK.C, *([F(v) for v in row.split()] for row in OUT_OF)]
    plant = MultivariablePlant(NETWORK.A, B, C, [[0] * 5] * 5, dt=1)
    through = NonlinearityClass.performance(1 / F(gamma))
    return certify(
        plant, Diagonal((one, one, *[through] * 3), repeated=(2, 3)), ways=ProofOptions(criterion=theorem)
    ).shown


@pytest.mark.parametrize(
    ("one", "theorem", "gamma"),
    [
        (RELU, "coupled-circle", "7.557"),
        (RELU, "coupled-windows", "2.993"),
        (NonlinearityClass.slope_restricted(0, 1), "coupled-circle", "34.38"),
        (NonlinearityClass.slope_restricted(0, 1), "coupled-windows", "3.3955"),
    ],
)
def test_the_gain_of_the_network_is_certified(one, theorem, gamma):
    shown = gain_certificate(one, theorem, gamma)
    certificate = accepted_by_both(shown)
    assert certificate["theorem"] == theorem
    for path, value in [
        (("laws", "channels", 2, "sector"), ["-1", "1"]),
        (("multiplier", "lambda", 4), "0"),
        (("multiplier", "lambda", 0), "1"),
        (("multiplier", "lambda"), lambda v: [f"-{one}" for one in v]),
    ]:
        assert_both_reject(edited(shown.certificate, *path, value=value))


# -- the falsifier: random elements of each cone, random members, random signals


def classes_of(kind, *, same):
    slope = ["0", "inf"] if "rising" in kind else ["-inf", "2"] if "falling" in kind else ["0", "2"]
    entry = {"sector": ["0", "2"], "slope": slope, "odd": "odd" in kind, "time_varying": False, "linear": False}
    return {"channels": [entry | ({"relu": True} if kind == "relu" else {})] * 2, "repeated": same}


def random_form(rng, kind, samples, *, summed):
    """The rows of an element on the boundary of the cone that the search is over."""
    p, cone = 2 * samples, cone_of(kind, 2, samples, summed=summed, first=False)
    values = [F(rng.choice((0, 0, 1, 3, 8)) * (rng.choice((1, -1)) if entry.free else 1)) for entry in cone.entries]
    own = {next(k for k, sign in terms.items() if sign > 0) for terms in cone.sums}
    values = [F(0) if k in own else v for k, v in enumerate(values)]
    for terms in cone.sums:
        k = next(k for k, sign in terms.items() if sign > 0)
        values[k] += max(F(0), -sum(values[j] * int(sign) for j, sign in terms.items()))
    M = [[F(0)] * 2 * p for _ in range(2 * p)]
    for value, entry in zip(values, cone.entries, strict=True):
        M[entry.row][entry.column] += entry.sign * value
    if kind == "relu":
        return [[str(v) for v in row[: i + 1]] for i, row in enumerate(M)]
    return [[str(M[p + j][k]) for j in range(p)] for k in range(p)]


def member(rng, kind):
    """A random nonlinearity with slopes in [0, 2], phi(0) = 0, as a function of integers."""
    if kind == "relu":
        return lambda x: 2 * max(x, 0)
    if "rising" in kind or "falling" in kind:  # 0 <= p(x)/x <= 2, and p ascends as steeply as this lets it
        sides = [[max(rng.randint(0, 2 * n) for _ in range(2)) * (rng.random() < 0.5) for n in range(40)] for _ in "ab"]
        up, down = ([max(side[: n + 1]) for n in range(40)] for side in (sides if "odd" not in kind else sides[:1] * 2))
        p = lambda x: up[x] if x >= 0 else -down[-x]
        return p if "rising" in kind else lambda x: 2 * x - p(x)
    steps = [rng.choice((0, 0, 1, 2, 2)) for _ in range(40)]
    other = steps if kind == "odd" else [rng.choice((0, 0, 1, 2, 2)) for _ in range(40)]
    return lambda x: sum(steps[:x]) if x > 0 else -sum(other[:-x])


def least_value(kind, *, samples, summed, members=None, twice=True, difference=False):
    """The least value of forms that the checker takes, over random members and signals."""
    rng, least = random.Random(20261122), F(0)
    asked = channels(classes_of(kind, same=True), 2)
    for _ in range(40):
        rows = random_form(rng, kind, samples, summed=summed)
        ((_, M),), _ = windows.coupled([{"kind": kind, "channels": [1, 2], "rows": rows}], asked, samples, summed)
        for _ in range(10):
            phi = [member(rng, members or kind)] * 2
            phi = phi if twice else [phi[0], member(rng, members or kind)]
            length = 3 * samples if summed else samples
            sigma = [[rng.randint(-9, 9) for _ in range(2)] for _ in range(length)]
            u = [[f(x) for f, x in zip(phi, row, strict=True)] for row in sigma]
            v = [[2 * x - y for x, y in zip(*rows, strict=True)] for rows in zip(sigma, u, strict=True)]
            if difference:
                sigma = [[rng.randint(-9, 9) for _ in range(2)] for _ in range(length)]
                w = [[f(x) for f, x in zip(phi, row, strict=True)] for row in sigma]
                z = [[2 * x - y for x, y in zip(*rows, strict=True)] for rows in zip(sigma, w, strict=True)]
                u = [[a - b for a, b in zip(*rows, strict=True)] for rows in zip(u, w, strict=True)]
                v = [[a - b for a, b in zip(*rows, strict=True)] for rows in zip(v, z, strict=True)]
            if summed:  # at rest before and after
                rest = [[0, 0]] * (samples - 1)
                u, v = rest + u + rest, rest + v + rest
            total = F(0)
            for t in range(len(u) - samples + 1):
                y = [a for row in u[t : t + samples] for a in row] + [a for row in v[t : t + samples] for a in row]
                total += sum(M[i][j] * a * b for i, a in enumerate(y) if a for j, b in enumerate(y) if b)
            least = min(least, total)
    return least


SIDED = ["rising", "odd rising", "falling", "odd falling"]


@pytest.mark.slow_for("2-odd rising", "2-odd falling")
@pytest.mark.parametrize(
    ("samples", "kind"),
    rarely(
        product((1, 2), ["relu", "monotone", "odd", "sector", *SIDED]), (2, "monotone"), (2, "rising"), (2, "falling")
    ),
)
def test_no_member_makes_a_form_negative(kind, samples):
    assert least_value(kind, samples=samples, summed=False) == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", rarely(["monotone", "odd", "sector", *SIDED], "monotone", "odd", "rising", "falling", "odd falling")
)
def test_no_member_makes_a_form_negative_over_all_time(kind):
    assert least_value(kind, samples=2, summed=True) == 0


# The same search is not blind: each form breaks where one of its hypotheses does. The last two are why nothing is ever
# said of differences of solutions with a form that couples channels, as Lipschitz bounds of networks have been.
@pytest.mark.parametrize(
    "broken",
    [
        {"kind": "relu", "members": "monotone"},
        {"kind": "odd", "members": "monotone"},
        {"kind": "monotone", "members": "rising"},
        {"kind": "monotone", "members": "falling"},
        {"kind": "rising", "members": "falling"},
        {"kind": "falling", "members": "rising"},
        {"kind": "odd rising", "members": "rising"},
        {"kind": "odd falling", "members": "falling"},
        {"kind": "monotone", "twice": False},
        {"kind": "monotone", "difference": True},
        {"kind": "relu", "difference": True},
    ],
    ids=lambda broken: " ".join(map(str, broken.values())),
)
def test_a_form_is_negative_where_its_hypotheses_fail(broken):
    assert least_value(samples=1, summed=False, **broken) < 0


class Question(NamedTuple):
    """What the second checker reads of a certificate to know the classes."""

    system: dict
    nonlinearities: dict


def test_both_checkers_read_the_same_forms():
    rng, taken = random.Random(20261122), 0
    system = {"kind": "multivariable", "time": "discrete"}
    system |= {name: [["0", "0"], ["0", "0"]] for name in "ABCD"}
    for trial in range(160):
        kind, summed, same = rng.choice(("relu", "monotone", "odd", *SIDED)), rng.random() < 0.5, rng.random() < 0.8
        other = rng.choice((kind, kind, *SIDED)) if kind in SIDED else kind
        given, samples = classes_of(other, same=same), rng.choice((1, 2))
        rows = random_form(rng, kind, samples, summed=summed)
        if trial % 2:
            i = rng.randrange(len(rows))
            rows[i][rng.randrange(len(rows[i]))] = str(rng.randint(-4, 4))
        forms = [{"kind": kind, "channels": [1, 2], "rows": rows}]
        try:
            first = windows.coupled(forms, channels(given, 2), samples, summed)
        except Rejected:
            first = None
        try:
            second = read_forms(forms, read(Question(system, given)), samples, over_time=summed)
        except NotShown:
            second = None
        assert (first is None) == (second is None), (kind, summed, same, rows)
        taken += first is not None
        if first is not None:
            assert [[str(v) for v in row] for row in first[0][0].M] == [
                [str(v) for v in row] for row in second.each[0].M.tolist()
            ]
    assert 40 < taken < 140


# x' = -x - phi, sigma = -x: the gain 1 is the end. 2 x (-x - phi) + 2 phi (-k x - phi) falls for (1 + k)^2 < 4, and
# with phi (-k x - 2 phi) in its place it would for (1 + k)^2 < 8
def test_a_form_of_one_sample_is_about_the_bounds_of_its_class():
    family = {"sector": ["0", "49/50"], "slope": None, "odd": False, "time_varying": True, "linear": False}
    plant = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": [["1"]], "C": [["-1"]], "D": [["0"]]}
    draft = {
        "verdict": "PROVED",
        "system": plant,
        "laws": {"channels": [family], "repeated": False},
        "theorem": "coupled-circle",
        "multiplier": {"forms": [{"kind": "sector", "channels": [1], "rows": [["1"]]}]},
        "proof": {"method": "matrix", "P": [["1"]], "exponent": 0},
    }
    shown = complete_and_check(draft).certificate
    assert recheck(shown).accepted
    assert_both_reject(edited(shown, "laws", "channels", 0, "sector", 1, value="3/2"))
