"""Steps by DOP853, Rodas5P and series, each with what it gives inside."""
