"""The time loop in machine code, and the small language in which it is written."""
