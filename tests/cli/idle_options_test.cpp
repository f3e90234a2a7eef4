// Options that would change nothing are refused before any file is read.
#include "cli/cli_fixture.h"

namespace simgap::test {
namespace {

struct Idle {
  Arguments arguments;
  std::string sentence;
};

class IdleOptionsTest : public CliTest {
 protected:
  void expectIdle(const std::vector<Idle>& all) const {
    for (const Idle& idle : all) expectRefused(idle.arguments, 2, idle.sentence);
  }
};

TEST_F(IdleOptionsTest, OfFitFriction) {
  expectIdle({{{"fit-friction", "log.csv", "--require", "paper"}, "found --require without a ratio, expected --ratio"},
              {{"fit-friction", "log.csv", "--ratio", "9", "--require", "x:-1:5"},
               "--require: found 'x:-1:5', expected NAME:DEG_PER_S:NM with numbers above 0"},
              {{"fit-friction", "log.csv", "--sign", "raw", "--dead-band", "2"}, "found --dead-band with --sign raw"}});
}

TEST_F(IdleOptionsTest, OfSimulate) {
  const Arguments serve{"simulate", "arm.yaml", "--serve"}, play{"simulate", "arm.yaml", "--commands", "c.csv"};
  const auto with = [](Arguments all, const Arguments& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  expectIdle({{with(serve, {"--commands", "c.csv"}), "found --commands with --serve"},
              {with(serve, {"--start", "zero"}), "found --start with --serve"},
              {with(serve, {"-o", "run"}), "found --output with --serve"},
              {with(play, {"--start-pose", "first"}), "found --start-pose without a file, expected it with --start"},
              {with(play, {"--start", "zero", "--start-pose", "first"}), "found --start-pose without a file"},
              {{"simulate", "arm.yaml", "--commands", "s.yaml", "--hold", "linear"}, "found --hold with a schedule"}});
}

TEST_F(IdleOptionsTest, OfDesign) {
  expectIdle(
      {{{"design", "arm.yaml", "--poses", "poses.csv", "--speeds", "1,2"}, "found --speeds without --separate"},
       {{"design", "arm.yaml", "--poses", "poses.csv", "--law", "stribeck"}, "found --law without --excite"},
       {{"design", "--drive", "limits.yaml", "--criterion", "information"}, "found --criterion with --drive"},
       {{"design", "--separate", "run", "--config", "c.yaml"}, "found --config with --separate"},
       {{"design", "--excite", "arm.yaml", "limits.yaml", "--count", "3"}, "found --count with --excite"},
       {{"design", "arm.yaml", "--poses", "poses.csv", "--candidates", "3"}, "found --count 7 of --candidates 3"}});
}

TEST_F(IdleOptionsTest, OfPosesLogsAndMotions) {
  expectIdle({{{"validate", "arm.yaml", "--motions", "m.yaml", "--settle-s", "3"}, "found --settle-s with --motions"},
              {{"calibrate", "arm.yaml", "--motions", "m.yaml", "--only", "*"}, "found --only with --motions"},
              {{"calibrate", "arm.yaml", "--motions", "m.yaml", "--validation", "p.csv"},
               "found --validation with --motions, expected --validation-motions"},
              {{"diagnose", "arm.yaml", "--poses", "poses.csv", "--ratio", "3"}, "found --ratio without --log"},
              {{"diagnose", "arm.yaml", "--motions", "m.yaml", "--map", "a=b"}, "found --map with --motions"},
              {{"diagnose", "classic", "--log", "log.csv", "--config", "c.yaml"}, "found --config with --log"}});
}

}  // namespace
}  // namespace simgap::test
