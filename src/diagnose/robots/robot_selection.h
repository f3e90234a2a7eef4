/// \file
/// Which causes of a robot are accepted: forward, each step judged on blocks that a fit has not seen, then every cause
/// against its rivals once more, and without those that later ones make superfluous.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "robot_search.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"

namespace simgap {

/// One hypothesis beside the causes that are accepted.
struct RobotTrial {
  std::size_t hypothesis = 0;
  std::optional<Interval> gain;  ///< of the joints that it acts on, on unseen folds; none: not worth measuring
  double p = 1.0, p_adjusted = 1.0;
  double saved = 0.0;  ///< weighed squares of all joints on unseen folds
  BlockErrors validation;
};

struct RobotSelection {
  RobotSearch::Set set;
  std::vector<double> p_adjusted;                        ///< shape (causes)
  std::vector<std::vector<std::string>> ambiguous_with;  ///< shape (causes)
  std::vector<HypothesisRecord> records;
};

class RobotSelector {
 public:
  RobotSelector(RobotSearch& search, const RobotDiagnosisOptions& options);

  RobotSelection run(const DiagnosisProgress& progress);
  /// More causes beside those that there are, until none helps.
  void grow(RobotSelection& selection, const DiagnosisProgress& progress);
  /// Takes a cause out that is no finding, and sets the others against their rivals again.
  void drop(std::size_t cause, RobotSelection& selection);

 private:
  std::vector<RobotTrial> step(const RobotSearch::Set& set) const;
  /// A set with what its errors are on unseen folds, and what it costs.
  struct Start {
    RobotSearch::Set set;
    BlockErrors errors;
    double cost = 0.0;
  };
  Start startOf(RobotSearch::Set set) const;
  /// \param start  with what stands beside the hypothesis. \param before  errors of the set without that
  RobotTrial tryOne(const Start& start, const BlockErrors& before, std::size_t h) const;
  /// Whether either makes most of the other needless: others explain something else, however little they differ.
  bool overlap(const RobotSearch::Set& set, const RobotTrial& a, const RobotTrial& b) const;
  bool acceptable(const RobotTrial& trial) const;
  std::optional<std::size_t> best(const RobotSearch::Set& set, const std::vector<RobotTrial>& trials) const;
  bool ties(const RobotTrial& trial, const RobotTrial& winner) const;
  bool encompasses(const RobotSearch::Set& set, const RobotTrial& winner, const RobotTrial& rival) const;
  std::vector<std::string> rivals(const RobotSearch::Set& set, const std::vector<RobotTrial>& trials,
                                  std::size_t winner) const;
  void record(const std::vector<RobotTrial>& trials, std::optional<std::size_t> accepted, RobotSelection& selection);
  static void remove(std::size_t cause, RobotSelection& selection);
  void prune(RobotSelection& selection);
  void review(RobotSelection& selection);

  RobotSearch& search_;
  const RobotDiagnosisOptions& options_;
  std::vector<std::size_t> everywhere_;  ///< all joints
  std::vector<bool> refused_;            ///< shape (hypotheses)
  std::size_t step_ = 0;
};

/// p of the largest of the last hypothesis' numbers against its deviation, times the places it was looked for at.
double waldP(const RobotSearch& search, const RobotSearch::Set& set);

}  // namespace simgap
