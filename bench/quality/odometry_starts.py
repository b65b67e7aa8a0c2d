"""Coarse camera poses with the errors of an odometry: extrinsic, clock, drift and noise, drawn with a seed."""

import math
import random
from dataclasses import dataclass

import poses


@dataclass(frozen=True)
class OdometryErrors:
    """What is wrong with the camera poses of one odometry. Angles and distances are lengths of 3-vectors.

    The extrinsic error has exactly the given size and is constant in the camera frame. Drift is an Ornstein-Uhlenbeck
    process in the map frame with memory `drift_memory_s`, brought to zero at the first image (`align="start"`: the
    odometry begins at the map's origin) or to zero mean (`align="trajectory"`: it is laid over the true trajectory)
    and then scaled to exactly the given root mean square over the images. Noise is drawn anew for each image."""

    extrinsic_deg: float
    extrinsic_m: float
    time_offset_s: float
    drift_deg: float
    drift_m: float
    drift_memory_s: float
    noise_deg: float
    noise_m: float
    align: str


# Sources and reasons: docs/paper_experiments.md.
ODOMETRIES = {
    "vins_mono": OdometryErrors(1.0, 0.03, 0.005, 1.1, 0.11, 8.0, 0.1, 0.01, "trajectory"),
    "lio_sam": OdometryErrors(1.0, 0.03, 0.020, 0.3, 0.03, 25.0, 0.05, 0.005, "start"),
    "r2live": OdometryErrors(0.5, 0.02, 0.010, 0.28, 0.028, 25.0, 0.05, 0.005, "start"),
    "r3live": OdometryErrors(0.3, 0.02, 0.005, 0.14, 0.014, 25.0, 0.05, 0.005, "start"),
}


def ornstein_uhlenbeck(stamps_s, memory_s, generator):
    """One stationary path of unit variance at these instants (ascending)."""
    values = []
    for i, stamp in enumerate(stamps_s):
        keep = math.exp(-(stamp - stamps_s[i - 1]) / memory_s) if i > 0 else 0.0
        previous = values[-1] if values else 0.0
        values.append(keep * previous + math.sqrt(1.0 - keep * keep) * generator.gauss(0.0, 1.0))
    return values


def drift(stamps_s, memory_s, size, align, generator):
    """A 3-vector for each instant, with root mean square length `size` over all of them."""
    paths = []
    for _ in range(3):
        path = ornstein_uhlenbeck(stamps_s, memory_s, generator)
        zero = path[0] if align == "start" else sum(path) / len(path)
        paths.append([value - zero for value in path])
    vectors = list(zip(*paths))
    mean_square = sum(x * x for vector in vectors for x in vector) / len(vectors)
    scale = size / math.sqrt(mean_square) if mean_square > 0.0 else 0.0
    return [tuple(scale * x for x in vector) for vector in vectors]


def noise(size, generator):
    """A normal 3-vector with root mean square length `size`."""
    return tuple(size / math.sqrt(3.0) * generator.gauss(0.0, 1.0) for _ in range(3))


def rotation_exp(vector_rad):
    angle = math.hypot(*vector_rad)
    if angle == 0.0:
        return (1.0, 0.0, 0.0, 0.0)
    return (math.cos(0.5 * angle), *(math.sin(0.5 * angle) / angle * x for x in vector_rad))


def perturb(pose, rotation_rad, translation_m):
    """Turns and moves the camera by vectors in its own frame (docs/conventions.md): R Exp(a), c + R b."""
    q = poses.multiply(poses.conjugate(rotation_exp(rotation_rad)), pose.q)
    step = poses.rotate(poses.conjugate(pose.q), translation_m)
    center = [c + s for c, s in zip(poses.camera_center(pose), step)]
    return poses.Pose(q, tuple(-x for x in poses.rotate(q, center)))


def odometry_start(images, stamps_s, errors, seed):
    """The images with the errors of an odometry. `images` have their true poses at stamp + errors.time_offset_s (the
    clock error is in them already); stamps_s are by name."""
    generator = random.Random(seed)
    stamps = [stamps_s[image.name] for image in images]
    radians = math.pi / 180.0
    extrinsic_rad = [errors.extrinsic_deg * radians * x for x in poses.random_unit_vector(generator)]
    extrinsic_m = [errors.extrinsic_m * x for x in poses.random_unit_vector(generator)]
    drift_rad = drift(stamps, errors.drift_memory_s, errors.drift_deg * radians, errors.align, generator)
    drift_m = drift(stamps, errors.drift_memory_s, errors.drift_m, errors.align, generator)
    result = []
    for i, image in enumerate(images):
        turns = (extrinsic_rad, poses.rotate(image.pose.q, drift_rad[i]), noise(errors.noise_deg * radians, generator))
        steps = (extrinsic_m, poses.rotate(image.pose.q, drift_m[i]), noise(errors.noise_m, generator))
        pose = perturb(image.pose, [sum(x) for x in zip(*turns)], [sum(x) for x in zip(*steps)])
        result.append(poses.Image(pose, image.camera_id, image.name))
    return result
