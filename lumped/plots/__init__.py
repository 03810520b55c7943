"""Pictures as data, and what draws them: matplotlib or plotly."""
