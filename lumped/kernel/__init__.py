"""The time loop, from start to end: steps, crossings, positions, impacts, shares of friction."""
