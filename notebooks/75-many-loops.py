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
# # Maps of many loops
#
# One loop has a verdict; a designer wants a map. A *study* names a system, what is varied and what is asked, and
# `sweep` answers every point and keeps the answers as a labelled data set. Here it maps the paper's rod over dashpot,
# compliance and number of cells, and a servo over the tolerances of its parameters.

# %% tags=["hide-input"]
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray

from lure.analysis.plots.studies import planes, values_drawn, verdicts_drawn
from lure.analysis.plots.style import BLUE, LEGEND, VERMILLION, finish_axes
from lure.analysis.sweeps import sweep

folder = Path(tempfile.mkdtemp())


def answered(name, study):
    """Sweep a study into a store of the folder, say what came out, and open it."""
    found = sweep(study, folder / name)
    print(
        f"{found.done} points: {found.proved} PROVED, {found.refuted} REFUTED, "
        f"{found.inconclusive} INCONCLUSIVE"
    )
    return xarray.open_zarr(folder / name, chunks=None)


# %% [markdown]
# ## The paper's rod
#
# By the energy theorem the sign of $k$ alone decides, for the rod and for its scheme with any number of cells $N$,
# and whatever the compliance $\varepsilon$ is: rods with $k > 0$ are PROVED, those with $k < 0$ REFUTED, and
# $k = 0$ is INCONCLUSIVE.

# %%
rods = answered(
    "rods.zarr",
    {
        "system": "paper-rod",
        "ask": "rod",
        "over": {
            "rod.damping": {"from": -0.5, "to": 4.0, "count": 37},
            "rod.compliance": {"from": 1e-6, "to": 10, "count": 3, "spacing": "log"},
            "discretisation.cells": [5, 10, 40],
        },
    },
)
print(
    (rods["verdict"] == rods["scheme_verdict"]).all().item(),
    "- rod and scheme have the same verdict everywhere",
)

# %% [markdown]
# What does differ is how fast the waves decay: the scheme adds damping of its own, the more the fewer cells it has, and
# near $k = Z = 1.2$, where no wave comes back from the dashpot, it misses most of the rod's.

# %%
figure, axes = plt.subplots(figsize=(4.8, 3.4))
at = {"rod.compliance": 1e-6}
axes.plot(
    rods["rod.damping"],
    rods["slowest_decay"].sel(at).isel({"discretisation.cells": 0}),
    color=BLUE,
    label="rod",
)
for cells, style in ((5, ":"), (10, "--"), (40, "-.")):
    decay = rods["scheme_slowest_decay"].sel({**at, "discretisation.cells": cells})
    axes.plot(
        rods["rod.damping"],
        decay,
        style,
        color=VERMILLION,
        label=f"scheme, N = {cells}",
    )
axes.axhline(0, color="grey", lw=0.8)
axes.set(
    xlabel="k [N s/m]",
    ylabel="decay of the slowest wave mode [1/s]",
    ylim=(-4000, 16000),
)
axes.legend(**LEGEND)
finish_axes(axes)
plt.show()

# %% [markdown]
# ## A servo and its tolerances
#
# $H(s) = k/(s\,(s + 1)(s + a))$ with both parameters uncertain. By Routh's test linear gains are stable below
# $a(a + 1)/k$, and Popov's criterion proves the sectors below that.

# %%
(folder / "servo.toml").write_text(
    '[plant]\ntransfer = "k/(s*(s + 1)*(s + a))"\n[plant.parameters]\nk = 1\na = '
    "2\n[class]\nsector = [0, 4]\n"
)
servo = {"system": str(folder / "servo.toml"), "ask": "class", "refine": "boundary"}
servo["over"] = {
    "plant.parameters.a": {"from": 1, "to": 3, "count": 11},
    "plant.parameters.k": {"from": 0.5, "to": 2, "count": 7},
}
points = answered("points.zarr", servo)
refined = [
    xarray.open_zarr(folder / "points.zarr" / "boundary" / str(i), chunks=None)
    for i in (1, 2, 3, 4, 5)
]

# %% [markdown]
# The sector $[0, 4]$ is proved on one side of a curve and refuted on the other; `refine` has put points on it, halving
# five times each step across which the verdict changes.

# %%
figure, axes = plt.subplots(figsize=(4.8, 3.4))
verdicts_drawn(next(planes(points)), refined, ax=axes)
a = np.linspace(1, 2.4)
axes.plot(a, a * (a + 1) / 4, color="black", lw=0.8)
plt.show()

# %% [markdown]
# Points say nothing of what lies between them. Cells do: each is proved as a whole, for every plant in it, so that the
# map below has no gaps. The largest sector of a cell is that of its worst corner, $a$ least and $k$ largest.

# %%
cells = answered(
    "cells.zarr",
    {
        "system": servo["system"],
        "ask": "sector",
        "boxes": {
            "plant.parameters.a": [1.0, 1.5, 2.0, 3.0],
            "plant.parameters.k": [0.5, 1.0, 2.0],
        },
    },
)
low, high = (cells[f"plant.parameters.{name} bounds"].values for name in "ak")
worst = low[:, :1] * (low[:, :1] + 1) / high[:, 1]
print(
    "largest relative distance to Routh's bound:",
    f"{np.abs(cells['largest_low'] / worst - 1).max().item():.1e}",
)
figure, axes = plt.subplots(figsize=(4.8, 3.4))
values_drawn(next(planes(cells)), "largest_low", ax=axes)
plt.show()
