/// \file
/// Working ranges that a drive has to cover, and how far a log does: a law is no more than a guess beyond its rows.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace simgap {

/// What a joint has to do (003 table 1): every velocity and torque up to these, in both directions.
struct Requirement {
  std::string name;
  double velocity;                                      ///< [rad/s] at the joint
  double torque;                                        ///< [N m]
  std::optional<std::pair<double, double>> angle = {};  ///< [rad] of the joint, from and to
};

/// The paper's requirements of daily living, with their ranges of motion: shoulder 71 deg/s and 100 to -135 deg, elbow
/// 91 deg/s and 0 to 135 deg, 20 N m (003 table 1, from its reference [40]).
std::vector<Requirement> paperRequirements();

/// \param texts  "NAME:DEG_PER_S:NM" each, or "paper" for those. \throws ConfigError
std::vector<Requirement> readRequirements(const std::vector<std::string>& texts);

/// Where the rows of a log lie.
struct CoveredRange {
  double velocity, load;             ///< the largest: [rad/s] at the joint, [N m]
  double cells = 0.0;                ///< of the required rectangle of velocity and load, share in which there are rows
  std::optional<double> angle = {};  ///< of the required angles, share where there are rows; none without positions
  /// The furthest row in both is at the edge or beyond; `cells` says how much lies between.
  bool covers(const Requirement& r) const { return velocity >= r.velocity && load >= r.torque; }
};
/// A tenth of the range by a tenth of it is a cell; ten rows make one covered.
/// \param velocity, position  of the motor, shape (n); no position: shape (0)  \param ratio  motor per joint
CoveredRange coveredRange(const Requirement& requirement, const Eigen::ArrayXd& velocity, const Eigen::ArrayXd& load,
                          const Eigen::ArrayXd& position, double ratio);

/// How many rows lie between two neighbouring edges.
struct Histogram {
  std::vector<double> edges;  ///< shape (bins + 1)
  std::vector<std::size_t> rows;
};
/// Of equal bins from the lowest value to the highest. \param values  not empty
Histogram histogramOf(const Eigen::ArrayXd& values, std::size_t bins = 40);

}  // namespace simgap
