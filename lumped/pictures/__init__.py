"""Pictures of models and runs: schematics, moving linkages, and pages."""
