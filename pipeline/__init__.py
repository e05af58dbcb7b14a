"""Runs the study: reads parameters, finds what is stale, runs stages, keeps results. Knows nothing of its subject."""
