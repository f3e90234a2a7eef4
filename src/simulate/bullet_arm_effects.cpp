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

/// Between cord and body guides take up to `loss` of the tension, as impulses against the slip that they leave.
void BulletArm::slipGuides(double step) {
  Motion& m = *motion_;
  m.guides.clear();
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    const Motion::Pull& pull = m.pulls[i];
    const double most = pull.taut ? step * muscles_[i].guide.loss * pull.force : 0.0;
    if (most > 0.0) m.guides.add(pull.row, most, muscles_[i].guide.creep);
  }
  if (m.guides.empty()) return;
  m.guides.solve(m.inertia, m.v, m.next);
  m.mobility = m.guides.mobility();  // friction and limits push against lines that creep, too
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
