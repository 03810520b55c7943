"""Processes that are forked while other threads of this one assemble and compile."""

import os
import threading
import time

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Spring
from lumped.support.process_lock import process_lock

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


def swung(c=300.0):
    """Twist of a spring between two bodies after a second, and its closed form."""
    model = in_a_row(a=Inertia(J=2.0, w=1.0), shaft=Spring(c=c), b=Inertia(J=1.0))
    run = lp.simulate(lp.assemble(model), until=1.0, rtol=1e-9, method="steps", grid=[1.0])
    omega = np.sqrt(c * (1 / 2.0 + 1 / 1.0))
    return run["shaft.phi_rel"][-1], -np.sin(omega) / omega


def is_right():
    received, expected = swung()
    return abs(received - expected) < 1e-7


def test_a_fork_waits_until_no_other_thread_assembles_or_compiles():
    is_held = threading.Event()

    def holds():
        with process_lock:
            is_held.set()
            time.sleep(0.3)

    holder = threading.Thread(target=holds, daemon=True)
    holder.start()
    assert is_held.wait(60.0)
    begun = time.monotonic()
    assert in_child(is_right)
    assert time.monotonic() - begun > 0.25
    holder.join()


def test_the_thread_that_forks_may_hold_the_lock():
    with process_lock:
        assert in_child(is_right)


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
        for _ in range(5):
            assert in_child(is_right)
            time.sleep(0.02)
    finally:
        ends.set()
        for thread in threads:
            thread.join()
