"""What a method is: settings, and `fit(training) -> Rom`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, fields
from typing import ClassVar, Literal, get_type_hints

import msgspec

from vibrom.config.kinds import Whole
from vibrom.models.rom import Guards, Rom
from vibrom.models.training import MethodError, Training


@dataclass(frozen=True)
class Method(ABC):
    """How to learn a Rom. The fields are the settings of its yaml file; those of `Guards` are
    every method's.
    """

    of_equations: ClassVar[bool] = False  # is it made from Training.term, without any motion?

    # of polynomials beyond the training range: extrapolated linearly, or evaluated as they are
    extrapolation: Literal["none", "linear"] = field(default="none", kw_only=True)
    # order of dynamics that are fitted again such that they cannot gain energy; 0: none
    dissipative: Whole = field(default=0, kw_only=True)

    def __post_init__(self) -> None:
        kinds = get_type_hints(type(self), include_extras=True)
        for name in (item.name for item in fields(self)):
            value = getattr(self, name)
            try:
                object.__setattr__(self, name, msgspec.convert(value, kinds[name]))
            except msgspec.ValidationError as error:
                raise MethodError(f"{name} is {value!r}: {error}") from error
        self.check()

    def check(self) -> None:  # noqa: B027  nothing, unless overridden
        """Raises a MethodError where settings contradict one another."""

    @abstractmethod
    def fit(self, training: Training) -> Rom:
        """The model that these settings make of the training data."""

    def prepare(self, device: str) -> None:  # noqa: B027  nothing, unless overridden
        """Loads what a fit on this device needs, so that its time is not that of the first fit."""

    def learn(self, training: Training) -> Rom:
        """`fit`, then the guards; the monitor's phase `total` is around both."""
        monitor = training.monitor
        with monitor.phase("total"):
            fitted = self.fit(training)
            with monitor.phase("dynamics"):
                return fitted.guarded(Guards(self.extrapolation, self.dissipative), training)
