/// simgap/decoder/1
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "simgap/decode/decoder.h"

namespace simgap {
namespace {

constexpr Range kProbability{0.5, 1.0, true, "a number in (0.5, 1]"};
constexpr double kSymmetric = 1e-9;

std::vector<double> numbersOfRow(const YamlNode& row, std::size_t count) {
  std::vector<double> numbers;
  for (const YamlNode& item : row.items()) numbers.push_back(item.number());
  if (numbers.size() != count) row.fail(fmt::format("found {} numbers, expected {}", numbers.size(), count));
  return numbers;
}

Eigen::MatrixXd readWeights(const YamlNode& node, std::size_t channels) {
  const std::vector<YamlNode> rows = node.items();
  if (rows.size() != channels)
    node.fail(fmt::format("found {} rows, expected one per channel, {}", rows.size(), channels));
  Eigen::MatrixXd weights(rows.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double> numbers = numbersOfRow(rows[i], channels);
    for (std::size_t j = 0; j < channels; ++j) weights(i, j) = numbers[j];
  }
  if ((weights - weights.transpose()).cwiseAbs().maxCoeff() > kSymmetric * weights.cwiseAbs().maxCoeff()) {
    node.fail("expected a symmetric matrix");
  }
  return weights;
}

}  // namespace

std::string toYaml(const Decoder& decoder) {
  const DecoderSettings& s = decoder.settings;
  std::string text = fmt::format(
      "format: simgap/decoder/1\n"
      "# Brain-Controlled Exoskeleton Robot for BMI Rehabilitation, eq. (1)-(9): ln P(up) / P(down) = tr(W C) + b\n"
      "rate_Hz: {}\nband: {{low_Hz: {}, high_Hz: {}, order: {}}}\nkept_rate_Hz: {}\nwindow_s: {}\nthreshold: {}\n"
      "penalty: {}\nbias: {}\nchannels:\n",
      decoder.rate, s.low, s.high, s.order, s.rate, s.window, s.threshold, decoder.penalty, decoder.bias);
  for (const std::string& channel : decoder.channels) text += fmt::format("  - {}\n", yamlText(channel));
  text += "weights:  # W [1/V^2]\n";
  for (Eigen::Index i = 0; i < decoder.weights.rows(); ++i) {
    const Eigen::VectorXd row = decoder.weights.row(i);
    text += fmt::format("  - [{}]\n", fmt::join(row.begin(), row.end(), ", "));
  }
  return text;
}

Decoder readDecoder(const YamlNode& root) {
  root.at("format").oneOf({"simgap/decoder/1"});
  Decoder decoder;
  decoder.rate = root.quantity("rate", "Hz", kPositive);
  DecoderSettings& s = decoder.settings;
  const YamlNode band = root.at("band");
  s.low = band.quantity("low", "Hz", kPositive);
  s.high = band.quantity("high", "Hz", kPositive);
  if (s.high <= s.low) band.fail("expected high_Hz above low_Hz");
  s.order = static_cast<int>(band.at("order").integer(1, 8));
  s.rate = root.quantity("kept_rate", "Hz", kPositive);
  s.window = root.quantity("window", "s", kPositive);
  s.threshold = root.at("threshold").number(kProbability);
  decoder.penalty = root.at("penalty").number(kNonNegative);
  decoder.bias = root.at("bias").number();
  for (const YamlNode& channel : root.at("channels").items()) decoder.channels.push_back(channel.text());
  if (decoder.channels.size() < 2) root.at("channels").fail("expected two channels or more");
  decoder.weights = readWeights(root.at("weights"), decoder.channels.size());
  root.expectAllRead();
  return decoder;
}

}  // namespace simgap
