"""The truth behind the synthetic measurements: for scoring the ingest, never for the ingest."""

from dataclasses import dataclass

import numpy as np

from stages.biped.design import Biped
from stages.biped.quantity import quantity

#: What the name of a run without the outsole has more than that of the same machine's with it.
BARE = "bare "
#: The databases: of the runs as the prototype is, and of those without its outsole.
DATABASE, WITHOUT_OUTSOLE = "measurements.sqlite", "without_outsole.sqlite"
#: Why some numbers have no error.
DRAWN = "it is drawn"


@dataclass(frozen=True)
class SensorErrors:
    """The truth about one sensor that the ingest must not know."""

    rotation: np.ndarray = quantity(
        "1", "rotation from body to sensor axes, shape (3, 3)", symbol="R", without_error=DRAWN)
    acceleration_gain: np.ndarray = quantity(
        "1", "gain of each accelerometer axis, shape (3,)", dimensions=("sensor_axis",), without_error=DRAWN
    )
    angular_rate_gain: np.ndarray = quantity(
        "1", "gain of each gyroscope axis, shape (3,)", dimensions=("sensor_axis",), without_error=DRAWN
    )
    acceleration_bias: np.ndarray = quantity(
        "m/s^2", "bias of each accelerometer axis, shape (3,)", dimensions=("sensor_axis",), without_error=DRAWN
    )
    angular_rate_bias: np.ndarray = quantity(
        "rad/s", "bias of each gyroscope axis, shape (3,)", dimensions=("sensor_axis",), without_error=DRAWN
    )
    period: float = quantity("s", "true sampling period", without_error=DRAWN)


@dataclass(frozen=True)
class SensorTruth(SensorErrors):
    """One synthetic sensor in one run."""

    place: str = quantity("-", "hip or foot")
    low_pass_delay: float = quantity(
        "s", "delay of the sensor's low pass far below its cut-off", without_error="it follows from the cut-off alone")
    packet: np.ndarray = quantity("1", "packet number of each row that arrived, shape (n,)", dimensions=("sample",))
    position: np.ndarray = quantity("1", "its position in the packet, shape (n,)", dimensions=("sample",))
    sample_time: np.ndarray = quantity(
        "s", "true time at which it was sampled, shape (n,)", symbol="t", dimensions=("sample",), without_error=DRAWN
    )
    lost_packets: int = quantity("1", "packets that did not arrive")
    peak: float = quantity("m/s^2", "median over the strikes of the greatest specific force, as simulated")
    peak_filtered: float = quantity("m/s^2", "the same behind the sensor's low pass")
    peak_sampled: float = quantity("m/s^2", "the same in the sensor's samples")


@dataclass(frozen=True)
class LegTruth:
    """How the inner leg and the hip really moved through a walk, and when feet left the ground."""

    time: np.ndarray = quantity("s", "even times, shape (n,)", symbol="t")
    angle: np.ndarray = quantity("rad", "inner leg's angle from the slope normal, foot ahead positive, shape (n,)")
    hip_at_strike: np.ndarray = quantity(
        "m", "hip along and above the slope at each heel strike, shape (s, 2)", dimensions=("heel_strike", "direction")
    )
    toe_off_time: np.ndarray = quantity("s", "times of toe-off, shape (o,)", symbol="t_TO", dimensions=("toe_off",))
    toe_off_leg: np.ndarray = quantity(
        "1", "pair that leaves the ground, 0 inner, 1 outer, shape (o,)", dimensions=("toe_off",)
    )


@dataclass(frozen=True)
class RunTruth:
    """One synthetic run."""

    name: str = quantity("-", "experiment, as in the database")
    clock_start: float = quantity("s", "what the phone's clock showed at true time zero")
    slope_deg: float = quantity("deg", "true inclination")
    stance_push: float = quantity("1", "factor on the stance leg's initial rate")
    swing_push: float = quantity("1", "factor on the swing leg's initial rate")
    outsole: float = quantity("m", "thickness of the outsole")
    robot: Biped = quantity("-", "the machine of this run seen from the side, left and right on average")
    weighed: float = quantity("kg", "mass of the machine as the scale showed it")
    failed_attempts: int = quantity("1", "pushes after which the twin did not walk to the end")
    heel_strike_time: np.ndarray = quantity(
        "s", "true times of heel strike, shape (s,)", symbol="t_HS", dimensions=("heel_strike",)
    )
    heel_strike_leg: np.ndarray = quantity(
        "1", "pair that lands, 0 inner, 1 outer, shape (s,)", dimensions=("heel_strike",)
    )
    leg: LegTruth = quantity("-", "motion of the inner leg and of the hip")
    hip: SensorTruth = quantity("-", "hip sensor")
    foot: SensorTruth = quantity("-", "foot sensor")


@dataclass(frozen=True)
class SetSpike:
    """What the twin's planar sensors read in the first steps on one member of the contact set's family; NaN if it fell.

    A component counts: forward or up the leg, as a sensor's range does.
    """

    share: float = quantity("1", "member of the contact set's family; 1 is the set itself, 0 the rigid limit")
    contact_stiffness: float = quantity("N/mm^e", "stiffness of the normal force", symbol="k_c")
    hip_peak: float = quantity("m/s^2", "largest specific force at the hip")
    foot_peak: float = quantity("m/s^2", "largest specific force at the foot")
    time_above_range: float = quantity("s", "time a step that a component is above the accelerometer's range")


@dataclass(frozen=True)
class Result:
    """The synthetic campaign: the truth of every run, and the database a lab would have."""

    origin: str = quantity("-", "synthetic, or not needed where a lab has measurements of its own")
    runs: tuple[RunTruth, ...] = quantity("-", "all runs")
    bare: tuple[RunTruth, ...] = quantity("-", "runs made again without the outsole: same machine, push and ramp")
    spikes: tuple[SetSpike, ...] = quantity("-", "what the sensors would read on other members of the contact's family")
    files: dict[str, bytes] = quantity("-", "the synthetic measurements, and those without an outsole, by name")

    def summary(self) -> str:
        """What was made, in one line."""
        if not self.runs:
            return f"{self.origin}: imu.database holds the measurements"
        strikes = sum(len(run.heel_strike_time) for run in self.runs)
        failed = sum(run.failed_attempts for run in self.runs)
        rows = sum(len(sensor.sample_time) for run in self.runs for sensor in (run.hip, run.foot))
        again = f", {failed} failed attempts" if failed else ""
        return f"{len(self.runs)} synthetic runs of the twin, {strikes} heel strikes, {rows} rows{again}"

    def tables(self) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
        """What the sensor makes of the spike at heel strike: (title, columns, rows); none without runs."""
        if not self.runs:
            return []
        rows: list[tuple[str, ...]] = []
        for place in ("hip", "foot"):
            sensors = [getattr(run, place) for run in self.runs]
            peaks = [(s.peak, s.peak_filtered, s.peak_sampled) for s in sensors]
            rows.append((place, *(f"{value:.1f}" for value in np.median(peaks, axis=0))))
        sensed: list[tuple[str, ...]] = [
            (f"{one.share:g}", f"{one.contact_stiffness:.3g}", f"{one.hip_peak:.0f}", f"{one.foot_peak:.0f}",
             f"{1e3 * one.time_above_range:.2f}")
            for one in self.spikes
        ]  # fmt: skip
        sets = ("share", "k_c N/mm^e", "hip m/s^2", "foot m/s^2", "above range, ms a step")
        columns = ("sensor", "simulated m/s^2", "behind the low pass m/s^2", "in the samples m/s^2")
        return [
            ("Spike at heel strike (synthetic)", columns, rows),
            ("The twin's spike on the family of the contact set towards the rigid limit", sets, sensed),
        ]
