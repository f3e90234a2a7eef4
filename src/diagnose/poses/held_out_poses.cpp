#include "held_out_poses.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/fit/poses/pose_posterior.h"

namespace simgap {

std::vector<bool> chooseHeldout(std::size_t poses, double holdout) {
  std::vector<bool> heldout;
  double owed = 0.0;
  for (std::size_t p = 0; p < poses; ++p) {
    owed += holdout;
    heldout.push_back(owed >= 1.0 - 1e-12);
    if (heldout.back()) owed -= 1.0;
  }
  return heldout;
}

Split splitPoses(const PoseSet& set, const std::vector<bool>& heldout, const std::vector<bool>& faulty) {
  Split split;
  for (std::size_t p = 0; p < set.poses.size(); ++p) {
    if (faulty[p]) continue;
    split.all.push_back(set.poses[p]);
    (heldout[p] ? split.heldout : split.selection).push_back(set.poses[p]);
  }
  return split;
}

void requireEnough(const PoseSet& set, const PoseDiagnosisOptions& options) {
  constexpr auto kFewest = static_cast<std::ptrdiff_t>(kFewestPoses);
  const auto selecting = [&](std::size_t poses) {
    return std::ranges::count(chooseHeldout(poses, options.holdout), false);
  };
  const std::size_t different = countDifferent(set.poses);
  if (selecting(different) >= kFewest) return;
  std::size_t fewest = kFewestPoses;
  while (selecting(fewest) < kFewest) ++fewest;
  throw DataError(
      fmt::format("{}: found {} {}poses, expected at least {}: {} to select causes with, and {:.0f} % that only "
                  "measure the gain",
                  set.file, different, different < set.poses.size() ? "different " : "", fewest, kFewestPoses,
                  100.0 * options.holdout));
}

}  // namespace simgap
