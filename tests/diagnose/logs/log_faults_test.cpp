// Faults put into a log that has none must be found, each as what it is.
#include "diagnose/logs/log_faults.h"

#include <gtest/gtest.h>

#include "prepared_logs.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"

namespace simgap::test {
namespace {

using Eigen::Index;

TEST(LogFaults, NoneInACleanLog) {
  PreparedLog log = preparedLog(smallRig());
  const std::vector<DataFault> faults = findFaults(log);
  EXPECT_TRUE(faults.empty()) << faults[0].sentence;
}

TEST(LogFaults, FindsClippedEffort) {
  PreparedLog log = preparedLog(smallRig());
  log.data.rows.effort = log.data.rows.effort.min(0.5 * log.data.rows.effort.maxCoeff());
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u) << "long clipped stretches are not reported as stuck, too";
  EXPECT_EQ(faults[0].channel, log.effort_column);
  EXPECT_NE(faults[0].sentence.find("saturated"), std::string::npos) << faults[0].sentence;
  EXPECT_GT(faults[0].rows, 20u);
}

/// The grid is as coarse as the noise of a row: what stands at its last level comes there by one count.
TEST(LogFaults, ASpeedThatSettlesOnAGridIsNotSaturated) {
  PreparedLog log = preparedLog(smallRig());
  Eigen::ArrayXd& speed = log.data.rows.speed;
  const double count = 0.05 * speed.maxCoeff(), top = 0.5 * speed.maxCoeff();
  speed = top * (speed / top).tanh();
  speed = count * (speed / count).round();
  const Index standing = (speed == speed.maxCoeff()).count();
  ASSERT_GT(standing, 100);
  const std::vector<DataFault> faults = findFaults(log);
  EXPECT_TRUE(faults.empty()) << faults[0].sentence;
}

TEST(LogFaults, LeavesOutEveryRowAtALimit) {
  PreparedLog log = preparedLog(smallRig());
  const double limit = 0.7 * log.data.rows.effort.maxCoeff();
  log.data.rows.effort = log.data.rows.effort.min(limit);
  const Index beyond = (log.data.rows.effort == limit).count();
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].sentence.find(std::to_string(beyond) + " rows"), std::string::npos)
      << faults[0].sentence << ": rows that noise lifts there alone are clipped, too";
  EXPECT_GT(faults[0].rows, static_cast<std::size_t>(beyond)) << "the rows beside them go with them";
  for (Index i = 0; i < log.data.rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_TRUE(log.data.effort_lost[k] || log.data.rows.effort[i] < limit) << "row " << i;
    EXPECT_FALSE(log.data.effort_lost[k] && log.data.keep[k]) << "row " << i;
  }
}

TEST(LogFaults, FindsAStuckSpeedOnlyWhereTheDriveMoves) {
  PreparedLog log = preparedLog(smallRig());
  Index fastest = 0;
  log.data.rows.speed.segment(100, 2700).abs().maxCoeff(&fastest);
  log.data.rows.speed.segment(100 + fastest, 60) = log.data.rows.speed[100 + fastest];
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].sentence.find("stuck"), std::string::npos) << faults[0].sentence;
  EXPECT_EQ(faults[0].first_row, static_cast<std::size_t>(100 + fastest + 1));
}

TEST(LogFaults, FindsAMirroredEffort) {
  PreparedLog log = preparedLog(smallRig());
  log.data.rows.effort *= -1.0;
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].sentence.find("wrong sign"), std::string::npos) << faults[0].sentence;
}

/// A residual of even size, and a drive that moves fast in one direction.
struct Misfit {
  PreparedLog log = preparedLog(smallRig());
  Eigen::VectorXd residual;
  Misfit() {
    const Index n = log.data.rows.rows();
    log.data.rows.speed = 100.0 * log.dead_band + 1.0;
    log.data.rows.direction = 1.0;
    log.data.keep.assign(static_cast<std::size_t>(n), true);
    residual = Eigen::VectorXd::Constant(n, 0.1);
    for (Index i = 0; i < n; i += 2) residual[i] = -0.1;
  }
};

TEST(LogFaults, TakesOutASpikeThatStandsAlone) {
  Misfit misfit;
  misfit.residual[500] = 5.0;
  const std::vector<DataFault> faults = takeOutSpikes(misfit.log, misfit.residual);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(faults[0].corrected);
  EXPECT_EQ(faults[0].first_row, 501u);
  EXPECT_FALSE(misfit.log.data.keep[500]);
  EXPECT_EQ(std::ranges::count(misfit.log.data.keep, false), 1);
}

TEST(LogFaults, LeavesAMisfitWithNeighboursAlone) {
  Misfit misfit;
  misfit.residual.segment(500, 10).setConstant(5.0);
  EXPECT_TRUE(takeOutSpikes(misfit.log, misfit.residual).empty());
}

TEST(LogFaults, TakesOutAFewThatStandTogether) {
  Misfit misfit;
  misfit.residual.segment(500, 4) << 5.0, -4.0, 6.0, 5.0;
  EXPECT_EQ(takeOutSpikes(misfit.log, misfit.residual).size(), 1u);
  EXPECT_EQ(std::ranges::count(misfit.log.data.keep, false), 4);
}

TEST(LogFaults, TakesOutSlowRowsThatNeitherDirectionExplains) {
  Misfit misfit;
  misfit.log.data.rows.speed.segment(400, 400) = 0.0;
  Eigen::VectorXd flipped = -10.0 * misfit.residual;
  misfit.residual.segment(500, 3).setConstant(5.0);
  misfit.residual.segment(600, 3).setConstant(5.0);
  flipped.segment(500, 3).setConstant(4.0);
  flipped.segment(600, 3).setConstant(-4.0);  // between the two: a direction that is wrong or not yet clear
  EXPECT_EQ(takeOutSpikes(misfit.log, misfit.residual, flipped).size(), 1u);
  EXPECT_FALSE(misfit.log.data.keep[501]);
  EXPECT_TRUE(misfit.log.data.keep[601]);
}

TEST(LogFaults, LeavesAFewAfterATurn) {  // play and bristles leave such bursts
  Misfit misfit;
  misfit.residual.segment(500, 4).setConstant(5.0);
  misfit.log.data.rows.direction.head(494) = -1.0;
  EXPECT_TRUE(takeOutSpikes(misfit.log, misfit.residual).empty());
}

TEST(LogFaults, LeavesAFewBesideARest) {
  Misfit misfit;
  misfit.residual.segment(500, 4).setConstant(5.0);
  misfit.residual.segment(480, 19).setZero();  // rows of a rest do not count
  EXPECT_TRUE(takeOutSpikes(misfit.log, misfit.residual).empty());
}

TEST(LogFaults, TakesOutABeginningThatIsLikeNothingElse) {
  Misfit misfit;
  const auto rows = static_cast<Index>(std::lround(0.2 / misfit.log.data.rows.step));
  misfit.residual.head(rows).setConstant(5.0);
  misfit.residual[1] = 0.1;
  misfit.residual[500] = 5.0;  // stands alone
  const std::vector<DataFault> faults = takeOutSpikes(misfit.log, misfit.residual);
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[1].last_row, static_cast<std::size_t>(rows)) << faults[1].sentence;
  EXPECT_EQ(std::ranges::count(misfit.log.data.keep, false), rows + 1);
}

TEST(LogFaults, LeavesABeginningThatIsLikeOtherMoments) {
  Misfit misfit;
  misfit.residual.head(20).setConstant(5.0);
  misfit.residual.segment(500, 20).setConstant(5.0);
  EXPECT_TRUE(takeOutSpikes(misfit.log, misfit.residual).empty());
}

TEST(LogFaults, ManySpikesDoNotStopADiagnosis) {
  Misfit misfit;
  std::ptrdiff_t spikes = 0;
  for (Index i = 50; i + 50 < misfit.residual.size(); i += 25, ++spikes) misfit.residual[i] = 5.0;
  const std::vector<DataFault> faults = takeOutSpikes(misfit.log, misfit.residual);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(faults[0].corrected);
  EXPECT_EQ(std::ranges::count(misfit.log.data.keep, false), spikes);
}

TEST(LogFaults, TakesOutRowsNearRestBetweenBothDirections) {
  Misfit misfit;
  Eigen::VectorXd flipped = 10.0 * misfit.residual;
  misfit.residual[500] = 5.0;  // far off both ways, on either side
  flipped[500] = -5.0;
  misfit.residual[600] = 5.0;  // the same, but in fast motion
  flipped[600] = -5.0;
  misfit.log.data.rows.speed[500] = 0.0;
  EXPECT_EQ(takeOutUndecided(misfit.log, misfit.residual, flipped), 1u);
  EXPECT_FALSE(misfit.log.data.keep[500]);
  EXPECT_TRUE(misfit.log.data.keep[600]);
}

PreparedLog preparedMuscle(const reality::PamRecord& record) {
  return prepareLog(CsvTable::parse(record.csv(), "log.csv"), {}, ActuatorKind::kPam);
}

TEST(LogFaults, SamplesOfAMuscleThatStandAloneAreLeftOut) {
  reality::PamRecord record = reality::recordPam({}, {});
  EXPECT_TRUE(preparedMuscle(record).spikes.empty());
  record.force[700] += 200.0;
  record.pressure[1900] *= 0.5;
  record.contraction[3000] += 0.1;
  PreparedLog log = preparedMuscle(record);
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 3u);
  for (const DataFault& fault : faults) EXPECT_TRUE(fault.corrected && fault.rows == 1) << fault.sentence;
  for (const std::size_t row : {700u, 1900u, 3000u}) EXPECT_FALSE(log.data.keep[row]);
  EXPECT_EQ(std::ranges::count(log.data.keep, false), 3);
  EXPECT_NEAR(log.data.rows.contraction[3000], record.contraction[2999], 0.01) << "no bristle travels to it and back";
}

TEST(LogFaults, OfAMuscleTheModelSaysWhatStandsAloneToo) {
  PreparedLog log = preparedMuscle(reality::recordPam({}, {}));
  Eigen::VectorXd residual = Eigen::VectorXd::Constant(log.data.rows.rows(), 0.1);
  residual[500] = 5.0;
  EXPECT_EQ(takeOutSpikes(log, residual).size(), 1u);
  EXPECT_FALSE(log.data.keep[500]);
  log.data.rows.timed = false;  // levels: beside one stands another, not the next moment
  residual[600] = 5.0;
  EXPECT_TRUE(takeOutSpikes(log, residual).empty());
}

TEST(LogFaults, FindsAForceOfAMuscleAtItsLimit) {
  reality::PamRecord record = reality::recordPam({}, {});
  PreparedLog clean = preparedMuscle(record);
  EXPECT_TRUE(findFaults(clean).empty());
  const double limit = 0.8 * *std::ranges::max_element(record.force);
  for (double& force : record.force) force = std::min(force, limit);
  PreparedLog log = preparedMuscle(record);
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].channel, "force_N");
  EXPECT_NE(faults[0].sentence.find("saturated"), std::string::npos) << faults[0].sentence;
  for (std::size_t i = 0; i < record.force.size(); ++i) EXPECT_FALSE(log.data.keep[i] && record.force[i] == limit);
}

TEST(LogFaults, FindsACurrentOfAWindingAtItsLimit) {
  reality::MotorBenchLog record = reality::simulateMotor({}, {.current_noise = 0.02, .velocity_noise = 0.2});
  const auto prepared = [&] { return prepareLog(CsvTable::parse(record.csv(), "log.csv"), {}, ActuatorKind::kMotor); };
  PreparedLog clean = prepared();
  EXPECT_TRUE(findFaults(clean).empty()) << "steps hold a voltage as long";
  const double limit = 0.5 * *std::ranges::max_element(record.current);
  for (double& current : record.current) current = std::min(current, limit);
  record.current[900] = 1.5 * limit;  // a spike is no end of the range
  PreparedLog log = prepared();
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].channel, "current_A");
}

TEST(LogFaults, ASensorOfLoadHasALimitAndWeightsHaveNone) {
  PreparedLog weights = preparedLog(smallRig());
  const double size = weights.data.rows.top_load;
  weights.data.rows.load = (weights.data.rows.load > 0.0).select(size, Eigen::ArrayXd::Zero(weights.data.rows.rows()));
  EXPECT_TRUE(findFaults(weights).empty());
  PreparedLog log = preparedLog(smallRig());
  log.data.rows.load = log.data.rows.load.min(0.6 * size);
  const std::vector<DataFault> faults = findFaults(log);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].channel, "external_torque");
}

}  // namespace
}  // namespace simgap::test
