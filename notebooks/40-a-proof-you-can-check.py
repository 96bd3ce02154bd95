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
# # A proof you can check
#
# You need not trust our solver, our linear algebra or our plots. Beside every PROVED and REFUTED stands a file in
# exact numbers, and this notebook reads five of them with you, by hand: `fractions.Fraction` and `json`, no `lure`
# between you and the arithmetic. What is left to believe is a handful of theorems with names, and Python's integers.
#
# The parts can be read alone: a polynomial, a matrix, an orbit, and the checker on its own. Start with the first; it
# fits on the back of an envelope. [A rod and a delay](42-a-rod-and-a-delay-by-hand.py) go on from here. A report lists
# such files ([reading a report](30-reading-a-report.py)); `lure certify` writes one, `lure verify` checks it.
#
# The sign is $\sigma = H\mu$, $\mu = -\phi(\sigma)$ throughout, and the nonlinearities are locally Lipschitz.

# %% tags=["hide-input"]
import json
import shutil
import subprocess
import sys
import tempfile
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from lure.analysis import popov_response

# what is checked: called to compare, never to compute
from lure.analysis.certificates import checker
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.plots import plot_popov_response
from lure.analysis.plots.style import BLUE, GREEN, GREY, VERMILLION, finish_axes
from lure.analysis.questions.certify import text_of


def times(p, q):
    """The product of two polynomials, ascending."""
    out = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            out[i + j] += x * y
    return out


def plus(p, q, factor=1):
    """``p + factor q``, without zeros at the end."""
    size = max(len(p), len(q))
    out = [
        a + factor * b
        for a, b in zip(
            p + [0] * (size - len(p)), q + [0] * (size - len(q)), strict=True
        )
    ]
    while out and out[-1] == 0:
        out.pop()
    return out


def value(p, x):
    """``p(x)``."""
    return sum(a * x**i for i, a in enumerate(p))


def words(p):
    """A list of exact numbers, to read."""
    return "[" + ", ".join(map(str, p)) + "]"


# %% [markdown]
# ## 1. A polynomial
#
# The block $1/(s(s+1)(s+2))$ has a pole at zero, the nonlinearities lie in the sector $[0, 59/10]$ and do not depend on
# time. Somebody proposes Popov's multiplier $\theta = 3/2$. `complete_and_check` fills in what a draft leaves open and
# hands it to the checker. The file:

# %%
SECTOR = {
    "sector": ["0", "59/10"],
    "slope": None,
    "odd": False,
    "time_varying": False,
    "linear": False,
}
PLANT = {"kind": "transfer", "time": "continuous", "numerator": ["1"]}
PLANT |= {"denominator": ["1", "3", "2", "0"]}
POPOV = {
    "verdict": "PROVED",
    "system": PLANT,
    "laws": SECTOR,
    "theorem": "popov",
    "multiplier": {"theta": "3/2"},
}
BY_POLYNOMIAL = {"proof": {"method": "polynomial"}}


def checked(**changes):
    """That claim, with changes, completed and checked."""
    return complete_and_check({**POPOV, **changes})


file = text_of(checked(**BY_POLYNOMIAL).certificate)
print(file)

# %% [markdown]
# Popov's condition is $1/k + \mathrm{Re}[(1 + i\omega\theta) H(i\omega)] > 0$ at every frequency. Multiplied by
# $k\,|d|^2$ it is a polynomial: $F = k\,\mathrm{Re}[(1 + i\omega\theta)\, n \bar d\,] + |d|^2$. We form it from the
# claim alone.

# %%
claim = json.loads(file)
n, d = (
    [Fraction(x) for x in reversed(claim["system"][key])]
    for key in ("numerator", "denominator")
)
k = Fraction(claim["laws"]["sector"][1])
theta = Fraction(claim["multiplier"]["theta"])


def on_axis(p):
    """Real and imaginary part of ``p(i omega)``, as polynomials in omega."""
    return [a * (1, 0, -1, 0)[j % 4] for j, a in enumerate(p)], [
        a * (0, 1, 0, -1)[j % 4] for j, a in enumerate(p)
    ]


def popov(k, theta):
    """``F`` of the claim, in omega."""
    (nr, ni), (dr, di) = on_axis(n), on_axis(d)
    # n times the conjugate of d
    x, y = plus(times(nr, dr), times(ni, di)), plus(times(ni, dr), times(nr, di), -1)
    return plus(
        plus(times([k], x), times([0, -k * theta], y)),
        plus(times(dr, dr), times(di, di)),
    )


F = popov(k, theta)
print("F, ascending in omega:        ", words(F))
assert F[:2] == [0, 0]  # divisible by omega^2
assert not any(F[1::2])  # and even
f = F[2::2]
print("F/omega^2, in X = omega^2:    ", words(f))
print("the same without denominators:", words([20 * a for a in f]))

# %% [markdown]
# $F/\omega^2 = 4 - \tfrac{77}{20} X + X^2$. Dividing by $\omega^2$ is what the pole at zero is worth: there $|d|^2$
# vanishes like $4\omega^2$, and the condition itself tends to $\tfrac14 \cdot 4/k = 1/k$. At infinity $|d|^2$ grows
# like $\omega^6$, and it tends to $1/k$ too. Both ends are positive. Between them: Sturm's chain $p, p'$, minus each
# remainder; the sign changes lost from $0$ to $\infty$ are the roots in between.


# %%
def sturm(p):
    """Sturm's chain of ``p``."""
    rows = [p, [i * a for i, a in enumerate(p)][1:]]
    while rows[-1]:
        a, b = rows[-2:]
        while len(a) >= len(b):
            a = plus(a, [0] * (len(a) - len(b)) + b, -a[-1] / b[-1])
        rows.append([-x for x in a])
    return rows[:-1]


def changes(signs):
    """How often the sign changes."""
    return sum((a > 0) != (b > 0) for a, b in pairwise([x for x in signs if x]))


chain = sturm(f)
for row in chain:
    print(f"{words(row):16}  at 0: {row[0]!s:9}  leading: {row[-1]}")
roots = changes([row[0] for row in chain]) - changes([row[-1] for row in chain])
print("roots of F/omega^2 in (0, inf):", roots)

# %% [markdown]
# One change at both ends, so no root, and $F > 0$. In this degree you need no Sturm: the minimum, at $X = 77/40$, is
# $471/1600$.
#
# The theorem asks one more thing of the block: a simple pole at zero with positive residue, all others on the left.

# %%
deflated = d[1:]  # d/s
residue = n[0] / deflated[0]
print("d(0) =", d[0], "  d/s =", words(deflated), "  residue", residue)
assert (d[0], len(deflated)) == (0, 3)
# a quadratic whose coefficients have one sign has its roots on the left
assert min(deflated) > 0

# %% [markdown]
# **Concluded**, by Popov's theorem in the critical case (Aizerman and Gantmacher 1964): for every nonlinearity of the
# class, every solution converges to the set of equilibria.
#
# **Not concluded**: asymptotic stability of 0, which would be false. The nonlinearity $\max(\sigma - 1, 0)$ belongs
# to the class, the checker confirms it, and with it the loop rests at $\sigma = 1/2$ for ever. Nor a rate, nor
# anything about nonlinearities that depend on time, or about loads, or whether your plant has these coefficients.

# %%
dead_zone = {
    "kind": "piecewise-linear",
    "points": [["0", "0"], ["1", "0"]],
    "left": "0",
    "right": "1",
}
print(checked(law=dead_zone, **BY_POLYNOMIAL).facts["law"])
# d sigma = n mu with all derivatives zero
assert d[0] * Fraction(1, 2) == n[0] * -max(Fraction(1, 2) - 1, 0)

# %% [markdown]
# Now change a digit. One, then each digit of the file to each other digit.


# %%
def verdict(text):
    """What the checker says."""
    try:
        return type(checker.check(text)).__name__
    except ValueError as reason:
        return f"{type(reason).__name__}: {reason}"


print(verdict(file))
print(verdict(file.replace('"-77"', '"-76"')))
changed = [
    file[:i] + x + file[i + 1 :]
    for i, c in enumerate(file)
    if c.isdigit()
    for x in "0123456789"
    if x != c
]
accepted = [text for text in changed if verdict(text) in ("Proved", "Refuted")]
print(len(changed), "files with one digit changed,", len(accepted), "accepted")

# %% [markdown]
# Not every change must be refused: one that consistently makes another true claim would be accepted, and rightly.
#
# ### The sector $[0, 6]$
#
# With the same $\theta$, $F/\omega^2 = (X - 2)^2$: never negative, and zero at $X = 2$. No other $\theta$ helps.

# %%
print("k = 6, theta = 3/2:", words(popov(Fraction(6), theta)[2::2]))
for other in (Fraction(-5), Fraction(0), Fraction(1, 7), Fraction(1000)):
    print(
        f"k = 6, theta = {other}: F/omega^2 at X = 2 is",
        value(popov(Fraction(6), other)[2::2], Fraction(2)),
    )
six = {**SECTOR, "sector": ["0", "6"]}
try:
    checked(laws=six, **BY_POLYNOMIAL)
    refusal = None
except checker.Rejected as reason:
    refusal = str(reason)
print("Rejected:", refusal)

# %% [markdown]
# No multiplier of any kind can work. The nonlinearity $\phi = 6\sigma$ is in the class, and
# $d + 6n = s^3 + 3s^2 + 2s + 6 = (s+3)(s^2+2)$ has its roots $\pm i\sqrt2$ on the axis: that loop has the solution
# $\cos\sqrt2\,t$, which never comes to rest. At $\omega^2 = 2$ we have $1/6 + H = 0$, whatever it is multiplied by.
# What can be certified is the opposite.

# %%
assert times([3, 1], [2, 0, 1]) == plus(d, [6 * a for a in n])
AGAINST = {"verdict": "REFUTED", "theorem": "counterexample"}
gain = {
    "system": PLANT,
    "laws": six,
    "proof": {"method": "linear-gain", "gain": "6"},
}
refuted = complete_and_check({**AGAINST, **gain})
print(f"{type(refuted).__name__}: {refuted.claim}")
print(refuted.facts["root"])

# %% [markdown] explore="num=1&den=1,3,2,0&k=5.9&theta=1.5"
# Left, Popov's plot: the curve stays to the right of the line of slope $1/\theta$ through $-1/k$. Right, the
# polynomial.

# %%
_, (left, right) = plt.subplots(1, 2, figsize=(8.6, 3.8), layout="constrained")
plot_popov_response(
    popov_response(([1], [1, 3, 2, 0]), k=Fraction("5.9"), theta=Fraction(3, 2)),
    ax=left,
)
left.set_title("1/(s(s+1)(s+2)), κ = k = 5.9, θ = 3/2", fontsize="medium")
X = np.linspace(0, 4.2, 400)
for upper, colour in ((k, BLUE), (Fraction(6), VERMILLION)):
    drawn = [float(a) for a in popov(upper, theta)[2::2]]
    right.plot(
        X, value(drawn, X), color=colour, lw=1.4, label=f"k = {float(upper):g}"
    )
least = {"label": "minimum 471/1600 at 77/40"}
right.plot([77 / 40], [471 / 1600], "o", ms=5, color=GREEN, **least)
right.axhline(0, color=GREY, lw=0.6)
right.set(xlabel="X = ω² [rad²/s²]", ylabel="F/ω² [rad⁴/s⁴]", xlim=(0, 4.2))
finish_axes(right)
right.legend(frameon=False)
plt.show()

# %%
assert claim["proof"]["coefficients"] == ["80", "-77", "20"]
assert claim["proof"]["limits"] == ["4", "1"]
assert [20 * a for a in f] == [80, -77, 20]
assert [str(f[0]), str(f[-1])] == claim["proof"]["limits"]
assert chain == [
    [4, Fraction(-77, 20), 1],
    [Fraction(-77, 20), 2],
    [Fraction(-471, 1600)],
]
assert (roots, residue, deflated) == (0, Fraction(1, 2), [2, 3, 1])
assert value(f, Fraction(77, 40)) == Fraction(471, 1600)
assert claim["conclusion"] == "every motion converges to the set of equilibria"
assert len(changed) > 300
assert accepted == []
assert popov(Fraction(6), theta)[2::2] == times([-2, 1], [-2, 1])
assert refusal is not None
assert type(refuted).__name__ == "Refuted"

# %% [markdown]
# ## 2. A matrix
#
# In state space the same condition at all frequencies at once is one matrix inequality. For $1/(s^2+s+1)$, the sector
# $[0, 10]$ and $\theta = 1$, in the companion form of the block, $P = \tfrac14\begin{pmatrix}9&4\\4&5\end{pmatrix}$:
#
# $$M = \begin{pmatrix} -(A^TP + PA) & c^T + \theta A^Tc^T - Pb \\ \cdot & 2/k + 2\theta\,(cb + \varrho)
# \end{pmatrix} > 0, \qquad P > 0.$$
#
# Then $V = x^TPx + 2\theta\int_0^\sigma\phi$ falls along every solution: $-V' = v^TMv + 2\phi\,(\sigma -
# \phi/k)$ with $v = (x, -\phi)$, and the last product is not negative in the sector. ($\varrho = 0$ here.) A
# matrix is positive definite if the pivots of its $LDL^T$ are positive; in fractions that is a matter of fact.


# %%
def formed(P, block, k, theta):
    """The matrix M, of a block ``A, b, c, rho``."""
    A, b, c, rho = block
    size = range(len(A))
    PA = [[sum(P[i][m] * A[m][j] for m in size) for j in size] for i in size]
    Pb, cA = (
        [sum(P[i][m] * b[m] for m in size) for i in size],
        [sum(c[m] * A[m][j] for m in size) for j in size],
    )
    edge = [c[i] + theta * cA[i] - Pb[i] for i in size]
    corner = 2 / k + 2 * theta * (sum(c[i] * b[i] for i in size) + rho)
    return [[-PA[i][j] - PA[j][i] for j in size] + [edge[i]] for i in size] + [
        [*edge, corner]
    ]


def pivots(M):
    """The diagonal of D in ``M = L D L'``."""
    M, found = [list(row) for row in M], []
    for j in range(len(M)):
        found.append(M[j][j])
        for i in range(j + 1, len(M)):
            factor = M[i][j] / M[j][j]
            M[i] = [x - factor * y for x, y in zip(M[i], M[j], strict=True)]
    return found


def dyadic(proof):
    """P of a certificate: rows of the lower triangle, times 2^exponent."""
    rows = [[Fraction(x) for x in row] for row in proof["P"]]
    unit = Fraction(1, 2 ** proof["exponent"])
    return [
        [rows[max(i, j)][min(i, j)] * unit for j in range(len(rows))]
        for i in range(len(rows))
    ]


plain = {"method": "matrix", "P": [["9"], ["4", "5"]], "exponent": 2, "zero": None}
P = dyadic(plain)
M = formed(P, ([[0, 1], [-1, -1]], [0, 1], [1, 0], 0), k=Fraction(10), theta=1)
print(*map(words, M), sep="\n")
principal = pivots(P), pivots(M)
print("pivots of P", words(principal[0]), " of M", words(principal[1]))
damped = {**PLANT, "denominator": ["1", "1", "1"]}
wide = {**SECTOR, "sector": ["0", "10"]}
asked = {"system": damped, "laws": wide, "multiplier": {"theta": "1"}}
print(checked(**asked, proof=plain).claim)

# %% [markdown]
# With a pole at zero no $P$ makes $A^TP + PA$ definite: $Ax_0 = 0$. The critical case is **deflated**. The file names
# $x_0$ and $\ell$ with $Ax_0 = 0$, $\ell A = 0$ and a coordinate $p$ where $x_0$ does not vanish. The loop is then read
# in $x_i - x_{0i}\,x_p/x_{0p}$, which do not see $x_0$, and in $\zeta = (cx_0)(\ell x)/(\ell x_0)$, which obeys $\zeta'
# = \varrho\mu$. For the plant of part 1:

# %%
A, b, c = [[0, 1, 0], [0, 0, 1], [0, -2, -3]], [0, 0, 1], [1, 0, 0]
zero = {"right": ["1", "0", "0"], "left": ["2", "3", "1"], "pivot": 0}
x0, left_null = ([Fraction(x) for x in zero[side]] for side in ("right", "left"))


def dot(u, v):
    """``u . v``."""
    return sum(x * y for x, y in zip(u, v, strict=True))


assert not any(dot(row, x0) for row in A)
assert not any(dot(left_null, column) for column in zip(*A, strict=True))
weight = dot(c, x0) / dot(left_null, x0)
rho = weight * dot(left_null, b)
rest, p = (1, 2), zero["pivot"]
small_A = [[A[i][j] - x0[i] / x0[p] * A[p][j] for j in rest] for i in rest]
small_b = [b[i] - x0[i] / x0[p] * b[p] for i in rest]
small_c = [c[i] - weight * left_null[i] for i in rest]
print("A", *map(words, small_A), " b", words(small_b), end=" ")
print(" c", words(small_c), " rho", rho)

critical = {"method": "matrix", "P": [["131"], ["1", "64"]], "exponent": 7}
critical |= {"zero": zero}
P = dyadic(critical)
M = formed(P, (small_A, small_b, small_c, rho), k, theta)
print(*map(words, M), sep="\n")
deflated_pivots = pivots(P), pivots(M)
print("pivots of P", words(deflated_pivots[0]), " of M", words(deflated_pivots[1]))
by_matrix = checked(proof=critical)
print(by_matrix.claim)

# %% [markdown]
# $V = x^TPx + \zeta^2/\varrho + 2\theta\int\phi$. The conclusion is that of part 1, word for word, by another
# proof. The last pivot is 0.002; in floating point one would have to say how well that is known.
#
# This $P$ was found with a pencil. The search solves Riccati equations at order 400, and what it returns is rounded to
# dyadic numbers and read in just this way.

# %%
assert principal == (
    [Fraction(9, 4), Fraction(29, 36)],
    [2, Fraction(1, 2), Fraction(3, 40)],
)
assert rho == residue
assert deflated_pivots[1][:2] == [Fraction(1, 32), Fraction(191, 64)]
assert deflated_pivots[1][2] == Fraction(20, 59) - Fraction(1, 512) - Fraction(
    64, 191
)
assert min(deflated_pivots[0]) > 0
assert round(float(deflated_pivots[1][2]), 3) == 0.002
assert by_matrix.certificate["conclusion"] == claim["conclusion"]

# %% [markdown]
# ## 3. An orbit
#
# In discrete time, $\sigma_{t+1} = \tfrac12\sigma_t + 2\mu_t + \tfrac{23}{25}\mu_{t-1}$ (example 6 of Carrasco, Heath,
# Zhang, Ahmad and Wang 2019). Every linear gain below $25/23$ stabilises it. Take a nonlinearity through four points,
# constant outside:

# %%
points = [
    ["-74498/72625", "-192/415"],
    ["-36864/72625", "-192/415"],
    ["0", "0"],
    ["192/175", "1"],
]
knots = [(Fraction(x), Fraction(y)) for x, y in points]
slopes = [(y2 - y1) / (x2 - x1) for (x1, y1), (x2, y2) in pairwise(knots)]
print("slopes between the points:", words(slopes))


def phi(x):
    """The nonlinearity."""
    if x <= knots[0][0] or x >= knots[-1][0]:
        return knots[0][1] if x <= knots[0][0] else knots[-1][1]
    i = max(i for i, (place, _) in enumerate(knots) if place <= x)
    return knots[i][1] + slopes[i] * (x - knots[i][0])


# mu[0] is the sample before
sigma, mu = [Fraction(-74498, 72625)], [-Fraction(1), Fraction(192, 415)]
for _ in range(3):
    sigma.append(sigma[-1] / 2 + 2 * mu[-1] + Fraction(23, 25) * mu[-2])
    mu.append(-phi(sigma[-1]))
print("sigma:", words(sigma))
print("mu:   ", words(mu[1:]))

_, ax = plt.subplots(figsize=(4.8, 3), layout="constrained")
law_x, law_y = (np.array([float(pair[i]) for pair in knots]) for i in (0, 1))
ax.plot(
    [-1.5, *law_x, 1.5], [law_y[0], *law_y, law_y[-1]], color=BLUE, lw=1.4, label="φ"
)
ax.plot(
    sigma[:3], [-u for u in mu[1:4]], "o", ms=5, color=VERMILLION, label="visited"
)
for i, (x, u) in enumerate(zip(sigma[:3], mu[1:4], strict=True)):
    ax.annotate(
        f"t = {i}",
        (x, -u),
        (-4, 8),
        textcoords="offset points",
        fontsize="small",
        ha="right",
    )
ax.set(
    xlabel="σ [unit of σ]",
    ylabel="φ(σ) [unit of μ]",
    xlim=(-1.5, 1.5),
    ylim=(-0.6, 1.2),
)
finish_axes(ax)
ax.legend(loc="lower right", frameon=False)
plt.show()

# %% [markdown]
# After three samples everything is back: an orbit of period 3, under a nondecreasing nonlinearity of slope at most
# $175/192 = 0.9115$. No claim about all nonlinearities of slope $[0, 175/192]$ can therefore be true, whatever
# multiplier stands in it; a checker that accepts one is broken. (The nonlinearity is not odd. For odd nonlinearities
# such claims are true up to $25/23$; see [when criteria fail](80-when-criteria-fail.py).)

# %%
monotone = {**SECTOR, "sector": ["0", "175/192"], "slope": ["0", "175/192"]}
discrete = {
    "kind": "transfer",
    "time": "discrete",
    "numerator": ["2", "23/25"],
    "denominator": ["1", "-1/2", "0"],
}
orbit = {"method": "orbit", "points": points, "left": "0", "right": "0"}
orbit |= {"u": [str(x) for x in mu[1:4]], "sigma": [str(x) for x in sigma[:3]]}
example = {"system": discrete, "laws": monotone, "proof": orbit}
refuted = complete_and_check({**AGAINST, **example})
print(f"{type(refuted).__name__}: {refuted.claim}")

# %%
assert sigma[3] == sigma[0]
assert mu[-1] == mu[1]
assert mu[-2] == mu[0]
assert len(set(sigma)) == 3
assert sorted(set(mu)) == [-1, Fraction(192, 415)]
assert slopes == [0, Fraction(175, 192), Fraction(175, 192)]
assert round(175 / 192, 4) == 0.9115
# z^2 - (1/2 - 2 g) z + 23 g/25 is stable while 23 g/25 < 1 and |1/2 - 2 g| < 1 + 23 g/25
limit = Fraction(25, 23)
assert Fraction(23, 25) * limit == 1
assert abs(Fraction(1, 2) - 2 * limit) < 2
assert type(refuted).__name__ == "Refuted"
assert all(mu[i + 1] == -phi(x) for i, x in enumerate(sigma))

# %% [markdown]
# ## 4. The checker alone
#
# `checker.py` and the seventeen files beside it need Python and nothing else. We copy all into an empty folder and
# run them without installed packages (`-S`), without the environment's variables (`-E`), isolated (`-I`): first on the
# file of part 1, then with 76 for 77, then on no certificate at all.

# %%
BESIDE = [
    "arithmetic",
    "balls",
    "blocks",
    "boxes",
    "channels",
    "frequencies",
    "gains",
    "memory",
    "parametric",
]
BESIDE += [
    "parts",
    "pieces",
    "powers",
    "regions",
    "several",
    "signals",
    "states",
    "windows",
]
with tempfile.TemporaryDirectory() as folder:
    kernel = Path(folder, "kernel")
    kernel.mkdir()
    for name in ("checker", *BESIDE):
        shutil.copy(Path(checker.__file__).with_name(f"{name}.py"), kernel)
    statuses = []
    for text in (file, file.replace('"-77"', '"-76"'), "trust me"):
        Path(folder, "certificate.json").write_text(text, encoding="utf-8")
        alone = ["-S", "-E", "-I", "kernel/checker.py", "certificate.json"]
        command = [sys.executable, *alone]
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False
        )
        statuses.append(done.returncode)
        print(f"{done.stdout}status {done.returncode}\n")
assert statuses == [0, 11, 2]

# %% [markdown]
# The format and the theorems, each with its source, are in [note 8](notes/0008-certificates.md). A second checker, on
# another library and written from the theorems and not from the first, must agree on every certificate of the tests:
# `lure verify --second`.
