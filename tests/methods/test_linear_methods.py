"""Modal projection and SSMLearn on data whose reduced dynamics is known."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix, identity

from vibrom.artefacts.data import DataError, label, open_dataset, save_dataset, variable
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.methods import method_from_settings
from vibrom.methods.modal_projection import ModalProjection
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import MethodError, Structure, Training, Trajectory

OMEGA, DAMPING, CUBIC = 3.0, 0.05, 2.0
PHI = np.array([0.6, 0.8, 0.0])


def slaved(z):
    """Displacements (m, 3): one mode, and a second direction that follows it quadratically."""
    return np.outer(z, PHI) + np.outer(z**2, [0.0, 0.0, 0.3])


@pytest.fixture(scope="module")
def training():
    t = np.linspace(0, 20, 2001)
    z, dz = solve_ivp(
        lambda t, y: [y[1], -(OMEGA**2) * y[0] - DAMPING * y[1] - CUBIC * y[0] ** 3],
        (0, 20),
        [0.8, 0.0],
        t_eval=t,
        rtol=1e-11,
        atol=1e-13,
    ).y
    ddz = -(OMEGA**2) * z - DAMPING * dz - CUBIC * z**3
    follow = np.array([0.0, 0.0, 0.3])
    q, v = slaved(z), np.outer(dz, PHI) + np.outer(2 * z * dz, follow)
    a = np.outer(ddz, PHI) + np.outer(2 * dz**2 + 2 * z * ddz, follow)
    structure = Structure(
        csr_matrix(identity(3)),
        csr_matrix(DAMPING * identity(3)),
        csr_matrix(OMEGA**2 * np.outer(PHI, PHI)),
        PHI[None],
        np.array([OMEGA]),
    )
    return Training((Trajectory(t, q, v, a),), structure=structure)


@pytest.mark.parametrize("method", [ModalProjection(), SsmLearn(), SsmLearn(1, 5, 5)])
def test_finds_the_dynamics_it_was_given(training, method):
    rom = method.fit(training)
    z = np.random.default_rng(0).uniform(-0.5, 0.5, (20, 2)) * [1.0, OMEGA]
    exact = np.stack(
        [z[:, 1], -(OMEGA**2) * z[:, 0] - DAMPING * z[:, 1] - CUBIC * z[:, 0] ** 3], axis=1
    )
    # The data hold the model exactly; least squares on it loses the condition number of the cubic
    # library, some 1e3.
    np.testing.assert_allclose(rom.drift(z), exact, atol=1e-6)
    np.testing.assert_allclose(
        rom.force_map(z, np.array([1.0, 2.0, 5.0])), np.tile([0.0, 2.2], (20, 1))
    )


def test_ssmlearn_finds_the_graph(training):
    rom, z = SsmLearn().fit(training), np.linspace(-0.7, 0.7, 11)
    x = rom.decode(np.stack([z, np.zeros(11)], axis=1))
    np.testing.assert_allclose(x[:, :3], slaved(z), atol=1e-8)
    np.testing.assert_allclose(rom.encode(x), np.stack([z, np.zeros(11)], axis=1), atol=1e-8)


def test_modal_projection_misses_the_graph_and_says_so_by_its_error(training):
    rom, truth = ModalProjection().fit(training), training.trajectories[0]
    q = rom.decode(rom.encode(truth.state))[:, :3]
    np.testing.assert_allclose(q[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(q[:, :2], truth.displacement[:, :2], atol=1e-12)


def test_save_equals_load(training, tmp_path):
    rom = SsmLearn(1, 4, 3).fit(training)
    dataset = rom.to_dataset().assign(outcome=variable((), "ok", "1", "how the fit ended"))
    save_dataset(label(dataset, "rom", scene="s", method="m"), tmp_path / "rom.nc")
    again, z = rom_from_dataset(open_dataset(tmp_path / "rom.nc", "rom")), np.array([[0.3, -1.0]])
    for question in ("decode", "drift"):
        np.testing.assert_array_equal(getattr(again, question)(z), getattr(rom, question)(z))
    np.testing.assert_array_equal(again.encode(np.arange(6.0)), rom.encode(np.arange(6.0)))


def test_without_operators_one_clear_line(training):
    bare = Training(training.trajectories)
    with pytest.raises(MethodError, match="ssmlearn needs mass, damping, stiffness and modes"):
        SsmLearn(tangent="modes").fit(bare)


def test_unknown_setting_is_named():
    with pytest.raises(
        MethodError,
        match="methods.ssmlearn.degree is no setting; ",
    ):
        method_from_settings("ssmlearn", {"degree": 5})


def test_a_rom_of_an_unknown_class_is_refused():
    with pytest.raises(DataError, match="names no model class of vibrom"):
        rom_from_dataset(xr.Dataset(attrs={"rom": "os:system"}))


def test_monomials_by_hand():
    assert exponents(2, 1, 2).tolist() == [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]
    np.testing.assert_allclose(monomials(np.array([2.0, 3.0]), exponents(2, 1, 2)), [2, 3, 4, 6, 9])
    assert len(exponents(4, 0, 5)) == 126  # binomial(4 + 5, 4)


def test_least_squares_does_not_care_for_units():
    rng = np.random.default_rng(0)
    library, weights = rng.standard_normal((50, 4)), rng.standard_normal((2, 4))
    scale = np.array([1e-12, 1.0, 1e9, 1e3])
    np.testing.assert_allclose(
        least_squares(library * scale, library @ weights.T) * scale, weights, rtol=1e-9
    )


def test_more_modes_than_there_are_is_refused(training):
    with pytest.raises(MethodError, match="modes = 2: the structure holds 1 modes"):
        ModalProjection(modes=2).fit(training)
