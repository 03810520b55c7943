"""The check of arguments by annotations."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pytest
from test_wrong_calls import NAN

from lumped.errors import OptionError
from lumped.support.arguments import checked


def test_a_function_is_checked_by_its_annotations():
    @checked
    def area(
        width: "float",
        corners: "int" = 4,
        names: "Sequence[str]" = (),
        heights: "Iterable[float]" = (),
        more: "Mapping[str, float] | None" = None,
        *rest: "float",
    ) -> "float":
        """Something with all kinds of arguments."""
        return width * corners + sum(heights) + sum(rest)

    assert area(2.0) == 8.0
    assert area(np.float64(2), np.int64(3), ["a"], (x for x in (1.0, 2.0)), {"a": 1.0}, 4.0) == 13.0
    for arguments, text in [
        (("2",), "area: width = '2': a finite number"),
        ((2.0, 3.5), "corners = 3.5: a whole number"),
        ((2.0, True), "corners = True: a whole number"),
        ((2.0, 3, "ab"), "names = 'ab': a list of names"),
        ((2.0, 3, [], [1.0, NAN]), "heights = [1.0, nan]: a list of finite numbers"),
        ((2.0, 3, [], 5.0), "heights = 5.0: a list of finite numbers is needed. Write [5.0]."),
        ((2.0, 3, [], [], [1]), "more = [1]: a dictionary"),
        ((2.0, 3, [], [], None, 1.0, "a"), "rest[1] = 'a': a finite number"),
        ((), "missing a required argument: 'width'"),
    ]:
        with pytest.raises(OptionError) as caught:
            area(*arguments)
        assert text in str(caught.value)
