// Rows of a log of several sessions.
#include "simgap/measure/logs/actuator_rows.h"

#include <gtest/gtest.h>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;

/// Two sessions of ten seconds; the clock of the second one begins anew, or goes on after a pause.
ActuatorRows twoSessions(double second_begins) {
  ActuatorRows rows;
  rows.time.resize(40);
  rows.time << ArrayXd::LinSpaced(20, 0.0, 10.0), ArrayXd::LinSpaced(20, second_begins, second_begins + 10.0);
  rows.session.assign(40, 0);
  std::fill(rows.session.begin() + 20, rows.session.end(), 1);
  rows.elapsed = elapsedOf(rows.time, rows.session);
  return rows;
}

TEST(ActuatorRows, AClockThatBeginsAnewGoesOnWhereTheSessionBeforeEnded) {
  const ActuatorRows rows = twoSessions(0.0);
  EXPECT_EQ(rows.elapsed[19], 10.0);
  EXPECT_EQ(rows.elapsed[20], 10.0);
  EXPECT_EQ(rows.elapsed[39], 20.0);
}

TEST(ActuatorRows, AClockThatGoesOnIsTakenAsItIs) {
  const ActuatorRows rows = twoSessions(100.0);
  EXPECT_TRUE((rows.elapsed == rows.time).all());
}

TEST(ActuatorRows, AChangeOfRegimeIsOneMomentOfTheLogAndNotOneOfEverySession) {
  const ActuatorRows rows = twoSessions(0.0);
  const ActuatorEffect& change = actuator_effects::find("regime-change");
  double last = 0.0;
  for (const std::vector<double>& start : change.starts(rows, {})) last = std::max(last, start[1]);
  EXPECT_GT(last, 15.0);
  Eigen::ArrayXXd column(40, 1);
  change.fill(std::vector<double>{0.0, 15.0}, rows, {}, {}, column);
  EXPECT_EQ(column.topRows(30).sum(), 0.0);
  EXPECT_EQ(column.bottomRows(10).sum(), 10.0);
}

}  // namespace
}  // namespace simgap
