"""Where robots are drawn: a server of viser, which shows its scene in every browser that connects."""

from __future__ import annotations

import io
import ipaddress
import socket
from collections.abc import Sequence
from contextlib import redirect_stdout
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput, MissingPackage
from hqp.checks import of_type, whole_number

from ..base.checks import Array
from ..base.telling import tell

if TYPE_CHECKING:
    import viser

#: Address that only this machine reaches; the first port, and the last one that is tried.
LOOPBACK, PORT, LAST_PORT = "127.0.0.1", 8080, 65535
#: Names of this machine itself.
OWN = (LOOPBACK, "localhost", "::1")


def viser_module() -> Any:
    """viser, imported when something is drawn.

    Raises
    ------
    MissingPackage
        If viser is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingPackage("a picture in the browser needs viser: pip install 'hqp[live]'") from error
    return viser


def open_stage(host: str = LOOPBACK, port: int = PORT, label: str = "hqp") -> viser.ViserServer:
    """A viser server with a floor and lights, which cannot be shared over the internet.

    Parameters
    ----------
    host : str
        Address to listen on (default: this machine only; any other address gives a warning).
    port : int
        Port to use, or the next one that is free.
    label : str
        Title at the top of the panel.

    Raises
    ------
    InvalidInput
        If it cannot listen at this address.
    MissingPackage
        If viser is not installed.
    """
    of_type(host, str, "host")
    port = whole_number(port, "port", least=1)
    if port > LAST_PORT:
        raise InvalidInput(f"port = {port}; it must be at most {LAST_PORT}")
    viser_module()
    _check_address(host)
    if host not in OWN:
        tell(
            f"listening on {host!r}: whoever reaches this machine can move what is shown, and there is no password;"
            f" without --host it is {LOOPBACK}, for this machine alone"
        )
    try:
        with redirect_stdout(io.StringIO()):  # the caller prints the address
            server: viser.ViserServer = _stage()(host=host, port=port, label=label, verbose=False)
    except (OSError, AssertionError, RuntimeError) as error:
        raise InvalidInput(f"cannot listen on {host!r}, port {port}: {error}") from None
    server.gui.configure_theme(show_share_button=False, show_logo=False, control_width="large")
    server.gui.main_panel.dock_right()
    server.scene.set_up_direction("+z")
    server.scene.configure_default_lights(cast_shadow=False)
    return server


def page_of(server: viser.ViserServer) -> str:
    """The address at which a browser on this machine opens the page: one that listens to all is found at its own."""
    host = server.get_host() or "0.0.0.0"
    try:
        ip = ipaddress.ip_address(host)
    except ValueError:  # a name
        return f"http://{host}:{server.get_port()}"
    if ip.version == 4:
        return f"http://{LOOPBACK if ip.is_unspecified else ip}:{server.get_port()}"
    return f"http://[{'::1' if ip.is_unspecified else ip}]:{server.get_port()}"


def _check_address(host: str) -> None:
    """Refuse an address that is none of this machine; viser would try every port of it."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host or None, 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(address)
    except OSError as error:
        told = f"it is no address of this machine ({error.strerror or error})"
        raise InvalidInput(f"cannot listen on {host!r}: {told}; {LOOPBACK} is for this machine alone") from None


@cache
def _stage() -> Any:
    viser = viser_module()

    class Stage(viser.ViserServer):  # type: ignore[misc, name-defined]
        """A server that prints nothing, and opens no tunnel to the internet if a page asks for one."""

        def request_share_url(self, verbose: bool = True) -> None:
            return None

        def stop(self) -> None:
            with redirect_stdout(io.StringIO()):
                super().stop()

    return Stage


def look(server: viser.ViserServer, bounds: Array, points: Sequence[Array] = ()) -> None:
    """Lay a floor below the box between two corners [m], shape (2, 3); a page starts with it and the points in view."""
    seen = np.vstack([bounds, *points])
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    floor = 0.0 if bounds[0, 2] > -0.05 * size else float(bounds[0, 2])
    width = max(2.0, 2.0 * round(2.0 * size) / 2.0)
    server.scene.add_grid(
        "/floor",
        width=width,
        height=width,
        cell_size=0.25,
        section_size=1.0,
        position=(0.0, 0.0, floor),
        shadow_opacity=0.0,
    )
    camera = server.initial_camera
    camera.position = middle + size * np.array([1.05, -0.7, 0.45])
    camera.look_at = middle
