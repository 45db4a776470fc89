"""drone-cli findings: what a run has found, as files for maps and tables."""

from __future__ import annotations

from pathlib import Path

import click

from runner.findings import EVENT, write_findings
from vencejo.errors import UserError, Where


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
def findings(folder: Path) -> None:
    """Write what the run in FOLDER has found into it, also of one that was killed.

    Every run does this at its end. The files are findings.geojson, which maps and ground stations
    open, and findings.csv.
    """
    files = write_findings(folder)
    if not files:
        message = "this run has found nothing"
        hint = f"behaviours that find things, as sweep_detect, raise `{EVENT}`"
        raise UserError("no-findings", message, Where(str(folder)), hint)
    for file in files:
        click.echo(file)
