"""Operating points: start, equilibrium, linearisation, and how they change."""
