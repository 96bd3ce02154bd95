"""The data set ``example.csv``: an indenter pressed into a rubber pad and withdrawn, made up by this script.

The pad obeys ``F = max(u - gap, 0)^m / eps`` with the numbers below; the load cell scatters by 0.15 N plus 1 % of the
force, and twice something knocked on the table.  Made up means that the answer is known: tests and the notebook compare
with it.  ``python -m lure.analysis.measured.example FILE`` writes the same bytes every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from lure.analysis.measured.reading import Measurements, read_measurements

# The data set that comes with the package.

EXAMPLE = Path(__file__).with_name("example.csv")
"""The file that :func:`lure.analysis.measured.example_measurements` reads; also ``lure.analysis.measured.EXAMPLE``."""


def example_measurements(*, area: float | None = None) -> Measurements:
    """A rubber pad pressed and released: 241 rows, two of them knocked; ``example_text`` says how they were made.

    Parameters
    ----------
    area : float, optional
        Area [m^2] to divide the force by, as in :func:`read_measurements`; the punch has 25e-6.

    Examples
    --------
    >>> len(example_measurements())
    241
    """
    return read_measurements(EXAMPLE, area=area)


EPS = 2.5e-7
"""[m^1.5/N]."""
GAP = 0.12e-3
"""[m]."""
EXPONENT = 1.5
DEEPEST = 0.8e-3
"""[m]."""
KNOCKS = {58: 6.5, 171: -4.0}
"""Row of the table, and error of the force there [N]."""
_SEED = 20260
_LOADING, _UNLOADING = 161, 80
_NOISE = (0.15, 0.01)
_HEAD = """\
# Indentation of a rubber pad by a flat punch, 25 mm^2
# Made up by analysis/measured/example.py: F = max(u - gap, 0)^m / eps, seed {seed}
# loading at 5 um/s, unloading at 10 um/s; the load cell is not filtered
time [s],displacement [um],force [N]
"""


def example_text() -> str:
    """The file as text."""
    random = np.random.default_rng(_SEED)
    down = np.linspace(0.0, DEEPEST, _LOADING)
    u = np.concatenate([down, np.linspace(DEEPEST, 0.0, _UNLOADING + 1)[1:]])
    time = np.concatenate([down / 5e-6, DEEPEST / 5e-6 + (DEEPEST - u[_LOADING:]) / 10e-6])
    force = np.maximum(u - GAP, 0.0) ** EXPONENT / EPS
    force = force + random.standard_normal(u.size) * (_NOISE[0] + _NOISE[1] * force)
    for row, knock in KNOCKS.items():
        force[row] += knock
    rows = [f"{t:.1f},{1e6 * x:.1f},{f:.3f}\n" for t, x, f in zip(time, u, force, strict=True)]
    return _HEAD.format(seed=_SEED) + "".join(rows)


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(example_text(), encoding="utf-8", newline="\n")
