"""A running behaviour: the values of the graph become a Behavior object's parameters, and back."""

from __future__ import annotations

import dataclasses
import traceback
from collections.abc import Callable, Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.channel import Channel
from behaviors.flight import Flight
from fsm.host import BehaviorInfo, Outcome
from fsm.values.functions import EvaluationError
from hal.vehicle import Observation

Post = Callable[[str, Mapping[str, Any]], None]


class DroneActivity:
    """Runs one Behavior; whatever it raises becomes the outcome ``failed``."""

    def __init__(
        self,
        info: BehaviorInfo,
        values: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
        channel: Channel,
        post: Post,
        start: Observation | None = None,
    ) -> None:
        """``start``: the observation that relative points count from, by default the present."""
        self.info = info
        self.published: Any = info.blank
        self.failure: Outcome | None = None
        self._channel = channel
        self._flight = Flight(channel, info.controls, self._raise, self._publish)
        self._post = post
        self._start = start or channel.observation
        self._behavior: Behavior | None = None
        self._stopped = False
        given = self._given = {name: p.default for name, p in info.parameters.items()}
        given.update({name: value for name, value in values.items() if value is not None})
        missing = [n for n, p in info.parameters.items() if p.required and given[n] is None]
        if missing:
            self.failure = _failed(f"the parameter '{missing[0]}' has no value")
            return
        try:
            self._behavior = info.implementation(info.implementation.Params(**self._resolve(given)))
            self._behavior.start(self._flight, progress)
        except Exception as error:
            self.failure = _failed(story(error))

    @classmethod
    def resumed(
        cls, info: BehaviorInfo, saved: Mapping[str, Any], channel: Channel, post: Post
    ) -> DroneActivity:
        """Continue from a saved activity; relative points stay where they were."""
        position, yaw = saved["start"]
        start = channel.observation._replace(position=position, yaw=yaw)
        activity = cls(info, saved["with"], saved["progress"], channel, post, start)
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

    def _resolve(self, values: Mapping[str, Any]) -> dict[str, Any]:
        frame, parameters = self._channel.frame, self.info.parameters
        return {
            name: frame.resolve(parameters[name].type, value, self._start)
            for name, value in values.items()
        }

    def _raise(self, name: str, record: Any) -> None:
        if name not in self.info.events:
            raise ValueError(f"{self.info.name} declares no event '{name}'")
        self._post(name, _as_fields(record))

    def _publish(self, record: Any) -> None:
        self.published = record

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        if self.failure is not None or self._behavior is None:
            return self.failure
        try:
            for name, value in self._resolve(live).items() if live else ():
                # A parameter without a value now, such as the place of something unseen, stays.
                if value is not None:
                    self._given[name] = live[name]
                    setattr(self._behavior.params, name, value)
            ended = self._behavior.step(self._flight)
        except Exception as error:
            return _failed(story(error))
        if ended is None:
            return None
        outcome = Outcome(ended) if isinstance(ended, str) else ended
        if outcome.word not in self.info.outcomes and outcome.word != "failed":
            return _failed(f"{self.info.name} ended in '{outcome.word}', which it does not declare")
        return outcome

    def progress(self) -> Mapping[str, Any] | None:
        if self._behavior is None or self.failure is not None:
            return None
        self._flight.may_command = False
        try:
            return self._behavior.progress()
        except Exception:
            # Without progress it starts anew; an error here is no reason to end the flight.
            return None
        finally:
            self._flight.may_command = not self._stopped

    def stop(self) -> None:
        if self._behavior is None or self._stopped:
            return
        self._stopped, self._flight.may_command = True, False
        try:
            self._behavior.stop(self._flight)
        except Exception as error:
            self._post("error.execution", {"message": story(error), "where": self.info.name})


def _as_fields(record: Any) -> dict[str, Any]:
    if record is None:
        return {}
    if dataclasses.is_dataclass(record):
        return {f.name: getattr(record, f.name) for f in dataclasses.fields(record)}
    return dict(record)


def _failed(reason: str) -> Outcome:
    return Outcome("failed", {"reason": reason})


def story(error: Exception) -> str:
    """Describe an error, with the file and line it was raised at but no path of this machine."""
    if isinstance(error, EvaluationError):
        return str(error)
    frames = traceback.extract_tb(error.__traceback__)
    last = frames[-1] if frames else None
    place = f" ({last.filename.rsplit('/', 1)[-1]}:{last.lineno})" if last else ""
    return f"{type(error).__name__}: {error}{place}"
