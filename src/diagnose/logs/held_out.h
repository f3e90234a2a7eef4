/// \file
/// The part of a log that measures the gain and decides nothing.
#pragma once

#include <vector>

#include "log_selection.h"

namespace simgap {

struct LogSplit {
  std::vector<Block> training, heldout;
};

/// \throws DataError: too few blocks to learn from, or none to hold out.
LogSplit splitLog(const PreparedLog& log, const LogDiagnosisOptions& options);

/// The same with other blocks held out, until all blocks or four times as many were: none where the caller says which
/// rows are held out, where there are too few blocks, and in long logs, of which fifty blocks that are held out say
/// enough.
std::vector<LogSplit> otherSplits(const PreparedLog& log, const LogDiagnosisOptions& options);

/// Errors of models on the held-out blocks, shape (rows) each; 0 elsewhere and where one of the models does not count a
/// row. In a log of eight sessions and more those of a session are of a refit that has seen none of it: what shares a
/// motion shares its errors, and parameters hide a part of them there. Else they are of the fit itself. \param session
/// shape (rows)
std::vector<Eigen::VectorXd> heldOutResiduals(const LogSearch& search, const std::vector<Fitted>& models,
                                              const std::vector<Block>& heldout, const std::vector<int>& session);

/// Their squares, those of a session together where the log has eight and more, else those of a block.
GroupErrors heldOutErrors(const LogSearch& search, const Eigen::VectorXd& residual, const std::vector<Block>& heldout,
                          const std::vector<int>& session);

}  // namespace simgap
