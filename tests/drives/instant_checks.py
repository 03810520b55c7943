"""Checks a run of a drive against the laws of its instants and motions; knows no `lumped`.

A run is given by its states on both sides of each event, and at some times between. It is not
simulated a second time, but each part of it is checked from its own states (`instant_laws`,
`instant_motions`), so that chaos does not matter.
"""

import numpy as np
from hybrid_reference import STICK
from instant_laws import MARGINS, Finding, Law
from instant_motions import Motions

MOMENT = 1e-8
"""Length of a part of a run that is too short to see its modes, s."""


def check(drive, parts, happened):
    """What is wrong with a run.

    Parameters
    ----------
    drive : Drive
        Its reference, with positions and speeds before the run begins.
    parts : list of Part
        Between its events.
    happened : list of tuple
        Times of events, names of contacts that change or collide, and energies lost.
    """
    found, law, past = Finding(), Law(drive), []
    motions = Motions(law)
    q, v, a, modes, named = drive.q, drive.v, 0.0 * drive.v, None, set()
    for part in parts:
        t, size = part.t[0], 1.0 + np.abs(part.q[0]).max()
        law.enter(t)
        if np.abs(part.q[0] - q).max() > 1e-9 * size:
            found.wrong.append(f"{t:.7f}: positions jump")
        law.check_impact(t, part.q[0], v, part.v[0], found)
        told = sum(loss for s, _, loss in happened if s == t)
        lost = float(law.J @ (v**2 - part.v[0] ** 2)) / 2
        if abs(lost - told) > MARGINS * (1 + float(law.J @ v**2)):
            found.wrong.append(f"{t:.7f}: events say {told:.4g} J of {lost:.4g} J lost")
        law.stuck = {k for k, mode in enumerate(modes or ()) if mode == STICK}
        law.check_rates(part, found)
        named |= {
            name
            for s, name, _ in happened
            if abs(s - t) < 1e-12 or law.ends_series(name, t, a, s, happened)
        }
        if part.t[-1] - t > MOMENT:
            before, doubtful = modes, motions.doubtful
            modes = motions.check(part, modes, found)
            changed = motions.changed(before or modes, modes) - named - doubtful
            changed = {name for name in changed if not motions.was_idle(name, past)}
            modes = motions.as_before_if_idle(part, modes, before, changed)
            changed &= motions.changed(before or modes, modes)
            past.append((part, modes, drive.piece, named))
            if changed:
                found.wrong.append(f"{t:.7f}: {sorted(changed)} change without event")
            named = set()
        q, v, a = part.q[-1], part.v[-1], part.a[-1]
        if len(found.wrong) > 3:
            break
    return found
