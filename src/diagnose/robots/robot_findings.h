/// \file
/// A fit is no finding: what an accepted cause of a robot has to hold against before it is named.
#pragma once

#include <string>
#include <string_view>

#include "robot_selection.h"

namespace simgap {

/// What blocks say that decided nothing.
struct RobotFindings {
  std::vector<Candidate> candidates;
  std::vector<Interval> gain;  ///< of each named cause, on the joints that it acts on
};

/// The torque of one cause on every joint. \param theta  shape (C)
ExtraColumn signatureOf(const RobotRows& rows, const RobotHypothesis& hypothesis, const Eigen::VectorXd& theta);

/// Share of the placebos that explain as much as the cause itself, one more counted on either side; 0 for a constant,
/// which has no colour that a placebo could have.
double placeboP(const RobotSearch& search, const RobotSearch::Set& set, std::size_t cause, std::uint64_t seed);

/// Channel of what other numbers of bodies and drives would save, behind which stands the joint that it helps most.
inline constexpr std::string_view kAllNumbers = "all numbers of its bodies and drives";

/// What is left beside the causes on unseen folds, of the error of the model without any: by other numbers of the
/// bodies and drives, where those were known, and by the channels of each joint.
struct RobotLeft {
  double share = 0.0;
  std::vector<Leftover> channels;
};
/// What it is seen by, of all joints at once.
struct RobotUnseen {
  const RobotSearch& search;
  BlockErrors plain, with;    ///< on unseen folds and on blocks held out: without causes and with them
  BlockErrors free;           ///< on unseen folds, with all other numbers free, too
  Eigen::MatrixXd predicted;  ///< with the last, shape (rows, N)
};
RobotUnseen unseenOf(const RobotSearch& search, const RobotSearch::Set& set);
RobotLeft whatIsLeft(const RobotUnseen& unseen, const std::vector<std::size_t>& joints);
/// Times the squared error that was left of a joint when the robot was found: more than other motions leave.
inline constexpr double kBeyondKnown = 2.0;
/// Why a cause may only stand in for what acts: much is left beside all causes beyond that, of what the model without
/// them has beyond its known errors. Where the cause leaves some of its own joints' excess, of any joint that has much
/// of it, or a joint stays far beyond: what acts at one shakes others, whose causes would be named. Empty: it does not,
/// or nobody has written down what was left. \param joints  on which it acts \param of_bodies  on several of them at
/// once, and not late: it has to explain those that have most of the excess
std::string leftBeyondKnown(const RobotUnseen& unseen, const std::vector<std::size_t>& joints, bool of_bodies);

/// Takes causes out of the selection that are no findings.
RobotFindings judgeFindings(RobotSearch& search, RobotSelector& selector, const RobotDiagnosisOptions& options,
                            RobotSelection& selection);

}  // namespace simgap
