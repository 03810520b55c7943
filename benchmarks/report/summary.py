"""The few numbers of the benchmarks that ``docs/benchmarks.md`` begins with, from their files."""

import csv
from pathlib import Path

from benchmarks.harness import RESULTS

THREE, ROW, CLUTCHES = "three masses, 2 s", "300 masses, 1 s", "three clutches, 1.5 s"
INSIDE, FIRST = "lumped, inside the loop", "ratio to the first"

Row = dict[str, str]


def rows(name: str, **wanted: str) -> list[Row]:
    """Rows of a file of results that have these values in their columns."""
    with (RESULTS / f"{name}.csv").open(newline="") as file:
        found = [r for r in csv.DictReader(file) if all(r[k] == v for k, v in wanted.items())]
    if not found:
        raise LookupError(f"{name}.csv has no row with {wanted}")
    return found


def fill_in(answer: str, name: str, **wanted: str) -> str:
    """An answer with the numbers of the first such row, by the names of its columns."""
    return answer.format_map(rows(name, **wanted)[0])


def list_column(column: str, name: str, *choices: Row) -> str:
    """A column of several rows."""
    return ", ".join(rows(name, **wanted)[0][column] for wanted in choices or rows(name))


def by_hand(problem: str) -> tuple[str, str, str]:
    """A run against a loop by hand and against SciPy."""
    ways = {row["way"]: row for row in rows("time_loop_by_hand", problem=problem)}
    own, scipy = ways["lumped"], ways["SciPy, NumPy"]
    slower = float(scipy["ms"]) / float(own["ms"])
    return (
        f"{problem}, error {own['error']}: time over that of a loop by hand in C",
        "time_loop",
        f"{own[FIRST]} ({ways[INSIDE][FIRST]} without the Python around it); SciPy on NumPy takes "
        f"{slower:.0f} times as long",
    )


def fastest_peer(problem: str) -> str:
    """The fastest other package on a problem."""
    others = [row for row in rows("run_peers", problem=problem) if row["ms"]]
    ahead = min(others[1:], key=lambda row: float(row["ms"]))
    return f"{problem}: {ahead['ratio to lumped']} ({ahead['package']})"


def edges(name: str) -> str:
    """How many runs end how."""
    outcomes = [row["outcome"] for row in rows(name)]
    within, outside = (sum(o.startswith(w) for o in outcomes) for w in ("within", "OUTSIDE"))
    refused = len(outcomes) - within - outside
    return (
        f"{within} runs within their tolerance, {refused} refused with a reason, {outside} outside"
    )


def summary() -> list[tuple[str, str, str]]:
    """Question, benchmark, answer."""
    two, three = (
        fill_in("{over the fastest}", "default_call", problem=name)
        for name in ("two masses, 1 s", THREE)
    )
    changing = sorted((row["ratio"] for row in rows("default_call_changing")), key=float)
    least, most = changing[0], changing[-1]
    ratios = {row["what"]: row["over heyoka"] for row in rows("series")}
    a_run = fill_in(
        "a run takes {lanes over C} times as long as in scalar C, {lanes over fastest C} times as "
        "long as in C with vector registers",
        "ensembles",
        task="a",
        rtol="1e-06",
    )
    return [
        (
            "assembling a chain of 29 999 components",
            "flatten_time",
            fill_in(
                "{assemble, s} s, {us/component} us for each", "flatten_time", components="29999"
            ),
        ),
        *map(by_hand, (THREE, ROW, CLUTCHES)),
        (
            "the same runs in the fastest of the other packages: time over that of lumped",
            "run_peers",
            "; ".join(map(fastest_peer, (THREE, ROW))),
        ),
        (
            "method chosen by itself: time over that of the fastest method at the same accuracy",
            "default_call",
            f"two masses {two}, three masses {three}; ten drives with a parameter that changes at "
            f"each call {least} to {most}",
        ),
        (
            "first result of a new process, three masses",
            "first_result",
            fill_in(
                "{all, s} s, {over SciPy} times SciPy's; installed, with nothing cached ",
                "first_result",
                **{"new process": "lumped, cached"},
            )
            + fill_in(
                "{all, s} s, ",
                "first_result",
                **{"new process": "lumped from a wheel, nothing cached"},
            )
            + fill_in(
                "from a checkout {all, s} s",
                "first_result",
                **{"new process": "lumped, nothing cached"},
            ),
        ),
        (
            "stiff chains of 300 and 1 000 inertias: time over that of CVODE's BDF, banded",
            "stiff_chain",
            list_column(
                "ratio to CVODE", "stiff_chain_peers", {"inertias": "300"}, {"inertias": "1000"}
            ),
        ),
        (
            "gradient of three functionals by 200 parameters",
            "sensitivity",
            fill_in("{own runs} runs with its steps", "sensitivity", what="sweep back, all three"),
        ),
        (
            "gradients across events: rolling mill that skids, three clutches, impacts",
            "sensitivity",
            list_column("own runs", "sensitivity_across_events") + " runs with their steps",
        ),
        (
            "three masses by Taylor's series, error 1e-8: time over that of heyoka.py",
            "series",
            "{series, call} for a whole call, {series, loop} for the loop in it, "
            "{series, in lanes} in lanes".format_map(ratios),
        ),
        (
            "20 lowest modes of 10 000 inertias",
            "modes",
            fill_in("{modes, s} s, error {error}", "modes", inertias="10000"),
        ),
        (
            "all modes of 2 000 inertias, with their accuracy and energies",
            "modes",
            fill_in(
                "{in all, s} s, error {error}",
                "modes_all",
                **{"drive of 2000 inertias": "undamped"},
            ),
        ),
        (
            "1 000 speeds and 24 orders of a drive of nine inertias",
            "order_response",
            fill_in(
                "{order response, ms} ms, {over batched solver} of a batched solver in numpy by "
                "hand",
                "order_response",
                inertias="9",
            ),
        ),
        (
            "diesel genset, 1 000 speeds and 24 orders, with an operating point for each speed",
            "order_response",
            fill_in(
                "{order response, s} s; {difference} from speeds one by one",
                "order_response_genset",
                **{"operating points": "at each speed"},
            ),
        ),
        (
            "100 000 runs of three masses on 2 cores, peak of both shafts, rtol 1e-6",
            "ensembles",
            fill_in("{s on all threads} s; ", "ensembles_whole", task="a") + a_run,
        ),
        (
            "100 000 variants: time of the processor one by one over that of a scatter",
            "scatter",
            "; ".join("{what} {ratio}".format_map(row) for row in rows("scatter")),
        ),
        (
            "share of the processor's time in compiled code",
            "scatter",
            "; ".join("{what} {share}".format_map(row) for row in rows("scatter_share")),
        ),
        *(
            (
                f"stiffness, inertia, tolerance and geometry at their edges, {what}",
                name,
                edges(name),
            )
            for what, name in (("closed forms", "extreme"), ("five machines", "machine_extremes"))
        ),
    ]


def set_between(page: Path, mark: str, lines: list[str]) -> None:
    """Set lines in a page, between two comments that name them."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->\n"
    before, rest = page.read_text(encoding="utf-8").split(begin)
    _, after = rest.split(end)
    page.write_text(before + begin + "\n".join(lines) + "\n" + end + after, encoding="utf-8")


def write(page: Path) -> None:
    """Set the table in a page."""
    head = ["| question | benchmark | answer |", "|---|---|---|"]
    lines = [f"| {what} | `{name}` | {answer} |" for what, name, answer in summary()]
    set_between(page, "benchmarks", [*head, *lines])
