"""The difference between two pictures, or two files of arrays."""
