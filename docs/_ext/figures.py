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

import numpy as np

from lure import Saturation, SlopeBounds, max_sector, methods
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
    plane(ax, x=(-0.5, 1.5), y=(-0.95, 0.65))
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
    plane(ax, x=(-2.4, 6.4), y=(-4, 4))
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
    ax.set(yticks=range(3), yticklabels=[name for name, _ in reversed(rows)], xlabel="largest slope k", xlim=(0, 1.35))
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
    ax.set(xlabel="ω [rad/s]", ylabel="phase of the multiplier [°]", xlim=(1e-3, 1e3), ylim=(-40, 95))
    ax.legend(loc="upper left", fontsize=9)


@figure
def off_axis_circle(ax: Axes) -> None:
    """A line off the axis through ``-1/k`` on the right of which the curve lies, and the circle criterion's line."""
    block = RationalPlant([1], [1, 3, 3, 1])
    circle, k = circle_largest(block).largest.low, off_axis_largest(block).largest.low
    curve = values(block, OMEGA)
    ax.plot(curve.real, curve.imag, color=BLUE, label="H(iω), ω ≥ 0")
    plane(ax, x=(-0.6, 1.1), y=(-0.9, 0.4))
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
    ax.set(xscale="log", xlabel="ω [rad/s]", ylabel="amplitude of z", ylim=(0, None))
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
        page = Figure(figsize=(5.6, 3.6), layout="constrained")
        drawing(page.add_subplot())
        page.savefig(folder / f"{name}.svg")
