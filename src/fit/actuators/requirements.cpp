#include "simgap/fit/actuators/requirements.h"

#include <fmt/format.h>

#include "simgap/core/error.h"
#include "simgap/core/rotation.h"
#include "simgap/core/units.h"

namespace simgap {

std::vector<Requirement> paperRequirements() {
  return {{"shoulder flexion/extension", 71.0 * kDegree, 20.0}, {"elbow flexion/extension", 91.0 * kDegree, 20.0}};
}

std::vector<Requirement> readRequirements(const std::vector<std::string>& texts) {
  std::vector<Requirement> all;
  for (const std::string& text : texts) {
    if (text == "paper") {
      for (const Requirement& r : paperRequirements()) all.push_back(r);
      continue;
    }
    const std::size_t first = text.find(':'), last = text.rfind(':');
    const auto velocity = first < last ? parseNumber(text.substr(first + 1, last - first - 1)) : std::nullopt;
    const auto torque = first < last ? parseNumber(text.substr(last + 1)) : std::nullopt;
    if (!velocity || !torque) {
      throw ConfigError(fmt::format("--require: found '{}', expected NAME:DEG_PER_S:NM, or paper", text));
    }
    all.push_back({text.substr(0, first), unitConversion("deg_s", "rad_s")->operator()(*velocity), *torque});
  }
  return all;
}

WorkingPoint furthestPoint(const Eigen::ArrayXd& velocity, const Eigen::ArrayXd& load, double ratio) {
  return {velocity.abs().maxCoeff() / ratio, load.abs().maxCoeff()};
}

}  // namespace simgap
