"""What is installed, `vibrom`; whether a configuration is fine, `vibrom check [overlay ...]`; a
scene from files of recorded motion, `vibrom record FILE ... --out config/scenes/NAME.yaml`; a run's
scores beside those of the project's own run, `vibrom compare results/scores.csv`.
"""

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import vibrom
from vibrom.artefacts.files import DataError
from vibrom.config import plugs, settings
from vibrom.config.errors import ConfigError

KINDS = ("bodies", "effects", "methods", "experiments", "studies")
EXTRAS = {
    "train": ("torch", "autoencoders can be trained"),
    "workflow": ("snakemake", "the whole workflow can be run"),
    "pardiso": ("pypardiso", "wide bands are factorised by PARDISO"),
}


def report() -> str:
    """The version, the plugs that are there, and the extras."""
    lines = [f"vibrom {vibrom.__version__} in {Path(vibrom.__file__).parent}"]
    lines += [f"{kind:12} {', '.join(plugs.names(kind))}" for kind in KINDS]
    for extra, (package, use) in EXTRAS.items():
        there = "yes" if find_spec(package) else f"no: install vibrom[{extra}]"
        lines.append(f"{use}: {there}")
    return "\n".join(lines)


def check(folder: Path, overlays: list[Path]) -> str:
    """What the configuration in `folder` asks for, with the overlays laid over it, read as the
    workflow reads it, its bodies built; or one line that names file or scene, key, value and cure.
    """
    asked = settings.load(folder, overlays)
    for name, scene in asked.scenes.items():
        build(name, scene.to_builtins())
    lists = ("scenes", "methods", "experiments", "studies")
    lines = [f"{name:12} {', '.join(getattr(asked, name))}" for name in lists]
    return "\n".join(["The configuration is fine.", *lines, f"{'results':12} {asked.results}"])


def build(name: str, scene: dict[str, Any]) -> None:
    """What only the body tells: nodes, groups of its mesh file, boundaries that effects name."""
    if "body" not in scene:  # it is recorded
        return
    from vibrom import effects
    from vibrom.artefacts.hardware import TooLarge
    from vibrom.bodies import space
    from vibrom.term import SceneError

    try:
        effects.assemble(space.build(scene["body"]), scene["effects"])
    except (SceneError, TooLarge) as error:
        raise ConfigError(f"scene {name}: {error}") from error


def record(
    files: list[Path],
    out: Path,
    step: float | None,
    forced: tuple[Path, ...],
    signal: str | None,
) -> str:
    """Writes the file of a scene of recorded motion, with comments, and says what was found."""
    from vibrom.recordings import start

    return start.written(files, out, step, forced, signal)


def compare(scores: Path, reference: Path, keep: bool) -> str:
    """How many of the reference's scores a run has within their tolerances, and which not; ends
    with 1 where there are some.
    """
    from vibrom.report import reference as known

    if keep:
        return known.keep(scores, reference)
    words, same = known.compared(scores, reference)
    if not same:
        print(words)
        sys.exit(1)
    return words


def main() -> None:
    """The command `vibrom`."""
    parser = argparse.ArgumentParser(prog="vibrom", description=vibrom.__doc__)
    parser.add_argument("--version", action="version", version=f"vibrom {vibrom.__version__}")
    commands = parser.add_subparsers(dest="command")
    about = "is the configuration fine, with these overlays?"
    checking = commands.add_parser("check", help=about, description=check.__doc__)
    checking.add_argument("overlays", nargs="*", type=Path, help="as given to --configfile")
    checking.add_argument("--folder", type=Path, default="config", help="of config.yaml")
    about = "write a scene of recorded motion"
    recording = commands.add_parser("record", help=about, description=record.__doc__)
    recording.add_argument("files", nargs="+", type=Path, help="text, NumPy, MATLAB or netCDF")
    recording.add_argument("--out", required=True, type=Path, help="config/scenes/NAME.yaml")
    recording.add_argument("--step", type=float, help="time between samples without instants")
    about = "motions under a signal, beside the decays"
    recording.add_argument("--forced", nargs="+", default=[], type=Path, help=about)
    recording.add_argument("--signal", help="the column or array in them that drove them")
    about = "are a run's scores those of the project's own run?"
    comparing = commands.add_parser("compare", help=about, description=compare.__doc__)
    comparing.add_argument("scores", type=Path, help="results/scores.csv")
    comparing.add_argument("--reference", type=Path, default="config/reference_scores.csv")
    about = "make them the reference instead"
    comparing.add_argument("--keep", action="store_true", help=about)
    given = parser.parse_args()
    if given.command is None:
        print(report())
        return
    try:
        if given.command == "record":
            print(record(given.files, given.out, given.step, tuple(given.forced), given.signal))
        elif given.command == "compare":
            print(compare(given.scores, given.reference, given.keep))
        else:
            print(check(given.folder, given.overlays))
    except (ConfigError, DataError) as error:
        sys.exit(f"vibrom: {error}")


if __name__ == "__main__":
    main()
