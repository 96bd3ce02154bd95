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
# # Reading a report
#
# `lure report paper-rod` writes a page, a JSON file, figures and certificates. This notebook makes the same report
# from Python and reads it as you would read a test protocol: what was claimed, of what, by what means, and what was
# not. Then it makes four more, on purpose with different answers.

# %% tags=["hide-input"]
import hashlib
import json
import tempfile
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from lure import LoopSystem, NonlinearityClass, Saturation, Sector, as_plant
from lure.analysis import Verdict, check
from lure.analysis.certificates.checker import Proved
from lure.analysis.plots import plot_largest, plot_popov
from lure.analysis.report import build_loop_report, write_loop_report
from lure.analysis.rod.plots import plot_both_decays, plot_both_ends, plot_damping
from lure.analysis.rod.report import build_report, claims, write_report
from lure.analysis.wording import plain
from lure.rod import RodPlant, builtin_system


def say(*texts):
    """Print paragraphs."""
    print(*texts, sep="\n\n")


system = builtin_system("paper-rod")
report = build_report(system)
folder = Path(tempfile.mkdtemp())
page = write_report(report, folder)
written = sorted(path.relative_to(folder) for path in folder.rglob("*.*"))
print(*(path for path in written if path.suffix != ".png"), sep="\n")

# %% [markdown]
# `report.html` is one file and works offline; `report.json` is for programs, the figures are vectors for your paper
# (and PNG for slides), and the certificates are for those who trust nobody.
#
# ## The verdict, and what it is about
#
# The system: an elastic rod with a dashpot at one end and a soft obstacle near the other, from a paper. Read three
# things before anything else.

# %%
found = report.conclusion
print(report.verdict)
say(
    found.statement,
    f"Set of equilibria: {found.stationary_set}",
    *(f"Assumed: {text}" for text in found.assumptions),
)

# %% [markdown]
# 1. **The verdict** is one of PROVED, REFUTED, INCONCLUSIVE. It has no truth value: `if report:` raises, because an
#    `if` could take INCONCLUSIVE for PROVED.
# 2. **Of what?** *In the rod and in its 10-cell scheme.* Two objects: the rod is a partial differential equation, the
#    scheme the twenty-one ordinary ones that replace it for a computer. They have different spectra and different
#    proofs, and every row below names the one it is about.
# 3. **For which nonlinearities?** *For every other stiffness of it*: the claim is about a class of nonlinearities.
#    Without load, note. And *which z depends on the start*: the equilibria are a half-line, so no single point
#    attracts.
#
# Every claim of the report, strongest evidence first:

# %%
for claim in claims(report):
    print(f"{claim.evidence}, {claim.answer}, {claim.model}: {claim.text}")

# %% [markdown]
# **Certified** rests on exact arithmetic or a proof, over all frequencies and the whole class. **Computed** is
# floating point compared with a second computation. **Observed** is one solution: it may contradict a claim, and
# then no report is written; it cannot prove one. Only the first ever carries PROVED.
#
# ## The criteria: theta, margin, largest k

# %%
print("criterion  model   verdict  theta  margin     at       largest k")
print("                            [s]    [m/Pa]     [rad/s]  [Pa/m]")
for row in report.criteria:
    print(
        f"{row.criterion:10} {row.model:7} {row.verdict!s:8} {row.theta:<6.4g} "
        f"{row.margin.low:<10.8g} "
        f"{row.worst_frequency:<8.5g} {row.largest.low:.8g}"
    )

# %% [markdown]
# The inequality is $1/k + \mathrm{Re}[(1 + i\omega\theta)H(i\omega)] > 0$ at every frequency, for the sector $[0,
# k]$, here $k = 1$ Pa/m.
#
# - **theta** is Popov's multiplier, 1.25 s. With $\theta = 0$ the inequality is the circle criterion.
# - **margin** is the least value of the left-hand side over *all* frequencies, and *at* is where. It is not read off a
#   grid. Positive is what counts; its size is how much further $-1/k$ could move.
# - **largest k** is the largest $k$ for which the criterion still holds. The circle criterion gives up at 8 Pa/m, since
#   $\mathrm{Re}\,H$ goes down to $-1/8$ (hence its margin, $0.875 = 1 - 1/8$); Popov proves every finite
#   stiffness. A contact ten times as hard as this one would need Popov.
#
# You can check the margin with one evaluation of the block:

# %%
blocks = {"scheme": report.scheme, "rod": RodPlant(report.scheme.rod)}
seen = {}
for row in report.criteria:
    s = 1j * row.worst_frequency
    if row.criterion == "popov" and row.worst_frequency < 1e6:
        seen[row.model] = float(
            1 + ((1 + s * row.theta) * blocks[row.model].transfer(s)).real
        )
        print(
            f"{row.model}: {seen[row.model]:.9f} at {row.worst_frequency:.5g} "
            f"rad/s; reported {row.margin.low:.9f}"
        )

popov = {row.model: row for row in report.criteria if row.criterion == "popov"}
_, axes = plt.subplots(1, 2, figsize=(8.6, 3.7), layout="constrained")
for ax, (model, row) in zip(axes, popov.items(), strict=True):
    plot_popov(blocks[model], row, ax=ax)
    ax.set_title(model, fontsize="medium")
plt.show()

# %% [markdown]
# Popov's plot says it in one picture: the curve stays to the right of a line of slope $1/\theta$ through $-1/k$. A
# picture has finitely many points and proves nothing; the certificate covers the axis. The textbook theorem is about
# ordinary differential equations; that the inequality on the right proves the same of the rod is [note
# 11](notes/0011-popov-for-the-rod.md). The report's own verdict rests on an energy theorem ([note
# 5](notes/0005-energy-theorem.md)), which asks for no frequency.
#
# ## The spectrum: how much of the damping is the grid's?

# %%
print("      scheme [1/s]            rod [1/s]               numerical")
print("mode  decay       frequency   decay       frequency       share")
pairs = json.loads((folder / "report.json").read_text())["spectrum"]["modes"]
for mode in pairs[:5]:
    (a, b), (c, d) = mode["scheme"], mode["rod"]
    share = round(mode["numerical_share"], 4) + 0.0
    print(
        f"{mode['number']:<5} {-a:<11.6g} {b:<11.6g} {-c:<11.6g} {d:<11.6g} "
        f"{share:9.2%}"
    )
_, ax = plt.subplots(figsize=(5, 3), layout="constrained")
plot_damping(report.scheme, ax=ax)
plt.show()

# %% [markdown]
# The first elastic mode of the scheme decays at 2938 1/s and that of the rod at 1.0 1/s: all but 0.03 % of that
# damping belongs to ten cells, not to the rod. The report puts the two columns side by side for this reason, and reads
# no verdict about the rod off the scheme.
#
# ## Simulation and confirmation: an attempt to prove us wrong

# %%
run = report.simulation.trajectory
print(
    f"{report.simulation.cells} cells up to {run.t[-1]:g} s, energy identity within "
    f"{run.energy_residual:.1e}"
)
say(f"Where the rod comes to rest: {report.confirmation.rod.rest.way}.")
_, axes = plt.subplots(1, 2, figsize=(8.6, 3.7), layout="constrained")
plot_both_ends(report.confirmation, ax=axes[0])
plot_both_decays(report.confirmation, ax=axes[1])
plt.show()

# %% [markdown]
# Two motions, both without a time step: of the rod along its characteristics, of the scheme from event to event.
# Energy and Lyapunov function must not rise, $\zeta$ must not rise, and the resting place, predicted from momentum
# as $-0.0199$ m, must be the one shown. Had one of these failed, you would have got an error instead of a report.
# That they hold speaks for our programs, and is no proof: these are two motions out of infinitely many.
#
# ## The certificates
#
# Beside the page lie the proofs, as files. The report lists each with its SHA-256, so that a file swapped alone
# shows, and the checker decides each again from scratch (on the command line: `lure verify certificates/*.json`).

# %%
data = json.loads((folder / "report.json").read_text())
accepted = []
for entry in data["certificates"]:
    content = (folder / entry["file"]).read_bytes()
    assert hashlib.sha256(content).hexdigest() == entry["sha256"]
    accepted.append(check(content))
    print(
        f"{entry['file']}  {entry['sha256'][:12]}...  {type(accepted[-1]).__name__}"
    )
    say(f"  {plain(accepted[-1].claim)}")

# %% [markdown]
# Read the claims, not the file names: 1 and 2 are the energy theorem, for the rod and its scheme. 3 says *converges*,
# of the scheme; 4 only *bounded*, since the circle criterion allows nonlinearities that change with time. 5 and 6 are
# of the rod: by Popov's inequality it *comes to rest* too; by the circle criterion even if the nonlinearity varies.
#
# For your own programs `report.json` follows a published schema, in which `null` is "does not apply" and `"inf"` is
# infinity; there is no NaN.

# %%
schema = json.loads(
    files("lure.analysis.report").joinpath("schema.json").read_text()
)
try:
    import jsonschema
except ImportError:
    print("jsonschema is not installed; nothing was validated")
else:
    jsonschema.validate(data, schema)
    print(f"report.json is valid against {schema['title']}")

# %% [markdown]
# ## Three more answers
#
# **Without damping.** The theorem needs $k > 0$, so the report proves nothing, and says so:


# %%
def damped(value):
    """The report on the rod with another dashpot [N s/m]."""
    return build_report(replace(system, rod=system.rod.replace(damping=value)))


undamped = damped(0)
print(undamped.verdict)
say(undamped.conclusion.statement, undamped.criteria[0].reason)

# %% [markdown]
# INCONCLUSIVE does not mean REFUTED. It says which hypothesis is missing (the zero eigenvalue is double) and what
# to try (a damping above zero). A criterion that fails refutes nothing.
#
# **With a dashpot that pushes.** Now one of the motions runs away, and the report has to name it:

# %%
pushed = damped(-1e-4)
print(pushed.verdict)
say(
    pushed.conclusion.statement,
    f"The checker: {plain(pushed.certificates[0].claim)}",
)

# %% [markdown]
# REFUTED is about the class: there is a nonlinearity in it, $\phi = 0$, under which the rod recedes for ever. The
# second sentence goes further, for the rod and any nonlinearity.
#
# **Where the slope decides.** Reports on any other loop look the same. A plant with a zero in the right half-plane,
# under a saturation of gain 3; and once more, if all you know is that the nonlinearity lies in the sector $[0, 3]$:

# %%
plant = as_plant("(s^2 - 0.2*s - 0.1)/(s^3 + 2*s^2 + s + 1)")
loop = LoopSystem(name="plant", title="a zero in the right half-plane", block=plant)
saturated = build_loop_report(
    replace(loop, nonlinearity=Saturation(gain=3, limit=1))
)
sector_only = build_loop_report(
    replace(loop, nonlinearity_class=NonlinearityClass(sector=Sector(0, 3)))
)
for one in (saturated, sector_only):
    print(one.verdict)
    say(
        one.analysis.statement,
        *(f"To decide more: {hint}." for hint in one.analysis.hints),
    )
    print()

names = [row.class_name for row in sector_only.analysis.rows]
_, ax = plt.subplots(figsize=(5.4, 3.4), layout="constrained")
plot_largest(sector_only.analysis.rows, names, ax=ax)
ax.axvline(3, color="black", lw=0.8, ls=":")
plt.show()

# %% [markdown]
# The same plant, the same number 3 (dotted), two answers, both right. Sector nonlinearities are proved up to 1.79, and
# where a time-invariant one first destabilises is not known (hatched); nonlinearities with bounded slope are proved to
# where a linear gain fails. A saturation has bounded slope, and the report found that out from its formula. What you
# know about your nonlinearity is worth as much as what you know about your plant.
#
# The report on a loop has its certificates too, one for each criterion that proved something and one for each
# counterexample, and follows the same schema.

# %%
loop_folder = Path(tempfile.mkdtemp())
write_loop_report(saturated, loop_folder)
loop_data = json.loads((loop_folder / "report.json").read_text())
loop_checked = [
    check((loop_folder / entry["file"]).read_bytes())
    for entry in loop_data["certificates"]
]
print(*(f"{type(one).__name__:8} {one.theorem}" for one in loop_checked), sep="\n")
say(*saturated.observed, *saturated.hints)

# %% [markdown]
# On the command line the exit status of `lure report` is the answer: 0 PROVED, 10 INCONCLUSIVE, 11 REFUTED, 2 bad
# input. The last two lines are an observation and a hint; they would not have changed it.
#
# ## What must not be read into it
#
# The report says this itself, at the end, in words that depend on the case:

# %%
say("Of the rod:", *(f"- {text}" for text in found.not_shown))
print()
say(
    "Of the plant, not shown:",
    *(f"- {text}" for text in saturated.analysis.not_shown),
)

# %% [markdown]
# And three things that no report can say. That your rod is this rod: linear, one-dimensional, with these constants.
# That your nonlinearity lies in the class you named: [from measurements](60-from-measurements.py) is about that. And
# that a motion which comes to rest does so before your shift ends.
#
# ## What this notebook claims

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
assert report.verdict is Verdict.PROVED
assert undamped.verdict is sector_only.verdict is Verdict.INCONCLUSIVE
assert pushed.verdict is Verdict.REFUTED
assert saturated.verdict is Verdict.PROVED
assert {claim.evidence for claim in claims(report) if claim.answer == "PROVED"} == {
    found.proofs[0].evidence
}
assert str(found.proofs[0].evidence) == "certified"
assert report.scheme.order == 21
circle = [row for row in report.criteria if row.criterion == "circle"]
assert all(abs(row.theta - 1.25) < 1e-7 for row in popov.values())
assert all(row.theta == 0 for row in circle)
assert all(row.largest.low == np.inf for row in popov.values())
assert all(abs(row.largest.low - 8) < 1e-6 for row in circle)
assert report.criteria[0].sector == Sector(0, 1)
assert seen
assert all(abs(seen[model] - popov[model].margin.low) < 1e-9 for model in seen)
assert (-pairs[1]["scheme"][0], -pairs[1]["rod"][0]) > (2937.5, 0.999)
assert round(-pairs[1]["scheme"][0]) == 2938
assert round(-pairs[1]["rod"][0], 1) == 1.0
assert 0 < 1 - pairs[1]["numerical_share"] < 4e-4
assert abs(report.confirmation.rod.rest.predicted + 0.0199) < 1e-12
assert abs(report.confirmation.rod.rest.shown + 0.0199) < 1e-9
assert not report.confirmation.contradictions
assert len(accepted) == 6
assert all(isinstance(one, Proved) for one in accepted)
assert "converges" in accepted[2].claim
assert "bounded" in accepted[3].claim
assert all("of finite energy comes to rest" in one.claim for one in accepted[4:])
assert undamped.spectrum.zero_multiplicity == 2
assert not undamped.certificates
assert len(loop_checked) == len(loop_data["certificates"])
rows = {row.class_name: row for row in sector_only.analysis.rows}
assert 1.79 <= rows["sector"].largest.low < 1.8
assert rows["slope"].closed
assert rows["slope"].witness.kind == "linear gain"
