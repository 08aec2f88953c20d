"""The panel beside the picture: time, priorities, gains, targets, joints and plots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..base.rotations import from_rpy
from ..robots.robot import joint_names
from ..rows.task import Task
from .motion import PLOTTED
from .session import Session
from .targets import Target
from .words import joints, reasons, status, units

if TYPE_CHECKING:
    import viser

    from .scene import Scene

UP, DOWN, SWITCH = "▲", "▼", "on/off"
#: Upper end of the sliders of gains [1/s], if the tick allows it.
MOST_GAIN = 20.0
COLORS = ("#4c6ef5", "#e8590c", "#2b8a3e", "#ae3ec9", "#c92a2a", "#1098ad", "#f08c00", "#495057")


class Panel:
    """All controls of a session.

    Parameters
    ----------
    server : viser.ViserServer
    session : Session
    scene : Scene
        The scene whose gizmos follow targets that are typed.
    folder : Path
        Where recordings are saved.
    """

    def __init__(self, server: viser.ViserServer, session: Session, scene: Scene, folder: Path) -> None:
        self._gui, self._session, self._scene, self._folder = server.gui, session, scene, folder
        self._typed: dict[int, tuple[Any, Any]] = {}
        self.status = self._gui.add_html(status(session))
        self._time()
        tabs = self._gui.add_tab_group()
        with tabs.add_tab("Priorities"):
            self._priorities()
        with tabs.add_tab("Targets"):
            for target in session.targets:
                self._target(target)
            if not session.targets:
                self._gui.add_markdown("No task of this stack has a target in space.")
        with tabs.add_tab("Joints"):
            self.joints = self._gui.add_html(joints(session.controller.robot, session.q))
        with tabs.add_tab("Plots"):
            self._plots()
        scene.moved = self._show_typed
        self._gui.add_markdown(f"Simulated, by the model of its controller; {scene.figure.note}.")

    # Inputs.

    def _on(self, handle: Any, wish: Callable[[], Any]) -> None:
        """Run `wish` between two ticks when the button `handle` is clicked."""

        async def clicked(event: Any) -> None:
            self._session.do(wish)

        handle.on_click(clicked)

    def _changed(self, handle: Any, wish: Callable[[Any], Any]) -> None:
        """Run `wish` between two ticks with the value of the input `handle`, if a page has set it, not this program."""

        async def changed(event: Any) -> None:
            if event.client is not None:
                value = handle.value
                self._session.do(lambda: wish(value))

        handle.on_update(changed)

    def _time(self) -> None:
        session = self._session
        self.clock = self._gui.add_button_group("time", ("pause", "step", "reset"))
        acts = {"pause": lambda: session.pause(session.running), "step": session.step, "reset": session.reset}

        async def clicked(event: Any) -> None:
            session.do(acts[self.clock.value])

        self.clock.on_click(clicked)
        self.speed = self._gui.add_slider("speed of time", 0.05, 2.0, 0.05, 1.0)
        self._changed(self.speed, lambda value: setattr(session, "speed", float(value)))
        self.tape = self._gui.add_button_group("record", ("start", "stop", "save page", "save data"))

        async def taped(event: Any) -> None:
            word = self.tape.value
            session.do(lambda: self.save(word) if word.startswith("save") else session.record(word == "start"))

        self.tape.on_click(taped)

    def save(self, word: str) -> Path:
        """Save the recording under the next free name; a page can choose neither folder nor name.

        `word` is "save page" or "save data". Returns the path.
        """
        ending = ".html" if word == "save page" else ".npz"
        names = (self._folder / f"live-{number}{ending}" for number in range(1, 1000))
        path = next((name for name in names if not name.exists()), None)
        if path is None:
            raise InvalidInput(f"the folder {str(self._folder)!r} holds 999 recordings; clear it")
        self._session.save(path)
        return path

    def _priorities(self) -> None:
        session = self._session
        self.levels = [self._gui.add_button_group("", (UP, DOWN, SWITCH)) for _ in session.priorities.names]
        for place, group in enumerate(self.levels):
            self._level(place, group)
        self._show_order()
        self.reasons = self._gui.add_html(reasons(session))  # below the buttons, which its lines would push about
        most = min(MOST_GAIN, 1.0 / session.motion.dt)
        self.gains: list[tuple[Task, Any]] = []
        with self._gui.add_folder("gains [1/s]", expand_by_default=len(session.tasks) <= 6):
            for task in session.tasks:
                now = float(np.max(task.gain))
                slider = self._gui.add_slider(task.name, 0.1, max(most, now), 0.1, now)
                self._gain(task, slider)
                self.gains.append((task, slider))

    def _gain(self, task: Task, slider: Any) -> None:
        def wish(value: Any) -> None:
            try:
                self._session.set_gain(task, float(value))
            finally:
                slider.value = float(np.max(task.gain))

        self._changed(slider, wish)

    def _level(self, place: int, group: Any) -> None:
        session = self._session

        async def clicked(event: Any) -> None:
            word = group.value

            def wish() -> None:
                if word == SWITCH:
                    session.switch_level(place, not session.priorities.on[place])
                else:
                    session.move_level(place, -1 if word == UP else 1)
                self._show_order()

            session.do(wish)

        group.on_click(clicked)

    def _show_order(self) -> None:
        own = self._session.priorities
        for place, (group, name, on) in enumerate(zip(self.levels, own.names, own.on, strict=True)):
            group.label = f"{place} {name}" if on else f"{place} {name} (off)"

    def _target(self, target: Target) -> None:
        point = turn = None
        if target.point is not None:
            point = self._gui.add_vector3(
                f"{target.name} [m]", _three(target.p), step=0.01, disabled=not target.draggable
            )
            self._changed(point, lambda value: self._type(target, p=np.array(value)))
        if target.turn is not None:
            words = f"{target.name} roll, pitch, yaw [deg]"
            turn = self._gui.add_vector3(words, _three(_rpy(target.R)), step=1.0, disabled=not target.draggable)
            self._changed(turn, lambda value: self._type(target, R=from_rpy(*np.radians(value))))
        self._typed[id(target)] = point, turn

    def _type(self, target: Target, p: Array | None = None, R: Array | None = None) -> None:
        try:
            target.move(p, R)
        finally:
            self._show_typed(target)
            self._scene.put(target)

    def _show_typed(self, target: Target) -> None:
        """Show the numbers of a dragged target; only those that differ are written, or typing would be interrupted."""
        point, turn = self._typed[id(target)]
        for handle, now in (point, target.p), (turn, _rpy(target.R)):
            if handle is not None and np.abs(np.subtract(handle.value, now)).max() > 1e-4:
                handle.value = _three(now)

    # Outputs.

    def _plots(self) -> None:
        session, robot = self._session, self._session.controller.robot
        self._names = list(dict.fromkeys(session.priorities.names))
        empty = np.zeros(1)

        def lines(names: Sequence[str]) -> Any:
            strokes = ({"label": name, "stroke": COLORS[i % 8], "width": 1.5} for i, name in enumerate(names))
            return {"label": "t [s]"}, *strokes

        unit = "m/s, rad/s" if session.controller.order == "velocity" else "m/s², rad/s², N"
        self.residuals, self.speeds = (
            self._gui.add_uplot(
                (empty, *(empty for _ in names)),
                lines(names),
                title=title,
                scales={"x": {"time": False}},
                height=240,
                legend={"show": len(names) <= 12},
            )
            for names, title in (
                (self._names, f"what each level lacks [{unit}], {PLOTTED:g} s"),
                (joint_names(robot), f"joint velocities [{units(robot)}], {PLOTTED:g} s"),
            )
        )

    def show(self) -> None:
        """Update texts, bars and plots."""
        session = self._session
        self.status.content, self.reasons.content = status(session), reasons(session)
        self.joints.content = joints(session.controller.robot, session.q)
        samples = list(session.motion.samples)
        if len(samples) > 1:
            t = np.array([sample.t for sample in samples])
            levels = [np.array([sample.residuals.get(name, np.nan) for sample in samples]) for name in self._names]
            self.residuals.data = (t, *levels)
            self.speeds.data = (t, *np.array([sample.v for sample in samples]).T.copy())


def _three(numbers: Array) -> tuple[float, float, float]:
    x, y, z = (round(float(number), 4) for number in numbers)
    return x, y, z


def _rpy(R: Array) -> Array:
    """Roll, pitch and yaw of a rotation [deg], about the axes of the world in this order."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    return np.degrees([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])
