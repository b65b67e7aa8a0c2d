#!/usr/bin/env python3
"""Tests of the parts of the quality benchmark that its figures depend on."""

import argparse
import math
import pathlib
import random
import struct
import sys
import tempfile
import unittest

import figures
import moved_scene
import poses
import quality


def angle_deg_between(a, b):
    relative = poses.multiply(poses.conjugate(a.q), b.q)
    return math.degrees(2 * math.atan2(math.hypot(*relative[1:]), abs(relative[0])))


class PosesTest(unittest.TestCase):
    POSE = poses.Pose((0.5, 0.5, -0.5, 0.5), (1.0, -2.0, 3.0))

    def test_quarter_turn_about_z_moves_x_to_y(self):
        turned = poses.rotate((math.sqrt(0.5), 0, 0, math.sqrt(0.5)), (1, 0, 0))
        for value, expected in zip(turned, (0, 1, 0)):
            self.assertAlmostEqual(value, expected)

    def test_disturbance_has_exactly_the_given_size(self):
        generator = random.Random(3)
        for _ in range(10):
            moved = poses.disturb(self.POSE, 1.0, 0.05, generator)
            self.assertAlmostEqual(angle_deg_between(self.POSE, moved), 1.0)
            self.assertAlmostEqual(math.dist(poses.camera_center(self.POSE), poses.camera_center(moved)), 0.05)

    def test_images_are_disturbed_each_on_its_own_and_repeat_with_the_seed(self):
        images = [poses.Image(self.POSE, 1, "a.jpg"), poses.Image(self.POSE, 1, "b.jpg")]
        first = poses.disturbed(images, 1.0, 0.05, random.Random(7))
        self.assertEqual(first, poses.disturbed(images, 1.0, 0.05, random.Random(7)))
        self.assertNotEqual(first[0].pose, first[1].pose)
        self.assertEqual([i.name for i in first], ["a.jpg", "b.jpg"])

    def test_written_models_read_back(self):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "source"
            source.mkdir()
            (source / "cameras.txt").write_text("1 PINHOLE 4 3 1 1 2 1.5\n")
            images = [poses.Image(self.POSE, 1, "a b.jpg"), poses.Image(self.POSE, 1, "c.jpg")]
            poses.write_model(pathlib.Path(folder) / "copy", images, source)
            self.assertEqual(poses.read_images(pathlib.Path(folder) / "copy"), images)


class MovedSceneTest(unittest.TestCase):
    OFFSET = (0.5, -1.25, 2.0)

    def test_a_camera_sees_the_moved_points_as_before(self):
        pose, point = PosesTest.POSE, (0.3, 0.7, -1.1)
        moved = moved_scene.moved_pose(pose, self.OFFSET)
        moved_point = [x + d for x, d in zip(point, self.OFFSET)]
        before = [r + t for r, t in zip(poses.rotate(pose.q, point), pose.t)]
        after = [r + t for r, t in zip(poses.rotate(moved.q, moved_point), moved.t)]
        for value, expected in zip(after, before):
            self.assertAlmostEqual(value, expected)

    def test_points_are_moved_and_nothing_else(self):
        header = (b"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
                  b"WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary\n")
        with tempfile.TemporaryDirectory() as folder:
            cloud, out = pathlib.Path(folder) / "a.pcd", pathlib.Path(folder) / "b.pcd"
            cloud.write_bytes(header + struct.pack("<8f", 1, 2, 3, 50, -1, 0, 4, 60))
            moved_scene.move_cloud(cloud, out, self.OFFSET)
            self.assertEqual(out.read_bytes(), header + struct.pack("<8f", 1.5, 0.75, 5, 50, -0.5, -1.25, 6, 60))


class FiguresTest(unittest.TestCase):
    @staticmethod
    def evaluation(shifts):
        return {"images": [{"name": n, "mean_shift_px": s} for n, s in shifts.items()]}

    def test_images_of_several_trials_are_told_apart(self):
        merged = figures.merge([self.evaluation({"a": 1.0}), self.evaluation({"a": 2.0})])
        self.assertEqual(figures.shifts_by_name(merged), {"t00/a": 1.0, "t01/a": 2.0})

    def test_summary_by_hand(self):
        before = self.evaluation({"a": 8.0, "b": 6.0, "c": 4.0, "d": 2.0, "dark": None})
        after = self.evaluation({"a": 0.5, "b": 1.5, "c": 4.0, "d": 3.5, "dark": None})
        report = {"images": [
            {"name": "a", "status": "refined", "milliseconds": {"total": 100.0}},
            {"name": "b", "status": "refined", "milliseconds": {"total": 300.0}},
            {"name": "c", "status": "kept_coarse", "milliseconds": {"total": 200.0}},
            {"name": "d", "status": "refined", "milliseconds": {"total": 200.0}},
        ]}
        summary = figures.summarize(before, after, report)
        self.assertEqual(summary["num_images"], 4)
        self.assertEqual(summary["before_median_px"], 5.0)
        self.assertEqual(summary["after_median_px"], 2.5)
        self.assertEqual(summary["share_better"], 0.5)
        self.assertEqual(summary["share_under_1_px"], 0.25)
        self.assertEqual(summary["share_under_2_px"], 0.5)
        self.assertEqual(summary["share_under_5_px"], 1.0)
        self.assertEqual(summary["share_returned"], 0.75)
        self.assertEqual(summary["num_accepted"], 3)
        self.assertEqual(summary["accepted_worse"], ["d"])
        self.assertAlmostEqual(summary["seconds_per_image"], 0.2)

    def test_rows_have_as_many_cells_as_the_header(self):
        summary = figures.summarize(self.evaluation({}), self.evaluation({}), {"images": []})
        run = {"scene": "s", "start": "x", "kind": "truth", "error": "", "figures": summary, "peak_mb": 1.0}
        columns = figures.REFINE_HEADER.splitlines()[0].count("|")
        self.assertEqual(figures.refine_row(run).count("|"), columns)
        self.assertEqual(figures.refine_row({**run, "error": "exit code 1: no"}).count("|"), columns)
        columns = figures.METHOD_HEADER.splitlines()[0].count("|")
        run["method"] = "nid"
        self.assertEqual(figures.method_row(run).count("|"), columns)
        self.assertEqual(figures.method_row({**run, "error": "exit code 1: no"}).count("|"), columns)

    def test_methods_of_a_scene_and_start_stand_together_the_best_first(self):
        def run(scene, start, method, median):
            return {"scene": scene, "start": start, "method": method,
                    "figures": None if median is None else {"after_median_px": median}}

        runs = [run("b", "small", "cp_plus", 1.0), run("a", "small", "cp_plus", 2.0), run("b", "small", "nid", 0.5),
                run("a", "small", "lines", None), run("a", "small", "none", 7.0)]
        self.assertEqual([(r["scene"], r["method"]) for r in figures.by_scene_and_start(runs)],
                         [("b", "nid"), ("b", "cp_plus"), ("a", "cp_plus"), ("a", "none"), ("a", "lines")])


class ArgumentsTest(unittest.TestCase):
    def test_unknown_methods_are_named(self):
        self.assertEqual(quality.method_list("cp_plus,nid"), ["cp_plus", "nid"])
        with self.assertRaisesRegex(argparse.ArgumentTypeError, "'icp'"):
            quality.method_list("lines,icp")


if __name__ == "__main__":
    sys.exit(unittest.main())
