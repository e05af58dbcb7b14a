"""What the calibrated twin depends on."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.accuracy.level import Level
from stages.biped.design import Biped
from stages.calibration.parameters import Parameters as CalibrationParameters
from stages.calibration.parameters import Settings
from stages.campaign.parameters import RunSettings, SensorSettings
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.imu.parameters import Drawing, Limits
from stages.imu.parameters import Settings as IngestSettings
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Parameters:
    """All the stage depends on."""

    biped: Biped
    slope: Slope
    contact: ContactLaw
    sensor: SensorSettings
    runs: RunSettings
    settings: Settings
    ingest_settings: IngestSettings
    limits: Limits
    drawing: Drawing
    twin: TwinSettings
    level: Level = Level()

    @property
    def calibration(self) -> CalibrationParameters:
        """What the calibration itself depends on."""
        return CalibrationParameters(
            self.biped, self.slope, self.sensor, self.settings, self.ingest_settings, self.limits, self.drawing,
            self.twin, self.level)
