"""Three rows for the README: runs by lumped beside the same runs by a named package.

All rows are of one run of `run_peers`, so of one version, with the set-up beside each time.
"""

from pathlib import Path

from benchmarks.report.summary import Row, rows

BEGIN, END = "<!-- peers -->\n", "<!-- end of peers -->\n"
BASELINES = (
    ("three masses, 2 s", "exudyn"),
    ("three masses, 2 s", "scipy"),
    ("300 masses, 1 s", "scipy"),
)


def cell(row: Row) -> str:
    """Time of a run and set-up, package and method."""
    method = row["method"].partition(", rtol")[0]
    times = f"{float(row['ms']):.2f} ms, set-up {float(row['set-up, s']):.2f} s"
    return f"{times} ({row['package']}, {method})"


def run_of(problem: str, package: str) -> Row:
    """The run of a problem by a package."""
    found = (row for row in rows("run_peers") if row["problem"] == problem)
    return next(row for row in found if row["package"].partition(" ")[0] == package)


def table() -> str:
    """The rows as Markdown."""
    lines = ["| run | lumped | baseline |", "|---|---|---|"]
    for problem, package in BASELINES:
        both = (cell(run_of(problem, name)) for name in ("lumped", package))
        lines.append(f"| {problem} | {' | '.join(both)} |")
    return "\n".join(lines) + "\n"


def write(page: Path) -> None:
    """Set the rows in a page, between its marks."""
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    page.write_text(before + BEGIN + table() + END + after, encoding="utf-8")
