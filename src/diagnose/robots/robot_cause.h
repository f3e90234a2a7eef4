/// \file
/// A physical cause that a robot's model may lack: one file in src/diagnose/robots/causes, found by CMake. A cause has
/// one hypothesis per joint, body or pair of joints that it can act on; each changes the regressor's parameters, or
/// adds a torque of its own to every joint.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "robot_rows.h"
#include "simgap/diagnose/diagnosis.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

/// A number of a cause, 0 without it; beyond its bounds it has no physical size.
struct RobotCauseParameter : ParameterSpec {
  double step = 1.0;     ///< by which its slope is taken
  double neutral = 0.0;  ///< is added where people read it
};

struct RobotHypothesis {
  std::string cause;   ///< "payload"
  std::string form;    ///< of a cause with several laws; or empty
  std::string target;  ///< joint or body, or "j2 by j3"; empty: the robot
  std::string sentence, separates;
  std::vector<RobotCauseParameter> parameters;  ///< shape (C)
  bool linear = true;
  Eigen::VectorXd start = {};  ///< where its slopes are taken first, shape (C); empty: 0. Of those that are not linear
  int drive = -1;              ///< the joint whose drive alone it changes; -1: more than one drive
  bool ordinary = false;       ///< no cause: numbers of a drive that a model without causes has
  double searched = 1.0;       ///< places at which its shape was looked for; of more than one several can act at once
  /// \name Either of them; theta has shape (C)
  ///@{
  std::function<Eigen::VectorXd(const Eigen::VectorXd& theta)> change = {};  ///< of the parameters, shape (P)
  std::function<ExtraColumn(const Eigen::VectorXd& theta)> torque = {};
  ///@}
  /// False for values that are no finding; none: all are.
  std::function<bool(const Eigen::VectorXd& theta)> counts = {};
  /// [s] by how much later the motion was logged that its joint's friction meets; none: with the effort.
  std::function<double(const Eigen::VectorXd& theta)> later = {};
  /// What people read, and its slopes, shape (C, C); none: theta itself.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& theta, Eigen::MatrixXd& slopes)> shown = {};
  std::vector<RobotCauseParameter> shown_as = {};
  /// Puts it into a robot's model; none: `change` does. False where its file cannot hold it.
  std::function<bool(const Eigen::VectorXd& theta, RobotModel& model)> hold = {};

  bool isDelay() const { return parameters.size() == 1 && parameters[0].unit == "s"; }
  std::string label() const { return effectLabel(cause, target); }
};

struct RobotCause {
  using Names = std::vector<std::string_view>;
  Names (*names)();  ///< of the causes that it makes
  std::vector<RobotHypothesis> (*hypotheses)(const RobotRows& rows);
};

namespace robot_causes {
std::span<const RobotCause* const> all();
}

/// A hypothesis on every joint, or on every body that has a mass; `describe` writes all but cause and target.
using DescribeHypothesis = std::function<void(std::size_t number, RobotHypothesis& h)>;
std::vector<RobotHypothesis> onEveryJoint(const RobotRows& rows, const char* cause, const DescribeHypothesis& describe);
std::vector<RobotHypothesis> onEveryBody(const RobotRows& rows, const char* cause, const DescribeHypothesis& describe);

/// Torques that act on one joint of N alone.
ExtraColumn onJoint(std::size_t joints, std::size_t c, Eigen::ArrayXd torque);
/// Torques on every joint, shape (rows, N).
ExtraColumn onAll(const Eigen::MatrixXd& torque);
/// "Nm" of a hinge, "N" of a slide.
const char* effortUnit(const Joint& joint);

}  // namespace simgap
