from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from comparisons.crew import Crew
from comparisons.renderers import RendererFailed
from scenes import library

SCENE = library.case("furnace-box").scene.resized(8, 8)


def test_the_image_of_a_seed_does_not_depend_on_who_made_it() -> None:
    images = []
    for jobs in (1, 3):
        with Crew(jobs) as crew:
            futures = [
                crew.render("reference:mis", SCENE, [0, 1, 2], 4, seed, timeout=60) for seed in range(6)
            ]
            images.append(np.array([future.result() for future in futures]))
    np.testing.assert_array_equal(*images)
    assert len({image.tobytes() for image in images[0]}) == 6


def test_a_process_that_failed_is_replaced(wrong: Any) -> None:
    with Crew(1) as crew:
        with pytest.raises(RendererFailed):
            crew.render("wrong:leave", SCENE, [0, 1], 1, 0, timeout=60).result()
        assert crew.render("wrong:right", SCENE, [0, 1], 1, 0, timeout=60).result().shape == (2, 8, 8, 3)


def test_leaving_ends_what_is_still_at_work(wrong: Any) -> None:
    with Crew(2) as crew:
        futures = [crew.render("wrong:hang", SCENE, [0, 1], 1, seed, timeout=600) for seed in range(2)]
        crew.render("wrong:hang", SCENE, [0, 1], 1, 3, timeout=600)
    assert all(isinstance(future.exception(), RendererFailed) for future in futures)


def test_dismissing_a_renderer_ends_what_it_is_doing(wrong: Any) -> None:
    with Crew(2) as crew:
        crew.version("wrong:right")
        hanging = crew.render("wrong:hang", SCENE, [0], 1, 0, timeout=600)
        time.sleep(2)  # for the process to have started
        crew.dismiss("wrong:hang")
        assert isinstance(hanging.exception(timeout=30), RendererFailed)
        assert crew.render("wrong:right", SCENE, [0], 1, 0, timeout=60).result().shape == (1, 8, 8, 3)
