"""Natural frequencies, damping and shapes, and how they change with parameters."""
