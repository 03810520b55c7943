"""What errors say."""

import pytest

from lumped.errors import LumpedError


def message(action, kind=LumpedError):
    """Text of the error that an action ends in."""
    with pytest.raises(kind) as caught:
        action()
    assert isinstance(caught.value, LumpedError)
    print(f"\n{type(caught.value).__name__}: {caught.value}")
    return str(caught.value)
