#include "free_shape.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr EffectParameter kShapeParameters[] = {{"channel", "1", -2.0, 1e6, 0.0, 0.0, Kind::kConstant},
                                                {"lowest", "1", -1e12, 1e12, 0.0, 0.0, Kind::kConstant},
                                                {"between", "1", 0.0, 1e12, 1.0, 1.0, Kind::kConstant}};
constexpr EffectColumn effortKnot(std::string_view name) { return {.name = name, .unit = "A", .torque = false}; }
constexpr EffectColumn kShapeColumns[] = {effortKnot("c_1"), effortKnot("c_2"), effortKnot("c_3"), effortKnot("c_4"),
                                          effortKnot("c_5"), effortKnot("c_6"), effortKnot("c_7"), effortKnot("c_8")};
constexpr Index kShapeKnots = std::size(kShapeColumns);

const ArrayXd& valuesOf(ShapeOver channel, const ActuatorRows& rows) {
  if (channel == ShapeOver::kMotorAngle) return rows.motor_angle;
  if (channel == ShapeOver::kJointAngle) return rows.joint_angle;
  return rows.context[static_cast<std::size_t>(channel)];
}

void fillShape(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
               const ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const ArrayXd at = (valuesOf(static_cast<ShapeOver>(p[0]), rows) - p[1]) / p[2];
  for (Index k = 0; k < kShapeKnots; ++k) x.col(k) = (1.0 - (at - static_cast<double>(k)).abs()).max(0.0);
}

constexpr ActuatorEffect kFreeShape = {
    .name = "free-shape",
    .cause = "an effort of any shape over one channel",
    .equation = "I + c(u)",
    .signature = "structure over a channel",
    .source = "not a cause: what causes have to explain more than",
    .look_alikes = "",
    .separates = "the channel stepped up and down while all else repeats",
    .parameters = kShapeParameters,
    .columns = kShapeColumns,
    .fill = fillShape,
};

}  // namespace

Fitted besideShapeOver(const LogSearch& search, const Fitted& fitted, ShapeOver channel) {
  const ArrayXd& values = valuesOf(channel, search.data().rows);
  const double low = values.minCoeff(), between = (values.maxCoeff() - low) / static_cast<double>(kShapeKnots - 1);
  return search.beside(fitted, {&kFreeShape, {}, {static_cast<double>(channel), low, between}});
}

}  // namespace simgap
