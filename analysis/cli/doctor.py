"""What is installed, for `lure doctor`."""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version

from lure import __version__

NEEDED = (
    *("control", "jinja2", "matplotlib", "numpy", "pydantic", "python-flint", "rich", "scipy", "sympy"),
    *("threadpoolctl", "typer"),
)
OPTIONAL = {  # the extras of pyproject.toml that a user chooses
    "fast": ("numba",),
    "netcdf": ("netCDF4", "xarray"),
    "cvode": ("scikit-sundae",),
    "pdf": ("weasyprint",),
    "notebooks": ("ipykernel", "ipywidgets", "jsonschema", "jupytext", "nbmake"),
    "testing": ("hypothesis", "pytest"),
}


def findings() -> tuple[list[str], bool]:
    """Lines to print, and whether everything that lure needs is there."""
    versions = {name: _version(name) for name in NEEDED}
    lines = [
        f"lure {__version__}, Python {platform.python_version()} ({platform.system()} {platform.machine()})",
        "",
        "Needed",
        *(f"  {name:<14}{found or 'MISSING'}" for name, found in versions.items()),
        f"  {'BLAS':<14}{_blas() if versions['numpy'] else 'unknown'}",
        "",
        'Optional (pip install "lure[fast]" and so on)',
    ]
    for extra, names in OPTIONAL.items():
        found = ", ".join(f"{name} {_version(name) or 'missing'}" for name in names)
        lines.append(f"  {extra:<14}{found}")
    lines += [
        "",
        "Terminal",
        f"  {'stdout':<14}{_stream(terminal=sys.stdout.isatty())}, {sys.stdout.encoding}",
        f"  {'stderr':<14}{_stream(terminal=sys.stderr.isatty())}"
        + ("; progress is shown there" if sys.stderr.isatty() else "; no progress is shown"),
        f"  {'colours':<14}{'off, NO_COLOR is set' if os.environ.get('NO_COLOR') else 'where the terminal has them'}",
    ]
    missing = [name for name, found in versions.items() if not found]
    lines += [
        "",
        f"Missing: {', '.join(missing)}; install lure again." if missing else "Everything lure needs is there.",
    ]
    return lines, not missing


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _blas() -> str:
    """Name and version of numpy's linear algebra, as numpy tells it."""
    import numpy as np

    try:
        library = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
        return f"{library['name']} {library['version']}"
    except (KeyError, TypeError):
        return "unknown"


def _stream(*, terminal: bool) -> str:
    return "a terminal" if terminal else "not a terminal"
