#include "image_names.h"

#include <fmt/format.h>
#include <string.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>

#include "simgap/core/error.h"

namespace simgap {
namespace {

const std::set<std::string> kImageEndings = {".png", ".jpg", ".jpeg", ".pgm", ".tif", ".tiff", ".bmp"};

/// Calls use(name) for every image, in the order of the file system, until that returns false.
template <class Use>
void forImages(const std::filesystem::path& folder, const Use& use) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
    if (!entry.is_regular_file() || !kImageEndings.contains(ending)) continue;
    if (!use(entry.path().filename().string())) return;
  }
}

}  // namespace

ImageNames::ImageNames(const std::filesystem::path& folder) {
  if (!count(folder)) {
    forImages(folder, [&](std::string name) {
      list_.push_back(std::move(name));
      return true;
    });
    list_.shrink_to_fit();
    std::ranges::sort(list_, [](const auto& a, const auto& b) { return strverscmp(a.c_str(), b.c_str()) < 0; });
    size_ = list_.size();
  }
  if (size_ == 0) {
    throw DataError(fmt::format("{}: found no image, expected files that end in {}", folder.string(),
                                fmt::join(kImageEndings, ", ")));
  }
}

std::string ImageNames::at(std::size_t i) const {
  return listed() ? list_[i] : fmt::format("{}{:0{}}{}", before_, first_ + i, digits_, behind_);
}

std::optional<ImageNames::Parts> ImageNames::partsOf(const std::string& name) {
  constexpr std::size_t kMostDigits = 15;
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t end = name.rfind('.');
  while (end > 0 && !isDigit(name[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && isDigit(name[begin - 1])) --begin;
  if (begin == end || end - begin > kMostDigits) return std::nullopt;
  return Parts{name.substr(0, begin), name.substr(begin, end - begin), name.substr(end)};
}

/// Whether all names are one text around numbers without a gap, all written in one way.
bool ImageNames::count(const std::filesystem::path& folder) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  unsigned long long last = 0;
  std::size_t fewest = kNone, filled = kNone;  // digits of any number, of one with a zero in front
  bool alike = true;
  forImages(folder, [&](const std::string& name) {
    const std::optional<Parts> parts = partsOf(name);
    if (!parts) return alike = false;
    const unsigned long long number = std::stoull(parts->digits);
    if (size_++ == 0) {
      before_ = parts->before;
      behind_ = parts->behind;
      first_ = last = number;
    }
    first_ = std::min(first_, number);
    last = std::max(last, number);
    fewest = std::min(fewest, parts->digits.size());
    const bool zero_in_front = parts->digits.size() > 1 && parts->digits.front() == '0';
    alike = parts->before == before_ && parts->behind == behind_ &&
            (!zero_in_front || filled == kNone || filled == parts->digits.size());
    if (zero_in_front) filled = parts->digits.size();
    return alike;
  });
  if (size_ == 0) return alike;
  digits_ = filled == kNone ? 1 : filled;
  return alike && (filled == kNone || fewest == filled) && last - first_ + 1 == size_;
}

}  // namespace simgap
