"""The problems of scene files, as data: where, what, and what to do instead."""
