"""Files and folders that appear together when all is done, or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from lure.errors import InputError

if TYPE_CHECKING:
    import xarray


def check_targets(paths: Sequence[Path], *, replace: bool) -> None:
    """Refuse places that cannot be written to, before anything is computed; a name without a suffix is a folder.

    Parameters
    ----------
    paths : sequence of Path
        Files, and folders to come.
    replace : bool
        Whether files that exist may be replaced.

    Raises
    ------
    InputError
        Two are the same; one exists, is a directory, or lies in a directory that does not exist or is read-only.
    """
    if len({os.path.abspath(path) for path in paths}) < len(paths):
        raise InputError(f"{str(paths[-1])!r} is given for two results; give each a name of its own")
    for path in paths:
        try:
            _check_target(path, replace=replace)
            probe = _aside(path)
            probe.touch(exist_ok=False)
            probe.unlink()
        except InputError:
            raise
        except (OSError, ValueError) as error:  # ValueError: a NUL byte
            raise InputError(_unwritable(path, error)) from None


def _check_target(path: Path, *, replace: bool) -> None:
    label = repr(str(path))
    if not path.parent.is_dir():
        raise InputError(f"{str(path.parent)!r} is no directory; give a file in one that exists")
    if not path.suffix:
        if _exists(path) and not (path.is_dir() and not any(path.iterdir())):
            raise InputError(f"{label} exists; frames go to a folder that is new or empty, give another name")
    elif path.is_dir():
        raise InputError(f"{label} is a directory; give the name of a file")
    elif _exists(path) and not replace:
        raise InputError(f"{label} exists; give another name, or --replace to replace it")


def _exists(path: Path) -> bool:
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True


@contextmanager
def written(paths: Sequence[Path], *, replace: bool) -> Iterator[dict[Path, Path]]:
    """Places beside the targets to write to; all are moved into place when the block ends well, and removed if not.

    Parameters
    ----------
    paths : sequence of Path
        As for :func:`check_targets`.
    replace : bool
        Whether files that exist may be replaced.

    Yields
    ------
    dict of Path to Path
        For each target the file, not there yet, or the folder, empty, to write to.

    Raises
    ------
    InputError
        A target appeared meanwhile, or the system refuses to write.
    """
    aside = {path: _aside(path) for path in paths}
    try:
        for path, place in aside.items():
            if not path.suffix:
                place.mkdir()
        yield aside
        check_targets(paths, replace=replace)
        for path, place in aside.items():
            place.replace(path)
    except OSError as error:
        raise InputError(_unwritable(paths[0] if len(paths) == 1 else Path(str(paths[0].parent)), error)) from error
    finally:
        for place in aside.values():
            with suppress(OSError):
                shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)


def check_netcdf() -> None:
    """Refuse to begin what ends in a netCDF file without the packages that write one.

    Raises
    ------
    InputError
        xarray or netCDF4 is not installed.
    """
    try:
        import netCDF4
        import xarray
    except ImportError as error:
        raise InputError(f'a netCDF file needs {error.name}: pip install "lure[netcdf]"') from None
    del netCDF4, xarray


def write_dataset(dataset: xarray.Dataset, path: Path) -> None:
    """Write a Dataset as netCDF 4, the same bytes for the same Dataset; tables are compressed without loss.

    Parameters
    ----------
    dataset : xarray.Dataset
        From :func:`lure.analysis.rod.runs.run_dataset`.
    path : Path
        The file; one that exists is replaced.

    Raises
    ------
    InputError
        netCDF4 is not installed.
    OSError
        The file cannot be written.
    """
    check_netcdf()
    encoding = {
        str(name): {"_FillValue": None, **({"zlib": True, "complevel": 4} if variable.ndim > 1 else {})}
        for name, variable in dataset.variables.items()
    }
    dataset.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=encoding)


def _aside(path: Path) -> Path:
    return path.with_name(f".lure-{secrets.token_hex(4)}{path.suffix}")


def _unwritable(path: Path, error: Exception) -> str:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"{str(path)!r} cannot be written ({reason}); give another place"
