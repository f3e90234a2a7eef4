// What effects that need motion change of BulletArm::stepMotion().
#include <algorithm>
#include <cmath>

#include "bullet_arm_motion_state.h"

namespace simgap {

void BulletArm::setMotionEffects() {
  supply_ = {0.0, 1.0};
  guided_ = yielding_ = false;
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    MuscleState& muscle = muscles_[m];
    MotorTerm term;
    muscle.guide = {};
    muscle.relaxation = {0.0, 1.0};
    for (const auto& [effect, target, p] : extensions_) {
      if (target >= 0 && target != static_cast<int>(m)) continue;
      if (effect->motor) effect->motor(p, term);
      if (effect->guide) muscle.guide = effect->guide(p);
      if (effect->relaxation) muscle.relaxation = effect->relaxation(p);
    }
    muscle.setTerm(term, driveStep());
    muscle.relaxing = -std::expm1(-options_.step / muscle.relaxation.time);
    guided_ |= muscle.guide.loss > 0.0;
    yielding_ |= muscle.relaxation.share > 0.0;
  }
  for (const ArmExtension& extension : extensions_) {
    if (extension.effect->supply) supply_ = extension.effect->supply(extension.p);
  }
}

/// time dU/dt = U_0 - R sum V i / U - U with what the motors draw now, as a fraction of U_0; in parts of its time, so
/// that a heavy load does not make it ring.
void BulletArm::sagSupply() {
  double drawn = 0.0;  // [A] of the supply, by the duty cycles V / U_0
  for (const MuscleState& muscle : muscles_) drawn += muscle.voltage / muscle.supply_voltage * muscle.state.current;
  const double full = muscles_.front().supply_voltage;
  const double settled = std::clamp(1.0 - supply_.resistance * drawn / full, 0.05, 1.5);
  const double part = -std::expm1(-driveStep() / supply_.time);
  for (MuscleState& muscle : muscles_) muscle.supplied += part * (settled - muscle.supplied);
}

namespace {

/// v of v + most give s(v) = free, s(v) = v / sqrt(v^2 + creep^2): the slip that friction leaves of one that would be
/// `free`. Newton's steps from below the root, where the left side is concave, stay below it.
double slipLeft(double free, double most, double creep) {
  const double sign = free < 0.0 ? -1.0 : 1.0, wanted = sign * free;
  double v = std::max(wanted - most, wanted / (1.0 + most / creep));
  for (int i = 0; i < 8; ++i) {
    const double root = std::hypot(v, creep);
    v += (wanted - v - most * v / root) / (1.0 + most * creep * creep / (root * root * root));
  }
  return sign * v;
}

}  // namespace

/// Between cord and body guides take up to `loss` of the tension, as impulses against the slip that they leave. One
/// after the other until nothing changes (Gauss-Seidel).
void BulletArm::slipGuides(double step) {
  Motion& m = *motion_;
  constexpr int kMostSweeps = 30;
  constexpr double kStill = 1e-7;  // [m/s]
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    Motion::Pull& pull = m.pulls[i];
    pull.guided = pull.give = 0.0;
    if (!pull.taut || muscles_[i].guide.loss <= 0.0) continue;
    pull.response.noalias() = m.mobility.lazyProduct(pull.row);
    pull.give = pull.row.dot(pull.response);
  }
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double changed = 0.0;
    for (std::size_t i = 0; i < muscles_.size(); ++i) {
      Motion::Pull& pull = m.pulls[i];
      const GuideTerm& guide = muscles_[i].guide;
      if (!(pull.give > 0.0)) continue;
      const double slip = pull.row.dot(m.next), free = slip - pull.give * pull.guided;
      const double left = slipLeft(free, pull.give * step * guide.loss * std::max(0.0, pull.force), guide.creep);
      m.next += (left - slip) / pull.give * pull.response;
      pull.guided += (left - slip) / pull.give;
      changed = std::max(changed, std::abs(left - slip));
    }
    if (changed < kStill) return;
  }
}

/// y follows x, exactly for an x that holds.
void BulletArm::yieldCords() {
  for (MuscleState& muscle : muscles_) {
    const double stretched = std::max(0.0, muscle.expansion);
    muscle.yielded = muscle.yielded < 0.0 ? stretched : muscle.yielded + muscle.relaxing * (stretched - muscle.yielded);
  }
}

double BulletArm::controllerGain(std::size_t muscle) const { return muscles_[muscle].term.gain; }

}  // namespace simgap
