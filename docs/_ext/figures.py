"""Figures of the theory pages, each drawn from what lure computes for a loop of its page, as the docstring says.

``draw`` writes all of them, ``NAME.svg`` for each name in ``FIGURES``, and runs the commands of
``docs/how-to/long-runs.md``, which take too long for the tests; `pictures` calls it before Sphinx reads.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import channel_figures
import numpy as np

from lure import Saturation, Sector, SlopeBounds, as_plant, max_sector, methods
from lure.analysis import decay_rate, region, steady_response
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.plots.style import BLUE, GREEN, GREY, PURPLE, VERMILLION
from lure.analysis.theorems.circle import circle_largest
from lure.analysis.theorems.off_axis import off_axis_largest
from lure.analysis.theorems.passivity import passivity_indices
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.theorems.zames_falb_discrete import zames_falb_discrete_largest
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from lure.rod import Rod, Scenario, exact_motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Draw = Callable[["Axes"], None]
OMEGA = np.logspace(-3, 3, 4000)
SERVO = RationalPlant([1], [1, 3, 2, 0])
SAMPLED = RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
FIGURES: dict[str, Draw] = {}


def figure(draw: Draw) -> Draw:
    """Register a figure under the name of its function, with hyphens."""
    FIGURES[draw.__name__.replace("_", "-")] = draw
    return draw


def values(block: RationalPlant, omega: np.ndarray) -> np.ndarray:
    """``H(i omega)``; of a sampled block ``H(e^(i omega))``."""
    at = 1j * omega if block.dt is None else np.exp(1j * omega)
    num, den = ([float(value) for value in each] for each in (block.numerator, block.denominator))
    return np.polyval(num, at) / np.polyval(den, at)


def plane(ax: Axes, *, x: tuple[float, float], y: tuple[float, float]) -> None:
    """The complex plane, with its axes, in equal units."""
    ax.axhline(0, color=GREY, lw=0.6)
    ax.axvline(0, color=GREY, lw=0.6)
    ax.set(xlim=x, ylim=y, xlabel="Re H", ylabel="Im H", aspect="equal")


def forbidden(ax: Axes, edge: float, name: str) -> None:
    """What lies left of a vertical line."""
    ax.axvspan(ax.get_xlim()[0], edge, color=GREY, alpha=0.25, lw=0)
    ax.axvline(edge, color=GREY, lw=1.4)
    ax.annotate(name, (edge, ax.get_ylim()[1]), (4, -12), textcoords="offset points", fontsize=9)


@figure
def passivity(ax: Axes) -> None:
    """Nyquist curves, and the vertical lines of their first index."""
    for block, colour, name in (
        (RationalPlant([1], [1, 1]), BLUE, "1/(s + 1)"),
        (RationalPlant([1, 1, 1], [1, 2, 1]), VERMILLION, "(s² + s + 1)/(s + 1)²"),
    ):
        curve = values(block, np.concatenate([-OMEGA[::-1], OMEGA]))
        style = "-" if colour == BLUE else "--"
        nu = passivity_indices(block).input_feedforward.low
        ax.plot(curve.real, curve.imag, color=colour, ls=style, label=f"{name}: ν = {nu:.3g}")
        ax.axvline(nu, color=colour, lw=0.8, ls=style)
    plane(ax, x=(-0.5, 1.5), y=(-1.15, 0.65))
    ax.legend(loc="lower right", fontsize=9)


@figure
def hurwitz(ax: Axes) -> None:
    """Roots of ``d + g n`` while the gain grows, and where they cross."""
    (interval,) = gain_intervals(SERVO)
    limit = interval.upper.value.high
    gains = np.linspace(0, 20, 401)
    roots = np.array([np.roots([1, 3, 2, gain]) for gain in gains])
    for share, colour, name in ((gains <= limit, BLUE, "stable"), (gains >= limit, VERMILLION, "unstable")):
        ax.plot(roots[share].real, roots[share].imag, ".", ms=2, color=colour)
        ax.plot([], [], color=colour, label=name)
    crossing = np.roots([1, 3, 2, limit])
    ax.plot(crossing.real, crossing.imag, "o", mfc="white", color="black", label=f"κ = {limit:.4g}")
    plane(ax, x=(-5, 1), y=(-3, 3))
    ax.set(xlabel="Re s [1/s]", ylabel="Im s [rad/s]")
    ax.legend(loc="upper left", fontsize=9)


@figure
def discrete_time(ax: Axes) -> None:
    """The curve on the unit circle, and the line of the circle criterion's largest sector."""
    curve = values(SAMPLED, np.linspace(-np.pi, np.pi, 2001))
    k = circle_largest(SAMPLED).largest.low
    ax.plot(curve.real, curve.imag, color=BLUE, label="H(exp(iω))")
    plane(ax, x=(-2.4, 6.4), y=(-4.2, 5))
    forbidden(ax, -1 / k, f"−1/k, k = {k:.4g}")
    ax.legend(loc="center", fontsize=9)


@figure
def loop_shifts(ax: Axes) -> None:
    """A nonlinearity between its lines, before and after the lower one is taken away."""
    sigma = np.linspace(-2, 2, 401)
    phi = 3.5 * sigma + 1.5 * sigma * np.cos(2 * sigma)
    for values_, low, high, colour, name in (
        (phi, 2, 5, BLUE, "φ in [2, 5]"),
        (phi - 2 * sigma, 0, 3, VERMILLION, "φ − 2σ in [0, 3]"),
    ):
        ax.fill_between(sigma, low * sigma, high * sigma, color=colour, alpha=0.15, lw=0)
        ax.plot(sigma, values_, color=colour, ls="-" if low else "--", label=name)
    ax.axhline(0, color=GREY, lw=0.6)
    ax.axvline(0, color=GREY, lw=0.6)
    ax.set(xlabel="σ", ylabel="φ(σ)", xlim=(-2, 2))
    ax.legend(loc="upper left", fontsize=9)


@figure
def zames_falb(ax: Axes) -> None:
    """Largest slopes proved by multipliers for odd and for all monotone nonlinearities, and the circle criterion's."""
    rows = [
        ("odd", zames_falb_discrete_largest(SAMPLED, odd=True).largest.low),
        ("monotone", zames_falb_discrete_largest(SAMPLED, odd=False).largest.low),
        ("sector, any time", circle_largest(SAMPLED).largest.low),
    ]
    for row, (_, proved) in enumerate(reversed(rows)):
        ax.barh(row, proved, height=0.5, color=BLUE)
        ax.annotate(f"{proved:.4g}", (proved, row), (4, -3), textcoords="offset points", fontsize=9)
    ax.plot([], [], color=BLUE, lw=6, label="proved")
    for row, value in ((2, 25 / 23), (1, 175 / 192)):
        ax.plot(value, row, "D", color=VERMILLION, ms=6, label="an orbit exists" if row == 2 else None)
    ax.set(yticks=range(3), yticklabels=[name for name, _ in reversed(rows)], xlabel="largest slope k", xlim=(0, 1.75))
    ax.legend(loc="lower right", fontsize=9)


@figure
def park(ax: Axes) -> None:
    """Phases that the multipliers of three criteria have at their most."""
    for name, multiplier, colour, style in (
        ("circle: 1", np.ones_like(OMEGA), GREY, ":"),
        ("Popov: 1 + θs, θ = 1 s", 1 + 1j * OMEGA, BLUE, "-"),
        ("Park: 1 + θs − τs², θ = 0.5 s, τ = 1 s²", 1 + 0.5j * OMEGA + OMEGA**2, VERMILLION, "--"),
        ("Park: θ = −0.5 s, τ = 1 s²", 1 - 0.5j * OMEGA + OMEGA**2, PURPLE, "-."),
    ):
        ax.semilogx(OMEGA, np.degrees(np.angle(multiplier)), color=colour, ls=style, label=name)
    ax.set(xlabel="ω [rad/s]", ylabel="phase of the multiplier [°]", xlim=(1e-3, 1e3), ylim=(-40, 170))
    ax.set_yticks(range(-30, 91, 30))
    ax.legend(loc="upper left", fontsize=9)


@figure
def off_axis_circle(ax: Axes) -> None:
    """A line off the axis through ``-1/k`` on the right of which the curve lies, and the circle criterion's line."""
    block = RationalPlant([1], [1, 3, 3, 1])
    circle, k = circle_largest(block).largest.low, off_axis_largest(block).largest.low
    curve = values(block, OMEGA)
    ax.plot(curve.real, curve.imag, color=BLUE, label="H(iω), ω ≥ 0")
    plane(ax, x=(-0.6, 1.1), y=(-1.15, 0.4))
    forbidden(ax, -1 / circle, f"circle: −1/k, k = {circle:.4g}")
    near = int(np.argmin(np.abs(OMEGA - np.sqrt(3))))
    slope = np.diff(curve.imag)[near] / np.diff(curve.real)[near]
    x = np.array(ax.get_xlim())
    ax.plot(x, slope * (x + 1 / k), color=VERMILLION, ls="--", label=f"off the axis: through −1/k, k = {k:.4g}")
    ax.legend(loc="lower right", fontsize=9)


@figure
def rates(ax: Axes) -> None:
    """Certified rates of two methods of optimisation over the condition number."""
    conditions = np.array([2, 4, 10, 30, 100])
    for method, colour, marker, name in (
        (methods.gradient, BLUE, "o", "gradient"),
        (methods.triple_momentum, VERMILLION, "s", "triple momentum"),
    ):
        found = [decay_rate(method(1, int(L)), SlopeBounds(1, int(L))).rate.high for L in conditions]
        ax.semilogx(conditions, found, marker=marker, ls="", color=colour, label=f"{name}, proved")
    dense = np.logspace(np.log10(2), 2, 100)
    ax.semilogx(dense, 1 - 1 / dense, color=BLUE, lw=1, label="1 − 1/κ")
    ax.semilogx(dense, 1 - 1 / np.sqrt(dense), color=VERMILLION, lw=1, ls="--", label="1 − 1/√κ")
    ax.set(xlabel="condition number κ", ylabel="rate per step", ylim=(0, 1.02), xticks=conditions)
    ax.set_xticks(conditions, [str(one) for one in conditions])
    ax.minorticks_off()
    ax.legend(loc="lower right", fontsize=9)


@figure
def regions(ax: Axes) -> None:
    """The region of attraction of an unstable plant behind a saturation, in the plane."""
    region(([[0, 1], [1, 0]], [0, 1], [3, 4], 0), Saturation(gain=1, limit=1)).plot(ax=ax)


@figure
def steady(ax: Axes) -> None:
    """Amplitudes of the steady response of a loop with a saturation, enclosed."""
    for omega in np.round(np.logspace(-0.6, 0.6, 9), 3):
        forcing = {"amplitude": 3, "omega": Fraction(str(omega))}
        (found,) = steady_response(([1], [1, 1, 1]), Saturation(), forcing).response
        ax.vlines(omega, found.low, found.high, color=BLUE, lw=3)
        ax.plot(omega, (found.low + found.high) / 2, "o", color=BLUE, ms=4)
    linear = np.logspace(-0.7, 0.7, 300)
    ax.plot(linear, 3 / np.abs((1j * linear) ** 2 + 1j * linear + 2), color=GREY, ls="--", label="the linear gain 1")
    ax.plot([], [], "o", color=BLUE, label="saturation: enclosed")
    ax.set(xscale="log", xlabel="ω [rad/s]", ylabel="amplitude of z", ylim=(0, 3.6))
    ax.set_xticks([0.25, 0.5, 1, 2, 4], ["0.25", "0.5", "1", "2", "4"])
    ax.minorticks_off()
    ax.legend(fontsize=9)


@figure
def tolerances(ax: Axes) -> None:
    """Popov curves of plants of a box, and the line that holds for all of them."""
    family = PlantFamily.of_formula("k/(s*(s + 1)*(s + a))", {"k": (0.75, 1.25), "a": (1.75, 2.25)})
    for k in (0.75, 1.0, 1.25):
        for a in (1.75, 2.0, 2.25):
            curve = values(RationalPlant([k], [1, 1 + a, a, 0]), OMEGA)
            worst = (k, a) == (1.25, 1.75)
            ax.plot(curve.real, OMEGA * curve.imag, color=VERMILLION if worst else BLUE, lw=1.6 if worst else 0.8)
    largest = max_sector(family).largest.low
    theta = popov_largest(RationalPlant([Fraction(5, 4)], [1, Fraction(11, 4), Fraction(7, 4), 0])).theta
    y = np.array([-0.8, 0.2])
    ax.plot(theta * y - 1 / largest, y, color=GREY, lw=1.6, label=f"θ = {theta:.3g} s, k = {largest:.4g}")
    ax.plot([], [], color=BLUE, label="plants of the box")
    ax.plot([], [], color=VERMILLION, label="k = 5/4, a = 7/4")
    ax.axhline(0, color=GREY, lw=0.6)
    ax.axvline(0, color=GREY, lw=0.6)
    ax.set(xlabel="Re H", ylabel="ω Im H [1/s]", xlim=(-1.1, 0.1), ylim=(-0.8, 0.1))
    ax.legend(loc="lower right", fontsize=9)


@figure
def all_frequencies(ax: Axes) -> None:
    """The polynomial of Popov's inequality for ``1/(s(s + 1)(s + 2))``, whose sign Sturm's theorem decides."""
    x = np.linspace(0, 4.2, 400)
    for k, colour, style in ((Fraction(59, 10), BLUE, "-"), (6, GREY, ":"), (Fraction(61, 10), VERMILLION, "--")):
        # (|d|^2 + k Re[(1 + 1.5 i omega) n d*])/x for d = s(s + 1)(s + 2), n = 1
        form = x * x + 5 * x + 4 + float(k) * (1.5 * (2 - x) - 3)
        ax.plot(x, form, color=colour, ls=style, label=f"k = {float(k):g}")
    ax.axhline(0, color="black", lw=0.8)
    ax.set(xlabel="x = ω² [rad²/s²]", ylabel="F(x)", xlim=(0, 4.2), ylim=(-1, 8))
    ax.legend(fontsize=9)


@figure
def critical_case(ax: Axes) -> None:
    """Solutions of an integrator behind a dead zone: each converges, not all to 0."""
    from scipy.integrate import solve_ivp

    def rate(_: float, x: np.ndarray) -> list[float]:
        sigma = x[0]
        return [x[1], x[2], -3 * x[2] - 2 * x[1] - 5 * (sigma - min(max(sigma, -1), 1))]

    for start, colour in zip((4.0, 2.0, 0.6, -0.8, -3.0), (BLUE, VERMILLION, GREEN, PURPLE, "black"), strict=True):
        run = solve_ivp(rate, (0, 25), [start, 0.8, 0.0], max_step=0.05, rtol=1e-9)
        ax.plot(run.t, run.y[0], color=colour, lw=1.2)
    ax.axhspan(-1, 1, color=GREY, alpha=0.25, lw=0, label="equilibria")
    ax.set(xlabel="t [s]", ylabel="σ", xlim=(0, 25))
    ax.legend(fontsize=9)


@figure
def evidence(ax: Axes) -> None:
    """A resonance between the points of a grid: ``1/(s^2 + 1e-5 s + 1)``, which it misses."""
    block = RationalPlant([1], [1, Fraction(1, 10**5), 1])
    grid = np.logspace(-3, 3, 10_001)
    near = np.concatenate([-np.logspace(-2.5, -7, 400), np.logspace(-7, -2.5, 400)])
    dense = 1 + np.sort(np.concatenate([near, np.linspace(-3e-5, 3e-5, 400)]))
    ax.plot(dense, values(block, dense).real, color=BLUE, label="Re H(iω)")
    shown = grid[np.abs(grid - 1) < 4e-3]
    ax.plot(shown, values(block, shown).real, "o", color=VERMILLION, ms=5, label="the grid")
    ax.axhline(0, color=GREY, lw=0.6)
    least, missed = values(block, grid).real.min(), -1 / max_sector(block, criterion="circle").largest.low
    for level, name in ((least, "least on the grid"), (missed, "least of all")):
        ax.axhline(level, color=GREY, lw=0.8, ls=":")
        ax.annotate(f"{name}: {level:,.0f}", (0.9971, level), (0, 4), textcoords="offset points", fontsize=9)
    ax.set(xlabel="ω [rad/s]", ylabel="Re H", xlim=(0.997, 1.003), yscale="symlog", ylim=(-3e5, 3e5))
    ax.set_xticks([0.998, 1, 1.002], ["0.998", "1", "1.002"])
    ax.set_yticks([-1e4, -1e2, 0, 1e2, 1e4])
    ax.legend(loc="upper right", fontsize=9)


@figure
def dead_time(ax: Axes) -> None:
    """Popov's curve of ``exp(-s)/(s + 1)``, and the lines of Popov's and the circle criterion."""
    omega = np.linspace(0, 30, 6000)
    curve = np.exp(-1j * omega) / (1 + 1j * omega)
    ax.plot(curve.real, omega * curve.imag, color=BLUE, label="H, 0 ≤ ω ≤ 30 rad/s")
    popov, circle = (max_sector("exp(-s)/(s+1)", criterion=name) for name in ("popov", "circle"))
    ax.set(xlabel="Re H", ylabel="ω Im H [1/s]", xlim=(-0.75, 1.05), ylim=(-1.6, 1.2))
    ax.axvline(-1 / circle.largest.low, color=GREY, lw=1.4, label=f"circle: k = {circle.largest.low:.5g}")
    k, y = popov.largest.low, np.array([-1.6, 1.2])
    line = f"Popov: k = {k:.5g}, θ = {popov.theta:.3g} s"
    ax.plot(popov.theta * y - 1 / k, y, color=VERMILLION, ls="--", label=line)
    ax.axhline(0, color=GREY, lw=0.6)
    ax.axvline(0, color=GREY, lw=0.6)
    ax.legend(loc="lower right", fontsize=9)


@figure
def order_cones(ax: Axes) -> None:
    """The six orders of two samples and 0."""
    for row, (corners, order) in enumerate(
        (
            (((1, 0), (1, 1)), "0 < σ₂ < σ₁"),
            (((0, 1), (1, 1)), "0 < σ₁ < σ₂"),
            (((0, 1), (-1, 1), (-1, 0)), "σ₁ < 0 < σ₂"),
            (((-1, 0), (-1, -1)), "σ₁ < σ₂ < 0"),
            (((0, -1), (-1, -1)), "σ₂ < σ₁ < 0"),
            (((0, -1), (1, -1), (1, 0)), "σ₂ < 0 < σ₁"),
        )
    ):
        shape = np.array([(0, 0), *corners])
        ax.fill(*shape.T, color=(BLUE, GREEN, VERMILLION)[row % 3], alpha=0.3, lw=0)
        at = shape[1:].mean(axis=0) * 0.75
        ax.annotate(order, at, ha="center", va="center", fontsize=10)
    ax.plot([-1, 1], [-1, 1], color="black", lw=1)
    ax.axhline(0, color="black", lw=1)
    ax.axvline(0, color="black", lw=1)
    ax.set(xlim=(-1, 1), ylim=(-1, 1), xlabel="σ₁ = σ(t)", ylabel="σ₂ = σ(t + 1)", xticks=[0], yticks=[0], aspect=0.6)


@figure
def several_nonlinearities(ax: Axes) -> None:
    """Pairs of sectors of a loop with two channels: proved, and refuted by constant gains."""
    plant = as_plant([["1/(s+1)^3", "1/(s+2)"], ["-1/(s+3)", "2/(s+1)^3"]])
    for ratio in (
        Fraction(1, 8),
        Fraction(1, 4),
        Fraction(1, 2),
        Fraction(3, 4),
        Fraction(1),
        Fraction(2),
        Fraction(4),
    ):
        found = max_sector(plant, [Sector(0, 1), Sector(0, ratio)])
        proved, share = found.largest.low, float(ratio)
        ax.fill_between([0, proved], 0, share * proved, color="#bfe6da", lw=0)
        ax.plot(proved, share * proved, "o", color=GREEN, ms=6)
        ax.plot(found.refuted_at, share * found.refuted_at, "x", color=VERMILLION, ms=9, mew=1.6)
    ax.plot([], [], "o", color=GREEN, label="proved, with all below and left of it")
    ax.plot([], [], "x", color=VERMILLION, mew=1.6, label="refuted by constant gains")
    ax.set(xlabel="k₁", ylabel="k₂", xlim=(0, 9.5), ylim=(0, 6.2))
    ax.legend(loc="upper right", fontsize=9)


@figure
def rod(ax: Axes) -> None:
    """The rod between its dashpot and its obstacle."""
    from matplotlib.patches import Rectangle

    for left, hatch in ((-0.6, "////"), (6.6, "////")):
        ax.add_patch(Rectangle((left, -0.9), 0.3, 1.8, fill=False, hatch=hatch, lw=0, edgecolor=GREY))
    ax.plot([-0.3, -0.3], [-0.9, 0.9], color="black")
    ax.plot([6.6, 6.6], [-0.9, 0.9], color="black")
    ax.plot([-0.3, 0.2], [0, 0], color="black")  # the dashpot: a piston in a cylinder
    ax.plot([0.2, 0.2], [-0.2, 0.2], color="black", lw=2)
    ax.plot([0, 0.55, 0.55, 0], [0.3, 0.3, -0.3, -0.3], color="black")
    ax.plot([0.55, 1], [0, 0], color="black")
    ax.add_patch(Rectangle((1, -0.35), 5, 0.7, facecolor=BLUE, alpha=0.35, edgecolor="black"))
    arrow = {"arrowstyle": "->", "color": VERMILLION, "lw": 1.4}
    ax.annotate("", (4.4, 0.15), (2.6, 0.15), arrowprops=arrow)
    ax.annotate("", (2.6, -0.15), (4.4, -0.15), arrowprops=arrow)
    for x, y, text in (
        (2.3, 0.15, "r₁"), (4.7, -0.15, "r₂"), (1, -0.62, "x = 0"), (6, -0.62, "x = L"),
        (0.5, 0.52, "dashpot k"), (3.5, 0.55, "E, ρ, A"), (6.3, 0.55, "gap"),
    ):  # fmt: skip
        ax.annotate(text, (x, y), ha="center", va="center", fontsize=11)
    ax.annotate(
        "", (6.6, 0.4), (6, 0.4), arrowprops={"arrowstyle": "<->", "color": "black", "shrinkA": 0, "shrinkB": 0}
    )
    ax.annotate(
        "u", (3.1, -0.75), (4.1, -0.75), arrowprops=arrow | {"arrowstyle": "<-", "shrinkA": 6}, fontsize=11, va="center"
    )
    ax.set(xlim=(-0.7, 7), ylim=(-1, 1), aspect="equal")
    ax.set_axis_off()


@figure
def popov_for_the_rod(ax: Axes) -> None:
    """Popov's curve of the rod with ``k = 3 Z``, in units ``d = T = 1``: it returns to the same heights for ever."""
    a, omega = 0.5, np.linspace(0.02, 60, 20_000)
    curve = (1 - a * np.exp(-2j * omega)) / (1 + a * np.exp(-2j * omega)) / (1j * omega)
    ax.plot(curve.real, omega * curve.imag, color=BLUE, lw=0.9, label="rod, 0 < ω ≤ 60 rad/T")
    theta, y = 4 * a / (1 - a * a), np.array([-3.3, 1.7])
    ax.plot(theta * y, y, color=VERMILLION, ls="--", label=f"K = ∞, θ = 4|a|T/(1 − a²) = {theta:.3g} T")
    ax.axhline(0, color=GREY, lw=0.6)
    ax.axvline(0, color=GREY, lw=0.6)
    ax.set(xlabel="Re H / (d T)", ylabel="ω Im H / d", xlim=(-1.6, 1.2), ylim=(-3.3, 1.7))
    ax.legend(loc="upper right", fontsize=9)


@figure
def energy_theorem(ax: Axes) -> None:
    """Energy of a rod that strikes the obstacle: it falls only while a wave passes the dashpot."""
    struck = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.2, compliance=0.5, gap=0.5)
    motion = exact_motion(struck, Scenario.parse(velocity=1), until=12)
    t = np.linspace(0, 12, 2401)
    ax.plot(t, motion.energies(t), color=BLUE, label="energy")
    ax.plot(t, struck.nonlinearity.primitive(motion.z(t)), color=VERMILLION, ls="--", label="of it in the obstacle")
    ax.fill_between(
        t,
        0,
        struck.damping * motion.dashpot_velocity(t) ** 2,
        color=GREY,
        alpha=0.4,
        lw=0,
        label="power of the dashpot",
    )
    ax.set(xlabel="t / T", ylabel="energy, and power × T", xlim=(0, 12), ylim=(0, None))
    ax.legend(fontsize=9)


for drawing in channel_figures.DRAWN:
    figure(drawing)


def commands(page: Path) -> list[list[str]]:
    """The commands in the shell blocks of a page, in words."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    lines = "".join(blocks).replace("\\\n", " ").splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("lure ")]


def draw(folder: Path) -> None:
    """Write every figure."""
    from matplotlib.figure import Figure

    folder.mkdir(parents=True, exist_ok=True)
    for words in commands(Path(__file__).parents[1] / "how-to" / "long-runs.md"):
        called = [sys.executable, "-m", "lure.analysis.cli", *words, "--quiet", "--replace"]
        subprocess.run(called, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    for name, drawing in FIGURES.items():
        page = Figure(figsize=(4.6, 3.1), layout="constrained")  # of a size that a phone need not shrink by much
        drawing(page.add_subplot())
        page.savefig(folder / f"{name}.svg", bbox_inches="tight")
