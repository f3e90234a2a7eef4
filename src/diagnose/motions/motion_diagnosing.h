/// \file
/// The steps of a diagnosis of motions, and what they hand on to each other: motion_diagnosis.cpp searches, and
/// motion_conclusion.cpp says what follows.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "motion_heldout.h"
#include "motion_ordinary.h"
#include "motion_selection.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"

namespace simgap {

/// Of the held-out mean square: what a named cause gains at least.
inline constexpr double kLeastMotionGain = 0.05;
/// Of the error that named causes took: their laws and steps may leave as much.
inline constexpr double kOfNamed = 0.01;

class MotionDiagnosing {
 public:
  MotionDiagnosing(const ArmModel& model, const MotionCalibrationConfig& config, const MotionDiagnosisOptions& options,
                   const DiagnosisProgress& progress)
      : problem_(motionProblem(model, config)), options_(options), progress_(progress) {}
  MotionDiagnosis run(const MotionSet& motions, const MotionSet* held_out);

 private:
  bool faulty(const MotionSet& motions, const MotionSet* held_out);
  void review(MotionSelector& selector);
  void search();
  std::string doubtOfFound(const FoundCause& found) const;
  bool judge(const MotionCauseFit& base, const FoundCause& found);
  bool leavesMore() const;
  void conclude();
  void fillErrors();
  void fillUnexplained(const MotionCauseFit& after, const Eigen::MatrixXd& seen, const Eigen::MatrixXd& unseen);
  void sayWhatIsLeft();
  void withdrawPartial();
  void forgetCauses();
  bool preferOrdinary();
  void nameOrdinary();
  void compareWithExpected(const Eigen::MatrixXd& judging);
  void keepCandidates();
  Eigen::MatrixXd unseenOf(const MotionCauseFit& fit) const {
    return unseenSquares(fit, fit.here().z, problem_, split_.judging.motions);
  }

  MotionProblem problem_;
  const MotionDiagnosisOptions& options_;
  const DiagnosisProgress& progress_;
  MotionSplit split_;
  std::vector<ArmHypothesis> hypotheses_;
  std::unique_ptr<MotionCauseFit> plain_, last_;  // last_: with all named causes, null without any
  std::vector<FoundCause> found_;                 // named; their fits have moved to last_
  std::vector<MotionCandidate> others_;           // in place of a named cause, and what was not named
  std::optional<OrdinaryShift> shift_;            // named where no cause is
  double explained_of_all_ = 0.0;                 ///< [%] of what the median motion, seen or not, is missed by
  MotionDiagnosis result_;
};

}  // namespace simgap
