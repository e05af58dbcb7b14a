"""Which signals of a walk are recorded, beside the motion by which the walk is found.

The motion is recorded at every solver step: events, energy and what is sampled are computed from it. A signal that is
not named has no sensor in Exudyn and no rows in the result.
"""

#: Force of the ground on each foot; specific force and angular velocity of both sensors; of each foot in contact its
#: slip velocity and its penetration.
GROUND_REACTION, IMU, SLIP, PENETRATION = SIGNALS = ("ground_reaction", "imu", "slip", "penetration")
#: Those that later stages and figures read.
READ_LATER = (GROUND_REACTION, IMU, SLIP)
