"""Data to a checked model, and what is wrong with it in the words of a scene file."""
