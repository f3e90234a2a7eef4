#include "simgap/core/blocks.h"

#include <algorithm>

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

std::vector<int> foldsOfBlocks(std::span<const Block> blocks, int folds, std::size_t rows) {
  std::vector<int> result(rows, 0);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    std::fill(result.begin() + static_cast<std::ptrdiff_t>(blocks[b].begin),
              result.begin() + static_cast<std::ptrdiff_t>(blocks[b].end),
              static_cast<int>(b % static_cast<std::size_t>(folds)));
  }
  return result;
}

}  // namespace simgap
