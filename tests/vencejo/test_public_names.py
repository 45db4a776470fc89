"""The names that packages offer to the programs of others."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

import pytest

PACKAGES = ("vencejo", "fsm", "hal", "worlds", "behaviors", "runner")


@pytest.mark.parametrize("name", PACKAGES)
def test_all_of_them_are_there(name: str) -> None:
    package = import_module(name)
    public = getattr(package, "__all__", ())
    assert len(set(public)) == len(public)
    for each in public:
        found = getattr(package, each)
        assert not isinstance(found, ModuleType), each


def test_the_runner_s_are_those_of_its_modules() -> None:
    """They are imported when they are used, by a table of their modules."""
    runner = import_module("runner")
    assert runner.__all__ == sorted(runner.__all__)
    for each in runner.__all__:
        found = getattr(runner, each)
        assert found.__name__ == each and found.__module__.startswith("runner.")
    with pytest.raises(AttributeError, match="module 'runner' has no attribute 'flyy'"):
        _ = runner.flyy
