"""Draw ``model.svg``: what becomes of a model, from its class to results.

The example is the lift of ``compiler.md``; its numbers, curve and mode are computed here.
"""

import re
from html import escape
from pathlib import Path
from typing import Any

import lumped as lp

DOCS = Path(__file__).resolve().parent
WIDTH, HEIGHT = 1060, 700
INK, SOFT, BLUE, RED, PAPER = "#222", "#667", "#1f77b4", "#d62728", "#f2f4f7"
USES = (
    (("functionals", "gradients"), "numbers that sum up a run,", "and their derivatives"),
    (("many_runs", "ensembles"), "many runs: threads,", "vector registers"),
    (("orbits",), "periodic motions", "and their branches"),
    (("life",), "cycles of loads,", "damage, life"),
    (("tolerances",), "scatter, probability", "of failure"),
    (("optimisation",), "best parameters,", "fits, motions"),
    (("exchange", "live"), "the same loop as C:", "FMU, web page"),
    (("plots", "drawing", "explorer"), "pictures, reports,", "sliders"),
)


def lift() -> Any:
    """The model of ``compiler.md``."""
    block = re.search(r"```python\n(.*?)```", (DOCS / "compiler.md").read_text("utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec(block[1].partition("system =")[0] if block else "", names)
    return names["Lift"]()


def text(x: float, y: float, words: str, **style: object) -> str:
    """A line of letters."""
    given = "".join(f' {key.replace("_", "-")}="{value}"' for key, value in style.items())
    return f'<text x="{x:g}" y="{y:g}"{given}>{escape(words)}</text>'


def panel(x: float, y: float, w: float, h: float, title: str, folders: str) -> list[str]:
    """A frame with what it holds and the folders that make it."""
    return [
        f'<rect x="{x}" y="{y}" width="{w}" height="{h}" rx="8" fill="{PAPER}"/>',
        text(x + 14, y + 26, title, font_size=16, font_weight="bold"),
        text(x + w - 14, y + 25, folders, fill=BLUE, text_anchor="end"),
    ]


def arrow(*points: tuple[float, float]) -> str:
    """A line with a head at its end."""
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    return (
        f'<polyline points="{path}" fill="none" stroke="{SOFT}" stroke-width="2" '
        'marker-end="url(#head)"/>'
    )


def curve(run: lp.Trajectory, name: str, x: float, y: float, w: float, h: float) -> list[str]:
    """A quantity over time, and where the run stopped."""
    values, until = run[name], run.t[-1]
    least, most = min(values.min(), 0.0), values.max()

    def place(t: float, value: float) -> tuple[float, float]:
        return x + w * t / until, y + h * (most - value) / (most - least)

    shown = " ".join(
        "{:.1f},{:.1f}".format(*place(t, v)) for t, v in zip(run.t, values, strict=True)
    )
    lines = [
        f'<path d="M{x} {y}v{h}h{w}" fill="none" stroke="{SOFT}"/>',
        f'<polyline points="{shown}" fill="none" stroke="{BLUE}" stroke-width="2"/>',
        text(x + w, y + h + 18, f"{until:g} s", fill=SOFT, text_anchor="end"),
        text(x + 8, y + 12, f"speed of the rotor, up to {most:.0f} rad/s", fill=SOFT),
    ]
    for instant in sorted({event.time for event in run.events}):
        at = place(instant, 0.0)[0]
        lines += [
            f'<path d="M{at:.1f} {y + 24}V{y + h}" stroke="{RED}" stroke-dasharray="4 3"/>',
            text(at, y + h + 18, f"event, {instant:g} s", fill=RED, text_anchor="middle"),
        ]
    return lines


def upper(system: lp.System) -> list[str]:
    """From the class to the system."""
    counts = system.report().counts
    flat, joined, states = (
        counts[name] for name in ("equations", "after alias elimination", "states")
    )
    code = ("class Lift(lp.Component):", "    rotor = Inertia(J=0.02)", "    gear = IdealGear(...)")
    code += ("    shaft = SpringDamper(...)", "    brake = Brake(...)", "    ...")
    code += ("    def connections(self): ...",)
    lines = panel(20, 20, 250, 190, "Class", "language")
    lines += [
        text(
            34,
            66 + 20 * i,
            line,
            font_family="monospace",
            font_size=12,
            **{"xml:space": "preserve"},
        )
        for i, line in enumerate(code)
    ]
    lines += panel(300, 20, 210, 190, "Equations", "flattening")
    rows = (f"{counts['components']} components become", f"{flat} numbered equations.")
    rows += ("Each class is lowered to", "CasADi once, for all of", "its instances.")
    lines += [text(314, 76 + 22 * i, row) for i, row in enumerate(rows)]
    lines += panel(540, 20, 230, 190, "States", "reduction")
    shrinking = ((flat, "equations"), (joined, "without aliases"), (states, "states"))
    for i, (count, what) in enumerate(shrinking):
        y, long = 66 + 46 * i, 200 * count / flat
        lines.append(f'<rect x="554" y="{y}" width="{long:.1f}" height="14" fill="{BLUE}"/>')
        lines.append(text(554, y + 30, f"{count} {what}"))
    lines += panel(800, 20, 240, 190, "System", "compiler")
    formulas = (("der(x) = f(x, p, t, m)", "rates of the states"),)
    formulas += (("0 < g(x, p, t, m)", "margins to the next event"),)
    formulas += (("y = h(x, p, t, m)", "all other quantities"),)
    for i, (formula, words) in enumerate(formulas):
        lines.append(text(814, 64 + 38 * i, formula, font_family="monospace"))
        lines.append(text(814, 81 + 38 * i, words, fill=SOFT))
    lines.append(text(814, 180, "x states, p parameters, t time,"))
    lines.append(text(814, 198, "m settings: stuck, open, ..."))
    return lines + [arrow((x, 115), (x + 26, 115)) for x in (272, 512, 772)]


def loop() -> list[str]:
    """The time loop: a step, its error, its margins, what holds from an instant on."""
    boxes = ((36, 300, "step"), (184, 300, "error small?"), (184, 390, "event?"))
    boxes += ((36, 390, "settle, jump"),)
    lines = []
    for x, y, words in boxes:
        lines.append(f'<rect x="{x}" y="{y}" width="112" height="36" fill="white" stroke="{INK}"/>')
        lines.append(text(x + 56, y + 23, words, text_anchor="middle"))
    lines += [
        arrow((148, 312), (180, 312)),
        arrow((184, 327), (152, 327)),
        text(166, 344, "no", fill=SOFT, text_anchor="middle"),
        arrow((240, 336), (240, 386)),
        text(247, 366, "yes", fill=SOFT),
        arrow((184, 408), (152, 408)),
        text(166, 427, "yes", fill=SOFT, text_anchor="middle"),
        arrow((92, 390), (92, 340)),
        arrow((204, 390), (130, 340)),
        text(150, 376, "no", fill=SOFT),
        text(36, 456, "by LLVM, in C, in Python, alone or"),
        text(36, 474, "side by side: the same bits"),
    ]
    return lines


def middle(system: lp.System) -> list[str]:
    """A run, and a point with its modes."""
    run = lp.simulate(system, until=0.4, grid=80)
    lines = panel(20, 250, 670, 240, "Run", "code, kernel, timeloop, simulation")
    lines += [*loop(), *curve(run, "rotor.w", 330, 296, 335, 160)]
    lines += panel(720, 250, 320, 240, "Point", "points, vibration")
    modes = lp.modes(system, at=run.point(0.3))
    lines.append(text(734, 300, "start, equilibrium, linearisation"))
    lines.append(text(734, 320, f"mode at {modes.hertz[0]:.1f} Hz, brake open:", fill=SOFT))
    names = ("rotor.phi", "wheel.phi", "drum.phi")
    shape = [float(modes.shape(name)[0].real) for name in names]
    size = max(abs(each) for each in shape)
    places = [(770 + 100 * i, 400 - 55 * each / size) for i, each in enumerate(shape)]
    lines.append(f'<path d="M750 400H1000" stroke="{SOFT}" stroke-dasharray="4 3"/>')
    joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    lines.append(f'<polyline points="{joined}" fill="none" stroke="{BLUE}" stroke-width="2"/>')
    for (x, y), name in zip(places, names, strict=True):
        lines.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{BLUE}"/>')
        lines.append(text(x, 478, name.split(".")[0], text_anchor="middle", fill=SOFT))
    return [
        *lines,
        arrow((920, 212), (920, 246)),
        arrow((860, 212), (860, 230), (355, 230), (355, 246)),
        arrow((718, 268), (694, 268)),
        arrow((692, 284), (716, 284)),
    ]


def lower() -> list[str]:
    """What is made of runs and points."""
    lines = [
        arrow((355, 492), (355, 510)),
        arrow((880, 492), (880, 510)),
        arrow((1040, 115), (1052, 115), (1052, 519), (1044, 519)),
        f'<path d="M20 524V514H1040V524" fill="none" stroke="{SOFT}" stroke-width="2"/>',
    ]
    for i, (folders, *words) in enumerate(USES):
        x, y = 20 + 259 * (i % 4), 530 + 82 * (i // 4)
        lines.append(f'<rect x="{x}" y="{y}" width="243" height="70" rx="8" fill="{PAPER}"/>')
        lines.append(text(x + 14, y + 20, ", ".join(folders), fill=BLUE))
        lines += [text(x + 14, y + 41 + 18 * k, line) for k, line in enumerate(words)]
    return lines


def picture() -> str:
    """The picture as text."""
    system = lp.assemble(lift())
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="14" fill="{INK}">',
        '<defs><marker id="head" markerWidth="8" markerHeight="8" refX="6" refY="3" '
        f'orient="auto"><path d="M0 0L7 3L0 6z" fill="{SOFT}"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    return "\n".join([*lines, *upper(system), *middle(system), *lower(), "</svg>\n"])


if __name__ == "__main__":
    (DOCS / "model.svg").write_text(picture(), encoding="utf-8")
