#!/usr/bin/env python3
"""Prints the errors of two evaluations side by side.

usage: before_after.py BEFORE.json AFTER.json      files of `cpplus evaluate --json`
"""
import json
import sys

ROWS = [
    ("rotation, median", "deg", lambda s: s["rotation_deg"]["median"]),
    ("translation, median", "m", lambda s: s["translation_m"]["median"]),
    ("reprojection shift, median", "px", lambda s: s["shift_px"]["median"]),
    ("reprojection shift, worst image", "px", lambda s: s["shift_px"]["max"]),
    ("images under 2 px", "%", lambda s: 100 * s["shift_shares"]["under_2_px"]),
]


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    summaries = []
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as stream:
            summaries.append(json.load(stream)["summary"])
    print(f"{'error':<34}{'before':>10}{'after':>10}")
    for name, unit, value in ROWS:
        before, after = (value(summary) for summary in summaries)
        print(f"{name + ' [' + unit + ']':<34}{before:>10.3f}{after:>10.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
