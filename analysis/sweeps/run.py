"""``sweep``: the chunks of a study, computed by several processes, kept as they come, taken up where they stopped."""

from __future__ import annotations

import errno
import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import forkserver
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np

from lure.analysis.sweeps.boundary import halved
from lure.analysis.sweeps.reading import read_study, study_of
from lure.analysis.sweeps.rows import APART, Answered, Certificate, Row, answered
from lure.analysis.sweeps.store import FAILED, Store
from lure.analysis.sweeps.study import Study
from lure.errors import InputError
from lure.files.reading import system_source
from lure.record import Record, described, quantity

if TYPE_CHECKING:
    import xarray

Keep = Literal["none", "sample", "all"]
KEEP: tuple[Keep, ...] = ("none", "sample", "all")
IN_FLIGHT = 4  # chunks for each process
ONE_IN = 1000  # rows that are computed again
MOST_AGAIN = 1000
_LOST = 3  # deaths of a process in turn, without a chunk done between them, after which the run ends
_READ_ONLY = (errno.EACCES, errno.EPERM, errno.EROFS)
_WATCH = 1.0  # [s] between two looks for a scheduler that went away


class SweepSummary(Record):
    """What a sweep has done."""

    store: str = quantity("The data set", label="")
    question: str = quantity("What was asked of what")
    points: int = quantity("Points of the study")
    answers: int = quantity("Answers: of each point one to each question")
    done: int = quantity("Points with a row, failed ones among them")
    failed: int = quantity("Answers that are a sentence which says why there is none")
    proved: int = quantity("Answers PROVED")
    refuted: int = quantity("Answers REFUTED")
    inconclusive: int = quantity("Answers INCONCLUSIVE")
    computed_now: int = quantity("Points computed in this run")
    first_error: str = quantity("What the first one that failed says", default="")
    lost: int = quantity("Times that a process died and what it was at was computed again", default=0)
    repeated: int = quantity("Chunks begun again in all runs, one at most for each process that was stopped", default=0)
    removed: int = quantity("Stores half made by runs that were killed, removed", default=0)
    refined: int = quantity("Points put where the verdict changes, beside those of the grid", default=0)
    checked_again: int = quantity("Rows computed again by the plain question and by both checkers", default=0)
    seconds: float = quantity("Time of this run", "s")

    def __str__(self) -> str:
        rest = self.points - self.done
        return (
            f"{self.question}. {self.done} of {self.points} points done, {self.computed_now} now in "
            f"{self.seconds:.1f} s: "
            f"{self.proved} PROVED, {self.refuted} REFUTED, {self.inconclusive} INCONCLUSIVE, {self.failed} failed."
            + (" Every point failed: nothing is said of any." if self.failed == self.answers else "")
            + (f" The first that failed: {self.first_error.rstrip('.')}." if self.first_error else "")
            + (f" Processes died {self.lost} times." if self.lost else "")
            + (f" Chunks begun again after an interruption: {self.repeated}." if self.repeated else "")
            + (" What a run that was killed had left half made was removed." if self.removed else "")
            + (f" {rest} are open; the same command goes on." if rest else "")
            + (f" {self.refined} points more stand where the verdict changes." if self.refined else "")
            + (" A sample, computed again and rechecked, agrees." if self.checked_again else "")
        )


class Pool(Protocol):
    """What computes chunks: this process, several of this machine, or a Dask cluster."""

    @property
    def workers(self) -> int:
        """How many processes there are."""

    def check(self) -> None:
        """Raise where what was submitted will never end."""

    def submit(self, number: int, job: Job) -> Future[int]:
        """Have a chunk computed."""

    def shutdown(self) -> None:
        """Let the processes go."""


def sweep(  # noqa: PLR0913  (a study, a store and five settings with defaults)
    study: Study | Mapping[str, Any] | Path | str,
    output: Path | str,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    certificates: Keep = "none",
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> SweepSummary:
    """Answer one question for every point of a study, and keep the answers in a Zarr store.

    The store opens with ``xarray.open_zarr``.  Interrupted at any moment, the same call goes on: nothing that is done
    is computed again, nothing is lost, and each process that dies repeats at most the chunk it was at.

    Parameters
    ----------
    study : Study, Mapping or path
        The study, the tables of its file, or the file.
    output : path
        The store, such as ``study.zarr``; one that holds the same study is continued.
    workers : int
        Processes.
    scheduler : str, optional
        Address of a Dask scheduler whose workers compute in place of processes of this machine.
    certificates : {"none", "sample", "all"}
        Which certificates are kept in the store, one of a chunk or all.
    seconds : float, optional
        Time allowed to each point.
    progress : callable, optional
        Called as ``progress(stage, done)``, ``0 <= done <= 1``.

    Returns
    -------
    SweepSummary
        Counts.

    Raises
    ------
    InputError
        The study or the store is no good, or processes died three times before anything was done.
    RuntimeError
        A row that was computed again differs, or a checker rejects its certificate: a bug.
    KeyboardInterrupt
        What is done is kept.
    """
    if not isinstance(study, Study):
        study = study_of(study) if isinstance(study, Mapping) else read_study(Path(study))
    if isinstance(workers, bool) or not isinstance(workers, int) or not 1 <= workers <= 1024:
        raise InputError(f"workers is {workers!r:.40}; give a whole number from 1 to 1024")
    if certificates not in KEEP:
        raise InputError(f"certificates is {certificates!r:.40}; give 'none', 'sample' or 'all'")
    begun, tell = time.monotonic(), progress or (lambda _stage, _done: None)
    store, asked = Store(Path(output), study), _Asked(workers, scheduler, certificates, seconds, tell)
    now, lost = _complete(store, asked)
    again, refined = computed_again(store, seconds), 0
    for between in halved(store):
        more, died = _complete(between, asked)
        now, lost, refined = now + more, lost + died, refined + between.study.points
        again += computed_again(between, seconds)
    with _writing(store.path):
        store.note("checked_again", again)
        store.widen()
    return replace(
        _summary(store),
        computed_now=now,
        lost=lost,
        refined=refined,
        checked_again=again,
        seconds=time.monotonic() - begun,
    )


class _Asked(NamedTuple):
    """How a sweep is to be made."""

    workers: int
    scheduler: str | None
    keep: Keep
    seconds: float | None
    tell: Callable[[str, float], None]


def _complete(store: Store, asked: _Asked) -> tuple[int, int]:
    """Compute what is left of a study: how many points, and how many times a process died."""
    study, there = store.study, store.there()
    done = store.done() if there else set()
    left = [number for number in range(study.chunks) if number not in done]
    job = Job(
        path=str(store.path.resolve()),
        study=replace(study),  # without what it has read
        digest=study.digest,
        keep=asked.keep,
        seconds=asked.seconds,
    )
    run = _Run(store, left, job, asked.tell)
    run.everything(lambda: _pool(min(asked.workers, len(left)), asked.scheduler), make=not there)
    missing = set(left) - store.done()
    if missing:
        raise InputError(
            f"{len(missing)} chunks were computed and are not in {store.path}; "
            "put the store where every worker writes to the same files"
        )
    asked.tell("some rows again", 1.0)
    return sum(study.size(number) for number in left), run.lost


class _Run:
    """The chunks that are left, handed to a pool a few at a time."""

    def __init__(self, store: Store, left: list[int], job: Job, tell: Callable[[str, float], None]) -> None:
        self.store, self.waiting, self.job, self.tell = store, list(reversed(left)), job, tell
        self.lost = self.in_vain = 0
        self.finished = store.study.chunks - len(left)

    def everything(self, opened: Callable[[], Pool], *, make: bool) -> None:
        """Compute them all; a pool whose process died is opened anew.

        A store that is to be made is made after the first pool is there: one that never comes leaves nothing behind,
        and processes begin meanwhile.
        """
        while self.waiting:
            pool = opened()
            try:
                if make:
                    self.store.make()
                    make = False
                lost = self._with(pool)
            finally:
                pool.shutdown()
            if lost is not None:  # what the others were at is done by now
                self._after_loss(lost)

    def _with(self, pool: Pool) -> list[int] | None:
        """Compute what is waiting; what was handed out when a process died."""
        running: dict[Future[int], int] = {}
        try:
            while self.waiting or running:
                most = max(IN_FLIGHT * pool.workers, 1)
                while self.waiting and len(running) < most:
                    running[pool.submit(self.waiting[-1], self.job)] = self.waiting[-1]
                    self.waiting.pop()
                over, _ = wait(running, timeout=_WATCH, return_when=FIRST_COMPLETED)
                pool.check()
                for future in over:
                    future.result()
                    del running[future]
                    self.finished, self.in_vain = self.finished + 1, 0
                    self.tell(f"{self.store.study.system}", self.finished / self.store.study.chunks)
        except (BrokenProcessPool, ImportError):  # what is imported here is not for want of memory alone
            return list(running.values())
        return None

    def _after_loss(self, begun: list[int]) -> None:
        """Take up what was handed out and has no marker; end where processes die and nothing gets done."""
        done = self.store.done()
        left = [number for number in begun if number not in done]
        self.lost += 1
        self.in_vain = self.in_vain + 1 if len(done) == self.finished else 1
        at = (left or self.waiting[::-1])[:1]  # none was handed out where no process could begin
        if self.in_vain >= _LOST and at:
            first = self.store.study.settings([part.start for part in self.store.study.region(at[0])])
            raise InputError(
                f"a process died {_LOST} times before anything was done at {', '.join(first)}, of too little memory "
                f"perhaps; what is done is kept in {self.store.path}: give fewer --workers and run it again"
            )
        self.finished = len(done)
        self.waiting += reversed(left)


class _Here:
    """A pool of one: the process itself."""

    workers = 0

    def check(self) -> None:
        """What is computed here ends."""

    def submit(self, number: int, job: Job) -> Future[int]:
        """Have a chunk computed, at once."""
        future: Future[int] = Future()
        future.set_result(computed(number, job))
        return future

    def shutdown(self) -> None:
        """Let nothing go."""


class _Processes:
    """Processes of this machine: copies of one that has imported what they need, where the system has a cheap copy."""

    def __init__(self, workers: int) -> None:
        self.workers, linux = workers, sys.platform.startswith("linux")
        if linux:
            forkserver.set_forkserver_preload(_imported())
            forkserver.ensure_running()
        context = multiprocessing.get_context("forkserver" if linux else "spawn")
        self._pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin)

    def check(self) -> None:
        """The pool itself tells when a process has died."""

    def submit(self, number: int, job: Job) -> Future[int]:
        """Have a chunk computed by one that is free."""
        try:
            return self._pool.submit(_to_the_end, number, job)
        except (OSError, EOFError) as error:  # the process that is copied has died
            raise BrokenProcessPool(str(error)) from None

    def shutdown(self) -> None:
        """Let them finish what they are at."""
        self._pool.shutdown(cancel_futures=True)


def _pool(workers: int, scheduler: str | None) -> Pool:
    if scheduler is not None:
        from lure.analysis.sweeps.cluster import Cluster

        return Cluster(scheduler)
    return _Here() if workers == 1 else _Processes(workers)


def _imported() -> list[str]:
    """What the question has had imported here, as it was asked of a point when the study was read."""
    return [name for name in sys.modules if name.startswith("lure.") and not {"cli", "plots"} & set(name.split("."))]


def _begin() -> None:
    """Of a process: leave interrupts to the parent, end when it has died, look for no garbage in what is imported."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _Ending.wish)
    parent = multiprocessing.parent_process()
    assert parent is not None, "it has been started by one"

    def watch() -> None:
        """End this process as soon as its parent has ended."""
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    gc.freeze()


class _Ending:
    """Whether a process is to end after its chunk: when one dies, the pool asks all others to end at once."""

    at_work = wanted = False

    @classmethod
    def wish(cls, *_given: object) -> None:
        """End, now or after the chunk."""
        cls.wanted = True
        if not cls.at_work:
            os._exit(0)


def _to_the_end(number: int, job: Job) -> int:
    """Compute a chunk in a process of a pool."""
    _Ending.at_work = True
    try:
        return computed(number, job)
    finally:
        _Ending.at_work = False
        if _Ending.wanted:
            os._exit(0)  # the pool is broken, and its queue may be held by the dead


@described(frozen=True, kw_only=True)
class Job:
    """What every process needs to compute chunks."""

    path: str = quantity("The store")
    study: Study = quantity("What it holds")
    digest: str = quantity("That of the study")
    keep: Keep = quantity("Which certificates are kept")
    seconds: float | None = quantity("Time allowed to each point")


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """What cannot be written ends the run with a sentence; what has no marker does not count as done."""
    try:
        yield
    except (OSError, MemoryError) as error:
        said = "too little memory" if isinstance(error, MemoryError) else error.strerror or str(error)
        remedy = "make it writable" if getattr(error, "errno", None) in _READ_ONLY else "make room"
        raise InputError(
            f"{path} cannot be written ({said}); what is done is kept: {remedy} and give the same command again"
        ) from None


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """Whether an interrupt came, also one that a search took for the end of its time."""
    seen = threading.Event()
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before == signal.SIG_IGN:
        yield seen
        return

    def interrupt(*_given: object) -> None:
        """Remember that the user interrupted, and pass it on."""
        seen.set()
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield seen
    finally:
        signal.signal(signal.SIGINT, before)


_KNOWN: dict[tuple[str, str], Store] = {}  # the store of a process, whose system was read once


def computed(number: int, job: Job) -> int:
    """Compute and keep one chunk; how many points it has.

    ``job``: of which study.

    Raises
    ------
    KeyboardInterrupt
        The user interrupted; nothing of the chunk is kept.
    """
    store = _KNOWN.get((job.path, job.digest))
    if store is None:
        _KNOWN.clear()
        store = _KNOWN[job.path, job.digest] = Store(Path(job.path), job.study)
    study = store.study
    rows: list[Row] = []
    kept: list[Certificate] = []
    with _writing(store.path):
        store.begin(number)
    with _interrupts() as interrupted:
        for place in study.of_chunk(number):
            answers = [answered(study.source, place, one, job.seconds) for one in study.ask]
            if interrupted.is_set():  # a search hands back what it had so far: no answer to keep
                raise KeyboardInterrupt
            rows += [each.row for each in answers]
            if job.keep == "all" or (job.keep == "sample" and not kept):
                kept += [one for each in answers for one in each.certificates]
    with _writing(store.path):
        store.write(number, rows, kept)
    return study.size(number)


# Rows again, by another way.


def computed_again(store: Store, seconds: float | None = None) -> int:
    """Compute a sample of the rows again, by the plain question and by both checkers; how many have an answer.

    ``store``: a store that is done; ``seconds``: time allowed to each.

    Raises
    ------
    RuntimeError
        One of them differs: a bug, and the store is not to be believed.
    """
    study = store.study
    count = min(max(study.points // ONE_IN, 1), MOST_AGAIN)
    chosen = np.random.default_rng(int(study.digest[:15], 16)).choice(study.points, count, replace=False)
    places = np.stack(np.unravel_index(np.sort(chosen), study.shape), axis=1)
    source, answers = system_source(study.reference), np.zeros(count, dtype=bool)
    for i, question in enumerate(study.ask):
        asked = np.insert(places, places.shape[1], i, axis=1) if len(study.ask) > 1 else places
        values = {name: store.values(name, asked) for name in store.variables}
        for j, place in enumerate(places.tolist()):
            found = answered(source, study.settings(place), question, seconds, plain=True)
            _demand_agreement(store, study.settings(place), found, {name: each[j] for name, each in values.items()})
            answers[j] |= not found.row.get("error")
    return int(answers.sum())


def _demand_agreement(store: Store, settings: list[str], found: Answered, kept: Mapping[str, Any]) -> None:
    for name, one in store.variables.items():
        if name in APART:
            continue
        value = found.row.get(name, "" if one.kind == "text" else np.nan)
        same = (
            str(value) == str(kept[name]) if one.kind == "text" else np.array_equal(value, kept[name], equal_nan=True)
        )
        if not same:
            raise RuntimeError(
                f"{', '.join(settings)}: {name} is {value}, and {kept[name]} in {store.path}: please report it"
            )
    from lure.analysis.certificates.checker import check
    from lure.analysis.certificates.second import recheck

    for certificate in found.certificates:
        check(certificate)
        opinion = recheck(certificate)
        if not opinion.accepted:
            raise RuntimeError(f"{', '.join(settings)}: the second checker says {opinion.reason}: please report it")


def opened(path: Path) -> xarray.Dataset:
    """The data set of a store."""
    import warnings

    import xarray

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found: xarray.Dataset = xarray.open_zarr(path, chunks=None)
    return found


def _summary(store: Store) -> SweepSummary:
    """What a store holds."""
    study, (counts, error) = store.study, store.counts()
    return SweepSummary(
        store=str(store.path),
        question=str(study),
        points=study.points,
        answers=study.points * len(study.ask),
        done=sum(study.size(number) for number in store.done()),
        failed=counts[FAILED],
        first_error=error,
        proved=counts["PROVED"],
        refuted=counts["REFUTED"],
        inconclusive=counts["INCONCLUSIVE"],
        computed_now=0,
        repeated=store.repeated(),
        removed=store.removed,
        seconds=0.0,
    )
