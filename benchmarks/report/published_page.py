"""The table of ``docs/published.md``, from the results of `published`."""

from pathlib import Path

from benchmarks.report.summary import Row, rows, set_between

MARK = "published"
TOLERANCES = ("1e-06", "1e-10")
WAYS = ("lumped", "SciPy Radau, NumPy", "CVODE BDF, NumPy")


def cell(found: list[Row], way: str, rtol: str) -> str:
    """Error and time of a run."""
    for row in found:
        if row["way"] == way and row["rtol"] == rtol:
            ms = float(row["ms"] or 0.0)
            time = f", {ms:.3g}" if ms < 1000 else f", {ms:.0f}"
            return row["error"] + (time if ms else "")
    return " "


def lines() -> list[str]:
    """The table as Markdown."""
    names = dict.fromkeys(row["problem"] for row in rows("published"))
    head = ["problem", "source", "equations -> states"]
    head += [f"{way.partition(',')[0]}, {rtol}" for way in WAYS for rtol in TOLERANCES]
    table = [head, ["---"] * len(head)]
    for name in names:
        found = rows("published", problem=name)
        first = found[0]
        cells = [cell(found, way, rtol) for way in WAYS for rtol in TOLERANCES]
        table.append([name, first["source"], first["equations -> states"], *cells])
    return ["| " + " | ".join(line) + " |" for line in table]


def write(page: Path) -> None:
    """Set the table in the page, between its marks."""
    set_between(page, MARK, lines())
