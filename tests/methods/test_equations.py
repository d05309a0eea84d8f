"""A model from the equations alone, against closed forms, the full order and its own residual."""

import numpy as np
import pytest
import xarray as xr
from few_dofs import TWO_MASS, cubic_coupling, square_coupling, two
from scenes import THESIS, UNDAMPED, body, quadratic_body
from scipy.integrate import solve_ivp

from vibrom import effects
from vibrom.bodies import space
from vibrom.latent.manifold_rom import nearest
from vibrom.methods.equations import Equations
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Drive, Watch
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import MethodError, Training, Trajectory, Unsupported
from vibrom.models.trust import Residual, ellipse, equation_error, trusted
from vibrom.solvers.full.motion import Record
from vibrom.solvers.full.newmark import Newmark
from vibrom.term import Term

SHORT = body(cells=[10, 1])  # locks in shear, as the thesis's beam does
CLOSE = Integrator(rtol=1e-9, atol=1e-11)


def fitted(term, **settings):
    return Equations(**settings).learn(Training((), term=term))


@pytest.fixture(scope="module")
def beam():
    return effects.assemble(space.build(SHORT), THESIS)


@pytest.fixture(scope="module")
def rom(beam):
    return fitted(beam, order=9)


def motion(term, state, step, steps, every, signal=None):
    """Of the full order, converged."""
    start, velocity = np.split(state[:, None], 2)
    signal = None if signal is None else signal[:, None]
    run = Newmark(tolerance=1e-9).run(
        term,
        start,
        np.array([step]),
        steps,
        velocity=velocity,
        signal=signal,
        record=Record(every=every),
    )
    assert run.outcomes == ["ok"]
    return run.displacement[0]


def test_a_decay_is_that_of_the_full_order(beam, rom):
    start = rom.reach * np.array([0.5, 0.1])
    period = 2 * np.pi * rom.reach[0] / rom.reach[1]
    truth = motion(beam, rom.decode(start), period / 4000, 20_000, 40)
    assert abs(truth).max() > 0.5  # of a beam one metre long
    times = period / 100 * np.arange(len(truth))
    run = rollout(rom, start[None], times[None], CLOSE)
    assert run.outcome == ["ok"]
    assert nmte_percent(truth, rom.displacement(run.reduced[0])) < 0.01


def test_two_modes_of_a_beam_move_as_the_body_does():
    """Both swing, the beam bends by a third of its length: the error falls with the order, and one
    mode alone misses the second one's part.
    """
    term = effects.assemble(space.build(SHORT), UNDAMPED)
    both = [
        fitted(term, order=order, modes=(1, 2), beyond="taylor", tolerance=0.1) for order in (3, 5)
    ]
    start, errors = np.array([[0.09, 0.012, 0.0, 0.0]]), []
    period = 2 * np.pi * both[0].reach[0] / both[0].reach[2]
    times = period / 100 * np.arange(101)
    for model in both:
        truth = motion(term, model.decode(start)[0], period / 3000, 3000, 30)
        run = rollout(model, start, times[None], CLOSE)
        errors.append(nmte_percent(truth, model.displacement(run.reduced[0])))
    assert abs(truth).max() > 0.3
    # Left out are terms of degree four, then of degree six: times the amplitude's square.
    assert errors[1] < 0.1 and errors[0] > 4.0 * errors[1]
    one = fitted(term, order=5, beyond="taylor", tolerance=0.1)
    run = rollout(one, one.encode(both[1].decode(start)), times[None], CLOSE)
    assert nmte_percent(truth, one.displacement(run.reduced[0])) > 5.0


def test_a_forced_motion_has_the_displacement_beside_the_manifold(beam, rom):
    """A tip load bends the beam in other modes too: with them the error is five times less."""
    load = np.zeros(beam.size)
    load[-1] = 1.0
    term = Term(beam.mass, 2.0 * beam.damping, beam.stiffness, beam.forces, load)
    pushed = fitted(term, order=7)
    frequency = 1.15 * pushed.reach[1] / pushed.reach[0]
    period, count, periods = 2 * np.pi / frequency, 2000, 120
    wave = np.sin(2 * np.pi * np.arange(periods * count + 1) / count)
    force = 0.1 / abs(np.linalg.solve(term.stiffness.toarray(), load)).max()
    truth = motion(term, np.zeros(2 * term.size), period / count, periods * count, 50, force * wave)
    model = Reduced(pushed, load, np.array([0]), frequency, CLOSE)
    instants = period * (periods - 1 + np.arange(41) / 40)
    drive = Drive(np.array([force]), np.array([frequency]))
    run = model.motion(np.zeros((1, 2 * term.size)), drive, Watch(instants))
    assert list(run.outcome) == ["ok"]
    last = truth[-41:]
    alone = pushed.displacement(run.reduced[0][0])
    error, without = nmte_percent(last, run.displacement[0][0]), nmte_percent(last, alone)
    assert error < 0.2 * without
    assert error < 0.3


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_encoding_finds_the_state_it_was_decoded_from(rom, amplitude):
    z = np.concatenate([ellipse(rom.reach, 0, amplitude), np.zeros((1, 2))])
    np.testing.assert_allclose(rom.encode(rom.decode(z)) / rom.reach, z / rom.reach, atol=1e-8)
    one = rom.encode(rom.decode(z)[2])
    np.testing.assert_allclose(one, rom.encode(rom.decode(z))[2], rtol=1e-10)


def test_the_nearest_point_of_a_circle():
    def circle(y):
        angle = y[:, 0]
        point = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return point, np.stack([-point[:, 1], point[:, 0]], axis=1)[:, None]

    target = np.array([[0.2, 3.0], [-1.5, 0.1]])
    found = nearest(circle, target, np.array([[0.3], [2.0]]))
    np.testing.assert_allclose(found[:, 0], np.arctan2(target[:, 1], target[:, 0]), atol=1e-8)


def test_save_equals_load(rom, tmp_path):
    path = tmp_path / "rom.nc"
    rom.to_dataset().to_netcdf(path)
    again = rom_from_dataset(xr.load_dataset(path))
    z = 0.5 * rom.reach * np.array([[0.4, -0.2]])
    for name in ("decode", "drift", "displacement"):
        np.testing.assert_array_equal(getattr(again, name)(z), getattr(rom, name)(z))
    np.testing.assert_array_equal(again.beside(z, rom.load), rom.beside(z, rom.load))
    twice, other = 2.0 * rom.load, np.arange(1.0, 1.0 + len(rom.load))
    np.testing.assert_allclose(again.beside(z, twice), 2.0 * rom.beside(z, rom.load))
    assert again.beside(z, other) is None


@pytest.mark.parametrize("settings", [{"beyond": "taylor"}, {"style": "graph"}, {"order": 5}])
def test_other_settings_move_alike_where_all_are_trusted(beam, rom, settings):
    other = fitted(beam, **{"order": 9, **settings})
    shape = 0.2 * rom.decode(ellipse(rom.reach, 0, 1.0))[:1]
    times = np.linspace(0, 0.03, 60)[None]
    shapes = [
        model.displacement(rollout(model, model.encode(shape), times, CLOSE).reduced[0])
        for model in (rom, other)
    ]
    assert nmte_percent(*shapes) < 0.01


def test_both_force_maps_are_one_where_damping_is_by_the_mass(beam, rom):
    other = fitted(beam, order=9, force="invariance")
    z = ellipse(rom.reach, 0, 0.8)
    found = [model.force_map(z, beam.load) / rom.reach for model in (rom, other)]
    np.testing.assert_allclose(found[1], found[0], atol=1e-6 * abs(found[0]).max())


def test_the_invariant_force_map_is_right_for_any_damping():
    """Two displacements, two modes: the manifold is everything, and a push is exact."""
    term = two()
    load = np.array([0.3, 1.0])
    rom = fitted(
        Term(term.mass, term.damping, term.stiffness, load=load),
        modes=(1, 2),
        order=3,
        force="invariance",
        beyond="taylor",
    )
    z = np.random.default_rng(0).normal(size=(5, 4)) * 0.1 * rom.reach
    step = 1e-6
    pushed = rom.decode(z + step * rom.force_map(z, load)) - rom.decode(
        z - step * rom.force_map(z, load)
    )
    expected = np.concatenate([np.zeros(2), np.linalg.solve(TWO_MASS, load)])
    np.testing.assert_allclose(pushed / (2 * step), np.tile(expected, (5, 1)), atol=1e-6)


def test_two_modes_at_one_to_three_exchange_energy_as_the_body_does():
    """u_1'' + u_1 + d/du_1 U = 0, u_2'' + 9.1 u_2 + d/du_2 U = 0, with U = u_1^3 u_2/3."""
    term = cubic_coupling(9.1)
    rom = Equations(modes=(1, 2), order=7)._series(term).model(0)

    def slope(t, x):
        a, b, *v = x
        return [*v, -a - a * a * b, -9.1 * b - a**3 / 3]

    start, times = np.array([0.4, 0.0, 0.0, 0.0]), np.linspace(0, 60, 301)
    truth = solve_ivp(slope, (0, 60), start, t_eval=times, rtol=1e-11, atol=1e-13).y[:2].T
    assert abs(truth[:, 1]).max() > 0.01
    run = rollout(rom, rom.encode(start[None]), times[None], CLOSE)
    assert nmte_percent(truth, rom.displacement(run.reduced[0])) < 0.05
    assert nmte_percent(truth[:, 1:], rom.displacement(run.reduced[0])[:, 1:]) < 0.5


def test_two_modes_at_one_to_two_exchange_energy_as_the_body_does():
    """u_1'' + u_1 + u_1 u_2/2 = 0, u_2'' + 4.1 u_2 + u_1^2/4 = 0."""
    rom = Equations(modes=(1, 2), order=7)._series(square_coupling(4.1)).model(0)

    def slope(t, x):
        a, b, *v = x
        return [*v, -a - a * b / 2, -4.1 * b - a * a / 4]

    start, times = np.array([0.3, 0.0, 0.0, 0.0]), np.linspace(0, 100, 401)
    truth = solve_ivp(slope, (0, 100), start, t_eval=times, rtol=1e-11, atol=1e-13).y[:2].T
    assert abs(truth[:, 1]).max() > 0.05
    run = rollout(rom, rom.encode(start[None]), times[None], CLOSE)
    found = rom.displacement(run.reduced[0])
    assert nmte_percent(truth, found) < 0.05
    assert nmte_percent(truth[:, 1:], found[:, 1:]) < 0.5


def test_its_reach_is_where_the_residual_meets_the_tolerance(beam, rom):
    residual = Residual(beam)
    error = [equation_error(residual, rom, ellipse(rom.reach, 0, at)) for at in (0.5, 1.0, 1.1)]
    assert error[0] < 1e-3 < error[1] <= 0.01 < error[2]
    np.testing.assert_allclose(rom.trust_error[3], error[1])
    assert (np.diff(rom.trust_displacement[:4]) > 0).all()
    closer = fitted(beam, order=9, tolerance=1e-3)
    assert closer.reach[0] < 0.95 * rom.reach[0]


def test_the_search_for_the_trusted_amplitude():
    assert 0.95 * 0.3 < trusted(lambda a: a**3, 0.3**3, 8.0) <= 0.3
    assert trusted(lambda a: 0.0, 0.1, 8.0) == 8.0
    assert trusted(lambda a: a, 0.1, 8.0, least=0.2) == 0.0
    assert trusted(lambda a: 1.0, 0.1, 8.0) == 0.0


def test_action_coordinates_and_ratios_reach_farther_than_series(beam, rom):
    series = fitted(beam, order=9, beyond="taylor")
    assert rom.reach[0] > 1.05 * series.reach[0]


def test_a_motion_beyond_the_reach_says_so(rom):
    start = np.array([[1.2 * rom.reach[0], 0.0]])
    run = rollout(rom, start, np.linspace(0, 0.01, 9)[None], Integrator())
    assert run.outcome == ["left_range"]


def test_a_linear_body_has_its_modes():
    term = effects.assemble(space.build(SHORT), {k: v for k, v in THESIS.items() if k[:3] != "geo"})
    rom = fitted(term, order=5)
    omega, c = rom.reach[1] / rom.reach[0], 2 * 0.01 * rom.reach[1] / rom.reach[0]
    z = np.array([[0.1, 3.0]])
    np.testing.assert_allclose(rom.drift(z), [[3.0, -(omega**2) * 0.1 - c * 3.0]], rtol=1e-6)
    np.testing.assert_allclose(rom.force_map(z, term.load), [[0.0, 1.0]], atol=1e-8)


def test_a_stop_makes_it_skip_with_a_reason():
    stop = {"at": [1.0, 0.01], "direction": "y", "gap": 0.1, "stiffness": 5.0}
    term = effects.assemble(space.build(quadratic_body(cells=[2, 1])), {**UNDAMPED, "stop": stop})
    with pytest.raises(Unsupported, match="effects.stop"):
        fitted(term)


def test_without_equations_it_says_what_is_missing():
    motion = Trajectory(np.arange(3.0), *(np.ones((3, 2)) for _ in range(3)))
    with pytest.raises(MethodError, match="equations of motion"):
        Equations().learn(Training((motion,)))
