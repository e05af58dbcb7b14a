"""MuJoCo's system identification toolbox on the twin exported to MuJoCo: time, and which of its intervals hold.

    pip install "mujoco[sysid]"
    python -m benchmarks.mujoco_sysid [--trials 10] [--steps 3]

The robot is MuJoCo's own: the export of `bipedstudy export twin --format mjcf`, with masses, springs and dampers off
by 3 % each and noise of campaign.yaml on its sensors. The toolbox begins with the drawing; it is told the true start,
since it has no unknowns of a run, and the masses of the frames: with them free every interval is infinite, for the
scale of mass is not seen. Its sensors have no low pass.
"""

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mujoco
import numpy as np
from mujoco import rollout, sysid

from pipeline.study import Study
from stages.twin.exports import mjcf
from stages.twin.exports.exported import exported

ROOT = Path(__file__).resolve().parent.parent
GROUND = mjcf.Ground(time_constant=0.004, step=5e-4)
SPREAD, RATE_HZ, STEP_S = 0.03, 100.0, 0.5
#: Step of the toolbox's differences; its own, 1e-8, does no better on contact.
DIFFERENCE = 1e-4
#: What is looked for: bodies whose mass, or joints whose spring or damper, share one factor.
FEET = tuple(f"{pair} {side} foot" for pair in ("inner", "outer") for side in ("left", "right"))
SPRINGS = tuple(f"{pair} {side} spring" for pair in ("inner", "outer") for side in ("left", "right"))


def scaled(names: tuple[str, ...], kind: str, field: str, drawn: dict[str, Any]) -> Callable[[Any, Any], None]:
    """A modifier that gives a field of bodies or joints so many times its drawn value."""
    def modify(spec: Any, parameter: Any) -> None:
        for name in names:
            value = np.asarray(drawn[name, field]) * parameter.value[0]
            setattr(getattr(spec, kind)(name), field, value if value.ndim else float(value))

    return modify


class Robots:
    """Robots of MuJoCo's own: the export of a study's twin with masses, springs and dampers off by some percent."""

    LOOKED: ClassVar = {"foot masses": (FEET, "body", "mass"), "stiffness": (SPRINGS, "joint", "stiffness"),
                        "damping": (SPRINGS, "joint", "damping")}

    def __init__(self, twin: Any, seed: int, ground: mjcf.Ground = GROUND) -> None:
        self.seed, self.ground, self.exported = seed, ground, exported(twin)
        self._text = mjcf.write(self.exported, ground).decode()
        self.spec = self._new()
        self.drawn = {(name, field): np.array(getattr(getattr(self.spec, kind)(name), field))
                      for names, kind, field in self.LOOKED.values() for name in names}  # fmt: skip

    def _new(self) -> Any:
        return mujoco.MjSpec.from_string(self._text)

    def truth(self, trial: int) -> np.ndarray:
        """Factors of foot masses, springs and dampers of a robot, (3,)."""
        return 1 + SPREAD * np.random.default_rng([self.seed, trial]).normal(size=len(self.LOOKED))

    def model(self, trial: int) -> Any:
        """The robot, compiled."""
        robot = self._new()
        for value, what in zip(self.truth(trial), self.LOOKED.values(), strict=True):
            scaled(*what, self.drawn)(robot, sysid.Parameter("truth", nominal=float(value), min_value=0.5,
                                                             max_value=1.5))  # fmt: skip
        return robot.compile()


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--steps", type=int, default=3, help="steps of a run")
    parser.add_argument("--seed", type=int, default=7000)
    asked = parser.parse_args()
    every = Study(ROOT, ROOT / "params", ROOT / "results", ()).parameters(["twin", "calibration"])
    robots = Robots(every["twin"], asked.seed)
    noise = np.repeat([every["calibration"].noise[0], every["calibration"].noise[2]] * 2, 3)

    def parameters() -> Any:
        found = sysid.ParameterDict()
        for name, what in Robots.LOOKED.items():
            found.add(sysid.Parameter(name, nominal=1.0, min_value=0.7, max_value=1.3,
                                      modifier=scaled(*what, robots.drawn)))  # fmt: skip
        return found

    held, errors, spent, begun = [], [], [], time.process_time()
    for trial in range(asked.trials):
        rng, truth, model = np.random.default_rng([asked.seed, trial]), robots.truth(trial), robots.model(trial)
        rng.normal(size=len(truth))  # the truth's own
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        count = round(asked.steps * STEP_S / model.opt.timestep)
        start = sysid.create_initial_state(model, data.qpos, data.qvel, data.act)
        control = sysid.TimeSeries(np.arange(count) * model.opt.timestep, np.zeros((count, 0)))
        state, shown = (np.squeeze(each, axis=0) for each in rollout.rollout(
            model, data, start, nstep=count - 1))  # fmt: skip
        every_so_many = round(1 / RATE_HZ / model.opt.timestep)
        times, shown = state[::every_so_many, 0], shown[::every_so_many]
        seen = sysid.TimeSeries.from_names(times, shown + noise * rng.normal(size=shown.shape), model)
        sequence = sysid.ModelSequences("twin", robots.spec, "run", start, control, seen)
        residual = sysid.build_residual_fn(models_sequences=[sequence])
        first = time.process_time()
        found, result = sysid.optimize(parameters(), residual, optimizer="mujoco", verbose=False, eps=DIFFERENCE)
        left, _, _ = residual(result.x, found)
        _, half = sysid.calculate_intervals(left, result.jac)
        spent.append(time.process_time() - first)
        errors.append(result.x - truth)
        held.append(np.abs(errors[-1]) <= half)
        print(f"trial {trial}: {spent[-1]:.1f} s, errors % {np.round(100 * errors[-1], 2).tolist()}, "
              f"half widths % {np.round(100 * half, 3).tolist()}", flush=True)
    print("| parameter | 95 % intervals that hold | error, median, % |\n|---|---|---|")
    for row, name in enumerate(Robots.LOOKED):
        print(f"| {name} | {sum(one[row] for one in held)} of {len(held)} | "
              f"{100 * np.median(np.abs([one[row] for one in errors])):.3f} |")
    print(f"\n{asked.steps} steps of {STEP_S} s, {len(Robots.LOOKED)} unknowns: {np.median(spent):.1f} s of processor "
          f"time a fit (median), {time.process_time() - begun:.0f} s in all.")


if __name__ == "__main__":
    main()
