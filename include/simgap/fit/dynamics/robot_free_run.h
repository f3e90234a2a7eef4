/// \file
/// From efforts to motion: how a robot moves under the efforts of its log, told nothing of the motion but where it
/// begins. Alone every error adds up. With the gains of the joints' controllers it is held on its course as the real
/// robot is: of what feeds forward u(t) and back,
///
///     tau = u + P (q_ref - q) + D (dq_ref - dq) + I int (q_ref - q) dt,
///
/// the log holds tau of the real motion, and so the effort of the simulated one is
///
///     tau_sim = tau_log + P (q_log - q_sim) + D (dq_log - dq_sim) + I int (q_log - q_sim) dt:
///
/// neither the reference nor u has to be known.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

/// Of a joint's controller, in the unit of the model's efforts per [rad] or [m] of the joint; all 0: none.
struct JointGains {
  double proportional = 0.0, derivative = 0.0, integral = 0.0;
};

/// `format: simgap/joint-gains/1`, shape (N). \throws ConfigError: a joint that the robot does not have, or lacks
std::vector<JointGains> readJointGains(const YamlNode& root, const RobotModel& model);

struct RobotFreeRun {
  Eigen::MatrixXd position;          ///< shape (rows, N) [rad] or [m]
  std::vector<double> rms, range;    ///< shape (N): against the log; how far the log's motion reaches
  std::vector<double> half_step;     ///< shape (N): what half the step changes (RMS)
  std::vector<double> near_s;        ///< shape (N): how long it stays within a tenth of `range`, in the worst session
  std::vector<double> beyond_limit;  ///< shape (N): how far it leaves the joint's limits, which are no stops here
};

/// Every session from its first row on, and again after a gap in it. Between two rows efforts and the log's motion are
/// straight lines; steps are 1 ms at most. A step solves
///
///     (M + h (D + V) + h^2 P) dq' = M dq + h (tau - h_0(q, dq)) - p,   |p_j| <= h F_j,
///
/// implicit in the controller and in viscous friction V, with the impulse p of dry friction F that leaves a joint at
/// rest where it can (Moreau & Jean's time-stepping, Jean 1999), by projected Gauss-Seidel. \param gains  shape (N);
/// empty: nothing feeds back \throws NumericsError: a motion without bound, or an inertia that no robot has;
/// InterruptedError
RobotFreeRun runFreely(const RobotModel& model, const RobotLog& log, std::span<const JointGains> gains);

}  // namespace simgap
