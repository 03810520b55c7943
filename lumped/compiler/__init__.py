"""From a component tree to a system, step by step."""
