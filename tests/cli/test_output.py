"""Output that cannot be written, in all commands: it ends no flight and loses nothing else."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from io import BytesIO, StringIO, TextIOWrapper
from pathlib import Path

import pytest

from cli.main import COMMANDS
from cli.output import Output
from runner import read_run
from runner.recorder import Recorder
from tests.cli.run_cli import run_cli
from vencejo.errors import UserError

ROOT = Path(__file__).parents[2]
EVERY_COMMAND = {
    "": 0,
    "--help": 0,
    "--version": 0,
    "run hop.yaml": 0,
    "run hop.yaml --json": 0,
    "check hop.yaml": 0,
    "check hop.yaml --json": 0,
    "check wrong.yaml": 2,
    "show hop.yaml": 0,
    "show hop.yaml --format svg": 0,
    "missions": 0,
    "missions first_flight --json": 0,
    "behaviors": 0,
    "behaviors goto": 0,
    "worlds": 0,
    "worlds yard": 0,
    "schema": 0,
    "new mine": 0,
    "picture flown": 0,
    "completion bash": 0,
    "fly hop.yaml": 2,
}
"""Every command, and its exit code where all that it says can be read."""


def drone_cli(
    command: str, folder: Path, then: str = "", **environment: str
) -> subprocess.CompletedProcess[bytes]:
    """A command in a shell of its own, with a redirection or a pipe ``then``."""
    line = f"{sys.executable} -m tests.cli.drone_cli {command} {then}"
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", line],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=60,
        check=False,
    )


@pytest.fixture
def folder(hop: str, tmp_path: Path, undrawn: None) -> Path:
    """A folder with a mission, a wrong one, and a run."""
    (tmp_path / "wrong.yaml").write_text("mission: wrong\nstates: {a: {do: fly → there}}\n")
    assert run_cli("run", hop, "--runs-dir", "runs").code == 0
    (run,) = (tmp_path / "runs").iterdir()
    run.rename(tmp_path / "flown")
    return tmp_path


def test_every_command_is_tried() -> None:
    assert {command.split(" ")[0] for command in EVERY_COMMAND} >= set(COMMANDS)


@pytest.mark.slow
@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_a_pipe_that_closes(command: str, folder: Path) -> None:
    done = drone_cli(command, folder, "| true")
    lands = command == "run hop.yaml"
    assert done.returncode == (130 if lands else EVERY_COMMAND[command])
    if EVERY_COMMAND[command] == 0:
        assert done.stderr == b""
    assert b"Traceback" not in done.stderr and b"Exception" not in done.stderr
    if command.startswith("run"):
        assert_landed(folder)


@pytest.mark.slow
@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_a_full_disk_behind_the_output(command: str, folder: Path) -> None:
    done = drone_cli(command, folder, "> /dev/full")
    if EVERY_COMMAND[command] == 0:
        assert done.returncode == 4
        assert done.stderr.decode() == (
            "error: the output could not be written: No space left on device [output-lost]\n"
        )
    else:
        assert done.returncode == EVERY_COMMAND[command]
        assert b"Traceback" not in done.stderr
    if command.startswith("run"):
        assert_landed(folder)
        (run,) = (folder / "runs").iterdir()
        summary = read_run(run).summary
        assert summary is not None and summary.alone.outcome == "done"


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_an_encoding_without_arrows(command: str, encoding: str, folder: Path) -> None:
    done = drone_cli(command, folder, PYTHONIOENCODING=encoding)
    assert done.returncode == EVERY_COMMAND[command]
    text = (done.stdout + done.stderr).decode(encoding)
    assert "Traceback" not in text
    if command == "run hop.yaml":
        assert "-> land (done)  altitude 1.0 m" in text
        assert "ok hop ended in 'done'" in text


@pytest.mark.slow
@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_a_dumb_terminal(command: str, folder: Path) -> None:
    code, text = on_a_terminal(command, folder, TERM="dumb")
    assert code == EVERY_COMMAND[command]
    assert "\x1b" not in text and "Traceback" not in text
    if command == "run hop.yaml":
        assert "→ land (done)  altitude 1.0 m" in text
        assert "✔ hop ended in 'done'" in text


@pytest.mark.slow
def test_other_terminals_are_drawn_on(folder: Path) -> None:
    code, text = on_a_terminal("run hop.yaml", folder, TERM="xterm")
    assert code == 0
    assert "\x1b" in text and "from above, north up" in text
    code, text = on_a_terminal("run hop.yaml", folder, TERM="xterm", PYTHONIOENCODING="ascii")
    assert code == 0
    assert "\x1b" not in text and "-> land (done)  altitude 1.0 m" in text


@pytest.mark.slow
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_descriptors(closed: str, folder: Path) -> None:
    """What the engine prints by itself must not get into the run's files either."""
    assert drone_cli("run hop.yaml", folder, closed).returncode == 0
    assert_landed(folder)
    (run,) = (folder / "runs").iterdir()
    assert read_run(run).missing == ()
    assert read_run(run).events[-1].fields["outcome"] == "done"


def on_a_terminal(command: str, folder: Path, **environment: str) -> tuple[int, str]:
    """The exit code and output of a command on a pseudo-terminal."""
    code = (
        "import os, pty, sys\n"
        "ended = pty.spawn([sys.executable, '-m', 'tests.cli.drone_cli', *sys.argv[1:]])\n"
        "sys.exit(os.waitstatus_to_exitcode(ended))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *command.split()],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "100", **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout.decode()


def assert_landed(folder: Path) -> None:
    (run,) = (folder / "runs").iterdir()
    last = read_run(run).telemetry["drone"][-1]
    assert last.mode == "landed" and abs(last.position.z) < 0.05


# -- the stream ------------------------------------------------------------------------------------


def test_a_full_disk_is_remembered_and_said_no_more() -> None:
    with Path("/dev/full").open("w") as full:
        out = Output(full)
        print("→", file=out)
        assert out.lost == ""  # it is in the buffer
        print("→", file=out, flush=True)
        assert (out.lost, out.gone) == ("No space left on device", False)
        print("→", file=out, flush=True)


def test_a_closed_pipe_is_nothing_lost() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        out = Output(pipe)
        print("→", file=out, flush=True)
        assert (out.lost, out.gone) == ("", True)


def test_a_stream_that_was_closed_by_the_program_itself() -> None:
    stream = StringIO()
    out = Output(stream)
    stream.close()
    print("→", file=out, flush=True)
    assert out.lost == "it was closed"
    assert not out.isatty()


def test_no_stream_at_all() -> None:
    out = Output(None)
    print("→", file=out, flush=True)
    assert (out.lost, out.gone, out.isatty(), out.unicode) == ("", False, False, True)


@pytest.mark.parametrize(
    ("encoding", "written"),
    [("ascii", b"-> ? ? ok a"), ("latin-1", b"-> \xe4 ? ok a"), ("utf-8", "→ ä 鸟 ✔ a".encode())],
)
def test_characters_that_an_encoding_lacks(encoding: str, written: bytes) -> None:
    raw = BytesIO()
    out = Output(TextIOWrapper(raw, encoding))
    print("→ ä 鸟 ✔ a", end="", file=out, flush=True)
    assert raw.getvalue() == written
    assert out.unicode == (encoding == "utf-8")


def test_a_file_name_that_is_no_text(tmp_path: Path) -> None:
    raw = BytesIO()
    out = Output(TextIOWrapper(raw, "utf-8"))
    print("m\udcff.yaml", end="", file=out, flush=True)
    assert raw.getvalue() == b"m?.yaml"


# -- the record ------------------------------------------------------------------------------------


def full_after_2_s(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = Recorder.take

    def take(self: Recorder, pilot: object) -> object:
        if pilot.channel.now > 2:  # type: ignore[attr-defined]
            raise UserError("cannot-record", "no room")
        return taken(self, pilot)  # type: ignore[arg-type]

    monkeypatch.setattr(Recorder, "take", take)


def no_summary(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Recorder, summary: object) -> None:
        raise UserError("cannot-record", "no room")

    monkeypatch.setattr(Recorder, "write_summary", refuse)


def no_closing(monkeypatch: pytest.MonkeyPatch) -> None:
    closed = Recorder.close

    def close(self: Recorder) -> None:
        closed(self)
        raise UserError("cannot-record", "no room")

    monkeypatch.setattr(Recorder, "close", close)


@pytest.mark.parametrize("happens", [full_after_2_s, no_summary, no_closing])
def test_a_flight_that_cannot_be_recorded_lands_and_is_summed_up(
    happens: Callable[[pytest.MonkeyPatch], None],
    hop: str,
    undrawn: None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    happens(monkeypatch)
    done = run_cli("run", hop)
    assert done.code == 4
    assert done.err == "error: no room [cannot-record]\n"
    outcome = "aborted" if happens is full_after_2_s else "done"
    assert f"hop ended in '{outcome}'" in done.out
    assert "run folder: " in done.out
    done = run_cli("run", hop, "--json")
    summary = json.loads(done.out)
    assert (done.code, summary["outcome"], summary["exit_code"]) == (4, outcome, 4)
    assert (summary["success"], summary["unrecorded"]) == (False, "error: no room [cannot-record]")
    if happens is not no_summary:
        run = read_run(summary["run_folder"])
        assert run.summary is not None
        assert (run.summary.exit_code, run.summary.unrecorded) == (4, summary["unrecorded"])


def test_a_picture_without_room_is_told(hop: str, monkeypatch: pytest.MonkeyPatch) -> None:
    write_bytes = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if path.name == "flight.png.part":
            raise OSError(28, "No space left on device")
        return write_bytes(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    done = run_cli("run", hop)
    assert done.code == 4
    assert "no picture: " in done.err and "No space left on device [cannot-write]" in done.err
    (run,) = Path("runs").iterdir()
    assert [path.name for path in run.iterdir() if "flight" in path.name] == []
    assert "✔ hop ended in 'done'" in done.out


def test_a_drawing_is_interrupted_without_losing_the_rest(
    hop: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(folder: Path) -> Path:
        os.kill(os.getpid(), signal.SIGINT)
        raise AssertionError("it goes on")

    monkeypatch.setattr("cli.plot.draw", interrupted)
    done = run_cli("run", hop)
    assert done.code == 0
    assert done.err.startswith("no picture: interrupted; drawn by `drone-cli picture runs/")
    assert "✔ hop ended in 'done'" in done.out and "run folder: " in done.out


@pytest.mark.parametrize(
    ("command", "code"),
    [
        (("show", "hop.yaml", "-o", "/dev/full"), 4),
        (("worlds", "yard", "--render", "full.png"), 4),
        (("worlds", "yard", "--render", "x.nothing"), 2),
        (("show", "hop.yaml", "-o", "no/such/folder/x.txt"), 2),
        (("worlds", "yard", "--render", "no/such/folder/x.png"), 2),
        (("new", "there/is"), 2),
    ],
)
def test_a_file_that_cannot_be_written(command: tuple[str, ...], code: int, hop: str) -> None:
    Path("full.png").symlink_to("/dev/full")
    done = run_cli(*command)
    assert done.code == code
    assert done.err.count("\n  hint") <= 1 and "error: " in done.err
    assert "Traceback" not in done.err


def test_a_folder_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(path: Path, *arguments: object, **more: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", refused)
    done = run_cli("new", "mine")
    assert done.code == 2
    assert (
        done.err == "mine: error: this cannot be read or written: Permission denied [no-access]\n"
    )
