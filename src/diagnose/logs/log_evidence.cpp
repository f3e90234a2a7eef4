#include "log_evidence.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/ml.hpp>
#include <optional>

#include "diagnose/paired_error.h"
#include "log_hypotheses.h"
#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kBins = 20;
constexpr int kForestFolds = 3;
constexpr std::size_t kForestRows = 12000;  // per fold; more rows make the bound slower, not tighter

std::vector<std::size_t> keptRows(const PreparedLog& log) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < log.data.keep.size(); ++i) {
    if (log.data.keep[i]) rows.push_back(i);
  }
  return rows;
}

/// Rows where a drive turns, stops or starts, and as far from them as a smoother blurs the jump of its acceleration
/// there, are no evidence of structure: what a model lacks in them is as likely the smoother's. Where it stops and
/// starts, rows that count (of motion) border on rows that do not.
void leaveOutBlurred(const PreparedLog& log, std::vector<std::size_t>& kept) {
  if (log.blurred_seconds <= 0.0) return;
  const ActuatorRows& rows = log.data.rows;
  std::vector<bool> blurred(log.data.keep.size(), false);
  const auto reach = static_cast<Index>(std::ceil(log.blurred_seconds / rows.step));
  for (Index i = 1; i < rows.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (rows.direction[i] == rows.direction[i - 1] && log.data.keep[at] == log.data.keep[at - 1]) continue;
    for (Index k = std::max<Index>(0, i - reach); k < std::min(rows.rows(), i + reach); ++k) {
      blurred[k] = true;
    }
  }
  std::erase_if(kept, [&](std::size_t i) { return blurred[i]; });
}

ArrayXd sinceReversal(const ActuatorRows& rows) {
  ArrayXd time = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool same = rows.session[k] == rows.session[k - 1] && rows.direction[i] == rows.direction[i - 1];
    time[i] = same ? time[i - 1] + rows.time[i] - rows.time[i - 1] : 0.0;
  }
  return time;
}

struct Means {
  double mean, ci95;
};

Means meanOf(const VectorXd& residual, std::span<const std::size_t> rows, double correlation) {
  double sum = 0.0, squares = 0.0;
  for (const std::size_t i : rows) {
    const double r = residual[i];
    sum += r;
    squares += r * r;
  }
  const auto n = static_cast<double>(rows.size());
  const double mean = sum / n, variance = std::max(squares / n - mean * mean, 0.0);
  return {mean, 1.96 * std::sqrt(variance / std::max(n / correlation, 1.0))};
}

/// A measured channel as its neighbours see it: the noise of a row is in what a model makes of that row, too, and read
/// back from there it would look like structure.
ArrayXd besidesOwnNoise(const ArrayXd& values, const std::vector<int>& session) {
  const auto together = [&](Index i, Index k) {
    return k >= 0 && k < values.size() && session[static_cast<std::size_t>(i)] == session[static_cast<std::size_t>(k)];
  };
  ArrayXd besides = values;
  for (Index i = 0; i < values.size(); ++i) {
    const bool before = together(i, i - 1), behind = together(i, i + 1);
    if (before || behind) {
      besides[i] = ((before ? values[i - 1] : 0.0) + (behind ? values[i + 1] : 0.0)) / (before + behind);
    }
  }
  return besides;
}

cv::Mat features(const std::vector<EvidenceChannel>& channels, std::span<const std::size_t> rows) {
  cv::Mat x(static_cast<int>(rows.size()), static_cast<int>(channels.size()), CV_32F);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      x.at<float>(static_cast<int>(i), static_cast<int>(c)) = static_cast<float>(channels[c].values[rows[i]]);
    }
  }
  return x;
}

/// Squared errors, shape (rows).
ArrayXd squaredErrors(const cv::Ptr<cv::ml::RTrees>& forest, const cv::Mat& x, const VectorXd& y) {
  cv::Mat predicted;
  forest->predict(x, predicted);
  ArrayXd squares(y.size());
  for (Index i = 0; i < y.size(); ++i) {
    const double e = y[i] - static_cast<double>(predicted.at<float>(static_cast<int>(i)));
    squares[i] = e * e;
  }
  return squares;
}

/// What a forest leaves of rows that it has not seen, on pieces of the log.
class PiecewiseErrors {
 public:
  explicit PiecewiseErrors(const PreparedLog& log) {
    const ActuatorRows& rows = log.data.rows;
    const double seconds = LogSearch::pieceSeconds(rows);
    Index piece = -1;
    double begin = 0.0;
    for (Index i = 0; i < rows.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const bool anew = i == 0 || rows.session[k] != rows.session[k - 1];
      if (anew || rows.elapsed[i] - begin >= seconds) begin = rows.elapsed[i], ++piece;
      piece_.push_back(piece);
    }
    const ArrayXd none = ArrayXd::Zero(piece + 1);
    before_ = after_ = {none, none};
  }
  /// \param before, after  squared errors, shape (rows)
  void add(const std::vector<std::size_t>& rows, const ArrayXd& before, const ArrayXd& after) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Index piece = piece_[rows[k]];
      before_.sum[piece] += before[static_cast<Index>(k)], after_.sum[piece] += after[static_cast<Index>(k)];
      before_.rows[piece] += 1.0, after_.rows[piece] += 1.0;
    }
  }
  /// What forests explain, 0 where a few pieces may have made it by chance.
  double share(std::uint64_t seed) const {
    const Interval gain = pairedGain(before_, after_, seed);
    return gain.lower95 > 0.0 ? gain.value : 0.0;
  }
  double total() const { return before_.sum.sum(); }
  double left() const { return after_.sum.sum(); }

 private:
  std::vector<Index> piece_;  ///< of a row
  GroupErrors before_, after_;
};

std::vector<std::size_t> thinned(const std::vector<std::size_t>& rows, std::size_t most) {
  if (rows.size() <= most) return rows;
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(rows[k * rows.size() / most]);
  return some;
}

VectorXd valuesAt(const VectorXd& all, std::span<const std::size_t> rows) {
  VectorXd some(static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) some[i] = all[rows[i]];
  return some;
}

/// Rows far off, such as those of a reversal at the wrong moment, are taken for less: a few of them in a row would be
/// all that a forest learns.
VectorXd bounded(VectorXd residual, std::span<const std::size_t> rows) {
  constexpr double kFar = 4.0;  // robust standard deviations
  std::vector<double> sizes;
  for (const std::size_t i : rows) sizes.push_back(residual[i]);
  const double far = kFar * robustDeviation(std::move(sizes));
  return residual.cwiseMax(-far).cwiseMin(far);
}

/// A residual without what another smoothing of the motion would have made of it. The upper octave of an acceleration
/// that was worked out from positions holds nearly all of the encoder's noise (as the fourth power of the frequency),
/// and is what the smoother blurs: what goes with it is no structure. \param kept  rows that count
VectorXd besidesSmoothing(const PreparedLog& log, const VectorXd& residual, std::span<const std::size_t> kept) {
  constexpr double kBlunter = 1.4;
  const ActuatorRows& rows = log.data.rows;
  if (log.blurred_seconds <= 0.0) return residual;
  const std::vector<Block> runs = splitRuns(spanOf(rows.time), rows.session);
  const auto blunter = [&](double times) {
    const std::vector<double> smoothed =
        smoothRuns(spanOf(rows.time), spanOf(rows.acceleration), runs, 1.0 / (log.blurred_seconds * times));
    return ArrayXd(Eigen::Map<const ArrayXd>(smoothed.data(), std::ssize(smoothed)));
  };
  const ArrayXd once = blunter(kBlunter), twice = blunter(kBlunter * kBlunter);
  Eigen::MatrixXd octave(residual.size(), 2);
  octave << rows.acceleration - once, once - twice;
  Eigen::MatrixXd x(std::ssize(kept), 2);
  for (std::size_t i = 0; i < kept.size(); ++i) x.row(static_cast<Index>(i)) = octave.row(static_cast<Index>(kept[i]));
  return residual - octave * solveLeastSquares(x, valuesAt(residual, kept));
}

}  // namespace

std::vector<EvidenceChannel> evidenceChannels(const PreparedLog& log) {
  const ActuatorRows& rows = log.data.rows;
  std::vector<EvidenceChannel> channels;
  const std::string& speed_unit = log.data.velocity_unit;
  const auto unitOf = [&](const std::string& name) -> std::string {
    if (name == "motor_velocity") return speed_unit;
    if (name == "external_torque") return log.data.load_unit;
    return name == "time" ? "s" : "";
  };
  for (const ContextChannel& c : log.context) channels.push_back({c.name, c.values, unitOf(c.name)});
  channels.push_back({"direction", rows.direction, {}});
  channels.push_back({"acceleration", rows.acceleration, speed_unit + "2"});
  channels.push_back({"time_since_reversal_s", sinceReversal(rows), {}});
  channels.push_back({"rest_s", rows.rest, {}});
  // 1: driving forwards, 2: driven forwards, 3: driving backwards, 4: driven backwards
  const ArrayXd driven = (rows.load * rows.direction < 0.0).cast<double>();
  channels.push_back({"power_quadrant", 1.0 + driven + 2.0 * (rows.direction < 0.0).cast<double>(), {}});
  ArrayXd session(rows.rows());
  for (Index i = 0; i < rows.rows(); ++i) session[i] = rows.session[i];
  channels.push_back({"session", session, {}});
  std::erase_if(channels, [](const EvidenceChannel& c) { return !(c.values.maxCoeff() > c.values.minCoeff()); });
  return channels;
}

namespace {

/// Bins of equal counts of a channel. \param rows  by its values
void addBins(const EvidenceChannel& channel, const std::string& against, const std::vector<std::size_t>& rows,
             const VectorXd& before, const VectorXd& after, double correlation, std::vector<EvidenceBin>& bins) {
  const auto value = [&](std::size_t i) { return channel.values[i]; };
  for (std::size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    end = std::min(rows.size(), begin + rows.size() / kBins + 1);
    while (end < rows.size() && value(rows[end]) == value(rows[end - 1])) ++end;
    const std::span<const std::size_t> part(rows.data() + begin, end - begin);
    double center = 0.0;
    for (const std::size_t i : part) center += value(i) / static_cast<double>(part.size());
    const Means b = meanOf(before, part, correlation), a = meanOf(after, part, correlation);
    bins.push_back({against, center, b.mean, b.ci95, a.mean, a.ci95, part.size(), channel.unit});
  }
}

}  // namespace

std::vector<EvidenceBin> binEvidence(const PreparedLog& log, const std::vector<EvidenceChannel>& channels,
                                     const VectorXd& before, const VectorXd& after, double correlation) {
  std::vector<std::size_t> rows = keptRows(log);
  // What friction lacks has one sign forwards and the other backwards: its mean over both says nothing.
  const VectorXd direction = log.data.rows.direction.matrix();
  const VectorXd drag_before = before.cwiseProduct(direction), drag_after = after.cwiseProduct(direction);
  const std::string drag = fmt::format("residual in the direction of motion [{}] against ", log.data.effort_unit);
  std::vector<EvidenceBin> bins;
  for (const EvidenceChannel& channel : channels) {
    std::ranges::sort(rows);  // rows of one value stand in the log's order
    std::ranges::stable_sort(rows, {}, [&](std::size_t i) { return channel.values[i]; });
    addBins(channel, channel.name, rows, before, after, correlation, bins);
    if (channel.name != "direction") {
      addBins(channel, drag + channel.name, rows, drag_before, drag_after, correlation, bins);
    }
  }
  return bins;
}

namespace {

/// What a forest leaves of the rows of one fold, which it has not seen.
struct ForestFold {
  std::vector<std::size_t> rows;
  ArrayXd before, after;         ///< squared errors, shape (rows)
  std::vector<double> shuffled;  ///< sums of them with one channel's values exchanged, shape (channels)
};

cv::Ptr<cv::ml::RTrees> trainedForest(const std::vector<EvidenceChannel>& channels,
                                      const std::vector<std::size_t>& rows, const VectorXd& residual, int seed) {
  cv::Mat target(static_cast<int>(rows.size()), 1, CV_32F);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    target.at<float>(static_cast<int>(i)) = static_cast<float>(residual[rows[i]]);
  }
  const cv::Ptr<cv::ml::RTrees> forest = cv::ml::RTrees::create();
  forest->setMaxDepth(10);
  forest->setMinSampleCount(std::max(20, static_cast<int>(rows.size() / 150)));
  forest->setActiveVarCount(std::max(2, static_cast<int>(channels.size() / 2)));
  forest->setTermCriteria({cv::TermCriteria::MAX_ITER, 40, 0.0});
  cv::setRNGSeed(seed);  // of this thread, which trains it
  forest->train(features(channels, rows), cv::ml::ROW_SAMPLE, target);
  return forest;
}

/// \returns nothing where there are too few rows to train on, or none to judge by
std::optional<ForestFold> judgeFold(const std::vector<EvidenceChannel>& channels,
                                    const std::vector<std::size_t>& training, const std::vector<std::size_t>& test,
                                    const VectorXd& residual, int seed) {
  if (training.size() < 100 || test.empty()) return std::nullopt;
  const cv::Ptr<cv::ml::RTrees> forest = trainedForest(channels, training, residual, seed);
  const VectorXd y = valuesAt(residual, test);
  cv::Mat x = features(channels, test);
  ForestFold fold{test, y.array().square(), squaredErrors(forest, x, y), {}};
  for (int c = 0; c < x.cols; ++c) {
    // Shuffled by a turn of half the rows: other values of the same channel, in other blocks.
    const cv::Mat original = x.col(c).clone();
    for (int i = 0; i < x.rows; ++i) x.at<float>(i, c) = original.at<float>((i + x.rows / 2) % x.rows);
    fold.shuffled.push_back(squaredErrors(forest, x, y).sum());
    original.copyTo(x.col(c));
  }
  return fold;
}

}  // namespace

Ceiling explainable(const PreparedLog& log, const std::vector<EvidenceChannel>& channels, const VectorXd& residual,
                    std::uint64_t seed) {
  std::vector<std::size_t> kept = keptRows(log);
  leaveOutBlurred(log, kept);
  if (kept.empty()) return {};
  const VectorXd near = bounded(besidesSmoothing(log, residual, kept), kept);
  if (near.isZero(0.0)) return {};  // nothing is left
  std::vector<EvidenceChannel> used;
  for (const EvidenceChannel& c : channels) {
    if (c.name == "session" || c.name == "power_quadrant") continue;  // others say the same
    used.push_back(c);
    const bool measured = std::ranges::find(log.context, c.name, &ContextChannel::name) != log.context.end();
    if (measured) used.back().values = besidesOwnNoise(c.values, log.data.rows.session);
  }
  std::vector<int> fold(log.data.keep.size(), 0);
  for (std::size_t b = 0; b < log.blocks.size(); ++b) {
    for (std::size_t i = log.blocks[b].begin; i < log.blocks[b].end; ++i) fold[i] = static_cast<int>(b % kForestFolds);
  }
  std::array<std::optional<ForestFold>, kForestFolds> folds;
  tbb::parallel_for(0, kForestFolds, [&](int f) {
    std::vector<std::size_t> training, test;
    for (const std::size_t i : kept) (fold[i] == f ? test : training).push_back(i);
    folds[f] =
        judgeFold(used, thinned(training, kForestRows), thinned(test, kForestRows), near, static_cast<int>(seed) + f);
  });
  PiecewiseErrors errors(log);
  std::vector<double> shuffled(used.size(), 0.0);
  for (const std::optional<ForestFold>& one : folds) {
    if (!one) return {};
    errors.add(one->rows, one->before, one->after);
    for (std::size_t c = 0; c < used.size(); ++c) shuffled[c] += one->shuffled[c];
  }
  Ceiling ceiling;
  ceiling.share = errors.share(seed);
  if (ceiling.share == 0.0) return ceiling;
  for (std::size_t c = 0; c < used.size(); ++c) {
    const double lost = (shuffled[c] - errors.left()) / errors.total();
    if (lost > 0.1 * ceiling.share && lost > 0.002) ceiling.channels.push_back({used[c].name, lost, {}});
  }
  std::ranges::stable_sort(ceiling.channels, std::greater<>{}, &Leftover::share);
  return ceiling;
}

}  // namespace simgap
