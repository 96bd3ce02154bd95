"""Kernels of one function of a plant with dead time, of neutral type too: certificates by hand, and what is refused."""

import cmath
import copy
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from certificate_format import FORMAT
from flint import acb, acb_mat, acb_series, arb, fmpq
from late_loops import LAG, NO, ONE, draft, late, sector, value
from tampering import assert_both_reject, edited

from lure.analysis.certificates.arithmetic import Form, S, real
from lure.analysis.certificates.balls import turning
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.pieces import Axis, Member, minors, on_piece, with_kernels
from lure.analysis.certificates.second import pieces
from lure.analysis.certificates.second.late_loops import Kernels
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.opinion import recheck

CLASS, KERNEL = ("laws", "channels", 0), ("multiplier", "kernels", 0)


def slope(low, high, **more):
    return sector(low, high, slope=[low, high], time_varying=False, **more)


def kernel(coefficient, rate, order=1, side="causal"):
    return {"coefficient": coefficient, "rate": rate, "order": order, "side": side}


def proof(*ends):
    return {"method": "pieces", "ends": [*map(str, ends)]}


# 1/(s^2 + s/5 + 4) + exp(-s)/8: beside the resonance Re H = -.92, so that the circle criterion ends at .798; linear
# gains end at 3.6545.  M = 1 - .9 (10/(10 + s))^2 is small below 4 and lags behind by little
ECHO = late([["0", "1"], ["-4", "-1/5"]], [["0"], ["1"]], [["1", "0"]], NO)
ECHO["late"] = [["1", [["1/2", "1/40"]], [["0", "0"], ["0", "0"]], [["0", "1/8"]], [["0", "0"], ["0", "0"]]]]
KERNELS = draft(
    ECHO,
    [slope("0", "3")],
    "late-zames-falb",
    proof(*(Fraction(i, 2) for i in range(1, 33))),
    {"lambda": ["1"], "theta": ["0"], "kernels": [kernel("9/10", "10", 2)]},
)
# 1/(s + 1 + s exp(-s)/2) is positive real; with a kernel F/2 = Re M (1 + 3 H)
BELOW = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, NO, NO, [["-1/2"]])),
    [slope("0", "3", odd=True)],
    "late-zames-falb",
    proof(*(Fraction(i, 2) for i in range(1, 33))),
    {"lambda": ["1"], "theta": ["1/100"], "kernels": [kernel("-1/4", "1", 1, "anticausal")]},
)
# exp(-s)/(s + 1), |H| <= 1: F/2 = Re (1 - H/2)^* M (1 + H/2) is about 1 - |H|^2/4 > 0
AROUND = draft(
    LAG,
    [slope("-1/2", "1/2")],
    "late-zames-falb",
    proof(1, 2, 4, 8),
    {"lambda": ["1"], "theta": ["0"], "kernels": [kernel("1/10", "2")]},
)
ALL = {"kernels": KERNELS, "below": BELOW, "around": AROUND}


@cache
def certificate(name):
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    assert recheck(found).accepted, recheck(found).reason
    attracts = "0 attracts every motion with inputs to the block and initial functions of finite energy"
    assert check(found).certificate["conclusion"] == attracts


@pytest.mark.parametrize(
    "change",
    [
        ("kernels", *CLASS, slope("0", "37/10")),  # a linear gain of 3.6545 puts a root on the axis
        ("kernels", *CLASS, sector("0", "3", time_varying=False)),  # a sector says nothing of slopes
        ("kernels", *CLASS, "slope", ["-1", "3"]),
        ("kernels", *CLASS, "slope", ["0", "4"]),
        ("kernels", *CLASS, "time_varying", True),
        ("kernels", *CLASS, "linear", True),
        ("kernels", *CLASS, "memory", "play"),
        ("kernels", *KERNEL, "coefficient", "11/10"),
        ("kernels", *KERNEL, "coefficient", "1/10"),  # F < 0 beside the resonance
        ("kernels", *KERNEL, "coefficient", "-9/10"),
        ("kernels", *KERNEL, "side", "anticausal"),
        ("kernels", *KERNEL, "side", "both"),
        ("kernels", *KERNEL, "rate", "0"),
        ("kernels", *KERNEL, "rate", "-10"),
        ("kernels", *KERNEL, "order", 0),
        ("kernels", *KERNEL, "order", 21),
        ("kernels", *KERNEL, {"coefficient": "9/10", "delay": "1/10"}),
        ("kernels", *KERNEL, 7),
        ("kernels", "multiplier", "kernels", "none"),
        ("kernels", "multiplier", "kernels", []),  # the circle criterion
        ("kernels", "multiplier", "lambda", ["1/2"]),
        ("kernels", "multiplier", "lambda", ["-1"]),
        ("kernels", "multiplier", "theta", ["1/10"]),  # sigma echoes phi, and has no derivative
        ("kernels", "multiplier", {"lambda": ["1"], "kernels": [kernel("9/10", "10", 2)]}),
        ("kernels", "proof", proof()),
        ("kernels", "theorem", "matrix-zames-falb"),
        ("kernels", "theorem", "piecewise-popov"),
        ("kernels", "system", "A", [["0", "1"], ["0", "-1/5"]]),  # a pole at 0
        ("kernels", "system", "A", [["0", "1"], ["-4", "1/5"]]),
        ("kernels", "system", "D", [["-1/3"]]),  # 1 + k D = 0
        ("kernels", "system", "late", 0, 3, [["0", "3/8"]]),  # 1 - 3 (3/8) < 0 far out
        ("below", "system", "late", 0, 4, [["-1"]]),  # not less than 1
        ("below", "system", "late", 0, 4, [["-5/4"]]),
        ("below", *CLASS, "odd", False),
        ("below", *CLASS, slope("-1", "3", odd=True)),  # the gain -1 puts a root at 0
        ("around", *CLASS, slope("-11/10", "1/2")),  # the gain -1 puts a root at 0
        ("around", *CLASS, slope("-1/2", "23/10")),  # and 2.2618 one on the axis
        ("around", "system", "A", NO),
        ("around", "multiplier", "kernels", [kernel("1/10", "2"), kernel("-1/10", "3")]),  # and not odd
        ("around", "multiplier", "kernels", [kernel("-1/10", "2"), kernel("1/10", "3")]),
        ("around", *KERNEL, {"coefficient": "1/10", "delay": "1/10"}),  # a shift, of which F > 0 is not looked at
    ],
    ids=lambda change: "-".join(map(str, change[:-1])),
)
def test_neither_checker_accepts_what_is_tampered_with(change):
    name, *path, value = change
    assert_both_reject(edited(certificate(name), *path, value=value))


def test_neither_checker_has_kernels_without_dead_time_at_a_rate_or_of_two_channels():
    found = certificate("around")
    plain = {name: value for name, value in found["system"].items() if name != "late"} | {"kind": "multivariable"}
    assert_both_reject(found | {"system": plain})
    assert_both_reject(found | {"rate": "1/100"})
    two = late([["-1", "0"], ["0", "-1"]], *([["1", "0"], ["0", "1"]],) * 2, [["0", "0"]] * 2, ("1", [["0", "0"]] * 2))
    wider = edited(found | {"system": two}, "laws", "channels", value=[slope("0", "1/2")] * 2)
    for key in ("lambda", "theta"):
        wider = edited(wider, "multiplier", key, value=found["multiplier"][key] * 2)
    assert_both_reject(wider)


@pytest.mark.parametrize(("beside", "holds"), [(100, True), (-25, True), (-30, False), (-100, False)])
def test_far_out_what_falls_with_the_frequency_counts_with_its_sign(beside, holds):
    # omega^4 (2 + cos omega) + b omega^2 from 5 on: over omega^4 it is at least 1 + b/25, or 1 where b > 0
    one, half = Fraction(1), Fraction(1, 2)
    F = Form({(0 * one, 4): (2 * one, 0 * one), (0 * one, 2): (one * beside, 0 * one)})
    F |= {(one, 4): (half, 0 * one), (-one, 4): (half, 0 * one)}
    assert turning(Form(F), Fraction(5) if beside != -25 else Fraction(51, 10), 4) is holds


def test_kernels_that_cancel_have_their_masses_still():
    found = edited(certificate("around"), *CLASS, "odd", value=True)
    pair = [kernel("1/3", "2"), kernel("-1/3", "2")]
    alone = edited(found, "multiplier", "kernels", value=pair)  # M = 1, masses 2/3
    assert recheck(complete_and_check(alone).certificate).accepted
    assert_both_reject(edited(found, "multiplier", "kernels", value=pair * 2))  # M = 1, masses 4/3


MIXED = [
    kernel("1/3", "2"),
    kernel("-1/5", "2", 3, "anticausal"),
    kernel("1/7", "1/2", 2),
    kernel("-1/9", "3", 1, "anticausal"),
]


def mixed(s):
    """``M`` with these, ``lambda`` being 1."""
    return 1 - (2 / (2 + s)) / 3 + (2 / (2 - s)) ** 3 / 5 - (0.5 / (0.5 + s)) ** 2 / 7 + 3 / (3 - s) / 9


def form_of(s, H):
    """``F`` of one channel with ``M`` for slopes in ``[-1/3, 5/3]`` and ``theta = 1/4``."""
    return 2 * ((1 - H / 3).conjugate() * mixed(s) * (1 + 5 / 3 * H) + s * H / 4).real


@pytest.mark.parametrize("omega", [0.0, 0.75, 5.0])
def test_the_form_with_kernels_is_that_of_complex_numbers(omega):
    one, s = Member("", Fraction(2), Fraction(1), Fraction(1, 4), Fraction(0), Fraction(-1, 3)), 1j * omega
    moved = with_kernels(one, MIXED, odd=True)
    over = value(moved.over, omega)
    assert moved.rise == max(n for _, n in moved.over) == 2 * (3 + 2 + 1)
    assert value(moved.acting, omega) / over == pytest.approx(mixed(s))
    N, d = Form({(Fraction(1, 2), 0): (Fraction(3), Fraction(0))}) + S, real(2) + S + S * S
    axis = Axis(d, [[N]], d, [[N]], [], 2, [moved], True, None).over(lambda form: form)
    (found,) = minors(axis, [(Fraction(0), Fraction(0))])
    below = value(d, omega)
    wanted = form_of(s, value(N, omega) / below) * abs(below) ** 2 * over.real
    assert value(found, omega).real == pytest.approx(wanted)


def test_the_form_with_kernels_of_the_second_checker_is_that_of_complex_numbers():
    kernels, omega, s, step = Kernels.read(MIXED), 0.75, 0.75j, 1e-6j
    one = pieces._Channel("", Fraction(2), Fraction(1), Fraction(1, 4), low=Fraction(-1, 3), kernels=kernels)
    loop = pieces._Loop([acb(2), acb(1), acb(1)], [[[acb(3), acb(2)]]], [[]], discrete=False, far=False)
    with working_precision(96):
        far = kernels.far(Fraction(1), arb(fmpq(4, 3)))
        near = kernels.near(Fraction(1), acb_series([acb(s), acb(0, 1)]))
        ((found,),) = pieces._series(loop, [one], [None], acb_series([acb(omega), acb(1)]))
    slope = (mixed(s + step) - mixed(s - step)) / 2e-6
    assert [complex(v.mid()) for v in (far, near[0], near[1])] == pytest.approx([mixed(s), mixed(s), slope])
    assert complex(found[0].mid()) == pytest.approx(form_of(s, (3 + 2 * s) / (2 + s + s * s)))


# Re (1 + l h)^* M (1 + u h), u = l + 2, is a polynomial in the size of h, and vanishes first in some directions
@pytest.mark.parametrize(("low", "shift"), [("0", "0"), ("-1/3", "0"), ("0", "1/3"), ("-1/6", "-1/6")])
@pytest.mark.parametrize("turn", [1, 2, 3, 4])
def test_far_out_the_form_with_kernels_is_sharp(low, shift, turn):
    lower, way, M = float(Fraction(low) + Fraction(shift)), cmath.exp(1j * turn), mixed(0.75j)
    u = lower + 2
    roots = np.roots([lower * u * M.real, ((u * M + lower * M.conjugate()) * way).real, M.real])
    ends = sorted(v.real for v in roots if v.real > 0 and abs(v.imag) < 1e-9)
    sides = {"low": Fraction(low), "shift": Fraction(shift), "kernels": Kernels.read(MIXED)}
    known = [pieces._Channel("", Fraction(2), Fraction(1), Fraction(0), **sides)]
    for size, holds in [(0.99 * ends[0], True), (1.01 * ends[0], False)] if ends else [(5, True)]:
        with working_precision(64):
            here = [(acb_mat([[acb(size * way)]]), acb_mat(1, 1))]
            assert pieces._above(here, known, [None], arb(fmpq(4, 3))) is holds


# H = s exp(-s)/(s + 1) at any phase, M = 1 - .9 (10/(10 + s)), [0, w]: Re M > w |M H| from 17.8719 on for w = .9, and
# from 10.9501 on for .8
@pytest.mark.parametrize(
    ("width", "start", "holds"),
    [("9/10", "176/10", False), ("9/10", "181/10", True), ("8/10", "108/10", False), ("8/10", "111/10", True)],
)
def test_far_out_kernels_count_with_their_phase_and_what_is_late_with_any(width, start, holds):
    class_, given = (Fraction(width), Fraction(1), Fraction(0)), [kernel("9/10", "10")]
    member, d, start = with_kernels(Member("", *class_, Fraction(0)), given, odd=False), real(1) + S, Fraction(start)
    N = Form({(Fraction(1), 1): (Fraction(0), Fraction(1))})
    axis = Axis(d, [[N]], d, [[N]], [], 1, [member], True, None).over(lambda form: form)
    assert (on_piece(axis, [(Fraction(0), Fraction(0))], start, None) == "") is holds
    known, none = [pieces._Channel("", *class_, kernels=Kernels.read(given))], [[[acb(0)]]]
    with working_precision(96):  # N/s = exp(-s) and d/s = 1 + u/i, u = 1/omega
        late = ((arb(1), [[[acb(1)]]], none),)
        loop = pieces._Loop([acb(1), acb(0, -1)], none, none, discrete=False, far=True, late=late)
        assert pieces._at_any_phase(loop, known, [None], 1 / start) is holds
