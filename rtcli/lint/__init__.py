"""Warnings about a valid scene that is probably not as intended, and about its picture."""
