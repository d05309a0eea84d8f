"""The configuration of a project, and what is said of a wrong one."""

import json

import pytest

from vibrom.config import settings
from vibrom.config.errors import SettingsError


def load(project, *overlays, **command):
    return settings.load(project / "config", overlays, command)


def complaint(project, *overlays, **command) -> str:
    with pytest.raises(SettingsError) as caught:
        load(project, *overlays, **command)
    line = str(caught.value)
    assert line.isprintable()
    return line


def overlay(folder, text: str | bytes):
    path = folder / "mine.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def shown(run) -> str:
    """What rules see of the settings."""
    blocks = [
        {name: item.to_builtins() for name, item in block.items()}
        for block in (run.scenes, run.methods)
    ]
    return json.dumps([blocks, run.studies, run.integrator, run.seeds])
