#!/usr/bin/env python3
"""Scale benchmark: how time and memory of `cpplus index`, `refine` and `colorize` grow with the map.

A simulated world is laid out again and again on a grid, far enough apart that its images see the first copy alone; so
the map grows while what an image sees stays the same. With --spread every copy has its images, whose number grows with
the map; with --images-in-all N as well copy k of n has the k-th n-th of the first N images alone. --world takes another
world than the rooms, such as a district. With --district simulated city districts of these areas take the place of copies, with --images images all
over each. Writes OUT/scale.json and OUT/scale.md (scale_spread, scale_district). Memory is the anonymous memory of the process at its
highest: what it holds itself, without the pages of mapped files, which the system may drop. Needs nothing but Python's
standard library."""

import argparse
import array
import datetime
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

POLL_S = 0.02
GAP_M = 60.0  # between copies: no image sees the next one


class RunFailed(Exception):
    """The program ended with an error; the text is its last line."""


def read_pcd(path):
    """(header lines, floats, floats a point) of a binary PCD of float32 fields that begin with x y z."""
    data = path.read_bytes()
    begin = data.index(b"DATA binary\n") + len(b"DATA binary\n")
    header = data[:begin].decode().splitlines()
    fields = next(line for line in header if line.startswith("FIELDS")).split()[1:]
    types = set(next(line for line in header if line.startswith("TYPE")).split()[1:])
    sizes = set(next(line for line in header if line.startswith("SIZE")).split()[1:])
    if fields[:3] != ["x", "y", "z"] or types != {"F"} or sizes != {"4"}:
        raise RunFailed(f"{path}: not a PCD of float32 fields x y z ...")
    values = array.array("f")
    values.frombytes(data[begin:])
    return header, values, len(fields)


def copy_offsets(size, copies):
    """Where each copy lies, x and y, on a square grid."""
    columns = next(n for n in range(1, copies + 1) if n * n >= copies)
    return [(copy % columns * size[0], copy // columns * size[1]) for copy in range(copies)]


def write_copies(source, target, copies):
    """The cloud `copies` times. Returns the number of points and the offsets of the copies."""
    header, values, width = read_pcd(source)
    count = len(values) // width
    size = [max(values[axis::width]) - min(values[axis::width]) + GAP_M for axis in range(2)]
    offsets = copy_offsets(size, copies)
    total = str(copies * count)
    changed = {"WIDTH": total, "POINTS": total, "HEIGHT": "1"}
    with open(target, "wb") as file:
        for line in header:
            key = line.split(" ")[0]
            file.write((f"{key} {changed[key]}" if key in changed else line).encode() + b"\n")
        for offset in offsets:
            moved = array.array("f", values)
            for axis in range(2):
                if offset[axis]:
                    moved[axis::width] = array.array("f", (v + offset[axis] for v in values[axis::width]))
            file.write(moved.tobytes())
    return copies * count, offsets


def rotate(quaternion_wxyz, vector):
    w, x, y, z = quaternion_wxyz
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
    return [sum(a * b for a, b in zip(row, vector)) for row in rows]


def write_spread_images(world, folder, offsets, images_in_all):
    """Links to the world's images in a folder a copy, folder/images/COPY/NAME, and folder/coarse with their poses."""
    (folder / "coarse").mkdir(parents=True, exist_ok=True)
    coarse = world / "coarse_small"
    (folder / "coarse" / "cameras.txt").write_bytes((coarse / "cameras.txt").read_bytes())
    (folder / "coarse" / "points3D.txt").write_text("")
    lines = [line.split() for line in (coarse / "images.txt").read_text().splitlines()
             if line and not line.startswith("#")]
    posed = [words for words in lines if len(words) == 10]
    with open(folder / "coarse" / "images.txt", "w") as file:
        for copy, offset in enumerate(offsets):
            link = folder / "images" / f"{copy:03d}"
            link.parent.mkdir(exist_ok=True)
            if not link.is_symlink():
                link.symlink_to((world / "images").resolve())
            first, end = 0, len(posed)
            if images_in_all:
                first, end = (images_in_all * part // len(offsets) for part in (copy, copy + 1))
            for k, words in list(enumerate(posed))[first:end]:
                # x_in_camera = R x + t is to stay the same for x + offset.
                turned = rotate([float(word) for word in words[1:5]], (*offset, 0.0))
                moved = [repr(float(t) - r) for t, r in zip(words[5:8], turned)]
                image_id = str(copy * len(posed) + k + 1)
                file.write(" ".join([image_id, *words[1:5], *moved, words[8], f"{copy:03d}/{words[9]}"]) + "\n\n")


def anonymous_mb(pid):
    try:
        with open(f"/proc/{pid}/status") as status:
            for line in status:
                if line.startswith("RssAnon:"):
                    return int(line.split()[1]) / 1024.0
    except OSError:
        pass
    return 0.0


def run(log, *command):
    """Seconds, CPU seconds and peak anonymous MB of a command; its output goes to `log`."""
    begin = time.monotonic()
    peak_mb = 0.0
    with open(log, "w") as file:
        process = subprocess.Popen([str(part) for part in command], stdout=file, stderr=subprocess.STDOUT)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            peak_mb = max(peak_mb, anonymous_mb(process.pid))
            time.sleep(POLL_S)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RunFailed(f"{command[1]}: exit code {process.returncode}: {log.read_text().strip().splitlines()[-1:]}")
    return {"seconds": time.monotonic() - begin, "cpu_seconds": usage.ru_utime + usage.ru_stime, "peak_mb": peak_mb}


def measure_copies(program, world, out, copies, threads, spread, images_in_all):
    folder = out / f"{'spread' if spread else 'x'}{copies}"
    folder.mkdir(parents=True, exist_ok=True)
    cloud = folder / "map.pcd"
    points, offsets = write_copies(world / "map.pcd", cloud, copies)
    images, coarse = (world / "images", world / "coarse_small")
    stamps = ["--stamps", world / "stamps.txt"]
    if spread:
        write_spread_images(world, folder, offsets, images_in_all)
        images, coarse, stamps = folder / "images", folder / "coarse", []  # the sequence jumps from copy to copy
    row = {"copies": copies, "points": points}
    row.update(measure_commands(program, folder, cloud, images, coarse, stamps, threads))
    cloud.unlink()
    return row


def num_points(pcd):
    with open(pcd, "rb") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(b"POINTS"))


def measure_district(program, out, area_km2, images, threads):
    folder = out / f"district{area_km2:g}"
    folder.mkdir(parents=True, exist_ok=True)
    world = folder / "world"
    row = {"area_km2": area_km2}
    if not (world / "map.pcd").exists():
        row["simulate"] = run(folder / "simulate.log", program, "simulate", "--scene", "district", "--area", area_km2,
                              "--seed", 1, "--images", images, "--out", world, "--quiet", "--threads", threads)
    row["points"] = num_points(world / "map.pcd")
    stamps = ["--stamps", world / "stamps.txt"]
    row.update(measure_commands(program, folder, world / "map.pcd", world / "images", world / "coarse_small", stamps,
                                threads))
    return row


def measure_commands(program, folder, cloud, images, coarse, stamps, threads):
    row = {}
    index = folder / "map.vox"
    common = ["--quiet", "--threads", threads]
    inputs = ["--map", index, "--images", images]
    row["index"] = run(folder / "index.log", program, "index", cloud, "--out", index, *common)
    # The first one finds planes and edges around the images, the second one reads them.
    for stage in ("refine", "refine_again"):
        row[stage] = run(folder / f"{stage}.log", program, "refine", *inputs, "--poses", coarse, "--out",
                         folder / "refined", *stamps, *common)
    reports = json.loads((folder / "refined" / "report.json").read_text())["images"]
    row["images"] = len(reports)
    row["image_ms"] = sum(report["milliseconds"]["total"] for report in reports) / len(reports)
    row["colorize"] = run(folder / "colorize.log", program, "colorize", *inputs, "--poses",
                          folder / "refined" / "sparse", "--out", folder / "colored.pcd", *common)
    index.unlink()
    shutil.rmtree(f"{index}.features", ignore_errors=True)
    (folder / "colored.pcd").unlink()
    return row


def table(rows):
    lines = ["| million points | images | index s (CPU), MB | refine s (CPU), MB | again | ms an image | "
             "colorize s (CPU), MB |", "|--:|--:|--:|--:|--:|--:|--:|"]
    for row in rows:
        cells = [f"{row[stage]['seconds']:.1f} ({row[stage]['cpu_seconds']:.1f}), {row[stage]['peak_mb']:.0f}"
                 for stage in ("index", "refine", "refine_again", "colorize")]
        lines.append(f"| {row['points'] / 1e6:.1f} | {row['images']} | {cells[0]} | {cells[1]} | {cells[2]} | "
                     f"{row['image_ms']:.0f} | {cells[3]} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="build folder with apps/cpplus")
    parser.add_argument("out", type=pathlib.Path, help="folder for worlds, logs and tables")
    parser.add_argument("--copies", default="1,10,50", help="sizes of the map in copies of the world (default 1,10,50)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--district", metavar="KM2,...", help="areas of simulated districts, in place of copies")
    parser.add_argument("--images", type=int, default=200, help="of each district (default 200)")
    parser.add_argument("--world", type=pathlib.Path, help="folder that cpplus simulate wrote (default: rooms)")
    parser.add_argument("--images-in-all", type=int, help="of a spread map (default: those of the world for each copy)")
    parser.add_argument("--spread", action="store_true", help="every copy has its images, not the first one alone")
    settings = parser.parse_args()
    program = settings.build / "apps" / "cpplus"
    world = settings.world or settings.out / "world"
    rows = []
    try:
        settings.out.mkdir(parents=True, exist_ok=True)
        if not settings.district and not (world / "map.pcd").exists():
            run(settings.out / "simulate.log", program, "simulate", "--scene", "rooms", "--seed", 1, "--out", world)
        for size in (settings.district or settings.copies).split(","):
            if settings.district:
                rows.append(measure_district(program, settings.out, float(size), settings.images, settings.threads))
            else:
                rows.append(measure_copies(program, world, settings.out, int(size), settings.threads, settings.spread,
                                           settings.images_in_all))
            report = {"date": datetime.date.today().isoformat(), "machine": platform.processor() or platform.machine(),
                      "threads": settings.threads, "rows": rows}
            name = "scale_district" if settings.district else "scale_spread" if settings.spread else "scale"
            (settings.out / f"{name}.json").write_text(json.dumps(report, indent=1) + "\n")
            (settings.out / f"{name}.md").write_text(table(rows))
            print(table(rows[-1:]).splitlines()[-1], flush=True)
    except (RunFailed, OSError) as error:
        print(f"scale.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
