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
# # Convergence rates of optimisation methods
#
# How fast does the gradient method converge, how fast Nesterov's, and does the heavy ball converge at all? A method
# with steps, momentum and extrapolation is a linear plant with a pole at $z = 1$, and the gradient is a nonlinearity
# in feedback with it: $\mu = -\nabla f(\sigma)$. Its slope lies between $m$ and $L$; $\kappa = L/m$ is all that
# matters.
#
# `decay_rate` answers from both sides: a factor $r$ per iteration such that $|x_t| \le c\,r^t\,|x_0|$ for *every* such
# $f$, with one $c$, proved in rational numbers; and a member of the class that is no faster than some other factor. In
# between nothing is known.

# %% tags=["hide-input"]
from fractions import Fraction

import matplotlib.pyplot as plt
import numpy as np

from lure import Sector, SlopeBounds, methods
from lure.analysis import decay_rate
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    LEGEND,
    PURPLE,
    VERMILLION,
    finish_axes,
)

# %% [markdown]
# The gradient method with the step $1/L$ has the rate $1 - 1/\kappa$, exactly: proved, and attained by
# $f = m x^2/2$.

# %%
print(decay_rate(methods.gradient(1, 10), SlopeBounds(1, 10)))

# %% [markdown]
# ## Rates against $\kappa$

# %%
METHODS = {
    "gradient": (methods.gradient, GREEN, "o"),
    "Nesterov": (methods.nesterov, BLUE, "s"),
    "heavy ball": (methods.heavy_ball, VERMILLION, "^"),
    "triple momentum": (methods.triple_momentum, PURPLE, "D"),
}
KAPPAS = [
    Fraction("1.5"),
    Fraction(10**0.5),
    Fraction(10),
    Fraction(25),
    Fraction(100),
]
found = {
    name: [decay_rate(method(1, kappa), SlopeBounds(1, kappa)) for kappa in KAPPAS]
    for name, (method, *_) in METHODS.items()
}

# %%
_, ax = plt.subplots(figsize=(4.8, 5.2), layout="constrained")
k = np.array([float(kappa) for kappa in KAPPAS])
for name, (_, color, mark) in METHODS.items():
    high = np.array([one.rate.high for one in found[name]])
    ax.plot(
        k,
        np.where(np.isfinite(high), high, np.nan),
        mark + "-",
        color=color,
        lw=1.2,
        ms=5,
        label=f"{name}, proved",
    )
    low = [one.rate.low for one in found[name]]
    ax.plot(
        k,
        low,
        mark,
        color=color,
        mfc="white",
        ms=5,
        label=f"{name}, a member that slow",
    )
ax.set_xscale("log")
ax.set_xlabel("κ = L/m [1]")
ax.set_ylabel("factor per iteration [1]")
finish_axes(ax)
ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, **LEGEND)
plt.show()

# %% [markdown]
# Full marks are proved, empty ones are members of the class that are no faster. Where both coincide nothing is left
# open: for the gradient method and for triple momentum, $1 - 1/\sqrt\kappa$, the fastest known. For Nesterov's
# method the proved numbers are those published from semidefinite programmes. The heavy ball is tuned for quadratic
# functions, where it is the fastest of all; with slopes that change it is proved at small $\kappa$ only, and at
# $\kappa = 25$ a piecewise linear gradient keeps it in a cycle for ever:

# %%
print(found["heavy ball"][-2])
cycle = found["heavy ball"][-2].refutation.certificate["proof"]
print(
    "points of the gradient:",
    [tuple(float(Fraction(v)) for v in point) for point in cycle["points"]],
)

# %% [markdown]
# ## What the slope is worth
#
# Who knows only that $\nabla f$ lies between $m\sigma$ and $L\sigma$, or lets it depend on the iteration, knows less;
# then the circle criterion is all there is.

# %%
for kappa in (5, 10, 15):
    plant = methods.nesterov(1, kappa)
    print(
        f"kappa = {kappa}:",
        *(
            str(decay_rate(plant, kind(1, kappa)).rate)
            for kind in (SlopeBounds, Sector)
        ),
        sep="   ",
    )

# %% [markdown]
# ## The numbers of this notebook
#
# Each is asserted, and the second checker, which shares no code with the first, accepts every certificate. The proofs
# with Zames-Falb taps $\ge 0$ hold for functions of several variables as well (theory, decay rates).

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
close = np.testing.assert_allclose
high = {
    name: np.array([one.rate.high for one in row]) for name, row in found.items()
}
low = {name: np.array([one.rate.low for one in row]) for name, row in found.items()}
close(high["gradient"], 1 - 1 / k, atol=1e-9)
close(low["gradient"], 1 - 1 / k, atol=1e-9)
close(high["triple momentum"], 1 - 1 / np.sqrt(k), atol=3e-6)
close(low["triple momentum"], 1 - 1 / np.sqrt(k), atol=3e-6)
close(high["Nesterov"][[1, 2, 4]], [0.5201, 0.7518, 0.9280], atol=3e-4)
assert (high["heavy ball"][:3] < [0.26, 0.5091, 0.8602]).all()
assert [one.verdict.name for one in found["heavy ball"]] == ["PROVED"] * 3 + [
    "REFUTED"
] * 2
assert all(
    low[name][i] <= high[name][i] for name in found for i in range(len(KAPPAS))
)
shown = [
    side
    for row in found.values()
    for one in row
    for side in (one.proof, one.refutation)
    if side is not None
]
assert all(recheck(dict(side.certificate)).accepted for side in shown)
print(f"{len(shown)} certificates accepted by both checkers")
