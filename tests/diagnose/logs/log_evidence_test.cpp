// What a flexible model may read in the channels, and what it may not.
#include "diagnose/logs/log_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/prepared_logs.h"

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

}  // namespace
}  // namespace simgap::test
