#include "motion_scan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr std::size_t kBatch = 24;             // models played at once
constexpr std::size_t kScreened = 12;          // hypotheses of single muscles tried on all motions
constexpr std::size_t kRefined = 6;            // hypotheses tried from all their starts at all points
constexpr std::size_t kPerEffect = 3;          // of one effect among these
constexpr std::uint32_t kMotionPlacebos = 19;  // so that one of 20 is better by chance
constexpr std::size_t kMostColumns = 40;       // hypotheses that placebos are made of
constexpr double kLeastShift = 0.15;           // of a motion

using Residuals = std::vector<Eigen::VectorXd>;
using Column = std::vector<Eigen::VectorXf>;  // shape (motions) of (numbers)

/// A parameter in standard deviations of the effect's prior, as ScaledParameters.
double priorUnits(const ArmEffectParameter& p, double value) {
  return p.range.lower > 0.0 ? std::log(value / p.neutral) * p.neutral / p.scale : (value - p.neutral) / p.scale;
}

double fromPriorUnits(const ArmEffectParameter& p, double z) {
  return p.range.lower > 0.0 ? p.neutral * std::exp(z * p.scale / p.neutral) : p.neutral + z * p.scale;
}

double priorOf(const ArmEffect& effect, const EffectParameters& values, const ArmSizes& arm) {
  double sum = 0.0;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const ArmEffectParameter p = onArm(effect.parameters[i], arm);
    if (p.fitted) sum += std::pow(priorUnits(p, values[i]), 2);
  }
  return 0.5 * sum;
}

MotionPoint::OwnClock clockBeside(const ArmEffect& effect) {
  return effect.frame_delay ? MotionPoint::OwnClock::kStays : MotionPoint::OwnClock::kFollows;
}

/// The change of all residuals per unit of the cause's first parameter, with what a quadratic needs of it.
struct Profile {
  Column column;
  MotionPoint::OwnClock clock;
  double along = 0.0;      ///< slope of the objective along it, the ordinary parameters following
  double curvature = 0.0;  ///< its second derivative, prior included
  double gain() const { return 0.5 * along * along / curvature; }
  double best() const { return -along / curvature; }  ///< in prior standard deviations
};

class Scanner {
 public:
  /// \param some  the motions that the points know; empty: all
  Scanner(std::span<const MotionPoint> points, const std::vector<ArmHypothesis>& hypotheses, std::uint64_t seed,
          const std::function<void(long)>& news, std::vector<std::size_t> some = {})
      : points_(points),
        hypotheses_(hypotheses),
        random_(seed),
        news_(news),
        some_(std::move(some)),
        arm_(sizesOf(points.front().posterior().modelAt(Eigen::VectorXd::Zero(points.front().here().z.size())))) {
    for (const MotionPoint& point : points_) {
      Column plain;
      for (const Eigen::VectorXd& r : point.here().at.residuals) plain.push_back(r.cast<float>());
      without_.push_back(point.predicted(point.here().at.residuals));
      Eigen::VectorXd gradient = point.projected(plain);
      for (Eigen::Index i = 0; i < gradient.size(); ++i) {
        if (point.posterior().hasPrior(i)) gradient[i] += point.here().z[i];
      }
      solved_.push_back(point.solved(gradient));
      held_.push_back(point.solved(gradient, MotionPoint::OwnClock::kStays));
      plain_.push_back(std::move(plain));
    }
    for (const Eigen::VectorXf& r : plain_.front()) numbers_ += static_cast<double>(r.size());
  }

  MotionScan run();

 private:
  struct Try {
    std::size_t hypothesis, point;
    EffectParameters start;
  };
  std::vector<MotionTrial> play(const std::vector<Try>& tries, bool profiles);
  void keep(const MotionTrial& trial) {
    const auto [entry, added] = best_.try_emplace(trial.hypothesis, trial);
    if (!added && trial.gain > entry->second.gain) entry->second = trial;
  }
  double told(double gain, std::size_t point) const;
  Profile profileOf(const Column& column, MotionPoint::OwnClock clock, std::size_t point) const;
  bool extrapolate(std::size_t hypothesis, const EffectParameters& from, double z, EffectParameters& to) const;
  std::vector<std::size_t> promising(std::size_t most) const;
  std::vector<std::size_t> screened();
  std::vector<double> placebos() const;
  std::vector<std::vector<Eigen::Index>> shifts(std::uint32_t draw) const;

  std::span<const MotionPoint> points_;
  const std::vector<ArmHypothesis>& hypotheses_;
  CounterRandom random_;
  const std::function<void(long)>& news_;
  std::vector<std::size_t> some_;
  ArmSizes arm_;
  double numbers_ = 0.0;                 // of all motions
  std::vector<double> without_;          // what the quadratic promises without a further cause, by point
  std::vector<Eigen::VectorXd> solved_;  // A^-1 g there
  std::vector<Eigen::VectorXd> held_;    // the same while the fit's own clock stays
  std::vector<Column> plain_;            // residuals there
  std::map<std::size_t, MotionTrial> best_;
  std::map<std::size_t, Profile> profiles_;  // at the first point
  long rollouts_ = 0;
};

/// Log odds that a gain stands for, n/2 ln(before / after): residuals tell their own size, which differs from point to
/// point by as much as the models there miss. Where a model misses nothing, that is the gain itself.
double Scanner::told(double gain, std::size_t point) const {
  const double before = without_[point], after = std::max(before - gain, 1e-6 * before);
  return 0.5 * numbers_ * std::log(before / after);
}

Profile Scanner::profileOf(const Column& column, MotionPoint::OwnClock clock, std::size_t point) const {
  const MotionPoint& here = points_[point];
  Profile profile{column, clock, 0.0, 1.0};
  const Eigen::VectorXd q = here.projected(column);
  for (std::size_t m = 0; m < column.size(); ++m) {
    const Eigen::VectorXf weighted = here.weights()[m].cwiseProduct(column[m]);
    profile.along += static_cast<double>(weighted.dot(plain_[point][m]));
    profile.curvature += static_cast<double>(weighted.dot(column[m]));
  }
  profile.along -= q.dot(clock == MotionPoint::OwnClock::kFollows ? solved_[point] : held_[point]);
  profile.curvature -= q.dot(here.solved(q, clock));
  profile.curvature = std::max(profile.curvature, 1e-6);
  return profile;
}

/// Plays all motions with each try's cause. \param profiles  keep what they change, at the first point
std::vector<MotionTrial> Scanner::play(const std::vector<Try>& tries, bool profiles) {
  std::vector<MotionTrial> trials;
  for (std::size_t first = 0; first < tries.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, tries.size() - first), point = tries[first].point;
    std::vector<ArmModel> models;
    std::vector<double> delays;
    for (std::size_t i = first; i < first + count; ++i) {
      const MotionPoint& at = points_[tries[i].point];
      const ArmHypothesis& hypothesis = hypotheses_[tries[i].hypothesis];
      models.push_back(at.posterior().modelAt(at.here().z));
      models.back().extensions.push_back(makeExtension(*hypothesis.effect, hypothesis.target, tries[i].start));
      delays.push_back(at.posterior().captureDelay(at.here().z));
    }
    const auto played = points_[point].posterior().residualsOf(models, delays, some_);
    stopIfInterrupted();
    rollouts_ += static_cast<long>(count) * (some_.empty() ? std::ssize(played.front()) : std::ssize(some_));
    if (news_) news_(rollouts_);
    for (std::size_t i = 0; i < count; ++i) {
      const Try& one = tries[first + i];
      const ArmEffect& effect = *hypotheses_[one.hypothesis].effect;
      MotionTrial trial{one.hypothesis, one.start, 0.0};
      const MotionPoint::OwnClock clock = clockBeside(effect);
      const double objective = points_[one.point].predicted(played[i], clock);
      if (!std::isfinite(objective)) continue;
      trial.gain = told(without_[one.point] - objective - priorOf(effect, one.start, arm_), one.point);
      keep(trial);
      trials.push_back(trial);
      if (!profiles || one.point != 0) continue;
      const double unit = priorUnits(onArm(effect.parameters[0], arm_), one.start[0]);
      Column column;
      for (std::size_t m = 0; m < played[i].size(); ++m) {
        column.push_back((played[i][m].cast<float>() - plain_[0][m]) / static_cast<float>(unit));
      }
      profiles_.emplace(one.hypothesis, profileOf(column, clock, 0));
    }
  }
  return trials;
}

/// The start with another first parameter. \returns false where that may not be
bool Scanner::extrapolate(std::size_t hypothesis, const EffectParameters& from, double z, EffectParameters& to) const {
  const ArmHypothesis& h = hypotheses_[hypothesis];
  to = from;
  const ArmEffectParameter first = onArm(h.effect->parameters[0], arm_);
  to[0] = fromPriorUnits(first, std::clamp(z, -5.0, 5.0));
  return to[0] >= first.range.lower && to[0] <= first.range.upper;
}

/// Those worth a closer look, some of each effect, and beside one of a single muscle the same of all muscles.
std::vector<std::size_t> Scanner::promising(std::size_t most) const {
  std::vector<std::pair<double, std::size_t>> order;
  for (const auto& [hypothesis, trial] : best_) {
    const auto profile = profiles_.find(hypothesis);
    EffectParameters to;
    double gain = trial.gain;
    if (profile != profiles_.end() && extrapolate(hypothesis, trial.start, profile->second.best(), to)) {
      gain = std::max(gain, told(profile->second.gain(), 0));
    }
    order.emplace_back(gain, hypothesis);
  }
  std::ranges::stable_sort(order, std::greater<>(), [](const auto& one) { return one.first; });
  std::vector<std::size_t> chosen;
  std::map<const ArmEffect*, std::size_t> of_effect;
  const auto add = [&](std::size_t hypothesis) {
    if (std::ranges::find(chosen, hypothesis) == chosen.end()) chosen.push_back(hypothesis);
  };
  for (const auto& [gain, hypothesis] : order) {
    if (chosen.size() >= most) break;
    const ArmHypothesis& one = hypotheses_[hypothesis];
    if (!one.target.empty() && ++of_effect[one.effect] > kPerEffect) continue;
    add(hypothesis);
    for (const auto& [other, trial] : best_) {
      if (hypotheses_[other].effect == one.effect && hypotheses_[other].target.empty()) add(other);
    }
  }
  return chosen;
}

/// For each motion the number that each number is replaced by: channels keep their order in time, moved round by a part
/// of the motion that is the same for all.
std::vector<std::vector<Eigen::Index>> Scanner::shifts(std::uint32_t draw) const {
  std::vector<std::vector<Eigen::Index>> from;
  const std::vector<MotionResiduals>& motions = points_[0].posterior().motions();
  for (std::uint32_t m = 0; m < motions.size(); ++m) {
    const double part = kLeastShift + (1.0 - 2.0 * kLeastShift) * random_.uniform({draw, m, 0, 61});
    const std::vector<ResidualBlock>& blocks = motions[m].blocks();
    std::vector<Eigen::Index> moved(static_cast<std::size_t>(motions[m].size()));
    for (std::size_t first = 0, last = 0; first < blocks.size(); first = last) {
      while (last < blocks.size() && blocks[last].group == blocks[first].group &&
             blocks[last].item == blocks[first].item) {
        ++last;
      }
      const std::size_t count = last - first, by = static_cast<std::size_t>(part * static_cast<double>(count));
      for (std::size_t b = 0; b < count; ++b) {
        const ResidualBlock &to = blocks[first + b], &source = blocks[first + (b + by) % count];
        for (Eigen::Index i = 0; i < to.size; ++i) moved[to.first + i] = source.first + i;
      }
    }
    from.push_back(std::move(moved));
  }
  return from;
}

std::vector<double> Scanner::placebos() const {
  std::vector<const Profile*> columns;
  for (const auto& [hypothesis, profile] : profiles_) columns.push_back(&profile);
  std::ranges::stable_sort(columns, std::greater<>(), [](const Profile* profile) { return profile->gain(); });
  columns.resize(std::min(columns.size(), kMostColumns));
  std::vector<double> best(kMotionPlacebos, 0.0);
  tbb::parallel_for(std::uint32_t{0}, kMotionPlacebos, [&](std::uint32_t draw) {
    const auto from = shifts(draw);
    for (const Profile* profile : columns) {
      if (interruptRequested()) return;
      Column moved;
      for (std::size_t m = 0; m < profile->column.size(); ++m) moved.emplace_back(profile->column[m](from[m]));
      best[draw] = std::max(best[draw], told(profileOf(moved, profile->clock, 0).gain(), 0));
    }
  });
  stopIfInterrupted();
  return best;
}

/// Of the hypotheses of single muscles those that look best on some of the motions, at the first point.
std::vector<std::size_t> Scanner::screened() {
  std::vector<Try> tries;
  for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
    if (ofOneMuscle(hypotheses_[h])) tries.push_back({h, 0, hypotheses_[h].starts.front()});
  }
  const std::vector<std::size_t> some = someMotions(points_[0].here().jacobians.size());
  const MotionLinearisation few = onlyOf(points_[0].here(), some);
  const MotionPoint point(points_[0].posterior(), few);
  Scanner screen({&point, 1}, hypotheses_, 0, news_, some);
  screen.play(tries, true);
  rollouts_ += screen.rollouts_;
  return screen.promising(kScreened);
}

MotionScan Scanner::run() {
  std::vector<Try> tries;
  for (const std::size_t h : screened()) tries.push_back({h, 0, hypotheses_[h].starts.front()});
  for (std::size_t point = 0; point < points_.size(); ++point) {
    for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
      if (!ofOneMuscle(hypotheses_[h])) tries.push_back({h, point, hypotheses_[h].starts.front()});
    }
  }
  play(tries, true);
  tries.clear();
  for (std::size_t point = 0; point < points_.size(); ++point) {
    for (const std::size_t h : promising(kRefined)) {
      for (const EffectParameters& start : hypotheses_[h].starts) tries.push_back({h, point, start});
      EffectParameters start;
      const auto profile = profiles_.find(h);
      if (profile != profiles_.end() && extrapolate(h, best_.at(h).start, profile->second.best(), start)) {
        tries.push_back({h, point, start});
      }
    }
  }
  play(tries, false);
  MotionScan scan;
  for (const auto& [hypothesis, trial] : best_) scan.trials.push_back(trial);
  std::ranges::stable_sort(scan.trials, std::greater<>(), &MotionTrial::gain);
  scan.placebos = placebos();
  scan.rollouts = rollouts_;
  return scan;
}

}  // namespace

MotionScan scanMotions(std::span<const MotionPoint> points, const std::vector<ArmHypothesis>& hypotheses,
                       std::uint64_t seed, const std::function<void(long)>& news) {
  return Scanner(points, hypotheses, seed, news).run();
}

}  // namespace simgap
