"""The size of a body as its settings tell it, against the body; what jobs took is compared by
tests/workflow/test_small_dag.py and benchmarks/memory.py.
"""

from pathlib import Path

import numpy as np
import pytest

from vibrom.bodies import space
from vibrom.config import settings
from vibrom.config.memory import HELD, mem_mb, size

CONFIG = Path(__file__).parents[1] / "config"
SCENES = ["folding", "shaker", "perforated_beam", "solid_cantilever"]


def scene(name, **body):
    made = settings.load(CONFIG, [], {"scenes": [name]}).scenes[name].to_builtins()
    return made | {"body": made["body"] | body}


@pytest.mark.parametrize("name", SCENES)
def test_the_size_of_a_body_is_known_before_it_is_built(name):
    """Clamped displacements and, of `serendipity` and mesh files, some more are in the bound."""
    made = scene(name)
    built = space.build(made["body"])
    displacements, across = size(made["body"])
    assert built.size <= displacements <= 2.5 * built.size
    dofs = built.element_dofs
    lowest = np.where(dofs < 0, built.size, dofs).min(axis=1)
    # An element reaches from one line to the next, or to the one after it.
    assert (dofs.max(axis=1) - lowest).max() <= 2 * (across + 9)


def test_memory_grows_with_the_body_where_it_is_held_and_with_samples_where_these_are():
    small, large = scene("folding"), scene("folding", cells=[1000, 30])
    ratio = size(large["body"])[0] / size(small["body"])[0]
    more = {kind: mem_mb(large, kind) - mem_mb(small, kind) for kind in HELD}
    assert 0 < more["fit"] < more["full_order"] < more["equations"]
    # Which took 1.2 GB (benchmarks/memory.py).
    assert (
        1240 < mem_mb(scene("folding", cells=[500, 15], element="quadratic"), "full_order") < 2000
    )
    # 12 arrays of 6001 samples: 0.58 MB a displacement.
    held = 12 * 8e-6 * 6001 * size(small["body"])[0]
    assert more["whole"] == pytest.approx(held * (ratio - 1.0), abs=1.0)
    longer = small | {"record": small["record"] | {"periods": 60}}
    for kind in ("full_order", "fit", "answer", "full_order_answer", "study_scene", "study_models"):
        assert mem_mb(longer, kind) == mem_mb(small, kind)
    assert mem_mb(longer, "whole") - mem_mb(small, "whole") == pytest.approx(held, abs=1.0)


def test_the_factor_of_a_wide_body_has_its_place():
    """A banded factor has a number for every displacement and every place of half the band, which
    is a layer of nodes, a row and a node wide where elements are trilinear.
    """
    cells = np.array([40, 30, 30])
    nodes = cells + 1
    half = 3 * (nodes[1] * nodes[2] + nodes[2] + 1)
    factor = 8e-6 * 3 * nodes.prod() * half
    made = scene("solid_cantilever", cells=cells.tolist(), element="trilinear")
    asked = mem_mb(made, "full_order")
    assert factor < asked < 4 * factor
