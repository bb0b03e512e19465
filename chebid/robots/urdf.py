"""A robot from a URDF file, read by pinocchio: its kinematics alone, the inertias are what chebid finds."""

import difflib
from pathlib import Path
from typing import Any

import numpy as np

from chebid.errors import InputError, Place
from chebid.robots.chain import Tree, straightened
from chebid.robots.robot import Array


def urdf_tree(path: Path, joints: tuple[str, ...], gravity: tuple[float, float, float], place: Place) -> Tree:
    """The bodies that the named joints move, in the order of the names; all other joints are locked at zero.

    Raises InputError for a file that is not there or no URDF, and for a joint that it lacks or that is not simple.
    """
    import pinocchio as pin

    whole = _read(path, joints, place)
    names = list(whole.names)[1:]
    locked = [whole.getJointId(name) for name in names if name not in joints]
    model = pin.buildReducedModel(whole, locked, pin.neutral(whole))
    keys = [model.getJointId(name) for name in joints]
    number = {key: i for i, key in enumerate(keys)}
    parents = tuple(number.get(model.parents[key], -1) for key in keys)
    if any(parent > i for i, parent in enumerate(parents)):
        told = ", ".join(model.names[key] for key in sorted(keys))  # pinocchio's numbers grow away from the base
        raise InputError("has these joints in another order", hint=f"name them from the base on: {told}", place=place)
    screws = [_screw(model, key, place) for key in keys]
    poses = [model.jointPlacements[key] for key in keys]
    return Tree(
        parent=parents,
        rotation=np.array([straightened(pose.rotation) for pose in poses]),
        origin=np.array([pose.translation for pose in poses]),
        turn=np.array([turn for _, turn in screws]),
        slide=np.array([slide for slide, _ in screws]),
        gravity=np.array(gravity),
    )


def _screw(model: Any, key: int, place: Place) -> tuple[Array, Array]:
    """Unit translation and rotation (3,) of a joint in its own frame. Raises InputError for one of several freedoms."""
    import pinocchio as pin

    joint = model.joints[key]
    if joint.nv != 1:
        name = model.names[key]
        hint = "only joints that turn or slide can be identified"
        raise InputError(f"joint {name!r} has {joint.nv} freedoms", hint=hint, place=place)
    data = model.createData()
    jacobian = pin.computeJointJacobian(model, data, pin.neutral(model), key)
    column = jacobian[:, joint.idx_v]
    return np.array(column[:3]), np.array(column[3:])


def read_limits(path: Path, joints: tuple[str, ...], place: Place) -> tuple[Array, Array]:
    """Positions, the smaller of both sides, and velocities (J,) that a URDF allows; half a turn where it has no end."""
    model = _read(path, joints, place)
    position, velocity = [], []
    for name in joints:
        joint = model.joints[model.getJointId(name)]
        ends = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        position.append(min(abs(ends[0]), abs(ends[1])) if joint.nq == joint.nv else np.pi)
        velocity.append(abs(model.velocityLimit[joint.idx_v]))
    return np.array(position), np.array(velocity)


def _read(path: Path, joints: tuple[str, ...], place: Place) -> Any:
    """The whole model of a URDF that has these joints."""
    import pinocchio as pin

    if not path.is_file():
        raise InputError("is not there", hint="give its path, relative to the model file", place=place)
    try:
        whole = pin.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as err:
        hint = str(err).strip().splitlines()[0]
        raise InputError("is no URDF file that can be read", hint=hint, place=place) from err
    names = list(whole.names)[1:]
    for name in joints:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            hint = f"did you mean {near[0]}?" if near else f"it has: {', '.join(names)}"
            raise InputError(f"has no movable joint {name!r}", hint=hint, place=place)
    return whole
