"""How far two pictures, or two files of arrays, are apart."""
