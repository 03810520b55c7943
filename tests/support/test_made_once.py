"""What is made for an object is made once, by one thread, and kept as long as it is told to."""

import time
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest
from interrupts import interrupt_before

from lumped.support.made_once import Recent, Shared, made_once
from lumped.support.process_lock import process_lock


class Owner(Shared):
    def __init__(self):
        super().__init__()
        self.calls = []

    @property
    @made_once
    def slow(self):
        """Takes a while."""
        self.calls.append("slow")
        time.sleep(0.01)
        return object()


@made_once
def pair(owner, first, second):
    """Two things, and what is slow."""
    owner.calls.append((first, second))
    return owner.slow, first, second


def test_threads_find_what_one_of_them_made():
    owner, barrier = Owner(), Barrier(8)

    def call(k):
        barrier.wait()
        return pair(owner, "a", k % 2)

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(call, range(8)))
    assert sorted(owner.calls, key=str) == [("a", 0), ("a", 1), "slow"]
    assert len(set(map(id, found))) == 2
    assert {part[0] for part in found} == {owner.slow}


def test_objects_and_functions_keep_their_own():
    one, other = Owner(), Owner()
    assert pair(one, 1, 2) is pair(one, 1, 2)
    assert pair(one, 1, 2) is not pair(other, 1, 2)
    assert pair.__doc__ == "Two things, and what is slow."
    assert Owner.slow.__doc__ == "Takes a while."


def test_what_could_not_be_made_is_tried_again():
    owner, tries = Owner(), []

    @made_once
    def failing(_):
        tries.append(len(tries))
        if len(tries) == 1:
            raise KeyboardInterrupt
        return 1.5

    with pytest.raises(KeyboardInterrupt):
        failing(owner)
    assert failing(owner) == failing(owner) == 1.5
    assert tries == [0, 1]


def interrupted_at(line, owner):
    """Whether an interrupt before the line of this number came while a pair was made."""

    def is_ours(code):
        return code.co_filename.endswith("/made_once.py")

    found, _ = interrupt_before(line, is_ours, lambda: pair(owner, 1, 2))
    return isinstance(found, KeyboardInterrupt)


def test_an_interrupt_anywhere_does_not_stop_the_thread_it_came_to():
    """Also where the lock is about to open, where a tracer comes but no signal does."""
    line, owner = 1, Owner()
    while interrupted_at(line, owner):
        assert pair(owner, 1, 2)[1:] == (1, 2)
        while process_lock._is_owned():
            process_lock.release()
        line, owner = line + 1, Owner()
    assert line > 10


def test_the_last_results_are_kept():
    recent, made = Recent(2), []

    def get(key):
        return recent.of(key, lambda: made.append(key) or key.upper())

    assert [get(key) for key in "aababcaa"] == list("AABABCAA")
    assert made == ["a", "b", "c", "a"]
