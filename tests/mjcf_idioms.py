"""How MJCF files say what a robot is: small files, each in one of the ways that are found in the wild."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Idiom:
    """A file, and what is to be made of it.

    Attributes
    ----------
    text : str
        Of the file.
    robot : tuple of str
        The bodies that the robot begins with; everything that the world carries, if none.
    left : tuple of str
        What of the scene is not the robot, and what of the robot its model does not count.
    options : dict
        Of ``load_robot``.
    files : dict
        Path -> text of what lies beside it.
    """

    text: str
    robot: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Refusal:
    """A file that is no robot, and the words of the refusal, each of which must be in it."""

    text: str
    named: tuple[str, ...]
    options: Mapping[str, Any] = field(default_factory=dict)


def arm(name: str = "", at: str = "0 0 0") -> str:
    """Two hinges above a base that stands, and a tip."""
    return f"""
    <body name="{name}base" pos="{at}"><geom type="cylinder" size=".1 .05"/>
      <body name="{name}upper" pos="0 0 .1">
        <joint name="{name}shoulder" axis="0 0 1" range="-100 120"/>
        <geom type="capsule" size=".03" fromto="0 0 0 .4 0 .1"/>
        <body name="{name}lower" pos=".4 0 .1" euler="20 0 10">
          <joint name="{name}elbow" axis="0 1 0" range="-130 20"/>
          <geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/>
          <site name="{name}tip" pos=".3 0 0" euler="0 90 0"/>
        </body>
      </body>
    </body>"""


def gripper(equality: str, left: str = "", right: str = "", head: str = "") -> str:
    """A wrist with two fingers, and what ties the right one to the left one."""
    return f"""<mujoco>{head}<worldbody><body name="palm"><joint name="wrist" axis="0 0 1" range="-90 90"/>
      <geom type="box" size=".05 .1 .02"/>
      <body name="left" pos="0 .02 .05"><joint name="left" type="slide" axis="0 1 0" range="0 .04" {left}/>
        <geom type="box" size=".01 .01 .04" pos=".01 0 .04"/><site name="left_pad" pos="0 0 .07"/></body>
      <body name="right" pos="0 -.02 .05"><joint name="right" type="slide" axis="0 -1 0" {right}/>
        <geom type="box" size=".01 .02 .04" pos="0 .01 .04"/><site name="right_pad" pos="0 0 .07"/></body>
      </body></worldbody><equality>{equality}</equality></mujoco>"""


def two_arms(more: str = "") -> str:
    return f"<mujoco><worldbody>{arm('left_', '0 .3 0')}{arm('right_', '0 -.3 .1')}</worldbody>{more}</mujoco>"


CUBE = '<body name="cube" pos=".5 0 .1"><freejoint name="cube"/><geom type="box" size=".03 .03 .03"/></body>'
BALL_TO_CATCH = '<body name="ball" pos="0 1 1"><freejoint/><geom size=".05"/></body>'
TABLE = '<body name="table" pos=".6 0 .2"><geom type="box" size=".3 .5 .2"/><site name="corner" pos=".3 .5 .2"/></body>'
TARGET = '<body name="target" mocap="true" pos=".5 .2 .5"><geom size=".02" contype="0" conaffinity="0"/></body>'
FLOOR = '<geom name="floor" type="plane" size="5 5 .1"/><light pos="0 0 3"/><camera name="eye" pos="2 0 1"/>'
DOG = """
    <body name="trunk" pos="0 0 .4" euler="0 0 90"><freejoint name="root"/><geom type="box" size=".2 .1 .05"/>
      <site name="imu" pos=".02 0 .03"/>
      <body name="thigh" pos=".2 .1 0"><joint name="hip" axis="0 1 0" range="-60 90"/>
        <geom type="capsule" size=".02" fromto="0 0 0 0 0 -.2"/>
        <body name="calf" pos="0 0 -.2"><joint name="knee" axis="0 1 0" range="-150 -30"/>
          <geom type="capsule" size=".015" fromto="0 0 0 0 0 -.2"/><site name="foot" pos="0 0 -.2"/></body></body>
          </body>"""
TETRAHEDRON = """v 0 0 0\nv .2 0 0\nv 0 .1 0\nv 0 0 .3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"""
GRASPS = """<keyframe><key name="open" qpos="0 .04 .04"/><key name="home" qpos=".3 .01 .01"/></keyframe></mujoco>"""
#: Stands for the same in numbers, which the test packs.
STL = "wedge.stl"
BEADS = "".join(f'<body name="c{i}" pos="0 0 -.1"><joint name="b{i}" type="ball"/><geom size=".02"/>' for i in range(5))
ALONE = f"<worldbody>{arm()}</worldbody>"
TWO_FREE = f"<mujoco><worldbody>{CUBE}{BALL_TO_CATCH}</worldbody></mujoco>"

READ: dict[str, Idiom] = {}

# Angles and ranges.

READ |= {
    "an arm in radian": Idiom("""<mujoco model="arm"><compiler angle="radian"/><worldbody>
      <body name="one" pos="0 0 .3"><joint name="a" axis="0 0 1" range="-2 1.5"/><geom size=".1" pos=".1 0 0"/>
        <body name="two" pos=".3 0 0" quat="0.9 0.1 0.2 0.3"><joint name="b" axis="0 1 0" range="-1 2"/>
          <geom type="box" size=".1 .02 .03"/><site name="tip" pos=".1 .2 .3" quat="1 2 0 0"/></body></body>
      </worldbody></mujoco>"""),
    "degrees, by default": Idiom(f'<mujoco model="arm">{ALONE}</mujoco>'),
    "degrees, by name": Idiom(f'<mujoco><compiler angle="degree"/>{ALONE}</mujoco>'),
    "the compiler comes last": Idiom("""<mujoco><worldbody><body name="one" euler="0 .5 0">
      <joint name="a" axis="0 0 1" range="-2 2"/><geom size=".1"/><site name="tip" pos="1 0 0"/></body></worldbody>
      <compiler angle="radian"/></mujoco>"""),
    "limited where it says so": Idiom("""<mujoco><compiler autolimits="false"/><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" limited="true" range="-20 30"/><geom size=".1"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0" limited="false" range="-20 30"/><geom size=".1"/>
          <site name="tip" pos="0 0 1"/></body></body></worldbody></mujoco>"""),
    "a range that is not one": Idiom("""<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" limited="false" range="-20 30"/><geom size=".1"/>
        <site name="tip" pos="1 0 0"/></body></worldbody></mujoco>"""),
    "a range that a class gives and a joint takes back": Idiom("""<mujoco>
      <default><joint range="-20 30" axis="0 0 1"/></default><worldbody>
      <body name="one"><joint name="a"/><geom size=".1"/><body name="two" pos=".3 0 0">
        <joint name="b" limited="false"/><geom size=".1"/><site name="tip" pos="1 0 0"/></body></body>
      </worldbody></mujoco>"""),
    "a slide in a file of degrees": Idiom("""<mujoco><compiler angle="degree"/><worldbody>
      <body name="cart"><joint name="rail" type="slide" axis="1 0 0" range="-1.5 2"/><geom type="box" size=".1 .1 .1"/>
        <body name="pole"><joint name="pin" axis="0 1 0" range="-90 90"/>
          <geom type="capsule" size=".02" fromto="0 0 0 0 0 1"/><site name="tip" pos="0 0 1"/></body></body>
      </worldbody></mujoco>"""),
    "a slide with the range of its class": Idiom("""<mujoco>
      <default><default class="rail"><joint type="slide" axis="0 1 0" range="-.2 .7"/></default></default><worldbody>
      <body name="cart"><joint name="rail" class="rail"/><geom type="box" size=".1 .1 .1"/></body></worldbody>
      </mujoco>"""),
    "a range beyond half a turn": Idiom("""<mujoco><compiler angle="radian"/><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-6.2 6.2"/><geom size=".1"/><body name="two" pos=".3 0 0">
        <joint name="b" axis="0 1 0" range="3.5 9"/><geom size=".1"/><site name="tip" pos="1 0 0"/></body></body>
      </worldbody></mujoco>"""),
    "a start outside the range": Idiom("""<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="20 80"/><geom size=".1"/><body name="two" pos=".3 0 0">
        <joint name="b" type="slide" axis="0 1 0" range="-.5 -.1"/><geom size=".1"/></body></body></worldbody>
        </mujoco>"""),
    "a wheel without end": Idiom("""<mujoco><worldbody>
      <body name="fork"><joint name="steer" axis="0 0 1" range="-40 40"/><geom size=".1"/>
        <body name="wheel" pos="0 0 -.3"><joint name="roll" axis="0 1 0"/>
          <geom type="cylinder" size=".1 .02" euler="90 0 0"/><site name="valve" pos=".08 0 0"/></body></body>
      </worldbody></mujoco>"""),
    "axes that are tilted, turned round and long": Idiom("""<mujoco><worldbody>
      <body name="one" euler="10 20 30"><joint name="a" axis="1 2 3" range="-90 90"/><geom size=".1" pos="0 .1 0"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 -1 0" range="-90 90"/><geom size=".1"/>
          <body name="three" pos="0 .3 0"><joint name="c" type="slide" axis="0 -5 1" range="-1 1"/><geom size=".1"/>
            <site name="tip" pos="0 .2 .1"/></body></body></body></worldbody></mujoco>"""),
    "an axis that nobody gave": Idiom("""<mujoco><worldbody><body name="one"><joint name="a" range="-90 90"/>
      <geom size=".1" pos=".2 0 0"/></body></worldbody></mujoco>"""),
}

# Defaults.

READ |= {
    "classes in classes, and a childclass": Idiom("""<mujoco><default>
        <geom density="500"/><joint axis="0 1 0" armature=".1"/>
        <default class="robot"><joint range="-50 60"/>
          <default class="elbow"><joint range="-1 140" axis="0 0 1"/><geom type="box" size=".1 .02 .02"/></default>
          <default class="finger"><joint type="slide" range="0 .04"/></default></default></default>
      <worldbody><body name="one" childclass="robot"><joint name="a"/><geom size=".1" pos=".1 0 0"/>
        <body name="two" pos=".3 0 0"><joint name="b" class="elbow"/><geom class="elbow"/>
          <body name="three" pos=".2 0 0" childclass="finger"><joint name="c"/><geom size=".02"/>
            <body name="four" pos=".05 0 0"><joint name="d" class="robot"/><geom size=".02"/>
              <site name="tip" pos=".1 0 0"/></body></body></body></body></worldbody></mujoco>"""),
    "several defaults": Idiom("""<mujoco><default><joint axis="0 1 0"/></default>
      <default><geom type="capsule" size=".05 .2"/></default><default><default class="z"><joint axis="0 0 1"/>
      </default></default>
      <worldbody><body name="one"><joint name="a" range="-30 30"/><geom/><body name="two" pos="0 0 .4">
        <joint name="b" class="z" range="-30 30"/><geom pos=".1 0 0"/></body></body></worldbody></mujoco>"""),
    "the main class by its name": Idiom("""<mujoco><default class="main"><joint axis="1 0 0" ref="10" range="-30 40"/>
      <default class="back"><joint axis="-1 0 0"/></default></default><worldbody>
      <body name="one"><joint name="a"/><geom size=".1" pos="0 .1 0"/><body name="two" pos="0 .2 0">
        <joint name="b" class="back"/><geom size=".1" pos="0 .1 0"/></body></body></worldbody></mujoco>"""),
    "an anchor from a class": Idiom("""<mujoco><default><joint pos="0 .1 .2" axis="0 1 0" range="-90 90"/></default>
      <worldbody>
      <body name="one" pos="0 0 1"><joint name="a"/><geom size=".1"/><body name="two" pos=".3 0 0">
        <joint name="b" axis="1 0 1"/><geom size=".1"/><site name="tip" pos=".2 0 0"/></body></body></worldbody>
        </mujoco>"""),
    "sites from classes": Idiom("""<mujoco><default><site size=".02"/>
      <default class="turned"><site quat=".7 .1 .2 .3" pos=".1 .2 .3"/></default>
      <default class="euler"><site euler="10 20 30" pos="0 0 1"/></default>
      <default class="line"><site type="capsule" size=".01" fromto="0 0 0 .3 .2 .1"/></default></default>
      <worldbody><body name="one" pos="0 0 .2"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1"/>
        <site name="s0"/><site name="s1" class="turned"/><site name="s2" class="euler"/><site name="s3" class="line"/>
        <site name="s4" class="turned" pos="1 0 0"/></body></worldbody></mujoco>"""),
}

# Places.

READ |= {
    "euler angles in another order": Idiom("""<mujoco><compiler eulerseq="ZYX" angle="radian"/><worldbody>
      <body name="one" euler=".1 .2 .3"><joint name="a" axis="0 0 1" range="-1 1"/><geom size=".1" pos=".2 0 0"/>
        <body name="two" pos=".3 0 0" euler="-.5 .4 1"><joint name="b" axis="0 1 0" range="-1 1"/><geom size=".1"/>
          <site name="tip" pos=".1 .2 .3" euler="1 2 3"/></body></body></worldbody></mujoco>"""),
    "an axis and an angle": Idiom("""<mujoco><worldbody>
      <body name="one" axisangle="1 1 0 40"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".2 0 0"/>
        <body name="two" pos=".3 0 0" axisangle="0 0 2 -70"><joint name="b" axis="0 1 0" range="-90 90"/>
          <geom size=".1"/><site name="tip" axisangle="0 1 0 90"/></body></body></worldbody></mujoco>"""),
    "two axes, or one": Idiom("""<mujoco><worldbody>
      <body name="one" xyaxes="0 1 0 -1 0 .3"><joint name="a" axis="0 0 1" range="-90 90"/>
      <geom size=".1" pos=".2 0 0"/>
        <body name="two" pos=".3 0 0" zaxis="1 0 1"><joint name="b" axis="0 1 0" range="-90 90"/><geom size=".1"/>
          <site name="tip" zaxis="0 1 0"/><site name="side" xyaxes="0 0 1 0 1 0"/></body></body></worldbody>
          </mujoco>"""),
    "quaternions of any length": Idiom("""<mujoco><worldbody>
      <body name="one" quat="1 1 0 0"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".2 0 0"/>
        <body name="two" pos=".3 0 0" quat="3 0 -4 1"><joint name="b" axis="0 1 0" range="-90 90"/><geom size=".1"/>
          <site name="tip" quat="0 0 0 2"/></body></body></worldbody></mujoco>"""),
    "from here to there": Idiom("""<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90"/>
      <geom type="cylinder" size=".02" fromto="0 0 0 .3 .1 .2"/>
        <site name="along" type="capsule" size=".01" fromto="0 0 0 .3 .1 .2"/></body></worldbody></mujoco>"""),
    "frames in frames": Idiom("""<mujoco><default><default class="robot"><joint axis="0 1 0" range="-70 80"/></default>
        <default class="z"><joint axis="0 0 1"/></default></default><worldbody>
      <frame pos="1 0 0" euler="0 0 90"><frame pos="0 1 0" quat="1 1 0 0" childclass="robot">
        <body name="one"><joint name="a"/><geom size=".1" pos=".2 0 0"/>
          <frame name="inside" pos=".3 0 0" axisangle="0 1 0 30"><site name="elbow"/><geom size=".05"/>
            <body name="two" pos="0 .1 0"><frame childclass="z"><joint name="b" range="-10 20"/></frame>
            <geom size=".1"/>
              <site name="tip" pos=".2 0 0"/></body></frame></body></frame></frame></worldbody></mujoco>"""),
    "a joint inside of a frame": Idiom("""<mujoco><worldbody><body name="one" pos="0 0 1">
      <frame pos=".1 .2 .3" euler="30 40 50"><joint name="a" axis="0 0 1" pos=".1 0 0" range="-90 90"/></frame>
      <geom size=".1"/><site name="tip" pos="0 .5 0"/></body></worldbody></mujoco>"""),
    "two worldbodies": Idiom(f"<mujoco><worldbody>{FLOOR}</worldbody>{ALONE}</mujoco>"),
    "anchors away from the bodies": Idiom("""<mujoco><worldbody>
      <body name="one" pos="0 0 1" euler="0 0 45"><joint name="a" axis="0 0 1" pos=".1 .2 .3" range="-90 90"/>
        <geom size=".1"/><body name="two" pos=".3 0 0" euler="90 0 0">
          <joint name="b" axis="0 1 1" pos="-.2 0 .1" range="-90 90"/><geom size=".1"/>
          <site name="tip" pos=".1 .2 .3"/></body></body></worldbody></mujoco>"""),
    "an anchor of a slide": Idiom("""<mujoco><worldbody><body name="one" pos="0 0 1">
      <joint name="a" type="slide" axis="0 1 1" pos="1 2 3" range="-1 1"/><geom size=".1"/></body></worldbody>
      </mujoco>"""),
    "a reference": Idiom("""<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" ref="30" range="-60 90"/><geom size=".1" pos=".2 0 0"/>
        <body name="two" pos=".3 0 0"><joint name="b" type="slide" axis="0 1 0" ref=".2" range="-.1 .5"/>
        <geom size=".1"/>
          <body name="three" pos="0 .1 0"><joint name="c" axis="1 0 0" ref="-45" pos="0 .1 0"/><geom size=".1"/>
            <site name="tip" pos="0 0 .3"/></body></body></body></worldbody></mujoco>"""),
    "a spring that rests elsewhere": Idiom(
        """<mujoco><worldbody>
      <body name="one"><joint name="sprung" axis="0 0 1" stiffness="10" springref="30" range="-60 90"/>
        <geom size=".1" pos=".2 0 0"/></body></worldbody></mujoco>""",
        left=("sprung",),
    ),
    "a base that stands, turned": Idiom("""<mujoco><worldbody>
      <body name="base" pos="1 2 3" euler="30 40 50"><geom size=".1"/><site name="plate" pos="0 0 .1" euler="0 0 45"/>
        <body name="one" pos="0 0 .1"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".2 0 0"/>
          <site name="tip" pos=".3 0 0"/></body></body></worldbody></mujoco>"""),
    "bodies that only hold others": Idiom("""<mujoco><worldbody>
      <body name="base"><body name="riser" pos="0 0 .5"><body name="flange" euler="0 90 0"><body name="one">
        <joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".2 0 0"/>
        <body name="plate" pos=".3 0 0"><body name="tool" pos="0 0 .1" euler="0 0 45">
          <body name="tcp" pos="0 0 .1"><site name="tip"/></body></body></body></body></body></body></body>
      </worldbody></mujoco>"""),
}

# Masses.

READ |= {
    "meshes": Idiom(
        """<mujoco><asset><mesh name="wedge" file="wedge.obj"/><mesh name="big" file="wedge.obj" scale="2 1 -1"/>
          </asset>
      <worldbody><body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom type="mesh" mesh="wedge"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0" range="-90 90"/>
          <geom type="mesh" mesh="big" mass="2" pos=".1 0 0" euler="10 20 30"/></body></body></worldbody></mujoco>""",
        files={"wedge.obj": TETRAHEDRON},
    ),
    "meshes in a folder": Idiom(
        f"""<mujoco><compiler meshdir="assets/meshes"/><asset><mesh file="wedge.obj"/><mesh name="stl" file="{STL}"/>
          </asset>
      <worldbody><body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom type="mesh" mesh="wedge"/>
        <geom type="mesh" mesh="stl" pos=".2 0 0"/></body></worldbody></mujoco>""",
        files={"assets/meshes/wedge.obj": TETRAHEDRON, f"assets/meshes/{STL}": STL},
    ),
    "a mesh of numbers, hollow": Idiom("""<mujoco><asset>
        <mesh name="wedge" vertex="0 0 0 .2 0 0 0 .1 0 0 0 .3" inertia="shell" refpos=".1 0 0"/></asset>
      <worldbody><body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom type="mesh" mesh="wedge"/></body>
      </worldbody></mujoco>"""),
    "shapes with masses and densities": Idiom("""<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" mass="2" pos=".1 0 0"/>
        <geom type="box" size=".1 .1 .2" density="300" euler="0 30 0"/><geom size=".1" mass="0"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0" range="-90 90"/>
          <geom type="ellipsoid" size=".1 .2 .3" density="100"/>
          <geom type="cylinder" size=".05 .1" shellinertia="true"/>
        </body></body></worldbody></mujoco>"""),
    "inertias from shapes, whatever is written": Idiom("""<mujoco><compiler inertiafromgeom="true"/><worldbody>
      <body name="one"><inertial pos="1 2 3" mass="77" diaginertia="1 1 1"/>
      <joint name="a" axis="0 0 1" range="-90 90"/>
        <geom size=".1" pos=".1 0 0"/></body></worldbody></mujoco>"""),
    "inertias from some of the shapes": Idiom("""<mujoco><compiler inertiafromgeom="true" inertiagrouprange="3 4"/>
      <worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".1 0 0" group="3"/>
        <geom size=".3" group="1"/></body></worldbody></mujoco>"""),
    "inertias as written": Idiom("""<mujoco><compiler inertiafromgeom="false"/><worldbody>
      <body name="one"><inertial pos=".1 .2 .3" mass="2" diaginertia=".02 .03 .04" euler="10 20 30"/>
        <joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1"/>
        <body name="two" pos=".3 0 0"><inertial pos="0 .1 0" mass="3" fullinertia=".05 .06 .07 .003 .002 .001"/>
          <joint name="b" axis="0 1 0" range="-90 90"/><geom size=".1"/></body></body></worldbody></mujoco>"""),
    "one mass for all": Idiom(f'<mujoco><compiler settotalmass="12.5"/>{ALONE}</mujoco>'),
    "masses that are at least so large": Idiom("""<mujoco><compiler boundmass=".5" boundinertia=".01"/><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".01"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0" range="-90 90"/></body></body></worldbody>
        </mujoco>"""),
    "inertias put right": Idiom("""<mujoco><compiler balanceinertia="true"/><worldbody>
      <body name="one"><inertial pos=".1 0 0" mass="1" diaginertia=".1 .01 .01"/>
        <joint name="a" axis="0 1 0" range="-90 90"/></body></worldbody></mujoco>"""),
    "motors with inertia and friction": Idiom("""<mujoco><default><joint armature=".02"/></default><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90" damping="3" frictionloss=".2"/><geom size=".1"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0" range="-90 90" armature="1.5"/><geom size=".1"/>
        </body></body></worldbody></mujoco>"""),
    "shapes that are only seen": Idiom("""<mujoco><compiler discardvisual="true"/><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1" pos=".1 0 0"/>
        <geom type="box" size=".1 .1 .2" contype="0" conaffinity="0"/></body></worldbody></mujoco>"""),
    "weight that is carried": Idiom(
        """<mujoco><worldbody><body name="lifted" gravcomp="1">
      <joint name="a" axis="0 1 0" range="-90 90"/><geom size=".1" pos=".1 0 0"/></body></worldbody></mujoco>""",
        left=("lifted",),
    ),
}

# Several joints in a body.

READ |= {
    "two hinges with anchors of their own": Idiom("""<mujoco><worldbody>
      <body name="hand" pos="0 0 1" euler="0 20 0"><joint name="a" axis="0 0 1" pos=".1 0 0" range="-90 90"/>
        <joint name="b" axis="0 1 0" pos="0 .2 .1" range="-60 60"/><geom type="box" size=".1 .2 .3" pos=".1 0 0"/>
        <site name="tip" pos=".3 .2 .1"/></body></worldbody></mujoco>"""),
    "a slide and a hinge": Idiom("""<mujoco><worldbody>
      <body name="cart" euler="0 0 30"><joint name="a" type="slide" axis="1 0 0" range="-1 1"/>
        <joint name="b" axis="0 0 1" pos=".1 0 0" range="-60 60"/><geom type="box" size=".1 .2 .3" pos=".1 0 0"/>
        <site name="tip" pos=".3 .2 .1"/></body></worldbody></mujoco>"""),
    "a hinge and a slide": Idiom("""<mujoco><worldbody>
      <body name="turret" euler="0 0 30"><joint name="b" axis="0 0 1" pos=".1 0 0" range="-60 60" ref="15"/>
        <joint name="a" type="slide" axis="1 0 0" range="-1 1" ref=".1"/><geom type="box" size=".1 .2 .3" pos=".1 0 0"/>
        <site name="tip" pos=".3 .2 .1"/></body></worldbody></mujoco>"""),
    "a hip of three hinges": Idiom("""<mujoco><worldbody><body name="pelvis" pos="0 0 1"><geom size=".1"/>
      <body name="thigh" pos="0 .1 0"><joint name="hip_x" axis="1 0 0" range="-30 10" armature=".01"/>
        <joint name="hip_z" axis="0 0 1" range="-60 35"/><joint name="hip_y" axis="0 1 0" range="-110 20"/>
        <geom type="capsule" size=".06" fromto="0 0 0 0 .01 -.34"/>
        <body name="shin" pos="0 .01 -.4"><joint name="knee" pos="0 0 .02" axis="0 -1 0" range="-160 -2"/>
          <geom type="capsule" size=".05" fromto="0 0 0 0 0 -.3"/><site name="foot" pos="0 0 -.4"/></body></body></body>
      </worldbody></mujoco>"""),
    "three slides and three hinges": Idiom("""<mujoco><worldbody><body name="vessel" pos="0 0 1" euler="0 0 20">
      <joint name="x" type="slide" axis="1 0 0" range="-3 3"/><joint name="y" type="slide" axis="0 1 0" range="-3 3"/>
      <joint name="z" type="slide" axis="0 0 1"/><joint name="roll" axis="1 0 0" range="-40 40"/>
      <joint name="pitch" axis="0 1 0" range="-40 40"/><joint name="yaw" axis="0 0 1"/>
      <geom type="box" size=".3 .2 .1" pos=".05 0 0"/><site name="bow" pos=".3 0 0"/></body></worldbody></mujoco>"""),
    "an arm on a base that drives in the plane": Idiom("""<mujoco><worldbody><body name="cart" pos="0 0 .1">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
      <joint name="yaw" axis="0 0 1"/>
      <geom type="box" size=".3 .2 .1"/><body name="upper" pos=".2 0 .1">
      <joint name="shoulder" axis="0 1 0" range="-90 90"/>
        <geom type="capsule" size=".02" fromto="0 0 0 0 0 .3"/><site name="tip" pos="0 0 .3"/></body></body>
      </worldbody></mujoco>"""),
}

# Joints that are more than a number.

READ |= {
    "a ball joint": Idiom("""<mujoco><worldbody><body name="one" pos="0 0 1" euler="10 20 30">
      <joint name="ball" type="ball" pos=".1 .2 0"/><geom type="box" size=".1 .2 .3" pos=".1 0 0"/>
      <site name="tip" pos="0 .3 0"/></body></worldbody></mujoco>"""),
    "a tree of balls and hinges": Idiom("""<mujoco><worldbody><body name="torso" pos="0 0 1"><geom size=".2"/>
      <body name="left_arm" pos="0 .2 0"><joint name="left_shoulder" type="ball" armature=".03"/>
        <geom type="capsule" size=".03" fromto="0 0 0 .1 .3 0"/>
        <body name="left_hand" pos=".1 .3 0"><joint name="left_elbow" axis="0 0 1" range="0 150"/>
        <geom size=".05" pos=".1 0 0"/>
          <site name="left_tip" pos=".2 0 0"/></body></body>
      <body name="right_arm" pos="0 -.2 0"><joint name="right_elbow" axis="0 0 1" range="-150 0"/>
        <geom type="capsule" size=".03" fromto="0 0 0 .1 -.3 0"/>
        <body name="right_hand" pos=".1 -.3 0" quat="1 0 1 0"><joint name="right_wrist" type="ball"/>
        <geom size=".05" pos=".1 0 0"/>
          <site name="right_tip" pos=".2 0 0"/></body></body></body></worldbody></mujoco>"""),
    "slides and a ball in one body": Idiom("""<mujoco><worldbody><body name="one" euler="0 0 30">
      <joint name="x" type="slide" axis="1 0 0" range="-1 1"/><joint name="z" type="slide" axis="0 0 1" range="-1 1"/>
      <joint name="turn" type="ball" pos="0 .1 0"/><geom type="box" size=".1 .2 .3" pos=".1 0 0"/>
      <site name="tip" pos="0 .3 0"/>
      </body></worldbody></mujoco>"""),
    "a free base": Idiom(f"<mujoco><worldbody>{FLOOR}{DOG}</worldbody></mujoco>"),
    "a free base that is a joint": Idiom("""<mujoco><default><joint armature=".1" range="-1 1"/></default><worldbody>
      <body name="trunk" pos="1 2 3" quat="1 2 3 4"><joint name="root" type="free" limited="false"/>
      <geom size=".2" pos=".1 0 0"/>
        <body name="arm" pos=".3 0 0"><joint name="shoulder" axis="0 1 0" range="-90 90"/>
        <geom size=".05" pos=".1 0 0"/>
          <site name="tip" pos=".2 0 0"/></body></body></worldbody></mujoco>"""),
    "a drone": Idiom(f"""<mujoco><worldbody>{FLOOR}<body name="drone" pos="0 0 .1"><freejoint/>
      <geom type="box" size=".1 .1 .02"/>
      <site name="rotor" pos=".1 .1 .02"/><body name="camera" pos=".1 0 -.02" euler="0 30 0"><geom size=".02"/>
      </body></body>
      </worldbody></mujoco>"""),
    "a free base with keyframes": Idiom(f"""<mujoco><worldbody>{DOG}</worldbody><keyframe>
      <key name="stand" qpos="0 0 .3 1 0 0 0 .5 -1"/><key name="lie" qpos="1 2 .1 .5 .5 -.5 .5 1 -2.5"/></keyframe>
      </mujoco>"""),
}

# Scenes.

READ |= {
    "a target that the mouse drags": Idiom(
        f"<mujoco><worldbody>{TARGET}{arm()}</worldbody></mujoco>", robot=("base",), left=("target",)
    ),
    "a hand tied to what the mouse drags": Idiom(
        f"""<mujoco><worldbody>{arm()}{TARGET}</worldbody><equality>
        <weld name="drag" body1="target" body2="lower"/></equality></mujoco>""",
        robot=("base",),
        left=("target",),
    ),
    "a cube first": Idiom(f"<mujoco><worldbody>{CUBE}{arm()}</worldbody></mujoco>", robot=("base",), left=("cube",)),
    "cubes on both sides": Idiom(
        f"<mujoco><worldbody>{CUBE}{arm()}{BALL_TO_CATCH}</worldbody></mujoco>", robot=("base",), left=("cube", "ball")
    ),
    "a dog and a ball": Idiom(
        f"<mujoco><worldbody>{BALL_TO_CATCH}{DOG}</worldbody></mujoco>", robot=("trunk",), left=("ball",)
    ),
    "a table first": Idiom(f"<mujoco><worldbody>{TABLE}{arm()}</worldbody></mujoco>", robot=("base",), left=("table",)),
    "a drone and a landing place": Idiom(
        f"""<mujoco><worldbody>{TABLE}<body name="drone" pos="0 0 1" euler="0 0 90"><freejoint name="fly"/>
          <geom size=".1"/>
        </body></worldbody></mujoco>""",
        robot=("drone",),
        left=("table",),
    ),
    "a whole scene": Idiom(
        f"<mujoco><worldbody>{FLOOR}{TABLE}{CUBE}{TARGET}{arm('', '0 0 .4')}{BALL_TO_CATCH}</worldbody></mujoco>",
        robot=("base",),
        left=("table", "cube", "target", "ball"),
    ),
    "a scene that includes the robot": Idiom(
        f'<mujoco model="scene"><include file="arm.xml"/><worldbody>{FLOOR}{TABLE}</worldbody></mujoco>',
        robot=("base",),
        left=("table",),
        files={"arm.xml": f'<mujoco model="arm"><compiler angle="degree"/>{ALONE}</mujoco>'},
    ),
    "parts that are included": Idiom(
        """<mujoco><include file="parts/defaults.xml"/><worldbody><body name="one"><include file="parts/links.xml"/>
        <geom size=".1"/></body></worldbody></mujoco>""",
        files={
            "parts/defaults.xml": """<x><compiler angle="radian"/>
              <default><joint axis="0 1 0" range="-1 2"/></default></x>""",
            "parts/links.xml": """<x><joint name="a"/><body name="two" pos=".3 0 0"><joint name="b"/><geom size=".1"/>
              <site name="tip"/></body></x>""",
        },
    ),
    "the right one of two arms": Idiom(
        two_arms(), robot=("right_base",), left=("left_",), options={"body": "right_base"}
    ),
    "both of two arms": Idiom(
        two_arms(), robot=("left_base", "right_base"), options={"body": ["left_base", "right_base"]}
    ),
    "an arm among what is not chosen": Idiom(
        f"<mujoco><worldbody>{CUBE}{arm('left_')}{TABLE}{arm('right_', '1 0 0')}</worldbody></mujoco>",
        robot=("left_base",),
        left=("cube", "table", "right_"),
        options={"body": "left_base"},
    ),
    "the second of two dogs": Idiom(
        f"""<mujoco><worldbody>{DOG}<body name="cat" pos="1 0 .2"><freejoint name="paws"/><geom size=".1"/>
        <body name="tail" pos="-.1 0 0"><joint name="wag" axis="0 0 1" range="-50 50"/><geom size=".02" pos="-.1 0 0"/>
        <site name="end" pos="-.2 0 0"/></body></body></worldbody></mujoco>""",
        robot=("cat",),
        left=("trunk",),
        options={"body": "cat"},
    ),
    "an arm on what is moved by hand": Idiom(f"""<mujoco><worldbody><body name="cart" mocap="true" pos=".2 0 .4"
      euler="0 0 30"><geom type="box" size=".3 .5 .2"/>{arm("", "0 0 .2")}</body></worldbody></mujoco>"""),
    "an arm on a table": Idiom(f"""<mujoco><worldbody><body name="table" pos=".2 0 .4" euler="0 0 30">
      <geom type="box" size=".3 .5 .2"/>{arm("", "0 0 .2")}</body></worldbody></mujoco>"""),
    "an arm on a table, by its name": Idiom(
        f"""<mujoco><worldbody><body name="table" pos=".2 0 .4" euler="0 0 30"><geom type="box" size=".3 .5 .2"/>
        {arm("", "0 0 .2")}</body></worldbody></mujoco>""",
        robot=("base",),
        options={"body": "base"},
    ),
    "one of two arms on a table": Idiom(
        f"""<mujoco><worldbody><body name="table" pos=".2 0 .4" euler="0 0 30"><geom type="box" size=".3 .5 .2"/>
        {arm("left_", "0 .3 .2")}{arm("right_", "0 -.3 .2")}</body></worldbody></mujoco>""",
        robot=("right_base",),
        left=("left_",),
        options={"body": "right_base"},
    ),
    "two arms on one trunk": Idiom(f"""<mujoco><worldbody><body name="trunk" pos="0 0 1"><geom size=".1"/>
      {arm("left_", "0 .3 .2")}{arm("right_", "0 -.3 .2")}</body></worldbody></mujoco>"""),
    "keyframes of two robots": Idiom(
        two_arms('<keyframe><key name="home" qpos=".1 .2 .3 -.4"/><key name="up" qpos=".5 -.6 .7 -.8"/></keyframe>'),
        robot=("right_base",),
        options={"body": "right_base"},
    ),
    "what is tied is not the robot": Idiom(
        f"""<mujoco><worldbody>{arm()}{CUBE}{BALL_TO_CATCH}</worldbody><equality>
        <connect body1="cube" body2="ball" anchor="0 0 0"/><weld body1="cube"/></equality></mujoco>""",
        robot=("base",),
        left=("cube", "ball"),
    ),
}

# Joints that are tied.

READ |= {
    "a finger that is held": Idiom(gripper('<joint joint1="right" joint2="left"/>')),
    "a finger that follows": Idiom(
        gripper('<joint joint1="right" joint2="left" polycoef="0 1 0 0 0"/>'), options={"mimic": "follow"}
    ),
    "a finger that follows from a reference": Idiom(
        gripper('<joint joint1="right" joint2="left" polycoef=".003 .8 0 0 0"/>', left='ref=".01"', right='ref="-.02"'),
        options={"mimic": "follow"},
    ),
    "a finger that is held where a reference puts it": Idiom(
        gripper('<joint joint1="right" joint2="left" polycoef=".003 .8 0 0 0"/>', left='ref=".01"', right='ref="-.02"'),
    ),
    "a finger that is held by what begins outside its range": Idiom(
        gripper(
            '<joint joint1="right" joint2="left" polycoef="0 -2 0 0 0"/>',
            head='<default><joint armature=".01"/></default>',
        ).replace('range="0 .04"', 'range=".01 .04"')
    ),
    "a finger that follows within a range of its own": Idiom(
        gripper('<joint joint1="right" joint2="left"/>', right='range=".01 .025"'), options={"mimic": "follow"}
    ),
    "a finger that is held within a range of its own": Idiom(
        gripper('<joint joint1="right" joint2="left"/>', right='range=".01 .025"')
    ),
    "keyframes and a finger that follows": Idiom(
        gripper('<joint joint1="right" joint2="left"/>').replace("</mujoco>", GRASPS), options={"mimic": "follow"}
    ),
    "keyframes and a finger that is held": Idiom(
        gripper('<joint joint1="right" joint2="left"/>').replace("</mujoco>", GRASPS)
    ),
    "a finger that is free after all": Idiom(
        gripper('<joint joint1="right" joint2="left" polycoef="0 1 0 0 0"/>'), options={"mimic": "free"}
    ),
    "a tie that is off": Idiom(gripper('<joint joint1="right" joint2="left" active="false" polycoef="0 1 1 1 0"/>')),
    "ties that are off": Idiom(f"""<mujoco>{ALONE}<equality><weld body1="lower" active="false"/>
      <connect body1="upper" body2="lower" anchor="0 0 0" active="false"/></equality></mujoco>"""),
    "a joint tied to a number": Idiom(gripper('<joint joint1="right" polycoef=".02 0 0 0 0"/>')),
    "a finger whose joints follow one another": Idiom(
        """<mujoco><default><joint axis="0 1 0" armature=".01"/>
          <geom type="capsule" size=".01" fromto="0 0 0 .05 0 0"/></default>
        <worldbody><body name="one"><joint name="a" range="0 60"/><geom/><body name="two" pos=".05 0 0">
        <joint name="b"/><geom/>
        <body name="three" pos=".05 0 0"><joint name="c"/><geom/><site name="tip" pos=".05 0 0"/></body></body>
        </body></worldbody>
        <equality><joint joint1="b" joint2="a" polycoef="0 .9 0 0 0"/>
        <joint joint1="c" joint2="b" polycoef=".1 .8 0 0 0"/>
        </equality></mujoco>""",
        options={"mimic": "follow"},
    ),
    "a slide that follows a hinge": Idiom(
        """<mujoco><worldbody><body name="screw"><joint name="turn" axis="0 0 1" range="-720 720"/><geom size=".1"/>
          </body>
        <body name="nut" pos=".3 0 0"><joint name="move" type="slide" axis="0 0 1"/><geom size=".1"/>
        <site name="tip"/></body>
        </worldbody><equality><joint joint1="move" joint2="turn" polycoef="0 .01 0 0 0"/></equality></mujoco>""",
        robot=("screw", "nut"),
        options={"mimic": "follow", "body": ("screw", "nut")},
    ),
    "a finger that follows one which comes later": Idiom(
        gripper('<joint joint1="left" joint2="right" polycoef=".01 1 0 0 0"/>', right='range="-.01 .03"'),
        options={"mimic": "follow"},
    ),
}

# Names.

READ |= {
    "nothing has a name": Idiom("""<mujoco><worldbody><body><geom size=".1"/><body pos="0 0 .1">
      <joint axis="0 0 1" range="-90 90"/>
      <geom size=".1"/><site/><body pos=".3 0 0"><joint axis="0 1 0" range="-90 90"/><joint type="slide" range="-1 1"/>
      <geom size=".1"/><site/><body pos=".1 0 0"><joint type="ball"/><geom size=".1"/></body></body></body></body>
      </worldbody></mujoco>"""),
    "one name for a body, a joint and a site": Idiom("""<mujoco><worldbody><body name="one" pos="0 0 .1">
      <joint name="one" axis="0 0 1" pos=".1 0 0" range="-90 90"/><geom name="one" size=".1"/>
      <site name="one" pos="0 .2 0"/>
      <body name="two" pos=".3 0 0"><joint name="tip" axis="0 1 0" pos=".1 0 0" range="-90 90"/><geom size=".1"/>
        <site name="tip" pos="0 0 .4"/></body></body></worldbody></mujoco>"""),
    "names that Pinocchio has taken": Idiom("""<mujoco><worldbody><body name="universe" pos="0 0 .1">
      <joint name="a" axis="0 0 1" range="-90 90"/><geom size=".1"/><site name="universe" pos="0 .2 0"/>
      <body name="root_joint" pos=".3 0 0"><joint name="root_joint" axis="0 1 0" range="-90 90"/><geom size=".1"/>
        </body></body></worldbody></mujoco>"""),
    "a name that looks like one for a joint without": Idiom("""<mujoco><worldbody><body name="body2">
      <joint axis="1 0 0" range="-90 90"/><geom size=".1"/><body name="body 2"><joint range="-90 90"/><geom size=".1"/>
      <body><joint range="-90 90"/><geom size=".1"/></body></body></body></worldbody></mujoco>"""),
    "a base without a name, and a joint with one": Idiom("""<mujoco><worldbody><body name="trunk"><freejoint/>
      <geom size=".1"/><body name="head"><joint name="root_joint" range="-90 90"/><geom size=".1" pos=".1 0 0"/></body>
      </body></worldbody></mujoco>"""),
    "names of other letters": Idiom("""<mujoco><worldbody><body name="robot/link 1" pos="0 0 .1">
      <joint name="robot/joint[1]" axis="0 0 1" range="-90 90"/><geom size=".1"/>
      <site name="robot/größe:1" pos="0 .2 0"/>
      </body></worldbody></mujoco>"""),
    "comments with lines of dashes": Idiom(f"""<!-- -------- my arm -------- -->
<mujoco model="arm"><!-- ---- links -- and joints ---->{ALONE}</mujoco>"""),
    "an empty line before everything": Idiom(f"""
<?xml version="1.0"?>
<mujoco model="arm">{ALONE}</mujoco>"""),
    "a bare ampersand": Idiom(f'<mujoco model="arm & hand">{ALONE}</mujoco>'),
    "a head before the robot": Idiom(f"""<?xml version="1.0" encoding="utf-8"?>
<!-- <robot name="of another kind"/> -->

<mujoco model="arm"><!-- a comment -->{ALONE}</mujoco>
"""),
}

# What repeats, and what is put together.

READ |= {
    "fingers that repeat": Idiom("""<mujoco><worldbody><body name="palm">
      <joint name="wrist" axis="0 0 1" range="-90 90"/>
      <geom size=".1"/><replicate count="3" euler="0 0 120" sep="_"><body name="finger" pos=".1 0 0">
        <joint name="flex" axis="0 1 0" range="0 80"/><geom type="capsule" size=".01" fromto="0 0 0 .1 0 0"/>
        <site name="pad" pos=".1 0 0"/></body></replicate></body></worldbody></mujoco>"""),
    "arms that are attached": Idiom(
        """<mujoco><asset><model name="arm" file="arm.xml"/></asset><worldbody><body name="trunk" pos="0 0 1">
        <joint name="yaw" axis="0 0 1" range="-90 90"/><geom size=".1"/>
        <frame pos="0 .2 0" euler="-90 0 0"><attach model="arm" body="base" prefix="left/"/></frame>
        <frame pos="0 -.2 0" euler="90 0 0"><attach model="arm" body="base" prefix="right/"/></frame></body>
        </worldbody></mujoco>""",
        files={"arm.xml": f"<mujoco>{ALONE}</mujoco>"},
    ),
    "a cloth beside the arm": Idiom(
        f"""<mujoco><worldbody>
          <flexcomp name="cloth" type="grid" dim="2" count="3 3 1" spacing=".1 .1 .1" pos="0 0 1" mass=".1"
        radius=".01"><edge equality="true"/></flexcomp>{arm()}</worldbody></mujoco>""",
        robot=("base",),
        options={"body": "base"},
    ),
    "a chain of many balls": Idiom(f"""<mujoco><worldbody><body name="hand">
      <joint name="lift" type="slide" axis="0 0 1" range="-1 1"/><geom size=".1"/>{BEADS}{"</body>" * 5}</body>
      </worldbody></mujoco>"""),
    "what stands is one": Idiom("""<mujoco><compiler fusestatic="true"/><worldbody>
      <body name="base" pos="0 0 .2"><geom size=".1"/><body name="one" pos="0 0 .1">
      <joint name="a" axis="0 0 1" range="-90 90"/>
        <geom size=".1" pos=".1 0 0"/><body name="flange" pos=".3 0 0" euler="0 90 0"><geom size=".1"/>
        <site name="tip" pos="0 0 .1"/>
        </body></body></body></worldbody></mujoco>"""),
    "every flag of the compiler": Idiom(f"""<mujoco><compiler coordinate="local" autolimits="true" strippath="true"
      alignfree="true" usethread="false" angle="degree" eulerseq="xyz" inertiafromgeom="auto"/>{ALONE}</mujoco>"""),
}

# What is no matter of the robot's.

READ |= {
    "torques of motors": Idiom(
        """<mujoco><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" range="-90 90" actuatorfrcrange="-30 30"/><geom size=".1"/>
        <body name="two" pos=".3 0 0"><joint name="b" axis="0 1 0"/><geom size=".1"/>
        <body name="three" pos=".3 0 0"><joint name="c" type="slide" actuatorfrcrange="-5 5"/><geom size=".1"/>
        <body name="four" pos=".3 0 0"><joint name="d" actuatorfrcrange="-5 5" actuatorfrclimited="false"/>
        <geom size=".1"/>
        </body></body></body></body></worldbody><actuator><motor joint="b" forcerange="-3 3"/></actuator></mujoco>"""
    ),
    "actuators of all kinds": Idiom(f"""<mujoco>{ALONE}<actuator><motor name="m" joint="shoulder" gear="50"/>
      <position joint="elbow" kp="10" ctrlrange="-1 1"/><velocity joint="elbow" kv="1"/>
      <general joint="shoulder" gaintype="fixed" biastype="affine"/><motor site="tip" gear="0 0 1 0 0 0"/>
      <intvelocity joint="elbow" kp="1" actrange="-1 1"/></actuator></mujoco>"""),
    "tendons that only pull": Idiom(f"""<mujoco>{ALONE}<tendon><fixed name="sum"><joint joint="shoulder" coef="1"/>
      <joint joint="elbow" coef="-.5"/></fixed><spatial name="rope" limited="false" range="0 1"><site site="tip"/>
      <site site="anchor"/></spatial></tendon><actuator><motor tendon="sum"/><motor tendon="rope"/></actuator>
      <worldbody><site name="anchor" pos="1 1 1"/></worldbody></mujoco>"""),
    "contacts": Idiom(f"""<mujoco><option gravity="0 0 -9.81" timestep=".005"><flag contact="disable"/></option>
      <size nuserdata="3"/><default><joint solreflimit=".01 1" solimplimit=".9 .95 .001" margin=".1"/>
      <geom solref=".01 1" margin=".01" gap=".001" condim="4" friction="1 .1 .1"/></default>{ALONE}
      <contact><exclude body1="base" body2="lower"/></contact></mujoco>"""),
    "on the moon, on a slope": Idiom(f'<mujoco><option gravity=".3 0 -1.6"/>{ALONE}</mujoco>'),
    "sensors, cameras, lights": Idiom("""<mujoco><visual><global offwidth="640"/></visual><statistic extent="2"/>
      <custom><numeric name="n" data="1 2 3"/><text name="t" data="words"/></custom>
      <asset><texture name="grid" type="2d" builtin="checker" width="8" height="8"/>
      <material name="grid" texture="grid"/></asset>
      <worldbody><geom type="plane" size="1 1 .1" material="grid"/><body name="one">
      <joint name="a" axis="0 0 1" range="-90 90"
        user="1"/><geom size=".1" rgba="1 0 0 1"/><site name="tip" pos=".1 0 0"/>
          <camera name="hand" pos="0 0 .1" euler="0 180 0"/>
        <light name="lamp" pos="0 0 .2"/></body></worldbody>
      <sensor><jointpos joint="a"/><framepos objtype="site" objname="tip"/><gyro site="tip"/><force site="tip"/>
      </sensor>
      </mujoco>"""),
    "keyframes": Idiom("""<mujoco><worldbody><body name="one"><joint name="a" axis="0 0 1" ref="30" range="-60 90"/>
      <geom size=".1" pos=".2 0 0"/><body name="two" pos=".3 0 0">
      <joint name="b" type="slide" axis="0 1 0" ref=".2"/><geom size=".1"/>
      <site name="tip" pos="0 0 .3"/></body></body></worldbody>
      <keyframe><key qpos=".1 .2"/><key name="home" qpos=".7 -.3"/><key name="ready" qpos="-.5 .4" qvel="1 2"/>
      </keyframe></mujoco>"""),
}

FOUR_BARS = """<mujoco><default><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/>
  </default><worldbody>
  <body name="one"><joint name="a"/><geom/><body name="two" pos=".3 0 0"><joint name="b"/><geom/>
  <site name="pin" pos=".3 0 0"/>
  <body name="three" pos=".3 0 0"><joint name="c"/><geom/></body></body></body><site name="ground" pos=".3 0 0"/>
  </worldbody>
  <equality>{}</equality></mujoco>"""

#: What closes chains of it.
LOOPS = {
    "points": '<connect name="loop" body1="three" body2="one" anchor=".3 0 0"/>',
    "points, without a name": '<connect body1="three" body2="one" anchor=".3 0 0"/>',
    "a point of the world": '<connect name="grounded" body1="three" anchor=".3 0 0"/>',
    "sites": '<connect name="pinned" site1="pin" site2="ground"/>',
    "bodies, welded": '<weld name="rigid" body1="two" body2="three"/>',
    "bodies, welded elsewhere": '<weld body1="one" body2="three" relpose=".3 .1 .2 .8 .6 0 0" anchor=".1 0 0"/>',
    "sites, welded": '<weld name="held" site1="pin" site2="ground"/>',
    "the world, welded": '<weld name="glue" body1="three"/>',
}

REFUSED: dict[str, Refusal] = {
    "a joint with a name that Pinocchio has taken": Refusal(
        """<mujoco><worldbody><body name="one" pos="0 0 .1"><joint name="universe" axis="0 0 1" range="-90 90"/>
        <geom size=".1"/></body></worldbody></mujoco>""",
        ("universe",),
    ),
    "a ball with a range": Refusal(
        """<mujoco><worldbody><body name="one"><joint name="shoulder_ball" type="ball" range="0 40"/>
          <geom size=".1"/></body>
        </worldbody></mujoco>""",
        ("shoulder_ball",),
    ),
    "a tie that is bent": Refusal(
        gripper('<joint name="bent" joint1="right" joint2="left" polycoef="0 1 2 0 0"/>'), ("bent",)
    ),
    "a bent tie without a name": Refusal(
        gripper('<joint joint1="right" joint2="left" polycoef="0 1 0 0 .5"/>'), ("right",), {"mimic": "follow"}
    ),
    "a joint that follows two": Refusal(
        gripper('<joint joint1="right" joint2="left"/><joint joint1="right" joint2="wrist"/>'),
        ("right",),
        {"mimic": "follow"},
    ),
    "joints that follow each other": Refusal(
        gripper('<joint joint1="right" joint2="left"/><joint joint1="left" joint2="right"/>'),
        ("right", "left"),
        {"mimic": "follow"},
    ),
    "a joint with the name of a part of another": Refusal(
        """<mujoco><worldbody><body name="one"><joint name="ball" type="ball"/><geom size=".1"/><body name="two">
        <joint name="ball[0]"/><geom size=".1"/></body></body></worldbody></mujoco>""",
        ("ball[0]",),
    ),
    "a tendon that is tied": Refusal(
        f"""<mujoco>{ALONE}<tendon><fixed name="sum"><joint joint="shoulder" coef="1"/>
          <joint joint="elbow" coef="1"/></fixed>
        </tendon><equality><tendon name="constant" tendon1="sum"/></equality></mujoco>""",
        ("constant",),
    ),
    "a tendon with a range": Refusal(
        f"""<mujoco>{ALONE}<tendon><fixed name="coupled" range="-1 1"><joint joint="shoulder" coef="1"/>
        <joint joint="elbow" coef="1"/></fixed></tendon></mujoco>""",
        ("coupled",),
    ),
    "a rope with an end": Refusal(
        f"""<mujoco>{ALONE}<worldbody><site name="wall" pos="1 1 1"/></worldbody><tendon>
        <spatial name="leash" range="0 1"><site site="wall"/><site site="tip"/></spatial></tendon></mujoco>""",
        ("leash",),
    ),
    "two arms": Refusal(two_arms(), ("left_base", "right_base", "body")),
    "two free bodies": Refusal(TWO_FREE, ("cube", "ball", "body")),
    "a body that is not there": Refusal(two_arms(), ("left_bse", "left_base"), {"body": "left_bse"}),
    "a body that does not move": Refusal(
        f"<mujoco><worldbody>{TABLE}{arm()}</worldbody></mujoco>", ("table",), {"body": "table"}
    ),
    "furniture": Refusal(f"<mujoco><worldbody>{FLOOR}{TABLE}</worldbody></mujoco>", ("robot.xml",)),
    "nothing": Refusal("<mujoco/>", ("robot.xml",)),
    "XML that breaks off": Refusal("<mujoco><worldbody><body name='one'>", ("robot.xml",)),
    "an element that MuJoCo has not": Refusal(
        '<mujoco><worldbody><body name="one"><jiont name="a"/></body></worldbody></mujoco>', ("robot.xml", "jiont")
    ),
    "a body without mass": Refusal(
        '<mujoco><worldbody><body name="ghost"><joint name="a"/></body></worldbody></mujoco>', ("robot.xml", "ghost")
    ),
    "a mesh that is not there": Refusal(
        """<mujoco><asset><mesh name="wedge" file="lost.obj"/></asset><worldbody><body name="one"><joint name="a"/>
        <geom type="mesh" mesh="wedge"/></body></worldbody></mujoco>""",
        ("robot.xml", "lost.obj"),
    ),
    "a part that is not there": Refusal(
        f'<mujoco><include file="lost.xml"/>{ALONE}</mujoco>', ("robot.xml", "lost.xml")
    ),
    "a joint to be held that is not there": Refusal(f"<mujoco>{ALONE}</mujoco>", ("elbw", "elbow"), {"lock": ["elbw"]}),
}
