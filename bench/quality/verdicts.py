#!/usr/bin/env python3
"""How far the verdicts and covariances of `cpplus refine` can be believed, from runs that quality.py wrote.

Prints markdown: precision and recall of the verdict for being within 3 or 2 px of the best pose on the map, and the
errors of accepted poses against their covariances. Only scenes with exact truth count, of these the images that
`cpplus evaluate` measured. Needs nothing but Python's standard library."""

import argparse
import itertools
import json
import math
import pathlib
import statistics
import sys
from dataclasses import dataclass

import figures
import line_chart
import poses
import quality

RIGHT_PX = (3.0, 2.0)  # an image is right when its mean shift from the best pose is at most this
THRESHOLDS_PX = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, math.inf)
MARKED_PX = (1.5, 2.0, 3.0, 5.0)  # the thresholds that the picture names
COLORS = ("#1f5fa8", "#b23a2e")
CHI_SQUARED_95 = 12.592  # of 6 degrees of freedom


class BadInput(Exception):
    """What is wrong with the files given, in one line."""


@dataclass(frozen=True)
class Judged:
    """What refine says of an image and what is true of it."""

    scene: str
    accepted: bool  # status `refined`
    reason: str
    predicted_px: float | None  # none without the joint solve
    shift_px: float
    squared_error: float | None  # of accepted images: in units of the covariance; none where that is not usable


def rotation_vector(q):
    """Axis times angle, rad, the shorter way round."""
    sign = -1.0 if q[0] < 0 else 1.0
    sin_half = math.hypot(*q[1:])
    # The limit for small angles, where the quotient is that of two zeros.
    factor = 2.0 if sin_half < 1e-12 else 2.0 * math.atan2(sin_half, sign * q[0]) / sin_half
    return [sign * factor * x for x in q[1:]]


def camera_difference(start, end):
    """The perturbation (rad, then m, on the right of map_from_camera) that takes the camera `start` to `end`.

    It is the convention of the report's covariances, see docs/conventions.md."""
    q = poses.multiply(start.q, poses.conjugate(end.q))
    return rotation_vector(q) + [s - e for s, e in zip(start.t, poses.rotate(q, end.t))]


def normalised_squared_error(covariance, error):
    """errorᵀ covariance⁻¹ error, or None where the covariance is not a finite, positive definite matrix."""
    # refine writes null for what is not finite; the baselines write zeros.
    if any(value is None for row in covariance for value in row):
        return None
    factor, whitened, size = [], [], len(error)
    for i in range(size):  # row i of the Cholesky factor L, and the solution of L whitened = error up to i
        row = []
        for j in range(i):
            row.append((covariance[i][j] - sum(a * b for a, b in zip(row, factor[j]))) / factor[j][j])
        pivot = covariance[i][i] - sum(a * a for a in row)
        if not pivot > 0.0:
            return None
        row.append(math.sqrt(pivot))
        factor.append(row)
        whitened.append((error[i] - sum(a * b for a, b in zip(row, whitened))) / row[i])
    return sum(x * x for x in whitened)


def read_json(file):
    try:
        return json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise BadInput(f"{file}: cannot be read ({getattr(error, 'strerror', None) or error})") from error


def read_poses(model):
    try:
        return {image.name: image.pose for image in poses.read_images(model)}
    except (OSError, ValueError, ZeroDivisionError) as error:
        raise BadInput(f"{model}: no COLMAP text model ({getattr(error, 'strerror', None) or error})") from error


def judge(scene_name, image, shift_px, estimates, references):
    """`image`: an entry of report.json. The error is that from the output to the reference, as the covariance is stated
    in the camera frame of the output."""
    accepted = image["status"] == "refined"
    squared_error = None
    if accepted:
        error = camera_difference(estimates[image["name"]], references[image["name"]])
        squared_error = normalised_squared_error(image["covariance"], error)
    return Judged(scene_name, accepted, image["reason"], image["predicted_shift_px"], shift_px, squared_error)


def judged_of_run(scene, run):
    """The images of one run of quality.py, OUT/runs/SCENE/START/COPY, that were measured; blurred ones are not."""
    # quality.py keeps moved copies beside the starts; a scene that was not moved is where it was.
    place = scene if run.name == scene.name else run.parent.parent / run.name
    report, evaluation = read_json(run / "report.json"), read_json(run / "after.json")
    estimates, references = read_poses(run / "sparse"), read_poses(place / "truth" / "on_map")
    try:
        shifts_px = figures.shifts_by_name(evaluation)
        return [judge(scene.name, image, shifts_px[image["name"]], estimates, references)
                for image in report["images"] if image["name"] in shifts_px]
    except KeyError as error:
        raise BadInput(f"{run}: report, evaluation and poses do not fit together, {error} is missing") from error
    except (TypeError, IndexError) as error:
        raise BadInput(f"{run}: not a report and an evaluation ({error})") from error


def judged_of_out(scenes, out):
    """The images of all runs of these scenes below one OUT of quality.py."""
    judged = []
    for scene in scenes:
        for run in sorted((out / "runs" / scene.name).glob("coarse_*/*/")):
            judged += judged_of_run(scene, run)
    if not judged:
        raise BadInput(f"{out}: no runs of scenes with exact truth")
    return judged


def precision_and_recall(judged, accepts, right_px):
    """(right among the accepted, accepted among the right); None where there are none to choose from."""
    precision = figures.share(image.shift_px <= right_px for image in judged if accepts(image))
    recall = figures.share(accepts(image) for image in judged if image.shift_px <= right_px)
    return precision, recall


def accepts_within(threshold_px):
    """The verdict of a user who takes refined images up to this prediction; those without a prediction never."""
    return lambda i: i.accepted and i.predicted_px is not None and i.predicted_px <= threshold_px


def curve(judged, right_px):
    """(recall, precision, threshold px) of each distinct prediction of an accepted image, from the smallest on."""
    num_right = sum(image.shift_px <= right_px for image in judged)
    if num_right == 0:
        return []
    points, num_taken, num_taken_right = [], 0, 0
    candidates = sorted((i for i in judged if accepts_within(math.inf)(i)), key=lambda i: i.predicted_px)
    for threshold_px, group in itertools.groupby(candidates, key=lambda i: i.predicted_px):
        for image in group:
            num_taken += 1
            num_taken_right += image.shift_px <= right_px
        points.append((num_taken_right / num_right, num_taken_right / num_taken, threshold_px))
    return points


def threshold_title(threshold_px):
    return "any `predicted_shift_px`" if math.isinf(threshold_px) else f"`predicted_shift_px` ≤ {threshold_px:g}"


VERDICT_HEADER = ("| accepted when | accepted |"
                  + "".join(f" precision, {right_px:g} px | recall, {right_px:g} px |" for right_px in RIGHT_PX)
                  + "\n|---|--:|" + "--:|--:|" * len(RIGHT_PX) + "\n")


def verdict_row(title, judged, accepts):
    cells = [title, str(sum(map(accepts, judged)))]
    for right_px in RIGHT_PX:
        cells += map(figures.percent, precision_and_recall(judged, accepts, right_px))
    return "| " + " | ".join(cells) + " |\n"


def verdict_table(judged):
    rows = [(threshold_title(threshold_px), accepts_within(threshold_px)) for threshold_px in THRESHOLDS_PX]
    rows.append(("`refined` without a reason", lambda i: i.accepted and not i.reason))
    rows.append(("`refined`", lambda i: i.accepted))
    return VERDICT_HEADER + "".join(verdict_row(title, judged, accepts) for title, accepts in rows)


COVARIANCE_HEADER = ("| scene | accepted | without usable covariance | mean | median | within the 95 % ellipsoid |\n"
                     "|---|--:|--:|--:|--:|--:|\n")


def covariance_row(title, judged):
    accepted = [image for image in judged if image.accepted]
    errors = [image.squared_error for image in accepted if image.squared_error is not None]
    cells = [title, str(len(accepted)), str(len(accepted) - len(errors)),
             figures.number(statistics.fmean(errors) if errors else None, 1),
             figures.number(statistics.median(errors) if errors else None, 1),
             figures.percent(figures.share(error <= CHI_SQUARED_95 for error in errors))]
    return "| " + " | ".join(cells) + " |\n"


def covariance_table(judged):
    rows = [covariance_row(scene, [image for image in judged if image.scene == scene])
            for scene in sorted({image.scene for image in judged})]
    return COVARIANCE_HEADER + "".join(rows) + covariance_row("all", judged)


def markdown(judged):
    right = ", ".join(f"{sum(i.shift_px <= r for i in judged)} within {r:g} px" for r in RIGHT_PX)
    return (f"{len(judged)} images; by the pose in the output {right} of the best pose on the map.\n\n"
            + verdict_table(judged)
            + "\nSquared errors of accepted poses in units of their covariances (6 degrees of freedom: mean 6.0, "
            "median 5.3, 95 % within the ellipsoid if the covariances are true):\n\n"
            + covariance_table(judged))


def chart(judged):
    lines = []
    for right_px, color in zip(RIGHT_PX, COLORS):
        points = curve(judged, right_px)
        # A mark stands at the last image that its threshold takes.
        taken = [(mark, [p for p in points if p[2] <= mark]) for mark in MARKED_PX]
        marks = [(*within[-1][:2], f"{mark:g}") for mark, within in taken if within]
        if points:
            lines.append(line_chart.Line(f"within {right_px:g} px", color, [p[:2] for p in points], marks))
    if not lines:
        raise BadInput("nothing to draw: no image is right, or none accepted has a predicted_shift_px")
    return line_chart.svg(f"Accepting by predicted_shift_px (marks: up to how many px), {len(judged)} images",
                          "recall: accepted of the right ones", "precision: right of the accepted ones", lines)


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("data", type=pathlib.Path, help="folder with the scenes, as given to quality.py")
    parser.add_argument("out", type=pathlib.Path, nargs="+", help="folder that quality.py wrote; several are pooled")
    parser.add_argument("--scene", action="append", default=[], help="only this scene (may be repeated)")
    parser.add_argument("--svg", type=pathlib.Path, metavar="FILE", help="write the precision-recall curves here")
    return parser.parse_args(arguments)


def main(arguments=None):
    settings = parse_arguments(arguments)
    try:
        scenes, _ = quality.find_scenes(settings.data, settings.scene)
        if not scenes:
            raise BadInput(f"{settings.data}: no scenes with exact truth")
        judged = [image for out in settings.out for image in judged_of_out(scenes, out)]
        print(markdown(judged), end="")
        if settings.svg:
            settings.svg.write_text(chart(judged))
    except (BadInput, OSError) as error:
        sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
