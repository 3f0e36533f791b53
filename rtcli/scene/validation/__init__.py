"""From data to a validated scene, and to problems in the words of a scene file."""
