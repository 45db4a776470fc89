"""The pilot: flies one graph on one vehicle, a mission period at a time.

It joins what fsm and hal each leave open: observes, posts urgent events, lets the graph take its
period, and commands the vehicle. Authority is in this order: the operator and safety (a landing
past the mission), then the mission; where nobody commands, the vehicle holds its place. When the
mission ends, in whatever way, the vehicle is landed.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from behaviors.activity import DroneActivity, story
from behaviors.flight import Flight, MissionFrame
from behaviors.vocabulary import VehicleView
from behaviors.watch import Thresholds, Watch
from fsm.chart.graph import Graph
from fsm.engine.instance import Instance
from fsm.host import BehaviorInfo
from fsm.values.functions import EvaluationError
from hal.vehicle import Hold, Order, Position, Setpoint, Vehicle
from vencejo.errors import UserError, VehicleError
from vencejo.geometry import Point, distance
from vencejo.seeds import generator

HOLD_BEFORE_LANDING = 1.0
"""Seconds the vehicle comes to rest for, when a mission ends in the air."""
LANDING_TIMEOUT = 300.0
"""Seconds (vehicle's clock) within which any landing must have ended."""
LANDING_RETRY = 1.0
"""Seconds after which a refused landing is asked for again."""
STAY_WITHIN = 1.0
"""Metres within which a place that was commanded is held, rather than where the vehicle stops."""
STILL = Point(0.0, 0.0, 0.0)


class Pilot:
    """One vehicle with the mission it flies. ``period`` after every ``session.wait``."""

    def __init__(
        self,
        graph: Graph,
        vehicle: Vehicle,
        parameters: Mapping[str, Any] | None = None,
        *,
        frame: MissionFrame | None = None,
        seed: int = 0,
        thresholds: Thresholds | None = None,
    ) -> None:
        self.vehicle = vehicle
        self.flight = Flight(
            vehicle,
            frame or MissionFrame(vehicle.observe().position),
            generator(seed, vehicle.name, "behaviours"),
        )
        self.instance = Instance(graph, self, parameters)
        self.landing: Order | None = None
        """The landing past the mission, once it has begun."""
        self.reason = ""
        """Why the mission was ended from outside; empty when it ended by itself."""
        self.outcome: str | None = None
        self._watch = Watch(thresholds or Thresholds())
        self._ended_at: float | None = None
        self._landing_asked = -inf
        self._last: Setpoint = Hold()
        """What was commanded last, mission frame."""
        self._require(graph)

    def _require(self, graph: Graph) -> None:
        """Refuse, before take-off, what this vehicle cannot do. Raises UserError."""
        for capability, node in graph.required().items():
            if capability not in self.vehicle.capabilities:
                behavior = node.invocation.behavior.name if node.invocation else ""
                raise UserError(
                    "missing-capability",
                    f"'{behavior}' needs '{capability}', which this vehicle does not have",
                    node.where,
                    f"it has: {', '.join(sorted(self.vehicle.capabilities))}",
                )

    # -- Host: what the graph asks for ------------------------------------------------------

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> DroneActivity:
        """Start a behaviour for a state (see fsm.Host)."""
        if "motion" in behavior.controls:
            self.flight.order = None
        return DroneActivity(behavior, parameters, progress, self.flight, self.instance.post)

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> DroneActivity:
        """Go on with a behaviour of a saved run (see fsm.Host)."""
        if "motion" in behavior.controls:
            self.flight.order = None
        return DroneActivity.resumed(behavior, saved, self.flight, self.instance.post)

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Run a registered function (see fsm.Host)."""
        try:
            self.instance.graph.vocabulary.functions[name].implementation(**arguments)
        except Exception as error:
            raise EvaluationError(story(error)) from error

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        """Give an event to another vehicle (see fsm.Host); this one flies alone."""
        self.instance.record("undelivered", event=event, to=to)

    # -- the period -------------------------------------------------------------------------

    @property
    def finished(self) -> bool:
        """Whether the mission has ended and the vehicle is down."""
        return self.outcome is not None and self._is_down()

    def period(self) -> None:
        """One mission period. Raises VehicleError when the vehicle cannot be brought down."""
        seen = self.flight.observe()
        if self.outcome is None:
            for name, fields in self._watch.events(seen):
                self.instance.post(name, fields)
            self.instance.period(seen.time, (VehicleView(seen),))
            self._react()
            if self.instance.ended:
                self._end(self.instance.outcome or "failed")
        if self.outcome is not None:
            self._bring_down()
        elif self.landing is None:
            self._command()

    def abort(self) -> None:
        """The operator asks to stop: ``operator.abort``, whose default is to land."""
        self.instance.post("operator.abort")

    def land_now(self, reason: str = "the operator asked to land") -> None:
        """Land at once, past the mission."""
        if self.outcome is None:
            self.reason = reason
            self._end("aborted")
        if self.landing is None and not self._is_down():
            self._land()

    def _react(self) -> None:
        """The host's own reaction to what no active state handled.

        Hold, land and ``failed``; or suspend the mission, and hold.
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

    def _end(self, outcome: str) -> None:
        self.outcome = outcome
        self.instance.stop(outcome)
        self._ended_at = self.flight.now
        self.instance.record("outcome", outcome=outcome, reason=self.reason or None)

    def _is_down(self) -> bool:
        seen = self.flight.observation
        return not seen.flying and not seen.armed

    def _bring_down(self) -> None:
        if self._is_down():
            return
        assert self._ended_at is not None
        waited = self.flight.now - self._ended_at
        if waited > LANDING_TIMEOUT:
            raise VehicleError(
                "cannot-land", f"the vehicle did not land within {LANDING_TIMEOUT:.0f} s"
            )
        if self.landing is None and waited < HOLD_BEFORE_LANDING and self.flight.observation.flying:
            self.vehicle.command(Hold())
        elif self.landing is None or (self.landing.state == "refused" and self._may_ask_again()):
            self._land()

    def _land(self) -> None:
        self.instance.record("landing", by="host")
        self._landing_asked = self.flight.now
        self.landing = self.vehicle.land()

    def _may_ask_again(self) -> bool:
        return self.flight.now - self._landing_asked >= LANDING_RETRY

    def _command(self) -> None:
        """The set-point of the behaviour in control; without one, hold: nothing stays latched."""
        flight = self.flight
        if flight.setpoint is not None:
            self._last = flight.setpoint
        elif self._manoeuvres():
            self._last = Hold()
            return
        else:
            flight.setpoint = self._last = self._stay(self._last)
        flight.send()

    def _manoeuvres(self) -> bool:
        """Whether the vehicle flies by itself: on the order of a behaviour, or because it has
        carried one out, and so holds its place or stands on the ground.
        """
        order = self.flight.order
        if order is None or order.state == "refused":
            return False
        return order.state == "done" or self.instance.is_controlled("motion")

    def _stay(self, setpoint: Setpoint) -> Setpoint:
        """What is held once nobody commands this any more.

        A near place to be at rest in is kept; from all that moves the vehicle comes to rest.
        """
        if not isinstance(setpoint, Position) or (setpoint.velocity or STILL) != STILL:
            return Hold()
        if distance(setpoint.xyz, self.flight.observation.position) > STAY_WITHIN:
            return Hold()
        return setpoint._replace(yaw_rate=None)
