"""What the analytic stage refuses, with its reason."""


class NoGait(ValueError):
    """The design has no gait of the kind requested; the message says why."""


class StepFailed(ValueError):
    """A step did not reach its heel strike; the message says what happened instead."""


class NotDerived(RuntimeError):
    """The equations of motion are not there and cannot be derived; the message says why."""
