"""The forms of a data set: one module each."""
