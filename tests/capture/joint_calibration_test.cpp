// Joints from the motion of targets that were placed by eye.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "simgap/capture/joint_angles.h"
#include "simgap/capture/rig_calibration.h"
#include "support/arms.h"
#include "support/capture_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

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
    const Eigen::Vector3d axis = randomDirection(random);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(uniform(random, 0.05, 0.17), axis).matrix();
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
  return {"",
          "",
          {},
          {{"shoulder", JointType::kSpherical, 0, 1, x},
           {"elbow", JointType::kRevolute, 1, 2, x, -Eigen::Vector3d::UnitZ()}}};
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
    return calibrateRig(armRig(), motion.targets, motion.frames, options);
  };
  EXPECT_LT(largestMiss(calibrated(0.0).targets), 1e-9);
  const RigCalibration noisy = calibrated(5e-4);  // 0.03 degrees and 0.05 mm per axis
  EXPECT_LT(largestMiss(noisy.targets), 0.5e-3);
  ASSERT_EQ(noisy.bones.size(), 1u);
  EXPECT_NEAR(noisy.bones[0].length, 0.28, 0.2e-3);
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
    return errorOf([&] { calibrateRig(armRig(), motion.targets, motion.frames, {}); });
  };
  EXPECT_THAT(sentence(motionOf(0.05, 1.2, 0, 5e-4)), HasSubstr("3: joint shoulder: the motion spans only"));
  EXPECT_THAT(sentence(motionOf(0.6, 0.05, 0, 5e-4)), HasSubstr("3: joint elbow: the motion spans only"));
  Motion few = motionOf(0.6, 1.2, 0, 5e-4);
  few.frames.resize(5);
  EXPECT_THAT(sentence(few), HasSubstr("3: joint shoulder: both targets were seen in 5 frames"));
}

TEST(JointCalibration, RefusesABallThatIsDeclaredAHinge) {
  const Motion motion = motionOf(0.6, 1.2, 0, 5e-4);
  Rig rig = armRig();
  rig.joints[0].type = JointType::kRevolute;
  EXPECT_THAT(errorOf([&] { calibrateRig(rig, motion.targets, motion.frames, {}); }),
              ::testing::AllOf(HasSubstr("3: joint shoulder: its target turns by"), HasSubstr("about a second axis")));
}

/// A hand's tree: a thumb on a ball and a finger of two hinges across each other, whose targets were placed by eye.
class HandCalibration : public ::testing::Test {
 protected:
  HandCalibration() {
    std::mt19937 random(11);
    motion_.targets.marker_radius = 0.004;
    for (const char* name : {"palm", "thumb", "finger", "tip"}) {
      MarkerTarget target{name, name, {}};
      const Eigen::Vector3d axis = randomDirection(random);
      const Eigen::AngleAxisd turn(uniform(random, 0.05, 0.2), axis);
      motion_.bone_in_target.push_back({turn.matrix(), 0.02 * randomDirection(random)});
      for (int m = 0; m < 4; ++m) {
        on_bone_.push_back(0.03 * randomDirection(random));
        target.markers.push_back(motion_.bone_in_target.back() * on_bone_.back());
      }
      motion_.targets.targets.push_back(target);
    }
    const Eigen::Vector3d y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    rig_.joints = {{"tip", JointType::kRevolute, 2, 3, z},  // the tree's order is not the file's
                   {"thumb", JointType::kSpherical, 0, 1, z},
                   {"finger", JointType::kRevolute, 0, 2, y}};
    for (int f = 0; f < 150; ++f) move(f, f < 10 ? 0.0 : 1.0, random);
    options_.zero_first = 0;
    options_.zero_last = 9;
  }

  void move(int number, double part, std::mt19937& random) {
    std::vector<TargetPose> bones(4);
    bones[0] = {Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).matrix(), {0.1, 0.0, 1.0}};
    const auto carry = [&](int parent, const Eigen::Vector3d& at, const Eigen::AngleAxisd& turn) {
      return TargetPose{bones[parent].rotation * turn.matrix(), bones[parent] * at};
    };
    const Eigen::Vector3d axis = randomDirection(random);
    const Eigen::AngleAxisd thumb(part * uniform(random, -0.7, 0.7), axis);
    bones[1] = carry(0, Eigen::Vector3d::Zero(), thumb);
    bones[2] = carry(0, {0.1, 0.0, 0.05}, {part * uniform(random, -0.2, 1.2), Eigen::Vector3d::UnitY()});
    bones[3] = carry(2, {0.03, 0.08, 0.0}, {part * uniform(random, -0.9, 0.1), Eigen::Vector3d::UnitZ()});
    MotionFrame frame{number, {}};
    for (std::size_t t = 0; t < 4; ++t) {
      const TargetPose& b = motion_.bone_in_target[t];
      const Eigen::Matrix3d rotation = bones[t].rotation * b.rotation.transpose();
      frame.targets.push_back(TargetPose{rotation, bones[t].origin - rotation * b.origin});
    }
    motion_.frames.push_back(frame);
  }

  Motion motion_;
  Rig rig_;
  JointCalibrationOptions options_;
  std::vector<Eigen::Vector3d> on_bone_;  ///< markers in the bones' frames, target by target
};

TEST_F(HandCalibration, FindsTheBonesOfATree) {
  const RigCalibration found = calibrateRig(rig_, motion_.targets, motion_.frames, options_);
  for (std::size_t i = 0; i < on_bone_.size(); ++i) {
    EXPECT_LT((found.targets.targets[i / 4].markers[i % 4] - on_bone_[i]).norm(), 1e-9);
  }
  ASSERT_EQ(found.bones.size(), 1u);
  EXPECT_EQ(found.bones[0].from + " " + found.bones[0].to, "finger tip");
  EXPECT_NEAR(found.bones[0].length, std::hypot(0.03, 0.08), 1e-9);
}

/// A carriage on a rail that a hinge carries, with a hinge of its own: targets placed by eye.
class SlideCalibration : public ::testing::Test {
 protected:
  static constexpr double kZero = 0.12;  // [m] along the rail, from the arm's origin
  SlideCalibration() {
    motion_.targets.marker_radius = 0.004;
    for (const char* name : {"base", "arm", "carriage", "hand"}) {
      const Eigen::Vector3d axis = randomDirection(random_);
      const Eigen::AngleAxisd turn(uniform(random_, 0.05, 0.2), axis);
      motion_.bone_in_target.push_back({turn.matrix(), 0.02 * randomDirection(random_)});
      MarkerTarget target{name, name, {}};
      for (int m = 0; m < 4; ++m) {
        target.markers.push_back(motion_.bone_in_target.back() * (0.03 * randomDirection(random_)));
      }
      motion_.targets.targets.push_back(target);
    }
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
    rig_.joints = {{"turn", JointType::kRevolute, 0, 1, z},
                   {"rail", JointType::kPrismatic, 1, 2, x},
                   {"wrist", JointType::kRevolute, 2, 3, z}};
    options_.zero_first = 0;
    options_.zero_last = 9;
  }

  /// \param way  of the carriage beyond its zero [m]; noise of origins [m]
  MotionFrame frame(int number, double turn, double way, double wrist, double noise = 0.0) {
    std::normal_distribution<double> normal(0.0, noise);
    std::vector<TargetPose> bones(4);
    bones[0] = {Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).matrix(), {0.1, 0.0, 1.0}};
    const auto carry = [](const TargetPose& parent, const Eigen::Vector3d& at, double angle) {
      return TargetPose{parent.rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).matrix(), parent * at};
    };
    bones[1] = carry(bones[0], {0.0, 0.0, 0.0}, turn);
    bones[2] = carry(bones[1], {kZero + way, 0.05, 0.02}, 0.0);
    bones[3] = carry(bones[2], {0.04, 0.0, 0.01}, wrist);
    MotionFrame seen{number, {}};
    for (std::size_t t = 0; t < 4; ++t) {
      const TargetPose& b = motion_.bone_in_target[t];
      const Eigen::Matrix3d rotation = bones[t].rotation * b.rotation.transpose();
      Eigen::Vector3d jitter = Eigen::Vector3d::Zero();
      for (int i = 2; noise > 0.0 && i >= 0; --i) jitter[i] = normal(random_);
      seen.targets.push_back(TargetPose{rotation, bones[t].origin - rotation * b.origin + jitter});
    }
    return seen;
  }
  void record(double noise, double reach = 0.1) {
    for (int f = 0; f < 150; ++f) {
      const double part = f < 10 ? 0.0 : 1.0;
      const double hand = uniform(random_, -1.0, 0.4), way = uniform(random_, -reach, reach);
      motion_.frames.push_back(frame(f, part * uniform(random_, -0.6, 0.9), part * way, part * hand, noise));
    }
  }
  /// What a capture reads on the calibrated rig.
  JointSample read(const RigCalibration& found, const MotionFrame& seen) {
    Rig rig = rig_;
    for (std::size_t j = 0; j < 3; ++j) rig.joints[j].zero = found.zeros[j];
    std::vector<TargetFrame> frames(4);
    for (std::size_t t = 0; t < 4; ++t) {  // the bone's frame, from where the calibration puts the markers
      std::vector<Eigen::Vector3d> points;
      for (const Eigen::Vector3d& m : motion_.targets.targets[t].markers) points.push_back(*seen.targets[t] * m);
      frames[t].found = true;
      frames[t].pose = umeyama(found.targets.targets[t].markers, points);
    }
    return *jointAngles(rig, frames, 0, 0.0);
  }

  std::mt19937 random_{5};
  Motion motion_;
  Rig rig_;
  JointCalibrationOptions options_;
};

TEST_F(SlideCalibration, ReadsTheWayOfACarriageOnATurningArm) {
  record(0.0);
  const RigCalibration found = calibrateRig(rig_, motion_.targets, motion_.frames, options_);
  EXPECT_GT(found.joints[1].range, 0.15);
  for (const auto& [turn, way, wrist] : {std::array{0.3, 0.07, -0.5}, std::array{-0.4, -0.05, 0.3}}) {
    const JointSample sample = read(found, frame(999, turn, way, wrist));
    EXPECT_NEAR(sample.joints[0].angle, turn, 1e-9);
    EXPECT_NEAR(sample.joints[1].angle, way, 1e-9);
    EXPECT_NEAR(sample.joints[2].angle, wrist, 1e-9);
    for (const double off : sample.off_axis) EXPECT_LT(off, 1e-7);
  }
}

TEST_F(SlideCalibration, AxisSdIsOfTheOrderOfTheError) {
  record(5e-4);
  const RigCalibration found = calibrateRig(rig_, motion_.targets, motion_.frames, options_);
  const FunctionalJoint& rail = found.joints[1];
  const Eigen::Vector3d truth = motion_.bone_in_target[1].rotation * Eigen::Vector3d::UnitX();
  const double error = std::acos(std::min(1.0, rail.axis_in_parent.dot(truth)));
  EXPECT_LT(error, 4.0 * rail.axis_sd);
  EXPECT_GT(error, 0.05 * rail.axis_sd);
  EXPECT_NEAR(read(found, frame(999, 0.3, 0.07, -0.5)).joints[1].angle, 0.07, 1e-3);
}

TEST_F(SlideCalibration, RefusesAShortWayAndATargetThatTurns) {
  const auto sentence = [&] { return errorOf([&] { calibrateRig(rig_, motion_.targets, motion_.frames, options_); }); };
  record(0.0, 0.01);
  EXPECT_THAT(sentence(), HasSubstr("3: joint rail: the motion spans only"));
  EXPECT_THAT(sentence(), HasSubstr("mm along its axis, expected at least 35.0 mm"));
  rig_.joints[2].type = JointType::kPrismatic;
  EXPECT_THAT(sentence(), HasSubstr("expected"));
  motion_.frames.clear();
  record(0.0);
  EXPECT_THAT(sentence(), HasSubstr("3: joint wrist: its target turns by"));
}

TEST_F(HandCalibration, RefusesWhatIsNoTree) {
  const auto sentence = [&] { return errorOf([&] { calibrateRig(rig_, motion_.targets, motion_.frames, options_); }); };
  rig_.joints[1].child = 3;
  EXPECT_THAT(sentence(), HasSubstr("joints tip and thumb of the rig move the same target"));
  rig_.joints[1].child = 0;
  rig_.joints[1].parent = 3;
  EXPECT_THAT(sentence(), HasSubstr("the joints of the rig close a loop"));
  rig_.joints.clear();
  EXPECT_THAT(sentence(), HasSubstr("found no joint in the rig"));
}

}  // namespace
}  // namespace simgap::test
