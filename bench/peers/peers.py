#!/usr/bin/env python3
"""Colours, handles and shows one map with cpplus, Open3D and CloudCompare: seconds, CPU seconds, peak memory of each.

SCENE is a folder with map.pcd (float32 x y z ...), images/, truth/ (exact poses and depth). The map is measured as it is
for colours, and laid out until it has 20 million points for the rest. Needs cloudcompare and python3-open3d, and a display
(DISPLAY of Xvfb does); for --result node, Chromium and web/node_modules. Writes OUT/peers.json and OUT/peers.md."""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "scale"))
from scale import RunFailed, write_copies  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
OPEN3D = ["/usr/bin/python3", HERE / "open3d_worker.py"]
CHECK = ["/usr/bin/python3", HERE / "color_check.py"]
LARGE_POINTS = 20_000_000
LEFT_OUT_EVERY = 8


class Bench:
    def __init__(self, out):
        self.out = out
        self.rows = []

    def run(self, group, tool, what, *command):
        """Runs a command and keeps what it took; returns the last line of its output where that is JSON."""
        log = self.out / "log.txt"
        begin = time.monotonic()
        with open(log, "w") as file:
            process = subprocess.Popen([str(part) for part in command], stdout=file, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        lines = log.read_text(errors="replace").strip().splitlines()
        if process.returncode != 0:
            raise RunFailed(f"{tool}, {what}: exit code {process.returncode}: {lines[-1:]}")
        row = {"group": group, "tool": tool, "what": what, "seconds": time.monotonic() - begin,
               "cpu_seconds": usage.ru_utime + usage.ru_stime, "peak_mb": usage.ru_maxrss / 1024.0}
        if lines and lines[-1].startswith("{"):
            row.update(json.loads(lines[-1]))
        self.rows.append(row)
        (self.out / "peers.json").write_text(json.dumps(self.rows, indent=1) + "\n")
        print(table([row]).splitlines()[-1], flush=True)
        return row

    def check(self, row, scene, cloud, left_out):
        result = subprocess.run([str(part) for part in (*CHECK, scene, cloud, "--leave-out", ",".join(left_out))],
                                capture_output=True, text=True)
        if result.returncode != 0:
            raise RunFailed(f"color_check.py {cloud}: {result.stderr.strip().splitlines()[-1:]}")
        row.update(json.loads(result.stdout))
        (self.out / "peers.json").write_text(json.dumps(self.rows, indent=1) + "\n")
        print(f"  {result.stdout.strip()}", flush=True)


def table(rows):
    lines = ["| tool | what | s | CPU s | MB | |", "|---|---|--:|--:|--:|---|"]
    known = {"group", "tool", "what", "seconds", "cpu_seconds", "peak_mb"}
    for row in rows:
        rest = ", ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
                         for key, value in row.items() if key not in known)
        lines.append(f"| {row['tool']} | {row['what']} | {row['seconds']:.1f} | {row['cpu_seconds']:.1f} | "
                     f"{row['peak_mb']:.0f} | {rest} |")
    return "\n".join(lines) + "\n"


def fresh(folder):
    shutil.rmtree(folder, ignore_errors=True)
    return folder


def measure_colors(bench, program, scene, threads):
    poses = scene / "truth" / "on_map"
    inputs = ["--map", scene / "map.pcd", "--images", scene / "images", "--poses", poses]
    common = ["--quiet", "--threads", threads]
    out = bench.out
    row = bench.run("colours", "cpplus", "colorize", program, "colorize", *inputs, *common, "--hold-out", LEFT_OUT_EVERY,
                    "--out", out / "cpplus.ply", "--report", out / "cpplus.json")
    held_out = json.loads((out / "cpplus.json").read_text())["held_out"]["images"]
    left_out = [image["name"] for image in held_out if not image["blurred"]]
    bench.check(row, scene, out / "cpplus.ply", left_out)
    row = bench.run("colours", "cpplus", "colorize, corners left dark as the photos'", program, "colorize", *inputs, *common,
                    "--hold-out", LEFT_OUT_EVERY, "--out", out / "dark.ply", "--no-color.exposure.vignetting")
    bench.check(row, scene, out / "dark.ply", left_out)
    bench.run("colours", "cpplus", "export undistorted, for Open3D", program, "export", "--format", "undistorted", *inputs,
              *common, "--out", fresh(out / "undistorted"))
    bench.run("colours", "cpplus", "export depth, for Open3D", program, "export", "--format", "depth", "--map",
              scene / "map.pcd", "--poses", out / "undistorted" / "sparse", *common, "--out", fresh(out / "depths"))
    open3d = [*OPEN3D, "color", scene / "map.pcd", out / "open3d.ply", "--model", out / "undistorted", "--leave-out",
              ",".join(left_out)]
    depths = ["--depths", out / "depths"]
    for what, more in (("color_map, depth of its own projection", []), ("color_map, depth maps of cpplus", depths),
                       ("the same, 10 iterations", [*depths, "--iterations", 10])):
        row = bench.run("colours", "Open3D", what, *open3d, *more)
        bench.check(row, scene, out / "open3d.ply", left_out)
        if not more:
            shutil.copy(out / "open3d.ply", out / "open3d_own.ply")


def measure_handling(bench, program, cloud, copy, threads):
    """Reading and writing, thinning and normals, for which cpplus has no command; its own ways to lay a cloud out."""
    out = bench.out
    convert = ["CloudCompare", "-SILENT", "-NO_TIMESTAMP", "-AUTO_SAVE", "OFF", "-C_EXPORT_FMT"]
    to_ply = [*convert, "PLY", "-PLY_EXPORT_FMT", "BINARY_LE", "-O", cloud]
    save = ["-SAVE_CLOUDS", "FILE", out / "handled.ply"]
    for what, steps, task in (("read and write", [], "copy"), ("one point in 5 cm", ["-SS", "SPATIAL", "0.05"], "subsample"),
                              ("normals, radius 10 cm", ["-OCTREE_NORMALS", "0.1"], "normals")):
        bench.run("large", "CloudCompare", what, *to_ply, *steps, *save)
        bench.run("large", "Open3D", what, *OPEN3D, task, cloud, out / "handled.ply")
    bench.run("large", "CloudCompare", "convert to .bin", *convert, "BIN", "-O", cloud, "-SAVE_CLOUDS", "FILE", copy)
    common = ["--quiet", "--threads", threads]
    bench.run("large", "cpplus", "index", program, "index", cloud, "--out", out / "large.vox", *common)


def measure_showing(bench, program, result, cloud):
    bench.run("large", "cpplus", "view in Chromium", "node", HERE / "view_speed.mjs", program, result, bench.out / "view.png",
              "--cloud", cloud)
    bench.run("large", "Open3D", "window", *OPEN3D, "show", cloud, bench.out / "open3d.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="build folder with apps/cpplus")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--result", type=pathlib.Path, help="result of refine on the scene: the viewers are measured too")
    parser.add_argument("--threads", type=int, default=2)
    settings = parser.parse_args()
    settings.out.mkdir(parents=True, exist_ok=True)
    bench = Bench(settings.out)
    program = settings.build / "apps" / "cpplus"
    cloud = settings.out / "large.ply"
    try:
        measure_colors(bench, program, settings.scene, settings.threads)
        points = bench.rows[0]["points"]
        bench.run("large", "Open3D", "lay out (makes the cloud)", *OPEN3D, "layout", settings.out / "open3d_own.ply", cloud,
                  "--copies", -(-LARGE_POINTS // points))
        measure_handling(bench, program, cloud, settings.out / "large.bin", settings.threads)
        if settings.result:
            measure_showing(bench, program, settings.result, cloud)
    except (RunFailed, OSError) as error:
        print(f"peers.py: {error}", file=sys.stderr)
        return 1
    (settings.out / "peers.md").write_text(table(bench.rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
