"""Simulated elements with and without memory, driven along a path of displacements."""

from itertools import pairwise

import numpy as np


def path(branches, rows, *, seed=None, low=-1.0):
    """(branches * rows + 1,) displacements from `low` to 1 and back; with a seed, each turn at a random place."""
    random = np.random.default_rng(seed)
    turns = [low if k % 2 == 0 else 1.0 for k in range(branches + 1)]
    if seed is not None:
        turns = [
            low + (1 - low) * random.uniform(*((0.0, 0.3) if k % 2 == 0 else (0.7, 1.0))) for k in range(branches + 1)
        ]
    pieces = [np.linspace(a, b, rows + 1)[:-1] for a, b in pairwise(turns)]
    return np.append(np.concatenate(pieces), turns[-1])


def play(u, half=0.15):
    """The play operator (backlash of width 2 half): the output moves when the input pushes one of the two sides."""
    out, w = np.empty_like(u), float(np.clip(0.0, u[0] - half, u[0] + half))
    for i, x in enumerate(u):
        w = min(max(w, x - half), x + half)
        out[i] = w
    return out


def bouc_wen(u, *, alpha=0.4, beta=8.0, gamma=4.0):
    """alpha u + (1 - alpha) z with dz = (1 - |z| (gamma + beta sign(z du))) du, integrated in small steps of u."""
    z, out = 0.0, np.empty_like(u)
    out[0] = alpha * u[0]
    for i in range(1, u.size):
        steps = 20
        du = (u[i] - u[i - 1]) / steps
        for _ in range(steps):
            z += du * (1 - (gamma + beta * np.sign(z * du)) * abs(z)) if du else 0.0
        out[i] = alpha * u[i] + (1 - alpha) * z
    return out


def preisach(u, widths=(0.05, 0.1, 0.2, 0.3)):
    """A spring with plays of several widths in parallel: a Prandtl-Ishlinskii element, a special case of Preisach's."""
    return 0.5 * u + 0.5 * np.mean([play(u, half) for half in widths], axis=0)


def viscous(u, share=0.3):
    """u plus a force in proportion to the velocity, of steps of one duration."""
    return u + share * np.gradient(u) / np.abs(np.gradient(u)).max()


LOOPS = {"play": play, "Bouc-Wen": bouc_wen, "Preisach": preisach, "viscous": viscous}
NONLINEARITIES = {
    "spring": lambda u: u,
    "saturation": lambda u: np.clip(2 * u, -1, 1),
    "Hertz": lambda u: np.maximum(u, 0) ** 1.5,
    "tanh": lambda u: np.tanh(3 * u),
    "cubic": lambda u: 0.2 * u + 0.8 * u**3,
    "relay": np.sign,
}


def errors(size, seed, correlation=0.0):
    """Normal errors of deviation 1, first-order autoregressive."""
    white = np.random.default_rng(seed).standard_normal(size)
    out = white.copy()
    for i in range(1, size):
        out[i] = correlation * out[i - 1] + np.sqrt(1 - correlation**2) * white[i]
    return out
