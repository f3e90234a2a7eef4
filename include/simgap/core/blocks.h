/// \file
/// Splits of a log into blocks of some seconds and of blocks into folds. The rows of a log are correlated: a split by
/// single rows would let a fit see its own test data.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace simgap {

/// Rows [begin, end) of one session, in order of time.
struct Block {
  std::size_t begin;
  std::size_t end;
  std::size_t size() const { return end - begin; }
};

/// Blocks of about `length` seconds that cover all rows; none reaches over a session's end or over a jump in time of
/// more than `length`. \param time, session  shape (rows).
std::vector<Block> splitBlocks(std::span<const double> time, std::span<const int> session, double length);

/// Splits blocks again so that none has more rows; for uncertainties, where a block is some correlation times.
std::vector<Block> splitRows(std::span<const int> session, std::size_t rows_per_block);

}  // namespace simgap
