"""What the methods with an autoencoder share: settings, coordinates, one training, and the model
made of it.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent import coordinates
from vibrom.latent.autoencoder_rom import BEYOND, RULES, AutoencoderRom, slope_at_rest
from vibrom.latent.coordinates import Coordinates
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Training

if TYPE_CHECKING:
    import torch

    from vibrom.latent.autoencoder import Autoencoder
    from vibrom.latent.training import Dynamics, Schedule

CHOICES = {
    "activation": ("elu", "silu", "softplus", "tanh"),
    "linear": ("none", "pod", "modes"),
    "time_scale": ("first_frequency", "none"),
    "optimiser": ("soap", "adam"),
    "schedule": ("one_cycle", "constant"),
    "precision": ("float32", "float64"),
    "force_rule": RULES,
    "decoder_beyond": BEYOND,
}


@dataclass(frozen=True)
class Problem:
    """Samples (3, m, k) in these coordinates, the linear parts E and D beside the networks, the
    networks, and the dynamics learnt with them.
    """

    coordinates: Coordinates
    train: np.ndarray
    straight: tuple[np.ndarray, np.ndarray]
    autoencoder: Autoencoder
    dynamics: Dynamics | None
    device: torch.device


@dataclass(frozen=True)
class AutoencoderMethod(Method):
    """Settings of network, coordinates and optimiser."""

    latent: int = 1  # d, reduced positions; the state has 2 d coordinates
    order: int = 3  # p, of the polynomial dynamics
    hidden: tuple[int, ...] = (
        64,
        32,
    )  # units of the encoder's hidden layers; the decoder mirrors them
    activation: str = "silu"
    # proper orthogonal directions that carry the displacements, at most; 0: the displacements
    # themselves
    rank: int = 14
    # linear part beside the networks: none, first POD directions, or modes with the decoder tangent
    # to them at rest
    linear: str = "pod"
    scaled: bool = True  # displacements divided by their root mean square
    time_scale: str = "first_frequency"  # or none: seconds
    every: int = 10  # train on every k-th sample
    epochs: int = 400
    batch: int = 0  # samples in a step; 0: all
    shuffle: bool = False
    optimiser: str = "soap"
    learning_rate: float = 3e-2
    schedule: str = "one_cycle"
    precision: str = "float32"
    force_rule: str = "decoder"
    decoder_beyond: str = (
        "network"  # the training range: the network itself, or its tangent at the edge
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "hidden", tuple(self.hidden))
        for name, allowed in CHOICES.items():
            if getattr(self, name) not in allowed:
                raise MethodError(
                    f"{name} is {getattr(self, name)!r}; give one of {', '.join(allowed)}"
                )
        for name in ("latent", "order", "every", "epochs"):
            if getattr(self, name) < 1:
                raise MethodError(f"{name} is {getattr(self, name)}; give 1 or more")
        if self.rank and self.rank < self.latent:
            raise MethodError(
                f"rank is {self.rank}, fewer directions than latent = {self.latent}; give {self.latent} or more, or 0 for the displacements themselves"
            )
        if not self.learning_rate > 0:
            raise MethodError(f"learning_rate is {self.learning_rate}; give a positive number")
        if not all(isinstance(size, int) and size > 0 for size in self.hidden):
            raise MethodError(
                f"hidden is {list(self.hidden)}; give the number of units of each layer, such as [64, 32]"
            )

    def dynamics(
        self, training: Training, chosen: Coordinates, stack: np.ndarray
    ) -> Dynamics | None:
        """What is learnt together with the autoencoder; None: nothing."""
        return None

    @abstractmethod
    def coefficients(
        self,
        motion: tuple[np.ndarray, ...],
        learnt: np.ndarray | None,
        training: Training,
        rate: float,
    ) -> np.ndarray:
        """Coefficients of all monomials 1..order, from the encoded motion z, dz/dtau, d2z/dtau2 and
        from what was learnt with the networks.
        """

    def fit(self, training: Training) -> AutoencoderRom:
        # torch takes seconds to import, and neither a plan of the workflow nor a fitted model needs
        # it.
        from vibrom.latent.training import pick_device, train, warm_up

        warm_up(pick_device(training.device))
        with training.monitor.phase("mapping"):
            problem = self.problem(training)
            learnt = train(
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
            return self.model(training, problem, learnt)

    def problem(self, training: Training) -> Problem:
        """What is to be learnt, from which samples."""
        import torch

        from vibrom.latent.autoencoder import Autoencoder
        from vibrom.latent.training import pick_device

        chosen = coordinates.choose(
            training,
            rank=self.rank,
            modes=self._modes,
            scaled=self.scaled,
            time_scale=self.time_scale,
        )
        stack = chosen.stack(training.trajectories, self.every)
        straight = coordinates.linear_parts(training, chosen, stack[0], self.linear, self.latent)
        device = pick_device(training.device)
        tensors = [
            None
            if self.linear == "none"
            else torch.tensor(part, dtype=getattr(torch, self.precision), device=device)
            for part in straight
        ]
        autoencoder = Autoencoder(
            (stack.shape[-1], *self.hidden, self.latent),
            self.activation,
            *tensors,
            fixed_tangent=self._modes > 0,
        )
        return Problem(
            chosen,
            stack,
            straight,
            autoencoder,
            self.dynamics(training, chosen, stack),
            device,
        )

    def plan(self) -> Schedule:
        from vibrom.latent.training import Schedule

        return Schedule(
            self.epochs,
            self.batch,
            self.shuffle,
            self.learning_rate,
            self.schedule,
            self.precision,
            self.optimiser,
        )

    @property
    def _modes(self) -> int:
        return self.latent if self.linear == "modes" else 0

    def model(
        self, training: Training, problem: Problem, learnt: list[np.ndarray]
    ) -> AutoencoderRom:
        """The model with these weights and, if dynamics were learnt with them, its coefficients."""
        sizes, chosen = problem.autoencoder.sizes, problem.coordinates
        parts, found = (learnt[:-1], learnt[-1]) if problem.dynamics else (learnt, None)
        encoder_linear, decoder_linear = problem.straight
        if self._modes:
            decoder_linear = decoder_linear - slope_at_rest(
                parts[len(sizes) - 1 :], self.activation
            )
        mass = dict.fromkeys(("mass_row", "mass_column", "mass_value"))
        if training.structure:
            entries = training.structure.mass.tocoo()
            mass = {"mass_row": entries.row, "mass_column": entries.col, "mass_value": entries.data}
        rom = AutoencoderRom(
            reach=np.ones(2 * self.latent),
            sizes=np.array(sizes),
            weights=np.concatenate([part.ravel() for part in parts]),
            encoder_linear=encoder_linear,
            decoder_linear=decoder_linear,
            basis=chosen.basis,
            scale=np.float64(chosen.scale),
            rate=np.float64(chosen.rate),
            coefficients=np.zeros((self.latent, len(exponents(2 * self.latent, 1, self.order)))),
            order=self.order,
            activation=self.activation,
            force_rule=self.force_rule,
            decoder_beyond=self.decoder_beyond,
            **mass,
        )
        motion = scaled_motion(rom, training)
        reach = np.concatenate(
            [np.abs(motion[0]).max(axis=0), np.abs(motion[1]).max(axis=0) * chosen.rate]
        )
        return replace(
            rom, reach=reach, coefficients=self.coefficients(motion, found, training, chosen.rate)
        )


def scaled_motion(rom: AutoencoderRom, training: Training) -> tuple[np.ndarray, ...]:
    """z, dz/dtau and d2z/dtau2 (samples, d) of all training data."""
    z, first, second = rom.encode_motion(
        *(training.joined(what) for what in ("displacement", "velocity", "acceleration"))
    )
    rate = float(rom.rate)
    return z, first / rate, second / rate**2


def fit_first_order(
    motion: tuple[np.ndarray, ...], order: int, linear: np.ndarray | None, amplitude_power: float
) -> np.ndarray:
    """R (2d, l) of d/dtau (z, z') = R Phi(z, z') by least squares; `linear` R0 (d, 2d) keeps the
    second row's linear part fixed.

    A sample weighs |(z, z')|^amplitude_power. What one coordinate leaves of the motion, the
    vibration of other modes, decays with it: errors are in proportion to the amplitude, and the
    power -1 makes them alike (generalised least squares; Aitken, Proc. R. Soc. Edinb. 55 (1936)
    42).
    """
    z, first, second = motion
    y, d = np.hstack([z, first]), z.shape[1]
    target = np.hstack([first, second])
    size = np.linalg.norm(y, axis=1)
    weight = (np.maximum(size / size.max(), 1e-6) ** amplitude_power)[
        :, None
    ]  # a sample at rest tells nothing, and must not weigh infinitely
    if linear is None:
        return least_squares(weight * monomials(y, exponents(2 * d, 1, order)), weight * target)
    fixed = np.vstack([np.eye(2 * d)[d:], linear])
    return np.hstack(
        [
            fixed,
            least_squares(
                weight * monomials(y, exponents(2 * d, 2, order)), weight * (target - y @ fixed.T)
            ),
        ]
    )
