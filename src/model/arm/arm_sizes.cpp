#include "simgap/model/arm/arm_sizes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

// The sample arm's own (tests/model/arm/arm_sizes_test.cpp).
constexpr double kSampleLength = 0.0952;  // [m]
constexpr double kSampleForce = 85.7;     // [N] of its cords
constexpr double kSampleWeight = 16.38;   // [N] of its bodies
constexpr double kGravity = 9.81;         // [m/s^2]: an arm that lies on a table has its weight, too

/// Distance to the nearest joint of the body; infinite where it has none.
double leverOf(const ArmModel& model, const Attachment& attachment) {
  double nearest = kInfinity;
  for (const Joint& joint : model.joints) {
    if (joint.child == attachment.body) nearest = std::min(nearest, (attachment.point - joint.child_position).norm());
    if (joint.parent == attachment.body) nearest = std::min(nearest, (attachment.point - joint.parent_position).norm());
  }
  return nearest;
}

void addLevers(const ArmModel& model, const TendonPath& line, std::vector<double>& levers) {
  for (const Attachment& attachment : line.attachments) {
    const double lever = leverOf(model, attachment);
    if (lever > 0.0 && std::isfinite(lever)) levers.push_back(lever);
  }
}

}  // namespace

double ArmSizes::of(ArmSize size) const {
  switch (size) {
    case ArmSize::kNone:
      return 1.0;
    case ArmSize::kLength:
      return length;
    case ArmSize::kTorque:
      return force * length;
    case ArmSize::kCompliance:
      return 1.0 / force;
  }
  return 1.0;
}

ArmSizes sizesOf(const ArmModel& model) {
  std::vector<double> levers, stiffnesses;
  for (const Muscle& muscle : model.muscles) {
    addLevers(model, muscle, levers);
    stiffnesses.push_back(muscle.shock_cord.stiffness);
  }
  for (const PassiveTendon& tendon : model.tendons) {
    if (!tendon.kind->at_joint && !tendon.jointsOnly()) addLevers(model, tendon, levers);
  }
  double weight = 0.0;
  for (const Body& body : model.bodies) {
    if (!body.fixed) weight += kGravity * massProperties(body).mass;
  }
  ArmSizes sizes;
  if (!levers.empty()) sizes.length = median(std::move(levers)) / kSampleLength;
  if (!stiffnesses.empty()) {
    sizes.force = median(std::move(stiffnesses)) * sizes.length * kSampleLength / kSampleForce;
  } else if (weight > 0.0) {
    sizes.force = weight / kSampleWeight;
  }
  // Narrower priors lose what they were to help finding: a light forearm's payload, in motions.
  for (double* size : {&sizes.length, &sizes.force}) *size = std::max(1.0, *size);
  return sizes;
}

}  // namespace simgap
