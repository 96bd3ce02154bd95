"""Where a sweep is kept: a Zarr store with one array a variable, and beside it which chunks are done.

A worker writes the values of one chunk, which are whole files of the store, and then its marker.  What has no marker
was not done, whatever files there are: an interrupted chunk is computed again, and a chunk that is done is not.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import platform
import re
import secrets
import shutil
import warnings
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
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
_WHOLE, _WIDER, _BEGUN, _HALF_WIDER = ".lure/whole.json", ".lure/wider", ".lure/begun", "wider"
MOST_FILES = 10_000
WIDE = 200_000  # values of a chunk of a store that was put together in the end
QUESTION, FAILED = "question", "failed"


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
        self.removed = 0  # what runs that were killed had left half made
        self._arrays: dict[str, Any] = {}  # by variable, open for the chunks that this process writes

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
        label, known = shown_path(str(self.path)), self.path / _STUDY
        wanted = {"study": self.study.digest, "code": code_version()}
        try:
            for folder in (self.path.parent, self.path / ".lure"):
                self.removed += _without_leftovers(folder, {self.path.name, _HALF_WIDER})
            if known.is_file():
                there = json.loads(known.read_text(encoding="utf-8"))
                if there.get("study") != wanted["study"]:
                    raise InputError(f"{label} holds another study; give another -o, or remove it")
                if there.get("code") != wanted["code"]:
                    raise InputError(f"{label} was begun with another version of lure; give another -o, or remove it")
                self._finish_wider()
                return len(self.done())
            if self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
                raise InputError(f"{label} exists and is no sweep of lure; give another -o")
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._make(wanted)
        except OSError as error:
            raise InputError(f"{label} cannot be written ({error.strerror}); give another -o") from None
        except (json.JSONDecodeError, UnicodeDecodeError, AttributeError):
            raise InputError(f"{label} is no sweep of lure that can be read; give another -o, or remove it") from None
        return 0

    def _make(self, wanted: Mapping[str, str]) -> None:
        """The whole store aside, without any answer, and then moved into place."""
        aside = _aside(self.path.parent, self.path.name)
        try:
            with _quiet():
                self._group(aside, self.study.chunk)
                zarr.consolidate_metadata(aside)
            (aside / _DONE).mkdir(parents=True)
            (aside / _STUDY).write_text(
                json.dumps({**wanted, "text": self.study.text, "reference": self.study.reference}), encoding="utf-8"
            )
            if self.path.is_dir():
                self.path.rmdir()
            aside.rename(self.path)
        finally:
            shutil.rmtree(aside, ignore_errors=True)

    def _group(self, path: Path, chunk: tuple[int, ...]) -> zarr.Group:
        """A group with an empty array for each variable, and the coordinates."""
        study, questions = self.study, (len(self.study.ask),) * (len(self.study.ask) > 1)
        group = zarr.create_group(path, attributes=self._attributes())
        for name, one in self.variables.items():
            text = one.kind == "text"
            drawn = {"coordinates": " ".join(study.keys)} if study.draw is not None else {}
            group.create_array(
                name,
                shape=(*study.shape, *questions),
                chunks=(*chunk, *questions),
                dtype=str if text else "float64",
                fill_value="" if text else np.nan,
                dimension_names=self.dimensions,
                attributes={"long_name": one.text, "units": one.unit, **drawn},
                config={"write_empty_chunks": True},
            )
        for name, along, values in self._coordinates():
            array = group.create_array(
                name, shape=values.shape, dtype=values.dtype, dimension_names=along, chunks=values.shape
            )
            array[:] = values
        return group

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
            "meaning": f"each row is the answer of {'all plants of one box' if study.boxes else 'one point'}; "
            "a row with a sentence in error has no answer",
            "boxes": study.boxes,
        }

    def _coordinates(self) -> Iterable[tuple[str, tuple[str, ...], np.ndarray[Any, Any]]]:
        """Names, dimensions and values of the coordinates."""
        for key, values in self.study.drawn.items():
            yield key, self.study.dimensions, np.asarray(values)
        for axis in self.study.axes:
            found = axis.coordinates
            yield axis.key, (axis.key,), np.asarray(found, dtype=str if isinstance(found[0], str) else float)
            if axis.edges:
                yield f"{axis.key} bounds", (axis.key, "end"), np.array(list(pairwise(axis.edges)))
        if len(self.study.ask) > 1:
            yield QUESTION, (QUESTION,), np.asarray(self.study.ask, dtype=str)

    def done(self) -> set[int]:
        """The chunks that are done."""
        if (self.path / _WHOLE).is_file():
            return set(range(self.study.chunks))
        return {int(entry.name) for entry in os.scandir(self.path / _DONE) if entry.name.isdigit()}

    def begin(self, number: int) -> None:
        """Note that a chunk is begun.

        Parameters
        ----------
        number : int
            Of the chunk.
        """
        with (self.path / _BEGUN).open("a", encoding="ascii") as file:
            file.write(f"{number}\n")

    def repeated(self) -> int:
        """How many times a chunk was begun again, as what computed it had been stopped."""
        begun = self.path / _BEGUN
        numbers = begun.read_text(encoding="ascii").split() if begun.is_file() else []
        return len(numbers) - len(set(numbers))

    def counts(self) -> tuple[Counter[str], str]:
        """How many answers of the chunks that are done have which verdict, how many failed, and why the first did."""
        whole = self.path / _WHOLE
        paths = [whole] if whole.is_file() else [self.path / _DONE / str(number) for number in sorted(self.done())]
        total, first = Counter[str](), ""
        for path in paths:
            found = json.loads(path.read_text(encoding="utf-8"))
            total, first = total + Counter(found["counts"]), first or found["error"]
        return total, first

    def values(self, number: int) -> dict[str, np.ndarray[Any, Any]]:
        """What a chunk that is done holds, by variable.

        Parameters
        ----------
        number : int
            Of the chunk.
        """
        region = self.study.region(number)
        with _quiet():
            group = zarr.open_group(self.path, mode="r")
            return {name: np.asarray(_array(group, name)[region]) for name in self.variables}

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
        rows = [row for point in points for row in point]
        with _quiet():
            arrays, self._arrays = self._arrays, {}  # opened anew after a chunk that could not be written
            if not arrays:
                group = zarr.open_group(self.path, mode="r+", use_consolidated=False)
                arrays = {name: _array(group, name) for name in self.variables}
            for name, one in self.variables.items():
                empty = "" if one.kind == "text" else np.nan
                values = np.array([row.get(name, empty) for row in rows], dtype=str if one.kind == "text" else float)
                arrays[name][region] = values.reshape(*shape, *([len(self.study.ask)] if several else []))
            self._arrays = arrays
        if certificates:
            folder = self.path / _CERTIFICATES
            folder.mkdir(exist_ok=True)
            aside = folder / f".{number}.{secrets.token_hex(4)}"
            with gzip.open(aside, "wt", encoding="ascii") as file:
                file.writelines(json.dumps(one) + "\n" for one in certificates)
            aside.replace(folder / f"{number}.jsonl.gz")
        error = next((row["error"] for row in rows if row.get("error")), "")
        aside = self.path / _DONE / f".{number}.{secrets.token_hex(4)}"
        aside.write_text(_marker(Counter(row["verdict"] or FAILED for row in rows), error), encoding="utf-8")
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
        with _quiet():
            if zarr.open_group(self.path, mode="r").attrs.get(name) == value:  # a store that is done may be read-only
                return
            zarr.open_group(self.path, mode="r+").attrs[name] = value
            zarr.consolidate_metadata(self.path)

    # Many files, put together in the end.

    def widen(self, most: int = MOST_FILES) -> bool:
        """Put a store that is done, and has more than so many files, together in larger chunks; whether it was.

        Killed at any moment, it is done again, or finished, by whoever opens the store next.

        Parameters
        ----------
        most : int
            Files that are left as they are.
        """
        if self.study.chunks * len(self.variables) <= most or (self.path / _WHOLE).is_file():
            return False
        aside = _aside(self.path / ".lure", _HALF_WIDER)
        chunk = self.study.chunks_of(WIDE)
        try:
            with _quiet():
                old, new = zarr.open_group(self.path, mode="r"), self._group(aside, chunk)
                for name in self.variables:
                    source, target = _array(old, name), _array(new, name)
                    for region in self.study.regions(chunk):
                        target[region] = source[region]
            (aside / "whole.json").write_text(_marker(*self.counts()), encoding="utf-8")
            aside.rename(self.path / _WIDER)
        finally:
            shutil.rmtree(aside, ignore_errors=True)
        self._finish_wider()
        return True

    def _finish_wider(self) -> None:
        """Move what was put together into place, a variable at a time, and then say so."""
        wider = self.path / _WIDER
        if not wider.is_dir():
            return
        for name in self.variables:
            if (wider / name).is_dir():
                shutil.rmtree(self.path / name, ignore_errors=True)
                (wider / name).rename(self.path / name)
        with _quiet():
            zarr.consolidate_metadata(self.path)
        if (wider / "whole.json").is_file():
            (wider / "whole.json").replace(self.path / _WHOLE)
        shutil.rmtree(self.path / _DONE, ignore_errors=True)
        shutil.rmtree(wider)


def _aside(folder: Path, name: str) -> Path:
    """A new name for what is moved into place when it is whole; it says which process makes it."""
    return folder / f".{name}.{_host()}-{os.getpid()}-{secrets.token_hex(4)}"


@cache
def _host() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]


def _without_leftovers(folder: Path, names: Collection[str]) -> int:
    """Remove what processes of this machine that are gone had begun to make; how many there were."""
    made = re.compile(rf"\.({'|'.join(map(re.escape, names))})\.{_host()}-(\d+)-[0-9a-f]{{8}}")
    found = [(entry, made.fullmatch(entry.name)) for entry in folder.iterdir()] if folder.is_dir() else []
    gone = [entry for entry, match in found if match is not None and not _runs(int(match[2]))]
    for entry in gone:
        shutil.rmtree(entry, ignore_errors=True)
    return len(gone)


def _runs(process: int) -> bool:
    """Whether there is such a process on this machine, as far as can be told."""
    if os.name == "nt":  # where signal 0 interrupts
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # it is somebody else's
        return True
    return True


def _marker(counts: Counter[str], error: str) -> str:
    return json.dumps({"counts": counts, "error": error})


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Zarr's warning that texts have no data type in its specification yet."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _array(group: zarr.Group, name: str) -> Any:  # noqa: ANN401  (Zarr's types know no names)
    return group[name]
