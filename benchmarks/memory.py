"""Memory of a decay, of fits to it, of answers and of a study, up to 60 000 degrees of freedom.

The steps of the workflow on the folding beam in finer meshes, each in a process of its own, whose
peak of memory is listed beside what the rules ask for (`vibrom.config.memory`). A decay lasts 30
periods and keeps all samples, 100 to a period instead of the 1000 steps of the thesis, as it is the
samples that could fill the memory. Its file is larger than any of the processes. The answers of
the first fit and of the full order are those under a blow (`response`), too, and the study leaves
an effect out.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.growth import peak_memory
from benchmarks.table import Row
from vibrom.config import settings
from vibrom.config.memory import mem_mb
from vibrom.steps import ask, fit, record, release, scores, structure, study

BODIES = {"bilinear": [40, 2], "serendipity": [100, 6], "quadratic": [500, 15]}  # by element
STEPS = 100  # time steps in a period, all of them stored
FITS = {"ssmlearn": {}, "ssmlearn_11": {"order_decoder": 11, "order_dynamics": 11}}
FITS |= {"split": {"epochs": 20}}
KINDS = {"structure": "full_order", "release": "full_order", "train": "full_order"}
KINDS |= {"response": "full_order_answer", "answers": "answer", "scores": "sink"}
KINDS |= {"ablation": "study_scene"}
PERIODS = 30
BLOW = {
    "at": [1.0, 0.01],
    "direction": "y",
    "factor": 100.0,
    "signal": {"pulse": {"duration": 0.004}},
}  # N, s
ASKED = {"reconstruction": {}, "decay": {}, "response": {"periods": PERIODS}}  # of the first fit
STUDY = {"decay_periods": PERIODS, "forced_periods": 1, "timed_periods": 1, "repeats": 1}
INTEGRATOR = {"rtol": 1e-8, "atol": 1e-10}
LIMIT = 2e9  # bytes, of the largest job on 60 000 degrees of freedom
STEPS_OF_A_RUN = ("structure", "release", "train", *FITS)
STEPS_OF_A_RUN += ("response", "answers", "ablation", "scores")
CODE = {"source_digest": "0" * 16, "versions": "{}"}


def scene(element: str) -> dict:
    """The folding beam, finer, released at rest from where a small load holds it."""
    made = settings.load(Path("config")).scenes["folding"].to_builtins()
    made["body"] |= {"cells": BODIES[element], "element": element}
    made["time"] |= {"steps_per_period": STEPS, "every": 1}
    made["effects"]["point_load"] = BLOW
    made["experiments"]["response"] = ASKED["response"]
    made["releases"] = {role: {"forcing": 100.0, "static": True} for role in ("train", "test")}
    return made


def one(element: str, step: str, folder: str) -> None:
    """One step of the workflow in this process."""
    known, base = scene(element), Path(folder)
    paths = {name: str(base / f"{name}.nc") for name in ("structure", "release", "train")}
    if step == "structure":
        structure.run(structure=paths[step], scene=known, name="folding", provenance=CODE)
    elif step == "release":
        release.run(**{k: paths[k] for k in ("structure", step)}, scene=known, provenance=CODE)
    elif step == "train":
        shape = {name: paths[name] for name in ("structure", "release")}
        record.run(**shape, trajectory=paths[step], scene=known, role="train", provenance=CODE)
    elif step == "response":
        names = {"scene": "folding", "method": "full_order", "seed": None}
        given = {"structure": paths["structure"], "response": str(base / "full_response.nc")}
        given |= {"questions": {"response": ASKED["response"]}, "scene": known, "samples": STEPS}
        ask.run(names=names, provenance=CODE, **given)
    elif step == "answers":
        names = {"scene": "folding", "method": next(iter(FITS)), "seed": None}
        given = {"structure": paths["structure"], "test": paths["train"], "integrator": INTEGRATOR}
        given |= {f"truth_{name}": paths["train"] for name in ASKED} | answers(base)
        given |= {"truth_response": str(base / "full_response.nc")}
        given |= {"rom": str(base / f"{names['method']}_rom.nc"), "samples": STEPS}
        ask.run(questions=ASKED, names=names, provenance=CODE, **given)
    elif step == "ablation":
        names = {"scene": "folding", "method": "full_order"}
        given = {"structure": paths["structure"], "full_order": [paths["release"]]}
        given |= {"case": {"scene": known | {"effects": less(known["effects"])}}}
        about = {"name": step, "kind": "scene", "settings": STUDY}
        study.run(
            output=str(base / f"{step}.nc"), study=about, names=names, provenance=CODE, **given
        )
    elif step == "scores":
        every = [paths["train"], *answers(base).values()]
        scores.run(predictions=every, scores=str(base / "scores.csv"), provenance=CODE)
    else:
        recipe = {"scene": "folding", "method": step, "kind": step.removesuffix("_11")}
        recipe |= {"settings": FITS[step], "seed": 0, "device": "cpu"}
        made = {name: str(base / f"{step}_{name}.nc") for name in ("rom", "losses")}
        inputs = {name: paths[name] for name in ("structure", "train")}
        fit.run(**made, **inputs, recipe=recipe, checkpoint=None, provenance=CODE)


def less(effects: dict) -> dict:
    """Few, as each of them is left out once."""
    kept = ("inertia", "elasticity", "geometric_nonlinearity", "modal_load")
    return {name: effects[name] for name in kept}


def answers(base: Path) -> dict[str, str]:
    """Where they are."""
    return {name: str(base / f"{name}.nc") for name in ASKED}


def measure(note) -> Iterator[Row]:
    for element in BODIES:
        with tempfile.TemporaryDirectory() as folder:
            for step in STEPS_OF_A_RUN:
                if step == "ablation" and element == "quadratic":
                    continue  # an hour
                command = [sys.executable, "-m", "benchmarks.memory", element, step, folder]
                run = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True)
                peak, dofs = json.loads(run.stdout.splitlines()[-1])
                asked = mem_mb(scene(element), KINDS.get(step, "fit"))
                text = f"{step}, {dofs} dofs: peak of memory"
                yield Row("memory", text, 1.048576 * peak, "MB", "asked for by the rule", asked)
                if peak * 2**20 > LIMIT:
                    note(f"{step} took more than {LIMIT / 1e9:g} GB")
            size = Path(folder, "train.nc").stat().st_size / 1e6
            yield Row("memory", f"train, {dofs} dofs: size of the file", size, "MB")


if __name__ == "__main__":
    one(*sys.argv[1:])
    import xarray as xr

    with xr.open_dataset(Path(sys.argv[3]) / "structure.nc") as opened:
        print(json.dumps([peak_memory(), opened.sizes["dof"]]))
