# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # When criteria fail
#
# Slope, oddness, time-invariance: the small print of every criterion. This notebook takes the words away one by one
# and shows the loop that breaks. The sign is $\sigma = H\mu$, $\mu = -\phi(\sigma)$ throughout, and each answer
# has two sides: *proved* up to here, *refuted* from there on by a named nonlinearity, and in between nothing was shown.
#
# Two kinds of statement appear. **Certified** ones come from exact arithmetic, and a checker that does not trust the
# search has accepted them. Everything we draw is a floating-point trajectory, **observed**: good for seeing, no proof.

# %% tags=["hide-input"]
from fractions import Fraction
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from scipy import signal
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from lure import Cubic, PiecewiseLinear, Saturation, as_plant
from lure.analysis import check, max_sector, max_slope, steady_response
from lure.analysis.certificates.checker import Refuted
from lure.analysis.describing import describing_hint
from lure.analysis.plots import plot_largest, plot_nonlinearity
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    finish_axes,
)
from lure.files.builtin import builtin_loop


def say(*answers):
    """Print sentences, a line between them."""
    print(*answers, sep="\n\n")


def companion(block):
    """Matrices of ``x' = A x + b mu``, ``sigma = c x``, for a strictly proper
    block."""
    low, high = (
        [float(x) for x in reversed(p)] for p in (block.denominator, block.numerator)
    )
    n = len(low) - 1
    A = np.eye(n, k=1)
    A[-1] = [-a / low[-1] for a in low[:n]]
    return A, np.eye(n)[-1], np.array(high + [0.0] * (n - len(high))) / low[-1]


def motion(block, nonlinearity, state, until):
    """Times, ``sigma`` and the last state of the solution under a nonlinearity, in
    floating point."""
    A, b, c = companion(block)
    times = np.linspace(0, until, 4000)
    steps = {"rtol": 1e-10, "atol": 1e-11, "max_step": 0.2}

    def rate(_, x):
        return A @ x - b * nonlinearity(c @ x)

    run = solve_ivp(rate, (0, until), state, "DOP853", times, **steps)
    return times, c @ run.y, run.y[:, -1]


def nonlinearity_entry(witness):
    """The nonlinearity of a periodic orbit."""
    data = witness.data
    slopes = {side: Fraction(data[side]) for side in ("left_slope", "right_slope")}
    return PiecewiseLinear(
        points=[tuple(map(Fraction, point)) for point in data["points"]], **slopes
    )


def law_and_orbit(found, block, gains, periods=8):
    """The nonlinearity in its sector, and the orbit beside solutions of linear
    gains from the same state."""
    nonlinearity, data = nonlinearity_entry(found.witness), found.witness.data
    _, (left, right) = plt.subplots(
        1, 2, figsize=(8.6, 3.6), width_ratios=(1, 1.7), layout="constrained"
    )
    plot_nonlinearity(found.witness, ax=left)
    edge = np.array([0.0, max(left.get_xlim())])
    for sign in (1, -1):
        span = (sign * float(found.lower) * edge, sign * found.refuted_at * edge)
        left.fill_between(
            sign * edge,
            *span,
            color=GREY,
            alpha=0.2,
            lw=0,
            label="sector" if sign > 0 else None,
        )
    left.legend(loc="upper left", **LEGEND)
    until = periods * data["period"]
    for gain, colour in gains:
        times, sigma, _ = motion(
            block, lambda x, gain=gain: gain * x, data["state"], until
        )
        right.plot(times, sigma, color=colour, lw=0.9, label=f"φ = {gain:.4g} σ")
    times, sigma, _ = motion(block, nonlinearity, data["state"], until)
    right.plot(times, sigma, color=VERMILLION, lw=1.4, label="φ, on the left")
    right.set_xlabel("t [s]")
    right.set_ylabel("σ [unit of σ]")
    right.set_xlim(0, until)
    right.set_ylim(-1.2 * np.abs(sigma).max(), 1.4 * np.abs(sigma).max())
    finish_axes(right)
    right.legend(loc="upper right", ncols=3, **LEGEND)
    plt.show()


def gap_after_a_period(found, block):
    """How far the motion is from where it began, one period later, relative to the
    state."""
    data = found.witness.data
    *_, end = motion(
        block, nonlinearity_entry(found.witness), data["state"], data["period"]
    )
    return float(np.linalg.norm(end - data["state"]) / np.linalg.norm(data["state"]))


# %% [markdown]
# ## 1. Every linear gain is stable. Is the sector?
#
# In 1949 Aizerman guessed: if the loop is stable for every linear gain in $[a, b]$, then for every $\phi$ with $a
# \le \phi(\sigma)/\sigma \le b$ too. It would spare us this whole subject. Take the plant of Leonov, Bragin and
# Kuznetsov (2010), of order four, and let the sector begin at $1/100$:

# %%
aizerman = builtin_loop("leonov-bragin-kuznetsov").block
sector = max_sector(aizerman, lower=Fraction(1, 100), search="full")
print(f"H = {aizerman}")
print(
    f"linear gains: stable from 1/100 up to {sector.hurwitz.low:.6g}, by exact root "
    "counts\n"
)
say(sector)

# %%
law_and_orbit(sector, aizerman, [(0.1, GREEN), (sector.refuted_at, BLUE)])
print(
    "after one period the drawn motion is back to "
    f"{gap_after_a_period(sector, aizerman):.0e} of its state: observed"
)
again = check(sector.refutation.certificate)
say(f"the checker, on the certificate: {type(again).__name__}, {again.claim}")

# %% [markdown]
# A gain of 0.0995 that falls back to 0.01 where the amplitude is large keeps the loop swinging for ever, although the
# linear loop could take a gain ninety times as large. Popov proves the sector up to 0.0847. Of the sectors in
# between, up to 0.0995, nothing is known here.
#
# **Moral: a gain margin is a statement about straight lines.**
#
# ## 2. And if the slope is bounded as well?
#
# The nonlinearity above falls where it leaves the gain for the leak, and a negative slope is no stable gain. That
# slopes among the stable gains would suffice was Kalman's guess of 1957. Up to order three it is true (Barabanov
# 1988). The first example of the usual test set for such nonlinearities, of order three, from both sides:

# %%
third = builtin_loop("ct-1").block
third_sector, third_slope = max_sector(third), max_slope(third, search="linear")
print(f"H = {third}\n")
say(third_sector, third_slope)

# %% [markdown]
# With a bound on the slope the proof extends from 1.7636 to 4.5894, where a linear gain fails, by the criterion of
# Yakubovich and Park: for this plant the question of slope is closed. From order four on the guess is false. Fitts
# (1966) found the plant; every linear gain $k \ge 0$ is stable:

# %%
kalman = builtin_loop("kalman-fitts")
fitts = max_slope(kalman.block, odd=True)
print(f"H = {kalman.block}")
print("linear gains: stable up to", fitts.hurwitz.low, end="\n\n")
say(fitts)
law_and_orbit(fitts, kalman.block, [(0.75, GREEN), (fitts.refuted_at, BLUE)])
print(
    "after one period the drawn motion is back to "
    f"{gap_after_a_period(fitts, kalman.block):.0e}: observed"
)

# %% [markdown]
# A dead zone that saturates: nothing up to 0.37, slope 0.948 from there to 0.95, flat beyond. It is odd, monotone, and
# has a certified periodic solution of 8.8 s, which is not the mirror of itself; with half waves alone the least slope
# found is 1.4994. Proved for odd nonlinearities is the slope up to 0.6738. The `inf` above is about linear gains only.
#
# **Moral: from order four on, stability under every linear gain replaces no criterion.**
#
# ## 3. Is oddness a formality?
#
# Now in discrete time, example 6 of Carrasco, Heath, Zhang, Ahmad and Wang (2019): $\sigma_{t+1} = \tfrac12\sigma_t +
# 2\mu_t + \tfrac{23}{25}\mu_{t-1}$. Every linear gain up to $25/23$ is stable. Nonlinearities with the slope in
# $[0, k]$, odd or not:

# %%
sixth = builtin_loop("dt-6").block
odd, monotone = max_slope(sixth, odd=True), max_slope(sixth)
say(odd, monotone)
_, (left, right) = plt.subplots(
    1, 2, figsize=(8.6, 3.4), width_ratios=(1.5, 1), layout="constrained"
)
plot_largest([odd, monotone], ["odd φ", "monotone φ"], ax=left)
left.set_xlabel("upper end k of the slope [unit of μ / unit of σ]")
plot_nonlinearity(monotone.witness, ax=right)
plt.show()

# %% [markdown]
# For odd nonlinearities the proof stops within $10^{-8}$ of $25/23 = 1.08696$, where a linear gain fails. Without
# oddness it stops at $175/192 = 0.91146$, and no proof can go further: the nonlinearity on the right, of slope 0
# and $175/192$, has an orbit that visits the three marked points for ever. In fractions, by hand:

# %%
points = [tuple(map(Fraction, point)) for point in monotone.witness.data["points"]]
slopes = [(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(points)]


def phi(x):
    """The nonlinearity through the points, constant outside."""
    x = min(max(x, points[0][0]), points[-1][0])
    i = max(i for i, (left_end, _) in enumerate(points[:-1]) if left_end <= x)
    return points[i][1] + slopes[i] * (x - points[i][0])


sigma = [Fraction(monotone.witness.data["sigma"][0])]
mu = [Fraction(monotone.witness.data["u"][-1])]  # the sample before
for _ in range(4):
    mu.append(-phi(sigma[-1]))
    sigma.append(sigma[-1] / 2 + 2 * mu[-1] + Fraction(23, 25) * mu[-2])
print("slopes:", *slopes)
print("sigma: ", *sigma)
print("mu:    ", *mu[1:])

# %% [markdown]
# An exact orbit of period 3; no rounding is involved, so nobody's solver need be believed. A multiplier search that
# assumes oddness in silence certifies this loop up to 1.0869, and is wrong.
#
# **Moral: odd is a hypothesis. If your valve leaks on one side, you do not have it.**
#
# ## 4. May the nonlinearity drift?
#
# The plant $1/(s^2 + s + 1)$ is a damped spring. With $\theta = 1$ Popov's expression is
# $1/k + 1/|d(i\omega)|^2 > 0$, for every finite $k$: no time-invariant nonlinearity of any finite sector $[0, k]$
# destabilises it. The circle criterion stops at 3, because $\mathrm{Re}\,H$ is least, $-1/3$, at $\omega^2 = 2$. A
# weak criterion? It allows more nonlinearities, and with them even a Lyapunov function of degree 24 ends at 5.63:

# %%
spring = as_plant("1/(s^2 + s + 1)")
still, varying = (
    max_sector(spring),
    max_sector(spring, time_varying=True, search="full"),
)
say(still, varying)
pattern = varying.witness.data
times = [float(Fraction(x)) for x in pattern["times"]]
A, b, c = companion(spring)


def growth(k):
    """Largest modulus of an eigenvalue over one period: gain 0 for ``times[0]``,
    then ``k`` for ``times[1]``."""
    period = expm((A - k * np.outer(b, c)) * times[1]) @ expm(A * times[0])
    return float(np.abs(np.linalg.eigvals(period)).max())


print(f"\ngain 0 for {times[0]:.4f} s, then k for {times[1]:.4f} s, over and over:")
for k in (5.6, varying.refuted_at, 6.5, 8.0):
    print(f"k = {k:<12.9g}  growth per period {growth(k):.10f}")

# %% [markdown]
# The gain alternates between 0 and 5.71022, each of them stable on its own, and at the right moments: a child on a
# swing stands up and squats. At the certified gain the growth per period is barely above 1, as it should be at the
# end of a search for the smallest; at 8, in the same rhythm, each period multiplies the solution by 1.147.


# %%
def switched(k, rhythm, periods=10):
    """Times and ``sigma`` when the gain is 0, then ``k``, over and over."""
    state, t, sigma, clock = np.array([1.0, 0.0]), [0.0], [1.0], 0.0
    for duration, gain in zip(rhythm * periods, (0.0, k) * periods, strict=False):
        step = expm((A - gain * np.outer(b, c)) * duration / 40)
        for _ in range(40):
            state, clock = step @ state, clock + duration / 40
            t.append(clock)
            sigma.append(c @ state)
    return t, sigma


_, ax = plt.subplots(figsize=(8.6, 3.4), layout="constrained")
ax.plot(
    *switched(8.0, [0.0, sum(times)]), color=BLUE, lw=1.1, label="k = 8 all the time"
)
ax.plot(*switched(0.0, times), color=GREEN, lw=1.1, label="k = 0 all the time")
ax.plot(
    *switched(8.0, times), color=VERMILLION, lw=1.4, label="k = 0 and k = 8 in turn"
)
ax.set_xlabel("t [s]")
ax.set_ylabel("σ [unit of σ]")
finish_axes(ax)
ax.set_xlim(0, 10 * sum(times))
ax.set_ylim(-2.2, 2.6)
ax.legend(loc="upper left", ncols=3, **LEGEND)
plt.show()

# %% [markdown]
# Between 5.63 and 5.7102 nothing was shown of nonlinearities that depend on time; that does not touch Popov's result.
#
# **Moral: gain scheduling, wear and temperature make a nonlinearity time-varying. Popov's criterion and Zames and
# Falb's do not cover that.**
#
# ## 5. The describing function, wrong both ways
#
# Harmonic balance looks for a sinusoid that sustains itself, $1 + N(A)H(i\omega) = 0$. It is a good place to start
# looking, and we call it a hint. First the two loops above, which oscillate, certified:

# %%
missed = [
    describing_hint(block, nonlinearity_entry(found.witness))
    for block, found in ((aizerman, sector), (kalman.block, fitts))
]
say(*missed)

# %% [markdown]
# No balance for either: the linear loop is stable for every gain that $N$ can take. Now a false alarm, for the plant
#
# $$H(s) = -\frac{s + 1.6}{s^2 + 0.39\,s + 1}$$
#
# under a nonlinearity that does nothing up to 1, has slope 1 up to 2, and saturates there:

# %%
alarm = as_plant("-(s + 1.6)/(s^2 + 0.39*s + 1)")
stop = PiecewiseLinear(
    points=((-2, -1), (-1, 0), (1, 0), (2, 1)), left_slope=0, right_slope=0
)
hint = describing_hint(alarm, stop)
linear = max_sector(alarm)
say(hint, linear)
inner, outer = hint.balances
t, spiral, rest = motion(alarm, stop, [-25.0, 0.0], 150.0)  # sigma(0) = 40
seconds, response = signal.impulse(
    ([-1, -1.6], [1, 0.39, 1]), T=np.linspace(0, 100, 20001)
)
# what |mu| <= 1 can do to |sigma|, in the long run
most = np.trapezoid(np.abs(response), seconds)

_, (left, right) = plt.subplots(
    1, 2, figsize=(8.6, 3.8), width_ratios=(1.25, 1), layout="constrained"
)
hint.plot(ax=left)
right.plot(t, np.abs(spiral), color=VERMILLION, lw=1.2, label="|σ|, observed")
right.axhline(
    outer.amplitude,
    color=PURPLE,
    lw=1,
    ls="--",
    label="amplitude of the predicted oscillation",
)
right.set_xlabel("t [s]")
right.set_ylabel("|σ| [unit of σ]")
right.set_yscale("log")
right.set_ylim(1e-3, 60)
right.set_xlim(0, 80)
right.legend(loc="upper right", **LEGEND)
finish_axes(right)
plt.show()

# %% [markdown]
# The hint announces an attracting oscillation of amplitude 2.66. We see none, and here seeing comes close to knowing.
# The solution starts at $\sigma = 40$, where the nonlinearity, bounded by 1, can keep nothing up ($\int |h| = 6.06$),
# and spirals straight through the predicted amplitude into the dead zone, where the loop is linear and decays. In the
# plane that is the end of it: a closed orbit would go round 0, the only equilibrium, and the spiral would have to cross
# it. (In floating point; so the solution is observed, and `lure` does not call this loop proved. It proves the sector
# up to 0.39, and this nonlinearity reaches $\phi(2)/2 = 0.5$.)
#
# **Moral: a balance says where to look for an oscillation; that there is none proves nothing.**
#
# ## 6. Stable, and yet it remembers
#
# Without an input $\ddot x + \dot x/10 + x + x^3/25 = w$, Duffing's equation, comes to rest from everywhere: a spring
# that hardens, and some damping. Shaken by $w = \cos(\omega t)$ it answers in more than one way, and the start decides:

# %%
spring = as_plant("1/(s^2 + s/10 + 1)")
frequencies = [Fraction(w, 20) for w in (14, 18, 20, 22, 24, 26, 27, 30, 34)]
jumps = steady_response(
    spring, Cubic(cubic=Fraction(1, 25)), {"amplitude": 1, "omega": frequencies}
)
calm = steady_response(
    "1/(s^2 + s + 1)",
    Saturation(),
    {"amplitude": 3, "omega": [Fraction(w, 4) for w in range(1, 13)]},
)
say(jumps, calm)

_, (left, right) = plt.subplots(1, 2, figsize=(8.6, 3.8), layout="constrained")
jumps.plot(left)
calm.plot(right)
plt.show()

# %% [markdown]
# On the left two steady responses to one input are *certified* to exist, one more than three times the other; that
# they attract what is near is computed. On the right one attracts all others, certified, and its amplitude is enclosed:
# there the circle criterion holds for the *slopes*, which is what differences of two solutions see.
#
# **Moral: that a loop is stable says nothing of what it does when it is shaken. A proof by Popov's criterion or
# Zames and Falb's does not tell.**
#
# ## What to take home
#
# | you may assume | and may then use | forget it, and |
# |---|---|---|
# | linear | the gain margin | a saturation swings where any gain up to 9.9 is fine |
# | a sector, time-invariant | Popov | a gain that switches between 0 and 5.71022 makes the solution grow |
# | a sector, time-varying | the circle, homogeneous Lyapunov functions | no criterion here applies |
# | a slope | Park, Zames and Falb | Popov proves 1.7636 instead of 4.5894 |
# | odd as well | their odd multipliers | an orbit of period 3 at $175/192$, below $25/23$ |
#
# ## What this notebook claims

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
assert (jumps.verdict.name, calm.verdict.name) == ("REFUTED", "PROVED")
pair = [row for row in jumps.response if row.omega == 1.3 and row.attracts]
assert [f"{row.low:.4f} {row.high:.4f}" for row in pair] == [
    "1.5972 1.5972",
    "5.3193 5.3193",
]
assert all(row.alone and row.high < (1 + 1e-3) * row.low for row in calm.response)
LINEAR = 1000 / 101  # the stable gains of the first plant end here
assert abs(sector.hurwitz.low - LINEAR) < 1e-8
assert aizerman.order == kalman.block.order == 4
assert (int(sector.largest.low * 10**4), sector.criterion) == (847, "popov")
assert f"{sector.refuted_at:.4f}" == "0.0995"
assert LINEAR / sector.refuted_at > 90
assert isinstance(again, Refuted)
assert gap_after_a_period(sector, aizerman) < 1e-8
assert not sector.witness.slope_restricted
assert third.order == 3
assert int(third_sector.largest.low * 10**4) == 17636
assert (
    int(third_slope.largest.low * 10**4)
    == int(third_slope.refuted_at * 10**4)
    == 45894
)
assert third_slope.closed
assert (third_slope.criterion, third_slope.witness.kind) == ("park", "linear gain")
assert fitts.hurwitz.low == np.inf
assert (f"{fitts.refuted_at:.3f}", f"{fitts.witness.data['period']:.1f}") == (
    "0.948",
    "8.8",
)
assert int(fitts.largest.low * 10**4) == 6738
assert isinstance(check(fitts.refutation.certificate), Refuted)
assert gap_after_a_period(fitts, kalman.block) < 1e-7
assert 0 < Fraction(25, 23) - Fraction(odd.largest.low) < Fraction(1, 10**8)
assert odd.witness.kind == "linear gain"
assert 0 < Fraction(175, 192) - Fraction(monotone.largest.low) < Fraction(1, 10**7)
assert (f"{25 / 23:.5f}", f"{175 / 192:.5f}") == ("1.08696", "0.91146")
assert set(slopes) == {Fraction(0), Fraction(175, 192)}
assert sigma[3:] == sigma[:2]
assert mu[3:] == mu[:2]
assert len(set(sigma)) == 3
assert all(u == -phi(x) for x, u in zip(sigma, mu[1:], strict=False))
assert (still.largest.low, still.criterion) == (np.inf, "popov")
circle, forms = (
    {one.criterion: one.largest.low for one in varying.answers}[name]
    for name in ("circle", "homogeneous-lyapunov")
)
assert 0 < 3 - circle < 1e-8
assert 5.62 < forms == varying.largest.low < varying.refuted_at
assert f"{varying.refuted_at:.5f}" == "5.71022"
assert 1 < growth(varying.refuted_at) < 1 + 1e-6
assert round(growth(8.0), 3) == 1.147
assert isinstance(check(varying.refutation.certificate), Refuted)
assert not any(one.balances for one in missed)
assert (f"{outer.amplitude:.2f}", outer.stable_guess, f"{inner.gain:.2f}") == (
    "2.66",
    True,
    "0.39",
)
assert 39.9 < spiral[0] < 40.1
assert round(most, 2) == 6.06
assert np.hypot(*rest) < 1e-4  # deep inside the dead zone
assert 0 < Fraction(39, 100) - Fraction(linear.largest.low) < Fraction(1, 10**8)
