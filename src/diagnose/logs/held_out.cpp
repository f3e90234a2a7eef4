#include "held_out.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

using Eigen::ArrayXd;
using Eigen::Index;

LogSplit splitLog(const PreparedLog& log, const LogDiagnosisOptions& options) {
  LogSplit split;
  const auto every = static_cast<std::size_t>(std::max(2.0, std::round(1.0 / std::max(options.holdout, 0.02))));
  for (std::size_t b = 0; b < log.blocks.size(); ++b) {
    bool out = b % every == every / 2;
    if (!options.heldout_rows.empty()) out = options.heldout_rows[log.blocks[b].begin];
    (out ? split.heldout : split.training).push_back(log.blocks[b]);
  }
  if (split.training.size() < 5 || split.heldout.empty()) {
    throw DataError(
        fmt::format("{}: found {} blocks to learn from and {} to hold out, expected at least 5 and 1: record "
                    "longer, or hold out less",
                    log.file, split.training.size(), split.heldout.size()));
  }
  return split;
}

namespace {

/// Held-out blocks that are predicted together.
struct Fold {
  std::vector<Block> blocks;
  std::vector<Block> others;  ///< what a refit for them may see; empty: no refit, the fit itself predicts them
};

std::vector<Fold> foldsOf(const std::vector<Block>& heldout, const std::vector<Block>& training,
                          const std::vector<int>& session) {
  constexpr std::size_t kFewestSessions = 8;
  std::vector<Fold> sessions, single;
  for (const Block& block : heldout) {
    single.push_back({{block}, {}});
    const int own = session[block.begin];
    if (sessions.empty() || session[sessions.back().blocks.back().begin] != own) {
      Fold& fold = sessions.emplace_back(Fold{{}, training});
      std::erase_if(fold.others, [&](const Block& b) { return session[b.begin] == own; });
    }
    sessions.back().blocks.push_back(block);
  }
  return sessions.size() < kFewestSessions ? single : sessions;
}

/// Errors of a model that has seen nothing of the fold.
Eigen::VectorXd errorsIn(const LogSearch& search, const Fitted& fitted, const Fold& fold) {
  return residualOf(fold.others.empty() ? fitted : search.refitted(fitted, fold.others));
}

}  // namespace

std::vector<GroupErrors> heldOutErrors(const LogSearch& search, const std::vector<Fitted>& models,
                                       const std::vector<Block>& heldout, const std::vector<int>& session) {
  const std::vector<Fold> folds = foldsOf(heldout, search.training(), session);
  const auto count = static_cast<Index>(folds.size());
  std::vector<GroupErrors> errors(models.size(), {ArrayXd(count), ArrayXd(count)});
  tbb::parallel_for(Index{0}, count, [&](Index u) {
    const Fold& fold = folds[static_cast<std::size_t>(u)];
    std::vector<Eigen::VectorXd> residuals;
    ArrayXd shared = ArrayXd::Ones(search.data().rows.rows());  // a delay counts other rows
    for (const Fitted& model : models) {
      residuals.push_back(errorsIn(search, model, fold));
      shared *= (residuals.back().array() != 0.0).cast<double>();
    }
    for (std::size_t m = 0; m < models.size(); ++m) {
      const GroupErrors own =
          search.errors((residuals[m].array() * shared).matrix(), fold.blocks, LogSearch::kPieceSeconds);
      errors[m].sum[u] = own.sum.sum();
      errors[m].rows[u] = own.rows.sum();
    }
  });
  return errors;
}

}  // namespace simgap
