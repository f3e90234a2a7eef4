/// \file
/// Which cause the motions of the selection speak for: a scan, refits of the best, new derivatives for those that may
/// win.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "motion_candidates.h"
#include "motion_plan.h"
#include "motion_scan.h"

namespace simgap {

/// A cause found beside those that a model has.
struct FoundCause {
  std::unique_ptr<MotionCauseFit> fit;  ///< with it, the last of its causes
  double evidence = 0.0;                ///< gain of the log posterior, at the variance that the residuals show
  double p = 1.0;                       ///< how often placebos promise as much
  std::vector<std::string> rivals;      ///< that do about as well in its place, "effect:target"
  Eigen::VectorXd by_motion;            ///< each motion's part of the evidence, shape (motions)
  std::vector<MotionCandidate> others;  ///< that stood in its place, the best first
};

inline constexpr double kMotionsTellApart = 6.0;  ///< evidence by which a cause has to lead
inline constexpr double kOnTheWay = 5.0;  ///< times what its last derivatives gained: a fit may still come so far

class MotionSelector {
 public:
  /// Called with the part of the rollouts that are expected.
  using News = std::function<void(double done)>;
  /// \param problem, hypotheses  must outlive it  \param level  placebos may promise as much with this probability at
  /// most; where no hypothesis promises more, none is fitted
  MotionSelector(const MotionProblem& problem, const std::vector<ArmHypothesis>& hypotheses, std::uint64_t seed,
                 double level, News news);

  /// The model without causes, fitted until nothing is gained. \throws NumericsError, InterruptedError
  std::unique_ptr<MotionCauseFit> fitPlain();
  /// The best cause beside those of `base`, whether or not it is worth naming; none where no hypothesis is open or any
  /// better. \param[in,out] base  a fit with the cause may show it a better place \param[out] records  of all refits
  std::optional<FoundCause> step(MotionCauseFit& base, std::vector<HypothesisRecord>& records);
  /// The fit with one of its causes left out, from where it stands; null where the motions cannot be played so.
  std::unique_ptr<MotionCauseFit> without(const MotionCauseFit& fit, std::size_t cause);
  long rollouts() const { return rollouts_; }

 private:
  struct Refit {
    std::unique_ptr<MotionCauseFit> fit;
    double promised;
    bool settled = false;  ///< its last derivatives gained nothing
    int refreshed = 0;     ///< how often it got derivatives of its own
    double gained = 0.0;   ///< by the last of them

    const ArmCause& cause() const { return fit->causes().back(); }
    bool standsBeside(const ArmCause& best) const;
    bool mayPass(const Refit& best) const;
  };
  using Begin = std::function<bool(MotionCauseFit&)>;
  std::unique_ptr<MotionCauseFit> descended(std::vector<ArmCause> causes, const Begin& begin);
  static std::vector<const MotionTrial*> worthFitting(const MotionScan& scan, const std::vector<ArmHypothesis>& open,
                                                      const std::vector<Refit>& fitted);
  static std::vector<const MotionTrial*> otherTargets(const MotionScan& scan, const std::vector<ArmHypothesis>& open,
                                                      const std::vector<Refit>& fitted);
  std::vector<Refit> refit(const MotionCauseFit& base, std::span<const MotionPoint> points,
                           const std::vector<ArmHypothesis>& open, const std::vector<const MotionTrial*>& chosen);
  MotionScan lookAround(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open,
                        std::vector<MotionPoint>& points);
  void startBesideBest(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open, std::vector<Refit>& refits);
  void lookAgain(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open, std::vector<Refit>& refits);
  static void sortBest(std::vector<Refit>& refits);
  void finishRivals(std::vector<Refit>& refits);
  static std::size_t owedDerivatives(const std::vector<Refit>& refits);
  void settle(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open, std::vector<Refit>& refits,
              int owed_of_new);
  std::vector<std::vector<ArmCause>> choicesOf(const MotionCauseFit& fit) const;
  void chooseAgain(Refit& refit);
  void catchUp(MotionCauseFit& fit, double least);
  void bringBack(Refit& refit, double least);
  static FoundCause conclude(const MotionCauseFit& base, std::vector<Refit>& refits,
                             const std::vector<double>& placebos, std::vector<HypothesisRecord>& records);
  static bool enough(double gain, double objective);  ///< a round that gains less was the last
  void converge(MotionCauseFit& fit, int most);
  void improveBase(MotionCauseFit& base, const MotionCauseFit& with);
  MotionCauseFit::News newsOf();
  void count(long rollouts);
  void tell(long rollouts);

  const MotionProblem& problem_;
  const std::vector<ArmHypothesis>& hypotheses_;
  std::uint64_t seed_;
  double level_;
  News news_;
  MotionPlan plan_;
  MotionLinearisation first_;  ///< at the prior's mean, without causes
  double gained_ = 0.0;        ///< by the last derivatives of the model without another cause
  long rollouts_ = 0;
};

}  // namespace simgap
