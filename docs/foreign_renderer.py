"""The page of the foreign renderer: ``python docs/foreign_renderer.py`` runs its commands and writes what they print.

They are the lines that begin with ``$`` in blocks marked ``console``, run in order in a copy of the example; what
stands below them is replaced. A block below ``<!-- file: NAME -->`` is that file of the example.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = Path(__file__).with_name("foreign-renderer.md")
EXAMPLE = ROOT / "examples" / "tiny"
BUILT = ("tiny", "*.o", "*.exr", "*.json", "lightproof-report")

_CONSOLE = re.compile(r"(?<=^```console\n)(.*?)(?=^```$)", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"(<!-- file: (\S+) -->\n```\w+\n).*?(?=^```$)", re.MULTILINE | re.DOTALL)


def rewritten(text: str, built: Path | None = None) -> str:
    """The page with what its commands print now; of a program that ``make`` has built already, if one says where."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "tiny"
        shutil.copytree(EXAMPLE, work, ignore=shutil.ignore_patterns(*BUILT))
        for file in [*built.glob("*.o"), built / "tiny"] if built else []:
            shutil.copy(file, work)  # newer than the sources
        text = _FILE.sub(lambda match: match[1] + (EXAMPLE / match[2]).read_text(), text)
        return _CONSOLE.sub(lambda match: "".join(_session(match[0], work)), text)


def _session(block: str, work: Path) -> Iterator[str]:
    """The commands of a block, each with what it prints."""
    for command in re.findall(r"^\$ (.*)$", block, re.MULTILINE):
        yield f"$ {command}\n"
        yield _printed(command, work)


def _printed(command: str, work: Path) -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    found = subprocess.run(
        ["bash", "-c", command.replace("lightproof ", f"{sys.executable} -m lightproof ", 1)],
        cwd=work,
        env={**os.environ, "PATH": path, "COLUMNS": "114", "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )
    shown = found.stdout.replace(f"{work}/", "")
    if command == "make":
        if found.returncode:
            raise RuntimeError(shown)
        return ""  # how the compiler was called tells nothing
    return "".join(line.rstrip() + "\n" for line in shown.splitlines() if line.strip())


if __name__ == "__main__":
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
