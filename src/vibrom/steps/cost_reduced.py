"""Full-order data and fitted models -> cost_reduced.nc: error and seconds of reduced models,
setting by setting.

Every model of the run is asked as it was configured. Then one setting after the other is varied,
the others being those of config/methods. Besides the method's own settings: `thin` (train on every
k-th sample), `periods` (on the first k periods of the training decay, whose share of the simulation
counts), `start.<setting>` (of the method that this one starts from) and `rtol` (of the integrator;
atol a hundredth of it). Each model is asked the test decay, the forced run and the response curve
of the scene, with the errors of those experiments: NMTE, NMTE of the last period, median error of
the amplitude. A value that does not go with the method's other settings is `skipped`.

Offline seconds are those of the training data, the mapping (that of a model to start from included)
and the dynamics; online ones those of one answer. All are medians of repeated calls, after one that
compiles; what takes long is not repeated, `calls` and `fits` say how often.
"""

import json
import sys
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from statistics import median
from time import perf_counter

import numpy as np
import xarray as xr

from vibrom import experiments
from vibrom.artefacts.data import FINISHED, UNSEEDED, label, open_dataset, save_dataset, variable
from vibrom.artefacts.hardware import description
from vibrom.artefacts.progress import bar
from vibrom.methods import method_from_settings
from vibrom.models.recorded import structure as operators
from vibrom.models.recorded import trajectory
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import MethodError, Monitor, Training, TrainingDiverged, Trajectory
from vibrom.steps.experiment import KINDS, REFERENCE_FAILED, shortened
from vibrom.studies.work_precision import repeated

ERRORS = {
    "decay": "nmte_percent",
    "forced": "nmte_percent",
    "frc": "amplitude_error_median_percent",
}
ONLINE = ("rtol", "force_rule")  # settings that need no new fit
CONFIGURED = "as configured"


class Clock(Monitor):
    """Seconds of each phase of a fit."""

    def __init__(self) -> None:
        self.seconds = {"mapping": 0.0, "dynamics": 0.0}

    @contextmanager
    def phase(self, name: str):
        began = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += perf_counter() - began


@dataclass(frozen=True)
class Fitted:
    """A model, or the outcome that stands for it; seconds of its training data, mapping and
    dynamics, and how many fits are behind them.
    """

    rom: Rom | None
    outcome: str
    data: float
    mapping: float
    dynamics: float
    fits: int = 1


@dataclass
class Row:
    """One setting of one method, and its answers: question -> (error [%], seconds, calls, outcome)."""

    method: str
    seed: int | None
    varied: str
    value: str
    fitted: Fitted
    answers: dict[str, tuple[float, float, int, str]] = field(default_factory=dict)


def run(
    *,
    structure: str,
    train: str,
    test: str,
    forced: str,
    frc: str,
    models: list[str],
    cost: str,
    scene_name: str,
    methods: dict,
    settings: dict,
    seed: int | None,
    device: str,
    integrator: dict,
    repeats: int,
    patience: float,
    provenance: dict,
) -> None:
    """`methods`: name -> kind (file of vibrom.methods), settings, seeded, and start, the method
    that it starts from.
    """
    paths = {"structure": structure, "train": train, "test": test, "forced": forced, "frc": frc}
    study = Study(
        {name: open_dataset(path, KINDS.get(name, name)) for name, path in paths.items()},
        methods,
        seed,
        device,
        Integrator(**integrator),
        repeats,
        patience,
    )
    # A method is varied where it takes part in the run.
    wanted = [
        (method, dict.fromkeys(block["vary"], value))
        for method in settings
        if method in methods
        for block in settings[method]
        for value in block["over"]
    ]
    rows = []
    with bar(
        f"{scene_name}: what the methods cost", len(models) + len(wanted), "settings"
    ) as advance:
        for ask, given in [(study.configured, (path,)) for path in models] + [
            (study.varied, pair) for pair in wanted
        ]:
            rows.append(ask(*given))
            advance(1)
    save_dataset(
        label(
            as_dataset(rows),
            "cost_reduced",
            scene=scene_name,
            method="full_order",
            settings=settings,
            hardware=description(),
        ),
        cost,
        provenance,
    )


class Study:
    """The data of a scene, what is asked, and the fits that were already made."""

    def __init__(
        self,
        artefacts: dict[str, xr.Dataset],
        methods: dict,
        seed: int | None,
        device: str,
        integrator: Integrator,
        repeats: int,
        patience: float,
    ):
        self.artefacts, self.methods, self.seed, self.device = artefacts, methods, seed, device
        self.integrator, self.repeats, self.patience = integrator, repeats, patience
        self.structure, self.motion = (
            operators(artefacts["structure"]),
            trajectory(artefacts["train"]),
        )
        self.period = float(artefacts["train"]["period"])
        self.as_configured: dict[str, Fitted] = {}  # of the first seed
        self.made: dict[str, Fitted] = {}
        self.warm: set[str] = set()

    def configured(self, path: str) -> Row:
        """A model of the run as its artefact holds it."""
        stored = open_dataset(path, "rom")
        outcome, seed = str(stored["outcome"].item()), int(stored.attrs["seed"])
        seconds = (float(stored[name]) for name in ("mapping_seconds", "dynamics_seconds"))
        fitted = Fitted(
            rom_from_dataset(stored) if outcome == "ok" else None,
            outcome,
            float(self.artefacts["train"]["seconds"]),
            *seconds,
        )
        self.as_configured.setdefault(stored.attrs["method"], fitted)
        return self.asked(
            Row(stored.attrs["method"], None if seed == UNSEEDED else seed, CONFIGURED, "", fitted),
            self.integrator,
        )

    def varied(self, method: str, changes: dict) -> Row:
        """One row: the method with these changes."""
        offline = {key: value for key, value in changes.items() if key not in ONLINE}
        fitted = self.as_configured[method] if not offline else self.fit(method, offline)
        integrator = (
            replace(self.integrator, rtol=changes["rtol"], atol=changes["rtol"] / 100)
            if "rtol" in changes
            else self.integrator
        )
        if fitted.rom is not None and "force_rule" in changes:
            fitted = replace(fitted, rom=replace(fitted.rom, force_rule=changes["force_rule"]))
        seed = self.seed if self.methods[method]["seeded"] else None
        return self.asked(
            Row(method, seed, ", ".join(changes), str(next(iter(changes.values()))), fitted),
            integrator,
        )

    def fit(self, method: str, changes: dict) -> Fitted:
        block = self.methods[method]
        about_start = {
            key.removeprefix("start."): value
            for key, value in changes.items()
            if key.startswith("start.")
        }
        data = {key: changes[key] for key in ("thin", "periods") if key in changes}
        own = {
            key: value
            for key, value in changes.items()
            if key not in data and not key.startswith("start.")
        }
        start = None
        if block["start"]:
            before = self.methods[block["start"]]
            again = about_start or data
            start = (
                self.learn(before["kind"], before["settings"] | about_start, data, None)
                if again
                else self.as_configured[block["start"]]
            )
        return self.learn(block["kind"], block["settings"] | own, data, start)

    def learn(self, kind: str, settings: dict, data: dict, start: Fitted | None) -> Fitted:
        """One fit, or the one made before of the same; times are medians of a few."""
        key = json.dumps(
            [kind, settings, data, None if start is None else [start.mapping, start.dynamics]],
            sort_keys=True,
        )
        if key in self.made:
            return self.made[key]
        motion, share = self.selected(**data)
        seconds = float(self.artefacts["train"]["seconds"]) * share
        before = 0.0 if start is None else start.mapping
        unfit = (
            REFERENCE_FAILED
            if str(self.artefacts["train"]["outcome"].item()) != "ok"
            else "ok"
            if start is None
            else start.outcome
        )
        if unfit != "ok":
            return Fitted(None, unfit, seconds, before, 0.0)
        clocks: list[Clock] = []

        def call(method):
            clocks.append(Clock())
            rom = method.learn(
                Training(
                    (motion,),
                    structure=self.structure,
                    seed=self.seed,
                    device=self.device,
                    start=start and start.rom,
                    monitor=clocks[-1],
                )
            )
            return rom, sum(clocks[-1].seconds.values())

        try:
            method = method_from_settings(kind, settings)
            if kind not in self.warm:  # libraries load at their first use
                call(
                    method_from_settings(
                        kind, settings | {"epochs": 1} if "epochs" in settings else settings
                    )
                )
                self.warm.add(kind)
            clocks.clear()
            rom, _, fits = repeated(lambda: call(method), self.repeats, self.patience)
        except TrainingDiverged:
            return Fitted(None, "training_diverged", seconds, before, 0.0)
        # a value that does not go with the method's other settings; the rest of the study does
        except MethodError as error:
            print(f"{kind}: {settings} is skipped: {error}", file=sys.stderr)
            return Fitted(None, "skipped", seconds, before, 0.0)
        middle = {
            name: median(clock.seconds[name] for clock in clocks)
            for name in ("mapping", "dynamics")
        }
        self.made[key] = Fitted(
            rom, "ok", seconds, before + middle["mapping"], middle["dynamics"], fits
        )
        return self.made[key]

    def selected(self, thin: int = 1, periods: int | None = None) -> tuple[Trajectory, float]:
        """The training motion that is used, and which share of it had to be simulated."""
        time = self.motion.time - self.motion.time[0]
        kept = np.arange(
            0,
            len(time)
            if periods is None
            else max(2, int(np.searchsorted(time, periods * self.period))),
            thin,
        )
        chosen = Trajectory(
            *(
                getattr(self.motion, name)[kept]
                for name in ("time", "displacement", "velocity", "acceleration")
            )
        )
        return chosen, min(1.0, periods * self.period / time[-1]) if periods else 1.0

    def asked(self, row: Row, integrator: Integrator) -> Row:
        """The row with its answers."""
        for question, error in ERRORS.items():
            reference = self.artefacts["test" if question == "decay" else question]
            outcome = row.fitted.outcome
            if (
                outcome == "ok"
                and question != "frc"
                and str(reference["outcome"].item()) == "no_convergence"
            ):
                outcome = REFERENCE_FAILED
            if outcome != "ok":
                row.answers[question] = (np.nan, np.nan, 0, outcome)
                continue
            module, given = experiments.load(question), {**self.artefacts, "rom": row.fitted.rom}
            module.predict({**given, **shortened(given)}, integrator)  # compiles

            def call():
                answer = module.predict(given, integrator)
                return answer, float(answer["seconds"])

            answer, seconds, calls = repeated(call, self.repeats, self.patience)
            scores = dict(
                zip(answer["score"].values.tolist(), answer["score_value"].values.tolist())
            )
            endings = [str(word) for word in np.atleast_1d(answer["outcome"].values)]
            worst = next(
                (word for word in endings if word not in FINISHED),
                "left_range" if "left_range" in endings else "ok",
            )
            row.answers[question] = (scores[error], seconds, calls, worst)
        return row


def as_dataset(rows: list[Row]) -> xr.Dataset:
    dims, questions = ("setting", "question"), list(ERRORS)

    def column(index: int) -> list[list]:
        return [[row.answers[name][index] for name in questions] for row in rows]

    def words(values: list[str], said: str) -> xr.Variable:
        return variable("setting", np.array(values, dtype=object), "1", said)

    seconds = {
        "data_seconds": ("data", "the training data"),
        "mapping_seconds": ("mapping", "the mapping, that of a model to start from included"),
        "dynamics_seconds": ("dynamics", "the dynamics after the mapping"),
    }
    return xr.Dataset(
        {
            "model": words([row.method for row in rows], "method"),
            "model_seed": variable(
                "setting",
                np.array([UNSEEDED if row.seed is None else row.seed for row in rows]),
                "1",
                "seed, -1 where it is fitted once",
            ),
            "varied": words([row.varied for row in rows], "setting that is varied"),
            "value": words([row.value for row in rows], "its value"),
            **{
                name: variable(
                    "setting",
                    np.array([getattr(row.fitted, key) for row in rows], float),
                    "s",
                    f"wall time of {said}",
                )
                for name, (key, said) in seconds.items()
            },
            "fits": variable(
                "setting",
                np.array([row.fitted.fits for row in rows]),
                "1",
                "fits behind the median",
            ),
            "error": variable(
                dims,
                np.array(column(0), float),
                "percent",
                "NMTE of decay and forced run, median amplitude error of the response curve",
            ),
            "seconds": variable(
                dims, np.array(column(1), float), "s", "median wall time of one answer"
            ),
            "calls": variable(dims, np.array(column(2)), "1", "answers behind the median"),
            "outcome": variable(
                dims,
                np.array(column(3), dtype=object),
                "1",
                "how the answer ended; of a response curve its worst point",
            ),
        },
        coords={
            "question": variable(
                "question", np.array(questions, dtype=object), "1", "what is asked"
            )
        },
    )
