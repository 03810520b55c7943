"""What the README and the page of benchmarks say of the results."""
