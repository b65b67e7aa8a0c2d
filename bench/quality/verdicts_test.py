#!/usr/bin/env python3
"""Tests of the figures for verdicts and covariances, and of what is said of input that does not fit."""

import contextlib
import io
import json
import math
import pathlib
import shutil
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import moved_scene
import poses
import verdicts

POSE = poses.Pose((0.5, 0.5, -0.5, 0.5), (1.0, -2.0, 3.0))
SIGMAS = (0.001, 0.002, 0.003, 0.01, 0.02, 0.03)  # rad, rad, rad, m, m, m
COVARIANCE = [[SIGMAS[i] ** 2 if i == j else 0.0 for j in range(6)] for i in range(6)]
OFFSET_M = (0.5, -1.25, 2.0)


def perturbed(pose, error):
    """map_from_camera * Exp(error), rotation vector (rad) then translation (m), as a camera_from_map."""
    angle = math.hypot(*error[:3])
    factor = math.sin(angle / 2.0) / angle if angle > 0.0 else 0.5
    turned_back = (math.cos(angle / 2.0), *(-factor * x for x in error[:3]))
    return poses.Pose(poses.multiply(turned_back, pose.q),
                      poses.rotate(turned_back, [t - v for t, v in zip(pose.t, error[3:])]))


def along(axis, size):
    return [size if i == axis else 0.0 for i in range(6)]


def judged(predicted_px, shift_px, accepted=True, reason="", squared_error=None):
    return verdicts.Judged("scene", accepted, reason, predicted_px, shift_px, squared_error)


class ErrorTest(unittest.TestCase):
    def test_a_perturbation_is_found_again(self):
        error = [0.3, -0.2, 0.1, 0.5, -0.4, 0.2]
        for value, expected in zip(verdicts.camera_difference(POSE, perturbed(POSE, error)), error):
            self.assertAlmostEqual(value, expected)

    def test_translation_is_that_of_the_camera_in_its_own_frame(self):
        error = verdicts.camera_difference(POSE, perturbed(POSE, along(5, 0.1)))
        moved = [b - a for a, b in zip(poses.camera_center(POSE), poses.camera_center(perturbed(POSE, along(5, 0.1))))]
        self.assertAlmostEqual(error[5], 0.1)
        for value, expected in zip(moved, poses.rotate(poses.conjugate(POSE.q), (0.0, 0.0, 0.1))):
            self.assertAlmostEqual(value, expected)

    def test_both_quaternions_of_a_rotation_give_the_same_error(self):
        moved = perturbed(POSE, along(1, 0.1))
        negated = poses.Pose(tuple(-x for x in moved.q), moved.t)
        self.assertAlmostEqual(verdicts.camera_difference(POSE, negated)[1], 0.1)

    def test_one_sigma_along_any_axis_is_one(self):
        for axis, sigma in enumerate(SIGMAS):
            error = verdicts.camera_difference(POSE, perturbed(POSE, along(axis, sigma)))
            self.assertAlmostEqual(verdicts.normalised_squared_error(COVARIANCE, error), 1.0)

    def test_coupled_axes_by_hand(self):
        # [2 1; 1 2]^-1 = [2 -1; -1 2] / 3
        self.assertAlmostEqual(verdicts.normalised_squared_error([[2.0, 1.0], [1.0, 2.0]], [1.0, 1.0]), 2.0 / 3.0)
        self.assertAlmostEqual(verdicts.normalised_squared_error([[2.0, 1.0], [1.0, 2.0]], [1.0, -1.0]), 2.0)

    def test_covariances_that_state_nothing_are_told(self):
        self.assertIsNone(verdicts.normalised_squared_error([[0.0] * 6] * 6, [0.0] * 6))
        self.assertIsNone(verdicts.normalised_squared_error([[1.0, 0.0], [0.0, None]], [0.0, 0.0]))
        self.assertIsNone(verdicts.normalised_squared_error([[1.0, 2.0], [2.0, 1.0]], [0.0, 0.0]))


class VerdictTest(unittest.TestCase):
    # Three accepted, of which two right; one that is right by its pose, but not accepted.
    FOUR = [judged(1.0, 0.5), judged(2.0, 8.0, reason="uncertain"), judged(3.0, 3.0), judged(4.0, 1.0, accepted=False)]

    def test_curve_by_hand(self):
        self.assertEqual(verdicts.curve(self.FOUR, 3.0), [(1 / 3, 1.0, 1.0), (1 / 3, 0.5, 2.0), (2 / 3, 2 / 3, 3.0)])
        self.assertEqual(verdicts.curve(self.FOUR, 2.0), [(0.5, 1.0, 1.0), (0.5, 0.5, 2.0), (0.5, 1 / 3, 3.0)])

    def test_equal_predictions_are_one_point(self):
        self.assertEqual(verdicts.curve([judged(1.0, 0.5), judged(1.0, 9.0)], 3.0), [(1.0, 0.5, 1.0)])

    def test_curve_and_table_agree(self):
        for recall, precision, threshold_px in verdicts.curve(self.FOUR, 3.0):
            accepts = verdicts.accepts_within(threshold_px)
            self.assertEqual(verdicts.precision_and_recall(self.FOUR, accepts, 3.0), (precision, recall))

    def test_nothing_accepted_has_no_precision(self):
        self.assertEqual(verdicts.precision_and_recall(self.FOUR, verdicts.accepts_within(0.5), 3.0), (None, 0.0))
        self.assertIn("| 0 | – | 0 % | – | 0 % |", verdicts.verdict_row("x", self.FOUR, verdicts.accepts_within(0.5)))

    def test_nothing_right_has_no_recall_and_no_curve(self):
        wrong = [judged(1.0, 9.0)]
        self.assertEqual(verdicts.precision_and_recall(wrong, verdicts.accepts_within(1.0), 3.0), (0.0, None))
        self.assertEqual(verdicts.curve(wrong, 3.0), [])

    def test_images_without_a_prediction_are_in_the_last_row_alone(self):
        rows = verdicts.verdict_table([judged(None, 0.5), judged(1.0, 0.5, reason="uncertain")]).splitlines()
        self.assertEqual(rows[-3], "| any `predicted_shift_px` | 1 | 100 % | 50 % | 100 % | 50 % |")
        self.assertEqual(rows[-2], "| `refined` without a reason | 1 | 100 % | 50 % | 100 % | 50 % |")
        self.assertEqual(rows[-1], "| `refined` | 2 | 100 % | 100 % | 100 % | 100 % |")

    def test_covariance_row_by_hand(self):
        images = [judged(1.0, 0.5, squared_error=e) for e in (1.0, 2.0, 12.0, 13.0, None)]
        images.append(judged(1.0, 0.5, accepted=False))
        self.assertEqual(verdicts.covariance_row("all", images), "| all | 5 | 1 | 7.0 | 7.0 | 75 % |\n")

    def test_rows_have_as_many_cells_as_the_header(self):
        for table in (verdicts.verdict_table(self.FOUR), verdicts.covariance_table(self.FOUR)):
            self.assertEqual(len({line.count("|") for line in table.splitlines()}), 1)

    def test_chart_is_an_image_with_both_lines_and_the_marks(self):
        root = xml.etree.ElementTree.fromstring(verdicts.chart(self.FOUR))
        texts = [element.text for element in root.iter() if element.tag.endswith("text")]
        self.assertEqual(sum(element.tag.endswith("polyline") for element in root.iter()), 2)
        for expected in ("within 3 px", "within 2 px", "1.5", "5", "100 %"):
            self.assertIn(expected, texts)

    def test_nothing_to_draw_is_told(self):
        with self.assertRaisesRegex(verdicts.BadInput, "nothing to draw"):
            verdicts.chart([judged(None, 0.5)])


class FilesTest(unittest.TestCase):
    """A scene with one run in place; "a.jpg" is refined and wrong by a sigma, "b.jpg" blurred."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.data, self.out = pathlib.Path(folder.name) / "data", pathlib.Path(folder.name) / "out"
        scene = self.data / "room"
        (scene / "images").mkdir(parents=True)
        (scene / "map.pcd").touch()
        (scene / "cameras.txt").touch()
        (self.data / "recorded" / "images").mkdir(parents=True)
        (self.data / "recorded" / "map.pcd").touch()
        (self.data / "recorded" / "reference").mkdir()
        self.write_model(scene / "truth" / "on_map", POSE)
        self.run_folder = self.out / "runs" / "room" / "coarse_small" / "room"
        self.write_run(self.run_folder, POSE)

    def write_model(self, model, pose):
        poses.write_model(model, [poses.Image(pose, 1, name) for name in ("a.jpg", "b.jpg")], self.data / "room")

    def write_run(self, run, reference):
        # The output is where the reference is one sigma off along the camera's y.
        self.write_model(run / "sparse", perturbed(reference, along(4, -SIGMAS[4])))
        images = [{"name": name, "status": status, "reason": "", "predicted_shift_px": predicted_px,
                   "covariance": COVARIANCE}
                  for name, status, predicted_px in (("a.jpg", "refined", 1.5), ("b.jpg", "blurred", None))]
        (run / "report.json").write_text(json.dumps({"images": images}))
        (run / "after.json").write_text(json.dumps({"images": [{"name": "a.jpg", "mean_shift_px": 2.5}]}))

    def run_main(self, *arguments):
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            self.assertEqual(verdicts.main([str(self.data), str(self.out), *arguments]), 0)
        return output.getvalue()

    def assert_fails(self, text):
        with contextlib.redirect_stdout(io.StringIO()), self.assertRaises(SystemExit) as caught:
            verdicts.main([str(self.data), str(self.out)])
        # The interpreter prints a text that a program exits with, and makes it exit code 1.
        self.assertIsInstance(caught.exception.code, str)
        self.assertIn(text, caught.exception.code)
        self.assertNotIn("\n", caught.exception.code)

    def test_a_run_in_place(self):
        svg = self.out / "curve.svg"
        printed = self.run_main("--svg", str(svg))
        self.assertIn("1 images; by the pose in the output 1 within 3 px, 0 within 2 px", printed)
        self.assertIn("| `predicted_shift_px` ≤ 1.5 | 1 | 100 % | 100 % | 0 % | – |", printed)
        self.assertIn("| room | 1 | 0 | 1.0 | 1.0 | 100 % |", printed)
        self.assertIn("polyline", svg.read_text())

    def test_a_moved_copy_is_compared_with_its_own_reference(self):
        moved = moved_scene.moved_pose(POSE, OFFSET_M)
        self.write_model(self.out / "runs" / "room" / "moved0" / "truth" / "on_map", moved)
        # What else a copy holds is not taken for a run.
        self.write_model(self.out / "runs" / "room" / "moved0" / "coarse_small", moved)
        self.write_run(self.run_folder.parent / "moved0", moved)
        self.assertIn("| room | 2 | 0 | 1.0 | 1.0 | 100 % |", self.run_main())

    def test_missing_and_odd_input_is_told_in_a_line(self):
        (self.run_folder / "after.json").write_text("{")
        self.assert_fails("after.json: cannot be read")
        (self.run_folder / "after.json").unlink()
        self.assert_fails("after.json: cannot be read (No such file or directory)")
        (self.run_folder / "after.json").write_text("[]")
        self.assert_fails("not a report and an evaluation")

    def test_reports_that_lack_something_are_told(self):
        (self.run_folder / "report.json").write_text('{"images": [{"name": "a.jpg", "status": "kept_coarse"}]}')
        self.assert_fails("'reason' is missing")

    def test_missing_poses_are_told(self):
        shutil.rmtree(self.run_folder / "sparse")
        self.assert_fails("no COLMAP text model")

    def test_missing_runs_and_scenes_are_told(self):
        shutil.rmtree(self.out / "runs")
        self.assert_fails("no runs of scenes with exact truth")
        shutil.rmtree(self.data / "room")
        self.assert_fails("no scenes with exact truth")


if __name__ == "__main__":
    sys.exit(unittest.main())
