"""Optimisers of one vector of weights, whose state is tensors on the vector's device: nothing in a
step waits for the host.

    Adam:  m <- b1 m + (1 - b1) g,    v <- b2 v + (1 - b2) g^2,    w <- w - rate  m / (1 - b1^t)  /
    (sqrt(v / (1 - b2^t)) + eps)
    SOAP:  the same for every matrix W (m, n) of the vector in turned coordinates,  g = Q' G P  and
    back,  with Q and P the eigenvectors of
           L <- s L + (1 - s) G G'    and    R <- s R + (1 - s) G' G

Layers see inputs and errors of very unequal size along different directions; SOAP gives each of
those directions a step of its own, where Adam gives one to each weight. Q and P follow L and R by
one step of orthogonal iteration, Q <- qr(L Q), every few steps; a side of one row or column stays
as it is. Sources: Kingma and Ba, arXiv:1412.6980; Vyas et al., arXiv:2409.11321 (SOAP); Golub and
Van Loan, Matrix Computations, section 8.2.4.
"""

from collections.abc import Sequence

import torch

EPSILON = 1e-8


class Adam:
    """`state` is all that it remembers; `rate` is a tensor without dimensions."""

    every = 0  # steps between two calls of `turn`; 0: never

    def __init__(
        self,
        vector: torch.Tensor,
        shapes: Sequence[torch.Size],
        betas: tuple[float, float] = (0.9, 0.999),
    ):
        self.vector, self.shapes, self.betas = vector, list(shapes), betas
        self._betas = torch.tensor(betas, dtype=torch.float64, device=vector.device)
        self.state = {
            "mean": torch.zeros_like(vector),
            "square": torch.zeros_like(vector),
            "decay": torch.ones_like(self._betas),
        }

    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        self.state["mean"].lerp_(gradient, 1.0 - self.betas[0])
        self.vector.sub_(self._move(gradient, self.state["mean"], rate))

    def _move(self, gradient: torch.Tensor, mean: torch.Tensor, rate: torch.Tensor) -> torch.Tensor:
        square, decay = self.state["square"], self.state["decay"]
        square.mul_(self.betas[1]).addcmul_(gradient, gradient, value=1.0 - self.betas[1])
        first, second = (1.0 - decay.mul_(self._betas)).unbind()
        return (mean * (rate / first)).div_((square / second).sqrt_().add_(EPSILON))

    def turn(self) -> None:
        """What is done every few steps only."""


class Soap(Adam):
    every = 5

    def __init__(
        self,
        vector: torch.Tensor,
        shapes: Sequence[torch.Size],
        betas: tuple[float, float] = (0.9, 0.95),
        memory: float = 0.95,
    ):
        super().__init__(vector, shapes, betas)
        self.memory = memory
        # Sides of one size lie in one tensor, so that one call turns all of them. (part, side) ->
        # its own L or R, and its Q or P.
        sides = [
            (part, side, size)
            for part, shape in enumerate(self.shapes)
            for side, size in enumerate(shape)
            if size > 1
        ]
        self.factors: dict[tuple[int, int], torch.Tensor] = {}
        self.bases: dict[tuple[int, int], torch.Tensor] = {}
        self._sizes = sorted({size for *_, size in sides})
        for size in self._sizes:
            places = [(part, side) for part, side, its in sides if its == size]
            self.state[f"factors {size}"] = vector.new_zeros(len(places), size, size)
            self.state[f"bases {size}"] = torch.eye(
                size, dtype=vector.dtype, device=vector.device
            ).repeat(len(places), 1, 1)
            self.factors |= zip(places, self.state[f"factors {size}"])
            self.bases |= zip(places, self.state[f"bases {size}"])

    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        for size in self._sizes:
            self.state[f"factors {size}"].mul_(self.memory)
        for part, matrix in enumerate(self._matrices(gradient)):
            for side, pair in enumerate(((matrix, matrix.T), (matrix.T, matrix))):
                if (part, side) in self.factors:
                    self.factors[part, side].addmm_(*pair, alpha=1.0 - self.memory)
        mean = self.state["mean"].lerp_(gradient, 1.0 - self.betas[0])
        turned = self._turned(torch.stack([gradient, mean]), back=False)
        self.vector.sub_(self._turned(self._move(turned[0], turned[1], rate), back=True))

    def turn(self) -> None:
        for size in self._sizes:
            basis = self.state[f"bases {size}"]
            basis.copy_(torch.linalg.qr(self.state[f"factors {size}"] @ basis)[0])

    def _matrices(self, rows: torch.Tensor) -> list[torch.Tensor]:
        """The matrices (*rows, m, n) in vectors (*rows, weights)."""
        return [
            part.view(*rows.shape[:-1], *shape)
            for part, shape in zip(
                rows.split([shape.numel() for shape in self.shapes], dim=-1), self.shapes
            )
        ]

    def _turned(self, rows: torch.Tensor, back: bool) -> torch.Tensor:
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


OPTIMISERS = {"adam": Adam, "soap": Soap}
