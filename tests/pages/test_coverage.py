"""The table of what is reproduced of the five publications says what the machines compute."""

import re

import pytest
from page_code import read_page

PARTS = dict(
    re.findall(
        r"^## [^\n]*\(`(\w+)`\)\n(.*?)(?=^## |\Z)", read_page("machines/coverage"), re.M | re.S
    )
)
FIVE = ("carrousel_coiler", "eccentric_shear", "pilger_mill", "reversing_mill", "rotary_arm")


def cells(name):
    """Rows of the table of a machine without its head."""
    lines = [line for line in PARTS[name].splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def read_numbers(text):
    return re.findall(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?", text)


@pytest.mark.parametrize("name", FIVE)
def test_each_place_has_a_verdict_and_a_reason(name):
    for place, says, verdict, where in cells(name):
        assert place
        assert says
        assert verdict in ("reproduced", "partly", "left out")
        assert where


@pytest.mark.parametrize("name", FIVE)
def test_numbers_are_those_of_the_command(name, machine_rows):
    rows = {row.quantity: row for row in machine_rows(name)}
    found = 0
    for _, says, _, where in cells(name):
        # what follows a name up to the next one
        for quantity, told in re.findall(r"`([^`]+)`([^`]*)", where):
            if row := rows.get(quantity):
                published, *own = row.texts
                assert set(read_numbers(" ".join(own))) <= set(read_numbers(told)), (quantity, own)
                assert set(read_numbers(published)) <= set(read_numbers(says + where)), quantity
                found += 1
    assert found > 5
