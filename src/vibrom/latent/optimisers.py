"""Optimisers of one vector of weights, whose state is tensors on the vector's device: nothing in a
step waits for the host.

    Adam:  m <- b1 m + (1 - b1) g,    v <- b2 v + (1 - b2) g^2,
           w <- w - rate  m / (1 - b1^t)  /  (sqrt(v / (1 - b2^t)) + eps)
    SOAP:  the same for every matrix W (m, n) of the vector in rotated coordinates,  g = Q' G P  and
           back,  with Q and P the eigenvectors of
           L <- s L + (1 - s) G G'    and    R <- s R + (1 - s) G' G

Layers see inputs and errors of very unequal size along different directions; SOAP gives each of
those directions a step of its own, where Adam gives one to each weight. Q and P follow L and R by
one step of orthogonal iteration every few steps,

    Q <- qr((L + delta (tr L / k) 1) Q),  the diagonal of its triangle positive,

where L is (k, k); a side of one row or column stays as it is. L is the sum of few products G G' and
has a null space, which `qr(L Q)` fills with rounding: directions whose gradient is rounding too, so
that the step along them, a gradient over its own size, is noise of full size. The shift keeps
directions that L does not tell apart as they were. Sources: Kingma and Ba, arXiv:1412.6980; Vyas et
al., arXiv:2409.11321 (SOAP); Golub and Van Loan, Matrix Computations, section 8.2.4.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from vibrom.latent.backend import torch

EPSILON = 1e-8  # eps


class Optimiser(ABC):
    """Moves `vector`, which holds matrices of these shapes one after the other."""

    every = 0  # steps between two calls of `turn`; 0: never

    def __init__(
        self, vector: torch.Tensor, shapes: Sequence[torch.Size], betas: tuple[float, float]
    ):
        self.vector, self.shapes, self.betas = vector, list(shapes), betas
        self._betas = torch.tensor(betas, dtype=torch.float64, device=vector.device)
        # All that an optimiser remembers.
        self.state: dict[str, torch.Tensor] = {
            "mean": torch.zeros_like(vector),  # m
            "square": torch.zeros_like(vector),  # v
            "decay": torch.ones_like(self._betas),  # b1^t, b2^t
        }

    @abstractmethod
    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        """One step; `rate` is a tensor without dimensions."""

    def turn(self) -> None:  # noqa: B027  nothing, unless overridden
        """What is done every few steps only."""

    def _averaged(self, gradient: torch.Tensor) -> torch.Tensor:
        """The m that follows."""
        return self.state["mean"].lerp_(gradient, 1.0 - self.betas[0])

    def _move(self, gradient: torch.Tensor, mean: torch.Tensor, rate: torch.Tensor) -> torch.Tensor:
        """What is subtracted, in the coordinates of `gradient` and `mean`."""
        square, decay = self.state["square"], self.state["decay"]
        square.mul_(self.betas[1]).addcmul_(gradient, gradient, value=1.0 - self.betas[1])
        first, second = (1.0 - decay.mul_(self._betas)).unbind()
        return (mean * (rate / first)).div_((square / second).sqrt_().add_(EPSILON))


class Adam(Optimiser):
    """The rule above."""

    def __init__(
        self,
        vector: torch.Tensor,
        shapes: Sequence[torch.Size],
        betas: tuple[float, float] = (0.9, 0.999),
    ):
        super().__init__(vector, shapes, betas)

    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        """See Optimiser."""
        self.vector.sub_(self._move(gradient, self._averaged(gradient), rate))


class Soap(Optimiser):
    """Adam's rule for each matrix in the eigenvectors of its averaged squares."""

    every = 5

    def __init__(
        self,
        vector: torch.Tensor,
        shapes: Sequence[torch.Size],
        betas: tuple[float, float] = (0.9, 0.95),
        memory: float = 0.95,  # s
        shift: float = 1.0,  # delta
    ):
        super().__init__(vector, shapes, betas)
        self.memory, self.shift = memory, shift
        sides = [
            (part, side, size)
            for part, shape in enumerate(self.shapes)
            for side, size in enumerate(shape)
            if size > 1
        ]
        # Sides of one size lie in one tensor, so that one call turns all of them.
        self.factors: dict[tuple[int, int], torch.Tensor] = {}  # (part, side) -> its L or R
        self.bases: dict[tuple[int, int], torch.Tensor] = {}  # (part, side) -> its Q or P
        self._sizes = sorted({size for *_, size in sides})
        for size in self._sizes:
            places = [(part, side) for part, side, its in sides if its == size]
            one = torch.eye(size, dtype=vector.dtype, device=vector.device)
            self.state[f"factors {size}"] = vector.new_zeros(len(places), size, size)
            self.state[f"bases {size}"] = one.repeat(len(places), 1, 1)
            self.factors |= zip(places, self.state[f"factors {size}"])
            self.bases |= zip(places, self.state[f"bases {size}"])

    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        """See Optimiser."""
        for size in self._sizes:
            self.state[f"factors {size}"].mul_(self.memory)
        for part, matrix in enumerate(self._matrices(gradient)):
            for side, pair in enumerate(((matrix, matrix.T), (matrix.T, matrix))):
                if (part, side) in self.factors:
                    self.factors[part, side].addmm_(*pair, alpha=1.0 - self.memory)
        both = self._rotated(torch.stack([gradient, self._averaged(gradient)]), back=False)
        self.vector.sub_(self._rotated(self._move(both[0], both[1], rate), back=True))

    def turn(self) -> None:
        """See Optimiser."""
        for size in self._sizes:
            factors, basis = self.state[f"factors {size}"], self.state[f"bases {size}"]
            shift = self.shift * factors.diagonal(dim1=-2, dim2=-1).mean(dim=-1)[:, None, None]
            q, r = torch.linalg.qr(torch.baddbmm(shift * basis, factors, basis))
            negative = r.diagonal(dim1=-2, dim2=-1) < 0.0
            basis.copy_(torch.where(negative[:, None, :], -q, q))

    def _matrices(self, rows: torch.Tensor) -> list[torch.Tensor]:
        """The matrices (*rows, m, n) in vectors (*rows, weights)."""
        parts = rows.split([shape.numel() for shape in self.shapes], dim=-1)
        return [part.view(*rows.shape[:-1], *shape) for part, shape in zip(parts, self.shapes)]

    def _rotated(self, rows: torch.Tensor, back: bool) -> torch.Tensor:
        """Q' G P of every matrix G, or Q G P' (`back`)."""
        found = []
        for part, matrix in enumerate(self._matrices(rows)):
            left, right = self.bases.get((part, 0)), self.bases.get((part, 1))
            if left is not None:
                matrix = (left if back else left.T) @ matrix
            if right is not None:
                matrix = matrix @ (right.T if back else right)
            found.append(matrix.flatten(-2))
        return torch.cat(found, dim=-1)


OPTIMISERS: dict[str, type[Optimiser]] = {"adam": Adam, "soap": Soap}
