#include "simgap/intervene/motions/motion_separation.h"

#include <fmt/format.h>

#include <algorithm>

#include "played_motion.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

/// The same way in another time.
MotionCommands atSpeed(MotionCommands commands, double speed) {
  const double first = commands.times.front();
  for (double& time : commands.times) time = first + (time - first) / speed;
  return commands;
}

/// Log odds of every pair that contradicts the named model: both ways round, shape (rivals, 2) as one list.
std::vector<double> pairsOf(const ForeseenChange& foreseen, const std::vector<bool>& rival) {
  std::vector<double> pairs;
  for (std::size_t c = 1; c < rival.size(); ++c) {
    if (!rival[c]) continue;
    pairs.push_back(foreseen.log_odds[0][c]);
    pairs.push_back(foreseen.log_odds[c][0]);
  }
  return pairs;
}

double smallestWith(const std::vector<double>& before, const std::vector<double>& more) {
  double smallest = kInfinity;
  for (std::size_t i = 0; i < more.size(); ++i) smallest = std::min(smallest, before[i] + more[i]);
  return smallest;
}

void requireOneWithin(const std::vector<MotionProtocol>& protocols) {
  if (std::ranges::any_of(protocols, [](const MotionProtocol& p) { return p.beyond.empty(); })) return;
  throw ConfigError(fmt::format("every motion at every speed is beyond the limits ({} x {:g}: {}), expected one within",
                                protocols.front().motion.name, protocols.front().speed, protocols.front().beyond));
}

}  // namespace

MotionSeparation separateMotions(const MotionEvidence& evidence, const std::vector<double>& speeds, std::size_t most,
                                 const MotionLimits& limits, const InterventionProgress& progress) {
  const std::vector<bool> rival = evidence.rivals();
  if (std::ranges::none_of(rival, [](bool one) { return one; })) {
    throw ConfigError("no model of the diagnosis contradicts the named one: there is nothing to tell apart");
  }
  MotionSeparation result;
  std::vector<std::vector<double>> pairs;  // empty where a motion is beyond the limits
  std::size_t within = 0;
  const auto all = static_cast<double>(evidence.profile.size() * speeds.size());
  for (const PlannedMotion& recorded : evidence.profile) {
    for (const double speed : speeds) {
      const auto done = static_cast<double>(result.protocols.size());
      MotionProtocol& protocol =
          result.protocols.emplace_back(MotionProtocol{{recorded.name, atSpeed(recorded.commands, speed)}, speed});
      protocol.beyond = beyondLimits(evidence, protocol.motion, limits);
      pairs.emplace_back();
      if (!protocol.beyond.empty()) continue;
      protocol.foreseen =
          foreseeChange(evidence, {}, {protocol.motion}, [&](double part) { progress((done + part) / all); });
      pairs.back() = pairsOf(protocol.foreseen, rival);
      ++within;
    }
  }
  requireOneWithin(result.protocols);
  std::vector<double> told(2 * static_cast<std::size_t>(std::ranges::count(rival, true)), 0.0);
  while (result.smallest.size() < std::min(most, within)) {
    if (!result.smallest.empty() && result.smallest.back() > kDecisiveLogOdds) break;
    std::size_t best = pairs.size();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (result.protocols[k].chosen > 0 || !result.protocols[k].beyond.empty()) continue;
      if (best == pairs.size() || smallestWith(told, pairs[k]) > smallestWith(told, pairs[best])) best = k;
    }
    for (std::size_t i = 0; i < told.size(); ++i) told[i] += pairs[best][i];
    result.smallest.push_back(*std::ranges::min_element(told));
    result.protocols[best].chosen = static_cast<int>(result.smallest.size());
  }
  return result;
}

}  // namespace simgap
