#!/usr/bin/env python3
"""The experiments of the CP+ paper on simulated sites: checkerboard residual (Eq. 6) before and after refine.

Two devices walk through four sites with checkerboards; from the true poses come starts with the errors of VINS-Mono,
LIO-SAM, R2LIVE and R3LIVE (odometry_starts.py), and each is refined. Writes OUT/paper_experiments.json and .md and a
bar chart for each device, and keeps worlds and runs in OUT/worlds; worlds that are there already are used again. The
exit code is 1 when a run failed. docs/paper_experiments.md tells the choices. Needs nothing but Python's standard
library."""

import argparse
import concurrent.futures
import datetime
import json
import pathlib
import resource
import statistics
import struct
import sys
from dataclasses import dataclass

import bar_chart
import figures
import odometry_starts
import poses
import quality

WIDTH, HEIGHT, NUM_IMAGES = 640, 480, 20
READOUT_S = 0.02
BEAMS_OF_A_SCAN = 16 * 450


@dataclass(frozen=True)
class Site:
    """A scene of `cpplus simulate`; `scans` makes the LiDAR's poses come at about 10 Hz."""

    scene: str
    seed: int
    scans: int
    boards: int


SITES = (Site("rooms", 1, 300, 6), Site("hall", 1, 400, 4), Site("street", 1, 300, 6), Site("corridor", 1, 110, 3))

DEVICES = {
    "spinning_fisheye": ("--camera", "OPENCV_FISHEYE", "--render.readout-s", READOUT_S, "--lidar.pattern", "spinning",
                         "--lidar.rings", 16, "--lidar.azimuth-steps", BEAMS_OF_A_SCAN // 16),
    "solid_state_wide": ("--camera", "OPENCV", "--lidar.pattern", "solid_state", "--lidar.beams", BEAMS_OF_A_SCAN),
}
DEVICE_TITLES = {"spinning_fisheye": "Spinning LiDAR, 180° fisheye with rolling shutter",
                 "solid_state_wide": "Solid-state LiDAR, 75° camera with global shutter"}
START_TITLES = {"vins_mono": "VINS-Mono", "lio_sam": "LIO-SAM", "r2live": "R2LIVE", "r3live": "R3LIVE"}
# The 2D-3D column of the paper: line matching (Yu et al. 2020) from the poses of VINS-Mono.
LINES_TITLE = "2D-3D"


def simulate(program, site, device, world):
    if (world / "truth" / "checkerboards.json").exists():  # written last but one
        return
    program.run(world.with_suffix(".log"), "simulate", "--scene", site.scene, "--seed", site.seed, "--images",
                NUM_IMAGES, "--scans", site.scans, "--boards", site.boards, "--width", WIDTH, "--height", HEIGHT,
                *DEVICES[device], "--out", world)


def write_detectable_boards(world, out):
    """The boards' file without the views in which a detector would not find the corners."""
    document = json.loads((world / "truth" / "checkerboards.json").read_text())
    for board in document["boards"]:
        board["images"] = {name: view for name, view in board["images"].items() if view["detectable"]}
    out.write_text(json.dumps(document))


def write_rig(world, file, time_offset_s):
    """The true extrinsic with a clock error, for `cpplus poses`."""
    rows = json.loads((world / "truth" / "extrinsic.json").read_text())["T_lidar_cam"]
    inverse = []
    for i in range(3):
        column = [rows[k][i] for k in range(3)]
        inverse += [*column, -sum(column[k] * rows[k][3] for k in range(3))]
    camera = next(line for line in (world / "truth" / "cameras.txt").read_text().splitlines() if line[0] != "#").split()
    file.write_text(f"trajectory_frame: lidar\ncameras:\n  camera:\n    model: {camera[1]}\n    width: {camera[2]}\n"
                    f"    height: {camera[3]}\n    params: [{', '.join(camera[4:])}]\n"
                    f"    camera_from_lidar: {{matrix: {inverse}}}\n    time_offset_s: {time_offset_s}\n")


def read_stamps(file):
    return {name: float(stamp) for name, stamp in (line.split() for line in file.read_text().splitlines())}


def make_start(program, world, errors, seed, out):
    """A model with the poses that an odometry with these errors would give."""
    out.mkdir(parents=True, exist_ok=True)
    write_rig(world, out / "rig.yaml", errors.time_offset_s)
    program.run(out / "late.log", "poses", "--trajectory", world / "truth" / "scan_poses.txt", "--rig",
                out / "rig.yaml", "--images", world / "images", "--stamps", world / "stamps.txt", "--out", out / "late")
    late = sorted(poses.read_images(out / "late"), key=lambda image: image.name)
    start = odometry_starts.odometry_start(late, read_stamps(world / "stamps.txt"), errors, seed)
    poses.write_model(out / "start", start, world / "truth")
    return out / "start"


def floor_area_m2(map_file):
    """Area of the 50 cm cells in which the map has a point less than 20 cm from the floor's level, z = 0."""
    data = map_file.read_bytes()
    begin = data.index(b"DATA binary\n") + len(b"DATA binary\n")
    header = data[:begin].decode()
    fields = next(line.split()[1:] for line in header.splitlines() if line.startswith("FIELDS"))
    count = next(int(line.split()[1]) for line in header.splitlines() if line.startswith("POINTS"))
    values = struct.iter_unpack("<" + "f" * len(fields), data[begin:begin + 4 * len(fields) * count])
    return 0.25 * len({(x // 0.5, y // 0.5) for x, y, z, *_ in values if abs(z) < 0.2})


def values_of(evaluation, key):
    return {i["name"]: i[key] for i in evaluation["images"] if i[key] is not None}


def quartiles(values):
    """(first quartile, median, third quartile), or None of nothing."""
    values = list(values)
    if len(values) < 2:
        return (values[0],) * 3 if values else None
    return tuple(statistics.quantiles(values, n=4, method="inclusive"))


def summarize(before, after, report):
    """Residuals over the images in which a board was found, shifts over all that have one."""
    status = {image["name"]: image["status"] for image in report["images"]}
    board = [values_of(evaluation, "checkerboard_residual_px") for evaluation in (before, after)]
    shift = [values_of(evaluation, "mean_shift_px") for evaluation in (before, after)]
    names = sorted(shift[0].keys() & shift[1].keys())
    accepted = [name for name in names if status.get(name) == "refined"]
    return {
        "num_board_images": len(board[0]),
        "board_before_px": quartiles(board[0].values()),
        "board_after_px": quartiles(board[1].values()),
        "shift_before_px": quartiles(shift[0].values()),
        "shift_after_px": quartiles(shift[1].values()),
        "num_images": len(names),
        "num_accepted": len(accepted),
        "num_accepted_worse": sum(shift[1][n] > shift[0][n] + figures.WORSE_MARGIN_PX for n in accepted),
        "images": [{"name": n, "status": status.get(n, "missing"), "shift_px": [s[n] for s in shift],
                    "board_px": [b.get(n) for b in board]} for n in names],
    }


def refine_run(program, world, start, out, options):
    """The figures of one start."""
    measure = ["--depth", world / "truth" / "depth", "--depth-poses", world / "truth", "--exclude",
               world / "truth" / "blurred.txt", "--checkerboards", world / "boards.json"]
    before, after, report, seconds, _ = quality.refine_once(program, world, out, world / "images", start,
                                                            world / "truth" / "on_map", options, measure)
    return {**summarize(before, after, report), "wall_seconds": seconds}


def run_world(program, site, device, folder, seed):
    """All starts of one device at one site, and the residual of the poses that fit the map best."""
    world = folder / f"{site.scene}_{device}"
    result = {"site": site.scene, "seed": site.seed, "device": device, "runs": {}, "error": ""}
    try:
        simulate(program, site, device, world)
        write_detectable_boards(world, world / "boards.json")
        result["floor_m2"] = floor_area_m2(world / "map.pcd")
        best = program.evaluate(world / "best.json", world / "truth" / "on_map", world / "truth", "--exclude",
                                world / "truth" / "blurred.txt", "--checkerboards", world / "boards.json")
        result["board_best_px"] = quartiles(values_of(best, "checkerboard_residual_px").values())
        joint = ["--stamps", world / "stamps.txt", "--trajectory", world / "scans" / "poses.txt"]
        for number, (name, errors) in enumerate(odometry_starts.ODOMETRIES.items()):
            out = world / "runs" / name
            start = make_start(program, world, errors, 1000 * seed + 10 * site.seed + number, out)
            result["runs"][name] = refine_run(program, world, start, out / "refined", joint)
            if name == "vins_mono":
                result["runs"]["lines"] = refine_run(program, world, start, out / "lines", ["--method", "lines"])
    except (quality.RunFailed, OSError, KeyError, ValueError) as error:
        result["error"] = str(error).replace("|", "/")
    return result


def three(values):
    """median [first quartile, third quartile]"""
    return "–" if values is None else f"{values[1]:.2f} [{values[0]:.2f}, {values[2]:.2f}]"


def markdown(results):
    lines = [f"{results['date']}, {results['machine']}, cpplus {results['version']}, {results['cpu_seconds']:.0f} s "
             "of CPU in all.\n"]
    for device, title in DEVICE_TITLES.items():
        lines += [f"\n{title}:\n\n| site (floor) | start | images with boards | residual before px | after px "
                  "| best px | shift before px | after px | accepted | accepted, but worse |\n"
                  "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n"]
        for world in (w for w in results["worlds"] if w["device"] == device):
            if world["error"]:
                lines.append(f"| {world['site']} | failed: {world['error']} |" + " |" * 8 + "\n")
            for name, run in world["runs"].items():
                shifts = [figures.number(run[key] and run[key][1], 2) for key in ("shift_before_px", "shift_after_px")]
                cells = [f"{world['site']} ({world['floor_m2']:.0f} m²)", START_TITLES.get(name, LINES_TITLE),
                         str(run["num_board_images"]), three(run["board_before_px"]), three(run["board_after_px"]),
                         figures.number(world["board_best_px"] and world["board_best_px"][1], 2), *shifts,
                         f"{run['num_accepted']} of {run['num_images']}", str(run["num_accepted_worse"])]
                lines.append("| " + " | ".join(cells) + " |\n")
    return "".join(lines)


COLORS = {"VINS-Mono": "#bbbbbb", "2D-3D": "#d9a441", "VINS-Mono + CP+": "#666666", "LIO-SAM": "#a8c8ea",
          "LIO-SAM + CP+": "#1f5fa8", "R2LIVE": "#b9e0b4", "R2LIVE + CP+": "#2e7d32", "R3LIVE": "#f2b8b0",
          "R3LIVE + CP+": "#b23a2e"}


def chart_bars(world):
    bars = []
    for name, title in START_TITLES.items():
        run = world["runs"].get(name)
        pairs = [(title, run and run["board_before_px"]), (f"{title} + CP+", run and run["board_after_px"])]
        if name == "vins_mono":
            lines = world["runs"].get("lines")
            pairs.insert(1, (LINES_TITLE, lines and lines["board_after_px"]))
        bars += [bar_chart.Bar(series, values[1], values[0], values[2]) for series, values in pairs if values]
    return bars


def write_charts(results, out):
    for device, title in DEVICE_TITLES.items():
        groups = {w["site"]: chart_bars(w) for w in results["worlds"] if w["device"] == device}
        if any(groups.values()):
            chart = bar_chart.svg(title, "checkerboard residual, px (median, quartiles)", groups, COLORS)
            (out / f"paper_{device}.svg").write_text(chart)


def write_results(results, out):
    """Tables and charts of the worlds that are done."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    results["cpu_seconds"] = usage.ru_utime + usage.ru_stime
    (out / "paper_experiments.json").write_text(json.dumps(results, indent=1) + "\n")
    (out / "paper_experiments.md").write_text(markdown(results))
    write_charts(results, out)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path, help="build folder (with apps/cpplus), or the cpplus binary itself")
    parser.add_argument("out", type=pathlib.Path, help="folder for worlds, runs, tables and charts")
    parser.add_argument("--site", action="append", default=[], choices=[site.scene for site in SITES],
                        help="only this site (may be repeated)")
    parser.add_argument("--device", action="append", default=[], choices=list(DEVICES),
                        help="only this device (may be repeated)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the starts' errors")
    parser.add_argument("--jobs", type=int, default=1, help="worlds at once, each with one thread")
    return parser.parse_args()


def main():
    settings = parse_arguments()
    binary = settings.build if settings.build.is_file() else settings.build / "apps" / "cpplus"
    if not binary.is_file():
        sys.exit(f"{binary}: no such program; build it first")
    program = quality.Program(binary.resolve(), 1)
    worlds_folder = settings.out / "worlds"
    worlds_folder.mkdir(parents=True, exist_ok=True)
    worlds = [(site, device) for site in SITES if not settings.site or site.scene in settings.site
              for device in DEVICES if not settings.device or device in settings.device]
    results = {"date": datetime.date.today().isoformat(), "machine": quality.machine(), "version": program.version(),
               "worlds": []}
    with concurrent.futures.ThreadPoolExecutor(settings.jobs) as pool:
        for world in pool.map(lambda w: run_world(program, *w, worlds_folder.resolve(), settings.seed), worlds):
            results["worlds"].append(world)
            write_results(results, settings.out)
    print(markdown(results), end="")
    return 1 if any(world["error"] for world in results["worlds"]) else 0


if __name__ == "__main__":
    sys.exit(main())
