"""Draws what vision behaviours see in shipped missions, for the pages of docs/vision.

A part of `make images`; alone `python -m docs.draw_vision`, which takes some minutes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import cv2
import numpy as np

from cli.plot import draw
from hal.scene.arrays import Pixels
from runner import Plan, Prepared, Recorder, Run, fly, missions, read_run
from runner.findings import findings_of
from runner.fleets import prepare_any

IMAGES = Path(__file__).parent / "images" / "vision"


class Moment(NamedTuple):
    """A moment of the flight of a mission, and what is shown of it."""

    mission: str
    name: str
    """Of its annotated pictures."""
    time: float
    """Seconds of the flight."""


FOURS: Mapping[str, Sequence[Moment]] = {
    "pictures": (
        Moment("follow_road", "road", 20.0),
        Moment("land_on_pad", "land_on", 10.6),
        Moment("track_object", "track_object", 24.4),
        Moment("tag_follower", "detect_tags", 22.9),
    ),
    "follow_road": (
        Moment("follow_road", "road", 8.5),
        Moment("follow_road", "road", 18.5),
        Moment("road_travel", "road", 18.0),
        Moment("road_watch", "traffic", 15.5),
    ),
}
"""Pictures of four moments, two by two."""
ROWS: Mapping[str, Sequence[float]] = {
    "track_object": (1.8, 6.6, 12.0, 30.0),
    "land_on_pad": (7.4, 9.0, 10.6, 11.6),
    "land_on_moving_pad": (6.6, 8.0, 9.2, 10.3),
}
"""Pictures of some seconds of the flight of a mission, side by side."""
TAGS: Mapping[str, Moment] = {
    each.mission: each
    for each in (
        Moment("tag_lights", "detect_tags", 8.8),
        Moment("tag_follower", "detect_tags", 20.0),
        Moment("tag_follower_braking", "detect_tags", 24.0),
        Moment("roundel_follower", "hover_over", 20.0),
        Moment("tag_navigator", "hover_over", 6.0),
    )
}
"""Pictures of one moment."""
_WIDTH = 480
"""Of the pictures of one moment, and of that of a whole flight, pixels."""
_SMALL = (240, 180)
"""Width and height of each moment in a row."""
_MAP = (slice(50, 610), slice(20, 595))
"""Where the map is in the picture of a run, pixels."""
_FOUND = ("person_1", "buoy_1", "marker_7", "person_4")
"""What is shown of the findings of a search."""
_HUNT = (9.0, 30.0, 45.0)
"""Seconds of the fleet cat_and_mouse at which the cat's view is shown."""


@contextmanager
def flown(mission: str, *, noise: float = 0.0, seed: int = 0) -> Iterator[Run]:
    """Fly a shipped mission or fleet; its run, whose folder is there until the block ends."""
    prepared = prepare_any(missions.find(mission))
    settings = {"noise": noise}
    if isinstance(prepared, Prepared):
        plan = Plan.alone(prepared, seed=seed, settings=settings)
    else:
        plan = Plan(prepared.assignments, seed=seed, settings=settings, fleet=prepared.fleet)
    with TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder))
        recorder.write_summary(fly(plan, lambda: recorder))
        yield read_run(folder)


def seen(run: Run, time: float, name: str | None = None) -> Pixels:
    """The annotated picture nearest to a second of a run; of one name, or of any."""
    named = [picture for picture in run.pictures if name in (None, picture.name)]
    return image_of(min(named, key=lambda picture: abs(picture.time - time)).path)


def image_of(file: Path) -> Pixels:
    return np.asarray(cv2.imread(str(file)), np.uint8)


def scaled(image: Pixels, size: tuple[int, int]) -> Pixels:
    """An image in a width and a height."""
    way = cv2.INTER_AREA if size[0] < image.shape[1] else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(image, size, interpolation=way), np.uint8)


def widened(image: Pixels, width: int) -> Pixels:
    """An image in a width, as high as it is then."""
    return scaled(image, (width, round(image.shape[0] * width / image.shape[1])))


def two_by_two(views: Sequence[Pixels]) -> Pixels:
    return np.vstack([np.hstack(views[:2]), np.hstack(views[2:])])


def save(name: str, image: Pixels, quality: int) -> None:
    IMAGES.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(IMAGES / f"{name}.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, quality])


def draw_fours() -> None:
    for file, moments in FOURS.items():
        views = []
        for moment in moments:
            with flown(moment.mission) as run:
                views.append(seen(run, moment.time, moment.name))
        save(file, two_by_two(views), 80)


def draw_rows() -> None:
    for mission, times in ROWS.items():
        with flown(mission, noise=1.0, seed=1) as run:
            save(mission, np.hstack([scaled(seen(run, time), _SMALL) for time in times]), 80)


def draw_tags() -> None:
    """What the tag missions see, and the whole flight of the square, which sees nothing."""
    for mission, moment in TAGS.items():
        with flown(mission, noise=1.0, seed=1) as run:
            save(mission, widened(seen(run, moment.time, moment.name), _WIDTH), 85)
    with flown("square", noise=1.0, seed=1) as run:
        save("square", widened(image_of(draw(run.folder)), _WIDTH), 85)


def draw_sweep() -> None:
    """The way over the meadow, and beside it some of what was found on it."""
    with flown("sweep_detect") as run:
        way = image_of(draw(run.folder))[_MAP]
        found = {finding.id: finding.time for finding in findings_of(run)}
        views = two_by_two([seen(run, found[each] + 0.3) for each in _FOUND])
    height = views.shape[0]
    small = scaled(way, (round(way.shape[1] * height / way.shape[0]), height))
    save("sweep_detect", np.hstack([small, views]), 70)


def draw_pursuit() -> None:
    """The ways of cat and mouse and their distance, and below what the cat sees."""
    with flown("cat_and_mouse") as run:
        ways = image_of(draw(run.folder))
        views = np.hstack([seen(run, time) for time in _HUNT])
    save("pursue", np.vstack([widened(ways, views.shape[1]), views]), 60)


def draw_vision() -> None:
    """Draw all of them."""
    draw_fours()
    draw_rows()
    draw_tags()
    draw_sweep()
    draw_pursuit()


if __name__ == "__main__":
    draw_vision()
