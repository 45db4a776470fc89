"""Whatever a person's code does, the vehicle lands: flights of missions with Python beside."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent, indent
from typing import Any

import pytest

from runner import Run, read_run
from tests.cli.run_cli import Result, run_cli

pytestmark = pytest.mark.usefixtures("undrawn")
ROOT = Path(__file__).parents[2]

HEAD = """\
import os, signal, sys, threading, time, warnings
from dataclasses import dataclass
from typing import Any
from behaviors import Behavior, BehaviorParams, Outcome, Point, action, param
from hal import Attitude, Hold, Lights, Position, Velocity

@dataclass
class Facts:
    number: float = 0.0
    thing: Any = None
"""
MISSION = """\
mission: own
uses: [own.py]
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: fly}}
  fly: {do: own, on: {done: down}, after: {1 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
INTERRUPTED = """\
mission: own
uses: [own.py]
data: {rested: false}
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: work}}
  work:
    after: {1 s: rest}
    states:
      fly: {do: own, on: {done: down}}
      again: {type: history, target: fly}
  rest:
    do: hover
    after: {1 s: [{guard: not rested, target: work.again, actions: {set: {rested: true}}}, down]}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
CALLING = MISSION.replace("own, on: {done: down}", "hover, entry: {call: act}")


@dataclass
class Flight:
    """A flight by the command line, as it was told and as it was recorded."""

    result: Result
    run: Run

    @property
    def summary(self) -> dict[str, Any]:
        return dict(json.loads(self.result.out))


def written(code: str, mission: str = MISSION) -> int:
    """Write a mission and its code; the line of the code with the mark ``# !``, or 0."""
    text = HEAD + dedent(code)
    Path("own.py").write_text(text)
    Path("m.yaml").write_text(mission)
    return next((n for n, line in enumerate(text.splitlines(), 1) if "# !" in line), 0)


def behavior(step: str = "pass", **methods: str) -> str:
    """A class ``Own``; ``flight`` and ``progress`` are its methods' arguments."""
    heads = {
        "start": "def start(self, flight, progress=None):",
        "step": "def step(self, flight):",
        "progress": "def progress(self):",
        "stop": "def stop(self, flight):",
    }
    body = methods.pop("body", "controls = ('motion', 'lights')")
    methods = {"step": step, **methods}
    texts = [body, *(heads[name] + "\n" + indent(code, "    ") for name, code in methods.items())]
    return "\nclass Own(Behavior):\n    'Own.'\n" + indent("\n".join(texts), "    ") + "\n"


def flown(code: str, mission: str = MISSION, *options: str) -> tuple[Flight, int]:
    """A flight of that code, landed and whole whatever came of it; the marked line."""
    line = written(code, mission)
    result = run_cli("run", "m.yaml", "--json", *options)
    (folder,) = Path("runs").iterdir()
    flight = Flight(result, read_run(folder))
    assert_landed_and_whole(flight)
    return flight, line


def assert_landed_and_whole(flight: Flight) -> None:
    run, summary = flight.run, flight.summary
    assert run.missing == ()
    assert run.summary is not None
    last = run.telemetry["drone"][-1]
    assert last.mode == "landed" and abs(last.position.z) < 0.05
    assert json.loads((run.folder / "summary.json").read_text()) == summary
    assert run.summary.alone.outcome == summary["outcome"]
    assert summary["exit_code"] == flight.result.code
    (outcome,) = [entry for entry in run.events if entry.kind == "outcome"]
    assert (outcome.fields["outcome"], outcome.fields["reason"]) == (
        summary["outcome"],
        summary["reason"],
    )
    assert "Traceback" not in flight.result.err


def assert_failed(flight: Flight, line: int, told: str, by: str = "failed") -> None:
    summary = flight.summary
    assert (summary["outcome"], flight.result.code) == ("failed", 1)
    assert summary["reason"].startswith(f"nothing handled {by}: ")
    assert told in summary["reason"]
    assert summary["reason"].endswith(f" (own.py:{line})"), summary["reason"]


STEPS = {
    "a number that is none": ("flight.command(Velocity(x=float('nan')))", "x is nan"),
    "an infinite height": ("flight.command(Position(Point(0, 0, float('inf'))))", "xyz is inf"),
    "a speed in words": ("flight.command(Velocity(x='fast'))", "x must be a number"),
    "no set-point": ("flight.command({'x': 1})", "a dict is no set-point"),
    "none at all": ("flight.command(None)", "a NoneType is no set-point"),
    "a frame there is not": ("flight.command(Velocity(1, 0, 0, 'body'))", "world or heading"),
    "a height in words": ("flight.takeoff('high')", "altitude must be a number"),
    "lights in words": ("flight.lights('red')", "not by a str"),
    "no camera's name": ("flight.camera([])", "unhashable"),
    "sys.exit": ("sys.exit()", "SystemExit"),
    "Ctrl-C of its own": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    "out of memory": ("'x' * 10**15", "MemoryError"),
    "for ever deeper": ("self.step(flight)", "RecursionError"),
    "the terminal": ("input('name? ')", "no terminal"),
    "standard input": ("sys.stdin.read()", "no terminal"),
    "all lines of it": ("list(sys.stdin)", "no terminal"),
    "nobody's attribute": ("flight.observation = 3", "no setter"),
    "an event of nobody": ("flight.raise_event('a.b')", "declares no event"),
    "no event's name": ("flight.raise_event([])", "unhashable"),
    "fields of no event": ("flight.raise_event('own.seen', {'x': 1})", "no field 'x'"),
    "an event that is a class": ("flight.raise_event('own.seen', Facts)", "the class Facts"),
    "an event in words": ("flight.raise_event('own.seen', 'x')", "not in a str"),
    "an infinite event": ("flight.raise_event('own.seen', Facts(1e400))", "not finite"),
    "half a character": ("flight.raise_event('own.seen', Facts(thing='\\ud800'))", "half a"),
    "what is no JSON": ("flight.raise_event('own.seen', Facts(thing=self))", "an Own is no value"),
    "a huge event": ("flight.raise_event('own.seen', Facts(thing='x' * 2_000_000))", "1 MB"),
    "no record": ("flight.publish({'number': 1})", "own publishes a Facts, not a dict"),
    "a number in words": ("flight.publish(Facts('many'))", "number: many is not a number"),
    "a set": ("flight.publish(Facts(thing={1}))", "a set is no value"),
}


@pytest.mark.parametrize("case", STEPS)
def test_a_mistake_in_a_step_is_its_failure(case: str) -> None:
    statement, told = STEPS[case]
    body = "controls = ('motion', 'lights')\nevents = {'own.seen': Facts}\npublishes = Facts"
    assert_failed(*flown(behavior(f"{statement}  # !", body=body)), told)


ENDS = {
    "a number": ("3", "returned an int"),
    "true": ("True", "returned a bool"),
    "a generator": ("(n for n in 'abc')", "returned a generator"),
    "an unknown word": ("'nowhere'", "ended in 'nowhere', which it does not declare"),
    "no word": ("Outcome(3)", "ended in 3"),
    "an unknown field": ("Outcome('done', {'x': 1})", "no field 'x'"),
    "a wrong field": ("Outcome('found', {'number': 'many'})", "number: many is not a number"),
    "fields in words": ("Outcome('found', 'many')", "not in a str"),
    "a reason that is none": ("Outcome('failed', {'reason': 3})", "reason: 3 is not a text"),
    "the class": ("Outcome", "the class Outcome"),
}


@pytest.mark.parametrize("case", ENDS)
def test_a_wrong_end_is_its_failure_where_its_step_begins(case: str) -> None:
    value, told = ENDS[case]
    code = behavior(f"return {value}", body="outcomes = {'done': None, 'found': Facts}")
    written(code.replace("def step(self, flight):", "def step(self, flight):  # !"))
    mission = MISSION.replace("{done: down}", "{done: down, found: down}")
    code = code.replace("def step(self, flight):", "def step(self, flight):  # !")
    assert_failed(*flown(code, mission), told)


def test_a_failure_without_a_reason_has_one() -> None:
    flight, _ = flown(behavior("return 'failed'"))
    assert flight.summary["reason"] == "nothing handled failed: own gives no reason"


@pytest.mark.parametrize("statement", ["sys.exit(0)", "raise KeyboardInterrupt", "{}['key']"])
def test_a_start_that_raises_is_its_failure(statement: str) -> None:
    flight, line = flown(behavior(start=f"{statement}  # !"))
    assert_failed(flight, line, "")


@pytest.mark.parametrize("statement", ["sys.exit(0)", "raise KeyboardInterrupt", "{}['key']"])
def test_a_stop_that_raises_fails_the_mission(statement: str) -> None:
    flight, line = flown(behavior(stop=f"{statement}  # !"))
    assert_failed(flight, line, "", by="error.execution")


PROGRESS = {
    "raises": ("{}['key']  # !", "KeyError: 'key'"),
    "exits": ("sys.exit()  # !", "SystemExit"),
    "is no map": ("return 3", "`progress` returned an int"),
    "is no JSON": ("return {'a': object()}", "an object is no value"),
}


@pytest.mark.parametrize("case", PROGRESS)
def test_progress_that_cannot_be_told_fails_the_mission(case: str) -> None:
    code, told = PROGRESS[case]
    text = behavior(progress=code)
    if "# !" not in code:
        text = text.replace("def progress(self):", "def progress(self):  # !")
    assert_failed(*flown(text, INTERRUPTED), told, by="error.execution")


@pytest.mark.parametrize("statement", ["sys.exit(0)", "raise KeyboardInterrupt", "{}['key']"])
def test_a_called_function_that_raises_fails_the_mission(statement: str) -> None:
    code = f"\n@action\ndef act():\n    {statement}  # !\n"
    assert_failed(*flown(code, CALLING), "call: ", by="error.execution")


def test_what_fails_at_the_very_end_fails_the_mission_too() -> None:
    mission = CALLING.replace("entry: {call: act}, ", "").replace(
        "on: {done: over}", "on: {done: {target: over, actions: {call: act}}}"
    )
    flight, line = flown("\n@action\ndef act():\n    sys.exit(0)  # !\n", mission)
    assert flight.summary["outcome"] == "failed" and flight.result.code == 1
    assert flight.summary["reason"] == f"call: SystemExit: 0 (own.py:{line})"


def test_a_stop_that_raises_at_the_very_end_fails_the_mission() -> None:
    mission = MISSION.replace("{1 s: down}", "{1 s: over}")
    flight, line = flown(behavior(stop="{}['key']  # !"), mission)
    assert flight.summary["outcome"] == "failed" and flight.result.code == 1
    assert flight.summary["reason"] == f"KeyError: 'key' (own.py:{line})"


def test_a_failure_that_is_handled_is_the_missions_own() -> None:
    mission = MISSION.replace("{done: down}", "{done: down, failed: down}")
    flight, line = flown(behavior("sys.exit()  # !"), mission)
    assert (flight.summary["outcome"], flight.result.code) == ("done", 0)
    (failed,) = [e for e in flight.run.events if e.fields.get("name") == "failed"]
    assert failed.fields["fields"] == {"reason": f"SystemExit (own.py:{line})"}


HARMLESS = {
    "prints": "print('hello', flush=True)",
    "prints elsewhere": "print('hello', file=sys.stderr); sys.stdout.write('hello')",
    "closes the streams": "sys.stdout.close(); sys.stderr.close(); sys.stdin.close()",
    "replaces the streams": "sys.stdout = sys.stderr = sys.stdin = None",
    "goes elsewhere": "os.chdir('/')",
    "goes nowhere": "os.mkdir('gone'); os.chdir('gone'); os.rmdir('../gone')",
    "sets signals": "[signal.signal(n, signal.SIG_IGN) for n in (2, 14, 15)]; signal.alarm(0)",
    "allows no depth": "sys.setrecursionlimit(150)",
    "warns": "warnings.simplefilter('error')",
    "changes its parameters": "self.params.items.append(1); self.params = None",
    "gives numpy's numbers": "import numpy as np; flight.command(Velocity(np.float32(0.1)))",
}


@pytest.mark.parametrize("case", HARMLESS)
def test_what_does_no_harm_is_flown(case: str) -> None:
    params = "class Params(BehaviorParams):\n    items: list = param([])"
    code = behavior(start=HARMLESS[case], body=params)
    before = Path.cwd(), signal.getsignal(signal.SIGINT), sys.getrecursionlimit()
    flight, _ = flown(HEAD_PRINTS + code)
    assert (flight.summary["outcome"], flight.result.code) == ("done", 0)
    assert "hello" not in flight.result.out
    assert (Path.cwd(), signal.getsignal(signal.SIGINT), sys.getrecursionlimit()) == before


def test_ctrl_c_works_again_within_a_second() -> None:
    ignore = "self.began = flight.now\nsignal.signal(signal.SIGINT, signal.SIG_IGN)"
    step = (
        "if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:\n"
        "    return Outcome('found', {'number': flight.now - self.began})"
    )
    code = behavior(step, start=ignore, body="outcomes = {'done': None, 'found': Facts}")
    found = '{done: down, found: {target: down, actions: {log: "$event.number"}}}'
    flight, _ = flown(code, MISSION.replace("{done: down}", found).replace("{1 s:", "{9 s:"))
    (log,) = [entry for entry in flight.run.events if entry.kind == "log"]
    assert float(log.fields["text"]) <= 1.0


def test_pictures_are_kept_wherever_its_code_goes() -> None:
    flight, _ = flown(behavior("os.chdir('/')\nflight.camera('front').latest()"))
    assert flight.result.code == 0
    assert flight.run.frames and all(frame.path.exists() for frame in flight.run.frames)


HEAD_PRINTS = "print('hello, I am imported')\n"


@pytest.mark.parametrize("command", ["check", "missions", "run", "show"])
def test_what_is_printed_on_import_is_never_among_the_output(command: str) -> None:
    written(HEAD_PRINTS + "sys.stdout.close()\n" + behavior())
    options = [] if command == "show" else ["--json"]
    result = run_cli(command, "m.yaml", *options)
    assert result.code == 0
    assert "hello, I am imported" in result.err
    assert "hello" not in result.out
    if options:
        json.loads(result.out)


def test_a_mission_s_values_are_not_its_behaviours_to_change() -> None:
    mission = MISSION.replace("states:", "data: {all: [1, [2]]}\nstates:", 1).replace(
        "do: own", "do: own, with: {items: $all}"
    )
    mission = mission.replace("{type: final}", "{type: final, output: {all: $all}}")
    params = "class Params(BehaviorParams):\n    items: list = param()"
    flight, _ = flown(behavior("self.params.items[1].append(3)", body=params), mission)
    assert flight.summary["output"] == {"all": [1, [2]]}


def test_a_default_is_not_changed_by_one_that_uses_it() -> None:
    params = "class Params(BehaviorParams):\n    items: list = param([])"
    mission = MISSION.replace("{done: down}", "{done: second}").replace(
        "  down:", "  second: {do: own, on: {done: down}}\n  down:"
    )
    code = behavior(
        "self.params.items.append(1)\nreturn 'done' if len(self.params.items) == 1 else 3",
        body=params,
    )
    flight, _ = flown(code, mission)
    assert flight.summary["outcome"] == "done"


def test_a_defect_is_shown_and_the_vehicle_lands() -> None:
    written(behavior("sys.settrace(lambda *_: 1 / 0)"))
    result = run_cli("run", "m.yaml", "--json")
    summary = json.loads(result.out)
    assert result.code == 1 and summary["outcome"] == "failed"
    assert summary["reason"] == "a defect of the program: ZeroDivisionError: division by zero"
    assert "Traceback" in result.err
    run = read_run(Path(summary["run_folder"]))
    assert run.telemetry["drone"][-1].mode == "landed" and run.missing == ()
    assert sys.gettrace() is None or "settrace" not in repr(sys.gettrace())


# -- the limit on a call ------------------------------------------------------------------------


@pytest.mark.parametrize("value", ["none", "0", "0 s"])
def test_there_need_be_no_limit(value: str) -> None:
    flight, _ = flown(behavior(), MISSION, "--call-limit", value)
    assert flight.result.code == 0


@pytest.mark.parametrize("value", ["-1s", "5 m", "soon", "inf", "nan"])
@pytest.mark.parametrize("command", ["run", "check", "show", "missions"])
def test_a_limit_that_is_no_time_is_refused(command: str, value: str) -> None:
    written(behavior())
    result = run_cli(command, "m.yaml", f"--call-limit={value}")
    assert result.code == 2
    assert "--call-limit" in result.err and result.out == ""
    assert not Path("runs").exists()


SHORT = ("--call-limit", "0.2s")
ENDLESS = {
    "computes": "while True: pass  # !",
    "sleeps": "time.sleep(1e9)  # !",
    "waits for a lock": "threading.Event().wait()  # !",
    "reads what never comes": "os.read(os.pipe()[0], 1)  # !",
    "looks for a text": "import re; re.match('(a+)+$', 'a' * 60 + 'b')  # !",
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ENDLESS)
def test_a_step_that_never_returns_is_its_failure(case: str) -> None:
    told = "the call took longer than 0.2 s (--call-limit)"
    assert_failed(*flown(behavior(ENDLESS[case]), MISSION, *SHORT), told)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "mission", "by"),
    [
        (behavior(start=ENDLESS["sleeps"]), MISSION, "failed"),
        (behavior(stop=ENDLESS["computes"]), MISSION, "error.execution"),
        (behavior(progress=ENDLESS["sleeps"]), INTERRUPTED, "error.execution"),
        (f"\n@action\ndef act():\n    {ENDLESS['computes']}\n", CALLING, "error.execution"),
    ],
)
def test_the_limit_holds_for_every_call(code: str, mission: str, by: str) -> None:
    flight, line = flown(code, mission, *SHORT)
    assert_failed(flight, line, "the call took longer than 0.2 s", by=by)


@pytest.mark.slow
def test_an_exception_that_never_tells_itself_is_told_by_its_name() -> None:
    code = "\nclass Mute(Exception):\n    def __str__(self): time.sleep(1e9)\n"
    assert_failed(*flown(code + behavior("raise Mute  # !"), MISSION, *SHORT), "failed: Mute")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "check", "show", "missions"])
def test_an_import_that_never_ends_is_refused_with_its_line(command: str) -> None:
    line = written("while True: pass  # !\n" + behavior())
    result = run_cli(command, "m.yaml", *SHORT)
    assert result.code == 2
    assert f"own.py:{line}:1: error: 'own.py' cannot be loaded: the call took longer" in result.err
    assert not Path("runs").exists()


# -- in a process of its own --------------------------------------------------------------------

SWALLOWS = """
def endless():
    while True:
        try:
            time.sleep(0.01)
        except BaseException:
            continue
"""
DEEP = """
def endless():
    while True:
        try:
            endless()
        except BaseException:
            endless()
"""
PRINTS = """
def endless():
    while True:
        try:
            print("here I am")
        except BaseException:
            pass
"""


def in_a_process(*arguments: str, **settings: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tests.cli.drone_cli", *arguments],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        **settings,
    )


def flown_apart(*options: str) -> Flight:
    done = in_a_process("run", "m.yaml", "--json", *options)
    (folder,) = Path("runs").iterdir()
    return Flight(Result(done.returncode, done.stdout, done.stderr), read_run(folder))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "mission"),
    [
        (SWALLOWS + behavior("endless()"), MISSION),
        (SWALLOWS + behavior(stop="endless()"), MISSION),
        (SWALLOWS + behavior(progress="endless()"), INTERRUPTED),
        (SWALLOWS + "\n@action\ndef act():\n    endless()\n", CALLING),
        (DEEP + behavior("endless()"), MISSION),
        (PRINTS + behavior(start="os.chdir('/'); endless()"), MISSION),
    ],
)
def test_what_swallows_even_that_is_landed_without_it(code: str, mission: str) -> None:
    written(code, mission)
    flight = flown_apart(*SHORT)
    assert_landed_and_whole(flight)
    assert (flight.result.code, flight.summary["outcome"]) == (1, "failed")
    told = "the call took longer than 0.2 s and could not be ended (--call-limit) (own.py:"
    assert flight.summary["reason"].startswith(told)
    assert (flight.run.folder / "flight.png").exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "check"])
def test_an_import_that_swallows_even_that_ends_the_program(command: str) -> None:
    written(SWALLOWS + "endless()\n")
    done = in_a_process(command, "m.yaml", *SHORT)
    assert done.returncode == 2
    assert "could not be ended" in done.stderr and "own.py:" in done.stderr
    assert not Path("runs").exists()


@pytest.mark.slow
@pytest.mark.parametrize("lasts", ["step", "import"])
def test_a_thread_that_is_left_behind_does_not_keep_the_program_alive(lasts: str) -> None:
    thread = (
        "threading.Thread(target=lambda: [time.sleep(0.001) or print('hello') "
        "for _ in range(10**6)]).start()"
    )
    written(behavior(start=thread) if lasts == "step" else f"{thread}\n{behavior()}")
    began = time.monotonic()
    flight = flown_apart()
    assert time.monotonic() - began < 30
    assert_landed_and_whole(flight)
    assert flight.result.code == 0
    assert "hello" in flight.result.err


@pytest.mark.slow
def test_a_process_that_is_left_behind_does_not_keep_the_program_alive() -> None:
    start = "import multiprocessing as m; m.get_context('fork').Process(target=wait).start()"
    written("def wait():\n    time.sleep(20)\n" + behavior(start=start))
    began = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.cli.drone_cli", "run", "m.yaml"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    assert process.wait(timeout=15) == 0
    assert time.monotonic() - began < 15


@pytest.mark.slow
def test_a_refused_import_that_left_a_thread_ends_too() -> None:
    written("threading.Thread(target=time.sleep, args=[1e6]).start()\nsys.exit()\n")
    assert in_a_process("check", "m.yaml").returncode == 2


def interrupted(process: subprocess.Popen[str], times: Sequence[float]) -> tuple[str, str]:
    for pause in times:
        time.sleep(pause)
        process.send_signal(signal.SIGINT)
    return process.communicate(timeout=30)


@pytest.mark.slow
@pytest.mark.parametrize(("code", "presses"), [("while True: pass", 3), ("endless()", 4)])
def test_the_third_ctrl_c_ends_what_has_no_limit_and_the_fourth_what_swallows_it(
    code: str, presses: int
) -> None:
    text = SWALLOWS + behavior(f"print('stuck', flush=True)\n{code}")
    written(text)
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.cli.drone_cli", "run", "m.yaml", "--call-limit", "none"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stderr is not None
        for line in process.stderr:
            if "stuck" in line:
                break
        for _ in range(presses):
            assert process.poll() is None
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130
    (folder,) = Path("runs").iterdir()
    assert read_run(folder).missing == ("summary.json is not there",)


@pytest.mark.slow
def test_ctrl_c_ends_an_import() -> None:
    written("print('stuck', file=sys.stderr, flush=True)\nwhile True: pass\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.cli.drone_cli", "check", "m.yaml"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stderr is not None and "stuck" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
    finally:
        process.kill()
    assert (process.returncode, err) == (130, "")
