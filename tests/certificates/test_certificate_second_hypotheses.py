"""What the second checker asks of the class, the weights and the multipliers of a theorem, beside what it accepts."""

from dataclasses import replace
from fractions import Fraction as F
from types import SimpleNamespace

import numpy as np
import pytest
from flint import acb, acb_series, arb, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, asked, assert_accepted_if

from lure.analysis.certificates.second import pieces, structure, theorems
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import working_precision
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
