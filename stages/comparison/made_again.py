"""Synthetic runs that closer solvers made once more, and the same runs as they were: what their numbers differ by.

A campaign is not made twice for its errors, but its first runs are.
"""

from collections.abc import Collection
from dataclasses import replace

from stages.comparison.evidence import Inputs
from stages.imu.run import alone


def as_both_have_it(inputs: Inputs) -> tuple[Inputs, Inputs] | None:
    """The inputs, and what closer solvers gave in their place, of synthetic runs those alone that both have; None where
    there is nothing closer.
    """
    closer = inputs.closer
    if closer is None:
        return None
    if {"imu", "campaign"} & {*inputs.missing}:
        return inputs, closer
    if closer.imu is inputs.imu:
        return inputs, replace(closer, campaign=inputs.campaign)
    names = {run.report.name for run in closer.imu.runs}
    return of_runs(inputs, names), of_runs(closer, names)


def of_runs(inputs: Inputs, names: Collection[str]) -> Inputs:
    """The inputs of synthetic runs of these names alone."""
    runs = tuple(run for run in inputs.campaign.runs if run.name in names)
    return replace(inputs, imu=alone(inputs.imu, names), campaign=replace(inputs.campaign, runs=runs))
