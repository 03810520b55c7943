"""Elastic couplings and dampers of torsional vibration."""
