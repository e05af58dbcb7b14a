"""What the paper says: its words, where they stand, and the quantity and limit that they imply.

The source of every sentence is Vasileiou, Smyrli, Drogosis and Papadopoulos, Mechanism and Machine Theory (2021).
Numbers that the paper prints stand here once; how far two numbers may differ stands in params/comparison.yaml.
"""

from __future__ import annotations

from dataclasses import dataclass

STANDARD_GRAVITY = 9.80665  # m/s^2 in one g of a sensor's data sheet

FREQUENCY_HZ = 2.08  # section 7.2
LAST_DIGIT_HZ = 0.01  # of that frequency
ACCELEROMETER_G = 4.0  # section 7.2
GYROSCOPE_DEG_S = 2000.0  # section 7.2
RAMP_M = 2.0  # section 7.1
BLOCK_SETS = 11  # section 7.1


@dataclass(frozen=True)
class Printed:
    """A parameter as the paper has it: its value, and where it stands."""

    value: float | str
    source: str


#: The biped and its slope: what a claim on the paper's biped is about.
BIPED = {
    "biped.legs": Printed("compliant", "section 2.1"),
    "biped.hip_mass": Printed(0.316, "Table 1"),
    "biped.foot_mass": Printed(0.335, "Table 1"),
    "biped.leg_length": Printed(0.333, "Table 1"),
    "biped.foot_radius": Printed(0.083, "Table 1"),
    "biped.foot_com": Printed(0.100, "Table 1"),
    "biped.stiffness": Printed(2800.0, "Table 1"),
    "biped.damping": Printed(58.350, "Table 1"),
    "biped.leg_inertia": Printed(0.0, "section 2.1: point masses"),
    "ground.slope_deg": Printed(2.0, "section 3.5"),
    "ground.gravity": Printed(9.81, "the standard value, which the paper does not print"),
}

#: Other parameters that the paper prints: claims stay with another value, and name it.
SETTINGS = {
    "analytic.tolerance": Printed(1e-7, "section 2.3"),
    "multibody.tolerance": Printed(1e-6, "section 3.5"),
    "twin.tolerance": Printed(1e-6, "section 3.5"),
    "ground.static_friction": Printed(1.1, "section 3.4"),
    "ground.stiction_velocity": Printed(0.1, "section 3.4: Adams' default"),
    "ground.friction_velocity": Printed(1.0, "section 3.4: Adams' default"),
}


@dataclass(frozen=True)
class Statement:
    """A sentence of the paper: its section, its words, and what can be measured of it."""

    section: str
    words: str
    implies: str


SAYS = {
    "constraints_reduce_effort": Statement(
        "2.1",
        "The practice of using Lagrange multipliers to model contacts in dynamic systems minimizes the computational "
        "effort by reducing the overall stiffness of the system.",
        "the constraint model needs fewer evaluations of its rates a step than the penalty model, at the same error",
    ),
    "twice_differentiated_constraints": Statement(
        "2.2",
        "A double differentiation of these constraints [...] was found to eliminate the first order terms of s in (6), "
        "resulting in a set of constraints that do not describe rolling without slipping.",
        "integrated at acceleration level, the landing foot slips or sinks by more than an integration error",
    ),
    "multipliers_minimised": Statement(
        "2.2",
        "A Newton-Raphson method was used to reach an optimal parameter set, for which the eigenvalues are minimum in "
        "magnitude [...] finally, their values were fine-tuned to measurements obtained from the robot.",
        "at the theoretical optimum, which is not printed, no change of a parameter lowers the largest multiplier; "
        "Table 1 is that optimum after fine-tuning",
    ),
    "stable_gait": Statement(
        "2.2, 3.5",
        "The simplified biped model achieves stable walking in a negative slope of 2°.",
        "every multiplier of the step map is smaller than 1, in the constraint model and in the multibody model",
    ),
    "tight_tolerances_add_rounding": Statement(
        "2.3",
        "[...] too small tolerances would lead to a large increase in solver steps, increasing the overall rounding "
        "error accumulated over the same time.",
        "below some tolerance a tighter one makes the error larger",
    ),
    "chaos_amplifies": Statement(
        "3.2",
        "The dynamic divergence introduced by these factors, albeit small, can be amplified in systems capable of "
        "chaotic behaviours, as is the double pendulum, and lead to completely different simulation outcomes.",
        "along this walk a small difference between two computations grows",
    ),
    "contact_set": Statement(
        "3.3, figure 5",
        "[...] a small change in the value of k_c results in an improvement of the contact force model's resemblance "
        "to the ground force that was calculated by the mathematical model [...]",
        "from Adams' defaults, a small change of k_c alone lowers the difference of the normal forces",
    ),
    "contact_set_figure_8": Statement(
        "3.3, figure 8",
        "Therefore, this parameter set is used for the comparison of the multibody dynamics model in MSC Adams to the "
        "mathematical model in MATLAB.",
        "with k_c alone changed from Adams' defaults the hips of the two models stay within figure 8's limit",
    ),
    "rolling_without_slip": Statement(
        "3.4",
        "The developed mathematical model in MATLAB assumes pure rolling of the foot on the ground. For this to hold "
        "[...] the friction on the foot must remain static. [...] a value of 1.1 was set for µ_s [...]",
        "friction needed over normal force stays below µ_s in both stances and in the impulses of heel strike",
    ),
    "friction_velocities": Statement(
        "3.4",
        "[...] for small to moderate changes of the stiction and friction transition velocities with respect to the "
        "default, the behaviour of the walker was not affected.",
        "such changes from Adams' defaults leave the gait the same",
    ),
    "stiff_solver": Statement(
        "3.5",
        "As reasoned in Section 2, a stiff solver is appropriate for this system.",
        "the stiff solvers of the paper reach their error with no more work than an explicit one",
    ),
    "hip_displacement": Statement(
        "3.5, figure 8",
        "Hip displacement along the x and y directions [...] present a maximum difference of 0.3 mm.",
        "the hips of constraint and penalty model stay within 0.3 mm; what no contact parameter removes is the "
        "distance to the constraint model with Coulomb friction, to which penalty contact tends as it hardens",
    ),
    "hip_velocity": Statement(
        "3.5, figure 8",
        "Hip velocity along the x and y directions [...] present a maximum difference of 5 mm/s.",
        "the hip velocities stay within 5 mm/s, judged in the same limit",
    ),
    "integration_tolerance": Statement(
        "3.5, figure 8",
        "After elimination of other possible causes, the small errors are attributed to integration tolerances.",
        "at the paper's tolerances integration moves the hip by more than what no other effect explains",
    ),
    "twin_settles": Statement(
        "5.2",
        "[...] these initial conditions are not part of the digital twin's fixed-point trajectory: due to this, a "
        "transient phase during the first few steps appears, which eventually converges to its stable walking pattern.",
        "started on the simple model's fixed point, period and length of the twin's steps settle",
    ),
    "ramp_length": Statement(
        "7.1",
        "The ramp has a length of 2 meters, and a total of 11 stepping block sets.",
        "11 sets one step apart find room on 2 m, and each foot of the twin comes down within its block",
    ),
    "push_converges": Statement(
        "7.1",
        "[...] the biped easily converged to its stable gait after a well-rehearsed push.",
        "walks that start with another push than the gait's end in the gait",
    ),
    "step_frequency": Statement(
        "7.2",
        "This sampling rate is almost 50 times larger than the simulated walking frequency of 2.08 Hz.",
        "the constraint model with Table 1 takes 2.08 steps a second on a slope of 2 degrees",
    ),
    "sensor_range": Statement(
        "7.2",
        "To ensure that the dynamics of the biped's gait are captured by the IMU devices, the latter are set to "
        "measure accelerations up to 4 g and angular velocities up to 2000 deg/s, both at a sampling rate of 100 Hz.",
        "what the sensors feel stays inside these ranges",
    ),
    "twin_like_simple": Statement(
        "7.4, figure 16",
        "The simulation results of the simplified model [...] are almost identical with the simulation results of the "
        "detailed model [...]",
        "at equal phase the hip's accelerations and angular velocity of both differ by a small part of their range",
    ),
    "hip_path_drifts": Statement(
        "7.4",
        "Different measurements could also be of interest: for example, the hip position in the x and y direction of "
        "motion [...]. However, [...] the double integrations that would be needed in the hip trajectory calculation "
        "would introduce a considerable amount of accumulated error.",
        "from the sensors the hip's path comes out only with a considerable error, since it takes two integrations",
    ),
    "measurement_encloses": Statement(
        "7.4",
        "Finally, the whole set of the experimental data envelops the simulated ones [...]",
        "the envelope of the runs holds the twin's curves over the stride",
    ),
    "measurement_slower": Statement(
        "7.4",
        "[...] the lab prototype appears to walk slightly slower than the simulated models.",
        "the runs' step frequency is below the twin's over the same steps",
    ),
    "outsole_slows": Statement(
        "7.4",
        "This small difference can be attributed to the extra length added to the biped's legs due to the rubber "
        "outsoles, as a larger length generally leads to slower swing frequencies in pendulum-like systems.",
        "an outsole lowers the step frequency, by the length that it adds",
    ),
    "push_slows": Statement(
        "7.4",
        "Another reason for this divergence could be the partial randomness in the initial velocity of the biped after "
        "each push at the beginning of each experiment.",
        "over the runs, step frequency goes with the push",
    ),
    "prototype_is_model": Statement(
        "7.4",
        "[...] the dynamic elements and geometry of the prototype truly correspond to the parameter values selected "
        "and used in the simulation models.",
        "parameters estimated from the runs, with their intervals, hold those of Table 1",
    ),
}
