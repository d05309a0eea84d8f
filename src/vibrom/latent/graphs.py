"""A step of training as one graph of CUDA kernels, launched at once: on a GPU, launching a small
network's kernels one by one takes longer than running them.

See the section on CUDA graphs of torch's notes on CUDA semantics.
"""

from collections.abc import Callable, Sequence

from vibrom.latent.backend import torch

REHEARSALS = 3  # torch's libraries take their workspace in the first calls, outside of the graph


def captured(
    step: Callable[[], None], changed: Sequence[torch.Tensor], device: torch.device
) -> Callable[[], None]:
    """The same as `step`, which must do the same work on the same memory at every call; `changed`:
    all tensors that it changes and reads again.

    On a CPU that is `step` itself. Nothing is trained here: the tensors are put back after the
    rehearsals.
    """
    if device.type != "cuda":
        return step
    before = [tensor.clone() for tensor in changed]
    with torch.cuda.device(device):  # a graph is captured on the current one
        aside = torch.cuda.Stream()
        aside.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(aside):
            for _ in range(REHEARSALS):
                step()
        torch.cuda.current_stream().wait_stream(aside)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph):
            step()
    for tensor, value in zip(changed, before):
        tensor.copy_(value)
    return graph.replay
