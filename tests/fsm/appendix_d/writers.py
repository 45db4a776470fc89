"""Charts written as SCXML documents and as missions."""

from __future__ import annotations

from typing import Any
from xml.sax.saxutils import quoteattr

import yaml

from tests.fsm.appendix_d.charts import Action, State, Transition

SCXML = '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript"'


def scxml_of(root: State) -> str:
    lines = [f"{SCXML}{_initial(root)}>"]
    for child in root.children:
        lines += _scxml(child, "  ")
    return "\n".join([*lines, "</scxml>"]) + "\n"


def _initial(state: State) -> str:
    if state.kind != "compound" or state.default is None or state.default.actions:
        return ""
    return f' initial="{_ids(state.default.targets)}"'


def _ids(states: list[State]) -> str:
    return " ".join(state.id for state in states)


def _scxml(state: State, indent: str) -> list[str]:
    tag, kind = {
        "atomic": ("state", ""),
        "compound": ("state", ""),
        "shallow": ("history", ' type="shallow"'),
        "deep": ("history", ' type="deep"'),
    }.get(state.kind, (state.kind, ""))
    lines = [f'{indent}<{tag} id="{state.id}"{kind}{_initial(state)}>']
    inner = indent + "  "
    for name, actions in (("onentry", state.onentry), ("onexit", state.onexit)):
        if actions:
            lines.append(f"{inner}<{name}>{_actions(actions)}</{name}>")
    if state.default is not None and not _initial(state):
        default = _transition(state.default)
        lines.append(inner + (default if state.is_history else f"<initial>{default}</initial>"))
    lines += [inner + _transition(transition) for transition in state.transitions]
    for child in state.children:
        lines += _scxml(child, inner)
    return [*lines, f"{indent}</{tag}>"]


def _transition(transition: Transition) -> str:
    text = "<transition"
    if transition.events:
        text += f' event="{transition.events}"'
    if transition.condition is not None:
        value, state = transition.condition
        text += f""" cond="{"" if value else "!"}In('{state.id}')\""""
    if transition.targets:
        text += f' target="{_ids(transition.targets)}"'
    if transition.internal:
        text += ' type="internal"'
    return f"{text}>{_actions(transition.actions)}</transition>"


def _actions(actions: list[Action]) -> str:
    return "".join(map(_action, actions))


def _action(action: Action) -> str:
    kind, text, states = action
    if kind == "raise":
        return f'<raise event="{text}"/>'
    asked = "".join(f" + (In('{state.id}') ? 1 : 0)" for state in states)
    return f"<log expr={quoteattr(repr(text + ' ') + asked)}/>"


def mission_of(root: State) -> str:
    document = {
        "mission": "chart",
        "events": {name: {} for name in ("e.a", "e.b", "f.a", "r.a", "r.b", "go.over")},
        **_body(root),
    }
    return yaml.safe_dump(document, sort_keys=False, width=100)


def path_of(state: State) -> str:
    return ".".join([s.id for s in (state, *state.ancestors)][-2::-1])


def _body(state: State) -> dict[str, Any]:
    body: dict[str, Any] = {}
    if state.kind in ("parallel", "final"):
        body["type"] = state.kind
    if state.is_history:
        body["type"] = "history"
        body["deep"] = state.kind == "deep"
    if state.default is not None:
        around = state.parent if state.is_history else state
        assert around is not None
        (target,) = state.default.targets
        inside = path_of(target).removeprefix(path_of(around)).removeprefix(".")
        body["target" if state.is_history else "initial"] = inside
    for key, actions in (("entry", state.onentry), ("exit", state.onexit)):
        if actions:
            body[key] = _mission_actions(actions)
    for each in state.transitions:
        done = each.events == f"done.state.{state.id}"
        if not each.events:
            body.setdefault("always", []).append(_alternative(each))
        else:
            on = body.setdefault("on", {})
            on.setdefault("done" if done else each.events, []).append(_alternative(each))
    if state.children:
        body["states"] = {child.id: _body(child) for child in state.children}
    return body


def _alternative(transition: Transition) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if transition.targets:
        found["target"] = [path_of(target) for target in transition.targets]
        found["reenter"] = not transition.internal
    if transition.condition is not None:
        value, state = transition.condition
        found["guard"] = f"{'' if value else 'not '}active('{path_of(state)}')"
    if transition.actions:
        found["actions"] = _mission_actions(transition.actions)
    return found


def _mission_actions(actions: list[Action]) -> list[dict[str, Any]]:
    return [
        {"raise": text}
        if kind == "raise"
        else {
            "log": text + " " + "".join(f"${{1 if active('{path_of(s)}') else 0}}" for s in states)
        }
        for kind, text, states in actions
    ]
