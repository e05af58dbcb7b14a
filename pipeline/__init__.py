"""Runs the study: reads parameters, decides what is stale, runs stages, keeps their results. Knows nothing of walking."""
