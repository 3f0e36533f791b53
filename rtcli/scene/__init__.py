"""Scene files: text to data (`reading`), data to `model` (`validation`), and their problems (`diagnostics`)."""
