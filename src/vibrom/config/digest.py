"""Files by what they hold; apart from how configuration is read, which no artefact depends on."""

from hashlib import sha256
from pathlib import Path


def digest(path: Path) -> str:
    """Of what a file holds."""
    return sha256(path.read_bytes()).hexdigest()[:16]
