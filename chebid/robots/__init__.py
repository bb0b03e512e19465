"""Rigid robots: the part of the inverse dynamic model that is linear in inertial parameters (eq. 17)."""

from chebid.errors import InputError
from chebid.model import Model
from chebid.robots.axes import Axes
from chebid.robots.robot import Array, Parameter, Robot
from chebid.robots.scara import Scara

__all__ = ["Array", "Axes", "Parameter", "Robot", "Scara", "make_robot"]


def make_robot(model: Model) -> Robot:
    """The robot of a model file. Raises InputError for a type that is not there."""
    if model.robot.type == "scara":
        return Scara(model.joints)
    if model.robot.type == "axes":
        return Axes(model.joints, model.robot.types or ("revolute",) * len(model.joints))
    raise InputError(
        "robots of this type cannot be identified with this version",
        hint="use type scara or axes; the commands project and derive need no robot",
        place=model.place("robot", "type", value=model.robot.type),
    )
