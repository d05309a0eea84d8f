"""Dissipative fits: least squares for z'' = g(z, z') under the inequalities that keep one
oscillator from gaining energy, inside its data and out.

    g = e + o,  e even and o odd in z':      o z' <= 0   (damping),      z e - z'^2 <= -MARGIN (z^2
    + z'^2)   (turning),    in units of the range

Why this is enough: without o the motion is reversible, z'(t) -> -z'(-t), and by turning its angle
in the phase plane falls for ever, so every orbit crosses the z axis twice and, being its own mirror
image, closes. With o the flow crosses each of these closed orbits inwards, for  z' (e + o) - e z' =
o z' <= 0. So an unforced motion shrinks from any start, and a forced one has no well to leave. The
closed orbits need no formula; with e = a + b z'^2 they are the level sets of the energy  m z'^2/2 +
V,  m = exp(-2 int b),  V' = -m a.

Both conditions are linear in the coefficients. They are imposed on rays of the training ellipse,
at radii up to one and for the slope at one; beyond, with the linear continuation of
`extrapolation`, g along a ray is affine in the radius. Where a finer grid finds them broken, its
points join, until it finds none (an exchange; Hettich and Kortanek, SIAM Review 35 (1993) 380).
Between points h apart a condition rises by O(h^2), so it is imposed with a slack, which doubles
until `dissipative_proof` bounds both conditions over the whole plane: a fit that is not proven to
be damped and to turn is an error.

The least squares problem with them is Lawson and Hanson's LDP (Solving Least Squares Problems,
chapter 23): with A = QR and y = Rx - Q'b, the smallest |y| with G y >= h comes from one
non-negative least squares.
"""

import numpy as np

from vibrom.latent.dissipative_proof import bounds as proven
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.training import MethodError, Unsupported

# The softest restoring force that a fit may choose, as a fraction of the turning at rest, which is
# one in units of the range.
MARGIN = 0.05
RAYS, RADII = 90, 12  # of a half ellipse; what is not mirrored by parity
FINER, ROUNDS = 4, 20  # the grid that is looked at, and how often points of it join
SLACK = 1e-4  # the first one, of z'^2 and of z^2 + z'^2, in units of the range


def fit_dissipative(
    motion: np.ndarray, reach: np.ndarray, scale: np.ndarray, order: int
) -> np.ndarray:
    """R (l,) of  z'' = sum_k R_k (z/s)^i (z'/s')^j  over all monomials 1..order, from z, z' and z''
    (3, m, 1); reach and scale are (2,).
    """
    z, velocity, acceleration = motion
    if z.shape[1] != 1:
        raise Unsupported(
            f"a dissipative fit is for one reduced position, and this model has {z.shape[1]}; "
            "set dissipative: 0, or modes or latent to 1"
        )
    powers, unit = exponents(2, 1, order), reach[1] ** 2 / reach[0]
    library = monomials(np.hstack([z, velocity]) / reach, powers)
    fitted = by_exchange(library, acceleration[:, 0] / unit, powers)
    return unit * fitted * np.prod((scale / reach) ** powers, axis=1)


def by_exchange(library: np.ndarray, target: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """The smallest |library x - target| under the conditions, proven between their points."""
    slack, (rows, bounds) = SLACK, conditions(powers, RAYS, RADII)
    finer, limits = conditions(powers, FINER * RAYS, FINER * RADII)
    for _ in range(ROUNDS):
        found = constrained_least_squares(library, target, rows, bounds - slack)
        broken = finer @ found > limits - 0.5 * slack
        if broken.any():
            rows = np.concatenate([rows, finer[broken]])
            bounds = np.concatenate([bounds, limits[broken]])
        elif max(proven(found, powers)) < 0.0:
            return found
        else:
            slack *= 2.0
    raise MethodError("the dissipative fit does not settle; choose another order for dissipative")


def conditions(powers: np.ndarray, rays: int, radii: int) -> tuple[np.ndarray, np.ndarray]:
    """(rows, bounds): rows R <= bounds holds where the model is damped and turns, in units of the
    range and of z'^2 or z^2 + z'^2.
    """
    angle = (np.arange(rays) + 0.5) * np.pi / rays
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ray = np.concatenate([ray, -ray])
    degree, odd = powers.sum(axis=1), powers[:, 1] % 2 == 1
    edge = monomials(ray, powers)
    # divided by the radius, so that small ones count
    inside = [edge * radius**degree / radius for radius in np.arange(1, radii + 1) / radii]
    values = np.concatenate([*inside, edge * degree])
    z, velocity = (np.tile(part, radii + 1)[:, None] for part in ray.T)
    damping = np.where(odd, values, 0.0) / velocity  # o z' over z'^2: small z' count too
    turning = np.where(odd, 0.0, values) * z
    return np.concatenate([damping, turning]), np.concatenate(
        [np.zeros(len(damping)), velocity[:, 0] ** 2 - MARGIN]
    )


def constrained_least_squares(
    matrix: np.ndarray, target: np.ndarray, rows: np.ndarray, bounds: np.ndarray
) -> np.ndarray:
    """The x with the smallest |matrix x - target| among those with  rows x <= bounds."""
    from scipy.optimize import nnls  # slow to import, and most jobs fit nothing

    free = least_squares(matrix, target[:, None])[0]
    if np.all(rows @ free <= bounds):
        return free
    size = np.linalg.norm(matrix, axis=0)
    q, r = np.linalg.qr(matrix / size)
    inverse = np.linalg.inv(r)
    image = q.T @ target
    g = -(rows / size) @ inverse
    h = -bounds - g @ image
    length = np.linalg.norm(np.column_stack([g, h]), axis=1)
    length[length == 0.0] = 1.0
    g, h = g / length[:, None], h / length
    goal = np.append(np.zeros(g.shape[1]), 1.0)
    weights, rest = nnls(np.vstack([g.T, h]), goal, maxiter=50 * len(g))
    residual = np.vstack([g.T, h]) @ weights - goal
    if rest < 1e-9:
        raise MethodError("no dissipative dynamics of this order exist; raise dissipative")
    y = -residual[:-1] / residual[-1]
    return (inverse @ (y + image)) / size
