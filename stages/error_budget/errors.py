"""What ends the budget early."""


class NotWalked(Exception):
    """A model on the path does not take the step; the message says why."""
