"""A world from above, on a map: roads, things, their ways, named places, the fence; and marks."""

from __future__ import annotations

from cli.plot.axes import FRAME, LABEL, Axes
from cli.plot.canvas import DARK, XY, Canvas
from worlds import World, outlines_of

_THING, _THING_EDGE, _ROAD = (226, 226, 222), (150, 150, 145), (240, 240, 238)
_FENCE = (214, 120, 120)


def draw_world(canvas: Canvas, axes: Axes, world: World) -> None:
    """Draw what stands in a world, and its roads and places."""
    scale = axes.x.pixel(1.0) - axes.x.pixel(0.0)
    for road in world.roads:
        places, width = axes.places(road.points), max(1.0, road.width * scale)
        canvas.line(places, _ROAD, width)
        for place in places:  # the short parts of a bend leave slits between them
            canvas.disc(place, width / 2, _ROAD)
    # Low things first, so that a roof covers what stands under it.
    for thing in sorted(world.things, key=lambda thing: thing.at.z):
        if thing.motion is not None:
            way = [(point.x, point.y) for point in thing.motion.points]
            canvas.dashes(axes.places(way), _THING_EDGE)
        for outline in outlines_of(thing):
            canvas.area(axes.places(outline), _THING, _THING_EDGE)
    for name, point in world.places.items():
        at = axes.place(point.x, point.y)
        if axes.box.holds(at):
            canvas.disc(at, 2.5, FRAME)
            canvas.text((at[0] + 6, at[1] + 8), name, 11, LABEL)


def draw_fence(canvas: Canvas, axes: Axes, world: World) -> None:
    """Draw the fence of a world, if it has one."""
    if world.fence is not None:
        corners = world.fence.corners
        canvas.dashes(axes.near((*corners, corners[0]), 20), _FENCE, 1.5)


def mark_start(canvas: Canvas, place: XY) -> None:
    """Mark where a vehicle begins."""
    x, y = place
    canvas.area([(x, y - 7), (x - 6.5, y + 5), (x + 6.5, y + 5)], DARK)
