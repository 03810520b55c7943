"""Controllers, sensors, signals, sequences."""
