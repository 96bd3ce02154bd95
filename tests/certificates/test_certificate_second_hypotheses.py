"""What the second checker asks of the class, the weights and the multipliers of a theorem, beside what it accepts."""

from dataclasses import replace
from fractions import Fraction as F
from types import SimpleNamespace

import pytest
from flint import fmpq_poly
from second_plants import PLAIN, asked, assert_accepted_if

from lure.analysis.certificates.second import pieces, structure, theorems
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
