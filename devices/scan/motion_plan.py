"""What a scan is to do, one file: the grid, three taught corners, and how the arm may move."""

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from physics.json_values import a_number, a_text, a_whole_number, an_object, numbers
from recordings.refusal import Refusal
from recordings.untrusted import reading

ORDERS = ("snake", "raster", "adaptive")
PASSES = ("separate", "interleaved", "patch only")
CORNERS = ("lower_left", "upper_left", "upper_right")
# Corners taught by hand may be turned against each other by so much before the patch is no longer parallel to itself.
MOST_TURN_DEG = 3.0
# Standard controllers allow more; beyond this a collision hurts.
MOST_SPEED_M_S = 1.0
MOST_POSITIONS = 1_000_000


@dataclass(frozen=True)
class MotionPlan:
    """A grid of columns x rows positions of the patch, and the motion between them.

    lower_left, upper_left, upper_right: (6,) poses of the tool at three corners of the grid as the camera sees it, in
    the arm's base frame, metres and rotation vector; row 0 is the lowest in the image, column 0 the leftmost.
    repeats: measurements at each position. order: "snake" and "raster" visit all positions; "adaptive" those where the
    maps are least certain, until the worst zone's map has the cosine `accuracy` with the full one.
    passes: "separate" scans all positions with the patch, then the same without; "interleaved" changes after every
    `block` positions; "patch only" leaves the background out.
    monitor_every: positions after which the middle of the grid is seen again, to watch for drift; 0 for never.
    speed_m_s, acceleration_m_s2: of the tool. settle_s: rest before a measurement begins, after the
    arm was read back at rest; more where its stand is soft.
    """

    columns: int = 80
    rows: int = 45
    lower_left: tuple[float, ...] = (0.0,) * 6
    upper_left: tuple[float, ...] = (0.0,) * 6
    upper_right: tuple[float, ...] = (0.0,) * 6
    repeats: int = 1
    order: str = "snake"
    accuracy: float = 0.995
    passes: str = "separate"
    block: int = 400
    monitor_every: int = 200
    speed_m_s: float = 0.25
    acceleration_m_s2: float = 0.5
    settle_s: float = 0.02

    @property
    def size(self) -> int:
        """Positions of the whole grid."""
        return self.columns * self.rows

    @property
    def middle(self) -> int:
        """The cell in the middle of the grid."""
        return self.rows // 2 * self.columns + self.columns // 2

    def poses(self, cells: np.ndarray) -> np.ndarray:
        """(K, 6) poses of the tool at cells (K,), numbered row · columns + column.

        Positions on the plane through the corners, at even steps; the direction is that of the corners, turned evenly
        from one to the next where they differ.
        """
        row, column = np.divmod(np.asarray(cells), self.columns)
        up, across = row / max(self.rows - 1, 1), column / max(self.columns - 1, 1)
        low_left, up_left, up_right = (np.array(getattr(self, corner)) for corner in CORNERS)
        at = low_left[:3] + up[:, None] * (up_left - low_left)[:3] + across[:, None] * (up_right - up_left)[:3]
        # The turns are slight (MOST_TURN_DEG), hence so is the order in which they are made.
        turned = [Rotation.from_rotvec(corner[3:]) for corner in (low_left, up_left, up_right)]
        rising = Slerp([0, 1], Rotation.concatenate(turned[:2]))(up)
        crossing = Slerp([0, 1], Rotation.concatenate([Rotation.identity(), turned[2] * turned[1].inv()]))(across)
        return np.column_stack([at, (crossing * rising).as_rotvec()])

    def text(self) -> str:
        """The file of this plan."""
        return json.dumps(asdict(self), indent=2) + "\n"


def load_plan(path: str | Path) -> MotionPlan:
    """Read a plan (.json); `Refusal` names the field at fault."""
    with reading(path, "scan plan (.json)"):
        said = json.loads(Path(path).read_text(encoding="utf-8"))
        return plan_from(said)


def plan_from(said: Any, place: str = "scan plan") -> MotionPlan:
    """A plan out of JSON values; what is left out keeps its default, but for the corners."""
    known = {f.name: f.name in CORNERS for f in fields(MotionPlan)}
    an_object(said, known, place)
    default, values = MotionPlan(), {}
    for name, value in said.items():
        where, kind = f"{place}.{name}", type(getattr(default, name))
        if kind is tuple:
            values[name] = tuple(numbers(value, where, 6).tolist())
        else:
            values[name] = {int: a_whole_number, float: a_number, str: a_text}[kind](value, where)
    plan = MotionPlan(**values)
    _expect_sound(plan, place)
    return plan


def _expect_sound(plan: MotionPlan, place: str) -> None:
    """Refuse numbers that make no scan."""
    for name, known in (("order", ORDERS), ("passes", PASSES)):
        if getattr(plan, name) not in known:
            raise Refusal(f"{place}.{name} is {getattr(plan, name)!r}, expected one of {', '.join(known)}")
    for name, low, high in (
        ("columns", 1, MOST_POSITIONS),
        ("rows", 1, MOST_POSITIONS),
        ("repeats", 1, 1000),
        ("block", 1, MOST_POSITIONS),
        ("monitor_every", 0, MOST_POSITIONS),
        ("speed_m_s", 1e-3, MOST_SPEED_M_S),
        ("acceleration_m_s2", 1e-3, 10.0),
        ("settle_s", 0.0, 60.0),
        ("accuracy", 0.5, 0.99999),
    ):
        if not low <= getattr(plan, name) <= high:
            raise Refusal(f"{place}.{name} is {getattr(plan, name)}, expected {low:g} to {high:g}")
    if plan.size > MOST_POSITIONS:
        raise Refusal(f"{place}: {plan.columns} x {plan.rows} positions, expected at most {MOST_POSITIONS}")
    corners = {corner: np.array(getattr(plan, corner)) for corner in CORNERS}
    up, across = (
        (corners["upper_left"] - corners["lower_left"])[:3],
        (corners["upper_right"] - corners["upper_left"])[:3],
    )
    if plan.size > 1 and np.linalg.norm(np.cross(up, across)) < 1e-6:
        raise Refusal(f"{place}: the three corners lie on one line, expected three corners of a rectangle")
    level = Rotation.from_rotvec(corners["lower_left"][3:])
    for name, corner in corners.items():
        turn = np.degrees((Rotation.from_rotvec(corner[3:]) * level.inv()).magnitude())
        if turn > MOST_TURN_DEG:
            raise Refusal(
                f"{place}.{name}: the tool is turned by {turn:.1f} degrees against lower_left, expected at most "
                f"{MOST_TURN_DEG:g}; teach the corners with the patch parallel to the camera's image"
            )
