"""Interrupts before a chosen line."""

import sys


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
