"""The moving picture of the README: one stride of the twin on its ramp, from results/, into docs/walk.gif.

    python docs/draw_walk.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import bipedstudy as bs
from stages.drawing import style
from stages.figures import view
from stages.twin.ramp import laid

TARGET = Path(__file__).with_name("walk.gif")
FRAMES, MILLISECONDS, INCHES, DPI = 24, 40, (6.4, 3.3), 100
CAMERA = np.radians(24.0), np.radians(14.0)


def main() -> None:
    """Draw the last stride, the camera going along, so that it can be repeated."""
    twin, given = bs.load("twin"), bs.parameters("twin")
    walk, settings, biped = twin.walk, given.settings, given.biped
    ramp = laid(settings, given.blocks, twin.settling.step_length_m)
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0][-2:]
    camera = view.Camera(*CAMERA, given.slope.angle)
    bodies, natural = view.of_twin(settings, biped), view.unloaded(settings, biped)
    edge, pictures = ramp.tracks[1] + 0.8 * ramp.width, []
    with style.drawing():
        for time in np.linspace(*strikes, FRAMES, endpoint=False):
            pose = view.pose_at(walk, float(time), natural)
            x = pose.hip[0]
            near = ramp.step * np.floor(x / (2.0 * ramp.step)) * 2.0
            moved = view.Pose(pose.hip - [near - 4.0 * ramp.step, 0.0], pose.angle, pose.slide)
            figure, axes = plt.subplots(figsize=INCHES)
            x = moved.hip[0]
            ground = view.deck(x - 1.2, x + 1.2, edge, 1.0), view.blocks(ramp, 1.0)
            view.paint(axes, camera, [*ground, moved.robot(bodies)])
            view.frame(axes)
            figure.set_layout_engine(None)
            axes.set_position((0.0, 0.0, 1.0, 1.0))
            middle, ground = camera.spot(np.array([x, 0.0, 0.0]))
            axes.set_xlim(middle - 0.42, middle + 0.42)
            axes.set_ylim(ground - 0.075, ground + 0.36)
            figure.set_dpi(DPI)
            figure.canvas.draw()
            pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()))
            plt.close(figure)
    palette = pictures[0].quantize(64)
    drawn = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    drawn[0].save(TARGET, save_all=True, append_images=drawn[1:], duration=MILLISECONDS, loop=0, optimize=True)


if __name__ == "__main__":
    main()
