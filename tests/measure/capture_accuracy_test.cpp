// How well the capture sees rendered arms. The Slow tests print the figures of docs/performance.md (600 pairs per
// setting); the others hold the same limits on fewer pairs.
#include <gtest/gtest.h>

#include <cstdio>

#include "support/capture_study.h"

namespace simgap::test {
namespace {

struct Setting {
  const char* name;
  StudyOptions options;
};

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const int scale : {1, 2}) {
    const std::string size = scale == 1 ? "640x480" : "1280x960";
    StudyOptions plain;
    plain.scale = scale;
    all.push_back({scale == 1 ? "640x480 independent" : "1280x960 independent", plain});
    StudyOptions moving = plain;
    moving.sequence = true;
    all.push_back({scale == 1 ? "640x480 moving" : "1280x960 moving", moving});
    StudyOptions hard = plain;
    hard.disturbance = {0.3, 10, false, 0.0};
    all.push_back({scale == 1 ? "640x480 30 % hidden 10 ghosts" : "1280x960 30 % hidden 10 ghosts", hard});
    StudyOptions hard_moving = hard;
    hard_moving.sequence = true;
    hard_moving.exposures = 5;
    hard_moving.disturbance = {0.3, 20, true, 0.0};
    all.push_back({scale == 1 ? "640x480 moving blur 20 gh glare" : "1280x960 moving blur 20 gh glare", hard_moving});
    StudyOptions blocked = plain;
    blocked.disturbance = {0.0, 3, false, 0.02};
    all.push_back({scale == 1 ? "640x480 partly covered marker" : "1280x960 partly covered marker", blocked});
  }
  return all;
}

TEST(SlowCaptureStudy, SixHundredPairsPerSetting) {
  for (Setting setting : settings()) {
    setting.options.pairs = 600;
    const StudyResult r = runStudy(setting.options);
    std::printf("%s\n", describe(setting.name, r).c_str());
    std::fflush(stdout);
    EXPECT_EQ(r.wrong_identities, 0) << setting.name;
  }
}

TEST(CaptureStudy, Quick) {
  for (Setting setting : settings()) {
    setting.options.pairs = 40;
    const StudyResult r = runStudy(setting.options);
    std::printf("%s\n", describe(setting.name, r).c_str());
    std::fflush(stdout);
    EXPECT_EQ(r.wrong_identities, 0) << setting.name;
  }
}

}  // namespace
}  // namespace simgap::test
