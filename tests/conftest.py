import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from beam import beam  # noqa: E402, F401  a fixture
