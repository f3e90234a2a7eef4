// The descent to the most probable parameters: where it ends, and what it costs.
#include "simgap/fit/poses/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/rig.h"

namespace simgap {
namespace {

class DescentOfARig : public testing::Test {
 protected:
  DescentOfARig()
      : rig_(test::recordRig(3)),
        space_(test::paperParameters(rig_.model)),
        posterior_(rig_.model, rig_.calibration, space_, {}),
        start_(Eigen::VectorXd::Zero(posterior_.parameters().size())) {}

  double objectiveAt(const Eigen::VectorXd& z) { return descendPosterior(posterior_, z, 0).objective; }

  test::RecordedRig rig_;
  ParameterSpace space_;
  PosePosterior posterior_;
  Eigen::VectorXd start_;
};

TEST_F(DescentOfARig, EndsWhereNoDirectionLeadsFurtherDown) {
  const double before = objectiveAt(start_);
  const PosteriorFit fit = descendPosterior(posterior_, start_, 60, 1e-10);
  ASSERT_TRUE(std::isfinite(fit.objective));
  EXPECT_LT(fit.objective, 0.5 * before);
  EXPECT_GT(fit.iterations, 1);
  EXPECT_GE(fit.evaluations, static_cast<long>(fit.iterations * rig_.calibration.size()));
  for (Eigen::Index i = 0; i < fit.z.size(); i += 9) {
    for (const double step : {-0.02, 0.02}) {
      const double beside = objectiveAt(fit.z + step * Eigen::VectorXd::Unit(fit.z.size(), i));
      EXPECT_GT(beside, fit.objective * (1.0 - 1e-6)) << space_.parameters()[i].name;
    }
  }
}

TEST_F(DescentOfARig, StepsThatAreNotAllowedAreNotTaken) {
  const PosteriorFit none = descendPosterior(posterior_, start_, 0);
  EXPECT_EQ(none.z, start_);
  const PosteriorFit two = descendPosterior(posterior_, start_, 2);
  EXPECT_LE(two.iterations, 2);
  EXPECT_LT(two.objective, none.objective);
}

TEST_F(DescentOfARig, BalancedTorquesLeaveTheArmNearItsMeasuredPoses) {
  const Eigen::VectorXd balanced = balanceTorques(posterior_, start_);
  EXPECT_LT(objectiveAt(balanced), objectiveAt(start_));
}

}  // namespace
}  // namespace simgap
