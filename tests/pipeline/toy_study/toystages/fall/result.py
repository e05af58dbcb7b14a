from dataclasses import dataclass

import numpy as np

from toystages.body.quantity import quantity


@dataclass(frozen=True)
class Sample:
    time: np.ndarray = quantity("s", "time, shape (n,)", symbol="t")
    distance: np.ndarray = quantity("m", "way fallen, shape (n,)", symbol="s")


@dataclass(frozen=True)
class Result:
    sample: Sample = quantity("1", "the fall")
    height: float = quantity("m", "height", symbol="h")
    mass: dict[str, float] = quantity("kg", "mass of each part")
    files: dict[str, bytes] = quantity("-", "files")

    def summary(self) -> str:
        return f"fell {self.sample.distance[-1]:.2f} m"

    def tables(self):
        return [("Parts", ("part", "mass [kg]"), list(self.mass.items()))]
