/// \file
/// Every block of a log measures what a cause gains, each by a model that was chosen without it: the choice is made
/// again without other blocks, and what it does not choose there gains nothing there (cross-fitting: Chernozhukov et
/// al. 2018).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "held_out.h"

namespace simgap {

/// Blocks that are held out, and the models of the named causes without them.
struct HeldOutPart {
  const LogSearch* search = nullptr;  ///< on the other blocks
  std::vector<Block> heldout;
  Fitted baseline;
  Fitted chosen;                ///< with those of the named causes that were chosen here
  std::vector<Fitted> steps;    ///< shape (causes + 1), as Selection::steps
  std::vector<Fitted> without;  ///< shape (causes); `chosen` for a cause that was not chosen here
};

class HeldOutParts {
 public:
  static constexpr double kMainShare = 0.25;  ///< of the time that all choices take, there are four at most

  /// The blocks of the main selection alone. \param search  its own, outlives this; \param own  effects of the baseline
  HeldOutParts(const LogSearch& search, std::vector<Block> heldout, std::size_t own);

  /// Chooses again without other blocks, from the hypotheses that explained something in the main selection. The log
  /// and the options must outlive it.
  void addOthers(const PreparedLog& log, const ActuatorModel& subject, const std::vector<Hypothesis>& named,
                 const std::vector<HypothesisRecord>& records, const LogDiagnosisOptions& options,
                 const DiagnosisProgress& progress);

  /// Fits the main selection's causes in every part.
  void take(const Selection& main);
  const std::vector<HeldOutPart>& parts() const { return parts_; }
  /// All that are held out, in the order of time.
  const std::vector<Block>& blocks() const { return blocks_; }

  /// Errors on all held-out blocks, shape (models) of shape (rows), as heldOutResiduals. \param models_of  of each part
  /// as many, on several threads
  std::vector<Eigen::VectorXd> residuals(const std::function<std::vector<Fitted>(const HeldOutPart&)>& models_of) const;

 private:
  /// What is left of a selection, without its trials.
  struct Choice {
    std::unique_ptr<LogSearch> search;
    std::vector<Block> heldout;
    Fitted baseline, chosen;
    std::vector<std::vector<std::string>> ambiguous_with;
  };
  std::optional<std::size_t> sameCause(const Choice& here, const Selection& main, std::size_t cause,
                                       const std::vector<std::size_t>& taken) const;
  HeldOutPart partOf(const Choice& here, const Selection& main) const;

  const LogSearch& search_;
  std::vector<Block> heldout_;
  std::size_t own_;
  std::vector<Choice> others_;
  std::vector<HeldOutPart> parts_;
  std::vector<Block> blocks_;
};

}  // namespace simgap
