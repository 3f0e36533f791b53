"""Data sets: from a template to labelled pictures."""
