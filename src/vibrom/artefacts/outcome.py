"""How a run, a fit or a question ended: a word that artefacts keep, and what the word means."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from enum import Enum, StrEnum


class Severity(Enum):
    """What an ending asks of a reader."""

    FINE = 0  # ended as asked
    NOTE = 1  # there is an answer, with a caveat
    FAILURE = 2  # the model or the solver gave up
    ABSENT = 3  # nothing was asked, for a reason that is no failure


class Outcome(StrEnum):
    """An ending. As text it is its word, so that it is stored in arrays and tables as it is."""

    has_value: bool  # are there numbers to compare?
    severity: Severity
    sentence: str  # what a person reads

    def __new__(
        cls,
        word: str,
        has_value: bool = False,
        severity: Severity = Severity.FAILURE,
        sentence: str = "",
    ) -> Outcome:
        """A member whose value is its word; the defaults are for type checkers, which see this in
        `Outcome(word)`.
        """
        member = str.__new__(cls, word)
        member._value_ = word
        member.has_value, member.severity, member.sentence = has_value, severity, sentence
        return member

    OK = "ok", True, Severity.FINE, "ended as asked"
    LEFT_RANGE = "left_range", True, Severity.NOTE, "left its training range"
    NOT_STEADY = "not_steady", True, Severity.NOTE, "still changed when the run ended"
    UNBALANCED = "unbalanced", True, Severity.NOTE, "its energy, work and losses do not add up"
    STATIC = "static", True, Severity.NOTE, "at rest: no mass is left that could move"
    UNFORCED = "unforced", True, Severity.NOTE, "no load is left"
    NO_MODES = "no_modes", True, Severity.NOTE, "no stiffness is left, so that it has no modes"
    UNFINISHED = "unfinished", True, Severity.NOTE, "the points ran out before the branch ended"
    LOST = "lost", True, Severity.FAILURE, "the branch could not be followed further"
    DIVERGED = "diverged", False, Severity.FAILURE, "diverged"
    STEP_UNDERFLOW = "step_underflow", False, Severity.FAILURE, "the time step became too small"
    NO_CONVERGENCE = "no_convergence", False, Severity.FAILURE, "an implicit step did not converge"
    NO_EQUILIBRIUM = "no_equilibrium", False, Severity.FAILURE, "no static equilibrium was found"
    UNDERDETERMINED = (
        "underdetermined",
        False,
        Severity.FAILURE,
        "its data do not determine its coefficients",
    )
    NO_TERMS = "no_terms", False, Severity.FAILURE, "no term of its dynamics is left"
    TRAINING_DIVERGED = "training_diverged", False, Severity.FAILURE, "the training diverged"
    REFERENCE_FAILED = (
        "reference_failed",
        False,
        Severity.FAILURE,
        "the full-order run to compare with stopped early",
    )
    SKIPPED = "skipped", False, Severity.ABSENT, "the method does not go with the scene"
    UNSUPPORTED = "unsupported", False, Severity.ABSENT, "the model has no such guard or integrator"
    NEEDED = "needed", False, Severity.ABSENT, "another effect cannot do without it"
    NOT_RUN = "not_run", False, Severity.ABSENT, "not part of this run"


def worst(outcomes: Iterable[str]) -> Outcome:
    """The gravest of some endings, the first one among equals; OK of none."""
    return max(
        map(Outcome, outcomes), key=lambda outcome: outcome.severity.value, default=Outcome.OK
    )


class Tally(Counter):
    """How often each ending occurred; as text `ok` where all agree, else `ok 2, diverged 1`."""

    def __init__(self, outcomes: Iterable[str] = ()):
        super().__init__(map(Outcome, outcomes))

    def __str__(self) -> str:
        if len(self) < 2:
            return next(iter(self), Outcome.NOT_RUN).value
        ranked = sorted(self, key=lambda outcome: (-self[outcome], outcome is not Outcome.OK))
        return ", ".join(f"{outcome} {self[outcome]}" for outcome in ranked)

    @classmethod
    def read(cls, text: str, total: int) -> Tally:
        """The tally of so many endings whose text this is."""
        endings = [ending.partition(" ") for ending in text.split(", ")] if total else []
        return cls(word for word, _, count in endings for _ in range(int(count or total)))
