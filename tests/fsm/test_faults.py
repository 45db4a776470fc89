# ruff: noqa: E501  (a fault and its mission stand in one line, so that columns can be counted)
"""Faulty missions: each with its code, its exact place and, where one helps, a hint."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fsm import parse_parameters, read_mission_text
from tests.fsm.toy import Run, faults_of, graph_of, shown
from vencejo.errors import Fault, UserError

OUT = "  out: {on: {operator.abort: end}}\n  end: {type: final}\n"
A = "states:\n  a: {%s}\n" + OUT
"""A mission whose only state to look at stands in line 2, its keys from column 7 on."""


def on(text: str) -> str:
    return A % f"on: {{operator.abort: out, {text}}}"


def expression(text: str) -> str:
    return f"states:\n  a:\n    when:\n      {text}: out\n" + OUT


CASES: list[tuple[str, str, list[str], str]] = [
    # name, mission, faults, a part of the first hint
    ("empty", "", ["1:1 empty-file"], ""),
    ("only a comment", "# nothing\n", ["1:1 empty-file"], ""),
    ("a list", "- a\n", ["1:1 not-a-map"], ""),
    ("a text", "hello\n", ["1:1 not-a-map"], ""),
    ("not YAML", "states: {a: [}\n", ["1:14 bad-yaml"], ""),
    ("tab", "states:\n\ta: {}\n", ["2:1 tab-indent"], "spaces"),
    ("two documents", "a: b\n---\na: c\n", ["2:1 two-documents"], ""),
    ("no states", "description: x\n", ["1:1 no-states"], "drone-cli new"),
    ("a behaviour alone", "do: wait\n", ["1:1 no-states"], ""),
    ("unknown key", A % "onn: {operator.abort: out}", ["2:7 unknown-key"], "'on'"),
    ("unknown key at the top", "stats: {}\n" + A % "on: {operator.abort: out}", ["1:1 unknown-key"], "'states'"),
    ("a key of the top inside", A % "on: {operator.abort: out}, world: x", ["2:34 unknown-key"], "top of the file"),
    ("no blank after the colon", A % "on:out", ["2:7 unknown-key"], "blank"),
    ("duplicate key", "states:\n  a: {}\n  a: {}\n", ["3:3 duplicate-key"], "rename"),
    ("duplicate outcome", on("link.lost: out, link.lost: end"), ["2:49 duplicate-key"], ""),
    ("custom tag", A % "on: !!python/name:os.system x", ["2:11 custom-tag"], "remove"),
    ("a negation", A % "when: {!armed : out}", ["2:14 custom-tag"], "not"),
    ("unknown anchor", A % "on: *nope", ["2:11 unknown-anchor"], ""),
    ("a bare star", "states:\n  a:\n    on:\n      *: out\n", ["4:8 bad-yaml"], '"*"'),
    ("a dollar unquoted in flow", A % "do: rise, with: {height: ${1 + 1}}", ["2:33 bad-yaml"], "needs quotes"),
    ("a bracket in a flow key", A % "when: {l[0] == 3: out}", ["2:15 bad-yaml"], "quotes"),
    ("a comma in a flow key", A % "when: {max(1, 2) < 3: out}", ["2:14 empty-transition"], "quotes"),
    ("a decimal comma", A % "do: go, with: {height: 1,5 m}, on: {done: out, blocked: out}", ["2:32 bad-name"], "point"),
    ("empty transition", on("link.lost: "), ["2:33 empty-transition"], "{}"),
    ("done:land", A % "do: wait, on: {done:out}", ["2:22 bad-event"], "blank"),
    ("an empty list of alternatives", on("link.lost: []"), ["2:44 empty-transition"], ""),
    ("a list in a list", on("link.lost: [[a, b]]"), ["2:45 wrong-type"], "target: [a, b]"),
    ("bad mission name", "mission: 1 x\n" + A % "on: {operator.abort: out}", ["1:10 bad-name"], "letters"),
    ("unknown language", "language: 7\n" + A % "on: {operator.abort: out}", ["1:11 unknown-language"], ""),
    ("bad outcome name", "states:\n  a: {on: {operator.abort: end}}\n  end: {type: final, outcome: all well}\n", ["3:31 bad-name"], "an outcome is one small word"),
    ("an outcome like an event", "states:\n  a: {on: {operator.abort: end}}\n  end: {type: final, outcome: a.b}\n", ["3:31 bad-name"], "an outcome is one small word"),
    ("bad name of published values", A % "do: look, as: my eye, on: {operator.abort: out}", ["2:21 bad-name"], "letters, digits and _"),
    ("bad data name", "data: {a b: 1}\n" + A % "on: {operator.abort: out}", ["1:8 bad-name"], ""),
    ("bad parameter name", "parameters: {a-b: 1}\n" + A % "on: {operator.abort: out}", ["1:14 bad-name"], ""),
    ("bad place name", "places: {a-b: [1, 2, 3]}\n" + A % "on: {operator.abort: out}", ["1:10 bad-name"], ""),
    ("a decimal comma in data", "data: {1,5: }\n" + A % "on: {operator.abort: out}", ["1:8 bad-name", "1:10 bad-name"], "decimals have a point"),
    ("bad state name", "states:\n  A: {on: {operator.abort: end}}\n  end: {type: final}\n", ["2:3 bad-name"], "small letter"),
    ("state is a list", "states:\n  a: [b]\n  end: {type: final}\n", ["2:6 wrong-type"], ""),
    ("unknown type", A % "type: finall", ["2:13 unknown-word"], "'final'"),
    ("a final root", "type: final\nstates: {a: {}}\n", ["1:7 unknown-word"], ""),
    ("parallel without states", A % "type: parallel, on: {operator.abort: out}", ["2:3 no-states"], ""),
    ("final with on", "states:\n  a: {type: final, on: {done: a}}\n", ["2:20 unknown-key"], ""),
    ("not of this version", A % "filters: {avoid: false}, on: {operator.abort: out}", ["2:7 not-yet"], ""),
    ("with without do", A % "with: {x: 1}, on: {operator.abort: out}", ["2:7 no-behaviour"], ""),
    ("on is a text", A % "on: out", ["2:11 wrong-type"], ""),
    ("misplaced for", on("link.lost: {for: 2 s, target: out}"), ["2:45 misplaced-for"], ""),
    ("reenter is yes", on("link.lost: {target: a, reenter: yes}"), ["2:65 unknown-word"], ""),
    ("bad define", "define: {f(1): 2}\n" + A % "on: {operator.abort: out}", ["1:10 bad-name"], "name(a, b)"),
    ("define a list", "define: {f: [2]}\n" + A % "on: {operator.abort: out}", ["1:13 wrong-type"], ""),
    ("unknown action", A % "entry: {lok: x}, on: {operator.abort: out}", ["2:15 unknown-key"], "'log'"),
    ("actions are a text", A % "entry: log, on: {operator.abort: out}", ["2:14 wrong-type"], ""),
    # behaviours
    ("unknown behaviour", A % "do: gol, with: {x: 1}, on: {done: out, lost: out}, when: {gol.x > 1: out}", ["2:11 unknown-behaviour"], "'go'"),
    ("unknown behaviour, renamed", "states:\n  a:\n    do: nope\n    as: n\n    define: {d: n.x}\n    when: {n.y and d: out}\n    on: {lost: out}\n    states: {b: {on: {my.x: b}, entry: {raise: my.x}, when: {n.z: b}}}\n" + OUT, ["3:9 unknown-behaviour"], "known"),
    ("missing parameter", A % "do: rise, on: {done: out}", ["2:11 missing-parameter"], "height"),
    ("misspelt parameter", A % "do: rise, with: {heigth: 2 m}, on: {done: out}", ["2:24 unknown-parameter"], "'height'"),
    ("unknown parameter", A % "do: go, with: {zz: 2 m}, on: {done: out, blocked: out}", ["2:22 unknown-parameter"], "known"),
    ("wrong type", A % "do: rise, with: {height: high}, on: {done: out}", ["2:32 wrong-type"], "2 m"),
    ("a map for a length", A % "do: rise, with: {height: {x: 1}}, on: {done: out}", ["2:32 wrong-type"], ""),
    ("bad unit", A % "do: rise, with: {height: 2 mm2}, on: {done: out}", ["2:32 unknown-unit"], "'mm'"),
    ("wrong dimension", A % "do: rise, with: {height: 2 s}, on: {done: out}", ["2:32 wrong-dimension"], "2 m"),
    ("wrong dimension of a name", "parameters: {t: 2 s}\n" + A % "do: rise, with: {height: $t}, on: {done: out}", ["3:33 wrong-dimension"], ""),
    ("off for a bool", A % "do: go, with: {loud: off}, on: {done: out, blocked: out}", ["2:28 wrong-type"], "false"),
    ("unknown word", A % "do: go, with: {color: rad}, on: {done: out, blocked: out}", ["2:29 unknown-word"], "'red'"),
    ("not whole", A % "do: go, with: {times: 1.5}, on: {done: out, blocked: out}", ["2:29 wrong-type"], ""),
    ("out of range", A % "do: go, with: {speed: 20 m/s}, on: {done: out, blocked: out}", ["2:29 out-of-range"], ""),
    ("too large a number", A % "do: go, with: {height: 1e999}, on: {done: out, blocked: out}", ["2:30 out-of-range"], ""),
    ("no value", A % "do: go, with: {height: '${1 / 0}'}, on: {done: out, blocked: out}", ["2:33 no-value"], ""),
    ("not live", A % "do: go, live: {height: 2 m}, on: {done: out, blocked: out}", ["2:22 not-live"], "`with`"),
    ("publishes nothing", A % "do: wait, as: w, on: {done: out}", ["2:21 no-values"], ""),
    ("published name taken", "data: {look: 1}\n" + A % "do: look, on: {operator.abort: out}", ["3:11 name-taken"], "as:"),
    # parameters and names
    ("default out of its bounds", "parameters: {h: {default: 5 m, max: 4 m}}\n" + A % "on: {operator.abort: out}", ["1:27 default-out-of-range"], ""),
    ("min over max", "parameters: {h: {default: 5 m, min: 6 m, max: 4 m}}\n" + A % "on: {operator.abort: out}", ["1:17 wrong-bounds"], ""),
    ("min of a text", "parameters: {h: {default: a, min: 6 m}}\n" + A % "on: {operator.abort: out}", ["1:35 wrong-type"], ""),
    ("bound of another dimension", "parameters: {h: {default: 5 m, max: 4 s}}\n" + A % "on: {operator.abort: out}", ["1:37 wrong-dimension"], ""),
    ("not one of the choices", "parameters: {h: {default: a, choices: [b, c]}}\n" + A % "on: {operator.abort: out}", ["1:27 unknown-word"], ""),
    ("unknown type of a parameter", "parameters: {h: {type: lenght}}\n" + A % "do: rise, with: {height: $h}, on: {done: out}", ["1:24 unknown-type"], "'length'"),
    ("unknown key of a parameter", "parameters: {h: {defualt: 1}}\n" + A % "on: {operator.abort: out}", ["1:18 unknown-key"], "'default'"),
    ("default that is none", "parameters: {h: $time}\n" + A % "do: rise, with: {height: $h}, on: {done: out}", ["1:18 unknown-name"], ""),
    ("name of the host", "data: {vehicle: 1}\n" + A % "on: {operator.abort: out}", ["1:8 name-taken"], "rename"),
    ("name twice", "parameters: {n: 1}\n" + A % "data: {n: a}, when: {n > 2: out}", ["3:14 name-taken"], "rename"),
    ("reserved name", "data: {event: 1, lambda: 2}\n" + A % "on: {operator.abort: out}", ["1:8 name-taken", "1:18 name-taken"], "another"),
    ("argument that hides", "define: {f(time): 1}\n" + A % "on: {operator.abort: out}", ["1:10 name-taken"], ""),
    ("define named as a function", "define: {min(a): 1}\n" + A % "on: {operator.abort: out}", ["1:10 name-taken"], ""),
    ("a map as first value", "data: {m: {a: 1}}\n" + A % "on: {operator.abort: out}, when: {m.a > 1: out}", ["1:11 wrong-type"], "{type: map"),
    ("a first value that is wrong", "data: {m: $nope}\n" + A % "when: {m > 1: out}", ["1:12 unknown-name"], ""),
    ("a define that is wrong", "define: {d: nope > 1}\n" + A % "when: {d: out}, on: {link.lost: {target: out, guard: d}}", ["1:13 unknown-name"], ""),
    ("event exists", "events: {battery.low: {}}\n" + A % "on: {operator.abort: out}", ["1:10 name-taken"], ""),
    ("event without dot", "events: {low: {}}\n" + A % "on: {operator.abort: out}", ["1:10 bad-name"], ""),
    ("event of a list", "events: {my.own: [a]}\n" + A % "on: {operator.abort: out}", ["1:18 wrong-type"], "number"),
    ("event with an unknown type", "events: {my.own: {x: numbr}}\n" + A % "on: {my.own: {target: out, guard: event.x > 1}}", ["1:22 unknown-type"], "'number'"),
    ("unknown place", "places: {p: nowhere}\n" + A % "do: go, with: {to: p}, on: {done: out, blocked: out}", ["1:13 unknown-place"], "[x, y]"),
    # transitions
    ("unknown target", A % "on: {operator.abort: ot}", ["2:28 unknown-target"], "'out'"),
    ("unknown target inside", A % "on: {operator.abort: out.b}", ["2:28 unknown-target"], ""),
    ("targets in one region", on("link.lost: {target: [out, end]}"), ["2:59 conflicting-targets"], "regions"),
    ("unknown initial", "initial: b\n" + A % "on: {operator.abort: out}", ["1:10 unknown-target"], "known"),
    ("misplaced initial", A % "initial: b, on: {operator.abort: out}", ["2:16 misplaced-initial"], ""),
    ("history without target", A % "on: {operator.abort: out, link.lost: h}, states: {b: {}, h: {type: history}}".replace("link.lost: h", "link.lost: a.h"), ["2:66 missing-key"], ""),
    ("unknown event", on("battery.lo: out"), ["2:33 unknown-event"], "'battery.low'"),
    ("unknown family", on("batery.*: out"), ["2:33 unknown-event"], "'battery.*'"),
    ("outcome for an event", on("battery_low: out"), ["2:33 unknown-outcome"], "'battery.low'"),
    ("unknown outcome", A % "do: go, on: {done: out, blockd: out, blocked: out}", ["2:31 unknown-outcome"], "'blocked'"),
    ("unknown field of an event", on("link.lost: {target: out, guard: event.agee > 1 s}"), ["2:65 unknown-field"], "'age'"),
    ("event where there is none", A % "when: {event.x > 1: out}", ["2:14 unknown-name"], ""),
    ("an expression that does not parse", expression("1 +"), ["4:10 bad-expression"], ""),
    ("an unknown name", expression("vehicle.battery < 30 % and nope"), ["4:34 unknown-name"], ""),
    ("a host value without its host", expression("altitude > 2 m"), ["4:7 unknown-name"], "'vehicle.altitude'"),
    ("an unknown field", expression("vehicle.batery < 30 %"), ["4:7 unknown-field"], "'battery'"),
    ("an unknown function", expression("mx(1, 2) > 1"), ["4:7 unknown-function"], "'max'"),
    ("a condition that is none", expression("vehicle.battery"), ["4:7 wrong-type"], ""),
    ("a duration that is none", A % "after: {2 m: out}", ["2:15 wrong-dimension"], ""),
    ("guard that is no condition", on("link.lost: {target: out, guard: event.age}"), ["2:65 wrong-type"], ""),
    # actions
    ("set what is no variable", A % "entry: {set: {nope: 1}}, on: {operator.abort: out}", ["2:21 unknown-variable"], "data"),
    ("set a parameter", "parameters: {p: 1}\n" + A % "entry: {set: {p: 1}}, on: {operator.abort: out}", ["3:21 unknown-variable"], "data"),
    ("set of another type", "data: {n: 1 m}\n" + A % "entry: {set: {n: 2 s}}, on: {operator.abort: out}", ["3:24 wrong-dimension"], ""),
    ("append to a number", "data: {n: 1}\n" + A % "entry: {append: {n: 2}}, on: {operator.abort: out}", ["3:24 wrong-type"], ""),
    ("raise a word", A % "entry: {raise: low}, on: {operator.abort: out}", ["2:22 bad-event"], ""),
    ("raise an error", A % "entry: {raise: error.mine}, on: {operator.abort: out}", ["2:22 bad-event"], ""),
    ("raise with an unknown field", A % "entry: {raise: {battery.low: {lvl: 1}}}, on: {operator.abort: out}", ["2:37 unknown-key"], ""),
    ("send nothing", A % "entry: {send: {delay: 2 s}}, on: {operator.abort: out}", ["2:21 bad-event"], ""),
    ("send with an unknown key", A % "entry: {send: {event: my.own, dely: 2 s}}, on: {operator.abort: out}", ["2:37 unknown-key"], "'delay'"),
    ("call", A % "entry: {call: f}, on: {operator.abort: out}", ["2:21 unknown-function"], "@action"),
    ("lone dollar", A % "entry: {log: 5 $ each}, on: {operator.abort: out}", ["2:22 lone-dollar"], "$$"),
    ("unclosed dollar", A % "entry: {log: 'a ${n'}, on: {operator.abort: out}", ["2:23 bad-expression"], ""),
    # structure
    ("unhandled outcome", A % "do: go, on: {done: out}", ["2:3 unhandled-outcome"], "blocked"),
    ("all alternatives guarded", A % "do: wait, on: {done: [{guard: time > 2 s, target: out}], operator.abort: out}", ["2:29 guarded-outcome"], "without guard"),
    ("no way out", A % "do: blink", ["2:3 no-way-out", "3:3 unreachable", "4:3 unreachable"], "final"),
    ("a companion that ends", A % "do: go, on: {blocked: out, operator.abort: out}, states: {b: {on: {link.lost: b}}}", ["2:3 ending-companion"], ""),
    ("two owners", A % "type: parallel, on: {done: out, operator.abort: out, blocked: out}, states: {b: {do: go}, c: {do: go}}", ["2:97 two-owners"], "one behaviour"),
    ("a region to itself", A % "type: parallel, on: {operator.abort: out}, states: {b: {on: {link.lost: b}}, c: {}}", ["2:79 region-restart"], "reenter"),
    ("a region into another", A % "type: parallel, on: {operator.abort: out}, states: {b: {on: {link.lost: c}}, c: {}}", ["2:79 region-restart"], "reenter"),
    ("a parallel state into its region", A % "type: parallel, on: {operator.abort: out, link.lost: b}, states: {b: {}, c: {}}", ["2:60 region-restart"], "reenter"),
    ("a dead alternative", on("link.lost: [out, {guard: time > 2 s, target: end}]"), ["2:50 dead-alternative"], "first"),
    ("a dead event", on("link.*: out, link.lost: end"), ["2:57 dead-alternative"], "before"),
    ("an endless always", A % "always: out" .replace("out", "b") + "  b: {always: a}\n", ["2:15 endless-always", "5:15 endless-always", "3:3 unreachable", "4:3 unreachable"], ""),
    ("an always without target", A % "always: {actions: {log: x}}, on: {operator.abort: out}", ["2:15 endless-always"], "entry"),
    ("equal durations", A % "after: {1 min: out, 60 s: end}", ["2:27 equal-durations"], "list"),
    ("a final region", A % "type: parallel, on: {operator.abort: out}, states: {b: {type: final}, c: {}}", ["2:59 final-region"], ""),
    ("never done", A % "type: parallel, on: {done: out, operator.abort: out}, states: {b: {do: wait}, c: {do: blink}}", ["2:34 never-done"], ""),
    ("reenter without a target", on("link.lost: {reenter: true, actions: {log: x}}"), ["2:45 misplaced-reenter"], "nothing is left"),
    # constants
    ("a duration without a value", A % "after: {1 s / 0: out}", ["2:15 no-value"], "constant"),
    ("a duration that is null", A % "after: {null: out}", ["2:15 wrong-type"], "10 s"),
    ("a lasting without a value", A % "when: {vehicle.altitude > 1 m: {for: 1 s / 0, target: out}}", ["2:44 no-value"], ""),
    ("a condition without a value", A % "when: {vehicle.altitude > 1 / 0: out}", ["2:33 no-value"], ""),
    ("a condition that is null", A % "when: {null: out}", ["2:14 wrong-type"], "compare"),
    ("a guard without a value", on("link.lost: {target: out, guard: 1 / 0 > 1}"), ["2:65 no-value"], ""),
    ("a define without a value", "define: {k: 1 / 0}\n" + A % "when: {k > 1: out}", ["1:13 no-value"], ""),
    ("a text without a value", A % "entry: {log: 'x ${1 / 0}'}, when: {vehicle.altitude > 1 m: out}", ["2:25 no-value"], ""),
    ("a delay without a value", A % "entry: {send: {event: my.own, delay: '${1 s / 0}'}}, on: {my.own: out}", ["2:47 no-value"], ""),
    ("a constant that is none of the words", A % "do: go, with: {color: \"${'rad'}\"}, on: {done: out, blocked: out}", ["2:32 wrong-type"], ""),
    ("a text with a number format", A % "entry: {log: '${vehicle.mode:.1f}'}, on: {operator.abort: out}", ["2:23 wrong-type"], "format"),
    ("a negative duration", A % "after: {-3 s: out}", ["2:15 out-of-range"], "10 s"),
    ("a negative lasting", A % "when: {vehicle.altitude > 1 m: {for: -1 s, target: out}}", ["2:44 out-of-range"], "10 s"),
    ("a negative delay", A % "entry: {send: {event: my.own, delay: -1 s}}, on: {my.own: out}", ["2:44 out-of-range"], ""),
    ("a number with a leading zero", A % "do: rise, with: {height: 010}, on: {done: out}", ["2:32 wrong-type"], "leading zero"),
    ("states as a list", "states:\n  - a\n", ["2:3 wrong-type"], "states: {"),
    ("inner states as a list", A % "on: {operator.abort: out}, initial: b, states: [b]", ["2:54 wrong-type"], "states: {"),
    ("on as a list", A % "do: go, on: [done]", ["2:19 wrong-type"], "on: {"),
    ("no state at all", "states: {}\n", ["1:1 no-states"], "states: {name"),
    ("an outcome of another word", A % "do: go, on: {arrived: out, done: out, blocked: out}", ["2:20 unknown-outcome"], "the outcomes here are: blocked, done, failed"),
    ("a list of an unknown type", "data: {l: {type: [lenght]}}\n" + A % "on: {operator.abort: out}, entry: {append: {l: 1}}", ["1:19 unknown-type"], "'length'"),
    ("a list of two types", "data: {l: {type: [length, time]}}\n" + A % "on: {operator.abort: out}, entry: {append: {l: 1}}", ["1:18 unknown-type"], "[length]"),
    ("append another dimension", "data: {l: {type: [length], default: [1 m]}}\n" + A % "on: {operator.abort: out}, entry: {append: {l: 2 s}}", ["3:54 wrong-dimension"], "2 m"),
    ("a typed list of another dimension", "parameters: {l: {type: [length], default: [5 s]}}\n" + A % "on: {operator.abort: out}, entry: {log: $l}", ["1:44 wrong-dimension"], "2 m"),
    # warnings
    ("a condition that is always false", A % "when: {1 > 2: out}, on: {operator.abort: end}", ["2:14 constant-condition", "3:3 unreachable"], "changes"),
    ("a condition that is always true", A % "when: {2 > 1: out}", ["2:14 constant-condition"], "changes"),
    ("a guard that is always false", on("link.lost: {target: end, guard: 1 > 2}"), ["2:65 constant-condition"], ""),
    ("a guard of always", A % "always: [{guard: 1 > 2, target: end}, out]", ["2:24 constant-condition"], ""),
    ("a part of a condition", A % "when: {vehicle.altitude > 1 m and 1 > 2: out}", ["2:41 constant-condition"], ""),
    ("a define that is always true", "define: {d: 2 > 1}\n" + A % "when: {d: out}", ["1:13 constant-condition"], ""),
    ("a condition of a define with arguments", "define: {far(v): v > 2 m and 1 > 2}\n" + A % "when: {far(vehicle.altitude): out}", ["1:30 constant-condition"], ""),
    ("no time at all", A % "when: {vehicle.altitude > 1 m: {for: 0 s, target: out}}", ["2:44 short-duration"], "leave `for` out"),
    ("a zero duration", A % "after: {0 s: out}", ["2:15 short-duration"], "first period"),
    ("a dead timer", A % "after: {2 s: out, 5 s: b}" + "  b: {on: {link.lost: end}}\n", ["2:25 dead-timer", "5:3 unreachable"], "shorter"),
    ("a dead timer above the other", A % "after: {5 s: end, 2 s: out}", ["2:15 dead-timer"], "shorter"),
    ("a dead timer inside", A % "after: {2 s: out}, states: {b: {after: {3 s: b}}}", ["2:47 dead-timer"], "shorter"),
    ("the same condition twice", A % "when: {vehicle.altitude > 3 m: out, 'vehicle.altitude  > 300 cm': end}", ["2:44 same-condition"], "list of alternatives"),
    ("the same condition the other way round", A % "when: {vehicle.altitude >= 3 m and vehicle.battery > 5 %: out, 3 m <= vehicle.altitude and 5 % < vehicle.battery: end}", ["2:70 same-condition"], ""),
    ("the same guard twice", on("link.lost: [{guard: event.age > 2 s, target: out}, {guard: event.age>2 s, target: end}]"), ["2:92 same-condition"], "never reached"),
    ("an event nobody hears", "events: {go.now: {}}\n" + A % "on: {operator.abort: out, go.now: out}, entry: {raise: goo.now}", ["3:62 unheard-event"], "'go.now'"),
    ("an event of the host, misspelt", A % "on: {operator.abort: out}, exit: {raise: battry.low}", ["2:48 unheard-event"], "'battery.low'"),
    ("an event with fields nobody hears", A % "on: {operator.abort: out}, exit: {raise: {my.own: {n: 1}}}", ["2:49 unheard-event"], "on: {my.own"),
    ("a sent event nobody hears", on("link.lost: {actions: {send: {event: my.own, delay: 2 s}}}"), ["2:69 unheard-event"], ""),
    ("an unknown id", A % "on: {operator.abort: out, my.own: out}, entry: {send: {event: my.own, id: tick}}, exit: {cancel: tikc}", ["2:104 unknown-id"], "'tick'"),
    ("one parameter twice", A % "do: go, with: {speed: 1 m/s}, live: {speed: 2 m/s}, on: {done: out, blocked: out}", ["2:29 given-twice"], "live"),
    ("a bare angle", A % "do: go, with: {heading: 90}, on: {done: out, blocked: out}", ["2:31 bare-angle"], "'90 deg'"),
    ("a bare angle in an expression", A % "do: go, with: {heading: '${2 * 45}'}, on: {done: out, blocked: out}", ["2:34 bare-angle"], "'2 * 45 deg'"),
    ("a bare angle of a parameter", "parameters: {a: {type: angle, default: -180}}\n" + A % "on: {operator.abort: out}, entry: {log: $a}", ["1:40 bare-angle"], "'-180 deg'"),
    ("a route without points", A % "do: fly, with: {route: []}, on: {done: out}", ["2:30 empty-route"], "points"),
    ("no end", "states:\n  a: {on: {link.lost: b}}\n  b: {on: {link.lost: a}}\n", ["1:1 never-ends"], "{type: final}"),
    ("an end inside is none of the mission", "states:\n  a: {on: {done: a}, states: {b: {on: {link.lost: c}}, c: {type: final}}}\n", ["1:1 never-ends"], ""),
    ("unreachable", A % "on: {operator.abort: end}", ["3:3 unreachable"], ""),
    ("a short duration", A % "after: {10 ms: out}", ["2:15 short-duration"], ""),
    ("always on the world", A % "always: {guard: vehicle.altitude > 1 m, target: out}, on: {operator.abort: out}", ["2:23 always-on-the-world"], "when"),
    ("a hidden handler", A % "on: {operator.abort: out}, states: {b: {on: {operator.abort: b}}}", ["2:68 hidden-handler"], ""),
    ("a landing that can be left", A % "on: {link.lost: out}, states: {b: {do: settle, on: {done: {}}}}", ["2:23 left-landing"], ""),
    ("a hidden state", A % "on: {operator.abort: out}, states: {out: {on: {link.lost: out}}}", ["2:28 hidden-state", "2:65 hidden-state", "3:3 unreachable", "4:3 unreachable"], ""),
]  # fmt: skip


FINE: list[tuple[str, str]] = [
    # name, mission: close to a mistake, and none
    ("a define as a switch", "define: {debug: false}\n" + A % "when: {debug: out, vehicle.altitude > 1 m and debug: out}"),
    ("an earlier timer with a guard", A % "after: {2 s: {guard: vehicle.altitude > 1 m, target: out}, 5 s: end}"),
    ("an earlier timer that stays", A % "after: {2 s: {actions: {log: x}}, 5 s: out}"),
    ("an earlier timer of the outer state that stays", A % "after: {2 s: c}, on: {link.lost: out}, states: {b: {after: {5 s: c}}, c: {after: {5 s: b}}}"),
    ("another condition", A % "when: {vehicle.altitude > 3 m: out, 3 m > vehicle.altitude: end}"),
    ("an event of the host is heard there", A % "on: {operator.abort: out}, entry: {raise: {battery.low: {level: 10 %}}}"),
    ("an event that a family hears", A % "on: {my.*: out}, entry: {raise: my.own}"),
    ("the id of an event", A % "on: {operator.abort: out, my.own: out}, entry: {send: {event: my.own}}, exit: {cancel: my.own}"),
    ("an id of the flight", A % "on: {operator.abort: out, my.own: out}, entry: {send: {event: my.own, id: $vehicle.mode}}, exit: {cancel: auto}"),
    ("a small bare angle", A % "do: go, with: {heading: 1.57}, on: {done: out, blocked: out}"),
]  # fmt: skip


@pytest.mark.parametrize("text", [c[1] for c in FINE], ids=[c[0] for c in FINE])
def test_no_fault(text: str) -> None:
    assert faults_of(text) == []


@pytest.mark.parametrize(
    ("text", "faults", "hint"), [c[1:] for c in CASES], ids=[c[0] for c in CASES]
)
def test_fault(text: str, faults: list[str], hint: str) -> None:
    found = faults_of(text)
    assert [shown(fault) for fault in found] == faults
    assert hint in (found[0].hint or "")


def test_several_faults_are_reported_at_once_in_their_order() -> None:
    found = faults_of(
        """
parameters: {h: {default: 5 m, max: 4 m}}
data: {n: 0}
states:
  a: {do: gol, on: {done: b}}
  b: {do: rise, with: {height: 2 s}, on: {done: nowhere}}
  c: {when: {nope > 1: a}, after: {2 m: a}, entry: {set: {n: 1 + m, k: 2}}}
"""
    )
    assert [shown(fault) for fault in found] == [
        "2:27 default-out-of-range", "5:11 unknown-behaviour", "6:32 wrong-dimension",
        "6:49 unknown-target", "7:14 unknown-name", "7:36 wrong-dimension", "7:62 wrong-type",
        "7:69 unknown-variable",
    ]  # fmt: skip


def test_a_guard_that_cannot_be_read_has_no_consequences() -> None:
    found = faults_of(
        """
states:
  a: {always: [{if: 1 > 2, target: b}, {target: b}]}
  b: {after: {1 s: {gard: 1 > 2, target: a}, 5 s: a}}
"""
    )
    assert [shown(fault) for fault in found] == ["3:17 unknown-key", "4:21 unknown-key"]


@pytest.mark.parametrize(
    ("text", "expected", "hint"),
    [
        ("states:\n  a:\n    do: wait\n    on:\n    done: b\n    operator.abort: b\n  b: {type: final}\n",
         ["5:5 unknown-key"], "further, if it belongs to `on`"),
        ("states:\na:\n  after: {1 s: b}\nb: {type: final}\n", ["2:1 unknown-key"], "belongs to `states`"),
        ("states:\n  a:\n  do: wait\n  on: {operator.abort: b}\n  b: {type: final}\n", ["3:3 unknown-key"], "belongs to `a`"),
        ("states:\n  a:\n    after:\n      1 s:\n      target: b\n  b: {type: final}\n", ["5:7 unknown-key"], "belongs to `1 s`"),
        # a misspelt key is no matter of indentation, nor is one in the same line
        ("states:\n  a:\n    on:\n    aftr: {1 s: b}\n  b: {type: final}\n", ["4:5 unknown-key", "3:8 wrong-type"], "'after'"),
        ("states:\n  a: {on: , done: b, after: {1 s: b}}\n  b: {type: final}\n", ["2:13 unknown-key", "2:11 wrong-type"], "'on'"),
        ("states:\n  a:\n    after: {1 s: b}\n    b: {on: {operator.abort: a}}\n  c: {type: final}\n",
         ["4:5 unknown-key"], "indent it less"),
    ],
)  # fmt: skip
def test_wrong_indentation_is_one_fault_with_its_cure(
    text: str, expected: list[str], hint: str
) -> None:
    found = faults_of(text)
    assert [shown(fault) for fault in found] == expected
    assert hint in (found[0].hint or "")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("states:\n  a: {states: [{b: {}}], on: {done: c}}\n  c: {type: final}\n", ["2:15 wrong-type"]),
        ("states:\n  a: {type: parallel, states: [{b: {}}], on: {done: c}}\n  c: {type: final}\n", ["2:31 wrong-type"]),
        ("states:\n  a: {on: {operator.abort: b}}\n  b: {typ: final}\n", ["3:7 unknown-key"]),
        ("states:\n  a: {on: {operator.abort: b}}\n  b: {type: finl}\n", ["3:13 unknown-word"]),
        ("states:\n  a: {on: {operator.abort: b}}\n  b: {type: last}\n", ["3:13 unknown-word"]),
        ("states:\n  a: {type: paralel, states: {x: {states: {b: {type: final}}}}, on: {done: c}}\n  c: {type: final}\n",
         ["2:13 unknown-word"]),
        ("states:\n  a: do wait\n  c: [{do: wait}]\n", ["2:6 wrong-type", "3:6 wrong-type"]),
    ],
)  # fmt: skip
def test_of_states_that_could_not_be_read_nothing_else_is_told(
    text: str, expected: list[str]
) -> None:
    assert [shown(fault) for fault in faults_of(text)] == expected


def test_mistakes_of_form_are_reported_at_once() -> None:
    with pytest.raises(UserError) as raised:
        read_mission_text(
            "statess: {}\nstates:\n  A: {type: x}\n  b: [1]\n  c: {with: {a: 1}}\n", "m.yaml"
        )
    assert [shown(fault) for fault in raised.value.faults] == [
        "1:1 unknown-key", "3:3 bad-name", "3:13 unknown-word", "4:6 wrong-type", "5:7 no-behaviour",
    ]  # fmt: skip


def test_states_nest_at_most_64_deep() -> None:
    def nested(depth: int) -> str:
        inner = "{on: {operator.abort: s}}"
        for _ in range(depth - 1):
            inner = f"{{states: {{s: {inner}}}}}"
        return f"states: {{s: {inner}}}"

    assert [f.code for f in faults_of(nested(64)) if f.severity == "error"] == []
    assert faults_of(nested(65))[0].code == "too-deep"


PARAMETERS = """
parameters:
  h: {default: 4 m, min: 1 m, max: 30 m}
  t: {type: time}
  word: {default: a}
  at: {type: point, default: home}
places: {pad: [4, 5, 0]}
states: {a: {on: {operator.abort: end}}, end: {type: final}}
"""
LISTS = """
parameters:
  heights: {type: [length], default: [1 m]}
  turn: {type: angle, default: 0}
  spots: {type: [point], default: [home]}
states: {a: {on: {operator.abort: end}}, end: {type: final}}
"""


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ({"t": "2"}, {"h": 4.0, "t": 2.0, "word": "a", "at": "home"}),
        ({"t": "2 min", "h": "600cm"}, {"h": 6.0, "t": 120.0, "word": "a", "at": "home"}),
        (
            {"t": "1", "word": "on: $5, [x"},
            {"h": 4.0, "t": 1.0, "word": "on: $5, [x", "at": "home"},
        ),
        ({"t": "1", "at": "pad"}, {"h": 4.0, "t": 1.0, "word": "a", "at": (4.0, 5.0, 0.0)}),
        ({"t": "1", "at": "pond"}, {"h": 4.0, "t": 1.0, "word": "a", "at": "pond"}),
        ({"t": "1", "at": "[1, 2]"}, {"h": 4.0, "t": 1.0, "word": "a", "at": {"x": 1.0, "y": 2.0}}),
        ({"t": "1", "at": "[1, 2, 3]"}, {"h": 4.0, "t": 1.0, "word": "a", "at": (1.0, 2.0, 3.0)}),
    ],
)
def test_parameters_from_texts(given: dict[str, str], values: dict[str, object]) -> None:
    assert parse_parameters(graph_of(PARAMETERS), given) == values


@pytest.mark.parametrize(
    ("given", "codes"),
    [
        ({}, ["missing-parameter"]),
        ({"t": "2 m"}, ["wrong-dimension"]),
        ({"t": "2", "h": "40 m"}, ["out-of-range"]),
        ({"t": "2", "hh": "4 m"}, ["unknown-parameter"]),
        ({"t": ""}, ["wrong-type"]),
        ({"t": "${1/0}"}, ["no-value"]),
        ({"t": "$time"}, ["unknown-name"]),
        ({"t": "[1"}, ["bad-yaml"]),
        ({"t": "1", "at": "nope"}, ["unknown-place"]),
        ({"t": "010"}, ["wrong-type"]),
        ({"t": "1\udcff"}, ["not-text"]),
        ({"h": "x", "hh": "y"}, ["wrong-type", "unknown-parameter", "missing-parameter"]),
    ],
)
def test_parameters_that_do_not_fit(given: dict[str, str], codes: list[str]) -> None:
    with pytest.raises(UserError) as raised:
        parse_parameters(graph_of(PARAMETERS), given)
    assert [fault.code for fault in raised.value.faults] == codes


def test_lists_from_texts() -> None:
    graph = graph_of(LISTS)
    assert parse_parameters(graph, {"heights": "[50 cm, 2]", "spots": "[pond, [1, 2, 3]]"}) == {
        "heights": [0.5, 2.0],
        "turn": 0.0,
        "spots": ["pond", (1.0, 2.0, 3.0)],
    }
    for texts, code in (
        ({"heights": "[5 s]"}, "wrong-dimension"),
        ({"heights": "5 m"}, "wrong-type"),
        ({"spots": "[nope]"}, "unknown-place"),
    ):
        with pytest.raises(UserError) as raised:
            parse_parameters(graph, texts)
        assert [fault.code for fault in raised.value.faults] == [code]


def test_what_is_doubtful_in_a_text_is_told() -> None:
    found: list[Fault] = []
    assert parse_parameters(graph_of(LISTS), {"turn": "90"}, found)["turn"] == 90.0
    assert [str(fault) for fault in found] == [
        "-p turn:1:8: warning: 90 without a unit is 90 rad, 14 turns [bare-angle]\n"
        "  hint: did you mean '90 deg'?"
    ]


SHIPPED = [
    """
mission: road_patrol
description: Follow the road, noting every new tag, then come home.
parameters:
  cruise: {default: 4 m, min: 1 m, max: 30 m, help: height above home}
  patience: 20 s
data: {found: []}
states:
  up: {do: rise, with: {height: $cruise}, on: {done: patrol, failed: land}}
  patrol:
    do: look
    as: tags
    on:
      battery.low: back
      link.lost: land
      failed: land
      tag.seen:
        guard: event.id not in [t.id for t in found]
        actions: {append: {found: $event}}
    when: {vehicle.battery < 30 %: back}
    after: {180 s: back}
    states:
      follow: {do: go, with: {speed: 1.2 m/s}, on: {done: back, blocked: search}}
      search: {do: wait, on: {done: follow}, after: {patience: back}}
  back: {do: go, with: {to: home}, on: {done: land, blocked: land, failed: land}}
  land: {do: settle, on: {done: finish}}
  finish: {type: final, output: {found: $found}}
""",
    """
initial: hunt
states:
  hunt:
    do: look
    as: blob
    define: {lost: not blob.visible, band(v): 0 if abs(v) < 0.1 else v}
    on: {operator.abort: manual}
    states:
      search: {do: go, on: {done: {}, blocked: {}}, when: {blob.visible: pursue}}
      pursue:
        do: go
        live: {speed: "${-0.5 * band(blob.x)}"}
        on: {done: {}, blocked: {}}
        when: {lost: {for: 0.5 s, target: search}}
      back: {type: history, target: search}
  manual: {on: {link.lost: hunt.back}, after: {9 s: end}}
  end: {type: final}
""",
]


@pytest.mark.parametrize("text", SHIPPED)
def test_missions_as_they_are_written_have_no_fault(text: str) -> None:
    assert faults_of(text) == []


WORDS = ["states", "a", "b", "on", "when", "after", "always", "do", "with", "live", "as", "data", "define",
         "entry", "set", "append", "raise", "send", "event", "type", "parallel", "final", "history", "target",
         "initial", "parameters", "default", "min", "events", "places", "output", "guard", "for", "done",
         "failed", "battery.low", "my.own", "*", "go", "look", "rise", "height", "to", "1", "2 m", "5 s",
         "$a", "${a + 1}", "a > 1", "a.x", "null", "true", "home", "f(v)", "v * 2"]  # fmt: skip
LEAVES = st.sampled_from(WORDS)
TREES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(LEAVES, inner, max_size=4),
    max_leaves=25,
)


@given(st.dictionaries(LEAVES, TREES, max_size=5), st.dictionaries(LEAVES, TREES, max_size=5))
def test_any_tree_of_the_language_s_words_flies_or_is_refused(
    root: dict[str, object], state: dict[str, object]
) -> None:
    text = json.dumps({**root, "states": {"a": state, "b": {}}})
    for fault in faults_of(text):
        assert str(fault)


def test_a_mission_that_flies_as_well_as_it_can_be_checked_runs() -> None:
    for text in SHIPPED:
        run = Run(text)
        run.run(20)
        assert "error" not in " ".join(run.take())
