"""Random charts, small enough to read, in which everything that appendix D speaks of occurs."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from tests.fsm.appendix_d.charts import Action, State, Transition
from tests.fsm.appendix_d.interpreter import EndlessError, Interpreter

EVENTS = ("e.a", "e.b", "f.a")
RAISED = ("r.a", "r.b")
MAX_DEPTH = 4
MAX_CALMED = 10
HISTORY = ("shallow", "deep")


def random_chart(seed: int, mission: bool) -> tuple[State, list[str]]:
    """A chart and the events to post; ``mission`` keeps to what the mission language can say.

    That is one target for initial and history transitions and no content in them; conditions on
    eventless transitions; `done` heard by its own state alone, and taken there in any case.
    """
    random = Random(seed)
    root = State("root", "compound", None)
    _Growth(random, random.randint(5, 18)).fill(root, 0)
    maker = _Maker(random, root, mission)
    for state in root.walk():
        maker.fill(state)
    if mission:
        # No state may be without a way out.
        over = State("over", "final", root)
        root.children.append(over)
        root.transitions.append(Transition(root, "go.over", [over], internal=True))
    events = [random.choice(EVENTS) for _ in range(random.randint(4, 12))]
    _calm(root, events)
    return root, events


def _calm(root: State, events: list[str]) -> None:
    """Take away what makes a macrostep endless; most charts would stop at one soon."""
    for _ in range(MAX_CALMED):
        running = Interpreter(root)
        try:
            running.start()
            for event in events:
                running.hear(event)
        except EndlessError:
            for transition in running.latest:
                transition.targets, transition.actions = [], []
                if not transition.events:
                    transition.source.transitions.remove(transition)
        else:
            return


class _Growth:
    """Grows states inside others."""

    def __init__(self, random: Random, left: int) -> None:
        self.random = random
        self.left = left
        """States that may still be added."""
        self.count = 0

    def fill(self, state: State, depth: int) -> None:
        parallel = state.kind == "parallel"
        for place in range(self.random.randint(2, 3)):
            self.add(state, self.kind(depth, parallel, parallel or not place), depth)
        if depth and self.random.random() < 0.5:
            state.children.insert(self.random.randint(0, 1), self.new(self.pick(HISTORY), state))

    def add(self, parent: State, kind: str, depth: int) -> None:
        child = self.new(kind, parent)
        parent.children.append(child)
        if kind in ("compound", "parallel"):
            self.fill(child, depth + 1)

    def new(self, kind: str, parent: State) -> State:
        self.count += 1
        self.left -= 1
        return State(f"s{self.count}", kind, parent)

    def kind(self, depth: int, region: bool, no_final: bool) -> str:
        if self.left > 0 and depth < MAX_DEPTH and self.random.random() < (0.9 if region else 0.5):
            return self.pick(("compound", "compound", "parallel"))
        final = not no_final and self.random.random() < (0.5 if depth else 0.1)
        return "final" if final else "atomic"

    def pick(self, kinds: tuple[str, ...]) -> str:
        return self.random.choice(kinds)


class _Maker:
    """Adds transitions and content to the states of a chart."""

    def __init__(self, random: Random, root: State, mission: bool) -> None:
        self.random = random
        self.root = root
        self.mission = mission
        self.states = [s for s in root.walk() if s is not root and not s.is_history]
        self.finishing = [s for s in self.states if _can_finish(s)] or self.states

    def fill(self, state: State) -> None:
        if state.is_history:
            around = state.parent
            assert around is not None
            state.default = self.default(state, around, lambda target: not target.is_history)
            return
        if state.kind == "compound":
            state.default = self.default(state, state, lambda target: True)
        if state is self.root:
            return
        state.onentry = self.content("in", state)
        if not self.mission or state.kind != "final":
            state.onexit = self.content("out", state)
        if state.kind != "final":
            state.transitions += [self.transition(state) for _ in range(self.random.randint(1, 4))]
            if self.mission:
                self.bring_in_order(state)

    def default(self, state: State, around: State, fit: Callable[[State], bool]) -> Transition:
        """An initial or a history's default transition."""
        targets = self.targets(around, fit)
        if self.mission or state is self.root:
            return Transition(state, "", targets[:1] if self.mission else targets)
        return Transition(state, "", targets, actions=self.content("default", state))

    def targets(self, around: State, fit: Callable[[State], bool] = lambda _: True) -> list[State]:
        """One state inside another, or several in regions of one parallel state."""
        state = self.random.choice([s for s in around.walk() if s is not around and fit(s)])
        if state.kind != "parallel" or self.random.random() < 0.4:
            return [state]
        regions = [child for child in state.children if not child.is_history]
        found: list[State] = []
        for region in self.random.sample(regions, self.random.randint(1, len(regions))):
            inside = any(s is not region and fit(s) for s in region.walk())
            found += (
                self.targets(region, fit) if inside and self.random.random() < 0.8 else [region]
            )
        return found

    def transition(self, state: State) -> Transition:
        events = self.events(state)
        condition = None
        if self.random.random() < (0.3 if events else 0.8) or (self.mission and not events):
            condition = (self.random.random() < 0.6, self.random.choice(self.states))
        targets = self.targets_of(state)
        internal = self.random.random() < 0.4
        if self.mission and not _may_be_internal(state, targets):
            internal = False
        actions = self.content("on", state)
        return Transition(state, events, targets, condition, internal, actions)

    def events(self, state: State) -> str:
        chance = self.random.random()
        if chance < 0.08:
            found = ""
        elif chance < 0.3:
            owner = state if self.mission else self.random.choice(self.finishing)
            found = f"done.state.{owner.id}"
        else:
            found = self.random.choice((*EVENTS, *RAISED, "e.*"))
        if not self.mission and self.random.random() < 0.1:
            found = self.random.choice(("*", "e", "e.a r", "done.state", "r.b f.*"))
        return found

    def targets_of(self, state: State) -> list[State]:
        """Where a transition leads: more often than by chance to a history around its state."""
        around = [place for place in (state, *state.ancestors) if place.children]
        histories = [child for place in around for child in place.children if child.is_history]
        if histories and self.random.random() < 0.2:
            return [self.random.choice(histories)]
        if self.random.random() < 0.85:
            return self.targets(self.random.choice([self.root, *around]))
        return []

    def content(self, word: str, state: State) -> list[Action]:
        found: list[Action] = []
        if self.random.random() < 0.7:
            asked = tuple(self.random.sample(self.states, min(3, len(self.states))))
            found.append(("log", f"{word} {state.id}", asked))
        if self.random.random() < 0.1:
            found.append(("raise", self.random.choice(RAISED), ()))
        return found

    def bring_in_order(self, state: State) -> None:
        """Make the transitions of a state such that a mission can have them."""
        own = f"done.state.{state.id}"
        can_finish = _can_finish(state)
        region = state.parent is not None and state.parent.kind == "parallel"
        found: dict[str, list[Transition]] = {}
        for each in state.transitions:
            if each.events != own or can_finish:
                found.setdefault(each.events, []).append(each)
        if own in found or (can_finish and not region):
            found.setdefault(own, []).append(Transition(state, own))
        if "e.*" in found:
            found["e.*"] = found.pop("e.*")
        state.transitions = [each for same in found.values() for each in _up_to_free(same)]


def _may_be_internal(source: State, targets: list[State]) -> bool:
    """Whether a mission may have such a transition without `reenter`."""
    return source.kind == "compound" and all(
        target.is_inside(source)
        or (target.is_history and around.kind == "compound" and source.is_inside(around))
        for target in targets
        if (around := target.parent) is not None
    )


def _up_to_free(alternatives: list[Transition]) -> list[Transition]:
    """Those up to the first without a condition, after which none is reached."""
    for place, each in enumerate(alternatives):
        if each.condition is None:
            return alternatives[: place + 1]
    return alternatives


def _can_finish(state: State) -> bool:
    if state.kind == "parallel":
        return all(_can_finish(child) for child in state.children if not child.is_history)
    return any(child.kind == "final" for child in state.children)
