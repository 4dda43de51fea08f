"""Which geoms may touch which, as MuJoCo collision bits; nothing else collides.

Fixtures touch the cable's capsules, the notebook's spheres and the gripper; the floor touches the
cable's floor spheres and the notebook's spheres. The cable touches neither itself nor the gripper,
the notebook not the gripper; its held cover touches its free one.
"""

from __future__ import annotations

from typing import Final

import numpy as np

Layer = dict[str, int]

CONTACT_MARGIN: Final = 0.002
"""[m] removes the 1-3 mm penetration of a taut cable at no cost (docs/tasks)."""

FIXTURE: Final[Layer] = {"contype": 1, "conaffinity": 0, "group": 1}
FLOOR: Final[Layer] = {"contype": 2, "conaffinity": 0, "group": 0}
CABLE: Final[Layer] = {"contype": 0, "conaffinity": 1, "group": 2}
CABLE_FLOOR: Final[Layer] = {"contype": 0, "conaffinity": 2, "group": 4}
GRIPPER: Final[Layer] = {"contype": 0, "conaffinity": 1, "group": 3}
SHEET: Final[Layer] = {"contype": 0, "conaffinity": 1 | 2, "group": 4}
SHEET_HELD: Final[Layer] = {"contype": 0, "conaffinity": 1 | 2 | 4, "group": 4}
SHEET_FREE: Final[Layer] = {"contype": 4, "conaffinity": 0, "group": 2}
SHEET_VISUAL: Final[Layer] = {"contype": 0, "conaffinity": 0, "group": 2}
VISUAL: Final[Layer] = {"contype": 0, "conaffinity": 0, "group": 1}

VISIBLE_GROUPS: Final = np.array([1, 1, 1, 1, 0, 0], dtype=np.uint8)
"""Floor, fixtures, object and gripper; what only collides is not shown."""
