"""Numbers of the KUKA KR 6 R700 sixx. SI units; sources and status of each are in ../README.md."""

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True)
class Joint:
    name: str
    parent: str
    child: str
    origin: tuple  # of the child frame in the parent frame [m]; all frames are parallel at q = 0
    axis: tuple  # in the parent frame
    lower_deg: float
    upper_deg: float
    velocity_deg_s: float
    effort: float  # [N m] at the link side
    acceleration: float  # [rad/s^2]
    armature: float  # reflected rotor inertia [kg m^2]


@dataclass(frozen=True)
class Inertial:
    mass: float  # [kg]
    com: tuple  # [m] in the link frame
    inertia: tuple  # about the centre of mass, link axes: xx yy zz xy xz yz [kg m^2]


JOINTS = (
    Joint(
        "joint_a1",
        "base_link",
        "link_1",
        (0, 0, 0.4),
        (0, 0, -1),
        -170,
        170,
        360,
        186.0,
        41.67,
        0.45,
    ),
    Joint(
        "joint_a2", "link_1", "link_2", (0.025, 0, 0), (0, 1, 0), -190, 45, 300, 168.9, 21.62, 0.5
    ),
    Joint(
        "joint_a3", "link_2", "link_3", (0.315, 0, 0), (0, 1, 0), -120, 156, 360, 81.5, 46.22, 0.2
    ),
    Joint(
        "joint_a4", "link_3", "link_4", (0, 0, 0.035), (-1, 0, 0), -185, 185, 381, 48.9, 145.8, 0.07
    ),
    Joint(
        "joint_a5", "link_4", "link_5", (0.365, 0, 0), (0, 1, 0), -120, 120, 388, 40.1, 152.3, 0.06
    ),
    Joint(
        "joint_a6", "link_5", "link_6", (0.08, 0, 0), (-1, 0, 0), -350, 350, 615, 27.4, 292.6, 0.03
    ),
)

# The acceleration limit is reached in this time: jerk limit = acceleration / JERK_TIME [s].
JERK_TIME = 0.1

INERTIALS = {
    "base_link": Inertial(
        15.9102,
        (-0.03713, 3e-05, 0.10864),
        (0.108209, 0.173632, 0.146596, -0.000365, -0.016107, -0.000451),
    ),
    "link_1": Inertial(
        7.9156,
        (0.00641, 0.01627, -0.08541),
        (0.103153, 0.079088, 0.075003, 0.00064, 0.004048, 0.006839),
    ),
    "link_2": Inertial(
        14.6404,
        (0.09111, 0.01912, 0.00409),
        (0.077021, 0.233908, 0.271737, 0.009595, -0.004025, -0.000179),
    ),
    "link_3": Inertial(
        4.9877,
        (0.02223, 0.01722, 0.01559),
        (0.016442, 0.024813, 0.025006, 0.00217, 0.001497, 0.00097),
    ),
    "link_4": Inertial(
        4.3387,
        (0.23264, 0.01027, 0.00011),
        (0.00995, 0.032187, 0.035125, 0.00089, -0.000486, -8.6e-05),
    ),
    "link_5": Inertial(
        1.5169,
        (0.00829, 0.02404, -0.00078),
        (0.001893, 0.001587, 0.002084, 0.000201, 1.5e-05, -1e-05),
    ),
    "link_6": Inertial(0.6904, (-0.01488, 0.0, 0.0), (0.000278, 0.000166, 0.000165, 0.0, 0.0, 0.0)),
}

HOME_DEG = (0, -90, 90, 0, 0, 0)

# Frames fixed to link_6: name, parent, roll-pitch-yaw, quaternion wxyz. Origins coincide.
HALF_SQRT2 = 0.5 * 2.0**0.5
FRAMES = (
    ("flange", "link_6", (0, 0, 0), (1, 0, 0, 0)),
    ("tool0", "flange", (0, 0.5 * pi, 0), (HALF_SQRT2, 0, HALF_SQRT2, 0)),
)

# RAL 2003, the near-black of the base, and greys.
COLOURS = {
    "orange": (0.965, 0.471, 0.157, 1),
    "black": (0.118, 0.118, 0.125, 1),
    "dark": (0.1, 0.1, 0.11, 1),
    "metal": (0.6, 0.61, 0.62, 1),
}
