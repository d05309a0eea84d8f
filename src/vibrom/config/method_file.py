"""What config/methods says of a method beside the settings that its own file declares."""

from __future__ import annotations

from typing import Annotated, Any

from msgspec import Meta

from vibrom.config.kinds import Name, RomClass
from vibrom.config.scene import Block

Resource = Annotated[int, Meta(ge=1)]


class MethodFile(Block, frozen=True):
    """One file of config/methods."""

    seeded: bool  # false: deterministic, and fitted once
    method: Name | None = None  # the file of src/vibrom/methods, where it bears another name
    settings: dict[str, Any] = {}  # those that differ from the method's own
    starts_from: Name | None = None  # the method whose fitted model this one starts from
    rule: str | None = None  # the rule file of a method that is not in src/vibrom/methods
    # module:name of the class that the rom.nc of an outside method is read as
    rom_class: RomClass | None = None
    resources: dict[str, Resource | str] = {}  # threads, mem_mb, ...
