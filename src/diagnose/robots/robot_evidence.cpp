#include "robot_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kJointBins = 20;
constexpr double kJointStructure = 0.05;  // share of a joint's error that a channel has to explain

struct Driver {
  std::string name, unit;
  ArrayXd values;  ///< shape (rows)
};

std::vector<Driver> driversOf(const RobotRows& rows, std::size_t c) {
  const ActuatorRows& drive = rows.drive(c);
  const bool slides = rows.joint(c).slides();
  const std::string& name = rows.jointName(c);
  return {{"position of " + name, slides ? "m" : "rad", drive.joint_angle},
          {"velocity of " + name, slides ? "m_s" : "rad_s", drive.speed},
          {"acceleration of " + name, slides ? "m_s2" : "rad_s2", drive.acceleration},
          {"load of " + name, effortUnit(rows.joint(c)), drive.load},
          {"time", "s", drive.time}};
}

std::vector<std::size_t> movingRows(const RobotRows& rows, std::size_t c) {
  std::vector<std::size_t> counted;
  for (std::size_t i = 0; i < rows.log().rows(); ++i) {
    if (rows.counts(i, c)) counted.push_back(i);
  }
  return counted;
}

/// Bins of equal counts, in the order of the driver. \param order  rows, is sorted
std::vector<std::span<const std::size_t>> binsOf(const ArrayXd& values, std::vector<std::size_t>& order) {
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<std::span<const std::size_t>> bins;
  for (std::size_t k = 0; k < kJointBins; ++k) {
    const std::size_t begin = k * order.size() / kJointBins, end = (k + 1) * order.size() / kJointBins;
    if (end > begin) bins.emplace_back(order.data() + begin, end - begin);
  }
  return bins;
}

/// Squares of a residual that its means in bins of a driver, taken from the other folds, save. \param fold  shape
/// (rows), negative: has no part
double savedBy(const ArrayXd& values, const ArrayXd& residual, const std::vector<int>& fold,
               std::vector<std::size_t> rows) {
  double saved = 0.0;
  for (const std::span<const std::size_t> bin : binsOf(values, rows)) {
    double sum = 0.0, count = 0.0, own[kRobotFolds] = {}, of[kRobotFolds] = {};
    for (const std::size_t i : bin) {
      if (fold[i] < 0) continue;
      const double r = residual[i];
      sum += r, count += 1.0;
      own[fold[i]] += r, of[fold[i]] += 1.0;
    }
    for (int f = 0; f < kRobotFolds; ++f) {
      if (of[f] == 0.0 || count - of[f] < 1.0) continue;
      const double mean = (sum - own[f]) / (count - of[f]);
      saved += 2.0 * mean * own[f] - mean * mean * of[f];
    }
  }
  return saved;
}

/// Of each row its fold; -1 where it only measures.
std::vector<int> foldsOfRows(const RobotSearch& search) {
  std::vector<int> folds(search.rows().log().rows(), -1);
  const std::vector<Block>& blocks = search.rows().log().blocks;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (!search.ground().training[b]) continue;
    std::fill(folds.begin() + static_cast<std::ptrdiff_t>(blocks[b].begin),
              folds.begin() + static_cast<std::ptrdiff_t>(blocks[b].end), search.ground().fold[b]);
  }
  return folds;
}

void addJointBins(const RobotSearch& search, const Driver& driver, std::size_t c, const ArrayXd& before,
                  const ArrayXd& after, std::vector<EvidenceBin>& evidence) {
  const RobotRows& rows = search.rows();
  std::vector<std::size_t> order = movingRows(rows, c);
  const std::string& unit = rows.log().joints[c].effort_unit;
  const std::string against = fmt::format("residual of {} [{}] against {}", rows.jointName(c), unit, driver.name);
  for (const std::span<const std::size_t> bin : binsOf(driver.values, order)) {
    double center = 0.0, sums[2] = {}, squares[2] = {};
    for (const std::size_t i : bin) {
      center += driver.values[i];
      const double errors[2] = {before[i], after[i]};
      for (int k = 0; k < 2; ++k) sums[k] += errors[k], squares[k] += errors[k] * errors[k];
    }
    const auto n = static_cast<double>(bin.size());
    double mean[2], half[2];
    for (int k = 0; k < 2; ++k) {
      mean[k] = sums[k] / n / rows.constant(c);
      const double variance = std::max(0.0, squares[k] / n - std::pow(sums[k] / n, 2)) / std::pow(rows.constant(c), 2);
      half[k] = kNormalQuantile * std::sqrt(variance * search.ground().inflation / n);
    }
    evidence.push_back({against, center / n, mean[0], half[0], mean[1], half[1], bin.size(), driver.unit});
  }
}

}  // namespace

VectorXd keptParameters(const RobotRegressor& regressor, const BaseParameters& base, const VectorXd& z) {
  VectorXd parameters = VectorXd::Zero(regressor.columns());
  for (std::size_t k = 0; k < base.columns.size(); ++k) parameters[base.columns[k]] = z[k];
  return parameters;
}

MatrixXd predictedTorque(const RobotSearch& search, const RobotSearch::Set& set, const RobotSearch::Fit& fit) {
  const RobotRows& rows = search.rows();
  const VectorXd parameters = keptParameters(rows.regressor(), search.ground().base, fit.z);
  MatrixXd torque = predictTorques(rows.log(), rows.regressor(), parameters, rows.model().curves);
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (!search.hypothesis(set[k]).torque) continue;  // others stand in the parameters
    const ExtraColumn own = signatureOf(rows, search.hypothesis(set[k]), fit.theta[k]);
    for (std::size_t c = 0; c < own.size(); ++c) {
      if (own[c].size() > 0) torque.col(c).array() += own[c];
    }
  }
  return torque;
}

RobotUnseen unseenOf(const RobotSearch& search, const RobotSearch::Set& set) {
  const std::vector<bool> heldout = search.ground().heldout();
  const auto errorsOf = [&](const RobotSearch::Set& causes) {
    return BlockErrors(search.validate(causes) + search.errors(search.fit(causes, kRobotFolds).z, heldout));
  };
  const RobotSearch::Fit fit = search.fit(set, kRobotFolds, /*without_prior=*/true);
  return {search, errorsOf({}), errorsOf(set), search.validate(set, /*without_prior=*/true),
          predictedTorque(search, set, fit)};
}

RobotLeft whatIsLeft(const RobotUnseen& unseen, const std::vector<std::size_t>& joints) {
  const RobotSearch& search = unseen.search;
  const RobotGround& ground = search.ground();
  const auto total = [&](const BlockErrors& errors) {
    return groupErrors(errors, search.counted(), ground.training, joints).sum.sum();
  };
  const double without = std::max(total(unseen.plain), 1e-300);
  RobotLeft left;
  const double saved_by_all = std::max(0.0, total(unseen.with) - total(unseen.free)) / without;
  if (saved_by_all > kJointStructure) {
    const auto saved = [&](std::size_t c) {
      return groupErrors(unseen.with, search.counted(), ground.training, {c}).sum.sum() -
             groupErrors(unseen.free, search.counted(), ground.training, {c}).sum.sum();
    };
    std::string channel(kAllNumbers);
    if (joints.size() > 1) {
      channel += ", most at " + search.rows().jointName(*std::ranges::max_element(joints, {}, saved));
    }
    left.channels.push_back({std::move(channel), saved_by_all, {}});
  }
  // What no numbers of the model can say: means over each joint's own channels.
  const std::vector<int> folds = foldsOfRows(search);
  for (const std::size_t c : joints) {
    const ArrayXd residual = search.rows().drive(c).effort - unseen.predicted.col(c).array();
    const std::vector<std::size_t> counted = movingRows(search.rows(), c);
    double squares = 1e-300;
    for (const std::size_t i : counted) {
      if (folds[i] >= 0) squares += std::pow(residual[i], 2);
    }
    Leftover most{"", 0.0, {}};
    for (const Driver& driver : driversOf(search.rows(), c)) {
      const double saved = savedBy(driver.values, residual, folds, counted);
      if (saved / squares > std::max(kJointStructure, most.share)) most = {driver.name, saved / squares, {}};
    }
    if (most.share == 0.0) continue;
    most.share *= squares / ground.variance[c] / without;
    left.channels.push_back(most);
  }
  std::ranges::stable_sort(left.channels, std::greater<>(), &Leftover::share);
  for (const Leftover& channel : left.channels) left.share += channel.share;
  left.share = std::min(1.0, left.share);
  return left;
}

std::string leftBeyondKnown(const RobotUnseen& unseen, const std::vector<std::size_t>& joints, bool of_bodies) {
  constexpr double kMuch = 0.25;   // bodies carry what acts at one joint to others
  constexpr double kCounts = 0.2;  // of all joints' excess: that of a joint which has to be explained itself, too
  constexpr double kFar = 20.0;    // times the known squared error: whatever was found, the joint is not explained
  constexpr double kLittle = 0.1;  // of its own joints' excess: what leaves no more is no other joint's
  constexpr double kWhole = 3.0, kOfBefore = 0.02;  // times the known squared error: what acts on bodies leaves
  const RobotSearch& search = unseen.search;
  const std::vector<double> floors = noiseFloors(search, unseen.predicted);
  const std::vector<bool> every(search.ground().training.size(), true);
  const Index all = std::ssize(floors) - 1;
  ArrayXd left = ArrayXd::Zero(all), before = ArrayXd::Constant(all, 1e-300), times = ArrayXd::Zero(all),
          times_before = ArrayXd::Zero(all);
  double own_left = 0.0, own_before = 1e-300;
  for (Index j = 0; j < all; ++j) {
    const auto c = static_cast<std::size_t>(j);
    const double known = knownError(search, floors[c], c);
    const GroupErrors plain = groupErrors(unseen.plain, search.counted(), every, {c});
    const GroupErrors with = groupErrors(unseen.with, search.counted(), every, {c});
    if (!(known > 0.0)) continue;
    before[j] += std::max(0.0, plain.sum.sum() - known * plain.rows.sum());
    left[j] = std::max(0.0, with.sum.sum() - kBeyondKnown * known * with.rows.sum());
    times[j] = with.mse() / known;
    times_before[j] = plain.mse() / known;
    if (std::ranges::find(joints, c) == joints.end()) continue;
    own_before += before[j];
    own_left += std::max(0.0, with.sum.sum() - known * with.rows.sum());
  }
  const auto staysAt = [&](Index j) {
    return fmt::format("{} stays at {:.0f} times its known squared error beside it: it may only stand in",
                       search.rows().jointName(static_cast<std::size_t>(j)), times[j]);
  };
  double share = left.sum() / before.sum();
  for (Index j = 0; j < all && of_bodies; ++j) {
    const bool counts = times_before[j] > kCounts * times_before.sum();
    if (counts && times[j] > std::max(kWhole, kOfBefore * times_before[j])) return staysAt(j);
  }
  if (own_left > kLittle * own_before) {
    Index worst = 0;
    if (times.maxCoeff(&worst) > kFar) return staysAt(worst);
    share = std::max(share, (before > kCounts * before.sum()).select(left / before, 0.0).maxCoeff());
  }
  if (share <= kMuch) return {};
  return fmt::format("{:.0f} % of what is beyond the known robot's error are left beside it: it may only stand in",
                     100.0 * share);
}

double knownError(const RobotSearch& search, double floor, std::size_t joint) {
  const std::vector<double>& heldout_sd = search.rows().model().heldout_sd;
  if (heldout_sd.empty() || !(heldout_sd[joint] > 0.0)) return std::nan("");
  const RobotGround& ground = search.ground();
  return std::max(std::pow(ground.constants[joint] * heldout_sd[joint], 2) / ground.variance[joint], floor);
}

std::vector<EvidenceBin> robotEvidence(const RobotSearch& search, const RobotSearch::Set& set,
                                       const RobotSearch::Fit& fit, const MatrixXd& before, const MatrixXd& after) {
  const RobotRows& rows = search.rows();
  const auto left = [&](const MatrixXd& predicted, std::size_t c) {
    return ArrayXd(rows.drive(c).effort - predicted.col(c).array());
  };
  std::vector<EvidenceBin> evidence;
  std::vector<bool> shown(rows.joints(), set.empty());
  for (std::size_t k = 0; k < set.size(); ++k) {
    const ExtraColumn own = signatureOf(rows, search.hypothesis(set[k]), fit.theta[k]);
    for (const std::size_t c : search.joints(set[k])) {
      shown[c] = true;
      if (own[c].size() == 0 || !(own[c].maxCoeff() > own[c].minCoeff())) continue;
      const Driver driver{"what " + search.hypothesis(set[k]).label() + " adds", rows.log().joints[c].effort_unit,
                          own[c] / rows.constant(c)};
      addJointBins(search, driver, c, left(before, c), left(after, c), evidence);
    }
  }
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    if (!shown[c]) continue;
    for (const Driver& driver : driversOf(rows, c)) {
      addJointBins(search, driver, c, left(before, c), left(after, c), evidence);
    }
  }
  return evidence;
}

std::vector<double> noiseFloors(const RobotSearch& search, const MatrixXd& predicted) {
  const RobotRows& rows = search.rows();
  std::vector<double> floors;
  double all = 0.0, all_pairs = 0.0;
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    const ArrayXd residual = rows.drive(c).effort - predicted.col(c).array();
    double sum = 0.0, pairs = 0.0;
    for (std::size_t i = 1; i < rows.log().rows(); ++i) {
      if (!rows.counts(i, c) || !rows.counts(i - 1, c)) continue;
      const double step = residual[i] - residual[i - 1];
      sum += 0.5 * step * step / search.ground().variance[c];
      pairs += 1.0;
    }
    floors.push_back(pairs > 0.0 ? sum / pairs : 0.0);
    all += sum;
    all_pairs += pairs;
  }
  floors.push_back(all_pairs > 0.0 ? all / all_pairs : 0.0);
  return floors;
}

}  // namespace simgap
