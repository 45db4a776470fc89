"""The simulator: deterministic, without a window, many times faster than the clock."""

from hal.engines import open_engine
from hal.sim.model_catalog import ModelCatalog
from hal.sim.physics import Physics
from hal.sim.sensors.camera_spec import CameraSpec
from hal.sim.session import SimSession
from hal.vehicle import Options, Session
from vencejo.errors import UserError
from worlds import find_world

MODELS = ModelCatalog()
"""The models of its vehicles."""

__all__ = ["MODELS", "CameraSpec", "SimSession", "open_session"]


def open_session(options: Options) -> Session:
    """Open the simulator on the world of the options, or on ``empty``; use it in a ``with``.

    Settings: ``engine``, the name of a physics engine (see :mod:`hal.engines`), by default the
    first that is installed; ``noise``, a factor on the command noise (true for 1; default 0);
    ``physics``, the effects that are computed (see :mod:`hal.sim.effects`); ``wind``, a text that
    takes the place of the world's (see :mod:`worlds.wind`); ``cameras`` (see
    :func:`hal.sim.sensors.camera_spec.read_cameras`); ``sensors`` (see
    :func:`hal.sim.sensors.rangefinder.read_rangefinders`); ``renderer``, the name of one (see
    :mod:`hal.renderers`); ``shadows``, true to render shadows.
    Raises UserError for a world or settings that are wrong, VehicleError without the engine.
    """
    if options.address is not None:
        raise UserError("no-address", "the simulator has no address to be reached at")
    world = find_world(options.world or "empty")
    physics: Physics = open_engine(options.settings.get("engine"))
    try:
        return SimSession(options, world, physics)
    except BaseException:
        physics.close()
        raise
