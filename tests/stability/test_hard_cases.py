"""The hardest cases: polynomials in modal coordinates of the beam that folds over itself, learnt
from its decay, driven far beyond it for long.

Without guards these models run away within ten periods; a dissipative fit holds wherever it is
sent.
"""

import numpy as np
import pytest
from scenes import CANTILEVER, THESIS
from vibrom.studies.grid import cases, let_go, rises, survive

from vibrom import effects
from vibrom.artefacts.data import FINISHED
from vibrom.bodies import space
from vibrom.methods.modal_projection import ModalProjection
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Guards
from vibrom.models.training import Structure, Training, Trajectory
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record

FORCING, RELEASE, STEPS = 6000.0, (3000.0, 13376), 1000  # as in config/scenes/folding.yaml
HARD = cases([1.0, 1.5, 2.0], np.linspace(0.8, 1.2, 9), 8, 1.3)


@pytest.fixture(scope="module")
def folding():
    """(training, load, omega): ten periods of decay from the state that the folding scene trains
    on.
    """
    made = space.build(CANTILEVER)
    term = effects.assemble(made, THESIS)
    frequency, shapes = eigenmodes(term, 2)
    omega = frequency[0] * np.sqrt(1 - 0.01**2)
    step, newmark = 2 * np.pi / omega / STEPS, Newmark(alpha=0.005)
    forcing, last = RELEASE
    signal = forcing * np.sin(omega * step * np.arange(last + 1))[:, None]
    bent = newmark.run(
        term,
        np.zeros((made.size, 1)),
        np.array([step]),
        last,
        signal=signal,
        record=Record(start=last),
    ).displacement[0, 0]
    assert abs(bent[made.probes["probe"]] - 0.377742) < 1e-3 * 0.378
    motion = newmark.run(term, bent[:, None], np.array([step]), 10 * STEPS, record=Record(every=5))
    decay = Trajectory(
        motion.kept * step,
        *(getattr(motion, name)[0] for name in ("displacement", "velocity", "acceleration")),
    )
    return (
        Training(
            (decay,),
            structure=Structure(term.mass, term.damping, term.stiffness, shapes, frequency),
        ),
        term.load,
        omega,
    )


@pytest.mark.parametrize("method", [ModalProjection(), SsmLearn(), SsmLearn(1, 9, 9)])
def test_dissipative_fits_hold_where_plain_ones_run_away(folding, method):
    training, load, omega = folding
    plain, integrator = method.fit(training), Integrator(1e-6, 1e-8)
    lost = {}
    for name, guards in {
        "none": Guards(),
        "bounded": Guards("linear"),
        "dissipative": Guards(dissipative=5),
        "dissipative_9": Guards(dissipative=9),
    }.items():
        outcome, failed_at, ratio = survive(
            plain.guarded(guards, training), HARD, load, FORCING, omega, 60, integrator
        )
        assert (
            set(outcome) <= {"ok", "left_range", "diverged", "step_underflow"}
            and np.isfinite(ratio).all()
            and np.isfinite(failed_at[outcome != "ok"]).all()
        )
        lost[name] = int((~np.isin(outcome, FINISHED)).sum())
    assert (
        lost["none"] >= 10
        and lost["bounded"] <= lost["none"]
        and lost["dissipative"] == lost["dissipative_9"] == 0
    )


def test_a_thousand_periods_at_twice_the_forcing(folding):
    training, load, omega = folding
    hardest = cases([2.0], np.array([0.9, 1.0, 1.05, 1.1]), 4, 1.3)
    for method in (ModalProjection(dissipative=5), SsmLearn(dissipative=9)):
        outcome, _, ratio = survive(
            method.learn(training), hardest, load, FORCING, omega, 1000, Integrator(1e-5, 1e-7)
        )
        assert np.isin(outcome, FINISHED).all() and ratio.max() < 10.0


def test_no_integrator_rescues_a_model_that_runs_away_and_none_spoils_one_that_holds(folding):
    training, load, omega = folding
    for guards, held in ((Guards(), False), (Guards(dissipative=5), True)):
        rom = ModalProjection().fit(training).guarded(guards, training)
        for integrator in (
            Integrator(1e-2, 1e-4),
            Integrator(1e-10, 1e-12),
            Integrator(1e-8, 1e-10, "gauss", 20),
            Integrator(1e-8, 1e-10, "gauss", 80),
        ):
            outcome = survive(
                rom, cases([1.0], np.array([1.0]), 1, 0.5), load, FORCING, omega, 40, integrator
            )[0]
            assert (outcome[0] in FINISHED) == held, integrator


def test_let_go_beyond_its_range_a_dissipative_model_comes_to_rest(folding):
    training, _, omega = folding
    for order in (3, 5, 7, 9):
        _, envelope = let_go(
            ModalProjection(dissipative=order).learn(training),
            HARD,
            omega,
            40,
            Integrator(1e-8, 1e-10),
            lambda q, v: np.zeros(len(q)),
        )
        assert not rises(envelope).any() and (envelope[:, -1] < 0.5).all()
