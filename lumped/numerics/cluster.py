"""What the workers of a cluster of Dask share."""

from __future__ import annotations

import pickle
from typing import Any


def hand_out(client: Any, what: object) -> Any:
    """Future of an object that all workers can take.

    It is the result of a task, whose input the scheduler keeps, so it is made again if a worker
    that has it, or is just given it, dies. What is scattered would be lost.
    """
    return client.submit(pickle.loads, pickle.dumps(what), pure=False)
