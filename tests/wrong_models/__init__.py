"""Models that are wrong, a module for each kind of mistake, and the answers to them."""
