"""Problems of scene files: where, what, and what to do instead."""
