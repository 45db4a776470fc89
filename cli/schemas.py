"""drone-cli schema: the languages of missions and worlds, for editors."""

from __future__ import annotations

import click

from behaviors import drone_vocabulary
from cli.options import call_limit_option
from cli.output import echo_json
from cli.user_code import user_code
from fsm.schema import mission_schema
from worlds.world_schema import world_schema


@click.command()
@call_limit_option
@click.option("--worlds", is_flag=True, help="Of world files instead of missions.")
def schema(call_limit: float | None, worlds: bool) -> None:
    """Print the JSON Schema of missions, with every installed behaviour.

    Editors that know YAML schemas complete and explain with it what you write:

      drone-cli schema > mission.schema.json

    and, as the first line of a mission:

      # yaml-language-server: $schema=mission.schema.json
    """
    if worlds:
        echo_json(world_schema(), indent=2)
        return
    with user_code(call_limit) as limit:
        found = mission_schema(drone_vocabulary(calls=limit.calls))
    echo_json(found, indent=2)
