#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cpplus {

/// A file of a page, part of the program (built from web/ and kept in web/dist).
struct WebFile {
  std::string name;
  std::string_view content;
};

/// The files that the report's page consists of, apart from its data.
std::vector<WebFile> report_web_files();

/// The same for the viewer.
std::vector<WebFile> view_web_files();

/// Writes them into a folder, each atomically.
void write_web_files(const std::vector<WebFile>& files, const std::string& folder);

}  // namespace cpplus
