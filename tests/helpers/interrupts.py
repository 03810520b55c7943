"""Ctrl-C in the midst of many runs."""

import os
import signal
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
