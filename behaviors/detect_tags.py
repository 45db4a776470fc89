"""detect_tags: look for tags while something else flies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.params import BehaviorParams, live, param, value
from behaviors.perception.tag_tracks import Sighting, TagTracks, Track
from behaviors.perception.tags import Place
from behaviors.plan import Unflyable
from behaviors.tag_watch import TagWatch, finder_of
from fsm.host import Outcome
from vencejo.geometry import Point
from worlds.markers import DICTIONARIES

NEARER = 20.0
"""By how much another tag must be nearer to the middle of the picture to become the nearest one,
pixels."""


@dataclass(frozen=True, slots=True)
class Tags:
    """The tags in view.

    All values but the first three are those of the nearest one, the one that is nearest to the
    middle of the picture, and stay when it is lost.
    """

    count: int = 0
    """How many are visible."""
    visible: bool = False
    """Whether any is."""
    ids: list[Any] = field(default_factory=list)
    """Of all that are visible, in order."""
    id: int | None = None
    kind: str = ""
    """The dictionary of a marker, or ``roundel``."""
    offset_x: float = 0.0
    """How far it is to the left, as a share of half the picture's width: -1 to 1."""
    offset_y: float = 0.0
    """How far it is above the middle (of a camera that looks down: ahead), as a share of half the
    picture's height: -1 to 1."""
    radius: float = 0.0
    """Distance from the middle of the picture, pixels."""
    centered: bool = False
    """Whether both offsets are within ``tolerance``."""
    angle: float = value("rad")
    """The turn to the left after which it is upright in the picture."""
    oriented: bool = False
    """Whether that is within ``aligned``."""
    distance: float | None = value("m", None)
    """From the camera."""
    nearest: Point | None = None
    """Its place, mission frame; where it is expected while it is missed for a moment."""
    velocity: Point | None = None
    """Of that place, m/s."""
    heading: float | None = value("rad", None)
    """Where its top points if it lies, where it faces if it stands."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A sighting of a tag."""

    id: int
    """Of a marker; of a roundel its number, from 1, in the order in which they were found."""
    kind: str
    """The dictionary of a marker, or ``roundel``."""
    radius: float
    """Distance from the middle of the picture, pixels."""
    centered: bool
    position: Point | None
    """Mission frame; None where it is not known."""
    distance: float | None = value("m", None)


class DetectTags(Behavior):
    """Look for tags with a camera, for as long as its state lasts; it moves nothing.

    Tags are fiducial markers and oriented roundels. ``tag.seen`` is raised once when a tag comes
    into view, and once more when it has been as near to the middle of the picture as it came. A tag
    is visible once it was found in ``needed`` of the last ``of`` pictures, and until it was found
    in none of them. Places need the ``size`` of the tags, or else tags that lie on the ground.
    """

    name = "detect_tags"

    class Params(BehaviorParams):
        camera: str = param(help="the name of a camera of the vehicle", names="camera")
        dictionary: str = param(
            "4X4_50", choices=tuple(DICTIONARIES), help="of the markers, by OpenCV's name"
        )
        ids: list[Any] | None = param(None, help="of the markers looked for; without it, all")
        roundels: bool = param(True, help="whether roundels are looked for")
        size: float | None = param(
            None, unit="m", min=0.005, max=20.0, help="side of a marker, diameter of a roundel"
        )
        tolerance: float = live(
            0.35, min=0.0, max=1.0, help="share of half the picture that is still centred"
        )
        aligned: float = live(18.0, unit="deg", min=0.0, max=180.0, help="angle that is oriented")
        roll_pitch_thr: float | None = param(
            None,
            unit="rad",
            min=0.0,
            max=pi / 2,
            help="pictures taken at more tilt are ignored",
        )
        needed: int = param(2, min=1, max=50, help="pictures in which it must be found")
        of: int = param(5, min=1, max=50, help="of so many last ones")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    events: ClassVar[Mapping[str, type | None]] = {"tag.seen": Seen}
    publishes = Tags
    controls = ()

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params = self.params
        if params.needed > params.of:
            raise Unflyable(
                f"nothing is found in {params.needed} of {params.of} pictures", "needed"
            )
        finder = finder_of(params.dictionary, params.ids, params.size, roundels=params.roundels)
        tracks = TagTracks(params.needed, params.of)
        self.watch = TagWatch(
            flight, self.name, params.camera, finder, tracks, params.roll_pitch_thr
        )
        self.nearest: Track | None = None
        self.published = Tags()

    def step(self, flight: Flight) -> Outcome | str | None:
        sighted = self.watch.look(flight, self._is_centered)
        for sighting in sighted or ():
            flight.raise_event("tag.seen", self._seen(sighting))
        visible = self.watch.visible(flight.now)
        if sighted is None and bool(visible) == self.published.visible:
            return None
        self.nearest = _nearest(visible, self.nearest)
        self.published = self._values(visible, flight.now)
        flight.publish(self.published)
        return None

    def _seen(self, sighting: Sighting) -> Seen:
        where = sighting.place
        return Seen(
            sighting.id,
            sighting.kind,
            where.radius,
            self._is_centered(where),
            sighting.position,
            sighting.distance,
        )

    def _values(self, visible: list[Track], now: float) -> Tags:
        tag, ids = self.nearest, sorted(track.id for track in visible)
        if tag is None:
            return replace(self.published, count=0, visible=False, ids=[])
        angle = -tag.tag.angle
        return Tags(
            len(visible),
            True,
            ids,
            tag.id,
            tag.kind,
            tag.place.left,
            tag.place.up,
            tag.place.radius,
            self._is_centered(tag.place),
            angle,
            abs(angle) <= self.params.aligned,
            tag.tag.distance,
            tag.position_at(now),
            tag.velocity,
            tag.tag.heading,
        )

    def _is_centered(self, where: Place) -> bool:
        most: float = self.params.tolerance
        return max(abs(where.left), abs(where.up)) <= most


def _nearest(visible: list[Track], last: Track | None) -> Track | None:
    """The tag that is nearest to the middle of the picture.

    The last one stays it as long as it is visible and no other is clearly nearer.
    """
    if not visible:
        return None
    nearest = min(visible, key=lambda track: track.place.radius)
    if last in visible and last.place.radius <= nearest.place.radius + NEARER:
        return last
    return nearest
