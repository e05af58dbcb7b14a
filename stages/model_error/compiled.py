"""What this stage's questions compile: what the constraint walkers do."""

from stages.analytic.compiled import CODE, COMPILING

__all__ = ["CODE", "COMPILING"]
