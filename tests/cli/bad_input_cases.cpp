#include "bad_input_cases.h"

#include <algorithm>
#include <filesystem>

#include "cpplus/io/colmap_io.h"

namespace cpplus {

namespace {

using Arguments = std::vector<std::string>;
using Cases = std::map<std::string, BadInputCase>;

std::string repeated(const std::string& text, size_t count) {
  std::string all;
  for (size_t i = 0; i < count; ++i) all += text;
  return all;
}

/// A PCD file of one line a point.
std::string pcd(const std::string& fields, const std::vector<std::string>& points) {
  const size_t num_fields = static_cast<size_t>(std::count(fields.begin(), fields.end(), ' ')) + 1;
  std::string text = "FIELDS " + fields + "\nSIZE" + repeated(" 4", num_fields) + "\nTYPE" +
                     repeated(" F", num_fields) + "\nCOUNT" + repeated(" 1", num_fields) + "\nWIDTH " +
                     std::to_string(points.size()) + "\nHEIGHT 1\nPOINTS " + std::to_string(points.size()) +
                     "\nDATA ascii\n";
  for (const std::string& point : points) text += point + "\n";
  return text;
}

/// A case that changes the value of one flag of `colorize`; DIR/ stands for the scene.
BadInputCase colorize_flag(const std::string& flag, const std::string& value) {
  return [=](const TinyScene& scene) {
    const bool is_path = value.starts_with("DIR/");
    return scene.colorize_with(flag, is_path ? scene.path(value.substr(4)) : value);
  };
}

/// A case that writes one file and then colours.
BadInputCase colorize_after_writing(const std::string& file, const std::string& text) {
  return [=](const TinyScene& scene) {
    scene.write(file, text);
    return scene.colorize();
  };
}

BadInputCase colorize_after_replacing(const std::string& file, const std::string& from, const std::string& to) {
  return [=](const TinyScene& scene) {
    scene.replace(file, from, to);
    return scene.colorize();
  };
}

BadInputCase info_after_writing(const std::string& file, const std::string& text) {
  return [=](const TinyScene& scene) {
    scene.write(file, text);
    return Arguments{"info", scene.path(file)};
  };
}

BadInputCase colorize_with_config(const std::string& yaml) {
  return [=](const TinyScene& scene) {
    scene.write("config.yaml", yaml);
    return scene.colorize({"--config", scene.path("config.yaml")});
  };
}

Arguments truncated_map(const TinyScene& scene, const std::string& name, size_t size) {
  scene.convert_map(name);
  scene.truncate(name, size);
  return scene.colorize_with("--map", scene.path(name));
}

/// LAS: the header's own size is the 16-bit number at byte 94.
Arguments las_with_header_size(const TinyScene& scene, uint16_t size) {
  scene.convert_map("map.las");
  std::string bytes = scene.read("map.las");
  bytes[94] = static_cast<char>(size & 0xff);
  bytes[95] = static_cast<char>(size >> 8);
  scene.write("map.las", bytes);
  return scene.colorize_with("--map", scene.path("map.las"));
}

Arguments truncated_binary_model(const TinyScene& scene) {
  const SparseModel model = read_sparse_model(scene.path("model"));
  write_sparse_model_binary(scene.path("binary"), model);
  scene.truncate("binary/images.bin", 100);
  return scene.colorize_with("--poses", scene.path("binary"));
}

Cases map_cases() {
  return {
      {"map does not exist", colorize_flag("--map", "DIR/none.pcd")},
      {"map is a folder", colorize_flag("--map", "DIR/images")},
      {"map of unknown extension", colorize_flag("--map", "DIR/stamps.txt")},
      {"map file of no bytes", colorize_after_writing("map.pcd", "")},
      {"map of no points", colorize_after_writing("map.pcd", pcd("x y z", {}))},
      {"PCD that is another kind of file", colorize_after_writing("map.pcd", "ply\nformat ascii 1.0\n")},
      {"PCD without z", colorize_after_writing("map.pcd", pcd("x y", {"0 0", "1 1"}))},
      {"PCD with a word for a number", colorize_after_writing("map.pcd", pcd("x y z", {"0 0 3", "0 one 3"}))},
      {"PCD with fewer points than it says", colorize_after_replacing("map.pcd", "0.00 0.65 3\n", "")},
      {"only NaN points", colorize_after_writing("map.pcd", pcd("x y z", {"nan nan nan", "0 inf 0"}))},
      {"some NaN points", info_after_writing("nan.pcd", pcd("x y z", {"nan nan nan", "0 0 3"}))},
      {"PLY truncated", [](const TinyScene& scene) { return truncated_map(scene, "map.ply", 1000); }},
      {"LAS truncated", [](const TinyScene& scene) { return truncated_map(scene, "map.las", 1000); }},
      {"LAS with wrong header size", [](const TinyScene& scene) { return las_with_header_size(scene, 100); }},
      {"map in millimetres",
       [](const TinyScene& scene) {
         scene.write("map.pcd", pcd("x y z", {"0 0 300000", "100 0 300000", "0 100 300000"}));
         return scene.colorize();
       }},
  };
}

Cases image_cases() {
  return {
      {"folder of images does not exist", colorize_flag("--images", "DIR/none")},
      {"folder of images is a file", colorize_flag("--images", "DIR/map.pcd")},
      {"folder without the model's images", colorize_flag("--images", "DIR/model")},
      {"image without pose", colorize_after_writing("images/c.png", "")},
      {"pose without image",
       [](const TinyScene& scene) {
         std::filesystem::remove(scene.path("images/b.png"));
         return scene.colorize();
       }},
      {"image truncated",
       [](const TinyScene& scene) {
         scene.truncate("images/b.png", 100);
         return scene.colorize();
       }},
      {"image that is text", colorize_after_writing("images/b.png", "no picture")},
      {"corrupt JPEG",
       [](const TinyScene& scene) {
         scene.write("images/b.jpg", "\xff\xd8\xff\xe0 broken");
         std::filesystem::remove(scene.path("images/b.png"));
         scene.replace("model/images.txt", "b.png", "b.jpg");
         return scene.colorize();
       }},
      {"no image that can be read",
       [](const TinyScene& scene) {
         for (const char* name : {"images/a.png", "images/b.png"}) scene.write(name, "no picture");
         return scene.colorize();
       }},
      {"image of another size than its camera",
       [](const TinyScene& scene) {
         scene.write("model/cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n2 PINHOLE 128 96 60 60 64 48\n");
         scene.replace("model/images.txt", "0 0 1 b.png", "0 0 2 b.png");
         return scene.colorize();
       }},
  };
}

Cases model_cases() {
  return {
      {"model folder does not exist", colorize_flag("--poses", "DIR/none")},
      {"folder without a model", colorize_flag("--poses", "DIR/images")},
      {"unknown camera model", colorize_after_replacing("model/cameras.txt", "PINHOLE", "PINHOLES")},
      {"zero focal length", colorize_after_replacing("model/cameras.txt", "60 60", "0 60")},
      {"missing camera parameter", colorize_after_replacing("model/cameras.txt", " 32 24", " 32")},
      {"image size of zero", colorize_after_replacing("model/cameras.txt", "64 48", "0 48")},
      {"image of a missing camera", colorize_after_replacing("model/images.txt", "1 b.png", "7 b.png")},
      {"bad quaternion", colorize_after_replacing("model/images.txt", "1 1 0 0 0", "1 0.5 0 0 0")},
      {"NaN pose", colorize_after_replacing("model/images.txt", "0.1 0 0 1 b.png", "nan 0 0 1 b.png")},
      {"image name twice", colorize_after_replacing("model/images.txt", "b.png", "a.png")},
      {"image id twice", colorize_after_replacing("model/images.txt", "2 1 0 0 0", "1 1 0 0 0")},
      {"binary model truncated", truncated_binary_model},
      {"cameras outside the map",
       [](const TinyScene& scene) {
         scene.replace("model/images.txt", "1 1 0 0 0 0 0", "1 1 0 0 0 900 0");
         scene.replace("model/images.txt", "0.1 0 0", "900 0 0");
         return scene.colorize();
       }},
  };
}

Cases text_cases() {
  return {
      {"trajectory with stamps that go back", info_after_writing("t.txt", "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n")},
      {"stamps with a word for a number", info_after_writing("s.txt", "a.png now\n")},
      {"stamps of one image twice", info_after_writing("s.txt", "a.png 1\na.png 2\n")},
      {"trajectory with commas", info_after_writing("t.txt", "1,0,0,0,0,0,0,1\n")},
      {"trajectory line with a missing value", info_after_writing("t.txt", "1 0 0 0 0 0 1\n")},
      {"path that does not exist",
       [](const TinyScene& scene) {
         return Arguments{"info", scene.path("none")};
       }},
      {"kind of file that is not known", info_after_writing("notes.doc", "text")},
  };
}

Arguments import(const TinyScene& scene, const std::string& format, const std::string& source) {
  return {"import", format, scene.path(source), "--out", scene.path("out")};
}

BadInputCase import_transforms(const std::string& json) {
  return [=](const TinyScene& scene) {
    scene.write("transforms.json", json);
    return import(scene, "nerfstudio", "transforms.json");
  };
}

Cases import_cases() {
  const auto of = [](const std::string& format, const std::string& source) {
    return [=](const TinyScene& scene) { return import(scene, format, source); };
  };
  const auto frame = [](const std::string& x, const std::string& number) {
    return "{\"fl_x\": 60, \"frames\": [{\"file_path\": \"images/a.png\", \"transform_matrix\": [[" + number +
           ", 0, 0, " + x + "], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}";
  };
  return {
      {"format to import that is not known", of("rtabmap", "images")},
      {"import without a source",
       [](const TinyScene& scene) {
         return Arguments{"import", "kitti", "--out", scene.path("out")};
       }},
      {"source to import does not exist", of("colmap", "none")},
      {"import into a folder that is in use",
       [](const TinyScene& scene) {
         return with_flag(import(scene, "colmap", "model"), "--out", scene.path("images"));
       }},
      {"COLMAP folder without a model", of("colmap", "images")},
      {"transforms.json that is not JSON", import_transforms("{\"frames\": [")},
      {"transforms.json without its images", import_transforms("{\"frames\": [{\"file_path\": \"gone.png\"}]}")},
      {"transform matrix with a word", import_transforms(frame("\"one\"", "1"))},
      {"transform matrix that stretches", import_transforms(frame("0", "2"))},
      {"KITTI sequence without calibration", of("kitti", "images")},
      {"KITTI drive without calibration", of("kitti-raw", "images")},
      {"FAST-LIVO2 output without its configuration",
       [](const TinyScene& scene) {
         std::filesystem::create_directories(scene.path("image"));
         scene.write("image/image_poses.txt", "10 0 0 0 0 0 0 1\n");
         return import(scene, "fast-livo2", ".");
       }},
      {"LIO-SAM poses without angles",
       [](const TinyScene& scene) {
         std::filesystem::create_directories(scene.path("lio_sam"));
         scene.write("lio_sam/transformations.pcd", pcd("x y z", {"0 0 0"}));
         return import(scene, "lio-sam", "lio_sam");
       }},
      {"bag that is none", of("rosbag", "stamps.txt")},
      {"R3LIVE output without a map", of("r3live", "images")},
  };
}

Cases run_cases() {
  const auto with_config = [](const TinyScene& scene, const std::string& yaml) {
    scene.write("config.yaml", yaml);
    return Arguments{"run", "--config", scene.path("config.yaml")};
  };
  return {
      {"run without a configuration", [](const TinyScene&) { return Arguments{"run"}; }},
      {"run of a configuration without steps",
       [=](const TinyScene& scene) { return with_config(scene, "threads: 1\n"); }},
      {"run of a step that fails",
       [=](const TinyScene& scene) {
         return with_config(scene, "poses: {trajectory: t, images: i, out: " + scene.path("out") +
                                       ", rig: " + scene.path("none.yaml") + "}\n");
       }},
  };
}

BadInputCase poses_flag(const std::string& flag, const std::string& value) {
  return [=](const TinyScene& scene) {
    return with_flag(scene.poses(), flag, value.starts_with("DIR/") ? scene.path(value.substr(4)) : value);
  };
}

BadInputCase poses_after_writing(const std::string& file, const std::string& text) {
  return [=](const TinyScene& scene) {
    scene.write(file, text);
    return scene.poses();
  };
}

BadInputCase poses_after_replacing(const std::string& file, const std::string& from, const std::string& to) {
  return [=](const TinyScene& scene) {
    scene.replace(file, from, to);
    return scene.poses();
  };
}

Cases poses_rig_cases() {
  return {
      {"rig that does not exist", poses_flag("--rig", "DIR/none.yaml")},
      {"rig that is not YAML", poses_after_writing("rig.yaml", "cameras: [\n")},
      {"rig of no known format", poses_after_writing("rig.yaml", "camera: 1\n")},
      {"unknown key in the rig", poses_after_replacing("rig.yaml", "{model", "{readout: 0.03, model")},
      {"bad quaternion in the rig", poses_after_replacing("rig.yaml", "[0.5, 0.5", "[1, 0.5")},
      {"rig without the extrinsic that is needed", poses_flag("--trajectory-frame", "body")},
      {"inverted extrinsic", poses_after_replacing("rig.yaml", "[0.5, 0.5, -0.5, 0.5]", "[0.5, -0.5, 0.5, -0.5]")},
      {"rig of another image size",
       poses_after_replacing("rig.yaml", "width: 64, height: 48", "width: 128, height: 96")},
  };
}

Cases poses_stamp_cases() {
  const std::string standing = " 0 0 0 0 0 0 1\n";
  return {
      {"KITTI trajectory without times", poses_after_writing("trajectory.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n")},
      {"csv trajectory without a header", poses_after_writing("trajectory.txt", "9,0,0,0,0,0,0,1\n")},
      {"trajectory pose that is no rotation",
       poses_after_replacing("trajectory.txt", "10 0 0 0 0 0 0 1", "10 0 0 0 0 0 0 2")},
      {"trajectory with a double stamp",
       poses_after_writing("trajectory.txt", "9" + standing + "10" + standing + "10" + standing + "11" + standing)},
      {"trajectory out of order",
       poses_after_writing("trajectory.txt", "9" + standing + "11" + standing + "10" + standing)},
      {"image outside the trajectory", poses_after_replacing("stamps.txt", "10.5", "12.5")},
      {"image in a gap of the trajectory", poses_flag("--max-gap-s", "0.5")},
      {"image without a stamp", poses_after_writing("stamps.txt", "a.png 10\n")},
      {"image with the stamp of another", poses_after_replacing("stamps.txt", "10.5", "10.0")},
      {"no image inside the trajectory", poses_after_writing("stamps.txt", "a.png 110\nb.png 111\n")},
      {"images numbered instead of stamped",
       [](const TinyScene& scene) {
         std::filesystem::create_directory(scene.path("numbered"));
         scene.write("numbered/000001.png", "");
         return with_flag(with_flag(scene.poses(), "--stamps", ""), "--images", scene.path("numbered"));
       }},
      {"stamps of images without names", poses_after_writing("stamps.txt", "10.0\n")},
      {"unknown unit of stamps", poses_flag("--stamp-unit", "days")},
      {"coarse model below a file", poses_flag("--out", "DIR/map.pcd/coarse")},
  };
}

BadInputCase refine_after_writing(const std::string& file, const std::string& text) {
  return [=](const TinyScene& scene) {
    scene.write(file, text);
    return scene.refine();
  };
}

Cases refine_cases() {
  return {
      {"view without edges", [](const TinyScene& scene) { return scene.refine(); }},
      {"camera outside the map",
       [](const TinyScene& scene) {
         scene.replace("model/images.txt", "0.1 0 0", "900 0 0");
         return scene.refine();
       }},
      {"corrupt image among good ones", refine_after_writing("images/b.png", "no picture")},
      {"pose without image to refine",
       [](const TinyScene& scene) {
         std::filesystem::remove(scene.path("images/b.png"));
         return scene.refine();
       }},
      {"image to refine of another size than its camera",
       [](const TinyScene& scene) {
         scene.write("model/cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n2 PINHOLE 128 96 60 60 64 48\n");
         scene.replace("model/images.txt", "0 0 1 b.png", "0 0 2 b.png");
         return scene.refine();
       }},
      {"no image to refine can be read",
       [](const TinyScene& scene) {
         for (const char* name : {"images/a.png", "images/b.png"}) scene.write(name, "no picture");
         return scene.refine();
       }},
      {"empty map to refine against", refine_after_writing("map.pcd", pcd("x y z", {}))},
      {"refined model below a file",
       [](const TinyScene& scene) { return with_flag(scene.refine(), "--out", scene.path("map.pcd/out")); }},
      {"read-only folder for the refined model",
       [](const TinyScene& scene) { return with_flag(scene.refine(), "--out", "/proc/cpplus"); }},
      {"unknown method of refinement",
       [](const TinyScene& scene) { return with_flag(scene.refine(), "--method", "icp"); }},
      {"option of refine out of range",
       [](const TinyScene& scene) { return with_flag(scene.refine(), "--voxel-map.root-size-m", "0"); }},
  };
}

Arguments evaluate(const TinyScene& scene, const Arguments& more = {}) {
  Arguments arguments = {"evaluate", "--estimate", scene.path("model"), "--reference", scene.path("model")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

Arguments simulate(const TinyScene& scene, const Arguments& more) {
  Arguments arguments = {"simulate", "--out", scene.path("out"), "--images", "1", "--scans", "1"};
  for (size_t i = 0; i + 1 < more.size(); i += 2) arguments = with_flag(arguments, more[i], more[i + 1]);
  return arguments;
}

Cases evaluate_cases() {
  return {
      {"reference that does not exist",
       [](const TinyScene& scene) { return with_flag(evaluate(scene), "--reference", scene.path("none")); }},
      {"models without a common image",
       [](const TinyScene& scene) {
         std::filesystem::copy(scene.path("model"), scene.path("other"));
         scene.write("other/images.txt", "1 1 0 0 0 0 0 0 1 x.png\n\n");
         return with_flag(evaluate(scene), "--reference", scene.path("other"));
       }},
      {"checkerboards that are not JSON",
       [](const TinyScene& scene) {
         scene.write("boards.json", "{\"boards\": [");
         return evaluate(scene, {"--checkerboards", scene.path("boards.json")});
       }},
      {"folder of ranges that does not exist",
       [](const TinyScene& scene) {
         return evaluate(scene, {"--depth", scene.path("none")});
       }},
  };
}

Cases simulate_cases() {
  return {
      {"unknown scene",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "castle"});
       }},
      {"no images to simulate",
       [](const TinyScene& scene) {
         return simulate(scene, {"--images", "0"});
       }},
      {"camera that cannot be simulated",
       [](const TinyScene& scene) {
         return simulate(scene, {"--camera", "FULL_OPENCV"});
       }},
      {"district without an area",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district"});
       }},
      {"district of a negative area",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "-2"});
       }},
      {"district of an area that is no number",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "nan"});
       }},
      {"district as large as a country",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "357000"});
       }},
      {"district of fewer than no points",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "1", "--points", "-5"});
       }},
      {"area of a room",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "room", "--area", "0.1"});
       }},
      {"district with checkerboards",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "1", "--boards", "3"});
       }},
      {"district below a file",
       [](const TinyScene& scene) {
         return simulate(scene, {"--scene", "district", "--area", "0.01", "--out", scene.path("map.pcd/world")});
       }},
      {"world below a file",
       [](const TinyScene& scene) {
         return simulate(scene, {"--out", scene.path("map.pcd/world")});
       }},
  };
}

/// A case that changes the value of one flag of `clean`.
BadInputCase clean_flag(const std::string& flag, const std::string& value) {
  return [=](const TinyScene& scene) {
    const bool is_path = value.starts_with("DIR/");
    return with_flag(scene.clean(), flag, is_path ? scene.path(value.substr(4)) : value);
  };
}

Cases clean_cases() {
  const auto after_writing = [](const std::string& file, const std::string& text) -> BadInputCase {
    return [=](const TinyScene& scene) {
      scene.write(file, text);
      return scene.clean();
    };
  };
  return {
      {"folder of scans does not exist", clean_flag("--scans", "DIR/none")},
      {"folder of scans is a file", clean_flag("--scans", "DIR/map.pcd")},
      {"folder without scans", clean_flag("--scans", "DIR/images")},
      {"scan poses do not exist", clean_flag("--poses", "DIR/none.txt")},
      {"more poses than scans",
       after_writing("scans/poses.txt", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n")},
      {"scan without pose", after_writing("scans/2.pcd", "")},
      {"corrupt scan among good ones", after_writing("scans/1.pcd", "no scan\n")},
      {"scan without a finite point", after_writing("scans/1.pcd", pcd("x y z", {"nan 0 1"}))},
      {"scan pose that is not a number", after_writing("scans/poses.txt", "1 0 0 0 0 0 0 1\n2 0 nan 0 0 0 0 1\n")},
      {"static map of unknown extension", clean_flag("--out", "DIR/out.xyz")},
      {"static map below a file", clean_flag("--out", "DIR/map.pcd/out.ply")},
      {"labels below a file", clean_flag("--labels", "DIR/map.pcd/labels")},
      {"option of clean out of range", clean_flag("--dynamics.fill-share", "0")},
  };
}

/// A case that changes the value of one flag of `export`; DIR/ stands for the scene.
BadInputCase export_flag(const std::string& format, const std::string& flag, const std::string& value) {
  return [=](const TinyScene& scene) {
    return with_flag(scene.exports(format), flag, value.starts_with("DIR/") ? scene.path(value.substr(4)) : value);
  };
}

/// A case that writes one file and then exports with the stamps.
BadInputCase export_after_writing(const std::string& format, const std::string& file, const std::string& text) {
  return [=](const TinyScene& scene) {
    scene.write(file, text);
    return scene.exports(format, {"--stamps", scene.path("stamps.txt")});
  };
}

Cases export_cases() {
  const std::string poses = " 1 0 0 0 0 0 0 1 ";
  return {
      {"unknown format of an export", export_flag("ply", "--out", "DIR/out")},
      {"export of a map without the map", export_flag("colmap-bin", "--map", "")},
      {"export of images without their folder", export_flag("3dgs", "--images", "")},
      {"export of a TUM trajectory without stamps", export_flag("tum", "--out", "DIR/out")},
      {"export of poses without the model", export_flag("kitti", "--poses", "")},
      {"Potree export about the cameras without poses",
       [](const TinyScene& scene) { return with_flag(scene.exports("potree", {"--local-origin"}), "--poses", ""); }},
      {"Potree export of a broken map", export_after_writing("potree", "map.pcd", "no cloud")},
      {"export into a folder that holds files", export_flag("colmap-bin", "--out", "DIR/images")},
      {"export below a file", export_flag("colmap-bin", "--out", "DIR/map.pcd/out")},
      {"depth of unknown kind", export_flag("depth", "--depth-kind", "disparity")},
      {"option of export out of range", export_flag("colmap-bin", "--max-points", "0")},
      {"export of a map that the images do not see",
       export_after_writing("colmap-bin", "map.pcd", pcd("x y z", {"0 0 -3", "1 0 -3", "0 1 -3"}))},
      {"stamps of other images in an export", export_after_writing("tum", "stamps.txt", "c.png 10\n")},
      {"images of one camera with the same stamp in an export",
       export_after_writing("tum", "stamps.txt", "a.png 10\nb.png 10\n")},
      {"depth of a panorama along its axis",
       export_after_writing("depth", "model/cameras.txt", "1 EQUIRECTANGULAR 64 48 64 48\n")},
      {"undistorted image of too few pixels",
       export_after_writing("3dgs", "model/cameras.txt", "1 SIMPLE_RADIAL 64 48 60 2 24 0.1\n")},
      {"image name that leads out of an export",
       export_after_writing("undistorted", "model/images.txt",
                            "1" + poses + "../images/a.png\n\n2" + poses + "b.png\n\n")},
      {"corrupt image among good ones in an export",
       [](const TinyScene& scene) {
         scene.write("images/b.png", "no image");
         return with_flag(scene.exports("undistorted"), "--map", "");
       }},
  };
}

/// `adjust` of the scene, a flag of it changed where one is named.
BadInputCase adjust_flag(const std::string& flag, const std::string& value) {
  return [=](const TinyScene& scene) {
    const auto path_of = [&](const std::string& text) {
      return text.starts_with("DIR/") ? scene.path(text.substr(4)) : text;
    };
    const Arguments arguments = {"adjust",
                                 "--scans",
                                 scene.path("scans"),
                                 "--poses",
                                 scene.path("scans/poses.txt"),
                                 "--out",
                                 scene.path("adjusted.txt")};
    return with_flag(arguments, flag, path_of(value));
  };
}

Cases adjust_cases() {
  return {
      {"scans to adjust do not exist", adjust_flag("--scans", "DIR/none")},
      {"poses to adjust do not exist", adjust_flag("--poses", "DIR/none.txt")},
      {"scan to adjust without pose",
       [](const TinyScene& scene) {
         scene.write("scans/2.pcd", "");
         return adjust_flag("--scans", "DIR/scans")(scene);
       }},
      {"scan to adjust without a finite point",
       [](const TinyScene& scene) {
         scene.write("scans/1.pcd", pcd("x y z", {"nan 0 1"}));
         return adjust_flag("--scans", "DIR/scans")(scene);
       }},
      {"fewer than three scans to adjust", adjust_flag("--scans", "DIR/scans")},
      {"map of adjust of unknown extension", adjust_flag("--map", "DIR/out.xyz")},
      {"option of adjust out of range", adjust_flag("--adjust.patches.min-scans", "1")},
      {"report in the trajectory's place", adjust_flag("--out", "poses.json")},
  };
}

Cases output_cases() {
  return {
      {"output of unknown extension", colorize_flag("--out", "DIR/out.xyz")},
      {"output below a file", colorize_flag("--out", "DIR/map.pcd/out.ply")},
      {"output is a folder",
       [](const TinyScene& scene) {
         std::filesystem::create_directory(scene.path("folder.ply"));
         return scene.colorize_with("--out", scene.path("folder.ply"));
       }},
      {"output folder that is read-only", colorize_flag("--out", "/proc/cpplus/out.ply")},
  };
}

Cases usage_cases() {
  return {
      {"no such command", [](const TinyScene&) { return Arguments{"colourise"}; }},
      {"unknown option", colorize_flag("--mapp", "x.pcd")},
      {"required option missing", [](const TinyScene&) { return Arguments{"colorize"}; }},
      {"argument too many", [](const TinyScene& scene) { return scene.colorize({"more"}); }},
      {"option without its value", [](const TinyScene& scene) { return scene.colorize({"--threads"}); }},
      {"negative number of threads", colorize_flag("--threads", "-2")},
      {"word for a number", colorize_flag("--voxel-map.leaf-size-m", "small")},
      {"number out of range", colorize_flag("--voxel-map.leaf-size-m", "-1")},
      {"configuration does not exist", colorize_flag("--config", "DIR/none.yaml")},
      {"configuration that is not YAML", colorize_with_config("colorize: {map: [\n")},
      {"unknown key in the configuration", colorize_with_config("colorize:\n  colour: 3\n")},
      {"wrong type in the configuration", colorize_with_config("colorize:\n  color:\n    max_samples: many\n")},
      {"key twice in the configuration", colorize_with_config("threads: 1\nthreads: 2\n")},
      {"number out of range in the configuration", colorize_with_config("threads: -3\n")},
  };
}

}  // namespace

Cases bad_input_cases() {
  Cases all;
  for (Cases some :
       {map_cases(), bad_voxel_map_cases(), image_cases(), model_cases(), text_cases(), import_cases(), run_cases(),
        poses_rig_cases(), poses_stamp_cases(), refine_cases(), clean_cases(), adjust_cases(), export_cases(),
        bad_result_cases(), evaluate_cases(), simulate_cases(), output_cases(), usage_cases()}) {
    all.merge(some);
  }
  return all;
}

}  // namespace cpplus
