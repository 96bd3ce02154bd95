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
# # Neural networks as controllers
#
# A network holds an inverted pendulum upright. From where does it? Each neuron is a channel
# $\mu_i = -\phi(\sigma_i)$ of a Lur'e loop; between $-c$ and $c$ it lies in the sector $[\tanh(c)/c, 1]$, and the
# intervals follow from one layer to the next. A quadratic form that falls on its own level set then proves a region of
# attraction, and what is proved is decided in rational numbers.
#
# First the network of Yin, Seiler and Arcak (IEEE Transactions on Automatic Control 67, 2022), 64 neurons with their
# published weights; then one that is trained here.

# %% tags=["hide-input"]
from fractions import Fraction
from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import solve_discrete_are

from lure import as_plant
from lure.analysis import check, region
from lure.analysis.certificates.second.opinion import recheck
from lure.files import read_system
from lure.networks import Network, read_network

# %% [markdown]
# ## The pendulum with 64 neurons
#
# With $g = 10$, $m = 0.15$, $l = 0.5$, friction $0.05$ and steps of $0.02$ s,
# $x_1^+ = x_1 + 0.02\,x_2$, $x_2^+ = x_2 + 0.02\,(20 \sin x_1 - \tfrac43 x_2 + \tfrac{80}{3} u)$,
# $u = \mathrm{sat}(N(x))$ between $-0.7$ and $0.7$. The file has it with the channel $x_1 - \sin x_1$ before the
# neurons.

# %%
pendulum = read_system(files("lure.networks") / "pendulum.toml")
print(pendulum.title, "|", pendulum.block)
proved = region(pendulum)
print(proved)

# %% [markdown]
# With $|\sigma| \le 0.1$ in the first layer and $|x_1| \le 0.73$ their programme has an ellipsoid of the area $1.75$.
# Here the search chooses the intervals, the saturation of the output has the generalised sector condition, and the
# largest area is asked for. The certificate is about every nonlinearity in the sectors it lists, and both checkers
# accept it.

# %%
certificate = dict(proved.proof.certificate)
print(
    check(certificate).theorem,
    "| the second checker accepts it:",
    recheck(certificate).accepted,
)
for number in (1, 2, 34):
    one = proved.sets[0].bounds[number - 1]
    low, high = (float(Fraction(v)) for v in one["sector"])
    print(
        f"channel {number}: sector [{low:.4f}, {high:.4f}] for |sigma| <= "
        f"{float(Fraction(one['interval'][1])):.4f}"
    )

# %% [markdown]
# ## A network that is trained here
#
# Two layers of six neurons learn $\mathrm{sat}(Kx)$ of a linear-quadratic regulator by gradient descent (Adam) on the
# mean square error at points of a box, beside a small price on large weights: these make the sectors wide. Without
# biases $N(0) = 0$. The weights are rounded to four decimals, and what is proved is about those.

# %%
A = np.array([[1, 0.02], [0.4, 73 / 75]])
B = np.array([[0], [8 / 15]])
X = solve_discrete_are(A, B, np.diag([1, 0.1]), [[20.0]])
K = -np.linalg.solve([[20.0]] + B.T @ X @ B, B.T @ X @ A)


def trained(gain, *, neurons=6, steps=3000, rate=0.01, seed=1):
    """Weights of a tanh network of two hidden layers that imitates ``sat(gain x)``
    between -0.7 and 0.7."""
    rng = np.random.default_rng(seed)
    x = rng.uniform([-1, -3], [1, 3], size=(400, 2))
    wanted = np.clip(x @ gain.T, -0.7, 0.7)
    W = [
        rng.normal(size=shape) / np.sqrt(4 * shape[1])
        for shape in ((neurons, 2), (neurons, neurons), (1, neurons))
    ]
    mean, square = (
        [np.zeros_like(one) for one in W],
        [np.zeros_like(one) for one in W],
    )
    for step in range(1, steps + 1):
        one = np.tanh(x @ W[0].T)
        two = np.tanh(one @ W[1].T)
        back = 2 * (two @ W[2].T - wanted) / len(x)
        at_two = back @ W[2] * (1 - two**2)
        at_one = at_two @ W[1] * (1 - one**2)
        for k, slope in enumerate((at_one.T @ x, at_two.T @ one, back.T @ two)):
            slope = slope + 1e-3 * W[k]
            mean[k] = 0.9 * mean[k] + 0.1 * slope
            square[k] = 0.999 * square[k] + 0.001 * slope**2
            W[k] -= (
                rate
                * (mean[k] / (1 - 0.9**step))
                / (np.sqrt(square[k] / (1 - 0.999**step)) + 1e-8)
            )
    return [np.round(one, 4) for one in W], float(
        np.sqrt(np.mean((two @ W[2].T - wanted) ** 2))
    )


weights, error = trained(K)
own = Network.given(
    [[[Fraction(f"{v:.4f}") for v in row] for row in one] for one in weights],
    activation="tanh",
    saturation="0.7",
)
print(own, f"| root mean square error {error:.4f}")

# %% [markdown]
# The plant has the channel $\mu_1 = -(x_1 - \sin x_1)$ of its own; $u$ is its last input, and the last outputs are what
# the network measures.

# %%
A = [[1, "0.02"], ["0.4", "73/75"]]
B = [[0, 0], ["0.4", "8/15"]]
plant = as_plant((A, B, [[1, 0], [1, 0], [0, 1]], [[0, 0]] * 3), dt=Fraction(2, 100))
loop = own.closed(plant)
ours = region(loop, ["sigma - sin(sigma)", *own.nonlinearities()])
print(ours)

# %% [markdown]
# ## Nothing escapes
#
# From 50 000 initial states on their boundaries the solutions with the networks themselves are followed. This is an
# observation; the proofs are the certificates.


# %%
def attacked(found, network, *, count=50_000, steps=150):
    """The largest value of ``V`` in each step of solutions that start on the
    boundary of a set."""
    P = np.array(found.sets[0].P, dtype=float)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    x = np.linalg.solve(
        np.linalg.cholesky(P).T, np.stack([np.cos(angle), np.sin(angle)])
    ).T
    highest = []
    for _ in range(steps):
        u = network(x)[:, 0]
        x = np.stack(
            [
                x[:, 0] + 0.02 * x[:, 1],
                0.4 * np.sin(x[:, 0]) + 73 / 75 * x[:, 1] + 8 / 15 * u,
            ],
            axis=1,
        )
        highest.append(float(np.einsum("ki,ij,kj->k", x, P, x).max()))
    return highest


theirs = read_network(
    files("lure.networks") / "pendulum.json", saturation=Fraction(7, 10)
)
runs = {"published": attacked(proved, theirs), "trained here": attacked(ours, own)}
print(
    {
        name: f"V at most {run[0]:.4f} after one step, {run[-1]:.1e} after 150"
        for name, run in runs.items()
    }
)

# %%
_, axes = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
for ax, found, name in zip(axes, (proved, ours), runs, strict=True):
    found.plot(ax=ax)
    ax.set_title(f"network {name}")
    ax.set_xlabel("angle [rad]")
    ax.set_ylabel("velocity [rad/s]")
plt.show()

# %% [markdown]
# ## The numbers of this notebook

# %% tags=["hide-input"] mystnb={"code_prompt_show": "Show the checks", "code_prompt_hide": "Hide the checks"}
assert proved.area[0] > 7.6 > 1.75
assert ours.verdict.name == "PROVED"
assert ours.area[0] > 10
assert all(
    np.all(np.diff([1.0, *run]) < 1e-12) and run[-1] < 0.05 for run in runs.values()
)
assert recheck(dict(ours.proof.certificate)).accepted
print(f"areas {proved.area[0]:.4f} and {ours.area[0]:.4f}")
