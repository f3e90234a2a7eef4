/// \file
/// Hypotheses about a robot, fitted and judged on sums of its log. What is searched is z = (x, e): base parameters and
/// the factors of extra columns. Per joint c and moment
///
///     k_c i_c = Y_c x + sum_e Z_ce e + springs + noise,   x = x_0 + d + B theta + known,   d ~ N(0, C),
///
/// where x_0 and C are what is known of the robot before (C^-1 = 0: nothing), and a hypothesis adds theta along its
/// columns, in the base parameters or in extra columns.
#pragma once

#include <optional>
#include <vector>

#include "diagnose/paired_error.h"
#include "robot_cause.h"

namespace simgap {

/// A x = b over all joints, weighed by the joints' variances.
struct RobotNormal {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;

  RobotNormal& operator+=(const RobotNormal& other) {
    a += other.a;
    b += other.b;
    return *this;
  }
};
/// \param acts  of each joint the places of its sums' columns in A. \param size  of A. \param variance  shape (N)
/// [torque^2] \param constants  shape (N)
RobotNormal normalOf(const std::vector<JointSums>& sums, const std::vector<std::vector<std::size_t>>& acts,
                     Eigen::Index size, const std::vector<double>& variance, const std::vector<double>& constants);

/// What a search stands on.
struct RobotGround {
  const BaseParameters& base;
  std::vector<bool> training;     ///< shape (blocks): the others only measure the gain
  std::vector<int> fold;          ///< shape (blocks)
  std::vector<double> variance;   ///< shape (N): of the residuals of a fit without priors [torque^2]
  double inflation = 1.0;         ///< by how much a row counts less than an independent one
  std::vector<double> constants;  ///< shape (N)
  Eigen::VectorXd x0;             ///< shape (K)
  Eigen::MatrixXd precision;      ///< C^-1, shape (K, K)

  /// Blocks that only measure the gain, shape (blocks).
  std::vector<bool> heldout() const {
    std::vector<bool> others = training;
    others.flip();
    return others;
  }
};

inline constexpr int kRobotFolds = 5;

/// Squared errors, shape (blocks, N), each joint's over its variance.
using BlockErrors = Eigen::ArrayXXd;

class RobotSearch {
 public:
  using Set = std::vector<std::size_t>;  ///< of hypotheses
  RobotSearch(const RobotRows& rows, const RobotGround& ground, std::vector<RobotHypothesis> hypotheses);

  std::size_t size() const { return hypotheses_.size(); }
  const RobotHypothesis& hypothesis(std::size_t h) const { return hypotheses_[h]; }
  const RobotGround& ground() const { return ground_; }
  const RobotRows& rows() const { return rows_; }
  /// Joints on which it acts.
  const std::vector<std::size_t>& joints(std::size_t h) const { return shapes_[h].joints; }
  /// Numbers of it that any joint feels.
  std::size_t freedom(std::size_t h) const { return shapes_[h].active.size(); }
  /// False where what is fitted anyway says the same.
  bool testable(std::size_t h) const { return shapes_[h].testable; }
  /// The ordinary numbers of the drive that a cause changes: what was known of them was found without it, in a log that
  /// may have had it, so that they are free beside it. None where they say the same as the cause.
  Set beside(std::size_t h) const;
  /// Whether all that hypothesis h can say of this log g can say, too.
  bool contains(std::size_t g, std::size_t h) const;

  struct Fit {
    Eigen::VectorXd z;
    std::vector<Eigen::VectorXd> theta;  ///< of each hypothesis of the set
    double cost = 0.0;                   ///< chi squared, with the prior's part, less that of the efforts alone
  };
  /// With what stands beside its causes. \param left_out  a fold; kRobotFolds: none. The blocks that only measure are
  /// never fitted to.
  Fit fit(const Set& set, int left_out, bool without_prior = false) const;
  /// Of the hypotheses' theta from their scores per block, shape (C, C) of all after each other.
  Eigen::MatrixXd covariance(const Set& set, const Fit& fit) const;
  /// \param blocks  shape (blocks): of others they are 0
  BlockErrors errors(const Eigen::VectorXd& z, const std::vector<bool>& blocks) const;
  /// Errors of training blocks by fits to the other folds; 0 for the others.
  BlockErrors validate(const Set& set, bool without_prior = false) const;
  const BlockErrors& counted() const { return counted_; }  ///< rows, shape (blocks, N)

  /// Columns of those that are not linear where a fit of each alone has come to. \returns whether any has moved
  bool relinearise();
  /// The same of a set, where a fit of all has come to, until none of it moves.
  bool settle(const Set& set);

 private:
  struct Shape {
    Eigen::MatrixXd columns;           ///< shape (D, C)
    Eigen::VectorXd known, at;         ///< shape (D), (C)
    std::vector<Eigen::Index> active;  ///< columns that are independent
    std::vector<std::size_t> joints;
    Eigen::Index first_extra = -1;  ///< of its own extra columns; the last of them is `known`
    bool testable = true;
    std::optional<std::size_t> beside;
  };
  void addOrdinary();
  Set expanded(const Set& set) const;
  void shape(std::size_t h);
  void sum();
  void findActive(std::size_t h, const std::vector<JointSums>& total);
  Eigen::MatrixXd activeColumns(std::size_t h) const;
  Eigen::MatrixXd waysOf(const Set& set) const;
  Eigen::VectorXd clamped(std::size_t h, Eigen::VectorXd theta) const;
  /// Whether that is far enough from where its columns were taken to take them anew.
  bool moveTo(std::size_t h, const Eigen::VectorXd& theta);

  const RobotRows& rows_;
  const RobotGround& ground_;
  std::vector<RobotHypothesis> hypotheses_;
  std::vector<Shape> shapes_;
  std::vector<ExtraColumn> extras_;
  Eigen::Index base_ = 0, all_ = 0;
  DynamicsSums sums_;
  std::vector<std::vector<std::size_t>> acts_;
  std::vector<RobotNormal> blocks_;   ///< of each
  std::vector<RobotNormal> without_;  ///< of all training blocks but those of a fold; the last: of all
  BlockErrors counted_;
};

/// A set without its cause of that place.
RobotSearch::Set without(const RobotSearch::Set& set, std::size_t cause);
/// The same, but with the numbers free that stand beside it: what the cause itself adds.
RobotSearch::Set bareOf(const RobotSearch& search, const RobotSearch::Set& set, std::size_t cause);

/// Of some joints, over the blocks of one kind, in their order.
GroupErrors groupErrors(const BlockErrors& errors, const BlockErrors& counted, const std::vector<bool>& blocks,
                        const std::vector<std::size_t>& joints);

}  // namespace simgap
