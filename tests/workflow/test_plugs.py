"""What is read of a plug's text is what Python makes of it."""

import dataclasses
import importlib
import json
import shutil

import msgspec
import pytest

from vibrom.config import plugs, source
from vibrom.config.check import checked
from vibrom.config.errors import ConfigError, SettingsError

ALL = [(folder, name) for folder in plugs.PLUGS for name in plugs.names(folder)]
FORGETFUL = [
    source.tree,
    source.is_package,
    source.is_module,
    source._lines,
    plugs.names,
    plugs.names_of,
    plugs.class_of,
    plugs.declared,
]


def refuse(path, value, cure):
    raise SettingsError("here", path, value, cure)


@pytest.mark.parametrize("folder, name", ALL)
def test_fields_and_defaults_are_those_of_the_class(folder, name):
    """And every default is of its own kind."""
    kind = plugs.settings_of(folder, name)
    module = importlib.import_module(plugs.module_of(folder, name))
    fields = {item.name: item for item in dataclasses.fields(getattr(module, kind.__name__))}
    declared = {item.name: item for item in msgspec.inspect.type_info(kind).fields}
    assert set(declared) == set(fields)
    for key, item in declared.items():
        real = fields[key]
        if real.default_factory is not dataclasses.MISSING:
            default = real.default_factory()
        else:
            default = real.default
        assert item.required == (default is dataclasses.MISSING)
        if not item.required:
            made = item.default_factory()
            assert made == default
            checked(msgspec.to_builtins(made), plugs.kinds_of(kind)[key], (key,), refuse)


@pytest.mark.parametrize("folder, name", ALL)
def test_a_schema_of_every_plug_can_be_written(folder, name):
    """Documentation is made from it; what stands beside a field is its description."""
    schema = msgspec.json.schema(plugs.settings_of(folder, name))
    assert json.loads(json.dumps(schema))["$defs"]


def test_descriptions_stand_beside_or_above_the_field():
    kinds = msgspec.json.schema(plugs.settings_of("effects", "stop"))["$defs"]["Stop"]["properties"]
    assert (
        kinds["stiffness"]["description"] == "N/m" and kinds["stiffness"]["exclusiveMinimum"] == 0
    )
    assert kinds["side"]["description"].startswith("of the node on which the stop lies")


BAD_PLUG = """
from dataclasses import dataclass, field

import numpy as np

from vibrom.config.kinds import Positive
from vibrom.effects.gravity import Gravity

Several = list[int]


@dataclass(frozen=True)
class Inner:
    size: Positive = 2.0  # m


@dataclass(frozen=True)
class Odd(Gravity):
    inner: Inner = field(default_factory=Inner)
    these: Several = field(default_factory=lambda: [1, 2])
    wrong: {kind} = {default}
"""


@pytest.fixture
def odd(tmp_path, monkeypatch):
    """odd(kind, default): the settings of an effect with a field of this kind and default."""
    copy = tmp_path / "vibrom"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(source.PACKAGE, copy, ignore=ignored)
    monkeypatch.setattr(source, "PACKAGE", copy)

    def forget():
        for function in FORGETFUL:
            function.cache_clear()

    def settings(kind, default):
        (copy / "effects/odd.py").write_text(BAD_PLUG.format(kind=kind, default=default))
        forget()
        return plugs.settings_of("effects", "odd")

    yield settings
    monkeypatch.undo()
    forget()


def test_blocks_factories_and_inherited_fields_are_read(odd):
    made = checked({"inner": {"size": 3}}, odd("int | None", "None"), (), refuse)
    assert made.pop("z") == 0.0
    assert made == {"x": 0.0, "y": -9.81, "inner": {"size": 3.0}, "these": [1, 2], "wrong": None}
    with pytest.raises(SettingsError, match=r"inner.size = 0 must be greater than 0; .* \(m\)"):
        checked({"inner": {"size": 0}}, odd("int", "1"), (), refuse)


@pytest.mark.parametrize("kind, default", [("np.ndarray", "1"), ("int", "np.zeros(3)")])
def test_what_cannot_be_read_from_the_text_is_one_line(odd, kind, default):
    with pytest.raises(ConfigError) as refused:
        odd(kind, default)
    line = str(refused.value)
    assert "effects/odd.py: Odd.wrong cannot be read from the text" in line and "\n" not in line
    assert line.endswith("take a kind of vibrom.config.kinds, and a literal as the default")
