"""Synthetic runs that closer solvers made once more, and the same runs as they were: what their numbers differ by.

A campaign is not made twice for its errors, but its first runs are. Both recordings of these are read as all are.
"""

from collections.abc import Collection
from dataclasses import replace

from stages.campaign.result import DATABASE
from stages.campaign.result import Result as Campaign
from stages.comparison.evidence import Inputs
from stages.comparison.parameters import Parameters
from stages.imu.parameters import Cover
from stages.imu.parameters import Parameters as IngestParameters
from stages.imu.result import Result as Ingested
from stages.imu.run import as_result, collect, trials
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused, as_file


def as_both_have_it(parameters: Parameters, inputs: Inputs) -> tuple[Inputs, Inputs] | None:
    """The inputs, and what closer solvers gave in their place, of synthetic runs those alone that both have; None where
    there is nothing closer.
    """
    closer = inputs.closer
    if closer is None:
        return None
    if {"imu", "campaign"} & {*inputs.missing}:
        return inputs, closer
    anew = ingested_anew(parameters, closer.campaign) if inputs.imu.origin == inputs.campaign.origin else None
    names = {run.report.name for run in inputs.imu.runs} & {run.report.name for run in anew.runs} if anew else set()
    if anew is None or not names:
        return inputs, replace(closer, imu=inputs.imu, campaign=inputs.campaign)
    return (replace(inputs, imu=alone(inputs.imu, names), campaign=made(inputs.campaign, names)),
            replace(closer, imu=alone(anew, names), campaign=made(closer.campaign, names)))  # fmt: skip


def ingested_anew(parameters: Parameters, campaign: Campaign) -> Ingested | None:
    """What the ingest makes of the runs in the databases of a campaign's result; None where it can use none."""
    read = IngestParameters(parameters.ingest, parameters.ingest_limits, parameters.drawing, parameters.biped,
                            parameters.slope, Cover(parameters.runs.outsole)).read  # fmt: skip
    content = campaign.files.get(DATABASE)
    if not content:
        return None
    try:
        with as_file(content, DATABASE) as path, SqliteSource(path) as source:
            return collect(trials(source.runs(), read))
    except SourceRefused:
        return None


def alone(imu: Ingested, names: Collection[str]) -> Ingested:
    """The ingest of the runs of these names, in one order."""
    return as_result(
        sorted((run for run in imu.runs if run.report.name in names), key=lambda run: run.report.name),
        [report for report in imu.reports if report.run in names])  # fmt: skip


def made(campaign: Campaign, names: Collection[str]) -> Campaign:
    """A campaign of the runs of these names."""
    return replace(campaign, runs=tuple(run for run in campaign.runs if run.name in names))
