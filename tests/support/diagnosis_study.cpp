#include "support/diagnosis_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

double rms(const std::filesystem::path& folder, const std::string& binary, const std::string& model,
           const std::vector<std::string>& bench) {
  std::vector<std::string> command = {binary, "predict", "d/" + model, "fresh.csv", "-q", "--force", "-o", "p"};
  command.insert(command.end(), bench.begin(), bench.end());
  runOrThrow(command, folder);
  return Json::parse(readText(folder / "p/result.json")).at("rms_error");
}

std::vector<std::string> command(const std::string& binary, const HiddenLog& log, const std::string& file,
                                 const std::string& out) {
  std::vector<std::string> words = {binary, "diagnose", log.law, "--log", file, "-q", "--force", "-o", out};
  words.insert(words.end(), log.options.begin(), log.options.end());
  return words;
}

/// Whether the interval of the parameter holds its true value; none where the first cause does not state it.
std::optional<bool> intervalHolds(const std::pair<std::string, double>& truth, const Json& cause) {
  for (const Json& parameter : cause.at("parameters")) {
    if (parameter.at("name") != truth.first) continue;
    const double low = parameter.at("ci95")[0], high = parameter.at("ci95")[1];
    // A weight of -w that hangs down at theta_0 is one of w at theta_0 + pi.
    const double value = truth.first == "mgl" && high < 0.0 ? -truth.second : truth.second;
    return low <= value && value <= high;
  }
  return std::nullopt;
}

Json toJson(const StudyCase& c) {
  Json json = {{"rig", c.rig},     {"hidden", c.hidden},         {"seed", c.seed},       {"worth", c.worth},
               {"named", c.named}, {"channel", c.channel_right}, {"verdict", c.verdict}, {"seconds", c.seconds}};
  if (c.interval_right) json["interval"] = *c.interval_right;
  if (c.fresh_right) json["fresh"] = *c.fresh_right;
  return json;
}

StudyCase fromJson(const Json& json) {
  StudyCase c{json.at("rig"),
              json.at("hidden"),
              json.at("verdict"),
              json.at("seed"),
              json.at("worth"),
              json.at("named"),
              json.at("channel"),
              {},
              {},
              json.at("seconds")};
  if (json.contains("interval")) c.interval_right = json.at("interval").get<bool>();
  if (json.contains("fresh")) c.fresh_right = json.at("fresh").get<bool>();
  return c;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// "k/n" → whether case i (from 0) is of this part.
bool isMine(std::size_t i) {
  const std::string part = environment("SIMGAP_STUDY_PART");
  const std::size_t slash = part.find('/');
  if (slash == std::string::npos) return true;
  return i % std::stoul(part.substr(slash + 1)) + 1 == std::stoul(part.substr(0, slash));
}

}  // namespace

HiddenLog hiddenLog(const reality::DriveDraw& draw) {
  HiddenLog log{"prescribed", draw.effects, draw.channel, draw.rig.seed, "classic", {}, {}, {}, {}, {}, {}};
  if (draw.effects.size() == 1) log.stated = reality::statedParameter(draw);
  log.csv = [draw] { return reality::recordDrive(draw.rig, draw.secret).csv(); };
  log.plain_csv = [draw] {
    reality::DriveSecret plain;
    plain.bristle_travel = std::min(plain.bristle_travel, draw.secret.bristle_travel);
    return reality::recordDrive(draw.rig, plain).csv();
  };
  if (draw.effects[0] == "regime-change") return log;
  log.fresh_csv = [draw] {
    reality::DriveRig rig = draw.rig;
    rig.seed += 500000;
    return reality::recordDrive(rig, draw.secret).csv();
  };
  return log;
}

HiddenLog hiddenLog(const reality::ServoDraw& draw) {
  HiddenLog log{"servo",
                draw.effects,
                draw.channel,
                draw.rig.seed,
                draw.law,
                reality::diagnoseOptions(draw.rig),
                reality::benchYaml(draw.rig),
                {},
                {},
                {},
                {}};
  if (draw.effects.size() == 1) log.stated = reality::statedParameter(draw);
  log.csv = [draw] { return reality::recordServo(draw.rig, draw.secret).csv(); };
  log.plain_csv = [draw] { return reality::recordServo(draw.rig, draw.secret).csv(true); };
  return log;
}

bool StudyCase::namedAlone(const std::string& effect) const {
  return verdict == "cause-found" && named.size() == 1 && named[0][0] == effect;
}

bool StudyCase::namedInGroup(const std::string& effect) const {
  if (namedAlone(effect)) return true;
  if (verdict != "ambiguous" || named.size() != 1 || named[0].size() > 3) return false;
  return std::ranges::find(named[0], effect) != named[0].end();
}

bool StudyCase::names(const std::string& effect) const {
  return std::ranges::any_of(named, [&](const auto& group) { return std::ranges::find(group, effect) != group.end(); });
}

std::string StudyCase::text() const {
  std::string causes;
  for (const std::vector<std::string>& group : named) causes += fmt::format(" {}", fmt::join(group, "~"));
  return fmt::format("{:<10} {:<28} seed {:>6} worth {:5.1f} % -> {}{}{} ({:.0f} s)", rig, hidden, seed, 100.0 * worth,
                     verdict, causes, interval_right == false ? ", interval misses" : "", seconds);
}

DiagnosisStudy::DiagnosisStudy(std::filesystem::path folder, std::string binary)
    : folder_(std::move(folder)), binary_(std::move(binary)) {
  std::filesystem::create_directories(folder_);
  std::ifstream file(environment("SIMGAP_STUDY_FILE"));
  for (std::string line; std::getline(file, line);) {
    const Json json = Json::parse(line);
    kept_[json.at("key")] = fromJson(json);
  }
}

std::vector<StudyCase> DiagnosisStudy::ask(const std::vector<std::function<HiddenLog()>>& draws,
                                           const std::vector<std::string>& keys) {
  std::vector<StudyCase> cases;
  partial_ = false;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const auto kept = kept_.find(keys[i]);
    if (kept == kept_.end() && !isMine(i)) {
      partial_ = true;
      continue;
    }
    cases.push_back(kept != kept_.end() ? kept->second : run(draws[i]()));
    fmt::print("{}\n", cases.back().text());
    std::fflush(stdout);
    if (kept != kept_.end() || environment("SIMGAP_STUDY_FILE").empty()) continue;
    Json json = toJson(cases.back());
    json["key"] = keys[i];
    std::ofstream(environment("SIMGAP_STUDY_FILE"), std::ios::app) << json.dump() << "\n";
  }
  return cases;
}

double DiagnosisStudy::baselineError(const HiddenLog& log) const {
  writeText(folder_ / "plain.csv", log.plain_csv());
  std::vector<std::string> words = command(binary_, log, "plain.csv", "b");
  words.insert(words.end(), {"--effects", "channel-delay", "--max-causes", "1"});  // what is asked for does not matter
  runOrThrow(words, folder_);
  return Json::parse(readText(folder_ / "b/result.json")).at("baseline").at("mse_heldout");
}

StudyCase DiagnosisStudy::run(const HiddenLog& log) const {
  writeText(folder_ / "log.csv", log.csv());
  if (!log.bench.empty()) writeText(folder_ / "bench.yaml", log.bench);
  const auto start = std::chrono::steady_clock::now();
  runOrThrow(command(binary_, log, "log.csv", "d"), folder_);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const Json result = Json::parse(readText(folder_ / "d/result.json"));
  StudyCase c{log.rig,
              fmt::format("{}", fmt::join(log.effects, " + ")),
              result.at("verdict"),
              log.seed,
              0.0,
              {},
              false,
              {},
              {},
              took.count()};
  for (const Json& cause : result.at("causes")) {
    c.named.push_back({cause.at("effect")});
    for (const Json& rival : cause.at("ambiguous_with")) c.named.back().push_back(rival);
  }
  for (const Json& left : result.at("left_over").at("channels")) {
    c.channel_right = c.channel_right || left.at("channel") == log.channel;
  }
  if (log.effects[0] == "none" || c.verdict == "data-fault") return c;
  const double error = result.at("baseline").at("mse_heldout");
  c.worth = 1.0 - baselineError(log) / error;
  if (log.effects.size() > 1 || !c.namedAlone(log.effects[0])) return c;
  const Json cause = result.at("causes")[0];
  if (log.stated) c.interval_right = intervalHolds(*log.stated, cause);
  if (!log.fresh_csv) return c;
  writeText(folder_ / "fresh.csv", log.fresh_csv());
  const double before = rms(folder_, binary_, "baseline.yaml", {}), after = rms(folder_, binary_, "model.yaml", {});
  const double fresh = 100.0 * (1.0 - after * after / (before * before));
  c.fresh_right = cause.at("gain_ci95")[0] <= fresh && fresh <= cause.at("gain_ci95")[1];
  return c;
}

double upperLimit(int k, int n) {
  // The p at which k or fewer of n has a probability of 5 %, by bisection.
  double low = static_cast<double>(k) / n, high = 1.0;
  for (int round = 0; round < 60; ++round) {
    const double p = 0.5 * (low + high);
    double tail = 0.0;
    for (int i = 0; i <= k; ++i) {
      tail += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) +
                       (n - i) * std::log1p(-p));
    }
    (tail > 0.05 ? low : high) = p;
  }
  return high;
}

}  // namespace simgap::test
