"""Random missions that compile, for comparing the safety proof with all their flights."""

from __future__ import annotations

from random import Random
from typing import Any

import yaml

from fsm import Graph
from tests.fsm.exhaustive import MUST_LAND, VOCABULARY
from tests.fsm.toy import graph_of
from vencejo.errors import UserError

MOVES = ("goto", "goto", "hover", "hover", "land", "land", "takeoff", "wait", "look", "")
GUARDS = ("see.a", "see.b", "see.a", "see.b", "1 > 2", "1 < 2")
CONDITIONS = ("see.c", "see.c", "not see.c", "1 < 2", "1 > 2")
State = dict[str, Any]


def random_mission(seed: int) -> tuple[str, Graph]:
    """A mission that compiles, as text and as graph: the first of the seed's drafts that does."""
    rng = Random(seed)
    while True:
        text = yaml.safe_dump(_Draft(rng).mission(), sort_keys=False, width=200)
        try:
            return text, graph_of(text, VOCABULARY)
        except UserError:
            continue


class _Draft:
    """A mission in the making: first its states, then transitions between them."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.places: list[str] = []
        """The paths of all states but the final ones of the mission."""
        self.raises = rng.random() < 0.25
        self.has_history = rng.random() < 0.3

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    def mission(self) -> State:
        states: State = {"up": {"do": "takeoff"}}
        self.places.append("up")
        for index in range(self.rng.randint(1, 4)):
            states[f"s{index}"] = self.state(f"s{index}", 0)
        states["land"] = {"do": "land", "on": {"done": "finish"}}
        self.places.append("land")
        states["finish"] = {"type": "final"}
        for name, state in states.items():
            if name not in ("land", "finish"):
                self.join(state, "")
        if self.chance(0.1):
            states["land"]["on"]["failed"] = self.target()
        mission: State = {"mission": "m", "states": states}
        if self.chance(0.2):
            mission["on"] = {self.rng.choice((MUST_LAND, "failed")): self.target()}
        return mission | ({"priority": "outer"} if self.chance(0.15) else {})

    # -- states -------------------------------------------------------------------------------

    def state(self, path: str, depth: int) -> State:
        self.places.append(path)
        kind = self.rng.random()
        if depth < 2 and kind < 0.18:
            regions = {f"r{n}": self.state(f"{path}.r{n}", depth + 1) for n in range(2)}
            return {"type": "parallel", "states": regions}
        if depth < 2 and kind < 0.4:
            return self.compound(path, depth)
        do = self.rng.choice(MOVES)
        return {"do": do} if do else {}

    def compound(self, path: str, depth: int) -> State:
        names = [f"t{n}" for n in range(self.rng.randint(1, 2 + (depth == 0)))]
        states = {name: self.state(f"{path}.{name}", depth + 1) for name in names}
        if self.chance(0.4):
            states["f"] = {"type": "final"}
            self.places.append(f"{path}.f")
        if self.has_history and self.chance(0.6):
            deep = self.chance(0.5)
            states["h"] = {"type": "history", "deep": deep, "target": self.rng.choice(names)}
            self.places += [f"{path}.h"] * 3
        return {"states": states}

    # -- transitions --------------------------------------------------------------------------

    def target(self) -> str:
        if self.chance(0.25):
            return "land"
        return "finish" if self.chance(0.06) else self.rng.choice(self.places)

    def transition(self, guarded: float = 0.25) -> Any:
        if self.chance(guarded):
            first = {"guard": self.rng.choice(GUARDS), "target": self.target()}
            return [first, self.transition(0.0)] if self.chance(0.6) else first
        if self.chance(0.06):
            return {}
        if self.raises and self.chance(0.3):
            return {"target": self.target(), "actions": self.action()}
        return {"target": self.target(), "reenter": True} if self.chance(0.15) else self.target()

    def action(self) -> State:
        if self.chance(0.15):
            return {"send": {"event": "own.word", **({"delay": "5 s"} if self.chance(0.5) else {})}}
        return {"raise": "own.word"}

    def join(self, state: State, around: str) -> None:
        """Give a state, and those inside it, transitions."""
        if state.get("type") in ("final", "history"):
            return
        for name, inner in state.get("states", {}).items():
            self.join(inner, f"{around}{name}.")
        on = {**self.outcomes(state), **self.events()}
        if on:
            state["on"] = {event: _flat(value) for event, value in on.items()}
        for key, share in (("after", 0.35), ("when", 0.2), ("always", 0.07)):
            if self.chance(share):
                state[key] = self.waiting(key)
        if self.raises and self.chance(0.15):
            state[self.rng.choice(("entry", "exit"))] = self.action()

    def outcomes(self, state: State) -> State:
        """Transitions for the outcomes that a state may have."""
        on: State = {}
        if "states" in state:
            on.update({"done": self.transition(0.1)} if self.chance(0.6) else {})
        elif state.get("do") in ("goto", "takeoff", "land", "wait"):
            on["done"] = [self.transition(0.1)]
            if state["do"] == "goto":
                on["blocked"] = self.target()
        return on | ({"failed": self.transition()} if self.chance(0.12) else {})

    def events(self) -> State:
        """Transitions for some events."""
        shares = {"go.now": 0.2, "tag.seen": 0.1, "own.word": 0.5 * self.raises, "*": 0.03}
        return {
            event: self.transition()
            for event, share in {MUST_LAND: 0.55, **shares}.items()
            if self.chance(share)
        }

    def waiting(self, key: str) -> Any:
        """A timer, a condition, or what is taken at once."""
        if key == "after":
            return {"5 s": self.transition(0.2)}
        if key == "when":
            return {self.rng.choice(CONDITIONS): self.transition(0.15)}
        return self.transition(0.7)


def _flat(value: Any) -> Any:
    """A list of alternatives without lists inside."""
    if not isinstance(value, list):
        return value
    flat = [each for part in value for each in (part if isinstance(part, list) else [part])]
    return flat if len(flat) > 1 else flat[0]
