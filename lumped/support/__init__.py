"""Helpers independent of models: texts, tables, units, checks of arguments, files, progress."""
