#include "support/log_answer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "simgap/core/csv.h"
#include "simgap/report/html/result_files.h"
#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

double freshRms(const std::filesystem::path& folder, const std::string& binary, const std::string& model) {
  runOrThrow({binary, "predict", "d/" + model, "fresh.csv", "-q", "--force", "-o", "p"}, folder);
  return Json::parse(readText(folder / "p/result.json")).at("rms_error");
}

}  // namespace

std::vector<NamedCause> LogAnswer::causes() const {
  std::vector<NamedCause> list;
  for (const Json& cause : result.at("causes")) {
    list.push_back({cause.at("effect"), cause.at("ambiguous_with").get<std::vector<std::string>>()});
  }
  return list;
}

bool LogAnswer::namedAlone(const std::string& effect) const {
  const auto all = causes();
  return verdict() == "cause-found" && all.size() == 1 && all[0].effect == effect;
}

bool LogAnswer::namedInGroup(const std::string& effect) const {
  const auto all = causes();
  if (namedAlone(effect)) return true;
  if (verdict() != "ambiguous" || all.size() != 1 || all[0].ambiguous_with.size() > 2) return false;
  return all[0].effect == effect || std::ranges::find(all[0].ambiguous_with, effect) != all[0].ambiguous_with.end();
}

bool LogAnswer::names(const std::string& effect) const {
  return std::ranges::any_of(causes(), [&](const NamedCause& c) {
    return c.effect == effect || std::ranges::find(c.ambiguous_with, effect) != c.ambiguous_with.end();
  });
}

LogAnswer diagnoseDraw(const reality::DriveDraw& draw, const std::filesystem::path& folder, const std::string& binary) {
  std::filesystem::create_directories(folder);
  writeText(folder / "log.csv", reality::recordDrive(draw.rig, draw.secret).csv());
  runOrThrow({binary, "diagnose", "classic", "--log", "log.csv", "-q", "--force", "-o", "d"}, folder);
  LogAnswer answer{draw, Json::parse(readText(folder / "d/result.json")), 0.0};
  if (!std::filesystem::exists(folder / "d/hypotheses.csv")) return answer;
  const CsvTable hypotheses = CsvTable::load(folder / "d/hypotheses.csv");
  const std::vector<std::string> effect = hypotheses.text("effect");
  const std::vector<double> step = hypotheses.quantity("step", ""), gain = numbersOf(hypotheses, "gain_percent");
  for (std::size_t i = 0; i < effect.size(); ++i) {
    const bool measured = std::isfinite(gain[i]);
    if (step[i] == 1.0 && effect[i] == draw.effects[0] && measured) answer.true_gain = 0.01 * gain[i];
  }
  return answer;
}

double gainOnFreshLog(const reality::DriveDraw& draw, const std::filesystem::path& folder, const std::string& binary) {
  reality::DriveRig rig = draw.rig;
  rig.seed += 500000;
  writeText(folder / "fresh.csv", reality::recordDrive(rig, draw.secret).csv());
  const double before = freshRms(folder, binary, "baseline.yaml"), after = freshRms(folder, binary, "model.yaml");
  return 1.0 - after * after / (before * before);
}

}  // namespace simgap::test
