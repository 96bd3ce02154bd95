"""Figures of the theory pages on several channels, each drawn for a loop of its page, as the docstring says.

`figures` registers them with its own, and draws them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from lure import NonlinearityClass, Sector, as_plant, max_sector
from lure.analysis import l2_gain
from lure.analysis.plots.style import BLUE, GREEN, GREY, PURPLE, VERMILLION

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def integrators(ax: Axes) -> None:
    """Solutions of ``1/(s(s + 1))`` with a dead zone: each ends in the interval of equilibria."""
    for start, colour in (((4, 0), BLUE), ((0.5, 3), VERMILLION), ((-3, 1), GREEN), ((-0.5, -4), PURPLE)):
        found = solve_ivp(lambda _, x: [x[1], -x[1] - (x[0] - np.clip(x[0], -1, 1))], (0, 40), start, max_step=0.05)
        ax.plot(*found.y, color=colour)
        ax.plot(*found.y[:, -1], "o", color=colour)
    ax.plot([-1, 1], [0, 0], color="black", lw=3, label="equilibria")
    ax.set(xlabel="σ", ylabel="dσ/dt")
    ax.legend(fontsize=9)


def full_block(ax: Axes) -> None:
    """What diagonal and full-block multipliers prove of the sectors of two channels that act on each other."""
    plant = as_plant([["1/(s+1)", "2/(s+2)"], ["-2/(s+3)", "1/(s+1)^2"]])
    bounds = [(1, 0.1), (1, 0.35), (1, 1), (0.35, 1), (0.1, 1)]
    classes = [[NonlinearityClass(sector=Sector(0, k), time_varying=True) for k in pair] for pair in bounds]
    for criterion, colour, style, name in (
        ("diagonal-circle", VERMILLION, "s--", "a multiplier for each channel"),
        ("full-block-circle", BLUE, "o-", "one for both channels"),
    ):
        factors = [max_sector(plant, pair, criterion=criterion).largest.low for pair in classes]
        pairs = np.array([factor * np.array(pair) for factor, pair in zip(factors, bounds, strict=True)], float)
        ax.plot(*pairs.T, style, color=colour, label=name)
    ax.set(xlabel="upper bound k₁", ylabel="upper bound k₂", xscale="log", yscale="log")
    ax.legend(fontsize=9)


def channel_kernels(ax: Axes) -> None:
    """Kernels of mass 1 in time, causal and anticausal, of the orders that the search tries."""
    t = np.linspace(0, 6, 601)
    for order, colour, style in ((1, BLUE, "-"), (2, VERMILLION, "--"), (3, GREEN, "-.")):
        kernel = t ** (order - 1) * np.exp(-t) / max(order - 1, 1)
        ax.plot(t, kernel, color=colour, ls=style, label=f"(r/(r + s))^{order}" if order > 1 else "r/(r + s)")
    ax.plot(-t, np.exp(-t), color=GREY, label="r/(r − s)")
    ax.set(xlabel="r t", ylabel="h(t)/r", xlim=(-6, 6), ylim=(0, None))
    ax.legend(fontsize=9)


def relus(ax: Axes) -> None:
    """Where ``(u, v)`` lies for a sector, and for a ReLU."""
    ax.fill([0, 2, 2, 0], [0, 0, 2, 2], color=GREY, alpha=0.3, lw=0, label="a sector: uv ≥ 0")
    ax.fill([0, -2, -2, 0], [0, 0, -2, -2], color=GREY, alpha=0.3, lw=0)
    ax.plot([0, 2], [0, 0], color=BLUE, lw=3, label="a ReLU: σ > 0")
    ax.plot([0, 0], [0, -2], color=VERMILLION, lw=3, ls="--", label="a ReLU: σ < 0")
    ax.set(xlabel="u = φ(σ) − lσ", ylabel="v = hσ − φ(σ)", xlim=(-2, 2), ylim=(-2, 2), aspect="equal")
    ax.legend(fontsize=9, loc="upper left")


def uncertain_gains(ax: Axes) -> None:
    """Hulls of ``p(i omega, g)`` over a box of two gains: none holds 0."""
    corners = [(1, 0), (4, 0), (4, 2), (1, 2), (1, 0)]
    for k, omega in enumerate(np.linspace(0, 2.6, 14)):
        s = 1j * omega
        values = np.array([(s + 1) ** 3 + g1 * (s + 1) + g2 for g1, g2 in corners])
        ax.fill(values.real, values.imag, fc=BLUE, ec=BLUE, alpha=0.35, label=None if k else "gains of the box")
    ax.plot(0, 0, "o", color=VERMILLION, label="0")
    ax.set(xlabel="Re p(iω, g)", ylabel="Im p(iω, g)")
    ax.legend(fontsize=9)


def operators(ax: Axes) -> None:
    """Norm and spectral radius of the plant ``[[1, 10], [0, 1]]/(s + 1)`` over frequency."""
    omega = np.logspace(-2, 2, 201)
    plants = [np.array([[1, 10], [0, 1]]) / (1j * w + 1) for w in omega]
    ax.loglog(omega, [np.linalg.norm(h, 2) for h in plants], color=BLUE, label="|H(iω)|, for any operator")
    radii = [max(abs(np.linalg.eigvals(h))) for h in plants]
    ax.loglog(omega, radii, color=VERMILLION, ls="--", label="ρ(H(iω)), for one scalar operator twice")
    ax.set(xlabel="ω [rad/s]", ylabel="1 / largest norm")
    ax.legend(fontsize=9)


def channel_dead_times(ax: Axes) -> None:
    """The curve ``chi(i omega)`` of ``exp(-s)/s`` with the gain 1/2, whose angle rises by one quarter turn."""
    omega = np.linspace(0, 40, 8001)
    chi = (1j * omega + np.exp(-1j * omega) / 2) / (1 + omega)
    ax.plot(chi.real, chi.imag, color=BLUE, label="χ(iω)/(1 + ω)")
    ax.plot(chi.real[0], 0, "o", color=BLUE)
    ax.annotate("ω = 0", (chi.real[0], 0), (6, 4), textcoords="offset points", fontsize=9)
    ax.annotate("ω → ∞", (0, 1), (6, -2), textcoords="offset points", fontsize=9)
    ax.plot(0, 0, "+", color="black", ms=10)
    ax.set(xlabel="real part", ylabel="imaginary part", xlim=(-0.3, 0.7), ylim=(-0.15, 1.05))
    ax.legend(fontsize=9)


def delays(ax: Axes) -> None:
    """How far ``exp(-i omega tau)`` may be from 1, and the majorant above it."""
    x = np.linspace(0, 10, 1001)
    s = 1j * x
    majorant = (1.0041 * s + 0.4751 * s**2 + 0.1133 * s**3) / (1 + 0.8563 * s + 0.3183 * s**2 + 0.0561 * s**3)
    ax.plot(x, abs(majorant), color=BLUE, label="|m(iωh)|")
    ax.plot(x, np.where(x < np.pi, abs(np.exp(-s) - 1), 2), color=VERMILLION, ls="--", label="delays up to h")
    ax.set(xlabel="ωh", ylabel="|exp(−iωτ) − 1|, at most", xlim=(0, 10), ylim=(0, None))
    ax.legend(fontsize=9)


def hysteresis(ax: Axes) -> None:
    """Play and stop of width 2 and slope 1, as ``sigma`` swings."""
    sigma = np.concatenate([np.linspace(0, 3, 61), np.linspace(3, -3, 121), np.linspace(-3, 3, 121)])
    play = [0.0]
    for value in sigma[1:]:
        play.append(float(np.clip(play[-1], value - 1, value + 1)))
    ax.plot(sigma, play, color=BLUE, label="play")
    ax.plot(sigma, sigma - np.array(play), color=VERMILLION, ls="--", label="stop")
    ax.set(xlabel="σ", ylabel="φ")
    ax.legend(fontsize=9)


def gain(ax: Axes) -> None:
    """The gains of some members of a class at each frequency, and what is proved of all of them."""
    plant = as_plant(([[-0.5, -1], [1, 0]], [[1], [0]], [[0, 1]]))
    found = l2_gain(plant, [Sector(0, 1)], {"Bw": [[1], [0]], "Cz": [[0, 1]]})
    omega = np.linspace(0, 3, 601)
    for g, colour, style in ((0, BLUE, "-"), (0.5, GREEN, "-."), (1, PURPLE, ":")):
        response = 1 / abs(-(omega**2) + 0.5j * omega + 1 + g)
        ax.plot(omega, response, color=colour, ls=style, label=f"φ = {g:g} σ")
    high = float(found.gain.high)
    ax.axhline(high, color=VERMILLION, ls="--", label=f"every φ of [0, 1]: at most {high:.4g}")
    ax.set(xlabel="ω [rad/s]", ylabel="|T(iω)|", xlim=(0, 3), ylim=(0, 1.9 * high))
    ax.legend(fontsize=9)


def channel_counterexamples(ax: Axes) -> None:
    """A solution that grows while a gain jumps between 0 and 3, each of which alone makes it decay."""
    gains, times = (3, 0), (np.pi / 4, np.pi / 2)
    state, now, t, x = np.array([1.0, 0.0]), 0.0, [0.0], [1.0]
    for _ in range(6):
        for g, duration in zip(gains, times, strict=True):
            step = expm(np.array([[0, 1], [-1 - g, -0.3]]) * duration / 40)
            for _ in range(40):
                state, now = step @ state, now + duration / 40
                t.append(now)
                x.append(state[0])
    ax.plot(t, x, color=VERMILLION, label="gain 3 and 0 in turn")
    for g, colour, style in ((0, BLUE, "--"), (3, GREEN, ":")):
        fixed = [(expm(np.array([[0, 1], [-1 - g, -0.3]]) * at) @ [1, 0])[0] for at in np.linspace(0, now, 301)]
        ax.plot(np.linspace(0, now, 301), fixed, color=colour, ls=style, label=f"gain {g}")
    ax.set(xlabel="t [s]", ylabel="σ")
    ax.legend(fontsize=9)


DRAWN = (
    integrators,
    full_block,
    channel_kernels,
    relus,
    uncertain_gains,
    operators,
    channel_dead_times,
    delays,
    hysteresis,
    gain,
    channel_counterexamples,
)
