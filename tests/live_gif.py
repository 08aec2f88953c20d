"""The moving picture at the top of the README: ``python tests/live_gif.py docs/images/live.gif``.

A Panda's target is led out of its reach, the page says what holds it back, and orientation is put above position. Time
stands between two pictures, so that the film does not depend on how fast the machine draws.
"""

from __future__ import annotations

import io
import sys

import numpy as np
from browser import chromium, page, running
from PIL import Image

from tasks import load_robot
from tasks.view.live import Window
from tasks.view.session import Session
from tasks.view.stacks import ready_controller

SIZE, TICKS, FRAME = (960, 560), 8, 80  # pixels, ticks a picture, ms a picture
COLORS = 110
#: Colours of words, too few of them to be found by counting.
KEPT = (201, 42, 42, 43, 138, 62, 230, 140, 140, 140, 190, 150)
#: Where the target goes, in so many pictures each [m]; the first three are in reach.
WAY = (((0.45, -0.2, 0.45), 10), ((0.45, 0.3, 0.5), 14), ((-0.15, 1.05, 0.75), 14))


def film() -> list[Image.Image]:
    """All pictures."""
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    window = Window(Session(ready_controller(robot, 0.01), certify=TICKS), port=8400)
    live, shots = window.session, []
    live.pause()
    with running(window), chromium() as browser, page(browser, window.url, size=SIZE) as own:
        own.wait_for_selector("text=paused")
        own.add_style_tag(content="[class*=Notifications-root] { display: none }")
        own.wait_for_timeout(6000)

        def shoot(count: int) -> None:
            for _ in range(count):
                live.do(lambda: [live.motion.tick() for _ in range(TICKS)])
                own.wait_for_timeout(350)
                shots.append(Image.open(io.BytesIO(own.screenshot())).convert("RGB"))

        target = live.targets[0]
        start = target.p.copy()
        for end, count in WAY:
            for k in range(1, count + 1):
                p = start + (np.array(end) - start) * k / count
                live.do(lambda p=p: target.move(p=p))
                shoot(1)
            start = np.array(end)
        shoot(12)
        own.get_by_role("button", name="▲").nth(2).click()
        own.wait_for_selector("text=1 orientation")
        shoot(24)
    return shots


def main(path: str) -> None:
    shots = film()
    some = np.concatenate([np.asarray(shot) for shot in shots[:: len(shots) // 4]])
    palette = Image.fromarray(some).quantize(COLORS, dither=Image.Dither.NONE)
    palette.putpalette([*(palette.getpalette() or [])[: 3 * COLORS], *KEPT])
    pictures = [shot.quantize(palette=palette, dither=Image.Dither.NONE) for shot in shots]
    times = [FRAME] * (len(pictures) - 1) + [2000]
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=times, loop=0, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1])
