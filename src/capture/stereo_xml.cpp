// OpenCV's FileStorage in XML, without OpenCV's reader, which trusts what it reads.
#include <fmt/format.h>
#include <tinyxml2.h>

#include <cmath>

#include "camera_formats.h"
#include "camera_storage.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/core/words.h"

namespace simgap {
namespace {

class XmlStorage : public CameraStorage {
 public:
  explicit XmlStorage(const CameraFile& file) : file_(file.name) {
    if (document_.Parse(file.text.data(), file.text.size()) != tinyxml2::XML_SUCCESS) {
      throw ConfigError(fmt::format("{}:{}: found no XML, expected OpenCV's file storage ({})", file_,
                                    document_.ErrorLineNum(), document_.ErrorName()));
    }
    root_ = document_.FirstChildElement("opencv_storage");
    if (root_ == nullptr) throw ConfigError(fmt::format("{}: found no element opencv_storage, expected it", file_));
  }

  std::optional<cv::Mat> matrix(const std::string& name) const override {
    const tinyxml2::XMLElement* const element = find(name);
    if (element == nullptr) return std::nullopt;
    const int rows = integer(child(*element, "rows"), 1, kMostStorageRows);
    const int cols = integer(child(*element, "cols"), 1, kMostStorageRows);
    const tinyxml2::XMLElement& data = child(*element, "data");
    const std::vector<double> numbers = numbersOfElement(data);
    if (std::ssize(numbers) != rows * cols) {
      fail(data, fmt::format("found {} numbers, expected {} x {}", numbers.size(), rows, cols));
    }
    return cv::Mat(numbers, /*copyData=*/true).reshape(1, rows);
  }

  int side(const std::string& name) const override {
    const tinyxml2::XMLElement* const element = find(name);
    return element == nullptr ? 0 : integer(*element, 0, kMostPixels);
  }

 private:
  [[noreturn]] void fail(const tinyxml2::XMLElement& element, const std::string& sentence) const {
    throw ConfigError(fmt::format("{}:{}: {}: {}", file_, element.GetLineNum(), abridged(element.Name()), sentence));
  }

  const tinyxml2::XMLElement* find(const std::string& name) const {
    const tinyxml2::XMLElement* const element = root_->FirstChildElement(name.c_str());
    if (element != nullptr && element->NextSiblingElement(name.c_str()) != nullptr) {
      fail(*element, "found it twice, expected it once");
    }
    return element;
  }

  const tinyxml2::XMLElement& child(const tinyxml2::XMLElement& element, const char* name) const {
    const tinyxml2::XMLElement* const found = element.FirstChildElement(name);
    if (found == nullptr) fail(element, fmt::format("found no {} in it, expected rows, cols and data", name));
    return *found;
  }

  std::vector<double> numbersOfElement(const tinyxml2::XMLElement& element) const {
    Words words(element.GetText() == nullptr ? "" : element.GetText());
    std::vector<double> numbers;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const std::optional<double> number = parseNumber(word);
      if (!number || !(std::abs(*number) <= kLensNumber.upper)) {
        fail(element, fmt::format("found '{}', expected {}", abridged(word), kLensNumber.expected));
      }
      numbers.push_back(*number);
    }
    return numbers;
  }

  int integer(const tinyxml2::XMLElement& element, long lower, long upper) const {
    const std::vector<double> numbers = numbersOfElement(element);
    const bool whole = numbers.size() == 1 && numbers[0] == std::floor(numbers[0]) &&
                       numbers[0] >= static_cast<double>(lower) && numbers[0] <= static_cast<double>(upper);
    if (!whole) fail(element, fmt::format("found no integer from {} to {}, expected one", lower, upper));
    return static_cast<int>(numbers[0]);
  }

  std::string file_;
  tinyxml2::XMLDocument document_;
  const tinyxml2::XMLElement* root_ = nullptr;
};

}  // namespace

StereoCameras readStereoXml(const CameraFile& file) { return stereoFrom(XmlStorage(file), file.name); }

std::string writeStereoXml(const StereoCameras& cameras) {
  return storageText(cameras, {}, cv::FileStorage::FORMAT_XML);
}

}  // namespace simgap
