"""The assembled system: states in use, what switches, functions, report."""
