"""Natural frequencies, damping, responses, and their derivatives."""
