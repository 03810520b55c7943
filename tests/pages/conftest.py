"""The code of a page, executed once for the tests of its module."""

import pytest
from page_code import run_blocks


@pytest.fixture(scope="module")
def names(request, tmp_path_factory):
    """Names after the code of the page `NAME` of a module, which prints what the page shows.

    If the module says `PRINTS = False`, what is printed differs from run to run.
    """
    found, printed = run_blocks(request.module.NAME, tmp_path_factory.mktemp("page"))
    if getattr(request.module, "PRINTS", True):
        for lines, shown in printed:
            assert not shown or lines == shown
    return found
