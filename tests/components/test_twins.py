"""A component of straight-line motion has the law of its rotational twin, with other names.

So what is shown of one of them holds for both.
"""

import re

import pytest
from library_rigs import FIELDS, declared
from translation_twins import TWINS

import lumped as lp
from lumped.language.quantity import Quantity

NAMES = {"phi": "s", "w": "v", "tau": "f", "J": "m"}
RANGE = ("wish", "start", "nominal", "min", "max", "above", "below", "exceeds", "default")


def renamed(text):
    """An equation or expression of rotation in the names of straight-line motion."""
    return re.sub(r"\b(phi|w|tau|J)(?=\b|_|0)", lambda name: NAMES[name[1]], str(text))


def law(cls):
    """Equations, energy and loss as they are printed."""
    part = cls(**FIELDS.get(cls, {}))
    items = [*part.equations(), part.stored(), part.loss()]
    return [renamed(list(map(str, item)) if isinstance(item, tuple) else item) for item in items]


def ranges(cls):
    """Kind of each quantity, its values and whether it is wanted as a state."""
    return {
        renamed(name): (type(item), *(renamed(getattr(item, key, None)) for key in RANGE))
        for name, item in declared(cls, Quantity).items()
    }


@pytest.mark.parametrize(("sliding", "turning"), TWINS.items(), ids=lambda cls: cls.__name__)
def test_a_sliding_component_has_the_law_of_its_rotational_twin(sliding, turning):
    assert law(sliding) == law(turning)
    assert ranges(sliding) == ranges(turning)
    assert {*map(renamed, declared(sliding, lp.Port))} == {
        *map(renamed, declared(turning, lp.Port))
    }


def test_nearly_all_of_the_library_of_straight_line_motion_has_a_twin():
    assert len(TWINS) == 31
