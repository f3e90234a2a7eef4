// Every registered effect on drives: its promises to whoever uses it.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "reality/drive_draws.h"
#include "simgap/fit/drive_data.h"
#include "support/files.h"

namespace simgap::test {
namespace {

PreparedLog smallLog() {
  reality::DriveRig rig = reality::drawRig(3);
  rig.rows = 3000;
  return prepareDriveData(CsvTable::parse(reality::recordDrive(rig, {}).csv(), "log.csv"), {}, {}, {});
}

class DriveEffectContract : public testing::TestWithParam<const DriveEffect*> {
 protected:
  static std::vector<double> middle(const DriveRegression& model, const DriveRows& rows) {
    const DriveRegression plain(friction::find("classic"), {}, data(), 0.05);
    const std::vector<double> base = plain.thetaOf(std::vector<PhysicalParameter>{{"k_a", "", 1.2, 0, false},
                                                                                  {"n_c", "", 0.3, 0, false},
                                                                                  {"n_s", "", 0.4, 0, false},
                                                                                  {"k_v", "", 0.01, 0, false},
                                                                                  {"v_s", "", 6.0, 0, false},
                                                                                  {"delta", "", 1.1, 0, false},
                                                                                  {"presliding", "", 0.02, 0, false}});
    std::vector<double> theta = model.startFrom(plain, base);
    const DriveEffect& effect = *model.effects()[0];
    if (effect.starts != nullptr) {
      const auto starts = effect.starts(rows, Eigen::ArrayXd::LinSpaced(rows.rows(), -1.0, 1.0));
      if (!starts.empty())
        std::ranges::copy(starts.back(), theta.begin() + static_cast<std::ptrdiff_t>(model.firstParameter(0)));
    }
    for (std::size_t k = 0; k < effect.columns.size(); ++k) theta[model.firstColumn(0) + k] = 0.05;
    return theta;
  }
  static const DriveData& data() {
    static const PreparedLog log = smallLog();
    return log.data;
  }
};

TEST_P(DriveEffectContract, SaysWhatItIs) {
  const DriveEffect& effect = *GetParam();
  for (const std::string_view text :
       {effect.name, effect.cause, effect.equation, effect.source, effect.look_alikes, effect.separates}) {
    EXPECT_FALSE(text.empty()) << effect.name;
  }
  EXPECT_FALSE(effect.parameters.empty() && effect.columns.empty());
  EXPECT_EQ(&drive_effects::find(effect.name), &effect);
  std::set<std::string_view> names;
  for (const EffectParameter& p : effect.parameters) {
    EXPECT_LE(p.lower, p.upper);
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
  }
  for (const EffectColumn& c : effect.columns) EXPECT_TRUE(names.insert(c.name).second) << c.name;
}

TEST_P(DriveEffectContract, DerivativesAgreeWithDifferences) {
  const DriveRegression model(friction::find("classic"), {GetParam()}, data(), std::nullopt);
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
  const DriveEffect& effect = *GetParam();
  const DriveRegression plain(friction::find("classic"), {}, data(), std::nullopt);
  const DriveRegression model(friction::find("classic"), {&effect}, data(), std::nullopt);
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
  const double allowed = effect.name == "presliding-hysteresis" ? 0.02 : 1e-12;
  EXPECT_LT(((with - without).abs() > 1e-9).cast<double>().mean(), allowed) << effect.name;
}

TEST_P(DriveEffectContract, SurvivesAModelFile) {
  const DriveRegression model(friction::find("classic"), {GetParam()}, data(), std::nullopt);
  const std::vector<double> theta = middle(model, data().rows);
  const Eigen::MatrixXd none =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(theta.size()), static_cast<Eigen::Index>(theta.size()));
  FittedModel file;
  file.kind = "friction";
  file.law = "classic";
  file.extensions = model.extensions(theta, none);
  for (const PhysicalParameter& p : model.physical(theta, none)) {
    if (p.name.find('.') == std::string::npos) file.parameters.push_back({p.name, p.unit, p.value, p.sd, false});
  }
  const FittedModel read = readFittedModel(YamlNode::parse(writeFittedModel(file), "model.yaml"));
  const Eigen::ArrayXd predicted = predictExtended(subjectOf(read), data());
  EXPECT_LT((predicted - model.predict(theta)).abs().maxCoeff(), 1e-9 * (1.0 + predicted.abs().maxCoeff()));
}

INSTANTIATE_TEST_SUITE_P(All, DriveEffectContract,
                         testing::ValuesIn(drive_effects::all().begin(), drive_effects::all().end()),
                         [](const auto& effect) {
                           std::string name(effect.param->name);
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace simgap::test
