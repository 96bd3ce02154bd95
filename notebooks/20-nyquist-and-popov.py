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
# # Nyquist's plot and Popov's
#
# Two pictures of one curve, two theorems, and how much of either you can see. The loop is $\sigma = H\mu$, $\mu =
# -\phi(\sigma)$ throughout, and of $\phi$ only a sector $[0, k]$ is known: $0 \le \sigma\phi(\sigma) \le
# k\sigma^2$. What is called proved below was decided in exact arithmetic at every frequency. The pictures show it;
# they do not prove it, and at the end two of them mislead.

# %% tags=["hide-input"]
from importlib.util import find_spec
from math import inf, sqrt

import control
import matplotlib.pyplot as plt
import numpy as np

from lure import as_plant
from lure.analysis import max_sector, nyquist_response, popov_response
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    VERMILLION,
    finish_axes,
)


def side_by_side(left, right):
    """Two responses, drawn."""
    _, axes = plt.subplots(1, 2, figsize=(8.6, 3.9), layout="constrained")
    left.plot(ax=axes[0])
    right.plot(ax=axes[1])
    plt.show()


# %% [markdown]
# ## 1. A vertical line, and a line you may tilt
#
# **Nyquist's plot** is $\mathrm{Im}\,H$ over $\mathrm{Re}\,H$. For a stable $H$ the circle criterion asks that the
# curve stay to the right of the vertical line through $-1/k$. Then the loop is stable for every nonlinearity of the
# sector, even one that depends on time.
#
# **Popov's plot** is $\omega\,\mathrm{Im}\,H$ over $\mathrm{Re}\,H$, and its line through $-1/k$ may have any slope:
#
# $$\frac1k + \mathrm{Re}\,[(1 + i\omega\theta) H(i\omega)] > 0,$$
#
# which is
#
# $$\mathrm{Re}\,H > \theta\cdot\omega\,\mathrm{Im}\,H - \frac1k .$$
#
# Its slope is $1/\theta$: $\theta = 0$ is upright again, the circle criterion; larger $\theta$, in seconds, tilts it.
# The price of the freedom is that $\phi$ must not depend on time.
#
# Take $H = 1/(s^2 + s + 1)$ and $x = \omega^2$. By hand, $\mathrm{Re}\,H = (1 - x)/((1 - x)^2 + x)$, which is least at
# $x = 2$: there it is $-1/3$. The circle criterion stops at $k = 3$. With $\theta = 1$ the $x$ cancels,
# $\mathrm{Re}[(1 + i\omega)H] = 1/((1 - x)^2 + x)$ is positive, and Popov's criterion proves every finite $k$.

# %%
OSCILLATOR = "1/(s^2 + s + 1)"
circle, popov = (
    max_sector(OSCILLATOR, criterion=name) for name in ("circle", "popov")
)
print(circle)
print(popov)
tilted = popov_response(OSCILLATOR, k=10, theta=1)
print(tilted)
side_by_side(nyquist_response(OSCILLATOR), tilted)

# %% [markdown] explore="num=1&den=1,1,1&k=10&theta=1"
# The shaded part is forbidden. On the left the curve touches the line of $k = 3$. On the right $k = 10$, the line has
# slope 1, and there is room. In between each $\theta$ has a $k$ of its own; for $\theta = 1/2$ it is $6 +
# 4\sqrt3 = 12.93$.

# %%
ax = plt.subplots(figsize=(4.8, 3.4), layout="constrained")[1]
reach = {}
for theta, colour in ((0, VERMILLION), (0.5, PURPLE), (1, GREEN)):
    response = popov_response(OSCILLATOR, theta=theta)
    reach[theta] = response.k
    heights = np.array([-1.2, 0.3])
    words = f"k = {response.k:.4g}" if theta < 1 else "every finite k (drawn: k → ∞)"
    label = f"θ = {theta} s, {words}"
    ax.plot(
        theta * heights - 1 / response.k, heights, color=colour, lw=1.3, label=label
    )
x, y = response.values.real, response.omega * response.values.imag
ax.plot(x, y, color=BLUE, lw=1.3, label="H(iω), ω > 0")
ax.axhline(0, color=GREY, lw=0.6)
ax.set(
    xlabel="Re H(iω)",
    ylabel="ω Im H(iω) [rad/s]",
    xlim=(-0.8, 1.1),
    ylim=(-1.2, 0.3),
)
finish_axes(ax)
ax.legend(loc="lower right", fontsize="small")
plt.show()

# %% [markdown]
# ## 2. A disk
#
# If the sector starts above 0, at $k_1 > 0$, the half-plane closes to the disk with diameter $[-1/k_1, -1/k]$, and $H$
# may be unstable: then the curve must go round the disk, once counter-clockwise for each unstable pole, $\omega < 0$
# included. $4/((s - 1)(s/3 + 1))$ has one, and needs a gain above $1/4$. For nonlinearities in $[1/2, k]$:

# %%
UNSTABLE = "4/((s - 1)*(s/3 + 1))"
disk = nyquist_response(UNSTABLE, lower=0.5)
print(disk.found)
disk.plot(ax=plt.subplots(figsize=(4.8, 3.4), layout="constrained")[1])
plt.show()

# %% [markdown]
# ## 3. The critical case: a pole at 0
#
# $1/(s(s + 1)(s + 2))$. Routh: $s^3 + 3s^2 + 2s + k$ is stable for $0 < k < 6$.
#
# Near 0, $H \approx \varrho/s$ with the residue $\varrho = 1/2$, so $\mathrm{Im}\,H \approx -\varrho/\omega$ falls to
# $-\infty$ along the asymptote $\mathrm{Re}\,H = -3/4$: Nyquist's curve leaves the picture. Popov's does not, since
# $\omega\,\mathrm{Im}\,H$ stays finite. It starts at $(-3/4, -\varrho)$ and meets the axis at $-1/6$, where
# $\omega^2 = 2$; the tangent there has slope $2/3$, hence $\theta = 3/2$: every $k < 6$
# is proved, and 6 itself is not, since the inequality is strict.

# %%
MOTOR = "1/(s*(s + 1)*(s + 2))"
print(max_sector(MOTOR, criterion="circle"))
critical = max_sector(MOTOR, criterion="popov")
print(critical)
side_by_side(nyquist_response(MOTOR), popov_response(MOTOR, k=5.9, theta=1.5))

# %% [markdown] explore="num=1&den=1,3,2,0&k=5.9&theta=1.5"
# What a pole at 0 changes:
#
# - **The conclusion.** The gain 0 is not stable, yet $\phi = 0$ belongs to $[0, k]$: the integrator then stays
#   wherever it is. So "0 attracts every solution" is false for the class, and what is proved is convergence to the set
#   of equilibria, which is the point 0 if your nonlinearity vanishes at 0 alone. Even $1/s$, proved for every finite
#   $k$, gets no stronger conclusion.
# - **The residue** must be positive. With a negative one every small positive gain is unstable, although
#   $\mathrm{Re}\,H$ can be positive everywhere, as it is for $-1/(s(s + 1))$.
# - **The order.** With a double pole at 0 the criterion does not apply, whatever the picture shows.

# %%
print(max_sector("1/s"))
wrong_sign, double = max_sector("-1/(s*(s + 1))"), max_sector("(s + 1)/s^2")
print(f"-1/(s(s+1)): {wrong_sign.verdict}; {wrong_sign.reason}")
print(f"(s+1)/s^2: {double.verdict}; {double.reason}")

# %% [markdown] explore="num=1,0,0&den=1,1,1&k=6.4&theta=-1"
# ## 4. Negative theta
#
# Many texts ask for $\theta \ge 0$. For finite $k$ that is not needed ([note 6](notes/0006-negative-theta.md)), and
# it can cost most of the sector. $s^2/(s^2 + s + 1)$ is the oscillator of part 1 with $s$ and $1/s$ exchanged. The
# circle criterion stops at $k = 3$ again, positive $\theta$ makes it worse, and $\theta = -1$ gives
# $3 + 2\sqrt3 = 6.46$. The more negative $\theta$ is, the larger is $k$.

# %%
MIRRORED = "s^2/(s^2 + s + 1)"
leaning = {theta: popov_response(MIRRORED, theta=theta) for theta in (1, 0, -1, -10)}
for theta, response in leaning.items():
    print(f"theta = {theta:3} s: k = {response.k:.6g} ({response.answer.verdict})")
side_by_side(leaning[0], leaning[-1])

# %% [markdown] explore="num=1&den=1,3,2,0&k=6&theta=1.5"
# ## 5. Two pictures that lie
#
# The loop of part 3 with $k = 6$: the curve stays to the right of the line, at every frequency drawn. But $\phi =
# 6\sigma$ oscillates for ever, since $s^3 + 3s^2 + 2s + 6 = (s + 3)(s^2 + 2)$. Between two of the frequencies the curve
# touches the line.

# %%
touching = popov_response(MOTOR, k=6, theta=1.5)
print(touching)

# %% [markdown]
# Worse: a resonance narrower than the grid. $\frac{1}{s+1} - \frac{20\zeta s}{s^2 + 20\zeta s + 100}$ with $\zeta =
# 10^{-5}$. On three thousand frequencies from 0.01 to 1000 rad/s, as scripts do, the real part is positive:
# "stable for every $k$". By hand, at 10 rad/s the second term is $-1$ and the first has the real part $1/101$; so the
# circle criterion stops at $k = 101/100$, and with the gain 2 the loop has two poles on the right.

# %%
RINGING = as_plant("1/(s + 1) - 0.0002*s/(s^2 + 0.0002*s + 100)")
grid = np.geomspace(0.01, 1000, 3000)
coarse = nyquist_response(RINGING, omega=grid)
print(f"least real part on the grid: {coarse.values.real.min():.3g}")
refined = nyquist_response(RINGING)
print(refined.found)
popov_ringing = max_sector(RINGING, criterion="popov")
print(popov_ringing)
tf = control.tf([1], [1, 1]) - control.tf([2e-4, 0], [1, 2e-4, 100])
poles = control.feedback(2 * tf, 1).poles()
print("poles with the gain 2:", *(f"{pole:.7g}" for pole in poles), sep="\n  ")
_, axes = plt.subplots(1, 2, figsize=(8.6, 3.9), layout="constrained")
titles = ("3000 frequencies", "refined at the poles")
for ax, seen, words in zip(axes, (coarse, refined), titles, strict=True):
    ax.plot(seen.values.real, seen.values.imag, ".-", ms=3, lw=0.8, color=BLUE)
    label = f"-1/k, k = {refined.k:.4g}"
    ax.axvline(-1 / refined.k, color=VERMILLION, lw=1.3, label=label)
    ax.set(title=words, xlabel="Re H(iω)", ylabel="Im H(iω)", ylim=(-0.65, 0.45))
    finish_axes(ax)
    ax.legend(fontsize="small")
plt.show()

# %% [markdown]
# A better grid is no remedy: it only needs a narrower resonance. The criterion is decided by counting the real roots of
# a polynomial, exactly, and that has no grid to slip through.
#
# ## 6. Try it
#
# With a live kernel and ipywidgets there are sliders: find a line for $k = 5.9$.


# %%
def at(k=5.0, theta=1.5):
    """The loop of part 3 with a line of your choice, and what is known of it."""
    response = popov_response(MOTOR, k=k, theta=theta)
    response.plot(ax=plt.subplots(figsize=(4.8, 3.4), layout="constrained")[1])
    plt.show()
    print(response)


def live():
    """Whether there is a kernel, and ipywidgets to talk to it."""
    if find_spec("ipywidgets") is None or find_spec("IPython") is None:
        return False
    from IPython import get_ipython

    return getattr(get_ipython(), "kernel", None) is not None


if live():
    from ipywidgets import FloatSlider, interact

    steepness = FloatSlider(1.5, min=-1, max=4, step=0.05)
    interact(at, k=FloatSlider(5, min=0.5, max=7, step=0.1), theta=steepness)
else:
    print(
        "For sliders open this notebook in Jupyter, with ipywidgets (pip install "
        "ipywidgets). One position:"
    )
    at()

# %% [markdown]
# ## What this notebook claims

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
assert abs(circle.largest.low - 3) < 1e-6
assert (popov.largest.low, str(popov.verdict), str(popov.evidence)) == (
    inf,
    "PROVED",
    "certified",
)
assert str(tilted.answer.verdict) == "PROVED"
assert abs(reach[0] - 3) < 1e-6
assert abs(reach[0.5] - (6 + 4 * sqrt(3))) < 1e-6
assert round(6 + 4 * sqrt(3), 2) == 12.93
assert reach[1] > 1e9
assert disk.found.largest.low > 1.41
assert (
    control.feedback(0.26 * control.tf([12], [1, 2, -3]), 1).poles().real.max() < 0
)
assert (
    control.feedback(0.24 * control.tf([12], [1, 2, -3]), 1).poles().real.max() > 0
)
assert (
    abs(critical.largest.low - 6) < 1e-6,
    round(critical.theta, 9),
    critical.refuted_at >= 6,
) == (True, 1.5, True)
assert (
    critical.meaning
    == max_sector("1/s").meaning
    == "Every solution converges to the set of equilibria"
)
# the asymptote is at -3/4
assert abs(max_sector(MOTOR, criterion="circle").largest.low - 4 / 3) < 1e-6
assert max_sector("1/s").largest.low == inf
assert str(wrong_sign.verdict) == "REFUTED"
assert str(double.verdict) != "PROVED"
assert [round(response.k, 2) for response in leaning.values()] == [
    1,
    3,
    round(3 + 2 * sqrt(3), 2),
    42.07,
]
assert touching.margin_seen > 0
assert str(touching.answer.verdict) == "INCONCLUSIVE"
assert np.allclose(np.polymul([1, 3], [1, 0, 2]), [1, 3, 2, 6])
assert coarse.values.real.min() > 0
assert abs(refined.found.largest.low - 1.01) < 1e-6
assert abs(popov_ringing.largest.low - popov_ringing.hurwitz.low) < 1e-6
assert sum(poles.real > 0) == 2
