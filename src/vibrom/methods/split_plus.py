"""SPLIT+: the coordinates of a fitted SPLIT, with first-order dynamics fitted anew.

    d/dt (z, z') = R0 (z, z') + R Phi(z, z')

R0 is the known linear part, Phi the monomials 2..p, and R comes by least squares from the encoded
motion, every amplitude alike (`amplitude_power`).
"""

from dataclasses import dataclass, replace

from vibrom.latent.autoencoder_method import fit_first_order, scaled_motion
from vibrom.latent.autoencoder_rom import RULES, AutoencoderRom
from vibrom.latent.coordinates import linear_dynamics
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Training


@dataclass(frozen=True)
class SplitPlus(Method):
    order: int = 3  # p
    force_rule: str = "decoder"
    amplitude_power: float = -1.0  # of a sample's weight

    def __post_init__(self) -> None:
        if self.force_rule not in RULES:
            raise MethodError(f"force_rule is {self.force_rule!r}; give one of {', '.join(RULES)}")
        if self.order < 1:
            raise MethodError(f"order is {self.order}; give 1 or more")

    def fit(self, training: Training) -> AutoencoderRom:
        start = training.start
        if not isinstance(start, AutoencoderRom):
            raise MethodError(
                f"split_plus starts from a fitted autoencoder, and was given {type(start).__name__}; set starts_from: split"
            )
        with training.monitor.phase("dynamics"):
            linear = linear_dynamics(
                training.require_structure("split_plus"), start.latent, float(start.rate)
            )
            coefficients = fit_first_order(
                scaled_motion(start, training), self.order, linear, self.amplitude_power
            )
        return replace(
            start, coefficients=coefficients, order=self.order, force_rule=self.force_rule
        )
