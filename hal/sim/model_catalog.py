"""The simulator's models, as it tells of them without flying."""

from __future__ import annotations

from math import pi, sqrt, tan

from hal.flight_model import VehicleModel
from hal.sim.flight_model import flight_model_of
from hal.sim.model import AIR_DENSITY, Model
from hal.sim.model_files import DEFAULT, load_model, model_names
from hal.sim.vehicle import capabilities_of
from vencejo.errors import Where


class ModelCatalog:
    """See :class:`hal.flight_model.Models`."""

    def names(self) -> list[str]:
        return model_names()

    def find(self, word: str | None, where: Where | None = None) -> VehicleModel:
        model = load_model(word or DEFAULT, where)
        return VehicleModel(
            model.name,
            model.description,
            capabilities_of(model) | {f"camera.{name}" for name in model.cameras},
            model.one_active_camera,
            flight_model_of(model),
            {
                "mass_kg": model.mass,
                "thrust_to_weight": model.max_thrust / model.weight,
                "max_tilt_deg": model.max_tilt * 180 / pi,
                "max_speed_m_s": model.max_speed,
                "top_speed_m_s": top_speed(model),
                "max_climb_m_s": model.max_climb,
                "hover_power_w": model.hover_power,
                "endurance_s": model.endurance,
            },
        )


def top_speed(model: Model) -> float:
    """The level speed at which drag meets the thrust of the largest tilt in still air, m/s.

    Parasitic drag ρ/2·A·v² and rotor drag k·v together are weight · tan(tilt).
    """
    square, linear = AIR_DENSITY / 2 * model.drag.area, model.drag.rotors
    push = model.weight * tan(model.max_tilt)
    if square == 0.0:
        return push / linear if linear else float("inf")
    return (sqrt(linear * linear + 4 * square * push) - linear) / (2 * square)
