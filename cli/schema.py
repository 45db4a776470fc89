"""drone-cli schema: the mission language for editors."""

from __future__ import annotations

import json

import click

from behaviors import drone_vocabulary
from fsm.schema import mission_schema


@click.command()
def schema() -> None:
    """Print the JSON Schema of missions, with every installed behaviour.

    Editors that know YAML schemas complete and explain with it what you write:

      drone-cli schema > mission.schema.json

    and, as the first line of a mission:

      # yaml-language-server: $schema=mission.schema.json
    """
    click.echo(json.dumps(mission_schema(drone_vocabulary()), ensure_ascii=False, indent=2))
