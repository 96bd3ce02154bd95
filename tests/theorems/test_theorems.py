"""The suite over the table of theorems: what every criterion has to satisfy, whatever its inequality."""

import json
import math
from contextlib import suppress
from fractions import Fraction as F
from functools import cache
from pathlib import Path

import pytest
from depth import sampled
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plants import CONTINUOUS, DISCRETE, product, stable_plants
from sharpness import CLOSE, raised
from tampering import refused_again

from lure.analysis import max_slope
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.proposals import certified
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.gains import hurwitz_limit, is_stable_gain
from lure.analysis.theorems.differences import tsypkin_largest, tsypkin_odd_largest
from lure.analysis.theorems.table import BEST, CRITERIA, LAST, TABLE, row_of, theorems_for
from lure.analysis.verdict import Verdict
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant

ROOT = Path(__file__).parents[2]
ALL = [pytest.param(row, time, id=f"{row.name}-{time}") for row in TABLE for time in row.times]
EVERY = [case for case in ALL if case.values[0].stage < LAST]  # the last stage costs seconds: test_order_cone.py
RANDOMLY = [case for case in EVERY if case.values[0].stage < 2]
SECOND = ("theorems", "question", "pace", "boxes")
FOUND = {"continuous": CONTINUOUS[1], "discrete": DISCRETE[6]}


def with_each(first, *others):
    """Every criterion with every value; the dearest one with the first, and with the others in `make thorough`."""
    dear = [case for case in EVERY if (case.values[0].name, case.values[1]) == ("zames-falb", "discrete")]
    return [
        pytest.param(
            *case.values,
            value,
            id=f"{case.id}-{value}",
            marks=[pytest.mark.thorough] * (value != first and case in dear),
        )
        for value in (first, *others)
        for case in EVERY
    ]


def reach(row, block, lower=0):
    """What the criterion proves of the least class that it is about: odd only where it must be."""
    return row.answer(block, lower=F(lower), odd=False)


@cache
def usual(row, time):
    """What the criterion proves of the block of its time, which several tests compare with others."""
    return reach(row, FOUND[time])


def with_time(block, time, speed):
    """``H(s/speed)``, or the same samples at another rate."""
    if time == "discrete":
        return RationalPlant(block.numerator, block.denominator, dt=speed)
    lead = len(block.denominator) - len(block.numerator)
    return RationalPlant(
        [c * speed ** (lead + i) for i, c in enumerate(block.numerator)],
        [c * speed**i for i, c in enumerate(block.denominator)],
    )


def with_gain(block, gain):
    return RationalPlant([gain * c for c in block.numerator], block.denominator, dt=block.dt)


def supporting_proof(block, lower):
    """``H/(1 + lower H)``, the loop closed with the gain ``lower``."""
    padded = [F(0)] * (len(block.denominator) - len(block.numerator)) + list(block.numerator)
    return RationalPlant(
        block.numerator, [d + lower * n for d, n in zip(block.denominator, padded, strict=True)], dt=block.dt
    )


def assert_same(one, other, *, scale=1, shift=0, rel=1e-6):
    """Assert that two ends, one of them rescaled, are the same number, as far as a search determines it."""
    assert float(scale) * other.largest.low + float(shift) == pytest.approx(one.largest.low, rel=rel)
    assert one.verdict is other.verdict


@pytest.mark.slow_for("zames-falb-discrete-1/1000000")
@pytest.mark.parametrize(("row", "time", "speed"), with_each(F(1, 10**6), F(3), F(10**4)))
def test_the_unit_of_time_changes_nothing(row, time, speed):
    assert_same(usual(row, time), reach(row, with_time(FOUND[time], time, speed)))


@pytest.mark.parametrize(("row", "time", "gain"), with_each(F(1, 10**9), F(3000)))
def test_a_gain_moves_between_the_block_and_the_class(row, time, gain):
    assert_same(usual(row, time), reach(row, with_gain(FOUND[time], gain)), scale=gain)


# phi = l sigma + phi': the class [l, l + k] of H is the class [0, k] of H/(1 + l H)
@pytest.mark.slow_for("zames-falb-discrete--1/10")
@pytest.mark.parametrize(("row", "time", "lower"), with_each(F(-1, 10), F(1, 5)))
def test_a_shift_of_the_class_is_a_shift_of_the_loop(row, time, lower):
    found = reach(row, FOUND[time], lower)
    assert_same(found, reach(row, supporting_proof(FOUND[time], lower)), shift=lower)
    assert found.nonlinearity_class.sector.lower == lower


@st.composite
def sampled_plants(draw):
    """Stable blocks of order 1 to 4 in discrete time, from well damped to nearly on the circle."""
    bottom = []
    for _ in range(draw(st.integers(1, 2))):
        r, c = (
            draw(st.fractions(F(1, 20), F(19, 20), max_denominator=40)),
            draw(st.fractions(-1, 1, max_denominator=20)),
        )
        bottom.append(draw(st.sampled_from([[1, r], [1, -r], [1, -2 * r * c, r * r]])))
    d = product(*bottom)
    n = [draw(st.fractions(-3, 3, max_denominator=10)) for _ in range(len(d) - 1)]
    assume(any(n))
    return RationalPlant(n, d, dt=1)


RANDOM = {
    "continuous": stable_plants(critical=False).filter(lambda plant: plant.order <= 5 and any(plant.numerator)),
    "discrete": sampled_plants(),
}


FEW = settings(max_examples=sampled(4, of=1000))  # for each row


@pytest.mark.slow_for("park-continuous", "circle-continuous")
@pytest.mark.parametrize(("row", "time"), RANDOMLY)
@FEW
@given(
    data=st.data(), speed=st.fractions(F(1, 50), 50, max_denominator=50), lower=st.fractions(0, 1, max_denominator=9)
)
def test_the_symmetries_hold_for_random_blocks(row, time, data, speed, lower):
    block = data.draw(RANDOM[time])
    moved = with_gain(with_time(block, time, speed), speed)
    assert_same(reach(row, block), reach(row, moved), scale=speed)
    assume(1 + lower * block.feedthrough != 0 and is_stable_gain(block, lower))
    assert_same(reach(row, block, lower), reach(row, supporting_proof(block, lower)), shift=lower)


@pytest.mark.parametrize(("row", "time"), RANDOMLY)
@FEW
@given(data=st.data())
def test_no_criterion_proves_more_than_the_linear_gains_allow(row, time, data):
    block = data.draw(RANDOM[time])
    found = reach(row, block)
    assert row.linear or found.verdict is Verdict.PROVED
    assert found.largest.low <= hurwitz_limit(block).high
    if math.isfinite(found.largest.low) and not row.linear:
        assert is_stable_gain(block, F(found.largest.low))


@pytest.mark.slow_for("zames-falb-discrete")
@pytest.mark.parametrize(("row", "time"), EVERY)
def test_the_decision_about_a_class_is_sharp_from_both_sides(row, time):
    block, found = FOUND[time], usual(row, time)
    inside = row.decide(block, Sector(0, found.largest.low * (1 - (1e-3 if row.stage == 2 else 1e-9))))
    beyond = row.decide(block, Sector(0, found.largest.high * (1 + 1e-9)))
    assert beyond.verdict is not Verdict.PROVED
    if row.linear:  # it proves nothing of nonlinearities, and refutes with a gain
        assert (inside.verdict, beyond.verdict) == (Verdict.INCONCLUSIVE, Verdict.REFUTED)
    else:
        assert inside.verdict is Verdict.PROVED


@pytest.mark.parametrize(("row", "time"), EVERY)
def test_both_checkers_accept_the_certificate_and_neither_one_beyond_the_end(row, time):
    block, found = FOUND[time], usual(row, time)
    accepted = certified(block, found)
    certificate = json.dumps(accepted.proved.certificate)
    assert isinstance(check(certificate), Proved)
    assert recheck(certificate).accepted
    assert found.largest.low * (1 - (1e-3 if row.stage == 2 else CLOSE)) <= accepted.upper <= F(found.largest.low)
    beyond = raised(accepted.proved.certificate, F(found.largest.high) / accepted.upper * (1 + CLOSE))
    with pytest.raises(Rejected):
        check(completed(beyond))
    larger = {**json.loads(certificate), "laws": beyond["laws"]}
    assert refused_again(larger)


# Without its weight, or with the trivial multiplier, every other criterion is the circle criterion.
@pytest.mark.parametrize(("row", "time"), RANDOMLY)
@FEW
@given(data=st.data())
def test_every_criterion_reaches_at_least_as_far_as_the_circle_criterion(row, time, data):
    block = data.draw(RANDOM[time])
    circle, found = reach(row_of("circle", block), block), reach(row, block)
    assert found.largest.high >= circle.largest.low
    assert found.largest.low >= circle.largest.low * (1 - 1e-9)


# The upper end is not claimed but shown: a class beyond it is not proved, one just below the lower end is.
@pytest.mark.slow_for("popov-continuous", "park-continuous")
@pytest.mark.parametrize(("row", "time"), [case for case in RANDOMLY if not case.values[0].linear])
@FEW
@given(data=st.data())
def test_random_brackets_are_narrow_and_decided_on_both_sides(row, time, data):
    block = data.draw(RANDOM[time])
    found = reach(row, block)
    if math.isfinite(found.largest.high):
        assert found.largest.width <= 1e-8 * found.largest.high
        assert row.decide(block, Sector(0, found.largest.low * (1 - 1e-6))).verdict is Verdict.PROVED
        with suppress(InputError):  # at 1 + k H(inf) = 0 the question itself is refused
            assert row.decide(block, Sector(0, found.largest.high * (1 + 1e-6))).verdict is not Verdict.PROVED


# The class of a certificate is the one that the row of the table promises, no larger.
@pytest.mark.parametrize(("row", "time"), EVERY)
def test_the_class_of_the_certificate_is_that_of_the_row(row, time):
    found = usual(row, time)
    nonlinearities = certified(FOUND[time], found).proved.certificate["laws"]
    assert nonlinearities["linear"] is row.linear
    assert nonlinearities["odd"] is row.only_odd
    assert nonlinearities["time_varying"] is row.time_varying
    assert (nonlinearities["slope"] is not None) is row.slope
    if row.slope:
        ends = found.nonlinearity_class.slope
        assert [end in ("inf", "-inf") for end in nonlinearities["slope"]] == [
            ends.lower == -math.inf,
            ends.upper == math.inf,
        ]
        assert row.free == ("below" if ends.lower == -math.inf else "above" if ends.upper == math.inf else "")


@pytest.mark.parametrize(("row", "time"), ALL)
def test_a_criterion_is_found_by_each_of_its_names_and_refused_where_it_does_not_apply(row, time):
    block = FOUND[time]
    for name in (row.name, row.name.replace("-", "_").upper(), *row.aliases):
        assert theorems_for(block, "slope", name, odd=True) == [row]
    assert row_of(row.name, block) is row
    if row.slope:
        with pytest.raises(AssumptionError, match=f"the criterion {row.name} needs slope bounds"):
            theorems_for(block, "sector", row.name)
    if not row.time_varying:
        with pytest.raises(
            AssumptionError, match=f"{row.name} (is for time-invariant nonlinearities|needs slope bounds)"
        ):
            theorems_for(block, "sector", row.name, time_varying=True)
    other = FOUND["discrete" if time == "continuous" else "continuous"]
    if not any(each.name == row.name for each in TABLE if time not in each.times or len(each.times) > 1):
        with pytest.raises(AssumptionError, match=f"the criterion {row.name} is for {time} time"):
            theorems_for(other, "slope", row.name)


def test_a_certificate_for_odd_laws_is_one_for_no_others():
    plant = RationalPlant([F("-0.1"), 0], [1, F("1.8"), F("0.81")], dt=1)
    certificate = certified(plant, tsypkin_odd_largest(plant)).proved.certificate
    assert recheck(certificate).accepted
    every = {**certificate, "laws": {**certificate["laws"], "odd": False}}
    assert refused_again(every)
    with pytest.raises(Rejected, match="odd nonlinearities"):
        completed({key: every[key] for key in every if key not in ("hypotheses", "conclusion")})


# sigma_t -> (-1)^t sigma_t maps odd nonlinearities to themselves and H(z) to H(-z), 1 - z^-1 to 1 + z^-1
@pytest.mark.parametrize("example", [1, 2, 5])
def test_tsypkins_criterion_for_odd_laws_is_that_of_the_block_turned_round(example):
    block = DISCRETE[example]
    turned = [
        [c * (-1) ** i for i, c in enumerate(reversed(side))][::-1] for side in (block.numerator, block.denominator)
    ]
    one, other = tsypkin_largest(block), tsypkin_odd_largest(RationalPlant(*turned, dt=1))
    assert other.largest.low == pytest.approx(one.largest.low, rel=1e-9)
    assert other.nonlinearity_class.odd


def test_a_criterion_for_odd_laws_is_not_asked_about_others():
    plant = RationalPlant([F("-0.1"), 0], [1, F("1.8"), F("0.81")], dt=1)
    with pytest.raises(AssumptionError, match="the criterion tsypkin-odd is for odd nonlinearities"):
        max_slope(plant, criterion="tsypkin-odd")
    found = max_slope(plant, criterion="tsypkin-odd", odd=True, search="linear")
    assert found.largest.low == pytest.approx(3.8, rel=1e-6)
    assert "odd phi with slope in [0, inf], in the sector [0, 3.79999" in str(found)


def test_a_name_that_does_not_exist_is_answered_with_all_that_do():
    with pytest.raises(InputError, match=f"did you mean 'park'.*{', '.join(CRITERIA)}"):
        theorems_for(CONTINUOUS[1], "slope", "parks")


def test_best_asks_every_criterion_about_nonlinear_laws_the_cheap_ones_first():
    for time, block in FOUND.items():
        rows = theorems_for(block, "slope", BEST, odd=True)
        assert [row for row in TABLE if time in row.times and not (row.linear or row.broad)] == rows
        assert theorems_for(block, "slope", BEST) == [row for row in rows if not row.only_odd]
        assert [row.stage for row in rows] == sorted(row.stage for row in rows)


def test_dead_time_leaves_the_criteria_that_have_a_function_for_it():
    block = DelayPlant.parse("exp(-s)/(s + 1)")
    assert [row.name for row in theorems_for(block, "sector", BEST)] == ["circle", "popov"]
    assert theorems_for(block, "slope", BEST) == [row for row in TABLE if row.late or row.name in ("circle", "popov")]
    with pytest.raises(
        AssumptionError, match=r"the criterion off-axis-circle is evaluated for rational blocks.*ask circle or popov"
    ):
        theorems_for(block, "slope", "off-axis")


# The name of a criterion about slopes stands in its row, its own module, the two checkers and the export to Coq, which
# states the theorem as its hypothesis, and nowhere else.
@pytest.mark.parametrize("name", sorted({row.name for row in TABLE if row.slope}))
def test_a_criterion_is_named_in_one_place(name):
    own = {f"analysis/{row.largest.split(':')[0].replace('.', '/')}.py" for row in TABLE if row.name == name}
    checkers = {f"analysis/certificates/{each}.py" for each in ("checker", "blocks")} | {
        f"analysis/certificates/second/{each}.py" for each in SECOND
    }
    files = [path for package in ("lure", "analysis") for path in (ROOT / package).rglob("*.py")]
    found = {path.relative_to(ROOT).as_posix() for path in files if f'"{name}"' in path.read_text("utf-8")}
    found = {path.removeprefix("lure/") if path.startswith("lure/analysis/") else path for path in found}
    assert found <= own | checkers | {"analysis/theorems/table.py", "analysis/export/relying.py"}
