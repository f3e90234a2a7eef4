/// \file
/// Something elastic that hangs at the joint and that no sensor sees: a hose, a harness, a spring that carries a
/// weight. The load grows by k (theta - theta_0), by its cube where what is bent folds up, or from theta_0 on where it
/// is slack before. Like a weight it sets the friction, too.
#include "simgap/model/effects/actuator_effect.h"

#include <Eigen/QR>
#include <algorithm>

namespace simgap::actuator_effects::joint_spring {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kJointAngle};
constexpr EffectParameter kParameters[] = {{"k", "Nm_rad", -1e6, 1e6, 0.0, 0.0},
                                           {"theta_0", "rad", -1e9, 1e9, 0.0, 0.0, EffectParameter::Kind::kShape}};
constexpr EffectParameter kBentParameters[] = {
    kParameters[0], {"hardening", "Nm_rad3", -1e6, 1e6, 0.0, 0.0}, kParameters[1]};

using Stretch = Eigen::ArrayXd (*)(const Eigen::ArrayXd&);

Eigen::ArrayXd linear(const Eigen::ArrayXd& s) { return s; }
Eigen::ArrayXd above(const Eigen::ArrayXd& s) { return s.max(0.0); }
Eigen::ArrayXd below(const Eigen::ArrayXd& s) { return s.min(0.0); }

template <Stretch kStretch>
void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.load += p[0] * kStretch(rows.joint_angle - p[1]);
}

void applyBent(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd stretch = rows.joint_angle - p[2];
  terms.load += p[0] * stretch + p[1] * stretch.cube();
}

/// As stiff as gives a twentieth of the largest load, or effort, over the range, from places in it.
template <Stretch kStretch>
std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double low = rows.joint_angle.minCoeff(), span = rows.joint_angle.maxCoeff() - low;
  if (!(span > 0.0)) return {};
  const double size = 0.05 * (rows.top_load > 0.0 ? rows.top_load : rows.effort.abs().maxCoeff());
  const double most = kStretch(Eigen::ArrayXd::Constant(1, span))[0] - kStretch(Eigen::ArrayXd::Constant(1, -span))[0];
  std::vector<std::vector<double>> list;
  for (const double place : {0.25, 0.5, 0.75}) {
    for (const double sign : {-1.0, 1.0}) list.push_back({sign * size / most, low + place * span});
  }
  return list;
}

std::vector<std::vector<double>> bentStarts(const ActuatorRows& rows, const Eigen::ArrayXd& residual) {
  std::vector<std::vector<double>> list;
  for (const std::vector<double>& start : starts<linear>(rows, residual)) list.push_back({start[0], 0.0, start[1]});
  return list;
}

/// A spring that is relaxed far from where the joint ever was only adds a constant effort.
bool isNearby(double angle, const ActuatorRows& rows) {
  const double low = rows.joint_angle.minCoeff(), high = rows.joint_angle.maxCoeff();
  return angle > low - (high - low) && angle < high + (high - low);
}

bool isRelaxedNearby(std::span<const double> p, const ActuatorRows& rows) { return isNearby(p[1], rows); }

/// Whether a bend over the angle is none that the load has: of a pendulum, theta^3 is what a straight line leaves of
/// sin(theta), which is the load but for its inertia, and a spring that bends so only says that the torque per ampere
/// is another.
bool isBentUnlikeTheLoad(const ActuatorRows& rows) {
  constexpr double kOwn = 0.3;  // share of the bend
  if (!(rows.top_load > 0.0)) return true;
  const Eigen::ArrayXd theta = (rows.joint_angle - rows.joint_angle.mean()) / rows.joint_angle.abs().maxCoeff();
  Eigen::MatrixXd x(theta.size(), 4);
  x << Eigen::VectorXd::Ones(theta.size()), theta.matrix(), (rows.load / rows.top_load).matrix(),
      (rows.acceleration / std::max(1e-12, rows.acceleration.abs().maxCoeff())).matrix();
  const Eigen::VectorXd bend = theta.cube().matrix();
  const auto left = [&](Eigen::Index columns) {
    const auto known = x.leftCols(columns);
    return (bend - known * known.householderQr().solve(bend)).norm();
  };
  return left(4) > kOwn * left(2);
}

/// A spring that pulls the less, the further it is stretched, and then the other way, is none.
bool isOneSpring(std::span<const double> p, const ActuatorRows& rows) {
  const double furthest = (rows.joint_angle - p[2]).abs().maxCoeff();
  return isNearby(p[2], rows) && p[0] * (p[0] + 3.0 * p[1] * furthest * furthest) > 0.0 && isBentUnlikeTheLoad(rows);
}

/// One that is taut everywhere is not one-sided; an end of a few rows, where a session begins, is no spring.
bool isSeenSlack(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFewest = 0.02;  // share of the rows
  const double below = (rows.joint_angle < p[1]).cast<double>().mean();
  return below > kFewest && below < 1.0 - kFewest;
}

constexpr ActuatorEffect kUsual = {
    .name = "joint-spring",
    .form = "linear",
    .cause = "something elastic at the joint that no sensor sees: a hose, a harness, a spring",
    .equation = "tau_ext += k (theta - theta_0)",
    .signature =
        "a residual that is a function of the joint angle alone, straight or bent, the same in both directions",
    .source = "catalogue of causes",
    .look_alikes = "joint-gravity where the joint moves little, current-bias, torque-bias",
    .separates = "slow motion over the widest range of joint angles, then again with hoses and cables taken off",
    .parameters = kParameters,
    .needs = kNeeds,
    .of_angle = true,
    .apply = apply<linear>,
    .starts = starts<linear>,
    .counts = isRelaxedNearby,
};

constexpr ActuatorEffect with(std::string_view form, std::string_view equation, decltype(kUsual.apply) apply,
                              decltype(kUsual.starts) starts) {
  ActuatorEffect effect = kUsual;
  effect.form = form;
  effect.equation = equation;
  effect.apply = apply;
  effect.starts = starts;
  effect.counts = isSeenSlack;
  return effect;
}

constexpr ActuatorEffect kBent = [] {
  ActuatorEffect effect =
      with("bent", "tau_ext += k (theta - theta_0) + hardening (theta - theta_0)^3", applyBent, bentStarts);
  effect.parameters = kBentParameters;
  effect.counts = isOneSpring;
  return effect;
}();
constexpr ActuatorEffect kAbove = with("above", "tau_ext += k max(theta - theta_0, 0)", apply<above>, starts<above>);
constexpr ActuatorEffect kBelow = with("below", "tau_ext += k min(theta - theta_0, 0)", apply<below>, starts<below>);
constexpr const ActuatorEffect* kForms[] = {&kBent, &kAbove, &kBelow};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::joint_spring
