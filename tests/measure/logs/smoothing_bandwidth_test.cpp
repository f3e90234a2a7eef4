// Velocity and acceleration from encoders, against the truth and against Savitzky & Golay's filter (1964) with the
// window that suits the truth best, which only somebody who knows the truth can choose.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kMargin = 20;  // one in so many rows, at either end, is not compared

struct Motion {
  std::vector<double> time, position, velocity, acceleration;
};

/// Three sines of 0.15 to 1.35 Hz, with a top speed near `speed` [rad/s], for 20 s.
Motion swinging(double rate, double speed, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  Motion m;
  const auto n = static_cast<std::size_t>(20.0 * rate);
  m.time.resize(n), m.position.resize(n), m.velocity.resize(n), m.acceleration.resize(n);
  for (std::size_t i = 0; i < n; ++i) m.time[i] = static_cast<double>(i) / rate;
  for (int k = 0; k < 3; ++k) {
    const double w = 2.0 * kPi * (0.15 + 1.2 * uniform(random)), phase = 2.0 * kPi * uniform(random);
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = w * m.time[i] + phase;
      m.position[i] += speed / (1.5 * w) * std::sin(angle);
      m.velocity[i] += speed / 1.5 * std::cos(angle);
      m.acceleration[i] -= speed / 1.5 * w * std::sin(angle);
    }
  }
  return m;
}

/// Forth and back at even speed with ramps of 0.4 s, and 0.4 s of rest at either end.
Motion ramping(double rate, double speed) {
  Motion m;
  double position = 0.0, velocity = 0.0;
  for (int i = 0; i < static_cast<int>(20.0 * rate); ++i) {
    const double t = i / rate, phase = std::fmod(t, 2.0), side = std::fmod(t, 4.0) < 2.0 ? 1.0 : -1.0;
    const double acceleration = phase < 0.4                   ? side * speed / 0.4
                                : phase >= 1.2 && phase < 1.6 ? -side * speed / 0.4
                                                              : 0.0;
    m.time.push_back(t);
    m.position.push_back(position);
    m.velocity.push_back(velocity);
    m.acceleration.push_back(acceleration);
    position += velocity / rate + 0.5 * acceleration / (rate * rate);
    velocity += acceleration / rate;
  }
  return m;
}

std::vector<double> rounded(const std::vector<double>& position, double count, double noise) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> read;
  for (const double x : position) read.push_back(count * std::round((x + noise * count * normal(random)) / count));
  return read;
}

double rmsError(const std::vector<double>& found, const std::vector<double>& truth) {
  const std::size_t margin = truth.size() / kMargin;
  double sum = 0.0;
  for (std::size_t i = margin; i + margin < truth.size(); ++i) sum += std::pow(found[i] - truth[i], 2);
  return std::sqrt(sum / static_cast<double>(truth.size() - 2 * margin));
}

/// The derivative of a cubic fitted to 2 half + 1 rows, in their middle.
double savitzkyGolay(const std::vector<double>& values, double rate, int half, int order,
                     const std::vector<double>& truth) {
  Eigen::MatrixXd x(2 * half + 1, 4);
  for (int i = -half; i <= half; ++i) {
    const double at = static_cast<double>(i) / half;
    x.row(i + half) << 1.0, at, at * at, at * at * at;
  }
  const Eigen::VectorXd weights =
      (x.transpose() * x).ldlt().solve(x.transpose()).row(order).transpose() * order * std::pow(rate / half, order);
  std::vector<double> slope(values.size(), 0.0);
  for (std::size_t i = static_cast<std::size_t>(half); i + static_cast<std::size_t>(half) < values.size(); ++i) {
    slope[i] = weights.dot(Eigen::Map<const Eigen::VectorXd>(values.data() + i - half, weights.size()));
  }
  return rmsError(slope, truth);
}

/// Error of ours over that of the best window. \param order  1 or 2: the derivative
double againstTheBestWindow(const Motion& m, const std::vector<double>& read, double rate, int order) {
  const std::vector<double>& truth = order == 1 ? m.velocity : m.acceleration;
  const std::vector<Block> runs = {{0, read.size()}};
  const double bandwidth = smoothingBandwidth(m.time, read, runs, 0.1 * rate);
  std::vector<double> own = smooth(m.time, read, bandwidth);
  for (int k = 0; k < order; ++k) own = differentiate(m.time, own);
  double best = 1e300;
  const int widest = static_cast<int>(read.size() / kMargin) - 1;
  for (int half = 3; half <= widest; half += 1 + half / 8) {
    best = std::min(best, savitzkyGolay(read, rate, half, order, truth));
  }
  return rmsError(own, truth) / best;
}

TEST(SmoothingBandwidth, CoarseEncodersAreDifferentiatedAsWellAsByTheBestWindow) {
  for (const double counts : {512.0, 4096.0, 65536.0}) {
    for (const double speed : {0.3, 3.0}) {
      for (const int order : {1, 2}) {
        SCOPED_TRACE(testing::Message() << counts << " counts, " << speed << " rad/s, derivative " << order);
        const double count = 2.0 * kPi / counts;
        for (const double noise : {0.0, 0.7}) {
          const Motion m = swinging(1000.0, speed, 3);
          EXPECT_LT(againstTheBestWindow(m, rounded(m.position, count, noise), 1000.0, order), 1.2) << noise;
        }
        const Motion ramps = ramping(1000.0, speed);
        EXPECT_LT(againstTheBestWindow(ramps, rounded(ramps.position, count, 0.0), 1000.0, order), 1.2) << "ramps";
      }
    }
  }
}

TEST(SmoothingBandwidth, ATenthOfTheRateWasFarTooMuchForSuchAnEncoder) {
  const Motion m = swinging(1000.0, 0.3, 3);
  const std::vector<double> read = rounded(m.position, 2.0 * kPi / 4096.0, 0.0);
  const std::vector<Block> runs = {{0, read.size()}};
  const auto error = [&](double bandwidth) {
    return rmsError(differentiate(m.time, smooth(m.time, read, bandwidth)), m.velocity);
  };
  EXPECT_GT(error(100.0), 30.0 * error(smoothingBandwidth(m.time, read, runs, 100.0)));
}

TEST(SmoothingBandwidth, StaysAtTheHighestForFewRows) {
  const Motion m = swinging(1000.0, 3.0, 4);
  const std::vector<Block> few = {{0, 20}};
  EXPECT_DOUBLE_EQ(smoothingBandwidth(m.time, rounded(m.position, 0.01, 0.5), few, 100.0), 100.0);
}

TEST(SmoothingBandwidth, StampsThatJitterAndGapsChangeLittle) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  Motion m = swinging(1000.0, 3.0, 6);
  for (double& t : m.time) t += 1e-3 * uniform(random);  // when it is stamped, not when it is read
  std::vector<double> read = rounded(m.position, 2.0 * kPi / 4096.0, 0.0);
  const double even = againstTheBestWindow(swinging(1000.0, 3.0, 6), read, 1000.0, 1);
  EXPECT_LT(againstTheBestWindow(m, read, 1000.0, 1), 1.5 * std::max(even, 1.0));
}

}  // namespace
}  // namespace simgap
