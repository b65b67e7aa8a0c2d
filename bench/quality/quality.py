#!/usr/bin/env python3
"""Quality benchmark: runs every scene of a data folder through `cpplus refine`, `evaluate` and `colorize`.

Writes OUT/quality.json and OUT/quality.md; the models, reports and logs of the runs stay in OUT/runs. The exit code is
1 when a run failed. Needs nothing but Python's standard library."""

import argparse
import datetime
import json
import os
import pathlib
import platform
import random
import re
import shlex
import subprocess
import sys
import time
import zlib

import figures
import moved_scene
import poses


class RunFailed(Exception):
    """The program ended with an error; the text is its last line."""


class Program:
    """The built cpplus; keeps the log of each call and measures time and peak memory."""

    def __init__(self, binary, threads):
        self.binary = str(binary)
        self.threads = threads

    def version(self):
        return subprocess.run([self.binary, "--version"], capture_output=True, text=True).stdout.strip() or "unknown"

    def run(self, log, *arguments):
        """Returns (seconds, peak MB); standard output and error go to the file `log`."""
        command = [self.binary, *map(str, arguments), "--threads", str(self.threads)]
        log.parent.mkdir(parents=True, exist_ok=True)
        begin = time.monotonic()
        with open(log, "w") as file:
            file.write(" ".join(command) + "\n")
            file.flush()
            process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - begin
        if process.returncode != 0:
            last_line = log.read_text().strip().splitlines()[-1]
            raise RunFailed(f"exit code {process.returncode}: {last_line}")
        return seconds, usage.ru_maxrss / 1024.0

    def evaluate(self, out, estimate, reference, *arguments):
        self.run(out.with_suffix(".log"), "evaluate", "--estimate", estimate, "--reference", reference, *arguments,
                 "--json", out)
        return json.loads(out.read_text())


def refine_once(program, scene, out, images, start, reference, refine_options, measure_options):
    """Refines from `start` and measures start and result against `reference`: (evaluation before, evaluation after,
    report.json, seconds, peak MB)."""
    seconds, peak_mb = program.run(out / "refine.log", "refine", "--map", scene / "map.pcd", "--images", images,
                                   "--poses", start, "--out", out, *refine_options)
    before = program.evaluate(out / "before.json", start, reference, *measure_options)
    after = program.evaluate(out / "after.json", out / "sparse", reference, *measure_options)
    return before, after, json.loads((out / "report.json").read_text()), seconds, peak_mb


def refine_run(kind, scene, start_name, trials, method="cp_plus"):
    """One row of the table: the images of all `trials`, functions that return what refine_once() does, together."""
    run = {"scene": scene.name, "start": start_name, "kind": kind, "method": method, "error": "", "figures": None,
           "peak_mb": None, "seconds": None}
    try:
        results = [trial() for trial in trials]
        before, after, reports = (figures.merge(r[k] for r in results) for k in range(3))
        run["seconds"] = sum(r[3] for r in results)
        run["peak_mb"] = max(r[4] for r in results)
        run["figures"] = figures.summarize(before, after, reports)
    except (RunFailed, OSError, KeyError, ValueError) as error:
        run["error"] = str(error).replace("|", "/")
    return run


def copies_of(scene, out, settings):
    """The scene itself, or where copies are asked for these, each moved to another place of the voxel grid."""
    if settings.moved == 0:
        return [scene]
    generator = random.Random(settings.seed + zlib.crc32(scene.name.encode()))
    copies = []
    for number in range(settings.moved):
        copy = out / scene.name / f"moved{number}"
        moved_scene.write_moved(scene, copy, [generator.uniform(0.0, 2.0) for _ in range(3)])
        copies.append(copy)
    return copies


def truth_runs(program, scene, out, settings, method="cp_plus"):
    """A scene with exact truth, from each of its coarse starts (of those asked for)."""
    copies = copies_of(scene, out, settings)
    for start in starts_of(scene, settings):
        yield refine_run("truth", scene, start,
                         [lambda c=copy: truth_run(program, c, out / scene.name / start / c.name, start, settings, method)
                          for copy in copies], method)


def starts_of(scene, settings):
    names = [path.name for path in scene.glob("coarse_*")]
    by_size = {"coarse_small": 0, "coarse_medium": 1, "coarse_large": 2}
    return [name for name in sorted(names, key=lambda n: (by_size.get(n, 3), n))
            if not settings.start or name in settings.start]


def truth_run(program, scene, out, start, settings, method):
    options = shlex.split(settings.refine)
    if (scene / "stamps.txt").exists():
        options += ["--stamps", scene / "stamps.txt"]
    if (scene / "scans" / "poses.txt").exists():
        options += ["--trajectory", scene / "scans" / "poses.txt"]
    measure = ["--depth", scene / "truth" / "depth", "--depth-poses", scene / "truth"]
    if (scene / "truth" / "blurred.txt").exists():
        measure += ["--exclude", scene / "truth" / "blurred.txt"]
    if method != "cp_plus":
        options += ["--method", method]
    return refine_once(program, scene, out, scene / "images", scene / start, scene / "truth" / "on_map", options, measure)


def method_runs(program, scene, out, settings):
    """A scene with exact truth by each method of the comparison; cp_plus is in the first table already."""
    for method in settings.methods:
        if method != "cp_plus":
            yield from truth_runs(program, scene, out / method, settings, method)


def recorded_runs(program, scene, out, settings):
    """A recorded scene: each trial is a run of its own, so that images of one trial tell nothing to those of another."""
    generator = random.Random(settings.seed + zlib.crc32(scene.name.encode()))
    images = poses.read_images(scene / "reference")

    def trial(number):
        folder = out / scene.name / f"t{number:02d}"
        poses.write_model(folder / "start", poses.disturbed(images, settings.angle_deg, settings.distance_m, generator),
                          scene / "reference")
        return refine_once(program, scene, folder, scene / "images", folder / "start", scene / "reference",
                           shlex.split(settings.refine), ["--map", scene / "map.pcd"])

    yield refine_run("recorded", scene, f"{settings.angle_deg:g}°, {100 * settings.distance_m:g} cm",
                     [lambda n=number: trial(n) for number in range(settings.trials)])


def colorize_run(program, scene, model, out):
    run = {"scene": scene.name, "error": "", "share_colored": None, "seconds": None, "peak_mb": None}
    log = out / scene.name / "colorize.log"
    try:
        run["seconds"], run["peak_mb"] = program.run(log, "colorize", "--map", scene / "map.pcd", "--images",
                                                     scene / "images", "--poses", model, "--out",
                                                     out / scene.name / "colored.ply")
        counts = re.search(r"(\d+) of (\d+) points coloured", log.read_text())
        if counts:
            run["share_colored"] = int(counts[1]) / int(counts[2])
    except (RunFailed, OSError) as error:
        run["error"] = str(error).replace("|", "/")
    return run


def machine():
    try:
        with open("/proc/cpuinfo") as file:
            model = next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.processor() or platform.machine()
    return f"{model}, {os.cpu_count()} cores"


def find_scenes(data, wanted):
    """(truth scenes, recorded scenes) by what they hold, not by their name or place."""
    truth, recorded = [], []
    for map_file in sorted(data.glob("**/map.pcd")):
        scene = map_file.parent
        if not (scene / "images").is_dir() or (wanted and scene.name not in wanted):
            continue
        if (scene / "truth" / "on_map").is_dir():
            truth.append(scene)
        elif (scene / "reference").is_dir():
            recorded.append(scene)
    return truth, recorded


METHODS = ("cp_plus", "lines", "nid", "none")


def method_list(text):
    methods = text.split(",")
    for method in methods:
        if method not in METHODS:
            raise argparse.ArgumentTypeError(f"'{method}' is none of {', '.join(METHODS)}")
    return methods


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("data", type=pathlib.Path, help="folder with the scenes, at any depth")
    parser.add_argument("build", type=pathlib.Path, help="build folder (with apps/cpplus), or the cpplus binary itself")
    parser.add_argument("out", type=pathlib.Path, help="folder for the results")
    parser.add_argument("--scene", action="append", default=[], help="only this scene (may be repeated)")
    parser.add_argument("--start", action="append", default=[],
                        help="only this start of the truth scenes, e.g. coarse_medium (may be repeated)")
    parser.add_argument("--methods", type=method_list, default=["cp_plus"], metavar="LIST",
                        help="one more table: scene x start x method, e.g. cp_plus,lines,nid,none (truth scenes)")
    parser.add_argument("--moved", type=int, default=0, metavar="N",
                        help="take N copies of each truth scene, moved at random against the voxel grid, as one row")
    parser.add_argument("--trials", type=int, default=20, help="disturbed trials of each recorded scene")
    parser.add_argument("--angle-deg", type=float, default=1.0, help="rotation of a disturbance")
    parser.add_argument("--distance-m", type=float, default=0.05, help="translation of a disturbance")
    parser.add_argument("--seed", type=int, default=1, help="seed of the disturbances")
    parser.add_argument("--refine", default="", metavar="OPTIONS",
                        help="more options for cpplus refine: --refine='--a 1 --b 2'")
    parser.add_argument("--threads", type=int, default=1, help="threads of cpplus; times are meant for one")
    parser.add_argument("--no-colorize", action="store_true", help="leave cpplus colorize out")
    return parser.parse_args()


def main():
    settings = parse_arguments()
    binary = settings.build if settings.build.is_file() else settings.build / "apps" / "cpplus"
    if not binary.is_file():
        sys.exit(f"{binary}: no such program; build it first")
    truth, recorded = find_scenes(settings.data, settings.scene)
    if not truth and not recorded:
        sys.exit(f"{settings.data}: no scenes found")
    program = Program(binary.resolve(), settings.threads)
    runs_folder = settings.out / "runs"
    results = {"date": datetime.date.today().isoformat(), "machine": machine(), "version": program.version(),
               "threads": settings.threads, "trials": settings.trials, "angle_deg": settings.angle_deg,
               "distance_m": settings.distance_m, "seed": settings.seed, "moved": settings.moved, "refine_options": settings.refine,
               "refine": [], "methods": [], "colorize": []}

    def keep(kind, run, row):
        print(row, end="", flush=True)
        results[kind].append(run)
        (settings.out / "quality.json").write_text(json.dumps(results, indent=1) + "\n")
        (settings.out / "quality.md").write_text(figures.markdown(results))

    settings.out.mkdir(parents=True, exist_ok=True)
    print(figures.REFINE_HEADER, end="")
    for scene in truth:
        for run in truth_runs(program, scene, runs_folder, settings):
            keep("refine", run, figures.refine_row(run))
    for scene in recorded:
        for run in recorded_runs(program, scene, runs_folder, settings):
            keep("refine", run, figures.refine_row(run))
    if settings.methods != ["cp_plus"]:
        print("\n" + figures.METHOD_HEADER, end="")
        for run in [r for r in results["refine"] if r["kind"] == "truth"]:
            keep("methods", run, figures.method_row(run))
        for scene in truth:
            for run in method_runs(program, scene, runs_folder, settings):
                keep("methods", run, figures.method_row(run))
    if not settings.no_colorize:
        print("\n" + figures.COLORIZE_HEADER, end="")
        for scene, model in [(s, s / "truth" / "on_map") for s in truth] + [(s, s / "reference") for s in recorded]:
            run = colorize_run(program, scene, model, runs_folder)
            keep("colorize", run, figures.colorize_row(run))
    return 1 if any(run["error"] for run in results["refine"] + results["methods"] + results["colorize"]) else 0


if __name__ == "__main__":
    sys.exit(main())
