"""What the twin stage hands on."""

from dataclasses import dataclass
from math import ceil, floor, isnan, log10, nan

import numpy as np

from stages.biped.accuracy.estimate import ErrorEstimate
from stages.biped.quantity import count_of, quantity
from stages.biped.walk import Walk
from stages.multibody.assembly.inventory import Inventory

Table = tuple[str, list[str], list[list[str]]]


@dataclass(frozen=True)
class PartRow:
    """A row of the bill of parts with the inertia that follows from its shape."""

    name: str = quantity("-", "name")
    group: str = quantity("-", "rigid group")
    material: str = quantity("-", "material")
    shape: str = quantity("-", "shape and size in mm")
    pieces: int = quantity("1", "number of pieces")
    mass: float = quantity("kg", "mass of one piece")
    x: float = quantity("m", "mass centre, forward of the hip axis")
    y: float = quantity("m", "mass centre, above the hip axis")
    z: float = quantity("m", "mass centre, along the hip axis")
    inertia_x: float = quantity("kg m^2", "moment of inertia of one piece about its mass centre, axis x")
    inertia_y: float = quantity("kg m^2", "the same, axis y")
    inertia_z: float = quantity("kg m^2", "the same, axis z")


@dataclass(frozen=True)
class SumRow:
    """A sum of the bill beside the design."""

    what: str = quantity("-", "what is summed, with its unit")
    found: float = quantity("1", "sum of the bill")
    table_1: float = quantity("1", "value of the design")


@dataclass(frozen=True)
class EnergyBalance:
    """Work and losses over a span of the walk; the residual is what does not add up."""

    gravity_work: float = quantity("J", "work of gravity")
    leg_damper_loss: float = quantity("J", "energy lost in the legs' dampers and sliders")
    bearing_loss: float = quantity("J", "energy lost in the bearings")
    ground_loss: float = quantity("J", "energy given to the ground: damping, friction, its spring")
    stored: float = quantity("J", "increase of kinetic energy and of the energy in the legs' springs")
    residual: float = quantity("J", "work of gravity less losses and stored energy")

    @property
    def relative_residual(self) -> float:
        """Residual as a part of the work of gravity."""
        return abs(self.residual / self.gravity_work)


#: Said where a mean holds an unknown part of a transient.
UNKNOWN = " (what is left of the transient is unknown)"


def with_doubt(value: float, left: float, unit: str = "") -> str:
    """A value with what is left open, rounded up to one digit, or two where the first is 1; that of a transient is
    unknown where it is not positive, and four digits are given.
    """
    if not left > 0.0:
        return f"{value:.4g}{unit}{UNKNOWN}"
    first = -floor(log10(left))
    places = max(0, first + (left * 10.0**first < 1.95))
    return f"{value:.{places}f} ± {ceil(left * 10.0**places) / 10.0**places:.{places}f}{unit}"


@dataclass(frozen=True)
class Settling:
    """Measures of each step, from heel strike to heel strike, and of the last four; NaN if the walk is too short."""

    step_period: np.ndarray = quantity("s", "duration of each step, shape (s - 1,)", symbol="T", dimensions=("step",))
    step_length: np.ndarray = quantity(
        "m", "advance of the hip in each step, shape (s - 1,)", symbol="s", dimensions=("step",)
    )
    steps_to_settle: int = quantity("1", "steps until period and length stay within 1% of its leg's last two; -1: no")
    period_s: float = quantity("s", "mean duration of the last four steps", symbol="T", default=nan)
    step_frequency_hz: float = quantity("Hz", "steps per second, of these four", symbol="f", default=nan)
    step_length_m: float = quantity("m", "mean advance of the hip in these four steps", symbol="s", default=nan)
    speed_m_s: float = quantity("m/s", "mean speed of these four steps", symbol="v", default=nan)
    double_stance_s: float = quantity(
        "s", "mean time with both pairs on the ground in these four steps", symbol="t_DSP", default=nan
    )
    inner_outer_difference: float = quantity(
        "1", "limp: mean duration of inner pair's less outer pair's stance step in these four, over the mean",
        default=nan
    )
    largest_roll: float = quantity("rad", "largest roll in these four steps", default=nan)
    yaw_change: float = quantity("rad", "change of yaw over the walk", default=nan)
    lateral_drift: float = quantity("m", "sideways drift of the hip over the walk", default=nan)
    period_transient_s: float = quantity(
        "s", "what the transient leaves in period_s: the gait's own lies within it; NaN: it does not fade, or the walk "
        "is too short to say", default=nan
    )
    step_length_transient_m: float = quantity("m", "the same of step_length_m", default=nan)

    def frequency_text(self) -> str:
        """Step frequency of the last four steps, as far as it is the gait's own."""
        left = self.period_transient_s * self.step_frequency_hz / self.period_s
        return with_doubt(self.step_frequency_hz, left, " Hz")

    def length_text(self) -> str:
        """Their length in mm, as far as it is the gait's own."""
        return with_doubt(1e3 * self.step_length_m, 1e3 * self.step_length_transient_m, " mm")

    def last_four(self) -> str:
        """Both, or that the walk ended before."""
        if isnan(self.period_s):
            return "there are fewer"
        frequency, length = self.frequency_text(), self.length_text()
        return f"{frequency.removesuffix(UNKNOWN) if length.endswith(UNKNOWN) else frequency} and {length}"


@dataclass(frozen=True)
class Signals:
    """What is sampled of a walk in space; times as in `walk.time`. A signal that is not requested has no rows."""

    walk: Walk = quantity("-", "planar projection: leg 0 the inner pair, leg 1 the outer pair, feet of a pair averaged")
    hip_imu_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the hip socket: forward, up the leg, lateral, (n, 3)", symbol="f_hip",
        dimensions=("time", "body_axis")
    )
    hip_imu_angular_velocity: np.ndarray = quantity(
        "rad/s", "angular velocity at the hip socket on the same axes, (n, 3)", symbol="omega_hip",
        dimensions=("time", "body_axis")
    )
    foot_imu_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the inner foot's socket on the same axes, (n, 3)", symbol="f_foot",
        dimensions=("time", "body_axis")
    )
    foot_imu_angular_velocity: np.ndarray = quantity(
        "rad/s", "angular velocity at the inner foot's socket on the same axes, (n, 3)", symbol="omega_foot",
        dimensions=("time", "body_axis")
    )
    roll: np.ndarray = quantity("rad", "roll about the forward axis, shape (n,)", dimensions=("time",))
    yaw: np.ndarray = quantity("rad", "yaw about the slope's normal, shape (n,)", dimensions=("time",))
    lateral: np.ndarray = quantity(
        "m", "place of the hip across the slope, shape (n,)", symbol="z_hip", dimensions=("time",)
    )
    coordinates: np.ndarray = quantity(
        "m, rad", "x, y, z, yaw, roll, pitch, slides inner left and right, hinge, slides outer left and right, (n, 11)",
        dimensions=("time", "coordinate")
    )
    foot_force: np.ndarray = quantity(
        "N", "force of the ground on each foot, x, y, z, shape (n, 4, 3)", dimensions=("time", "foot", "direction")
    )


@dataclass(frozen=True)
class Snapshots:
    """Poses at k times; legs: inner left, inner right, outer left, outer right; feet are cylinders about `hip_axis`."""

    time: np.ndarray = quantity("s", "times, shape (k,)", symbol="t")
    hip: np.ndarray = quantity("m", "middle of the hip axis, shape (k, 3)", dimensions=("time", "direction"))
    hip_axis: np.ndarray = quantity("1", "direction of the hip axis, shape (k, 3)", dimensions=("time", "direction"))
    leg_top: np.ndarray = quantity(
        "m", "where each leg meets the hip axis, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    leg_up: np.ndarray = quantity(
        "1", "direction up each leg, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    foot_centre: np.ndarray = quantity(
        "m", "centre of each foot's cylinder, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    foot_radius: np.ndarray = quantity("m", "radius of each foot, shape (4,)", dimensions=("leg",))
    foot_width: float = quantity("m", "width of each foot")


@dataclass(frozen=True)
class Result:
    """A walk of the twin from the simple model's fixed point, and what is said of it."""

    outcome: str = quantity("-", "completed, or why the walk ended early")
    reason: str = quantity("-", "how it ended early, else empty")
    steps: int = quantity("1", "heel strikes")
    signals: Signals = quantity("-", "sampled signals in space and their planar projection")
    settling: Settling = quantity("-", "how the twin settles, and its last four steps")
    energy: EnergyBalance = quantity("-", "energy balance over the last whole step")
    snapshots: Snapshots = quantity("-", "poses of the last two strides")
    parts: tuple[PartRow, ...] = quantity("-", "bill of parts as they are in this machine; none of point masses")
    sums: tuple[SumRow, ...] = quantity("-", "sums of the bill beside the design")
    bill: str = quantity("-", "how the parts of twin.yaml were made to fit the design; empty: they are as written")
    errors: tuple[ErrorEstimate, ...] = quantity("-", "errors of the walk, where an accuracy was requested")
    solver_steps: int = quantity("1", "number of solver steps")
    inventory: Inventory = quantity("-", "what the scene held, counted in the assembled system")

    @property
    def walk(self) -> Walk:
        """The planar projection of the walk."""
        return self.signals.walk

    def summary(self) -> str:
        """One line of what was found."""
        if self.outcome != "completed":
            return f"{self.outcome} after {count_of(self.steps, 'step')}: {self.reason}"
        gait = self.settling
        when = f"within 1 % after step {gait.steps_to_settle}" if gait.steps_to_settle >= 0 else "not settled"
        return (
            f"{self.steps} steps, {when}; the last four: {gait.frequency_text()}, step {gait.length_text()}; "
            f"energy closed to {self.energy.relative_residual:.0e}{'; ' * bool(self.bill)}{self.bill}"
        )

    def tables(self) -> list[Table]:
        """Bill of parts, its sums beside the design, and the steps, as (title, columns, rows of text)."""
        bill = [
            [
                part.name, part.group.replace("_", " "), part.material, part.shape, str(part.pieces),
                f"{1e3 * part.mass:.1f}",
                *(f"{1e3 * value:.1f}" for value in (part.x, part.y, part.z)),
                *(f"{1e6 * value:.2f}" for value in (part.inertia_x, part.inertia_y, part.inertia_z)),
            ]
            for part in self.parts
        ]  # fmt: skip
        sums = [
            [row.what, f"{row.found:.5f}", f"{row.table_1:.3f}", f"{row.found - row.table_1:+.1e}"] for row in self.sums
        ]
        steps = [
            [str(step), f"{period:.5f}", f"{1e3 * length:.3f}"]
            for step, (period, length) in enumerate(
                zip(self.settling.step_period, self.settling.step_length, strict=True), 1
            )
        ]
        columns = ["part", "group", "material", "shape [mm]", "pieces", "mass [g]", "x [mm]", "y [mm]", "z [mm]",
                   "Ix [kg mm2]", "Iy [kg mm2]", "Iz [kg mm2]"]  # fmt: skip
        return [
            ("Bill of parts (masses and sizes assumed; mass centre from the middle of the hip axis)", columns, bill),
            ("Sums of the bill beside the design", ["sum", "bill", "design", "difference"], sums),
            ("Steps", ["step", "period [s]", "length [mm]"], steps),
        ]
