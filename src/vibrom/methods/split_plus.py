"""SPLIT+: the coordinates of a fitted SPLIT, with first-order dynamics fitted again.

    d/dt (z, z') = R0 (z, z') + R Phi(z, z')

R0 is the known linear part, Phi the monomials 2..p, and R comes by least squares from the encoded
motion, every amplitude alike (`amplitude_power`).
"""

from dataclasses import dataclass, replace
from typing import Literal

from vibrom.config.kinds import Order
from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.coefficients import fit_first_order
from vibrom.latent.coordinates import linear_dynamics
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Training


@dataclass(frozen=True)
class SplitPlus(Method):
    """See the module."""

    order: Order = 3  # of the polynomial dynamics
    # decoder_mass: virtual work, right for any load; decoder: equation 2.16 of the thesis, and
    # encoder, which are right for loads proportional to the mass times the motion
    force_rule: Literal["decoder_mass", "decoder", "encoder"] = "decoder_mass"
    # a sample of the least squares weighs |(z, z')| to this power: -1 every amplitude alike, as
    # errors grow with it; 0 every sample alike
    amplitude_power: float = -1.0

    def fit(self, training: Training) -> AutoencoderRom:
        """See Method."""
        start, structure = training.start, training.require_structure("split_plus")
        if not isinstance(start, AutoencoderRom):
            raise MethodError(
                "split_plus starts from a fitted autoencoder, and was given "
                f"{type(start).__name__}; set starts_from: split"
            )
        with training.monitor.phase("dynamics"):
            linear = linear_dynamics(structure, start.latent, start.frequency)
            coefficients = fit_first_order(
                start.encoded(training), self.order, linear, self.amplitude_power
            )
        return replace(
            start, coefficients=coefficients, order=self.order, force_rule=self.force_rule
        )
