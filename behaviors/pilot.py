"""The pilot: flies one graph on one vehicle, a mission period at a time.

In each period it observes the vehicle, posts urgent events, runs the graph's period, and commands
the vehicle. The operator and safety (a landing outside the mission) have authority over the
mission; without a command the vehicle holds its place. However the mission ends, the vehicle is
landed: the landing is ordered even when the link is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf
from typing import Any

from behaviors.activity import DroneActivity
from behaviors.calls import Calls, CodeFailed
from behaviors.channel import Channel
from behaviors.frame import GroundHeight, MissionFrame
from behaviors.host_functions import HOST_FUNCTIONS
from behaviors.landing import Aside, Descent, is_unstable
from behaviors.vocabulary import VehicleView
from behaviors.watch import Thresholds, Watch
from fsm.chart.graph import Graph
from fsm.engine.instance import Instance
from fsm.engine.saving import TORN, load, save
from fsm.host import BehaviorInfo
from fsm.values.functions import EvaluationError
from fsm.values.intake import copied
from fsm.values.packing import pack, unpack
from hal.orders import Order
from hal.vehicle import PERIOD, Hold, Observation, Position, Setpoint, Vehicle
from vencejo.errors import UserError, VehicleError
from vencejo.geometry import Point, distance
from vencejo.seeds import generator

HOLD_BEFORE_LANDING = 1.0
"""Seconds of hold, to come to rest, after a mission has ended in the air."""
LANDING_TIMEOUT = 300.0
"""Seconds after which a landing has failed, while the vehicle is heard."""
SILENCE_TIMEOUT = 600.0
"""Seconds after which a landing has failed, while nothing is heard and it is ordered again."""
LANDING_RETRY = 1.0
"""Seconds after which a landing that was refused or lost is ordered again."""
STAY_WITHIN = 1.0
"""Metres within which a place that was commanded is held, rather than where the vehicle stops."""
SILENT = frozenset({"lost", "gone"})
"""Links over which nothing is heard: what was observed last may not be so any more."""
STILL = Point(0.0, 0.0, 0.0)
SAVED = {
    *("origin", "origin_shift", "watch", "rng", "last"),
    *("outcome", "reason", "ended_for", "landing"),
}
"""The keys that a saved flight has for the pilot, besides those of its instance."""


class Pilot:
    """One vehicle with the mission it flies: call ``period`` after every ``session.wait``."""

    def __init__(
        self,
        graph: Graph,
        vehicle: Vehicle,
        parameters: Mapping[str, Any] | None = None,
        *,
        frame: MissionFrame | None = None,
        seed: int = 0,
        thresholds: Thresholds | None = None,
        calls: Calls | None = None,
    ) -> None:
        """The vehicle must have been observed: its session has waited once. ``calls`` are those
        into people's code, for whoever limits their time.

        Raises UserError (``missing-capability``).
        """
        self.vehicle = vehicle
        self.channel = Channel(
            vehicle,
            frame or MissionFrame.at_start(vehicle.observe(), files=graph.files),
            generator(seed, vehicle.name, "behaviours"),
        )
        self.instance = Instance(graph, self, self._located(graph, parameters or {}))
        self.landing: Order | None = None
        """The order to land outside the mission; None before."""
        self.reason = ""
        """The reason why the mission was ended from outside; empty when it ended by itself."""
        self.outcome: str | None = None
        self.on_send: Callable[[str, Mapping[str, Any], str], None] | None = None
        """Called with each event to another vehicle: its name, its fields, the vehicle's name."""
        self.stands = False
        """Whether it commands nothing but a landing: for a vehicle without a mission."""
        self._watch = Watch(thresholds or Thresholds())
        self._calls = calls or Calls()
        self._lapses: set[str] = set()
        """What people's code did wrong in this period where no outcome could tell it."""
        self._called: list[Order] = []
        """Orders of functions that the mission called, not ended yet."""
        self._ended_for = 0.0
        """Seconds since the mission ended in the air, or it was heard again after a silence,
        without those in which others are known to fly.
        """
        self._landing_asked = -inf
        self._descent = Descent()
        self._aside: Aside | None = None
        """The way to another place to land, where it did not stand; None while it lands."""
        self._noted = "alive", "mission"
        """Link and authority in the last records of them."""
        self._refusal = ""
        """The reason why the vehicle refused the last set-point; empty when it did not."""
        self._last: Setpoint = Hold()
        """The set-point commanded last, mission frame; Hold after a manoeuvre."""
        self._require(graph)

    def _located(self, graph: Graph, given: Mapping[str, Any]) -> dict[str, Any]:
        """The given parameters, and each that names a place of the world as the point of that."""
        found = dict(given)
        for name, parameter in graph.parameters.items():
            value = given.get(name, parameter.default)
            located = self.channel.frame.located(parameter.type, value)
            if located is not value:
                found[name] = located
        return found

    def _require(self, graph: Graph) -> None:
        """Refuse a mission that needs more than this vehicle can do. Raises UserError."""
        for capability, needed in graph.required().items():
            if capability not in self.vehicle.capabilities:
                model = (
                    f"the model '{self.vehicle.model}'" if self.vehicle.model else "this vehicle"
                )
                raise UserError(
                    "missing-capability",
                    f"'{needed.by}' needs '{capability}', which {model} does not have",
                    needed.where,
                    f"it has: {', '.join(sorted(self.vehicle.capabilities))}",
                )

    # -- the graph's host (see fsm.Host) ------------------------------------------------------

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> DroneActivity:
        """Start a behaviour for a state (see fsm.Host)."""
        if "motion" in behavior.controls:
            self.channel.order = None
        self._activate_camera(behavior, parameters)
        return DroneActivity(behavior, parameters, progress, self.channel, self._post, self._calls)

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> DroneActivity:
        """Go on with a behaviour of a saved run (see fsm.Host)."""
        if "motion" in behavior.controls:
            self.channel.order = None
        self._activate_camera(behavior, saved["with"])
        return DroneActivity.resumed(behavior, saved, self.channel, self._post, self._calls)

    def _activate_camera(self, behavior: BehaviorInfo, given: Mapping[str, Any]) -> None:
        """Make the camera that a behaviour needs the active one, where only one is."""
        known = {name: value for name, value in given.items() if value is not None}
        for word in (*behavior.requires, *behavior.named(known)):
            kind, _, name = word.partition(".")
            # One that is given in flight and is not there: the behaviour's start tells it.
            if kind == "camera" and word in self.vehicle.capabilities:
                self.channel.vehicle.use_camera(name)

    def _post(self, name: str, fields: Mapping[str, Any]) -> None:
        """Queue an event of a behaviour for the next period."""
        if name == "error.execution":
            self._lapses.add(fields["message"])
        self.instance.post(name, fields)

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Run a registered function (see fsm.Host)."""
        if name in HOST_FUNCTIONS:
            if self.instance.is_controlled(name):
                raise EvaluationError(f"a behaviour controls the {name} now")
            _, run = HOST_FUNCTIONS[name]
            order = run(self.channel, **arguments)
            if order is not None:
                self._called.append(order)
            return
        function = self.instance.graph.vocabulary.functions[name].implementation
        try:
            self._calls.run(lambda: function(**copied(dict(arguments))))
        except CodeFailed as error:
            self._lapses.add(str(error))
            raise EvaluationError(str(error)) from None

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        """Give an event to another vehicle of the fleet; where there is none, record it as
        undelivered (see fsm.Host).
        """
        if self.on_send is None:
            self.instance.record("undelivered", event=event, to=to)
        else:
            self.on_send(event, fields, to)

    # -- the period -------------------------------------------------------------------------

    @property
    def finished(self) -> bool:
        """True once the mission has ended and the vehicle has landed."""
        return self.outcome is not None and self._is_down()

    @property
    def manoeuvre(self) -> str:
        """The verb of the order that the vehicle flies in this period, for records; else empty."""
        order = self.landing or self.channel.order
        return "" if order is None or order.ended else order.verb

    def period(self, dt: float = PERIOD) -> None:
        """Run one mission period, ``dt`` seconds after the last one.

        Raises VehicleError when the vehicle cannot be brought down, or its link is gone.
        """
        seen = self.channel.observe(dt)
        self._note(seen)
        if self.outcome is None:
            if self._lapses:
                self._lapses.clear()
            if self._called:
                self._hear_of_called()
            for name, fields in self._watch.events(seen, dt):
                if name == "vehicle.late":
                    self.instance.record("late", **fields)
                self.instance.post(name, fields)
            self.instance.period(seen.time, (VehicleView(seen),))
            self._react()
            if self.instance.ended:
                self._end(self.instance.outcome or "failed")
        if seen.link == "gone" and self.landing is None:
            self.land_now("the link to the vehicle is gone", "failed")
        if self.outcome is not None:
            self._bring_down(dt)
        elif self.landing is None and not self.stands:
            self._command()

    def _hear_of_called(self) -> None:
        """Tell the mission which orders of its functions were refused or lost."""
        for order in self._called:
            if order.state in ("refused", "lost"):
                message = f"{order.verb}: {order.reason}"
                self.instance.post("error.execution", {"message": message, "where": "call"})
        self._called = [order for order in self._called if not order.ended]

    def _note(self, seen: Observation) -> None:
        """Record a jump of the world frame, and changes of link and authority."""
        self._note_jump()
        if self._noted == (seen.link, seen.authority):
            return
        link, authority = self._noted
        self._noted = seen.link, seen.authority
        if seen.link != link:
            self.instance.record("link", link=seen.link, age=round(seen.link_age, 3))
            if link in SILENT and seen.link not in SILENT:
                # It may not have heard of its landing before, which takes its time.
                self._ended_for = 0.0
        if seen.authority != authority:
            reason = seen.authority_reason or None
            self.instance.record("authority", authority=seen.authority, reason=reason)

    def _note_jump(self) -> None:
        jump = self.channel.jump
        if jump is not None:
            self.instance.record("jump", epoch=jump.epoch, offset=list(jump.offset))

    def abort(self) -> None:
        """Post ``operator.abort``, the operator's wish to stop; by default it lands the vehicle."""
        self.instance.post("operator.abort")

    def land_now(
        self, reason: str = "the operator asked to land", outcome: str = "aborted"
    ) -> None:
        """Land at once, outside the mission, which ends in ``outcome``."""
        if self.outcome is None:
            self.reason = reason
            self._end(outcome)
        if self.landing is None and not self._is_down():
            self._land()

    def _react(self) -> None:
        """Carry out the host's reaction to an event that no active state handled.

        It either ends the mission, which then holds, lands and fails, or suspends it and holds.
        """
        if not self.instance.reactions:
            return
        reactions, self.instance.reactions = self.instance.reactions, []
        reaction = self.instance.graph.vocabulary.reaction
        landing = [event for event in reactions if reaction(event[0]) == "land"]
        if not landing:
            self.instance.record("reaction", event=reactions[0][0], does="suspend")
            self.instance.suspend()
            return
        name, fields = landing[0]
        detail = fields.get("reason") or fields.get("message")
        self.reason = f"nothing handled {name}" + (f": {detail}" if detail else "")
        self.instance.record("reaction", event=name, does="land")
        self.instance.stop("aborted" if name.startswith("operator.") else "failed")

    def abandon(self, reason: str) -> None:
        """End the mission in the midst of its period, in ``failed``, and land: for a call into a
        person's code that does not return. Nothing of the mission may run any more, that call
        included: states are not left, behaviours not stopped.
        """
        if self.outcome is None:
            self.reason, self.outcome = reason, "failed"
            self.instance.abandon(self.outcome)
            self.instance.record("outcome", outcome=self.outcome, reason=reason)

    def _end(self, outcome: str) -> None:
        self.instance.stop(outcome)
        lapse = self._unheard_lapse()
        if lapse and not self.reason:
            outcome, self.reason = "failed", lapse
        self.outcome = outcome
        self.instance.record("outcome", outcome=outcome, reason=self.reason or None)

    def _unheard_lapse(self) -> str:
        """What people's code did wrong so late that no state could hear of it, if anything."""
        unheard = [event.fields["message"] for event in self.instance.waiting("error.execution")]
        return next((m for m in unheard if any(m.endswith(lapse) for lapse in self._lapses)), "")

    def _is_down(self) -> bool:
        """Whether it is known to stand with its motors off, and has no order to change that."""
        seen, order = self.channel.observation, self.channel.order
        rests = order is None or order.ended
        return rests and not (seen.flying or seen.armed or seen.link in SILENT)

    def _is_flown_by_others(self) -> bool:
        return self.channel.observation.authority in ("operator", "autopilot")

    def _bring_down(self, dt: float) -> None:
        """Hold, then land; order it again when it is refused or lost, or beside where it does not
        stand.
        """
        seen, landing = self.channel.observation, self.landing
        if self._is_down():
            return
        if seen.link == "gone" and landing is not None and landing.state != "sent":
            raise VehicleError(
                "link-gone",
                f"the link to '{self.vehicle.name}' is gone; a landing was ordered, and the "
                "vehicle is left to its own failsafe",
            )
        silent = seen.link in SILENT
        timeout = SILENCE_TIMEOUT if silent else LANDING_TIMEOUT
        if self._is_flown_by_others() and (not silent or self._ended_for <= timeout):
            # Whoever else flies it is not disturbed: orders of ours would end a failsafe.
            self._ended_for += dt if silent else 0.0
            return
        if self._ended_for > timeout:
            if landing is None:
                self._land()
            raise VehicleError("cannot-land", f"the vehicle did not land within {timeout:.0f} s")
        if landing is None and self._ended_for < HOLD_BEFORE_LANDING and seen.flying:
            self.channel.commanded = Hold()
            self.vehicle.command(Hold())
        elif landing is None or (not self._goes_aside(seen, landing) and self._may_ask(landing)):
            self._land()
        self._ended_for += dt

    def _goes_aside(self, seen: Observation, landing: Order) -> bool:
        """Fly to a place beside, to land there, if it does not stand where it came down."""
        if landing.state == "refused" and is_unstable(seen):
            self._aside = self._descent.aside(seen)
        if self._aside is None:
            self._descent.watch(seen)
            return False
        self.channel.setpoint = self._aside.step(seen)
        if self.channel.setpoint is None:
            self._aside = None
            return False
        self.channel.send()
        return True

    def _land(self) -> None:
        self.instance.record("landing", by="host")
        self._landing_asked = self.channel.now
        self.landing = self.vehicle.land()

    def _may_ask(self, landing: Order) -> bool:
        """Whether to order it again."""
        waited = self.channel.now - self._landing_asked
        return landing.state in ("refused", "lost") and waited >= LANDING_RETRY

    def _command(self) -> None:
        """Command the set-point of the behaviour in control; without one, hold."""
        channel = self.channel
        if channel.setpoint is not None:
            self._last = channel.setpoint
            reason = channel.send().reason
            if reason and reason != self._refusal:
                self.instance.record("refused", setpoint=type(self._last).__name__, reason=reason)
            self._refusal = reason
        elif self._manoeuvres():
            self._last = Hold()
        else:
            channel.setpoint = self._last = self._stay(self._last)
            channel.send()

    def _manoeuvres(self) -> bool:
        """Whether the vehicle flies a behaviour's order, or holds or stands after doing one."""
        order = self.channel.order
        if order is None or order.state in ("refused", "lost"):
            return False
        return order.state == "done" or self.instance.is_controlled("motion")

    def _stay(self, setpoint: Setpoint) -> Setpoint:
        """The set-point to hold once the behaviour that commanded ``setpoint`` has ended.

        A fixed position within STAY_WITHIN is held; otherwise the vehicle stops.
        """
        if not isinstance(setpoint, Position) or (setpoint.velocity or STILL) != STILL:
            return Hold()
        if distance(setpoint.xyz, self.channel.observation.position) > STAY_WITHIN:
            return Hold()
        return setpoint._replace(yaw_rate=None)


def save_flight(pilot: Pilot) -> dict[str, Any]:
    """The state of a flight at the end of a period, as JSON, without the vehicle's own state.

    Raises UserError (see fsm.engine.saving.save).
    """
    last = pilot._last
    return {
        **save(pilot.instance),
        "pilot": {
            "origin": pack(pilot.channel.frame.origin),
            "origin_shift": pack(pilot.channel.frame.origin_shift),
            "watch": pilot._watch.progress(),
            "rng": pack(pilot.channel.rng.getstate()),
            "last": pack([*last]) if isinstance(last, Position) else None,
            "outcome": pilot.outcome,
            "reason": pilot.reason,
            "ended_for": pilot._ended_for,
            "landing": pilot._landing_asked if pilot.landing else None,
        },
    }


def resume_flight(
    graph: Graph,
    vehicle: Vehicle,
    saved: Mapping[str, Any],
    *,
    places: Mapping[str, Point] | None = None,
    geographic: tuple[float, float, float] | None = None,
    ground_height: GroundHeight | None = None,
    thresholds: Thresholds | None = None,
) -> Pilot:
    """A pilot that continues a saved flight.

    Raises UserError (see fsm.engine.saving.restore).
    """
    known = saved.get("pilot")
    if not isinstance(known, Mapping) or known.keys() != SAVED:
        raise _torn()
    try:
        origin, origin_shift = unpack(known["origin"]), unpack(known["origin_shift"])
        frame = MissionFrame(origin, places, geographic, origin_shift, ground_height, graph.files)
        pilot = Pilot(graph, vehicle, frame=frame, thresholds=thresholds)
        _go_on(pilot, known)
    except TORN:
        raise _torn() from None
    load(pilot.instance, saved)
    # The world frame may have jumped since it was saved.
    pilot._note_jump()
    if known["landing"] is not None and not pilot._is_flown_by_others():
        # The vehicle is at it already: this gives the order back.
        pilot.landing = vehicle.land()
    return pilot


def _go_on(pilot: Pilot, known: Mapping[str, Any]) -> None:
    pilot._watch.go_on(known["watch"])
    pilot.channel.rng.setstate(unpack(known["rng"]))
    if known["last"] is not None:
        pilot._last = Position(*unpack(known["last"]))
    pilot.outcome, pilot.reason = known["outcome"], known["reason"]
    pilot._ended_for = known["ended_for"]
    if known["landing"] is not None:
        pilot._landing_asked = float(known["landing"])


def _torn() -> UserError:
    hint = "name a file of a flight, or start the mission anew"
    return UserError("torn-save", "this is no whole saved flight", hint=hint)
