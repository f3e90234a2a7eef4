// The evaluator around the equilibria: threads, skipping, and a solve that takes no memory.
#include <gtest/gtest.h>

#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/evaluator.h"
#include "simulate/allocation_counter.h"
#include "support/arms.h"

#ifdef SIMGAP_COUNTS_ALLOCATIONS
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* malloc(std::size_t size) {  // every allocation of this program, Eigen's too
  ++simgap::test::allocations;
  return __libc_malloc(size);
}
#endif

namespace simgap {
namespace {

std::vector<Pose> examplePoses(const ArmModel& model) {
  return readPoseSet(CsvTable::load(test::dataFile("arm/poses_calibration.csv")), model.poseLayout()).poses;
}

// Models that differ, so that a thread's arm has to change its model.
std::vector<ArmModel> someModels() {
  std::vector<ArmModel> models(7, test::exampleArm());
  for (std::size_t k = 0; k < models.size(); ++k)
    models[k].muscles[k].kite_line_length += 0.003 * static_cast<double>(k);
  return models;
}

TEST(EquilibriumEvaluator, GivesTheSameBitsForAnyNumberOfThreads) {
  const std::vector<ArmModel> models = someModels();
  const std::vector<Pose> poses = examplePoses(models.front());
  const auto one = makeEquilibriumEvaluator(1)->evaluate(models, poses, AfterInvalid::kGoOn);
  const auto four = makeEquilibriumEvaluator(4)->evaluate(models, poses, AfterInvalid::kGoOn);
  ASSERT_EQ(one.size(), models.size() * poses.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].status, PoseStatus::kSteady);
    EXPECT_EQ(one[i].joints[0].rotation.coeffs(), four[i].joints[0].rotation.coeffs()) << i;
    EXPECT_EQ(one[i].joints[1].angle, four[i].joints[1].angle) << i;
    EXPECT_EQ(one[i].cord_expansion, four[i].cord_expansion) << i;
  }
}

TEST(EquilibriumEvaluator, APoseDoesNotDependOnTheOthers) {
  const ArmModel model = test::exampleArm();
  std::vector<Pose> poses = examplePoses(model);
  const auto forward = makeEquilibriumEvaluator(1)->evaluate({&model, 1}, poses, AfterInvalid::kGoOn);
  std::reverse(poses.begin(), poses.end());
  const auto backward = makeEquilibriumEvaluator(1)->evaluate({&model, 1}, poses, AfterInvalid::kGoOn);
  for (std::size_t p = 0; p < poses.size(); ++p) {
    EXPECT_EQ(forward[p].joints[1].angle, backward[poses.size() - 1 - p].joints[1].angle);
  }
}

TEST(EquilibriumEvaluator, SkipsTheRestOfAnIndividualWithoutEquilibrium) {
  // Without muscles a ball joint turns freely about the vertical: no pose of it is an equilibrium that it would keep.
  std::vector<ArmModel> models(2, test::pendulum(JointType::kSpherical));
  const std::vector<Pose> poses(3);
  const auto outcomes = makeEquilibriumEvaluator(1)->evaluate(models, poses, AfterInvalid::kSkipRest);
  for (const std::size_t k : {0u, 3u}) {
    EXPECT_EQ(outcomes[k].status, PoseStatus::kNoEquilibrium);
    EXPECT_EQ(outcomes[k + 1].status, PoseStatus::kSkipped);
    EXPECT_EQ(outcomes[k + 2].status, PoseStatus::kSkipped);
  }
  EXPECT_EQ(toString(PoseStatus::kNoEquilibrium), "no stable equilibrium");
}

TEST(EquilibriumArm, SolvingAndItsSensitivitiesTakeNoMemory) {
#ifdef SIMGAP_COUNTS_ALLOCATIONS
  const ArmModel model = test::exampleArm();
  const std::vector<Pose> poses = examplePoses(model);
  const std::vector<StaticParameter> parameters(99, {StaticParameter::Kind::kAttachment, 8, 1, 2});
  Eigen::MatrixXd columns(4, 99);
  EquilibriumArm arm(model);
  arm.solve(poses.front().shafts);  // the rest is found here, for all poses
  const long before = test::allocations;
  for (const Pose& pose : poses) {
    ASSERT_TRUE(arm.solve(pose.shafts).stable);
    arm.linearise();
    arm.sensitivities(parameters, columns);
  }
  EXPECT_EQ(test::allocations - before, 0);
  ::operator delete(::operator new(8));  // no compiler may leave these calls out
  EXPECT_GT(test::allocations - before, 0) << "the counter counts";
#else
  GTEST_SKIP() << "the sanitizers have an allocator of their own";
#endif
}

}  // namespace
}  // namespace simgap
