#include "simgap/fit/dynamics/dynamics_sums.h"

#include <tbb/parallel_for.h>

#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Rows of one joint that are multiplied at once.
constexpr Index kChunk = 128;

struct JointChunk {
  RegressorMatrix rows;  ///< shape (kChunk, A + 2)
  Index filled = 0;

  void addTo(JointSums& sums) {
    if (filled == 0) return;  // Eigen divides by the number of rows
    sums.products.selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(filled).transpose());
    sums.rows += static_cast<double>(filled);
    filled = 0;
  }
};

void fillMotion(const RobotLog& log, std::size_t row, RobotMotion& motion) {
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    const RobotJointLog& joint = log.joints[c];
    motion.position[c] = joint.position[row];
    motion.velocity[c] = joint.velocity[row];
    motion.acceleration[c] = joint.acceleration[row];
    motion.direction[c] = joint.direction[row];
  }
}

RobotMotion emptyMotion(std::size_t coordinates) {
  const std::vector<double> none(coordinates);
  return {none, none, none, none};
}

void sumBlock(const RobotLog& log, const Block& block, const RobotRegressor& regressor, const BaseParameters& base,
              std::span<const StribeckCurve> curves, std::span<const ExtraColumn> extras, const ExtraColumn& known,
              std::vector<JointSums>& sums) {
  const std::size_t n = regressor.coordinates();
  RobotRegressor::Workspace work = regressor.workspace();
  RegressorMatrix y(n, regressor.columns());
  RobotMotion motion = emptyMotion(n);
  std::vector<JointChunk> chunks(n);
  std::vector<std::vector<const Eigen::ArrayXd*>> own(n);  // extra columns of each joint
  sums.resize(n);
  for (std::size_t c = 0; c < n; ++c) {
    for (const ExtraColumn& extra : extras) {
      if (extra[c].size() > 0) own[c].push_back(&extra[c]);
    }
    const Index columns = std::ssize(base.acts[c]) + std::ssize(own[c]) + 2;
    chunks[c].rows.resize(kChunk, columns);
    sums[c].products = MatrixXd::Zero(columns, columns);
  }
  for (std::size_t row = block.begin; row < block.end; ++row) {
    if (!log.usable[row]) continue;
    fillMotion(log, row, motion);
    regressor.rows(motion, curves, work, y);
    for (std::size_t c = 0; c < n; ++c) {
      if (!log.joints[c].moves[row]) continue;
      JointChunk& chunk = chunks[c];
      const Index joint = c;
      Index at = 0;
      for (const std::size_t k : base.acts[c]) chunk.rows(chunk.filled, at++) = y(joint, base.columns[k]);
      for (const Eigen::ArrayXd* extra : own[c]) chunk.rows(chunk.filled, at++) = (*extra)[row];
      chunk.rows(chunk.filled, at++) =
          regressor.dynamics().springTorque(c, motion.position[c]) + (known.empty() ? 0.0 : known[c][row]);
      chunk.rows(chunk.filled, at) = log.joints[c].effort[row];
      if (++chunk.filled == kChunk) chunk.addTo(sums[c]);
    }
  }
  for (std::size_t c = 0; c < n; ++c) {
    chunks[c].addTo(sums[c]);
    sums[c].products = MatrixXd(sums[c].products.selfadjointView<Eigen::Lower>());
  }
}

}  // namespace

std::vector<JointSums> DynamicsSums::total(const std::vector<bool>& used) const {
  std::vector<JointSums> sums = blocks.front();
  for (JointSums& joint : sums) {
    joint.products.setZero();
    joint.rows = 0.0;
  }
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (!used[b]) continue;
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += blocks[b][c];
  }
  return sums;
}

DynamicsSums sumDynamics(const RobotLog& log, const RobotRegressor& regressor, const BaseParameters& base,
                         std::span<const StribeckCurve> curves, const std::vector<bool>& used,
                         std::span<const ExtraColumn> extras, const ExtraColumn& known) {
  DynamicsSums sums;
  sums.blocks.resize(log.blocks.size());
  tbb::parallel_for(std::size_t{0}, log.blocks.size(), [&](std::size_t b) {
    if (interruptRequested()) return;
    const Block rows = used[b] ? log.blocks[b] : Block{log.blocks[b].begin, log.blocks[b].begin};
    sumBlock(log, rows, regressor, base, curves, extras, known, sums.blocks[b]);
  });
  stopIfInterrupted();
  return sums;
}

RobotMotion motionAt(const RobotLog& log, std::size_t row) {
  RobotMotion motion = emptyMotion(log.joints.size());
  fillMotion(log, row, motion);
  return motion;
}

MatrixXd predictTorques(const RobotLog& log, const RobotRegressor& regressor, const Eigen::VectorXd& p,
                        std::span<const StribeckCurve> curves) {
  const Index n = regressor.coordinates();
  MatrixXd torques(log.rows(), n);
  tbb::parallel_for(std::size_t{0}, log.blocks.size(), [&](std::size_t b) {
    if (interruptRequested()) return;
    RobotRegressor::Workspace work = regressor.workspace();
    RegressorMatrix y(n, regressor.columns());
    RobotMotion motion = emptyMotion(regressor.coordinates());
    for (std::size_t row = log.blocks[b].begin; row < log.blocks[b].end; ++row) {
      fillMotion(log, row, motion);
      regressor.rows(motion, curves, work, y);
      const Index i = row;
      torques.row(i) = (y * p).transpose();
      for (Index c = 0; c < n; ++c) torques(i, c) += regressor.dynamics().springTorque(c, motion.position[c]);
    }
  });
  stopIfInterrupted();
  return torques;
}

}  // namespace simgap
