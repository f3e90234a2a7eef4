// What a smoother does where a drive turns is no structure; what goes on elsewhere is.
#include <gtest/gtest.h>

#include <random>

#include "diagnose/logs/log_evidence.h"
#include "diagnose/logs/prepared_logs.h"

namespace simgap::test {
namespace {

class Turns : public testing::Test {
 protected:
  Turns() {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    const ActuatorRows& rows = log_.data.rows;
    noise_.resize(rows.rows());
    for (double& r : noise_) r = normal(random);
    at_turns_ = noise_;
    for (Eigen::Index i = 1; i < rows.rows(); ++i) {
      if (rows.direction[i] == rows.direction[i - 1]) continue;
      for (Eigen::Index k = std::max<Eigen::Index>(0, i - 3); k < std::min(rows.rows(), i + 3); ++k) {
        at_turns_[k] += 3.0 * rows.direction[i];
      }
    }
  }
  double share(const Eigen::VectorXd& residual, double blurred_rows) {
    log_.blurred_seconds = blurred_rows * log_.data.rows.step;
    return explainable(log_, evidenceChannels(log_), residual, 1).share;
  }

  PreparedLog log_ = preparedLog(smallRig(6000));
  Eigen::VectorXd noise_, at_turns_;
};

TEST_F(Turns, AreNoStructureWithinASmoothersReach) {
  EXPECT_GT(share(at_turns_, 0.0), 0.05);  // the channels do show it: that is the trap
  EXPECT_LT(share(at_turns_, 4.0), 0.05);
}

TEST_F(Turns, AreStopsAndStartsToo) {
  const Eigen::ArrayXd& direction = log_.data.rows.direction;
  const double top = log_.data.rows.acceleration.abs().maxCoeff();
  Eigen::VectorXd at_stops = noise_;
  for (Eigen::Index i = 100; i + 13 < at_stops.size(); i += 60) {  // stands for ten rows, then goes on
    if ((direction.segment(i - 10, 24) != direction[i]).any()) continue;
    for (Eigen::Index k = i; k < i + 10; ++k) log_.data.keep[k] = false;
    for (Eigen::Index k = i - 3; k < i + 13; ++k) {  // the smoother's answer to both jumps
      log_.data.rows.acceleration[k] = 10.0 * top * direction[k];
      at_stops[k] += 4.0 * direction[k];
    }
  }
  EXPECT_GT(share(at_stops, 0.0), 0.05);
  EXPECT_LT(share(at_stops, 4.0), 0.05);
}

TEST_F(Turns, LeaveWhatIsElsewhere) {
  const Eigen::VectorXd structure = noise_ + 0.2 * log_.data.rows.speed.matrix();
  const double whole = share(structure, 0.0);
  EXPECT_GT(whole, 0.3);
  EXPECT_NEAR(share(structure, 4.0), whole, 0.1);
}

}  // namespace
}  // namespace simgap::test
