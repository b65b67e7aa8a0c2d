#!/usr/bin/env python3
"""How right the colours of a cloud are, whoever gave them: of a scene with exact depth, against images left out.

  seen      points that some image truly shows (range within 6 cm of the exact depth): which share has a colour?
  hidden    points that have a colour: which share lies behind the exact surface by more than 15 cm in every image that
            they project into?
  PSNR      of the points that a left-out image shows: their colours against the image's, dB

Needs numpy, and Open3D for reading images."""

import argparse
import json
import pathlib

import numpy as np
import open3d as o3d

from open3d_worker import rotation, rows_of

SEEN_M, HIDDEN_M = 0.06, 0.15
PLY_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "ushort": "<u2", "uint": "<u4", "int": "<i4"}


def read_ply(path):
    """The vertices of a binary PLY file, an array with a field a property."""
    data = path.read_bytes()
    begin = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:begin].decode().splitlines()
    if "format binary_little_endian 1.0" not in header:
        raise SystemExit(f"{path}: not a binary PLY")
    count = next(int(line.split()[2]) for line in header if line.startswith("element vertex"))
    fields = [line.split()[1:] for line in header if line.startswith("property") and "list" not in line]
    return np.frombuffer(data, np.dtype([(name, PLY_TYPES[kind]) for kind, name in fields]), count, begin)


def project(camera, x):
    """Pixels (centre of the top-left pixel = 0, 0) of points in the frame of an OPENCV camera, which lie in front."""
    fx, fy, cx, cy, k1, k2, p1, p2 = camera
    a, b = x[:, 0] / x[:, 2], x[:, 1] / x[:, 2]
    r2 = a * a + b * b
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)
    v = b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b
    return np.stack([fx * u + cx - 0.5, fy * v + cy - 0.5], 1)


def bilinear(image, pixels):
    x0 = np.clip(np.floor(pixels).astype(int), 0, [image.shape[1] - 2, image.shape[0] - 2])
    f = (pixels - x0)[:, :, None]
    at = lambda dx, dy: image[x0[:, 1] + dy, x0[:, 0] + dx].astype(np.float64)
    return (at(0, 0) * (1 - f[:, 0]) + at(1, 0) * f[:, 0]) * (1 - f[:, 1]) + \
           (at(0, 1) * (1 - f[:, 0]) + at(1, 1) * f[:, 0]) * f[:, 1]


class View:
    """Which points of a cloud an image shows, by the exact depth, and where."""

    def __init__(self, scene, row, cameras, points):
        _, model, width, height, *numbers = cameras[row[8]]
        if model != "OPENCV":
            raise SystemExit(f"{scene}: camera {row[8]} is {model}, not OPENCV")
        x = points @ rotation([float(v) for v in row[1:5]]).T + [float(v) for v in row[5:8]]
        camera = [float(v) for v in numbers]
        pixels = np.full((len(x), 2), -1.0)
        # Beyond the field of view the distortion folds back into the image.
        ahead = (x[:, 2] > 0.1) & (np.hypot(x[:, 0], x[:, 1]) < 1.2 * x[:, 2])
        pixels[ahead] = project(camera, x[ahead])
        inside = ahead & np.all((pixels >= 2) & (pixels <= [int(width) - 3, int(height) - 3]), 1)
        depth = np.load(scene / "truth" / "depth" / f"{pathlib.Path(row[9]).stem}.npz")["range"].astype(np.float32)
        cell = np.clip(np.rint((pixels - 1.5) / 4).astype(int), 0, [depth.shape[1] - 1, depth.shape[0] - 1])
        exact = depth[cell[:, 1], cell[:, 0]]
        behind = np.linalg.norm(x, axis=1) - exact
        self.name, self.pixels = row[9], pixels
        self.is_seen = inside & (exact > 0) & (np.abs(behind) < SEEN_M)
        self.is_not_hidden = inside & ~((exact > 0) & (behind > HIDDEN_M))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path, help="folder with images/ and truth/")
    parser.add_argument("cloud", type=pathlib.Path, help="coloured cloud, binary PLY")
    parser.add_argument("--leave-out", default="", help="names of the images that gave no colours, with commas")
    arguments = parser.parse_args()
    left_out = set(filter(None, arguments.leave_out.split(",")))
    cloud = read_ply(arguments.cloud)
    points = np.stack([cloud[name] for name in ("x", "y", "z")], 1).astype(np.float64)
    colors = np.stack([cloud[name] for name in ("red", "green", "blue")], 1).astype(np.float64)
    # What cpplus writes says which points have a colour; others leave those that have none black.
    is_colored = cloud["num_views"] > 0 if "num_views" in cloud.dtype.names else colors.max(1) > 0
    model = arguments.scene / "truth" / "on_map"
    cameras = {row[0]: row for row in rows_of(model / "cameras.txt")}
    rows = [row for row in rows_of(model / "images.txt") if len(row) == 10 and row[8] in cameras]
    is_seen, is_not_hidden = np.zeros(len(points), bool), np.zeros(len(points), bool)
    errors = []
    for row in rows:
        view = View(arguments.scene, row, cameras, points)
        if view.name not in left_out:
            is_seen |= view.is_seen
            is_not_hidden |= view.is_not_hidden
            continue
        photo = np.asarray(o3d.io.read_image(str(arguments.scene / "images" / view.name)))
        compared = view.is_seen & is_colored
        errors.append(colors[compared] - bilinear(photo, view.pixels[compared]))
    squares = np.concatenate(errors) ** 2 if errors else np.zeros((0, 3))
    print(json.dumps({
        "points": len(points), "colored": round(float(is_colored.mean()), 4),
        "seen_colored": round(float(is_colored[is_seen].mean()), 4),
        "hidden_of_colored": round(float((~is_not_hidden[is_colored]).mean()), 4),
        "compared": len(squares), "psnr_db": round(float(10 * np.log10(255.0 ** 2 / squares.mean())), 2),
        "median_error": round(float(np.median(np.sqrt(squares.mean(1)))), 2)}))


if __name__ == "__main__":
    main()
