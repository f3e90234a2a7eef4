/// \file
/// Recorded poses replayed on a model, and what a user should know of the outcome.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm.h"
#include "simgap/simulate/evaluator.h"
#include "simgap/simulate/pose_error.h"

namespace simgap {

/// The poses of a table, for that model. \throws DataError as readPoseSet, when the model's extensions need times that
/// the table does not have, and for numbers in another unit or order than announced (pose_plausibility.h).
PoseSet readPosesFor(const ArmModel& model, const CsvTable& table);

/// \param name  "bullet" or "equilibrium"
std::unique_ptr<Evaluator> makeEvaluator(const std::string& name, const PoseProtocol& protocol);

/// Judges a model on all poses of a set. \param progress  called with the number of poses done.
/// \throws InterruptedError
Assessment replayAll(Evaluator& evaluator, const ArmModel& model, const PoseSet& set,
                     const std::function<void(std::size_t)>& progress = {},
                     PoseObjective objective = PoseObjective::kGeodesic);

/// A cord that was stretched beyond the range in which it is linear (000 eq. 2).
struct StretchedCord {
  std::size_t muscle;
  double expansion;  ///< (1) the largest, of its rest length
};
/// \param outcomes  those without cords count for nothing
std::vector<StretchedCord> cordsBeyondLinear(std::span<const PoseOutcome> outcomes, std::size_t muscles);

/// A sentence per muscle whose cord was stretched beyond the range in which it is linear (000 eq. 2).
std::vector<std::string> stretchedCords(std::span<const PoseOutcome> outcomes, const PoseLayout& layout);

/// A sentence on poses with other stable equilibria beside the one that the arm came to; empty when there are none.
std::string otherEquilibria(const ArmModel& model, const PoseSet& set, std::span<const PoseOutcome> outcomes);

/// "2 of 15 poses are invalid: p003: …", with the first few of them and what helps.
/// \param evaluator  that found it: "bullet" or "equilibrium"
std::string describeInvalid(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout,
                            const std::string& evaluator);

}  // namespace simgap
