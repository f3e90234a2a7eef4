#include "log_conclusion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "diagnose/verdict.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kStructure = 0.05;  // share of the error that forests have to explain to count as structure

/// What is left beside the causes, if there are any.
double timesTheNoise(const Diagnosis& d) {
  return d.noise_floor > 0.0 ? std::sqrt(d.extended.mse_heldout / d.noise_floor) : 0.0;
}

std::string recordTwice(const Diagnosis& d) {
  return fmt::format(
      "What is left is {:.1f} times the noise, and no logged channel explains it on data never used: record longer, "
      "log what else acts on the rig, and record one motion twice; what differs between the two is not the drive's.",
      timesTheNoise(d));
}

/// Whether something acts on the rig that no channel shows, such as a push: more than a rough model or an uneven noise.
bool farAboveNoise(const Diagnosis& d) {
  constexpr double kFar = 2.0;
  return timesTheNoise(d) > kFar;
}

/// How measured less model follows a channel, from its bins (of model less measured): correlation with the channel or
/// with the distance from its middle.
std::string shapeOf(const std::vector<EvidenceBin>& evidence, const std::string& channel) {
  constexpr double kPlain = 0.8;
  std::vector<const EvidenceBin*> bins;
  for (const EvidenceBin& bin : evidence) {
    if (bin.against == channel && std::isfinite(bin.after)) bins.push_back(&bin);
  }
  if (bins.size() < 5) return {};
  std::vector<double> center, residual;
  for (const EvidenceBin* bin : bins) {
    center.push_back(bin->center);
    residual.push_back(bin->after);
  }
  const double slope = correlation(center, residual);
  if (std::abs(slope) > kPlain) return slope < 0.0 ? "rises with it" : "falls with it";
  const auto [low, high] = std::ranges::minmax(center);
  for (double& at : center) at = std::abs(at - 0.5 * (low + high));
  return std::abs(correlation(center, residual)) > kPlain ? "differs between its middle and its ends" : "";
}

}  // namespace

std::string leftText(const Diagnosis& d) {
  if (d.left_over_percent < 1.0) return {};
  if (d.unexplained.empty()) {
    return fmt::format(
        "{:.0f} % of the squared error, {:.1f} times the noise, which no logged channel explains on data never used",
        d.left_over_percent, timesTheNoise(d));
  }
  constexpr double kAsMuch = 0.8;  // of what the first is told by: it may as well be the second
  const Leftover& most = d.unexplained[0];
  const bool two = d.unexplained.size() > 1 && d.unexplained[1].share > kAsMuch * most.share;
  return fmt::format("{:.0f} % of the squared error, by {}{}{}", d.left_over_percent, most.channel,
                     most.shape.empty() ? "" : fmt::format(" ({})", most.shape),
                     two ? " and " + d.unexplained[1].channel : "");
}

double shareLeft(const Selection& selection, const Ceiling& left) {
  const double unnamed = selection.unnamed ? std::max(0.0, selection.unnamed->gain->value) : 0.0;
  const double forests = left.share > kStructure ? left.share : 0.0;
  return std::min(1.0, std::max(unnamed, forests));
}

void sayWhatIsLeft(const Selection& selection, const PreparedLog& log, const Ceiling& left, Diagnosis& d) {
  const double unnamed = selection.unnamed ? std::max(0.0, selection.unnamed->gain->value) : 0.0;
  d.left_over_percent = (100.0 - d.explained_percent) * shareLeft(selection, left);
  std::vector<Leftover> list;
  if (selection.unnamed) {
    const std::vector<double>& fixed = selection.unnamed->hypothesis.fixed;
    for (const double channel : {fixed[2], fixed[3]}) {
      if (channel >= 0.0) list.push_back({log.context[static_cast<std::size_t>(channel)].name, unnamed, {}});
    }
  }
  for (const Leftover& l : left.channels) {
    const bool known = std::ranges::any_of(list, [&](const Leftover& other) { return other.channel == l.channel; });
    if (!known && left.share > kStructure && l.share > 0.0) list.push_back(l);
  }
  double sum = 0.0;
  for (const Leftover& l : list) sum += l.share;
  for (Leftover& l : list) {
    l.share *= 0.01 * d.left_over_percent / std::max(sum, 1e-300);
    l.shape = shapeOf(d.evidence, l.channel);
  }
  std::ranges::stable_sort(list, std::greater<>(), &Leftover::share);
  if (d.left_over_percent > 0.0) d.unexplained = std::move(list);
}

void conclude(Diagnosis& d) {
  const std::string left = leftText(d);
  constexpr double kOfLaws = 3.0;  // [%] what a law's own shape may leave is no structure, as a cause's gain is none
  d.verdict = verdictOf(d.causes, d.left_over_percent >= kOfLaws);
  if (d.verdict == DiagnosisVerdict::kNothingFound) {
    d.sentence =
        fmt::format("Nothing found: no cause improves the model on data it has not seen; RMS {:.4g}, noise floor {}{}.",
                    std::sqrt(d.baseline.mse_heldout),
                    d.noise_floor > 0.0 ? fmt::format("{:.4g}", std::sqrt(d.noise_floor)) : "unknown",
                    farAboveNoise(d) ? ": no logged channel explains what is left on data never used" : "");
  } else if (d.verdict == DiagnosisVerdict::kUnexplained) {
    d.sentence = fmt::format("Unexplained: no cause of the catalogue was found. Left: {}.", left);
  } else {
    d.sentence = fmt::format("Found{}: {} ({:.0f} % of the squared error on data never used). Left: {}.",
                             d.verdict == DiagnosisVerdict::kAmbiguous ? ", but not alone" : "", namesOf(d.causes),
                             d.explained_percent, left.empty() ? "nothing that the logged channels show" : left);
  }
}

namespace {

/// What to record to see how what is left follows a channel.
std::string stepsOf(const std::string& channel) {
  static const std::map<std::string, const char*> kSteps = {
      {"time", "Repeat the first motion at the end of the log and once in its middle: that tells a drift from chance."},
      {"motor_velocity", "Repeat one stroke at six constant speeds, both ways: that shows the law over the speed."},
      {"acceleration",
       "Repeat one stroke with slow and with fast starts, and log faster: that tells inertia from lag."},
      {"external_torque", "Repeat one motion under other loads, or of another mass: that shows the law over the load."},
      {"time_since_reversal_s", "Record long and short strokes at one speed: that shows what follows a reversal."},
      {"rest_s", "Rest for 1, 3 and 10 s before the same slow motion: that shows what a rest does."},
      {"an offset", "Record rests under a known load, approached from either side: that tells a bias from friction."},
      {"direction", "Repeat one motion to and fro at several speeds: that shows how the two ways differ."}};
  const auto known = kSteps.find(channel);
  if (known != kSteps.end()) return known->second;
  return fmt::format("Repeat one motion and load at several values of {} over its range: that shows its law.", channel);
}

}  // namespace

std::string nextExperiment(const Diagnosis& d, const PreparedLog& log) {
  const double minutes = log.data.rows.elapsed[log.data.rows.rows() - 1] / 60.0;
  for (const Cause& cause : d.causes) {
    if (cause.ambiguous_with.empty()) continue;
    std::string text = fmt::format("To tell {} from {}: record {}", cause.effect, fmt::join(cause.ambiguous_with, ", "),
                                   actuator_effects::find(cause.effect).separates);
    for (const std::string& other : cause.ambiguous_with) {
      text += fmt::format("; and {}", actuator_effects::find(other).separates);
    }
    if (log.data.rows.top_load == 0.0) return text + ".";
    return text + fmt::format(" ({:.0f} min at loads up to {:.3g} {} would do).", std::max(2.0, 0.2 * minutes),
                              log.data.rows.top_load, log.data.load_unit);
  }
  if (d.verdict == DiagnosisVerdict::kUnexplained && !d.unexplained.empty()) return stepsOf(d.unexplained[0].channel);
  if (!d.causes.empty()) {
    const std::string confirm = fmt::format("To confirm {} independently: record {}.", d.causes[0].effect,
                                            actuator_effects::find(d.causes[0].effect).separates);
    return d.left_over_percent >= 1.0 && d.unexplained.empty() ? confirm + " " + recordTwice(d) : confirm;
  }
  if (farAboveNoise(d) || d.verdict == DiagnosisVerdict::kUnexplained) return recordTwice(d);
  if (d.verdict != DiagnosisVerdict::kNothingFound) return {};
  if (d.noise_floor <= 0.0) {
    return "The rows do not tell their own noise, so whether more is missing cannot be said: log more rows a second, "
           "or record one motion twice.";
  }
  constexpr double kAtTheNoise = 1.1;
  if (timesTheNoise(d) > kAtTheNoise || !d.candidates.empty()) {
    return fmt::format(
        "The model misses {:.1f} times the noise, by nothing that is sure here: a log of {:.0f} min, or one motion "
        "recorded twice, would tell a cause from chance.",
        timesTheNoise(d), std::max(2.0, 4.0 * minutes));
  }
  return fmt::format(
      "Nothing is missing at this noise; smaller effects than those under `detectable` need about {:.0f} min "
      "of log for half of their size.",
      4.0 * minutes);
}

}  // namespace simgap
