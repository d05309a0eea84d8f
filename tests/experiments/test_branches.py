"""Branches and sweeps of two masses with a hardening spring, whose curve folds."""

import dataclasses

import numpy as np
import periodic_systems as systems
import pytest
import two_dofs

from vibrom.experiments.branches import Branches
from vibrom.experiments.resonance import Resonance
from vibrom.experiments.s_curve import SCurve
from vibrom.experiments.sweeps import Sweeps
from vibrom.models.curves import curve_of
from vibrom.models.rollout import Integrator

FORCING = 0.06
RANGE = {"lowest": 0.85, "highest": 1.4}
LINEAR = systems.TWO | {"cubic": [0.0, 0.0]}


@pytest.fixture(scope="module")
def models():
    return systems.full_order(**systems.TWO), systems.reduced(**systems.TWO)


@pytest.fixture(scope="module")
def branches():
    return Branches(forcing=FORCING, frequencies=45, **RANGE)


@pytest.fixture(scope="module")
def answers(models, branches):
    return [branches.ask(model, two_dofs.given()) for model in models]


def test_an_exact_model_has_the_folds_of_the_full_order(answers, branches):
    truth, model = answers
    scores = branches.score(model, truth)
    assert scores["folds"] == 2.0 and scores["wrong_stable_motions"] == 0.0
    # The steps shift frequencies by 1e-5; a peak and a fold are flat in amplitude.
    assert abs(scores["fold_frequency_error_percent"]) < 0.01
    assert abs(scores["fold_amplitude_error_percent"]) < 0.1
    assert abs(scores["peak_error_percent"]) < 0.05
    assert abs(scores["bistable_width_error_percent"]) < 0.1
    assert scores["stable_amplitude_error_percent"] < 1.0
    assert scores["unstable_amplitude_error_percent"] < 1.0


def test_a_model_that_is_wrong_says_so(answers, branches, models):
    """A spring that is a fifth stiffer moves the folds by a tenth of their detuning or more."""
    truth, _ = answers
    stiffer = systems.reduced(**systems.TWO | {"cubic": [6.0, 0.0]})
    scores = branches.score(branches.ask(stiffer, two_dofs.given()), truth)
    assert scores["folds"] == 2.0 and 0.3 < scores["fold_frequency_error_percent"] < 10.0
    assert scores["wrong_stable_motions"] > 0.0
    linear = branches.ask(systems.reduced(**LINEAR), two_dofs.given())
    scores = branches.score(linear, truth)
    assert scores["folds"] == 0.0 and scores["fold_frequency_error_percent"] == np.inf
    assert scores["bistable_width_error_percent"] == pytest.approx(-100.0)


def test_harmonic_balance_gives_a_second_opinion_of_reduced_models(answers, branches, models):
    """The full order's motions stay those of its own steps."""
    asked = dataclasses.replace(branches, method="harmonic_balance", harmonics=9, resonances=0)
    answer = asked.ask(models[1], two_dofs.given())
    curve, shot = curve_of(answer), curve_of(answers[1])
    places = [item.parameter[item.folds] for item in (curve, shot)]
    np.testing.assert_allclose(*places, rtol=1e-7)
    np.testing.assert_array_equal(answer["stable_motions"], answers[1]["stable_motions"])
    assert int(answer["harmonics"]) == 9 and float(answer["missed"].max()) < 1e-5
    brief = asked.brief().ask(models[0], two_dofs.given())
    assert "missed" not in brief


def test_two_stable_motions_are_counted_between_the_folds(answers):
    for answer in answers:
        curve = curve_of(answer)
        high, low = curve.parameter[curve.folds]
        grid = answer["grid"].values
        inside = (low < grid) & (grid < high)
        assert inside.sum() > 2
        np.testing.assert_array_equal(answer["stable_motions"].values, 1 + inside)
        assert float(answer["bistable_width"]) == pytest.approx(high - low, rel=1e-6)


def test_the_largest_multiplier_decides_on_stability(answers):
    for answer in answers:
        largest = answer["multiplier_largest"].values
        np.testing.assert_array_equal(answer["stable"].values, largest < 1.0)
        parts = answer["multiplier_real"].values + 1j * answer["multiplier_imaginary"].values
        np.testing.assert_allclose(np.abs(parts), largest, rtol=1e-12)
        at_folds = largest[answer["kind"].values == "fold"]
        np.testing.assert_allclose(at_folds, 1.0, atol=1e-3)


def test_harmonics_add_up_to_the_motion(answers):
    """A symmetric spring has odd harmonics only; the first is the amplitude, nearly."""
    for answer in answers:
        harmonic = answer["harmonic_amplitude"].values
        assert np.abs(harmonic[..., ::2]).max() < 1e-6 * harmonic.max()
        np.testing.assert_allclose(harmonic[..., 1], answer["half_range"].values, rtol=0.1)


def test_a_motion_that_leaves_the_training_range_is_marked(branches):
    narrow = systems.reduced(**systems.TWO, reach=0.5)
    answer = branches.ask(narrow, two_dofs.given())
    left = answer["range_ratio"].values > 1.01
    assert 0 < left.sum() < len(left)
    np.testing.assert_array_equal(answer["outcome"].values == "left_range", left)


def test_a_branch_ends_far_from_the_training_data(branches):
    """Motions of more than four times the range, at the ends of the steps, are not followed, and
    the branch says that it was lost there.
    """
    answer = branches.ask(systems.reduced(**systems.TWO, reach=0.1), two_dofs.given())
    assert 3.0 < answer["range_ratio"].values.max() < 6.0
    assert set(answer["outcome"].values[answer["kind"].values == "end"]) == {"lost"}


@pytest.fixture(scope="module")
def s_curve(models, answers):
    """At a frequency at which the response curve has three motions."""
    curve = curve_of(answers[1])
    high, low = curve.parameter[curve.folds]
    return SCurve(frequency=(0.3 * high + 0.7 * low) / models[1].frequency, forcing=2 * FORCING)


def test_an_s_curve_goes_through_the_motions_of_the_response_curve(models, branches, s_curve):
    """Where both are at one frequency and one forcing: two stable ones and one that is not."""
    across, along = (
        curve_of(dataclasses.replace(asked, turn=0.05, points=500).ask(models[1], two_dofs.given()))
        for asked in (s_curve, branches)
    )
    place = s_curve.frequency * models[1].frequency

    def amplitudes(curve, at):
        side = np.sign(curve.parameter - at)
        (left,) = np.nonzero(side[1:] * side[:-1] < 0)
        share = (at - curve.parameter[left]) / (curve.parameter[left + 1] - curve.parameter[left])
        rise = curve.amplitude[left + 1] - curve.amplitude[left]
        return np.sort(curve.amplitude[left] + share * rise)

    one, other = amplitudes(across, FORCING), amplitudes(along, place)
    assert len(one) == len(other) == 3
    # Both are read from chords, which turn by a twentieth: (1/20)^2/8 of their length.
    np.testing.assert_allclose(one, other, rtol=2e-3)
    assert across.motions(np.array([FORCING])).tolist() == [2]


def test_an_exact_model_has_the_s_of_the_full_order(models, s_curve):
    truth, model = (s_curve.ask(item, two_dofs.given()) for item in models)
    scores = s_curve.score(model, truth)
    assert scores["folds"] == 2.0 and scores["wrong_stable_motions"] == 0.0
    # The steps shift the frequency by 1e-5, of a detuning of a tenth.
    assert abs(scores["fold_forcing_error_percent"]) < 0.05
    assert abs(scores["bistable_width_error_percent"]) < 0.1
    assert scores["stable_amplitude_error_percent"] < 1.0
    assert scores["unstable_amplitude_error_percent"] < 1.0
    linear = s_curve.ask(systems.reduced(**LINEAR), two_dofs.given())
    assert s_curve.score(linear, truth)["fold_forcing_error_percent"] == np.inf
    np.testing.assert_allclose(  # a linear motion is as large as its forcing
        linear["maximum"].values[0] / linear["forcing"].values,
        linear["maximum"].values[0, -1] / linear["forcing"].values[-1],
        rtol=1e-5,
    )


def test_backbones_tell_how_far_frequency_and_damping_are_off(models):
    """Of a model with a tenth more damping; of one whose spring is a fifth stiffer; and of one that
    gives way before it resonates.
    """
    asked = Resonance(forcing=FORCING)
    truth = asked.ask(models[0], two_dofs.given())
    changed = [{"damping": 0.044}, {"cubic": [6.0, 0.0]}, {"cubic": [-1e6, 0.0]}]
    damped, stiffer, lost = (
        asked.ask(systems.reduced(**systems.TWO | change), two_dofs.given()) for change in changed
    )
    scores = asked.score(damped, truth)
    assert scores["damping_error_percent"] == pytest.approx(10.0, abs=0.1)
    assert scores["frequency_error_percent"] < 0.1  # of the chords between its points
    scores = asked.score(stiffer, truth)
    # A cubic spring shifts the square of the frequency in proportion to its stiffness.
    frequency, amplitude = (truth[name].values for name in ("angular_frequency", "amplitude"))
    squares = np.interp(amplitude[0], stiffer["amplitude"][0], stiffer["angular_frequency"]) ** 2
    shifts = squares - frequency[0] ** 2, frequency**2 - frequency[0] ** 2
    assert shifts[0][-4] / shifts[1][-4] == pytest.approx(1.2, abs=0.05)
    assert scores["frequency_error_percent"] > 0.2
    assert lost["outcome"].values.tolist() == ["lost"]
    assert np.isnan(list(asked.score(lost, truth).values())).all()


def test_a_budget_of_points_is_kept(models, branches):
    short = dataclasses.replace(branches, points=12).ask(models[1], two_dofs.given())
    assert short.sizes["point"] <= 12 + 3  # and those about the peak
    assert short["kind"].values[-1] == "end" and short["outcome"].values[-1] == "unfinished"


def test_sweeps_jump_at_the_folds(models, answers, branches):
    """Up at the lower fold when sweeping down, down at the upper one when sweeping up; a sweep of
    finite pace stays a little too long.
    """
    sweeps = Sweeps(forcing=FORCING, frequencies=17, periods=60, lowest=1.0, highest=1.25)
    found = [sweeps.ask(model, two_dofs.given()) for model in models]
    curve = curve_of(answers[1])
    high, low = curve.parameter[curve.folds]
    step = np.diff(found[0]["angular_frequency"].values)[0] / 2**sweeps.halvings
    for answer in found:
        up, down = answer["jump_frequency"].values
        assert up[0] < up[1] and down[0] > down[1]
        assert abs(up[1] - up[0]) == pytest.approx(step, rel=1e-6)
        assert up[1] > high - step and up[0] < high + 2 * step
        assert down[0] > low - 2 * step and down[1] < low + step
    scores = sweeps.score(found[1], found[0])
    assert scores["jumps"] == 2.0 and scores["amplitude_error_median_percent"] < 0.05
    assert abs(scores["jump_up_error_percent"]) < 100 * step
    # What is left of a transient after 60 periods of the damping 0.03 is below 1e-3 but for jumps,
    # for which a stop goes on.
    for answer in found:
        assert (answer["outcome"].values == "ok").all()
        assert (answer["change"].values <= 1e-3).all()
    for periods, longest, steady in ((60, 60, 0.8), (8, 8, 0.0), (8, 180, 1.0)):
        asked = dataclasses.replace(sweeps, periods=periods, longest=longest)
        outcome = asked.ask(models[1], two_dofs.given())["outcome"].values
        assert abs((outcome == "ok").mean() - steady) < 0.2
        assert np.isin(outcome, ("ok", "not_steady")).all()
    linear = sweeps.ask(systems.reduced(**LINEAR), two_dofs.given())
    assert sweeps.score(linear, found[0])["jump_up_error_percent"] == np.inf


def test_a_sweep_that_fails_says_so():
    """A softening spring gives way."""
    soft = systems.reduced(**systems.TWO | {"cubic": [-5.0, 0.0]})
    sweeps = Sweeps(forcing=0.5, frequencies=5, periods=5, settle=5, **RANGE)
    answer = sweeps.ask(soft, two_dofs.given())
    failed = answer["outcome"].values == "diverged"
    assert failed.any()
    np.testing.assert_array_equal(np.isnan(answer["amplitude"].values).all(axis=-1), failed)


def test_models_without_compiled_code_answer_too(models, branches):
    """The four functions of a model are enough."""

    class Plain(type(models[1].rom)):
        def field(self, p):
            return None

    rom = models[1].rom
    plain = Plain(**{item.name: getattr(rom, item.name) for item in dataclasses.fields(rom)})
    model = dataclasses.replace(models[1], rom=plain, integrator=Integrator())
    few = dataclasses.replace(branches, points=6)
    one, other = (few.ask(item, two_dofs.given()) for item in (models[1], model))
    np.testing.assert_allclose(one["maximum"].values, other["maximum"].values, rtol=1e-6)


def test_harmonic_balance_gives_a_second_opinion_of_the_full_order(answers, branches, models):
    """Where something happens, and at the peak: folds and peak of the steps, to what these are off
    by, (omega h)^2/24 in frequency, T/400.
    """
    truth, _ = answers
    asked = dataclasses.replace(branches, method="harmonic_balance", harmonics=9, resonances=0)
    answer = asked.ask(models[0], two_dofs.given())
    asked_of = answer["balanced_harmonics"].values == 9
    special = answer["kind"].values != "regular"
    assert (asked_of >= special).all() and asked_of.sum() <= special.sum() + 1
    shot, balanced = (answer[name].values for name in ("angular_frequency", "balanced_frequency"))
    np.testing.assert_allclose(balanced[asked_of], shot[asked_of], rtol=5e-5)
    shot, balanced = (answer[name].values[0] for name in ("maximum", "balanced_maximum"))
    np.testing.assert_allclose(balanced[asked_of], shot[asked_of], rtol=2e-4)
    assert np.nanmax(balanced) == pytest.approx(truth["maximum"].values[0].max(), rel=2e-4)
    # Where the equations are all but singular, at a fold, a correction is more than what is missed.
    assert answer["balanced_missed"].values[asked_of].max() < 1e-5
    assert np.isnan(answer["balanced_frequency"].values[~asked_of]).all()


def test_sweeps_find_motions_that_are_no_mirror_images_of_themselves():
    """x'' + c x' - x + x^3 = a sin(Omega t) has a well at x = 1 and one at -1, in which it swings
    like y'' + c y' + 2 y = a sin(Omega t) but for terms of order a; the symmetric motion about the
    saddle between them is unstable.
    """
    damping, forcing = 0.1, 0.005
    seen = {"frequency": np.sqrt(2.0), "probes": np.array([0, 0])}
    model = dataclasses.replace(systems.saddle(damping, 1.0), **seen)
    asked = Branches(forcing=forcing, lowest=0.7, highest=1.3, resonances=0, sweeps=2)
    answer = asked.ask(model, two_dofs.given())
    branch, omega = answer["branch"].values, answer["angular_frequency"].values
    high, low = (answer[name].values[0] for name in ("maximum", "minimum"))
    wells = [
        number for number in np.unique(branch) if answer["stable"].values[branch == number].all()
    ]
    assert len(wells) == 2 and answer["stable_motions"].values.tolist() == [2] * asked.frequencies
    one, other = (branch == number for number in wells)
    expected = forcing / np.abs(2.0 - omega**2 + 1j * damping * omega)
    for here, centre in ((one, np.sign(high[one][0])), (other, np.sign(high[other][0]))):
        swing = 0.5 * (high - low)[here]
        # (3 x^2)' and x^3 shift the frequency by some a^2 and the amplitude by a few of its own.
        assert np.abs(swing / expected[here] - 1.0).max() < 0.05
        assert np.abs(0.5 * (high + low)[here] - centre).max() < 0.01
    assert np.sign(high[one][0]) == -np.sign(high[other][0])
