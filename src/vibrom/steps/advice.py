"""The study of ablation -> a line a scene on the terminal: which effects it needs."""

from vibrom.report import sentences
from vibrom.report.collection import Collection


def run(*, artefacts: list[str], shown: list[str]) -> None:
    """`shown` are the tables and figures of the study, which are there by then."""
    for words in sentences.advised(Collection.at(artefacts)):
        print(words)
