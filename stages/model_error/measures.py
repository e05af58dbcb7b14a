"""What is asked of a gait; read without what computes."""

from __future__ import annotations

#: What is asked of a gait: name, unit, and whether an error of it is told as a share of it. The last is the largest
#: multiplier's magnitude.
MEASURES = (
    ("period", "s", True), ("step_frequency", "Hz", True), ("step_length", "m", True), ("speed", "m/s", True),
    ("multiplier", "1", False),
)  # fmt: skip
NAMES = tuple(name for name, _, _ in MEASURES)
