"""The session of the simulator: a world, its vehicles and their common clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import combinations
from types import MappingProxyType

from hal.scene.appearance import color_of, quadrotor
from hal.scene.lamps import lamp_things
from hal.sim.air import Air
from hal.sim.battery import Battery
from hal.sim.contact_tracker import ContactTracker
from hal.sim.dynamics import STEPS_PER_PERIOD, Dynamics
from hal.sim.model_files import DEFAULT, load_model
from hal.sim.noise import CommandNoise
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import Physics
from hal.sim.pose_history import PoseHistory
from hal.sim.sensors.camera import RenderContext, SimCamera
from hal.sim.sensors.camera_spec import read_cameras
from hal.sim.sensors.camera_switch import CameraSwitch
from hal.sim.sensors.rangefinder import SimRangefinder
from hal.sim.sensors.sampling import FASTEST
from hal.sim.settings import Settings, plain_settings, read_settings
from hal.sim.starts import start_poses
from hal.sim.vehicle import SimVehicle
from hal.sim.weather import Weather
from hal.vehicle import PERIOD, PERIODS_PER_SECOND, Options
from vencejo.errors import VehicleError
from vencejo.geometry import Point
from vencejo.seeds import generator
from worlds.terrain import height_at
from worlds.wind import read_wind
from worlds.world import World


def _find_near(vehicles: Sequence[SimVehicle]) -> None:
    """Tell each vehicle whether it can touch another in the next mission period."""
    for vehicle in vehicles:
        vehicle.others_near = False
    for one, other in combinations(vehicles, 2):
        if one.dynamics.can_meet(other.dynamics):
            one.others_near = other.others_near = True


def _air_of(
    world: World, settings: Settings, vehicles: Sequence[SimVehicle], seed: int
) -> Air | None:
    """The air about some vehicles; None where nothing moves it."""
    wind = world.wind if settings.wind is None else read_wind(settings.wind, "wind")
    blown_down = settings.physics.downwash and len(vehicles) > 1
    if wind is None and not blown_down:
        return None
    return Air(Weather(wind, seed) if wind else None, vehicles, downwash=blown_down)


class SimSession:
    """The vehicles of one world, in lockstep (see :class:`hal.vehicle.Session`)."""

    def __init__(self, options: Options, world: World, physics: Physics) -> None:
        """Raises UserError for wrong settings, names of vehicles, models, or start poses."""
        settings = read_settings(options.settings)
        models = [load_model(spec.model or world.model or DEFAULT) for spec in options.vehicles]
        starts = start_poses(world, options.vehicles, [model.size for model in models])
        physics.add_things(world.things, world.ground.terrain)
        # One for each reach: where it may touch something is no matter of the other vehicles.
        obstacles = {
            reach: ObstacleHeightGrid(world.things, world.ground.terrain, reach)
            for reach in {model.reach for model in models}
        }
        moved: dict[str, Dynamics] = {}
        fitted = [read_cameras(settings.cameras, model.cameras) for model in models]
        rates = [camera.rate for cameras in fitted for camera in cameras.values()]
        interval = 1 / min(rates, default=FASTEST)  # a camera sees where all were so long ago
        chargers = {thing.name: thing.charges for thing in world.things if thing.charges}
        alone = len(options.vehicles) == 1
        self._has_movers = any(thing.motion is not None for thing in world.things)
        self._physics: Physics | None = physics
        self._engine = physics.name
        self._settings = plain_settings(settings)
        self._places = world.places
        origin = world.origin
        self._geographic = (origin.lat, origin.lon, origin.alt) if origin else None
        self._ground_height = partial(height_at, world.ground.terrain)
        self._count = 0
        self._all: list[SimVehicle] = []
        for spec, model, start in zip(options.vehicles, models, starts, strict=True):
            name = spec.name
            history = PoseHistory(interval)
            dynamics = moved[name] = Dynamics(
                name, physics, model, settings.physics, start, history
            )
            vehicle = SimVehicle(
                name,
                dynamics,
                model=model,
                home=start.home,
                battery=Battery(model.battery, world.battery, chargers),
                noise=CommandNoise(settings.noise, generator(options.seed, name, "command-noise")),
                contacts=ContactTracker(
                    physics,
                    dynamics.body,
                    model,
                    obstacles[model.reach],
                    lambda other: moved[other].velocity_before,
                ),
            )
            self._all.append(vehicle)
        self._air = _air_of(world, settings, self._all, options.seed)
        """None where it is still."""
        self._senses: list[Callable[[], None]] = []
        """The calls of the sensors after each physics step."""
        self._vehicles = MappingProxyType({vehicle.name: vehicle for vehicle in self._all})
        context = RenderContext(world, settings.renderer, settings.shadows, options.seed)
        self._render_context = context
        asked = [
            spec.color or start.color or model.color
            for spec, start, model in zip(options.vehicles, starts, models, strict=True)
        ]
        for vehicle, model, color, specs in zip(self._all, models, asked, fitted, strict=True):
            name = vehicle.name
            vehicle.color = color or color_of(name)
            context.pose_histories[name] = vehicle.dynamics.pose_history
            context.appearances[name] = quadrotor(
                name, arm=model.rotors.arm, size=model.size, color=vehicle.color
            )
            context.lamps[name] = vehicle.lamps
            if not alone:
                height = model.size[2]
                context.appearances |= lamp_things(name, arm=model.rotors.arm, height=height)
            cameras = {
                camera: SimCamera(name, camera, spec, context, self._steps)
                for camera, spec in specs.items()
            }
            sensors = {
                sensor: SimRangefinder(spec, physics, vehicle.dynamics.pose_history)
                for sensor, spec in settings.sensors.items()
            }
            switch = CameraSwitch(cameras, one_active=model.one_active_camera)
            vehicle.fit(switch, sensors)
            self._senses += [sensor.sense for sensor in sensors.values()]

    @property
    def vehicles(self) -> Mapping[str, SimVehicle]:
        return self._vehicles

    @property
    def engine(self) -> str:
        return self._engine

    @property
    def settings(self) -> Mapping[str, object]:
        return self._settings

    @property
    def places(self) -> Mapping[str, Point]:
        return self._places

    @property
    def geographic(self) -> tuple[float, float, float] | None:
        return self._geographic

    @property
    def ground_height(self) -> Callable[[float, float], float]:
        return self._ground_height

    def wait(self) -> float:
        """Advance by one mission period, six physics steps. Raises VehicleError when closed."""
        if self._physics is None:
            raise VehicleError("closed", "the simulator is closed")
        vehicles = self._all
        if len(vehicles) > 1:
            _find_near(vehicles)
        if self._air is not None:
            self._air.begin_period(self._count / PERIODS_PER_SECOND)
        for vehicle in vehicles:
            vehicle.plan()
        free = all(vehicle.dynamics.free for vehicle in vehicles)
        if free and not self._senses and not self._has_movers:
            for vehicle in vehicles:
                vehicle.dynamics.drive(STEPS_PER_PERIOD)
        else:
            self._step_by_step(self._physics.step)
        self._count += 1
        time = self._count / PERIODS_PER_SECOND
        for vehicle in vehicles:
            vehicle.update(time)
        return PERIOD

    def _step_by_step(self, step: Callable[[], None]) -> None:
        """Make the physics steps of a mission period with all vehicles side by side."""
        vehicles, senses = self._all, self._senses
        for _ in range(STEPS_PER_PERIOD):
            for vehicle in vehicles:
                vehicle.dynamics.drive()
            step()
            for vehicle in vehicles:
                vehicle.sense()
            for sense in senses:
                sense()

    def _steps(self) -> int:
        """Number of physics steps made."""
        return self._count * STEPS_PER_PERIOD

    def __enter__(self) -> SimSession:
        return self

    def __exit__(self, *exc: object) -> None:
        self._render_context.close()
        if self._physics is not None:
            self._physics.close()
            self._physics = None
