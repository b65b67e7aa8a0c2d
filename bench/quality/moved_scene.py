"""A scene with exact truth, moved: the same map and poses elsewhere relative to the voxel grid.

What leaves of the grid a surface falls into decides which planes and edges are found. A result that holds in one place
of the grid only is luck. Maps: PCD files, binary, with x y z as 32-bit floats."""

import struct

import poses

MODELS = ("coarse_small", "coarse_medium", "coarse_large", "truth", "truth/on_map")


def read_header(cloud):
    """(header text, where each of x, y, z lies in a point, bytes of a point)."""
    header = b""
    with open(cloud, "rb") as file:
        for line in file:
            header += line
            if line.startswith(b"DATA"):
                break
    lines = {line.split()[0]: line.split()[1:] for line in header.decode().splitlines() if not line.startswith("#")}
    if lines["DATA"] != ["binary"]:
        raise ValueError(f"{cloud}: not a binary PCD file")
    sizes = [int(size) * int(count) for size, count in zip(lines["SIZE"], lines.get("COUNT", ["1"] * 100))]
    places = {name: sum(sizes[:k]) for k, name in enumerate(lines["FIELDS"])}
    return header, [places[axis] for axis in "xyz"], sum(sizes)


def move_cloud(cloud, out, offset_m):
    header, places, stride = read_header(cloud)
    points = bytearray(cloud.read_bytes()[len(header):])
    for place, step in zip(places, offset_m):
        for at in range(place, len(points) // stride * stride, stride):
            struct.pack_into("<f", points, at, struct.unpack_from("<f", points, at)[0] + step)
    out.write_bytes(header + points)


def moved_pose(pose, offset_m):
    """The pose of the same camera in a map moved by offset_m: t' = t - R offset."""
    return poses.Pose(pose.q, tuple(t - r for t, r in zip(pose.t, poses.rotate(pose.q, offset_m))))


def move_trajectory(tum, out, offset_m):
    lines = []
    for line in tum.read_text().splitlines():
        fields = line.split()
        if line.startswith("#") or len(fields) < 8:
            continue
        place = [float(value) + step for value, step in zip(fields[1:4], offset_m)]
        lines.append(" ".join([fields[0], *map(repr, place), *fields[4:]]))
    out.write_text("\n".join(lines) + "\n")


def write_moved(scene, out, offset_m):
    """Writes what the benchmark needs of a scene; images, stamps and true depths are linked to."""
    (out / "truth").mkdir(parents=True, exist_ok=True)
    move_cloud(scene / "map.pcd", out / "map.pcd", offset_m)
    for model in MODELS:
        if (scene / model).is_dir():
            images = [poses.Image(moved_pose(i.pose, offset_m), i.camera_id, i.name)
                      for i in poses.read_images(scene / model)]
            poses.write_model(out / model, images, scene / model)
    if (scene / "scans" / "poses.txt").exists():
        (out / "scans").mkdir(exist_ok=True)
        move_trajectory(scene / "scans" / "poses.txt", out / "scans" / "poses.txt", offset_m)
    for shared in ("images", "stamps.txt", "truth/depth", "truth/blurred.txt"):
        if (scene / shared).exists() and not (out / shared).exists():
            (out / shared).symlink_to((scene / shared).resolve())
