"""Entry point of ``python -m benchmarks.published``."""

from benchmarks.published import main

main()
