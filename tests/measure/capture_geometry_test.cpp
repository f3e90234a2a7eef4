// The geometry below the capture: lens, triangulation, rigid fit, joints, targets; and its judgement of itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

#include "simgap/measure/capture/capture_statistics.h"
#include "simgap/measure/capture/joint_angles.h"
#include "simgap/measure/capture/joint_calibration.h"
#include "simgap/measure/capture/steady_poses.h"
#include "simgap/measure/capture/target_check.h"
#include "support/arms.h"
#include "support/capture_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const reality::StereoLenses kLenses = reality::standardLenses();

std::vector<Eigen::Vector3d> humerusMarkers() { return reality::standardTargets()[1].markers; }

Eigen::Vector2d imageOf(const Eigen::Vector3d& p) { return {p.x() / p.z(), p.y() / p.z()}; }

Eigen::Vector2d randomPlane(std::mt19937& random) {
  const double x = uniform(random, -1, 1);
  return {x, uniform(random, -1, 1)};
}

TEST(StereoCameras, WritesWhatItReads) {
  const StereoCameras cameras = camerasOf(kLenses);
  const StereoCameras again = readStereo(writeStereo(cameras, {"a comment"}), "again.yaml");
  EXPECT_EQ(again.size, cameras.size);
  EXPECT_EQ(again.left.K, cameras.left.K);
  EXPECT_EQ(again.right.distortion, cameras.right.distortion);
  EXPECT_TRUE(again.rotation.isApprox(cameras.rotation, 1e-15));
  EXPECT_EQ(again.translation, cameras.translation);
}

TEST(StereoCameras, TakesTheNamesOfOtherPrograms) {
  const std::string text = replaced(replaced(reality::stereoYaml(kLenses), "K1:", "M1:"), "K2:", "cameraMatrix2:");
  EXPECT_EQ(readStereo(text, "a.yaml").left.K, camerasOf(kLenses).left.K);
}

TEST(StereoCameras, SaysWhatIsWrongWithAFile) {
  const std::string good = reality::stereoYaml(kLenses);
  const auto sentence = [](const std::string& text) { return errorOf([&] { readStereo(text, "s.yaml"); }); };
  EXPECT_THAT(sentence("nothing"), HasSubstr("2: s.yaml: found no OpenCV file storage"));
  EXPECT_THAT(sentence(replaced(good, "K1:", "Q1:")), HasSubstr("2: s.yaml: K1 is missing"));
  EXPECT_THAT(sentence(replaced(good, "R:", "Q:")), HasSubstr("2: s.yaml: R is missing"));
  EXPECT_THAT(sentence(replaced(good, "[ 800,", "[ -800,")), HasSubstr("K1: found focal lengths -800"));
  reality::StereoLenses skewed = kLenses;
  skewed.rotation(0, 0) += 0.01;
  EXPECT_THAT(sentence(reality::stereoYaml(skewed)), HasSubstr("found no rotation"));
}

TEST(StereoCameras, UndistortionAgreesWithTheLens) {
  const StereoCameras cameras = camerasOf(kLenses);
  std::vector<cv::Point2d> normalized;
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(2, 3), Eigen::Vector2d(637, 470), Eigen::Vector2d(320, 10)}) {
    undistort(cameras.left, {{pixel.x(), pixel.y()}}, normalized);
    const Eigen::Vector3d ray = kLenses.left.ray(pixel);
    EXPECT_NEAR(normalized[0].x, ray.x(), 1e-10);
    EXPECT_NEAR(normalized[0].y, ray.y(), 1e-10);
  }
}

TEST(Triangulation, MovesNoisyImagesToTheNearestPairOnEpipolarLines) {
  const StereoCameras cameras = camerasOf(kLenses);
  const Eigen::Matrix3d e = cameras.essential();
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p(uniform(random, -0.3, 0.3), uniform(random, -0.2, 0.2), uniform(random, 0.8, 1.6));
    const Eigen::Vector2d noisy_left = imageOf(p) + 2e-3 * randomPlane(random);
    const Eigen::Vector2d noisy_right =
        imageOf(cameras.rotation * p + cameras.translation) + 2e-3 * randomPlane(random);
    Eigen::Vector2d left = noisy_left, right = noisy_right;
    correctToEpipolar(e, left, right);
    EXPECT_NEAR(right.homogeneous().dot(e * left.homogeneous()), 0.0, 1e-12);
    const double moved = (left - noisy_left).squaredNorm() + (right - noisy_right).squaredNorm();
    // No pair nearby on epipolar lines is nearer: shift the left image a little and take the best right one.
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector2d other = left + 1e-5 * Eigen::Vector2d(std::cos(k), std::sin(k));
      const Eigen::Vector3d line = e * other.homogeneous();
      const Eigen::Vector2d foot =
          noisy_right - line.dot(noisy_right.homogeneous()) / line.head<2>().squaredNorm() * line.head<2>();
      EXPECT_GE((other - noisy_left).squaredNorm() + (foot - noisy_right).squaredNorm(), moved * (1.0 - 1e-6));
    }
  }
}

TEST(Triangulation, IsExactWithoutNoiseAndRefusesWhatIsBehind) {
  const StereoCameras cameras = camerasOf(kLenses);
  const double radius = 0.006;
  Triangulator triangulator(cameras, radius, 1.0);
  const Eigen::Vector3d p(0.08, -0.12, 1.2);
  // The centre of a sphere's image: x / (1 - (r / z)^2).
  const auto image = [&](const reality::Lens& lens, const Eigen::Vector3d& q) {
    const double widened = 1.0 / (1.0 - radius * radius / (q.z() * q.z()));
    return Blob{lens.project({q.x() * widened, q.y() * widened, q.z()}), 50.0, 1.0};
  };
  const Eigen::Vector3d q = kLenses.rotation * p + kLenses.translation;
  const auto found = triangulator.candidates({image(kLenses.left, p)}, {image(kLenses.right, q)});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].point - p).norm(), 1e-8);
  EXPECT_NEAR(found[0].epipolar, 0.0, 1e-3);
  // Rays that part meet behind the cameras: the left image far to the left of the right one's.
  Blob wrong = image(kLenses.left, p);
  wrong.centre.x() = 5.0;
  EXPECT_THAT(Triangulator(cameras, radius, 100.0).candidates({wrong}, {image(kLenses.right, q)}), IsEmpty());
}

TEST(RigidFit, UmeyamaFindsTheMotionAndRefusesAMirror) {
  std::mt19937 random(2);
  const auto markers = humerusMarkers();
  const TargetPose truth{randomRotation(random).toRotationMatrix(), {0.1, 0.2, 1.3}};
  std::vector<Eigen::Vector3d> seen, mirrored;
  for (const auto& m : markers) {
    seen.push_back(truth * m);
    mirrored.push_back(truth * Eigen::Vector3d(-m.x(), m.y(), m.z()));
  }
  const TargetPose found = umeyama(markers, seen);
  EXPECT_TRUE(found.rotation.isApprox(truth.rotation, 1e-10));
  EXPECT_LT(fitRms(found, markers, seen), 1e-12);
  const TargetPose wrong = umeyama(markers, mirrored);
  EXPECT_NEAR(wrong.rotation.determinant(), 1.0, 1e-10);
  EXPECT_GT(fitRms(wrong, markers, mirrored), 5e-3);
}

TEST(RigidFit, RefinementHasTheSpreadItsCovarianceSays) {
  const StereoCameras cameras = camerasOf(kLenses);
  const auto markers = humerusMarkers();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const TargetPose truth{randomRotation(random).toRotationMatrix(), {0.0, 0.0, 1.2}};
  constexpr double kSd = 0.05;  // [px]
  constexpr int kTrials = 400;
  double squares = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<PointCandidate> points;
    for (const auto& m : markers) {
      PointCandidate c;
      const Eigen::Vector3d p = truth * m;
      const auto noise = [&](double focal) -> Eigen::Vector2d {
        const double x = normal(random);
        return kSd / focal * Eigen::Vector2d(x, normal(random));
      };
      c.left_image = imageOf(p) + noise(cameras.left.focal());
      c.right_image = imageOf(cameras.rotation * p + cameras.translation) + noise(cameras.right.focal());
      points.push_back(c);
    }
    std::vector<const PointCandidate*> seen;
    for (const auto& c : points) seen.push_back(&c);
    const RefinedPose refined = refinePose(cameras, truth, markers, seen);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(refined.pose.rotation * truth.rotation.transpose()));
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(), refined.pose.origin - truth.origin;
    squares += error.dot((kSd * kSd * refined.cofactor).inverse() * error) / 6.0;
  }
  // Chi-square over its degrees of freedom: 1 within three standard errors, sqrt(2 / (6 * 400)) each.
  EXPECT_NEAR(squares / kTrials, 1.0, 3.0 * std::sqrt(2.0 / (6.0 * kTrials)));
}

TEST(JointAngles, TwistAndSwingOfARotation) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond twist(Eigen::AngleAxisd(-2.5, x));
  EXPECT_NEAR(twistAbout(twist, x).angle, -2.5, 1e-12);
  Eigen::Quaterniond flipped = twist;
  flipped.coeffs() *= -1.0;  // the same rotation
  EXPECT_NEAR(twistAbout(flipped, x).angle, -2.5, 1e-12);
  const Eigen::Quaterniond swung = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()) * twist;
  EXPECT_NEAR(twistAbout(swung, x).angle, -2.5, 1e-12);
  EXPECT_NEAR(twistAbout(swung, x).off_axis, 0.1, 1e-12);
}

// ------------------------------------------------------------------------------------------ wrong calibrations

/// The doubts of a capture that believes `believed`, on images of the true cameras.
CaptureStatistics statisticsWith(const reality::StereoLenses& believed) {
  static const reality::CaptureStage stage(kLenses, reality::standardTargets());
  static const std::vector<reality::RenderedPair> pairs = [] {
    std::vector<reality::RenderedPair> all;
    for (std::uint64_t i = 0; i < 30; ++i) all.push_back(stage.render({reality::randomPose(i)}, {0.0, 3}, i));
    return all;
  }();
  const TargetSet targets = targetsOf(stage.targets());
  const double bar = (stage.targets()[0].markers[0] - stage.targets()[0].markers[3]).norm();
  const Rig rig{"", "", ScaleBar{{0, 0}, {0, 3}, bar}, {}};
  StereoCapture capture(camerasOf(believed), targets);
  CaptureStatistics statistics(camerasOf(believed), targets, rig);
  for (const auto& pair : pairs) {
    capture.forget();
    statistics.add(capture.process(matOf(pair.left), matOf(pair.right)), capture.centroidSd());
  }
  return statistics;
}

TEST(GeometryDoubts, NoneWithTheRightCalibration) {
  const CaptureStatistics statistics = statisticsWith(kLenses);
  EXPECT_THAT(statistics.doubts(), IsEmpty());
  EXPECT_LT(std::abs(statistics.scaleErrorPercent()), 0.02);
}

TEST(GeometryDoubts, AWrongCalibrationThatStillFitsIsCaught) {
  for (const Eigen::Vector3d axis : {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}) {
    for (const double sign : {-1.0, 1.0}) {
      reality::StereoLenses wrong = kLenses;
      wrong.rotation = Eigen::AngleAxisd(sign * 0.6e-3, axis).toRotationMatrix() * kLenses.rotation;
      for (reality::Lens* lens : {&wrong.left, &wrong.right}) {
        lens->fx *= 1.002;
        lens->fy *= 1.002;
      }
      const CaptureStatistics statistics = statisticsWith(wrong);
      SCOPED_TRACE(axis.transpose());
      for (std::size_t t = 0; t < 3; ++t) {
        EXPECT_GE(statistics.found(t), 28u);         // nothing looks wrong …
        EXPECT_LT(statistics.rms(t).rms(), 0.5e-3);  // … by the fit
      }
      const auto doubts = statistics.doubts();
      EXPECT_THAT(doubts, Not(IsEmpty()));
      for (const GeometryFinding& doubt : doubts) std::printf("  %s: %s\n", doubt.name.c_str(), doubt.sentence.c_str());
    }
  }
}

// ------------------------------------------------------------------------------------------- joints, targets

/// A motion of the arm as targets see it whose frames are not those of the bones.
struct Motion {
  TargetSet targets;
  std::vector<TargetPose> bone_in_target;  ///< what the calibration has to find
  std::vector<MotionFrame> frames;
};

Motion motionOf(double shoulder_range, double elbow_range, int zero_frames, double noise) {
  Motion motion;
  motion.targets = targetsOf(reality::standardTargets());
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int t = 0; t < 3; ++t) {
    // Placed by eye: up to 10 degrees and a few centimetres off the bone.
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(uniform(random, 0.05, 0.17), randomDirection(random)).matrix();
    const Eigen::Vector3d shift = 0.03 * randomDirection(random);
    motion.bone_in_target.push_back({turn, shift});
    for (auto& m : motion.targets.targets[std::size_t(t)].markers) m = turn * m + shift;
  }
  for (int f = 0; f < 200; ++f) {
    const bool zero = f < zero_frames;
    const double swing = zero ? 0.0 : uniform(random, -shoulder_range, shoulder_range);
    const Eigen::AngleAxisd shoulder(swing, randomDirection(random));
    const Eigen::AngleAxisd elbow(zero ? 0.0 : uniform(random, 0.1, 0.1 + elbow_range), Eigen::Vector3d::UnitX());
    const TargetPose camera{Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX()).matrix(), {0, 0, 1.2}};
    std::vector<TargetPose> bones{camera, camera, camera};
    bones[1].rotation = camera.rotation * shoulder.toRotationMatrix();
    bones[2].rotation = bones[1].rotation * elbow.toRotationMatrix();
    bones[2].origin = bones[1] * Eigen::Vector3d(0, 0, -0.28);
    MotionFrame frame{f, {}};
    for (std::size_t t = 0; t < 3; ++t) {
      const TargetPose& b = motion.bone_in_target[t];
      Eigen::Vector3d jitter;
      for (double& component : jitter) component = noise * normal(random);
      TargetPose pose;
      pose.rotation = bones[t].rotation * b.rotation.transpose();
      pose.origin = bones[t].origin - pose.rotation * b.origin + 0.1 * jitter;
      if (noise > 0.0) pose.rotation = Eigen::AngleAxisd(jitter.norm(), jitter.normalized()).matrix() * pose.rotation;
      frame.targets.push_back(pose);
    }
    motion.frames.push_back(frame);
  }
  return motion;
}

Rig armRig() {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  return {"", "", {}, {{"shoulder", JointType::kSpherical, 0, 1, x}, {"elbow", JointType::kRevolute, 1, 2, x}}};
}

/// Largest distance of a marker from where it is on its bone [m].
double largestMiss(const TargetSet& found) {
  const TargetSet truth = targetsOf(reality::standardTargets());
  double miss = 0.0;
  for (std::size_t t = 0; t < 3; ++t) {
    for (std::size_t i = 0; i < truth.targets[t].markers.size(); ++i) {
      miss = std::max(miss, (found.targets[t].markers[i] - truth.targets[t].markers[i]).norm());
    }
  }
  return miss;
}

TEST(JointCalibration, FindsBonesBehindBadlyPlacedTargets) {
  JointCalibrationOptions options;
  options.zero_first = 0;
  options.zero_last = 19;
  const auto calibrated = [&](double noise) {
    const Motion motion = motionOf(0.6, 1.2, 20, noise);
    return calibrateArmJoints(armRig(), motion.targets, motion.frames, options);
  };
  EXPECT_LT(largestMiss(calibrated(0.0).targets), 1e-9);
  const ArmJointCalibration noisy = calibrated(5e-4);  // 0.03 degrees and 0.05 mm per axis
  EXPECT_LT(largestMiss(noisy.targets), 0.5e-3);
  EXPECT_NEAR(noisy.upper_arm, 0.28, 0.2e-3);
  EXPECT_TRUE(noisy.zero_pose);
}

TEST(JointCalibration, CentreSdIsOfTheOrderOfTheError) {
  const Motion motion = motionOf(0.6, 1.2, 0, 1e-3);
  const FunctionalJoint joint = calibrateJoint(armRig().joints[0], motion.frames, {});
  const double error = (joint.in_child - motion.bone_in_target[1].origin).norm();
  EXPECT_LT(error, 4.0 * joint.centre_sd);
  EXPECT_GT(error, 0.1 * joint.centre_sd);
}

TEST(JointCalibration, RefusesAMotionThatSaysTooLittle) {
  const auto sentence = [](const Motion& motion) {
    return errorOf([&] { calibrateArmJoints(armRig(), motion.targets, motion.frames, {}); });
  };
  EXPECT_THAT(sentence(motionOf(0.05, 1.2, 0, 5e-4)), HasSubstr("3: joint shoulder: the motion spans only"));
  EXPECT_THAT(sentence(motionOf(0.6, 0.05, 0, 5e-4)), HasSubstr("3: joint elbow: the motion spans only"));
  Motion few = motionOf(0.6, 1.2, 0, 5e-4);
  few.frames.resize(5);
  EXPECT_THAT(sentence(few), HasSubstr("3: joint shoulder: both targets were seen in 5 frames"));
}

TEST(TargetCheck, TheStandardTargetsAreSound) {
  const TargetSetReport report = checkTargets(targetsOf(reality::standardTargets()), 0.2e-3);
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.targets.size(), 3u);
  EXPECT_EQ(report.cross.size(), 3u);
}

TEST(TargetCheck, FindsWhatCanBeConfused) {
  const std::vector<Eigen::Vector3d> isosceles = {{0, 0, 0}, {0.1, 0, 0}, {0.05, 0.08, 0}};
  EXPECT_NEAR(closestLikeness(isosceles, isosceles, 3, true, false).rms, 0.0, 1e-12);  // turned over
  // A chiral target is not its own mirror image, but is that of its mirrored twin.
  const auto chiral = humerusMarkers();
  auto twin = chiral;
  for (auto& m : twin) m.y() = -m.y();
  EXPECT_GT(closestLikeness(chiral, chiral, 5, false, true).rms, 5e-3);
  EXPECT_NEAR(closestLikeness(chiral, twin, 5, false, true).rms, 0.0, 1e-12);
  EXPECT_GT(closestLikeness(chiral, twin, 5, false, false).rms, 5e-3);
  // The same target, moved and renumbered.
  std::mt19937 random(5);
  std::vector<Eigen::Vector3d> moved;
  const Eigen::Quaterniond turn = randomRotation(random);
  for (const std::size_t i : {2, 0, 4, 1, 3}) moved.push_back(turn * chiral[i] + Eigen::Vector3d(1, 2, 3));
  const Likeness same = closestLikeness(chiral, moved, 5, false, false);
  EXPECT_NEAR(same.rms, 0.0, 1e-12);
  EXPECT_EQ(same.taken_for, (std::vector<int>{1, 3, 0, 4, 2}));
}

// ---------------------------------------------------------------------------------------------- steady poses

/// 60 Hz; one revolute joint that rests, moves for 0.2 s, and rests again.
std::vector<JointSample> twoRests() {
  std::vector<JointSample> samples;
  for (int i = 0; i < 60; ++i) {
    JointPosition position;
    position.angle = 0.5 * std::clamp((i - 24) / 12.0, 0.0, 1.0);
    samples.push_back({std::size_t(i), i / 60.0, {position}, {0.0}, {0.0}});
  }
  return samples;
}

const std::vector<CaptureJoint> kElbow = {{"elbow", JointType::kRevolute, 0, 1, Eigen::Vector3d::UnitX()}};

ShaftLog shaftsMovingAt(double start) {
  std::string csv = "time_s,shaft_biceps_rad\n";
  for (int i = 0; i < 100; ++i) {
    csv += std::to_string(i / 100.0) + "," + std::to_string(std::clamp((i / 100.0 - start) / 0.2, 0.0, 1.0)) + "\n";
  }
  return readShaftLog(CsvTable::parse(csv, "shafts.csv"));
}

TEST(SteadyPoses, FindsTheRestsAndWhatTheShaftsDid) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].first_frame, 0u);
  EXPECT_EQ(poses[0].last_frame, 24u);
  EXPECT_EQ(poses[1].first_frame, 36u);
  EXPECT_EQ(poses[1].last_frame, 59u);
  EXPECT_NEAR(poses[1].joints[0].angle, 0.5, 1e-12);
  EXPECT_EQ(joinShafts(poses, shaftsMovingAt(0.4)), 0u);
  EXPECT_NEAR(poses[0].shafts[0], 0.0, 1e-12);
  EXPECT_NEAR(poses[1].shafts[0], 1.0, 1e-12);
  EXPECT_THAT(posesCsv(poses, kElbow, {"biceps"}), HasSubstr("pose,repeat,time_s,shaft_biceps_rad,elbow_rad"));
}

TEST(SteadyPoses, ALogThatEndsEarlyLosesThePoses) {
  std::vector<SteadyPose> poses = findSteadyPoses(twoRests(), kElbow, {});
  ShaftLog log = shaftsMovingAt(0.4);
  log.times.resize(50);
  log.shafts[0].resize(50);
  EXPECT_EQ(joinShafts(poses, log), 1u);
  EXPECT_EQ(poses.size(), 1u);
}

TEST(SteadyPoses, FindsTheLagOfTheJointsBehindTheShafts) {
  const Lag lag = estimateLag(twoRests(), kElbow, shaftsMovingAt(0.3), 0.5);  // the joint starts at 0.4 s
  EXPECT_NEAR(lag.seconds, 0.1, 0.01);
  EXPECT_GT(lag.correlation, 0.9);
}

}  // namespace
}  // namespace simgap::test
