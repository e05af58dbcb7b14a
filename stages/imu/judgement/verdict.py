"""What is said against a trial, and what follows: accepted, accepted with remarks, or refused."""

from dataclasses import dataclass

ACCEPTED, WITH_REMARKS, REFUSED = "accepted", "accepted with remarks", "refused"

# Quantities a remark can be about; a sensor's own bear its place before them.
CLOCK, FREQUENCY, STRIKES, LEGS, LAG, LEVER = (
    "clock", "step frequency", "heel strikes", "legs", "foot lag", "lever arm",
)  # fmt: skip
FRAME, FORCE, RATE = "frame", "force", "rate"

#: What follows from others: not to be trusted where one of those is not, at either place. A sensor's force does from
#: its frame.
LEG_ANGLE, STEP_LENGTH = "leg angle", "step length"
FOLLOWS = ((LEG_ANGLE, (FRAME, RATE, LAG, CLOCK)), (STEP_LENGTH, (LEG_ANGLE, STRIKES, LEGS)))


@dataclass(frozen=True)
class Finding:
    """What one piece of evidence says against a trial; `about` are the quantities not to be trusted."""

    refused: bool
    about: tuple[str, ...]
    sentence: str


@dataclass(frozen=True)
class Verdict:
    """The findings against a trial, put together."""

    findings: tuple[Finding, ...] = ()

    @property
    def outcome(self) -> str:
        """One of ACCEPTED, WITH_REMARKS, REFUSED."""
        if any(one.refused for one in self.findings):
            return REFUSED
        return WITH_REMARKS if self.findings else ACCEPTED

    @property
    def accepted(self) -> bool:
        """Whether the trial is used, with or without remarks."""
        return self.outcome != REFUSED

    @property
    def not_trusted(self) -> tuple[str, ...]:
        """Quantities that the remarks are about, and what follows from them, each once."""
        stated = [name for one in self.findings if not one.refused for name in one.about]
        names = [each for name in stated for each in (name, name.replace(FRAME, FORCE))]
        for name, origins in FOLLOWS:
            names += [name] if any(one.removeprefix("hip ").removeprefix("foot ") in origins for one in names) else []
        return tuple(dict.fromkeys(names))

    def sentences(self, refused: bool) -> tuple[str, ...]:
        """Of the refusals, or of the remarks."""
        return tuple(one.sentence for one in self.findings if one.refused == refused)


Rule = Finding | None


def refusal(holds: bool, sentence: str) -> Rule:
    """What is said of a trial that is not used where this holds."""
    return Finding(True, (), sentence) if holds else None


def remark(holds: bool, sentence: str, *about: str) -> Rule:
    """What is said where this holds, and of which quantities."""
    return Finding(False, about, sentence) if holds else None
