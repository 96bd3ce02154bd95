"""Where a sweep is kept: a Zarr store with one array a variable, and beside it which chunks are done.

A worker writes the values of one chunk, which are whole files of the store, and then its marker.  What has no marker
was not done, whatever files there are: an interrupted chunk is computed again, and a chunk that is done is not.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import secrets
import shutil
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from lure import __version__
from lure.analysis.sweeps.rows import Certificate, Row, variables
from lure.analysis.sweeps.study import Study
from lure.errors import InputError
from lure.files.values import shown_path

_DONE, _STUDY, _CERTIFICATES = ".lure/done", ".lure/study.json", ".lure/certificates"
QUESTION = "question"


@cache
def code_version() -> str:
    """Of this package: its version and a digest of its source, so that a store never mixes two."""
    top = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder in (top, top / "analysis") if (top / "analysis").is_dir() else (top,):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return f"{__version__}+{digest.hexdigest()[:16]}"


class Store:
    """The store of a study.

    Parameters
    ----------
    path : Path
        The folder, such as ``study.zarr``.
    study : Study
        What it holds.
    """

    def __init__(self, path: Path, study: Study) -> None:
        self.path, self.study = path, study
        self.variables = variables(study.ask)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Of every variable: those of the study, and the questions where there are several."""
        return (*self.study.dimensions, *([QUESTION] if len(self.study.ask) > 1 else []))

    def open(self) -> int:
        """Make the store, or take up the one that is there; how many chunks are done.

        Raises
        ------
        InputError
            There is something else, another study, or no place to write.
        """
        label = shown_path(str(self.path))
        known = self.path / _STUDY
        wanted = {"study": self.study.digest, "code": code_version()}
        try:
            if known.is_file():
                there = json.loads(known.read_text(encoding="utf-8"))
                if there.get("study") != wanted["study"]:
                    raise InputError(f"{label} holds another study; give another -o, or remove it")
                if there.get("code") != wanted["code"]:
                    raise InputError(f"{label} was begun with another version of lure; give another -o, or remove it")
                return len(self.done())
            if self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
                raise InputError(f"{label} exists and is no sweep of lure; give another -o")
            self._make(wanted)
        except OSError as error:
            raise InputError(f"{label} cannot be written ({error.strerror}); give another -o") from None
        return 0

    def _make(self, wanted: Mapping[str, str]) -> None:
        """The whole store aside, without any answer, and then moved into place."""
        study = self.study
        aside = self.path.with_name(f".{self.path.name}.{secrets.token_hex(4)}")
        several = len(study.ask) > 1
        shape = (*study.shape, *([len(study.ask)] if several else []))
        chunk = (*study.chunk, *([len(study.ask)] if several else []))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # texts have no data type in Zarr's specification yet
                group = zarr.create_group(aside, attributes=self._attributes())
                for name, one in self.variables.items():
                    text = one.kind == "text"
                    array = group.create_array(
                        name,
                        shape=shape,
                        chunks=chunk,
                        dtype=str if text else "float64",
                        fill_value="" if text else np.nan,
                        dimension_names=self.dimensions,
                        config={"write_empty_chunks": True},
                    )
                    drawn = {"coordinates": " ".join(study.keys)} if study.draw is not None else {}
                    array.attrs.update({"long_name": one.text, "units": one.unit, **drawn})
                for name, along, values in self._coordinates():
                    array = group.create_array(
                        name, shape=values.shape, dtype=values.dtype, dimension_names=along, chunks=values.shape
                    )
                    array[:] = values
                zarr.consolidate_metadata(aside)
            (aside / _DONE).mkdir(parents=True)
            (aside / _STUDY).write_text(json.dumps({**wanted, "text": study.text}), encoding="utf-8")
            if self.path.is_dir():
                self.path.rmdir()
            aside.rename(self.path)
        finally:
            shutil.rmtree(aside, ignore_errors=True)

    def _attributes(self) -> dict[str, Any]:
        study = self.study
        return {
            "title": f"lure sweep of {study.system}",
            "system": study.source.title,
            "source": study.source.source,
            "ask": list(study.ask),
            "study": study.digest,
            "lure": code_version(),
            "points": study.points,
            "meaning": "each row is the answer of one point; a row with a sentence in error has no answer",
        }

    def _coordinates(self) -> Iterable[tuple[str, tuple[str, ...], np.ndarray[Any, Any]]]:
        """Names, dimensions and values of the coordinates."""
        for key, values in self.study.drawn.items():
            yield key, self.study.dimensions, np.asarray(values)
        for axis in self.study.axes:
            found = axis.coordinates
            yield axis.key, (axis.key,), np.asarray(found, dtype=str if isinstance(found[0], str) else float)
        if len(self.study.ask) > 1:
            yield QUESTION, (QUESTION,), np.asarray(self.study.ask, dtype=str)

    def done(self) -> set[int]:
        """The chunks that are done."""
        return {int(entry.name) for entry in os.scandir(self.path / _DONE) if entry.name.isdigit()}

    def write(self, number: int, points: Sequence[Sequence[Row]], certificates: Sequence[Certificate]) -> None:
        """Write the values of a chunk, and then its marker.

        Parameters
        ----------
        number : int
            Of the chunk.
        points : sequence of sequence of dict
            For each point of the chunk the row of each question.
        certificates : sequence of Mapping
            Certificates to keep.
        """
        region = self.study.region(number)
        shape = tuple(part.stop - part.start for part in region)
        several = len(self.study.ask) > 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            group = zarr.open_group(self.path, mode="r+")
            for name, one in self.variables.items():
                empty = "" if one.kind == "text" else np.nan
                cells = [[row.get(name, empty) for row in point] for point in points]
                values = np.array(cells, dtype=object if one.kind == "text" else float)
                values = values.reshape(*shape, *([len(self.study.ask)] if several else []))
                array: Any = group[name]
                array[region] = values.astype(str) if one.kind == "text" else values
        if certificates:
            folder = self.path / _CERTIFICATES
            folder.mkdir(exist_ok=True)
            aside = folder / f".{number}.{secrets.token_hex(4)}"
            with gzip.open(aside, "wt", encoding="ascii") as file:
                file.writelines(json.dumps(one) + "\n" for one in certificates)
            aside.replace(folder / f"{number}.jsonl.gz")
        aside = self.path / _DONE / f".{number}.{secrets.token_hex(4)}"
        aside.write_text(str(len(points)), encoding="ascii")
        aside.replace(self.path / _DONE / str(number))

    def note(self, name: str, value: int | str) -> None:
        """Write something of the whole run into the attributes of the store.

        Parameters
        ----------
        name : str
            The attribute.
        value : int or str
            Its value.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            zarr.open_group(self.path, mode="r+").attrs[name] = value
            zarr.consolidate_metadata(self.path)
