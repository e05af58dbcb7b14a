"""`bipedstudy doctor`: whether this machine can run the study."""

from __future__ import annotations

import dataclasses
import sys

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.study import Study


@click.command("doctor", epilog=options.examples("doctor"))
@options.study
@options.as_json
def command(study: Study, as_json: bool) -> None:
    """Look at what the study needs: Exudyn, versions, folders, compiled code, disk, cores.

    Ends with 1 if something is bad; a warning is no failure.
    """
    from pipeline import doctor

    findings = list(doctor.examine(study))
    if as_json:
        options.print_json([dataclasses.asdict(finding) for finding in findings])
    else:
        for finding in findings:
            click.echo(layout.beside(f"{finding.state:<8} {finding.what:<17} ", finding.text))
    if any(finding.state == doctor.BAD for finding in findings):
        sys.exit(1)
