"""Compares two folders of pictures: bytes first, then the pixels of PNG files, with a picture of what differs."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

from pipeline.cache import disk

#: Largest rms difference of two pictures, in grey levels of 255, called the same. A change of a figure's data by 1e-3
#: gives at least three times as much (tests/figures/test_golden.py); a single thin curve changed so may give less.
TOLERANCE = 0.25


@dataclass(frozen=True)
class Difference:
    """A file that differs: its name, what about it, whether that is a failure, and a picture of the difference."""

    name: str
    what: str
    fails: bool
    picture: Path | None = None


def compare(expected: Path, drawn: Path, kept: Path, tolerance: float = TOLERANCE) -> list[Difference]:
    """How the files in `drawn` differ from those in `expected`; pictures of the differences go into `kept`."""
    names = sorted({path.name for folder in (expected, drawn) if folder.is_dir() for path in folder.iterdir()})
    found = []
    for name in names:
        one, other = disk.read(expected / name), disk.read(drawn / name)
        if one is None or other is None:
            found.append(Difference(name, "is missing" if one is None else "is no longer drawn", True))
        elif one != other:
            found.append(
                difference(expected / name, drawn / name, kept, tolerance)
                if name.endswith(".png")
                else Difference(name, "has other bytes", False)
            )
    return found


def rms(expected: Path, drawn: Path) -> float:
    """Rms difference of two PNG files in grey levels of 255 over all pixels and colours; infinite for other sizes."""
    import numpy as np
    from matplotlib.image import imread

    one, other = (np.asarray(imread(path), dtype=float)[..., :3] for path in (expected, drawn))
    return 255.0 * float(np.sqrt(np.mean((one - other) ** 2))) if one.shape == other.shape else float("inf")


def difference(expected: Path, drawn: Path, kept: Path, tolerance: float) -> Difference:
    """How the pixels of two PNG files differ."""
    name = drawn.name
    size = rms(expected, drawn)
    if size <= tolerance:
        return Difference(name, f"has other bytes, pixels differ by {size:.2g} of 255 rms", False)
    for path, suffix in ((expected, "expected"), (drawn, "drawn")):
        disk.write(kept / f"{drawn.stem}-{suffix}.png", path.read_bytes())
    if size == float("inf"):
        return Difference(name, "has another size", True, kept / f"{drawn.stem}-drawn.png")
    target = kept / f"{drawn.stem}-difference.png"
    _draw_difference(expected, drawn, target)
    return Difference(name, f"differs by {size:.2g} of 255 rms (allowed {tolerance:g})", True, target)


def _draw_difference(expected: Path, drawn: Path, target: Path) -> None:
    """What is only in the first picture in orange, what is only in the second in blue, the rest faint."""
    import numpy as np
    from matplotlib.image import imread, imsave

    one, other = (np.asarray(imread(path), dtype=float)[..., :3].mean(axis=-1) for path in (expected, drawn))
    change = np.clip(10 * (one - other), -1, 1)[..., None]
    faint = np.repeat((0.75 + 0.25 * one)[..., None], 3, axis=-1)
    orange, blue = np.array([0.84, 0.37, 0.0]), np.array([0.0, 0.45, 0.70])
    paint = np.where(change < 0, orange, blue)
    drawn_difference = io.BytesIO()
    imsave(drawn_difference, np.clip(faint * (1 - abs(change)) + paint * abs(change), 0, 1), format="png")
    disk.write(target, drawn_difference.getvalue())
