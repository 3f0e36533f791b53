"""Templates: scene files with a `dataset` block, and draws where values stand."""
