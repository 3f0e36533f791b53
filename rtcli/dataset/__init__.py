"""Data sets: from a template to labeled pictures."""
