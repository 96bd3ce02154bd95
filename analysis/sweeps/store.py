"""Where a sweep is kept: a Zarr store with one array a variable, and beside it which chunks are done.

A worker writes the values of one chunk, which are whole files of the store, and then its marker.  What has no marker
was not done, whatever files there are: an interrupted chunk is computed again, and a chunk that is done is not.  The
files are written here, as the specification of Zarr 3 has them [1]_: a file costs a tenth of a millisecond that way,
and two and a half through the library, which the processes then need not even import.

References
----------
.. [1] Zarr core specification version 3, codecs ``bytes``, ``vlen-utf8`` and ``gzip``; https://zarr-specs.readthedocs.io
"""

from __future__ import annotations

import errno
import gzip
import hashlib
import json
import math
import os
import platform
import re
import secrets
import shutil
import struct
import warnings
import zlib
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from itertools import pairwise
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lure import __version__
from lure.analysis.sweeps.rows import Certificate, Kind, Row, variables
from lure.analysis.sweeps.study import Study
from lure.errors import InputError
from lure.files.values import shown_path

if TYPE_CHECKING:
    import zarr

_DONE, _STUDY, _CERTIFICATES = ".lure/done", ".lure/study.json", ".lure/certificates"
_WHOLE, _WIDER, _BEGUN, _HALF_WIDER, _PART = ".lure/whole.json", ".lure/wider", ".lure/begun", "wider", "part"
_LEVEL = 1  # of compression
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

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Of every variable: those of the study, and the questions where there are several."""
        return (*self.study.dimensions, *([QUESTION] if len(self.study.ask) > 1 else []))

    def there(self) -> bool:
        """Whether the store is there, and may be taken up; what a run that was killed left half made is removed.

        Raises
        ------
        InputError
            There is something else, or another study.
        """
        label, known = shown_path(str(self.path)), self.path / _STUDY
        try:
            for folder in (self.path.parent, self.path / ".lure"):
                self.removed += _without_leftovers(folder, {self.path.name, _HALF_WIDER})
            if not known.is_file():
                if self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
                    raise InputError(f"{label} exists and is no sweep of lure; give another -o")
                return False
            held = json.loads(known.read_text(encoding="utf-8"))
            if held.get("study") != self.study.digest:
                raise InputError(f"{label} holds another study; give another -o, or remove it")
            if held.get("code") != code_version():
                raise InputError(f"{label} was begun with another version of lure; give another -o, or remove it")
            self._finish_wider()
            self._forget_what_is_not_whole()
        except OSError as error:
            raise InputError(f"{label} cannot be written ({error.strerror}); give another -o") from None
        except (json.JSONDecodeError, UnicodeDecodeError, AttributeError):
            raise InputError(f"{label} is no sweep of lure that can be read; give another -o, or remove it") from None
        return True

    def make(self) -> None:
        """The whole store aside, without any answer, and then moved into place; or that which another process has made.

        Raises
        ------
        InputError
            It cannot be written.
        """
        import zarr

        aside = _aside(self.path.parent, self.path.name)
        held = {"study": self.study.digest, "code": code_version()}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with _quiet():
                self._group(aside, self.study.chunk)
                zarr.consolidate_metadata(aside)
            (aside / _DONE).mkdir(parents=True)
            (aside / _STUDY).write_text(
                json.dumps({**held, "text": self.study.text, "reference": self.study.reference}), encoding="utf-8"
            )
            with suppress(FileNotFoundError, NotADirectoryError):
                self.path.rmdir()
            aside.rename(self.path)
        except OSError as error:
            if error.errno in (errno.ENOTEMPTY, errno.EEXIST) and self.there():
                return
            raise InputError(
                f"{shown_path(str(self.path))} cannot be written ({error.strerror}); give another -o"
            ) from None
        finally:
            shutil.rmtree(aside, ignore_errors=True)

    def _forget_what_is_not_whole(self) -> None:
        """Take away the markers of chunks whose files are not as they were written, as a power cut may leave them."""
        if (self.path / _WHOLE).is_file():
            check_files(self.path, self.variables)
            return
        _without_leftovers(self.path / _DONE, {_PART})
        for number in self.done():
            marker = self.path / _DONE / str(number)
            try:
                sizes = json.loads(marker.read_bytes())["sizes"]
                files = self._files(number)
                whole = all(_intact(files[name], size) for name, size in sizes.items())
            except (FileNotFoundError, ValueError):
                whole = False
            if not whole:
                marker.unlink()

    def _group(self, path: Path, chunk: tuple[int, ...]) -> zarr.Group:
        """A group with an empty array for each variable, and the coordinates."""
        import zarr
        from zarr.codecs import GzipCodec

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
                compressors=GzipCodec(level=_LEVEL),
                dimension_names=self.dimensions,
                attributes={"long_name": one.text, "units": one.unit, **drawn},
                config={"write_empty_chunks": True},
            )
        for name, along, values in self._coordinates():
            array = group.create_array(
                name,
                shape=values.shape,
                dtype=values.dtype,
                dimension_names=along,
                chunks=values.shape,
                attributes=self._told(name.removesuffix(" bounds")),
            )
            array[:] = values
        return group

    def _told(self, key: str) -> dict[str, Any]:
        """What a key of the file is and in which unit, where its table says so."""
        table, _, name = key.partition(".")
        model = self.study.source.kind.tables.get(table)
        field = None if model is None else model.model_fields.get(name)
        if field is None or not field.description:
            return {}
        unit = re.search(r"\[([^],]+)\]", field.description)
        return {"long_name": field.description, **({"units": unit[1]} if unit else {})}

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
        """Note that a chunk is begun."""
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

    def values(self, name: str, places: np.ndarray[Any, Any] | None = None) -> np.ndarray[Any, Any]:
        """What the store holds of a variable: all of it, or what stands at some places.

        ``places``: (places, dimensions), whole numbers.
        """
        import zarr

        with _quiet():
            array: Any = zarr.open_array(self.path / name, mode="r")
            return np.asarray(array[...] if places is None else array.vindex[tuple(places.T)])

    def write(self, number: int, rows: Sequence[Row], certificates: Sequence[Certificate]) -> None:
        """Write the values of a chunk, and then its marker.

        ``number``: of the chunk; ``rows``: for each point of the chunk the row of each question; ``certificates``:
        certificates to keep.
        """
        blank = {name: "" if one.kind == "text" else math.nan for name, one in self.variables.items()}
        pick, sizes = itemgetter(*blank), dict[str, int]()
        columns = zip(*(pick(blank | row) for row in rows), strict=True)
        for (name, target), column in zip(self._files(number).items(), columns, strict=True):
            one = self.variables[name]
            if not any(column) if one.kind == "text" else all(map(math.isnan, column)):
                target.unlink(missing_ok=True)  # nothing is what Zarr takes a file that is missing for
                continue
            content = _encoded(self._filled(number, column, blank[name]), one.kind)
            self._put(target, content)
            sizes[name] = len(content)
        if certificates:
            lines = "".join(json.dumps(one) + "\n" for one in certificates)
            self._put(self.path / _CERTIFICATES / f"{number}.jsonl.gz", gzip.compress(lines.encode("ascii")))
        error = next((row["error"] for row in rows if row.get("error")), "")
        counts = Counter(row["verdict"] or FAILED for row in rows)
        self._put(self.path / _DONE / str(number), _marker(counts, error, sizes))

    def _files(self, number: int) -> dict[str, Path]:
        """Where a chunk of each variable lies."""
        place = "/".join(map(str, (*self.study.block(number), *([0] if len(self.study.ask) > 1 else []))))
        return {name: self.path / name / "c" / place for name in self.variables}

    def _filled(self, number: int, column: Sequence[Any], blank: str | float) -> Sequence[Any]:
        """The values of a chunk, filled up to the shape that all chunks have."""
        study, several = self.study, [len(self.study.ask)] if len(self.study.ask) > 1 else []
        if study.size(number) == math.prod(study.chunk):
            return column
        region = study.region(number)
        shape = [*(part.stop - part.start for part in region), *several]
        full = np.full([*study.chunk, *several], blank, dtype=object)
        full[tuple(slice(size) for size in shape)] = np.array(column, dtype=object).reshape(shape)
        return full.ravel().tolist()

    def _put(self, target: Path, content: bytes) -> None:
        """A whole file or none: it is made aside and moved into place."""
        aside = _aside(self.path / _DONE, _PART)
        try:
            aside.write_bytes(content)
            try:
                aside.replace(target)
            except FileNotFoundError:  # the first one there
                target.parent.mkdir(parents=True, exist_ok=True)
                aside.replace(target)
        except BaseException:  # also where the user interrupts: no part of a file stays behind
            aside.unlink(missing_ok=True)
            raise

    def note(self, name: str, value: int | str) -> None:
        """Write something of the whole run into the attributes of the store."""
        path = self.path / "zarr.json"
        held = json.loads(path.read_text(encoding="utf-8"))
        if held["attributes"].get(name) != value:  # a store that is done may be read-only
            held["attributes"][name] = value
            self._put(path, json.dumps(held, indent=2).encode())

    # Many files, put together in the end.

    def widen(self, most: int = MOST_FILES) -> bool:
        """Put a store that is done, and has more than so many files, together in larger chunks; whether it was.

        Killed at any moment, it is done again, or finished, by whoever opens the store next.

        ``most``: files that are left as they are.
        """
        if self.study.chunks * len(self.variables) <= most or (self.path / _WHOLE).is_file():
            return False
        import zarr

        aside = _aside(self.path / ".lure", _HALF_WIDER)
        chunk = self.study.chunks_of(WIDE)
        try:
            with _quiet():
                old, new = zarr.open_group(self.path, mode="r"), self._group(aside, chunk)
                for name in self.variables:
                    source, target = _array(old, name), _array(new, name)
                    for region in self.study.regions(chunk):
                        target[region] = source[region]
            (aside / "whole.json").write_bytes(_marker(*self.counts(), {}))
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
        import zarr

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
        if entry.is_dir():
            shutil.rmtree(entry, ignore_errors=True)
        else:
            entry.unlink(missing_ok=True)
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


def check_files(path: Path, names: Iterable[str]) -> None:
    """That the chunks of a store can be read.

    ``path``: of the store; ``names``: of its variables.

    Raises
    ------
    InputError
        One cannot.
    """
    for file in (file for name in names for file in (path / name / "c").rglob("*") if file.is_file()):
        if not _intact(file):
            raise InputError(
                f"{shown_path(str(file))} is damaged, as after a power cut; give the same lure sweep again, which "
                "computes the chunk anew, and where it says this too, remove the store first"
            )


def _intact(path: Path, size: int | None = None) -> bool:
    """Whether a chunk is as it was written: so long, with the checksum of gzip."""
    content = path.read_bytes()
    try:
        gzip.decompress(content)
    except (gzip.BadGzipFile, EOFError, zlib.error):
        return False
    return size in (None, len(content))


def _marker(counts: Counter[str], error: str, sizes: Mapping[str, int]) -> bytes:
    return json.dumps({"counts": counts, "error": error, "sizes": sizes}).encode()


def _encoded(values: Sequence[Any], kind: Kind) -> bytes:
    """The values of a chunk as the bytes of its file."""
    if kind == "number":
        plain = struct.pack(f"<{len(values)}d", *values)
    else:
        known = {text: text.encode(errors="replace") for text in set(values)}
        sized = {text: struct.pack("<I", len(each)) + each for text, each in known.items()}
        plain = struct.pack("<I", len(values)) + b"".join([sized[text] for text in values])
    return gzip.compress(plain, _LEVEL, mtime=0)


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Zarr's warning that texts have no data type in its specification yet."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _array(group: zarr.Group, name: str) -> Any:  # noqa: ANN401  (Zarr's types know no names)
    return group[name]
