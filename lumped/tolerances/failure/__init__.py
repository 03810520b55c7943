"""How likely a limit is exceeded: design points, curvature, samples."""
