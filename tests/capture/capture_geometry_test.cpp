// The geometry below the capture: lens, triangulation, rigid fit, joint angles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

#include "simgap/capture/joint_angles.h"
#include "support/arms.h"
#include "support/capture_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

// OpenCV's own reader ran out of stack, or asked for 50 GB.
TEST(StereoCameras, RefusesHostileFiles) {
  const std::string good = reality::stereoYaml(kLenses);
  const auto sentence = [](const std::string& text) { return errorOf([&] { readStereo(text, "s.yaml"); }); };
  EXPECT_THAT(sentence("%YAML:1.0\n---\nK1: " + std::string(100'000, '[')), HasSubstr("2: s.yaml:"));
  EXPECT_THAT(sentence(replaced(good, "rows: 3", "rows: 2000000000")), HasSubstr("K1.rows: found 2000000000"));
  EXPECT_THAT(sentence(replaced(good, "rows: 3", "rows: -3")), HasSubstr("K1.rows: found -3"));
  EXPECT_THAT(sentence(replaced(good, "rows: 3", "rows: 4")), HasSubstr("K1.data: found 9 numbers, expected 4 x 3"));
  EXPECT_THAT(sentence(replaced(good, "[ 800,", "[ 1e300,")), HasSubstr("K1.data[0]: found 1e300"));
  EXPECT_THAT(sentence(replaced(good, "[ 800,", "[ .nan,")), HasSubstr("K1.data[0]: found '.nan'"));
  EXPECT_THAT(sentence(replaced(good, "image_width: ", "image_width: -")), HasSubstr("image_width: found -640"));
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
    const double z = uniform(random, 0.8, 1.6), y = uniform(random, -0.2, 0.2), x = uniform(random, -0.3, 0.3);
    const Eigen::Vector3d p(x, y, z);
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

}  // namespace
}  // namespace simgap::test
