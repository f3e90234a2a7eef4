/// \file
/// MJCF by hand for the tests of its reader.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"

namespace simgap::test {

inline const FileReader kNoFiles = [](const std::filesystem::path& file) -> std::string {
  throw DataError(file.string() + " was asked for");
};

inline ImportedArm readText(const std::string& text) { return readMjcf(text, "robot.xml", kNoFiles); }

/// A robot of one body on a hinge, with `more` in its worldbody and behind it.
inline std::string robot(const std::string& head, const std::string& body, const std::string& tail = "") {
  return "<mujoco>\n" + head + "<worldbody>\n<body name='b'>\n" + body + "</body>\n</worldbody>\n" + tail +
         "</mujoco>\n";
}

inline constexpr const char* kBall = "<geom size='0.1' mass='2'/>\n";

inline std::string refusal(const std::string& text) {
  try {
    readText(text);
  } catch (const DataError& error) {
    return error.what();
  }
  return "nothing was refused";
}

inline bool hasRemark(const std::vector<ExchangeRemark>& remarks, const std::string& what, bool matters,
                      const std::string& place) {
  return std::ranges::any_of(remarks, [&](const ExchangeRemark& r) {
    return r.what == what && r.matters == matters && std::ranges::find(r.places, place) != r.places.end();
  });
}

}  // namespace simgap::test
