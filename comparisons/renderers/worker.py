"""The process in which one renderer lives: ``python -m comparisons.renderers.worker NAME ENTRY``.

Started by ``process.py``; a crash, a hang or a leak of the renderer stays in here. ``ENTRY`` is an ``entry.Entry`` as
JSON: all that is known of the renderer, wherever the run has found it.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import threading
import time
import traceback

import msgspec
import numpy as np

from comparisons.renderers import limits
from comparisons.renderers.entry import Entry
from comparisons.renderers.messages import (
    Failed,
    FirstHits,
    Ready,
    Refused,
    Rendered,
    Reply,
    Request,
    Total,
    receive_request,
    send_reply,
)
from comparisons.renderers.protocol import (
    NO_TOTAL,
    Hits,
    Images,
    Renderer,
    RendererError,
    RendererFailed,
    RendersTotal,
    SeesFirstHits,
    Unsupported,
)
from comparisons.renderers.registry import make
from scenes import Scene

_LONGEST = 1000
"""Characters of a message; the log has the rest."""

_LEAVING = threading.Lock()


def main(name: str, known: str) -> None:
    """Answer requests until the standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which then ends its workers
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    # replies go through a copy of the standard output; whatever else is printed there joins the log
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        entry = msgspec.json.decode(known, type=Entry)
        if entry.folder:
            sys.path[:] = map(os.path.abspath, sys.path)
            os.chdir(entry.folder)
        renderer = make(entry)
        send_reply(replies, Ready(_version(renderer)))
    except (Exception, SystemExit) as error:
        send_reply(replies, Failed(f"{name} can't be loaded: {_told(error)}"))
        return
    try:
        while (request := receive_request(sys.stdin.buffer)) is not None:
            send_reply(replies, *_answer(renderer, *request))
    except Exception:
        traceback.print_exc()
    finally:  # the run has gone: had it sent us home, we would not get here
        _leave()


def _version(renderer: object) -> str:
    """As it says itself; an object of the user's may have none, its module perhaps."""
    ask = getattr(renderer, "version", None)
    module = sys.modules.get(type(renderer).__module__)
    found = ask() if callable(ask) else getattr(module, "__version__", "unknown")
    if not isinstance(found, str):
        raise RendererFailed(f"version() returned {found!r}: expected a text")
    return found


def _end_with(parent: int) -> None:
    """End this process when the run is gone, even if it was killed."""
    while os.getppid() == parent:
        time.sleep(1.0)
    _leave()


def _leave() -> None:
    """End this process and all it has started, and take its temporary files along."""
    with _LEAVING:
        if folder := os.environ.get(limits.MARK):
            limits.end_all(os.getpid(), folder)
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(0)


def _answer(renderer: Renderer, request: Request, scene: Scene) -> tuple[Reply, Images | None]:
    try:
        if isinstance(request, FirstHits):
            image = _first_hits(renderer, scene)
        elif isinstance(request, Total):
            image = _total(renderer, scene, request)
        else:
            image = renderer.render(scene, request.bounces, request.spp, request.seed)
        return _rendered(image)
    except Unsupported as missing:
        return Refused(str(missing)), None
    except RendererError as error:
        return Failed(str(error)), None
    except (Exception, SystemExit) as error:  # what calls sys.exit wants to end a program, and is none
        return Failed(_told(error)), None


def _told(error: BaseException) -> str:
    """What was raised, in a line or a few; all of it goes to the log, but what we say ourselves is all there is."""
    if not isinstance(error, RendererError):
        traceback.print_exc()
    told = (
        str(error) if isinstance(error, RendererError | ImportError) else f"{type(error).__name__}: {error}"
    )
    return told if len(told) <= _LONGEST else f"{told[:_LONGEST]} …"


def _rendered(found: object) -> tuple[Reply, Images | None]:
    image = np.asarray(found)
    if image.dtype.kind not in "fiu":
        return Failed(f"returned values of type {image.dtype}, expected an array of real numbers"), None
    return Rendered(image.shape), image


def _total(renderer: Renderer, scene: Scene, request: Total) -> Images:
    if not isinstance(renderer, RendersTotal):
        raise Unsupported(NO_TOTAL)
    return renderer.total(scene, request.spp, request.seed)


def _first_hits(renderer: Renderer, scene: Scene) -> Hits:
    if not isinstance(renderer, SeesFirstHits):
        raise Unsupported("first hits: its adapter has no first_hits(scene)")
    return renderer.first_hits(scene)


if __name__ == "__main__":
    main(*sys.argv[1:])
