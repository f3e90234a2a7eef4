#include "simgap/core/blocks.h"

namespace simgap {

std::vector<Block> splitBlocks(std::span<const double> time, std::span<const int> session, double length) {
  std::vector<Block> blocks;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= time.size(); ++i) {
    const bool ends = i == time.size() || session[i] != session[begin] || time[i] - time[begin] >= length ||
                      time[i] - time[i - 1] > length;
    if (!ends) continue;
    blocks.push_back({begin, i});
    begin = i;
  }
  return blocks;
}

std::vector<Block> splitRows(std::span<const int> session, std::size_t rows_per_block) {
  std::vector<Block> blocks;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= session.size(); ++i) {
    const bool ends = i == session.size() || session[i] != session[begin] || i - begin >= rows_per_block;
    if (!ends) continue;
    blocks.push_back({begin, i});
    begin = i;
  }
  return blocks;
}

}  // namespace simgap
