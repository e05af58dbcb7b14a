"""Sweeps: one stage computed at many points of parameter space, in many processes, on one machine or several."""
