"""SPLIT as one writes it with torch's own means: modules, forward-mode derivatives in time,
automatic differentiation, torch.optim.Adam.

    L = |q - v(w(q))|^2 + l1 |q'' - d2/dt2 v(z)|^2 + l2 |z'' - f(z, z')|^2,    f = R0 (z, z') +
    sum_i Xi_i z^a_i z'^b_i

Physical time and displacements, ELU, no biases, as the thesis has it; one latent coordinate.
"""

import torch
from torch import nn


def network(sizes: tuple[int, ...]) -> nn.Sequential:
    layers = []
    for inputs, outputs in zip(sizes, sizes[1:]):
        layers += [nn.Linear(inputs, outputs, bias=False), nn.ELU()]
        nn.init.xavier_uniform_(layers[-2].weight)
    return nn.Sequential(*layers[:-1])


def second_derivative(function, value, first, second):
    """d/dt and d2/dt2 of function(value(t))."""

    def rate(value, first):
        return torch.func.jvp(function, (value,), (first,))[1]

    return torch.func.jvp(rate, (value, first), (first, second))


class Split(nn.Module):
    def __init__(
        self, dofs: int, linear: torch.Tensor, powers: torch.Tensor, full: float, reduced: float
    ):
        super().__init__()
        self.encoder, self.decoder = network((dofs, 64, 32, 1)), network((1, 32, 64, dofs))
        self.coefficients = nn.Parameter(torch.ones(len(powers)))
        self.linear, self.powers, self.full, self.reduced = linear, powers, full, reduced

    def forward(
        self, q: torch.Tensor, velocity: torch.Tensor, acceleration: torch.Tensor
    ) -> torch.Tensor:
        """The loss of samples (m, dofs)."""
        z = self.encoder(q)
        first, second = second_derivative(self.encoder, q, velocity, acceleration)
        y = torch.cat([z, first], dim=1)
        model = (y @ self.linear.T)[:, 0] + (y[:, None, :] ** self.powers).prod(
            dim=-1
        ) @ self.coefficients
        _, back = second_derivative(self.decoder, z, first, model[:, None])
        return (
            (q - self.decoder(z)).square().sum(1).mean()
            + self.full * (acceleration - back).square().sum(1).mean()
            + self.reduced * (second[:, 0] - model).square().mean()
        )


def iterations(model: Split, motion: torch.Tensor, batch: int, count: int, rate: float) -> float:
    """`count` steps of Adam on batches of motion (3, m, dofs) in turn; the last loss."""
    optimiser = torch.optim.Adam(model.parameters(), lr=rate)
    for step in range(count):
        first = step * batch % motion.shape[1]
        optimiser.zero_grad()
        loss = model(*motion[:, first : first + batch])
        loss.backward()
        optimiser.step()
    return loss.item()
