/// \file
/// How many rollouts a diagnosis is expected to play still: what a bar and the time left go by.
#pragma once

#include <array>
#include <cstddef>

namespace simgap {

class MotionPlan {
 public:
  /// In the order in which they come; a further cause goes back to its scan.
  enum Stage : std::size_t { kPlain, kScan, kFits, kDerivatives, kFurther, kStages };

  /// \param parameters  of a fit  \param motions  that select  \param single, other  hypotheses of single muscles,
  /// which are tried on some motions first, and all others
  MotionPlan(std::size_t parameters, std::size_t motions, std::size_t single, std::size_t other);

  /// A stage begins after so many rollouts; those before it will not come again.
  void begin(Stage stage, long rollouts);
  /// \returns the part that is done, which never falls
  double done(long rollouts);
  double usual(Stage stage) const { return usual_[stage]; }

 private:
  std::array<double, kStages> usual_{};  ///< rollouts
  Stage stage_ = kPlain;
  long began_ = 0;
  double shown_ = 0.0;
};

}  // namespace simgap
