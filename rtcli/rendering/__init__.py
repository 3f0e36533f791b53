"""From a checked scene to a film, or straight to its files."""
