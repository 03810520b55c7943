"""Runs spread over the threads of this process, or over a cluster."""

from __future__ import annotations

import time as clock
from collections.abc import Generator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextvars import copy_context
from typing import Any

import numpy as np

from lumped.errors import SolverError
from lumped.many_runs.native_runs import Batch, NativeRuns
from lumped.numerics.process_pool import hand_out

_FIRST, _MOST = 16, 100_000
"""Runs of the first and of the largest chunk that a thread is given."""
_AT_A_TIME = 0.1
"""Seconds of work in one chunk."""
_CHUNKS = 8
"""Chunks for each thread of a cluster, so that the last ones end together."""
DIED = -1
"""Status of runs in which the process of a worker died again and again."""

Done = tuple[int, Batch, float]
"""First run of a chunk, its results, seconds of work."""


def run_in_threads(runs: NativeRuns, points: np.ndarray, count: int) -> Generator[Done, None, None]:
    """Chunks of runs in the order in which they are done.

    After an interrupt (Ctrl-C) what was done by then is given and no more.

    Parameters
    ----------
    points : ndarray, shape (n, k)
        Parameters of the runs.
    count : int
        Number of threads.
    """
    size, first = _FIRST, 0
    running: set[Future[Done]] = set()

    def work(begin: int, end: int) -> Done:
        begun = clock.perf_counter()
        batch = runs.run(points[begin:end])
        return begin, batch, clock.perf_counter() - begun

    with ThreadPoolExecutor(count) as pool:
        try:
            while first < len(points) or running:
                while first < len(points) and len(running) < 2 * count:
                    left = -(-(len(points) - first) // count)
                    end = min(first + max(1, min(size, left)), len(points))
                    # the engine chosen here is chosen in the thread
                    running.add(pool.submit(copy_context().run, work, first, end))
                    first = end
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    begin, batch, spent = future.result()
                    pace = len(batch.values) / max(spent, 1e-9)
                    size = int(min(max(_AT_A_TIME * pace, 1), 4 * size, _MOST))
                    yield begin, batch, spent
        except KeyboardInterrupt:
            runs.stop()
            for future in running:
                if not future.cancel():
                    yield future.result()


def on_cluster(runs: NativeRuns, points: np.ndarray, client: Any) -> Generator[Done, None, None]:
    """The same on a cluster of Dask; chunks of a worker that dies are made by another one.

    Raises
    ------
    SolverError
        If workers cannot make the runs at all.
    """
    from dask.distributed import KilledWorker, as_completed

    threads = sum(client.nthreads().values()) or 1
    size = max(1, min(_MOST, -(-len(points) // (_CHUNKS * threads))))
    held = hand_out(client, runs)
    futures = {
        client.submit(_work, held, points[first : first + size], pure=False): first
        for first in range(0, len(points), size)
    }
    try:
        for future in as_completed(futures):  # type: ignore[no-untyped-call]
            first = futures[future]
            if future.status == "finished":
                batch, spent = future.result()
            elif future.status == "error" and not isinstance(future.exception(), KilledWorker):
                fault = future.exception()
                raise SolverError(
                    f"{runs.system.name}: a worker of the cluster cannot make the runs: "
                    f"{type(fault).__name__}: {fault}. It needs the same versions of Python, "
                    "lumped and the packages that the model is written with."
                ) from fault
            else:
                batch, spent = _make_lost(runs, len(points[first : first + size])), 0.0
            yield first, batch, spent
    except KeyboardInterrupt:
        return
    finally:
        client.cancel([future for future in futures if not future.done()])


def _work(runs: NativeRuns, points: np.ndarray) -> tuple[Batch, float]:
    begun = clock.perf_counter()
    return runs.run(points), clock.perf_counter() - begun


def _make_lost(runs: NativeRuns, count: int) -> Batch:
    values = np.full((count, len(runs.watched.of)), np.nan)
    return Batch(values, np.full(count, DIED, dtype=np.int64))
