"""The data set that comes with the package."""

from __future__ import annotations

from pathlib import Path

from analysis.measured.measurements import Measurements
from analysis.measured.reading import read_measurements

PATH = Path(__file__).with_name("example.csv")
"""The file that :func:`analysis.measured.example_measurements` reads; also ``analysis.measured.EXAMPLE``."""


def example_measurements(*, area: float | None = None) -> Measurements:
    """A rubber pad pressed and released: 241 rows, two of them knocked; ``make_example.py`` says how they were made.

    Parameters
    ----------
    area : float, optional
        Area [m^2] to divide the force by, as in :func:`read_measurements`; the punch has 25e-6.

    Examples
    --------
    >>> len(example_measurements())
    241
    """
    return read_measurements(PATH, area=area)
