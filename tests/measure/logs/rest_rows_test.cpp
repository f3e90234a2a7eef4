// Rows beside a rest, of an acceleration that was worked out from positions: those that count are right.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simgap/measure/logs/friction_rows.h"
#include "support/current_log.h"

namespace simgap {
namespace {

constexpr double kPush = 5.0;  // [rad/s^2]: begins and ends at once, as where a drive breaks away and sticks

struct Stroke {
  std::vector<double> time, angle, acceleration, since_rest;  ///< the last to the nearer end of the motion, 0 at rest
};

/// Rests of 1 s between strokes of 1.4 s, forth and back, at 50 Hz.
Stroke strokes() {
  Stroke s;
  double from = 0.0;
  for (int stroke = 0; stroke < 20; ++stroke) {
    const double way = stroke % 2 == 0 ? 1.0 : -1.0;
    for (int i = 0; i < 120; ++i) {
      const double t = 0.02 * i - 1.0, left = 1.4 - t, up = std::clamp(t, 0.0, 0.4),
                   down = std::clamp(t - 1.0, 0.0, 0.4);
      const double even = std::clamp(t - 0.4, 0.0, 1.0);
      s.time.push_back(0.02 * static_cast<double>(s.time.size()));
      s.angle.push_back(from + way * kPush * (0.5 * up * up + 0.4 * even - 0.5 * down * down));
      const bool rests = t <= 0.0;
      s.acceleration.push_back(rests ? 0.0 : t < 0.4 ? way * kPush : t > 1.0 ? -way * kPush : 0.0);
      s.since_rest.push_back(rests ? 0.0 : std::min(t, left));
    }
    from += way * kPush * (0.08 + 0.4 - 0.08);
  }
  for (double& q : s.angle) q = 1e-4 * std::round(q / 1e-4);
  return s;
}

TEST(RestRows, AccelerationsThatCountAreRightBesideThem) {
  const Stroke s = strokes();
  ActuatorLog log = test::currentLog("log.csv");
  log.time = s.time, log.position = s.angle;
  log.session.assign(s.time.size(), 0), log.session_names = {"0"};
  for (std::size_t i = 0; i < s.time.size(); ++i) log.effort.push_back(1.0 + 0.5 * std::sin(0.013 * double(i)));
  Bench bench;
  bench.load = BenchLoad::kFreeAxis;
  bench.inertia = {0.0, true};
  bench.bandwidth = 8.0;
  FrictionDataOptions options;
  options.all_rows = true;
  const FrictionData data = prepareFrictionData(log, bench, options);
  int counted = 0, blurred = 0;
  for (std::size_t i = 0; i < s.time.size(); ++i) {
    if (s.since_rest[i] > 0.28) continue;                              // beyond, the push ends
    if (s.time[i] < 1.5 || s.time[i] > s.time.back() - 0.5) continue;  // nor is there a rest at the ends of the log
    const double error = std::abs(data.load_per(static_cast<Eigen::Index>(i), 0) - s.acceleration[i]);
    if (data.keep[i]) {
      EXPECT_LT(error, 0.1 * kPush) << "at " << s.time[i] << ", " << s.since_rest[i] << " s from a rest";
      ++counted;
    } else {
      blurred += error > 0.1 * kPush ? 1 : 0;
    }
  }
  EXPECT_GT(counted, 100);
  EXPECT_GT(blurred, 40);  // there were such rows
}

}  // namespace
}  // namespace simgap
