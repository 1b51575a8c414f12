"""The process in which one renderer lives: ``python -m comparisons.renderers.worker NAME``.

Started by ``process.py``; a crash, a hang or a leak of the renderer stays in here.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback

from comparisons.renderers import Unsupported, create
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
from comparisons.renderers.protocol import NO_TOTAL, Hits, Images, Renderer, RendersTotal, SeesFirstHits
from scenes import Scene


def main(name: str) -> None:
    """Answer requests until the standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which then ends its workers
    # replies go through a copy of the standard output; whatever else is printed there joins the log
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        renderer = create(name)
        send_reply(replies, Ready(renderer.version()))
    except Exception as error:
        traceback.print_exc()
        send_reply(replies, Failed(f"{name} can't be loaded: {error}"))
        return
    while (request := receive_request(sys.stdin.buffer)) is not None:
        send_reply(replies, *_answer(renderer, *request))


def _answer(renderer: Renderer, request: Request, scene: Scene) -> tuple[Reply, Images | None]:
    try:
        if isinstance(request, FirstHits):
            image = _first_hits(renderer, scene)
        elif isinstance(request, Total):
            image = _total(renderer, scene, request)
        else:
            image = renderer.render(scene, request.bounces, request.spp, request.seed)
    except Unsupported as missing:
        return Refused(str(missing)), None
    except Exception as error:
        traceback.print_exc()
        return Failed(f"{type(error).__name__}: {error}"), None
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
    main(sys.argv[1])
