"""Some rounds of faults: the same command ends well afterwards, with the same scores.

`python tests/workflow/faults.py 100` is the whole of it.
"""

from faults import Run, rounds

SHORT = ["kill -9", "damaged", "swapped, no records"]
SMALLEST = "methods: [ssmlearn, modal_projection]\nexperiments: [decay]\n"


def test_after_a_fault_the_same_command_ends_with_the_same_scores(tmp_path):
    overlay = tmp_path / "smallest.yaml"
    overlay.write_text(SMALLEST)
    seen = rounds(len(SHORT), Run(tmp_path / "run", ["scores"], [str(overlay)]), SHORT)
    assert {fault for fault, _ in seen} == set(SHORT) and sum(seen.values()) == len(SHORT)
