/// \file
/// An arm with causes fitted to motions, step by step: a diagnosis chooses which fits are worth new derivatives.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "diagnose/arm_cause.h"
#include "simgap/fit/motions/motion_search.h"

namespace simgap {

/// What all fits of a diagnosis share.
struct MotionProblem {
  ArmModel nominal;
  std::vector<ParameterSpace::Choice> parameters;
  MotionPosterior::Options options;
  std::span<const RecordedMotion> motions;  ///< to select with
};

/// Those of a fit with causes: beside one that is the capture's clock no fit has a clock of its own, from which it
/// could not be told.
MotionPosterior::Options optionsWith(const MotionProblem& problem, const std::vector<ArmCause>& causes);

/// The posterior of an arm with causes. \param problem, motions  must outlive it
std::unique_ptr<MotionPosterior> posteriorWith(const MotionProblem& problem, const std::vector<ArmCause>& causes,
                                               std::span<const RecordedMotion> motions);

/// A posterior's numbers at one place, with the quadratic that its derivatives promise; for many trials at once.
/// Motions without derivatives are left out.
class MotionPoint {
 public:
  MotionPoint(const MotionPosterior& posterior, const MotionLinearisation& here);
  /// Whether the fit's own clock follows, as all other ordinary parameters do: beside a cause that is the capture's
  /// clock it would take over what that should explain.
  enum class OwnClock { kFollows, kStays };
  /// The least objective that other residuals leave once the ordinary parameters have followed them within their
  /// bounds.
  double predicted(std::span<const Eigen::VectorXd> residuals, OwnClock clock = OwnClock::kFollows) const;
  const MotionPosterior& posterior() const { return *posterior_; }
  const MotionLinearisation& here() const { return *here_; }
  const std::vector<Eigen::VectorXf>& weights() const { return weights_; }  ///< shape (motions) of (numbers)
  /// J^T W x, x of shape (motions) of (numbers)
  Eigen::VectorXd projected(std::span<const Eigen::VectorXf> x) const;
  Eigen::VectorXd solved(const Eigen::VectorXd& gradient, OwnClock clock = OwnClock::kFollows) const;

 private:
  const MotionPosterior* posterior_;
  const MotionLinearisation* here_;
  std::vector<Eigen::VectorXf> weights_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd of_clock_;  ///< what a push on the clock moves
};

/// Indices of a few motions spread over a set, which are enough to look around with: all of a small one.
std::vector<std::size_t> someMotions(std::size_t count);
/// A fit's place with the derivatives of some motions only, for a MotionPoint that knows no others.
MotionLinearisation onlyOf(const MotionLinearisation& here, std::span<const std::size_t> some);

class MotionCauseFit {
 public:
  using News = std::function<void(long rollouts)>;
  /// \param problem  must outlive it
  MotionCauseFit(const MotionProblem& problem, std::vector<ArmCause> causes);

  const std::vector<ArmCause>& causes() const { return causes_; }
  std::span<const RecordedMotion> motions() const { return problem_->motions; }
  const MotionPosterior& posterior() const { return *posterior_; }
  const MotionLinearisation& here() const { return here_; }
  double objective() const;  ///< with the same robust loss for all fits
  long rollouts() const { return rollouts_; }

  /// Begins at the prior's mean with derivatives of its own.
  void begin(const News& news);
  /// Begins beside a fit with one cause less: at its point, the cause where a search along its first parameter finds it
  /// from its start, with derivatives of its own. \returns false where the motions cannot be played there
  bool beginBeside(const MotionPoint& point);
  /// Begins with the derivatives of a fit of the same parameters. \returns false where the motions cannot be played
  bool beginAs(const MotionCauseFit& other, const Eigen::VectorXd& z);
  /// Begins where a fit with one cause more stands. \param cause  which of its causes is left out
  bool beginWithout(const MotionCauseFit& other, std::size_t cause);
  /// As `beginAs`, with the last cause looked for anew, from its start.
  bool beginAnew(const MotionCauseFit& other, Eigen::VectorXd z);
  /// Steps with the derivatives at hand. \returns what they gained
  double descend();
  /// Derivatives made anew where they count, then steps. \returns what these gained
  double refresh(const News& news);
  /// Another place, if it is better; derivatives stay.
  bool moveTo(const Eigen::VectorXd& z);

  /// z with ordinary parameters that lie far from their prior back where they were expected; none where none does.
  std::optional<Eigen::VectorXd> withoutFar() const;
  /// z of the fit without the last cause.
  Eigen::VectorXd withoutLast() const;
  /// Place and derivatives of the fit without the last cause, if it stood where this one does; the residuals are this
  /// one's.
  MotionLinearisation withoutLastCause() const;
  ArmModel model() const { return posterior_->modelAt(here_.z); }
  /// Mean square of the whitened residuals as they are weighed.
  double misfit() const;
  /// Each motion's part of the objective.
  Eigen::VectorXd losses() const;
  /// Of z; wider where residuals are larger than their weights assume.
  Eigen::MatrixXd covariance() const;
  /// The causes with their values and standard deviations.
  std::vector<Extension> extensions() const;
  Eigen::Index ordinary() const;  ///< parameters before the causes'

 private:
  bool place(const Eigen::VectorXd& z);
  void putAtStart(Eigen::VectorXd& z) const;
  void searchAlong(Eigen::Index i);
  const MotionProblem* problem_;
  std::vector<ArmCause> causes_;
  std::unique_ptr<MotionPosterior> posterior_;
  MotionLinearisation here_;
  double damping_ = 1e-3;
  long rollouts_ = 0;
};

}  // namespace simgap
