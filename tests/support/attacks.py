"""Attacks on what is proved of several nonlinearities: members of the classes, and whether solutions persist.

Nothing here uses a multiplier, a Lyapunov function of a proof or the searches of the house.  The loop is ``x' = A x + B
mu`` (``x+`` in discrete time), ``sigma = C x``, ``mu = -phi(sigma)``.
"""

import numpy as np
from scipy.linalg import block_diag, expm, solve_continuous_lyapunov, solve_discrete_lyapunov

GONE, STAYS = 1e-7, 0.999  # of the largest state: then it decays; of the window before: then it persists


def growth(A, discrete):
    """The largest real part of the eigenvalues, in discrete time the largest modulus less 1."""
    values = np.linalg.eigvals(A)
    return (np.abs(values).max(axis=-1) - 1) if discrete else values.real.max(axis=-1)


def ends_or_inside(rng, shape):
    """Numbers in [0, 1], most of them 0 or 1."""
    inside = rng.random(shape)
    return np.where(rng.random(shape) < 0.6, np.round(rng.random(shape)), inside)


def contraction(rng, size):
    """A random matrix of norm 1: orthogonal, or of rank one."""
    q, r = np.linalg.qr(rng.normal(size=(size, size)))
    return q * np.sign(np.diag(r)) if rng.random() < 0.5 else np.outer(q[0], q[:, -1])


def linear_member(classes, rng):
    """A constant matrix ``G`` with ``mu = -G sigma``, of which ReLUs have none."""
    parts = []
    for block in classes.blocks:
        one = classes.classes[block[0]]
        low, high = (float(v) for v in one.gains)
        if one.operator.startswith("scalar"):
            parts.append(high * rng.choice([-1.0, 1.0]) * np.eye(len(block)))
        elif one.operator:
            parts.append(high * contraction(rng, len(block)))
        else:
            parts.append((low + (high - low) * ends_or_inside(rng, ())) * np.eye(len(block)))
    return block_diag(*parts)


def worst_linear(parts, classes, rng, discrete, count=200):
    """The largest growth of constant linear members."""
    A, B, C = parts
    members = np.array([linear_member(classes, rng) for _ in range(count)])
    return float(growth(A - B @ members @ C, discrete).max())


def worst_period(parts, classes, rng, discrete, count=60, climbs=60):
    """The largest multiplier over a period of linear members that jump, the best of them changed a little at random."""
    A, B, C = parts
    longest = 2 / (1e-9 + np.abs(np.linalg.eigvals(A)).max())

    def multiplier(members, times):
        closed = A - B @ members @ C
        whole = np.eye(len(A))
        for one in closed if discrete else expm(closed * times[:, None, None]):
            whole = one @ whole
        return float(np.abs(np.linalg.eigvals(whole)).max()) ** (1 / len(times))

    best = (0.0, None, None)
    for k in range(count + climbs):
        if k < count or best[1] is None:
            size = rng.integers(1, 7)
            members = np.array([linear_member(classes, rng) for _ in range(size)])
            times = rng.exponential(longest, size)
        else:
            members, times = best[1].copy(), best[2] * np.exp(0.2 * rng.normal(size=len(best[2])))
            if discrete or rng.random() < 0.3:
                members[rng.integers(len(members))] = linear_member(classes, rng)
        found = multiplier(members, times)
        best = (found, members, times) if found > best[0] else best
    return best[0]


def with_dynamics(parts, classes, rng, discrete):
    """The plant with linear operators closed by ``r Q1 diag(all-pass) Q2``; the other channels stay."""
    A, B, C = parts
    rest = list(range(B.shape[1]))
    for block in classes.operators:
        one = classes.classes[block[0]]
        if one.time_varying:
            continue
        r, size = float(one.gains[1]), len(block)
        alike = one.operator.startswith("scalar")
        left, right = (np.eye(size),) * 2 if alike else (contraction(rng, size), contraction(rng, size))
        slow, fast = np.log(np.sort(np.abs(np.linalg.eigvals(parts[0])))[[0, -1]])
        a = np.exp(rng.uniform(slow - 1, fast + 1, size))  # slower ones take long to die out
        a = np.clip(np.tanh(rng.normal(size=size)), -0.95, 0.95) if discrete else a
        a = np.full(size, a[0]) if alike else a
        # continuous: (s - a)/(s + a) = 1 - 2 a/(s + a); discrete: (1 - a z)/(z - a) = -a + (1 - a^2)/(z - a)
        F, direct = np.diag(a if discrete else -a), np.diag(-a if discrete else np.ones(size))
        inputs, outputs = (np.diag(1 - a**2), np.eye(size)) if discrete else (np.diag(-2 * a), np.eye(size))
        Bb, Cb = B[:, list(block)] @ left * -r, right @ C[list(block)]  # mu_b = -r left (all-pass) right sigma_b
        A = np.block([[A + Bb @ direct @ Cb, Bb @ outputs], [inputs @ Cb, F]])
        B, C = np.vstack([B, np.zeros((size, B.shape[1]))]), np.hstack([C, np.zeros((len(C), size))])
        rest = [i for i in rest if i not in block]
    return (A, B[:, rest], C[rest]), rest


class Members:
    """``count`` members of the classes at once, for a simulation: functions with corners, gains that chase growth."""

    def __init__(self, parts, classes, rest, rng, discrete, count):
        A, B, C = parts
        self.parts, self.discrete, self.rng, m = parts, discrete, rng, len(rest)
        own = [classes.classes[i] for i in rest]
        self.low, self.high = (np.array([float(one.gains[k]) for one in own]) for k in range(2))
        same = {i: block for block in classes.blocks for i in block}
        self.first = [rest.index(same[i][0]) for i in rest]
        self.blocks = [[rest.index(i) for i in block] for block in classes.blocks if block[0] in rest]
        self.operators = [b for b in self.blocks if own[b[0]].operator]
        self.moves = np.array([one.time_varying and not one.operator for one in own])
        self.rate = np.array([float(one.rate) if one.rate else np.inf for one in own])
        self.sloped = np.array([one.slope is not None for one in own])
        self.share = ends_or_inside(rng, (count, m))
        corners = rng.exponential(1.0, (2, count, m, 4)).cumsum(axis=-1) * rng.choice([0.02, 1, 20], (count, m, 1))
        slopes = ends_or_inside(rng, (2, count, m, 5))
        for i, one in enumerate(own):
            if one.sector and not self.sloped[i]:
                slopes[:, :, i] = slopes[:, :, i] * 9 - 4  # clipped to the sector below
                slopes[:, :, i, 0] = rng.random((2, count))
            if one.odd:
                slopes[1, :, i], corners[1, :, i] = slopes[0, :, i], corners[0, :, i]
            if one.rectifier:
                slopes[0, :, i], slopes[1, :, i] = 1, 0
            if one.linear:
                slopes[:, :, i] = self.share[None, :, i, None]
        for i, k in enumerate(self.first):
            slopes[:, :, i], corners[:, :, i], self.share[:, i] = slopes[:, :, k], corners[:, :, k], self.share[:, k]
        self.start, self.corners, self.bends = slopes[..., 0], corners, np.diff(slopes, axis=-1)
        solve = solve_discrete_lyapunov if discrete else solve_continuous_lyapunov
        self.P = []
        for _ in range(count):  # V that gains try to raise
            base = A - B @ np.diag(self.low + (self.high - self.low) * rng.random()) @ C
            root = rng.normal(size=(len(A), len(A)))
            cost = root @ root.T if rng.random() < 0.7 else np.eye(len(A))
            stable = growth(base, discrete) < 0
            P = solve(base.T, cost if discrete else -cost) if stable else cost
            self.P.append(P / np.abs(P).max())
        self.P, self.greedy = np.array(self.P), rng.random(count) < 0.7
        self.gain = self.share.copy()
        self.pace = rng.exponential(0.2, (count, 1))

    def functions(self, sigma):
        """``phi`` less the lower bound, by its width: (count, m)."""
        size, side = np.abs(sigma), (sigma < 0).astype(int)[None]
        start = np.take_along_axis(self.start, side, axis=0)[0]
        corners = np.take_along_axis(self.corners, side[..., None], axis=0)[0]
        bends = np.take_along_axis(self.bends, side[..., None], axis=0)[0]
        found = start * size + (bends * np.maximum(size[..., None] - corners, 0)).sum(axis=-1)
        return np.sign(sigma) * np.where(self.sloped, found, np.clip(found, 0, size))

    def turn(self, x, step):
        """New gains for the next step: those that raise ``x'Px``, or at random; no faster than they may."""
        A, B, C = self.parts
        if not self.moves.any():
            return
        ahead = x @ A.T if self.discrete else x
        pull = -(np.einsum("ki,kij->kj", ahead, self.P) @ B) * (x @ C.T)
        drawn = np.where(self.rng.random(self.gain.shape) < self.pace, 1 - np.round(self.gain), self.gain)
        wanted = np.where(self.greedy[:, None], pull > 0, drawn)[:, self.first]
        most = self.rate * step / np.where(self.high > self.low, self.high - self.low, 1)
        self.gain = np.where(self.moves, self.gain + np.clip(wanted - self.gain, -most, most), self.gain)

    def moved(self, x):
        """``A x + B mu``."""
        A, B, C = self.parts
        sigma = x @ C.T
        inner = np.where(self.moves, self.gain * sigma, self.functions(sigma))
        mu = -(self.low * sigma + (self.high - self.low) * inner)
        for b in self.operators:
            pull = np.einsum("ki,kij->kj", x @ A.T if self.discrete else x, self.P) @ B[:, b]
            size = np.linalg.norm(pull, axis=1, keepdims=True) + 1e-300
            mu[:, b] = self.high[b[0]] * np.linalg.norm(sigma[:, b], axis=1, keepdims=True) * pull / size
        return x @ A.T + mu @ B.T


def late(parts, classes, rng, discrete, count=40, windows=8, first=64):
    """The largest state in the last window by that in the one before it, 0 for what decays; windows double.

    Near 1: a periodic or growing solution, or one that decays in many thousand steps.
    """
    reduced, rest = with_dynamics(parts, classes, rng, discrete)
    if not rest:
        return 2.0 if growth(reduced[0], discrete) >= 0 else 0.0
    members = Members(reduced, classes, rest, rng, discrete, count)
    A, B, C = reduced
    most = np.maximum(np.abs(members.low), members.high).max()
    step = 1.0 if discrete else 0.7 / (np.linalg.norm(A, 2) + most * np.linalg.norm(B, 2) * np.linalg.norm(C, 2))
    x = rng.normal(size=(count, len(A))) * np.geomspace(0.1, 1e3, count)[:, None]
    x[:, len(parts[0]) :] = 0  # operators are at rest
    largest = before = np.linalg.norm(x, axis=1)
    ratio = np.ones(count)
    for window in range(windows):
        now = np.zeros(count)
        for _ in range(first << window):
            members.turn(x, step)
            if discrete:
                x = members.moved(x)
            else:  # Runge and Kutta's method of order 4
                k1 = members.moved(x)
                k2 = members.moved(x + step / 2 * k1)
                k3 = members.moved(x + step / 2 * k2)
                x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + members.moved(x + step * k3))
            now = np.maximum(now, np.linalg.norm(x, axis=1))
        gone = now < GONE * largest
        ratio, before, largest = np.where(gone, 0, now / np.maximum(before, 1e-300)), now, np.maximum(largest, now)
        if gone.all() or now.max() > 1e30:
            break
    return float(ratio.max())


def attacked(parts, classes, rng, discrete, rounds=2, **sizes):
    """What the attacks found against the classes, in words; empty if nothing."""
    if not classes.rectified and worst_linear(parts, classes, rng, discrete) >= 0:
        return "a constant linear member"
    if all(one.time_varying and not one.rate for one in classes.classes) and (
        worst_period(parts, classes, rng, discrete) >= 1
    ):
        return "linear members that jump"
    for _ in range(rounds):
        found = late(parts, classes, rng, discrete, **sizes)
        if found > STAYS:
            return f"a solution that persists: {found:.6g} of the window before"
    return ""
