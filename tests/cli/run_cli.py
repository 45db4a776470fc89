"""Runs drone-cli in this process, as the shell would."""

from __future__ import annotations

import io
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from unittest.mock import patch

from cli.main import main

WALL = """\
mission: wall
world: yard
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: shed}}
  shed: {do: goto, with: {to: [6, 2, 1]}, on: {done: home, blocked: home}}
  home: {do: goto, with: {to: [0, 0, 1]}, on: {done: land, blocked: land}}
  land: {do: land, on: {done: gave_up}}
  gave_up: {type: final, outcome: gave_up}
"""
"""A mission that runs into the shed of the yard, and gives up."""


@dataclass(frozen=True)
class Result:
    code: int
    out: str
    err: str


def run_cli(*arguments: str) -> Result:
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with (
        patch.object(sys, "argv", ["drone-cli", *arguments]),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1 if stop.code else 0
    return Result(code, out.getvalue(), err.getvalue())
