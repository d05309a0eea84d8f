"""What is installed: `vibrom`, `python -m vibrom`; `vibrom --version`."""

import argparse
from importlib.util import find_spec
from pathlib import Path

import vibrom
from vibrom.config import plugs

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


def main() -> None:
    """The command `vibrom`."""
    parser = argparse.ArgumentParser(prog="vibrom", description=vibrom.__doc__)
    parser.add_argument("--version", action="version", version=f"vibrom {vibrom.__version__}")
    parser.parse_args()
    print(report())


if __name__ == "__main__":
    main()
