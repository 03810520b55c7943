"""``python -m lumped``: the command."""

import sys

from lumped.cli import main

sys.exit(main())
