#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/exchange/exchange.h"

namespace simgap {
namespace {

constexpr std::array<std::string_view, 5> kXmlEndings = {".xml", ".mjcf", ".urdf", ".sdf", ".xacro"};

constexpr std::size_t kTextBeginning = 1000;  ///< [bytes] where what is no text shows it, as a binary STL

/// The name of the first element; empty without one.
std::string rootElement(const std::string& text) {
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text.compare(at, 4, "<!--") == 0) {
      at = text.find("-->", at);
      if (at == std::string::npos) return {};
      continue;
    }
    if (at + 1 < text.size() && (text[at + 1] == '?' || text[at + 1] == '!')) continue;
    return text.substr(at + 1, std::min(text.find_first_of(" \t\r\n/>", at), at + 100) - at - 1);
  }
  return {};
}

bool isLfsPointer(std::string_view text) { return text.starts_with("version https://git-lfs.github.com/spec/"); }

/// What stands in a file that has the name of one but not its text; empty: nothing is wrong with it.
std::string_view notXml(std::string_view text) {
  if (isLfsPointer(text)) return "a pointer of Git LFS (`git lfs pull` fetches the file itself)";
  const std::string_view first_letters = text.substr(0, 2);
  const bool wide = first_letters == std::string_view("<\0", 2) || first_letters == std::string_view("\0<", 2);
  if (wide || text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return "UTF-16 text";
  if (text.substr(0, kTextBeginning).find('\0') != std::string_view::npos) return "no text";
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string_view::npos) return "an empty file";
  return text[first] == '<' ? "" : "no XML";
}

}  // namespace

RobotFormat robotFormatOf(const std::string& text, const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  if (const std::string_view found = notXml(text); !found.empty()) {
    const std::string ending = file.extension().string();
    const bool named_so = std::ranges::find(kXmlEndings, ending) != kXmlEndings.end();
    if (!named_so && !isLfsPointer(text)) return RobotFormat::kArm;
    throw DataError(fmt::format("{}: found {}, expected a robot in XML (MJCF, URDF, SDF)", name, found));
  }
  const std::string root = rootElement(text);
  if (root == "mujoco" || root == "mujocoinclude") return RobotFormat::kMjcf;
  if (root == "robot") return RobotFormat::kUrdf;
  if (root == "sdf") return RobotFormat::kSdf;
  throw DataError(
      fmt::format("{}: found <{}> as its outermost element, expected <mujoco> (MJCF), <robot> (URDF) or <sdf>", name,
                  abridged(root)));
}

RobotFormat robotFormatOf(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".yaml" || extension == ".yml") return RobotFormat::kArm;
  if (extension == ".xml" || extension == ".mjcf") return RobotFormat::kMjcf;
  if (extension == ".urdf") return RobotFormat::kUrdf;
  throw ConfigError(fmt::format("{}: found the ending '{}', expected .yaml (arm), .xml (MJCF) or .urdf", file.string(),
                                abridged(extension)));
}

std::string_view nameOf(RobotFormat format) {
  switch (format) {
    case RobotFormat::kArm:
      return "arm";
    case RobotFormat::kMjcf:
      return "MJCF";
    case RobotFormat::kSdf:
      return "SDF";
    case RobotFormat::kUrdf:
      break;
  }
  return "URDF";
}

}  // namespace simgap
