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
# # Several nonlinearities
#
# How large are the sectors that can be proved for a plant with three or four nonlinearities, and what does each
# property that is known of them add? The plant is $\sigma = H\mu$, and $\mu_i = -\phi_i(\sigma_i)$ closes its
# channels. We ask for the largest factor $\alpha$ of the upper bounds: *proved* up to here, *refuted* from there on,
# and between the two nothing was shown.
#
# Both plants are published, with numbers from semidefinite programmes in floating point. Ours are certificates in
# rational numbers that two checkers accept; what is refuted comes with gains that destabilise the loop.

# %% tags=["hide-input"]
import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import expm

from lure import Diagonal, NonlinearityClass, Sector, as_plant, builtin_loop
from lure.analysis import analyse, max_sector, max_slope
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.plots.regions import plot_map
from lure.analysis.plots.style import BLUE, LEGEND, VERMILLION, finish_axes


def rows(text):
    """A matrix from its rows."""
    return [line.split() for line in text.split(";")]


def bars(found, others, title):
    """For each class what is proved, in blue, what is refuted, in red, and what
    others published, as a diamond."""
    last = 1.12 * max(
        [one.refuted_at or one.largest.low for one in found.values()]
        + [*others.values()]
    )
    _, ax = plt.subplots(
        figsize=(8.2, 0.8 + 0.42 * len(found)), layout="constrained"
    )
    for row, (name, one) in enumerate(found.items()):
        ax.barh(
            row,
            one.largest.low,
            color=BLUE,
            height=0.62,
            label="proved" if not row else None,
        )
        if one.refuted_at is not None:
            style = {"color": VERMILLION, "hatch": "///", "edgecolor": "white"}
            start = one.refuted_at
            ax.barh(row, last - start, 0.62, start, label="refuted", **style)
        if name in others:
            ax.plot(
                others[name],
                row,
                "D",
                color="black",
                mfc="white",
                ms=6,
                label="published",
            )
    ax.set_yticks(range(len(found)), found)
    ax.invert_yaxis()
    ax.set_xlim(0, last)
    ax.set_xlabel("factor α of the upper bounds [1]")
    finish_axes(ax)
    handles, labels = ax.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    ax.legend(once.values(), once, loc="upper left", bbox_to_anchor=(1, 1), **LEGEND)
    ax.set_title(title, fontsize=10)
    plt.show()


# %% [markdown]
# The kinds of class, from many members to few. Where nothing depends on time Popov's terms help; slopes bring the
# kernels of Zames and Falb, odd functions kernels of either sign; one function in all channels brings kernels between
# the channels.

# %%
KINDS = {
    "sector, time-varying": (
        NonlinearityClass(sector=Sector(0, 1), time_varying=True),
        False,
    ),
    "sector": (NonlinearityClass(sector=Sector(0, 1)), False),
    "slopes": (NonlinearityClass.slope_restricted(0, 1), False),
    "slopes, odd": (NonlinearityClass.slope_restricted(0, 1, odd=True), False),
    "one with slopes": (NonlinearityClass.slope_restricted(0, 1), True),
    "one, odd, with slopes": (
        NonlinearityClass.slope_restricted(0, 1, odd=True),
        True,
    ),
}


def every_kind(plant):
    """The largest factor for each kind of class."""
    found = {}
    for name, (one, repeated) in KINDS.items():
        ask = max_sector if one.slope is None else max_slope
        found[name] = ask(plant, Diagonal((one,) * plant.inputs, repeated=repeated))
    return found


# %% [markdown]
# ## 1. Three channels
#
# Veenman, Scherer and Köroğlu (2016) sweep this plant in IQClab's demonstration `Demo_006`. Theirs is positive feedback
# $p = \phi(q)$; here $B$ and $D$ have the other sign. $D$ is not zero: channel 3 sees the input of channel 2.

# %%
THREE = as_plant(
    (
        rows("-.4 -1; 1 0"),
        rows(".2 1 .25; 0 0 0"),
        rows("1 0; 0 1; 0 0"),
        rows("0 0 0; 0 0 0; 0 -1 0"),
    )
)
three = every_kind(THREE)
print(three["sector, time-varying"])

# %% [markdown]
# Their sweeps end at 3.7 for three different nonlinearities and at 5.5 for one odd nonlinearity in all channels,
# with kernels whose pole the user picks. The end of a sweep is no bound on what is true, so that the diamonds only
# say how far the sweeps went.

# %%
SWEPT = {"slopes": 3.7, "one, odd, with slopes": 5.5}
bars(three, SWEPT, "Veenman, Scherer, Köroğlu: three channels")

# %% [markdown]
# How much does one multiplier for all channels add where gains depend on time? Diagonal multipliers end at 0.767134;
# the full block was published with 0.798467 at the vertices of the gains, and its orthants show a little more.

# %%
diagonal = max_sector(
    THREE, [KINDS["sector, time-varying"][0]] * 3, criterion="diagonal-circle"
)
print(
    f"diagonal {diagonal.largest.low:.6f}, full block "
    f"{three['sector, time-varying'].largest.low:.6f}"
)

# %% [markdown]
# The hatched bar is for gains that jump. Here they are, a fifth above that factor and a fifth below: after the first
# periods the state grows or decays. The drawing is in floating point; that some solution grows is certified.

# %%
jumps = three["sector, time-varying"].refutation.certificate["proof"]


def number(text):
    """A fraction as a double."""
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or "1")


def switched(share, periods, steps=60):
    """Times and states under the gains of the counterexample times a factor."""
    A, B, C, D = THREE.doubles()
    x, t, times, states = np.array([1.0, 0.0]), 0.0, [0.0], [np.array([1.0, 0.0])]
    for _ in range(periods):
        for gains, length in zip(jumps["gains"], jumps["times"], strict=True):
            G = share * np.diag([number(g) for g in gains])
            step = expm(
                (A - B @ G @ np.linalg.solve(np.eye(3) + D @ G, C))
                * number(length)
                / steps
            )
            for _ in range(steps):
                x, t = step @ x, t + number(length) / steps
                times.append(t)
                states.append(x)
    return np.array(times), np.array(states)


_, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
grown = {}
for share, colour, width in ((1.2, VERMILLION, 1.2), (0.8, BLUE, 1.2)):
    times, states = switched(share, 12)
    # over six periods
    grown[share] = np.linalg.norm(states[-1]) / np.linalg.norm(
        states[len(states) // 2]
    )
    label = f"{share * three['sector, time-varying'].refuted_at:.3f}"
    left.plot(*states.T, color=colour, lw=width, label=f"α = {label}")
    right.semilogy(
        times,
        np.linalg.norm(states, axis=1),
        color=colour,
        lw=width,
        ls="-" if share > 1 else "--",
    )
left.set_xlabel("$x_1$ [1]")
left.set_ylabel("$x_2$ [1]")
right.set_xlabel("t [s]")
right.set_ylabel("|x| [1]")
for ax in (left, right):
    finish_axes(ax)
left.legend(**LEGEND)
plt.show()

# %% [markdown]
# ## 2. Four channels, and either sign
#
# Example 4.9 of Fetzer and Scherer (2017). With the sign of the paper every criterion ends at 0.523596, and constant
# gains show that there is nothing beyond: the gap is closed. One nonlinearity in all channels is another matter, since
# then only equal gains are members; they are stable up to 0.698325. One that is not odd gives the loop other equilibria
# from 0.681838 on, where the proof ends.

# %%
STATE, OUT = (
    rows("-4 -3 0; 2 0 0; -1 -1 -2"),
    rows("-.1 -.2 1; -1 -.3 .1; -.2 .1 1; .1 -.2 .2"),
)
FOUR = as_plant((STATE, rows("0 -4 -1 -3; -2 0 -3 -1; -1 0 -3 -1"), OUT))
OPPOSITE = as_plant((STATE, rows("0 4 1 3; 2 0 3 1; 1 0 3 1"), OUT))
four, opposite = every_kind(FOUR), every_kind(OPPOSITE)
bars(
    four,
    {name: 0.523596 for name in list(KINDS)[:3]},
    "Fetzer, Scherer: the sign of the paper",
)

# %% [markdown]
# With the opposite sign the criteria differ: 0.670053 with diagonal multipliers, 0.678574 with one for all channels,
# and 0.699833 with Popov's terms $\theta \ge 0$ were published. With finite sectors $\theta$ may have either sign;
# with that Popov's terms close the gap at 0.767662.

# %%
PUBLISHED = {"sector, time-varying": 0.678574, "sector": 0.699833}
bars(opposite, PUBLISHED, "Fetzer, Scherer: the opposite sign")
print(opposite["sector"])

# %% [markdown]
# ## 3. Two channels as a map
#
# With two channels the bounds are a plane. In the built-in loop `secant-ring` $1 + g_1 g_2/(s+1)^3$ decides, so that
# constant gains are stable as long as $g_1 g_2 < 8$; Popov's criterion proves nonlinearities up to that hyperbola. The
# staircase is what was certified, on seven rays.

# %%
ring = analyse(builtin_loop("secant-ring"))
_, ax = plt.subplots(figsize=(5.4, 4.2), layout="constrained")
plot_map(ring.map, ax=ax)
k = np.geomspace(*np.clip(ax.get_xlim(), 0.1, None), 200)
height = ax.get_ylim()
ax.plot(k, 8 / k, color="black", lw=1.2, ls="--", label="$k_1 k_2 = 8$")
ax.set_ylim(height)
ax.legend(**LEGEND)
plt.show()

# %% [markdown]
# ## 4. Networks of ReLUs
#
# Richardson, Turner and Gunn (2023) take eight plants of the literature, close each with one ReLU in all channels and
# ask for the largest factor of the ReLU (their code is called Max-Series-Gain). Their circle criterion is our
# `diagonal-circle`, and their circle-like one, which uses that a ReLU and what is left of it are nonnegative, is
# contained in our `coupled-circle`. The last two columns are the farthest of all criteria and a factor that is refuted.

# %% tags=["hide-input"]
FAST = """-5.8097 -1.7258 -1.3496 -.8882 -.3991 -.2843 -.3009 -.3524; 8 0 0 0 0
0 0 0; 0 2 0 0 0 0 0 0; 0 0 2 0 0 0 0 0; 0 0 0 2 0 0 0 0; 0 0 0 0 1 0 0 0; 0 0 0
0 0 .5 0 0; 0 0 0 0 0 0 .25 0"""
FAST_IN = """-.0697 .1982 -.4746 -.3289; -.4567 .3788 -.2270 .5888; .3737 -.6601
.6961 -.3923; -.7929 -.6439 -.0461 -.2640; .0148 .4926 .5402 .7878; -.5594
-.0041 .2616 .4186; .0385 -.5487 -.5681 .5668; -.1095 .0133 .6951 .7202"""
FAST_OUT = """.5336 -.2416 .4056 .0167 .0115 -.6213 .4604 .1259; .1910 .1106
.3421 -.1956 .2760 .9206 .4323 -.7717; .2772 .2116 -.2094 .4855 .0615 -.3314
-.7378 -.6914; -.6986 -.0247 -.0576 .2415 .3123 .2021 -.0033 -.1274"""
SLOW = """-5.4966 -1.7013 -1.7006 -1.0871 -.3885 -.2560; 8 0 0 0 0 0; 0 2 0 0 0
0; 0 0 2 0 0 0; 0 0 0 2 0 0; 0 0 0 0 .5 0"""
POSITIVE_IN = """.5751 .3840 .0158 .6315; .4514 .6831 .0164 .7176; .0439 .0928
.1901 .6927; .0272 .0353 .5869 .0841; .3127 .6124 .0576 .4544; .0129 .6085 .3676
.4418"""
POSITIVE_OUT = """.3533 .7275 .4508 .2548 .9084 .0784; .1536 .4784 .7159 .8656
.2319 .6408; .6756 .5548 .8928 .2324 .2393 .1909; .6992 .1210 .2731 .8049 .0498
.8439"""
MIXED_IN = """-.1747 .1242 -.1618 -.4348; .1069 -.4609 .3498 .2012; -.2069
-.2954 -.1913 .5389; -.3018 .4648 .6416 .3872; -.3921 -.0244 .4655 -.5162;
-.8676 -.6227 .1863 .2499"""
MIXED_OUT = """-.0874 -.4380 .2355 -.1751 -.3313 -.0954; -.5379 .0904 -.0862
.0422 .0770 -.2257; -.3988 .1378 -.1092 .2767 .1642 -.2763; .0327 -.4871 -.4322
.2185 -.8372 .2476"""


def numbers(text):
    """A matrix of decimals."""
    return np.array(rows(text), dtype=float)


park_in = np.zeros((9, 3))
park_in[[0, 4, 7, 1, 3, 8, 2, 5, 6], [0, 0, 0, 1, 1, 1, 2, 2, 2]] = -1
NETWORKS = {
    "Park (2002) 3": (
        -np.diag([1.0, 4, 6, 2, 9, 8, 3, 10, 12]),
        park_in,
        np.kron(np.eye(3), np.ones(3)),
    ),
    "Drummond (2022) 3": (
        np.diag([-1.0, -10, -100]) + 0.01,
        np.eye(3),
        numbers("0 1 1; 0 0 1; 0 0 1"),
    ),
    "Fetzer (2017) 4.9": (
        numbers("-4 -3 0; 2 0 0; -1 -1 -2"),
        numbers("0 4 1 3; 2 0 3 1; 1 0 3 1"),
        np.array(OUT, dtype=float),
    ),
    "Turner (2015) 22": tuple(map(numbers, (FAST, FAST_IN, FAST_OUT))),
    "Turner (2015) 17": tuple(map(numbers, (SLOW, POSITIVE_IN, POSITIVE_OUT))),
    "Turner (2015) 19": tuple(map(numbers, (SLOW, MIXED_IN, MIXED_OUT))),
    "Turner (2015) 23": (
        numbers(FAST),
        numbers(FAST_IN),
        numbers(FAST_OUT) / 100,
    ),
    "Drummond (2022) 2": (
        np.diag([-1.0, -10, -30, -60, -100]) + 0.1,
        np.eye(5),
        np.ones((5, 5)) - np.eye(5),
    ),
}
COLUMNS = ("diagonal-circle", "coupled-circle", "best")
reached = {}
print(f"{'':18}{'circle':>11}{'like circle':>12}{'best':>12}{'refuted':>12}")
for name, (A, B, C) in NETWORKS.items():
    sides = [
        [[f"{v:.6f}" for v in row] for row in side.tolist()] for side in (A, -B, C)
    ]
    network = as_plant((*sides, np.zeros((B.shape[1],) * 2).tolist()))
    relus = Diagonal((NonlinearityClass.relu(),) * B.shape[1], repeated=True)
    found = [max_sector(network, relus, criterion=each) for each in COLUMNS]
    reached[name] = [one.largest.low for one in found]
    against = found[-1].refuted_at
    shown_against = "-" if against is None else f"{against:.4f}"
    low = "".join(f"{v:12.4f}" for v in reached[name])
    print(f"{name:17}{low}{shown_against:>12}")

# %% [markdown]
# The same as shares of the farthest. What is proved of a factor of a ReLU is proved for that factor alone.

# %% tags=["hide-input"]
_, ax = plt.subplots(figsize=(8.2, 3.8), layout="constrained")
for row, values in enumerate(reached.values()):
    for shift, colour, label, value in zip(
        (-0.2, 0.2),
        ("0.6", BLUE),
        ("circle", "like circle"),
        values[:2],
        strict=True,
    ):
        share = value / values[2]
        ax.barh(row + shift, share, 0.36, color=colour, label=None if row else label)
ax.set_yticks(range(len(reached)), reached)
ax.invert_yaxis()
ax.set_xlim(0, 1.05)
ax.set_xlabel("share of the factor that the farthest criterion proves [1]")
finish_axes(ax)
ax.legend(loc="upper left", bbox_to_anchor=(1, 1), **LEGEND)
plt.show()

# %% [markdown]
# ## The numbers of this notebook
#
# Each is asserted, and the second checker, which shares no code with the first, accepts every certificate.

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
close = np.testing.assert_allclose
close(diagonal.largest.low, 0.767134, atol=1e-6)
close(three["sector, time-varying"].largest.low, 0.79998, atol=1e-4)
close(three["sector, time-varying"].refuted_at, 1.260974, atol=1e-5)
assert three["slopes"].largest.low > 4.3
assert three["slopes, odd"].largest.low > 5.43
assert three["one with slopes"].largest.low > 5.90
assert three["one, odd, with slopes"].largest.low > 9.98
assert all(three[name].largest.low > swept for name, swept in SWEPT.items())
assert grown[1.2] > 1 > grown[0.8]
for name in list(KINDS)[:4]:
    close([four[name].largest.low, four[name].refuted_at], 0.523596, atol=1e-6)
close(
    [four["one with slopes"].largest.low, four["one with slopes"].refuted_at],
    [0.681838, 0.681838],
    atol=1e-4,
)
close(four["one, odd, with slopes"].largest.low, 0.698325, atol=1e-5)
close(opposite["sector, time-varying"].largest.low, 0.678573, atol=1e-5)
close(
    [opposite["sector"].largest.low, opposite["sector"].refuted_at],
    0.767662,
    atol=1e-6,
)
assert all(7.99 < a * b < 8 for a, b in ring.map.proved)
assert all(8 < a * b < 8.01 for a, b in ring.map.refuted)
assert all(
    own[2] >= 0.99 * max(own[:2]) for own in reached.values()
)  # the farthest of all
close(reached["Drummond (2022) 3"], 89.9, atol=0.1)
assert reached["Park (2002) 3"][2] > 10_000
everything = [one for found in (three, four, opposite) for one in found.values()]
shown = [
    side
    for one in everything
    for side in (one.proof, one.refutation)
    if side is not None
]
assert all(recheck(dict(side.certificate)).accepted for side in shown)
print(f"{len(shown)} certificates accepted by both checkers")
