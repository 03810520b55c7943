"""Wrong drive trains: each gets an error that names the guilty parts and says what to do.

The same tables make the error catalogue; `python -m tests.wrong_models` rewrites it.
"""

import pytest

from .catalogue import CASES, CATALOGUE, answer, catalogue


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_wrong_model_is_answered_in_words_of_the_model(case):
    error = answer(case)
    assert type(error) is case.error
    for word in case.words:
        assert word in str(error)


def test_the_catalogue_of_errors_shows_the_texts_of_today():
    received = CATALOGUE.read_text(encoding="utf-8")
    expected = catalogue()
    assert received == expected, "run: python -m tests.wrong_models"
