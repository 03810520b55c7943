"""Reference cases, scenes of the machines and random nets stand in folders of their own."""

import sys
from pathlib import Path

for folder in ("msl", "kernel", "components"):
    sys.path.append(str(Path(__file__).parents[1] / folder))
