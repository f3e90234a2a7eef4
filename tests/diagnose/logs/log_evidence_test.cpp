// What a flexible model may read in the channels, and what it may not.
#include "diagnose/logs/log_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/prepared_logs.h"
#include "simgap/measure/logs/motion.h"

namespace simgap::test {
namespace {

class LogEvidence : public testing::Test {
 protected:
  LogEvidence() {
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal;
    const Eigen::Index n = log_.data.rows.rows();
    slow_.resize(n), of_sensor_.resize(n), elsewhere_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      slow_[i] = std::sin(0.003 * static_cast<double>(i));
      of_sensor_[i] = normal(random);
      elsewhere_[i] = normal(random);
    }
    log_.context.push_back({"sensor", slow_ + of_sensor_});
  }
  double share(const Eigen::ArrayXd& residual) const {
    return explainable(log_, evidenceChannels(log_), residual.matrix(), 1).share;
  }

  PreparedLog log_ = preparedLog(smallRig(6000));
  Eigen::ArrayXd slow_, of_sensor_, elsewhere_;
};

// V - R i has the noise of i in it, with a minus: a row's own current tells of that row's residual.
TEST_F(LogEvidence, NoiseOfAChannelThatIsInTheModelIsNoStructure) {
  EXPECT_LT(share(elsewhere_ - 0.8 * of_sensor_), 0.02);
}

// What two slips show, a forest that saw one of them knows of the other.
TEST_F(LogEvidence, WhatTwoMomentsShowIsNoStructure) {
  Eigen::ArrayXd residual = elsewhere_;
  const auto slip = [&](Eigen::Index at) {
    log_.context.back().values.segment(at, 60) = 10.0;
    residual.segment(at, 60) += 4.0;
  };
  slip(1000), slip(4000);
  EXPECT_EQ(share(residual), 0.0);
  for (Eigen::Index at = 200; at < 5900; at += 400) slip(at);
  EXPECT_GT(share(residual), 0.2);
}

TEST_F(LogEvidence, WhatAChannelTellsIsSeenThroughItsNoise) { EXPECT_GT(share(elsewhere_ + slow_), 0.1); }

/// An acceleration that was worked out from positions a count of an encoder apart from the truth.
class WorkedOutAcceleration : public LogEvidence {
 protected:
  WorkedOutAcceleration() {
    ActuatorRows& rows = log_.data.rows;
    const double bandwidth = 0.3 / rows.step, w = 0.4 * bandwidth;
    log_.blurred_seconds = 1.0 / bandwidth;
    const Eigen::ArrayXd read = (w * rows.time).sin() + 0.01 * of_sensor_;
    const auto slope = [&](const std::vector<double>& values) { return differentiate(spanOf(rows.time), values); };
    const std::vector<double> twice = slope(slope(smooth(spanOf(rows.time), spanOf(read), bandwidth)));
    rows.acceleration = Eigen::Map<const Eigen::ArrayXd>(twice.data(), std::ssize(twice));
    true_ = -w * w * (w * rows.time).sin();
  }
  double scale(const Eigen::ArrayXd& part) const { return 1.0 / std::sqrt(part.square().mean()); }

  Eigen::ArrayXd true_;
};

// The weight of an inertia times it would be read back from it.
TEST_F(WorkedOutAcceleration, HasNoiseThatIsNoStructure) {
  const Eigen::ArrayXd noise = log_.data.rows.acceleration - true_;
  const Eigen::ArrayXd residual = elsewhere_ + scale(noise) * noise;
  const double smoothed = log_.blurred_seconds;
  log_.blurred_seconds = 0.0;
  EXPECT_GT(share(residual), 0.1);  // the trap
  log_.blurred_seconds = smoothed;
  EXPECT_LT(share(residual), 0.03);
}

TEST_F(WorkedOutAcceleration, ShowsAnInertiaThatIsMissing) { EXPECT_GT(share(elsewhere_ + scale(true_) * true_), 0.3); }

}  // namespace
}  // namespace simgap::test
