/// Weights from windows, and how well they will do.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/decode/decoder.h"
#include "simgap/optimize/trace_norm_logistic.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Windows = std::vector<LabelledCovariance>;
using Places = std::vector<std::size_t>;  // of windows

constexpr std::array<double, 7> kParts = {0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.008};
constexpr int kInnerFolds = 4;
constexpr double kSearchGap = 5e-3, kDeliveredGap = 1e-6;
constexpr double kDisturbed = 5.0;     // robust deviations of a window's logarithmic power
constexpr double kNoDirection = 1e-9;  // of the largest variance: the mean of all channels was taken away

/// Covariances of the windows that are learnt from, seen where their mean is the identity, less that mean: so every
/// direction weighs alike, and the bias need not carry what all have in common.
class Whitening {
 public:
  Whitening(const Windows& windows, const Places& learnt) {
    mean_ = MatrixXd::Zero(windows[0].covariance.rows(), windows[0].covariance.rows());
    for (const std::size_t w : learnt) mean_ += windows[w].covariance / static_cast<double>(learnt.size());
    const SymmetricEigen eigen = symmetricEigen(mean_);
    const double floor = kNoDirection * eigen.values.maxCoeff();
    VectorXd inverse_roots = VectorXd::Zero(eigen.values.size());
    for (Index k = 0; k < eigen.values.size(); ++k) {
      if (eigen.values[k] > floor) inverse_roots[k] = 1.0 / std::sqrt(eigen.values[k]);
    }
    whitener_ = eigen.vectors * inverse_roots.asDiagonal() * eigen.vectors.transpose();
  }

  MatrixXd packed(const Windows& windows, const Places& places) const {
    std::vector<MatrixXd> seen;
    for (const std::size_t w : places) seen.push_back(whitener_ * (windows[w].covariance - mean_) * whitener_);
    return packSymmetric(seen);
  }
  /// tr(V P (C - M) P) + b = tr(P V P C) + b - tr(P V P M).
  void unfold(const TraceNormFit& fit, Decoder& decoder) const {
    decoder.weights = whitener_ * unpackSymmetric(fit.weights, mean_.rows()) * whitener_;
    decoder.bias = fit.bias - decoder.weights.cwiseProduct(mean_).sum();
  }

 private:
  MatrixXd mean_, whitener_;
};

VectorXd labelsOf(const Windows& windows, const Places& places) {
  VectorXd labels(std::ssize(places));
  for (std::size_t i = 0; i < places.size(); ++i) labels[i] = windows[places[i]].instruction;
  return labels;
}

/// The places of `among` whose trials are in fold f of `folds`, or are not: neighbouring trials stay together, because
/// a head changes slowly.
Places ofFold(const Windows& windows, const Places& among, int fold, int folds, bool inside) {
  std::vector<std::size_t> trials;
  for (const std::size_t w : among) {
    if (trials.empty() || trials.back() != windows[w].trial) trials.push_back(windows[w].trial);
  }
  Places places;
  for (const std::size_t w : among) {
    const auto at = static_cast<std::size_t>(std::ranges::find(trials, windows[w].trial) - trials.begin());
    const bool is_inside = static_cast<int>(at * static_cast<std::size_t>(folds) / trials.size()) == fold;
    if (is_inside == inside) places.push_back(w);
  }
  return places;
}

/// Windows in which no channel is far louder or quieter than it is wont to be.
std::vector<bool> disturbedWindows(const Windows& windows) {
  std::vector<bool> disturbed(windows.size(), false);
  for (Index c = 0; c < windows[0].covariance.rows(); ++c) {
    std::vector<double> power;
    for (const LabelledCovariance& window : windows) power.push_back(std::log(window.covariance(c, c) + 1e-300));
    const double middle = median(power), spread = robustDeviation(power);
    for (std::size_t w = 0; w < windows.size(); ++w) {
      if (std::abs(power[w] - middle) > kDisturbed * spread) disturbed[w] = true;
    }
  }
  return disturbed;
}

Places calmOnes(const Places& places, const std::vector<bool>& disturbed) {
  Places calm;
  std::ranges::copy_if(places, std::back_inserter(calm), [&](std::size_t w) { return !disturbed[w]; });
  return calm;
}

/// Log odds of `judged` by weights of `learnt`, for each part of the largest penalty, from the strongest on.
std::vector<VectorXd> logOddsAlong(const Windows& windows, const Places& learnt, const Places& judged,
                                   std::span<const double> parts) {
  const Whitening whitening(windows, learnt);
  const Index dimension = windows[0].covariance.rows();
  const MatrixXd seen = whitening.packed(windows, learnt), other = whitening.packed(windows, judged);
  const VectorXd labels = labelsOf(windows, learnt);
  const double largest = largestTraceNormPenalty(seen, labels, dimension);
  VectorXd start;
  std::vector<VectorXd> odds;
  for (const double part : parts) {
    const TraceNormFit fit = fitTraceNormLogistic(seen, labels, dimension, part * largest, {kSearchGap, 2000}, start);
    start = fit.weights;
    odds.push_back((other * fit.weights).array() + fit.bias);
  }
  return odds;
}

/// Held-out loss of every penalty, by folds of whole trials.
std::vector<PenaltyLoss> penaltyLosses(const Windows& windows, const Places& places,
                                       const std::vector<bool>& disturbed) {
  std::vector<std::array<double, kParts.size()>> sums(kInnerFolds);
  tbb::parallel_for(0, kInnerFolds, [&](int fold) {
    const Places judged = ofFold(windows, places, fold, kInnerFolds, true);
    const auto odds =
        logOddsAlong(windows, calmOnes(ofFold(windows, places, fold, kInnerFolds, false), disturbed), judged, kParts);
    for (std::size_t k = 0; k < kParts.size(); ++k) {
      sums[fold][k] = logisticLoss(odds[k], labelsOf(windows, judged)) * static_cast<double>(judged.size());
    }
  });
  std::vector<PenaltyLoss> losses;
  for (std::size_t k = 0; k < kParts.size(); ++k) {
    double sum = 0.0;
    for (const auto& fold : sums) sum += fold[k];
    losses.push_back({kParts[k], sum / static_cast<double>(places.size())});
  }
  return losses;
}

double bestPart(const std::vector<PenaltyLoss>& losses) {
  return std::ranges::min_element(losses, {}, &PenaltyLoss::loss)->part;
}

void requireTrials(const EegRecording& recording, const Windows& windows, int folds) {
  std::set<std::size_t> up, down;
  for (const LabelledCovariance& window : windows) (window.instruction > 0 ? up : down).insert(window.trial);
  const auto needed = static_cast<std::size_t>(2 * folds);
  if (std::min(up.size(), down.size()) < needed) {
    throw DataError(
        fmt::format("{}: found {} trials up and {} down that last a window, expected {} of each or more: "
                    "their order says how well it will do",
                    recording.name, up.size(), down.size(), needed));
  }
}

/// Accuracy by trials: windows of one trial are alike.
void judge(Training& training, const Windows& windows, const VectorXd& odds) {
  std::vector<double> right, of;
  std::size_t last = windows.size();
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (last == windows.size() || windows[w].trial != windows[last].trial) {
      right.push_back(0.0);
      of.push_back(0.0);
    }
    last = w;
    right.back() += odds[w] * windows[w].instruction > 0.0;
    of.back() += 1.0;
  }
  const double count = static_cast<double>(right.size());
  const double all = std::accumulate(of.begin(), of.end(), 0.0);
  training.trials = right.size();
  training.accuracy = std::accumulate(right.begin(), right.end(), 0.0) / all;
  // Of a ratio of sums over trials: the deviation of what each adds to it.
  double squares = 0.0;
  for (std::size_t t = 0; t < right.size(); ++t) squares += std::pow(right[t] - training.accuracy * of[t], 2);
  training.accuracy_half = studentQuantile(count - 1.0) * std::sqrt(squares * count / (count - 1.0)) / all;
  const double up = static_cast<double>(std::ranges::count(windows, 1, &LabelledCovariance::instruction)) / all;
  training.chance = std::max(up, 1.0 - up);
}

}  // namespace

Training trainDecoder(const EegRecording& recording, const TrainingOptions& options,
                      const std::function<void(double, const char*)>& progress) {
  if (recording.instructions.empty()) {
    throw DataError(fmt::format("{}: found no column label, expected what was asked for at each time", recording.name));
  }
  const Windows windows = labelledWindows(recording, options.settings);
  requireTrials(recording, windows, options.folds);
  const std::vector<bool> disturbed = disturbedWindows(windows);
  Places all(windows.size());
  std::iota(all.begin(), all.end(), 0U);
  const auto say = [&](double done, const char* what) {
    if (progress) progress(done, what);
  };

  Training training;
  training.windows = windows.size();
  training.disturbed = static_cast<std::size_t>(std::ranges::count(disturbed, true));
  VectorXd held_out(std::ssize(windows));
  for (int fold = 0; fold < options.folds; ++fold) {
    say(static_cast<double>(fold) / (options.folds + 1), "held-out trials");
    const Places rest = ofFold(windows, all, fold, options.folds, false);
    const Places judged = ofFold(windows, all, fold, options.folds, true);
    const std::array<double, 1> part = {bestPart(penaltyLosses(windows, rest, disturbed))};
    const VectorXd odds = logOddsAlong(windows, calmOnes(rest, disturbed), judged, part)[0];
    for (std::size_t i = 0; i < judged.size(); ++i) {
      held_out[judged[i]] = odds[i];
    }
  }
  judge(training, windows, held_out);
  training.loss = logisticLoss(held_out, labelsOf(windows, all));

  say(static_cast<double>(options.folds) / (options.folds + 1), "weights");
  training.penalties = penaltyLosses(windows, all, disturbed);
  const Places learnt = calmOnes(all, disturbed);
  const Whitening whitening(windows, learnt);
  const MatrixXd packed = whitening.packed(windows, learnt);
  const VectorXd labels = labelsOf(windows, learnt);
  const Index dimension = windows[0].covariance.rows();
  Decoder& decoder = training.decoder;
  decoder = {options.settings, recording.channels, recording.rate, {}, 0.0, 0.0};
  decoder.penalty = bestPart(training.penalties) * largestTraceNormPenalty(packed, labels, dimension);
  const TraceNormFit fit = fitTraceNormLogistic(packed, labels, dimension, decoder.penalty, {kDeliveredGap, 20'000});
  if (!fit.converged) {
    throw NumericsError(fmt::format("{}: the duality gap is {:.2g} of the objective after {} steps, expected {:.0e}",
                                    recording.name, fit.gap, fit.iterations, kDeliveredGap));
  }
  training.gap = fit.gap;
  const VectorXd values = symmetricEigen(unpackSymmetric(fit.weights, dimension)).values.cwiseAbs();
  training.rank = (values.array() > 1e-9 * values.maxCoeff()).count();
  whitening.unfold(fit, decoder);
  return training;
}

}  // namespace simgap
