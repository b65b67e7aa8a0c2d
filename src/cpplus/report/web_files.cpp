#include "cpplus/report/web_files.h"

#include "cpplus/io/atomic_file.h"

// The assembler puts the file's bytes between two symbols, which is quicker to build than an array of numbers.
#define CPPLUS_EMBED(symbol, file)                                                         \
  __asm__(                                                                                 \
      ".section .rodata\n"                                                                 \
      ".global " #symbol "_begin\n.global " #symbol                                        \
      "_end\n"                                                                             \
      ".balign 16\n" #symbol "_begin:\n.incbin \"" CPPLUS_WEB_DIST "/" file "\"\n" #symbol \
      "_end:\n.byte 0\n.previous\n");                                                      \
  extern "C" const char symbol##_begin[], symbol##_end[]

CPPLUS_EMBED(cpplus_web_report_html, "report.html");
CPPLUS_EMBED(cpplus_web_report_js, "report.js");
CPPLUS_EMBED(cpplus_web_report_css, "report.css");
CPPLUS_EMBED(cpplus_web_view_html, "view.html");
CPPLUS_EMBED(cpplus_web_view_js, "view.js");
CPPLUS_EMBED(cpplus_web_view_css, "view.css");
CPPLUS_EMBED(cpplus_web_licenses, "LICENSES.txt");

namespace cpplus {
namespace {

WebFile file(const char* name, const char* begin, const char* end) {
  return {name, std::string_view(begin, static_cast<size_t>(end - begin))};
}

}  // namespace

std::vector<WebFile> report_web_files() {
  return {file("index.html", cpplus_web_report_html_begin, cpplus_web_report_html_end),
          file("report.js", cpplus_web_report_js_begin, cpplus_web_report_js_end),
          file("report.css", cpplus_web_report_css_begin, cpplus_web_report_css_end),
          file("LICENSES.txt", cpplus_web_licenses_begin, cpplus_web_licenses_end)};
}

std::vector<WebFile> view_web_files() {
  return {file("index.html", cpplus_web_view_html_begin, cpplus_web_view_html_end),
          file("view.js", cpplus_web_view_js_begin, cpplus_web_view_js_end),
          file("view.css", cpplus_web_view_css_begin, cpplus_web_view_css_end),
          file("LICENSES.txt", cpplus_web_licenses_begin, cpplus_web_licenses_end)};
}

void write_web_files(const std::vector<WebFile>& files, const std::string& folder) {
  for (const WebFile& web_file : files) write_text_file(folder + "/" + web_file.name, std::string(web_file.content));
}

}  // namespace cpplus
