"""Machine code for runs: functions of a system and the time loop, without Python in between."""
