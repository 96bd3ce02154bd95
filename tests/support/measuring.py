"""Simulated measurements with known nonlinearities."""

import numpy as np

from lure.analysis.measured import Measurements

EPS, GAP, DEEPEST = 2e-9, 1.2e-4, 1e-3


def compliance_data(seed, *, m=1.5, noise=0.02, kind="constant", rows=150):
    """A contact pressed from 0.3 mm short of the origin to 1 mm: the data, and the true (eps, gap, m).

    The noise is a share of the largest load, or of each load (and at least of 1 % of the largest).
    """
    random = np.random.default_rng(seed)
    u = np.linspace(-3e-4, DEEPEST, rows)
    eps = EPS * DEEPEST ** (m - 1.5)  # about the same largest load for every m
    load = np.maximum(u - GAP, 0.0) ** m / eps
    size = load.max() if kind == "constant" else np.maximum(load, 0.01 * load.max())
    return Measurements.from_arrays(u, load + noise * size * random.standard_normal(rows), unit="Pa"), (eps, GAP, m)


def covers(fit, truth, which="joint"):
    """Whether each interval of a fit contains the truth."""
    found = [getattr(fit.parameters[name], which) for name in ("eps", "gap", "m")]
    return [low <= value <= high for (low, high), value in zip(found, truth, strict=True)]
