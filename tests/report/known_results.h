/// \file
/// Results whose every number is known.
#pragma once

#include <cmath>
#include <limits>

#include "simgap/report/poses/pose_report.h"

namespace simgap::test {

/// A shoulder (spherical) and an elbow (revolute), one muscle.
inline PoseLayout knownLayout() {
  return {{"biceps"}, {}, {{"shoulder", JointType::kSpherical}, {"elbow", JointType::kRevolute}}};
}

/// `count` poses that all miss by the same angles [deg]; NaN: they are invalid.
inline Assessment knownAssessment(std::size_t count, double shoulder_deg, double elbow_deg) {
  PoseOutcome outcome;
  const bool valid = !std::isnan(shoulder_deg);
  outcome.status = valid ? PoseStatus::kSteady : PoseStatus::kAcquisitionError;
  outcome.worst = 0;
  outcome.worst_value = 12.34 * kDegree;
  const double shoulder = shoulder_deg * kDegree, elbow = elbow_deg * kDegree;
  Assessment judged;
  judged.outcomes.assign(count, outcome);
  judged.errors.assign(count, valid ? std::vector<double>{shoulder, elbow} : std::vector<double>{});
  judged.mje = {shoulder, elbow};
  judged.valid = valid ? count : 0;
  judged.fitness = static_cast<double>(count) * (shoulder * shoulder + elbow * elbow);
  return judged;
}

inline PoseSet knownPoses(const std::vector<std::string>& names) {
  PoseSet set{"poses.csv", {}};
  for (const std::string& name : names) set.poses.push_back({name, {0.0}, std::vector<JointPosition>(2), 1, {0, 0}});
  return set;
}

/// Two generations; 20 and 10 deg become 2 and 1 deg; the one validation pose was invalid before.
inline CalibrationResult knownCalibration() {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  CalibrationResult result;
  result.layout = knownLayout();
  result.sets = {{"calibration", knownPoses({"low", "a,\"b\""}), knownAssessment(2, 20, 10), knownAssessment(2, 2, 1)},
                 {"validation", knownPoses({"<far>"}), knownAssessment(1, unknown, unknown), knownAssessment(1, 3, 4)}};
  result.parameters = {{{"muscles.biceps.stiffness", "N_m", 1, 1e4}, 900, 25, {}},
                       {{"joints.elbow.friction", "Nm"}, 0.1, 0.1, {}}};
  result.config.optimizer = "es";
  result.config.strategy.mu = 2;
  result.config.strategy.lambda = 8;
  result.config.strategy.generations = 2;
  result.state.strategy.generation = 2;
  result.state.strategy.stop = StopReason::kMaxGenerations;
  result.state.strategy.best = {{1.0, 0.3}, {1.0, 1.0}, 0.25};
  result.state.invalid = 5;
  result.state.evaluations = 32;
  result.state.wall = 1.5;
  result.state.history = {{1, 0.5, 0.75, 0.5, 0.1, 1.0, 2.0, 3, {4 * kDegree, 3 * kDegree}},
                          {2, 0.25, 0.5, 0.25, 0.1, 0.5, 1.0, 2, {2 * kDegree, kDegree}}};
  return result;
}

/// Two valid poses and an invalid one; one criterion holds, one cannot be judged.
inline ValidationResult knownValidation() {
  ValidationResult result;
  result.layout = knownLayout();
  result.set = knownPoses({"low", "a,\"b\"", "<far>"});
  result.assessment = knownAssessment(2, 20, 10);
  const Assessment invalid = knownAssessment(1, std::numeric_limits<double>::quiet_NaN(), 0);
  result.assessment.outcomes.push_back(invalid.outcomes[0]);
  result.assessment.errors.push_back({});
  result.assessment.fitness = std::numeric_limits<double>::quiet_NaN();
  result.criteria = {{"mje_deg of shoulder", 20.5, 20.0}, {"mje_deg of elbow", 5, std::nan("")}};
  return result;
}

}  // namespace simgap::test
