"""Scene files: text to data (`parse`), data to a checked model (`model`), and what is wrong with them."""
