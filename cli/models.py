"""drone-cli models: the models of the simulator's vehicles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from cli.options import SIMULATOR, ModelName
from cli.output import echo_json
from hal import VehicleModel, backend_models, vehicle_model
from hal.limits import DIMENSIONS
from vencejo.errors import Where
from vencejo.units import format_quantity

_LISTED: Mapping[str, tuple[str, str]] = {
    "mass_kg": ("mass", "{:g} kg"),
    "thrust_to_weight": ("thrust / weight", "{:.2f}"),
    "hover_power_w": ("hovering takes", "{:.1f} W"),
    "endurance_s": ("hovers for", "{:.0f} s"),
    "top_speed_m_s": ("top speed", "{:.1f} m/s"),
}
"""What people read for each figure of a list: its name, and the form of its value."""
_FORMS: Mapping[str, tuple[str, str]] = {
    **_LISTED,
    "max_speed_m_s": ("speed limit", "{:g} m/s"),
    "max_climb_m_s": ("climb limit", "{:g} m/s"),
    "max_tilt_deg": ("tilt limit", "{:.0f} deg"),
}


@click.command()
@click.argument("name", required=False, type=ModelName())
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def models(name: str | None, as_json: bool) -> None:
    """List the models that the simulator's vehicles can be of, or show NAME (or a file's).

    The top speed is that at which drag meets the largest tilt in still air, whatever its limit.
    """
    if name is not None:
        model = _model(name)
        echo_json(_facts(model)) if as_json else _show(model)
        return
    catalog = backend_models(SIMULATOR)
    found = [_model(each) for each in (catalog.names() if catalog else ())]
    if as_json:
        echo_json([_facts(model) for model in found])
        return
    table = [("", *(label for label, _ in _LISTED.values()), "")]
    for model in found:
        figures = (value for _, value in _figures(model, _LISTED))
        table.append((model.name, *figures, model.description))
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        click.echo("  ".join(cells).rstrip())
    click.echo("\ndrone-cli run MISSION --model NAME flies one, drone-cli models NAME tells more.")


def _model(word: str) -> VehicleModel:
    model = vehicle_model(SIMULATOR, word, Where("models"))
    assert model is not None, "the simulator has models"
    return model


def _figures(model: VehicleModel, forms: Mapping[str, tuple[str, str]]) -> list[tuple[str, str]]:
    return [(label, form.format(model.figures[key])) for key, (label, form) in forms.items()]


def _cameras(model: VehicleModel) -> list[str]:
    return sorted(w.removeprefix("camera.") for w in model.capabilities if w.startswith("camera."))


def _facts(model: VehicleModel) -> dict[str, Any]:
    profiles = {name: limits.given() for name, limits in model.flight.profiles.items()}
    return {
        "model": model.name,
        "description": model.description,
        **{name: round(value, 4) for name, value in model.figures.items()},
        "cameras": _cameras(model),
        "one_active_camera": model.one_active_camera,
        "profiles": profiles,
    }


def _show(model: VehicleModel) -> None:
    click.echo(f"{model.name}: {model.description}")
    rows = _figures(model, _FORMS)
    cameras = ", ".join(_cameras(model)) or "none"
    if model.one_active_camera:
        cameras += " (one active at a time)"
    rows.append(("cameras", cameras))
    width = max(len(label) for label, _ in rows)
    for label, value in rows:
        click.echo(f"  {label:<{width}}  {value}")
    if model.flight.profiles:
        click.echo("\nprofiles of limits (--limit NAME):")
    for name, limits in model.flight.profiles.items():
        given = (
            f"{key} {format_quantity(round(value, 6), DIMENSIONS[key])}"
            for key, value in limits.given().items()
        )
        click.echo(f"  {name}: {', '.join(given)}")
