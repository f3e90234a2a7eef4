#include "pose_evidence.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "simgap/core/decompositions.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {
namespace {

constexpr double kFlippedAngle = 35.0 * kDegree;  // marker confusion turns a frame by far more than a model errs
constexpr double kFarFromOthers = 4.0;            // times the median distance
constexpr double kAlone = 1.5;                    // times far, and most are not: a reading that was wrong
constexpr double kMostAlone = 0.08;               // of the poses
constexpr double kCopied = 6.0;                   // capture sd between two recordings of a joint that did not move
constexpr double kShouldMove = 12.0 * kDegree;
constexpr double kUnpredictable = 100.0;  // [deg^2] variance of a pose that says nothing of a model
constexpr std::size_t kPoseBins = 5;

/// Positions that the model predicts where the poses were measured; empty where it has none.
std::vector<std::vector<JointPosition>> predictions(const ArmModel& model, std::span<const Pose> poses) {
  EquilibriumArm arm(model);
  std::vector<std::vector<JointPosition>> all;
  for (const Pose& pose : poses) {
    arm.setHistory(pose.time, pose.shafts_before);
    const bool stable = arm.solveFrom(pose.joints, pose.shafts).stable;
    all.push_back(stable ? arm.observe(pose.shafts, pose.shafts_before) : std::vector<JointPosition>{});
  }
  return all;
}

/// Error of a joint [rad], of a slide as it counts beside angles.
double countedError(const Joint& joint, const JointPosition& a, const JointPosition& b) {
  return kindOf(joint.type).counted * jointError(joint.type, a, b);
}

double largest(const ArmModel& model, const std::vector<JointPosition>& a, const std::vector<JointPosition>& b) {
  double angle = 0.0;
  for (std::size_t j = 0; j < a.size(); ++j) angle = std::max(angle, countedError(model.joints[j], a[j], b[j]));
  return angle;
}

/// What gravity and muscles would do to the arm where it was measured [N m].
std::vector<double> torquesAt(const ArmModel& model, std::span<const Pose> poses) {
  PotentialEnergy energy(model);
  std::vector<double> torques;
  for (const Pose& pose : poses) {
    energy.setHistory(pose.time, pose.shafts_before);
    energy.setShafts(pose.shafts);
    energy.evaluate(pose.joints);
    torques.push_back(energy.gradient().norm());
  }
  return torques;
}

DataFault fault(std::span<const Pose> poses, const std::vector<std::size_t>& which, std::string_view what) {
  std::vector<std::string> names;
  for (const std::size_t p : which) names.push_back(poses[p].name);
  return {"pose",
          fmt::format("{} {}: {}", which.size() == 1 ? "pose" : "poses", fmt::join(names, ", "), what),
          which.front() + 1,
          which.back() + 1,
          which.size(),
          false};
}

}  // namespace

std::vector<DataFault> findPoseFaults(PoseFit& fit, double capture_sd, std::vector<bool>& faulty) {
  const std::span<const Pose> poses = fit.posterior().poses();
  const ArmModel model = fit.model();
  const auto predicted = predictions(model, poses);
  std::vector<double> distances, off;
  std::vector<std::size_t> unsolved;
  for (const PoseResidual& residual : fit.posterior().evaluate(fit.z(), false)) {
    if (!residual.valid) unsolved.push_back(distances.size());
    distances.push_back(residual.valid ? residual.error.norm() : 0.0);
  }
  for (std::size_t p = 0; p < poses.size(); ++p) {
    off.push_back(predicted[p].empty() ? 0.0 : largest(model, predicted[p], poses[p].joints));
  }
  const double far = std::max(kRobustScale, kFarFromOthers * upperMedian(distances));
  const double off_usual = kFarFromOthers * upperMedian(off);
  const std::vector<double> torques = torquesAt(model, poses);
  const double pushed = kFarFromOthers * upperMedian(torques);  // no model is wrong by that
  faulty.assign(poses.size(), false);
  std::vector<std::size_t> flipped, soft, stuck, alone;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (distances[p] < far) continue;
    const bool copied = p > 0 && largest(model, poses[p].joints, poses[p - 1].joints) < kCopied * capture_sd;
    const bool moved = p > 0 && !predicted[p].empty() && !predicted[p - 1].empty() &&
                       largest(model, predicted[p], predicted[p - 1]) > kShouldMove;
    if (copied && moved) {
      stuck.push_back(p);
    } else if (off[p] > std::max(kFlippedAngle, off_usual)) {
      (torques[p] > pushed ? flipped : soft).push_back(p);
    } else {
      if (distances[p] > kAlone * far) alone.push_back(p);
      continue;
    }
    faulty[p] = true;
  }
  // More than a few are no readings that were wrong: something is missing that acts in these poses.
  if (static_cast<double>(alone.size()) > std::max(1.0, kMostAlone * static_cast<double>(poses.size()))) alone.clear();
  for (const std::size_t p : alone) faulty[p] = true;
  for (const std::size_t p : unsolved) faulty[p] = true;
  std::vector<DataFault> faults;
  const auto add = [&](const std::vector<std::size_t>& which, std::string_view what, bool left_out) {
    if (which.empty()) return;
    faults.push_back(fault(poses, which, what));
    faults.back().corrected = left_out;
  };
  add(unsolved, "the model has no equilibrium near it, so it is left out", true);
  add(alone,
      fmt::format("more than {:.0f} times as far from the model as half of the others are, and alone in that; left out",
                  kAlone * kFarFromOthers),
      true);
  add(soft,
      "hardly anything holds the arm where the model rests at this command, so that small errors carry it far; left "
      "out",
      true);
  add(flipped,
      "turned far from where this model can be, as when markers are confused, or something strong is missing in the "
      "model; record them anew: if they come back, look for that, else leave them out",
      false);
  add(stuck, "the same joint positions as in the pose before though the shafts moved; the capture was stuck", false);
  return faults;
}

std::vector<bool> posesWithoutRest(const PoseFit& fit, std::span<const Pose> poses) {
  std::vector<bool> without;
  for (const auto& predicted : predictions(fit.model(), poses)) without.push_back(predicted.empty());
  return without;
}

std::vector<double> squaredErrors(const ArmModel& model, std::span<const Pose> poses) {
  const auto predicted = predictions(model, poses);
  std::vector<double> errors;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    double sum = 0.0;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const double error =
          predicted[p].empty() ? M_PI : countedError(model.joints[j], predicted[p][j], poses[p].joints[j]);
      sum += toDegrees(error) * toDegrees(error);
    }
    errors.push_back(sum / static_cast<double>(model.joints.size()));
  }
  return errors;
}

namespace {

/// What turns an error of the joints' coordinates into one of angles, shape (dof): 1, of a slide what it counts.
Eigen::VectorXd countedUnits(const ArmModel& model, Eigen::Index dof) {
  Eigen::VectorXd units = Eigen::VectorXd::Ones(dof);
  Eigen::Index d = 0;
  for (const Joint& joint : model.joints) {
    units.segment(d, joint.degreesOfFreedom()).setConstant(kindOf(joint.type).counted);
    d += joint.degreesOfFreedom();
  }
  return units;
}

/// Variance of each pose, mean over the joints [deg^2].
std::vector<double> variances(PosePosterior& posterior) {
  std::vector<double> all;
  const Eigen::VectorXd units = countedUnits(posterior.model(), posterior.degreesOfFreedom());
  for (std::size_t p = 0; p < posterior.poses().size(); ++p) {
    const Eigen::MatrixXd root = units.asDiagonal() * inverse(posterior.whitening(p));
    all.push_back((root * root.transpose()).trace() /
                  (kDegree * kDegree * static_cast<double>(posterior.model().joints.size())));
  }
  return all;
}

}  // namespace

PoseErrors::PoseErrors(const PoseProblem& problem, PoseFit& fit, std::span<const Pose> poses) : poses_(poses) {
  PoseFit there(problem, poses, fit.causes());
  there.posterior().whiten(fit.z());
  variances_ = variances(there.posterior());
  const Eigen::LLT<Eigen::MatrixXd> curvature(fit.curvature());
  const std::vector<PoseResidual>& residuals = there.posterior().evaluate(fit.z(), true);
  const Eigen::VectorXd units = countedUnits(there.posterior().model(), there.posterior().degreesOfFreedom());
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (!residuals[p].valid) variances_[p] = std::numeric_limits<double>::infinity();
    if (!residuals[p].valid) continue;
    const Eigen::MatrixXd jacobian =
        units.asDiagonal() * inverse(there.posterior().whitening(p)) * residuals[p].jacobian;
    variances_[p] += curvature.matrixL().solve(jacobian.transpose()).squaredNorm() /
                     (kDegree * kDegree * static_cast<double>(there.posterior().model().joints.size()));
  }
  double precision = 0.0;
  for (const double variance : variances_) {
    if (variance > kUnpredictable) continue;
    precision += 1.0 / variance;
    ++counted_;
  }
  typical_ = counted_ > 0 ? static_cast<double>(counted_) / precision : 0.0;
}

Eigen::ArrayXd PoseErrors::of(const ArmModel& model) const {
  const std::vector<double> squared = squaredErrors(model, poses_);
  Eigen::ArrayXd errors(static_cast<Eigen::Index>(counted_));
  Eigen::Index at = 0;
  for (std::size_t p = 0; p < squared.size(); ++p) {
    if (variances_[p] <= kUnpredictable) errors[at++] = typical_ * robustLoss(squared[p] / variances_[p]);
  }
  return errors;
}

double poseNoiseFloor(PoseFit& fit) {
  double precision = 0.0;
  const std::vector<double> all = variances(fit.posterior());
  for (const double variance : all) precision += 1.0 / variance;
  return static_cast<double>(all.size()) / precision;
}

namespace {

/// What is known of every pose beside its error.
struct PoseChannels {
  std::vector<std::string> names;
  Eigen::MatrixXd values;    ///< shape (poses, channels)
  Eigen::MatrixXd errors;    ///< shape (poses, dof), not whitened [rad], of slides [m]
  Eigen::MatrixXd whitened;  ///< shape (poses, dof)
  Eigen::MatrixXd missing;   ///< tension that would close the gap, shape (poses, muscles) [N]
};

PoseChannels channelsOf(PoseFit& fit) {
  const std::span<const Pose> poses = fit.posterior().poses();
  const ArmModel model = fit.model();
  PotentialEnergy energy(model);
  const auto n = std::ssize(poses);
  const int dof = fit.posterior().degreesOfFreedom();
  const auto muscles = std::ssize(model.muscles);
  PoseChannels channels;
  channels.names.push_back(std::isnan(poses.front().time) ? "pose order" : "time_s");
  for (const Joint& joint : model.joints) channels.names.push_back("joint " + joint.name);
  for (const Muscle& muscle : model.muscles) channels.names.push_back("tension " + muscle.name);
  channels.values.resize(n, std::ssize(channels.names));
  channels.errors.resize(n, dof);
  channels.whitened.resize(n, dof);
  channels.missing.resize(n, muscles);
  const std::vector<PoseResidual> residuals = fit.posterior().evaluate(fit.z(), false);
  for (Eigen::Index p = 0; p < n; ++p) {
    const auto at = static_cast<std::size_t>(p);
    const Pose& pose = poses[at];
    channels.whitened.row(p) = residuals[at].error;
    channels.errors.row(p) = inverse(fit.posterior().whitening(at)) * residuals[at].error;
    energy.setHistory(pose.time, pose.shafts_before);
    energy.setShafts(pose.shafts);
    energy.evaluate(pose.joints);
    Eigen::Index c = 0;
    channels.values(p, c++) = std::isnan(pose.time) ? static_cast<double>(p) : pose.time;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      channels.values(p, c++) = model.joints[j].hasAxis()
                                    ? pose.joints[j].angle
                                    : geodesicAngle(pose.joints[j].rotation, Eigen::Quaterniond::Identity());
    }
    // H dq is the torque that is missing at the measured pose; a muscle's lever arms are its shaft's column over k r.
    Eigen::MatrixXd levers(dof, std::ssize(pose.shafts));
    energy.differentiateByShafts(levers);
    const Eigen::VectorXd torque = energy.hessian() * channels.errors.row(p).transpose();
    for (Eigen::Index m = 0; m < muscles; ++m) {
      const Muscle& muscle = model.muscles[m];
      const double tension = energy.tension(static_cast<std::size_t>(m));
      channels.values(p, c++) = tension;
      const Eigen::VectorXd arm = levers.col(m) / (muscle.shock_cord.stiffness * muscle.spindle_radius);
      channels.missing(p, m) = tension > 0.0 ? arm.dot(torque) / std::max(arm.squaredNorm(), 1e-8) : 0.0;
    }
  }
  return channels;
}

/// Mean and half width of its 95 % interval.
std::pair<double, double> meanOf(const Eigen::VectorXd& values, std::span<const std::size_t> rows) {
  double sum = 0.0, squares = 0.0;
  for (const std::size_t r : rows) sum += values[r];
  const auto n = static_cast<double>(rows.size());
  for (const std::size_t r : rows) squares += std::pow(values[r] - sum / n, 2);
  return {sum / n, n > 1.0 ? 1.96 * std::sqrt(squares / (n - 1.0) / n) : 0.0};
}

void addBins(std::vector<EvidenceBin>& bins, const std::string& against, const Eigen::VectorXd& channel,
             const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  std::vector<std::size_t> order(static_cast<std::size_t>(channel.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return channel[i]; });
  for (std::size_t b = 0; b < kPoseBins; ++b) {
    const std::size_t first = b * order.size() / kPoseBins, last = (b + 1) * order.size() / kPoseBins;
    if (first == last) continue;
    const std::span<const std::size_t> rows(order.data() + first, last - first);
    const auto [mean_before, half_before] = meanOf(before, rows);
    const auto [mean_after, half_after] = meanOf(after, rows);
    bins.push_back(
        {against, meanOf(channel, rows).first, mean_before, half_before, mean_after, half_after, rows.size()});
  }
}

}  // namespace

std::vector<EvidenceBin> poseEvidence(PoseFit& before, PoseFit& after) {
  const PoseChannels old = channelsOf(before), now = channelsOf(after);
  const std::vector<Joint>& joints = before.posterior().model().joints;
  std::vector<EvidenceBin> bins;
  const auto errorOf = [&](const PoseChannels& channels, std::size_t joint, Eigen::Index first) {
    return Eigen::VectorXd(channels.errors.middleCols(first, joints[joint].degreesOfFreedom()).rowwise().norm() /
                           kindOf(joints[joint].type).error_size);
  };
  const auto unitOf = [&](Eigen::Index channel) -> std::string {
    return channel == 0 ? "" : fmt::format(" [{}]", kindOf(joints[static_cast<std::size_t>(channel) - 1].type).unit);
  };
  for (Eigen::Index c = 0; c <= std::ssize(joints); ++c) {
    Eigen::Index first = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto at = static_cast<std::size_t>(c);
      addBins(bins,
              fmt::format("error of {} [{}] against {}{}", joints[j].name, kindOf(joints[j].type).error_unit,
                          old.names[at], unitOf(c)),
              old.values.col(c), errorOf(old, j, first), errorOf(now, j, first));
      first += joints[j].degreesOfFreedom();
    }
  }
  for (Eigen::Index m = 0; m < old.missing.cols(); ++m) {
    const Eigen::Index c = 1 + std::ssize(joints) + m;
    addBins(bins, fmt::format("missing tension [N] against {} [N]", old.names[c]), old.values.col(c),
            old.missing.col(m), now.missing.col(m));
  }
  return bins;
}

std::vector<Leftover> poseLeftovers(PoseFit& fit) {
  const PoseChannels channels = channelsOf(fit);
  const Eigen::Index n = channels.values.rows();
  std::vector<Leftover> leftovers;
  if (n < 12) return leftovers;
  for (Eigen::Index c = 0; c < channels.values.cols(); ++c) {
    const Eigen::VectorXd x = channels.values.col(c);
    const double spread = std::sqrt((x.array() - x.mean()).square().mean());
    if (spread < 1e-9) continue;
    Eigen::MatrixXd basis(n, 3);
    basis.col(0).setOnes();
    basis.col(1) = (x.array() - x.mean()) / spread;
    basis.col(2) = basis.col(1).array().square();
    const Eigen::MatrixXd fitted = basis * solveLeastSquares(basis, channels.whitened);
    const double total = channels.whitened.squaredNorm();
    const double explained = fitted.squaredNorm() / total;
    const double by_chance = 3.0 / static_cast<double>(n);
    leftovers.push_back({channels.names[c], (explained - by_chance) / (1.0 - by_chance), {}});
  }
  std::ranges::stable_sort(leftovers, std::greater<>(), &Leftover::share);
  std::erase_if(leftovers, [](const Leftover& leftover) { return leftover.share < 0.05; });
  if (leftovers.size() > 3) leftovers.resize(3);
  return leftovers;
}

}  // namespace simgap
