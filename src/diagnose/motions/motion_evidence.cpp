#include "motion_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnose/verdict.h"
#include "motion_candidates.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr double kBin = 0.25;  // [s]

/// Root mean square of a series over a bin, and how many samples it has.
std::pair<double, std::size_t> binned(const ErrorSeries& series, double begin) {
  double squares = 0.0;
  std::size_t samples = 0;
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    if (series.times[i] < begin || series.times[i] >= begin + kBin) continue;
    squares += series.errors[i].squaredNorm();
    ++samples;
  }
  return {samples > 0 ? std::sqrt(squares / static_cast<double>(samples)) : 0.0, samples};
}

}  // namespace

std::string worstMoment(const RecordedMotion& motion, const PlayedMotion& played, const PoseLayout& layout,
                        const MotionNoise& noise) {
  if (!played.valid) return "it cannot be played";
  const ErrorSeries* worst = nullptr;
  ChannelError error{};
  double size = -1.0;
  const std::vector<ErrorSeries> all = errorSeries(motion, played, layout);
  for (const ErrorSeries& series : all) {
    if (series.group == ChannelGroup::kCurrent) continue;  // of which drives leave more than others
    const ChannelError one = summarise(series);
    const bool shaft = series.group == ChannelGroup::kShaft;
    const double in_noise = one.worst_second / (shaft ? noise.shafts : noise.joints[series.item]);
    if (!(in_noise > size)) continue;
    size = in_noise;
    worst = &series;
    error = one;
  }
  if (!worst) return "no joint was measured";
  if (worst->group == ChannelGroup::kShaft) {
    return fmt::format("the shaft of {}, {:.2f} deg in the second from {:.1f} s on", layout.muscles[worst->item],
                       toDegrees(error.worst_second), error.worst_at);
  }
  const JointKind& kind = kindOf(layout.joints[worst->item].type);
  return fmt::format("{}, {:.2f} {} in the second from {:.1f} s on", layout.joints[worst->item].name,
                     kind.shown(error.worst_second), kind.error_unit, error.worst_at);
}

std::vector<EvidenceBin> errorsOverTime(const MotionSet& set, const std::vector<PlayedMotion>& before,
                                        const std::vector<PlayedMotion>& after, const PoseLayout& layout) {
  std::vector<EvidenceBin> bins;
  for (std::size_t m = 0; m < set.motions.size(); ++m) {
    if (!before[m].valid || !after[m].valid) continue;
    const std::vector<ErrorSeries> was = errorSeries(set.motions[m], before[m], layout),
                                   is = errorSeries(set.motions[m], after[m], layout);
    for (std::size_t s = 0; s < was.size(); ++s) {
      if (was[s].group != ChannelGroup::kJoint) continue;
      const JointKind& kind = kindOf(layout.joints[was[s].item].type);
      const std::string against = fmt::format("error of {} [{}] against time in {}", layout.joints[was[s].item].name,
                                              kind.error_unit, set.motions[m].name);
      for (double begin = was[s].times.front(); begin < was[s].times.back(); begin += kBin) {
        const auto [old_error, samples] = binned(was[s], begin);
        const auto [new_error, same] = binned(is[s], begin);
        if (samples == 0) continue;
        const double root = std::sqrt(2.0 * static_cast<double>(samples));
        bins.push_back({against, begin + 0.5 * kBin, kind.shown(old_error), 1.96 * kind.shown(old_error) / root,
                        kind.shown(new_error), 1.96 * kind.shown(new_error) / root, samples, "s"});
      }
    }
  }
  return bins;
}

void fillParameters(Diagnosis& diagnosis, const MotionSet& set, double step) {
  const double row = usualRow(set.motions);
  for (std::size_t c = 0; c < diagnosis.causes.size(); ++c) {
    const ArmEffect& effect = *findArmEffect(diagnosis.causes[c].effect);
    for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
      const Estimate& p = diagnosis.extensions[c].parameters[i];
      // Of what it changes, or of itself where that is less: no current is limited at a thousand amperes.
      const double size = std::min(std::abs(p.value - effect.parameters[i].neutral), std::abs(p.value));
      const double of_model = effect.command_delay               ? 0.0
                              : effect.parameters[i].unit == "s" ? std::hypot(effect.law_sd * size, step)
                                                                 : effect.law_sd * size;
      const double told = p.sd > 0.0 ? 1.96 * std::hypot(p.sd, of_model) : std::nan("");
      const double half = effect.command_delay ? told + row : told;
      diagnosis.causes[c].parameters.push_back(withIntervalIn(effect.parameters[i], p, half));
    }
  }
}

std::string doubtOfDelay(const Estimate& delay, double row) {
  const double half = std::isfinite(delay.sd) ? 1.96 * delay.sd : 0.0;
  if (delay.value > half + row) return {};
  return fmt::format("{} = {:.2g} s may be none: when a command changed is known to a row, {:.2g} s", delay.name,
                     delay.value, row);
}

std::vector<Absorption> shiftsBetween(const MotionCauseFit& plain, const MotionCauseFit& with) {
  const Eigen::MatrixXd known = with.covariance();
  std::vector<Absorption> shifts;
  const Eigen::Index ordinary = plain.here().z.size() - 1;
  for (Eigen::Index i = 0; i < ordinary; ++i) {
    const double sd = std::sqrt(std::max(1e-12, known(i, i)));
    shifts.push_back({plain.posterior().space().parameters()[i].name, (with.here().z[i] - plain.here().z[i]) / sd});
  }
  return absorbed(std::move(shifts));
}

}  // namespace simgap
