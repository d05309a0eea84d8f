"""What every method promises, whichever are in the folder; no method is named here.

A file in src/vibrom/methods is tested by lying there. One more is the example of docs/: four
functions, and no compiled code.
"""

from dataclasses import dataclass, fields, replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import torch
import xarray as xr
import yaml
from scipy.linalg import eigh

from vibrom.config import plugs
from vibrom.methods import method_from_settings
from vibrom.models.measures import nmte_percent
from vibrom.models.rollout import Drive, Integrator, rollout
from vibrom.models.rom import Guards, Rom, rom_from_dataset
from vibrom.models.training import Clock, MethodError, Training, Underdetermined, Unsupported

FILES = Path(__file__).parents[2] / "config/methods"
EXAMPLE = "example of docs"
NAMES = [*plugs.names("methods"), EXAMPLE]
RNG = np.random.default_rng(0)


@dataclass(frozen=True)
class Fit:
    """A method, the model that it learnt, and what it learnt from."""

    method: object
    rom: Rom
    training: Training


def starts_from(name):
    """The class that this one starts from, as one of its files in config says; None: nothing."""
    for path in sorted(FILES.glob("*.yaml")):
        file = yaml.safe_load(path.read_text())
        if file.get("method", path.stem) == name and file.get("starts_from"):
            start = file["starts_from"]
            return yaml.safe_load((FILES / f"{start}.yaml").read_text()).get("method", start)
    return None


@pytest.fixture(scope="module")
def fits(beam, example):
    """name -> Fit, made when it is first wanted."""
    before, found = torch.get_num_threads(), {}
    torch.set_num_threads(1)

    def fit(name):
        name = example if name == EXAMPLE else name
        if name not in found:
            start = starts_from(name)
            training = Training(
                (beam.trajectory,),
                beam.structure,
                seed=0,
                start=None if start is None else fit(start).rom,
                monitor=Clock(),
                term=beam.term,
            )
            method = method_from_settings(name, {})
            found[name] = Fit(method, method.learn(training), training)
        return found[name]

    yield fit
    torch.set_num_threads(before)


@pytest.fixture(params=NAMES)
def fit(request, fits):
    return fits(request.param)


@pytest.mark.parametrize("name", plugs.names("methods"))
@pytest.mark.parametrize("samples", [2, 200])
def test_two_samples_determine_no_polynomials(fits, name, beam, samples):
    """Once, or a hundred times each."""
    fit, motion = fits(name), beam.trajectory
    if fit.method.of_equations:
        return
    kept = np.tile([0, 10], samples // 2)
    few = replace(
        motion,
        **{item.name: getattr(motion, item.name)[kept] for item in fields(motion)},
    )
    with pytest.raises(Underdetermined, match="coefficients|terms"):
        fit.method.fit(replace(fit.training, trajectories=(few,), monitor=Clock()))


def states(rom, count=6):
    """Reduced states (count, 2d) within the training range."""
    return RNG.uniform(-0.7, 0.7, (count, len(rom.reach))) * rom.reach


def test_what_was_encoded_is_decoded(fit, beam):
    """To the share of the motion that one coordinate leaves: 1.2 % of it is in other modes."""
    x = beam.trajectory.state
    z = fit.rom.encode(x)
    assert nmte_percent(beam.trajectory.displacement, fit.rom.displacement(z)) < 3.0
    assert np.abs(fit.rom.encode(fit.rom.decode(z)) - z).max(axis=0) == pytest.approx(
        np.zeros(z.shape[1]), abs=0.03 * fit.rom.reach.max()
    )
    if fit.method.of_equations:
        return  # its reach is not that of the data
    assert np.array_equal(fit.rom.reach, np.abs(z).max(axis=0)) or np.allclose(
        fit.rom.reach, np.abs(z).max(axis=0), rtol=1e-12
    )


def test_a_state_does_not_see_the_others_of_its_batch(fit, beam):
    rom, p = fit.rom, beam.load("tip")
    z = states(rom).reshape(2, 3, -1)
    x = rom.decode(z)
    asked = [
        (rom.encode, x),
        (rom.decode, z),
        (rom.displacement, z),
        (lambda z: rom.displacement(z, np.array([5, 2])), z),
        (rom.drift, z),
        (lambda z: rom.force_map(z, p), z),
    ]
    for function, values in asked:
        together = function(values)
        size = np.abs(together).max()
        for place in product(range(2), range(3)):
            # Sums of a few hundred terms in another order.
            np.testing.assert_allclose(together[place], function(values[place]), atol=1e-12 * size)
    n = beam.known.sizes["dof"]
    assert rom.decode(z).shape == (2, 3, 2 * n) and rom.displacement(z).shape == (2, 3, n)
    np.testing.assert_allclose(rom.displacement(z), rom.decode(z)[..., :n], atol=1e-14)
    np.testing.assert_allclose(
        rom.displacement(z, np.array([5, 2])), rom.decode(z)[..., [5, 2]], atol=1e-14
    )


def test_compiled_code_is_the_same_model(fit, beam):
    rom, p = fit.rom, beam.load("tip")
    field = rom.field(p)
    if field is None:
        return  # numpy is the model
    z = states(rom, 8)
    for kernel, right in ((field.drift, rom.drift(z)), (field.force, rom.force_map(z, p))):
        out, work = np.empty(z.T.shape), np.full(8 * max(kernel.rows, 1), np.nan)
        kernel.function(np.ascontiguousarray(z.T), kernel.numbers, kernel.index, work, out)
        np.testing.assert_allclose(out.T, right, atol=1e-11 * np.abs(right).max())


def test_rest_stays_at_rest(fit, beam):
    rom, n = fit.rom, beam.known.sizes["dof"]
    nothing = np.zeros(len(rom.reach))
    assert not rom.encode(np.zeros(2 * n)).any()
    assert not rom.decode(nothing).any() and not rom.drift(nothing).any()


def test_small_motions_have_the_pole_of_the_first_mode(fit, beam):
    """Its frequency to 0.5 %, its damping to a fifth: what is learnt from large motions alone."""
    steps = np.diag(1e-5 * fit.rom.reach)
    slope = (fit.rom.drift(steps) - fit.rom.drift(-steps)).T / (2e-5 * fit.rom.reach)
    found = np.linalg.eigvals(slope)
    pole = found[np.argmin(np.where(found.imag > 0, found.imag, np.inf))]
    omega = beam.known["frequency"].values[0]
    decay = beam.known["damping_ratio"].values[0] * omega
    assert pole.imag == pytest.approx(np.sqrt(omega**2 - decay**2), rel=5e-3)
    assert pole.real == pytest.approx(-decay, rel=0.2)


@pytest.mark.parametrize("load", ["modal", "tip", "middle", "base"])
def test_small_forced_motions_are_those_of_linear_theory(fit, beam, load):
    """Three periods from rest at the first frequency: other modes have a four hundredth of the
    response.
    """
    rom, p, n = fit.rom, beam.load(load), beam.known.sizes["dof"]
    omega = float(beam.known["frequency"].values[0])
    time = np.linspace(0.0, 6 * np.pi / omega, 121)
    linear = response(beam.structure, p, omega, time)
    # As large as leaves the model linear: a thousandth of its range.
    size = 1e-3 * np.abs(beam.trajectory.displacement).max() / np.abs(linear).max()
    drive = Drive(p, np.array([size]), np.array([omega]))
    run = rollout(rom, rom.encode(np.zeros((1, 2 * n))), time[None], Integrator(), drive)
    assert nmte_percent(size * linear, rom.displacement(run.reduced[0])) < 1.5


def response(structure, p, omega, time):
    """Displacement (m, n) under p sin(omega t) from rest, of all modes of M, C, K; C = c M."""
    squares, phi = eigh(structure.stiffness.toarray(), structure.mass.toarray())
    damping = np.diag(phi.T @ structure.damping @ phi)
    free = np.sqrt(squares - damping**2 / 4)
    steady = (p @ phi) / (squares - omega**2 + 1j * omega * damping)
    start, speed = -steady.imag, -omega * steady.real
    t = time[:, None]
    fading = np.exp(-damping * t / 2) * (
        start * np.cos(free * t) + (speed + damping * start / 2) / free * np.sin(free * t)
    )
    return ((steady * np.exp(1j * omega * t)).imag + fading) @ phi.T


def test_force_is_linear_in_the_load(fit, beam):
    z, one, two = states(fit.rom), beam.load("tip"), beam.load("base")
    apart = 2.0 * fit.rom.force_map(z, one) - 3.0 * fit.rom.force_map(z, two)
    together = fit.rom.force_map(z, 2.0 * one - 3.0 * two)
    np.testing.assert_allclose(together, apart, atol=1e-10 * np.abs(apart).max())


def test_what_is_loaded_is_what_was_saved(fit, beam, tmp_path):
    fit.rom.to_dataset().to_netcdf(tmp_path / "rom.nc")
    again = rom_from_dataset(xr.load_dataset(tmp_path / "rom.nc"))
    assert type(again) is type(fit.rom)
    z, p = states(fit.rom), beam.load("middle")
    for function in ("decode", "drift", "displacement"):
        assert np.array_equal(getattr(again, function)(z), getattr(fit.rom, function)(z))
    assert np.array_equal(again.encode(fit.rom.decode(z)), fit.rom.encode(fit.rom.decode(z)))
    assert np.array_equal(again.force_map(z, p), fit.rom.force_map(z, p))


def test_wrong_shapes_are_refused(fit, beam):
    rom, n, r = fit.rom, beam.known.sizes["dof"], len(fit.rom.reach)
    z, p = states(rom), beam.load("tip")
    for wrong in (
        lambda: rom.encode(np.zeros((3, 2 * n + 2))),
        lambda: rom.decode(np.zeros((3, r + 1))),
        lambda: rom.drift(np.zeros((3, r + 1))),
        lambda: rom.force_map(z, p[:-1]),
    ):
        with pytest.raises(ValueError):
            wrong()


def test_guards_are_there_or_unsupported(fit):
    z = 5.0 * states(fit.rom)
    for guards in (Guards(), Guards("linear"), Guards(dissipative=3), Guards("linear", 3)):
        try:
            guarded = fit.rom.guarded(guards, fit.training)
        except Unsupported:
            continue
        assert np.isfinite(guarded.drift(z)).all()


def test_phases_are_parts_of_the_time_that_a_fit_takes(fit):
    clock = fit.training.monitor
    assert clock.spent("total") > 0.0
    assert clock.spent("mapping") + clock.spent("dynamics") <= clock.spent("total")


@pytest.mark.parametrize("path", sorted(FILES.glob("*.yaml")), ids=lambda path: path.stem)
def test_a_file_holds_only_what_differs_from_the_class(path):
    file = yaml.safe_load(path.read_text())
    if "rule" in file:
        return  # an outside method has no class
    plain = method_from_settings(file.get("method", path.stem), {})
    for key, value in (file.get("settings") or {}).items():
        assert getattr(plain, key) != value, f"{key}: {value} is the default"


@pytest.mark.parametrize("name", NAMES)
def test_wrong_settings_are_one_line(name, example):
    name = example if name == EXAMPLE else name
    with pytest.raises(MethodError, match=f"methods.{name}.colour is no setting"):
        method_from_settings(name, {"colour": "red"})
    for item in fields(method_from_settings(name, {})):
        with pytest.raises(MethodError, match=item.name):
            method_from_settings(name, {item.name: {"neither": "number nor word"}})
