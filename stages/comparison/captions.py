"""What each figure shows, in words with the study's own numbers, and what is synthetic: results/captions.yaml.

Nothing here is typed in: every number comes from a result.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.figures import (
    error_budget,
    extremes,
    figure_02,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_10,
    figure_16,
    gait_animation,
    tradeoff,
    twin_ladder,
    twin_pushes,
)
from stages.comparison.measurement import MeasurementAgreement
from stages.comparison.parameters import Parameters


@dataclass(frozen=True)
class Compared:
    """What captions draw their numbers from: all inputs of the stage, its parameters, its own agreements."""

    inputs: Mapping[str, Any]
    parameters: Parameters
    models: ModelAgreement
    twin: TwinAgreement
    measured: MeasurementAgreement


def _gait(known: Compared) -> str:
    analytic, multibody, twin = (known.inputs[name] for name in ("analytic", "multibody", "twin"))
    return (
        "All three start in the constraint model's mid-stance state and settle into gaits of their own: "
        f"{analytic.gait.step_frequency_hz:.4f} Hz and steps of {1e3 * analytic.gait.step_length_m:.1f} mm with "
        f"constraints, {multibody.cycle.step_frequency_hz:.4f} Hz and {1e3 * multibody.cycle.step_length_m:.1f} mm "
        f"with penalty contact, {twin.settling.step_frequency_hz:.4f} Hz and "
        f"{1e3 * twin.settling.step_length_m:.1f} mm for the twin; so they drift apart."
    )


def _figure_02(known: Compared) -> str:
    gait, cycle = known.inputs["analytic"].gait, known.inputs["multibody"].cycle
    return (
        "Ground reaction of one foot from heel strike to toe-off. Penalty contact peaks at "
        f"{cycle.peak_normal_force:.0f} N with {1e6 * cycle.largest_penetration:.0f} µm of penetration; the constraint "
        f"model has an impulse instead. Both feet are down for {1e3 * gait.double_stance_s:.2f} ms a step with "
        f"constraints and {1e3 * cycle.double_stance_s:.2f} ms with penalty contact."
    )


def _figure_04(known: Compared) -> str:
    law = known.parameters.contact
    return (
        f"The law of the normal force as ground.yaml sets it: k_c = {law.contact_stiffness:g} N/mm^e, "
        f"e = {law.contact_exponent:g}, c_max = {1e-3 * law.contact_damping:g} N s/mm, complete at "
        f"d = {1e3 * law.damping_depth:g} mm. The force never pulls."
    )


def _figure_05(known: Compared) -> str:
    study = known.inputs["contact_study"]
    return (
        "Each contact parameter changed alone. From Adams' defaults the hip differs from the constraint model's by "
        f"{1e3 * study.default.hip_position.max():.2f} mm over a step; with the set chosen from "
        f"{len(study.candidates.outcome)} tried, by {1e3 * study.chosen.hip_position.max():.2f} mm."
    )


def _figure_06(known: Compared) -> str:
    study = known.inputs["contact_study"]
    return (
        "Below the stiction velocity a loaded foot creeps: at "
        f"{1e3 * study.default.creep_velocity:.2f} mm/s with Adams' defaults and "
        f"{1e3 * study.chosen.creep_velocity:.2f} mm/s with the chosen set."
    )


def _figure_07(known: Compared) -> str:
    cycle = known.inputs["multibody"].cycle
    return (
        f"Exudyn's model on the slope of {np.degrees(known.parameters.slope.angle):.3g}°: "
        f"{cycle.speed_m_s:.4f} m/s, a step in {cycle.period_s:.4f} s."
    )


def _figure_08(known: Compared) -> str:
    position, velocity = known.models.same_start.position, known.models.same_start.velocity
    return (
        "The same mid-stance state walks on in both models. Over one step the hips differ by at most "
        f"{1e3 * position[0]:.2f} mm in x and {1e3 * position[1]:.2f} mm in y, {1e3 * velocity[0]:.1f} mm/s and "
        f"{1e3 * velocity[1]:.1f} mm/s outside the impacts; the paper states "
        f"{1e3 * known.parameters.settings.position_limit:g} mm and "
        f"{1e3 * known.parameters.settings.velocity_limit:g} mm/s."
    )


def _figure_10(known: Compared) -> str:
    twin = known.inputs["twin"]
    steps = twin.settling.steps_to_settle
    when = f"settles after step {steps}" if steps >= 0 else "does not settle"
    return (
        f"Four feet, paired legs, bodies with inertia from an assumed bill of parts. From the simple model's gait the "
        f"twin {when} and walks at {twin.settling.step_frequency_hz:.4f} Hz."
    )


def _figure_16(known: Compared) -> str:
    measured = known.measured
    shares = ", ".join(f"{100 * measured.twin[name].envelope_share:.0f} %" for name in list(measured.twin)[:3])
    return (
        f"{measured.runs} {measured.origin} runs at {measured.step_frequency:.4f} Hz "
        f"(± {measured.step_frequency_spread:.4f} between runs), twin {measured.twin_step_frequency:.4f} Hz over the "
        f"same steps. The envelope holds the twin over {shares} of the stride."
        + (" Synthetic runs test the method; they cannot confirm a model." if measured.origin != "measured" else "")
    )


def _twin_ladder(known: Compared) -> str:
    return f"What each detail does to a step: {known.inputs['twin_ladder'].summary()}."


def _error_budget(known: Compared) -> str:
    return (
        "Penalty model minus constraint model, split into signed contributions that add up to it; integration "
        f"errors are too small to draw. {known.inputs['error_budget'].summary()}."
    )


def _twin_pushes(known: Compared) -> str:
    return f"{known.inputs['twin_pushes'].summary()}."


def _tradeoff(known: Compared) -> str:
    return f"Errors against a converged reference over the cost of a step: {known.inputs['tradeoff'].summary()}."


def _extremes(known: Compared) -> str:
    return f"What every model answers far from the usual parameters: {known.inputs['extremes'].summary()}."


#: Figure -> its title and its text, in the order in which a report shows them.
CAPTIONS: dict[str, tuple[str, Callable[[Compared], str]]] = {
    gait_animation.NAME: ("The gait in three models", _gait),
    figure_02.NAME: ("Figure 2: ground reaction", _figure_02),
    figure_04.NAME: ("Figure 4: law of the normal force", _figure_04),
    figure_05.NAME: ("Figure 5: contact parameters", _figure_05),
    figure_06.NAME: ("Figure 6: friction", _figure_06),
    figure_07.NAME: ("Figure 7: snapshots", _figure_07),
    figure_08.NAME: ("Figure 8: hip motion of both models", _figure_08),
    figure_10.NAME: ("Figure 10: the digital twin", _figure_10),
    figure_16.NAME: ("Figure 16: measurements and models", _figure_16),
    twin_ladder.NAME: ("From the simple model to the twin", _twin_ladder),
    error_budget.NAME: ("Error budget", _error_budget),
    twin_pushes.NAME: ("Pushes to the side", _twin_pushes),
    tradeoff.NAME: ("Speed against accuracy", _tradeoff),
    extremes.NAME: ("The extremes", _extremes),
}


def synthetic(measured: MeasurementAgreement) -> str:
    """What of the study is made up, in words."""
    if measured.origin == "measured":
        return "Nothing is synthetic: the runs come from a measurement database."
    return (
        f"The {measured.runs} runs of the measurement are {measured.origin}: walks of the twin through a model of the "
        "sensors, with random pushes, slopes, outsoles and build tolerances. They test the ingest and cannot confirm "
        "the model; the claims they touch stay open. Figure 16 is marked."
    )


def as_yaml(known: Compared, drawn: Sequence[str]) -> bytes:
    """Captions of the `drawn` figures as YAML, a figure without one by its name. JSON strings are YAML strings."""

    def quoted(text: str) -> str:
        return json.dumps(text, ensure_ascii=False)

    lines = ["# Generated by the comparison stage: what the figures show."]
    lines += [f"synthetic: {quoted(synthetic(known.measured))}", "figures:"]
    order = [name for name in CAPTIONS if name in drawn]
    for name in order + [name for name in drawn if name not in CAPTIONS]:
        title, text = CAPTIONS.get(name, (name.replace("_", " "), lambda known: ""))
        lines += [f"- name: {name}", f"  title: {quoted(title)}", f"  text: {quoted(text(known))}"]
    return ("\n".join(lines) + "\n").encode()
