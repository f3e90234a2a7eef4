#include "simgap/report/decode/decode_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simgap/core/csv.h"
#include "simgap/core/decompositions.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

constexpr Eigen::Index kPatterns = 4;

std::string percent(const Json& share) { return numberText(Json(100.0 * numberOf(share)), "{:.1f} %"); }

const char* word(int state) { return state > 0 ? "up" : state < 0 ? "down" : "none"; }

Table trainTable(const Json& result) {
  const Json& accuracy = result.at("accuracy");
  return {"",
          {"held out", ""},
          {{"windows judged", cellText(result.at("windows"))},
           {"trials", cellText(result.at("trials"))},
           {"right", fmt::format("{} ({} to {})", percent(accuracy.at("value")), percent(accuracy.at("ci95")[0]),
                                 percent(accuracy.at("ci95")[1]))},
           {"always the same answer", percent(result.at("chance"))},
           {"loss (a coin: 0.693)", numberText(result.at("loss"), "{:.3f}")},
           {"directions of the weights", cellText(result.at("rank"))},
           {"duality gap", numberText(result.at("gap"), "{:.1e}")},
           {"windows too disturbed to learn from", cellText(result.at("disturbed"))}}};
}

Table runTable(const Json& result) {
  return {"",
          {"decoded", ""},
          {{"samples", cellText(result.at("samples"))},
           {"seconds", numberText(result.at("duration_s"), "{:.1f}")},
           {"switches", cellText(result.at("switches"))},
           {"time in the state up", percent(result.at("up"))},
           {"right side of 0.5", result.at("accuracy").is_null() ? "not told" : percent(result.at("accuracy"))},
           {"right state", result.at("state_share").is_null() ? "not told" : percent(result.at("state_share"))}}};
}

}  // namespace

Json toJson(const Training& training, const EegRecording& recording) {
  Json losses = Json::array();
  for (const PenaltyLoss& loss : training.penalties) losses.push_back({{"part", loss.part}, {"loss", loss.loss}});
  return {{"format", "simgap/decode-train/1"},
          {"recording", recording.name},
          {"channels", recording.channels.size()},
          {"rate_Hz", recording.rate},
          {"windows", training.windows},
          {"trials", training.trials},
          {"disturbed", training.disturbed},
          {"accuracy",
           {{"value", training.accuracy},
            {"ci95",
             {std::max(0.0, training.accuracy - training.accuracy_half),
              std::min(1.0, training.accuracy + training.accuracy_half)}}}},
          {"chance", training.chance},
          {"better_than_chance", training.betterThanChance()},
          {"loss", numberOrNull(training.loss)},
          {"penalty", training.decoder.penalty},
          {"penalties", losses},
          {"rank", training.rank},
          {"gap", training.gap}};
}

Json toJson(const Decoded& decoded, const EegRecording& recording) {
  const auto orNull = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  const double up = static_cast<double>(std::ranges::count(decoded.state, 1));
  return {{"format", "simgap/decode-run/1"},      {"recording", recording.name},
          {"samples", decoded.times.size()},      {"duration_s", decoded.times.back() - decoded.times.front()},
          {"switches", decoded.switches},         {"up", up / static_cast<double>(decoded.times.size())},
          {"accuracy", orNull(decoded.accuracy)}, {"state_share", orNull(decoded.state_share)}};
}

std::string decodeTrainAnswer(const Json& result) {
  const bool better = result.at("better_than_chance").get<bool>();
  return fmt::format(
      "{} of the windows that were held out are told right, by {} trials; always the same answer would "
      "be right in {}{}",
      percent(result.at("accuracy").at("value")), cellText(result.at("trials")), percent(result.at("chance")),
      better ? "" : ": no better than chance, so no decoder was written");
}

std::string decodeRunAnswer(const Json& result) {
  const std::string right = result.at("accuracy").is_null()
                                ? ""
                                : fmt::format(", the right side of 0.5 in {}", percent(result.at("accuracy")));
  return fmt::format("up in {} of the time, {} switches{}", percent(result.at("up")), cellText(result.at("switches")),
                     right);
}

std::string decodeTrainText(const Json& result) { return answerText(decodeTrainAnswer(result), {trainTable(result)}); }
std::string decodeRunText(const Json& result) { return answerText(decodeRunAnswer(result), {runTable(result)}); }

std::string decodedCsv(const Decoded& decoded) {
  std::vector<std::string> header = {"time_s", "probability_up", "state"};
  if (!decoded.instruction.empty()) header.emplace_back("label");
  CsvWriter csv(header);
  for (std::size_t i = 0; i < decoded.times.size(); ++i) {
    csv.add(decoded.times[i]).add(decoded.probability[i]).add(word(decoded.state[i]));
    if (!decoded.instruction.empty()) csv.add(word(decoded.instruction[i]));
    csv.endRow();
  }
  return csv.text();
}

std::string patternsCsv(const Decoder& decoder) {
  const SymmetricEigen eigen = symmetricEigen(decoder.weights);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(eigen.values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater(), [&](Eigen::Index k) { return std::abs(eigen.values[k]); });
  order.resize(std::min(kPatterns, eigen.values.size()));
  std::vector<std::string> header = {"channel"};
  for (const Eigen::Index k : order) {
    header.push_back(fmt::format("{}_{}", eigen.values[k] > 0.0 ? "up" : "down", header.size()));
  }
  CsvWriter csv(header);
  for (Eigen::Index c = 0; c < decoder.weights.rows(); ++c) {
    csv.add(decoder.channels[c]);
    for (const Eigen::Index k : order) csv.add(eigen.vectors(c, k));
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
