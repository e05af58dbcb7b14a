"""What the calibrated twin depends on."""

from dataclasses import dataclass

from stages.calibration.parameters import Parameters as CalibrationParameters
from stages.campaign.parameters import RunSettings
from stages.ground.contact_law import ContactLaw


@dataclass(frozen=True, kw_only=True)
class Parameters(CalibrationParameters):
    """All the stage depends on: what the calibration itself does, and what the twin's runs do beside."""

    contact: ContactLaw
    runs: RunSettings
