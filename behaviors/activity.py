"""A running behaviour: the values of the graph become a Behavior object's parameters, and back."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.calls import Calls, CodeFailed, place_of_function
from behaviors.channel import Channel
from behaviors.flight import Flight, NotInControl
from fsm.host import BehaviorInfo, Outcome
from fsm.values.functions import EvaluationError
from fsm.values.intake import admitted, admitted_fields, copied, kind_of, record_reader
from fsm.values.types import TEXT
from hal.vehicle import Observation

Post = Callable[[str, Mapping[str, Any]], None]
FAILED_FIELDS = {"reason": TEXT}


class DroneActivity:
    """Runs one Behavior; what its code raises or returns wrongly becomes the outcome ``failed``.

    Once its state is being left there is no outcome any more: then it is ``error.execution``.
    """

    def __init__(
        self,
        info: BehaviorInfo,
        values: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
        channel: Channel,
        post: Post,
        calls: Calls | None = None,
        start: Observation | None = None,
    ) -> None:
        """``start``: the observation that relative points count from, by default the present."""
        self.info = info
        self.published: Any = info.blank
        self.failure: Outcome | None = None
        self._channel = channel
        self._flight = Flight(channel, info.controls, self._raise, self._publish)
        self._post = post
        self._calls = calls or Calls()
        self._read_record = record_reader(info.publishes)
        self._publishes = getattr(info.implementation, "publishes", None)
        self._start = start or channel.observation
        self._behavior: Behavior | None = None
        self._untold = ""
        """The reason why its progress could not be told, until the graph has heard it."""
        self._being_stopped = False
        self._over = False
        """Whether its ``stop`` has returned."""
        given = self._given = {name: p.default for name, p in info.parameters.items()}
        given.update({name: value for name, value in values.items() if value is not None})
        missing = [n for n, p in info.parameters.items() if p.required and given[n] is None]
        if missing:
            self.failure = _failed(f"the parameter '{missing[0]}' has no value")
            return
        try:
            self._calls.run(self._begin, progress)
        except CodeFailed as error:
            self.failure = _failed(str(error))

    @classmethod
    def resumed(
        cls,
        info: BehaviorInfo,
        saved: Mapping[str, Any],
        channel: Channel,
        post: Post,
        calls: Calls | None = None,
    ) -> DroneActivity:
        """Continue from a saved activity; relative points stay where they were."""
        position, yaw = saved["start"]
        start = channel.observation._replace(position=position, yaw=yaw)
        activity = cls(info, saved["with"], saved["progress"], channel, post, calls, start)
        activity.published = saved["published"]
        return activity

    def saved(self) -> Mapping[str, Any]:
        """See fsm.Activity: the parameters as given, the pose they count from, and the progress."""
        return {
            "with": self._given,
            "start": [self._start.position, self._start.yaw],
            "progress": self.progress(),
            "published": self.published,
        }

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        if self.failure is not None:
            self._untold = ""
            return self.failure
        run: Any = self._calls.run
        behavior: Any = self._behavior
        try:
            if live:
                run(self._refresh, live)
            ended = run(behavior.step, self._flight)
            return None if ended is None else run(self._outcome, ended)
        except CodeFailed as error:
            return _failed(str(error))

    def progress(self) -> Mapping[str, Any] | None:
        """See fsm.Activity. When it cannot be told the behaviour has failed, and starts anew."""
        if self._behavior is None or self.failure is not None:
            return None
        self._flight.may_command = False
        try:
            return self._calls.run(self._progress)
        except CodeFailed as error:
            self._untold = str(error)
            self.failure = _failed(self._untold)
            return None
        finally:
            self._flight.may_command = not self._being_stopped

    def stop(self) -> None:
        if self._behavior is None or self._being_stopped:
            return
        self._being_stopped, self._flight.may_command = True, False
        if self._untold:
            self._lapse(self._untold)
        try:
            self._calls.run(self._stop)
        except CodeFailed as error:
            self._lapse(str(error))
        self._over = True

    # -- inside the guard: everything that runs or looks at a person's code --------------------

    def _begin(self, progress: Mapping[str, Any] | None) -> None:
        class_ = self.info.implementation
        self._behavior = class_(class_.Params(**self._resolve(self._given)))
        self._behavior.start(self._flight, None if progress is None else copied(progress))

    def _refresh(self, live: Mapping[str, Any]) -> None:
        behavior: Any = self._behavior
        for name, value in self._resolve(live).items():
            # A parameter without a value now, such as the place of something unseen, stays.
            if value is not None:
                self._given[name] = live[name]
                setattr(behavior.params, name, value)

    def _progress(self) -> Mapping[str, Any] | None:
        behavior: Any = self._behavior
        progress = behavior.progress()
        if progress is not None and not isinstance(progress, Mapping):
            told = f"`progress` returned {kind_of(progress)}: return a map, or None for none"
            raise self._mistake("progress", told)
        try:
            admitted_progress: Mapping[str, Any] | None = admitted(progress)
        except EvaluationError as error:
            told = f"what `progress` returned cannot be kept: {error}"
            raise self._mistake("progress", told) from None
        return admitted_progress

    def _stop(self) -> None:
        behavior: Any = self._behavior
        behavior.stop(self._flight)

    def _outcome(self, ended: Any) -> Outcome:
        """What ``step`` returned, as an outcome that the behaviour declares."""
        if isinstance(ended, str):
            ended = Outcome(ended)
        if not isinstance(ended, Outcome):
            if inspect.isgenerator(ended) or inspect.iscoroutine(ended):
                ended.close()
            told = f"`step` returned {kind_of(ended)}: return None, a word or an Outcome"
            raise self._mistake("step", told)
        known = {"failed": FAILED_FIELDS, **self.info.outcomes}
        if not isinstance(ended.word, str) or ended.word not in known:
            told = f"{self.info.name} ended in {ended.word!r:.40}, which it does not declare"
            raise self._mistake("step", told)
        word = str(ended.word)
        try:
            fields = admitted_fields(_as_fields(ended.fields), known[word])
            if word == "failed":
                fields.setdefault("reason", f"{self.info.name} gives no reason")
            return Outcome(word, fields)
        except (EvaluationError, TypeError) as error:
            raise self._mistake("step", f"the fields of its '{word}' are wrong: {error}") from None

    def _mistake(self, method: str, message: str) -> CodeFailed:
        """The failure of a method that came to its end, with the line in which it begins."""
        return CodeFailed(message, place_of_function(getattr(self._behavior, method)))

    def _raise(self, name: str, record: Any) -> None:
        if self._over:
            raise NotInControl("a behaviour that was stopped raises no events")
        if name not in self.info.events:
            raise ValueError(f"{self.info.name} declares no event '{name}'")
        try:
            fields = admitted_fields(_as_fields(record), self.info.events[name])
        except EvaluationError as error:
            raise ValueError(f"the fields of '{name}' are wrong: {error}") from None
        self._post(name, fields)

    def _publish(self, record: Any) -> None:
        if self._over:
            raise NotInControl("a behaviour that was stopped publishes nothing")
        declared = self._publishes
        if declared is None or not isinstance(record, declared):
            known = "nothing" if declared is None else f"a {declared.__name__}"
            raise TypeError(f"{self.info.name} publishes {known}, not {kind_of(record)}")
        try:
            self.published = self._read_record(record)
        except EvaluationError as error:
            raise ValueError(f"what {self.info.name} publishes is wrong: {error}") from None

    # ------------------------------------------------------------------------------------------

    def _resolve(self, values: Mapping[str, Any]) -> dict[str, Any]:
        frame, parameters = self._channel.frame, self.info.parameters
        return {
            name: copied(frame.resolve(parameters[name].type, value, self._start))
            for name, value in values.items()
        }

    def _lapse(self, message: str) -> None:
        self._post("error.execution", {"message": message, "where": self.info.name})


def _as_fields(record: Any) -> Mapping[str, Any]:
    """The fields of a record or a map. Raises TypeError for anything else."""
    if record is None:
        return {}
    if dataclasses.is_dataclass(record) and not isinstance(record, type):
        return {f.name: getattr(record, f.name) for f in dataclasses.fields(record)}
    if not isinstance(record, Mapping):
        raise TypeError(f"fields stand in a record or a map, not in {kind_of(record)}")
    return record


def _failed(reason: str) -> Outcome:
    return Outcome("failed", {"reason": reason})
