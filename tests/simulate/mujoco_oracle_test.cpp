// MuJoCo itself (tests/oracle, npm's mujoco-js) judges robots that came from MJCF or go there: lengths of tendons,
// their moment arms, places of bodies, masses, and where a robot comes to rest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "simgap/core/random.h"
#include "simgap/core/run_directory.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

using Joints = std::vector<JointPosition>;

/// Answers of MuJoCo, one per line.
std::vector<Json> askMujoco(const Json& request) {
  const TemporaryFolder folder;
  const ProcessResult result = runProcess({"/usr/bin/env", "node", sourceFile("tests/oracle/mujoco.mjs").string(),
                                           folder.put("request.json", request.dump()).string()},
                                          folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err << result.out;
  std::vector<Json> answers;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) answers.push_back(Json::parse(line));
  return answers;
}

bool mujocoIsThere() {
  if (!std::filesystem::exists(sourceFile("tests/oracle/node_modules/mujoco-js"))) return false;
  return runProcess({"/usr/bin/env", "node", sourceFile("tests/oracle/mujoco.mjs").string()}, "/").exit_code == 0;
}

#define SIMGAP_NEEDS_MUJOCO() \
  if (!mujocoIsThere()) GTEST_SKIP() << "no MuJoCo to compare with: scripts/install_oracle (needs node and npm)"

ImportedArm importFile(const std::filesystem::path& file) {
  return readMjcf(readText(file), file, [](const std::filesystem::path& included) { return readText(included); });
}

/// MuJoCo's numbers of a position: quaternions w first.
std::vector<double> qposOf(const ArmModel& arm, const Joints& joints) {
  std::vector<double> qpos;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Eigen::Quaterniond& q = joints[j].rotation;
    if (arm.joints[j].hasAxis()) {
      qpos.push_back(joints[j].angle);
    } else {
      qpos.insert(qpos.end(), {q.w(), q.x(), q.y(), q.z()});
    }
  }
  return qpos;
}

Joints positionOf(const ArmModel& arm, const Json& qpos) {
  Joints joints(arm.joints.size());
  std::size_t k = 0;
  const auto next = [&] { return qpos.at(k++).get<double>(); };
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (arm.joints[j].hasAxis()) {
      joints[j].angle = next();
    } else {
      const double w = next(), x = next(), y = next(), z = next();
      joints[j].rotation = Eigen::Quaterniond(w, x, y, z).normalized();
    }
  }
  return joints;
}

Joints randomPosition(const ArmModel& arm, std::uint32_t individual) {
  const CounterRandom random(19);
  Joints joints(arm.joints.size());
  for (std::uint32_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = arm.joints[j];
    const auto uniform = [&](std::uint32_t k) { return random.uniform({0, individual, j, k}); };
    const double lower = std::max(joint.lower_limit, -1.5), upper = std::min(joint.upper_limit, 1.5);
    joints[j].angle = lower + (upper - lower) * uniform(0);
    joints[j].rotation = expSo3(0.8 * Eigen::Vector3d(uniform(1) - 0.5, uniform(2) - 0.5, uniform(3) - 0.5));
  }
  return joints;
}

/// The lines of an arm in the order of the file's tendons.
std::vector<std::pair<std::string, const TendonPath*>> linesOf(const ArmModel& arm) {
  std::vector<std::pair<std::string, const TendonPath*>> lines;
  for (const Muscle& muscle : arm.muscles) lines.emplace_back(muscle.name, &muscle);
  for (const PassiveTendon& tendon : arm.tendons) lines.emplace_back(tendon.name, &tendon);
  return lines;
}

double lengthAt(const ArmModel& arm, const TendonPath& path, const Joints& joints) {
  return tendonLength(arm, path, bodiesInWorld(arm, joints), joints);
}

/// d length / d dof, MuJoCo's dofs: a ball turns in its child's frame.
std::vector<double> momentArms(const ArmModel& arm, const TendonPath& path, const Joints& joints) {
  constexpr double kStep = 1e-6;
  std::vector<double> arms;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (int k = 0; k < arm.joints[j].degreesOfFreedom(); ++k) {
      Joints ahead = joints, behind = joints;
      ahead[j].angle += kStep;
      behind[j].angle -= kStep;
      if (!arm.joints[j].hasAxis()) {
        ahead[j].rotation = joints[j].rotation * expSo3(kStep * Eigen::Vector3d::Unit(k));
        behind[j].rotation = joints[j].rotation * expSo3(-kStep * Eigen::Vector3d::Unit(k));
      }
      arms.push_back((lengthAt(arm, path, ahead) - lengthAt(arm, path, behind)) / (2.0 * kStep));
    }
  }
  return arms;
}

/// Where MuJoCo and the arm disagree most over random positions.
struct Disagreement {
  double length = 0.0, arm = 0.0, place = 0.0, mass = 0.0;
  std::size_t compared = 0;
};

Disagreement disagreement(const ArmModel& arm, const std::string& xml, const std::filesystem::path& folder,
                          int positions) {
  Json request = {{"xml", xml}, {"folder", folder.string()}, {"positions", Json::array()}};
  std::vector<Joints> all;
  for (int i = 0; i < positions; ++i) {
    all.push_back(randomPosition(arm, static_cast<std::uint32_t>(i)));
    request["positions"].push_back(qposOf(arm, all.back()));
  }
  const std::vector<Json> answers = askMujoco(request);
  Disagreement worst;
  if (answers.size() != all.size() + 1) return worst;
  const std::vector<std::string> tendons = answers[0]["tendons"], bodies = answers[0]["bodies"];
  for (std::size_t j = 0; j < arm.joints.size(); ++j) EXPECT_EQ(answers[0]["joints"][j]["name"], arm.joints[j].name);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Json& answer = answers[i + 1];
    for (const auto& [name, path] : linesOf(arm)) {
      const auto at = static_cast<std::size_t>(std::ranges::find(tendons, name) - tendons.begin());
      EXPECT_LT(at, tendons.size()) << name;
      if (at == tendons.size()) continue;
      worst.length =
          std::max(worst.length, std::abs(lengthAt(arm, *path, all[i]) - answer["length"][at].get<double>()));
      const std::vector<double> arms = momentArms(arm, *path, all[i]);
      for (std::size_t d = 0; d < arms.size(); ++d) {
        worst.arm = std::max(worst.arm, std::abs(arms[d] - answer["arm"][at][d].get<double>()));
      }
      ++worst.compared;
    }
    const std::vector<BodyInWorld> placed = bodiesInWorld(arm, all[i]);
    for (std::size_t b = 0; b < arm.bodies.size(); ++b) {
      const auto at = static_cast<std::size_t>(std::ranges::find(bodies, arm.bodies[b].name) - bodies.begin());
      if (arm.bodies[b].fixed || at == bodies.size()) continue;
      const Json& p = answer["position"][at];
      worst.place = std::max(worst.place, (placed[b].origin - Eigen::Vector3d(p[0], p[1], p[2])).norm());
      const double mass = massProperties(arm.bodies[b]).mass - answers[0]["mass"][at].get<double>();
      worst.mass = std::max(worst.mass, std::abs(mass));
    }
  }
  return worst;
}

void expectAgreement(const std::filesystem::path& file, int positions) {
  const ImportedArm imported = importFile(file);
  const std::string xml = readText(file);
  for (const bool exported : {false, true}) {
    SCOPED_TRACE(exported ? "as exported again" : "as imported");
    const Disagreement found = exported
                                   ? disagreement(imported.model, writeMjcf(imported.model).text, "", positions / 10)
                                   : disagreement(imported.model, xml, file.parent_path(), positions);
    EXPECT_GT(found.compared, 0U);
    EXPECT_LT(found.length, 1e-6);  // [m]
    EXPECT_LT(found.arm, 1e-6);     // [m]; differences of lengths leave 1e-9
    EXPECT_LT(found.place, 1e-9);
    EXPECT_LT(found.mass, 1e-9);
  }
}

TEST(MujocoOracle, AgreesOnAFingerWithPulleyAndWraps) {
  SIMGAP_NEEDS_MUJOCO();
  expectAgreement(sourceFile("tests/oracle/finger.xml"), 1000);
}

TEST(MujocoOracle, AgreesOnAChainOfSlideBallAndHinge) {
  SIMGAP_NEEDS_MUJOCO();
  expectAgreement(sourceFile("tests/oracle/mixed_chain.xml"), 1000);
}

/// Models of others, which are no part of this repository.
void expectAgreementOnModel(const std::string& name) {
  const char* const given = std::getenv("SIMGAP_REAL_DATA");
  const std::filesystem::path real =
      given != nullptr ? std::filesystem::path(given) : sourceFile("../shared/data/real");
  const std::filesystem::path file = real / "../models" / name;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << " (SIMGAP_REAL_DATA)";
  expectAgreement(file, 1000);
}

TEST(MujocoOracle, AgreesOnArm26) {
  SIMGAP_NEEDS_MUJOCO();
  expectAgreementOnModel("arm26.xml");
}

TEST(MujocoOracle, AgreesOnTheTendonFinger) {
  SIMGAP_NEEDS_MUJOCO();
  expectAgreementOnModel("finger_v0.xml");
}

double largestTurn(const ArmModel& arm, const Joints& a, const Joints& b) {
  const std::vector<BodyInWorld> one = bodiesInWorld(arm, a), other = bodiesInWorld(arm, b);
  double turn = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    turn = std::max(turn, geodesicAngle(Eigen::Quaterniond(one[k].rotation), Eigen::Quaterniond(other[k].rotation)));
  }
  return toDegrees(turn);
}

TEST(MujocoOracle, AnImportedChainRestsWhereItDoesThere) {
  SIMGAP_NEEDS_MUJOCO();
  const std::filesystem::path file = sourceFile("tests/oracle/mixed_chain.xml");
  const ArmModel arm = importFile(file).model;
  const std::vector<Json> answers = askMujoco({{"xml", readText(file)}, {"settle", {{"seconds", 60}}}});
  ASSERT_EQ(answers.size(), 2U);
  ASSERT_LT(answers[1]["speed"].get<double>(), 1e-6);
  EquilibriumArm solver(arm);
  ASSERT_TRUE(solver.solveFrom(Joints(arm.joints.size()), {}).stable);
  const Joints rest = positionOf(arm, answers[1]["qpos"]);
  EXPECT_LT(largestTurn(arm, solver.joints(), rest), 0.05);
  EXPECT_NEAR(solver.joints()[0].angle, rest[0].angle, 1e-5);  // [m]
}

/// Poses at rest of an arm without friction: an equilibrium is where none is needed.
struct Rests {
  std::vector<Joints> poses;
  Json controls = Json::array(), starts = Json::array();
  int at_stops = 0;
};

Rests restsOf(const ArmModel& arm, double largest_shaft) {
  EquilibriumArm solver(arm);
  const CounterRandom random(7);
  Rests rests;
  for (std::uint32_t i = 0; i < 16; ++i) {
    std::vector<double> shafts;
    for (std::uint32_t m = 0; m < arm.muscles.size(); ++m)
      shafts.push_back(largest_shaft * random.uniform({0, i, m, 0}));
    if (!solver.solve(shafts).stable) continue;
    Joints start = solver.joints();
    bool at_stop = false;
    for (std::size_t j = 0; j < start.size(); ++j) {
      const Joint& joint = arm.joints[j];
      const double angle = start[j].angle;
      at_stop = at_stop || (joint.hasAxis() && std::min(angle - joint.lower_limit, joint.upper_limit - angle) < 1e-6);
      start[j].rotation = start[j].rotation * expSo3({0.03, -0.02, 0.04});
      start[j].angle += angle + 0.03 < joint.upper_limit ? 0.03 : -0.03;
    }
    rests.poses.push_back(solver.joints());
    rests.starts.push_back(qposOf(arm, start));
    rests.controls.push_back(shafts);
    rests.at_stops += at_stop ? 1 : 0;
  }
  return rests;
}

/// The largest turn between a body's rest here and there [deg]. \param xml  the exported model
double largestRestError(const ArmModel& arm, const Rests& rests, const std::string& xml) {
  const Json settle = {{"seconds", 40}, {"controls", rests.controls}, {"starts", rests.starts}};
  const std::vector<Json> answers = askMujoco({{"xml", xml}, {"settle", settle}});
  if (answers.size() != rests.poses.size() + 1) return 360.0;
  double worst = 0.0;
  for (std::size_t i = 0; i < rests.poses.size(); ++i) {
    EXPECT_LT(answers[i + 1]["speed"].get<double>(), 1e-6) << "pose " << i;
    worst = std::max(worst, largestTurn(arm, rests.poses[i], positionOf(arm, answers[i + 1]["qpos"])));
  }
  std::printf("%zu rests of %s, %d of them at a stop: within %.3f deg\n", rests.poses.size(), arm.name.c_str(),
              rests.at_stops, worst);
  return worst;
}

ArmModel withoutFriction(const std::string& file) {
  ArmModel arm = readArm(YamlNode::parse(readText(sourceFile(file)), "arm.yaml"));
  for (Joint& joint : arm.joints) joint.coulomb_friction = 0.0;
  return arm;
}

TEST(MujocoOracle, TheSampleArmRestsThereWhereItDoesHere) {
  SIMGAP_NEEDS_MUJOCO();
  const ArmModel arm = withoutFriction("data/arm/arm.yaml");
  const Rests rests = restsOf(arm, 4.0);
  ASSERT_GE(rests.poses.size(), 8U);
  EXPECT_LT(largestRestError(arm, rests, writeMjcf(arm).text), 0.05);
}

/// The model with MuJoCo's own numbers for limits and equalities.
std::string soft(const std::string& xml) {
  return std::regex_replace(xml, std::regex(" (solref|solimp)(limit)?=\"[^\"]*\""), "");
}

// The figures of docs/convert.md.
TEST(MujocoOracle, TheFingerRestsThereAtItsStopsAndByItsCoupling) {
  SIMGAP_NEEDS_MUJOCO();
  ArmModel arm = withoutFriction("data/finger/arm.yaml");
  const Rests free = restsOf(arm, 4.0);
  ASSERT_GE(free.at_stops, 4);
  EXPECT_LT(largestRestError(arm, free, writeMjcf(arm).text), 0.15);
  EXPECT_GT(largestRestError(arm, free, soft(writeMjcf(arm).text)), 5.0);
  Joint& tip = arm.joints.back();
  tip.leader = 2;
  tip.coupling_ratio = 0.7;
  tip.coupling_offset = 0.05;
  const Rests coupled = restsOf(arm, 4.0);
  ASSERT_GE(coupled.poses.size(), 8U);
  EXPECT_LT(largestRestError(arm, coupled, writeMjcf(arm).text), 0.05);
  EXPECT_GT(largestRestError(arm, coupled, soft(writeMjcf(arm).text)), 5.0);
}

TEST(MujocoOracle, ItsStopsGiveWayAsFarAsTheExportSays) {
  SIMGAP_NEEDS_MUJOCO();
  const std::string link = "<geom type='capsule' fromto='0 0 0 0.03 0 0.01' size='0.005' mass='0.004'/>";
  const std::string text =
      "<mujoco><option gravity='0 0 0'/><worldbody><body><joint name='a' axis='0 1 0' stiffness='2' "
      "damping='0.0005'/>" +
      link + "<body pos='0.03 0 0'><joint name='b' axis='0 1 0' range='-90 5' damping='0.0005'/>" + link +
      "</body></body></worldbody><actuator><motor joint='b'/></actuator></mujoco>";
  const ArmModel arm = readMjcf(text, "robot.xml", [](const std::filesystem::path&) { return std::string(); }).model;
  const ExportedArm written = writeMjcf(arm);
  const std::vector<Json> answers =
      askMujoco({{"xml", written.text}, {"settle", {{"seconds", 5}, {"controls", {{0.1}}}}}});
  ASSERT_EQ(answers.size(), 2U);
  const double beyond = toDegrees(answers[1]["qpos"][1].get<double>() - arm.joints[1].upper_limit);
  std::string said;
  for (const ExchangeRemark& remark : written.remarks) said += remark.what == "joint limits" ? remark.done : "";
  std::smatch number;
  ASSERT_TRUE(std::regex_search(said, number, std::regex("0.1 Nm press 'b', .*, ([0-9.]+) deg beyond")));
  EXPECT_GT(beyond, 0.1);
  EXPECT_NEAR(std::stod(number[1]) / beyond, 1.0, 0.05);  // two digits are said
}

/// Processor time of a step of a motion [us].
double ourStep(const ArmModel& arm) {
  constexpr int kSteps = 5000;
  BulletArmOptions options;
  options.step = 0.001;
  BulletArm bullet(arm, options);
  const std::clock_t begin = std::clock();
  for (int i = 0; i < kSteps; ++i) bullet.stepMotion();
  EXPECT_TRUE(bullet.isFinite());
  return 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / kSteps;
}

// Says what a step takes there and here (docs/studies/speed.md); the machine decides, so there is no limit but sanity.
TEST(MujocoOracle, TakesStepsOfTheSameLengthInTheTimeThatIsPrinted) {
  SIMGAP_NEEDS_MUJOCO();
  for (const char* name : {"arm", "finger"}) {
    const std::filesystem::path file = sourceFile(std::string("data/") + name + "/arm.yaml");
    const ArmModel arm = readArm(YamlNode::parse(readText(file), "arm.yaml"));
    const Json answer = askMujoco({{"xml", writeMjcf(arm).text}, {"time_steps", 5000}}).at(0);
    const double theirs = answer.at("step_us").get<double>(), ours = ourStep(arm);
    std::printf("%s: MuJoCo (WebAssembly) %.1f us, here %.1f us for a step of 1 ms\n", name, theirs, ours);
    EXPECT_EQ(answer.at("timestep_s").get<double>(), 0.001);
    EXPECT_GT(theirs, 0.0);
    EXPECT_LT(std::max(ours, theirs), 1000.0) << "slower than the movement itself";
  }
}

}  // namespace
}  // namespace simgap::test
