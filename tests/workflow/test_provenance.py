"""What makes a result be made again: the code behind it, and nothing else."""

import json
import shutil
import subprocess
import sys

import pytest

from vibrom.artefacts import provenance
from vibrom.config import plugs, source

CACHED = [
    source.tree,
    source.is_package,
    source.is_module,
    plugs.names,
    plugs.names_of,
    plugs.class_of,
    provenance._store,
    provenance._read,
    provenance.imports,
    provenance.modules_behind,
    provenance.data_digest,
    provenance.attributes,
]


@pytest.fixture(scope="module")
def before():
    """The digests of the package as it is, and what was read for them."""
    return digests(), json.dumps(provenance._store())


@pytest.fixture
def package(before, tmp_path, monkeypatch):
    """A copy of the package to edit; what is not edited was parsed once for all tests."""
    copy = tmp_path / "vibrom"
    shutil.copytree(source.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    read = copy / "__pycache__" / f"provenance.{sys.implementation.cache_tag}.json"
    read.parent.mkdir()
    read.write_text(before[1])
    monkeypatch.setattr(source, "PACKAGE", copy)
    yield copy
    monkeypatch.undo()
    forget()


def forget():
    for function in CACHED:
        function.cache_clear()


def digests() -> dict[str, str]:
    """Of every method's fit, of every experiment, and of the other steps."""
    forget()
    found = {
        f"fit {name}": provenance.digest("vibrom.steps.fit", f"vibrom.methods.{name}")
        for name in plugs.names("methods")
    }
    found |= {
        f"ask {name}": provenance.digest("vibrom.steps.ask", f"vibrom.experiments.{name}")
        for name in plugs.names("experiments")
    }
    found["table"] = provenance.digest("vibrom.steps.output", "vibrom.report.tables.decay")
    return found | {
        name: provenance.digest(f"vibrom.steps.{name}")
        for name in ("structure", "scores", "tracking")
    }


def changed(before) -> set[str]:
    after = digests()
    return {name for name, digest in before[0].items() if digest != after[name]}


def rewrite(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_comments_docstrings_and_layout_change_nothing(package, before):
    path = package / "methods/ssmlearn.py"
    path.write_text(
        "# A comment.\n\n"
        + path.read_text().replace('"""', '"""Another word. ', 1)
        + "\n\n# The end.\n"
    )
    assert changed(before) == set()


def test_editing_a_method_touches_only_its_fit(package, before):
    rewrite(
        package / "methods/ssmlearn.py", "order_dynamics: Order = 3", "order_dynamics: Order = 5"
    )
    assert changed(before) == {"fit ssmlearn"}


def test_editing_an_experiment_touches_only_it(package, before):
    (package / "experiments/decay.py").open("a").write("\nEXTRA = 1\n")
    assert changed(before) == {"ask decay"}


def test_editing_what_all_share_touches_all(package, before):
    (package / "artefacts/data.py").open("a").write("\nEXTRA = 1\n")
    assert changed(before) == set(before[0])


def test_editing_the_sink_retrains_nothing(package, before):
    (package / "tracking/views.py").open("a").write("\nEXTRA = 1\n")
    assert changed(before) == {"tracking"}


def test_relative_and_lazy_imports_count(package):
    (package / "methods/ssmlearn.py").open("a").write(
        "\n\ndef later():\n    from ..kernels import banded\n    return banded\n"
    )
    forget()
    behind = provenance.modules_behind("vibrom.methods.ssmlearn")
    assert {
        "vibrom",
        "vibrom.methods",
        "vibrom.kernels",
        "vibrom.kernels.banded",
        "vibrom.models.rom",
    } <= behind


def test_versions_are_those_of_the_packages_behind():
    structure = json.loads(provenance.attributes("vibrom.steps.structure")["versions"])
    assert {"python", "numpy", "scipy", "scikit-fem"} <= set(structure) and not {
        "torch",
        "mlflow",
        "xarray",
    } & set(structure)
    assert "torch" in json.loads(provenance.attributes("vibrom.methods.split")["versions"])
    stored = json.loads(
        provenance.completed(provenance.attributes("vibrom.steps.structure"))["versions"]
    )
    assert {"vibrom", "xarray", "netCDF4"} <= set(stored)


def test_published_numbers_remake_tables_and_no_model(package, before):
    rewrite(package / "thesis/tables/decay.csv", "0.99619", "0.99618")
    assert changed(before) == {"table"}


def test_how_the_configuration_is_read_makes_nothing_again(package, before):
    """What a step gets is in its parameters."""
    for name in ("check", "files", "layers", "reading", "settings", "sweeps"):
        (package / f"config/{name}.py").open("a").write("\nEXTRA = 1\n")
    assert changed(before) <= {"table"}


def test_what_editors_and_compilers_leave_changes_nothing(package, before):
    (package / "latent/__pycache__").mkdir(exist_ok=True)
    for name in (
        "methods/.split.py.swp",
        "methods/split.py~",
        "latent/__pycache__/kernel.nbc.tmp.1f2e",
        "solvers/.DS_Store",
    ):
        (package / name).write_bytes(b"passing")
    assert changed(before) == set()


def test_what_earlier_processes_read_is_not_believed_after_an_edit(package, monkeypatch):
    """Three processes: one that parses, one that finds what the first read, one after an edit that
    keeps the file's length.
    """
    code = (
        "from vibrom.artefacts import provenance; "
        "print(provenance.digest('vibrom.methods.ssmlearn'), provenance.tree.cache_info().misses)"
    )
    monkeypatch.setenv("PYTHONPATH", str(package.parent))
    shutil.rmtree(package / "__pycache__")

    def process() -> list[str]:
        return subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.split()

    (first, parsed), (second, again) = process(), process()
    assert int(parsed) > 5 and int(again) == 0 and first == second
    rewrite(
        package / "methods/ssmlearn.py", "order_dynamics: Order = 3", "order_dynamics: Order = 5"
    )
    third, once = process()
    assert third != first and int(once) == 1
