/// \file
/// A load that an end of the robot picks up and puts down while it is recorded. When it carries it is looked for in
/// what a fit to the whole log leaves: with the load's columns Y of every block b of rows, s_b = 1 where it is carried,
///
///     r = Y theta_0 + s_b Y theta_1,
///
/// theta_0 being what that fit has taken for a load that is always there. The two are solved in turn: theta by least
/// squares, s by the best sequence of two states with a price for every change within a session (Viterbi's algorithm).
/// Which of the two states is the one with a load is said by the model: it is right about the other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "point_mass.h"
#include "simgap/core/decompositions.h"
#include "simgap/model/arm/arm_tree.h"

namespace simgap::robot_causes::payload_change {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr char kName[] = "payload-change";
constexpr double kAlike = 10.0;       // rows that count as one, as their errors are alike
constexpr double kPrice = 10.0;       // of a change [nats]
constexpr double kClear = 30.0;       // what it has to explain more than a load that is always there [nats]
constexpr double kLeastShare = 0.05;  // of the blocks, with it and without
constexpr int kRounds = 8;

/// Sums over a block: Y^T Y and Y^T r of all joints, each of its own variance.
struct LoadBlock {
  MatrixXd squares = MatrixXd::Zero(4, 4);
  VectorXd right = VectorXd::Zero(4);
  VectorXd right_of_model = VectorXd::Zero(4);  ///< the same of what the model leaves
  int session = 0;

  LoadBlock& operator+=(const LoadBlock& other) {
    squares += other.squares;
    right += other.right;
    right_of_model += other.right_of_model;
    return *this;
  }
};

/// theta_0 and theta_1, shape (8).
struct CarriedLoad {
  VectorXd theta = VectorXd::Zero(8);
  double explained = 0.0;  ///< [nats]
};

/// \param all, with  sums over all blocks and over those in which it is carried
CarriedLoad solveLoad(const LoadBlock& all, const LoadBlock& with) {
  MatrixXd a(8, 8);
  a << all.squares, with.squares, with.squares, with.squares;
  VectorXd b(8);
  b << all.right, with.right;
  a.diagonal().array() += 1e-9 * a.diagonal().maxCoeff() + 1e-300;
  CarriedLoad load{solveLeastSquares(a, b)};
  load.explained = 0.5 * b.dot(load.theta);
  return load;
}

LoadBlock sumOver(const std::vector<LoadBlock>& blocks, const std::vector<bool>& some) {
  LoadBlock sum;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    if (some[k]) sum += blocks[k];
  }
  return sum;
}

/// The sequence of states that explains most at a price for each change.
std::vector<bool> bestStates(const std::vector<LoadBlock>& blocks, const VectorXd& theta) {
  const VectorXd always = theta.head<4>(), load = theta.tail<4>();
  double empty = 0.0, full = 0.0;
  std::vector<std::pair<bool, bool>> came_from;  // whether it carried before, if it does not and if it does
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const double price = k > 0 && blocks[k].session != blocks[k - 1].session ? 0.0 : kPrice;
    came_from.emplace_back(full - price > empty, full > empty - price);
    const double before = empty;
    empty = std::max(empty, full - price);
    full = std::max(full, before - price) + load.dot(blocks[k].right - blocks[k].squares * (always + 0.5 * load));
  }
  std::vector<bool> carried(blocks.size());
  bool state = full > empty;
  for (std::size_t k = blocks.size(); k-- > 0;) {
    carried[k] = state;
    state = state ? came_from[k].second : came_from[k].first;
  }
  return carried;
}

/// The best of all beginnings: carried from some block on.
std::vector<bool> bestBeginning(const std::vector<LoadBlock>& blocks, const LoadBlock& all) {
  std::size_t best = 0;
  double most = 0.0;
  LoadBlock with;
  for (std::size_t first = blocks.size(); first-- > 1;) {
    with += blocks[first];
    const double explained = solveLoad(all, with).explained;
    if (explained <= most) continue;
    most = explained;
    best = first;
  }
  std::vector<bool> carried(blocks.size(), true);
  std::fill_n(carried.begin(), best, false);
  return carried;
}

/// What a load explains that is there in some blocks, of what the model leaves.
double explainedBeside(const LoadBlock& with) {
  MatrixXd a = with.squares;
  a.diagonal().array() += 1e-9 * a.diagonal().maxCoeff() + 1e-300;
  return with.right_of_model.dot(solveLeastSquares(a, with.right_of_model).col(0));
}

/// When the load is carried, by blocks; empty: no such load is clearly there.
std::vector<bool> carriedIn(const std::vector<LoadBlock>& blocks) {
  const LoadBlock all = sumOver(blocks, std::vector<bool>(blocks.size(), true));
  std::vector<bool> carried = bestBeginning(blocks, all);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<bool> better = bestStates(blocks, solveLoad(all, sumOver(blocks, carried)).theta);
    if (better == carried) break;
    carried = std::move(better);
  }
  const LoadBlock with = sumOver(blocks, carried);
  const double more = solveLoad(all, with).explained - solveLoad(all, {}).explained;
  const double share = static_cast<double>(std::ranges::count(carried, true)) / static_cast<double>(carried.size());
  if (share < kLeastShare || share > 1.0 - kLeastShare || more < kClear) return {};
  std::vector<bool> otherwise = carried;
  otherwise.flip();
  return explainedBeside(with) >= explainedBeside(sumOver(blocks, otherwise)) ? carried : otherwise;
}

std::vector<LoadBlock> blocksOf(const RobotRows& rows, std::size_t body) {
  const RobotLog& log = rows.log();
  std::vector<MatrixXd> columns;
  for (Index k = 0; k < 4; ++k) {
    VectorXd change = VectorXd::Zero(rows.regressor().columns());
    change[rows.regressor().bodyColumn(body) + k] = 1.0;
    columns.push_back(rows.torqueOf(change));
  }
  std::vector<LoadBlock> blocks(log.blocks.size());
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    const ArrayXd residual = rows.residual(c), of_model = rows.drive(c).effort - rows.torque().col(c).array();
    const double counted = static_cast<double>((residual != 0.0).count()), squares = residual.square().sum();
    if (!(squares > 0.0)) continue;
    const double weight = counted / squares / kAlike;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      blocks[b].session = log.session[log.blocks[b].begin];
      for (std::size_t row = log.blocks[b].begin; row < log.blocks[b].end; ++row) {
        const auto i = static_cast<Index>(row);
        if (residual[i] == 0.0) continue;
        Eigen::Vector4d y;
        for (Index k = 0; k < 4; ++k) y[k] = columns[k](i, static_cast<Index>(c));
        blocks[b].squares += weight * y * y.transpose();
        blocks[b].right += weight * residual[i] * y;
        blocks[b].right_of_model += weight * of_model[i] * y;
      }
    }
  }
  return blocks;
}

/// No other body with a mass hangs on it.
bool isEnd(const RobotRows& rows, std::size_t body) {
  const std::vector<int>& bodies = rows.regressor().dynamics().bodies();
  const ArmModel& arm = rows.model().arm;
  const auto isOwn = [&](int joint) { return arm.joints[joint].parent == bodies[body]; };
  for (std::size_t other = 0; other < bodies.size(); ++other) {
    if (!rows.regressor().massless(other) && std::ranges::any_of(jointsAbove(arm, bodies[other]), isOwn)) return false;
  }
  return true;
}

std::string whenText(const RobotLog& log, const std::vector<bool>& carried) {
  const std::size_t first = static_cast<std::size_t>(std::ranges::find(carried, true) - carried.begin());
  const auto with = static_cast<double>(std::ranges::count(carried, true));
  return fmt::format("; it carries it in {:.0f} % of the log, first from {:.1f} s on",
                     100.0 * with / static_cast<double>(carried.size()), log.time[log.blocks[first].begin]);
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  std::vector<RobotHypothesis> list;
  const RobotRegressor& regressor = rows.regressor();
  const RobotLog& log = rows.log();
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    if (regressor.massless(b) || !isEnd(rows, b)) continue;
    const std::vector<bool> carried = carriedIn(blocksOf(rows, b));
    if (carried.empty()) continue;
    ArrayXd there = ArrayXd::Zero(std::ssize(log.time));
    for (std::size_t k = 0; k < carried.size(); ++k) {
      const auto begin = static_cast<Index>(log.blocks[k].begin);
      if (carried[k]) there.segment(begin, static_cast<Index>(log.blocks[k].size())).setOnes();
    }
    RobotHypothesis& h = list.emplace_back();
    describePointMass(h);
    h.cause = kName;
    h.target = rows.bodyName(b);
    h.sentence = "the body picks up a mass, or puts it down, while it is recorded" + whenText(log, carried);
    h.separates = "the same motion without any load, and with it from the beginning to the end";
    h.torque = [&rows, b, there](const VectorXd& theta) {
      const MatrixXd more = rows.torqueOf(pointMass(rows.regressor(), b, theta));
      return onAll((more.array().colwise() * there).matrix());
    };
  }
  return list;
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::payload_change
