/// \file
/// Logs of one rig, recorded one after another, as one log: an experiment and the one that it asked for.
#pragma once

#include <vector>

#include "simgap/measure/logs/log_table.h"

namespace simgap {

/// One log of the columns that all of them have. Each is a session named after its file ("2-after"), or several where
/// it has sessions of its own ("2-after-day3"). \param logs  at least one
/// \throws DataError: a channel of the first that another lacks.
LogTable joinedLogs(std::vector<LogTable> logs);

}  // namespace simgap
