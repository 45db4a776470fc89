"""An interpreter of statecharts, line by line after appendix D of the W3C recommendation of 2015.

It knows nothing of the engine that it is compared with. The appendix is informative; the text of
the recommendation decides where the two differ. That is so in two places, marked with its section.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator

from tests.fsm.appendix_d.charts import Action, State, Transition

MAX_STEPS = 40


class EndlessError(Exception):
    """A macrostep of more than MAX_STEPS events and microsteps."""


class Interpreter:
    """A running chart; ``trace`` tells what has happened so far."""

    def __init__(self, root: State) -> None:
        self.root = root
        self.order = {state: place for place, state in enumerate(root.walk())}
        self.configuration: set[State] = set()
        self.history: dict[State, list[State]] = {}
        self.queue: deque[tuple[str, State | None]] = deque()
        """Internal events, with the state that is done."""
        self.latest: list[Transition] = []
        """The transitions of the latest microstep."""
        self.running = True
        self.trace: list[str] = []

    def start(self) -> None:
        self.configuration.add(self.root)
        self.trace.append(f"enter {self.root.id}")
        assert self.root.default is not None
        self.enter_states([self.root.default])
        self.complete_macrostep()

    def hear(self, event: str) -> None:
        if not self.running:
            return
        self.take(event, self.select(event))
        self.complete_macrostep()

    def exit(self) -> None:
        for state in self.in_exit_order(self.configuration):
            self.leave(state)

    def complete_macrostep(self) -> None:
        for _ in range(MAX_STEPS):
            if not self.running:
                return
            enabled = self.select(None)
            if enabled:
                self.microstep(enabled)
            elif self.queue:
                event, _ = self.queue.popleft()
                self.take(event, self.select(event))
            else:
                return
        raise EndlessError

    def take(self, event: str, enabled: list[Transition]) -> None:
        self.trace.append(f"event {event}{'' if enabled else ' unheard'}")
        if enabled:
            self.microstep(enabled)

    # -- selection --------------------------------------------------------------------------

    def select(self, event: str | None) -> list[Transition]:
        enabled: list[Transition] = []
        for atomic in self.in_entry_order(filter(is_atomic, self.configuration)):
            for transition in (t for s in (atomic, *atomic.ancestors) for t in s.transitions):
                if self.is_enabled(transition, event):
                    if transition not in enabled:
                        enabled.append(transition)
                    break
        return self.without_conflicts(enabled)

    def is_enabled(self, transition: Transition, event: str | None) -> bool:
        if event is None:
            matches = not transition.events
        else:
            matches = any(name_match(each, event) for each in transition.events.split())
        return matches and self.passes(transition.condition)

    def passes(self, condition: tuple[bool, State] | None) -> bool:
        return condition is None or (condition[1] in self.configuration) == condition[0]

    def without_conflicts(self, enabled: list[Transition]) -> list[Transition]:
        filtered: list[Transition] = []
        for one in enabled:
            to_remove = []
            for other in filtered:
                if self.exit_set([one]) & self.exit_set([other]):
                    if not one.source.is_inside(other.source):
                        break
                    to_remove.append(other)
            else:
                filtered = [other for other in filtered if other not in to_remove] + [one]
        return filtered

    def domain(self, transition: Transition) -> State | None:
        targets, source = self.effective_targets(transition), transition.source
        if not targets:
            return None
        around = [source] if transition.internal else []
        for state in (*around, *source.ancestors):
            if state.kind == "compound" and all(target.is_inside(state) for target in targets):
                return state
        return self.root

    def effective_targets(self, transition: Transition) -> list[State]:
        found: list[State] = []
        for target in transition.targets:
            if not target.is_history:
                found.append(target)
            elif target in self.history:
                found += self.history[target]
            elif target.default is not None:
                found += self.effective_targets(target.default)
        return found

    # -- microsteps -------------------------------------------------------------------------

    def microstep(self, enabled: list[Transition]) -> None:
        self.latest = enabled
        leaving = self.in_exit_order(self.exit_set(enabled))
        for state in leaving:
            for history in state.children:
                if history.kind == "deep":
                    held = [s for s in self.configuration if is_atomic(s) and s.is_inside(state)]
                    self.history[history] = self.in_entry_order(held)
                elif history.kind == "shallow":
                    held = [s for s in self.configuration if s.parent is state]
                    self.history[history] = self.in_entry_order(held)
        for state in leaving:
            self.leave(state)
        for transition in enabled:
            targets = " ".join(target.id for target in transition.targets)
            name = transition.events or "always"
            self.trace.append(f"{transition.source.id} -> {targets} by {name}")
            self.execute(transition.actions)
        self.enter_states(enabled)

    def exit_set(self, transitions: Iterable[Transition]) -> set[State]:
        found: set[State] = set()
        for transition in transitions:
            domain = self.domain(transition)
            if domain is not None:
                found |= {state for state in self.configuration if state.is_inside(domain)}
        return found

    def leave(self, state: State) -> None:
        self.execute(state.onexit)
        self.configuration.remove(state)
        self.trace.append(f"exit {state.id}")

    def enter_states(self, enabled: list[Transition]) -> None:
        entry = EntrySet(self)
        for transition in enabled:
            entry.add(transition)
        for state in self.in_entry_order(entry.states):
            self.configuration.add(state)
            self.trace.append(f"enter {state.id}")
            self.execute(state.onentry)
            if state in entry.defaults and state.default is not None:
                self.execute(state.default.actions)
            self.execute(entry.history_content.get(state, []))
            if state.kind == "final":
                self.finish(state)

    def finish(self, final: State) -> None:
        parent = final.parent
        assert parent is not None
        if parent is self.root:
            self.running = False
            return
        self.done(parent)
        # Section 3.4: every parallel state whose children have finished, not only the inner one.
        around = parent.parent
        while around is not None and around.kind == "parallel" and self.is_in_final(around):
            self.done(around)
            around = around.parent

    def done(self, state: State) -> None:
        self.queue.append((f"done.state.{state.id}", state))

    def is_in_final(self, state: State) -> bool:
        if state.kind == "compound":
            return any(c.kind == "final" and c in self.configuration for c in state.children)
        return state.kind == "parallel" and all(map(self.is_in_final, regions(state)))

    def execute(self, actions: Iterable[Action]) -> None:
        for kind, text, states in actions:
            if kind == "raise":
                self.queue.append((text, None))
            else:
                told = "".join(str(int(state in self.configuration)) for state in states)
                self.trace.append(f"log {text} {told}")

    def in_entry_order(self, states: Iterable[State]) -> list[State]:
        return sorted(states, key=lambda state: self.order[state])

    def in_exit_order(self, states: Iterable[State]) -> list[State]:
        return self.in_entry_order(states)[::-1]


class EntrySet:
    """The states that transitions enter, and whose default content is to be executed."""

    def __init__(self, running: Interpreter) -> None:
        self.running = running
        self.states: set[State] = set()
        self.defaults: set[State] = set()
        self.history_content: dict[State, list[Action]] = {}

    def add(self, transition: Transition) -> None:
        domain = self.running.domain(transition)
        if domain is not None:
            self.domain = domain
            for target in transition.targets:
                self.add_descendants(target)
            for target in self.running.effective_targets(transition):
                self.add_ancestors(target, domain)

    def add_all(self, states: list[State], around: State) -> None:
        for state in states:
            self.add_descendants(state)
        for state in states:
            self.add_ancestors(state, around)

    def add_descendants(self, state: State) -> None:
        if state.is_history:
            assert state.parent is not None and state.default is not None
            if state in self.running.history:
                self.add_all(self.running.history[state], state.parent)
            else:
                self.history_content[state.parent] = state.default.actions
                self.add_all(state.default.targets, state.parent)
            return
        self.states.add(state)
        if state.kind == "compound" and state.default is not None:
            self.defaults.add(state)
            self.add_all(state.default.targets, state)
        elif state.kind == "parallel":
            self.add_regions(state)

    def add_ancestors(self, state: State, end: State) -> None:
        for ancestor in state.ancestors:
            if ancestor is end:
                return
            # Section 3.13: what is active and is not left is not entered.
            if not ancestor.is_inside(self.domain):
                return
            self.states.add(ancestor)
            if ancestor.kind == "parallel":
                self.add_regions(ancestor)

    def add_regions(self, parallel: State) -> None:
        for region in regions(parallel):
            if not any(state.is_inside(region) for state in self.states):
                self.add_descendants(region)


def is_atomic(state: State) -> bool:
    return state.kind in ("atomic", "final")


def regions(parallel: State) -> Iterator[State]:
    return (child for child in parallel.children if not child.is_history)


def name_match(descriptor: str, event: str) -> bool:
    tokens = descriptor.removesuffix("*").removesuffix(".").split(".")
    return tokens == [""] or event.split(".")[: len(tokens)] == tokens
