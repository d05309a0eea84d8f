"""Packages that only some uses need: pyproject's extras bring them."""

from importlib.util import find_spec


def need(package: str, use: str, extra: str) -> None:
    """Raises ModuleNotFoundError where the package is missing, and says which extra brings it."""
    if find_spec(package) is None:
        raise ModuleNotFoundError(
            f"{use} needs {package}, which is not installed; install vibrom[{extra}]"
        )
