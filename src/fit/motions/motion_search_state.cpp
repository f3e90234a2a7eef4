// A search's state as it is stored, number for number.
#include <fmt/format.h>

#include "simgap/core/error.h"
#include "simgap/core/json_numbers.h"
#include "simgap/fit/motions/motion_search.h"

namespace simgap {
namespace {

Json numbers(const Eigen::VectorXd& x) { return std::vector<double>(x.begin(), x.end()); }
Eigen::VectorXd vectorOf(const Json& json) {
  const auto values = json.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

}  // namespace

Json toJson(const MotionSearchState& state) {
  Json history = Json::array();
  for (const MotionRound& r : state.history) {
    history.push_back({{"round", r.round},
                       {"before", r.before},
                       {"after", r.after},
                       {"steps", r.steps},
                       {"rollouts", r.rollouts},
                       {"expected", r.expected},
                       {"horizon", r.horizon}});
  }
  return {{"format", "simgap/motion-search-state/1"},
          {"z", numbers(state.z)},
          {"steps", numbers(state.steps)},
          {"damping", state.damping},
          {"history", history},
          {"converged", state.converged},
          {"wall_s", state.wall}};
}

MotionSearchState motionSearchStateFromJson(const Json& json, Eigen::Index parameters) try {
  MotionSearchState state;
  state.z = vectorOf(json.at("z"));
  state.steps = vectorOf(json.at("steps"));
  json.at("damping").get_to(state.damping);
  json.at("converged").get_to(state.converged);
  json.at("wall_s").get_to(state.wall);
  for (const Json& r : json.at("history")) {
    state.history.push_back({static_cast<int>(wholeNumber(r.at("round"))), r.at("before").get<double>(),
                             r.at("after").get<double>(), static_cast<int>(wholeNumber(r.at("steps"))),
                             wholeNumber(r.at("rollouts")), r.at("expected").get<double>(),
                             r.at("horizon").get<double>()});
  }
  if (state.z.size() != parameters || state.steps.size() != parameters) {
    throw ConfigError(fmt::format("the stored state is not one of {} parameters", parameters));
  }
  return state;
} catch (const Json::exception& error) {
  throw ConfigError(std::string("the stored state is not a simgap/motion-search-state/1: ") + error.what());
}

}  // namespace simgap
