"""The planar penalty walker as a Functional Mock-up Unit: all its numbers, C source, what a compiler makes of it.

The same design and compiler give the same bytes: no times, no paths, a token that is the source's digest.
"""

import hashlib
import io
import math
import platform
import shutil
import subprocess
import sysconfig
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.scales import powers, scales_of
from stages.biped.design import Biped, require_own_strikes
from stages.biped.question import WrongOption
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.motion.feet import LANDED, OUT
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import FALLEN_GUARD, Settings
from stages.planar.limit_cycle import gait_near
from stages.planar.run import PlanarState, rolling_state
from stages.planar.section import section_state
from stages.twin.exports.exported import Element, document, tag
from stages.twin.exports.fmu.equations import equations

#: A design on its slope and ground.
Sections = tuple[Biped, Slope, ContactLaw]
#: Coordinates: symbol in C, name and unit; rigid legs have the first four.
COORDINATES = (("x", "hip.x", "m"), ("y", "hip.y", "m"), ("phi_0", "leg_0.angle", "rad"),
               ("phi_1", "leg_1.angle", "rad"), ("L_0", "leg_0.length", "m"), ("L_1", "leg_1.length", "m"))  # fmt: skip
#: Causality, variability and initial of each group, in C's order, and their elements in the model's structure.
ROLES = {
    "TIME": ("independent", "continuous", ""), "STATE": ("output", "continuous", "exact"),
    "DERIVATIVE": ("local", "continuous", "calculated"), "STEPS": ("output", "discrete", "exact"),
    "STATUS": ("output", "discrete", "exact"), "INPUT": ("input", "continuous", "exact"),
    "FIXED": ("parameter", "fixed", "exact"), "TUNABLE": ("parameter", "tunable", "exact"),
    "OUTPUT": ("output", "continuous", "calculated"), "INDICATOR": ("local", "continuous", "calculated"),
}  # fmt: skip
STRUCTURE = {"Output": ("STATE", "STEPS", "STATUS", "OUTPUT"), "ContinuousStateDerivative": ("DERIVATIVE",),
             "InitialUnknown": ("DERIVATIVE", "OUTPUT"), "EventIndicator": ("INDICATOR",)}  # fmt: skip
MEANING = """The planar walker on penalty ground. x is downhill along the slope, y along its normal; pushes act on the
 hip. Angles are from the normal, positive with the foot ahead of the hip; lengths from the hip to the foot's bottom.
 Sensors at the hip and at the mass centre of foot 0 read acceleration less gravity on the axes of leg 0, and its rate.
 A leg's status: 0, the ground does not act on its foot; 1, it does, and the foot is awaited; 2, the foot has landed."""
#: Tolerances of the constraint model's gait and of the walker's; steps of the run that is proposed.
ROUGH, TOLERANCE, STEPS = 1e-9, 1e-12, 6
OPTIONS = "-std=c11 -O2 -g0 -ffp-contract=off -fPIC -shared -w -o walker walker.c -lm"
ENDINGS, MACHINES = {"darwin": ".dylib", "windows": ".dll"}, {"amd64": "x86_64", "arm64": "aarch64"}


class Number(NamedTuple):
    """A number of the walker; one without `start` is computed, one without `symbol` has no name of its own in C."""

    group: str
    name: str
    unit: str
    start: float | None = None
    symbol: str = ""
    meaning: str = ""


def numbers(parameters: Sequence[str], given: Sections, state: PlanarState) -> Iterator[Number]:
    """All numbers, starting at a state in which leg 0 stands and leg 1 swings."""
    places = [*state.hip_position, *state.leg_angle, *state.leg_length]
    rates = [*state.hip_velocity, *state.leg_rate, *state.leg_length_rate]
    q = list(zip(COORDINATES[: 4 if given[0].legs == "rigid" else 6], places, rates))
    yield Number("TIME", "time", "s")
    yield from (Number("STATE", name, unit, at, symbol) for (symbol, name, unit), at, _ in q)
    yield from (Number("STATE", f"{name}_rate", f"{unit}/s", at, f"d{symbol}") for (symbol, name, unit), _, at in q)
    yield from (Number("DERIVATIVE", f"der({name})", f"{unit}/s") for (_, name, unit), _, _ in q)
    yield from (Number("DERIVATIVE", f"der({name}_rate)", f"{unit}/s^2") for (_, name, unit), _, _ in q)
    yield Number("STEPS", "steps", "1", 0.0)
    yield from (Number("STATUS", f"leg_{leg}.status", "1", float(status)) for leg, status in enumerate((LANDED, OUT)))
    yield from (Number("INPUT", f"push.{axis}", "N", 0.0, f"push_{axis}") for axis in "xy")
    yield from values(parameters, given)
    for place in ("hip_sensor", "foot_sensor"):
        for name, unit in (("forward", "m/s^2"), ("upward", "m/s^2"), ("turning", "rad/s")):
            yield Number("OUTPUT", f"{place}.{name}", unit)
    yield from (Number("OUTPUT", f"leg_{leg}.{name}", "N") for leg in (0, 1) for name in ("normal_force", "friction"))
    yield from (Number("INDICATOR", f"leg_{leg}.{name}", "1") for name in ("changes", "depth") for leg in (0, 1))
    yield Number("INDICATOR", "upright", "1")


def values(parameters: Sequence[str], given: Sections) -> Iterator[Number]:
    """The parameters: the design's are fixed, those of the ground may be tuned."""
    for name in parameters:
        file, key = name.split(".")
        section: Any = next(each for each in given if file == each.FILE and hasattr(each, key))
        about = type(section).__dataclass_fields__[key].metadata
        group = "FIXED" if section is given[0] else "TUNABLE"
        yield Number(group, name, about["unit"], getattr(section, key), key, about["description"])


def description(every: Sequence[Number], token: str, duration: float) -> bytes:
    """The file `modelDescription.xml`, for a run of so many seconds."""
    place, variables = {number.name: str(index) for index, number in enumerate(every)}, []
    for group, name, unit, start, _, meaning in every:
        about = dict(zip(("causality", "variability", "initial"), filter(None, ROLES[group])))
        about |= {"derivative": place[name[4:-1]]} if group == "DERIVATIVE" else {}
        said = "" if start is None else repr(start), "" if "^e" in unit else unit  # such a unit is none of FMI's
        about |= {key: word for key, word in zip(("description", "start", "unit"), (meaning, *said)) if word}
        variables.append(tag("Float64", name=name, valueReference=place[name], **about))
    structure = [tag(kind, valueReference=place[number.name]) for kind, groups in STRUCTURE.items()
                 for number in every if number.group in groups]  # fmt: skip
    units = map(unit_definition, sorted({number.unit for number in every if "^e" not in number.unit}))
    return document(tag(
        "fmiModelDescription", tag("ModelExchange", modelIdentifier="walker"), tag("UnitDefinitions", *units),
        tag("DefaultExperiment", startTime=0.0, stopTime=duration, tolerance=1e-9), tag("ModelVariables", *variables),
        tag("ModelStructure", *structure), fmiVersion="3.0", modelName="walker", instantiationToken=token,
        description=MEANING.replace("\n", ""), variableNamingConvention="structured", generationTool="bipedstudy",
    ), "The numbers of the walker.")  # fmt: skip


def unit_definition(unit: str) -> Element:
    """A unit by its powers of the base units, and its size in them."""
    of = {name: f"{power:g}" for name, power in zip(("kg", "m", "s"), powers(unit)) if power}
    of |= {"rad": "1"} if unit.startswith(("rad", "deg")) else {}
    of |= {"factor": repr(math.radians(1.0))} if unit == "deg" else {}
    return tag("Unit", tag("BaseUnit", **of), name=unit)


def compiler() -> str:
    """The C compiler at hand: the one that made Python, or one of the usual names. Raises WrongOption without any."""
    own = str(sysconfig.get_config_var("CC") or "cc").split()[0]
    for path in filter(None, map(shutil.which, (own, "cc", "gcc", "clang"))):
        return path
    raise WrongOption("--format = fmu needs a C compiler, cc, gcc or clang, and none is found")


def gait(given: Sections) -> tuple[PlanarState, float]:
    """Mid-stance of the walker's gait, leg 0 standing, and its period [s]. Raises NoGait, NoLimitCycle, BeyondModel."""
    biped, slope, contact = given
    require_own_strikes(biped, "the exported walker")
    walker, point = find_gait(biped, slope, ROUGH)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, ROUGH, 1000.0)
    start = rolling_state(biped, contact, upright, walk.standing_force)
    found = gait_near(PenaltyStepper(biped, slope, contact, start, Settings(TOLERANCE)), start)
    return section_state(found.section_state, start), found.period_s


def source(given: Sections, state: PlanarState) -> tuple[str, str, list[Number]]:
    """C source of the walker from a state on, its token, and its numbers."""
    parameters, parts = equations(*given)
    every, own = list(numbers(parameters, given, state)), scales_of(given[0], given[1].gravity)
    sizes = {number.group: place for place, number in reversed([*enumerate(every)])}
    parts |= {
        "sizes": "\n".join(f"#define {name} {value}" for name, value in (
            *sizes.items(), ("COUNT", len(every)), ("ROUND_OFF", FALLEN_GUARD))),
        "starts": ", ".join(repr(number.start or 0.0) for number in every),
        "nominals": ", ".join(repr(own.size(number.unit)) for number in every if number.group == "STATE"),
        "names": "\n".join(f"    const double {number.symbol} = v[{place}];" for place, number in enumerate(every)
                           if number.symbol),
    }  # fmt: skip
    text = (Path(__file__).parent / "walker.c").read_text(encoding="utf-8")
    for name, part in parts.items():
        text = text.replace(f"/*@{name}@*/", part)
    token = hashlib.sha256(text.encode()).hexdigest()
    return text.replace("TOKEN", f'"{token}"'), token, every


def library(text: str, by: str) -> bytes:
    """The shared library that a compiler makes of the source. Raises WrongOption if it makes none."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "walker.c").write_text(text, encoding="utf-8")
        done = subprocess.run([by, *OPTIONS.split()], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise WrongOption(f"--format = fmu: {by} makes no library: {' '.join(done.stderr.split())[-300:]}")
        return (Path(folder) / "walker").read_bytes()


def write(given: Sections) -> tuple[bytes, list[Number]]:
    """The file as bytes, and the walker's numbers. Raises WrongOption without a compiler, and as `gait`."""
    by, (state, period) = compiler(), gait(given)
    text, token, every = source(given, state)
    system, machine = platform.system().lower(), platform.machine().lower()
    place = f"binaries/{MACHINES.get(machine, machine)}-{system}/walker{ENDINGS.get(system, '.so')}"
    of = tag("BuildConfiguration", tag("SourceFileSet", tag("SourceFile", name="walker.c")), modelIdentifier="walker")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in (
            ("modelDescription.xml", description(every, token, STEPS * period)),
            ("sources/buildDescription.xml", document(tag("fmiBuildDescription", of, fmiVersion="3.0"), "C11")),
            ("sources/walker.c", text),
            (place, library(text, by)),
        ):
            entry = zipfile.ZipInfo(name)
            entry.external_attr = 0o644 << 16  # who unpacks it may read it
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return packed.getvalue(), every
