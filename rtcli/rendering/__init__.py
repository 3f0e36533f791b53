"""From a validated scene to a film, or straight to its files."""
