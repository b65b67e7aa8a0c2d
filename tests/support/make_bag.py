"""Writes a ROS 1 bag with Debian's rosbag library: make_bag.py FOLDER BAG [raw|compressed].

FOLDER/recording.json says what goes into it, paths below FOLDER:
  camera      {width, height, k: 9 numbers, d: 5 numbers}
  transforms  [{parent, child, translation: x y z, rotation: x y z w}], for /tf_static
  poses       [{stamp, translation, rotation}], odometry of the frame body in the frame odom
  scans       [{stamp, file}], float32 x y z intensity a point, in the frame lidar
  images      [{stamp, ppm, png}], the same picture twice
Exit code 3 where rosbag or one of the message packages is missing.
"""

import json
import sys

try:
    import rosbag
    import rospy
    from geometry_msgs.msg import TransformStamped
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField
    from tf2_msgs.msg import TFMessage
except ImportError as missing:
    print(missing, file=sys.stderr)
    sys.exit(3)


def stamped(message, stamp, frame):
    message.header.stamp = rospy.Time.from_sec(stamp)
    message.header.frame_id = frame
    return message


def set_pose(position, orientation, item):
    position.x, position.y, position.z = item["translation"]
    orientation.x, orientation.y, orientation.z, orientation.w = item["rotation"]


def tf_static(recording):
    message = TFMessage()
    for item in recording["transforms"]:
        transform = stamped(TransformStamped(), 0.0, item["parent"])
        transform.child_frame_id = item["child"]
        set_pose(transform.transform.translation, transform.transform.rotation, item)
        message.transforms.append(transform)
    return message


def odometry(item):
    message = stamped(Odometry(), item["stamp"], "odom")
    message.child_frame_id = "body"
    set_pose(message.pose.pose.position, message.pose.pose.orientation, item)
    return message


def cloud(item, data):
    message = stamped(PointCloud2(), item["stamp"], "lidar")
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1)
                      for i, name in enumerate(("x", "y", "z", "intensity"))]
    message.height, message.width = 1, len(data) // 16
    message.point_step, message.row_step = 16, len(data)
    message.is_dense, message.data = True, data
    return message


def raw_image(item, data):
    """Of a binary PPM whose header is one line a value: P6, width and height, 255."""
    kind, size, depth, pixels = data.split(b"\n", 3)
    assert kind == b"P6" and depth == b"255"
    message = stamped(Image(), item["stamp"], "camera")
    message.width, message.height = (int(n) for n in size.split())
    message.encoding, message.step, message.data = "rgb8", 3 * message.width, pixels
    return message


def compressed_image(item, data):
    message = stamped(CompressedImage(), item["stamp"], "camera")
    message.format, message.data = "rgb8; png compressed", data
    return message


def camera_info(camera, stamp):
    message = stamped(CameraInfo(), stamp, "camera")
    message.width, message.height = camera["width"], camera["height"]
    message.distortion_model = "plumb_bob"
    message.K, message.D = camera["k"], camera["d"]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    k = camera["k"]
    message.P = k[0:3] + [0] + k[3:6] + [0] + k[6:9] + [0]
    return message


def messages(folder, recording, is_raw):
    """(topic, message, stamp), in no order of time."""
    def read(name):
        with open(f"{folder}/{name}", "rb") as file:
            return file.read()

    yield "/tf_static", tf_static(recording), recording["poses"][0]["stamp"]
    for item in recording["poses"]:
        yield "/odometry", odometry(item), item["stamp"]
    for item in recording["scans"]:
        yield "/lidar/points", cloud(item, read(item["file"])), item["stamp"]
    for item in recording["images"]:
        yield "/camera/camera_info", camera_info(recording["camera"], item["stamp"]), item["stamp"]
        if is_raw:
            yield "/camera/image_raw", raw_image(item, read(item["ppm"])), item["stamp"]
        else:
            yield "/camera/image_raw/compressed", compressed_image(item, read(item["png"])), item["stamp"]


def main(folder, bag_path, kind):
    with open(f"{folder}/recording.json") as file:
        recording = json.load(file)
    with rosbag.Bag(bag_path, "w", compression="none" if kind == "raw" else "lz4") as bag:
        for topic, message, stamp in sorted(messages(folder, recording, kind == "raw"), key=lambda item: item[2]):
            bag.write(topic, message, rospy.Time.from_sec(stamp))


if __name__ == "__main__":
    main(*sys.argv[1:])
