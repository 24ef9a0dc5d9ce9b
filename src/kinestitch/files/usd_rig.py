"""UsdSkel skeletons: which one, its joints as a tree, its rest pose and the animations that fit it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinestitch.core.rotation import Array, quat_about_axis, quat_identity, quat_to_matrix
from kinestitch.errors import FormatError, ParameterError
from kinestitch.files.extras import optional
from kinestitch.files.gltf_scene import World, below, proper_rotations

_MOST_JOINTS = 20_000


@dataclass(slots=True)
class Take:
    """One SkelAnimation: its name, its prim and the joints that it moves."""

    name: str
    animation: Any
    joints: tuple[str, ...]


@dataclass(slots=True)
class Rig:
    """One skeleton, its joints in topological order.

    paths : the joints' tokens; ``""`` for a root that was added above several
    columns : place of each joint in the file's arrays, -1 for an added root
    rest : (J, 4, 4) local matrices, column vectors, the file's unit
    bind : (J, 4, 4) in the world, None where the file has none that are sound
    bound : path of the animation that the skeleton is bound to
    """

    prim: Any
    names: tuple[str, ...]
    paths: tuple[str, ...]
    parents: tuple[int, ...]
    columns: tuple[int, ...]
    rest: Array
    bind: Array | None
    bound: str
    takes: list[Take]


def stage_frame(stage: Any) -> World:
    """The turn and the scale from the stage's axes and unit to Y up and metres."""
    geom = optional("pxr.UsdGeom", "usd")
    metres = float(geom.GetStageMetersPerUnit(stage))
    if not (math.isfinite(metres) and 1e-6 <= metres <= 1e6):
        raise FormatError(f"Expected metersPerUnit between 1e-6 and 1e6, got {metres}.")
    turn = quat_about_axis(0, -math.pi / 2) if geom.GetStageUpAxis(stage) == "Z" else quat_identity()
    return World(quat_to_matrix(turn)[None] * metres, np.zeros((1, 3)), turn[None])


def choose_rig(stage: Any, take: str | None) -> tuple[Rig, Take | None]:
    """The skeleton with the most joints among those that are animated, and the animation called `take`.

    Raises FormatError where there are no joints, ParameterError for an unknown take.
    """
    usd, skel = optional("pxr.Usd", "usd"), optional("pxr.UsdSkel", "usd")
    prims = list(usd.PrimRange.Stage(stage, usd.TraverseInstanceProxies()))
    animations = [skel.Animation(prim) for prim in prims if prim.IsA(skel.Animation)]
    rigs = [_rig(prim, animations) for prim in prims if prim.IsA(skel.Skeleton)]
    sound = [rig for rig in rigs if rig is not None]
    if not sound:
        found = f"{len(rigs)} skeleton(s) without joints" if rigs else "no skeleton"
        raise FormatError(f"Expected a UsdSkel skeleton with joints, got {found}.")
    if take is not None:
        named = [rig for rig in sound if any(entry.name == take for entry in rig.takes)]
        if not named:
            known = (
                ", ".join(repr(name) for name in dict.fromkeys(t.name for rig in sound for t in rig.takes)) or "none"
            )
            raise ParameterError(f"Expected the name of an animation ({known[:200]}), got {take!r}.")
        rig = max(named, key=lambda entry: len(entry.names))
        return rig, next(entry for entry in rig.takes if entry.name == take)
    rig = max(sound, key=lambda entry: (bool(entry.takes), bool(entry.bound), len(entry.names)))
    bound = [entry for entry in rig.takes if str(entry.animation.GetPath()) == rig.bound]
    most = sorted(rig.takes, key=lambda entry: -len(set(entry.joints) & set(rig.paths)))
    return rig, next(iter(bound or most), None)


def _tokens(attribute: Any) -> tuple[str, ...]:
    value = attribute.Get()
    try:
        return tuple(str(token) for token in value) if value is not None else ()
    except TypeError:
        return ()


def matrices(attribute: Any, count: int) -> Array | None:
    """Matrices (count, 4, 4) for column vectors; None where the attribute has none, or others than are needed."""
    try:
        values = np.array(attribute.Get(), dtype=np.float64)
    except (TypeError, ValueError):
        return None
    sound = values.shape == (count, 4, 4) and np.isfinite(values).all() and np.abs(values).max() < 1e12
    return np.swapaxes(values, 1, 2) if sound else None


def _rig(prim: Any, animations: list[Any]) -> Rig | None:
    skel = optional("pxr.UsdSkel", "usd")
    skeleton = skel.Skeleton(prim)
    tokens = _tokens(skeleton.GetJointsAttr())
    if not tokens:
        return None
    if len(set(tokens)) < len(tokens) or len(tokens) > _MOST_JOINTS:
        raise FormatError(f"Expected up to {_MOST_JOINTS} joints of different paths in {prim.GetPath()}, got others.")
    names = _tokens(skeleton.GetJointNamesAttr())
    if len(set(names)) < len(tokens) or len(names) != len(tokens) or not all(names):
        names = tuple(token.rsplit("/", 1)[-1] or "joint" for token in tokens)
    order, parents = _ordered(tokens)
    columns = [column for column in order if column >= 0]
    rest, bind = (matrices(attribute, len(tokens)) for attribute in _poses_of(skeleton))
    if bind is not None and not (np.abs(np.linalg.det(bind[:, :3, :3])) > 1e-18).all():
        bind = None
    rest = _rest(rest, bind, tokens)[columns]
    bind = bind if bind is None else bind[columns]
    if order[0] < 0:
        rest = np.concatenate([np.eye(4)[None], rest])
        bind = bind if bind is None else np.concatenate([np.eye(4)[None], bind])
    source = skel.BindingAPI(prim).GetInheritedAnimationSource()
    return Rig(
        prim,
        tuple(names[column] if column >= 0 else prim.GetName() for column in order),
        tuple(tokens[column] if column >= 0 else "" for column in order),
        tuple(parents),
        tuple(order),
        rest,
        bind,
        str(source.GetPath()) if source else "",
        _takes(animations, set(tokens)),
    )


def _poses_of(skeleton: Any) -> tuple[Any, Any]:
    return skeleton.GetRestTransformsAttr(), skeleton.GetBindTransformsAttr()


def _takes(animations: list[Any], tokens: set[str]) -> list[Take]:
    """The animations that move some of the joints; one of a name that repeats goes by its path."""
    found = [(animation, _tokens(animation.GetJointsAttr())) for animation in animations]
    fitting = [(animation, joints) for animation, joints in found if tokens & set(joints)]
    names = [animation.GetPrim().GetName() for animation, _ in fitting]
    return [
        Take(name if names.count(name) == 1 else str(animation.GetPath()), animation, joints)
        for name, (animation, joints) in zip(names, fitting, strict=True)
    ]


def _above(token: str, columns: dict[str, int]) -> int:
    """Column of the nearest joint above; -1 for none."""
    while "/" in token:
        token = token.rsplit("/", 1)[0]
        if token in columns:
            return columns[token]
    return -1


def _ordered(tokens: tuple[str, ...]) -> tuple[list[int], list[int]]:
    """Columns of the file in an order of parents first, and parents as places in it; -1 first for an added root."""
    columns = {token: column for column, token in enumerate(tokens)}
    above = [_above(token, columns) for token in tokens]
    order = sorted(range(len(tokens)), key=lambda column: tokens[column].count("/"))
    place_first = all(parent < column for column, parent in enumerate(above))
    order = list(range(len(tokens))) if place_first else order
    if above.count(-1) > 1:
        order = [-1, *order]
    elif order and above[order[0]] != -1:
        raise FormatError("Expected a joint that all others are below, got none.")
    places = {column: place for place, column in enumerate(order)}
    return order, [-1 if place == 0 else places[above[column]] for place, column in enumerate(order)]


def _rest(rest: Array | None, bind: Array | None, tokens: tuple[str, ...]) -> Array:
    """Local rest matrices; where the file has none, from the bind pose."""
    if rest is not None:
        return rest
    if bind is None:
        raise FormatError(f"Expected restTransforms or bindTransforms of {len(tokens)} joints, got neither.")
    columns = {token: column for column, token in enumerate(tokens)}
    above = [_above(token, columns) for token in tokens]
    inverse = np.linalg.inv(bind)
    return np.array([inverse[up] @ bind[at] if up >= 0 else bind[at] for at, up in enumerate(above)])


def world_of(matrix: Array) -> World:
    """Transforms (N, 4, 4) apart: linear part, position, turn."""
    linear = matrix[..., :3, :3]
    return World(linear, matrix[..., :3, 3], proper_rotations(linear, quat_identity((len(matrix),))))


def rest_worlds(rig: Rig, frame: World) -> tuple[Array, Array]:
    """World positions (J, 3) m and rotations (J, 4) of the bind pose, else of the rest pose."""
    if rig.bind is not None:
        worlds = [below(frame, world_of(matrix[None])) for matrix in rig.bind]
    else:
        geom = optional("pxr.UsdGeom", "usd")
        above = below(frame, world_of(placed(geom, rig.prim, None)[None]))
        worlds = []
        for joint, parent in enumerate(rig.parents):
            local = world_of(rig.rest[joint][None])
            worlds.append(below(worlds[parent] if parent >= 0 else above, local))
    if not all(np.isfinite(world.linear).all() and np.isfinite(world.position).all() for world in worlds):
        raise FormatError("Expected a finite rest pose, got an overflow.")
    rotations = np.concatenate([proper_rotations(world.linear, world.turn) for world in worlds])
    return np.concatenate([world.position for world in worlds]), rotations


def placed(geom: Any, prim: Any, time: float | None) -> Array:
    """World matrix (4, 4) of a prim, column vectors, at a time code; None for the default one."""
    usd = optional("pxr.Usd", "usd")
    code = usd.TimeCode.Default() if time is None else usd.TimeCode(time)
    return np.array(geom.Imageable(prim).ComputeLocalToWorldTransform(code), dtype=np.float64).T
