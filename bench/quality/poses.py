"""COLMAP text models as far as the benchmark needs them: poses in, disturbed poses out."""

import math
import pathlib
import random
import shutil
from dataclasses import dataclass


@dataclass(frozen=True)
class Pose:
    """x_in_camera = rotation(q) * x_in_map + t; q = (w, x, y, z), a unit quaternion."""

    q: tuple
    t: tuple


@dataclass(frozen=True)
class Image:
    pose: Pose
    camera_id: int
    name: str


def multiply(a, b):
    """Hamilton product: rotation(multiply(a, b)) = rotation(a) * rotation(b)."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q, v):
    return multiply(multiply(q, (0.0, *v)), conjugate(q))[1:]


def camera_center(pose):
    return tuple(-x for x in rotate(conjugate(pose.q), pose.t))


def random_unit_vector(generator):
    while True:
        v = [generator.uniform(-1.0, 1.0) for _ in range(3)]
        length = math.sqrt(sum(x * x for x in v))
        if 0.1 < length <= 1.0:
            return [x / length for x in v]


def disturb(pose, angle_deg, distance_m, generator):
    """Turns the camera by exactly angle_deg about a random axis and moves it by distance_m in a random direction."""
    half = math.radians(angle_deg) / 2.0
    axis = random_unit_vector(generator)
    step = random_unit_vector(generator)
    q = multiply((math.cos(half), *(math.sin(half) * x for x in axis)), pose.q)
    center = [c + distance_m * s for c, s in zip(camera_center(pose), step)]
    return Pose(q, tuple(-x for x in rotate(q, center)))


def read_images(model):
    """The images of a model folder with text files, in the order of the file."""
    images = []
    lines = [line for line in (pathlib.Path(model) / "images.txt").read_text().splitlines() if not line.startswith("#")]
    for line in lines[0::2]:  # every second line lists observations
        fields = line.split(maxsplit=9)
        if len(fields) < 10:
            continue
        numbers = [float(x) for x in fields[1:8]]
        norm = math.sqrt(sum(x * x for x in numbers[:4]))
        images.append(Image(Pose(tuple(x / norm for x in numbers[:4]), tuple(numbers[4:])), int(fields[8]), fields[9]))
    return images


def write_model(model, images, cameras_from):
    """Writes a model folder with these images and the cameras of another one."""
    folder = pathlib.Path(model)
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(pathlib.Path(cameras_from) / "cameras.txt", folder / "cameras.txt")
    (folder / "points3D.txt").write_text("")
    with open(folder / "images.txt", "w") as file:
        for number, image in enumerate(images, start=1):
            values = " ".join(repr(x) for x in (*image.pose.q, *image.pose.t))
            file.write(f"{number} {values} {image.camera_id} {image.name}\n\n")


def disturbed(images, angle_deg, distance_m, generator):
    """The images, each disturbed on its own."""
    return [Image(disturb(image.pose, angle_deg, distance_m, generator), image.camera_id, image.name) for image in images]
