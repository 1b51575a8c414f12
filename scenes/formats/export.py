"""What the writers of foreign formats share: what they make, how they refuse, how it gets into files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import msgspec

from scenes.scene import Scene


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
class Source:
    """Where a scene comes from, for the header of its file.

    Attributes:
        text: which scene, in words: ``case cornell-box, channel 1``.
        bounces: the last one that the file asks for, where its reader is not told otherwise.
    """

    text: str = "a scene of one's own"
    bounces: int = 5


UNKNOWN = Source()


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


def generator() -> str:
    """What wrote the file: ``lightproof 0.1.0``."""
    return f"lightproof {version('lightproof')}"


def header(scene: Scene, source: Source, *usage: str) -> list[str]:
    """Lines of text that say what the file is, where it comes from, and how it is used."""
    return [
        f"Written by {generator()}: {' '.join(source.text.split())}",
        f"SHA-256 of the scene as JSON: {scene.sha256}",
        *usage,
    ]


def portable(name: str) -> str:
    """The name with an underscore for whatever would have to be quoted in one of the formats that refer to it."""
    return re.sub(r"[^\w.-]", "_", name)


def kind(part: msgspec.Struct) -> str:
    """What a part of a scene is called in JSON."""
    return str(part.__struct_config__.tag).replace("_", " ")


def refuse_spectra(format: str, scene: Scene) -> None:
    """Refuse scenes with neither one channel nor three.

    Raises:
        UnsupportedFeatureError: naming how many there are.
    """
    if scene.channels not in (1, 3):
        raise UnsupportedFeatureError(
            format, f"{scene.channels} channels: the format has RGB; export one of them at a time (--channel)"
        )


def rgb(values: tuple[float, ...]) -> tuple[float, ...]:
    """Three numbers: the value of a single channel is grey."""
    return values if len(values) == 3 else values * 3
