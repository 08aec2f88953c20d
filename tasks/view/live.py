"""``tasks.live``: shows any controller in the browser while it runs."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from numpy.typing import ArrayLike

from ..base.telling import LOG
from ..control.controller import Controller
from ..drawing.stage import LOOPBACK, PORT, open_stage, page_of
from .panel import Panel
from .scene import Overlay, Scene
from .session import Session

#: Pictures per second; and every how many pictures texts and plots are updated.
PICTURES, WORDS = 20.0, 4


class Window:
    """A session with the page that shows it; closed by `close`, or at the end of a ``with`` block.

    A separate thread draws the picture, and the session never waits for it. Nothing is drawn while no page is open.

    Parameters
    ----------
    session : Session
    host, port, folder, overlays
        See :func:`live`.
    """

    def __init__(
        self,
        session: Session,
        *,
        host: str = LOOPBACK,
        port: int = PORT,
        folder: str | os.PathLike[str] = ".",
        overlays: Sequence[Overlay] = (),
    ) -> None:
        self.session = session
        self.server = open_stage(host, port, "hqp live")
        try:
            self.scene = Scene(self.server, session, overlays)
            self.panel = Panel(self.server, session, self.scene, Path(folder))
        except BaseException:
            self.server.stop()
            raise
        self.url = page_of(self.server)
        self._pictures, self._closed = 0, threading.Event()
        self._thread = threading.Thread(target=self._draw, name="picture", daemon=True)

    def show(self) -> None:
        """Draw one picture now."""
        self.scene.show()
        if self._pictures % WORDS == 0:
            self.panel.show()
        self._pictures += 1

    def __enter__(self) -> Window:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop drawing, and stop the server."""
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        self.server.stop()

    def _draw(self) -> None:
        while not self._closed.wait(1.0 / PICTURES):
            if self.server.get_clients():
                try:
                    self.show()
                except Exception:  # a failed picture must not end the motion, but must be logged
                    LOG.exception("a picture could not be drawn")


def live(
    controller: Controller,
    q0: ArrayLike | None = None,
    *,
    host: str = LOOPBACK,
    port: int = PORT,
    certify: int = 25,
    folder: str | os.PathLike[str] = ".",
    overlays: Sequence[Overlay] = (),
) -> None:
    """Run a controller in closed loop with its model, shown and changed in a browser, until Ctrl-C.

    The page shows the robot, the targets of its tasks (to be dragged or typed), gains, priorities (to be reordered),
    joints within their limits, and what each level lacks and why. Only a model moves, no real robot.

    Parameters
    ----------
    controller : Controller
        It must have a dt [s]. Its tasks keep what was set on the page.
    q0 : array, shape (nq,), optional
        Configuration at the start (default: the robot's home).
    host : str
        Address to listen on (default: this machine only). A warning tells who else can connect.
    port : int
        Port to use; if it is taken, the next free one.
    certify : int
        Every how many ticks one is put to the certificate and explained; 0 for none.
    folder : path
        Where recordings are saved.
    overlays : sequence of Overlay
        Other things to draw, see :class:`tasks.view.scene.Overlay`.

    Raises
    ------
    InvalidInput
        If the controller has no dt, q0 does not fit, or the host cannot be listened on.
    MissingPackage
        If viser is not installed.
    """
    session = Session(controller, q0, certify=certify)
    with Window(session, host=host, port=port, folder=folder, overlays=overlays) as window:
        print(f"open {window.url} in a browser; Ctrl-C ends it", flush=True)
        print("any page that is open in a browser on this machine can connect to it, too", flush=True)
        with suppress(KeyboardInterrupt):
            session.run()
