"""Loops with one nonlinearity in the second checker: plants, dead time, theorems, rates beside their formulas."""

import cmath
from dataclasses import replace
from fractions import Fraction as F
from itertools import product
from types import SimpleNamespace

import pytest
from flint import acb, arb, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, assert_accepted_if, at, poly, rational, transfer

from lure.analysis.certificates.second import pace, theorems
from lure.analysis.certificates.second.axis import Multiplier
from lure.analysis.certificates.second.classes import BOUNDED, DELAYED, EQUILIBRIA, Claim
from lure.analysis.certificates.second.numerics import (
    Laurent,
    ball,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.question import (
    Question,
    read_kernels,
    read_taps,
    require_legal,
    require_polynomial,
    require_written,
)
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import (
    Delayed,
    Plant,
    RodData,
    Shifted,
    read_system,
    require_well_posed,
    shifted,
    square_root,
)

ONE, Z = fmpq_poly([1]), fmpq_poly([0, 1])
FREE = replace(PLAIN, upper="inf", slope=None)
FINITE = replace(PLAIN, upper="finite", slope=None)


def value(p, s):
    """A polynomial at a complex number."""
    return sum((int(c.p) / int(c.q) * s**k for k, c in enumerate(p.coeffs())), 0j)


# Plants


def test_a_plant_of_matrices_has_the_polynomials_of_its_response():
    found = rational([[1, 2], ["1/3", -4]], [1, "1/2"], [3, -1], "2/3")
    sides = fmpq_mat([[1, 2], [fmpq(1, 3), -4]]), fmpq_mat([[1], [fmpq(1, 2)]]), fmpq_mat([[3, -1]])
    H, (n, d) = at((*sides, fmpq_mat([[fmpq(2, 3)]])), fmpq(3))[0, 0], found.polynomials
    assert n(fmpq(3)) == H * d(fmpq(3))
    assert (d, found.feedthrough, found.states.order) == (sides[0].charpoly(), F(2, 3), 2)
    g = F(3, 5)
    closed = fmpq_mat([[to_fmpq(v) for v in row] for row in found.states.closed(g)])
    assert found.closed(g) == (1 + to_fmpq(g) * fmpq(2, 3)) * closed.charpoly()


@pytest.mark.parametrize(("n", "d"), [("2 3 5", "4 1 7"), ("1 2", "-3 1 5"), ("7", "2"), ("0 0 3", "1 0 2 5")])
def test_a_transfer_function_has_its_companion_form(n, d):
    found = transfer(n, d)
    s, (top, bottom), state = fmpq(3), found.polynomials, found.states
    assert [top(s), bottom(s)] == [fmpq_poly([*map(int, side.split()[::-1])])(s) for side in (n, d)]
    sides = (
        [[to_fmpq(v) for v in row] for row in state.A],
        [[to_fmpq(v)] for v in state.b],
        [list(map(to_fmpq, state.c))],
    )
    inner = at((*map(fmpq_mat, sides), fmpq_mat([[0]])), s)[0, 0] if state.order else 0
    assert to_fmpq(state.d) + inner == top(s) / bottom(s)


def test_the_response_of_a_plant_is_that_of_complex_numbers():
    w = 1.3
    for n, d, power in (((2, -1, 3), (1, 4, 2, 5), 0), ((0, 3, 1), (0, 2, 1), 2), ((0, 0, 1), (0, 0, 3, 1), 4)):
        top, bottom = value(poly(*n), 1j * w), value(poly(*d), 1j * w)
        cross = top * bottom.conjugate()
        found = Plant(n=poly(*n), d=poly(*d), degree=len(d) - 1).response()
        wanted = [abs(bottom) ** 2, cross.real, -w * cross.imag]
        assert [value(p, w * w).real for p in found] == pytest.approx([v / w**power for v in wanted])


@pytest.mark.parametrize(
    ("n", "d", "lower", "discrete", "case"),
    [
        ("1", "1 1", 0, False, "stable"),
        ("1", "1 0", 0, False, "critical"),
        ("-1", "1 0", 0, False, None),
        ("1", "1 1 0", 0, False, "critical"),
        ("1", "1 0 0", 0, False, None),
        ("1", "1 0 1", 0, False, None),
        ("1", "1 0 1 0", 0, False, None),
        ("1", "1 -1", 0, False, None),
        ("1", "1 -1 0", 0, False, None),
        ("-1", "1 -1 0", 0, False, None),
        ("1", "1 -1", F(1), False, "critical"),
        ("1", "1 -1", F(2), False, "stable"),
        ("1 0", "1 1 0", 0, False, None),  # s/(s (s + 1)) does not see the pole at 0
        ("-1 0", "1 1", 1, False, None),  # 1 + l H(inf) = 0
        ("1", "1 -1", 0, True, "critical"),
        ("-1", "1 -1", 0, True, None),
        ("1", "1 1", 0, True, None),
        ("1", "1 -2", 0, True, None),
        ("1", "1 -2 1", 0, True, None),
        ("1", "1 -1/2", 0, True, "stable"),
        ("0", "1 1", 0, False, "stable"),
        ("0", "1 0", 0, False, None),
    ],
)
def test_poles_after_the_shift_are_stable_or_one_at_0_of_the_right_sign(n, d, lower, discrete, case):
    with assert_accepted_if(case is not None):
        found = shifted(transfer(n, d, discrete=discrete), F(lower))
        assert (found.case, found.discrete, found.back) == (case, discrete, ())


@pytest.mark.parametrize(
    ("direct", "lower", "upper", "holds"),
    [
        (0, 0, "inf", True),
        (1, 0, "inf", True),
        (-1, 0, "inf", False),
        (-1, 0, "finite", False),
        (-1, 0, F(1, 2), True),
        (-1, 0, F(1), False),
        (-1, 0, F(3, 2), False),
        (-1, 2, F(3), True),
        (-1, 2, "inf", True),
        (-1, 1, F(2), False),
        (-1, 1, "inf", False),
        (1, -2, F(-3, 2), True),
        (1, -2, F(0), False),
        (1, -2, "inf", False),
        (1, -1, F(2), False),
        (1, F(-1, 2), "finite", True),
    ],
)
def test_a_loop_is_well_posed_where_1_and_gains_times_the_direct_term_keep_their_sign(direct, lower, upper, holds):
    with assert_accepted_if(holds):
        require_well_posed(F(direct), F(lower), upper)


def test_the_rod_of_two_cells():
    # c = 3, s = c 2/L = 4, d = 1/Z = 1/6 per area 1/2: root = 6, Z = 3, a = (1 - 3)/(1 + 3)
    found = RodData(E=F(18), rho=F(2), length=F(3, 2), area=F(1, 2), k=F(1), cells=2).states().states
    rows = ((-4, 0, 0, 2, 0), (4, -4, 0, 0, 0), (0, 4, -4, 0, 0), (0, 0, 4, -4, 0), (0, 1, 0, 0, 0))
    assert rows == found.A
    assert (found.b, found.c, found.d) == ((0, 0, F(4, 3), 0, F(1, 6)), (0, 0, 0, 0, 1), 0)
    for changes in ({"k": F(-3)}, {"E": F(19)}, {"cells": None}):
        with pytest.raises(NotShown):
            RodData(
                **({"E": F(18), "rho": F(2), "length": F(1), "area": F(1, 2), "k": F(1), "cells": 2} | changes)
            ).states()
    assert square_root(F(9, 4)) == F(3, 2)


TRANSFER = {"kind": "transfer", "time": "discrete", "numerator": ["1"], "denominator": ["1", "2"]}
STATES = {"kind": "state-space", "time": "continuous", "A": [["1"]], "b": ["1"], "c": ["1"], "d": "0"}
LATE = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "2"], "feedback": [["2", ["1"]]]}
ROD = {"kind": "rod-scheme", "E": "1", "rho": "1", "L": "1", "A": "1", "k": "-1", "cells": 1}


@pytest.mark.parametrize(
    ("system", "change"),
    [
        *((TRANSFER, change) for change in ({"time": "x"}, {"numerator": []}, {"denominator": []})),
        *(
            (TRANSFER, change)
            for change in ({"denominator": ["0", "2"]}, {"numerator": ["1", "2", "3"]}, {"more": "1"})
        ),
        *((STATES, change) for change in ({"A": []}, {"A": [["1", "2"]]}, {"b": []}, {"c": ["1", "2"]}, {"d": None})),
        *((LATE, {"terms": terms}) for terms in ([], [["-1", ["1"]]], [["1", []]], [["1", ["1", "2"]]], [["1"]])),
        *(
            (LATE, change)
            for change in ({"terms": [["1", ["1"]]] * 2}, {"denominator": []}, {"denominator": ["0", "1"]})
        ),
        *((LATE, {"feedback": back}) for back in ([], [["0", ["1"]]], [["2", ["1", "1"]]])),
        *(
            (ROD, change)
            for change in ({"E": "0"}, {"rho": "-1"}, {"L": "0"}, {"A": "0"}, {"cells": 0}, {"kind": "rod"})
        ),
    ],
)
def test_what_is_no_plant_is_refused(system, change):
    read_system(system)
    with pytest.raises(NotShown):
        read_system(system | change)


# Dead time

BACK = Delayed(
    terms=((F(1), poly(2)), (F(3), poly(1, 5))),
    d=poly(4, 1, 6, 2),
    back=((F(1), poly(3, 1)), (F(2), poly("1/2", "1/3", 1))),
)


def chi(s, g=0):
    """Over the leading coefficient."""
    plain = 2 * s**3 + 6 * s**2 + s + 4 + (s + 3) * cmath.exp(-s) + (s**2 + s / 3 + 1 / 2) * cmath.exp(-2 * s)
    return (plain + g * (2 * cmath.exp(-s) + (5 * s + 1) * cmath.exp(-3 * s))) / 2


def test_the_equation_of_a_late_loop_is_enclosed():
    assert BACK.at_zero == fmpq(15, 2)
    loop = BACK.closed(F(3))
    assert loop.at_zero == fmpq(27, 2) + 3
    assert BACK.closed(F(0)).back == BACK.back
    again = Delayed(terms=((F(0), poly(2)), (F(1), poly(-1, "-1/3"))), d=BACK.d, back=BACK.back[:1]).closed(F(3))
    assert (again.d, again.back) == (poly(10, 1, 6, 2), ())
    with working_precision(96):
        for a, b in ((F(1), F(9, 8)), (F(0), F(1, 8))):
            ends = [acb(chi(1j * omega, 3)) for omega in (float(a), float(a + b) / 2, float(b))]
            turned, closer = loop.turn(a, b), loop.closer(a, b)
            for omega, end in zip((a, (a + b) / 2, b), ends, strict=True):
                power = acb(0, 1) ** 3 if not a else acb(0, ball(omega)) ** 3
                assert abs(turned * power - end).contains(arb(0)) or turned.overlaps(end / power)
                assert closer.overlaps(end / acb(0, 1) ** 3)
        far = loop.turn(None, F(20))
        for omega in (20.0, 21.7, 1000.0):
            assert far.overlaps(acb(chi(1j * omega, 3)) / acb(0, omega) ** 3)
        resting = Delayed(terms=(), d=poly(1, 2, 1), back=((F(1, 2), poly(-1, 3)),))
        turned = resting.turn(F(0), F(1, 100))
        for omega in (1e-9, 5e-3, 1e-2):
            s = 1j * omega
            chi_s = (s * s + 2 * s + 1 + (3 * s - 1) * cmath.exp(-s / 2)) / s
            assert turned.overlaps(acb(chi_s) * acb(0, -1) + acb(arb(0, 1e-7), arb(0, 1e-7)))


@pytest.mark.parametrize(
    ("n", "d", "back", "lower", "case"),
    [
        ((1,), (1, 1), None, 0, "stable"),
        ((1,), (-1, 1), None, 0, None),
        ((1,), (0, 1), None, 0, "critical"),
        ((-1,), (0, 1), None, 0, None),
        ((1,), (0, 0, 1), None, 0, None),
        ((1,), (1, 0, 1), None, 0, None),
        ((1,), (0, 1, 0, 1), None, 0, None),
        ((1,), (0, -1, 1), None, 0, None),
        ((-1,), (0, -1, 1), None, 0, None),
        ((1,), (0, 1), (1, 1), 0, "stable"),  # s + exp(-s)
        ((1,), (0, 1), (1, 2), 0, None),  # s + 2 exp(-s)
        ((1,), (0, 1), None, 1, "stable"),
        ((1,), (0, 1), None, 2, None),
        ((1,), (1, 1), (1, -1), 0, "critical"),  # s + 1 - exp(-s), of the slope 2 at 0
        ((-1,), (1, 1), (1, -1), 0, None),
        ((1,), (-1, 1), (F(1, 2), 1), 0, "critical"),  # s - 1 + exp(-s/2), of the slope 1/2
        ((1,), (-1, 1), (2, 1), 0, None),
        ((-1,), (-1, 1), (2, 1), 0, None),
    ],
)
def test_poles_beside_dead_time_after_the_shift(n, d, back, lower, case):
    late = () if back is None else ((F(back[0]), poly(back[1])),)
    loop = Delayed(terms=((F(1), poly(*n)),), d=poly(*d), back=late)
    with assert_accepted_if(case is not None):
        found = shifted(loop, F(lower))
        assert (found.case, found.plant, found.feedthrough) == (case, None, 0)


# Theorems

POINT = (F(3, 5), F(4, 5))  # z = (3 + 4 i)/5
TOP, BOTTOM = poly("1/3", 2, "1/5"), poly("1/7", "-1/2", 1)


def question(theorem, one, given=None, *, direct=0, **more):
    document = SimpleNamespace(
        **({"multiplier": given or {}, "rate": None, "hypotheses": {}, "proof": {}, "theorem": theorem} | more)
    )
    system = rational([[0]], [1], [1], direct, discrete=True)
    return Question(theorem=theorem, system=system, claim=Claim.of(one), document=document)


TAPS = [[1, "1/4"], [-2, "1/3"]]


@pytest.mark.parametrize(
    ("theorem", "given", "odd", "formula"),
    [
        ("circle", {}, False, lambda z, H: H + 1 / 2),
        ("zames-falb", {"taps": TAPS}, False, lambda z, H: (1 - z**-1 / 4 - z**2 / 3) * (H + 1 / 2)),
        ("tsypkin", {"q": "2/3"}, False, lambda z, H: (1 + 2 / 3 * (1 - z**-1)) * H + 1 / 2),
        ("tsypkin-odd", {"q": "2/3"}, True, lambda z, H: (1 + 2 / 3 * (1 + z**-1)) * H + 1 / 2),
        (
            "jury-lee",
            {"q": "2/3"},
            False,
            lambda z, H: (1 + 2 / 3 * (z - 1)) * H + 1 / 2 - 2 / 3 * abs((z - 1) * H) ** 2,
        ),
    ],
)
def test_the_inequality_on_the_circle_is_that_of_complex_numbers(theorem, given, odd, formula):
    one = replace(PLAIN, upper=F(2), slope=(F(0), F(2)), odd=odd)
    n, d, z = Laurent(TOP), Laurent(BOTTOM), complex(*map(float, POINT))
    products = n * d.conjugate(), d * d.conjugate(), n * n.conjugate()
    found = theorems.on_products(question(theorem, one, given), F(1, 5), products)
    H = value(TOP, z) / value(BOTTOM, z)
    assert value(found, z.real).real == pytest.approx(abs(value(BOTTOM, z)) ** 2 * formula(z, H).real)


def test_the_inequality_of_forms_of_samples_is_that_of_complex_numbers():
    rows = [["1/5"], ["1/50", "1/4"], ["1/40", "1/30", "1/3"], ["1/60", "-1/70", "1/80", "1/6"]]
    one = replace(PLAIN, upper=F(2), slope=(F(0), F(2)))
    asked = question("order-cone", one, {"taps": TAPS, "window": rows, "odd": False})
    block = Shifted(n=((F(0), TOP),), d=BOTTOM, discrete=True, plant=None, case="stable")
    z = complex(*map(float, POINT))
    G, size = 1 + 2 * value(TOP, z) / value(BOTTOM, z), abs(value(BOTTOM, z)) ** 2
    W = [1, z, -G, -z * G]
    form = sum(
        float(F(rows[max(i, j)][min(i, j)])) * (W[i].conjugate() * W[j] if i else W[j] * 1)
        for i, j in product(range(4), repeat=2)
    )
    wanted = ((1 - z**-1 / 4 - z**2 / 3) * G - form).real * size
    assert value(theorems._window(asked, block), z.real).real == pytest.approx(wanted)
    for change, class_ in (({"odd": True}, one), ({}, FINITE), ({"window": [["-1/5"], ["0", "1"]]}, one)):
        with pytest.raises(NotShown):
            theorems._window(question("order-cone", class_, asked.document.multiplier | change), block)


STEEP = replace(PLAIN, slope=(F(0), F(2)))
FALLING = replace(PLAIN, slope=(F(-1), F(1)))
ANY = replace(PLAIN, slope=None)


@pytest.mark.parametrize(
    ("theorem", "one", "direct", "q", "holds"),
    [
        ("tsypkin", PLAIN, 0, 1, True),
        ("tsypkin", PLAIN, 0, -1, False),
        ("tsypkin", STEEP, 0, 1, True),
        ("tsypkin", STEEP, -1, 1, False),
        ("tsypkin", PLAIN, -1, 1, True),
        ("tsypkin", FALLING, 0, 1, False),
        ("tsypkin", ANY, 0, 1, False),
        ("tsypkin-odd", PLAIN, 0, 1, False),
        ("tsypkin-odd", replace(PLAIN, odd=True), 0, 1, True),
        ("jury-lee", PLAIN, 0, 1, True),
        ("jury-lee", PLAIN, 0, -1, False),
        ("jury-lee", FALLING, 0, 1, True),
        ("jury-lee", FALLING, 1, 1, False),
        ("jury-lee", PLAIN, 1, 1, True),
        ("jury-lee", STEEP, 0, 1, False),
        ("jury-lee", replace(FINITE, slope=(F(0), "finite")), 0, 0, True),
        ("jury-lee", replace(FINITE, slope=(F(0), "finite")), 0, 1, False),
    ],
)
def test_which_slopes_the_criteria_of_samples_need(theorem, one, direct, q, holds):
    products = (Laurent(ONE),) * 3
    with assert_accepted_if(holds):
        theorems.on_products(question(theorem, one, {"q": str(q)}), F(direct), products)


IN_TIME = {
    False: ("circle", "popov", "off-axis-circle", "park", "zames-falb", "homogeneous-lyapunov"),
    True: ("circle", "zames-falb", "order-cone", "tsypkin", "tsypkin-odd", "jury-lee", "homogeneous-lyapunov"),
}


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("theorem", sorted({*IN_TIME[False], *IN_TIME[True], "hurwitz"}))
def test_which_theorems_are_for_a_time_and_a_class(theorem, discrete):
    system, late = rational([[0]], [1], [1], discrete=discrete), Delayed(terms=((F(1), ONE),), d=poly(1, 1))
    known = theorem in IN_TIME[discrete]
    asked = Question(theorem=theorem, system=system, claim=Claim.of(PLAIN), document=None)
    with assert_accepted_if(known):
        theorems._require_scope(asked)
    with assert_accepted_if(known and theorem in ("circle", "homogeneous-lyapunov")):
        theorems._require_scope(replace(asked, claim=Claim.of(replace(PLAIN, time_varying=True))))
    with assert_accepted_if(known and theorem in ("circle", "popov")):
        theorems._require_scope(replace(asked, claim=Claim.of(FREE)))
    if not discrete:
        with assert_accepted_if(known and theorem != "off-axis-circle"):
            theorems._require_scope(replace(asked, system=late))
        with pytest.raises(NotShown):
            theorems._require_scope(replace(asked, system=late, claim=Claim.of(FREE)))


@pytest.mark.parametrize(
    ("theorem", "changes", "rate", "holds"),
    [
        ("circle", {}, None, True),
        ("circle", {}, F(1), True),
        ("zames-falb", {}, None, True),
        ("zames-falb", {}, F(1), False),
        ("order-cone", {}, None, False),
        ("circle", {"rough": True}, None, False),
        ("circle", {"time_varying": True}, None, True),
    ],
)
def test_which_theorems_have_a_critical_case(theorem, changes, rate, holds):
    asked = question(theorem, replace(PLAIN, **changes), rate=rate)
    theorems.require_case(asked, "stable")
    with assert_accepted_if(holds):
        theorems.require_case(asked, "critical")


def test_what_follows_of_a_pole_at_0_is_less():
    late = Delayed(terms=((F(1), ONE),), d=poly(1, 1))
    asked = question("circle", PLAIN)
    assert theorems.sentence(asked, "critical") == EQUILIBRIA
    assert theorems.sentence(replace(asked, system=late), "critical") == EQUILIBRIA
    assert theorems.sentence(replace(asked, system=late), "stable") == DELAYED
    assert theorems.sentence(question("circle", replace(PLAIN, time_varying=True)), "critical") == BOUNDED
    assert theorems.sentence(asked, "stable") == theorems.claims.ATTRACTS


def test_slopes_bound_the_sector_of_the_theorems_on_slopes():
    steep = replace(PLAIN, lower=F(-1), upper=F(3), slope=(F(-1), F(2)))
    system = rational([[0]], [1], [1])
    for theorem in ("park", "zames-falb", "off-axis-circle"):
        found = theorems.posed(SimpleNamespace(theorem=theorem), system, steep)
        assert (found.claim.lower, found.claim.width) == (-1, 3)
        with pytest.raises(NotShown, match="slope bounds"):
            theorems.posed(SimpleNamespace(theorem=theorem), system, replace(steep, slope=None))
    assert theorems.posed(SimpleNamespace(theorem="popov"), system, steep).claim.width == 4
    with pytest.raises(NotShown, match="well posed"):
        theorems.posed(SimpleNamespace(theorem="popov"), rational([[0]], [1], [1], -1), steep)


@pytest.mark.parametrize(
    ("one", "direct", "theta", "plant", "case", "need"),
    [
        (PLAIN, 0, -1, "plain", "stable", "positive"),
        (FINITE, 0, -1, "plain", "stable", "nonnegative"),
        (FREE, 0, 1, "plain", "stable", "decaying"),
        (FREE, 0, -1, "plain", "stable", None),
        (FREE, 0, 1, "hidden", "stable", None),
        (FREE, 1, 1, "hidden", "stable", "positive"),
        (PLAIN, 0, 1, None, "critical", "positive"),
        (PLAIN, 0, -1, None, "critical", None),
        (PLAIN, 0, -1, None, "stable", "positive"),
        (PLAIN, 0, -1, "plain", "critical", "positive"),
    ],
)
def test_what_popovs_inequality_has_to_be(one, direct, theta, plant, case, need):
    hidden = {"plain": ONE, "hidden": poly(1, 1)}.get(plant)
    block = Shifted(n=(), d=ONE, discrete=False, plant=hidden and SimpleNamespace(hidden=hidden), case=case)
    with assert_accepted_if(need is not None):
        assert theorems._popov(question("popov", one, direct=direct), block, F(theta)) == need


@pytest.mark.parametrize("tau", [0, 2])
def test_parks_multiplier_grows_with_the_frequency(tau):
    found = theorems.multiplier_of(question("park", PLAIN, {"theta": "3", "tau": str(tau)}))
    (term,) = found.terms.values()  # 1 + tau x
    assert (term.e, term.o, found.theta, found.growth) == (poly(1, tau), poly(), 3, int(tau > 0))


def test_multipliers_of_other_theorems_are_none():
    assert theorems.multiplier_of(question("popov", PLAIN, {"theta": "3"})).theta == 3
    assert theorems.multiplier_of(question("circle", PLAIN)) == Multiplier()
    kernel = [{"coefficient": "1/4", "rate": "4", "order": 1, "side": "causal"}]
    for theta, direct, rate, holds in ((0, 1, 1, True), (1, 0, 1, True), (1, 1, 1, False), (1, 1, None, True)):
        given = {"theta": f"{theta}/8", "kernels": kernel}
        with assert_accepted_if(holds):
            theorems.multiplier_of(question("zames-falb", PLAIN, given, direct=direct, rate=rate and F(rate)))
    with pytest.raises(NotShown, match="no multiplier"):
        theorems.multiplier_of(question("tsypkin", PLAIN))


def test_the_mirrored_plant_is_its_negative():
    found = transfer("2 3 5", "4 1 7")
    turned = theorems._mirrored(found)
    assert turned.polynomials == (-found.polynomials[0], found.polynomials[1])
    assert (turned.states.c, turned.states.d) == (tuple(-v for v in found.states.c), -found.states.d)
    assert (turned.states.A, turned.states.b) == (found.states.A, found.states.b)
    assert theorems._mirrored(BACK) == replace(BACK, terms=((F(1), poly(-2)), (F(3), poly(-1, -5))))


def test_the_direct_term_after_the_shift():
    asked = question("circle", replace(PLAIN, lower=F(-1, 2)), direct="2/3")
    assert (asked.plain_direct, asked.direct) == (F(2, 3), 1)
    assert replace(asked, system=BACK).direct == 0


# What is written


@pytest.mark.parametrize(
    ("written", "limits", "variable", "method", "holds"),
    [
        (["2", "-1", "3"], ["4", "6"], "omega^2", "polynomial", True),
        (["2", "-1", "3"], ["2", "3"], "omega^2", "polynomial", True),
        (["2", "-1", "3"], ["2", "2"], "omega^2", "polynomial", False),
        (["2", "-1", "3"], ["3", "3"], "omega^2", "polynomial", False),
        (["2", "-1", "3"], ["-1", "-3/2"], "omega^2", "polynomial", False),
        (["2", "-1", "3"], ["2", "3", "3"], "omega^2", "polynomial", False),
        (["2", "-1", "3"], ["2", "3"], "omega", "polynomial", False),
        (["2", "-1", "3"], ["2", "3"], "omega^2", "cover", False),
        (["-2", "1", "-3"], ["2", "3"], "omega^2", "polynomial", False),
        (["2", "-1", "4"], ["2", "4"], "omega^2", "polynomial", False),
        (["1", "-1", "3"], ["1", "3"], "omega^2", "polynomial", False),
        (["0", "2", "-1", "3"], ["0", "3"], "omega^2", "polynomial", True),
        (["10", "-3", "14", "3"], ["10", "3"], "omega^2", "polynomial", True),  # times 5 + x, which is given
    ],
)
def test_the_polynomial_that_is_shown_is_the_own_one(written, limits, variable, method, holds):
    proof = {"method": method, "variable": variable, "coefficients": written, "limits": limits}
    block = Shifted(n=(), d=ONE, discrete=False, plant=None, case="stable")
    with assert_accepted_if(holds):
        require_written(question("circle", PLAIN, proof=proof), poly(2, -1, 3), block, (poly(5, 1),))


def test_an_inequality_is_decided_whatever_is_shown():
    proof = {"method": "polynomial", "variable": "omega^2", "coefficients": ["1", "-2", "1"], "limits": ["1", "1"]}
    block = Shifted(n=(), d=ONE, discrete=False, plant=None, case="stable")
    asked = question("circle", PLAIN, proof=proof)
    require_polynomial(asked, block, (poly(1, -2, 1), 2), "nonnegative")
    with pytest.raises(NotShown, match="every frequency"):
        require_polynomial(asked, block, (poly(1, -2, 1), 2), "positive")


@pytest.mark.parametrize(
    ("entry", "holds"),
    [
        ({"delay": "2"}, True),
        ({"delay": "0"}, False),
        ({"rate": "1", "order": 2, "side": "causal"}, True),
        ({"rate": "1", "order": 2, "side": "anticausal"}, True),
        ({"rate": "1", "order": 2, "side": "both"}, False),
        ({"rate": "1", "order": 0, "side": "causal"}, False),
        ({"rate": "1", "order": 10**6, "side": "causal"}, False),
    ],
)
def test_which_kernels_there_are(entry, holds):
    with assert_accepted_if(holds):
        theta, ((c, kernel),) = read_kernels({"theta": "3", "kernels": [{"coefficient": "1/2", **entry}]})
        sides = {"causal": 1, "anticausal": -1}
        assert kernel == (F(2) if "delay" in entry else (F(1), 2, sides[entry["side"]]))
        assert (theta, c) == (3, F(1, 2))


@pytest.mark.parametrize(
    ("taps", "holds"),
    [
        ([[1, "1/2"], [-1, "1/3"]], True),
        ([[0, "1/2"]], False),
        ([[1, "1/2"], [1, "1/3"]], False),
        ([[1, "1/2", "1"]], False),
        ([[10_001, "1/2"]], False),
    ],
)
def test_which_taps_there_are(taps, holds):
    with assert_accepted_if(holds):
        assert read_taps({"taps": taps}) == {1: F(1, 2), -1: F(1, 3)}


def test_for_every_finite_bound_at_once_a_multiplier_is_smaller():
    for share, holds in ((F(99, 200), True), (F(1, 2), False)):
        with assert_accepted_if(holds):
            require_legal([share, share], Claim.of(FINITE), strict=False)
    for c, odd, holds in ((-1, True, True), (-1, False, False), (1, False, True)):
        with assert_accepted_if(holds):
            require_legal([F(c, 2)], Claim.of(replace(PLAIN, odd=odd)), strict=False)


# Rates


@pytest.mark.parametrize("discrete", [False, True])
def test_the_loop_of_a_rate_has_the_response_of_moved_frequencies(discrete):
    # H(s - a), or H(r z), at s = 3 for a = r = 1/2
    time, s = {"time": "discrete" if discrete else "continuous"}, fmpq(3)
    moved = s / 2 if discrete else s - fmpq(1, 2)
    n, d = ["2", "3", "5"], ["4", "1", "7"]
    found = pace._system({"kind": "transfer", "numerator": n, "denominator": d, **time}, F(1, 2))
    sides = [
        fmpq_poly([fmpq(*map(int, F(v).as_integer_ratio())) for v in reversed(found[k])])
        for k in ("numerator", "denominator")
    ]
    assert sides[0](s) / sides[1](s) == (2 * moved**2 + 3 * moved + 5) / (4 * moved**2 + moved + 7)
    rows = {"A": [["1", "2"], ["1/3", "-4"]], "B": [["1"], ["1/2"]], "C": [["3", "-1"]], "D": [["2/3"]]}
    own = [fmpq_mat([[to_fmpq(F(v)) for v in row] for row in rows[name]]) for name in "ABCD"]
    for kind in ("multivariable", "state-space"):
        names = {"B": "B"} if kind == "multivariable" else {"B": "b"}
        given = rows | ({} if kind == "multivariable" else {"b": ["1", "1/2"]})
        turned = pace._system({"kind": kind, **given, **time}, F(1, 2))
        B = turned[names["B"]]
        B = B if kind == "multivariable" else [[v] for v in B]
        A = fmpq_mat([[to_fmpq(F(v)) for v in row] for row in turned["A"]])
        sides = A, fmpq_mat([[to_fmpq(F(v)) for v in row] for row in B]), own[2], own[3]
        assert at(sides, s) == at(own, moved)
    with pytest.raises(NotShown, match="rates are not shown"):
        pace._system({"kind": "delay", **time}, F(1, 2))
