"""Checkpoints of a fit: kept, and left aside where they are torn."""

import numpy as np

from vibrom.steps.fit import FileMonitor


def test_a_torn_checkpoint_is_none(tmp_path):
    path, weights = tmp_path / "state.npz", np.arange(500.0)
    FileMonitor(str(path), "fit").checkpoint({"weights": weights})
    assert np.array_equal(FileMonitor(str(path), "fit").restore()["weights"], weights)
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 255
    for torn in (
        whole[:0],
        whole[:2],
        whole[:100],
        whole[: len(whole) // 2],
        whole[:-3],
        bytes(flipped),
    ):
        path.write_bytes(torn)
        monitor = FileMonitor(str(path), "fit")
        assert monitor.restore() is None and monitor.spent("total") == 0.0
