"""The few numbers of the benchmarks that stand in the README, taken from the files of results."""

import csv
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
BEGIN, END = "<!-- benchmarks -->\n", "<!-- end of benchmarks -->\n"

Row = dict[str, str]


def rows(name: str) -> list[Row]:
    """Rows of a file of results."""
    with (RESULTS / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def pick(name: str, **wanted: str) -> Row:
    """The row of a file that has these values in its columns."""
    found = [row for row in rows(name) if all(row[k] == v for k, v in wanted.items())]
    if not found:
        raise LookupError(f"{name}.csv has no row with {wanted}")
    return found[0]


def loop(problem: str, way: str = "lumped, machine code") -> Row:
    """A run against a loop by hand."""
    return pick("native_loops", problem=problem, way=way)


def peer(problem: str) -> Row:
    """The fastest run of a problem in another package."""
    others = [
        row
        for row in rows("run_peers")
        if row["problem"] == problem and row["ms"] and not row["package"].startswith("lumped")
    ]
    return min(others, key=lambda row: float(row["ms"]))


def summary() -> list[tuple[str, str, str]]:
    """Question, benchmark, answer."""
    assembled = pick("flatten_time", topology="chain", components="29999")
    first = "ratio to the first"
    found = [
        (
            "assembling a chain of 29 999 components",
            "flatten_time",
            f"{assembled['assemble, s']} s, {assembled['us/component']} us for each",
        )
    ]
    for problem in ("three masses, 2 s", "300 masses, 1 s", "three clutches, 1.5 s"):
        whole, inner = loop(problem), loop(problem, "its loop alone")
        scipy = float(loop(problem, "SciPy, NumPy")["ms"]) / float(whole["ms"])
        found.append(
            (
                f"{problem}, error {whole['error']}: time over that of a loop by hand in C",
                "native",
                f"{whole[first]} ({inner[first]} without the Python around it); SciPy takes "
                f"{scipy:.0f} times as long",
            )
        )
    ahead = [peer(problem) for problem in ("three masses, 2 s", "300 masses, 1 s")]
    found.append(
        (
            "the same runs in the fastest of the other packages: time over that of lumped",
            "run_peers",
            "; ".join(
                f"{row['problem']}: {row['ratio to lumped']} ({row['package']})" for row in ahead
            ),
        )
    )
    cost = pick("sensitivity", what="sweep back, all three")
    found.append(
        (
            f"gradient of three functionals by {cost['parameters']} parameters",
            "sensitivity",
            f"{cost['runs']} runs without machine code",
        )
    )
    lowest = pick("modes", inertias="10000")
    found.append(
        (
            "20 lowest modes of 10 000 inertias",
            "modes",
            f"{lowest['modes, s']} s, error {lowest['error']}",
        )
    )
    share = rows("sweep")[-1]
    found.append(
        (
            f"1 000 runs on {share['processes']} cores",
            "sweep",
            f"{share['share of perfect use']} of perfect use",
        )
    )
    edges = [row["outcome"] for row in rows("extreme")]
    within = sum(outcome.startswith("within") for outcome in edges)
    outside = sum(outcome.startswith("OUTSIDE") for outcome in edges)
    found.append(
        (
            "stiffness, inertia, tolerance and geometry at their edges",
            "extreme",
            f"{within} runs within their tolerance, {len(edges) - within - outside} refused with a "
            f"reason, {outside} outside",
        )
    )
    return found


def write(page: Path) -> None:
    """Set the table in a page, between its marks."""
    head = ["| question | benchmark | answer |", "|---|---|---|"]
    lines = [f"| {what} | `{name}` | {answer} |" for what, name, answer in summary()]
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    table = "\n".join([*head, *lines]) + "\n"
    page.write_text(before + BEGIN + table + END + after, encoding="utf-8")
