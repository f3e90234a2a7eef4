#include "few_rows.h"

#include <cmath>

namespace simgap {
namespace {

using Eigen::Index;

std::vector<Index> evenly(const std::vector<Index>& all, std::size_t most) {
  constexpr double kGolden = 0.6180339887498949;  // its multiples are spread most evenly over [0, 1)
  if (all.size() < 2 * most) return all;
  std::vector<Index> some;
  const double part = static_cast<double>(all.size()) / static_cast<double>(most);
  for (std::size_t k = 0; k < most; ++k) {
    const double within = std::fmod(kGolden * static_cast<double>(k), 1.0);
    const auto at = static_cast<std::size_t>((static_cast<double>(k) + within) * part);
    some.push_back(all[at]);
  }
  return some;
}

}  // namespace

FewRows fewRowsOf(const ActuatorData& data, const std::vector<Block>& blocks, std::size_t most) {
  std::vector<Index> counted;
  for (const Block& b : blocks) {
    for (std::size_t i = b.begin; i < b.end; ++i) {
      if (data.keep[i]) counted.push_back(static_cast<Index>(i));
    }
  }
  std::vector<Index> some = evenly(counted, most);
  FewRows few{{}, data, {{0, some.size()}}};
  few.data.rows = data.rows.at(some);
  few.data.keep.assign(some.size(), true);
  few.data.effort_lost.clear();
  few.data.rig = data.rig(some, Eigen::all);
  if (data.angle) {
    few.data.angle->sine = data.angle->sine(some);
    few.data.angle->cosine = data.angle->cosine(some);
  }
  few.at = std::move(some);
  return few;
}

}  // namespace simgap
