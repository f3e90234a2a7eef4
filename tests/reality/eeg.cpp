#include "reality/eeg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

namespace simgap::reality {
namespace {

constexpr double kWholeTurn = 2.0 * std::numbers::pi;

struct ScalpPlace {
  double x, y;  // on the scalp, the nose towards +y
};

/// How strongly a source at `source` is heard at `electrode`: a dipole's potential falls with the distance and has two
/// signs.
double heard(const ScalpPlace& electrode, const ScalpPlace& source, double direction, double depth) {
  const double dx = electrode.x - source.x, dy = electrode.y - source.y;
  const double distance = std::sqrt(dx * dx + dy * dy + depth * depth);
  return (std::cos(direction) * dx + std::sin(direction) * dy + depth) / (distance * distance * distance);
}

/// Noise whose power falls as 1/f: a sum of first-order ones an octave apart, each of equal variance.
class PinkNoise {
 public:
  PinkNoise(double rate, std::mt19937_64& random) : random_(random) {
    for (double corner = 0.25; corner < 64.0; corner *= 2.0) keeps_.push_back(std::exp(-kWholeTurn * corner / rate));
    state_.assign(keeps_.size(), 0.0);
  }
  double next() {
    double sum = 0.0;
    for (std::size_t k = 0; k < keeps_.size(); ++k) {
      state_[k] = keeps_[k] * state_[k] + std::sqrt(1.0 - keeps_[k] * keeps_[k]) * normal_(random_);
      sum += state_[k];
    }
    return sum / std::sqrt(static_cast<double>(keeps_.size()));
  }

 private:
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  std::vector<double> keeps_, state_;
};

/// A rhythm: an oscillator that noise drives, so that its height and phase wander.
class Rhythm {
 public:
  Rhythm(double frequency, double rate, std::mt19937_64& random)
      : turn_(kWholeTurn * frequency / rate), keep_(std::exp(-1.0 / (0.4 * rate))), random_(random) {}
  double next() {
    const double re = keep_ * (std::cos(turn_) * re_ - std::sin(turn_) * im_);
    const double im = keep_ * (std::sin(turn_) * re_ + std::cos(turn_) * im_);
    const double drive = std::sqrt(1.0 - keep_ * keep_);
    re_ = re + drive * normal_(random_);
    im_ = im + drive * normal_(random_);
    return re_;
  }

 private:
  double turn_, keep_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  double re_ = 0.0, im_ = 0.0;
};

struct HeadSource {
  std::vector<double> gains;  // per channel [uV]
  double frequency;           // [Hz]; 0: slow noise alone
  int state;                  // +1, -1: its rhythm falls then; 0: never
};

std::vector<HeadSource> drawHeadSources(const EegDesign& design, const std::vector<ScalpPlace>& electrodes,
                                        std::mt19937_64& head) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<HeadSource> sources;
  const int speaking = 2 * design.rhythms;
  for (int k = 0; k < speaking + design.background; ++k) {
    const int state = k < speaking ? (k % 2 == 0 ? 1 : -1) : 0;
    // The rhythm of a hand lies on the other side of the head.
    const ScalpPlace at = {state != 0 ? -0.5 * state + 0.3 * (unit(head) - 0.5) : 1.6 * (unit(head) - 0.5),
                           state != 0 ? 0.4 * (unit(head) - 0.5) : 1.6 * (unit(head) - 0.5)};
    const double direction = kWholeTurn * unit(head), depth = 0.4 + 0.4 * unit(head), size = state != 0 ? 1.0 : 1.5;
    HeadSource source{{}, k % 3 == 2 && state == 0 ? 0.0 : 9.0 + 14.0 * unit(head) * unit(head), state};
    for (const ScalpPlace& electrode : electrodes)
      source.gains.push_back(size * heard(electrode, at, direction, depth));
    sources.push_back(source);
  }
  return sources;
}

std::vector<ScalpPlace> drawElectrodes(int channels) {
  std::vector<ScalpPlace> places;
  for (int c = 0; c < channels; ++c) {  // a sunflower's seeds
    const double radius = std::sqrt((c + 0.5) / channels), angle = c * 2.39996;
    places.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return places;
}

std::vector<std::string> drawHeadLabels(const EegDesign& design, std::mt19937_64& random) {
  std::vector<int> order;
  for (int t = 0; t < design.trials; ++t) order.push_back(t % 2 == 0 ? 1 : -1);
  std::shuffle(order.begin(), order.end(), random);
  const auto rows = [&](double seconds) { return static_cast<std::size_t>(std::lround(seconds * design.rate)); };
  std::vector<std::string> labels(rows(2.0), "rest");
  for (const int state : order) {
    labels.insert(labels.end(), rows(design.trial_s), state > 0 ? "up" : "down");
    labels.insert(labels.end(), rows(design.pause_s), "rest");
  }
  return labels;
}

void addHeadSource(EegTable& table, const HeadSource& source, const EegDesign& design, std::mt19937_64& random) {
  Rhythm rhythm(std::max(source.frequency, 1.0), design.rate, random);
  PinkNoise slow(design.rate, random);
  double height = 1.0;
  const double follow = 1.0 - std::exp(-1.0 / (0.4 * design.rate));  // it falls and returns within half a second
  for (std::size_t i = 0; i < table.times.size(); ++i) {
    const int asked = table.labels[i] == "up" ? 1 : table.labels[i] == "down" ? -1 : 0;
    const double aim = source.state != 0 && asked == source.state ? 1.0 - design.effect : 1.0;
    height += follow * (aim - height);
    const double value = source.frequency > 0.0 ? height * rhythm.next() + 0.5 * slow.next() : 1.5 * slow.next();
    for (std::size_t c = 0; c < table.volts.size(); ++c) table.volts[c][i] += source.gains[c] * value;
  }
}

/// Lids: a bump of a quarter of a second, loud in front. Jumps of an electrode, which creep back.
void addHeadArtefacts(EegTable& table, const std::vector<ScalpPlace>& places, const EegDesign& design,
                      std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const std::size_t rows = table.times.size();
  double blink = -1.0;
  std::vector<double> jump(places.size(), 0.0);
  for (std::size_t i = 0; i < rows; ++i) {
    if (design.blinks_s > 0.0 && unit(random) < 1.0 / (design.blinks_s * design.rate)) blink = 0.0;
    if (design.pops_s > 0.0 && unit(random) < 1.0 / (design.pops_s * design.rate)) {
      jump[static_cast<std::size_t>(unit(random) * static_cast<double>(places.size()))] += 200.0 * (unit(random) - 0.5);
    }
    double lid = 0.0;
    if (blink >= 0.0) {
      lid = 100.0 * std::pow(std::sin(std::numbers::pi * blink / 0.25), 2);
      blink = blink < 0.25 ? blink + 1.0 / design.rate : -1.0;
    }
    for (std::size_t c = 0; c < places.size(); ++c) {
      table.volts[c][i] += lid * std::exp(3.0 * (places[c].y - 1.0)) + jump[c];
      jump[c] *= std::exp(-1.0 / (3.0 * design.rate));
    }
  }
}

}  // namespace

EegTable recordEeg(const EegDesign& design) {
  std::mt19937_64 head(7919U * design.head), random(104729U * design.seed + 1U);
  const std::vector<ScalpPlace> places = drawElectrodes(design.channels);
  EegTable table;
  table.labels = drawHeadLabels(design, random);
  for (std::size_t i = 0; i < table.labels.size(); ++i) table.times.push_back(static_cast<double>(i) / design.rate);
  for (int c = 0; c < design.channels; ++c) table.channels.push_back("E" + std::to_string(c + 1));
  table.volts.assign(places.size(), std::vector<double>(table.times.size(), 0.0));
  for (const HeadSource& source : drawHeadSources(design, places, head)) addHeadSource(table, source, design, random);
  addHeadArtefacts(table, places, design, random);
  std::normal_distribution<double> amplifier(0.0, 0.5);
  for (auto& channel : table.volts) {
    for (double& value : channel) value = 0.1 * std::round(10.0 * (value + amplifier(random)));
  }
  return table;
}

std::string EegTable::csv() const {
  std::string text = "time_s";
  for (const std::string& channel : channels) text += ",eeg_" + channel + "_uV";
  text += ",label\n";
  std::array<char, 40> cell;
  for (std::size_t i = 0; i < times.size(); ++i) {
    text.append(cell.data(), static_cast<std::size_t>(std::snprintf(cell.data(), cell.size(), "%.6f", times[i])));
    for (const auto& channel : volts) {
      text.append(cell.data(), static_cast<std::size_t>(std::snprintf(cell.data(), cell.size(), ",%.1f", channel[i])));
    }
    text += "," + labels[i] + "\n";
  }
  return text;
}

}  // namespace simgap::reality
