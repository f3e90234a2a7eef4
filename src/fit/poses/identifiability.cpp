#include "identifiability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/core/decompositions.h"

namespace simgap {
namespace {

constexpr double kNull = 1e-7;    // of the largest singular value: rounding, far below anything a pose tells
constexpr double kMember = 1e-4;  // of the largest coefficient: belongs to the combination
constexpr double kCollinear = 1.0 - 1e-8;
constexpr std::size_t kMostNamed = 6;  // members of a combination that a person can read

/// "biceps", "shock_cord.rest_length_m" of "muscles.biceps.shock_cord.rest_length_m".
std::pair<std::string, std::string> itemAndMember(const std::string& name) {
  const auto first = name.find('.');
  const auto second = name.find('.', first + 1);
  if (first == std::string::npos || second == std::string::npos) return {"", name};
  return {name.substr(first + 1, second - first - 1), name.substr(second + 1)};
}

/// "kite_line_length_m and shock_cord.rest_length_m of biceps"
std::string namesOf(const std::vector<std::size_t>& members, const ParameterSpace& space) {
  std::vector<std::string> order;
  std::map<std::string, std::string> members_of;
  for (const std::size_t i : members) {
    const auto [item, member] = itemAndMember(space.parameters()[i].name);
    if (!members_of.contains(item)) order.push_back(item);
    std::string& text = members_of[item];
    text += (text.empty() ? "" : " and ") + member;
  }
  std::string text;
  for (const std::string& item : order) {
    text += (text.empty() ? "" : ", ") + members_of[item] + (item.empty() ? "" : " of " + item);
  }
  return text;
}

/// What of two parameters is known when `direction` (change of their values) cannot be seen.
std::string knownOfPair(double a, double b) {
  if (std::abs(std::abs(a) - std::abs(b)) > 1e-3 * std::abs(a)) return "only one combination of them";
  return a * b < 0.0 ? "only their sum" : "only their difference";
}

Combination describe(const std::vector<std::size_t>& members, const Eigen::VectorXd& direction, bool always,
                     const ParameterSpace& space) {
  Combination combination{members, always, {}};
  if (members.size() == 1) {
    combination.text = namesOf(members, space) + ": has no effect";
  } else if (members.size() <= kMostNamed) {
    combination.text = namesOf(members, space) + ": ";
    combination.text += members.size() == 2
                            ? knownOfPair(direction[members[0]], direction[members[1]])
                            : fmt::format("only {} combinations of the {}", members.size() - 1, members.size());
  } else {
    combination.text = fmt::format("a combination of {} parameters, among them {}", members.size(),
                                   namesOf({members.begin(), members.begin() + 3}, space));
  }
  if (!always) combination.text += ", with these poses";
  return combination;
}

/// Reduced row echelon form of the null space, so that each row has few members. \param rows  shape (dimension, n)
void reduceRows(Eigen::MatrixXd& rows) {
  Eigen::Index row = 0;
  for (; row < rows.rows(); ++row) {
    Eigen::Index r = 0, column = 0;
    const double largest = rows.bottomRows(rows.rows() - row).cwiseAbs().maxCoeff(&r, &column);
    if (largest < 1e-12) break;
    rows.row(row).swap(rows.row(row + r));
    rows.row(row) /= rows(row, column);
    for (Eigen::Index other = 0; other < rows.rows(); ++other) {
      if (other != row) rows.row(other) -= rows(other, column) * rows.row(row);
    }
  }
}

/// Scale of each parameter's z in its own unit, so that "sum" means a sum of values.
Eigen::VectorXd unitScales(const ParameterSpace& space) {
  Eigen::VectorXd scale(static_cast<Eigen::Index>(space.size()));
  const ScaledParameters scaled(space);
  for (Eigen::Index i = 0; i < scale.size(); ++i) scale[i] = scaled.slope(i, 0.0);
  return scale;
}

}  // namespace

std::vector<Combination> findCombinations(const Eigen::MatrixXd& recorded, const Eigen::MatrixXd& anywhere,
                                          const ParameterSpace& space, Eigen::VectorXd& unknowable) {
  std::vector<Combination> combinations;
  const Eigen::VectorXd scale = unitScales(space);
  const Eigen::Index n = recorded.cols();
  const RightSingular svd = rightSingular(anywhere);
  Eigen::Index rank = 0;
  while (rank < svd.values.size() && svd.values[rank] > kNull * svd.values[0]) ++rank;
  Eigen::MatrixXd null = svd.vectors.rightCols(n - rank).transpose();
  unknowable = null.colwise().squaredNorm();
  reduceRows(null);
  std::vector<bool> named(static_cast<std::size_t>(n), false);
  for (Eigen::Index row = 0; row < null.rows(); ++row) {
    std::vector<std::size_t> members;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (std::abs(null(row, i)) > kMember) members.push_back(static_cast<std::size_t>(i));
    }
    for (const std::size_t i : members) named[i] = true;
    combinations.push_back(describe(members, null.row(row).transpose().cwiseProduct(scale), true, space));
  }
  // Of the rest: what these poses do not see, and pairs that they cannot tell apart.
  const Eigen::VectorXd length = recorded.colwise().norm();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (named[i]) continue;
    if (length[i] <= kNull * length.maxCoeff()) {
      combinations.push_back(describe({static_cast<std::size_t>(i)}, scale, false, space));
      continue;
    }
    for (Eigen::Index j = i + 1; j < n; ++j) {
      if (named[j] || length[j] <= kNull * length.maxCoeff()) continue;
      const double cosine = recorded.col(i).dot(recorded.col(j)) / (length[i] * length[j]);
      if (std::abs(cosine) < kCollinear) continue;
      Eigen::VectorXd direction = Eigen::VectorXd::Zero(n);
      direction[i] = scale[i] / length[i];
      direction[j] = (cosine > 0.0 ? -1.0 : 1.0) * scale[j] / length[j];
      combinations.push_back(
          describe({static_cast<std::size_t>(i), static_cast<std::size_t>(j)}, direction, false, space));
    }
  }
  return combinations;
}

}  // namespace simgap
