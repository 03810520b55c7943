"""What all workers of a run of the tests share."""

import os
import pickle
import time


def made_once(tmp_path_factory, name, make):
    """What `make` returns for a new folder; the first worker that asks calls it, others wait."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
    ended, result = place / "ended", place / "result"
    try:
        place.mkdir()
    except FileExistsError:
        wait_until(ended.exists, 300.0)
        return pickle.loads(result.read_bytes())
    try:
        made = make(place)
        result.write_bytes(pickle.dumps(made))
        return made
    finally:
        ended.touch()


def wait_until(holds, seconds=20.0):
    """Ask again until something holds."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.1)
