// `simgap diagnose` on logs as a user runs it: hidden effects are found by name, silence where there is none, faults
// first.
#include <cmath>
#include <fstream>
#include <map>
#include <random>

#include "cli/cli_fixture.h"
#include "simgap/core/csv.h"
#include "support/log_answer.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

class DiagnoseTest : public CliTest {
 protected:
  /// A short log with the secret at a size that stands out.
  static reality::DriveDraw shortDraw(std::uint64_t seed, std::size_t rows = 8000) {
    reality::DriveDraw draw = reality::drawNone(seed);
    draw.rig.rows = rows;
    return draw;
  }
  LogAnswer ask(const reality::DriveDraw& draw) const { return diagnoseDraw(draw, folder_.path(), SIMGAP_BINARY); }
  /// The log of a draw, with cells changed. \param change  gets the row's number and its cells
  void putLog(const reality::DriveDraw& draw, const std::function<void(reality::DriveRecord&)>& change) const {
    reality::DriveRecord record = reality::recordDrive(draw.rig, draw.secret);
    change(record);
    put("log.csv", record.csv());
  }
  static std::string firstRows(const CsvTable& table, std::size_t rows) {
    std::vector<std::vector<std::string>> columns;
    for (const std::string& name : table.columns()) columns.push_back(table.text(name));
    CsvWriter csv(table.columns());
    for (std::size_t row = 0; row < rows; ++row) {
      for (const std::vector<std::string>& column : columns) csv.add(column[row]);
      csv.endRow();
    }
    return csv.text();
  }
};

TEST_F(DiagnoseTest, IsSilentWhereNothingIsHidden) {
  const LogAnswer answer = ask(shortDraw(11));
  EXPECT_EQ(answer.verdict(), "nothing-found") << answer.result.dump(1);
  EXPECT_TRUE(answer.causes().empty());
  EXPECT_GT(answer.result.at("detectable").size(), 10u);
  const double floor = answer.result.at("baseline").at("noise_floor");
  EXPECT_NEAR(floor, std::pow(answer.draw.rig.current_noise, 2), 0.15 * floor);
}

TEST_F(DiagnoseTest, NamesAnAdhesionOffsetAndExtendsTheModel) {
  reality::DriveDraw draw = shortDraw(12, 12000);
  draw.effects = {"coulomb-offset"};
  draw.secret.coulomb_offset = 0.35;
  const LogAnswer answer = ask(draw);
  ASSERT_TRUE(answer.namedAlone("coulomb-offset")) << answer.result.dump(1);
  const Json cause = answer.result.at("causes")[0];
  const Json n_c2 = cause.at("parameters")[0];
  EXPECT_EQ(n_c2.at("name"), "n_c2");
  EXPECT_NEAR(n_c2.at("value").get<double>(), 0.35, 0.06);
  EXPECT_GT(cause.at("gain_ci95")[0].get<double>(), 0.0);
  EXPECT_FALSE(cause.at("absorbed_by").empty());
  EXPECT_THAT(entries(path("d")), IsSupersetOf({"baseline.yaml", "evidence.csv", "hypotheses.csv", "model.yaml",
                                                "predictions.csv", "report.html", "result.json"}));
  // What the files predict is what was measured: the same rows count, and friction builds up after a reversal.
  for (const std::string model : {"baseline", "extended"}) {
    const std::string file = model == "extended" ? "d/model.yaml" : "d/baseline.yaml";
    succeed({"predict", file, "log.csv", "-q", "-o", "predicted-" + model});
    const double rms = Json::parse(text("predicted-" + model + "/result.json")).at("rms_error");
    const double mse = answer.result.at(model).at("mse");
    EXPECT_NEAR(rms * rms, mse, 0.05 * mse) << model;
  }
  const double fresh = gainOnFreshLog(draw, folder_.path(), SIMGAP_BINARY);
  EXPECT_GT(fresh, 0.5 * cause.at("gain_heldout_percent").get<double>() / 100.0);
  // The extended model is a model like any other: nothing is left to find in it.
  succeed({"diagnose", "d/model.yaml", "--log", "log.csv", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "nothing-found");
  // A fit to another log of the drive takes it, too.
  succeed({"fit-friction", "fresh.csv", "--model", "d/model.yaml", "-q", "-o", "refit"});
  const Json refit = Json::parse(text("refit/result.json"));
  EXPECT_EQ(refit.at("model"), "classic + coulomb-offset");
  EXPECT_NEAR(refit.at("mse_heldout").get<double>(), std::pow(draw.rig.current_noise, 2),
              0.2 * std::pow(draw.rig.current_noise, 2));
  const Json parameters = refit.at("parameters");
  const auto offset =
      std::ranges::find_if(parameters, [](const Json& p) { return p.at("name") == "coulomb-offset.n_c2"; });
  ASSERT_NE(offset, parameters.end());
  EXPECT_NEAR(offset->at("value").get<double>(), 0.35, 4.0 * offset->at("sd").get<double>());
  EXPECT_THAT(text("refit/model.yaml"), HasSubstr("coulomb-offset"));
  EXPECT_THAT(text("refit/report.html"), HasSubstr("Measured and predicted over time"));
  expectRefused({"fit-friction", "fresh.csv", "--model", "d/model.yaml", "--fix", "k_a=1"}, 2,
                "found --fix with --model d/model.yaml");
  expectRefused({"fit-pam", "fresh.csv", "--model", "d/model.yaml"}, 2, "found a model of kind friction, expected pam");
}

TEST_F(DiagnoseTest, NamesADelayBetweenChannels) {
  reality::DriveDraw draw = shortDraw(13);
  draw.effects = {"channel-delay"};
  draw.secret.delay = 0.05;
  const LogAnswer answer = ask(draw);
  ASSERT_TRUE(answer.namedAlone("channel-delay")) << answer.result.dump(1);
  EXPECT_NEAR(answer.result.at("causes")[0].at("parameters")[0].at("value").get<double>(), 0.05, 0.01);
}

// A bridge with one strain gauge, which loses balance with the load: torque-saturation was named for it, and "Left:
// nothing".
TEST_F(DiagnoseTest, NamesATorqueSensorThatBends) {
  reality::DriveDraw draw = shortDraw(16, 12000);
  draw.effects = {"torque-sensor-nonlinearity"};
  draw.secret.gauge_bend = 0.01;
  const LogAnswer answer = ask(draw);
  ASSERT_TRUE(answer.namedInGroup("torque-sensor-nonlinearity")) << answer.result.at("sentence");
  const Json c = answer.result.at("causes")[0].at("parameters").at(0);
  EXPECT_NEAR(c.at("value"), 0.01, 0.003);
}

// The amplifier of a torque sensor filters: the current was named, as if it were early.
TEST_F(DiagnoseTest, TellsALateLoadFromALateCurrent) {
  reality::DriveDraw draw = shortDraw(17, 12000);
  draw.effects = {"load-delay"};
  draw.secret.sensor_filter = 0.08;
  const LogAnswer answer = ask(draw);
  ASSERT_TRUE(answer.namedAlone("load-delay")) << answer.result.at("sentence");
  EXPECT_NEAR(answer.result.at("causes")[0].at("parameters").at(0).at("value"), 0.08, 0.02);
}

TEST_F(DiagnoseTest, NamesHeating) {
  reality::DriveDraw draw = shortDraw(14);
  draw.effects = {"friction-heating"};
  draw.secret.viscous_heating = 0.04;
  draw.secret.dry_heating = 0.02;
  EXPECT_TRUE(ask(draw).namedAlone("friction-heating"));
}

TEST_F(DiagnoseTest, NamesATransmissionThatStretches) {
  reality::DriveDraw draw = shortDraw(16);
  const auto withMotorAngle = [&](double stretch) {
    put("log.csv", csvWithMotorAngle(reality::recordDrive(draw.rig, draw.secret), draw.rig.ratio, stretch));
  };
  withMotorAngle(0.0);
  EXPECT_EQ(diagnosis("classic").at("verdict"), "nothing-found");
  withMotorAngle(0.004);
  const Json found = diagnosis("classic");
  ASSERT_EQ(found.at("verdict"), "cause-found") << found.dump(1);
  ASSERT_EQ(found.at("causes").size(), 1u);
  EXPECT_EQ(found.at("causes")[0].at("effect"), "transmission-compliance");
  const Json parameters = found.at("causes")[0].at("parameters");
  EXPECT_GT(parameters[0].at("ci95")[0].get<double>(), 0.0);
  EXPECT_GT(parameters[1].at("ci95")[0].get<double>(), 0.0) << "it stiffens";
  // The model that comes out still predicts the effort, and nothing is left to find in it.
  succeed({"predict", "d/model.yaml", "log.csv", "-q", "-o", "p"});
  succeed({"diagnose", "d/model.yaml", "--log", "log.csv", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "nothing-found");
  EXPECT_THAT(text("again/model.yaml"), HasSubstr("transmission-compliance"));
  // On another log of the drive the joint's angle follows from the motor's, but for the encoders' own errors.
  draw.rig.seed += 1;
  withMotorAngle(0.004);
  const std::string ratio = std::to_string(draw.rig.ratio);
  succeed({"predict", "d/model.yaml", "log.csv", "--joint-angle", "--ratio", ratio, "-q", "-o", "angle"});
  const Json angle = Json::parse(text("angle/result.json"));
  const double stiff = angle.at("joint_angle").at("rms_error_stiff"), elastic = angle.at("rms_error");
  const double noise = std::hypot(2e-3, draw.rig.angle_noise);  // [rad] of csvWithMotorAngle and of the joint's encoder
  EXPECT_GT(stiff, 1.3 * noise);
  EXPECT_LT(elastic, 1.1 * noise);
  // The motor's encoder is read 3 ms later: -0.003 s of the motor, over the ratio at the joint.
  EXPECT_NEAR(angle.at("joint_angle").at("lag_s").get<double>(), 0.003 / draw.rig.ratio, 3e-5 / 10);
  EXPECT_THAT(text("angle/report.html"), HasSubstr("Stretch over load and angle"));
  expectRefused({"predict", "d/baseline.yaml", "log.csv", "--joint-angle", "--ratio", ratio, "-o", "no"}, 2,
                "found no transmission-compliance");
  expectRefused({"predict", "d/model.yaml", "log.csv", "--joint-angle", "-o", "no"}, 2, "found no ratio");
}

TEST_F(DiagnoseTest, TellsPlayFromACableThatStretches) {
  const reality::DriveDraw draw = shortDraw(17);
  const auto found = [&](double stretch, double play) {
    put("log.csv", csvWithMotorAngle(reality::recordDrive(draw.rig, draw.secret), draw.rig.ratio, stretch, play));
    std::map<std::string, Json> causes;
    const Json result = diagnosis("classic");
    for (const Json& cause : result.at("causes")) causes[cause.at("effect")] = cause;
    return causes;
  };
  const std::map<std::string, Json> of_play = found(0.0, 0.02);
  ASSERT_EQ(of_play.size(), 1u);
  ASSERT_TRUE(of_play.contains("transmission-play"));
  const Json size = of_play.at("transmission-play").at("parameters")[0];
  EXPECT_NEAR(size.at("value").get<double>(), 0.02, 0.001);
  const std::map<std::string, Json> of_stretch = found(0.02, 0.0);
  EXPECT_TRUE(of_stretch.contains("transmission-compliance"));
  EXPECT_FALSE(of_stretch.contains("transmission-play"));
  expectRefused({"predict", "d/model.yaml", "log.csv", "--joint-angle", "-o", "no"}, 2, "found no ratio");
}

TEST_F(DiagnoseTest, SaysUnexplainedAndTheChannelForWhatHasNoName) {
  reality::DriveDraw draw = shortDraw(15, 12000);
  draw.secret.humid_friction = 0.3;
  const LogAnswer answer = ask(draw);
  ASSERT_EQ(answer.verdict(), "unexplained") << answer.result.dump(1);
  EXPECT_EQ(answer.result.at("left_over").at("channels")[0].at("channel"), "humidity_percent")
      << answer.result.at("left_over").dump(1) << answer.result.at("candidates").dump(1);
  EXPECT_THAT(text("d/residual_humidity_percent.csv"), HasSubstr("humidity_percent,mean_residual"));
  EXPECT_THAT(answer.result.at("next_experiment").get<std::string>(), HasSubstr("humidity_percent"));
}

TEST_F(DiagnoseTest, SaysThatPushesByHandActUnseen) {
  const reality::DriveDraw draw = shortDraw(18);
  std::mt19937_64 random(18);
  putLog(draw, [&](reality::DriveRecord& record) {  // half a second each, here and there, either way
    std::uniform_real_distribution<double> push(-8.0, 8.0), moment(0.0, static_cast<double>(record.current.size()));
    for (int k = 0; k < 60; ++k) {
      const double strength = push(random) * draw.rig.current_noise, middle = moment(random);
      for (std::size_t i = 0; i < record.current.size(); ++i) {
        record.current[i] += strength * std::exp(-0.5 * std::pow((static_cast<double>(i) - middle) / 15.0, 2));
      }
    }
  });
  const Json result = diagnosis("classic");
  EXPECT_EQ(result.at("verdict"), "unexplained") << result.at("sentence");
  EXPECT_TRUE(result.at("causes").empty());
  EXPECT_GT(result.at("left_over").at("share_percent").get<double>(), 50.0);
  EXPECT_THAT(result.at("next_experiment").get<std::string>(), HasSubstr("what else acts on the rig"));
}

TEST_F(DiagnoseTest, TheSameSeedGivesTheSameAnswerForAnyNumberOfThreads) {
  reality::DriveDraw draw = shortDraw(16);
  draw.rig.rows = 6000;
  draw.secret.capstan = 0.3;
  putLog(draw, [](reality::DriveRecord&) {});
  std::vector<std::string> answers;
  for (const char* threads : {"1", "2"}) {
    diagnosis("classic", {"--threads", threads});
    answers.push_back(text("d/result.json") + text("d/model.yaml") + text("d/hypotheses.csv"));
  }
  EXPECT_EQ(answers[0], answers[1]);
}

TEST_F(DiagnoseTest, DataFaultsComeBeforePhysics) {
  const reality::DriveDraw draw = shortDraw(17);
  const auto faultOf = [&](const char* channel, const char* words,
                           const std::function<void(reality::DriveRecord&)>& spoil) {
    putLog(draw, spoil);
    const Json json = diagnosis("classic");
    Json named = Json::object();
    for (const Json& fault : json.at("faults")) {
      if (fault.at("sentence").get<std::string>().find(words) != std::string::npos) named = fault;
    }
    EXPECT_EQ(named.value("channel", ""), channel) << words << ": " << json.at("faults").dump(1);
    return std::pair(json, named);
  };
  using Spoil = std::function<void(reality::DriveRecord&)>;
  // Rows that cannot be believed are left out: the others still tell that nothing is hidden.
  const std::tuple<const char*, const char*, Spoil> mended[] = {
      {"motor_current_A", "saturated",
       [](reality::DriveRecord& r) {
         for (double& i : r.current) i = std::clamp(i, -5.0, 5.0);
       }},
      {"external_torque", "stuck",
       [](reality::DriveRecord& r) {
         for (std::size_t i = 3000; i < 3400; ++i) r.torque[i] = r.torque[3000];
       }},
      {"motor_current_A", "drops to exactly 0", [](reality::DriveRecord& r) {
         for (std::size_t i = 500; i + 3 < r.current.size(); i += 60) {
           for (std::size_t k = i; k < i + 3; ++k) r.current[k] = 0.0;
         }
       }}};
  for (const auto& [channel, words, spoil] : mended) {
    const auto [json, fault] = faultOf(channel, words, spoil);
    EXPECT_EQ(json.at("verdict"), "nothing-found") << json.at("sentence");
    EXPECT_TRUE(fault.value("corrected", false));
    EXPECT_GT(fault.value("rows", 0), 0);
  }
  // A channel with the wrong sign leaves nothing to believe.
  const std::tuple<const char*, const char*, Spoil> hopeless[] = {
      {"external_torque", "wrong sign",
       [](reality::DriveRecord& r) {
         for (double& t : r.torque) t = -t;
       }},
      {"joint_position", "wrong sign", [](reality::DriveRecord& r) {
         for (double& a : r.angle) a = -a;
       }}};
  for (const auto& [channel, words, spoil] : hopeless) {
    const auto [json, fault] = faultOf(channel, words, spoil);
    EXPECT_FALSE(fault.value("corrected", true));
    EXPECT_EQ(json.at("verdict"), "data-fault");
    EXPECT_TRUE(json.at("baseline").at("mse_heldout").is_null());
  }
}

// Another rig's logs: it stands still under load for 6 to 45 s while the holding controller leaves its current
// anywhere; there is only an encoder, with spikes, and a gap. What is hidden has another shape than the catalogue's
// formula.
TEST_F(DiagnoseTest, StandstillIsNoEvidence) {
  const auto ask = [&](const std::string& log) {
    const CsvTable whole = CsvTable::load(sourceFile("data/logs/" + log));
    put("log.csv", firstRows(whole, whole.rows() / 2));
    return diagnosis("classic");
  };
  const Json none = ask("standstill-none.csv.gz");
  EXPECT_EQ(none.at("verdict"), "nothing-found") << none.at("sentence");
  EXPECT_THAT(none.at("warnings").dump(), HasSubstr("stands still"));
  const Json bend = ask("standstill-bend-friction.csv.gz");
  EXPECT_EQ(bend.at("verdict"), "cause-found") << bend.at("sentence");
  ASSERT_EQ(bend.at("causes").size(), 1u);
  EXPECT_EQ(bend.at("causes")[0].at("effect"), "bend-friction");
}

TEST_F(DiagnoseTest, AFewOutliersAreLeftOutAndSaid) {
  putLog(shortDraw(18), [](reality::DriveRecord& r) {
    for (std::size_t i = 700; i < r.current.size(); i += 400) r.current[i] += 15.0;
  });
  const Json json = diagnosis("classic");
  EXPECT_EQ(json.at("verdict"), "nothing-found");
  ASSERT_EQ(json.at("faults").size(), 1u);
  EXPECT_TRUE(json.at("faults")[0].at("corrected"));
  EXPECT_THAT(json.at("faults")[0].at("sentence").get<std::string>(), HasSubstr("left out"));
}

TEST_F(DiagnoseTest, SelfTestCountsWhatItNames) {
  reality::DriveDraw draw = shortDraw(19);
  draw.rig.rows = 8000;
  putLog(draw, [](reality::DriveRecord&) {});
  const Json json =
      diagnosis("classic", {"--self-test", "1", "--effects", "coulomb-offset,current-bias,bend-friction"});
  const Json test = json.at("self_test");
  EXPECT_EQ(test.at("hidden"), (std::vector<std::string>{"none", "bend-friction", "coulomb-offset", "current-bias"}));
  int runs = 0;
  for (const Json& row : test.at("count")) {
    for (const Json& count : row) runs += count.get<int>();
  }
  EXPECT_EQ(runs, 4);
  EXPECT_GE(test.at("power").get<double>(), 0.6);
  EXPECT_THAT(text("d/confusion.csv"), testing::StartsWith("hidden,nothing,"));
}

TEST_F(DiagnoseTest, RefusesWhatItCannotUse) {
  putLog(shortDraw(20), [](reality::DriveRecord&) {});
  expectRefused({"diagnose", "classic", "--log", "none.csv", "-o", "d"}, 2, "none.csv");
  expectRefused({"diagnose", "magic", "--log", "log.csv", "-o", "d"}, 2, "expected one of");
  expectRefused({"diagnose", "classic", "--log", "log.csv", "--effects", "gremlins", "-o", "d"}, 2, "gremlins");
  put("short.csv", firstLines(text("log.csv"), 200));
  expectRefused({"diagnose", "classic", "--log", "short.csv", "-o", "d"}, 3, "blocks");
}

}  // namespace
}  // namespace simgap::test
