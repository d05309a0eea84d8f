"""The moving beam of the page shows the motions that were computed."""

import base64

import numpy as np

from vibrom.models.rom import rom_from_dataset
from vibrom.report import motion
from vibrom.report.drawing import body
from vibrom.report.scores import Scores


def test_the_moving_beam_is_the_full_order_and_the_model(real):
    scored = Scores.of(real)
    made = motion.of_scene(real, scored, "small")
    truth, structure = (real.find("small", "full_order", name) for name in ("test", "structure"))
    shapes = np.frombuffer(base64.b64decode(made["shapes"]), "<f4").reshape(made["rank"], -1)
    nodes = np.concatenate(body.outline(structure))
    stride = motion.frame_stride(truth["time"].values, float(truth["period"]))
    for model in made["models"]:
        frames = np.frombuffer(base64.b64decode(model["motion"]), "<i2").reshape(-1, made["rank"])
        if model["method"] == "full_order":
            free = truth["displacement"].values[::stride]
        else:
            method = model["method"]
            seed = scored.median_seed("small", method, real.seeds("small", method))
            fit, decay = (real.find("small", method, name, seed) for name in ("rom", "decay"))
            free = rom_from_dataset(fit).displacement(decay["reduced"].values[::stride])
        wanted = [body.displacement(structure, one)[nodes].ravel() for one in free]
        # Shapes that are left out, then half a step of each coefficient.
        off = np.abs(frames @ shapes - wanted[: len(frames)]).max()
        assert len(frames) > 10 and off < 1.1 * motion.CLOSE * body.longest_side(structure)
