"""Repeating a run from its folder, with the folder's own copies of what it depended on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from behaviors import Calls
from fsm.faults import Faults
from fsm.fleet import compile_until
from runner.fleets import standing
from runner.kept_files import file_hash
from runner.missions import Found
from runner.plan import Assignment, Fleet, Plan
from runner.preparation import prepare
from runner.run_folder import EVENTS, Header, read_header
from runner.settings import MissionSettings, RunSettings
from vencejo.errors import Fault, UserError, Where
from vencejo.version import __version__
from worlds import find_world


@dataclass(frozen=True)
class Recorded:
    """A run as its folder tells it, to be flown again."""

    folder: Path
    header: Header
    settings: RunSettings

    @classmethod
    def read(cls, folder: Path) -> Recorded:
        """Raises UserError: ``no-run`` and others of ``read_run``, ``no-settings`` for a run of a
        release that did not keep them, ``changed-copy`` for each file that is not as it was flown.
        """
        header = read_header(folder)
        if header.settings is None:
            message = f"this run does not say with which settings it was flown, by {header.vencejo}"
            place = Where(str(folder / EVENTS), 1, 1)
            hint = "it was recorded before runs kept their settings; fly its mission anew"
            raise UserError("no-settings", message, place, hint)
        faults = list(_changed(folder, header.settings))
        if faults:
            raise UserError.of(faults)
        return cls(folder, header, header.settings)

    def plan(self, calls: Calls) -> Plan:
        """The plan of that run. Runs the folder's Python files, as ``calls``. Raises UserError."""
        settings, folder = self.settings, self.folder
        world = str(folder / settings.world)
        assignments = {
            vehicle: self._assignment(mission, world, calls)
            for vehicle, mission in settings.missions.items()
        }
        plan = Plan(
            assignments,
            settings.backend,
            settings.seed,
            settings.own,
            settings.connect,
            settings.profile,
            settings.limits,
            folder / settings.camera_file if settings.camera_file else None,
            settings.post,
            self._fleet(assignments),
        )
        if plan.world.sha256 != self.header.world_sha256:
            where = Where(world)
            raise _change("a file that this world names is not as it was flown", where)
        return plan

    def _assignment(self, mission: MissionSettings, world: str, calls: Calls) -> Assignment:
        if mission.file:
            path = self.folder / mission.file
            peers = self.settings.missions if self.settings.fleet else None
            prepared = prepare(Found(path, str(path)), world, calls=calls, peers=peers)
            known = set(prepared.graph.parameters)
            _require_same_parameters(known, set(mission.parameters), path)
        else:
            prepared = standing(find_world(world), world)
        return Assignment(
            prepared,
            mission.parameters,
            stands=not mission.file,
            model=self._model(mission.model),
            start=mission.start,
            color=mission.color,
        )

    def _model(self, word: str | None) -> str | None:
        """The word for a model, where it is a kept file that of its copy."""
        return str(self.folder / word) if word and word in self.settings.files else word

    def _fleet(self, assignments: Mapping[str, Assignment]) -> Fleet | None:
        name, file, text = self.settings.fleet, self.settings.fleet_file, self.settings.until
        if not name:
            return None
        graphs = {vehicle: each.prepared.graph for vehicle, each in assignments.items()}
        where = Where(str(self.folder / EVENTS), 1, 1)
        until = compile_until(text, where, graphs, Faults()) if text else None
        contest = self.settings.referee
        return Fleet(name, until, self.folder / file if file else None, contest)

    def doubt(self) -> Fault | None:
        """A warning where another release is at work than flew this run."""
        flown = self.header.vencejo
        if flown == __version__:
            return None
        message = f"this run was flown by vencejo {flown}; {__version__} may fly it otherwise"
        return Fault("other-release", message, Where(str(self.folder)), severity="warning")


def _changed(folder: Path, settings: RunSettings) -> Iterator[Fault]:
    """A fault for each copy that is not there or not as it was flown."""
    for name, flown in settings.files.items():
        path = folder / name
        try:
            found = file_hash(path.read_bytes())
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            yield from _change(f"this copy cannot be read: {reason}", Where(str(path))).faults
            continue
        if found != flown:
            message = f"this copy is not as it was flown: its SHA-256 is {found[:12]}…, and was "
            yield from _change(f"{message}{flown[:12]}…", Where(str(path))).faults


def _require_same_parameters(known: set[str], given: set[str], path: Path) -> None:
    if known != given:
        message = (
            f"it has other parameters than the run gave it: {', '.join(sorted(known ^ given))}"
        )
        raise _change(message, Where(str(path)))


def _change(message: str, where: Where) -> UserError:
    hint = "put back what was flown; or fly the changed one as a mission: drone-cli run MISSION"
    return UserError("changed-copy", message, where, hint)
