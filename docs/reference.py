"""Writes the pages of the reference: from docstrings, and from settings where they are declared."""

import ast
import re

import mkdocs_gen_files
from msgspec import NODEFAULT, inspect, structs

from vibrom.artefacts.outcome import Outcome
from vibrom.config import plugs, source
from vibrom.report.differences import POINTS

PLUGS = {
    "bodies": "A body is a shape: `body.shape` of a scene names one, the others are its settings.",
    "effects": "What acts on a body. A scene lists the effects it has; what it does not list is "
    "not simulated, not imported and not compiled.",
    "signals": "What drives a load in the experiment `response`: `signal` of a load names one or "
    "more, which add up. A load without a signal is what the other experiments drive.",
    "methods": "How a reduced model is made. `config/methods/<name>.yaml` lists what differs from "
    "these defaults; a variant is such a file with `method:`.",
    "experiments": "One question, put to the full order and to every model alike. Settings stand "
    "in a scene under `experiments.<name>`.",
    "studies": "Experiments repeated while something varies. Settings stand in config.yaml under "
    "`studies.<name>`.",
}
CONFIGURATION = {
    "config.yaml": ("vibrom.config.settings", "Config"),
    "integrator": ("vibrom.models.rollout", "Integrator"),
    "config/methods/<name>.yaml": ("vibrom.config.method_file", "MethodFile"),
    "config/scenes/<name>.yaml": ("vibrom.config.scene", "Scene"),
    "config/scenes/<name>.yaml, recorded": ("vibrom.config.recorded", "RecordedScene"),
}
PYTHON = (
    "vibrom.api",
    "vibrom.models.model",
    "vibrom.models.rom",
    "vibrom.models.method",
    "vibrom.models.training",
    "vibrom.models.reduced",
    "vibrom.models.full_order",
    "vibrom.models.measures",
    "vibrom.experiments",
    "vibrom.studies",
    "vibrom.term",
)
BOUNDS = {"gt": "> {}", "ge": ">= {}", "lt": "< {}", "le": "<= {}"}


def docstring(module):
    """What a module's file says first; its equations, which are indented, become blocks of code."""
    return ast.get_docstring(ast.parse(source.path(module).read_bytes())) or ""


def words(kind):
    """A type of msgspec, as a reader of a yaml file would say it."""
    match kind:
        case inspect.Metadata():
            return words(kind.type)
        case inspect.IntType() | inspect.FloatType():
            bounds = [
                text.format(f"{bound:g}")
                for name, text in BOUNDS.items()
                if (bound := getattr(kind, name)) is not None
            ]
            name = "whole number" if isinstance(kind, inspect.IntType) else "number"
            return " ".join([name, " and ".join(bounds)]).strip()
        case inspect.BoolType():
            return "true or false"
        case inspect.LiteralType():
            return ", ".join(f"`{value}`" for value in kind.values)
        case inspect.ListType() | inspect.VarTupleType():
            return f"list of: {words(kind.item_type)}"
        case inspect.TupleType():
            return f"list of {len(kind.item_types)}: {words(kind.item_types[0])}"
        case inspect.DictType():
            value = words(kind.value_type)
            return f"mapping to: {value}" if value != "any" else "mapping"
        case inspect.UnionType():
            types = [item for item in kind.types if not isinstance(item, inspect.NoneType)]
            return " or ".join(map(words, types))
        case inspect.StructType():
            return "keys: " + ", ".join(f"`{item.name}`" for item in kind.fields)
        case inspect.StrType():
            return "text"
    return "any"


def about(kind):
    """The comment beside a setting."""
    said = [meta.description for meta in getattr(kind, "__metadata__", ()) if meta.description]
    return said[-1] if said else ""


def default(field):
    """Its default as yaml has it."""
    if field.default is not NODEFAULT:
        value = field.default
    elif field.default_factory is not NODEFAULT:
        value = field.default_factory()
    else:
        return "*to be given*"
    plain = {True: "true", False: "false", None: "none"} if isinstance(value, bool | None) else {}
    value = list(value) if isinstance(value, tuple) else value
    return f"`{plain.get(value, value) if plain else value}`"


def cell(text):
    """Text of a table's cell."""
    return re.sub(r"\s+", " ", str(text)).replace("|", "\\|")


def settings(declared):
    """A table of settings."""
    rows = [
        f"| `{item.name}` | {cell(words(inspect.type_info(item.type)))} | {cell(default(item))} "
        f"| {cell(about(item.type))} |"
        for item in structs.fields(declared)
    ]
    if not rows:
        return "No settings.\n"
    return "\n".join(["| setting | value | default | |", "|---|---|---|---|", *rows, ""])


def page(name, title, parts):
    """One file of the reference."""
    with mkdocs_gen_files.open(f"reference/{name}.md", "w") as file:
        file.write(f"# {title}\n\n" + "\n\n".join(parts) + "\n")


def plug_pages():
    """A page for each kind of plug."""
    for folder, opening in PLUGS.items():
        parts = [opening, f"Each is one file in `src/vibrom/{folder}/`."]
        for name in plugs.names(folder):
            module = plugs.module_of(folder, name)
            if (folder, name) == ("methods", "__init__"):
                continue
            parts += [f"## {name}", docstring(module), settings(plugs.settings_of(folder, name))]
        page(folder, folder.capitalize(), parts)


def configuration_page():
    """What the yaml files may hold."""
    parts = ["Every key, with its unit and default, as the code declares it."]
    for title, (module, name) in CONFIGURATION.items():
        declared = plugs.declared(module, name)
        parts += [f"## {title}", settings(declared)]
        for item in structs.fields(declared):
            parts += nested(item.name, inspect.type_info(item.type))
    page("configuration", "Configuration", parts)


def nested(name, kind):
    """The blocks below a key."""
    match kind:
        case inspect.Metadata():
            return nested(name, kind.type)
        case inspect.DictType():
            return nested(f"{name}.<name>", kind.value_type)
        case inspect.VarTupleType():
            return nested(f"{name}[]", kind.item_type)
        case inspect.UnionType():
            return [part for item in kind.types for part in nested(name, item)]
        case inspect.StructType():
            below = [
                part
                for item in structs.fields(kind.cls)
                for part in nested(f"{name}.{item.name}", inspect.type_info(item.type))
            ]
            return [f"### {name}", settings(kind.cls), *below]
    return []


def outputs_page():
    """Captions of all tables and figures."""
    parts = []
    for folder in ("tables", "figures"):
        parts.append(f"## {folder.capitalize()}")
        for name in plugs.names(f"report/{folder}"):
            text = docstring(plugs.module_of(f"report/{folder}", name))
            title, _, caption = text.partition("\n")
            parts += [f"### {name}", f"**{title.strip()}.** {caption.strip()}"]
    page("outputs", "Tables and figures", parts)


def outcomes_page():
    """Every word for how a run ended."""
    rows = [
        f"| `{item.value}` | {item.sentence} | {item.severity.name.lower()} "
        f"| {'yes' if item.has_value else 'no'} |"
        for item in Outcome
    ]
    head = ["| outcome | meaning | weight | numbers to compare |", "|---|---|---|---|"]
    page("outcomes", "Outcomes", ["How a run, a fit or a question ended.", "\n".join(head + rows)])


def thesis_page():
    """Where the thesis and this project differ: what the report says, without a run's numbers."""
    parts = [
        "Each point stands in `results/report.html` too, with its number of the run.",
        *(f"## {title}\n\n{why}" for title, why, _ in POINTS),
    ]
    with mkdocs_gen_files.open("thesis.md", "w") as file:
        file.write("# The thesis and we\n\n" + "\n\n".join(parts) + "\n")


thesis_page()
page("python", "Python", [f"::: {module}" for module in PYTHON])
plug_pages()
configuration_page()
outputs_page()
outcomes_page()
