"""Which of Mitsuba's images contain which bounces: every bounce as one image, or as the difference of two.

| integrator | what an image contains |
|---|---|
| ``path``, ``volpath``, ``volpathmis``, ``prb``, ``ptracer`` | ``max_depth = d``: bounces 0 … d − 1 |
| ``direct`` | bounces 0 and 1; 0 alone where everything is black |

The two images of a difference are rendered with the same seed. Where each path has random numbers of its own that do
not depend on how many were drawn before it, they share their paths, and the difference is the single term with the
noise of that term alone. That is so in compiled variants, and in scalar ones with one sample per call, or with
``ldsampler``, which has its numbers from no stream. With other samplers in scalar variants the two are as good as
independent, which is noisy and no less right, and so are the particles of ``ptracer`` there. Its difference is taken
with ``hide_emitters``, which leaves out E, with its noise, and nothing else.

Russian roulette is off: ``rr_depth`` is huge. In what ``production`` returns it is on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from comparisons.renderers.mitsuba_names import Form
from comparisons.renderers.protocol import Unsupported

_NO_ROULETTE = 1 << 30


class Pass(NamedTuple):
    """One image that is asked for.

    Attributes:
        depth: as Mitsuba counts it; None where the integrator has none.
        black: whether every surface is black.
        hide_emitters: whether E is left out.
    """

    depth: int | None
    black: bool = False
    hide_emitters: bool = False


Difference = tuple[Pass, Pass | None]


def difference(form: Form, bounce: int) -> Difference:
    """The image that holds a bounce, and what is to be taken off it.

    Raises:
        Unsupported: the integrator does not go so far.
    """
    if form.integrator == "direct":
        if bounce > 1:
            raise Unsupported(f"bounce {bounce}: the integrator direct has bounces 0 and 1")
        black = Pass(None, black=True)
        return (Pass(None), black) if bounce else (black, None)
    if bounce == 0:
        return Pass(1), None
    hide = form.integrator == "ptracer" and not form.coupled
    nothing = hide and bounce == 1  # E is what it would hold
    return Pass(bounce + 1, hide_emitters=hide), None if nothing else Pass(bounce, hide_emitters=hide)


def passes(differences: Sequence[Difference]) -> list[Pass]:
    """All images that are needed, each once."""
    return list(dict.fromkeys(image for both in differences for image in both if image))


def properties(form: Form, image: Pass) -> dict[str, Any]:
    """The integrator's dictionary for one image."""
    made: dict[str, Any] = {"type": form.integrator}
    if image.depth is not None:
        made |= {"max_depth": image.depth, "rr_depth": _NO_ROULETTE}
    return made | ({"hide_emitters": True} if image.hide_emitters else {})


def production(form: Form) -> dict[str, Any]:
    """The integrator with Mitsuba's own settings: unlimited depth, Russian roulette from the fifth bounce on.

    Raises:
        Unsupported: it has no sum of all bounces.
    """
    if form.integrator == "direct":
        raise Unsupported("the sum of all bounces: the integrator direct has bounces 0 and 1")
    # prb's own limit is 6, which is no economy that its users have chosen, but a default for gradients
    return {"type": form.integrator} | ({"max_depth": -1} if form.integrator == "prb" else {})
