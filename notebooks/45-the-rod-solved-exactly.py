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
# # The rod, solved exactly
#
# Between its ends an elastic rod does nothing: two waves run through each other unchanged. All that happens, happens
# at $x = 0$ and $x = L$, and what happens at $x = L$ returns there $2T = 2L/c$ later. So the partial differential
# equation is a scalar equation with a delay, for the wave $W$ that arrives at the contacting end,
#
# $$W(t) = -a\,V(t - 2T) + 2b\,g(t - T),$$
#
# $$z' = W - d\,p(z), \qquad V = W - 2d\,p(z),$$
#
# and `lure.rod.motion` solves it round trip by round trip: no grid, no time step. [Note 10](notes/0010-exact-motion.md)
# says how. Here we use it: to see what a grid adds to the paper's rod, and then for contact, where grids do worst.

# %% tags=["hide-input"]
from fractions import Fraction
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    VERMILLION,
    finish_axes,
)
from lure.analysis.rod.comparison import compare, integrate
from lure.analysis.rod.plots.comparison import plot_comparison
from lure.analysis.rod.plots.motion import (
    plot_assembly_contacts,
    plot_assembly_ends,
)
from lure.analysis.rod.plots.response import plot_history, plot_poincare
from lure.analysis.rod.response import Plan, response
from lure.rod import Rod, Scenario, builtin_system, upwind
from lure.rod.assembly import RodAssembly
from lure.rod.assembly_motion import assembly_motion
from lure.rod.motion import Boundary, Numerics, exact_motion

system = builtin_system("paper-rod")
rod = system.rod
T, a, Z = rod.travel_time, rod.reflection, rod.impedance
COLOURS = {10: VERMILLION, 50: GREEN, 200: PURPLE}


def changed(**parameters):
    """The paper's rod with other parameters, all of them exact numbers."""
    return Rod(**{**rod.exact, **parameters})


def wall(eps, **parameters):
    """The rod a millimetre before an obstacle of this compliance [m/Pa]."""
    return changed(gap=Fraction(1, 1000), compliance=eps, **parameters)


def line(ax, x, y, colour, name, **style):
    """A curve, with its name for the legend."""
    ax.plot(x, y, color=colour, label=name, **{"lw": 1.2, **style})


def panels(count):
    """Axes side by side."""
    _, axes = plt.subplots(
        1,
        count,
        figsize=(max(5.8, 4.7 * count), 3.5),
        layout="constrained",
        squeeze=False,
    )
    return axes[0]


def label(ax, x, y, **limits):
    """Name the axes, and draw the legend if there is anything to tell apart."""
    ax.set(xlabel=x, ylabel=y, **limits)
    finish_axes(ax)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small", framealpha=0.85)


# %% [markdown]
# ## 1. The released rod
#
# Compressed by $2\cdot10^{-4}$ and let go, with the obstacle out of reach. Every round trip multiplies the wave by
# $-a = 0.99967$, so that with $e = 2\cdot 10^{-4}$ m
#
# $$u(2nT, L) = \tfrac e2 - e\,(-a)^n,$$
#
# $$u((2n+1)T, L) = \tfrac e2,$$
#
# straight lines in between: a triangle that shrinks by one part in three thousand each time, always from the same
# turning point. A thousand round trips:

# %%
free = exact_motion(rod, system.scenario, 2000 * T)
n = np.arange(1000)
at_even = free.end_displacement(2 * n * T) - (1e-4 - 2e-4 * (-a) ** n)
at_odd = free.end_displacement((2 * n + 1) * T) - 1e-4
off = max(abs(at_even).max(), abs(at_odd).max()) / 1e-4
print(
    f"largest distance from the closed form over {len(n)} round trips: {off:.1e} of "
    "the amplitude"
)

# %% [markdown]
# Now the same release as the paper computed it, by the first-order upwind scheme, with its ten cells, with 50 and with
# 200, beside the exact motion. The scheme is integrated event to event without a time step, so that what you see below
# is the grid's doing and nobody else's. For comparison a Galerkin model in the weak form of the paper's section 3.

# %%
found = compare(
    rod, system.scenario, 2.5e-3, cells=(10, 50, 200), galerkin=(("P1", 51),)
)
print(found)

# %%
_, axes = plt.subplots(figsize=(8.4, 6.0))
plot_comparison(found, ax=axes)
plt.show()

# %% [markdown]
# The paper reads a settling time of 1.11 ms off its figures 6 and 7. At that time 2.54 % of the ringing is left with
# ten cells, 40.6 % with 50, 70.1 % with 200, and 99.88 % in the rod. The table of decay rates says why: the rod loses
# all its modes at the same 1.0 per second, the scheme loses the first one at 2940, 593 and 149 per second, nearly in
# proportion to $1/N$. What settled was the grid.
#
# Energy tells it most plainly. The rod has one place to lose it, the dashpot, which takes half a percent in these
# 2.5 ms. Ten cells lose all but $3.5\cdot10^{-7}$ of it.

# %%
times = np.linspace(0, 2.5e-3, 301)
schemes = {
    N: integrate(
        upwind(rod, N), system.scenario, 2.5e-3, method="exact", samples=301
    )
    for N in COLOURS
}
exact_energy = free.energies(times)
(axes,) = panels(1)
line(axes, times, exact_energy / exact_energy[0], BLUE, "the rod", lw=1.6)
for N, run in schemes.items():
    line(axes, times, run.energy / run.energy[0], COLOURS[N], f"scheme, N = {N}")
label(
    axes, "t [s]", "energy, as a share of the first", xlim=(0, 2.5e-3), ylim=(0, 1.5)
)
plt.show()

# %%
shares = {row.method: row.left for row in found.settling}
assert round(-a, 5) == 0.99967
assert off < 1e-12
left_over = [f"{shares[f'scheme, N = {N}']:.1%}" for N in (10, 50, 200)]
assert left_over == ["2.5%", "40.6%", "70.1%"]
assert f"{shares['scheme, N = 10']:.2%}" == "2.54%"
assert f"{shares['exact']:.2%}" == "99.88%"
decays = [f"{row.decay[0]:.3g}" for row in found.rows[:3]]
assert decays == ["2.94e+03", "593", "149"]
assert all(abs(rate - 1) < 1e-3 for rate in found.decay)
assert f"{exact_energy[-1] / exact_energy[0]:.3f}" == "0.995"
assert f"{found.rows[0].energy_end / exact_energy[0]:.1e}" == "3.5e-07"
assert np.all(np.diff(exact_energy) <= 1e-15 * exact_energy[0])

# %% [markdown]
# ## 2. A bar hits a wall
#
# The oldest problem of impact: a free bar flies against an obstacle at $V = 1$ m/s. From the contact a wave of stress
# $\rho c V = 48$ kPa runs to the free end, comes back as relief, and the bar leaves after one round trip, $2T$,
# at full speed; the impulse is $2MV = 4\cdot10^{-4}$ N s, with $M = \rho A L$. Here is the paper's rod (its dashpot is
# almost nothing) against a rigid obstacle a millimetre away, and against one with $\varepsilon = 10^{-10}$ m/Pa: on
# that one the static stress $\rho c V$ would press in 4.8 µm.

# %%
V, bar = 1.0, wall(Fraction(1, 10**10))
thrown = Scenario.parse(velocity="1")
stiff = exact_motion(bar, thrown, 2e-3)
rigid = exact_motion(bar, thrown, 2e-3, boundary=Boundary(rigid=True))
for name, motion in (("rigid", rigid), ("1e-10", stiff)):
    (hit,) = motion.impacts
    print(
        f"eps = {name}: contact at {hit.start:.7f} s for "
        f"{(hit.end - hit.start) / (2 * T):.5f} round trips, impulse"
    )
    print(
        f"{hit.impulse:.5e} N s, up to {hit.peak_stress:.1f} Pa, leaves at "
        f"{motion.end_velocity(2e-3):.5f} m/s"
    )

# %% [markdown]
# What is missing from 48 000 Pa and from $4\cdot10^{-4}$ N s went to the dashpot. The obstacle returns all the
# energy it takes, and no coefficient of restitution was put in: 0.2 % of the speed is lost, to the dashpot.
#
# The scheme meets the same stiff obstacle without difficulty, stays on it for nearly the right time, and is thrown back
# as a different body.

# %%
contact = np.linspace(0.95e-3, 1.45e-3, 2001)
hits = {
    N: integrate(upwind(bar, N), thrown, 2e-3, method="exact", samples=8001)
    for N in COLOURS
}
left, right = panels(2)
line(
    left, contact, rigid.contact_stress(contact), GREY, "rod, rigid obstacle", lw=2.6
)
line(
    left, contact, stiff.contact_stress(contact), BLUE, "rod, ε = 1e-10 m/Pa", lw=1.4
)
energies = np.linspace(0, 2e-3, 401)
line(right, energies, stiff.energies(energies) * 1e4, BLUE, "the rod", lw=1.6)
for N, run in hits.items():
    stress, name = np.maximum(run.z, 0) * 1e10, f"scheme, N = {N}"
    line(left, run.t, stress, COLOURS[N], f"{name}, the same ε", lw=1.0)
    line(right, run.t, run.energy * 1e4, COLOURS[N], name)
shown = {"xlim": (contact[0], contact[-1])}
label(left, "t [s]", "contact stress [Pa]", ylim=(-2e3, 9.2e4), **shown)
label(right, "t [s]", "energy [10⁻⁴ J]", xlim=(0, 2e-3), ylim=(0, 1.05))
plt.show()
after = {N: run.energy[-1] / run.energy[0] for N, run in hits.items()}
kept = stiff.energy(2e-3) / stiff.energy(0)
print(
    f"energy left at 2 ms: rod {kept:.4f};",
    ", ".join(f"N = {N} {share:.4f}" for N, share in after.items()),
)

# %% [markdown]
# In these two milliseconds, with one impact, the rod loses 0.4 % of its energy, all through the dashpot. The scheme
# loses 55 % on ten cells, 24 % on 50 and 11 % on 200. An engineer who fits a coefficient of restitution to such a run
# has measured a grid.

# %%
(hit,), (soft,) = rigid.impacts, stiff.impacts
assert abs(rod.density * rod.wave_speed * V - 48000) < 1e-6
assert abs((hit.end - hit.start) / (2 * T) - 1) < 1e-10
assert abs(hit.peak_stress / 48000 - 0.999) < 1e-4
assert abs(hit.impulse / 4e-4 - 0.9988) < 1e-4
assert abs(stiff.end_velocity(2e-3) + 0.998) < 1e-4
assert abs(rod.density * rod.wave_speed * V * 1e-10 - 4.8e-6) < 1e-12
assert [round(after[N], 2) for N in (10, 50, 200)] == [0.45, 0.76, 0.89]
assert round(kept, 3) == 0.996
assert max(stiff.energy_residual, rigid.energy_residual) < 1e-14

# %% [markdown]
# ## 3. The rigid limit
#
# Signorini's obstacle, $z \le 0$, $p \ge 0$, $zp = 0$, is the limit $\varepsilon \to 0$ of normal compliance. On a
# compliant obstacle $z' = W - (d/\varepsilon)\,z$ forgets within $\varepsilon/d$; both the penetration and that time
# are proportional to $\varepsilon$, and so should be the distance of the two motions.

# %%
epsilons = [Fraction(1, 10**j) for j in range(9, 15)]
instants = np.linspace(0, 2e-3, 4001)
distance, later = [], []
for eps in epsilons:
    motion = exact_motion(wall(eps), thrown, 2e-3)
    distance.append(abs(motion.z(instants) - rigid.z(instants)).max())
    later.append(motion.impacts[0].end - hit.end)
rates = np.diff(np.log10(distance)) / -1.0
print("eps [m/Pa]   distance from the rigid motion   release later by")
for row in zip(map(float, epsilons), distance, later, strict=True):
    print("{:10.0e} {:30.4e} m {:16.4e} s".format(*row))

# %%
left, right = panels(2)
left.set(xscale="log", yscale="log")
softness = list(map(float, epsilons))
line(left, softness, distance, BLUE, "largest distance", marker="o", ms=4)
line(left, [1e-14, 1e-9], [1e-9, 1e-4], GREY, "first order", lw=1.0, ls="--")
label(left, "ε [m/Pa]", "max |z − z of the rigid obstacle| [m]")
for eps, colour in (
    (Fraction(1, 10**9), VERMILLION),
    (Fraction(1, 3 * 10**9), PURPLE),
    (Fraction(1, 10**10), BLUE),
):
    stress = exact_motion(wall(eps), thrown, 2e-3).contact_stress(contact)
    line(right, contact, stress, colour, f"ε = {float(eps):.2g} m/Pa")
line(right, contact, rigid.contact_stress(contact), GREY, "rigid", lw=2.0, ls="--")
label(right, "t [s]", "contact stress [Pa]", ylim=(-2e3, 6.8e4), **shown)
plt.show()

# %% [markdown]
# The observed order is one, over five decades: at $\varepsilon = 10^{-14}$ the two motions differ by a nanometre.
# An explicit solver with a time step would need steps below $\varepsilon/d$, here $5\cdot10^{-10}$ s.

# %%
assert all(abs(rate - 1) < 2e-3 for rate in rates)
assert 0.9e-9 < distance[-1] < 1.1e-9
assert f"{1e-14 / rod.mobility:.1e}" == "4.8e-10"

# %% [markdown]
# ## 4. Other nonlinearities
#
# $p = c_n\,z_+^m$ with $m \ne 1$ is no linear equation any more; it is solved by collocation on pieces of adapted
# length. Here $c_n$ is chosen such that every nonlinearity reaches 48 kPa at a depth of 10 µm: Hertz's exponent
# 3/2, a linear one, and a hard cubic one.

# %%
nonlinearities, depth = {}, 1e-5
for m in (1, Fraction(3, 2), 3):
    compliance = Fraction(depth ** float(m) / 48000)
    nonlinearities[m] = exact_motion(wall(compliance, exponent=m), thrown, 2e-3)
for ax, title, (start, stop) in zip(
    panels(2), ("touching", "leaving"), ((0.99, 1.06), (1.325, 1.365)), strict=True
):
    window = np.linspace(start * 1e-3, stop * 1e-3, 801)
    for (m, motion), colour in zip(
        nonlinearities.items(), (BLUE, GREEN, VERMILLION), strict=True
    ):
        line(ax, window * 1e3, motion.contact_stress(window), colour, f"m = {m}")
    label(
        ax, "t [ms]", "contact stress [Pa]", xlim=(start, stop), ylim=(-2e3, 5.2e4)
    )
    ax.set_title(title, fontsize="medium")
plt.show()
print("  m   round trips   deepest [µm]   impulse [N s]   energy balance off")
for m, motion in nonlinearities.items():
    (found_hit,) = motion.impacts
    print(
        f"{m!s:>3} {(found_hit.end - found_hit.start) / (2 * T):13.4f} "
        f"{motion.z(contact).max() * 1e6:15.4f} "
        f"{found_hit.impulse:15.5e} {motion.energy_residual:17.0e}"
    )

# %% [markdown]
# All arrive at the plateau $\rho c V$ and hold it until the relief comes: while the wave that arrives is constant, $p$
# tends to $W/d$ whatever the nonlinearity. What differs is how they rise and how they let go.

# %%
for motion in nonlinearities.values():
    (found_hit,) = motion.impacts
    assert abs(motion.z(contact).max() - 1e-5) < 1.2e-8
    assert abs(found_hit.peak_stress - hit.peak_stress) < 1e-3 * hit.peak_stress
    assert abs(found_hit.impulse - hit.impulse) < 2e-2 * hit.impulse
    assert motion.energy_residual < 1e-10

# %% [markdown]
# ## 5. The ends of the rod
#
# $k$ of the dashpot is one number between nothing and everything. Without it ($k = 0$) the released rod rings for ever;
# with $k = Z$ every wave leaves, and after two transits the rod is at rest, not nearly but exactly; clamped
# ($k = \infty$) it rings for ever again, with twice the period. A dashpot at $x = L$ as well (the $h_1$ of the paper's
# (2)) swallows the other wave at the same time: with $Z$ at both ends the rod is at rest after one transit.

# %%
release = system.scenario
matched = Fraction(6, 5)  # Z
cases = {
    "k = 0": (changed(damping=0), Boundary()),
    "k = Z/10": (changed(damping=matched / 10), Boundary()),
    "k = Z": (changed(damping=matched), Boundary()),
    "k = Z at both ends": (changed(damping=matched), Boundary(end_damping=1.2)),
    "clamped": (rod, Boundary(clamped=True)),
}
ends = {
    name: exact_motion(damped, release, 8 * T, boundary=boundary)
    for name, (damped, boundary) in cases.items()
}
left, right = panels(2)
grid = np.linspace(0, 8 * T, 801)
for (name, motion), colour in zip(
    ends.items(), (GREY, PURPLE, BLUE, GREEN, VERMILLION), strict=True
):
    width = 3.5 if name == "k = 0" else 1.3  # it shows behind the clamped one
    line(left, grid / T, motion.end_displacement(grid) * 1e4, colour, name, lw=width)
    line(right, grid / T, motion.energies(grid) * 1e4, colour, name, lw=width)
label(left, "t/T", "u(t, L) [10⁻⁴ m]", xlim=(0, 8), ylim=(-1.3, 5.4))
label(right, "t/T", "energy [10⁻⁴ J]", xlim=(0, 8), ylim=(-0.05, 1.6))
plt.show()
print("energy [J] at              0           T          2T          8T")
for name, motion in ends.items():
    print(
        f"{name:18}" + "".join(f"{motion.energy(i * T):12.4e}" for i in (0, 1, 2, 8))
    )

# %%
whole = rod.area * rod.youngs_modulus * (2e-4) ** 2 * rod.length / 2
assert all(abs(motion.energy(0) / whole - 1) < 1e-12 for motion in ends.values())
for name in ("k = 0", "clamped"):
    assert abs(ends[name].energy(8 * T) / whole - 1) < 1e-12
assert ends["k = Z"].energy(2 * T) == 0.0
assert ends["k = Z"].end_velocity(3 * T) == 0.0
assert ends["k = Z at both ends"].energy(1.5 * T) == 0.0
for name, period in (("clamped", 4 * T), ("k = 0", 2 * T)):
    at_end = ends[name].end_displacement
    assert np.allclose(at_end(period), at_end(0), rtol=1e-12)

# %% [markdown]
# ## 6. Bouncing
#
# Press the bar towards the obstacle with a constant force, 0.02 N at $x = 0$ (on its 0.2 g, an acceleration of
# 100 m/s²), and let it fall from 1 mm. It bounces. Each impact leaves waves in the bar, and the next one
# finds them there: the ratio of one rebound to the last is no constant of the material, and late impacts can be
# stronger than earlier ones. With a dashpot of 0.05 N s/m the bar stays on the obstacle from the 35th contact on, as
# far as we follow it, and settles at $z = \varepsilon g/A$. The solver lists every impact.

# %%
bouncing = wall(Fraction(1, 10**10), damping=Fraction(1, 20))
weight = Scenario.parse(force="0.02")
bounce = exact_motion(bouncing, weight, 0.05)
left, right = panels(2)
fall = np.linspace(0, 0.05, 8001)
line(left, fall, bounce.z(fall) * 1e3, BLUE, "z", lw=0.9)
left.axhline(0, color=VERMILLION, lw=1.0, label="obstacle")
label(left, "t [s]", "z [mm]", xlim=(0, 0.05))
done = [impact for impact in bounce.impacts if impact.closed]
struck = [(impact.start, impact.impulse) for impact in done]
right.semilogy(*zip(*struck, strict=True), "o", ms=3.5, color=BLUE)
label(right, "t [s]", "impulse of the impact [N s]", xlim=(0, 0.05))
plt.show()
for impact in bounce.impacts[:6]:
    print(
        f"t = {impact.start:.6f} s: {(impact.end - impact.start) / (2 * T):.4f} "
        f"round trips, {impact.impulse:.4e} N s, "
        f"up to {impact.peak_stress:.0f} Pa"
    )
last = bounce.impacts[-1]
print(
    f"{len(bounce.impacts)} contacts; the last from {last.start:.5f} s on, z = "
    f"{bounce.z(0.05):.3e} m"
)

# %% [markdown]
# The momentum balance agrees: what the force has given, $gt$, went into the impacts and into the dashpot,
# $k\,u(t, 0)$, but for what the bar still has.

# %%
given, taken = 0.02 * 0.05, sum(impact.impulse for impact in bounce.impacts)
held = 0.05 * bounce.displacement(0.05, np.array([0.0]))[0]
print(
    f"given {given:.5e} N s, to the obstacle {taken:.5e}, to the dashpot "
    f"{held:.5e}, left {given - taken - held:.1e}"
)
assert len(bounce.impacts) == 35
assert not last.closed
assert abs(bounce.z(0.05) / (1e-10 * 0.02 / rod.area) - 1) < 0.01
assert abs(given - taken - held) < 1e-8
ratios = [second.impulse / first.impulse for first, second in pairwise(done[:5])]
assert [round(ratio, 2) for ratio in ratios] == [0.65, 0.73, 0.78, 0.82]
assert max(impact.impulse for impact in done[20:]) > min(
    impact.impulse for impact in done[:20]
)

# %% [markdown]
# ## 7. Long runs
#
# Nothing of a motion is needed but its last round trip. `Numerics(keep=2)` keeps two, and `on_window` sees each one
# before it is dropped: memory does not grow with time. Two seconds of the paper's figure 8, with the force corrected to
# $3.33\cdot10^{-5}$ N, are 6000 round trips, and one contact that lasts to the end.

# %%
deepest = []


def watch(window):
    """The largest contact coordinate at the Chebyshev points of one round trip."""
    deepest.append(
        np.polynomial.chebyshev.chebval(
            np.cos(np.linspace(0, np.pi, 9)), window.z.T
        ).max()
    )


figure_8 = Scenario.parse(force="(2/60000)*sin(4*t)")
streamed = exact_motion(
    rod, figure_8, 2.0, numerics=Numerics(keep=2, on_window=watch)
)
(axes,) = panels(1)
begun = 2 * T * np.arange(len(deepest))
line(axes, begun, deepest, BLUE, "z, largest in each round trip")
axes.axhline(0, color=VERMILLION, lw=1.0, label="obstacle")
label(axes, "t [s]", "z [m]", xlim=(0, 2))
plt.show()
(rest,) = streamed.impacts
print(
    f"{len(deepest)} round trips, kept from {streamed.since:.6f} s on; contact from "
    f"{rest.start:.9f} s on"
)

# %% [markdown]
# For the steady response of a rod that is pressed and shaken there is `lure.analysis.rod.response`: it waits until
# the rod has
# forgotten its start, then watches. This bar, in units in which $E = \rho = A = L = 1$, under $0.3 + 0.7\sin(t/2)$,
# repeats only after two periods of the force.

# %%
ones = dict.fromkeys(("youngs_modulus", "density", "length", "area"), 1)
unit = Rod(**ones, damping=Fraction(1, 5), compliance=Fraction(1, 100))
seen = response(unit, "0.3 + 0.7*sin(t/2)", plan=Plan(settle=1500, run=24))
print(seen)
left, right = panels(2)
plot_history(seen, ax=left)
plot_poincare(seen, ax=right)
plt.show()

# %% [markdown]
# That is one motion from one start. Another start may lead to another motion, a longer watch may show a longer period,
# and a motion that was not seen to repeat would not thereby be chaotic.

# %%
assert len(deepest) == 6000
assert f"{2 / 60000:.2e}" == "3.33e-05"
assert not rest.closed
assert streamed.until - streamed.since < 4.1 * T
assert streamed.energy_residual < 1e-10
assert (seen.regime.kind, seen.regime.multiple) == ("periodic", 2)
assert abs(seen.balance.contact / seen.balance.force - 1) < 1e-9

# %% [markdown]
# ## 8. Two bars that meet
#
# Several contacts have a solver of their own, by the same waves: contact at both ends of a rod, two rods across a gap,
# some against one obstacle (`lure.rod.assembly_motion`). The oldest problem of this kind is that of Saint-Venant: a bar
# is thrown at an equal one that rests. The force is $Z v/2$ for as long as a wave takes to the far end and back, and
# then the bars have exchanged their velocities. With dashpots that are almost none, and a stiff contact:

# %%
bar = Rod(**ones, damping="Z/1000", compliance=1)
contact = {"compliances": (Fraction(1, 1000),), "gaps": (Fraction(1, 2),)}
pair = RodAssembly(arrangement="across-gap", rods=(bar, bar), **contact)
met = assembly_motion(pair, (Scenario.parse(velocity=1), Scenario()), until=4)
print(met)
left, right = panels(2)
plot_assembly_ends(met, ax=left)
plot_assembly_contacts(met, ax=right)
plt.show()

# %% [markdown]
# Both coordinates point to the gap, so the second bar moves to negative $u$. The contact is $10^{-3}$ longer than two
# passages: a soft one lets go late.

# %%
(impact,) = met.contacts[0]
assert abs(impact.start - 0.5) < 1e-12
assert abs(impact.end - 2.5) < 2e-3
assert abs(impact.peak_stress - 0.5) < 1e-12
assert abs(impact.impulse - 1) < 2e-3
velocities = [
    float(wave.sum() / 2)
    for wave in np.array([met.waves(j, 3.5, 0.5) for j in (0, 1)])
]
assert abs(velocities[0]) < 2e-3
assert abs(velocities[1] + 1) < 6e-3
assert met.energy_residual < 1e-12

# %% [markdown]
# ## 9. How do we know?
#
# "Exact" means: no error of a grid. There is rounding, there is the error of Chebyshev series where a solution is no
# polynomial, and the solver estimates the latter; it does not prove a bound. Three things speak for the numbers, and
# each can fail. Closed forms, as above. The energy balance, which no step of the solution uses: what the waves bring to
# the end is what the obstacle stores and what is lost. And a second computation with series of another degree. For the
# bar of section 6, where one impact follows from another:

# %%
degrees = (12, 16, 24)
motions = {
    degree: exact_motion(bouncing, weight, 0.05, numerics=Numerics(degree=degree))
    for degree in degrees
}
apart = {
    degree: abs(motion.z(fall) - motions[24].z(fall)).max()
    for degree, motion in motions.items()
}
print("degree   contacts   energy balance off   local errors   from degree 24")
for degree, motion in motions.items():
    row = (degree, len(motion.impacts), motion.energy_residual, motion.error)
    print("{:6} {:10} {:20.0e} {:15.0e} m {:14.0e} m".format(*row, apart[degree]))

# %% [markdown]
# Millimetres, on which the three agree to within a tenth of a picometre, and three times 35 contacts. That is evidence
# of the kind COMPUTED, for this motion. About other motions it says nothing, and CERTIFIED it is not; what is proved
# about every motion of the rod stands in [note 5](notes/0005-energy-theorem.md), and [notebook
# 42](42-a-rod-and-a-delay-by-hand.py) checks the same for its scheme.

# %%
assert {len(motion.impacts) for motion in motions.values()} == {35}
assert max(apart.values()) < 1e-13
assert max(motion.energy_residual for motion in motions.values()) < 1e-10
assert abs(bounce.z(fall) - motions[24].z(fall)).max() < 1e-12
