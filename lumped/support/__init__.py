"""What knows nothing of models: texts, tables, units, checks of arguments, files, progress."""
