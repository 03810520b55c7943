"""Write the tables of ``benchmarks/results`` into ``docs/benchmarks.md``, each below its mark.

python docs/write_tables.py
"""

import csv
import re
from pathlib import Path

PAGE = Path(__file__).parent / "benchmarks.md"
RESULTS = Path(__file__).parents[1] / "benchmarks" / "results"
MARK = re.compile(r"<!-- (\w+\.csv) -->\n(?:\|.*\n|\n)*")


def table(name: str) -> str:
    """A file of results as a Markdown table."""
    with (RESULTS / name).open(newline="") as file:
        head, *rows = csv.reader(file)
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def written(page: str) -> str:
    """The page with its tables as they stand in the files."""
    return (
        MARK.sub(lambda found: f"<!-- {found[1]} -->\n\n{table(found[1])}\n", page).rstrip() + "\n"
    )


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
