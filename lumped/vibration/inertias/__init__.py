"""A drive as inertias and shafts: mass-elastic data and Holzer tables."""
