"""Few states and explicit equations from many: aliases, index reduction, order of computation."""
