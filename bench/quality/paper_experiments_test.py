#!/usr/bin/env python3
"""Tests of the parts of the paper's experiments that their figures depend on."""

import dataclasses
import math
import pathlib
import random
import statistics
import struct
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import bar_chart
import odometry_starts
import paper_experiments
import poses

NOTHING_WRONG = odometry_starts.OdometryErrors(0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, "start")


def rotation_between(a, b):
    """Rotation vector, rad, that takes camera a's pose to b's in a's own frame (R_b = R_a Exp(v)), small angles."""
    q = poses.multiply(a.q, poses.conjugate(b.q))
    sign = 1.0 if q[0] > 0 else -1.0
    return [2.0 * sign * x for x in q[1:]]


def length(vector):
    return math.hypot(*vector)


class OdometryStartsTest(unittest.TestCase):
    STAMPS = {f"{i:06d}.jpg": 1.5 * i for i in range(40)}

    def images(self):
        generator = random.Random(5)
        result = []
        for name in self.STAMPS:
            q = odometry_starts.rotation_exp([generator.gauss(0, 1) for _ in range(3)])
            result.append(poses.Image(poses.Pose(q, tuple(generator.gauss(0, 3) for _ in range(3))), 1, name))
        return result

    def start(self, seed=3, **errors):
        return odometry_starts.odometry_start(self.images(), self.STAMPS,
                                              dataclasses.replace(NOTHING_WRONG, **errors), seed)

    def moves_in_map(self, start):
        return [[b - a for a, b in zip(poses.camera_center(true.pose), poses.camera_center(image.pose))]
                for true, image in zip(self.images(), start)]

    def test_without_errors_poses_stay(self):
        for true, image in zip(self.images(), self.start()):
            self.assertLess(length(rotation_between(true.pose, image.pose)), 1e-12)
        self.assertLess(max(length(move) for move in self.moves_in_map(self.start())), 1e-12)

    def test_quarter_turn_about_the_camera_z_axis_by_hand(self):
        # A camera at (1, 2, 3) with the map's axes, turned by Exp(pi/2 z) and moved 1 m along its x axis.
        moved = odometry_starts.perturb(poses.Pose((1, 0, 0, 0), (-1, -2, -3)), (0, 0, math.pi / 2), (1, 0, 0))
        for value, expected in zip(poses.camera_center(moved), (2, 2, 3)):
            self.assertAlmostEqual(value, expected)
        # Its x axis points along the map's y axis: a point there is ahead on x.
        ahead = poses.rotate(moved.q, (0, 1, 0))
        for value, expected in zip(ahead, (1, 0, 0)):
            self.assertAlmostEqual(value, expected)

    def test_extrinsic_error_is_constant_in_the_camera_frame(self):
        start = self.start(extrinsic_deg=1.0, extrinsic_m=0.03)
        turns = [rotation_between(true.pose, image.pose) for true, image in zip(self.images(), start)]
        for turn in turns:
            self.assertAlmostEqual(math.degrees(length(turn)), 1.0, places=4)
            self.assertLess(length([a - b for a, b in zip(turn, turns[0])]), 1e-9)
        steps = [poses.rotate(true.pose.q, move) for true, move in zip(self.images(), self.moves_in_map(start))]
        for step in steps:
            self.assertAlmostEqual(length(step), 0.03)
            self.assertLess(length([a - b for a, b in zip(step, steps[0])]), 1e-9)

    def test_drift_has_its_root_mean_square_and_begins_at_zero(self):
        moves = self.moves_in_map(self.start(drift_m=0.05, drift_memory_s=25.0))
        self.assertLess(length(moves[0]), 1e-12)
        self.assertAlmostEqual(math.sqrt(statistics.mean(length(move) ** 2 for move in moves)), 0.05)

    def test_drift_of_an_aligned_trajectory_has_zero_mean(self):
        moves = self.moves_in_map(self.start(drift_m=0.05, align="trajectory"))
        for component in zip(*moves):
            self.assertAlmostEqual(sum(component), 0.0)
        self.assertGreater(length(moves[0]), 1e-6)

    def test_process_remembers_as_long_as_it_says(self):
        stamps = [0.5 * i for i in range(40000)]
        path = odometry_starts.ornstein_uhlenbeck(stamps, 2.0, random.Random(11))
        # 20,000 s of memory 2 s are some 5,000 independent values: standard deviation 0.02 of variance and correlation.
        self.assertAlmostEqual(statistics.mean(x * x for x in path), 1.0, delta=0.08)
        lagged = statistics.mean(a * b for a, b in zip(path, path[4:]))
        self.assertAlmostEqual(lagged, math.exp(-1.0), delta=0.08)

    def test_noise_is_of_each_image_alone_and_of_the_size_stated(self):
        moves = self.moves_in_map(self.start(noise_m=0.01))
        # 120 normal numbers: the root mean square is good to 6.5 %.
        self.assertAlmostEqual(math.sqrt(statistics.mean(length(move) ** 2 for move in moves)), 0.01, delta=0.0026)
        self.assertNotEqual(moves[0], moves[1])

    def test_seed_decides(self):
        errors = dataclasses.asdict(odometry_starts.ODOMETRIES["lio_sam"])
        self.assertEqual(self.start(seed=1, **errors), self.start(seed=1, **errors))
        self.assertNotEqual(self.start(seed=1, **errors), self.start(seed=2, **errors))


class FiguresTest(unittest.TestCase):
    def test_quartiles_by_hand(self):
        self.assertEqual(paper_experiments.quartiles([4, 1, 2, 3, 5]), (2, 3, 4))
        self.assertEqual(paper_experiments.quartiles([7]), (7, 7, 7))
        self.assertIsNone(paper_experiments.quartiles([]))

    def test_summary_counts_boards_where_they_are_seen(self):
        def evaluation(rows):
            return {"images": [{"name": n, "mean_shift_px": s, "checkerboard_residual_px": b} for n, s, b in rows]}

        before = evaluation([("a", 8.0, 6.0), ("b", 4.0, None), ("c", 2.0, 4.0)])
        after = evaluation([("a", 1.0, 0.5), ("b", 1.0, None), ("c", 4.0, 1.5)])
        report = {"images": [{"name": n, "status": s} for n, s in
                             (("a", "refined"), ("b", "kept_coarse"), ("c", "refined"))]}
        summary = paper_experiments.summarize(before, after, report)
        self.assertEqual(summary["num_board_images"], 2)
        self.assertEqual(summary["board_before_px"], (4.5, 5.0, 5.5))
        self.assertEqual(summary["board_after_px"][1], 1.0)
        self.assertEqual(summary["shift_before_px"][1], 4.0)
        self.assertEqual((summary["num_images"], summary["num_accepted"], summary["num_accepted_worse"]), (3, 2, 1))

    def test_floor_counts_cells_with_points_on_the_floor(self):
        points = [(0.1, 0.1, 0.0), (0.2, 0.3, 0.1), (-0.1, 0.1, -0.1), (3.0, 3.0, 1.0)]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "map.pcd"
            file.write_bytes(b"FIELDS x y z intensity\nPOINTS 4\nDATA binary\n" +
                             b"".join(struct.pack("<ffff", *point, 9.0) for point in points))
            self.assertEqual(paper_experiments.floor_area_m2(file), 0.5)

    def test_rows_have_as_many_cells_as_the_header(self):
        run = {"num_board_images": 0, "board_before_px": None, "board_after_px": None, "shift_before_px": (1, 2, 3),
               "shift_after_px": (1, 2, 3), "num_accepted": 1, "num_images": 2, "num_accepted_worse": 0}
        world = {"site": "hall", "device": "solid_state_wide", "floor_m2": 100.0, "board_best_px": None}
        results = {"date": "d", "machine": "m", "version": "v", "cpu_seconds": 1.0, "worlds": [
            {**world, "error": "", "runs": {"lio_sam": run, "lines": run}},
            {**world, "error": "exit code 1", "runs": {}}]}
        rows = [line for line in paper_experiments.markdown(results).splitlines() if line.startswith("|")]
        self.assertEqual(len(rows), 2 * 2 + 3)  # header and rule of two devices
        self.assertEqual({row.count("|") for row in rows}, {11})


class BarChartTest(unittest.TestCase):
    COLORS = {"before": "#aaaaaa", "after": "#000000"}

    def rectangles(self, groups):
        tree = xml.etree.ElementTree.fromstring(bar_chart.svg("t", "px", groups, self.COLORS))
        return [r for r in tree.iter("{http://www.w3.org/2000/svg}rect") if r.get("width") == str(bar_chart.BAR_PX - 2)]

    def test_bars_are_as_high_as_their_values(self):
        groups = {"hall": [bar_chart.Bar("before", 8.0, 6.0, 10.0), bar_chart.Bar("after", 2.0, 1.0, 3.0)]}
        before, after = self.rectangles(groups)
        self.assertAlmostEqual(float(before.get("height")), 0.8 * bar_chart.PLOT_HEIGHT_PX, places=1)
        self.assertAlmostEqual(float(after.get("height")), 0.2 * bar_chart.PLOT_HEIGHT_PX, places=1)
        self.assertEqual(before.get("fill"), "#aaaaaa")

    def test_ticks_are_round_and_few(self):
        for top in (0.3, 1.0, 7.0, 33.0, 480.0):
            step = bar_chart.tick_step(top)
            self.assertTrue(4 <= top / step <= 10.0, top)
            self.assertIn(f"{step:e}"[0], "125")


if __name__ == "__main__":
    sys.exit(unittest.main())
