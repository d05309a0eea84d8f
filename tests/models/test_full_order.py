"""The full order answers at the instants that it is asked for, and only there."""

import numpy as np
import pytest
import two_dofs

from vibrom.models.model import Drive, Watch


def test_watches_are_independent_of_one_another():
    """All displacements at some instants, one of them at others, as in a run that keeps all."""
    model = two_dofs.full_order()
    step = model.period / model.steps_per_period
    drive = Drive(np.array([0.1, 0.3]), np.full(2, model.frequency))
    start = np.zeros((2, 4))
    every, some, late = np.arange(401) * step, np.arange(7, 400, 14) * step, np.arange(390, 401)
    whole = model.motion(start, drive, Watch(every)).displacement[0]
    watched = model.motion(
        start, drive, Watch(some, np.array([1])), Watch(late * step), Watch(some[:3], np.array([0]))
    ).displacement
    np.testing.assert_array_equal(watched[0], whole[:, 7:400:14, 1:])
    np.testing.assert_array_equal(watched[1], whole[:, 390:401])
    np.testing.assert_array_equal(watched[2], whole[:, 7:40:14, :1])


def test_an_instant_between_two_steps_is_refused():
    model = two_dofs.full_order()
    half = 0.5 * model.period / model.steps_per_period
    with pytest.raises(ValueError, match=r"the instant .* lies between two time steps"):
        model.motion(np.zeros((1, 4)), None, Watch(np.array([0.0, half])))


def test_eigenvalues_are_those_of_the_first_order_form():
    """Of [0, 1; -M^-1 K, -c]."""
    matrix = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(two_dofs.MASS, two_dofs.STIFFNESS), -two_dofs.DAMPING * np.eye(2)],
        ]
    )

    def ordered(values):
        return values[np.argsort(values.imag)]

    for model in (two_dofs.full_order(), two_dofs.reduced()):
        values = ordered(model.eigenvalues())
        np.testing.assert_allclose(values, ordered(np.linalg.eigvals(matrix)), rtol=1e-8)
