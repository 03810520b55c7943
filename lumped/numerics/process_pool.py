"""Work shared among processes; one that dies does not stop the others."""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import time as clock
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

Outcome = list[float] | str
Task = tuple[int, dict[str, float]]
Done = tuple[int, Outcome, float]

_FORKS = "fork" in multiprocessing.get_all_start_methods()
_AHEAD = 2
"""Chunks for each process that are handed out at a time."""
_CHUNKS = 20
"""Chunks for each process in all, so that the last ones end together."""
_DIED = "the process died in this run (see its last output; memory, or a fault of a library)"

_job: Callable[[dict[str, float]], Outcome]


def outcomes(
    job: Callable[[dict[str, float]], Outcome],
    tasks: Sequence[Task],
    workers: int,
    client: Any,
) -> Iterator[Done]:
    """Yield the outcome of each task and the seconds that it took, in the order of completion.

    An interrupt ends the work without an error.

    Parameters
    ----------
    job : callable
        Function of a task; pickled only where processes cannot be forked.
    tasks : sequence of (int, dict)
        Number and argument of each.
    workers : int
        Processes.
    client : dask.distributed.Client or None
        Cluster that works instead of own processes.
    """
    size = max(1, len(tasks) // (_CHUNKS * workers))
    chunks = [list(tasks[i : i + size]) for i in range(0, len(tasks), size)]
    try:
        if client is not None:
            yield from _on_cluster(job, chunks, client)
        elif workers == 1 or len(tasks) <= 1:
            _begin(job, False)
            for chunk in chunks:
                yield from _work(chunk)
        else:
            suspects: list[Task] = []
            while chunks:
                chunks = yield from _run_in_pool(job, chunks, workers, suspects)
            for task in suspects:  # one by one, so that the fatal one is known
                alone: list[Task] = []
                yield from _run_in_pool(job, [[task]], 1, alone)
                for number, _ in alone:
                    yield number, _DIED, 0.0
    except KeyboardInterrupt:
        return


def _run_in_pool(
    job: Callable[[dict[str, float]], Outcome],
    chunks: list[list[Task]],
    workers: int,
    suspects: list[Task],
) -> Any:
    """Work until all is done or a process dies; give back the tasks not begun."""
    waiting = list(reversed(chunks))
    running: dict[Future[list[Done]], list[Task]] = {}
    pool = ProcessPoolExecutor(workers, _context(), _begin, (job, True))
    try:
        while waiting or running:
            while waiting and len(running) < _AHEAD * workers:
                chunk = waiting.pop()
                with warnings.catch_warnings():
                    # forks wait until no other thread holds the lock of the process
                    for kind in (DeprecationWarning, RuntimeWarning):  # of Python, of JAX
                        warnings.filterwarnings("ignore", ".*fork", kind)
                    running[pool.submit(_work, chunk)] = chunk
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                found = future.result()
                del running[future]
                yield from found
    except BrokenProcessPool:
        for future, chunk in running.items():
            if future.done() and future.exception() is None:
                yield from future.result()
            else:
                suspects += chunk
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    return list(reversed(waiting))


def _context() -> Any:
    return multiprocessing.get_context("fork" if _FORKS else None)


def may_fork() -> bool:
    """Whether this process may be forked; a daemon, such as a worker of a pool, may not."""
    return _FORKS and not multiprocessing.current_process().daemon


def _begin(job: Callable[[dict[str, float]], Outcome], own_process: bool) -> None:
    global _job
    _job = job
    if own_process:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(chunk: list[Task]) -> list[Done]:
    return _work_on_cluster(_job, chunk)


def hand_out(client: Any, what: object) -> Any:
    """Future of an object that all workers of a cluster of Dask can take.

    It is the result of a task, whose input the scheduler keeps, so it is made again if a worker
    that has it, or is just given it, dies. What is scattered would be lost.
    """
    return client.submit(pickle.loads, pickle.dumps(what), pure=False)


def _on_cluster(
    job: Callable[[dict[str, float]], Outcome], chunks: list[list[Task]], client: Any
) -> Iterator[Done]:
    from dask.distributed import as_completed

    held = hand_out(client, job)
    futures = {client.submit(_work_on_cluster, held, chunk, pure=False): chunk for chunk in chunks}
    for future in as_completed(futures):  # type: ignore[no-untyped-call]
        if future.status == "finished":
            yield from future.result()
            continue
        for number, _ in futures[future]:
            yield number, f"{_DIED}: {future.exception()}", 0.0


def _work_on_cluster(job: Callable[[dict[str, float]], Outcome], chunk: list[Task]) -> list[Done]:
    found = []
    for number, argument in chunk:
        begin = clock.perf_counter()
        found.append((number, job(argument), clock.perf_counter() - begin))
    return found
