"""A Dask cluster, reached by the address of its scheduler, as the processes of a sweep."""

from __future__ import annotations

import asyncio
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any

from lure.analysis.sweeps.run import Job, computed
from lure.errors import InputError

_PATIENCE = 30  # [s] for a scheduler to answer, and for its first worker
_ONE_THREAD = "precision is one setting for a process"


class Cluster:
    """The workers of a scheduler; each computes one chunk at a time, and markers, not futures, say what is done.

    Parameters
    ----------
    address : str
        Such as ``tcp://127.0.0.1:8786``.

    Raises
    ------
    InputError
        Dask is not installed, nobody answers there, or there is no worker, or one with several threads.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise InputError("--scheduler needs Dask; install the extra: pip install 'lure[sweep]'") from None
        try:
            with ThreadPoolExecutor(1) as aside:  # whether a loop of events runs here or not
                aside.submit(asyncio.run, _greeted(address)).result()
            self._client: Any = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            said = str(error) or f"within {_PATIENCE} s"
            raise InputError(f"no Dask scheduler answers at {address!r} ({said}); start one: dask scheduler") from None
        self._address = address
        with suppress(TimeoutError):
            self._client.wait_for_workers(1, timeout=_PATIENCE)
        threads: dict[str, int] = self._client.nthreads()
        if not threads or max(threads.values()) > 1:
            self.shutdown()
            raise InputError(
                f"the scheduler at {address} has "
                + (f"workers with {max(threads.values())} threads" if threads else f"no worker after {_PATIENCE} s")
                + f", and {_ONE_THREAD}: start workers with dask worker ADDRESS --nthreads 1"
            )

    @property
    def workers(self) -> int:
        """How many there are now: a cluster may grow and shrink."""
        return len(self._client.scheduler_info(n_workers=-1)["workers"])

    def check(self) -> None:
        """Refuse to wait for a scheduler that went away."""
        if self._client.status != "running":
            raise InputError(self._gone)

    @property
    def _gone(self) -> str:
        return (
            f"the scheduler at {self._address} is gone; what is done is kept, as is what its workers still finish: "
            "start another and give the same command with its address"
        )

    def submit(self, number: int, job: Job) -> Future[int]:
        """Have a chunk computed; lost with a worker, it is computed by another."""
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        future: Future[int] = Future()
        task = self._client.submit(_computed_alone, number, job, pure=False, retries=3)

        def over(done: Any) -> None:  # noqa: ANN401  (a future of Dask, which has no types)
            """Hand on what a worker found, or in which way it failed."""
            try:
                future.set_result(done.result())
            except KilledWorker as error:  # several died with it, perhaps by its neighbours: it is begun again
                future.set_exception(BrokenProcessPool(str(error)))
            except (CancelledError, CommClosedError, OSError, TimeoutError):
                future.set_exception(InputError(self._gone))
            except BaseException as error:  # whatever the work raised, KeyboardInterrupt too, is what its future holds
                future.set_exception(error)

        task.add_done_callback(over)
        return future

    def shutdown(self) -> None:
        """Leave the cluster as it is."""
        self._client.close(timeout=2)


async def _greeted(address: str) -> None:
    """Wait for the first word of a scheduler, for which a client of Dask would wait for ever."""
    from distributed.comm.core import connect
    from distributed.security import Security

    given = Security().get_connection_args("client")
    comm = await asyncio.wait_for(connect(address, timeout=_PATIENCE, **given), _PATIENCE)
    comm.abort()


def _computed_alone(number: int, job: Job) -> int:
    """A chunk, by a worker that does nothing else meanwhile."""
    from distributed import get_worker

    if get_worker().state.nthreads > 1:
        raise InputError(f"a worker has several threads, and {_ONE_THREAD}: start workers with --nthreads 1")
    return computed(number, job)
