"""What the second checker asks of the class, the weights and the multipliers of a theorem, beside what it accepts."""

from dataclasses import replace
from fractions import Fraction as F
from types import SimpleNamespace
from unittest.mock import Mock, patch

import numpy as np
import pytest
from flint import acb, acb_mat, acb_series, arb, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, asked, assert_accepted_if

from lure.analysis.certificates.second import pace, pieces, rays, several, structure, theorems
from lure.analysis.certificates.second.classes import ATTRACTS, EQUILIBRIA, NO_REST, Graph
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.orbits import stays_of
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import Delayed, Rational, Shifted, States
from lure.analysis.certificates.second.windows import read_forms

TIMID = replace(PLAIN, slope=None, lower=F(-1), time_varying=True)


@pytest.mark.parametrize(
    ("discrete", "direct", "holds"), [(True, 0, True), (True, -1, False), (True, 1, False), (False, 0, False)]
)
def test_nonlinearities_that_jump_see_states_in_samples(discrete, direct, holds):
    state = States(A=((F(0),),), b=(F(1),), c=(F(1),), d=F(direct))
    question = SimpleNamespace(
        system=Rational(discrete=discrete, states=state, given=None),
        theorem="circle",
        claim=SimpleNamespace(nonlinearities=replace(PLAIN, rough=True), unbounded=False),
        plain_direct=F(direct),
    )
    with assert_accepted_if(holds):
        theorems._require_scope(question)


@pytest.mark.parametrize(("changes", "holds"), [({}, True), ({"time_varying": True}, False), ({"rough": True}, False)])
def test_beside_a_pole_at_0_and_dead_time_nonlinearities_are_fixed(changes, holds):
    system = Delayed(terms=((F(1), fmpq_poly([1])),), d=fmpq_poly([0, 1]))
    claim = SimpleNamespace(nonlinearities=replace(PLAIN, **changes))
    question = SimpleNamespace(system=system, claim=claim, theorem="circle", document=SimpleNamespace(rate=None))
    with assert_accepted_if(holds):
        theorems.require_case(question, "critical")


@pytest.mark.parametrize(("common", "hidden"), [([1], False), ([1, 1], True), ([2, 2, 1], True), (None, True)])
def test_a_common_factor_is_a_hidden_mode(common, hidden):
    plant = None if common is None else SimpleNamespace(hidden=fmpq_poly(common))
    block = Shifted(n=(), d=fmpq_poly([1, 1]), discrete=False, plant=plant, case="stable")
    assert block.hidden is hidden


@pytest.mark.parametrize(("value", "holds"), [("0", True), ("1/2", True), ("-1/2", False)])
def test_the_form_of_a_sector_is_not_negative(value, holds):
    plant = asked([[0]], [[1]], [[1]], [[0]], PLAIN, discrete=True)
    with assert_accepted_if(holds):
        read_forms([{"kind": "sector", "channels": [1], "rows": [[value]]}], plant, 1, over_time=False)


ANY, LINEAR = replace(TIMID, operator="any"), replace(TIMID, operator="linear time-invariant")
SEEN, GAIN = replace(TIMID, operator="performance"), replace(PLAIN, linear=True)
LATE = replace(TIMID, operator="delay", time_varying=False)
SLOW = replace(LATE, time_varying=True, rate=F(1, 2))


@pytest.mark.parametrize(
    ("classes", "repeated", "weights", "theta", "holds"),
    [
        ((PLAIN, PLAIN), (0, 1), (1, 2), (1, -1), True),
        ((PLAIN, PLAIN), (0, 1), (1, -2), (0, 0), False),
        ((ANY, ANY), (0, 0), (1, 1), (0, 0), True),
        ((ANY, ANY), (0, 0), (1, 2), (0, 0), False),
        ((ANY, ANY), (0, 1), (1, 2), (0, 0), True),
        ((PLAIN, ANY), (0, 1), (1, 1), (0, 1), False),
        ((PLAIN, replace(PLAIN, time_varying=True)), (0, 1), (1, 1), (0, 1), False),
        ((PLAIN, replace(PLAIN, rough=True)), (0, 1), (1, 1), (0, 0), False),
        ((PLAIN, replace(PLAIN, upper="inf", slope=None)), (0, 1), (1, 1), (0, 0), False),
        ((PLAIN, replace(PLAIN, lower=F(1), upper=F(3))), (0, 1), (1, 1), (0, 0), False),  # the gain 1 alone
        ((PLAIN, LINEAR), (0, 1), (1, 0), (0, 0), True),
        ((PLAIN, LINEAR), (0, 1), (1, 1), (0, 0), False),
        ((PLAIN, GAIN), (0, 1), (1, 0), (0, 0), True),
        ((PLAIN, GAIN), (0, 1), (1, 1), (0, 0), False),
        ((GAIN, GAIN), (0, 0), (1, 1), (1, 1), True),  # one gain in two channels is as a function is
        ((PLAIN, SEEN), (0, 1), (1, 1), (0, 0), True),
        ((PLAIN, SEEN), (0, 1), (1, 0), (0, 0), False),
        ((PLAIN, SLOW), (0, 1), (1, 0), (0, 0), True),
        ((PLAIN, replace(SLOW, rate=None)), (0, 1), (1, 0), (0, 0), False),
    ],
)
def test_which_weights_channels_may_have(classes, repeated, weights, theta, holds):
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, *classes, repeated=repeated)
    with assert_accepted_if(holds):
        pieces._channels(plant, [F(v) for v in weights], [F(v) for v in theta])


@pytest.mark.parametrize(
    ("one", "direct", "pair", "end", "holds"),
    [
        (PLAIN, 0, None, 1, True),
        (PLAIN, 0, (1, 0), 1, False),
        (GAIN, 0, None, 1, False),
        *((GAIN, 1, pair, None, holds) for pair, holds in (((1, -2), True), ((-1, 0), False))),
        *((LINEAR, 1, pair, None, holds) for pair, holds in (((1, 0), True), ((1, 1), False), ((-1, 0), False))),
        *((LATE, 0, pair, 6, holds) for pair, holds in (((-1, 1), True), ((1, 0), True), ((1, -1), False))),
        (LATE, 0, (1, 1), 7, False),  # beyond a whole turn
        (LATE, 0, (1, 1), None, False),
        (LATE, 0, (-1, 0), None, True),
        (LATE, 1, (-1, 0), 6, False),
        *((SLOW, 0, pair, None, holds) for pair, holds in (((1, 1), True), ((1, -1), False), ((-1, 1), False))),
        (SLOW, 1, (1, 1), None, False),
        (SLOW, 1, (1, 0), None, True),
        (replace(SLOW, rate=None), 0, (0, 1), None, True),
        (replace(SLOW, rate=None), 0, (1, 1), None, False),
    ],
)
def test_which_multipliers_a_piece_may_have(one, direct, pair, end, holds):
    plant = asked([[-1]], [[1]], [[1]], [[direct]], one)
    kind = {PLAIN: "", GAIN: "free", LINEAR: "free", LATE: "delay"}.get(one, "slow")
    channel = pieces._Channel(kind, F(1), F(kind == ""), F(0), F(0))
    with assert_accepted_if(holds):
        row = [None if pair is None else (F(pair[0]), F(pair[1]))]
        pieces._require_row(plant, [channel], row, None if end is None else F(end))


def test_a_multiplier_is_a_pair():
    assert (pieces._pair(["1", "2"]), pieces._pair(None)) == ((F(1), F(2)), None)
    for value in (["1"], ["1", "2", "3"]):
        with assert_accepted_if(holds=False):
            pieces._pair(value)


@pytest.mark.parametrize(("one", "second", "holds"), [(LINEAR, 1, True), (LINEAR, 2, False), (LATE, 2, True)])
def test_an_operator_has_one_multiplier_on_each_piece(one, second, holds):
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, one, one, repeated=(0, 0))
    channel = pieces._Channel("delay" if one is LATE else "free", F(1), F(0), F(0))
    with assert_accepted_if(holds):
        pieces._require_row(plant, [channel] * 2, [(F(1), F(0)), (F(second), F(0))], F(1))


# Z = A (rho E)^(1/2) = 6 and E/L = 2: by (k/Z)^2 = 4, 1/4, 49/36 and 1
@pytest.mark.parametrize(
    ("k", "one", "both"),
    [(12, F(2, 3), F(1, 2)), (3, F(2, 3), F(1, 4)), (7, F(72, 13), F(1)), (6, None, F(1))],
)
def test_how_steep_the_contacts_of_rods_may_be(k, one, both):
    bar = {"E": "4", "rho": "1", "L": "2", "A": "3", "k": str(k)}
    other = {"E": "9", "rho": "1", "L": "3", "A": "5", "k": "30"}  # k = 2 Z, (E/L)/(q - 1) = 1
    assert structure._reach("one-obstacle", [bar, other]) == [one, F(1)]
    assert structure._reach("both-ends", [bar]) == [both] * 2
    assert structure._reach("across-gap", [bar, other]) == [1 / ((1 / one if one else 0) + F(3, 5))]
    assert structure._reach("across-gap", [other, bar]) == structure._reach("across-gap", [bar, other])


# q' = y, y' = -y + mu, sigma = q + y: sigma has the pole 0 with the residue 1
@pytest.mark.parametrize(
    ("channel", "one", "plant", "holds"),
    [
        ({}, {}, {}, True),
        ({"theta": F(1)}, {}, {}, True),
        ({"theta": F(-1)}, {}, {}, False),
        ({"kind": "free"}, {}, {}, False),
        ({"low": F(1, 2)}, {}, {}, False),
        ({"weight": F(-1)}, {}, {}, False),
        ({}, {"operator": "any"}, {}, False),
        ({}, {"time_varying": True}, {}, False),
        ({}, {}, {"pace": F(1, 9)}, False),
        ({}, {}, {"rates": ((fmpq_mat(2, 2), fmpq_mat(2, 2)),)}, False),
        ({}, {}, {"A": fmpq_mat([[0, 1], [0, 1]])}, False),
        ({}, {}, {"B": fmpq_mat([[0, 0], [-1, 0]])}, False),
        ({}, {}, {"A": fmpq_mat([[0, 1], [0, 0]])}, False),
    ],
)
@pytest.mark.parametrize("varying", [False, True])
def test_for_which_functions_a_pole_at_0_is_covered_beside_dead_times(channel, one, plant, holds, varying):
    # beside a channel that sees nothing, of a function above 0 that may depend on time
    beside = replace(PLAIN, lower=F(1, 2), time_varying=varying)
    whole = asked([[0, 1], [0, -1]], [[0, 0], [1, 0]], [[1, 1], [0, 0]], [[0, 0]] * 2, replace(PLAIN, **one), beside)
    known = [
        pieces._Channel(**({"kind": "", "width": F(1), "weight": F(1), "theta": F(0)} | channel)),
        pieces._Channel("", F(1), F(1), F(0), low=F(1, 2)),
    ]
    for direct in (0, 1):
        seen = replace(whole, D=fmpq_mat([[0, direct], [0, 0]]), **plant)
        with working_precision(128), assert_accepted_if(holds and not (direct and varying)):
            pieces._past_zero(seen, known, LateLoop.of(replace(seen, rates=(), D=0 * seen.D), [F(0)] * 2), F(1, 16))


def test_near_a_pole_at_0_the_form_is_that_of_complex_numbers_less_what_is_skew():
    # H = G/s, G = top/below: of the first row with the limit R = (3, 0), of the second with 0
    below, tops = [2, 0.5, 0.25], [[[6, 1, -1], [0, 2, 0.5]], [[0, 0.5, 1], [0, -1, 2]]]
    known = [pieces._Channel("", F(2), F(3), F(1, 4)), pieces._Channel("", F(1), F(1, 2), F(0), low=F(1, 3))]
    s, w = 0.4j, 0.4

    def value(p):
        return sum(c * s**k for k, c in enumerate(p))

    H = np.array([[value(p) / value(below) / s for p in row] for row in tops])
    e = np.eye(2)
    Y = np.array([3 * (e[0] + 2 * H[0]) + s / 4 * H[0], 0.5 * (e[1] + 5 / 3 * H[1])])
    wanted = Y + Y.conj().T + 2 * 0.5 / 3 * 4 / 3 * np.outer(H[1].conj(), H[1])  # 3 2 R/s + its conjugate is 0
    with working_precision(96):
        rows = [[[acb(c) for c in p] for p in row] for row in tops]
        R = [[fmpq(3), fmpq(0)], [fmpq(0), fmpq(0)]]
        found = pieces._near_zero(known, R, [acb(c) for c in below], rows, acb_series([acb(w), acb(1)]))
    assert np.array([[complex(f[0].mid()) for f in line] for line in found]) == pytest.approx(wanted)
    assert pieces._near_zero(known, R, [acb(0)] * 3, rows, acb_series([acb(w), acb(1)])) is None


# 1 + Re H > 0: whatever the phase of H = 2 w/(s + 1) from 3^(1/2) on; of 1/H = s (1 - w/2), which must not be in the
# disc about -1/2 of the radius 1/2, from |1/2 + i omega| = 1/2 + omega/2 on, omega = 2/3
@pytest.mark.parametrize(("kind", "end"), [("late", 3**-0.5), ("neutral", 1.5)])
def test_far_out_a_form_is_positive_whatever_the_phases(kind, end):
    known, row = [pieces._Channel("", F(1), F(1), F(0))], [None]
    with working_precision(96):
        late = [[[acb(0), acb(0, -2)]]]  # u/i times 2
        plant = None
        if kind == "neutral":
            zero, back = fmpq_mat([[0]]), ((fmpq_mat([[0]]), fmpq_mat([[fmpq(1, 2)]])),)
            whole = replace(asked([[0]], [[1]], [[1]], [[0]]), late=((F(1), zero),), inner=(zero,), rates=back)
            plant = LateLoop.of(whole, [F(0)])
        loop = pieces._Loop(
            [acb(1), acb(0, -1)],  # (s + 1)/s = 1 + u/i
            [[[acb(0)]]],
            [[[acb(0)]]],
            discrete=False,
            far=True,
            late=((arb(1), late, [[[acb(0)]]]),) if plant is None else (),
            plant=plant,
        )
        for share, holds in ((0.95, True), (1.05, False)):
            most = F(end * share).limit_denominator(10**6)
            assert pieces._at_any_phase(loop, known, row, most) is holds


@pytest.mark.parametrize(("back", "holds"), [(0, True), (fmpq(1, 10), False)])
def test_beside_a_delay_and_a_function_d_has_no_cycle(back, holds):
    late = replace(TIMID, operator="delay", time_varying=False, upper=F(1))
    plant = replace(asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, PLAIN, late), D=fmpq_mat([[0, 1], [back, 0]]))
    multiplier = {"lambda": ["1", "0"], "pieces": [[None, ["1", "0"]]] * 2}
    proof = {"method": "pieces", "ends": ["1"]}
    with assert_accepted_if(holds):
        pieces._read(SimpleNamespace(theorem="piecewise-circle", multiplier=multiplier, proof=proof), plant)


def test_far_out_what_comes_back_twice_as_late_turns_twice_as_far():
    # 1 + Re H > 0 for H = u/(i q), q = 1 - z/3 + z^2/3, whatever z is: for u < 1/max Im -1/q
    angles = np.exp(1j * np.linspace(0, 2 * np.pi, 10_001))
    end = 1 / np.max(-(1 / (1 - angles / 3 + angles**2 / 3)).imag)
    zero, E = fmpq_mat([[0]]), fmpq_mat([[fmpq(1, 3)]])
    late, rates = ((F(1, 2), zero), (F(1), zero)), ((zero, E), (zero, -E))
    plant = LateLoop.of(replace(asked([[0]], [[1]], [[1]], [[0]]), late=late, inner=(zero, zero), rates=rates), [F(0)])
    assert plant.steps == [1, 2]
    assert replace(plant, late=((F(1, 2), zero, zero), (F(3, 4), zero, zero))).steps == [2, 3]
    loop = pieces._Loop([acb(1)], [[[acb(0)]]], [[[acb(0)]]], discrete=False, far=True, plant=plant)
    with working_precision(64):
        for share, holds in ((0.95, True), (1.05, False)):
            most = F(end * share).limit_denominator(10**6)
            assert pieces._at_any_phase(loop, [pieces._Channel("", F(1), F(1), F(0))], [None], most) is holds


# Rates

FLOW, SAMPLES = {"kind": "state-space", "time": "continuous"}, {"kind": "transfer", "time": "discrete"}
BLOCK = {"sector": ["-1", "1"], "operator": "full block"}


@pytest.mark.parametrize(
    ("change", "rate", "holds"),
    [
        ({}, 1, True),
        ({}, -1, True),
        ({"system": SAMPLES}, -1, False),
        ({"system": SAMPLES}, 0, False),
        ({"nonlinearity": {"kind": "tanh"}}, 1, False),
        ({"theorem": "zames-falb"}, 1, True),
        *(({"theorem": theorem}, 1, False) for theorem in ("popov", "park", "diagonal-circle")),
        *(({"nonlinearities": {"sector": ["0", end], "slope": ["0", "1"]}}, 1, False) for end in ("inf", "finite")),
        ({"nonlinearities": {"sector": ["-inf", "0"], "slope": ["0", "1"]}}, 1, False),
        ({"theorem": "zames-falb", "nonlinearities": {"sector": ["0", "inf"], "slope": ["0", "1"]}}, 1, True),
        ({"theorem": "zames-falb", "nonlinearities": {"sector": ["0", "1"], "slope": ["0", "inf"]}}, 1, False),
        ({"theorem": "circle", "nonlinearities": {"channels": [{}]}}, 1, False),
        ({"theorem": "diagonal-circle", "nonlinearities": {"channels": [{}]}}, 1, True),
        ({"theorem": "diagonal-circle", "nonlinearities": {"channels": [{}, {"operator": "any"}]}}, 1, False),
        ({"theorem": "diagonal-circle", "nonlinearities": {"channels": [{}, BLOCK]}}, 1, True),
        ({"theorem": "diagonal-circle", "nonlinearities": {"channels": [BLOCK, {"operator": "delay"}]}}, 1, False),
        ({"theorem": "coupled-windows", "nonlinearities": {"channels": [{}]}}, 1, True),
        ({"theorem": "coupled-windows", "nonlinearities": {"channels": [{}, BLOCK]}}, 1, False),
        ({"theorem": "diagonal-circle", "nonlinearities": {"channels": [{"memory": "play"}, {}]}}, 1, False),
        ({"verdict": "REFUTED", "proof": {"method": "linear-gain"}}, 1, True),
        ({"verdict": "REFUTED", "proof": {"method": "equilibrium"}}, 1, False),
        ({"verdict": "REFUTED", "proof": {"method": "member", "proof": {"method": "switched-gain"}}}, 1, True),
        ({"verdict": "REFUTED", "proof": {"method": "member", "proof": {"method": "flow-orbit"}}}, 1, False),
        ({"verdict": "REFUTED", "proof": {"method": "orbit"}, "system": SAMPLES}, 1, True),
        ({"verdict": "REFUTED", "proof": {"method": "orbit"}}, 1, False),
        ({"verdict": "REFUTED", "proof": {"method": "orbit"}, "system": SAMPLES | {"kind": "state-space"}}, 1, False),
    ],
)
def test_what_goes_with_a_rate(change, rate, holds):
    plain = {"sector": ["0", "1"], "slope": ["0", "1"]}
    document = theorems.Document(
        **(
            {"verdict": "PROVED", "system": FLOW, "nonlinearities": plain, "nonlinearity": None, "theorem": "circle"}
            | {"multiplier": {}, "conclusion": "", "hypotheses": {}, "proof": {}}
            | change
        )
    )
    rows = {"A": [["-1"]], "b": ["1"], "numerator": ["1"], "denominator": ["1", "0"]}
    given = replace(document, system={**document.system, **rows})
    with assert_accepted_if(holds):
        turned = pace.weighted(given, F(rate)).system
        assert (turned == given.system) is (given.proof.get("method") == "orbit" or given.system["kind"] == "transfer")


def test_what_a_rate_says_follows_from_solutions_that_are_bounded():
    document = SimpleNamespace(verdict="PROVED", system=FLOW)
    assert "exp(-2 t)" in pace.conclusion(document, F(2), ATTRACTS, (ATTRACTS,))
    assert "(2)^t" in pace.conclusion(SimpleNamespace(verdict="PROVED", system=SAMPLES), F(2), ATTRACTS, (ATTRACTS,))
    late = SimpleNamespace(verdict="PROVED", system={"kind": pace.LATE, "time": "continuous"})
    assert "before t = 0" in pace.conclusion(late, F(2), pace.DELAYED, (ATTRACTS,))
    for one, shown in ((document, EQUILIBRIA), (document, pace.DELAYED), (late, ATTRACTS)):
        with pytest.raises(NotShown, match="not bounded"):
            pace.conclusion(one, F(2), shown, (ATTRACTS,))
    grows = SimpleNamespace(verdict="REFUTED", system=FLOW)
    assert "x(t) exp(2 t)" in pace.conclusion(grows, F(2), NO_REST, ())
    assert pace.conclusion(grows, F(2), pace.NO_SOLUTION, ()) == pace.NO_SOLUTION
    # a kernel of the mass 1/2 and the rate 2: (1 +- 1/4)^-2 of it at the rate 1/2
    masses = pace.kernel_masses(F(-1, 2), F(2), 2, causal=True, rate=F(1, 2))
    assert masses == [F(8, 25), F(8, 9)]
    assert pace.kernel_masses(F(-1, 2), F(2), 2, causal=False, rate=F(1, 2)) == masses[::-1]
    for rate in (F(2), F(-2)):
        with pytest.raises(NotShown, match="faster than the rate"):
            pace.kernel_masses(F(1, 2), F(2), 1, causal=True, rate=rate)


# Forms that may be semidefinite: x' = -x + w, z = x, V = x^2, V' = w^2 - z^2 - (x - w)^2


@pytest.mark.parametrize(
    ("theorem", "given", "P", "loose", "plant", "holds"),
    [
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "1", True, {}, True),
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "99/100", True, {}, False),
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "1", False, {}, False),
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "1", None, {}, False),
        ("diagonal-circle", {"lambda": ["0", "0"]}, "1", True, {}, False),
        ("full-block-circle", {"lambda": ["0", "1/2"], "Pi": [["0"], ["0", "0"]]}, "1", True, {}, False),
        ("diagonal-popov", {"lambda": ["0", "1/2"], "theta": ["0", "0"]}, "1", True, {}, True),
        ("diagonal-popov", {"lambda": ["0", "1/2"], "theta": ["0", "0"]}, "1", True, {"discrete": True}, False),
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "1", True, {"D": fmpq_mat([[-1, 0], [0, 0]])}, False),
        ("diagonal-circle", {"lambda": ["0", "1/2"]}, "1", True, {"rough": True}, False),
        ("diagonal-zames-falb", {"lambda": ["0", "1/2"]}, "1", True, {}, False),
        ("triangular-circle", {"lambda": ["0", "1/2"]}, "1", True, {}, False),
    ],
)
def test_where_forms_may_be_semidefinite(theorem, given, P, loose, plant, holds):
    one = replace(PLAIN, rough=plant.get("rough", False))
    sides = [[-1]], [[0, 1]], [[1], [1]], [[0, 0]] * 2
    whole = asked(*sides, one, replace(SEEN, upper=F(1)))
    whole = replace(whole, **{name: v for name, v in plant.items() if name != "rough"})
    exact = F(P)
    proof = {"method": "matrix", "P": [[str(exact.numerator)]], "exponent": 0, "semidefinite": loose}
    if exact != 1:  # 99/128
        proof |= {"exponent": 7}
    proof = {key: v for key, v in proof.items() if v is not None}
    document = SimpleNamespace(theorem=theorem, multiplier=given, proof=proof, rate=None)
    with assert_accepted_if(holds):
        assert several._proved(document, whole) is False


# What follows: of functions, of gains, beside play, with and without an eigenvalue 0

ROWS = {"A": [["-1"]], "B": [["1", "1"]], "C": [["1"], ["1"]], "D": [["0", "0"]] * 2}
NORM = {"sector": ["-1", "1"], "slope": None, "odd": False, "time_varying": True, "linear": False}
SECTOR = NORM | {"sector": ["0", "1"], "time_varying": False}
PLAY = SECTOR | {"slope": ["0", "1"], "memory": "play"}


@pytest.mark.parametrize(
    ("channels", "at_zero", "change", "said"),
    [
        ([SECTOR, SECTOR], False, {}, ATTRACTS),
        ([SECTOR, SECTOR], True, {}, EQUILIBRIA),
        ([SECTOR, NORM], False, {}, ATTRACTS),
        ([SECTOR, NORM], True, {}, several.claims.BOUNDED),
        ([SECTOR, NORM | {"operator": "performance"}], False, {}, several.claims.GAIN),
        ([SECTOR, NORM | {"operator": "performance"}], True, {}, several.claims.GAIN),
        ([SECTOR, NORM | {"operator": "any"}], False, {}, ATTRACTS),
        ([SECTOR, NORM | {"operator": "any"}], True, {}, None),
        ([NORM | {"operator": "any"}, NORM | {"operator": "performance"}], True, {}, None),
        ([SECTOR, PLAY], False, {}, EQUILIBRIA),
        ([SECTOR, PLAY], True, {}, None),
        ([SECTOR, PLAY], False, {"proof": {"semidefinite": True}}, None),
        ([PLAY, NORM | {"operator": "performance"}], False, {}, several.claims.GAIN),
        ([SECTOR, SECTOR], False, {"nonlinearity": {}}, None),
        ([SECTOR, SECTOR], False, {"verdict": "DOUBTED"}, None),
        ([SECTOR, SECTOR], False, {"verdict": "REFUTED"}, None),
        ([SECTOR, SECTOR], False, {"verdict": "REFUTED", "theorem": "counterexample", "multiplier": {"a": 1}}, None),
    ],
)
def test_what_is_said_of_several_channels(channels, at_zero, change, said):
    document = theorems.Document(
        **(
            {"verdict": "PROVED", "nonlinearity": None, "theorem": "diagonal-circle", "multiplier": {}, "proof": {}}
            | {"system": {"kind": "multivariable", "time": "continuous", **ROWS}, "conclusion": "", "hypotheses": {}}
            | {"nonlinearities": {"channels": channels, "repeated": False}}
            | change
        )
    )
    parts = {"_proved": Mock(return_value=at_zero), "refuted": Mock(), "increments": Mock()}
    with patch.multiple(several, **parts), assert_accepted_if(said is not None):
        assert several.shown(document) == said


def test_terms_of_plants_with_parameters_are_those_of_their_rate():
    term = {"A": [["1", "2"], ["3", "4"]], "B": [["1"], ["5"]], "common": "3", "C": []}
    found = pace._part(term, F(1, 2), discrete=True)
    assert found == term | {"A": [["2", "4"], ["6", "8"]], "B": [["2"], ["10"]]}
    assert pace._part(term, F(1, 2), discrete=False) == term | {"A": [["5/2", "2"], ["3", "11/2"]]}


# sigma + D phi(sigma) ascends: from the class, or as the file says, where 1 + l D > 0
@pytest.mark.parametrize(
    ("direct", "lower", "stated", "holds"),
    [
        (-1, F(0), True, True),
        (-1, F(0), False, False),
        (-1, F(1, 2), True, True),
        (-1, F(3, 2), True, False),
        (-1, F(1), True, False),
        (1, F(-1, 2), True, True),
        (1, F(-3, 2), True, False),
    ],
)
def test_what_is_assumed_of_a_class_is_written(direct, lower, stated, holds):
    question = SimpleNamespace(
        direct=F(-1),
        plain_direct=F(direct),
        claim=SimpleNamespace(nonlinearities=replace(PLAIN, slope=None), lower=lower),
        document=SimpleNamespace(hypotheses={"solvable": theorems.SOLVABLE if stated else "it is"}),
    )
    with assert_accepted_if(holds):
        theorems._require_composed(question, F(1))


@pytest.mark.parametrize("shift", [F(0), F(1, 4)])
def test_far_out_a_form_is_that_of_both_bounds(shift):
    # (1 + l h) (1 + u h) for l = -1/2, u = 1: positive from -1 to 2
    known = [pieces._Channel("", F(3, 2), F(1), F(0), low=F(-1, 2) - shift, shift=shift)]
    for h, holds in ((-0.99, True), (-1.01, False), (1.99, True), (2.01, False)):
        with working_precision(64):
            assert pieces._above([(acb_mat([[acb(h)]]), acb_mat(1, 1))], known, [None], arb(0)) is holds


@pytest.mark.parametrize(("h", "holds"), [(-0.99, True), (-1.01, False), (-3.99, False), (-4.01, True), (1, True)])
def test_far_out_a_square_counts_where_both_bounds_are_above_0(h, holds):
    # (1 + h/4) (1 + h) is negative between -4 and -1
    known = [pieces._Channel("", F(3, 4), F(1), F(0), shift=F(1, 4))]
    with working_precision(64):
        assert pieces._above([(acb_mat([[acb(h)]]), acb_mat(1, 1))], known, [None], arb(0)) is holds
        late = [(acb_mat([[acb(h + 1)]]), acb_mat(1, 1)), (acb_mat([[acb(1)]]), acb_mat(1, 1))]  # with any phase
        assert pieces._above(late, known, [None], arb(0)) is (h > -0.9)
    for now, far in ((-9.21, False), (-9.23, True)):  # |sigma| >= r = |now| - 2: 1 - 5/4 (r + 4) + r^2/4
        late = [(acb_mat([[acb(now)]]), acb_mat(1, 1)), (acb_mat([[acb(2)]]), acb_mat(1, 1))]
        assert pieces._above(late, known, [None], arb(0)) is far


@pytest.mark.parametrize(("left", "half", "holds"), [(2, True, True), (3, True, False), (3, False, True)])
def test_half_a_period_is_of_an_odd_function(left, half, holds):
    state = States(A=((F(-1),),), b=(F(1),), c=(F(1),), d=F(0))
    phi = Graph((F(-1), F(0), F(1)), (F(-1), F(0), F(1)), (F(left), F(1), F(1), F(2)))  # kinks at -1 and 1
    with assert_accepted_if(holds):
        assert len(stays_of(state, phi, [0, 1], half=half)) == 2


def test_plants_with_parameters_have_their_own_terms_at_a_rate():
    # n = 0 s + 1, d = (s + 2) + a 0 s^0: at s - 1/2, or z/2, with as many zeros in front
    term = {"powers": [1], "numerator": ["0", "1"], "denominator": ["1", "2"]}
    for time, denominator in (("continuous", ["1", "3/2"]), ("discrete", ["1/2", "2"])):
        found = pace._system({"kind": "family", "time": time, "terms": [term]}, F(1, 2))
        assert found["terms"] == [term | {"denominator": denominator}]


# x' = 2 x - phi(x), of a ReLU: along x < 0 the gain is 0, along x > 0 it is 1
@pytest.mark.parametrize(
    ("gain", "state", "value", "holds"),
    [("0", "-1/2", "2", True), ("0", "1/2", "2", False), ("1", "1/2", "1", True), ("1", "-1/2", "1", False)],
)
def test_a_rectifier_has_its_gain_on_its_side(gain, state, value, holds):
    plant = asked([[2]], [[1]], [[1]], [[0]], replace(PLAIN, relu=True))
    proof = {"method": "relu-ray", "gains": [[gain]], "state": [state], "value": value, "radius": "1/1000"}
    with assert_accepted_if(holds):
        rays.refuted_by_ray(SimpleNamespace(proof=proof), plant)
