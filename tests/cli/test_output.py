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
from tests.cli.run_cli import Result, run_cli
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
    "models": 0,
    "models f450": 0,
    "worlds": 0,
    "worlds yard": 0,
    "schema": 0,
    "guide": 0,
    "new mine": 0,
    "picture flown": 0,
    "video flown": 2,
    "findings flown": 2,
    "tune": 0,
    "tune color nothing.png --at 1,1": 2,
    "doctor": 0,
    "doctor --json": 0,
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


WRITERS = {
    "missions first_flight --copy": "missions/first_flight.yaml",
    "new mine": "mine",
    "show hop.yaml --format svg -o it.svg": "it.svg",
    "worlds yard --render it.png": "it.png",
    "run hop.yaml": "runs",
}
"""Commands that write, and what."""


def assert_one_line(done: Result, code: int, command: str, reason: str) -> None:
    assert (done.code, done.out) == (code, "")
    first, _, hint = done.err.rstrip("\n").partition("\n")
    assert first.startswith(WRITERS[command]) and f": {reason} [" in first
    assert hint == "" or (hint.startswith("  hint: ") and "\n" not in hint)


@pytest.mark.parametrize("command", WRITERS)
def test_a_folder_that_cannot_be_written(
    command: str, hop: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(path: Path, *arguments: object, **more: object) -> None:
        raise OSError(30, "Read-only file system", str(path))

    for name in ("mkdir", "write_bytes", "write_text"):
        monkeypatch.setattr(Path, name, refused)
    done = run_cli(*command.split())
    assert_one_line(done, 2, command, "Read-only file system")
    assert [path.name for path in tmp_path.iterdir()] == [hop]


@pytest.mark.parametrize("command", WRITERS)
def test_a_disk_without_room_keeps_nothing_half_written(
    command: str, hop: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: object, **more: object) -> None:
        raise OSError(28, "No space left on device")

    for name in ("write_bytes", "write_text"):
        monkeypatch.setattr(Path, name, full)
    monkeypatch.setattr("shutil.copyfile", full)
    done = run_cli(*command.split())
    # A flight that cannot be recorded does not begin, and 4 says that it was flown.
    assert_one_line(done, 2 if command == "run hop.yaml" else 4, command, "No space left on device")
    left = [str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")]
    assert sorted(left) == ([hop, "runs"] if command == "run hop.yaml" else [hop])


def test_a_picture_over_an_old_one_is_whole_or_not_there(hop: str) -> None:
    Path("it.svg").write_text("old")
    assert run_cli("show", hop, "--format", "svg", "-o", "it.svg").code == 0
    assert Path("it.svg").read_text().startswith("<")
    assert [path.name for path in Path().iterdir() if "part" in path.name] == []


GONE = "the folder you are in has been deleted"
NEEDS_FOLDER = {
    "missions first_flight --copy": 2,
    "new mine": 2,
    "show first_flight -o it.svg": 2,
    "worlds yard --render it.png": 2,
    "run first_flight": 2,
    "behaviors --uses mine.py": 2,
    "run first_flight --runs-dir {}/runs": 0,
    "show first_flight -o {}/it.svg": 0,
    "check first_flight": 0,
    "missions": 0,
    "worlds yard": 0,
    "--help": 0,
}
"""Commands with their exit code where the working directory is gone; what needs it says so."""


@pytest.mark.slow
@pytest.mark.parametrize("command", NEEDS_FOLDER)
def test_a_working_directory_that_is_gone(command: str, tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    line = f'cd {folder} && rmdir {folder} && PYTHONPATH={ROOT} exec "$@"'
    words = command.format(tmp_path).split()
    done = subprocess.run(
        ["bash", "-c", line, "bash", sys.executable, "-m", "tests.cli.drone_cli", *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == NEEDS_FOLDER[command]
    if done.returncode:
        assert done.stdout == ""
        first, _, hint = done.stderr.rstrip("\n").partition("\n")
        assert GONE in first and "\n" not in hint
    else:
        assert done.stderr == ""
