"""Completion: what can stand at the cursor, and that bash, zsh and fish insert it."""

from __future__ import annotations

import os
import pty
import re
import select
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cli.main import COMMANDS
from runner.missions import SHIPPED
from tests.cli.run_cli import run_cli
from worlds import world_names

ROOT = Path(__file__).parents[2]
SHELLS = ("bash", "zsh", "fish")
OWN = "from behaviors import Behavior\nclass Wiggle(Behavior):\n    def step(self, flight): ...\n"


@pytest.fixture
def complete(monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, str]]:
    """Words that can stand at the end of a command line, each with what it is."""

    def words(line: str, shell: str = "zsh") -> dict[str, str]:
        monkeypatch.setenv("COMP_LINE", f"drone-cli {line}")
        monkeypatch.setenv("COMP_WORDBREAKS", " \t\n\"'@><=;|&(:")
        result = run_cli("completion", shell, "--at-cursor")
        assert (result.code, result.err) == (0, "")
        rows = [row.partition("\t") for row in result.out.splitlines() if row]
        return {word: text for word, _, text in rows}

    return words


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with missions, a world and Python."""
    (tmp_path / "missions").mkdir()
    shutil.copy(SHIPPED / "first_flight.yaml", tmp_path / "missions/of_my_own.yaml")
    (tmp_path / "my yard.yaml").write_text("world: my_yard\n")
    (tmp_path / "wiggle.py").write_text(OWN)
    (tmp_path / "runs").mkdir()
    (tmp_path / ".hidden").mkdir()
    return tmp_path


def test_commands_and_their_help(complete: Callable[..., dict[str, str]]) -> None:
    assert complete("") == {name: text for name, (_, text) in COMMANDS.items()}
    assert [*complete("ch")] == ["check"]
    assert "--help" in complete("no_such_command --")  # what is wrong is said when it is run


def test_missions_by_name_and_path(complete: Callable[..., dict[str, str]], folder: Path) -> None:
    shipped = {path.stem for path in SHIPPED.glob("*.yaml")}
    for command in ("run", "check", "show", "missions"):
        found = {*complete(f"{command} ")}
        assert found == shipped | {"of_my_own", "missions/", "runs/", "my yard.yaml"}
    assert [*complete("run missions/")] == ["missions/of_my_own.yaml"]
    assert [*complete("check first_flight of")] == ["of_my_own"]
    assert [*complete("run .h")] == [".hidden/"]
    assert complete("run no/such/") == {}
    assert complete("run ~nobody_has_this_name/") == {}


def test_parameters_of_the_mission(
    complete: Callable[..., dict[str, str]], write: Callable[[str, str], str]
) -> None:
    assert complete("run first_flight -p ") == {
        "altitude=": "height of the flight",
        "side=": "length of a side of the square",
        "speed=": "speed along the sides",
    }
    assert [*complete("run first_flight -p side=3m --parameter s")] == ["side=", "speed="]
    assert [*complete("run first_flight --parameter=al")] == ["--parameter=altitude="]
    assert complete("run -p ") == {}
    assert complete("run no_such -p ") == {}
    write("torn.yaml", "states: [")
    assert complete("run torn.yaml -p ") == {}
    write("wrong.yaml", "mission: w\nparameters: {reach: 3 m}\nstates: {a: {do: 5, on: 7}}\n")
    assert complete("run wrong.yaml -p ") == {"reach=": "3 m"}


def test_parameters_of_the_vehicles_of_a_fleet(complete: Callable[..., dict[str, str]]) -> None:
    found = complete("run handover -p ")
    assert found["sentry.side="] == "length of the square's sides"
    assert found["relief.rounds="] == "rounds to fly"
    assert [*complete("run handover -p relief.s")] == ["relief.speed="]


def test_worlds(complete: Callable[..., dict[str, str]], folder: Path) -> None:
    for line in ("run first_flight --world ", "check --world ", "show --world ", "worlds "):
        found = {*complete(line)}
        assert found > {*world_names(), "forest:", "roads:", "missions/", "my yard.yaml"}
        assert "wiggle.py" not in found
    assert [*complete("run --world=fo")] == ["--world=forest:"]


def test_behaviours_also_of_a_file_which_is_not_run(
    complete: Callable[..., dict[str, str]], write: Callable[[str, str], str]
) -> None:
    assert [*complete("behaviors r")] == ["reset", "return_home", "route"]
    write("mine.py", OWN + "raise SystemExit\n")
    assert [*complete("behaviors --uses mine.py wi")] == ["wiggle"]
    assert "goto" in complete("behaviors --uses mine.py ")
    assert "goto" in complete("behaviors --uses gone.py ")


def test_words_of_options_and_folders(
    complete: Callable[..., dict[str, str]], folder: Path
) -> None:
    assert [*complete("run --backend ma")] == ["mavlink"]
    assert [*complete("completion ")] == ["bash", "zsh", "fish"]
    assert [*complete("picture ")] == ["missions/", "runs/"]
    assert complete("run --json") == {"--json": "Print the summary as JSON, and nothing else."}


def test_a_word_in_quotes_or_with_a_blank(
    complete: Callable[..., dict[str, str]], folder: Path
) -> None:
    assert [*complete("worlds 'my ")] == ["my yard.yaml"]
    assert [*complete("worlds my\\ ")] == ["my yard.yaml"]
    assert [*complete("worlds my", "bash")] == ["my\\ yard.yaml"]


def test_bash_replaces_what_follows_a_break(complete: Callable[..., dict[str, str]]) -> None:
    assert [*complete("run first_flight --world=fo", "bash")] == ["forest:"]
    assert [*complete("run first_flight --parameter=al", "bash")] == ["altitude="]


@pytest.mark.parametrize("shell", SHELLS)
def test_the_scripts_are_printed(shell: str) -> None:
    result = run_cli("completion", shell)
    assert (result.code, result.err) == (0, "")
    assert f"completion {shell} --at-cursor" in result.out


# -- in the shells ---------------------------------------------------------------------------------

START = {
    "bash": (["bash", "--noprofile", "--norc", "-i"], "source <(drone-cli completion bash)"),
    "zsh": (["zsh", "-f", "-i"], "source <(drone-cli completion zsh)"),
    "fish": (["fish", "--no-config", "-i"], "drone-cli completion fish | source"),
}
LINES = {
    "drone-cli ru\tfirs\t": ["run", "first_flight"],
    "drone-cli run first_flight -p si\t3m": ["run", "first_flight", "-p", "side=3m"],
    "drone-cli run first_flight --world fo\t3": ["run", "first_flight", "--world", "forest:3"],
    "drone-cli run first_flight --world=fo\t3": ["run", "first_flight", "--world=forest:3"],
    "drone-cli check missions/o\t --wor\tslal\t": [
        *("check", "missions/of_my_own.yaml", "--world", "slalom")
    ],
    "drone-cli check mis\tof\t": ["check", "missions/of_my_own.yaml"],
    "drone-cli behaviors --uses wig\twig\t": ["behaviors", "--uses", "wiggle.py", "wiggle"],
    "drone-cli worlds my\t": ["worlds", "my yard.yaml"],
    "true && drone-cli worlds bea\t": ["worlds", "beacons"],
}
"""What is typed, and the arguments that the program is then given."""


class Terminal:
    """A shell on a pseudo-terminal."""

    def __init__(self, command: list[str], folder: Path) -> None:
        self.pid, self.master = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ["TERM"] = "dumb" if command[0] == "zsh" else "xterm"
            os.execvp(command[0], command)
        self.text = ""

    def type(self, line: str) -> None:
        os.write(self.master, line.encode())

    def wait_for(self, pattern: str) -> re.Match[str]:
        """Read until a pattern stands in what was not yet found."""
        end = time.monotonic() + 30
        while (found := re.search(pattern, self.text)) is None:
            ready, _, _ = select.select([self.master], [], [], max(0, end - time.monotonic()))
            assert ready, f"no {pattern!r} in {self.text!r}"
            self.text += os.read(self.master, 65536).decode(errors="replace")
        self.text = self.text[found.end() :]
        return found

    def close(self) -> None:
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.master)


@pytest.fixture(params=SHELLS)
def terminal(
    request: pytest.FixtureRequest, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Terminal]:
    """A shell with completion, in which `drone-cli` prints the arguments it is given."""
    shell = request.param
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    bin_ = folder / ".hidden"
    program = bin_ / "drone-cli"
    program.write_text(
        '#!/bin/sh\nif [ "$1" = completion ]; then\n'
        f'PYTHONPATH="{ROOT}" exec "{sys.executable}" -m tests.cli.drone_cli "$@"\nfi\n'
        "printf 'given:'; printf '<%s>' \"$@\"; echo ' end'\n"
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(bin_), prepend=os.pathsep)
    monkeypatch.setenv("HOME", str(bin_))
    command, source = START[shell]
    terminal = Terminal(command, folder)
    try:
        terminal.type(f"{source}; echo read''y\r")
        terminal.wait_for(r"\bready\r?\n")
        yield terminal
    finally:
        terminal.close()


@pytest.mark.slow
def test_a_shell_inserts_what_completes_the_line(terminal: Terminal) -> None:
    for line, arguments in LINES.items():
        terminal.type(f"{line}\r")
        given = terminal.wait_for(r"given:((?:<[^>]*>)*) end\r?\n")[1]
        assert given == "".join(f"<{word}>" for word in arguments), line


@pytest.mark.slow
def test_a_shell_shows_what_there_is(terminal: Terminal) -> None:
    terminal.type("drone-cli run first_flight -p \t\t")
    for name in ("altitude=", "side=", "speed="):
        terminal.wait_for(re.escape(name))
