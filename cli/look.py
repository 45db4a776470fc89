"""Pictures of a world, without a flight: `drone-cli worlds NAME --render FILE`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product as product_of
from math import hypot, pi, radians
from pathlib import Path

from cli.output import write_file
from hal.lights import STANDARD
from hal.renderers import open_renderer
from hal.scene.appearance import ARM, SIZE, quadrotor
from hal.scene.lamps import lamp_things, lit_lamps
from hal.vehicle import Intrinsics
from vencejo.errors import Fault, UserError, Where
from vencejo.geometry import (
    OPTICAL,
    Point,
    Pose,
    Quaternion,
    about_y,
    product,
    turned,
    yaw_quaternion,
)
from worlds import Thing, World, pose_at
from worlds.solids import bounds_of, holds, part_pose
from worlds.things import Part

VIEWS = ("front", "down", "top")
"""Level and ahead from a place, straight down from it, or all of the world from above."""
WIDTH, HEIGHT = 640, 480
_FIELD = pi / 3
LENS = Intrinsics.from_field_of_view(WIDTH, HEIGHT, _FIELD)
_MARGIN = 0.05
"""Share of a picture from above that is left free along its edges."""
_SMALLEST = 6.0
"""Least radius of the part of a world that a picture from outside shows, metres."""


def render(
    world: World,
    file: Path,
    camera: str = "front",
    at: tuple[float, float, float, float] | None = None,
    renderer: str = "raster",
    shadows: bool = False,
) -> None:
    """Write a picture of a world; the file's name says of which format.

    ``at`` is x, y, z and yaw of the world frame; without it, ``front`` shows the world from
    outside and above, and ``down`` looks at the start from 10 m. Raises UserError.
    """
    import cv2

    if camera == "top" and at:
        raise UserError(
            "two-places",
            "--camera top shows all of the world and has its own place",
            hint="take --camera down to look straight down from --at",
        )
    appearances, poses = _vehicles(world)
    opened = open_renderer(renderer, world, appearances, shadows=shadows)
    try:
        image = opened.render(view(world, camera, at), LENS, 0.0, poses)
    finally:
        opened.close()
    hint = "its name ends in .png or .jpg and its folder exists"
    try:
        done, data = cv2.imencode(file.suffix, image)
    except cv2.error:
        done = False
    if not done:
        message = "this picture cannot be written"
        raise UserError("cannot-write", message, Where(str(file)), hint)
    write_file(file, data.data, hint)


def hidden_by(world: World, at: tuple[float, float, float, float]) -> Iterator[Fault]:
    """Warnings for a place from which little can be seen: inside a thing."""
    place = Point(*at[:3])
    for thing in world.things:
        if any(_holds(part, thing, place) for part in thing.parts):
            message = f"the camera is inside '{thing.name}'"
            hint = "what stands around it may not be seen: choose another --at"
            yield Fault("inside-thing", message, Where("--at"), hint, "warning")


def _holds(part: Part, thing: Thing, place: Point) -> bool:
    """Whether a place is inside a part; of a mesh its bounding box counts."""
    at, (x, y, z, w) = part_pose(part, *pose_at(thing, 0.0))
    return holds(part.shape, turned(place.minus(at), (-x, -y, -z, w)))


def _vehicles(world: World) -> tuple[dict[str, Thing], dict[str, Pose]]:
    """Appearances and poses of vehicles at the starts of a world, with their standard lights."""
    appearances, poses = dict[str, Thing](), dict[str, Pose]()
    for number, start in enumerate(world.starts):
        name = f"start {number}"
        body = start.at.plus((0.0, 0.0, SIZE[2] / 2)), yaw_quaternion(start.heading)
        appearances |= {name: quadrotor(name), **lamp_things(name, arm=ARM, height=SIZE[2])}
        poses |= {name: body, **lit_lamps(name, STANDARD, body)}
    return appearances, poses


def view(world: World, camera: str, at: tuple[float, float, float, float] | None) -> Pose:
    """The pose of the camera."""
    if camera == "top" or (camera == "front" and at is None):
        middle, reach = _extent(world)
        if camera == "top":
            return middle._replace(z=_height_over(world, middle)), _aimed(pi / 2, pi / 2)
        # From the south-west and above, with all of it in the picture.
        heading, tilt = radians(45), radians(27)
        back = turned((-2.5 * reach, 0.0, 0.0), product(yaw_quaternion(heading), about_y(tilt)))
        return middle.plus(back), _aimed(heading, tilt)
    start = world.starts[0]
    x, y, z, yaw = at or (start.at.x, start.at.y, start.at.z + 10.0, start.heading)
    return Point(x, y, z), _aimed(yaw, pi / 2 if camera == "down" else 0.0)


def _aimed(heading: float, tilt: float) -> Quaternion:
    return product(product(yaw_quaternion(heading), about_y(tilt)), OPTICAL)


def _height_over(world: World, middle: Point) -> float:
    """The height over the middle of a world from which all of it is in the picture."""
    across, along = (side / 2 * (1 - _MARGIN) for side in (WIDTH / LENS.fx, HEIGHT / LENS.fy))
    return max(
        _SMALLEST / along,
        *(
            z + max(abs(x - middle.x) / across, abs(y - middle.y) / along)
            for x, y, z in _outermost(world)
        ),
    )


def _extent(world: World) -> tuple[Point, float]:
    """The middle of what is in a world, on the ground, and how far it reaches from there."""
    places = _outermost(world)
    east, north = [place.x for place in places], [place.y for place in places]
    middle = Point((min(east) + max(east)) / 2, (min(north) + max(north)) / 2, 0.0)
    reach = max((max(east) - min(east)) / 2, (max(north) - min(north)) / 2)
    return middle, max(reach, _SMALLEST)


def _outermost(world: World) -> list[Point]:
    """Points between which all of a world lies."""
    found = [*world.places.values(), *(start.at for start in world.starts)]
    for thing in world.things:
        found += _corners(thing)
    for stripe in world.ground.stripes:
        half = stripe.width / 2
        for x, y in stripe.points:
            found += [Point(x - half, y - half, 0.0), Point(x + half, y + half, 0.0)]
    return found


def _corners(thing: Thing) -> list[Point]:
    """The corners of the box about a thing; of one that moves, of boxes all along its path, about
    the thing in every heading.
    """
    bounds = [bounds_of(p.shape, *part_pose(p, thing.at, thing.attitude)) for p in thing.parts]
    ends = [end.minus(thing.at) for pair in bounds for end in pair]
    if not ends:
        return []
    low, high = (Point(*map(choose, zip(*ends, strict=True))) for choose in (min, max))
    places = [thing.at]
    if thing.motion is not None:
        reach = hypot(max(-low.x, high.x), max(-low.y, high.y))
        low, high = low._replace(x=-reach, y=-reach), high._replace(x=reach, y=reach)
        places = list(thing.motion.points)
    corners = [Point(*corner) for corner in product_of(*zip(low, high, strict=True))]
    return [place.plus(corner) for place in places for corner in corners]
