#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cpplus {

/// The unit of a stamp written as a number.
enum class StampUnit { kAuto, kSeconds, kMilliseconds, kMicroseconds, kNanoseconds };

/// "auto", "s", "ms", "us", "ns"; nothing for another name.
std::optional<StampUnit> stamp_unit_from_name(const std::string& name);

/// A stamp in seconds. kAuto: a number with a point is seconds; a whole one goes by its digits, as clocks that count
/// from 1970 do: 18 and more are nanoseconds, 15 to 17 microseconds, 12 to 14 milliseconds, fewer seconds. Nothing for
/// what is not a finite number.
std::optional<double> parse_stamp(std::string_view word, StampUnit unit);

/// The stamp in a file's name: its number with the most digits ("left/1403636579763555584.png", "image_12.25.jpg"), or
/// seconds and nine digits of nanoseconds joined by '_' or '-' ("1661398632_022152000.png"). Nothing without a number.
std::optional<double> stamp_of_file_name(const std::string& name, StampUnit unit);

/// Whether a name's number is whole and too short for a clock ("frame_000012.png"), so that it may count images.
bool may_be_frame_number(const std::string& name);

/// Reads stamps of images: lines `name seconds`, `seconds name`, or comma-separated with a name in one column and the
/// stamp in the first other one that is a number (EuRoC's data.csv); '#' starts a comment line, and a first line of csv
/// without a number is its header. Throws Error naming file, line and value for anything else, a name that occurs
/// twice, and a file without stamps.
std::map<std::string, double> read_image_stamps(const std::string& path, StampUnit unit);

}  // namespace cpplus
