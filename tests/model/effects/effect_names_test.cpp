// Whoever needs to know something of an effect reads its fields: no line of src or include outside the effects' files
// says an effect's name. Names of one word mean other things, too, and are not looked for.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

std::set<std::string> namesOfEffects() {
  std::set<std::string> names;
  const auto add = [&](std::string_view name) {
    if (name.find('-') != std::string_view::npos) names.emplace(name);
  };
  for (const ActuatorEffect* effect : actuator_effects::all()) add(effect->name);
  for (const ArmEffect* effect : arm_effects::all()) add(effect->name);
  return names;
}

/// Files of effects, and of a robot's causes, some of which have an effect's name.
bool isOfEffects(const fs::path& file) {
  const std::string path = file.generic_string();
  return path.find("/src/model/effects/") != std::string::npos ||
         path.find("/src/diagnose/robots/causes/") != std::string::npos;
}

TEST(EffectNames, StandInTheFilesOfEffectsAlone) {
  const std::set<std::string> names = namesOfEffects();
  ASSERT_GT(names.size(), 50u);
  const std::regex quoted("\"([a-z]+(-[a-z]+)+)\"");
  std::size_t files = 0;
  for (const char* folder : {"src", "include"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SIMGAP_SOURCE_DIR) / folder)) {
      if (!entry.is_regular_file() || isOfEffects(entry.path())) continue;
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".h") continue;
      ++files;
      std::ifstream in(entry.path());
      std::string line;
      for (int number = 1; std::getline(in, line); ++number) {
        line = line.substr(0, line.find("//"));
        for (std::sregex_iterator found(line.begin(), line.end(), quoted), end; found != end; ++found) {
          EXPECT_FALSE(names.contains((*found)[1])) << entry.path() << ":" << number << ": " << line;
        }
      }
    }
  }
  EXPECT_GT(files, 500u);
}

}  // namespace
}  // namespace simgap::test
