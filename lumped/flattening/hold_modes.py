"""The modes of a hold, in their order among all modes.

The first three tell its position, 0 or 1 each. What sticks accelerates by `DEMAND`, as impulses ask
for it, and by `COMPLIANCE` times what it carries beyond its `SHARE`, as redundant constraints share
what they carry; what does not stick carries its `SHARE` beside its law, as a limit at rest asks for
it. `SLACK` is what of a reaction is rounding. `PARTED` is the gap at which bodies parted last, zero
but for rounding; gaps count from there.
"""

from __future__ import annotations

STUCK, FORWARD, BACKWARD, COMPLIANCE, DEMAND, SHARE, SLACK, PARTED = range(8)
COUNT = 8
