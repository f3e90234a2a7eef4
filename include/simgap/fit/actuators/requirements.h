/// \file
/// Working points that a drive has to reach, and whether a log reaches them: a law is no more than a guess beyond.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace simgap {

/// A working point the drive has to reach (003 table 1).
struct Requirement {
  std::string name;
  double velocity;  ///< [rad/s] at the joint
  double torque;    ///< [N m]
};

/// The paper's requirements of daily living: shoulder 71 deg/s, elbow 91 deg/s, 20 N m.
std::vector<Requirement> paperRequirements();

/// \param texts  "NAME:DEG_PER_S:NM" each, or "paper" for those. \throws ConfigError
std::vector<Requirement> readRequirements(const std::vector<std::string>& texts);

/// The largest velocity (at the joint) and load in the data. \param ratio  motor per joint
struct WorkingPoint {
  double velocity, load;
  bool covers(const Requirement& r) const { return velocity >= r.velocity && load >= r.torque; }
};
WorkingPoint furthestPoint(const Eigen::ArrayXd& velocity, const Eigen::ArrayXd& load, double ratio);

}  // namespace simgap
