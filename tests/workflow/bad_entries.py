"""Wrong entries of the configuration: file, key, wrong value, and what the line must say (key, value, cure)."""

SCENE, METHOD, CONFIG = "config/scenes/folding.yaml", "config/methods/split.yaml", "config/config.yaml"

BAD = {
    "unknown effect": (
        SCENE,
        "effects.gravitty",
        {"g": 9.81},
        ["effects.gravitty", "9.81", "is no effect", "choose from"],
    ),
    "misspelt effect": (SCENE, "effects.inertial", {"density": 1.0}, ["effects.inertial", "did you mean 'inertia'?"]),
    "unknown scene": (CONFIG, "scenes", ["foldin"], ["scenes[0]", "'foldin'", "did you mean 'folding'?"]),
    "unknown method": (CONFIG, "methods", ["splitt"], ["methods[0]", "'splitt'", "did you mean 'split'?"]),
    "unknown experiment": (
        CONFIG,
        "experiments",
        ["decay", "decai"],
        ["experiments[1]", "'decai'", "did you mean 'decay'?"],
    ),
    "unknown key": (CONFIG, "seed", [0], ["seed = [0]", "unknown key", "did you mean 'seeds'?"]),
    "unknown scene key": (SCENE, "body.lenght", 1.0, ["body.lenght = 1.0", "did you mean 'length'?"]),
    "missing scene key": (SCENE, "body.width", ..., ["body.width", "is missing"]),
    "unknown element": (
        SCENE,
        "body.element",
        "triangle",
        ["body.element", "'triangle'", "choose from bilinear, quadratic"],
    ),
    "negative stiffness": (
        SCENE,
        "effects.elasticity.young_modulus",
        -1.0,
        ["effects.elasticity.young_modulus = -1.0", "greater than 0"],
    ),
    "unknown setting of an effect": (
        SCENE,
        "effects.elasticity.young_modul",
        1.0,
        ["effects.elasticity.young_modul", "did you mean 'young_modulus'?"],
    ),
    "missing setting of an effect": (
        SCENE,
        "effects.inertia.density",
        ...,
        ["effects.inertia.density", "is missing", "add it"],
    ),
    "unknown edge": (SCENE, "body.clamped", ["lef"], ["body.clamped[0] = 'lef'", "did you mean 'left'?"]),
    "train is test": (
        SCENE,
        "releases.test",
        {"forcing": 3000.0, "step": 13376},
        ["releases.test", "13376", "give another"],
    ),
    "zero time step": (SCENE, "time.steps_per_period", 0, ["time.steps_per_period = 0", "at least 20"]),
    "every does not divide": (SCENE, "time.every", 7, ["time.every = 7", "choose a divisor"]),
    "repeated seeds": (CONFIG, "seeds", [0, 1, 1], ["seeds = [0, 1, 1]", "repeats 1", "give each once"]),
    "negative seed": (CONFIG, "seeds", [-1], ["seeds[0] = -1", "at least 0"]),
    "text for a number": (SCENE, "body.length", "long", ["body.length = 'long'", "a number"]),
    "probe between nodes": (
        SCENE,
        "body.probes.probe.at",
        [0.53, 0.0],
        ["body.probes.probe.at", "the nearest one is [0.525, 0.0]"],
    ),
    "clamped probe": (SCENE, "body.probes.tip.at", [0.0, 0.0], ["body.probes.tip.at", "clamped left edge"]),
    "sweep backwards": (SCENE, "frc.from", 1.3, ["frc.from = 1.3", "frc.to = 1.2", "swap"]),
    "unknown setting of a method": (METHOD, "settings.epoch", 3, ["settings.epoch = 3", "did you mean 'epochs'?"]),
    "type of a setting": (METHOD, "settings.epochs", "many", ["settings.epochs = 'many'", "type int"]),
    "start outside the run": (CONFIG, "methods", ["split_plus"], ["starts_from = 'split'", "add it to methods"]),
    "overlay of an unknown method": (
        CONFIG,
        "method_settings",
        {"splt": {}},
        ["method_settings", "'splt'", "did you mean 'split'?"],
    ),
    "unknown key in an overlay": (
        CONFIG,
        "scene_settings",
        {"all": {"tim": {}}},
        ["scene_settings.all.tim", "did you mean 'time'?"],
    ),
    "wrong value in an overlay": (
        CONFIG,
        "scene_settings",
        {"folding": {"time": {"alpha": 2}}},
        ["scene_settings.folding.time.alpha = 2", "at most 1"],
    ),
}
