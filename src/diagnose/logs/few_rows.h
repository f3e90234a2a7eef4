/// \file
/// Of a long log the few rows that are enough to search with: neighbours say the same.
#pragma once

#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

struct FewRows {
  std::vector<Eigen::Index> at;  ///< which they are, in their order
  ActuatorData data;
  std::vector<Block> blocks;  ///< all of them
};

/// \param blocks  of whose rows, where they count, it takes some, spread evenly, but not in step with any period; all
/// where they are not twice as many as `most`
FewRows fewRowsOf(const ActuatorData& data, const std::vector<Block>& blocks, std::size_t most);

}  // namespace simgap
