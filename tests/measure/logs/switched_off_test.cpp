// A motor that is switched off while its pendulum swings: its log's 0 V are no voltage. Rows of a simulated hobby servo
// (tests/reality) that falls now and then.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "reality/servo_draws.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap::test {
namespace {

struct Falls {
  reality::ServoDraw draw;
  PreparedLog log;
  std::vector<double> effort;  ///< as it was logged, shape (rows)
};

Falls falls(reality::Mechanism mechanism, double off_every) {
  Falls f{reality::drawServoNone(5, mechanism), {}, {}};
  f.draw.rig.rows = 6000;
  f.draw.rig.off_every = off_every;
  const CsvTable table = CsvTable::parse(reality::recordServo(f.draw.rig, {}).csv(), "log.csv");
  f.log = prepareLog(table, readBench(YamlNode::parse(reality::benchYaml(f.draw.rig), "bench.yaml")),
                     ActuatorKind::kFriction);
  f.effort = table.quantity(f.log.effort_column, "");
  return f;
}

/// Rows that count, with an effort of exactly nothing at a good speed.
std::ptrdiff_t poweredByNothing(const Falls& f) {
  const ActuatorRows& rows = f.log.data.rows;
  std::ptrdiff_t count = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const bool nothing = f.effort[i] == 0.0 && std::abs(rows.speed[i]) > 0.1 * rows.top_speed;
    count += nothing && f.log.data.keep[i] ? 1 : 0;
  }
  return count;
}

/// Volts per speed, by plain least squares of the rows that count.
double voltsPerSpeed(const PreparedLog& log) {
  const ActuatorRows& rows = log.data.rows;
  Eigen::MatrixXd x(rows.rows(), 5);
  x << rows.load, rows.direction, rows.speed, rows.acceleration, Eigen::ArrayXd::Ones(rows.rows());
  Eigen::VectorXd y = rows.effort;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    if (log.data.keep[i]) continue;
    x.row(i).setZero();
    y[i] = 0.0;
  }
  return Eigen::VectorXd(x.colPivHouseholderQr().solve(y))[2];
}

bool saysOff(const PreparedLog& log) {
  return std::ranges::any_of(log.warnings,
                             [](const std::string& w) { return w.find("switched off") != std::string::npos; });
}

TEST(SwitchedOff, RowsOfAVoltageAreLeftOut) {
  Falls f = falls(reality::Mechanism::kVoltageServo, 6.0);
  EXPECT_TRUE(saysOff(f.log));
  const double always_on = voltsPerSpeed(falls(reality::Mechanism::kVoltageServo, 0.0).log);
  EXPECT_NEAR(voltsPerSpeed(f.log), always_on, 0.1 * always_on);
  const ActuatorRows& rows = f.log.data.rows;
  std::ptrdiff_t off = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const bool falls = rows.effort[i] == 0.0 && std::abs(rows.speed[i]) > 0.1 * rows.top_speed;
    off += falls && !f.log.data.keep[i] ? 1 : 0;
    if (falls) f.log.data.keep[i] = true;
  }
  EXPECT_GT(off, 100);
  EXPECT_LT(voltsPerSpeed(f.log), 0.9 * always_on);  // they would bend it: that is the trap
}

TEST(SwitchedOff, RowsOfACurrentCount) {  // no current flows, and that is what the log says
  const Falls f = falls(reality::Mechanism::kPendulum, 6.0);
  EXPECT_FALSE(saysOff(f.log));
  EXPECT_GT(poweredByNothing(f), 100);
}

TEST(SwitchedOff, IsNoServoThatIsOn) {
  const Falls f = falls(reality::Mechanism::kVoltageServo, 0.0);
  EXPECT_FALSE(saysOff(f.log));
}

}  // namespace
}  // namespace simgap::test
