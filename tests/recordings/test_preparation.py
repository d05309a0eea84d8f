"""What is made of recordings, against a motion that is known in closed form."""

import numpy as np
import pytest
from oscillator import Oscillator, noisy

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import Preparation
from vibrom.experiments.backbone import peak_finding_and_fitting
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Watch
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.training import Training
from vibrom.recordings import filters, linear, preparation, samples

IT = Oscillator()
TIME = np.arange(0.0, 12.0, 1 / 500)  # a hundred samples of each of 60 periods
NOISE = (0.0, 0.01, 0.05)


def recording(values, role="train", time=TIME):
    block = np.reshape(values, (len(time), -1))
    return samples.Samples(role, role, time, block, tuple("abc"[: block.shape[1]]))


def decays(noise, settings=None, starts=(1.0, 0.85)):
    both = [
        recording(noisy(IT.motion(TIME, start), noise, seed), role)
        for seed, (start, role) in enumerate(zip(starts, ("train", "test")))
    ]
    return preparation.prepare(both, settings or Preparation())


@pytest.mark.parametrize("noise", NOISE)
def test_displacement_velocity_and_acceleration_are_those_of_the_motion(noise):
    """Without noise the filter takes (f_1/f_c)^8 = 1e-4 of the motion. White noise of deviation s
    leaves s sqrt(2 f_c h) in the displacement, about sqrt(1/3) f_c/f_1 times as much, relative to
    the motion, in the velocity, and sqrt(1/5) (f_c/f_1)^2 in the acceleration; f_c = 3 f_1.
    """
    settings = Preparation(harmonics=1, delays=1, rest="zero", start=0.0)
    motion = decays(noise, settings).of("train")[0].motion
    step = 1e-4
    around = [IT.motion(motion.time + shift, 1.0) for shift in (-step, 0.0, step)]
    truth = (
        around[1],
        (around[2] - around[0]) / (2 * step),
        (around[2] - 2 * around[1] + around[0]) / step**2,
    )
    left = noise * np.sqrt(2 * 3 / 100)
    for order, (name, values) in enumerate(
        zip(("displacement", "velocity", "acceleration"), truth)
    ):
        error = getattr(motion, name)[:, 0] - values
        shares = left * 3.0**order / np.sqrt(2 * order + 1)
        relative = error.std() / IT.omega**order
        assert relative < 2e-4 + 1.3 * shares
        assert noise == 0.0 or relative > 0.7 * shares  # as much as must be left, no more


@pytest.mark.parametrize(("noise", "within"), [(0.0, (1e-3, 5e-3)), (0.01, (1e-3, 0.03))])
@pytest.mark.parametrize("kind", ["regularised", "savitzky_golay"])
def test_the_linear_part_is_found(noise, within, kind):
    found = linear.linear_part([decays(noise, Preparation(filter=kind)).of("train")[0].motion])
    assert found.frequency == pytest.approx(IT.omega, rel=within[0])
    assert found.frequency * found.damping_ratio == pytest.approx(IT.damping, rel=within[1])


@pytest.mark.parametrize(
    ("noise", "frequency", "damping", "decay"),
    [(0.0, 5e-4, 0.02, 0.2), (0.01, 1e-3, 0.03, 1.0), (0.05, 4e-3, 0.12, 4.0)],
)
def test_a_model_has_the_known_frequency_and_damping_over_amplitude(
    noise, frequency, damping, decay
):
    """Of motions from the largest amplitude to a seventh of it; and it predicts the decay that it
    never saw, the noise aside.
    """
    made = decays(noise)
    rom = SsmLearn(order_decoder=3, order_dynamics=5).learn(Training((made.of("train")[0].motion,)))
    model = Reduced(rom, np.full(3, np.nan), made.probes, IT.omega, Integrator())
    test = made.of("test")[0].motion
    instants = np.arange(0.0, 6.0, 1 / 500)
    run = model.motion(test.state[:1], None, Watch(instants, made.probes))
    found = run.displacement[0][0, :, 0]
    amplitude, omega, zeta, *_ = peak_finding_and_fitting(instants, found)
    assert amplitude.max() > 0.7 and amplitude.min() < 0.15
    inner = slice(2, -2)  # at its ends the slope of the amplitude is one-sided
    np.testing.assert_allclose(omega[inner], IT.frequency_at(amplitude)[inner], rtol=frequency)
    rate = (zeta * omega)[inner]
    np.testing.assert_allclose(rate, IT.damping_at(amplitude)[inner], rtol=damping)
    truth = IT.motion(test.time[0] + instants, 0.85)
    assert nmte_percent(truth[:, None], found[:, None]) < decay


@pytest.mark.parametrize("noise", NOISE)
@pytest.mark.parametrize(("ratio", "rate"), [(3.5, 3.0), (5.1, 3.0), (5.1, 12.0)])
def test_the_slow_motion_begins_where_the_fast_one_has_died_out(noise, ratio, rate):
    """A second mode whose share of the acceleration is ratio^4 exp(2 (0.3 - rate) t), also where
    its frequency is nearly a multiple of the first one. The rule has steps of a period, 0.2 s; the
    limit is 1e-4, or four times what noise leaves.
    """
    fast = 0.3 * np.exp(-rate * TIME) * np.cos(ratio * IT.omega * TIME)
    settings = Preparation(harmonics=4)
    mixed, pure = (
        preparation.prepare([recording(noisy(x, noise))], settings).prepared[0].slow
        for x in (IT.motion(TIME, 0.3) + fast, IT.motion(TIME, 0.3))
    )
    assert pure.begin == 0.0
    assert mixed.limit >= 1e-4 and (noise > 0.0 or mixed.limit == 1e-4)
    known = np.log(ratio**4 / mixed.limit) / (2 * (rate - IT.damping))
    assert mixed.begin == pytest.approx(known, abs=0.4)


def test_a_start_that_is_set_replaces_the_rule():
    chosen = preparation.prepare([recording(IT.motion(TIME, 0.3))], Preparation(start=3.0))
    assert chosen.prepared[0].motion.time[0] == pytest.approx(3.0 + chosen.lag * 2, abs=0.01)


def test_a_fast_motion_that_the_slow_channel_does_not_see_is_seen_by_the_other():
    """Two channels, in phase in the slow mode; the fast one moves the second alone."""
    fast = 0.1 * np.exp(-3.0 * TIME) * np.cos(3.5 * IT.omega * TIME)
    x = IT.motion(TIME, 0.3)
    both = recording(np.stack([x, 0.5 * x + fast], axis=1))
    alone = recording(np.stack([x, 0.5 * x], axis=1))
    settings = Preparation(harmonics=4)
    found = [preparation.prepare([item], settings).prepared[0].slow.begin for item in (both, alone)]
    assert found[0] > 1.0 and found[1] == 0.0


def test_a_motion_that_does_not_decay_is_refused():
    with pytest.raises(DataError, match="train: swings as far at its end as at its beginning"):
        preparation.prepare([recording(np.sin(31.0 * TIME))], Preparation())


def test_channels_that_determine_no_linear_motion_are_refused():
    """A counter beside the instants: it rises, and its acceleration is zero."""
    counter = recording(np.stack([IT.motion(TIME, 0.3), 1e3 * TIME], axis=1))
    motion = preparation.prepare([counter], Preparation(frequency=5.0, start=0.0)).of("train")[0]
    with pytest.raises(DataError, match="the recordings do not determine a linear motion"):
        linear.linear_part([motion.motion])


def test_delays_of_a_vibration_are_in_phase():
    """q_k = cos(k omega l) x, and so are their velocities; damping adds a quarter of a period later
    a k l sin(k omega l) = 0.3 * 0.024 * 0.68 = 5e-3 of x.
    """
    settings = Preparation(rest="zero", frequency=5.0)
    small = preparation.prepare([recording(IT.motion(TIME, 0.01))], settings)
    motion = small.prepared[0].motion
    assert small.delays == 5 and motion.displacement.shape[1] == 3
    for name in ("displacement", "velocity", "acceleration"):
        values = getattr(motion, name)
        np.testing.assert_allclose(
            values, values[:, :1] * small.in_phase, atol=6e-3 * np.abs(values).max()
        )


@pytest.mark.parametrize(("channels", "delays"), [(1, 5), (2, 3), (3, 3), (4, 3), (5, 1), (9, 1)])
def test_few_channels_are_delayed_until_there_are_five_observables(channels, delays):
    assert preparation.delays_of(channels) == delays


def test_harmonics_are_kept_as_far_as_they_stand_out():
    x = IT.motion(TIME, 0.5)
    third = (x + 0.05 * x**3)[:, None]  # a third harmonic of 0.05 r^2/4 = 3e-3 of the first
    assert filters.harmonics(third, 1 / 500, 5.06) == 3
    assert filters.harmonics(noisy(third, 0.05), 1 / 500, 5.06) == 1


def test_too_many_samples_of_a_period_are_thinned():
    time = np.arange(0.0, 4.0, 1 / 10000)
    made = preparation.prepare([recording(IT.motion(time, 0.3), time=time)], Preparation(delays=1))
    motion = made.prepared[0].motion
    np.testing.assert_allclose(motion.displacement[:, 0], IT.motion(motion.time, 0.3), atol=1e-3)
    assert np.diff(motion.time)[0] * 200 * 5.0 >= 0.95
    assert any("th sample kept" in note for note in made.prepared[0].notes)


def test_displacements_are_measured_from_rest():
    shifted = preparation.prepare([recording(IT.motion(TIME, 0.3) + 0.7)], Preparation(delays=1))
    motion = shifted.prepared[0].motion
    np.testing.assert_allclose(motion.displacement[:, 0], IT.motion(motion.time, 0.3), atol=1e-3)
