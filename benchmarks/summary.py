"""The few numbers of the benchmarks that ``docs/benchmarks.md`` begins with, from their files."""

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


def loop(problem: str, way: str = "lumped") -> Row:
    """A run against a loop by hand."""
    return pick("time_loop_by_hand", problem=problem, way=way)


def peer(problem: str) -> Row:
    """The fastest run of a problem in another package."""
    others = [
        row
        for row in rows("run_peers")
        if row["problem"] == problem and row["ms"] and not row["package"].startswith("lumped")
    ]
    return min(others, key=lambda row: float(row["ms"]))


def around() -> list[tuple[str, str, str]]:
    """What stands around the time loop, and a stiff drive."""
    ratio = "over the fastest"
    two, three = (
        next(row for row in rows("default_call") if row["problem"] == problem)
        for problem in ("two masses, 1 s", "three masses, 2 s")
    )
    read = pick("first_read", what="the torque, first read")
    fresh, cached = (
        pick("first_result", **{"new process": f"lumped, {way}"})
        for way in ("nothing cached", "cached")
    )
    stiff = [
        next(row for row in rows("stiff_chain_peers") if row["inertias"] == count)
        for count in ("300", "1000")
    ]
    between = [row for row in rows("between_steps") if row["way"].startswith("lumped default")]
    worst = max(float(row["error between steps over rtol x range"]) for row in between)
    return [
        (
            "call without options: time over that of the fastest method at the same accuracy",
            "default_call",
            f"two masses {two[ratio]}, three masses {three[ratio]}",
        ),
        (
            "first read of a torque at 502 times",
            "first_read",
            f"{read['us']} us, {read['over NumPy']} times the formula in NumPy",
        ),
        (
            "first result of a new process, three masses",
            "first_result",
            f"{cached['all, s']} s, {cached['over SciPy']} times SciPy's; "
            f"with nothing cached {fresh['all, s']} s",
        ),
        (
            "stiff chains of 300 and 1 000 inertias: time over that of CVODE's BDF, banded",
            "stiff_chain",
            " and ".join(row["ratio to CVODE"] for row in stiff),
        ),
        (
            "largest error between steps over that asked for, rtol 1e-4 to 1e-8",
            "between_steps",
            f"{worst:.0f}",
        ),
    ]


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
        whole, inner = loop(problem), loop(problem, "lumped, inside the loop")
        scipy = float(loop(problem, "SciPy, NumPy")["ms"]) / float(whole["ms"])
        found.append(
            (
                f"{problem}, error {whole['error']}: time over that of a loop by hand in C",
                "time_loop",
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
    found += around()
    cost = pick("sensitivity", what="sweep back, all three")
    found.append(
        (
            f"gradient of three functionals by {cost['parameters']} parameters",
            "sensitivity",
            f"{cost['own runs']} runs with its steps",
        )
    )
    events = [row["own runs"] for row in rows("sensitivity_across_events")]
    found.append(
        (
            "gradients across events: rolling mill that skids, three clutches, impacts",
            "sensitivity",
            f"{', '.join(events)} runs with their steps",
        )
    )
    series = [
        pick("series", what=f"series, {what}")["over heyoka"]
        for what in ("call", "loop", "in lanes")
    ]
    found.append(
        (
            "three masses by Taylor's series, error 1e-8: time over that of heyoka.py",
            "series",
            f"{series[0]} for a whole call, {series[1]} for the loop in it, {series[2]} in lanes",
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
    vibrating = pick("order_response", inertias="9")
    found.append(
        (
            "1 000 speeds and 24 orders of a drive of nine inertias",
            "order_response",
            f"{vibrating['order response, ms']} ms, {vibrating['over batched solver']} of a "
            "batched solver in numpy by hand",
        )
    )
    masses, side = pick("ensembles_whole", task="a"), pick("ensembles", task="a", rtol="1e-06")
    found.append(
        (
            "100 000 runs of three masses on 2 cores, peak of both shafts, rtol 1e-6",
            "ensembles",
            f"{masses['s on all threads']} s; a run costs {side['lanes over C']} of one in C, "
            f"{side['lanes over fastest C']} of one in C in vector registers",
        )
    )
    scattered = rows("scatter")
    found.append(
        (
            "100 000 variants: time of the processor one by one over that of a scatter",
            "scatter",
            "; ".join(f"{row['what']} {row['ratio']}" for row in scattered),
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
