#include "robot_cause.h"

namespace simgap {

using Eigen::Index;

std::vector<RobotHypothesis> onEveryJoint(const RobotRows& rows, const char* cause,
                                          const DescribeHypothesis& describe) {
  std::vector<RobotHypothesis> list(rows.joints());
  for (std::size_t c = 0; c < list.size(); ++c) {
    list[c].cause = cause;
    list[c].target = rows.jointName(c);
    describe(c, list[c]);
  }
  return list;
}

std::vector<RobotHypothesis> onEveryBody(const RobotRows& rows, const char* cause, const DescribeHypothesis& describe) {
  std::vector<RobotHypothesis> list;
  for (std::size_t b = 0; b < rows.regressor().bodies(); ++b) {
    if (rows.regressor().massless(b)) continue;
    RobotHypothesis& h = list.emplace_back();
    h.cause = cause;
    h.target = rows.bodyName(b);
    describe(b, h);
  }
  return list;
}

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
