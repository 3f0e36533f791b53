"""Scene text to plain data, with the span of every value."""
