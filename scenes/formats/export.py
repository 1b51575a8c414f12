"""What the writers of foreign formats share: what they make, how they refuse, how it gets into files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import msgspec


class UnsupportedFeatureError(ValueError):
    """A scene that a format can't express, or expresses with another meaning.

    Attributes:
        format: as on the command line.
        feature: what it is, and why it can't be written.
    """

    def __init__(self, format: str, feature: str) -> None:
        super().__init__(format, feature)  # both of them, so that it survives the way out of a process
        self.format, self.feature = format, feature

    def __str__(self) -> str:
        return f"{self.format} can't express this scene: {self.feature}"


@dataclass(frozen=True)
class Export:
    """A scene in another format.

    Attributes:
        content: of the main file.
        files: contents of the files that it refers to, by their names in the same folder.
    """

    content: bytes
    files: Mapping[str, bytes] = field(default_factory=dict)

    def write(self, path: Path) -> list[Path]:
        """Write all files; the main one last, so that it never refers to one that is not there.

        Returns:
            The files that were written.
        """
        contents = {path.with_name(name): content for name, content in self.files.items()} | {
            path: self.content
        }
        for file, content in contents.items():
            file.write_bytes(content)
        return list(contents)


def kind(part: msgspec.Struct) -> str:
    """What a part of a scene is called in JSON."""
    return str(part.__struct_config__.tag).replace("_", " ")


def rgb(format: str, values: tuple[float, ...]) -> tuple[float, ...]:
    """Three numbers: the value of a single channel is grey.

    Raises:
        UnsupportedFeatureError: neither one channel nor three.
    """
    if len(values) not in (1, 3):
        raise UnsupportedFeatureError(
            format, f"{len(values)} channels: the format has RGB; export one of them at a time (--channel)"
        )
    return values if len(values) == 3 else values * 3
