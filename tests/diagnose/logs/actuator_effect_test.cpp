// Every registered effect on drives: its promises to whoever uses it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "diagnose/logs/few_rows.h"
#include "reality/drive_draws.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"
#include "reality/spring_rig.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/measure/logs/prepared_log.h"
#include "support/files.h"

namespace simgap::test {
namespace {

PreparedLog smallLog(ActuatorKind kind) {
  if (kind == ActuatorKind::kPam) {
    return prepareLog(CsvTable::parse(reality::recordPam({}, {.sessions = 3, .rows = 600}).csv(), "log.csv"), {}, kind);
  }
  if (kind == ActuatorKind::kSpring) {
    return prepareLog(CsvTable::parse(reality::recordSpring({}, {.sessions = 3, .seconds = 12.0}).csv(), "log.csv"), {},
                      kind);
  }
  if (kind == ActuatorKind::kMotor) {
    const reality::MotorDesign design{.seconds = 1.5, .rate = 500.0, .current_noise = 0.02, .velocity_noise = 0.2};
    return prepareLog(CsvTable::parse(reality::simulateMotor({}, design).csv(), "log.csv"), {}, kind);
  }
  reality::DriveRig rig = reality::drawRig(3);
  rig.rows = 3000;
  return prepareLog(CsvTable::parse(reality::recordDrive(rig, {}).csv(), "log.csv"), {}, ActuatorKind::kFriction);
}

/// With an angle of the motor that does not quite follow the joint's.
PreparedLog transmissionLog() {
  PreparedLog drive = smallLog(ActuatorKind::kFriction);
  ActuatorRows& rows = drive.data.rows;
  rows.motor_angle = 97.74 * (rows.joint_angle + 1e-3 * rows.load);
  return prepareTransmissionData(drive);
}

/// The name of the model that the effect extends, and a base with plausible values.
std::string modelOf(const ActuatorEffect& effect) {
  if (effect.kind == ActuatorKind::kPam) return "pam";
  if (effect.kind == ActuatorKind::kSpring) return "spring";
  return effect.kind == ActuatorKind::kMotor ? "motor" : "classic";
}

class DriveEffectContract : public testing::TestWithParam<const ActuatorEffect*> {
 protected:
  static std::optional<double> presliding() {
    const ActuatorKind kind = GetParam()->kind;
    if (kind == ActuatorKind::kFriction || kind == ActuatorKind::kGearbox) return 0.05;
    return std::nullopt;
  }
  static ActuatorBase base() {
    if (GetParam()->kind == ActuatorKind::kTransmission) return *actuator_equations::find(ActuatorKind::kTransmission);
    return subjectOf(modelOf(*GetParam())).base;
  }
  static std::vector<double> middle(const ActuatorRegression& model, const ActuatorRows& rows) {
    const ActuatorRegression plain(base(), {}, data(), presliding());
    const std::vector<double> base = plain.thetaOf(std::vector<Estimate>{{"k_a", "", 1.2, 0},
                                                                         {"n_c", "", 0.3, 0},
                                                                         {"n_s", "", 0.4, 0},
                                                                         {"k_v", "", 0.01, 0},
                                                                         {"v_s", "", 6.0, 0},
                                                                         {"delta", "", 1.1, 0},
                                                                         {"presliding", "", 0.02, 0},
                                                                         {"a", "", 0.004, 0},
                                                                         {"b", "", -0.008, 0},
                                                                         {"c", "", 0.0025, 0},
                                                                         {"R", "", 0.8, 0},
                                                                         {"L", "", 0.004, 0},
                                                                         {"K_E", "", 0.02, 0},
                                                                         {"stiffness", "", 150.0, 0},
                                                                         {"offset", "", 0.3, 0},
                                                                         {"damping", "", 4.0, 0},
                                                                         {"inverse_ratio", "", 0.0102, 0}});
    std::vector<double> theta = model.startFrom(plain, base);
    const ActuatorEffect& effect = *model.effects()[0];
    if (effect.starts != nullptr) {
      const auto starts = effect.starts(rows, Eigen::ArrayXd::LinSpaced(rows.rows(), -1.0, 1.0));
      if (!starts.empty())
        std::ranges::copy(starts.back(), theta.begin() + static_cast<std::ptrdiff_t>(model.firstParameter(0)));
    }
    for (std::size_t k = 0; k < effect.columns.size(); ++k)
      theta[model.firstColumn(0) + k] = effect.columns[k].unit == "m2" ? 1e-5 : 0.05;
    return theta;
  }
  static const ActuatorData& data() {
    static const std::map<ActuatorKind, PreparedLog> logs = {
        {ActuatorKind::kFriction, smallLog(ActuatorKind::kFriction)},
        {ActuatorKind::kMotor, smallLog(ActuatorKind::kMotor)},
        {ActuatorKind::kPam, smallLog(ActuatorKind::kPam)},
        {ActuatorKind::kSpring, smallLog(ActuatorKind::kSpring)},
        {ActuatorKind::kTransmission, transmissionLog()}};
    const ActuatorKind kind = GetParam()->kind;
    return logs.at(kind == ActuatorKind::kGearbox ? ActuatorKind::kFriction : kind).data;
  }
};

TEST_P(DriveEffectContract, SaysWhatItIs) {
  const ActuatorEffect& effect = *GetParam();
  for (const std::string_view text : {effect.name, effect.cause, effect.equation, effect.signature, effect.source,
                                      effect.look_alikes, effect.separates}) {
    EXPECT_FALSE(text.empty()) << effect.name;
  }
  EXPECT_FALSE(effect.parameters.empty() && effect.columns.empty());
  EXPECT_EQ(&actuator_effects::find(effect.name, effect.form), &effect);
  EXPECT_EQ(actuator_effects::find(effect.name).name, effect.name);  // without a form the usual one
  std::set<std::string_view> names;
  for (const EffectParameter& p : effect.parameters) {
    EXPECT_LE(p.lower, p.upper);
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
  }
  for (const EffectColumn& c : effect.columns) EXPECT_TRUE(names.insert(c.name).second) << c.name;
}

TEST_P(DriveEffectContract, DerivativesAgreeWithDifferences) {
  const ActuatorRegression model(base(), {GetParam()}, data(), std::nullopt);
  const std::vector<double> theta = middle(model, data().rows);
  Eigen::VectorXd residual, ahead, behind;
  Eigen::MatrixXd jacobian;
  model.evaluate(theta, residual, &jacobian);
  ASSERT_TRUE(residual.allFinite());
  ASSERT_TRUE(jacobian.allFinite());
  for (std::size_t i = 0; i < theta.size(); ++i) {
    if (model.parameters()[i].fixed) continue;
    if (GetParam()->name == "channel-delay" && i + 1 == theta.size()) continue;  // piecewise linear between rows
    std::vector<double> moved = theta;
    const double h = 1e-4 * std::max(std::abs(theta[i]), 0.01);
    moved[i] = theta[i] + h;
    model.evaluate(moved, ahead, nullptr);
    moved[i] = theta[i] - h;
    model.evaluate(moved, behind, nullptr);
    const Eigen::VectorXd slope = (ahead - behind) / (2.0 * h);
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_LT((jacobian.col(k) - slope).norm(), 2e-3 * (slope.norm() + 1e-6)) << model.parameters()[i].name;
  }
}

TEST_P(DriveEffectContract, NeutralValuesChangeNothing) {
  const ActuatorEffect& effect = *GetParam();
  const ActuatorRegression plain(base(), {}, data(), std::nullopt);
  const ActuatorRegression model(base(), {&effect}, data(), std::nullopt);
  std::vector<double> theta = middle(model, data().rows);
  for (std::size_t k = 0; k < effect.columns.size(); ++k) theta[model.firstColumn(0) + k] = 0.0;
  for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
    // A bristle's travel is a shape, yet none at all is no bristle.
    if (effect.parameters[k].kind == EffectParameter::Kind::kSmooth || effect.parameters.size() == 1) {
      theta[model.firstParameter(0) + k] = std::max(effect.parameters[k].neutral, effect.parameters[k].lower);
    }
  }
  const Eigen::ArrayXd with = model.predict(theta), without = plain.predict(plain.startFrom(model, theta));
  // A bristle of no travel at all still needs a row to turn.
  const double allowed = effect.in_every_drive ? 0.02 : 1e-12;
  EXPECT_LT(((with - without).abs() > 1e-9).cast<double>().mean(), allowed) << effect.name;
}

/// Without the channels that an effect can do without.
ActuatorData bare(ActuatorData data, const ActuatorEffect& effect) {
  const auto drop = [&](OptionalChannel channel, Eigen::ArrayXd& values) {
    if (std::ranges::find(effect.needs, channel) == effect.needs.end()) values.resize(0);
  };
  drop(OptionalChannel::kJointAngle, data.rows.joint_angle);
  drop(OptionalChannel::kMotorAngle, data.rows.motor_angle);
  drop(OptionalChannel::kTemperature, data.rows.temperature);
  return data;
}

TEST_P(DriveEffectContract, SaysTheSameOfFewRows) {
  const ActuatorEffect& effect = *GetParam();
  if (effect.needs_all_rows) GTEST_SKIP() << "needs all of them";
  const ActuatorData least = bare(data(), effect);
  for (const ActuatorData* log : {&data(), &least}) {
    if (effect.kind == ActuatorKind::kTransmission && log == &least) continue;  // explains the angles themselves
    const FewRows few = fewRowsOf(*log, {{0, static_cast<std::size_t>(log->rows.rows())}}, 700);
    const ActuatorRegression model(base(), {&effect}, *log, std::nullopt);
    const std::vector<double> theta = middle(model, log->rows);
    const Eigen::ArrayXd all = model.predict(theta)(few.at), some = model.on(few.data).predict(theta);
    // What turns twice between two of the rows has forgotten the first time, and a clock may begin at another row.
    const double allowed = effect.remembers ? 0.01 : 1e-5;
    EXPECT_LE((some - all).matrix().norm(), allowed * all.matrix().norm()) << effect.name;
  }
}

TEST_P(DriveEffectContract, SurvivesAModelFile) {
  if (GetParam()->kind == ActuatorKind::kTransmission) GTEST_SKIP() << "says nothing about the effort";
  const ActuatorRegression model(base(), {GetParam()}, data(), std::nullopt);
  const std::vector<double> theta = middle(model, data().rows);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(theta.size(), theta.size());
  FittedModel file;
  file.kind = modelOf(*GetParam()) == "classic" ? "friction" : modelOf(*GetParam());
  file.law = "classic";
  file.extensions = model.extensions(theta, none);
  for (const Estimate& p : model.physical(theta, none)) {
    if (p.name.find('.') == std::string::npos) file.parameters.push_back({p.name, p.unit, p.value, p.sd});
  }
  const FittedModel read = readFittedModel(YamlNode::parse(writeFittedModel(file), "model.yaml"));
  const Eigen::ArrayXd predicted = predictExtended(subjectOf(read), data());
  EXPECT_LT((predicted - model.predict(theta)).abs().maxCoeff(), 1e-9 * (1.0 + predicted.abs().maxCoeff()));
}

TEST(PositionRipple, CountsWhereItIsSeenToRepeat) {
  const PreparedLog log = smallLog(ActuatorKind::kFriction);
  const Eigen::ArrayXd& angle = log.data.rows.joint_angle;
  const double period = 2.0 * std::numbers::pi / (angle.maxCoeff() - angle.minCoeff());
  const ActuatorEffect& ripple = actuator_effects::find("position-ripple");
  const double once = 2.0 * period, real = 3.0 * period;
  EXPECT_FALSE(ripple.counts({&once, 1}, log.data.rows));
  EXPECT_TRUE(ripple.counts({&real, 1}, log.data.rows));
}

TEST(SpeedLimit, IsACeilingOnlyWhereTheEffortStandsAtOne) {
  PreparedLog log = smallLog(ActuatorKind::kFriction);
  ActuatorRows& rows = log.data.rows;
  const ActuatorEffect& ceiling = actuator_effects::find("speed-limit", "ceiling");
  const Eigen::ArrayXd phase = Eigen::ArrayXd::LinSpaced(rows.rows(), 0.0, 60.0);
  rows.speed = rows.top_speed * phase.sin();
  rows.direction = (rows.speed > 0.0).select(Eigen::ArrayXd::Ones(rows.rows()), -Eigen::ArrayXd::Ones(rows.rows()));
  const double limit = 0.7 * rows.top_speed;
  rows.effort = 0.5 * rows.direction + 10.0 * rows.speed / rows.top_speed;
  EXPECT_FALSE(ceiling.counts({&limit, 1}, rows));  // it goes on growing
  rows.effort = rows.effort.min(7.5).max(-7.5);
  EXPECT_TRUE(ceiling.counts({&limit, 1}, rows));
  const Eigen::ArrayXd clipped = rows.effort;
  rows.effort = 40.0 + 0.1 * clipped;
  EXPECT_FALSE(ceiling.counts({&limit, 1}, rows));  // a constant force stands there always, at any speed
  rows.effort = clipped;
  const double nowhere = 2.0 * rows.speed.abs().maxCoeff();
  EXPECT_FALSE(ceiling.counts({&nowhere, 1}, rows));
}

TEST(TorqueSaturation, AKneeIsAboveAQuarterOfTheRows) {
  PreparedLog log = smallLog(ActuatorKind::kFriction);
  ActuatorRows& rows = log.data.rows;
  rows.effort = Eigen::ArrayXd::LinSpaced(rows.rows(), -1.0, 1.0);
  const ActuatorEffect& saturation = actuator_effects::find("torque-saturation", "knee");
  EXPECT_FALSE(saturation.counts(std::array{0.1, 0.1}, rows));  // of the size and the knee
  EXPECT_TRUE(saturation.counts(std::array{0.1, 0.5}, rows));
}

TEST(RegimeChange, HasRowsOnEitherSide) {
  PreparedLog log = smallLog(ActuatorKind::kFriction);
  ActuatorRows& rows = log.data.rows;
  rows.elapsed = Eigen::ArrayXd::LinSpaced(rows.rows(), 0.0, 100.0);
  const ActuatorEffect& change = actuator_effects::find("regime-change");
  EXPECT_FALSE(change.counts(std::array{0.2, 5.0}, rows));
  EXPECT_TRUE(change.counts(std::array{0.2, 50.0}, rows));
  EXPECT_FALSE(change.counts(std::array{0.2, 95.0}, rows));
}

std::vector<const ActuatorEffect*> everyForm() {
  std::vector<const ActuatorEffect*> list;
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    list.push_back(effect);
    list.insert(list.end(), effect->other_forms.begin(), effect->other_forms.end());
  }
  return list;
}

INSTANTIATE_TEST_SUITE_P(All, DriveEffectContract, testing::ValuesIn(everyForm()), [](const auto& effect) {
  std::string name(effect.param->name);
  if (!effect.param->form.empty()) name += "_" + std::string(effect.param->form);
  std::ranges::replace(name, '-', '_');
  return name;
});

// The first rows of every session, of which the motion is not yet known well, were a hose that pulls there.
TEST(JointSpring, IsNotAnEndOfAFewRows) {
  ActuatorRows rows;
  rows.joint_angle = Eigen::ArrayXd::LinSpaced(1000, 0.0, 1.0);
  for (const char* form : {"above", "below"}) {
    const ActuatorEffect& spring = actuator_effects::find("joint-spring", form);
    EXPECT_FALSE(spring.counts(std::array{0.4, 0.01}, rows)) << form;
    EXPECT_FALSE(spring.counts(std::array{0.4, 0.99}, rows)) << form;
    EXPECT_TRUE(spring.counts(std::array{0.4, 0.1}, rows)) << form;
  }
}

// A load cell that creeps was a drive that is warm within a second, the shortest time there is.
TEST(FrictionHeating, AtTheShortestWarmUpIsRefused) {
  for (const EffectParameter& p : actuator_effects::find("friction-heating").parameters) {
    if (p.name == "t_warm") EXPECT_NE(p.neutral, p.lower) << "a value at its neutral bound is not refused";
  }
}

TEST(SpringPlay, IsPulledThroughBothWays) {
  ActuatorRows rows;
  rows.deflection = Eigen::ArrayXd::LinSpaced(1000, 0.0, 1.0);
  const ActuatorEffect& play = actuator_effects::find("spring-play");
  EXPECT_TRUE(play.counts(std::array{0.2, 0.5}, rows));     // of its width and its middle
  EXPECT_FALSE(play.counts(std::array{0.2, 0.13}, rows));   // hardly beyond one end: a cord that hangs loose
  EXPECT_FALSE(play.counts(std::array{0.002, 0.5}, rows));  // hardly a row within it
  EXPECT_TRUE(play.counts(std::array{0.008, 0.5}, rows));   // fast through it: the force steps there all the same
}

// A jump has no derivative: a search had ended where it stood, with an interval of a thousandth of what the log told.
TEST(SpringPlay, AndSlackHaveADamperThatComesInWithoutAJump) {
  ActuatorRows rows;
  rows.deflection = Eigen::ArrayXd::LinSpaced(1000, 0.0, 1.0);
  const auto viscous = [&](const char* effect, std::initializer_list<double> p) {
    ActuatorTerms terms;
    terms.deflection = rows.deflection;
    terms.viscous = Eigen::ArrayXd::Ones(1000);
    actuator_effects::find(effect).apply({p.begin(), p.size()}, rows, terms);
    return terms.viscous;
  };
  constexpr double kStep = 1e-6;
  const Eigen::ArrayXd moved =
      viscous("spring-play", {0.2, 0.5 + kStep, 0.0}) - viscous("spring-play", {0.2, 0.5, 0.0});
  EXPECT_LT(moved.abs().maxCoeff(), 1e3 * kStep);
  const Eigen::ArrayXd slack = viscous("spring-slack", {0.5 + kStep}) - viscous("spring-slack", {0.5});
  EXPECT_LT(slack.abs().maxCoeff(), 1e3 * kStep);
  const Eigen::ArrayXd loose = viscous("spring-slack", {0.5});
  EXPECT_EQ(loose[400], 0.0);
  EXPECT_EQ(loose[600], 1.0);
}

TEST(EffectForms, AFormThatIsNoneIsRefusedWithThoseThatAre) {
  EXPECT_THROW(
      {
        try {
          actuator_effects::find("bend-friction", "cubic");
        } catch (const ConfigError& error) {
          EXPECT_STREQ(error.what(),
                       "found the form 'cubic' of bend-friction, expected one of exponential, linear, symmetric");
          throw;
        }
      },
      ConfigError);
  EXPECT_THROW(actuator_effects::find("inertia", "linear"), ConfigError);
}

}  // namespace
}  // namespace simgap::test
