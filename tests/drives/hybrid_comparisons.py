"""Many random drives or impacts, or storms, compared with the reference; counts of verdicts."""

import re
import signal
import time
from collections import Counter

from hybrid_drives import RandomDrive
from hybrid_impacts import RandomImpact, compare_impact
from hybrid_storms import Storm
from hybrid_verdicts import PATIENCE, SlowError, alarm, compare, unit

from lumped.errors import LumpedError


def impacts(first, last):
    """Compare impacts and count verdicts."""
    count, why = Counter(), Counter()
    for seed in range(first, last):
        verdict = compare_impact(seed)
        count[verdict.word] += 1
        if verdict.word not in ("agrees", "law open, sound"):
            case = RandomImpact(seed)
            kinds = ", ".join(f"{k} {e:.2g}" for k, e, _, _ in case.links)
            words = re.sub(r"-?\d[-+.\de]*", "#", verdict.text.split("Last tried")[0])
            why[verdict.word + " " + words] += 1
            print(f"{seed}: {verdict.word} {verdict.text} [{kinds}]", flush=True)
    print(dict(count))
    for text, times in why.most_common():
        print(f"{times:5d} {text}")


def storms():
    """Storms of growing length, each with the time that it takes."""
    signal.signal(signal.SIGALRM, alarm)
    for e in (0.9, 0.99, 0.999):
        for kind in ("plays", "stops"):
            for count, given in ((2, {}), (3, {}), (2, {"max_steps": 1000})):
                begun, storm = time.perf_counter(), Storm(kind, e, count)
                signal.alarm(PATIENCE)
                try:
                    _, losses, gone, left = storm.run(**given)
                    text = f"{len(losses)} instants, {sum(losses):.9g} of {gone:.9g} J"
                    text += f", {left:.1e} rad/s left, least loss {min(losses):.1e} J"
                except SlowError:
                    text = "SLOW"
                except LumpedError as failure:
                    text = str(failure)[:150]
                signal.alarm(0)
                print(f"{storm} {given}: {text}, {time.perf_counter() - begun:.1f} s", flush=True)


def drives(first, last, step=1, through=None):
    """Compare drives and count verdicts."""
    count, worst = Counter(), 0.0
    for seed in range(first, last, step):
        begun = time.perf_counter()
        verdict = compare(seed, through=through)
        count[verdict.word] += 1
        worst = max(worst, verdict.accuracy if verdict.word == "agrees" else 0.0)
        if verdict.word != "agrees":
            kinds = ", ".join(RandomDrive(seed).kinds)
            print(
                f"{seed}: {verdict.word} {verdict.text} [{kinds}] reference to "
                f"{verdict.accuracy:.0e}, {time.perf_counter() - begun:.0f} s",
                flush=True,
            )
    print(f"{dict(count)}; the reference is worth {worst:.0e} of each scale or better")


def main(arguments):
    """Random drives; with a word before the numbers: impacts, units, or storms."""
    words = [a for a in arguments if not a.isdigit()]
    numbers = [int(a) for a in arguments if a.isdigit()]
    first, last = [0, *numbers][-2:] if numbers else (0, 100)
    if words == ["units"]:
        drives(first, last, 20, unit)
    elif words == ["impacts"]:
        impacts(first, last)
    elif words == ["storms"]:
        storms()
    else:
        drives(first, last)
