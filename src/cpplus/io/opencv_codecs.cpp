#include "cpplus/io/opencv_codecs.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

struct Codecs {
  cv::Mat (*decode)(cv::InputArray, int) = nullptr;
  bool (*encode)(const std::string&, cv::InputArray, std::vector<uint8_t>&, const std::vector<int>&) = nullptr;
  std::string problem;
};

// Names as the Itanium C++ ABI spells cv::imdecode and cv::imencode with the types above. The library stays loaded.
Codecs load_codecs() {
  Codecs codecs;
  void* library = dlopen(CPPLUS_OPENCV_CODECS, RTLD_NOW | RTLD_LOCAL);
  if (library != nullptr) {
    codecs.decode = reinterpret_cast<decltype(codecs.decode)>(dlsym(library, "_ZN2cv8imdecodeERKNS_11_InputArrayEi"));
    codecs.encode = reinterpret_cast<decltype(codecs.encode)>(
        dlsym(library,
              "_ZN2cv8imencodeERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKNS_11_InputArrayERSt6vector"
              "IhSaIhEERKSB_IiSaIiEE"));
  }
  if (codecs.decode == nullptr || codecs.encode == nullptr) {
    const char* problem = dlerror();
    codecs.problem = fmt::format("cannot load OpenCV's codecs: {}", problem != nullptr ? problem : "unknown library");
  }
  return codecs;
}

const Codecs& codecs() {
  static const Codecs loaded = load_codecs();
  if (!loaded.problem.empty()) throw Error(loaded.problem);
  return loaded;
}

}  // namespace

cv::Mat opencv_decode(const std::vector<uint8_t>& bytes, int flags) { return codecs().decode(bytes, flags); }

std::vector<uint8_t> opencv_encode(const std::string& extension, const cv::Mat& bgr,
                                   const std::vector<int>& parameters) {
  std::vector<uint8_t> bytes;
  if (!codecs().encode(extension, bgr, bytes, parameters)) bytes.clear();
  return bytes;
}

}  // namespace cpplus
