#!/usr/bin/env python3
"""Tests of check_layers.py: each rule is broken once in a small tree of its own."""
import tempfile
import unittest
from pathlib import Path

import check_layers


def problems_of(name, source):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.parent.mkdir(parents=True)
        path.write_text(source, encoding="utf-8")
        return check_layers.check_repository(Path(folder))


class CheckLayers(unittest.TestCase):
    def test_good_includes(self):
        good = [
            ("src/cpplus/refine/a.cpp", '#include "cpplus/refine/a.h"\n#include <ceres/ceres.h>\n#include <vector>\n'),
            ("src/cpplus/refine/a.h", '#include <Eigen/Core>\n#include <cstdint>\n#include "cpplus/cloud/voxel_map.h"\n'),
            ("src/cpplus/pipeline/a.cpp", '#include "cpplus/refine/a.h"\n#include "cpplus/io/b.h"\n'),
            ("src/cpplus/visibility/a_test.cpp", '#include <gtest/gtest.h>\n#include "cpplus/io/b.h"\n'),
            ("src/cpplus/io/test_files.h", "#include <gtest/gtest.h>\n#include <unistd.h>\n"),
            ("apps/main.cpp", '#include <CLI/CLI.hpp>\n#include "cmd_refine.h"\n#include "cpplus/pipeline/run.h"\n'),
        ]
        for name, source in good:
            with self.subTest(name=name):
                self.assertEqual(problems_of(name, source), [])

    def test_bad_includes(self):
        bad = [
            ("src/cpplus/core/a.h", '#include "cpplus/geometry/rigid3.h"', "core must not include geometry"),
            ("src/cpplus/refine/a.cpp", '#include "cpplus/features/b.h"', "stage refine must not include stage features"),
            ("src/cpplus/refine/a.cpp", '#include "cpplus/io/b.h"', "refine must not include io"),
            ("src/cpplus/refine/a_test.cpp", '#include "cpplus/pipeline/b.h"', "refine must not include pipeline"),
            ("src/cpplus/io/a.cpp", '#include "cpplus/report/b.h"', "io must not include report"),
            ("src/cpplus/features/a.h", "#include <opencv2/core.hpp>", "public headers"),
            ("src/cpplus/refine/a.cpp", "#include <opencv2/core.hpp>", "OpenCV is not allowed in refine"),
            ("src/cpplus/io/a.cpp", "#include <CLI/CLI.hpp>", "CLI11 is not allowed in io"),
            ("src/cpplus/io/a.cpp", "#include <gtest/gtest.h>", "GoogleTest is not allowed in io"),
            ("src/cpplus/io/a.cpp", "#include <boost/any.hpp>", "unknown library"),
            ("src/cpplus/io/a.cpp", '#include "b.h"', "project headers are included as"),
            ("src/cpplus/io/a.cpp", "#include <cpplus/core/error.h>", "included with quotes"),
            ("src/cpplus/io/a.cpp", '#include "cpplus/nowhere/b.h"', "no folder nowhere"),
            ("src/cpplus/odd/a.cpp", "", "has no layer"),
        ]
        for name, source, expected in bad:
            with self.subTest(name=name, source=source):
                found = problems_of(name, source)
                self.assertEqual(len(found), 1, found)
                self.assertIn(expected, found[0])

    def test_empty_tree_is_an_error(self):
        self.assertEqual(len(problems_of("docs/a.md", "")), 1)


if __name__ == "__main__":
    unittest.main()
