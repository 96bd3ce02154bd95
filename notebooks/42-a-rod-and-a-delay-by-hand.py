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
# # A rod and a delay, by hand
#
# [A proof you can check](40-a-proof-you-can-check.py) reads certificates whose inequality is a polynomial or a matrix.
# Here are three without either, in `fractions.Fraction` again: a rod's scheme for every number of cells, by an
# inequality that was proved once and by its energy, and a dead time, by a box of frequencies and what lies beyond it.

# %% tags=["hide-input"]
from fractions import Fraction
from math import factorial

import matplotlib.pyplot as plt
import numpy as np
from numpy.polynomial.polynomial import polyval

# what is checked: called to compare, never to compute
from lure.analysis.certificates import checker
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.plots.style import BLUE, GREEN, GREY, VERMILLION, finish_axes

STRUCTURE = {"method": "structure"}


def drafted(theorem, system, sector, proof, multiplier=None):
    """What the checker makes of a draft about a sector."""
    laws = {"sector": sector, "slope": None, "odd": False, "time_varying": False}
    return complete_and_check(
        {
            "verdict": "PROVED",
            "system": system,
            "laws": {**laws, "linear": False},
            "theorem": theorem,
            "multiplier": multiplier or {},
            "proof": proof,
        }
    )


# %% [markdown]
# ## A rod, for every number of cells
#
# For the rod no frequency is examined at all; an inequality was proved once. With $q = e^{-2sT}$, or $(1 + sT/N)^{-2N}$
# for the scheme with $N$ cells, $a = (k-Z)/(k+Z)$ and $d = A/Z$:
#
# 1. $H = \frac ds\,\frac{1 - aq}{1 + aq}$. On the axis $q = re^{-i\psi}$ with $r \le 1$ and $|\sin\psi| \le \psi \le
#    2\omega T$.
# 2. $|1 + aq|^2\,\mathrm{Re}[(1 + i\omega\theta)H] = d\,[\theta(1 - a^2r^2) + 2ar\sin\psi/\omega] \ge d\,[\theta(1 -
#    a^2) - 4|a|T]$ for $\theta\ge0$.
# 3. So Popov's condition holds for every finite sector $[0, K]$ and every $N$ as soon as $\theta \ge 4|a|T/(1 - a^2) =
#    L\,|k^2 - Z^2|/(kAE)$.
#
# It makes Popov's theorem apply to the scheme; for the rod itself, a partial differential equation, [note
# 11](notes/0011-popov-for-the-rod.md) proves what follows. With the paper's numbers:

# %%
paper = {"E": "288000000", "rho": "8", "L": "1", "A": "1/40000", "k": "1/5000"}
E, density, L, area, damping = map(Fraction, paper.values())
Z = Fraction(6, 5)
assert area * area * density * E == Z * Z
least = L * abs(damping**2 - Z * Z) / (damping * area * E)
a, d_rod = (damping - Z) / (damping + Z), area / Z
travel = L * area * density / Z  # T = L/c, c = Z/(A rho)
print(f"a = {a}, d = {d_rod}, theta >= {least} s = {float(least):.8f} s")


def scheme(cells, theta):
    """What the checker says of Popov's inequality for the scheme and the sector [0,
    1]."""
    system = {"kind": "rod-scheme", **paper, "cells": cells}
    multiplier = {"theta": str(theta)}
    try:
        found = drafted("rod-popov", system, ["0", "1"], STRUCTURE, multiplier)
        return found.certificate["conclusion"]
    except checker.Rejected as reason:
        return f"Rejected: {reason}"


print(scheme(100_000, least))
print(scheme(100_000, least - Fraction(1, 10**30)))

# %% [markdown]
# The other theorem is about energy, for the rod and for its scheme. Here we follow the scheme. It is
# $y_i' = s\,(\mathrm{prev}_i - y_i)$ with $\mathrm{prev}_i = y_{i-1}$, but $\mathrm{prev}_1 = -a\,y_{2N}$ and
# $\mathrm{prev}_{N+1} = y_N - 2d\,p$, and $z' = y_N - d\,p$, $p = \phi(z)$. For
# $V = \frac1{2s}\sum y_i^2 + 2d\int_0^z\phi$, row by row,
#
# $$y_i\,y_i'/s + \tfrac12(\mathrm{prev}_i - y_i)^2 = \tfrac12\,(\mathrm{prev}_i^2 - y_i^2),$$
#
# the right-hand sides telescope, and what remains at the two ends cancels against $2d\,p\,z'$, up to
# $-\tfrac12(1-a^2)\,y_{2N}^2$. For $N = 3$ as quadratic forms in $(p, y_1, \dots, y_6)$, in fractions:

# %%
N = 3


def form(*products):
    """A quadratic form: the sum of ``factor u v`` for linear forms ``u``, ``v``,
    without zeros."""
    out = {}
    for factor, u, v in products:
        for i, x in u.items():
            for j, y in v.items():
                out[min(i, j), max(i, j)] = (
                    out.get((min(i, j), max(i, j)), 0) + factor * x * y
                )
    return {key: x for key, x in out.items() if x}


def added(*forms):
    """The sum of forms, without zeros."""
    out = {
        key: sum(each.get(key, 0) for each in forms) for key in set().union(*forms)
    }
    return {key: x for key, x in sorted(out.items()) if x}


def shown(quadratic):
    """A form, to read."""
    names = ["p"] + [f"y{i}" for i in range(1, 2 * N + 1)]
    return (
        "  ".join(f"{x} {names[i]}{names[j]}" for (i, j), x in quadratic.items())
        or "0"
    )


y = {i: {i: Fraction(1)} for i in range(2 * N + 1)}  # y[0] is p
prev = {i: y[i - 1] for i in range(2, 2 * N + 1)} | {
    1: {2 * N: -a},
    N + 1: {N: Fraction(1), 0: -2 * d_rod},
}
half, rows = Fraction(1, 2), []
for i in range(1, 2 * N + 1):
    jump = {j: prev[i].get(j, 0) - y[i].get(j, 0) for j in {*prev[i], *y[i]}}
    # y_i y_i'/s + (1/2) (prev_i - y_i)^2
    rows.append(form((1, y[i], jump), (half, jump, jump)))
    print(f"row {i}:      {shown(rows[-1])}")
nonlinearity = form((2 * d_rod, y[0], {N: Fraction(1), 0: -d_rod}))  # 2 d p z'
end = form(((1 - a * a) / 2, y[2 * N], y[2 * N]))
print(f"2 d p z':   {shown(nonlinearity)}\nat the end: {shown(end)}")
total = added(*rows, nonlinearity, end)
print(f"sum:        {shown(total)}")

# %% [markdown]
# The sum is zero: $V' = -\tfrac12\sum(\mathrm{prev}_i - y_i)^2 - \tfrac12(1-a^2)\,y_{2N}^2$, and $1 - a^2 > 0$ as
# $k > 0$. The checker does the same for the number of cells in the file, at values of $a$ and $d$ so large that a
# vanishing sum vanishes identically. How rest follows from it, and convergence, and the same for the rod itself: [note
# 5](notes/0005-energy-theorem.md).

# %%
three = {"kind": "rod-scheme", **paper, "cells": N}
settled_rod = drafted("rod-energy", three, ["0", "inf"], STRUCTURE)
print(settled_rod.claim)
print(settled_rod.facts["energy"])
assert (a, d_rod, least) == (
    Fraction(-5999, 6001),
    Fraction(1, 48000),
    Fraction(35999999, 36000000),
)
assert least == 4 * abs(a) * travel / (1 - a * a)
assert scheme(100_000, least) == "every motion converges to the set of equilibria"
assert scheme(100_000, least - Fraction(1, 10**30)).startswith(
    "Rejected: theta is below"
)
assert total == {}
assert all(rows)
assert 1 - a * a > 0
assert added(*rows[1:], nonlinearity, end) != {}

# %% [markdown]
# ## A box, and all that lies beyond it
#
# With dead time $F$ is no polynomial. For $e^{-s}/(s+1)$ and the sector $[0, 1]$ the circle criterion asks for
#
# $$F = 1 + \omega^2 + \cos\omega - \omega\sin\omega > 0 .$$
#
# On $[0, 1]$ replace cosine and sine by their Taylor polynomials of order 8. The remainders are at most $\omega^8/8!$
# each; subtract $(1 + \omega)\,\omega^8/8!$ and a polynomial is left that lies below $F$.

# %%
order, right_end = 8, Fraction(1)
terms = [Fraction(1, factorial(j)) for j in range(order)]
cosine = [x * (1, 0, -1, 0)[j % 4] for j, x in enumerate(terms)] + [0, 0]
sine = (
    [0] + [x * (0, 1, 0, -1)[j % 4] for j, x in enumerate(terms)] + [0]
)  # times omega
error = [0] * order + [Fraction(1, factorial(order))] * 2
undelayed = [1, 0, 1] + [0] * (order - 1)
below = [
    u + x - y - e for u, x, y, e in zip(undelayed, cosine, sine, error, strict=True)
]
print("below F:", *below)
negative = sum(min(x, 0) * right_end**i for i, x in enumerate(below))
print(
    f"constant {below[0]}, all negative terms together at least {negative}: F > "
    f"{below[0] + negative} on the box"
)

# %% [markdown]
# The constant outweighs all negative terms at the right end, where they are largest: $F > 0$ on the box. Beyond it the
# undelayed part prevails: by Cauchy and Schwarz $|\cos\omega - \omega\sin\omega| \le \sqrt{1 + \omega^2}$, and
# $(1 + \omega^2)^2 - (1 + \omega^2) = \omega^2 + \omega^4 > 0$. One box and one tail cover all frequencies.

# %%
dead_time = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
cover = {"method": "cover", "boxes": [["0", "1"]], "order": order}
covered = drafted("circle", dead_time, ["0", "1"], cover)
print(covered.claim)
assert below[0] == 2
assert below[0] + negative == Fraction(20029, 13440)
square = np.convolve([1, 0, 1], [1, 0, 1])
assert list(square - [1, 0, 1, 0, 0]) == [0, 0, 1, 0, 1]
omega = np.linspace(0, 1, 11)
assert np.all(
    polyval(omega, [float(x) for x in below])
    <= 1 + omega**2 + np.cos(omega) - omega * np.sin(omega) + 1e-15
)

_, ax = plt.subplots(figsize=(4.8, 3), layout="constrained")
omega, inside, beyond = (
    np.linspace(0, 3, 400),
    np.linspace(0, 1, 100),
    np.linspace(1, 3, 200),
)
ax.axvspan(0, 1, color=GREY, alpha=0.15, lw=0, label="the box")
ax.plot(
    omega,
    1 + omega**2 + np.cos(omega) - omega * np.sin(omega),
    color=BLUE,
    lw=1.4,
    label="F",
)
ax.plot(
    inside,
    polyval(inside, [float(x) for x in below]),
    color=VERMILLION,
    lw=1.4,
    ls="--",
    label="polynomial below F",
)
tail = 1 + beyond**2 - np.sqrt(1 + beyond**2)
ax.plot(
    beyond, tail, color=GREEN, lw=1.4, ls="-.", label="what Cauchy and Schwarz leave"
)
ax.axhline(0, color=GREY, lw=0.6)
ax.set(xlabel="ω [rad/s]", ylabel="F", xlim=(0, 3), ylim=(-0.3, 6))
finish_axes(ax)
ax.legend(loc="upper left", frameon=False)
plt.show()

# %% [markdown]
# "0 attracts every motion with inputs to the block and initial functions of finite energy" is what the theorem gives
# with dead time, and no more.
