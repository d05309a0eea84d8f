"""SINDy on modal coordinates by pysindy, as an outside method: xarray in, xarray out, nothing of
vibrom imported.

    z = phi' M q,  y = (z, z') / s,  dy/dtau = Xi Theta(y),  tau = omega_1 t,    q = phi z

Theta holds the monomials of degree 1 to `degree`, Xi comes by sequentially thresholded least
squares (coefficients below `threshold` are dropped), and s is the largest |z|, |z'| of the training
data, which makes all of it of order one. Where operators are not known, phi is the first direction
of the recorded motion.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import pysindy
import xarray as xr
from scipy.sparse import csr_matrix


class NoModel(Exception):
    """An outcome of the workflow's, and the reason."""


def modal(structure, modes):
    """Phi (d, n), phi' M (d, n) and the frequencies (d,) [rad/s]; M = 1 where it is not known."""
    phi = structure["mode_shape"].values[:modes]
    if "mass_value" not in structure:
        return phi, phi, structure["frequency"].values[:modes]
    entries = (
        structure["mass_value"].values,
        (structure["mass_row"].values, structure["mass_column"].values),
    )
    mass = csr_matrix(entries, shape=(phi.shape[1], phi.shape[1]))
    return phi, (mass @ phi.T).T, structure["frequency"].values[:modes]


def fit(structure, train, *, modes, degree, threshold):
    """The arrays of the model, and the seconds that mapping and dynamics took."""
    started = time.perf_counter()
    phi, encoder, frequency = modal(structure, modes)
    z = np.hstack([train["displacement"].values @ encoder.T, train["velocity"].values @ encoder.T])
    rate = np.hstack([z[:, modes:], train["acceleration"].values @ encoder.T])
    scale = np.abs(z).max(axis=0)
    decoder = np.kron(np.eye(2), phi.T) * scale
    mapped = time.perf_counter()
    library = pysindy.PolynomialLibrary(degree=degree, include_bias=False)
    terms = np.asarray(library.fit_transform(z / scale))
    rank = np.linalg.matrix_rank(terms / np.linalg.norm(terms, axis=0))
    samples, count = terms.shape
    if rank < count:
        raise NoModel(
            "underdetermined",
            f"of {count} coefficients the {samples} samples determine {rank}; lower degree, or "
            "give data that differ more from one another",
        )
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=threshold, alpha=0.0), feature_library=library
    )
    model.fit(z / scale, t=train["time"].values * frequency[0], x_dot=rate / (scale * frequency[0]))
    if not model.coefficients().any(axis=1).all():
        raise NoModel(
            "no_terms",
            f"threshold = {threshold:g} removes every term of the rate of a coordinate; lower it",
        )
    arrays = {
        "reach": (
            ("coordinate",),
            scale,
            "largest absolute reduced coordinate in the training data, in its own unit",
            "1",
        ),
        "encoder": (
            ("mode", "dof"),
            encoder,
            "projection of displacement and of velocity",
            "kg^(1/2)",
        ),
        "scale": (
            ("coordinate",),
            scale,
            "scale of the reduced coordinates in the monomials, in their own units",
            "1",
        ),
        "decoder": (
            ("state", "decoder_term"),
            decoder,
            "coefficients of the decoder, in the unit of the state",
            "1",
        ),
        "decoder_powers": (
            ("decoder_term", "coordinate"),
            np.eye(2 * modes, dtype=int),
            "exponents of the decoder's monomials",
            "1",
        ),
        "dynamics": (
            ("coordinate", "dynamics_term"),
            model.coefficients() * scale[:, None] * frequency[0],
            "coefficients of the dynamics, in the unit of the rate",
            "1",
        ),
        "dynamics_powers": (
            ("dynamics_term", "coordinate"),
            np.asarray(library.powers_, int),
            "exponents of the dynamics' monomials",
            "1",
        ),
        "force": (("mode", "dof"), phi, "projection of the load", "kg^(-1/2)"),
    }
    return arrays, mapped - started, time.perf_counter() - mapped


def dataset(arrays, **attributes):
    variables = {
        name: xr.Variable(dims, values, {"long_name": words, "units": units})
        for name, (dims, values, words, units) in arrays.items()
    }
    return xr.Dataset(variables).assign_attrs(Conventions="CF-1.11", **attributes)


def save(data, path):
    """All of the file or nothing."""
    partial = Path(path).with_suffix(".partial")
    try:
        data.to_netcdf(
            partial,
            engine="netcdf4",
            encoding={
                name: {"_FillValue": None}
                for name in data.variables
                if data[name].dtype.kind in "iu"
            },
        )
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def read(path, kind, scene):
    """The artefact of this kind and scene; a torn or foreign file is one line."""
    try:
        data = xr.load_dataset(path)
    except (OSError, ValueError) as error:
        complain(
            f"{path}: not a readable netCDF file ({str(error).splitlines()[0]}); delete it and "
            "run again"
        )
    if data.attrs.get("kind") != kind:
        complain(
            f"{path}: kind is {data.attrs.get('kind')!r}, but {kind!r} is needed here; give a "
            "file made by the matching rule"
        )
    if data.attrs["scene"] != scene:
        complain(
            f"{path}: scene is {data.attrs['scene']!r}, but {scene!r} belongs here; delete it and "
            "run again"
        )
    return data


def complain(line):
    for stream in (sys.__stderr__, sys.stderr):
        print(f"vibrom: {line}", file=stream)
    sys.exit(1)


def main(job):
    sys.stderr = open(job.log[0], "w", encoding="utf-8")  # noqa: SIM115  until the process ends
    settings, scene = dict(job.params.settings), job.params.scene_name
    structure = read(job.input.structure, "structure", scene)
    train = read(job.input.train, "trajectory", scene)
    asked = {key: value for key, value in job.params.items() if key != "provenance"}
    made_from = {"structure": structure.attrs["content"], "train": train.attrs["content"]}
    outcome, reason, own = "ok", "", {"rom": job.params.rom_class}
    began = time.perf_counter()
    try:
        arrays, mapping, dynamics = fit(structure, train, **settings)
    except NoModel as without:
        outcome, reason = without.args
        arrays, mapping, dynamics, own = {}, time.perf_counter() - began, 0.0, {}
    arrays |= {
        "outcome": ((), outcome, "how the fit ended", "1"),
        "data_seconds": ((), float(train["seconds"]), "wall time of the training data", "s"),
        "mapping_seconds": ((), mapping, "wall time of obtaining the mapping", "s"),
        "dynamics_seconds": ((), dynamics, "wall time of obtaining the dynamics", "s"),
    }
    shared = {
        "scene": scene,
        "method": "pysindy_modal",
        "seed": -1,
        "reason": reason,
        "settings": json.dumps(settings, sort_keys=True),
        "asked": json.dumps(asked, sort_keys=True),
        "made_from": json.dumps(made_from, sort_keys=True),
        **job.params.provenance,
    }
    title = f"pysindy_modal in scene {scene}"
    rom = dataset(arrays, kind="rom", title=f"vibrom rom: {title}", **own, **shared)
    save(rom, job.output.rom)
    # Nothing is trained epoch by epoch: the loss history is empty.
    losses = {
        name: (("epoch",), np.zeros(0), words, "1")
        for name, words in (("epoch", "epoch"), ("train_total", "training loss"))
    }
    save(
        dataset(losses, kind="losses", title=f"vibrom losses: {title}", **shared).set_coords(
            "epoch"
        ),
        job.output.losses,
    )


if __name__ == "__main__":
    main(snakemake)  # noqa: F821  put there by Snakemake
