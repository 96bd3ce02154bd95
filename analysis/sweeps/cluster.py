"""A Dask cluster, reached by the address of its scheduler, as the processes of a sweep."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from lure.analysis.sweeps.run import Job, computed
from lure.errors import InputError

_PATIENCE = 30  # [s] for a scheduler to answer


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
            self._client: Any = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(f"no Dask scheduler answers at {address!r} ({error}); start one: dask scheduler") from None
        threads: dict[str, int] = self._client.nthreads()
        self.workers = len(threads)
        if not threads or max(threads.values()) > 1:
            self.shutdown()
            raise InputError(
                f"the scheduler at {address} has {len(threads)} workers with {sorted(set(threads.values()))} threads; "
                "precision is one setting for a process: start workers with dask worker ADDRESS --nthreads 1"
            )

    def submit(self, number: int, job: Job) -> Future[int]:
        """Have a chunk computed; lost with a worker, it is computed by another."""
        future: Future[int] = Future()
        task = self._client.submit(computed, number, job, pure=False, retries=3)

        def over(done: Any) -> None:  # noqa: ANN401  (a future of Dask, which has no types)
            try:
                future.set_result(done.result())
            except Exception as error:
                future.set_exception(error)

        task.add_done_callback(over)
        return future

    def shutdown(self) -> None:
        """Leave the cluster as it is."""
        self._client.close()
