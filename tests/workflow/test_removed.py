"""What an overlay removes, another may remove again, or give again."""

import pytest
from reading import complaint, load, overlay, shown


@pytest.mark.parametrize(
    "first, second, means",
    [
        ("studies: {cost: null}", "studies: {cost: null}", ["studies: {cost: null}"]),
        ("studies: {cost: null}", "studies: {cost: {reduced: null}}", ["studies: {cost: null}"]),
        ("studies: null", "studies: {cost: {reduced: {split: null}}}", ["studies: null"]),
        (
            "studies: {robustness: {guards: null}}",
            "studies: {robustness: {guards: {none: null, mine: {}}}}",
            [
                "studies: {robustness: {guards: null}}",
                "studies: {robustness: {guards: {mine: {}}}}",
            ],
        ),
        (
            "scene_settings: {all: {effects: {modal_load: null}}}",
            "scene_settings: {all: &gone {effects: {modal_load: null}}, small: *gone}",
            ["scene_settings: {all: {effects: {modal_load: null}}}"],
        ),
        (
            "scene_settings: {folding: {experiments: {sweeps: null}}}",
            "scene_settings: {folding: {experiments: {sweeps: {forcing: null}}}}",
            ["scene_settings: {folding: {experiments: {sweeps: null}}}"],
        ),
        (
            "method_settings: {ssmlearn_11: {order_decoder: null}}",
            "method_settings: {ssmlearn_11: {order_decoder: null}}",
            ["method_settings: {ssmlearn_11: {order_decoder: null}}"],
        ),
    ],
)
def test_removing_twice_is_removing_once(project, first, second, means):
    """The whole, a part of it, or on the way to giving it again; in two files."""

    def shown_with(texts):
        paths = [project / f"{place}.yaml" for place in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text)
        return shown(load(project, *paths))

    assert shown_with([first, second]) == shown_with(means) != shown_with([])


def test_what_was_never_there_is_not_removed(project, tmp_path):
    """Neither beside what was removed, nor below it."""
    gone = project / "gone.yaml"
    gone.write_text("studies: {cost: null, trust: null}")
    for name in ("costs", "cost: {reducde", "trust: {amplitudes: {a"):
        text = f"studies: {{{name}: null{'}' * name.count('{')}}}"
        assert "is empty; give a value" in complaint(project, gone, overlay(tmp_path, text))
