#include "robot_cause.h"

namespace simgap {

using Eigen::Index;

ExtraColumn onJoint(std::size_t joints, std::size_t c, Eigen::ArrayXd torque) {
  ExtraColumn column(joints);
  column[c] = std::move(torque);
  return column;
}

ExtraColumn onAll(const Eigen::MatrixXd& torque) {
  ExtraColumn column;
  for (Index c = 0; c < torque.cols(); ++c) {
    column.emplace_back();
    if (!torque.col(c).isZero(0.0)) column.back() = torque.col(c).array();
  }
  return column;
}

const char* effortUnit(const Joint& joint) { return joint.slides() ? "N" : "Nm"; }

}  // namespace simgap
