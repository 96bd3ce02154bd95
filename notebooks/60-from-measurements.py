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
# # From measurements to a verdict
#
# Most nonlinearities arrive as a file: somebody pressed something and wrote down displacement and force. This notebook
# goes from such a file to a sector, from the sector to a verdict on a loop, and from a fitted nonlinearity to a rod.
# Each step rests on assumptions, and the last section is about what no measurement can show.
#
# | step | result | what it is worth |
# |---|---|---|
# | file to sector | bounds on $f(\sigma)/\sigma$ and on the slope | observed, with stated confidence |
# | file to nonlinearity | $\varepsilon$, gap, $m$, and a box for all three | observed, with stated confidence |
# | loop to sector | largest sector with a proof | certified |
# | both | does one lie inside the other? | as strong as the weaker: observed |

# %% tags=["hide-input"]
import itertools
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from lure.analysis.measured import (
    EXAMPLE,
    Measurements,
    example_measurements,
    fit_compliance,
    margin_from_data,
    read_measurements,
    report_from_data,
    sector_from_data,
)
from lure.analysis.plots.style import BLUE, GREEN, GREY, VERMILLION
from lure.analysis.rod.conclusion import conclusion
from lure.rod import Rod, Scenario, exact_motion, upwind

lines = EXAMPLE.read_text(encoding="utf-8").splitlines()
print(*lines[:8], "...", sep="\n")

# %% [markdown]
# ## 1. Read it, and look
#
# A rubber pad was pressed by a flat punch of 25 mm² and released again. The units stand in the headings and become SI;
# which column is which is told from them. (The file is made up, as it says itself, by a nonlinearity we know. So we can
# check every answer below, which with your own file you cannot.)

# %%
data = read_measurements(EXAMPLE)
# from the script that made the file
true = {"eps": 2.5e-7, "gap": 0.12e-3, "m": 1.5}
data

# %%
_, ax = plt.subplots(figsize=(4.8, 3.2), layout="constrained")
for direction, colour, marker in (("loading", BLUE, "."), ("unloading", GREEN, "+")):
    rows = data.rows(direction)
    ax.plot(
        1e3 * data.displacement[rows],
        data.load[rows],
        marker,
        color=colour,
        ms=5,
        label=direction,
    )
ax.set(xlabel="displacement [mm]", ylabel="force [N]")
ax.legend()
plt.show()

# %% [markdown]
# ## 2. The sector that holds with 95 % confidence
#
# Behind the scatter we assume one mean nonlinearity $f$ with $f(0) = 0$. `sector_from_data` bounds all its chords
# $f(\sigma)/\sigma$ and all its slopes *at once*: if the assumptions printed below hold, then of a hundred files
# measured like this one about 95 or more give four bounds that are all true.

# %%
found = sector_from_data(data)
found

# %%
found.plot(ax=plt.subplots(figsize=(5, 4.6))[1])
plt.show()

# %% [markdown]
# Three things to read off:
#
# - **The two outliers are named by line**, so you can look at them: something knocked on the table. They are left out.
# - **The slope costs more than the chord.** A chord leans on everything measured since 0, a slope on two knots: the
#   chord bound is 91 kN/m where the truth is 88.7, the slope bound 292 where it is 156. If a sector will do, take it.
# - **The lower bound is negative**, −18.3 kN/m. Rubber does not pull. But a file with noise cannot say that; you can.

# %%
for outlier in found.outliers:
    print(
        f"line {outlier.line}: {lines[outlier.line - 1]}   ({outlier.score:+.1f} "
        "standard deviations)"
    )
depth = 0.8e-3 - true["gap"]
true_chord, true_slope = (
    depth**1.5 / true["eps"] / 0.8e-3,
    1.5 * depth**0.5 / true["eps"],
)

# %% [markdown]
# ## 3. Does it remember?
#
# The criteria of this package are for nonlinearities without memory. `sector_from_data` therefore compares loading with
# unloading, here without finding a difference beyond noise. A pad that gives back 15 % less than it took is another
# matter:

# %%
load = data.load.copy()
load[data.rows("unloading")] *= 0.85
lossy = sector_from_data(Measurements.from_arrays(data.displacement, load))
print("as measured:", found.hysteresis)
print(
    f"with 15 % less on the way back: apart by {100 * lossy.hysteresis.share:.0f} % "
    "of the largest load"
)
loop = ([1e4], [1, 300, 2e4, 0])  # see section 4
print(margin_from_data(lossy, loop, gain=0.005, assume_nonnegative=True))

# %% [markdown]
# ## 4. A verdict for a loop
#
# A positioning stage holds the pad: $H(s) = 10^4/(s(s^2 + 300 s + 2\cdot10^4))$ from $\mu$ to $\sigma$,
# $\mu = -\phi(\sigma)$, and the force is fed back with the gain 0.005 per newton, $\phi = 0.005 f$. The loop has
# a pole at 0 and is stable for no negative gain, so here we assume that the pad never pulls
# (`assume_nonnegative=True`). The answer repeats the assumption.

# %%
verdict = margin_from_data(found, loop, gain=0.005, assume_nonnegative=True)
verdict

# %% [markdown]
# The same without this assumption, and with a gain of 0.007:

# %%
print(margin_from_data(found, loop, gain=0.005))
print()
print(margin_from_data(found, loop, gain=0.007, assume_nonnegative=True))

# %% [markdown]
# The proved sector ends at 600, certified at every frequency; the measured one ends at 455. What connects them is only
# observed, and so is the verdict. "Nothing follows" does not make a loop unstable.
#
# ## 5. The nonlinearity, and a rod that meets it
#
# A sector forgets the shape. If you believe in normal compliance, $p = (u - \mathrm{gap})_+^m/\varepsilon$, fit it.
# The estimates of $\varepsilon$ and $m$ are almost perfectly correlated (−0.999), so one interval for each would
# mislead; the box given holds all three at once. With the area of the punch the load becomes a stress, as a rod
# needs.

# %%
fit = fit_compliance(example_measurements(area=25e-6))
fit

# %%
fit.plot(ax=plt.subplots(figsize=(5, 4.6))[1])
plt.show()

# %% [markdown]
# A nylon rod of 1 m, 25 mm², dashpot 2 N s/m, flies against this pad at 1 m/s. What follows is of two kinds. That it
# comes to rest is *proved*, by the energy theorem of [note 5](notes/0005-energy-theorem.md), for every
# $\varepsilon > 0$, every gap and every $m > 0$: the uncertainty of the fit does not touch it. How hard it hits is
# *computed*, for the fit and for the eight corners of the box, and does depend on them.

# %%
corners = list(
    itertools.product(*(fit.parameters[name].joint for name in ("eps", "gap", "m")))
)
best = tuple(fit.parameters[name].value for name in ("eps", "gap", "m"))


def nylon(eps, gap, m):
    """The rod against a pad with this nonlinearity."""
    return Rod(
        youngs_modulus=3e9,
        density=1150,
        length=1,
        area=25e-6,
        damping=2,
        compliance=eps,
        gap=gap,
        exponent=m,
    )


print(conclusion(upwind(nylon(*best), 10), Scenario()))
until = 6 * nylon(*best).travel_time
motions = [
    exact_motion(nylon(*nonlinearity), Scenario.parse(velocity="1"), until)
    for nonlinearity in (best, *corners)
]
peaks = [motion.impacts[0].peak_stress / 1e6 for motion in motions]
depths = [motion.z(np.linspace(0, until, 2001)).max() * 1e3 for motion in motions]
plateau = nylon(*best).density * nylon(*best).wave_speed / 1e6
print(
    f"peak stress: {peaks[0]:.3f} MPa for the fit; corners {min(peaks[1:]):.3f} to "
    f"{max(peaks[1:]):.3f} MPa"
)
print(f"rho c v = {plateau:.3f} MPa; depths reached: up to {max(depths):.2f} mm")

# %% [markdown]
# Nine solutions are no bound for the box. There is a bound, $\rho c v$: with a dashpot below the
# impedance of the rod no impact ever exceeds it, for any nonlinearity that pushes the harder the deeper (the [notebook
# on the dashpot](70-designing-the-dashpot.py) says why). And look at the depths: the pad was measured down to 0.68 mm
# below its surface. Deeper than that the nonlinearity would be a guess; here it was not needed.
#
# ## 6. What measuring cannot show
#
# **Outside the range.** Nothing was measured beyond 0.8 mm. The fitted nonlinearity grows like $\sigma^{3/2}$ and would
# leave the proved sector of section 4 at a depth that can be computed; a theorem about all $\sigma$ needs the sector
# there too, or an argument that the solution never gets there. Neither is in the file.
#
# **Between the readings.** They are 5 µm apart. The nonlinearity drawn below agrees with the fit at each of the 241
# displacements, and therefore with the file; its chord is far outside. Only a constant that *you* state excludes
# it: if $|f(x) - f(y)| \le \Lambda|x - y|$, then between readings $h$ apart, of which the left one is at $x$, no chord
# exceeds $U + (U + \Lambda)h/(2x)$, where $U$ bounds those at the readings.

# %%
nonlinearity = fit_compliance(data)
sigma = np.linspace(0, 1.6e-3, 32001)[1:]
limit = float(verdict.proved.largest.low) / 0.005  # N/m
leaves = sigma[np.argmax(nonlinearity(sigma) / sigma > limit)]
tooth = nonlinearity(sigma) + 60 * np.maximum(
    1 - np.abs(sigma - 0.4025e-3) / 2e-6, 0
)
at_readings = np.interp(
    data.displacement, sigma, tooth - nonlinearity(sigma), left=0
)
stated, left = found.slope_upper.bound, 0.2e-3
allowance = (found.upper.bound + stated) * 5e-6 / (2 * left)

_, ax = plt.subplots(figsize=(4.8, 3.2), layout="constrained")
ax.axvspan(0.8, 1.6, color=GREY, alpha=0.2, lw=0, label="not measured")
ax.plot(
    1e3 * sigma,
    tooth / sigma / 1e3,
    color=VERMILLION,
    lw=1.0,
    label="agrees at every reading",
)
ax.plot(
    1e3 * sigma,
    nonlinearity(sigma) / sigma / 1e3,
    color=BLUE,
    lw=1.6,
    label="fitted nonlinearity",
)
ax.axhline(limit / 1e3, color=GREEN, ls="--", lw=1.3, label="proved up to here")
ax.set(xlabel="σ [mm]", ylabel="chord f(σ)/σ [kN/m]", xlim=(0, 1.6), ylim=(0, 220))
ax.legend(loc="lower right")
plt.show()
print(f"the fitted nonlinearity leaves the proved sector at {1e3 * leaves:.2f} mm")
print(
    f"if you state {stated / 1e3:.0f} kN/m: at most {allowance / 1e3:.1f} "
    "kN/m more, beyond 0.2 mm"
)

# %% [markdown]
# **One specimen, one speed, one day.** Temperature, rate, wear and the next pad from the box are not in the file
# either. Confidence is about scatter.
#
# ## 7. Your own file
#
# Comments after `#` or `%`, headings with units, tabs, decimal commas, columns you do not need: all of that is read.
# What cannot be told is refused in a sentence. The same from a shell: `lure sector mine.txt --fit --plot mine.svg`.

# %%
random = np.random.default_rng(3)
depth_um = np.linspace(0, 60, 90)
force_mn = 0.4 * np.maximum(depth_um - 10, 0) + random.normal(scale=0.15, size=90)
rows = [
    f"{u:.2f}\t{f:.3f}".replace(".", ",")
    for u, f in zip(depth_um, force_mn, strict=True)
]
with tempfile.TemporaryDirectory() as folder:
    mine = Path(folder) / "mine.txt"
    mine.write_text(
        "\n".join(
            [
                "# spring 7, room temperature",
                "% second try",
                "depth [µm]\tforce [mN]",
                *rows,
            ]
        )
    )
    own = report_from_data(mine, fit=True)
own.sector

# %%
own.fit

# %% [markdown]
# ## What this notebook claims

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
assert len(data) == 241
assert [outlier.line for outlier in found.outliers] == [63, 176]
assert (found.hysteresis, found.confidence, str(found.evidence)) == (
    None,
    0.95,
    "observed",
)
assert round(found.upper.bound, -3) == 91e3
assert round(found.slope_upper.bound, -3) == 292e3
assert (round(true_chord, -2), round(true_slope, -3)) == (88.7e3, 156e3)
assert found.lower.bound < 0 < true_chord < found.upper.bound
assert found.slope_lower.bound < 0 < true_slope < found.slope_upper.bound
assert round(found.lower.bound, -2) == -18.3e3
assert lossy.hysteresis is not None
assert not margin_from_data(lossy, loop, gain=0.005, assume_nonnegative=True).inside
assert verdict.inside
assert str(verdict.evidence) == "observed"
assert 599.9 < verdict.proved.largest.low <= 600
assert round(float(verdict.sector.upper)) == 455
assert not margin_from_data(found, loop, gain=0.005).inside
assert not margin_from_data(found, loop, gain=0.007, assume_nonnegative=True).inside
assert round(fit.correlation[0, 2], 3) == -0.999
# per pascal, not per newton
for name, value in (true | {"eps": true["eps"] * 25e-6}).items():
    low, high = fit.parameters[name].joint
    assert low < value < high
assert fit.misfit > 0.05
assert str(conclusion(upwind(nylon(*best), 10), Scenario()).verdict) == "PROVED"
assert len(corners) == 8
assert max(peaks) < plateau
assert max(motion.energy_residual for motion in motions) < 1e-12
assert max(depths) < 0.68
assert np.all(np.diff(np.unique(data.displacement)) < 5.1e-6)
assert max(abs(at_readings)) < 1e-9
assert max(tooth / sigma) > 1.5 * limit
assert 0.8e-3 < leaves < 1.6e-3
assert allowance < limit - found.upper.bound
assert own.measurements.unit == "N"
assert (
    own.fit.parameters["gap"].joint[0] < 10e-6 < own.fit.parameters["gap"].joint[1]
)
assert own.fit.parameters["m"].joint[0] < 1 < own.fit.parameters["m"].joint[1]
assert own.sector.lower.bound < 0 < own.sector.upper.bound < 500
