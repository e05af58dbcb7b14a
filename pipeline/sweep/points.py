"""The points of a sweep: what each varied parameter is at point 0, 1, 2, ... The same spec gives the same points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pipeline.sweep.spec import Spec

if TYPE_CHECKING:
    import numpy as np

Point = dict[str, Any]


class Points:
    """All points, each made when it is asked for, so that a million of them need little memory."""

    def __init__(self, spec: Spec) -> None:
        self._spec = spec
        self._shares = _shares(spec)
        self._grids = {name: axis.values() for name, axis in spec.axes.items()} if spec.kind == "grid" else {}

    def __len__(self) -> int:
        return self._spec.size

    def __getitem__(self, index: int) -> Point:
        """The point of this number. Raises IndexError beyond the last."""
        spec = self._spec
        if not 0 <= index < len(self):
            raise IndexError(index)
        if spec.kind == "list":
            return dict(spec.points[index])
        if self._shares is not None:
            return {name: axis.at(float(share)) for (name, axis), share in zip(spec.axes.items(), self._shares[index])}
        point: Point = {}
        for name, values in reversed(self._grids.items()):  # the last parameter changes fastest
            index, place = divmod(index, len(values))
            point[name] = values[place]
        return {name: point[name] for name in spec.axes}


def _shares(spec: Spec) -> np.ndarray | None:
    """Shares between 0 and 1 of each drawn point, shape (count, parameters); None where points are not drawn."""
    if spec.kind not in ("latin_hypercube", "monte_carlo"):
        return None
    import numpy as np

    random = np.random.default_rng(spec.seed)
    if spec.kind == "monte_carlo":
        return random.random((spec.size, len(spec.axes)))
    from scipy.stats import qmc

    drawn: np.ndarray = qmc.LatinHypercube(d=len(spec.axes), seed=random).random(spec.size)
    return drawn
