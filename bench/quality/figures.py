"""From the figures of single images to those of a scene, and from these to a table."""

import statistics

# An accepted pose counts as worse than its start beyond this margin, pixels.
WORSE_MARGIN_PX = 1.0
# A disturbed image counts as returned when its shift from the reference is below this, pixels.
RETURNED_PX = 4.0
THRESHOLDS_PX = (1.0, 2.0, 5.0)


def share(flags):
    flags = list(flags)
    return sum(flags) / len(flags) if flags else None


def shifts_by_name(evaluation):
    """Mean reprojection shift of each image of `cpplus evaluate --json` that has one."""
    return {i["name"]: i["mean_shift_px"] for i in evaluation["images"] if i["mean_shift_px"] is not None}


def merge(files):
    """One evaluation or report of several, whose images are told apart by the number of their file."""
    return {"images": [{**image, "name": f"t{number:02d}/{image['name']}"}
                       for number, file in enumerate(files) for image in file["images"]]}


def summarize(before, after, report):
    """Figures of one run: `before` and `after` are evaluations, `report` is refine's report.json.

    Only images with a shift in both evaluations count. An image is accepted when its status is `refined`."""
    start, end = shifts_by_name(before), shifts_by_name(after)
    status = {image["name"]: image["status"] for image in report["images"]}
    names = sorted(start.keys() & end.keys())
    accepted = [name for name in names if status.get(name) == "refined"]
    worse = [name for name in accepted if end[name] > start[name] + WORSE_MARGIN_PX]
    totals = [image["milliseconds"].get("total") for image in report["images"]]
    seconds = [total / 1000.0 for total in totals if total is not None]
    figures = {
        "num_images": len(names),
        "before_median_px": statistics.median(start[n] for n in names) if names else None,
        "after_median_px": statistics.median(end[n] for n in names) if names else None,
        "after_max_px": max((end[n] for n in names), default=None),
        "share_better": share(end[n] < start[n] for n in names),
        "share_returned": share(end[n] < RETURNED_PX for n in names),
        "num_accepted": len(accepted),
        "num_accepted_worse": len(worse),
        "accepted_worse": worse,
        "seconds_per_image": statistics.mean(seconds) if seconds else None,
        "images": [
            {"name": n, "before_px": start[n], "after_px": end[n], "status": status.get(n, "missing")} for n in names
        ],
    }
    for threshold in THRESHOLDS_PX:
        figures[f"share_under_{threshold:.0f}_px"] = share(end[n] < threshold for n in names)
    return figures


def number(value, digits):
    return "–" if value is None else f"{value:.{digits}f}"


def percent(value):
    return "–" if value is None else f"{100.0 * value:.0f} %"


REFINE_HEADER = (
    "| scene | start | images | before px | after px | better | < 1 px | < 2 px | < 5 px | back within 4 px "
    "| accepted | accepted, but worse | s / image | peak MB |\n"
    "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n"
)
METHOD_HEADER = (
    "| scene | start | method | images | median px | < 1 px | < 2 px | < 5 px | accepted | accepted, but worse "
    "| s / image |\n"
    "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
)
COLORIZE_HEADER = "| scene | points coloured | seconds | peak MB |\n|---|--:|--:|--:|\n"


def refine_row(run):
    if run["error"]:
        return f"| {run['scene']} | {run['start']} | failed: {run['error']} |" + " |" * 11 + "\n"
    f = run["figures"]
    cells = [
        run["scene"],
        run["start"],
        str(f["num_images"]),
        number(f["before_median_px"], 2),
        number(f["after_median_px"], 2),
        percent(f["share_better"]),
        *(percent(f[f"share_under_{threshold:.0f}_px"]) for threshold in THRESHOLDS_PX),
        percent(f["share_returned"]) if run["kind"] == "recorded" else "",
        str(f["num_accepted"]),
        str(f["num_accepted_worse"]),
        number(f["seconds_per_image"], 2),
        number(run["peak_mb"], 0),
    ]
    return "| " + " | ".join(cells) + " |\n"


def method_row(run):
    if run["error"]:
        return f"| {run['scene']} | {run['start']} | {run['method']} | failed: {run['error']} |" + " |" * 7 + "\n"
    f = run["figures"]
    cells = [
        run["scene"],
        run["start"],
        run["method"],
        str(f["num_images"]),
        number(f["after_median_px"], 2),
        *(percent(f[f"share_under_{threshold:.0f}_px"]) for threshold in THRESHOLDS_PX),
        str(f["num_accepted"]),
        str(f["num_accepted_worse"]),
        number(f["seconds_per_image"], 2),
    ]
    return "| " + " | ".join(cells) + " |\n"


def by_scene_and_start(runs):
    """The runs of a scene and start together, in the order in which each pair first occurs, then by median."""
    order = list(dict.fromkeys((run["scene"], run["start"]) for run in runs))

    def key(run):
        median = run["figures"]["after_median_px"] if run["figures"] else None
        return order.index((run["scene"], run["start"])), float("inf") if median is None else median

    return sorted(runs, key=key)


def colorize_row(run):
    result = f"failed: {run['error']}" if run["error"] else percent(run["share_colored"])
    return f"| {run['scene']} | {result} | {number(run['seconds'], 1)} | {number(run['peak_mb'], 0)} |\n"


def markdown(results):
    """The tables of a whole benchmark, to be read by a person."""
    lines = [
        f"{results['date']}, {results['machine']}, {results['threads']} thread(s), cpplus {results['version']}"
        + (f", refine {results['refine_options']}" if results["refine_options"] else "")
        + ".\n\n",
        "Pixels are medians over a scene of the images' mean reprojection shift. Scenes with exact truth: sharp images, "
        "against the poses that fit the map best, on the exact surface"
        + (f"; {results['moved']} copies of each, moved against the voxel grid, in a row" if results["moved"] else "")
        + ". Recorded scenes: "
        f"{results['trials']} trials, each image turned by {results['angle_deg']:g}° and moved by "
        f"{100 * results['distance_m']:g} cm at random, against the scene's reference poses, on the map's visible "
        f"points. Accepted, but worse: refined images that end more than {WORSE_MARGIN_PX:g} px farther off than they "
        "started.\n\n",
        REFINE_HEADER,
        *(refine_row(run) for run in results["refine"]),
    ]
    if results["methods"]:
        lines += ["\n", METHOD_HEADER, *(method_row(run) for run in by_scene_and_start(results["methods"]))]
    if results["colorize"]:
        lines += ["\n", COLORIZE_HEADER, *(colorize_row(run) for run in results["colorize"])]
    return "".join(lines)
