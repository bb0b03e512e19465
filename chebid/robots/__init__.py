"""Rigid robots: the part of the inverse dynamic model that is linear in inertial parameters (eq. 17)."""

from functools import lru_cache
from pathlib import Path

from chebid.errors import Place
from chebid.model import Model
from chebid.model.schema import Link
from chebid.robots.axes import Axes
from chebid.robots.chain import Chain
from chebid.robots.dh import dh_tree
from chebid.robots.robot import Array, Parameter, Robot
from chebid.robots.scara import Scara
from chebid.robots.urdf import read_limits, urdf_tree

__all__ = ["Array", "Axes", "Chain", "Parameter", "Robot", "Scara", "make_robot", "urdf_limits"]

_DOWN = (0.0, 0.0, -9.81)  # gravity of a chain, m/s^2 in its base, unless the model file says otherwise


def make_robot(model: Model) -> Robot:
    """The robot of a model file. Raises InputError for a URDF file that does not fit it."""
    robot = model.robot
    if robot.type == "scara":
        return Scara(model.joints)
    if robot.type == "axes":
        return Axes(model.joints, robot.types or ("revolute",) * len(model.joints))
    gravity = robot.gravity if robot.gravity is not None else _DOWN
    if robot.type == "dh":
        assert robot.table is not None, "the schema asks for it"
        return _dh_chain(model.joints, robot.table, robot.convention or "", gravity)
    assert robot.file is not None, "the schema asks for it"
    place = model.place("robot", "file", value=robot.file)
    return _urdf_chain(model.joints, (model.path.parent / robot.file).resolve(), gravity, place)


@lru_cache(maxsize=8)
def _dh_chain(
    joints: tuple[str, ...], table: tuple[Link, ...], convention: str, gravity: tuple[float, float, float]
) -> Chain:
    return Chain(joints, dh_tree(table, convention, gravity))


def urdf_limits(model: Model) -> dict[str, Array]:
    """`position` and `velocity` (J,) that the URDF of a model file allows to either side; it tells no accelerations."""
    place = model.place("robot", "file", value=model.robot.file)
    position, velocity = read_limits((model.path.parent / (model.robot.file or "")).resolve(), model.joints, place)
    return {"position": position, "velocity": velocity}


@lru_cache(maxsize=8)
def _urdf_chain(joints: tuple[str, ...], path: Path, gravity: tuple[float, float, float], place: Place) -> Chain:
    return Chain(joints, urdf_tree(path, joints, gravity, place))
