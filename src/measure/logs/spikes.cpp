#include "simgap/measure/logs/spikes.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "simgap/core/blocks.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

constexpr double kSpikeSizes = 12.0;  // of the usual distance from the line between the neighbours
constexpr std::size_t kNear = 12;     // rows on either side that say what is usual here
constexpr std::ptrdiff_t kSide = 4;   // rows on either side that a curve is drawn through
constexpr double kNextToIt = 0.3;     // what rows beside a wrong one may be off by, of its size
constexpr double kSmooth = 0.15;      // and rows of the sides: at a kink of the motion a cubic misses them by 0.3 of it

/// Distance of row i from the line between its neighbours.
double bendAt(std::span<const double> time, std::span<const double> values, std::size_t i) {
  const double part = (time[i] - time[i - 1]) / (time[i + 1] - time[i - 1]);
  return values[i] - (values[i - 1] + part * (values[i + 1] - values[i - 1]));
}

/// What bends are usual beside rows [begin, end): fast motion and jumps bend their surroundings, too.
double usualNear(const std::vector<double>& bend, const Block& rows) {
  std::vector<double> near;
  const std::size_t begin = rows.begin > kNear ? rows.begin - kNear : 1;
  for (std::size_t k = begin; k < std::min(bend.size() - 1, rows.end + kNear); ++k) {
    if (k + 1 < rows.begin || k > rows.end) near.push_back(std::abs(bend[k]));
  }
  return upperMedian(std::move(near));
}

/// Rows that bend where a wrong sample may be, those with less than kSide rows between them together.
std::vector<Block> suspects(const std::vector<double>& bend, double usual) {
  std::vector<Block> groups;
  for (std::size_t i = 2; i + 2 < bend.size(); ++i) {
    if (std::abs(bend[i]) <= kSpikeSizes * usual) continue;
    if (std::abs(bend[i]) <= kSpikeSizes * usualNear(bend, {i, i + 1})) continue;
    if (!groups.empty() && i < groups.back().end + kSide) {
      groups.back().end = i + 1;
    } else {
      groups.push_back({i, i + 1});
    }
  }
  return groups;
}

/// Values of a group less a cubic through the rows on both sides (a line where these are few), and by how much the
/// sides themselves miss it, at most.
struct AgainstSides {
  Eigen::VectorXd off;
  double sides = 0.0;
};
AgainstSides againstSides(std::span<const double> time, std::span<const double> values, const Block& group) {
  const auto first = std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(group.begin) - kSide);
  const auto last = std::min(std::ssize(values), static_cast<std::ptrdiff_t>(group.end) + kSide);
  const Eigen::Index rows = last - first, before = static_cast<std::ptrdiff_t>(group.begin) - first;
  const auto inside = static_cast<Eigen::Index>(group.size());
  const Eigen::Index powers = rows - inside < 2 * kSide ? 2 : 4;
  const double centre = 0.5 * (time[first] + time[last - 1]), scale = 0.5 * (time[last - 1] - time[first]);
  Eigen::MatrixXd basis(rows, powers);
  Eigen::VectorXd y(rows), weight = Eigen::VectorXd::Ones(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = (time[first + i] - centre) / scale;
    for (Eigen::Index p = 0; p < powers; ++p) basis(i, p) = std::pow(t, p);
    y[i] = values[first + i];
  }
  weight.segment(before, inside).setZero();
  const Eigen::VectorXd curve = (weight.asDiagonal() * basis).colPivHouseholderQr().solve(weight.cwiseProduct(y));
  y -= basis * curve;
  return {y.segment(before, inside), weight.cwiseProduct(y).cwiseAbs().maxCoeff()};
}

/// Wrong rows of a group and what stands there by its sides; empty where it is motion, or more than `most` are wrong.
std::vector<Spike> wrongRows(std::span<const double> time, std::span<const double> values, const Block& group,
                             double usual, std::size_t most) {
  const AgainstSides against = againstSides(time, values, group);
  const double largest = against.off.cwiseAbs().maxCoeff();
  std::vector<Spike> wrong;
  double smallest = largest, rest = 0.0;
  for (Eigen::Index i = 0; i < against.off.size(); ++i) {
    const double size = std::abs(against.off[i]);
    const std::size_t row = group.begin + static_cast<std::size_t>(i);
    if (size > kSpikeSizes * usual) {
      wrong.push_back({row, values[row] - against.off[i]});
      smallest = std::min(smallest, size);
    } else {
      rest = std::max(rest, size);
    }
  }
  const bool stand_out = rest < kNextToIt * smallest && against.sides < kSmooth * smallest;
  if (wrong.size() > most || !stand_out) wrong.clear();
  return wrong;
}

}  // namespace

std::vector<Spike> findSpikes(std::span<const double> time, std::span<const double> values, std::size_t most) {
  const std::size_t n = values.size();
  if (n < 2 * kNear) return {};
  std::vector<double> bend(n, 0.0), sizes;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    bend[i] = bendAt(time, values, i);
    sizes.push_back(std::abs(bend[i]));
  }
  const double usual = std::max(upperMedian(sizes), 0.5 * quantumOf(values));
  std::vector<Spike> spikes;
  for (const Block& group : suspects(bend, usual)) {
    if (group.size() > 2 * most + 1 + (most - 1) * kSide) continue;
    const std::vector<Spike> wrong = wrongRows(time, values, group, std::max(usual, usualNear(bend, group)), most);
    spikes.insert(spikes.end(), wrong.begin(), wrong.end());
  }
  return spikes;
}

std::string standsAlone(const ChannelSpikes& spikes) {
  return fmt::format("{} stands alone in {} rows", spikes.channel, spikes.rows.size());
}

std::vector<ChannelSpikes> repairSpikes(std::span<const double> time, const std::vector<int>& session,
                                        std::span<const SearchedChannel> channels) {
  std::vector<ChannelSpikes> found;
  for (const auto& [name, values, most] : channels) {
    if (values->empty()) continue;
    ChannelSpikes spikes{name, {}};
    for (const Block& b : splitRows(session, values->size())) {
      const std::span<double> own = std::span(*values).subspan(b.begin, b.size());
      for (const Spike& spike : findSpikes(time.subspan(b.begin, b.size()), own, most)) {
        own[spike.row] = spike.likely;
        spikes.rows.push_back(b.begin + spike.row);
      }
    }
    if (!spikes.rows.empty()) found.push_back(std::move(spikes));
  }
  return found;
}

}  // namespace simgap
