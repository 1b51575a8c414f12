"""Real processes that crash, hang, devour and garble: each is one error, with its log, and nothing of it stays."""

from __future__ import annotations

import mmap
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import pytest

from comparisons import campaign
from comparisons.crew import Crew
from comparisons.renderers import RendererError, RendererFailed, RendererTimeout, limits
from comparisons.renderers.process import RendererProcess
from comparisons.settings import Settings
from scenes import Image, ImageTexture, Lambertian, Scene, library


@pytest.fixture
def scene() -> Scene:
    return library.case("furnace-box").scene.resized(8, 8)


PROGRAMS = {
    "crash": "was killed by signal 11 (SIGSEGV)",
    "abort": "was killed by signal 6 (SIGABRT)",
    "leave": "ended with status 3; the last it said was: no more memory for textures",
    "forget": "wrote no image: expected it at {output}",
    "garbage": "expected an EXR file; it can't be read",
    "truncate": "its pixels can't be read; the file is incomplete",
    "size": "wrote an image of 8x7 pixels, expected 8x8",
    "nan": "wrote 1 of 64 pixels that are not finite (NaN or infinite), the first in row 2, column 1",
    "hang": "no image within 3 s; it was stopped",
    "hang-with-children": "no image within 3 s; it was stopped",
    "chatter": "no image within 3 s; it was stopped",
}


@pytest.mark.parametrize("how", PROGRAMS)
def test_a_program_that_misbehaves(start: Any, scene: Scene, how: str, spotless: Any) -> None:
    """Its worker lives on, and is asked again."""
    process = start("--wrong", how, timeout=3.0 if "stopped" in PROGRAMS[how] else 60.0)
    for _ in range(1 if "stopped" in PROGRAMS[how] else 2):
        with pytest.raises(RendererFailed) as caught:
            process.render(scene, [0, 1], 1, 0, timeout=60)
        assert PROGRAMS[how] in str(caught.value)
        assert [line for line in caught.value.log if f"about to {how}" in line or "garbage" in line]
    assert spotless() == [process._process.pid] or how == "hang-with-children"


def test_a_program_that_leaves_children_behind(start: Any, scene: Scene, spotless: Any) -> None:
    """It is fine, and its image counts; they end with it, at latest with its worker."""
    process = start("--wrong", "leave-children")
    assert process.render(scene, [0], 1, 0, timeout=60).min() == 1.0
    assert len(spotless()) == 2, "the worker, and the one that has left the process group"
    process.close()
    assert spotless() == []


def test_what_prints_without_end_does_not_fill_the_disk(
    start: Any, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    process = start("--wrong", "chatter", timeout=3.0)
    sizes, trim = [], process._trim_log

    def measured() -> None:
        sizes.append(os.fstat(process._log.fileno()).st_size)
        trim()

    process._trim_log = measured
    with pytest.raises(RendererFailed):
        process.render(scene, [0], 1, 0, timeout=60)
    # how much is printed between two looks depends on the machine; that it is let go of does not
    assert max(sizes) > 1_000_000
    assert any(later < earlier for earlier, later in pairwise(sizes))


def test_a_request_that_ends_ends_the_program_too(start: Any, scene: Scene, spotless: Any) -> None:
    """The time of a request is up before that of the call; also what has left its process group goes."""
    process = start("--wrong", "hang-with-children", timeout=600.0)
    with pytest.raises(RendererTimeout, match="no answer within 3 s"):
        process.render(scene, [0], 1, 0, timeout=3)
    assert spotless() == []


@pytest.mark.parametrize("keys", [{"memory": "400 MB"}, {}], ids=["of its own", "of all"])
def test_memory_has_a_limit(
    start: Any, scene: Scene, keys: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the worker and its program together, which is what takes it all."""
    monkeypatch.setattr("comparisons.renderers.config.default_memory", lambda: 400_000_000)
    process = start("--wrong", "devour", **keys)
    with pytest.raises(RendererFailed, match="took more than 400 MB of memory, its limit; it was stopped"):
        process.render(scene, [0], 1, 0, timeout=60)


def test_memory_that_is_only_reserved_does_not_count() -> None:
    """As compilers at run time do: a limit of the address space would end them."""
    before, no_reserve = limits.resident(os.getpid()), 0x4000  # Linux's number
    with mmap.mmap(-1, 1 << 34, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve):
        assert limits.resident(os.getpid()) < before + (1 << 28)


# ---- workers, and objects in them


WORKERS = {
    "garbage": (
        "print('hello'); input()",
        "said something that is no reply: 'hello': .*; what else is printed belongs on the standard error",
    ),
    "a line without end": (
        "import sys\nwhile True: sys.stdout.write('x' * 100000)",
        "no reply: a line of more",
    ),
    "leaves": ("import sys; print('no licence', file=sys.stderr); sys.exit(4)", "ended with status 4"),
    "closes its output": (
        "import os, time, sys; print('bye', file=sys.stderr); os.close(1); time.sleep(600)",
        "closed its standard output",
    ),
    "an image beyond all bounds": (
        """import sys
print('{"type": "ready", "version": "1"}', flush=True)
input(), input()
print('{"type": "rendered", "shape": [99999999, 99999999]}', flush=True)
input()""",
        "said something that is no reply: an image of shape",
    ),
    "half an image": (
        """import sys
print('{"type": "ready", "version": "1"}', flush=True)
input(), input()
print('{"type": "rendered", "shape": [1, 8, 8, 3]}', flush=True)
sys.stdout.write('x' * 100)""",
        "ended with status 0",
    ),
}


@pytest.mark.parametrize("how", WORKERS)
def test_a_worker_that_misbehaves(
    configured: Any, spotless: Any, scene: Scene, how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("comparisons.renderers.process._LEAVE", 1.0)
    text, message = WORKERS[how]
    (tmp_path / "mine.py").write_text(text)
    configured(mine={"worker": "mine.py", "python": sys.executable})
    with pytest.raises(RendererFailed, match=message), RendererProcess("mine") as process:
        process.render(scene, [0], 1, 0, timeout=60)


def test_a_worker_that_reads_no_request_is_stopped(configured: Any, spotless: Any, tmp_path: Path) -> None:
    """The scene is larger than a pipe holds: the run waits for it to be read, and no longer than it should."""
    ready = """print('{"type": "ready", "version": "1"}', flush=True)"""
    (tmp_path / "mine.py").write_text(f"import time\n{ready}\ntime.sleep(600)")
    configured(mine={"worker": "mine.py", "python": sys.executable})
    small = library.case("furnace-box").scene
    picture = ImageTexture(Image(tuple(((0.5, 0.5, 0.5),) * 200 for _ in range(200))))
    first = msgspec.structs.replace(small.surfaces[0], material=Lambertian(picture))
    large = msgspec.structs.replace(small, surfaces=(first, *small.surfaces[1:]))
    assert len(large.to_json()) > 1_000_000
    with RendererProcess("mine") as process, pytest.raises(RendererTimeout):
        process.render(large, [0], 1, 0, timeout=1)


OBJECT = """
import os, subprocess, time

class Mine:
    def __init__(self):
        print("made")
        {making}

    def version(self):
        return "1"

    def render(self, scene, bounces, spp, seed):
        {rendering}
"""


@contextmanager
def an_object(folder: Path, rendering: str = "", making: str = "pass") -> Iterator[RendererProcess]:
    (folder / "mine.py").write_text(OBJECT.format(making=making, rendering=rendering))
    with RendererProcess("mine:Mine") as process:
        yield process


def test_an_object_that_hangs_in_a_child(
    tmp_path: Path, scene: Scene, spotless: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with an_object(tmp_path, 'subprocess.run(["setsid", "sleep", "3603"])') as process:
        with pytest.raises(RendererTimeout):
            process.render(scene, [0], 1, 0, timeout=2)
        assert spotless() == []


def test_leaving_ends_renderers_that_are_still_being_loaded(
    tmp_path: Path, scene: Scene, spotless: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Ctrl-C does: nobody waits until a hanging import has had its two minutes."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(OBJECT.format(making="time.sleep(3600)", rendering="pass"))
    begun = time.monotonic()
    with Crew(2) as crew:
        futures = [crew.render("mine:Mine", scene, [0], 1, seed, timeout=600) for seed in range(2)]
        while len(spotless()) < 2 and time.monotonic() < begun + 60:
            time.sleep(0.05)
        left = time.monotonic()
    assert time.monotonic() < left + 20
    assert all(isinstance(future.exception(), RendererError) for future in futures)


RUN = """
import sys
from comparisons.renderers.process import RendererProcess
from scenes import library

with RendererProcess("mine") as process:
    print("ready", flush=True)
    process.render(library.case("furnace-box").scene.resized(8, 8), [0], 1, 0, timeout=600)
"""


@pytest.mark.parametrize("by", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_run_that_is_ended_takes_its_renderers_along(
    start: Any, spotless: Any, tmp_path: Path, by: signal.Signals
) -> None:
    """Killed, it leaves nobody to end them: they notice that it has gone."""
    start("--wrong", "hang-with-children", timeout=600.0).close()
    run = subprocess.Popen(
        [sys.executable, "-c", RUN],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "TMPDIR": str(tmp_path / "temporary")},
    )
    deadline = time.monotonic() + 60
    while (
        len(spotless()) < 4 and time.monotonic() < deadline
    ):  # the worker, its program, and two children of that
        time.sleep(0.05)
    assert len(spotless()) == 4
    run.send_signal(by)
    run.communicate(timeout=30)
    while spotless() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert spotless() == []


def test_the_run_goes_on(configured: Any, spotless: Any, tmp_path: Path, observer: Any) -> None:
    """A renderer that never finishes, one that crashes, and one that is fine: a verdict for each."""
    program = Path(__file__).with_name("program.py")
    call = f"{sys.executable} {program} {{scene}} -o {{output}} --spp {{spp}} --seed {{seed}}".split()
    call += ["--bounces", "{bounces}", "--shared"]
    table = {"command": call, "scene": "json", "images": "cumulative", "coupled": True}
    configured(
        hangs={**table, "command": [*call, "--wrong", "hang"], "timeout": 3.0},
        crashes={**table, "command": [*call, "--wrong", "crash"]},
        works={**table, "deterministic": True},  # E is: two replicates tell all
    )
    (tmp_path / "out").mkdir()
    settings = Settings(bounces=0, size=(8, 8), budget=60.0)
    case = library.case("furnace-box")
    found = list(campaign.run([case], ["hangs", "crashes", "works"], settings, tmp_path / "out", observer))
    assert [comparison.verdict for comparison in found[:2]] == ["error", "error"]
    assert "no image within 3 s; it was stopped" in found[0].message
    assert "SIGSEGV" in found[1].message
    assert any("about to crash" in line for line in found[1].log)
    assert found[2].verdict == "pass"
    assert found[2].replicates == 2
