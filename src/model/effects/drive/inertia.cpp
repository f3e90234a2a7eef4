/// \file
/// A torque that accelerates what the model takes for massless: + J dw/dt.
#include "simgap/model/drive_effect.h"

namespace simgap::drive_effects {
namespace {

constexpr EffectColumn kColumns[] = {{"J", "Nms2_rad", 0.0}};

void fill(std::span<const double> /*p*/, const DriveRows& rows, const DriveTerms& /*terms*/,
          const Eigen::ArrayXd& /*still*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.acceleration;
}

}  // namespace

extern const DriveEffect inertia;
const DriveEffect inertia = {
    .name = "inertia",
    .cause = "an inertia that the model leaves out has to be accelerated",
    .equation = "tau += J dw/dt",
    .source = "catalogue of causes",
    .look_alikes = "joint-gravity and channel-delay on sinusoids of one frequency",
    .separates = "the same angles at a slow and at a fast frequency",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::drive_effects
