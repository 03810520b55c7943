"""Processes that are forked while other threads of this one assemble, compile or hold locks."""

import os
import threading
import time

import numpy as np
import pytest

import lumped as lp
from lumped.code import machine_code
from lumped.components import Inertia, Spring
from lumped.support.locks import Lock

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here"),
    # of JAX, if another test of this process has loaded it
    pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning"),
]


def in_child(work, seconds=60.0):
    """Whether a forked process does some work to its end, and in time."""
    number = os.fork()
    if number == 0:
        try:
            os._exit(0 if work() else 1)
        finally:
            os._exit(2)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        gone, status = os.waitpid(number, os.WNOHANG)
        if gone:
            return status == 0
        time.sleep(0.005)
    os.kill(number, 9)
    os.waitpid(number, 0)
    return False


class Held:
    """A thread that holds a lock until it is told."""

    def __init__(self, lock):
        self.is_held, self.ends = threading.Event(), threading.Event()
        self.lock = lock
        self.thread = threading.Thread(target=self.hold, daemon=True)

    def hold(self):
        with self.lock:
            self.is_held.set()
            self.ends.wait(60.0)

    def __enter__(self):
        self.thread.start()
        assert self.is_held.wait(60.0)
        return self

    def __exit__(self, *_):
        self.ends.set()
        self.thread.join()


def swung(c=300.0):
    """Twist of a spring between two bodies after a second, and its closed form."""
    model = lp.compose(
        a=Inertia(J=2.0, w=1.0),
        shaft=Spring(c=c),
        b=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.a, m.shaft, m.b),
    )
    run = lp.simulate(lp.assemble(model), until=1.0, rtol=1e-9, method="steps", grid=[1.0])
    omega = np.sqrt(c * (1 / 2.0 + 1 / 1.0))
    return run["shaft.phi_rel"][-1], -np.sin(omega) / omega


def is_right():
    received, expected = swung()
    return abs(received - expected) < 1e-7


def test_a_lock_that_another_thread_holds_is_open_in_the_child():
    lock = Lock()

    def takes():
        with lock:
            return True

    with Held(lock):
        assert in_child(takes, 10.0)


def test_a_lock_that_the_forking_thread_holds_is_released_in_the_child_too():
    lock = Lock()

    def takes():
        with lock:
            return True

    with lock:
        assert in_child(lambda: takes() and lock.__exit__(None, None, None) is None, 10.0)


def test_a_fork_waits_until_nothing_is_compiled():
    with Held(machine_code._compiling) as held:
        threading.Timer(0.3, held.ends.set).start()
        begun = time.monotonic()
        assert in_child(is_right)
        assert time.monotonic() - begun > 0.25


def test_a_model_that_another_thread_works_on_is_used_in_the_child():
    system = lp.assemble(lp.compose(a=Inertia(J=2.0, w=1.5)))
    with Held(system.building):
        assert in_child(lambda: lp.simulate(system, until=1.0)["a.w"][-1] == 1.5)


def test_children_of_a_process_whose_threads_assemble_make_their_runs():
    ends = threading.Event()

    def assemble():
        for k in range(10_000):
            if ends.is_set():
                break
            swung(300.0 + k)

    assert is_right()
    threads = [threading.Thread(target=assemble, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(12):
            assert in_child(is_right)
            time.sleep(0.02)
    finally:
        ends.set()
        for thread in threads:
            thread.join()
