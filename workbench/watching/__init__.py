"""Watching: a study as it runs, in the terminal and on a local page."""
