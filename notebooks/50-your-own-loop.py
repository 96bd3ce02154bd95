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
# # Your own loop
#
# You have a plant and an amplifier that saturates. In ten minutes you will know up to which gain the loop is proved
# stable, from which gain on it is refuted, and what is unknown in between; you will have the Popov plot, a proof that
# a program of its own has checked, and a test that turns red when somebody changes the amplifier.
#
# First run everything as it is. Then change the two lines below and run everything again.
#
# ## 1. Two lines
#
# A DC motor positions an antenna through a flexible shaft. One volt turns it at 2 rad/s, with a time constant of
# 0.1 s; the shaft rings at 100 rad/s with a damping ratio of 0.2. From volts to radians:
#
# $$P(s) = \frac{2}{s\,(0.1 s + 1)}\cdot\frac{100^2}{s^2 + 40 s + 100^2},$$
#
# which is
#
# $$P(s) = \frac{200\,000}{s^4 + 50 s^3 + 10\,400 s^2 + 100\,000 s}.$$
#
# The amplifier gives 20 V for each radian of error, and never more than 24 V.

# %%
import control

# ------------------------------------------ change these two lines
PLANT = control.tf([200_000], [1, 50, 10_400, 100_000, 0])  # rad / V
PHI = "min(max(20*sigma, -24), 24)"  # V, of sigma in rad
# -----------------------------------------------------------------

# %% [markdown]
# `PLANT` may be a transfer function or a state space model of python-control or scipy.signal, `(num, den)`, or a
# formula such as `"exp(-s)/(s+1)"`; `PHI` a formula in `sigma`, a nonlinearity of `lure.nonlinearities`, or a function
# of your own. Coefficients are taken exactly, so write whole numbers where you can: the double `0.1` is not $1/10$. If
# your plant is unstable, no sector that contains 0 will do: then change the 0 in `lower=0` below to a gain that
# stabilises it.

# %%
import matplotlib.pyplot as plt

from lure import NonlinearityClass, as_plant
from lure.analysis import certify, max_sector, max_slope, nonlinearity_bounds
from lure.analysis.plots import plot_largest, plot_nonlinearity_sector

block = as_plant(PLANT)
print(f"H = {block}")

# %% [markdown]
# `lure` looks at one loop only, $\sigma = H\mu$, $\mu = -\phi(\sigma)$: $H$ is what lies between the output of the
# nonlinearity and its input, and the minus of the feedback is counted outside. Here $\sigma$ is the angle, $\mu$ the
# voltage. A controller with dynamics goes into $H$. A constant set point $r$ changes nothing as the plant integrates:
# read $\sigma$ as the angle minus $r$.
#
# ## 2. A saturation lies in a sector
#
# Draw a line from the origin to any point of the nonlinearity. Its slope $\phi(\sigma)/\sigma$ is 20 V/rad until the
# amplifier saturates, and then falls towards 0, always positive: $\phi$ lies in the sector $[0, 20]$. Besides that
# the theorem below asks that $\phi$ be locally Lipschitz (no jumps, no vertical tangents) and not change with time.

# %%
bounds = nonlinearity_bounds(PHI)
ax = plot_nonlinearity_sector(PHI, bounds)
ax.set(xlabel="σ [rad]", ylabel="φ(σ) [V]")
plt.show()
print(bounds)

# %% [markdown]
# ## 3. Straight lines first
#
# If the amplifier did not saturate, $\phi = K\sigma$, the loop would have the characteristic polynomial $s^4 +
# 50 s^3 + 10\,400 s^2 + 100\,000 s + 200\,000 K$, and Routh and Hurwitz would say: stable for $0 < K < 84$ V/rad. By
# hand, $(50\cdot10\,400 - 100\,000)\cdot100\,000 > 50^2\cdot200\,000\,K$.

# %%
found = max_sector(block, lower=0)
print(f"linear gains are stable up to {found.hurwitz.low:g}")

# %% [markdown]
# So 20 is safe for straight lines, with a factor of four to spare. A saturation is not one, and a loop that every
# straight line of a sector stabilises can oscillate with a curved one (Aizerman and Kalman conjectured otherwise).
#
# ## 4. The answer, and how to read it

# %%
print(found)

# %% [markdown]
# - *for every phi, time-invariant, in the sector [0, 23.13988]*: one statement about all such nonlinearities at once.
#   Yours is among them.
# - *converges to the set of equilibria*: the plant integrates, so wherever $\phi = 0$ the motor may stand still.
#   This saturation is 0 at 0 alone, so here the set is that one point. A dead zone would be another matter.
# - *popov, certified*: by Popov's criterion, decided in exact arithmetic at every frequency. *Computed* and *observed*
#   would be less, and neither may call itself PROVED.
# - *phi = 84 sigma: the loop is not asymptotically stable*: the other side, a member of the class that fails.
# - *in between nothing was shown.* Between 23 and 84 the loop is not shown to be unstable, nor to be stable.
#
# At the end of a cell an answer shows itself with all that stands behind it: what was tried, and why it stopped there.

# %%
found

# %% [markdown]
#
# ## 5. The bracket
#
# What is proved depends on what you state about the nonlinearity. If it may change with time the class is larger,
# and less is true of it; if its slope stays in $[0, k]$ the class is smaller.

# %%
varying = max_sector(block, time_varying=True, search="full")  # switching gains too
slope = max_slope(block, odd=True, search="linear")
print(varying, slope, sep="\n\n")
names = ["sector, φ may depend on time", "sector", "odd, slope in [0, k]"]
_, ax = plt.subplots(figsize=(5.4, 3.1), layout="constrained")
plot_largest([varying, found, slope], names, ax=ax)
plt.show()

# %% [markdown]
# Look at the first row. A gain that jumps between 0 and 13.7 V/rad at the right moments makes this loop swing ever
# wider, although no constant gain in between does. The amplifier is no such thing if its gain is fixed; if yours is
# rescheduled while the loop runs, the first row is the one that speaks about you, and 20 is beyond it.
#
# ## 6. Popov's plot
#
# $\omega\,\mathrm{Im}\,H$ over $\mathrm{Re}\,H$. A line through $-1/k$ that has the whole curve on its right proves the
# sector $[0, k]$; its slope, $1/\theta$, is yours to choose. The curve crosses the axis at $-1/84$, the linear
# limit; the ringing shaft, at 96 rad/s, stops the line at $-1/23.1$ already.

# %%
from lure.analysis import nyquist_response, popov_response

drawn = (
    popov_response(block)
    if getattr(block, "dt", None) is None
    else nyquist_response(block)
)
_, ax = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
drawn.plot(ax=ax)
if found.hurwitz.high > 0:
    ax.plot(
        [-1 / found.hurwitz.high],
        [0],
        "o",
        ms=7,
        mfc="none",
        color="tab:green",
        label="linear limit",
    )
ax.legend(fontsize="small")
plt.show()
print(drawn)

# %% [markdown] explore="num=200000&den=1,50,10400,100000,0&k=20"
# The notebook *20-nyquist-and-popov* explains this picture. It is a picture: 23.1 was not read off it. (In discrete
# time the criterion has another form and no such plot; you then see Nyquist's.)
#
# ## 7. A proof that a second program checks
#
# Now the question about *this* amplifier: is the loop stable for every nonlinearity in its sector? The answer is a file
# in exact numbers, and `checker.py` reads it without `lure`: plain Python, no packages (`-S`), isolated (`-I`).

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

from lure.analysis.certificates import checker
from lure.analysis.questions.certify import text_of

answer = certify(block, NonlinearityClass(sector=bounds.sector))
print(answer)


def run(name, text, *command):
    """Write a file into an empty folder and run Python on it there; its exit
    status."""
    command = [sys.executable, *command, name]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, name).write_text(text, encoding="utf-8")
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False
        )
    print(f"\n{(done.stdout or done.stderr).strip()}")
    return done.returncode


def accepted(shown):
    """Whether the stand-alone checker accepts the certificate of a proof or a
    refutation."""
    return (
        run("proof.json", text_of(shown.certificate), "-I", "-S", checker.__file__)
        == 0
    )


shown = [each for each in (answer.shown, found.refutation) if each is not None]
both = [accepted(each) for each in shown]

# %% [markdown]
# The first file is the proof for your nonlinearity, the second the refutation at 84. At the command line it is
# `lure certify --num "200000" --den "1 50 10400 100000 0" --sector 0 20 -o proof.json`, then `lure verify proof.json`.
#
# ## 8. A test that guards your nonlinearity
#
# The proof holds as long as the nonlinearity stays in the sector. People change amplifiers. This line fails when they
# do:

# %%
from lure import Sector
from lure.analysis.testing import assert_in_sector


def guard(sector):
    """What the assertion says of the nonlinearity: how it was kept, or where it is
    violated."""
    try:
        return assert_in_sector(PHI, sector)
    except AssertionError as violation:
        return violation


kept = guard(bounds.sector)
print(kept)

# %% [markdown]
# Certified, as the nonlinearity is a formula. Of a Python function a sample is all there is: *observed*, and the bounds
# above are then those of a sample too, which another sample may break by a hair; give it a sector of yours with some
# room. And so that you have seen it red, here is the same line with half the bound:

# %%
half = Sector(bounds.sector.lower, (bounds.sector.lower + bounds.sector.upper) / 2)
print(guard(half))

# %% [markdown]
# In a file it is an ordinary test, for `pytest test_phi.py` (`pip install pytest`). `lure init --test test_phi.py`
# writes one with comments.

# %%
from importlib.util import find_spec

TEST = """
from math import inf
from lure.analysis.testing import assert_in_sector
from lure import Sector

def test_phi_stays_in_its_sector():
    assert_in_sector({!r}, Sector({}, {}))
"""
outcomes = []
if find_spec("pytest") and isinstance(PHI, str):
    for sector in (bounds.sector, half):
        text = TEST.format(PHI, sector.lower, sector.upper)
        outcomes.append(run("test_phi.py", text, "-m", "pytest", "--tb=no", "-q"))

# %% [markdown]
# ## 9. Numbers that are known to a few per cent
#
# Nobody knows the gain of a motor to its last digit. With an interval in place of a number every answer is about *all*
# plants in it, in a file by `[plant.parameters]`. Here the gain of the motor, 200000, may be a tenth more or less:

# %%
from lure.analysis.questions import tolerances
from lure.plants.family import PlantFamily

motor = PlantFamily.of_coefficients(
    ["g"], [1, 50, 10_400, 100_000, 0], {"g": (180_000, 220_000)}
)
room = tolerances(motor, Sector(0, 20))
print(room)

# %% [markdown]
# The first interval is *certified*: with each motor gain in it and every nonlinearity of the sector, every solution
# converges to the set of equilibria. From the second on one plant and a constant gain refute the claim. Between
# them nothing is known. With two parameters the picture is a map: the outlined box is given, blue is how far each and
# both may go, a cross is a plant that refutes. A servo $k/(s(s+1)(s+a))$ takes gains below $a(a+1)/k$ by Routh's
# test, and Popov's criterion proves as much:

# %%
servo = PlantFamily.of_formula(
    "k/(s*(s + 1)*(s + a))", {"k": (0.75, 1.25), "a": (1.75, 2.25)}
)
joint = tolerances(servo, Sector(0, 3))
axes = joint.plot()
for margin in joint.margins:
    print(margin.words(servo))

# %% [markdown]
# ## What does not follow
#
# - **No rate, no overshoot.** Every solution comes to rest; nothing says how soon, or how far it swings before.
# - **Nothing about a gain of 50.** It lies in the open part. The loop may well be stable; it was not shown.
# - **Nothing about other signals.** Loads and noise that last, and set points that move, are not in the theorem.
# - **Nothing about the motor.** The theorem is about these coefficients and this nonlinearity. A second resonance,
#   friction, or a sampled controller is another block, or another nonlinearity.
# - **Nothing with integral action.** With it this $H$ has a double pole at 0, where no criterion here applies; you
#   would be told so in a sentence.
#
# ## What this notebook claims
#
# The numbers above are those of the motor. For two lines of your own this cell checks nothing.

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
if (
    str(block) == "200000 / (s^4 + 50 s^3 + 10400 s^2 + 100000 s)"
    and PHI == "min(max(20*sigma, -24), 24)"
):
    assert (bounds.sector, str(bounds.evidence)) == (Sector(0, 20), "certified")
    assert abs(found.hurwitz.high - 84) < 1e-9
    assert (50 * 10_400 - 100_000) * 100_000 == 50**2 * 200_000 * 84
    assert (str(found.verdict), found.criterion, str(found.evidence)) == (
        "PROVED",
        "popov",
        "certified",
    )
    assert abs(found.largest.low - 23.13988095) < 1e-6
    assert (
        found.witness.description
        == "phi = 84 sigma: the loop is not asymptotically stable"
    )
    assert not found.closed
    assert abs(varying.refuted_at - 13.7) < 0.02
    assert varying.largest.low < 20 < found.largest.low
    assert drawn.k == found.largest.low
    assert str(answer.verdict) == "PROVED"
    assert both == [True, True]
    assert str(kept.evidence) == "certified"
    assert half == Sector(0, 10)
    # passed, failed; not run where there is no pytest
    assert outcomes in ([0, 1], [])
    assert (
        str(certify(block, NonlinearityClass(sector=Sector(0, 50))).verdict)
        == "INCONCLUSIVE"
    )
    print("All of it holds.")

(low, high), (least, most) = room.margins[0].proved[0], motor.box[0]
assert low < least < most < high
widths = [margin.width for margin in joint.margins]
assert all(width.low < width.high < 1.02 * width.low for width in widths)
# a = 1.5 with k = 1.25: 1.5 * 2.5 = 3 * 1.25
assert abs(widths[1].high - 2.0) < 0.01
