#!/usr/bin/env python3
"""What Open3D (python3-open3d) does with the same cloud; one task a call, so that time and memory can be measured."""

import argparse
import json
import pathlib
import sys
import time

import numpy as np
import open3d as o3d

FRAMES = 60
GAP_M = 2.0  # between copies of a cloud


def write_line(**values):
    print(json.dumps(values), flush=True)


def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def rows_of(path):
    return [line.split() for line in path.read_text().splitlines() if line and not line.startswith("#")]


def read_pinhole_model(folder):
    """[(name, camera of Open3D)] of a COLMAP text model of PINHOLE cameras whose points2D lines are left out or empty."""
    cameras = {row[0]: row for row in rows_of(folder / "cameras.txt")}
    views = []
    for row in rows_of(folder / "images.txt"):
        if len(row) != 10 or row[8] not in cameras:
            continue
        camera = o3d.camera.PinholeCameraParameters()
        _, model, width, height, fx, fy, cx, cy = cameras[row[8]]
        if model != "PINHOLE":
            sys.exit(f"{folder}: camera {row[8]} is {model}, not PINHOLE")
        camera.intrinsic = o3d.camera.PinholeCameraIntrinsic(int(width), int(height), float(fx), float(fy),
                                                             float(cx) - 0.5, float(cy) - 0.5)
        camera_from_map = np.eye(4)
        camera_from_map[:3, :3] = rotation([float(x) for x in row[1:5]])
        camera_from_map[:3, 3] = [float(x) for x in row[5:8]]
        camera.extrinsic = camera_from_map
        views.append((row[9], camera))
    return views


def depth_of_points(cloud, camera):
    """Depth in metres of the nearest point of each pixel, 0 where there is none: Open3D's own projection of a cloud."""
    intrinsic = camera.intrinsic
    image = cloud.project_to_depth_image(intrinsic.width, intrinsic.height, o3d.core.Tensor(intrinsic.intrinsic_matrix),
                                         o3d.core.Tensor(camera.extrinsic), depth_scale=1.0, depth_max=100.0)
    return image.to_legacy()


def color(arguments):
    """Colours the points by pipelines.color_map. It takes a mesh: the points are its vertices, without triangles."""
    cloud = o3d.io.read_point_cloud(str(arguments.cloud))
    points = o3d.t.geometry.PointCloud.from_legacy(cloud)
    left_out = set(filter(None, arguments.leave_out.split(",")))
    trajectory, images = o3d.camera.PinholeCameraTrajectory(), []
    cameras = []
    for name, camera in read_pinhole_model(arguments.model / "sparse"):
        if name in left_out:
            continue
        photo = o3d.io.read_image(str(arguments.model / "images" / name))
        if arguments.depths:
            file = arguments.depths / (pathlib.Path(name).stem + ".png")
            millimetres = np.asarray(o3d.io.read_image(str(file)))
            depth = o3d.geometry.Image((millimetres / 1000.0).astype(np.float32))
        else:
            depth = depth_of_points(points, camera)
        images.append(o3d.geometry.RGBDImage.create_from_color_and_depth(photo, depth, 1.0, 100.0, False))
        cameras.append(camera)
    trajectory.parameters = cameras
    option = o3d.pipelines.color_map.RigidOptimizerOption(
        maximum_iteration=arguments.iterations, maximum_allowable_depth=100.0,
        depth_threshold_for_visibility_check=0.08, invisible_vertex_color_knn=0,
        # A cloud's own depth image has a hole in nearly every neighbourhood; each would count as a border.
        depth_threshold_for_discontinuity_check=0.1 if arguments.depths else 1e9)
    mesh = o3d.geometry.TriangleMesh()
    mesh.vertices = cloud.points
    mesh, _ = o3d.pipelines.color_map.run_rigid_optimizer(mesh, images, trajectory, option)
    cloud.colors = mesh.vertex_colors
    o3d.io.write_point_cloud(str(arguments.out), cloud)
    write_line(points=len(cloud.points), images=len(images))


def layout(arguments):
    """Lays the coloured cloud out again and again on a square grid, PLY with float32 positions and 8-bit colours."""
    cloud = o3d.t.io.read_point_cloud(str(arguments.cloud)).point
    positions, colors = cloud["positions"].numpy(), cloud["colors"].numpy()
    size = np.ptp(positions, axis=0) + GAP_M
    columns = int(np.ceil(np.sqrt(arguments.copies)))
    cells = [np.array([i % columns, i // columns, 0]) * size for i in range(arguments.copies)]
    result = o3d.t.geometry.PointCloud(np.concatenate([positions + cell for cell in cells]).astype(np.float32))
    result.point["colors"] = np.tile(colors, (arguments.copies, 1)).astype(np.uint8)
    o3d.t.io.write_point_cloud(str(arguments.out), result)
    write_line(points=len(positions) * arguments.copies)


def copy(arguments):
    cloud = o3d.io.read_point_cloud(str(arguments.cloud))
    o3d.io.write_point_cloud(str(arguments.out), cloud)


def subsample(arguments):
    cloud = o3d.io.read_point_cloud(str(arguments.cloud)).voxel_down_sample(0.05)
    o3d.io.write_point_cloud(str(arguments.out), cloud)


def normals(arguments):
    cloud = o3d.io.read_point_cloud(str(arguments.cloud))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamRadius(0.1))
    o3d.io.write_point_cloud(str(arguments.out), cloud)


def show(arguments):
    """Draws the cloud in a window, turns it, and says how many frames a second that was."""
    begin = time.monotonic()
    cloud = o3d.io.read_point_cloud(str(arguments.cloud))
    window = o3d.visualization.Visualizer()
    if not window.create_window(width=1280, height=800):
        sys.exit("no window")
    window.add_geometry(cloud)
    window.get_render_option().point_size = 2.0
    window.poll_events()
    window.update_renderer()
    window.capture_screen_image(str(arguments.out), True)
    first_s = time.monotonic() - begin
    begin, frames = time.monotonic(), 0
    while frames < FRAMES and time.monotonic() - begin < 30.0:
        window.get_view_control().rotate(8.0, 0.0)
        window.poll_events()
        window.update_renderer()
        frames += 1
    window.capture_screen_image(str(arguments.out), True)  # waits for what was drawn
    write_line(first_picture_s=first_s, frames_per_s=frames / (time.monotonic() - begin))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("task", choices=["color", "layout", "copy", "subsample", "normals", "show"])
    parser.add_argument("cloud", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--model", type=pathlib.Path, help="folder with sparse/ (COLMAP text, PINHOLE) and images/")
    parser.add_argument("--depths", type=pathlib.Path, help="folder of 16-bit depth maps, mm; else the cloud's own")
    parser.add_argument("--iterations", type=int, default=0)
    parser.add_argument("--copies", type=int, default=1)
    parser.add_argument("--leave-out", default="", help="names of images, with commas between them")
    arguments = parser.parse_args()
    globals()[arguments.task](arguments)


if __name__ == "__main__":
    main()
