"""A system as a plant that the time loop runs, and the room for a run."""
