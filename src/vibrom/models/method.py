"""What a method is: settings, and `fit(training) -> Rom`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from vibrom.models.rom import Guards, Rom
from vibrom.models.training import Training


@dataclass(frozen=True)
class Method(ABC):
    """How to learn a Rom. The fields are the settings of its yaml file; those of `Guards` are
    every method's.
    """

    extrapolation: str = field(default="none", kw_only=True)  # see Guards
    dissipative: int = field(default=0, kw_only=True)  # see Guards

    @abstractmethod
    def fit(self, training: Training) -> Rom:
        """The model that these settings make of the training data."""

    def learn(self, training: Training) -> Rom:
        """`fit`, then the guards."""
        guards, fitted = Guards(self.extrapolation, self.dissipative), self.fit(training)
        with training.monitor.phase("dynamics"):
            return fitted.guarded(guards, training)
