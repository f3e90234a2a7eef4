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

/// Squared errors of models on the held-out blocks. With eight sessions and more, those of a session
/// together, by a refit that has seen none of it: what shares a motion shares its errors, and parameters hide a part of
/// them there. Else those of each block, by the fit itself. Over the rows that all of the models count.
/// \param session  shape (rows)
std::vector<GroupErrors> heldOutErrors(const LogSearch& search, const std::vector<Fitted>& models,
                                       const std::vector<Block>& heldout, const std::vector<int>& session);

}  // namespace simgap
