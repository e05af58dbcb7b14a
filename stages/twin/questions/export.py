"""`export`: the twin, or the planar walker on penalty ground, as a file for another program."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, option, refuse

if TYPE_CHECKING:
    from stages.twin.exports.exported import Exported
    from stages.twin.exports.gltf import Motion
    from stages.twin.parameters import Parameters

FORMATS = ("mjcf", "urdf", "sdf", "gltf")
#: Poses a second of an animation; viewers go straight between them.
FRAME_RATE = 120.0


@dataclass(frozen=True)
class Options:
    """Options of `export`."""

    what: str = option("-", "What is exported", positional=True, choices=("twin", "walker"))
    format: str = option("-", "Its format", choices=(*FORMATS, "fmu"))
    out: Path | None = option("-", "Write into this new file (default: the name with the format's ending)",
                              default=None)  # fmt: skip
    steps: int = option("1", "Steps of the walk that is shown (gltf); 0: as many as there are blocks for", default=0,
                        bound=Bound(minimum=0, maximum=1000))  # fmt: skip


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Write the file. Raises NoGait, NoLimitCycle, BlocksDoNotFit, BeyondModel."""
    from stages.twin.exports import gltf
    from stages.twin.exports.exported import exported
    from stages.twin.exports.formats import FORMATS as WRITERS

    rms = parameters.blocks.block_height_rms
    walks, said = options.what == "walker", f"the walker is written as fmu, the twin as {', '.join(FORMATS)}"
    refuse(((options.format == "fmu") != walks, f"--format = {options.format} is not allowed: {said}"),
           (rms > 0.0, f"ground.block_height_rms = {rms:g} m: exported blocks are level; allowed here: 0 m"))
    if walks:
        return unit(parameters, options.out or Path("walker.fmu"), asking)
    chosen = WRITERS[options.format]
    path = options.out or Path(f"{options.what}.{chosen.ENDING}")
    with asking.new_file(path) as file:
        asking.progress(0.1, "looking for the gait to start on")
        given = exported(parameters)
        if chosen is gltf:
            asking.progress(0.3, "walking")
            content = gltf.write(given, walked(given, options.steps))
        else:
            content = chosen.write(given)
        file.write_bytes(content)
    missing = [(what, carried, ", ".join(values(given, what))) for what, carried in chosen.CARRIES.items()
               if not carried.startswith("yes")]  # fmt: skip
    start = {joint.name: {"value": value, "rate": rate} for joint, value, rate in given.coordinates()}
    return Answer(
        [f"{path}: the twin for {chosen.OF}, {len(content) / 1000:.0f} kB, {len(given.links)} bodies, "
         f"{given.ramp.sets} sets of blocks"],
        {"file": str(path), "bytes": len(content), "carries": chosen.CARRIES, "start": start},
        tables=(("What it does not carry, or not in full", ("what", "in this format", "here"), missing),),
    )  # fmt: skip


def unit(parameters: Parameters, path: Path, asking: Asking) -> Answer:
    """Write the walker as a Functional Mock-up Unit. Raises NoGait, NoLimitCycle, BeyondModel."""
    from stages.twin.exports.fmu.package import write

    with asking.new_file(path) as file:
        asking.progress(0.1, "looking for the gait to start on")
        content, numbers = write((parameters.biped, parameters.slope, parameters.contact))
        file.write_bytes(content)
    start = {each.name: {"value": each.start, "unit": each.unit} for each in numbers if each.start is not None}
    said = f"{path}: the walker for FMI 3.0, model exchange, {len(content) / 1000:.0f} kB, {len(numbers)} numbers"
    return Answer([said], {"file": str(path), "bytes": len(content), "start": start})


def walked(given: Exported, steps: int) -> Motion:
    """The walk on a plane, for an animation; as far as it goes."""
    import numpy as np

    from stages.twin.walking.simulate import simulate_twin

    record = simulate_twin(given.machine, given.slope, given.contact, given.start, given.settings,
                           steps=steps or given.ramp.steps)  # fmt: skip
    time = np.arange(0.0, record.time[-1], 1.0 / FRAME_RATE)
    return time, record.at(time)[0]


def values(given: Exported, what: str) -> Iterator[str]:
    """The study's numbers for what a format leaves out, so that they can be given in another way."""
    from stages.twin.machine.machine import LEGS

    law = given.contact
    if what == "springs and dampers":
        legs = [f"{each.stiffness:g} N/m, {each.damping:g} N s/m" for each in given.slides]
        yield from ([f"each leg {legs[0]}"] if len({*legs}) == 1 else map("{} leg {}".format, LEGS, legs))
        hinge = given.hinge
        if hinge.stiffness or hinge.damping or hinge.friction:
            yield (f"hinge {hinge.stiffness:g} N m/rad at rest at {hinge.rest:g} rad, {hinge.damping:g} N m s/rad, "
                   f"{hinge.friction:g} N m")
    elif what == "start":
        yield from (f"{joint.name} {value:.6g} at {rate:.6g}/s" for joint, value, rate in given.coordinates()
                    if value or rate)  # fmt: skip
    elif what == "contact law":
        yield f"{law.normal_force}: {law.contact_stiffness:g} N/mm^{law.contact_exponent:g} a pair"
        if law.normal_force == "impact":
            yield f"damping {law.contact_damping:g} N s/m from {1e3 * law.damping_depth:g} mm"
        else:
            yield f"restitution {law.restitution:g} at {law.impact_speed:g} m/s"
    elif what == "friction":
        held = law.coefficients
        yield f"{law.friction}: {held.static_friction:g} and {held.dynamic_friction:g}"
        yield f"{law.stiction_velocity:g} and {law.friction_velocity:g} m/s"
    elif what == "rule for scuffing":
        yield "no ground under a pair that swings"
    elif what == "motion":
        yield "bipedstudy run twin"


QUESTION = Question(
    "export",
    """Write the twin at the start of its walk, with the ramp's stepping blocks, as a file for another program.

    mjcf (MuJoCo) has all but the contact law. urdf and sdf have bodies and joints. gltf is the walk as an animation.
    fmu is the planar walker with its contact laws on even ground; it needs a C compiler. Prints what the format cannot
    carry, with the numbers; docs/exports.md compares the formats and the walks.
    """,
    Options,
    ask,
    examples=("bipedstudy export twin --format mjcf", "bipedstudy export twin --format gltf --out walk.glb",
              "bipedstudy export walker --format fmu"),
)
