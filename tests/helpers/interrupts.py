"""Interrupts before a chosen line, and Ctrl-C in the midst of many runs."""

import os
import signal
import sys
import time

from lumped.many_runs.native_runs import NativeRuns


def interrupting(monkeypatch, at):
    """Press Ctrl-C in one of the chunks of runs."""
    run, calls = NativeRuns.run, []

    def interrupted(self, values):
        calls.append(len(values))
        if len(calls) == at:
            time.sleep(0.1)  # so that the main thread waits for this chunk
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.1)
        return run(self, values)

    monkeypatch.setattr(NativeRuns, "run", interrupted)
    return calls


def interrupt_before(line, chooses, action):
    """What an action gives, or its interrupt before a line, and how many lines passed by then.

    Parameters
    ----------
    line : int
        Number of the line among those of the chosen frames, from 1.
    chooses : callable
        Whether the lines of a frame count.
    action : callable
    """
    passed = 0

    def trace(frame, event, _):
        nonlocal passed
        if not chooses(frame.f_code):
            return None
        passed += event == "line"
        if event == "line" and passed == line:
            sys.settrace(None)
            raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        return action(), passed
    except KeyboardInterrupt as error:
        return error, passed
    finally:
        sys.settrace(before)
