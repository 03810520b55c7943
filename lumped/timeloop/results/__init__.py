"""Results of runs, their events and files."""
