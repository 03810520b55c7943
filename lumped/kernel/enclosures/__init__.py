"""What happens inside a step, enclosed and not sampled."""
