#include "findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnose/surrogates.h"
#include "diagnose/verdict.h"
#include "drift.h"
#include "free_shape.h"
#include "load_friction.h"
#include "log_conclusion.h"
#include "measured_sizes.h"
#include "placebos.h"
#include "simgap/core/statistics.h"
#include "slow_friction.h"
#include "weight_friction.h"

namespace simgap {
namespace {

/// More than the whole error is no share of it: data that a model was not fitted to are then off without bound.
std::string inWords(const Interval& gain, double p) {
  if (gain.value < -1.0) return fmt::format("worse than without it, p = {:.2g}", p);
  const std::string lower = gain.lower95 < -1.0 ? "below -100" : fmt::format("{:.1f}", 100.0 * gain.lower95);
  return fmt::format("{:.1f} %, {} to {:.0f}, p = {:.2g}", 100.0 * gain.value, lower, 100.0 * gain.upper95, p);
}

class Judge {
 public:
  Judge(const LogSearch& search, const PreparedLog& log, HeldOutParts& parts, std::size_t own,
        std::vector<Hypothesis> hypotheses, const LogDiagnosisOptions& options, Selection& selection)
      : search_(search),
        log_(log),
        parts_(parts),
        own_(own),
        hypotheses_(std::move(hypotheses)),
        options_(options),
        selection_(selection) {}

  Findings run() {
    measure();
    while (takeOut() && causes() > 0) {  // what stays may only have been best beside what went
      reviewCauses(search_, own_, hypotheses_, options_, selection_);
      measure();
    }
    for (std::size_t k = 0; k < causes(); ++k) addLoadFriction(k);
    std::ranges::reverse(found_.candidates);
    return std::move(found_);
  }

 private:
  std::size_t causes() const { return selection_.steps.size() - 1; }
  /// By what the model loses without it, all others refitted: causes that need each other gain little alone.
  Interval gainOf(std::size_t cause) const {
    return predictedGain(errors_without_[cause].sum, found_.heldout.back().sum, options_.seed);
  }

  void measure() {
    parts_.take(selection_);
    const std::vector<Eigen::VectorXd> unseen = parts_.residuals([](const HeldOutPart& part) {
      std::vector<Fitted> models = part.steps;
      models.insert(models.end(), part.without.begin(), part.without.end());
      return models;
    });
    std::vector<GroupErrors> errors;
    errors.reserve(unseen.size());
    for (const Eigen::VectorXd& residual : unseen) errors.push_back(errorsOf(residual));
    const auto steps = std::ssize(selection_.steps);
    unseen_ = unseen[selection_.steps.size() - 1];
    unseen_without_.assign(unseen.begin() + steps, unseen.end());
    errors_without_.assign(errors.begin() + steps, errors.end());
    found_.heldout.assign(errors.begin(), errors.begin() + steps);
    without_ = parts_.parts().front().without;
    found_.on_all_rows = selection_.chosen;
    found_.fit = describe(search_, log_, found_.on_all_rows);
    found_.left = {};
  }

  GroupErrors errorsOf(const Eigen::VectorXd& unseen) const {
    return heldOutErrors(search_, unseen, parts_.blocks(), log_.data.rows.session);
  }

  /// Takes out all causes about which there is a doubt; false when there was none.
  bool takeOut() {
    bool any = false;
    while (takeOne([&](std::size_t cause) { return doubtOf(cause); }) ||
           takeOne([&](std::size_t cause) { return shadowOver(cause); })) {
      any = true;
    }
    return any;
  }

  /// Takes out the last cause about which there is a doubt; false when there is none.
  template <typename Doubt>
  bool takeOne(const Doubt& doubt_of) {
    for (std::size_t k = causes(); k-- > 0;) {
      const std::string doubt = doubt_of(k);
      if (doubt.empty()) continue;
      const std::string_view name = selection_.chosen.model->effects()[own_ + k]->name;
      found_.candidates.push_back({std::string(name), {}, doubt, gainOf(k)});
      if (isLost(selection_.ambiguous_with[k])) {
        lost_ = std::max(lost_, errors_without_[k].mse() - found_.heldout.back().mse());
      }
      std::erase_if(hypotheses_, [&](const Hypothesis& h) { return h.effect->name == name; });
      dropCause(search_, own_, k, selection_);
      measure();
      return true;
    }
    return false;
  }

  /// Names friction by the load beside a cause that is mostly that.
  void addLoadFriction(std::size_t cause) {
    if (!isMostlyByTheLoad(search_, selection_.chosen, own_ + cause)) return;
    std::vector<std::string>& rivals = selection_.ambiguous_with[cause];
    for (const Hypothesis& h : hypotheses_) {
      const std::string name(h.effect->name);
      if (isByTheLoad(*h.effect) && std::ranges::find(rivals, name) == rivals.end()) rivals.push_back(name);
    }
  }

  /// Why data that decided nothing do not confirm what others showed, and not next to the least; empty when they do.
  /// Small gains are what a law's shape leaves, which is no chance: they have to be surer.
  std::string doubtOfGain(const Interval& gain, double p) const {
    const double asked = 2.0 * options_.least_gain;
    const bool sure = p < (gain.value < kSmall ? 0.001 : 0.01);
    if (sure && gain.value >= asked) return {};
    if (sure && gain.lower95 > 0.0) {
      return fmt::format("it gains less on held-out data than the {:.0f} % that a law's own shape may leave ({})",
                         100.0 * asked, inWords(gain, p));
    }
    return fmt::format("its gain on held-out data may be nothing ({})", inWords(gain, p));
  }

  /// Why a cause is no finding; empty when it is one.
  std::string doubtOf(std::size_t cause) const {
    const std::size_t effect = own_ + cause;
    const Fitted& full = selection_.chosen;
    if (const auto& others = selection_.ambiguous_with[cause]; isLost(others)) {
      return fmt::format("cannot be told apart here from {}", fmt::join(others, ", "));
    }
    if (std::string reason = undetermined(*full.model, found_.on_all_rows.theta, found_.fit, effect); !reason.empty())
      return reason;
    if (losesStrength(without_[cause], found_.on_all_rows, effect)) {
      return "with it k_a ends at its bound: no torque of the log says how strong the motor is any more";
    }
    std::string unseen = outOfSight(*full.model, found_.on_all_rows.theta, effect, log_.data.rows);
    if (!unseen.empty()) return unseen;
    if (cancels(*full.model, full, effect)) return "its terms cancel each other: their sizes mean nothing";
    std::string beyond = beyondTheData(*full.model, found_.on_all_rows, effect, log_.data.rows);
    if (!beyond.empty()) return beyond;
    std::string nothing = loadThatMayBeNone(*full.model, found_.fit, effect, log_.data.rows);
    if (!nothing.empty()) return nothing;
    std::string replaced = loadItReplaces(without_[cause], full, log_.data.rows);
    if (!replaced.empty()) return replaced;
    const Interval gain = gainOf(cause);
    const double p = heldOutP(unseen_without_[cause], unseen_);
    if (std::string small = doubtOfGain(gain, p); !small.empty()) return small;
    if (std::string few = doubtOfFewRows(cause); !few.empty()) return few;
    if (std::string form = doubtOfForm(cause); !form.empty()) return form;
    if (selection_.unnamed && selection_.unnamed->gain->value > gain.value) {
      return fmt::format("a dependence without a name, on {}, explains more: it may only stand in for that",
                         selection_.unnamed->hypothesis.target);
    }
    std::string not_late = doubtOfDelay(search_, full, without_[cause], effect);
    if (!not_late.empty()) return not_late;
    if (std::string moment = doubtOfMoment(cause); !moment.empty()) return moment;
    if (std::string shape = doubtOfShape(cause); !shape.empty()) return shape;
    if (std::string slow = doubtOfSlowMotion(cause); !slow.empty()) return slow;
    if (std::string weight = doubtOfWeight(cause); !weight.empty()) return weight;
    if (std::string load = doubtOfLoad(cause); !load.empty()) return load;
    if (std::string sign = doubtOfLoadSign(cause); !sign.empty()) return sign;
    const PlaceboTest placebos = testPlacebos(search_, full, without_[cause], effect, options_.seed);
    if (placebos.p <= kPlaceboLevel) return {};
    if (placebos.p == 1.0 && placebos.gain == 0.0) {
      return "too few rows count to compare it with signals of its colour that belong to no motion";
    }
    return fmt::format("signals of its colour that belong to no motion explain as much ({:.1f} % against {:.1f} %)",
                       100.0 * placebos.largest, 100.0 * placebos.gain);
  }

  /// Why a cause serves few rows, such as those of knocks, at the cost of all others; empty when it does not.
  std::string doubtOfFewRows(std::size_t cause) const {
    constexpr double kFew = 0.04;    // share of the rows
    constexpr double kWorse = 0.05;  // share of the others' squared error
    const Eigen::ArrayXd rest = unseen_without_[cause].array().square(), full = unseen_.array().square();
    std::vector<std::size_t> rows;
    for (Eigen::Index i = 0; i < rest.size(); ++i) {
      if (rest[i] > 0.0 && full[i] > 0.0) rows.push_back(static_cast<std::size_t>(i));
    }
    const auto others = rows.begin() + static_cast<std::ptrdiff_t>((1.0 - kFew) * static_cast<double>(rows.size()));
    std::ranges::nth_element(rows, others, {}, [&](std::size_t i) { return std::max(rest[i], full[i]); });
    double before = 0.0, after = 0.0;
    for (auto row = rows.begin(); row != others; ++row) before += rest[*row], after += full[*row];
    if (!(after > (1.0 + kWorse) * before)) return {};
    return fmt::format(
        "it gains in {:.0f} % of the rows, those of the largest errors, and loses {:.0f} % in all others", 100.0 * kFew,
        100.0 * (after / before - 1.0));
  }

  /// Why a cause may be all that the form of another's law leaves of it; empty where that one is not far larger.
  /// A constant has no form.
  std::string doubtOfForm(std::size_t cause) const {
    constexpr double kForm = 0.05;  // of what a law describes
    const double explained = std::max(0.0, errors_without_[cause].sum.sum() - found_.heldout.back().sum.sum());
    for (std::size_t other = 0; other < causes(); ++other) {
      if (other == cause) continue;
      const double action = actionOf(selection_.chosen, own_ + other, (unseen_without_[other] - unseen_).array(),
                                     unseen_without_[other].array() != 0.0 && unseen_.array() != 0.0);
      const double share = std::sqrt(explained / std::max(action, 1e-300));
      if (!(share < kForm)) continue;
      return fmt::format("{} acts {:.0f} times as strongly: where its law misses its form by {:.1f} %, that is as much",
                         selection_.chosen.model->effects()[own_ + other]->name, 1.0 / std::max(share, 1e-6),
                         100.0 * share);
    }
    return {};
  }

  /// Why a change at one moment may be none: friction that wanders over the log explains as much, or where the motion
  /// was before and after.
  std::string doubtOfMoment(std::size_t cause) const {
    if (!selection_.chosen.model->effects()[own_ + cause]->at_moment) return {};
    Fitted wandering = besideDrift(search_, without_[cause]), changed = selection_.chosen;
    for (Fitted* fitted : {&wandering, &changed}) search_.validate(*fitted);
    // A small change has to be better on the rows that both were fitted to, too, where wandering has more to choose.
    const bool small = gainOf(cause).value < kSmall;
    if (wandering.validation.mse() <= changed.validation.mse() || (small && trained(wandering) <= trained(changed)))
      return "friction that wanders over the log explains as much as a change at one moment";
    for (std::size_t channel = 0; channel < log_.context.size(); ++channel) {
      const std::string& name = log_.context[channel].name;
      if (name == "time") continue;
      const auto over = static_cast<ShapeOver>(channel);
      const std::string doubt = doubtBeside([&](const HeldOutPart& part) -> std::optional<Beside> {
        return Beside{besideShapeOver(*part.search, part.without[cause], over),
                      besideShapeOver(*part.search, part.chosen, over)};
      });
      if (!doubt.empty()) return fmt::format("beside an effort of any shape over {} {}", name, doubt);
    }
    return {};
  }

  /// Why what goes with the joint's angle is not of this shape; empty for causes that are none of the angle alone.
  std::string doubtOfShape(std::size_t cause) const {
    constexpr double kMore = 0.1;  // of what is left
    const auto& effects = selection_.chosen.model->effects();
    if (!effects[own_ + cause]->of_angle) return {};
    for (std::size_t other = 0; other < causes(); ++other) {
      if (other == cause || !effects[own_ + other]->of_angle || gainOf(other).value < gainOf(cause).value) continue;
      return fmt::format("{} goes with the joint's angle, too, and it may only be what that one's shape lacks",
                         effects[own_ + other]->name);
    }
    const std::vector<Eigen::VectorXd> unseen = parts_.residuals([&](const HeldOutPart& part) -> std::vector<Fitted> {
      return {part.chosen, besideShapeOver(*part.search, part.without[cause], ShapeOver::kJointAngle)};
    });
    const Interval more = predictedGain(errorsOf(unseen[0]).sum, errorsOf(unseen[1]).sum, options_.seed);
    if (more.value < kMore || more.lower95 <= 0.0) return {};
    return fmt::format("an effort of any other shape over the joint's angle leaves {:.0f} % less", 100.0 * more.value);
  }

  /// Why a cause only bends the law's curve of slow motion; empty when it explains something beside any such curve, and
  /// for what is slow motion's own.
  std::string doubtOfSlowMotion(std::size_t cause) const {
    const ActuatorEffect& effect = *selection_.chosen.model->effects()[own_ + cause];
    const bool is_slow = effect.contained_in != nullptr && effect.contained_in(friction::find("stribeck")) &&
                         !effect.contained_in(friction::find("coulomb"));
    if (effect.in_every_drive || is_slow) return {};
    const bool of_any_load = gainOf(cause).value < kSmall;
    double below = 0.0;
    const auto slow = [&](const HeldOutPart& part) -> std::optional<Beside> {
      const auto both = besideSlowFriction(*part.search, part.without[cause], part.chosen, of_any_load);
      if (!both) return std::nullopt;
      if (&part == &parts_.parts().front()) below = both->below;
      return *both;
    };
    const std::string doubt = doubtBeside(slow);
    const std::string slow_motion =
        fmt::format("slow motion (below {:.2g} {})", below, log_.data.velocity_unit == "m_s" ? "m/s" : "rad/s");
    if (!doubt.empty()) return "beside friction of any shape in " + slow_motion + " " + doubt;
    if (below == 0.0 || effect.remembers || gainsInFastMotion(cause, below)) return {};
    return "it explains only " + slow_motion + ", where friction has no closed form";
  }

  /// Turns of some rows can be all that a cause explains, in which no curve over the speed stands for friction.
  bool gainsInFastMotion(std::size_t cause, double below) const {
    return gainsWhere(cause, log_.data.rows.speed.abs() >= below);
  }

  /// Whether a cause explains something of some of the held-out rows. \param least  share of their squared error
  template <typename Rows>
  bool gainsWhere(std::size_t cause, const Rows& rows, double least = 0.0) const {
    const auto there = [&](const Eigen::VectorXd& unseen) -> Eigen::VectorXd {
      return rows.select(unseen.array(), 0.0);
    };
    const Eigen::VectorXd rest = there(unseen_without_[cause]), full = there(unseen_);
    return full.squaredNorm() < (1.0 - least) * rest.squaredNorm() && heldOutP(rest, full) < 0.05;
  }

  /// Why a cause of the load's sign may be the noise of a load that is about zero, which the law's k_a has in it, too.
  std::string doubtOfLoadSign(std::size_t cause) const {
    constexpr double kClear = 0.5, kLarge = 0.99;  // of the largest load, single rows aside
    constexpr double kAsMuch = 0.3;                // of what it gains over all rows
    if (!selection_.chosen.model->effects()[own_ + cause]->of_load_sign) return {};
    const Eigen::ArrayXd sizes = log_.data.rows.load.abs();
    const double clear = kClear * quantile({sizes.begin(), sizes.end()}, kLarge);
    if (gainsWhere(cause, sizes >= clear, kAsMuch * gainOf(cause).value)) return {};
    return fmt::format(
        "it explains next to nothing where the load is clear (above {:.2g} {}): below, noise decides its sign", clear,
        log_.data.load_unit);
  }

  /// Friction by the load is in most drives whose law lacks it: what is named beside it must not be next to
  /// nothing on another log. Two forms of it leave a third, which passed for a Stribeck curve.
  static constexpr double kLeastAgain = 0.01;
  static constexpr double kSmall = 0.1;  ///< gains below

  /// Why a cause may only be friction that grows with a weight of which nobody knows how large it is.
  std::string doubtOfWeight(std::size_t cause) const {
    const auto weight = [&](const HeldOutPart& part) {
      return besideWeightFriction(*part.search, part.without[cause], part.chosen);
    };
    const std::string doubt = doubtBeside(weight, kLeastAgain);
    if (doubt.empty()) return {};
    return "beside friction that grows with the fitted weight " + doubt +
           ": with a weight that is known, load-dependence can be told";
  }

  /// Why a cause may only stand in for friction that grows with the load, which the law lacks.
  std::string doubtOfLoad(std::size_t cause) const {
    const auto load = [&](const HeldOutPart& part) {
      const ActuatorEffect& effect = *selection_.chosen.model->effects()[own_ + cause];
      return besideLoadFriction(*part.search, part.without[cause], part.chosen, effect);
    };
    const std::string doubt = doubtBeside(load, kLeastAgain);
    return doubt.empty() ? doubt : "beside friction that grows with the load " + doubt;
  }

  double trained(const Fitted& fitted) const { return search_.errors(fitted, search_.training()).mse(); }

  /// Empty where a cause gains on held-out data beside something that is none. \param beside  the models of a part with
  /// that, without the cause and with it; none: it does not apply. Where it explains nothing beside the cause it stays
  /// out there: terms that nothing determines only scatter on data that had no part in the fit.
  /// \param least_again  of the gain, on another log
  std::string doubtBeside(const std::function<std::optional<Beside>(const HeldOutPart&)>& beside,
                          double least_again = 0.0) const {
    const auto here = beside(parts_.parts().front());
    if (!here) return {};
    const bool needed = trained(here->full) < (1.0 - options_.least_gain) * trained(selection_.chosen);
    const std::vector<Eigen::VectorXd> unseen = parts_.residuals([&](const HeldOutPart& part) -> std::vector<Fitted> {
      const Beside both = &part == &parts_.parts().front() ? *here : *beside(part);
      return {both.rest, needed ? both.full : part.chosen};
    });
    const Interval gain = predictedGain(errorsOf(unseen[0]).sum, errorsOf(unseen[1]).sum, options_.seed);
    const double p = heldOutP(unseen[0], unseen[1]);
    if (doubtOfGain(gain, p).empty() && gain.lower95 >= least_again) return {};
    return fmt::format("it may explain nothing ({})", inWords(gain, p));
  }

  /// Of "what the cause adds is none of the truth", by pieces of the held-out blocks. \param rest, full  shape (rows)
  double heldOutP(const Eigen::VectorXd& rest, const Eigen::VectorXd& full) const {
    return nestedP(search_.added(rest, full, parts_.blocks(), LogSearch::pieceSeconds(log_.data.rows)));
  }

  /// What is left and has no name may be what the cause only stands in for, unless that is clearly smaller. It is what
  /// forests see, or what a group too large to name explained: that is there, whatever it is.
  std::string shadowOver(std::size_t cause) {
    constexpr double kClearly = 1.25;
    if (!found_.left) {
      found_.left = explainable(log_, evidenceChannels(log_), residualOf(found_.on_all_rows), options_.seed);
    }
    const double before = errors_without_[cause].mse(), after = found_.heldout.back().mse();
    const double left = std::max(lost_, shareLeft(selection_, *found_.left) * found_.heldout.back().mse());
    if (before - after >= kClearly * left || gainOf(cause).lower95 * before >= left) return {};
    return fmt::format("it explains {:.0f} %, and what is left without a name {:.0f} %: it may only stand in for that",
                       100.0 * (before - after) / before, 100.0 * left / before);
  }

  const LogSearch& search_;
  const PreparedLog& log_;
  HeldOutParts& parts_;
  std::size_t own_;
  std::vector<Hypothesis> hypotheses_;  ///< but those of causes that were taken out
  const LogDiagnosisOptions& options_;
  Selection& selection_;
  Findings found_;
  double lost_ = 0.0;            ///< mean squared error that a group too large to name explained, the largest
  std::vector<Fitted> without_;  ///< shape (causes): the model without each of them
  Eigen::VectorXd unseen_;       ///< errors of the model on the held-out blocks, shape (rows)
  std::vector<Eigen::VectorXd> unseen_without_;  ///< of `without_`
  std::vector<GroupErrors> errors_without_;      ///< their squares
};

}  // namespace

Findings keepFindings(const LogSearch& search, const PreparedLog& log, HeldOutParts& parts, std::size_t own,
                      const std::vector<Hypothesis>& hypotheses, const LogDiagnosisOptions& options,
                      Selection& selection) {
  return Judge(search, log, parts, own, hypotheses, options, selection).run();
}

}  // namespace simgap
