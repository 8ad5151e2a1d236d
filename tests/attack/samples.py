"""The good files that are damaged: made once by the program itself, small enough to be quick."""
import contextlib
import pathlib
import shutil
import sqlite3
import struct
import subprocess
import zlib

from damage import text32

SOURCE = pathlib.Path(__file__).resolve().parents[2]
# Two joints, short recordings, cheap fits: every stage within seconds.
SCENE = """name = "sample"
seed = 3

[robot]
urdf = "robot.urdf"
mount = "ceiling"

[friction]

[plant]
step_s = 0.001

[excitation]
harmonics = 3
base_rad_s = 1.5
train = 1
repeats = 1
validation = 1
restarts = 1
criterion = "none"

[sensors]
rate_hz = 100

[identify]
min_speed_rad_s = 0.02

[[model]]
name = "simple"
starts = 1

[evaluate]
horizons_s = [0]
starts = 1
draws = 0
substeps = 1
min_headroom = 0

[render]
video = false
"""
MJCF = """<mujoco model="planar_2r">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.001"/>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 -1 0" armature="0.4" range="-3.1 3.1" actuatorfrcrange="-120 120"/>
      <inertial pos="0.25 0 0" mass="3" diaginertia="0.01 0.08 0.08"/>
      <geom type="capsule" size="0.03" fromto="0 0 0 0.5 0 0" mass="0"/>
      <body name="lower" pos="0.5 0 0">
        <joint name="elbow" axis="0 -1 0" armature="0.2" range="-2.8 2.8" actuatorfrcrange="-60 60"/>
        <inertial pos="0.18 0 0" mass="2" diaginertia="0.006 0.03 0.03"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0" mass="0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
CONTRACT = """joint_names = {joints}
[time]
column = "t"
[position]
columns = "q{{}}"
[torque]
columns = "tau{{}}"
"""
MCAP_CONTRACT = """joint_names = {joints}
[position]
columns = "position.{{name}}"
[torque]
columns = "effort.{{name}}"
"""

MAT_CONTRACT = """joint_names = {joints}
format = "mat"
[torque]
columns = "tau{{}}"
"""


def cdr_text(body, text):
    body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(text) + 1) + text.encode() + b"\0"


def joint_state(joints, t, position, effort):
    """sensor_msgs/msg/JointState as little-endian CDR."""
    body = bytearray(struct.pack("<iI", int(t), round(t % 1 * 1e9)))
    cdr_text(body, "")
    body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(joints))
    for joint in joints:
        cdr_text(body, joint)
    for values in (position, [], effort):
        body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(values))
        if values:
            body += b"\0" * (-len(body) % 8) + struct.pack(f"<{len(values)}d", *values)
    return b"\0\1\0\0" + bytes(body)


def bag_of(path, joints, rows):
    """Joint states of (t, positions, efforts) as a ROS 2 bag of the storage sqlite3."""
    with contextlib.closing(sqlite3.connect(path)) as bag, bag:
        bag.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
        bag.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        bag.execute("INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr')")
        for k, row in enumerate(rows):
            bag.execute("INSERT INTO messages VALUES (?, 1, ?, ?)", (k + 1, k, joint_state(joints, *row)))


def mcap_of(joints, rows):
    """Joint states of (t, positions, efforts) in an MCAP file without chunks."""
    def record(opcode, content):
        return struct.pack("<BQ", opcode, len(content)) + content

    out = b"\x89MCAP0\r\n" + record(0x01, text32("ros2") + text32("test"))
    out += record(0x03, struct.pack("<H", 1) + text32("sensor_msgs/msg/JointState") +
                  text32("ros2msg") + text32(""))
    out += record(0x04, struct.pack("<HH", 1, 1) + text32("/joint_states") + text32("cdr") +
                  struct.pack("<I", 0))
    for k, row in enumerate(rows):
        out += record(0x05, struct.pack("<HIQQ", 1, k, 0, 0) + joint_state(joints, *row))
    return out + record(0x02, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n"


def mat_of(arrays):
    """Arrays of doubles, each (name, rows by columns), as a MAT-file of version 5: plain and by zlib in turn."""
    out = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"
    for k, (name, rows) in enumerate(arrays):
        text, numbers = name.encode(), [value for column in zip(*rows) for value in column]
        content = struct.pack("<8I", 6, 8, 6, 0, 5, 8, len(rows), len(rows[0]))
        content += struct.pack("<2I", 1, len(text)) + text + b"\0" * (-len(text) % 8)
        content += struct.pack(f"<2I{len(numbers)}d", 9, 8 * len(numbers), *numbers)
        array = struct.pack("<2I", 14, len(content)) + content
        stored = zlib.compress(array)
        out += array if k % 2 == 0 else struct.pack("<2I", 15, len(stored)) + stored
    return out


def make(program, folder):
    """Fills `folder` with the good files, unless they are there."""
    if (folder / "done").exists():
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)

    def fricid(*arguments):
        done = subprocess.run([program, *map(str, arguments)], cwd=folder, text=True,
                              capture_output=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(f"attack: the good files cannot be made: {arguments}: {done.stderr}")
        return done.stdout

    urdf = (SOURCE / "models/test/planar_2r.urdf").read_text()
    # heavy enough rotors for the friction of the effort limits
    (folder / "robot.urdf").write_text(
        urdf.replace('effort="120"/>', 'effort="120"/><fricid armature="0.4"/>')
            .replace('effort="60"/>', 'effort="60"/><fricid armature="0.2"/>'))
    (folder / "robot.xml").write_text(MJCF)
    (folder / "short.toml").write_text(SCENE)
    whole = fricid("info", "short.toml").replace(f'"{folder / "robot.urdf"}"', '"robot.urdf"')
    (folder / "scene.toml").write_text(whole)
    (folder / "mjcf.toml").write_text(whole.replace('mjcf = ""', 'mjcf = "robot.xml"'))
    fricid("simulate", "mjcf.toml", "-o", "mjcf", "--quiet")
    fricid("run", "scene.toml", "-o", "run", "--no-video", "--quiet")
    (folder / "empty.toml").write_text("")
    (folder / "loop").symlink_to("loop")
    shutil.copy(folder / "run/data/validation_0.h5", folder / "data.h5")
    shutil.copy(folder / "run/models/simple_s1.json", folder / "model.json")

    table = [row.split(",") for row in fricid("info", "data.h5", "--csv").split()]
    (folder / "log.csv").write_text("\n".join(map(",".join, table)) + "\n")
    joints = ["shoulder", "elbow"]
    column = {name: i for i, name in enumerate(table[0])}

    def group(row, signal):
        return [float(row[column[f"{signal}{j + 1}"]]) for j in range(len(joints))]

    names = str(joints).replace("'", '"')
    (folder / "contract.toml").write_text(CONTRACT.format(joints=names))
    (folder / "mcap.toml").write_text(MCAP_CONTRACT.format(joints=names))
    rows = [(float(row[column["t"]]), group(row, "q"), group(row, "tau")) for row in table[1:]]
    (folder / "log.mcap").write_bytes(mcap_of(joints, rows))
    bag_of(folder / "log.db3", joints, rows)
    (folder / "mat.toml").write_text(MAT_CONTRACT.format(joints=names))
    (folder / "log.mat").write_bytes(mat_of([("t", [[t] for t, _, _ in rows]), ("q", [q for _, q, _ in rows]),
                                             ("tau", [tau for _, _, tau in rows])]))
    twin = folder / "run/external/twin"
    twin.mkdir(parents=True)
    shutil.copy(folder / "run/rollouts/simple_s1_validation_0.h5", twin / "validation_0_0.h5")
    (twin / "model.json").write_text('{"format": "fricid.external/1", "label": "Twin", '
                                     '"parameters": 3, "fit_seconds": 1.5}\n')
    fricid("evaluate", "run", "--quiet")

    # a run of logs: the same log in two parts
    (folder / "logs.toml").write_text(
        SCENE.split("[friction]")[0] + '''[data]
contract = "contract.toml"
train = ["log.csv[0:2]"]
validation = ["log.csv[2:]"]

[identify]''' + SCENE.split("[identify]")[1])
    fricid("run", "logs.toml", "-o", "logs", "--no-video", "--quiet")

    # another robot with another number of joints: its files are of the right kind and the wrong shape
    (folder / "pendulum.urdf").write_text((SOURCE / "models/test/pendulum.urdf").read_text())
    (folder / "pendulum.toml").write_text(
        SCENE.replace("robot.urdf", "pendulum.urdf").replace("rate_hz = 100", "rate_hz = 125"))
    fricid("run", "pendulum.toml", "-o", "other", "--no-video", "--quiet")
    (folder / "done").write_text("")
