/// \file
/// The arm's view in three dimensions, from the tables of writeArmGeometry.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// A pose that the slider can show, and what is said of it in each simulated state.
struct ScenePose {
  std::string set, pose;
  std::vector<std::pair<std::string, std::string>> states;  ///< {"before", "shoulder 12.1°, elbow 3.0° off"}
};

/// More poses would fill the page; the first ones are shown.
inline constexpr std::size_t kMostScenePoses = 100;
/// The same for arms of many muscles: poses times muscles.
inline constexpr std::size_t kMostPaths = 1500;

/// Poses that follow each other in time.
struct SceneMotion {
  double duration;  ///< [s]
  bool measured;    ///< shown as a ghost
};

/// Nothing when the directory has no geometry or no pose.
std::optional<PageScene> armScene(const ResultFiles& files, std::vector<ScenePose> poses,
                                  const std::optional<SceneMotion>& motion = {});

}  // namespace simgap
