"""The flying loop: backend, pilots, recorder and watchers, one mission period at a time."""

from __future__ import annotations

import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import version
from pathlib import PurePosixPath
from platform import python_version
from types import SimpleNamespace
from typing import Protocol

from behaviors import Calls, Exchange, MissionFrame, Pilot
from behaviors.host_functions import set_limits
from behaviors.vocabulary import VehicleView
from fsm.engine.instance import Record
from fsm.fleet import Until
from fsm.values.functions import FAILURES, EvaluationError, plain
from hal import Options, Session, open_backend
from hal.vehicle import PERIODS_PER_SECOND
from runner.by_vehicle import are_alone
from runner.call_limit import CallLimit
from runner.course import Entered, collisions, entered
from runner.kept_files import KeptFiles, kept_files
from runner.pace import Pace
from runner.plan import Assignment, Fleet, Plan
from runner.posts import Post
from runner.process_settings import ProcessSettings
from runner.recorder import Recorder
from runner.referee import Referee
from runner.run_folder import LAST_ENTERED, Flown, Header, MissionFacts, Summary
from runner.separation import Separation
from runner.settings import MissionSettings, RunSettings
from vencejo.errors import UserError, VehicleError, Where
from vencejo.geometry import Point, distance
from vencejo.version import __version__

_EPSILON = 1e-9
"""Seconds within which two times count as equal."""


class Watcher(Protocol):
    """Called in every period for every vehicle, in the order of the plan.

    Looks through ``pilot.vehicle``: what is read through ``pilot.channel`` counts as read by the
    mission and is recorded.
    """

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None: ...


class Stops(Protocol):
    """Requests to stop: the first asks the missions, the second lands outside them."""

    @property
    def count(self) -> int: ...


@dataclass
class _Craft:
    """One vehicle of a run, with the figures of its flight so far."""

    pilot: Pilot
    start: float
    """Time at which the run began, seconds of the session's clock."""
    distance: float = 0.0
    max_altitude: float = 0.0
    left_ground: bool = False
    entered: deque[Entered] = field(default_factory=lambda: deque(maxlen=LAST_ENTERED))
    collisions: Counter[str] = field(default_factory=Counter)
    failure: VehicleError | None = None
    """The error because of which it could not be landed; None for none."""
    posts: deque[Post] = field(default_factory=deque)
    """Events that its mission is still to be told, the next one first."""
    has_defect: bool = False
    """Whether an exception that nobody expected has ended its mission."""
    _last: Point | None = None

    @property
    def over(self) -> bool:
        """True once it has landed after its mission, or cannot be landed."""
        return self.failure is not None or self.pilot.finished

    def period(self, dt: float) -> None:
        """Fly a mission period of ``dt`` seconds."""
        if self.posts:
            self._post()
        try:
            self.pilot.period(dt)
        except VehicleError as error:
            self.lose(error)
        except Exception as defect:
            # Ours, or of a person's code in a way nobody has thought of: shown, and landed.
            if self.pilot.outcome is not None:
                raise
            self.has_defect = True
            sys.excepthook(type(defect), defect, defect.__traceback__)
            self.pilot.abandon(f"a defect of the program: {type(defect).__name__}: {defect}")
        channel = self.pilot.channel
        position = channel.world.position
        if self._last is not None and channel.jump is not None:
            self._last = self._last.plus(channel.jump.offset)
        if self._last is not None:
            self.distance += distance(self._last, position)
        self.max_altitude = max(self.max_altitude, position.z - channel.frame.origin.z)
        self.left_ground = self.left_ground or channel.world.flying
        self._last = position
        if channel.world.events:
            self.collisions.update(collisions(channel.world))

    def _post(self) -> None:
        """Tell its mission the events whose time has come."""
        seen = self.pilot.vehicle.observe()
        while self.posts and seen.time - self.start >= self.posts[0].time - _EPSILON:
            post = self.posts.popleft()
            self.pilot.instance.post(post.event, post.fields_at(seen))

    def lose(self, error: VehicleError) -> None:
        """It or its backend has failed: order the landing all the same."""
        self.failure = error
        self.pilot.land_now(error.faults[0].message, "failed")

    def flown(self) -> Flown:
        pilot = self.pilot
        return Flown(
            outcome=pilot.outcome or "failed",
            reason=pilot.reason,
            output=pilot.instance.output,
            mission_time=pilot.channel.now - self.start,
            distance=self.distance,
            max_altitude=self.max_altitude,
            battery=pilot.channel.observation.battery,
            entered=tuple(self.entered),
            collisions=dict(self.collisions),
            failure=self.failure.faults[0].message if self.failure else "",
            left_ground=self.left_ground,
        )


class _Log:
    """The recorder of a run, if it has one, as long as it can write."""

    def __init__(self, recorder: Recorder | None) -> None:
        self._recorder = recorder
        self.failure = ""
        """The fault that stopped the writing; empty for none."""

    def begin(self, header: Header, files: KeptFiles, crafts: Iterable[_Craft]) -> None:
        if self._recorder is not None:
            with self._recorder.beginning():
                self._recorder.keep(files.contents)
                self._recorder.begin(header)
            for craft in crafts:
                self._recorder.follow(craft.pilot)

    def take(self, pilot: Pilot, *, period: bool = True) -> list[Record]:
        """The records of a pilot, written, with the row of telemetry of its ``period``; none where
        they cannot be.
        """
        if self._recorder is None or self.failure:
            records, pilot.instance.records = pilot.instance.records, []
            return records
        records = pilot.instance.records
        try:
            return self._recorder.take(pilot) if period else self._recorder.take_records(pilot)
        except UserError as error:
            self.failure = str(error)
            return records

    def close(self) -> None:
        """Have everything on disk after this, or the reason in ``failure``."""
        if self._recorder is not None:
            try:
                self._recorder.close()
            except UserError as error:
                self.failure = self.failure or str(error)


@dataclass(frozen=True)
class _Never:
    count: int = 0


class _Together:
    """What concerns the vehicles of a fleet together: messages, distances, and their common end."""

    def __init__(self, crafts: Sequence[_Craft], fleet: Fleet | None) -> None:
        pilots = [craft.pilot for craft in crafts]
        until = fleet.until if fleet else None
        contest = fleet.contest if fleet else None
        self.referee = Referee(contest) if contest else None
        """None where the fleet has none."""
        by_name = {pilot.vehicle.name: pilot for pilot in pilots}
        self._pair = [by_name[name] for name in contest.between] if contest else []
        """The vehicles that it looks at, the pursuer first."""
        self._channels = [pilot.channel for pilot in pilots]
        self._exchange = Exchange(pilots)
        self._until = until
        self._is_broken = False
        """Whether the condition had no value in the last period."""
        self._waits = until is not None and all(craft.pilot.stands for craft in crafts)
        self.separation = Separation([pilot.vehicle.name for pilot in pilots])
        self.is_over = False
        """Whether the condition that ends their flight came true."""

    def period(self, aloft: Sequence[_Craft], dt: float) -> None:
        """After all have flown a period of ``dt`` seconds: carry messages, measure, and end what is
        to end.
        """
        self._exchange.deliver()
        seen = [channel.world for channel in self._channels]
        time = aloft[0].pilot.channel.now
        self.separation.update(time, [s.position for s in seen], [s.flying for s in seen])
        if self.referee is not None:
            pair = [pilot.channel.world for pilot in self._pair]
            aloft_both = all(each.flying for each in pair)
            self.referee.update([each.position for each in pair], aloft_both, dt)
            self.referee.hear(self._pair[0].instance.records)
        if self._until is not None and not self.is_over and self._holds(self._until, time, aloft):
            self.is_over = True
            for craft in aloft:
                craft.pilot.land_now(f"until {self._until.text}", "done")
        elif not self._waits and all(craft.pilot.stands for craft in aloft):
            for craft in aloft:
                craft.pilot.land_now("", "done")

    def _holds(self, until: Until, time: float, aloft: Sequence[_Craft]) -> bool:
        vehicles = [
            SimpleNamespace(vehicle=VehicleView(channel.world, channel.frame.origin.z))
            for channel in self._channels
        ]
        try:
            holds = until.holds(time, vehicles)
        except FAILURES as error:
            if not self._is_broken:
                where = str(until.condition.where)
                aloft[0].pilot.instance.record("error", message=plain(error), where=where)
            self._is_broken = True
            return False
        self._is_broken = False
        return holds


@dataclass
class _Flying:
    """A flight under way: all vehicles in lockstep, one mission period after the other."""

    session: Session
    crafts: Sequence[_Craft]
    log: _Log
    watchers: Sequence[Watcher]
    pace: Pace
    stops: Stops
    limit: CallLimit
    together: _Together | None = None
    """None for a vehicle that flies alone."""
    answered: int = 0
    """The number of requests to stop that have been carried out."""

    def __post_init__(self) -> None:
        self.aloft = self.crafts
        """The vehicles that have not come to their end."""
        self.settings = ProcessSettings.now()

    def go_on(self, dt: float | None) -> None:
        """Fly on with a period of ``dt`` seconds until all vehicles are down, or cannot be."""
        stops, log, pace = self.stops, self.log, self.pace
        periods = 0
        while dt is not None and self.aloft:
            periods += 1
            if periods % PERIODS_PER_SECOND == 0:
                self._undo_changes()
            if stops.count > self.answered:
                self.answered = stops.count
                self._stop(at_once=self.answered > 1)
            for craft in self.aloft:
                craft.period(dt)
                if craft.has_defect:
                    self._undo_changes()
            if self.together is not None:
                self.together.period(self.aloft, dt)
            self._show()
            if log.failure:
                # A flight nobody can read afterwards is of no use, but it is not left in the air.
                self._stop(at_once=True)
            if pace.factor is not None:
                pace.wait(self.aloft[0].pilot.channel.now, self._is_asked_more)
            self.aloft = [craft for craft in self.aloft if not craft.over]
            if self.aloft:
                dt = self._wait()

    def abandon(self, reason: str) -> None:
        """End all missions in the midst of a period, land, and come back when all are down."""
        for craft in self.aloft:
            craft.pilot.abandon(reason)
        self._undo_changes()
        self.go_on(self._wait())

    def _wait(self) -> float | None:
        """Wait for the next period; its seconds, or None when the session has failed."""
        try:
            return self.session.wait()
        except VehicleError as error:
            for craft in self.aloft:
                craft.lose(error)
            self._show(period=False)
            return None

    def _undo_changes(self) -> None:
        """Set again what people's code may have changed in this process."""
        self.settings.restore()
        self.limit.renew()

    def _show(self, *, period: bool = True) -> None:
        """Write down and show what the vehicles have just done, in a new ``period`` or not."""
        for craft in self.aloft:
            records = self.log.take(craft.pilot, period=period)
            if records:
                craft.entered.extend(entered(craft.pilot.instance, records))
            for watcher in self.watchers:
                watcher.show(craft.pilot, records)

    def _stop(self, *, at_once: bool) -> None:
        """Ask every mission to stop, or land outside them."""
        for craft in self.aloft:
            craft.pilot.land_now() if at_once else craft.pilot.abort()

    def _is_asked_more(self) -> bool:
        return self.stops.count > self.answered


def fly(
    plan: Plan,
    record: Callable[[], Recorder] | None = None,
    watchers: Sequence[Watcher] = (),
    pace: Pace | None = None,
    stops: Stops | None = None,
    limit: CallLimit | None = None,
) -> Summary:
    """Fly a plan to its end: all vehicles in lockstep, each until its mission has ended and it is
    down, or cannot be brought down.

    ``record`` makes the recorder once nothing can keep the flight from starting any more.
    ``stops`` asks every mission to stop, then lands every vehicle. ``limit``, which its caller has
    entered, ends calls into people's code that last too long; without it none is ended.
    Raises VehicleError when a vehicle cannot be had, UserError when one cannot fly this. What fails
    later is in the summary.
    """
    limit = limit or CallLimit(None)
    options = Options(
        vehicles=plan.vehicles,
        world=plan.world_word,
        seed=plan.seed,
        address=plan.address,
        settings=plan.settings,
    )
    known = versions()  # before the engine takes its memory: later it would be slower to get again
    with open_backend(plan.backend, options) as session, ExitStack() as stack:
        dt = session.wait()
        crafts = [_craft(plan, session, name, dt, limit.calls) for name in session.vehicles]
        files = kept_files(plan)
        header = _header(plan, session, files, limit)
        log = _Log(record() if record else None)
        stack.callback(log.close)
        log.begin(header, files, crafts)
        together = _Together(crafts, plan.fleet) if plan.fleet or len(crafts) > 1 else None
        flying = _Flying(
            session, crafts, log, watchers, pace or Pace(None), stops or _Never(), limit, together
        )
        began = time.perf_counter()

        def summary() -> Summary:
            log.close()
            return Summary(
                header,
                {craft.pilot.vehicle.name: craft.flown() for craft in crafts},
                wall_time=time.perf_counter() - began,
                interrupted=flying.answered > 0,
                versions=known,
                unrecorded=log.failure,
                ended_by_until=together is not None and together.is_over,
                separation=together.separation.nearest() if together else (),
                verdict=together.referee.verdict() if together and together.referee else None,
            )

        def land(reason: str) -> Summary:
            flying.abandon(reason)
            return summary()

        limit.land = land
        stack.callback(setattr, limit, "land", None)
        flying.go_on(dt)
        return summary()


def _craft(plan: Plan, session: Session, name: str, dt: float, calls: Calls) -> _Craft:
    """A vehicle with its mission, about to begin with a period of ``dt`` seconds."""
    vehicle, assignment = session.vehicles[name], plan.assignments[name]
    seen = vehicle.observe()
    graph, parameters = assignment.prepared.graph, assignment.parameters
    frame = MissionFrame.at_start(
        seen, session.places, session.geographic, session.ground_height, graph.files
    )
    pilot = Pilot(graph, vehicle, parameters, frame=frame, seed=plan.seed, calls=calls)
    try:
        set_limits(pilot.channel, plan.profile, **plan.limits.given())
    except EvaluationError as error:
        raise UserError("bad-limit", f"'{name}': {error}", Where("--limit")) from None
    pilot.stands = assignment.stands
    told = () if pilot.stands else (post for post in plan.posts if post.to in ("", name))
    return _Craft(pilot, seen.time - dt, posts=deque(told))


def _header(plan: Plan, session: Session, files: KeptFiles, limit: CallLimit) -> Header:
    # What a backend does not give back is kept as it was given.
    hashes = files.hashes()
    unlisted = {n: value for n, value in plan.settings.items() if n not in session.settings}
    return Header(
        missions={
            name: replace(
                _facts(flown, PurePosixPath(files.missions[name]), hashes)
                if name in files.missions
                else MissionFacts("", "", {}),
                model=session.vehicles[name].model,
                color=None if are_alone(plan.assignments) else session.vehicles[name].color,
            )
            for name, flown in plan.assignments.items()
        },
        fleet=plan.fleet.name if plan.fleet else "",
        world=plan.world.name,
        world_sha256=plan.world.sha256,
        seed=plan.seed,
        backend=plan.backend,
        engine=session.engine,
        vencejo=__version__,
        settings=RunSettings(
            missions={
                name: MissionSettings(
                    files.missions.get(name, ""),
                    flown.all_parameters,
                    files.models.get(flown.model or "", flown.model),
                    flown.start,
                    flown.color,
                )
                for name, flown in plan.assignments.items()
            },
            world=files.world,
            files=hashes,
            backend=plan.backend,
            seed=plan.seed,
            connect=plan.address,
            profile=plan.profile,
            limits=plan.limits,
            call_limit=limit.seconds,
            camera_file=files.camera_file,
            post=plan.posts,
            fleet=plan.fleet.name if plan.fleet else "",
            fleet_file=files.fleet,
            until=plan.fleet.until.text if plan.fleet and plan.fleet.until else "",
            referee=plan.fleet.contest if plan.fleet else None,
            own={**session.settings, **unlisted},
        ),
    )


def _facts(assignment: Assignment, kept: PurePosixPath, hashes: Mapping[str, str]) -> MissionFacts:
    """``kept``: the path of the mission's copy; its other files keep their places beside it."""
    first, *others = assignment.prepared.files
    beside = [file.relative_to(first.parent).as_posix() for file in others]
    return MissionFacts(
        name=assignment.prepared.graph.name,
        sha256=hashes[str(kept)],
        parameters=assignment.all_parameters,
        files={name: hashes[str(kept.parent / name)] for name in beside},
    )


@cache
def versions() -> Mapping[str, str]:
    """Versions of the packages that a run's result may depend on, and of Python."""
    packages = ("transitions", "numpy", "opencv-python-headless", "pymavlink")
    return {
        "vencejo": __version__,
        "python": python_version(),
        **{package: version(package) for package in packages},
    }
