"""What the methods with an autoencoder share: settings, and three steps.

training data  ->  Problem: coordinates, samples, networks  ->  weights  ->  AutoencoderRom
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import asdict, dataclass, replace
from math import comb
from typing import TYPE_CHECKING, Literal

import numpy as np

from vibrom.config.kinds import Count, Order, Positive, Units, Whole
from vibrom.latent import coordinates
from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.coordinates import Coordinates
from vibrom.latent.networks import Network
from vibrom.latent.polynomial import check_determined
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Training, Underdetermined

if TYPE_CHECKING:
    from vibrom.latent.autoencoder import Autoencoder
    from vibrom.latent.backend import torch
    from vibrom.latent.learner import Dynamics
    from vibrom.latent.training import Schedule


@dataclass(frozen=True)
class Problem:
    """What is to be learnt, from which samples."""

    coordinates: Coordinates
    train: np.ndarray  # (3, samples, k): c, dc/dtau, d2c/dtau2
    straight: tuple[np.ndarray, np.ndarray]  # linear parts E (d, k), D (k, d) beside the networks
    autoencoder: Autoencoder
    dynamics: Dynamics | None  # learnt together with the networks
    device: torch.device


@dataclass(frozen=True)
class Learnt:
    """What a training found."""

    encoder: Network
    decoder: Network
    motion: np.ndarray  # (3, m, d): z, dz/dtau, d2z/dtau2 of all training data
    xi: np.ndarray  # (d, l), of the dynamics that were learnt with the networks; l = 0: of none


@dataclass(frozen=True)
class AutoencoderMethod(Method):
    """Settings of network, coordinates and optimiser."""

    latent: Count = 1  # reduced positions; the state has twice as many coordinates
    order: Order = 3  # of the polynomial dynamics
    hidden: tuple[Units, ...] = (64, 32)  # units of the encoder's hidden layers, mirrored to decode
    # smooth ones give smooth accelerations, and tanh alone cannot bend one way
    activation: Literal["elu", "silu", "softplus", "tanh"] = "silu"
    # proper orthogonal directions that carry the displacements; 0: the displacements themselves
    rank: Whole = 14
    # linear part beside the networks: none, the first proper orthogonal directions (pod), or the
    # known modes, to which the decoder is then tangent at rest
    linear: Literal["none", "pod", "modes"] = "pod"
    scaled: bool = True  # displacements divided by their root mean square
    time_scale: Literal["first_frequency", "none"] = "first_frequency"  # none: seconds
    every: Count = 10  # train on every k-th sample
    epochs: Count = 400
    batch: Whole = 0  # samples in a step; 0: all
    shuffle: bool = False
    # soap: Adam in the eigenvectors of each layer's averaged squared gradients
    optimiser: Literal["soap", "adam"] = "soap"
    # of soap: how firmly it keeps directions that its gradients do not tell apart, over their mean
    # square; with less it follows them sooner, and rounding changes more of what it learns
    shift: Positive = 1.0
    learning_rate: Positive = 3e-2
    schedule: Literal["one_cycle", "constant"] = "one_cycle"
    precision: Literal["float32", "float64"] = "float32"
    # decoder_mass: virtual work, right for any load; decoder: equation 2.16 of the thesis, and
    # encoder, which are right for loads proportional to the mass times the motion
    force_rule: Literal["decoder_mass", "decoder", "encoder"] = "decoder_mass"
    # beyond the training range: the network itself, or its tangent at the edge
    decoder_beyond: Literal["network", "tangent"] = "network"

    def check(self) -> None:
        """See Method."""
        if self.rank and self.rank < self.latent:
            raise MethodError(
                f"rank is {self.rank}, fewer directions than latent = {self.latent}; "
                f"give {self.latent} or more, or 0 for the displacements themselves"
            )

    @abstractmethod
    def dynamics(
        self, training: Training, chosen: Coordinates, stack: np.ndarray
    ) -> Dynamics | None:
        """What is learnt together with the autoencoder from samples (3, m, k); None: nothing."""

    @abstractmethod
    def coefficients(self, learnt: Learnt, problem: Problem, training: Training) -> np.ndarray:
        """Coefficients (d, l) or (2d, l) of all monomials 1..order, in scaled time."""

    def prepare(self, device: str) -> None:
        """See Method: torch takes seconds to import, and loads more at its first use."""
        from vibrom.latent.training import pick_device, warm_up

        warm_up(pick_device(device))

    def fit(self, training: Training) -> AutoencoderRom:
        """See Method."""
        from vibrom.latent.training import train

        with training.monitor.phase("mapping"):
            problem = self.problem(training)
            weights, xi = train(
                problem.autoencoder,
                problem.dynamics,
                self.plan(),
                problem.train,
                seed=training.seed or 0,
                device=problem.device,
                monitor=training.monitor,
                label=f"{type(self).__name__} {training.seed} {sorted(asdict(self).items())}",
            )
        with training.monitor.phase("dynamics"):
            return self.model(training, problem, weights, xi)

    def problem(self, training: Training) -> Problem:
        """What is to be learnt, from which samples."""
        from vibrom.latent.autoencoder import Autoencoder
        from vibrom.latent.backend import torch
        from vibrom.latent.training import pick_device

        chosen = coordinates.choose(
            training,
            rank=self.rank,
            modes=self._modes,
            scaled=self.scaled,
            time_scale=self.time_scale,
        )
        stack = chosen.stack(training.trajectories, self.every)
        if stack.shape[-1] < self.latent:
            raise MethodError(
                f"the training data move along {stack.shape[-1]} directions, fewer than latent = "
                f"{self.latent}; lower latent"
            )
        straight = coordinates.linear_parts(training, chosen, stack[0], self.linear, self.latent)
        samples, terms = stack.shape[1], comb(2 * self.latent + self.order, self.order) - 1
        if samples < terms:
            raise Underdetermined(
                f"every = {self.every} leaves {samples} samples to train on, fewer than the "
                f"{terms} terms of dynamics of order = {self.order}; lower one, or record more"
            )
        leading = np.linalg.svd(stack[0], full_matrices=False)[2][: self.latent]
        check_determined(np.hstack([part @ leading.T for part in stack[:2]]), self.order)
        device, dtype = pick_device(training.device), getattr(torch, self.precision)
        encoder, decoder = (
            None if self.linear == "none" else torch.tensor(part, dtype=dtype, device=device)
            for part in straight
        )
        sizes = (stack.shape[-1], *self.hidden, self.latent)
        fixed = self._modes > 0
        autoencoder = Autoencoder(sizes, self.activation, encoder, decoder, fixed_tangent=fixed)
        dynamics = self.dynamics(training, chosen, stack)
        return Problem(chosen, stack, straight, autoencoder, dynamics, device)

    def plan(self) -> Schedule:
        """How long and how fast."""
        from vibrom.latent.training import Schedule

        return Schedule(
            self.epochs,
            self.batch,
            self.shuffle,
            self.learning_rate,
            self.schedule,
            self.precision,
            self.optimiser,
            self.shift,
        )

    @property
    def _modes(self) -> int:
        return self.latent if self.linear == "modes" else 0

    def model(
        self,
        training: Training,
        problem: Problem,
        weights: list[np.ndarray],
        xi: np.ndarray,
    ) -> AutoencoderRom:
        """The model with these weights and coefficients of learnt dynamics."""
        chosen, (encoder_linear, decoder_linear) = problem.coordinates, problem.straight
        half = len(weights) // 2
        encoder = Network(weights[:half], encoder_linear, self.activation)
        decoder = Network(weights[half:], decoder_linear, self.activation)
        if self._modes:
            decoder = replace(decoder, linear=decoder_linear - decoder.slope_at_rest())
        motion = encoder.motion(chosen.stack(training.trajectories))
        largest = np.abs(motion[:2]).max(axis=1)
        learnt = Learnt(encoder, decoder, motion, xi)
        return AutoencoderRom(
            reach=np.concatenate([largest[0], largest[1] * chosen.frequency]),
            sizes=np.array(problem.autoencoder.sizes),
            weights=np.concatenate([part.ravel() for part in weights]),
            encoder_linear=encoder.linear,
            decoder_linear=decoder.linear,
            basis=chosen.basis,
            scale=chosen.scale,
            frequency=chosen.frequency,
            coefficients=self.coefficients(learnt, problem, training),
            mass=training.mass,
            order=self.order,
            activation=self.activation,
            force_rule=self.force_rule,
            decoder_beyond=self.decoder_beyond,
        )
