"""What the calibration refuses, with its reason."""

from __future__ import annotations


class NotIdentified(ValueError):
    """The measurements cannot tell what is asked of them; the message says what is missing."""
