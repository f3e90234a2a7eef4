#include "motion_ordinary.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <string>
#include <vector>

namespace simgap {
namespace {

constexpr double kChance = 0.005;      // that one of all groups moves as far, where nothing is out of the ordinary
constexpr double kAsImprobable = 1.0;  // in standard deviations of the shift: groups that close are not told apart

struct OrdinaryKind {
  std::string_view effect, owners, ending, sentence, separates_by;
};
constexpr std::array kKinds = {
    OrdinaryKind{"joint-viscous", "joints.", ".viscous_friction_Nms", "more or less viscous friction in the joint",
                 "move the joint by the same way slowly and fast"},
    OrdinaryKind{"joint-coulomb", "joints.", ".coulomb_friction_Nm", "more or less dry friction in the joint",
                 "move the joint to and fro by small ways, slowly, at two co-contractions"},
    OrdinaryKind{"cord-damping", "muscles.", ".shock_cord.damping_Ns_m", "more or less damping in the shock cords",
                 "swing the arm freely under tense and under loose cords"}};

/// Parameters of one kind: of one joint or muscle, or of all muscles.
struct Group {
  const OrdinaryKind* kind;
  std::string target;
  std::vector<Eigen::Index> members;
  double shift = 0.0;  ///< of their mean [sd of what chance leaves]
};

std::vector<Group> groupsOf(const MotionCauseFit& fit) {
  std::vector<Group> groups;
  const auto& parameters = fit.posterior().space().parameters();
  for (const OrdinaryKind& kind : kKinds) {
    Group all{&kind, "", {}};
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const std::string& name = parameters[i].name;
      const auto index = static_cast<Eigen::Index>(i);
      if (!name.starts_with(kind.owners) || !name.ends_with(kind.ending) || !fit.posterior().hasPrior(index)) continue;
      const std::size_t begin = kind.owners.size();
      groups.push_back({&kind, name.substr(begin, name.size() - begin - kind.ending.size()), {index}});
      all.members.push_back(index);
    }
    if (kind.owners == "muscles." && all.members.size() > 1) groups.push_back(std::move(all));
  }
  return groups;
}

/// Where the true value is drawn from the prior, a fit's mean varies by what the motions tell: 1 - covariance, in units
/// of the prior.
double shiftOf(const Group& group, const Eigen::VectorXd& z, const Eigen::MatrixXd& known) {
  double sum = 0.0, variance = 0.0;
  for (const Eigen::Index i : group.members) {
    sum += z[i];
    for (const Eigen::Index k : group.members) variance += (i == k ? 1.0 : 0.0) - known(i, k);
  }
  return variance > 0.25 * static_cast<double>(group.members.size()) ? sum / std::sqrt(variance) : 0.0;
}

/// The factor by which the members differ from what was expected, their geometric mean.
Estimate factorOf(const Group& group, const MotionCauseFit& fit, const Eigen::MatrixXd& known) {
  const ScaledParameters& scaled = fit.posterior().parameters();
  const Eigen::Index ordinary = fit.posterior().size() - 1;
  const Eigen::VectorXd z = fit.here().z.head(ordinary);
  const std::vector<double> now = scaled.values(z), expected = scaled.values(Eigen::VectorXd::Zero(ordinary));
  const auto count = static_cast<double>(group.members.size());
  const auto relative = [&](Eigen::Index i) { return scaled.slope(i, z[i]) / now[i]; };
  double log_factor = 0.0, variance = 0.0;
  for (const Eigen::Index i : group.members) {
    log_factor += std::log(now[i] / expected[i]) / count;
    for (const Eigen::Index k : group.members) variance += relative(i) * known(i, k) * relative(k) / (count * count);
  }
  const double half = 1.96 * std::sqrt(std::max(0.0, variance));
  Estimate factor{"factor", "1", std::exp(log_factor)};
  factor.lower95 = std::exp(log_factor - half);
  factor.upper95 = std::exp(log_factor + half);
  return factor;
}

}  // namespace

std::optional<OrdinaryShift> furthestShift(const MotionCauseFit& fit) {
  const Eigen::MatrixXd known = fit.covariance();
  const Eigen::VectorXd& z = fit.here().z;
  std::vector<Group> groups = groupsOf(fit);
  if (groups.empty()) return std::nullopt;
  for (Group& group : groups) group.shift = shiftOf(group, z, known);
  const auto further = [](const Group& a, const Group& b) { return std::abs(a.shift) > std::abs(b.shift); };
  std::ranges::stable_sort(groups, further);
  const Group& first = groups.front();
  const auto count = static_cast<double>(groups.size());
  const double least = boost::math::quantile(boost::math::normal(), 1.0 - 0.5 * kChance / count);
  if (std::abs(first.shift) < least) return std::nullopt;
  OrdinaryShift found{{}, z, first.kind->separates_by};
  found.cause.effect = first.kind->effect;
  found.cause.target = first.target;
  found.cause.sentence = first.kind->sentence;
  found.cause.p_adjusted = std::min(1.0, 2.0 * count * boost::math::cdf(boost::math::normal(), -std::abs(first.shift)));
  found.cause.parameters.push_back(factorOf(first, fit, known));
  for (const Eigen::Index i : first.members) found.back[i] = 0.0;
  for (const Group& other : groups) {
    // One muscle's damping is a part of all muscles', and speaks for them.
    const bool part = other.kind == first.kind && (other.target.empty() || first.target.empty());
    if (&other == &first || part || std::abs(other.shift) < std::max(least, std::abs(first.shift) - kAsImprobable))
      continue;
    found.cause.ambiguous_with.push_back(effectLabel(other.kind->effect, other.target));
  }
  return found;
}

}  // namespace simgap
