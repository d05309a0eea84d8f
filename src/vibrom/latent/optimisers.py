"""Optimisers of one vector of weights, whose state is tensors on the vector's device: nothing in a step waits for the host.

    Adam:  m <- b1 m + (1 - b1) g,    v <- b2 v + (1 - b2) g^2,    w <- w - rate  m / (1 - b1^t)  /  (sqrt(v / (1 - b2^t)) + eps)
    SOAP:  the same for every matrix W (m, n) of the vector in turned coordinates,  g = Q' G P  and back,  with Q and P the eigenvectors of
           L <- s L + (1 - s) G G'    and    R <- s R + (1 - s) G' G

Layers see inputs and errors of very unequal size along different directions; SOAP gives each of those directions a step of its own, where Adam gives one
to each weight. Q and P follow L and R by one step of orthogonal iteration, Q <- qr(L Q), every few steps; a side of one row or column stays as it is.
Sources: Kingma and Ba, arXiv:1412.6980; Vyas et al., arXiv:2409.11321 (SOAP); Golub and Van Loan, Matrix Computations, section 8.2.4.
"""

from collections.abc import Sequence

import torch

EPSILON = 1e-8


class Adam:
    """`state` is all that it remembers; `rate` is a tensor without dimensions."""

    every = 0  # steps between two calls of `turn`; 0: never

    def __init__(self, vector: torch.Tensor, shapes: Sequence[torch.Size], betas: tuple[float, float] = (0.9, 0.999)):
        self.vector, self.shapes, self.betas = vector, list(shapes), betas
        self._betas = torch.tensor(betas, dtype=torch.float64, device=vector.device)
        self.state = {"mean": torch.zeros_like(vector), "square": torch.zeros_like(vector), "decay": torch.ones_like(self._betas)}

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

    def __init__(self, vector: torch.Tensor, shapes: Sequence[torch.Size], betas: tuple[float, float] = (0.9, 0.95), memory: float = 0.95):
        super().__init__(vector, shapes, betas)
        self.memory = memory
        # Sides of one size stand side by side, so that one call turns all of them: (part, side) -> their place there.
        self._places: dict[tuple[int, int], tuple[str, int]] = {}
        counts: dict[int, int] = {}
        for part, shape in enumerate(self.shapes):
            for side, size in enumerate(shape):
                if size > 1:
                    self._places[part, side] = (f"{size}", counts.get(size, 0))
                    counts[size] = counts.get(size, 0) + 1
        for size, count in counts.items():
            self.state[f"factor {size}"] = vector.new_zeros(count, size, size)
            self.state[f"basis {size}"] = torch.eye(size, dtype=vector.dtype, device=vector.device).repeat(count, 1, 1)

    def step(self, gradient: torch.Tensor, rate: torch.Tensor) -> None:
        mean = self.state["mean"].lerp_(gradient, 1.0 - self.betas[0])
        for part, matrix in enumerate(self._matrices(gradient)):
            for side, pair in enumerate(((matrix, matrix.T), (matrix.T, matrix))):
                if (part, side) in self._places:
                    self._at("factor", part, side).mul_(self.memory).addmm_(*pair, alpha=1.0 - self.memory)
        turned = self._turned(torch.stack([gradient, mean]), back=False)
        self.vector.sub_(self._turned(self._move(turned[0], turned[1], rate)[None], back=True)[0])

    def turn(self) -> None:
        for name, factor in self.state.items():
            kind, _, size = name.partition(" ")
            if kind == "factor":
                basis = self.state[f"basis {size}"]
                basis.copy_(torch.linalg.qr(factor @ basis)[0])

    def _matrices(self, rows: torch.Tensor) -> list[torch.Tensor]:
        """The matrices (*rows, m, n) in vectors (*rows, weights)."""
        return [part.view(*rows.shape[:-1], *shape) for part, shape in zip(rows.split([shape.numel() for shape in self.shapes], dim=-1), self.shapes)]

    def _at(self, kind: str, part: int, side: int) -> torch.Tensor:
        size, place = self._places[part, side]
        return self.state[f"{kind} {size}"][place]

    def _turned(self, rows: torch.Tensor, back: bool) -> torch.Tensor:
        """Q' G P of every matrix G, or Q G P' (`back`)."""
        found = []
        for part, matrix in enumerate(self._matrices(rows)):
            if (part, 0) in self._places:
                basis = self._at("basis", part, 0)
                matrix = (basis if back else basis.T) @ matrix
            if (part, 1) in self._places:
                basis = self._at("basis", part, 1)
                matrix = matrix @ (basis.T if back else basis)
            found.append(matrix.flatten(-2))
        return torch.cat(found, dim=-1)


OPTIMISERS = {"adam": Adam, "soap": Soap}
