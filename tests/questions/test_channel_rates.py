"""Decay rates of several channels: multipliers that weigh, against formulas, members and changed certificates."""

import contextlib
import math
from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from tampering import assert_both_reject, edited, refused_again

from lure import NonlinearityClass, RationalPlant, Sector, SlopeBounds, methods
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.windows import _require_dominant, _slowed
from lure.analysis.certificates.windows import dominant
from lure.analysis.inequality.channels import ChannelInequality
from lure.analysis.inequality.coupled_forms import CoupledForms
from lure.analysis.questions.channel_hypotheses import groups_of
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_rates import weighed_searches
from lure.analysis.questions.decay import decay_rate
from lure.plants.multivariable import MultivariablePlant

F = Fraction
WIDTH = 28
MOMENTUM = methods.nesterov(1, 10)


def beside(*plants, turn=None):
    """One plant of several, side by side; ``turn`` mixes their states."""
    each = [
        [np.array(M, dtype=object) for M in (p.A, p.B, p.C, p.D)]
        for p in map(MultivariablePlant.of_one_channel, plants)
    ]
    sizes = [len(A) for A, *_ in each]
    n, m, at = sum(sizes), len(plants), 0
    A, B, C, D = (np.full(shape, F(0), dtype=object) for shape in ((n, n), (n, m), (m, n), (m, m)))
    for j, (one, size) in enumerate(zip(each, sizes, strict=True)):
        A[at : at + size, at : at + size], B[at : at + size, [j]], C[[j], at : at + size] = one[:3]
        at += size
    return MultivariablePlant(*(tuple(map(tuple, M)) for M in (A, B, C, D)), plants[0].dt)


def friction(d):
    return RationalPlant([1], [1, d, 0])


def ending(serves, low, high):
    """Where a condition ends, by halving."""
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if serves(middle) else (low, middle)
    return low


# G = 1/(s^2 + d s + 1) after the shift by 1, w = 28; with s - a: D = s^2 + (d - 2a) s + p, p = 1 - a d + a^2.  Slopes:
# theta a <= 1, and |D|^2 (1/w + Re (1 + s/a) G) is, times w, x^2 + (w (d/a - 3) - 2p + (d - 2a)^2) x + p^2 + w p
def popov_serves_slopes(d, a):
    p = 1 - a * d + a * a
    b = WIDTH * (d / a - 3) - 2 * p + (d - 2 * a) ** 2
    return b >= 0 or b * b < 4 * (p * p + WIDTH * p)


# a sector alone: 1 + w Re (1 + theta (s - a)) G - theta a w^2 |G|^2 > 0 for some theta >= 0, times |D|^2
def popov_serves_a_sector(d, a):
    p = 1 - a * d + a * a
    for theta in np.linspace(0, 4, 4001):
        b = -2 * p + (d - 2 * a) ** 2 - WIDTH + theta * WIDTH * (d - a)
        c = p * p + WIDTH * p - theta * WIDTH * a * (p + WIDTH)
        if c > 0 and (b >= 0 or b * b < 4 * c):
            return True
    return False


def best(plant, law, easy, hard):
    """What is accepted of the best rate that the first kind of multipliers is found to prove."""
    asked = channel_problem(plant, [law] * 2)
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry)}
    for rate, proposal in weighed_searches(asked)[0].farthest(easy, hard):
        with contextlib.suppress(Rejected):
            return complete_and_check({**draft, **proposal, "rate": str(rate)})
    return None


@pytest.fixture(scope="module")
def masses():
    """The largest rates that Popov's terms are found to prove of two masses with friction, with a certificate each."""
    plant = beside(friction(F(4, 5)), friction(1))
    return {
        name: best(plant, law, 0.02, 0.4) for name, law in (("slopes", SlopeBounds(1, 29)), ("sector", Sector(1, 29)))
    }


@pytest.mark.parametrize(("name", "serves"), [("slopes", popov_serves_slopes), ("sector", popov_serves_a_sector)])
def test_popovs_terms_reach_what_their_weights_allow(masses, name, serves):
    truth = ending(lambda a: serves(0.8, a), 1e-3, 0.4)  # that of d = 1 is larger
    rate = float(F(masses[name].certificate["rate"]))
    assert truth * (1 - 2e-3) < rate < truth
    assert recheck(dict(masses[name].certificate)).accepted


# 1/(s (s + 1)) with gains in [1, 2] beside 1/(s (s + 2)) with gains in [1, 3]: sectors have 1/3 by Popov's terms, and a
# class with slopes in these bounds is smaller, so that the same rate has to be found for it.
def test_slopes_within_a_sector_have_no_smaller_rate():
    asked = channel_problem(beside(friction(1), friction(2)), [Sector(1, 2), SlopeBounds(1, 3)])
    proposal = next(weighed_searches(asked)[0].proposals(F(13, 40)))
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry), **proposal}
    assert recheck(dict(complete_and_check({**draft, "rate": "13/40"}).certificate)).accepted


def test_popovs_terms_without_weights_would_prove_what_is_false(masses):
    # an odd phi with slopes in [1, 29] that looks alike in all sizes decays like exp(-0.3776 t): docs/theory/rates.md
    asked = channel_problem(beside(friction(F(4, 5))), [SlopeBounds(1, 29)])
    rate = F(39, 100)
    A, B, C, D = asked.plant.doubles()
    blind = CoupledForms(
        A + 0.39 * np.eye(2), B, C, D, np.ones(1), groups_of(asked), 1, [True], popov=True, discrete=False
    )
    (one,) = blind.proposals([F(28)], [F(1)])
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry)}
    draft |= {"theorem": "coupled-popov", "multiplier": one.multiplier, "proof": one.proof, "rate": str(rate)}
    with pytest.raises(Rejected, match="the inequality of P"):
        complete_and_check(draft)
    stated = {**masses["slopes"].certificate, **draft, "conclusion": "", "hypotheses": {}}
    assert refused_again(stated)


def changed(shown, *path, by):
    """The certificate with one number changed."""
    return edited(shown.certificate, *path, value=lambda text: str(by(F(text))))


def test_other_rates_terms_and_classes_are_rejected_by_both(masses):
    slopes, sector = masses["slopes"], masses["sector"]
    varying = edited(
        sector.certificate, "laws", "channels", value=lambda each: [one | {"time_varying": True} for one in each]
    )

    def sloped(lower, upper):
        """The same forms, said to be of the sector [1, 29], for slopes that lie in these bounds or do not."""
        law = {"sector": ["1", "29"], "slope": [lower, upper]}
        as_sectors = edited(
            slopes.certificate, "multiplier", "forms", value=lambda f: [one | {"kind": "sector"} for one in f]
        )
        return edited(as_sectors, "laws", "channels", value=lambda each: [one | law for one in each])

    assert recheck(complete_and_check(sloped("1", "29")).certificate).accepted
    for wrong in (
        changed(slopes, "rate", by=lambda v: v * F(101, 100)),
        changed(slopes, "multiplier", "theta", 0, by=lambda v: v * 3),
        changed(slopes, "multiplier", "theta", 0, by=lambda v: -v),
        {**slopes.certificate, "laws": sector.certificate["laws"]},  # the weights of slopes, for a sector
        sloped("1", "58"),
        sloped("1/2", "29"),
        varying,
    ):
        assert_both_reject(wrong)


@pytest.fixture(scope="module")
def pair():
    """Nesterov's method twice, by forms of two samples."""
    return best(beside(MOMENTUM, MOMENTUM), SlopeBounds(1, 10), 0.97, 0.69)


# published for one channel: .7518 (Van Scoy, Freeman, Lynch 2018)
def test_two_channels_side_by_side_have_the_rate_of_one(pair):
    assert pair.theorem == "coupled-windows"
    assert float(F(pair.certificate["rate"])) == pytest.approx(0.7518, abs=1e-4)
    assert recheck(dict(pair.certificate)).accepted


def test_the_sums_of_a_window_are_weighed(pair):
    (first, *_) = forms = pair.certificate["multiplier"]["forms"]
    assert len(forms) == 2
    assert_both_reject(changed(pair, "rate", by=lambda v: v - F(1, 1000)))
    samples = len(first["rows"])
    off = next((i, j) for i in range(samples) for j in range(samples) if i != j and F(first["rows"][i][j]) < 0)
    heavier = changed(pair, "multiplier", "forms", 0, "rows", off[0], off[1], by=lambda v: v * F(3, 2))
    assert_both_reject(heavier)
    bare = {key: value for key, value in pair.certificate.items() if key != "rate"}
    assert_both_reject(bare)


# one sample before another: with r = 1/2 a tap of r^-1 times its row at most, and r times its column
@pytest.mark.parametrize(("tap", "fine"), [("1/2", True), ("51/100", False)])
def test_the_last_tap_that_is_legal(tap, fine):
    Q, half = [[F(1), -F(tap)], [F(0), F(0)]], F(1, 2)
    for rows in (Q, [list(column) for column in zip(*Q, strict=True)]):
        with contextlib.nullcontext() if fine else pytest.raises(Rejected, match="doubly dominant"):
            dominant(rows, 1, summed=True, odd=False, rate=half)
        with contextlib.nullcontext() if fine else pytest.raises(NotShown, match="doubly dominant"):
            _require_dominant(_slowed(rows, 1, half), 1, over_time=True, odd=False, rate=half)


# s^2 + (4/5) s with s - 1/4, slopes from 1 up to 11/10: theta a/w is the weight of theta, 5/2 theta, and a kernel
# 2/(2 + s) counts 8/9 in its row and 8/7 in its column
@pytest.mark.parametrize(
    ("theta", "side", "mass", "fine"),
    [
        ("2/5", "causal", "0", True),
        ("401/1000", "causal", "0", False),
        ("-401/1000", "causal", "0", False),
        ("0", "causal", "7/8", True),
        ("0", "anticausal", "7/8", True),
        ("0", "causal", "88/100", False),
        ("0", "anticausal", "88/100", False),
        ("1/5", "anticausal", "9/16", True),  # 1 - 1/2 for the column, where anticausal kernels count 8/9
        ("1/5", "causal", "9/16", False),
    ],
)
def test_the_last_kernels_and_terms_that_are_legal(theta, side, mass, fine):
    asked = channel_problem(beside(friction(F(4, 5))), [SlopeBounds(1, F(11, 10))])
    kernel = {"channels": [1, 1], "coefficient": mass, "rate": "2", "order": 1, "side": side}
    given = {"gamma": [["1"]], "theta": [theta], "kernels": [kernel] if mass != "0" else []}
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry)}
    draft |= {"theorem": "matrix-zames-falb", "multiplier": given, "proof": {"method": "determinant"}, "rate": "1/4"}
    if fine:
        assert recheck(dict(complete_and_check(draft).certificate)).accepted
        return
    with pytest.raises(Rejected, match="less than the kernels"):
        complete_and_check(draft)
    lighter = complete_and_check(draft | {"multiplier": given | {"theta": ["0"], "kernels": []}})
    assert "outweigh gamma" in recheck({**lighter.certificate, "multiplier": given}).reason


@pytest.mark.slow
def test_kernels_of_several_channels_are_weighed():
    # with the gain 7 the slowest roots of (s + 1)^3 + 7 have the real part 7^(1/3)/2 - 1 = -0.04353
    lags = RationalPlant([1], [1, 3, 3, 1])
    asked = channel_problem(beside(lags, lags), [SlopeBounds(0, 7)] * 2)
    kernels, rate = weighed_searches(asked)[1], F(43, 1000)
    (proposal,) = kernels.proposals(rate)
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry), **proposal}
    shown = complete_and_check({**draft, "rate": str(rate)})
    assert shown.theorem == "matrix-zames-falb"
    assert recheck(dict(shown.certificate)).accepted
    assert kernels.serves(0.0435)
    assert not kernels.serves(0.0436)
    assert_both_reject(changed(shown, "rate", by=lambda v: F(44, 1000)))
    decayed = NonlinearityClass(sector=Sector(0, 7))  # kernels need slopes
    sector = channel_problem(beside(lags, lags), [decayed] * 2)
    assert_both_reject({**shown.certificate, "laws": dict(sector.class_entry)})


def alike(random, members):
    """Functions with ``phi(e sigma) = e phi(sigma)``, slopes 0 and 1/4 by steps of the logarithm: two a member."""
    slopes = random.integers(0, 2, (members, 2, 2, 4)) / 4  # channel, sign, piece of a period
    row, edges = np.arange(members), np.exp(np.arange(5) / 4 - 1)
    left = np.cumsum(slopes * np.diff(edges), axis=-1)
    before = left[..., -1] * math.exp(-1) / (1 - math.exp(-1))  # at the beginning of a period

    def phi(channel, sigma):
        y = np.log(np.abs(sigma) + 1e-300)
        turns = np.floor(y) + 1
        y = np.exp(y - turns)
        k, side = np.clip((np.log(y) * 4 + 4).astype(int), 0, 3), (sigma < 0).astype(int)
        value = before[row, channel, side] + np.where(k > 0, left[row, channel, side, k - 1], 0.0)
        return np.sign(sigma) * np.exp(turns) * (value + slopes[row, channel, side, k] * (y - edges[k]))

    return phi


# such members show their rate for as long as one likes
def test_random_members_decay_no_more_slowly_than_proved():
    random, loops, members, steps = np.random.default_rng(3), sampled(1, of=60), 1000, 300
    for _ in range(loops):
        A = random.normal(size=(3, 3))
        A, B, C = A * 0.8 / np.abs(np.linalg.eigvals(A)).max(), random.normal(size=(3, 2)), random.normal(size=(2, 3))
        A, B, C = (np.round(M, 2) for M in (A, B, C))
        exact = [tuple(tuple(F(str(v)) for v in row) for row in M) for M in (A, B, C, np.zeros((2, 2)))]
        found, phi = decay_rate(MultivariablePlant(*exact, 1), [SlopeBounds(0, F(1, 4))] * 2), alike(random, members)
        x, size = random.normal(size=(members, 3)), np.zeros((2, members))
        for t in range(steps):
            sigma = x @ C.T
            x = x @ A.T - np.stack([phi(0, sigma[:, 0]), phi(1, sigma[:, 1])], axis=1) @ B.T
            whole = np.floor(np.log(np.linalg.norm(x, axis=1) + 1e-300))
            x, size[1] = x * np.exp(-whole)[:, None], size[1] + whole
            if t == steps // 4:
                size[0] = size[1] + np.log(np.linalg.norm(x, axis=1))
        fallen = (size[1] + np.log(np.linalg.norm(x, axis=1)) - size[0]) / (steps - 1 - steps // 4)
        assert fallen.max() <= math.log(found.rate.high) + 6 / steps  # the number c


def test_rates_of_certificates_are_checked_again(pair, masses):
    for shown in (pair, *masses.values()):
        assert check(dict(shown.certificate)).claim == shown.claim


def test_widths_near_the_largest_double_square_to_no_infinity():
    # found by benchmarks/attacks.py (loop 9941 of "small discrete"): 2 a psi (w sigma - psi) with a w = 1, w = 7e301;
    # for an operator 2 a (w^2 sigma^2 - psi^2) = 2 w sigma^2 - 2 psi^2/w
    one, none = np.eye(1), np.zeros((1, 1))
    w = np.array([7e301])
    for operators, form in (((), [[0, 1], [1, -2 / 7e301]]), (((0,),), [[1.4e302, 0], [0, -2 / 7e301]])):
        loop = ChannelInequality(-one, one, none, none, np.zeros(1), (True,), True, False, operators)
        np.testing.assert_allclose(loop.form(1 / w, w), form)
