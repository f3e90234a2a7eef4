// `simgap fit-spring` and `simgap diagnose spring` on logs of a simulated rig, with and without a secret.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

#include "cli/cli_fixture.h"
#include "reality/spring_rig.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Springs : public CliTest {
 protected:
  static reality::SpringDesign rig(std::uint64_t seed) {
    reality::SpringDesign design;
    design.seed = seed;
    return design;
  }
  /// A cord that is never pushed.
  static reality::SpringDesign pulled(std::uint64_t seed) {
    reality::SpringDesign design = rig(seed);
    design.low = 0.0;
    design.high = 0.1;
    return design;
  }
  Json ask(const reality::SpringTruth& truth, reality::SpringDesign design, double rate = 25.0) const {
    design.rate = rate;
    put("log.csv", reality::recordSpring(truth, design).csv());
    return diagnosis("spring");
  }
  Json fit(const reality::SpringTruth& truth, const reality::SpringDesign& design, const Arguments& more = {}) const {
    put("log.csv", reality::recordSpring(truth, design).csv());
    Arguments all{"fit-spring", "log.csv", "-q", "--force", "-o", "f"};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return Json::parse(text("f/result.json"));
  }
  static Json parameter(const Json& list, const std::string& name) {
    for (const Json& p : list) {
      if (p.at("name") == name) return p;
    }
    throw std::runtime_error("no parameter " + name);
  }
  static double valueOf(const Json& result, const std::string& name) {
    return parameter(result.at("causes").at(0).at("parameters"), name).at("value");
  }
  static bool alone(const Json& result, const std::string& effect) {
    return result.at("verdict") == "cause-found" && result.at("causes").size() == 1 &&
           result.at("causes")[0].at("effect") == effect;
  }
  static std::vector<std::string> namesIn(const Json& result) {
    std::vector<std::string> names;
    for (const Json& cause : result.at("causes")) names.push_back(cause.at("effect"));
    return names;
  }
};

/// Rubber that hardens from its first pull on (neo-Hooke and a stiff end) has no rows of a slack cord.
TEST_F(Springs, ARubberThatHardensIsNoCord) {
  std::string csv = "length_m,force_N\n";
  for (int row = 0; row < 25; ++row) {
    const double stretch = 1.0 + 0.28 * row;
    csv += fmt::format("{},{}\n", stretch, 30.0 * (stretch - 1.0 / (stretch * stretch)) + 0.15 * std::pow(stretch, 4));
  }
  put("rubber.csv", csv);
  const std::string out = succeed({"fit-spring", "rubber.csv", "-o", "r"});
  EXPECT_THAT(out, HasSubstr("where the force still rises"));
  EXPECT_EQ(Json::parse(text("r/result.json")).at("model"), "spring");
}

/// A quarter of a bent line's gain is what a kink at its end makes of it; the data tell four independent rows.
TEST_F(Springs, AKinkThatGainsNothingIsNoCord) {
  std::string csv = "deflection_rad,torque_Nm\n";
  for (int row = 0; row < 60; ++row) {
    const double x = -1.2 + 0.04 * row;
    csv += fmt::format("{},{}\n", x, 0.03 * x + 0.004 * std::sin(2.5 * x + 1.0));
  }
  put("loop.csv", csv);
  const std::string out = succeed({"fit-spring", "loop.csv", "-o", "l"});
  EXPECT_EQ(Json::parse(text("l/result.json")).at("model"), "spring") << out;
}

TEST_F(Springs, AreFittedWithinTheirIntervals) {
  reality::SpringTruth truth;
  truth.force_offset = 0.4;
  const Json result = fit(truth, rig(21));
  EXPECT_EQ(result.at("model"), "spring");
  for (const auto& [name, value] : {std::pair("stiffness", 150.0), {"offset", 0.4}, {"damping", 4.0}}) {
    const Json p = parameter(result.at("parameters"), name);
    // The rig's rate is that of the step to a row, which is half a row late.
    EXPECT_NEAR(p.at("value").get<double>(), value, 3.0 * p.at("sd").get<double>() + 1e-3 * value) << name;
    EXPECT_LT(p.at("sd").get<double>(), 0.05 * value) << name;
  }
  EXPECT_NEAR(result.at("mse").get<double>(), 0.0025, 0.0003);
}

TEST_F(Springs, ANewCordSoftensWhereItHasBeenStretched) {
  reality::SpringTruth truth;
  truth.breaking = 60.0;
  reality::SpringDesign further = pulled(31);
  further.growing = true;
  const Json result = ask(truth, further);
  ASSERT_TRUE(alone(result, "stress-softening")) << result.at("sentence") << result.at("candidates");
  // Of chains drawn up to 0.12 m the furthest stretch breaks reach / 0.12.
  EXPECT_NEAR(valueOf(result, "softening"), 60.0 * valueOf(result, "reach") / 0.12, 5.0);
}

TEST_F(Springs, ACordHangsLooseBelowItsRestLength) {
  reality::SpringTruth truth;
  truth.pulls_only = true;
  truth.slack_below = 0.035;
  const Json result = fit(truth, pulled(22));
  EXPECT_EQ(result.at("model"), "cord");
  const Json rest = parameter(result.at("parameters"), "rest_length");
  EXPECT_NEAR(rest.at("value").get<double>(), 0.035, 3.0 * rest.at("sd").get<double>() + 2e-5);
  EXPECT_LT(rest.at("sd").get<double>(), 3e-4);
  succeed({"predict", "f/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_NEAR(Json::parse(text("p/result.json")).at("rms_error").get<double>(),
              std::sqrt(result.at("mse").get<double>()), 0.002);
}

TEST_F(Springs, ACordIsWrittenIntoTheArmWithItsPriors) {
  reality::SpringTruth truth;
  truth.pulls_only = true;
  truth.slack_below = 0.035;
  const Json result = fit(truth, pulled(23), {"--into", "arm.yaml", "--muscle", "biceps"});
  const auto cordOf = [](const ArmModel& arm) {
    return std::ranges::find(arm.muscles, "biceps", &Muscle::name)->shock_cord;
  };
  const ShockCord before = cordOf(readArm(YamlNode::load(path("arm.yaml"))));
  const ShockCord after = cordOf(readArm(YamlNode::load(path("f/arm.yaml"))));
  EXPECT_NEAR(after.stiffness, 150.0, 3.0);
  EXPECT_NEAR(after.damping, 4.0, 0.5);
  EXPECT_EQ(after.rest_length, before.rest_length) << "the log does not say how long the cord was";
  const std::string priors = text("f/calibration_parameters.yaml");
  EXPECT_THAT(priors, HasSubstr("muscles.biceps.shock_cord.stiffness_N_m"));
  EXPECT_THAT(priors, Not(HasSubstr("rest_length")));

  std::string log = text("log.csv");
  log.replace(log.find("deflection_m"), 12, "length_m");
  put("length.csv", log);
  succeed({"fit-spring", "length.csv", "-q", "--force", "-o", "f", "--into", "arm.yaml", "--muscle", "biceps"});
  EXPECT_NEAR(cordOf(readArm(YamlNode::load(path("f/arm.yaml")))).rest_length, 0.035, 5e-4);
  EXPECT_THAT(text("f/calibration_parameters.yaml"), HasSubstr("muscles.biceps.shock_cord.rest_length_m"));
}

TEST_F(Springs, SayWhatIsWrongWithALog) {
  put("sign.csv", "time_s,deflection_m,force_N\n0,0,0\n1,0.1,-10\n2,0.2,-20\n3,0.3,-31\n4,0.2,-20\n5,0.1,-9\n");
  expectRefused({"fit-spring", "sign.csv"}, 3, "sign.csv: force_N falls where deflection_m grows (correlation -1.00)");
  put("two.csv", "time_s,deflection_m,torque_Nm\n0,0,0\n1,0.1,10\n");
  expectRefused({"fit-spring", "two.csv"}, 3, "force");
  put("few.csv", "time_s,deflection_m,force_N\n0,0,0\n1,0.1,10\n");
  expectRefused({"fit-spring", "few.csv"}, 3, "found 2 rows for 3 parameters");
  put("angle.csv", "deflection_rad,torque_Nm\n0,0\n0.1,10\n0.2,20\n0.3,31\n0.4,40\n");
  expectRefused({"fit-spring", "angle.csv", "--into", "arm.yaml", "--muscle", "biceps"}, 3,
                "found a torque over an angle");
  succeed({"fit-spring", "angle.csv", "-q", "-o", "f"});
  EXPECT_THAT(text("f/parameters.csv"), HasSubstr("stiffness,Nm_rad,"));
}

TEST_F(Springs, AreSilentWhereNothingIsHidden) {
  reality::SpringDesign unkind = rig(2);
  unkind.spikes = 5;
  unkind.encoder_step = 2e-4;
  unkind.force_limit = 6.5;
  for (const reality::SpringDesign& design : {rig(1), unkind}) {
    const Json result = ask({}, design);
    EXPECT_EQ(result.at("verdict"), "nothing-found") << result.at("sentence") << result.at("candidates");
  }
  std::string channels;
  const Json last = Json::parse(text("d/result.json"));
  for (const Json& fault : last.at("faults")) {
    EXPECT_TRUE(fault.at("corrected").get<bool>());
    channels += fault.at("channel").get<std::string>() + " " + fault.at("sentence").get<std::string>() + "\n";
  }
  EXPECT_THAT(channels, HasSubstr("deflection_m stands alone in 5 rows"));
  EXPECT_THAT(channels, HasSubstr("force_N sits at its limit"));
}

TEST_F(Springs, NameWhatBendsTheirCurve) {
  reality::SpringTruth rubber, rope, cord;
  rubber.curve = reality::rubberCurve(0.05);
  rope.curve = reality::ropeCurve(0.05);
  cord.pulls_only = true;
  cord.slack_below = 0.04;
  const Json soft = ask(rubber, rig(3));
  ASSERT_TRUE(alone(soft, "spring-softening")) << soft.at("sentence");
  // From 150 N/m at first to 0.557 of it at the end.
  EXPECT_NEAR(valueOf(soft, "positive"), 150.0 * (1.0 - 0.557), 20.0);
  EXPECT_NEAR(valueOf(soft, "negative"), 150.0 * (1.0 - 0.557), 20.0);
  const Json hard = ask(rope, rig(4));
  EXPECT_TRUE(alone(hard, "spring-hardening")) << hard.at("sentence");
  reality::SpringDesign preloaded = rig(6);
  preloaded.low = 0.015;
  const Json never_let_go = ask(rope, preloaded);
  EXPECT_TRUE(alone(never_let_go, "spring-hardening")) << never_let_go.at("sentence");
  const Json loose = ask(cord, pulled(5), 50.0);  // so that few rows lie across the bend
  ASSERT_TRUE(alone(loose, "spring-slack")) << loose.at("sentence");
  EXPECT_NEAR(valueOf(loose, "rest_length"), 0.04, 5e-4);
  EXPECT_THAT(text("d/model.yaml"), HasSubstr("law: cord"));
  succeed({"diagnose", "d/model.yaml", "--log", "log.csv", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "nothing-found");
}

TEST_F(Springs, NameTheDirectionThatIsStiffer) {
  reality::SpringTruth truth;
  truth.curve = {{-1.0, -210.0}, {0.0, 0.0}, {1.0, 150.0}};
  const Json result = ask(truth, rig(6));
  ASSERT_TRUE(alone(result, "spring-direction")) << result.at("sentence");
  EXPECT_NEAR(valueOf(result, "change"), 60.0, 5.0);
}

/// 150 N/m on either side of a play. \param half  of it [m]  \param damping  beside it [N s/m]
reality::SpringTruth withPlay(double half, double damping, double middle = 0.0) {
  reality::SpringTruth truth;
  truth.damping = damping;
  const double reach = 150.0 * (1.0 - half);
  truth.curve = {{middle - 1.0, -reach}, {middle - half, 0.0}, {middle + half, 0.0}, {middle + 1.0, reach}};
  return truth;
}

// Play had passed for a spring that is stiffer one way, which leaves half of the error.
TEST_F(Springs, NameThePlayInSeriesWithThem) {
  const reality::SpringTruth truth = withPlay(0.001, 0.0);
  reality::SpringDesign design = rig(14);
  design.low = -0.02;
  const Json result = ask(truth, design);
  ASSERT_TRUE(alone(result, "spring-play")) << result.at("sentence") << result.at("candidates");
  EXPECT_NEAR(valueOf(result, "play"), 0.002, 1e-4);
  EXPECT_NEAR(valueOf(result, "middle"), 0.0, 1e-4);
}

// Few rows lie within a play of a hundredth of the range, and its place was where the search began.
TEST_F(Springs, PlaceAPlayThatIsSmall) {
  for (const std::uint64_t seed : {16u, 17u}) {
    reality::SpringDesign design = rig(seed);
    design.low = -0.05;
    const Json result = ask(withPlay(0.0008, 4.0, 0.003), design);
    ASSERT_TRUE(alone(result, "spring-play")) << result.at("sentence") << result.at("candidates");
    EXPECT_NEAR(valueOf(result, "play"), 0.0016, 2e-4);
    EXPECT_NEAR(valueOf(result, "middle"), 0.003, 2e-4);
  }
}

// Two bends of the curve, one up and one down, had taken it apart, and were refused for their sizes then.
TEST_F(Springs, NameAPlayWithRoundedEdges) {
  constexpr double kHalf = 0.0015, kRound = 0.0005;  // [m]
  reality::SpringTruth truth;
  truth.damping = 6.0;
  for (int i = -600; i <= 600; ++i) {
    const double x = 1e-4 * i, beyond = std::abs(x) - kHalf;
    truth.curve.emplace_back(x + 0.002, std::copysign(75.0 * (beyond + std::hypot(beyond, kRound)), x));
  }
  const Json result = ask(truth, rig(18));
  ASSERT_EQ(result.at("causes").size(), 1u) << result.at("sentence") << result.at("candidates");
  EXPECT_EQ(result.at("causes")[0].at("effect"), "spring-play") << result.at("sentence");
  EXPECT_NEAR(valueOf(result, "middle"), 0.002, 3e-4);
}

// A damper beside the spring, and not behind the play, resists within it, too: that had been "no multiple of the rate".
TEST_F(Springs, ADamperBesideThePlayIsALinearOne) {
  const reality::SpringTruth truth = withPlay(0.01, 2.0);
  reality::SpringDesign design = rig(15);
  design.low = -0.03;
  const Json result = ask(truth, design);
  EXPECT_TRUE(alone(result, "spring-play")) << result.at("sentence") << result.at("candidates");
}

// An encoder that slips once shifts the force from then on: that had passed for a creep as slow as the log.
TEST_F(Springs, DoNotCreepWhereAnEncoderSlips) {
  std::mt19937_64 random(3);
  std::normal_distribution<> noise(0.0, 0.15);
  const auto pathAt = [](double t) {
    return 0.02 * std::sin(0.44 * t + 0.3) + 0.008 * std::sin(1.95 * t + 1.2) + 0.003 * std::sin(6.91 * t + 2.0);
  };
  std::string log = "time_s,deflection_m,force_N\n";
  double x = 0.0, shift = 0.0;  // the motion goes on from where it was held
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.04 * i;
    const bool holds = (t > 20.0 && t < 24.0) || (t > 45.0 && t < 49.0) || (t > 65.0 && t < 69.0);
    if (holds) shift = x - pathAt(t);
    x = pathAt(t) + shift;
    const double read = x + (t > 50.0 ? 0.0012 : 0.0);
    log += fmt::format("{},{:.5f},{:.3f}\n", t, read, 2500.0 * x + noise(random));
  }
  put("log.csv", log);
  succeed({"diagnose", "spring", "--log", "log.csv", "-q", "--force", "-o", "d"});
  const Json result = Json::parse(text("d/result.json"));
  EXPECT_EQ(result.at("verdict"), "unexplained") << result.at("sentence");
  EXPECT_TRUE(result.at("causes").empty()) << result.at("sentence");
}

TEST_F(Springs, NameWhatTheyRemember) {
  reality::SpringTruth creep, narrow, friction, pack;
  narrow.creep_stiffness = 60.0;
  creep.creep_stiffness = 60.0;
  creep.creep_decades = 2.0;
  friction.friction = 0.6;
  pack.friction = 1.0;
  pack.slip = 0.015;
  pack.slip_spread = 1.0;
  const Json one = ask(narrow, rig(7));
  ASSERT_TRUE(alone(one, "spring-creep")) << one.at("sentence");
  EXPECT_NEAR(valueOf(one, "tau"), 2.0, 0.2);
  EXPECT_NEAR(valueOf(one, "stiffness"), 60.0, 5.0);
  EXPECT_EQ(valueOf(one, "decades"), 0.0);
  const Json many = ask(creep, rig(8));
  EXPECT_TRUE(alone(many, "spring-creep")) << many.at("sentence");
  EXPECT_EQ(valueOf(many, "decades"), 2.0);
  const Json rubbed = ask(friction, rig(9));
  ASSERT_TRUE(alone(rubbed, "spring-hysteresis")) << rubbed.at("sentence");
  EXPECT_NEAR(valueOf(rubbed, "friction"), 0.6, 0.05);
  EXPECT_NEAR(valueOf(rubbed, "slip"), 0.004, 0.0004);
  const Json packed = ask(pack, rig(10));
  ASSERT_TRUE(alone(packed, "spring-hysteresis")) << packed.at("sentence");
  EXPECT_EQ(valueOf(packed, "spread"), 1.0);
  // The extended model is read by the other commands.
  const double error = std::sqrt(packed.at("extended").at("mse").get<double>());
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  EXPECT_NEAR(Json::parse(text("p/result.json")).at("rms_error").get<double>(), error, 0.05 * error);
  succeed({"fit-spring", "log.csv", "--model", "d/model.yaml", "-q", "-o", "refit"});
  EXPECT_NEAR(Json::parse(text("refit/result.json")).at("mse").get<double>(), error * error, 0.1 * error * error);
  succeed({"diagnose", "d/model.yaml", "--log", "log.csv", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "nothing-found");
}

// Rubber's molecules slide: the loop grows with the logarithm of the rate, and hysteresis was named.
TEST_F(Springs, NameADampingThatIsNoMultipleOfTheRate) {
  reality::SpringTruth truth;
  truth.sliding = 0.15;
  const Json result = ask(truth, rig(13));
  ASSERT_TRUE(alone(result, "damping-nonlinearity")) << result.at("sentence");
  EXPECT_LT(valueOf(result, "n"), 0.8);
}

TEST_F(Springs, RefuseRests) {
  std::string rest = "time_s,deflection_m,force_N\n", same = rest;
  std::mt19937_64 random(1);
  std::normal_distribution<> noise;
  for (int i = 0; i < 2000; ++i) {
    const double force = 700.0 + 3.0 * noise(random);
    rest += fmt::format("{},{},{}\n", 0.01 * i, 0.05 + 1e-6 * noise(random), force);
    same += fmt::format("{},0.05,700\n", 0.01 * i);
  }
  put("rest.csv", rest);
  put("same.csv", same);
  expectRefused({"fit-spring", "rest.csv"}, 3, "stays within its own noise");
  expectRefused({"diagnose", "spring", "--log", "rest.csv"}, 3, "stays within its own noise");
  expectRefused({"diagnose", "spring", "--log", "same.csv"}, 3, "is constant throughout");
}

TEST_F(Springs, NameTwoCausesAtOnce) {
  reality::SpringTruth truth;
  truth.curve = reality::rubberCurve(0.05);
  truth.creep_stiffness = 60.0;
  EXPECT_THAT(namesIn(ask(truth, rig(11))), ::testing::UnorderedElementsAre("spring-softening", "spring-creep"));
}

/// One slow loop: neighbouring rows are alike, and yet what they miss together is no noise.
TEST_F(Springs, WhatGoesSlowlyIsNoNoise) {
  std::string log = "time_s,deflection_m,force_N\n";
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, 0.004);
  for (int row = 0; row < 150; ++row) {
    const double share = row / 149.0, there = 0.05 * (1.0 - std::abs(2.0 * share - 1.0));
    const double loop = 0.9 * std::sin(2.0 * std::numbers::pi * share);
    log += fmt::format("{},{},{}\n", 2.0 * row, there, 200.0 * there + loop + noise(random));
  }
  put("log.csv", log);
  const Json result = diagnosis("spring");
  const double left = result.at("extended").at("mse_heldout"), floor = result.at("baseline").at("noise_floor");
  const double told = 0.01 * result.at("left_over").at("share_percent").get<double>();
  ASSERT_GT(told, 0.2) << result.at("sentence");
  EXPECT_LE(floor, (1.0 - told) * left * 1.000001) << result.at("sentence");
}

TEST_F(Springs, SayUnexplainedForWhatHasNoName) {
  reality::SpringTruth truth;
  truth.sweating = 0.06;
  const Json result = ask(truth, rig(12));
  EXPECT_EQ(result.at("verdict"), "unexplained") << result.at("sentence");
  EXPECT_EQ(result.at("left_over").at("channels")[0].at("channel"), "humidity_percent");
}

}  // namespace
}  // namespace simgap::test
