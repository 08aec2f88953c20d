"""A page in headless Chromium: opened, looked at, clicked and dragged."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from tasks.view.live import Window

#: WebGL without a graphics card.
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
#: How long a page on a busy machine may take [ms].
PATIENCE = 60_000


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser; one a process at a time."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@contextmanager
def page(browser: Any, url: str, asked: list[str] | None = None, size: tuple[int, int] = (1200, 760)) -> Iterator[Any]:
    """An open page; `asked` collects the addresses of all that it asks for."""
    own = browser.new_page(viewport={"width": size[0], "height": size[1]})
    own.set_default_timeout(PATIENCE)
    if asked is not None:
        own.on("request", lambda request: asked.append(request.url))
        own.on("websocket", lambda socket: asked.append(socket.url))
    own.goto(url)
    yield own
    own.close()


@contextmanager
def running(window: Window) -> Iterator[None]:
    """The loop of a window in a thread of its own, as the page is driven from this one."""
    loop = threading.Thread(target=window.session.run)
    with window:
        loop.start()
        try:
            yield
        finally:
            window.session.end()
            loop.join()


def on_screen(window: Window, width: float, height: float, point: np.ndarray) -> tuple[float, float]:
    """Where a point of the world is in a picture of so many pixels."""
    from viser.transforms import SO3

    camera = next(iter(window.server.get_clients().values())).camera
    x, y, z = SO3(camera.wxyz).as_matrix().T @ (point - camera.position)  # x right, y down, z ahead
    pixels = 0.5 * height / np.tan(0.5 * camera.fov)
    return 0.5 * width + pixels * x / z, 0.5 * height + pixels * y / z


def drag(own: Any, window: Window, start: np.ndarray, end: np.ndarray, steps: int = 12) -> None:
    """Press the mouse at one point of the world, move to another, and let go."""
    box = own.locator("canvas").first.bounding_box()
    ways = [on_screen(window, box["width"], box["height"], point) for point in (start, end)]
    (x0, y0), (x1, y1) = [(box["x"] + x, box["y"] + y) for x, y in ways]
    for x in (x0 - 3, x0):
        own.mouse.move(x, y0)
        drawn(own)
    own.mouse.down()
    for k in range(1, steps + 1):
        own.mouse.move(x0 + (x1 - x0) * k / steps, y0 + (y1 - y0) * k / steps)
        drawn(own)
    own.mouse.up()


def drawn(own: Any, pictures: int = 3) -> None:
    """Wait until the page has drawn so many more pictures: what is under the mouse is found out while it draws."""
    for _ in range(pictures):
        own.evaluate("() => new Promise(requestAnimationFrame)")
