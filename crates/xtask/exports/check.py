"""Files of `wingbeat export` read by the programs that they are for: `python check.py FOLDER`.

FOLDER holds the run folder `turn` and its exports turn.mcap, .csv, .npz, .mat and turn-vtk; WINGBEAT names the program. Every number is
held against record.parquet.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyvista
import scipy.io
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

FOLDER = Path(sys.argv[1])
RECORD = pd.read_parquet(FOLDER / "turn" / "record.parquet")
tally = [0, 0]


def judge(name: str, value: float, most: float, unit: str = "") -> None:
    holds = bool(value <= most)
    tally[not holds] += 1
    print(f"{name:<64} {value:>12.4g}  at most {most:g} {unit}{'' if holds else '  FAILED'}")


def holds(name: str, what: bool) -> None:
    tally[not what] += 1
    print(f"{name:<64} {what!s:>12}{'' if what else '  FAILED'}")


def rows(times: np.ndarray) -> np.ndarray:
    """The rows of the record at those times, to the nanosecond."""
    known = RECORD["t"].to_numpy()
    found = np.abs(known[None, :] - times[:, None]).argmin(axis=1)
    judge("times are those of rows of the record", np.abs(known[found] - times).max(), 1e-9, "s")
    return found


def columns(prefix: str, axes: str) -> np.ndarray:
    return RECORD[[f"{prefix}_{axis}" for axis in axes]].to_numpy()


def stamp(header) -> float:
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def compared(reader: str, odometry: list, joints: list, wrenches: dict) -> None:
    """Messages as a reader gives them against the record."""
    at = rows(np.array([stamp(message.header) for message in odometry]))
    point = lambda p: (p.x, p.y, p.z)
    place = np.array([point(message.pose.pose.position) for message in odometry])
    judge(f"{reader}: odometry, place", np.abs(place - columns("p_WB", "xyz")[at]).max(), 1e-12, "m")
    turn = [(q.w, *point(q)) for q in (message.pose.pose.orientation for message in odometry)]
    judge(f"{reader}: odometry, quaternion", np.abs(np.array(turn) - columns("quat", "wxyz")[at]).max(), 1e-12)
    spin = np.array([point(message.twist.twist.angular) for message in odometry])
    judge(f"{reader}: odometry, rate", np.abs(spin - columns("w_WB_B", "xyz")[at]).max(), 1e-12, "rad/s")
    at = rows(np.array([stamp(message.header) for message in joints]))
    names = list(joints[0].name)
    angles = np.array([message.position for message in joints])
    judge(f"{reader}: {len(names)} joints", np.abs(angles - RECORD[names].to_numpy()[at]).max(), 1e-12, "rad")
    for source, messages in wrenches.items():
        at = rows(np.array([stamp(message.header) for message in messages]))
        force = np.array([point(message.wrench.force) for message in messages])
        judge(f"{reader}: force of {source}", np.abs(force - columns(f"force_{source}", "xyz")[at]).max(), 1e-12, "N")


def index_of(path: Path) -> list[str]:
    """The summary of the file; answers the sources of wrenches."""
    with path.open("rb") as file:
        reader = make_reader(file)
        header, summary = reader.get_header(), reader.get_summary()
        count = sum(1 for _ in reader.iter_messages())
    holds("mcap: profile ros2", header.profile == "ros2")
    holds("mcap: every message in CDR", {c.message_encoding for c in summary.channels.values()} == {"cdr"})
    holds("mcap: every schema is a definition of ROS 2", {s.encoding for s in summary.schemas.values()} == {"ros2msg"})
    holds("mcap: statistics count the messages", summary.statistics.message_count == count > 0)
    indexed = sum(len(chunk.message_index_offsets) for chunk in summary.chunk_indexes)
    holds("mcap: every chunk is indexed by channel", len(summary.chunk_indexes) > 0 and indexed >= len(summary.channels))
    latched = [c.topic for c in summary.channels.values() if "durability: 1" in c.metadata.get("offered_qos_profiles", "")]
    holds("mcap: late readers get the description", latched == ["/robot_description"])
    seconds = RECORD["t"].iloc[-1]
    judge("mcap: size for 5 s at 200 Hz", path.stat().st_size / 1e6 * 5 / seconds, 3, "MB")
    return [c.topic.removeprefix("/wrench/") for c in summary.channels.values() if c.topic.startswith("/wrench/")]


def mcap(path: Path) -> None:
    recorded = [name for name in index_of(path) if f"force_{name}_x" in RECORD]
    topics = ["/odom", "/joint_states", *(f"/wrench/{name}" for name in recorded)]
    found = {topic: [] for topic in topics}
    for message in read_ros2_messages(path, topics=topics):
        found[message.channel.topic].append(message.ros_msg)
    own = lambda of: {name: of[f"/wrench/{name}"] for name in recorded}
    compared("mcap-ros2-support", found["/odom"], found["/joint_states"], own(found))
    again = {topic: [] for topic in topics}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        listed = {connection.topic for connection in reader.connections}
        for connection, _, raw in reader.messages([c for c in reader.connections if c.topic in topics]):
            again[connection.topic].append(reader.deserialize(raw, connection.msgtype))
        described = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages([c for c in reader.connections if c.topic == "/robot_description"])]
        transforms = sum(len(reader.deserialize(raw, c.msgtype).transforms) for c, _, raw in reader.messages([c for c in reader.connections if c.topic == "/tf"]))
    compared("rosbags", again["/odom"], again["/joint_states"], own(again))
    holds("rosbags: transforms and one description", {"/tf", "/robot_description"} <= listed and len(described) == 1 and transforms > 1000)
    holds("rosbags: the description is a robot", described[0].data.startswith("<?xml") and "<link" in described[0].data)
    out = path.with_suffix(".rrd")
    out.unlink(missing_ok=True)
    rerun = Path(sys.executable).parent / "rerun"
    made = subprocess.run([rerun, "mcap", "convert", path, "-o", out], check=False, capture_output=True, text=True, timeout=300)
    print(made.stderr[-2000:] if made.returncode else "", end="")
    holds("rerun: converts the file", made.returncode == 0 and out.stat().st_size > 100_000)
    stats = subprocess.run([rerun, "rrd", "stats", out], check=False, capture_output=True, text=True, timeout=300)
    holds("rerun: reads what it converted", stats.returncode == 0 and "num_chunks" in stats.stdout + stats.stderr)


def arrays() -> None:
    apart = lambda of: max(np.abs(np.asarray(of(name)).ravel() - RECORD[name].to_numpy()).max() for name in RECORD)
    npz = np.load(FOLDER / "turn.npz")
    holds("npz: a column for each", set(npz) == set(RECORD))
    judge("npz: numbers", apart(lambda name: npz[name]), 0)
    mat = scipy.io.loadmat(FOLDER / "turn.mat")
    judge("mat: numbers", apart(lambda name: mat[name]), 0)
    csv = pd.read_csv(FOLDER / "turn.csv")
    judge("csv: numbers", apart(lambda name: csv[name]), 0)


def vtk() -> None:
    folder = FOLDER / "turn-vtk"
    listed = json.loads((folder / "frames.vtk.series").read_text())["files"]
    holds("vtk: every file of the list is there", all((folder / file["name"]).is_file() for file in listed) and len(listed) > 10)
    at = rows(np.array([file["time"] for file in listed[:: len(listed) // 10]]))
    edges = [name[:-2] for name in RECORD if name.startswith(("leading_", "trailing_")) and name.endswith("_x")]
    farthest, forces = 0.0, 0.0
    for file, row in zip(listed[:: len(listed) // 10], at, strict=True):
        mesh = pyvista.read(folder / file["name"])
        for edge in edges:
            place = columns(edge, "xyz")[row]
            farthest = max(farthest, np.linalg.norm(np.asarray(mesh.points) - place, axis=1).min())
        forces = max(forces, np.linalg.norm(mesh.point_data["force_N"], axis=1).max())
    judge("pyvista: edges of the wings, farthest from the record", farthest, 1e-9, "m")
    holds("pyvista: panels with a side, forces and circulation", mesh.n_cells > 10 and forces > 0 and {"circulation_m2_s"} <= set(mesh.point_data) and "side" in mesh.cell_data)


def hostile() -> None:
    """Records that no flight leaves: a page and files come of them, or one message says why not."""
    rows = len(RECORD)
    huge, lost, nowhere, odd = (RECORD.copy() for _ in range(4))
    huge.loc[rows // 2 :, ["pitch", "p_WB_z"]] = 1e300
    lost.iloc[rows // 3 :, 1:] = np.nan
    nowhere["p_WB_x"] = np.nan
    odd["quat_w"] = 1e300
    million = pd.concat([RECORD.iloc[:1000]] * 1000, ignore_index=True)
    million["t"] = 1e-3 * np.arange(len(million))
    records = {"huge": huge, "lost": lost, "nowhere": nowhere, "odd": odd, "none": RECORD.iloc[:0], "one": RECORD.iloc[:1], "million": million}
    manifest = json.loads((FOLDER / "turn" / "manifest.json").read_text())
    manifest.pop("checksums", None)
    place = FOLDER / "odd"
    shutil.rmtree(place, ignore_errors=True)
    for name, record in records.items():
        run = place / name
        run.mkdir(parents=True)
        for file in ("scenario.toml", "summary.json"):
            shutil.copy(FOLDER / "turn" / file, run)
        (run / "manifest.json").write_text(json.dumps(manifest))
        record.to_parquet(run / "record.parquet")
        asked = {"report": ["report", run, "--out", place / f"{name}.html"]}
        for form, file in {"mcap": "mcap", "gltf": "glb", "npz": "npz", "csv": "csv"}.items():
            if name != "million" or form == "gltf":
                asked[form] = ["export", run, f"--{form}", "--out", place / f"{name}.{file}"]
        for what, arguments in asked.items():
            ended = subprocess.run([os.environ["WINGBEAT"], *arguments, "--quiet"], check=False, capture_output=True, text=True, timeout=300)
            refused = ended.returncode == 2 and ended.stderr.startswith("error: ") and ended.stderr.count("\n") == 1 and not arguments[-1].exists()
            made = ended.returncode == 0 and arguments[-1].stat().st_size > 0
            holds(f"{name}: {what} is {'made' if made else 'refused: ' + ended.stderr.strip()[-60:]}", refused or made)


if __name__ == "__main__":
    mcap(FOLDER / "turn.mcap")
    arrays()
    vtk()
    hostile()
    print(f"{tally[0]} passed, {tally[1]} failed")
    sys.exit(bool(tally[1]))
