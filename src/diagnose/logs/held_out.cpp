#include "held_out.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::size_t everyNth(const LogDiagnosisOptions& options) {
  return static_cast<std::size_t>(std::max(2.0, std::round(1.0 / std::max(options.holdout, 0.02))));
}

/// Those that have rows which count.
std::vector<Block> movingBlocks(const std::vector<Block>& blocks, const PreparedLog& log) {
  std::vector<Block> moving;
  std::ranges::copy_if(blocks, std::back_inserter(moving),
                       [&](const Block& b) { return rowsIn({b}, log.data.keep) > 0.0; });
  return moving;
}

/// To learn from, and to judge by: a drive that stands tells nothing, and has no error on rows that were held out.
bool isEnough(const LogSplit& split, const PreparedLog& log) {
  constexpr std::size_t kFewestBlocks = 5;
  return movingBlocks(split.training, log).size() >= kFewestBlocks && !movingBlocks(split.heldout, log).empty();
}

/// Every n-th block is held out; of those that move alone where all others would be too few.
LogSplit splitAt(const PreparedLog& log, std::size_t every, std::size_t at) {
  const auto splitOf = [&](const std::vector<Block>& blocks) {
    LogSplit split;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      (b % every == at ? split.heldout : split.training).push_back(blocks[b]);
    }
    return split;
  };
  LogSplit split = splitOf(log.blocks);
  return isEnough(split, log) ? split : splitOf(movingBlocks(log.blocks, log));
}

}  // namespace

LogSplit splitLog(const PreparedLog& log, const LogDiagnosisOptions& options) {
  LogSplit split;
  if (options.heldout_rows.empty()) {
    split = splitAt(log, everyNth(options), everyNth(options) / 2);
  } else {
    for (const Block& block : log.blocks) {
      (options.heldout_rows[block.begin] ? split.heldout : split.training).push_back(block);
    }
  }
  if (!isEnough(split, log)) {
    throw DataError(
        fmt::format("{}: found {} blocks to learn from and {} to hold out, of {} rows each, expected at least 5 and 1: "
                    "record {} times as long, or hold out less",
                    log.file, split.training.size(), split.heldout.size(), log.blocks.front().size(),
                    std::max<std::size_t>(2, 6 / std::max<std::size_t>(1, log.blocks.size()) + 1)));
  }
  return split;
}

std::vector<LogSplit> otherSplits(const PreparedLog& log, const LogDiagnosisOptions& options) {
  constexpr std::size_t kMost = 3, kEnoughBlocks = 50;
  std::vector<LogSplit> splits;
  const std::size_t every = everyNth(options);
  if (!options.heldout_rows.empty() || log.blocks.size() / every >= kEnoughBlocks) return splits;
  for (std::size_t k = 1; k < every && splits.size() < kMost; ++k) {
    LogSplit split = splitAt(log, every, (every / 2 + k) % every);
    if (isEnough(split, log)) splits.push_back(std::move(split));
  }
  return splits;
}

namespace {

/// Held-out blocks that are predicted together.
struct Fold {
  std::vector<Block> blocks;
  int session;
};

bool isBySession(const std::vector<int>& session) {
  constexpr int kFewestSessions = 8;
  int count = 1;
  for (std::size_t i = 1; i < session.size(); ++i) count += session[i] != session[i - 1] ? 1 : 0;
  return count >= kFewestSessions;
}

std::vector<Fold> foldsOf(const std::vector<Block>& heldout, const std::vector<int>& session) {
  const bool by_session = isBySession(session);
  std::vector<Fold> folds;
  for (const Block& block : heldout) {
    const int own = session[block.begin];
    if (!by_session || folds.empty() || folds.back().session != own) folds.push_back({{}, own});
    folds.back().blocks.push_back(block);
  }
  return folds;
}

/// Errors of a model that has seen nothing of the session.
VectorXd residualWithout(const LogSearch& search, const Fitted& fitted, const RowEvaluation& at,
                         const std::vector<int>& session, int own) {
  std::vector<Block> others = search.training();
  std::erase_if(others, [&](const Block& b) { return session[b.begin] == own; });
  return others.empty() ? at.residual : search.refittedResidual(fitted, others, at);
}

}  // namespace

std::vector<VectorXd> heldOutResiduals(const LogSearch& search, const std::vector<Fitted>& models,
                                       const std::vector<Block>& heldout, const std::vector<int>& session) {
  const bool by_session = isBySession(session);
  const std::vector<Fold> folds = foldsOf(heldout, session);
  const Index rows = search.data().rows.rows();
  std::vector<VectorXd> unseen(models.size(), VectorXd::Zero(rows));
  tbb::parallel_for(std::size_t{0}, models.size(), [&](std::size_t m) {
    const Fitted& fitted = models[m];
    const RowEvaluation at = by_session ? RowEvaluation(*fitted.model, fitted.theta) : RowEvaluation();
    const VectorXd fit = by_session ? VectorXd() : residualOf(fitted);
    for (const Fold& fold : folds) {
      const VectorXd own = by_session ? residualWithout(search, fitted, at, session, fold.session) : VectorXd();
      const VectorXd& residual = by_session ? own : fit;
      for (const Block& b : fold.blocks) {
        const auto begin = static_cast<Index>(b.begin), size = static_cast<Index>(b.size());
        unseen[m].segment(begin, size) = residual.segment(begin, size);
      }
    }
  });
  ArrayXd shared = ArrayXd::Ones(rows);  // a delay counts other rows
  for (const VectorXd& residual : unseen) shared *= (residual.array() != 0.0).cast<double>();
  for (VectorXd& residual : unseen) residual.array() *= shared;
  return unseen;
}

GroupErrors heldOutErrors(const LogSearch& search, const VectorXd& residual, const std::vector<Block>& heldout,
                          const std::vector<int>& session) {
  const std::vector<Fold> folds = foldsOf(heldout, session);
  const auto count = static_cast<Index>(folds.size());
  GroupErrors errors{ArrayXd(count), ArrayXd(count)};
  for (Index u = 0; u < count; ++u) {
    const GroupErrors own = search.errors(residual, folds[u].blocks, LogSearch::kPieceSeconds);
    errors.sum[u] = own.sum.sum();
    errors.rows[u] = own.rows.sum();
  }
  return errors;
}

}  // namespace simgap
