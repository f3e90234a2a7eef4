// docs/effects.md says of every effect what its fields say: what stands between the markers
//     <!-- effects: GROUP -->  …  <!-- end -->
// is written from them, the rest is prose. To write the page anew: SIMGAP_WRITE_DOCS=1 build/dev/tests/model_test.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::test {
namespace {

constexpr char kPage[] = SIMGAP_SOURCE_DIR "/docs/effects.md";

std::string capitalised(std::string_view text) {
  std::string result(text);
  if (!result.empty()) result[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(result[0])));
  return result;
}

std::string wrapped(const std::string& text) {
  constexpr std::size_t kWidth = 118;
  std::istringstream words(text);
  std::string word, line, result;
  while (words >> word) {
    if (!line.empty() && line.size() + 1 + word.size() > kWidth) {
      result += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + line + "\n";
}

std::string joined(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

std::string parameterText(std::string_view name, std::string_view unit) {
  return unit == "1" ? fmt::format("`{}`", name) : fmt::format("`{}` [{}]", name, unit);
}

/// "*Signature:* a step.", nothing for an empty text.
std::string sentence(std::string_view title, std::string_view text) {
  return text.empty() ? "" : fmt::format("{}{}. ", title, text);
}

std::string entry(const ActuatorEffect& effect) {
  std::vector<std::string> parameters, needs, laws;
  for (const EffectParameter& p : effect.parameters) parameters.push_back(parameterText(p.name, p.unit));
  for (const EffectColumn& c : effect.columns) parameters.push_back(parameterText(c.name, c.unit));
  for (const OptionalChannel need : effect.needs) needs.emplace_back(toString(need));
  if (effect.needs_stribeck) needs.emplace_back("a law with a Stribeck term");
  for (const FrictionLaw* law : friction::all()) {
    if (effect.contained_in != nullptr && effect.contained_in(*law)) laws.emplace_back(law->name);
  }
  if (effect.is_offset) laws.emplace_back("fits with an offset of their own");
  std::string text = fmt::format("{}: `{}` ({}). ", capitalised(effect.cause), effect.equation, joined(parameters));
  for (const ActuatorEffect* form : effect.other_forms) {
    text += fmt::format("Or, {}: `{}`. ", form->form, form->equation);
  }
  text += sentence("", capitalised(effect.remarks)) + sentence("*Signature:* ", effect.signature);
  text += sentence("*Look-alikes:* ", effect.look_alikes) + sentence("*To separate them, record* ", effect.separates);
  text += sentence("*Needs* ", joined(needs)) + sentence("*Part of, or without meaning in,* ", joined(laws));
  const bool drive = effect.kind == ActuatorKind::kFriction;
  if (drive && !effect.on_gearbox) text += "*Not asked of gearboxes.* ";
  text += fmt::format("({}.)", capitalised(effect.source));
  return fmt::format("### `{}`\n{}\n", effect.name, wrapped(text));
}

std::string_view toString(ArmEffect::Target target) {
  switch (target) {
    case ArmEffect::Target::kNone:
      return "";
    case ArmEffect::Target::kMuscle:
      return " (a muscle)";
    case ArmEffect::Target::kMuscleOrAll:
      return " (a muscle or all)";
    case ArmEffect::Target::kLine:
      return " (a muscle or tendon)";
    case ArmEffect::Target::kTendon:
      return " (a tendon)";
    case ArmEffect::Target::kMovingBody:
      return " (a moving body)";
    case ArmEffect::Target::kBody:
      return " (a body)";
    case ArmEffect::Target::kJoint:
      return " (a joint)";
  }
  return "";
}

std::string entry(const ArmEffect& effect) {
  std::vector<std::string> parameters;
  for (const ArmEffectParameter& p : effect.parameters) parameters.push_back(parameterText(p.name, p.unit));
  const std::vector<std::string> look_alikes(effect.look_alikes.begin(), effect.look_alikes.end());
  std::string text = fmt::format("{}: `{}` ({}). ", capitalised(effect.cause), effect.equation, joined(parameters));
  text += sentence("", capitalised(effect.remarks)) + sentence("*Signature:* ", effect.signature);
  text += sentence("*Look-alikes:* ", joined(look_alikes)) + sentence("*To separate them:* ", effect.separates_by);
  if (effect.needs_time) text += "*Needs* `time_s` of every pose. ";
  return fmt::format("### `{}`{}\n{}\n", effect.name, toString(effect.target), wrapped(text));
}

std::string entries(const std::string& group) {
  std::string text;
  if (group == "arm" || group == "motion") {
    for (const ArmEffect* effect : arm_effects::all()) {
      if (effect->needs_motion == (group == "motion")) text += entry(*effect);
    }
    return text;
  }
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    const bool drive = effect->kind == ActuatorKind::kFriction || effect->kind == ActuatorKind::kTransmission;
    const bool here = (group == "drive" && drive) || (group == "gearbox" && effect->kind == ActuatorKind::kGearbox) ||
                      (group == "motor" && effect->kind == ActuatorKind::kMotor) ||
                      (group == "pam" && effect->kind == ActuatorKind::kPam) ||
                      (group == "spring" && effect->kind == ActuatorKind::kSpring);
    if (here) text += entry(*effect);
  }
  return text;
}

/// The page with what stands between its markers written anew.
std::string updated(const std::string& page) {
  constexpr std::string_view kBegin = "<!-- effects: ", kClose = " -->\n", kEnd = "<!-- end -->";
  std::string result;
  std::size_t at = 0;
  for (std::size_t begin; (begin = page.find(kBegin, at)) != std::string::npos;) {
    const std::size_t name = begin + kBegin.size(), close = page.find(kClose, name), end = page.find(kEnd, close);
    if (close == std::string::npos || end == std::string::npos) break;
    result += page.substr(at, close + kClose.size() - at) + "\n" + entries(page.substr(name, close - name));
    at = end;
  }
  return result + page.substr(at);
}

TEST(EffectsPage, SaysWhatTheFieldsSay) {
  std::ostringstream text;
  text << std::ifstream(kPage).rdbuf();
  const std::string page = text.str(), expected = updated(page);
  if (std::getenv("SIMGAP_WRITE_DOCS") != nullptr) std::ofstream(kPage) << expected;
  EXPECT_EQ(expected, page) << "docs/effects.md is out of date: SIMGAP_WRITE_DOCS=1 build/dev/tests/model_test";
}

TEST(EffectsPage, HoldsEveryEffectOnce) {
  std::ostringstream text;
  text << std::ifstream(kPage).rdbuf();
  const auto count = [&](std::string_view name) {
    const std::string heading = fmt::format("### `{}`", name), page = text.str();
    int found = 0;
    for (std::size_t at = 0; (at = page.find(heading, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  for (const ActuatorEffect* effect : actuator_effects::all()) EXPECT_EQ(count(effect->name), 1) << effect->name;
  for (const ArmEffect* effect : arm_effects::all()) EXPECT_EQ(count(effect->name), 1) << effect->name;
}

}  // namespace
}  // namespace simgap::test
