"""What is probably not meant in a valid scene, and in its picture."""
