"""Some rounds of faults: the same command ends well afterwards, with the same scores.

`python tests/workflow/faults.py 100` is the whole of it.
"""

from faults import rounds

SHORT = ["kill -9", "damaged", "swapped", "no records"]


def test_after_a_fault_the_same_command_ends_with_the_same_scores(tmp_path):
    seen = rounds(len(SHORT), tmp_path / "run", SHORT, "scores")
    assert {fault for fault, _ in seen} == set(SHORT) and sum(seen.values()) == len(SHORT)
