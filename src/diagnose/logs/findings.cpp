#include "findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "placebos.h"

namespace simgap {
namespace {

using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr double kCancelling = 30.0;  // times what a cause's terms add up to: each of them alone means nothing
constexpr double kPlaceboLevel = 0.05;

/// A size that was measured. With a shape beside it (how fast it heats up) each alone may be known badly where the two
/// together are not: whether the cause is there at all was tested before, here only sizes that mean nothing are
/// refused.
bool isMeasured(const Estimate& p, double neutral, double t) {
  constexpr double kMeaningless = 3.0;  // half widths of the interval, in sizes
  return std::isfinite(p.sd) && p.sd > 0.0 && t * p.sd < kMeaningless * std::abs(p.value - neutral);
}

/// Why the cause's own parameters are no measurement; empty when they are.
std::string undetermined(const ActuatorRegression& model, const LogFit& fit, std::size_t effect) {
  const ActuatorEffect& cause = *model.effects()[effect];
  bool any = false;
  for (std::size_t k = 0; k < cause.columns.size(); ++k) {
    any = any || isMeasured(fit.parameters[model.firstColumn(effect) + k], 0.0, fit.t);
  }
  bool sized = !cause.columns.empty();
  for (std::size_t k = 0; k < cause.parameters.size(); ++k) {
    const EffectParameter& p = cause.parameters[k];
    const Estimate& value = fit.parameters[model.firstParameter(effect) + k];
    if (p.kind == Kind::kScanned || p.kind == Kind::kConstant) continue;
    if (value.at_bound && std::abs(value.value - p.neutral) > 1e-9 * (1.0 + std::abs(p.neutral))) {
      return fmt::format("{} ends at the bound {:.4g} of its range", p.name, value.value);
    }
    if (p.kind != Kind::kSmooth) continue;
    sized = true;
    any = any || isMeasured(value, p.neutral, fit.t);
  }
  return any || !sized ? "" : "none of its own parameters is determined by these data";
}

/// Terms that nearly cancel each other have no physical size (a sine over a small part of its period).
bool cancels(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect) {
  const std::size_t count = model.effects()[effect]->columns.size();
  if (count < 2) return false;
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  model.evaluate(fitted.theta, residual, &jacobian);
  const auto first = static_cast<Index>(model.firstColumn(effect));
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(jacobian.rows());
  double largest = 0.0;
  for (Index k = first; k < first + static_cast<Index>(count); ++k) {
    const Eigen::VectorXd term = fitted.theta[static_cast<std::size_t>(k)] * jacobian.col(k);
    largest = std::max(largest, term.norm());
    sum += term;
  }
  return largest > kCancelling * sum.norm();
}

std::string doubtOf(const LogSearch& search, const Fitted& full, const LogFit& fit, std::size_t effect,
                    const Interval& gain, const LogDiagnosisOptions& options) {
  if (std::string reason = undetermined(*full.model, fit, effect); !reason.empty()) return reason;
  if (cancels(*full.model, full, effect)) return "its terms cancel each other: their sizes mean nothing";
  if (!(gain.lower95 > 0.0) || gain.value < options.least_gain) {
    return fmt::format("its gain on held-out data may be nothing ({:.0f} %, {:.0f} to {:.0f})", 100.0 * gain.value,
                       100.0 * gain.lower95, 100.0 * gain.upper95);
  }
  const PlaceboTest placebos = testPlacebos(search, full, search.without(full, effect), effect, options.seed);
  if (placebos.p > kPlaceboLevel) {
    return fmt::format("signals of its colour that belong to no motion explain as much ({:.1f} % against {:.1f} %)",
                       100.0 * placebos.largest, 100.0 * placebos.gain);
  }
  return {};
}

}  // namespace

std::vector<Candidate> keepFindings(const LogSearch& search, const PreparedLog& log, const LogSplit& split,
                                    std::size_t own, const LogDiagnosisOptions& options, Selection& selection) {
  std::vector<Candidate> candidates;
  for (bool taken = true; taken;) {
    taken = false;
    const std::vector<PieceErrors> heldout = heldOutErrors(search, selection, split.heldout, log.data.rows.session);
    Fitted all = selection.chosen;
    const LogFit fit = describe(search, log, all);
    for (std::size_t k = selection.steps.size() - 1; k-- > 0 && !taken;) {
      const Interval gain = predictedGain(heldout[k].sum, heldout[k + 1].sum, options.seed);
      std::string doubt = doubtOf(search, selection.chosen, fit, own + k, gain, options);
      if (doubt.empty() && selection.unnamed && selection.unnamed->gain->value > gain.value) {
        doubt = fmt::format("a dependence without a name, on {}, explains more: it may only stand in for that",
                            selection.unnamed->hypothesis.target);
      }
      if (doubt.empty()) continue;
      candidates.push_back({std::string(selection.chosen.model->effects()[own + k]->name), {}, doubt, gain});
      dropCause(search, own, k, selection);
      taken = true;
    }
  }
  std::ranges::reverse(candidates);
  return candidates;
}

}  // namespace simgap
