"""A run: its instants, its changes of modes, its steps, its results."""
