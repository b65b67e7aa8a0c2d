#!/usr/bin/env python3
"""Checks that every #include obeys the layers (docs/architecture.md). Prints one line a violation, exit code 1 if any.

usage: check_layers.py [ROOT]     ROOT is the repository (default: the one this script is in)
"""
import re
import sys
from pathlib import Path

STAGES = {"adjust", "dynamics", "visibility", "features", "refine", "render", "colorize", "evaluate", "simulate"}

# Project folders that a folder may include besides itself.
BASE = {"core", "geometry", "cloud"}
MAY_INCLUDE = {
    "core": set(),
    "geometry": {"core"},
    "cloud": {"core", "geometry"},
    "io": BASE,
    **{stage: BASE for stage in STAGES},
    "report": BASE | {"io"} | STAGES,
    "pipeline": BASE | {"io", "report"} | STAGES,
}
EVERYTHING = set(MAY_INCLUDE)
# Tests beside a stage may read scenes and make synthetic ones.
TESTS_MAY_ALSO_INCLUDE = {"io", "simulate"}

# Third-party library -> pattern of its headers, folders whose .cpp files may include it. Eigen is allowed everywhere.
THIRD_PARTY = {
    "fmt": (r"fmt/", EVERYTHING | {"apps", "tests", "bench"}),
    "TBB": (r"(oneapi/)?tbb/", {"core"}),
    "Ceres": (r"ceres/", {"refine"}),
    "Qhull": (r"(libqhull|qhull)", {"visibility"}),
    "OpenCV": (r"opencv2/", {"io", "features", "render", "colorize", "simulate", "report", "pipeline", "tests", "bench"}),
    "Embree": (r"embree", {"simulate"}),
    "JPEG": (r"(jpeglib|jerror)\.h", {"io"}),
    "zlib": (r"zlib\.h", {"io"}),
    "JSON": (r"nlohmann/", {"io", "report", "pipeline", "tests", "bench"}),
    "YAML": (r"yaml-cpp/", {"io", "apps", "tests"}),
    "cpp-httplib": (r"httplib\.h", {"pipeline"}),
    "CLI11": (r"CLI/", {"apps"}),
    "GoogleTest": (r"(gtest|gmock)/", {"tests"}),
    "peers": (r"(pcl|open3d|octomap|benchmark)/", {"tests", "bench"}),
}
PLATFORM = re.compile(r"(sys/\w+|unistd|fcntl|dirent|poll|malloc)\.h")
EIGEN = re.compile(r"Eigen/")
STANDARD = re.compile(r"[a-z_]+|(assert|errno|float|limits|math|signal|stddef|stdint|stdio|stdlib|string|time)\.h")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def check_project_include(folder, is_test, included):
    """Returns what is wrong with including the project header, or None."""
    parts = included.split("/")
    if len(parts) < 3 or parts[0] != "cpplus":
        return "project headers are included as \"cpplus/FOLDER/NAME.h\""
    target = parts[1]
    if target not in MAY_INCLUDE:
        return f"there is no folder {target}"
    if folder not in MAY_INCLUDE or target == folder or target in MAY_INCLUDE[folder]:
        return None
    if is_test and target in TESTS_MAY_ALSO_INCLUDE:
        return None
    if folder in STAGES and target in STAGES:
        return f"stage {folder} must not include stage {target}"
    return f"{folder} must not include {target}"


def check_system_include(folder, is_header, is_test, included):
    """Returns what is wrong with including the header in angle brackets, or None."""
    if EIGEN.match(included) or STANDARD.fullmatch(included):
        return None
    is_public_header = is_header and folder in MAY_INCLUDE and not is_test
    if is_public_header:
        return "public headers include only the standard library and Eigen"
    if PLATFORM.fullmatch(included):
        return None
    for name, (pattern, folders) in THIRD_PARTY.items():
        if re.match(pattern, included):
            allowed = folder in folders or (is_test and name in ("GoogleTest", "OpenCV", "JSON", "YAML", "Ceres"))
            return None if allowed else f"{name} is not allowed in {folder}"
    return "unknown library; add it to scripts/check_layers.py and docs/dependencies.md"


def check_file(path, folder):
    """Yields (line number, problem) for each bad include of the file."""
    is_header = path.suffix == ".h"
    is_test = path.stem.endswith("_test") or path.stem.startswith("test_")  # a test, or a header that tests share
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        match = INCLUDE.match(line)
        if not match:
            continue
        bracket, included = match.groups()
        if bracket == "<" and included.startswith("cpplus/"):
            problem = "project headers are included with quotes"
        elif bracket == "<":
            problem = check_system_include(folder, is_header, is_test, included)
        elif folder not in MAY_INCLUDE and "/" not in included:
            problem = None  # apps/, tests/ and bench/ may include a header beside the source
        else:
            problem = check_project_include(folder, is_test, included)
        if problem:
            yield number, f"{included}: {problem}"


def check_repository(root):
    """Returns one string a violation, sorted by file."""
    problems = []
    num_files = 0
    for path in sorted(root.rglob("*")):
        parts = path.relative_to(root).parts
        if path.suffix not in (".h", ".cpp") or parts[0] not in ("src", "apps", "tests", "bench"):
            continue
        num_files += 1
        folder = parts[2] if parts[0] == "src" else parts[0]
        if parts[0] == "src" and folder not in MAY_INCLUDE:
            problems.append(f"{path.relative_to(root)}: folder {folder} has no layer in scripts/check_layers.py")
            continue
        problems += [f"{path.relative_to(root)}:{number}: {problem}" for number, problem in check_file(path, folder)]
    if num_files == 0:
        problems.append(f"{root}: no sources found")
    return problems


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    problems = check_repository(root)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
