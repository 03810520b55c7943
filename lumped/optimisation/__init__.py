"""Parameters and motions that are best, or that fit what was measured."""
