/// \file
/// Arms drawn and moved by the independent simulator with one cause hidden in them, and what is believed of them: the
/// cases of the study of motion diagnoses, and of make_hidden_data.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "simgap/core/random.h"
#include "support/motions.h"

namespace simgap::test {

/// An arm and its rig as they are.
struct DrawnReality {
  reality::MovingArm truth;
  reality::MotionRigOptions rig;
};

/// A cause that the reality can have, by its own law; its magnitude is the first parameter of the catalogue's.
struct MotionTruth {
  const char* effect;  ///< "": nothing of the catalogue
  const char* target;  ///< "link", "joint": the last one of the arm; else by its name
  double from, to;     ///< between which its magnitude is drawn
  void (*hide)(double magnitude, DrawnReality& drawn);
};

/// Nothing hidden first, what is in no catalogue last.
std::span<const MotionTruth> motionTruths();
/// By its effect; null: there is none.
const MotionTruth* findMotionTruth(std::string_view effect);

struct HiddenMotionCase {
  reality::MovingArm believed;
  DrawnReality drawn;
  double magnitude = 0.0;
  std::string target;  ///< as the model names it
};

/// A forearm whose muscles pull at a lever that tension does not tip over: what falls to its stop tells little; or the
/// arm of eleven muscles. Off from what is believed by what a static calibration and data sheets leave; a pure function
/// of its arguments.
enum class MotionArm { kForearm, kReferenceArm };
HiddenMotionCase drawHidden(MotionArm arm, std::uint64_t seed, const MotionTruth& truth);

/// Normal numbers of one stream after the other, and factors exp(sd x) of them.
class Deviations {
 public:
  Deviations(std::uint64_t seed, std::uint32_t stream) : random_(seed), stream_(stream) {}
  double normal() { return random_.normalPair({next_++, 0, 0, stream_})[0]; }
  void scale(double& value, double sd) { value *= std::exp(sd * normal()); }

 private:
  CounterRandom random_;
  std::uint32_t stream_, next_ = 0;
};
/// Joints, lines and cords off by what a static calibration and data sheets leave.
void deviate(reality::Arm& arm, Deviations& deviations);

/// Sines and a step between tense and slack, fast and slow, then rest, of two muscles against each other. [rad]
struct SwingSizes {
  double swing_from, swing_to, step_from, step_to;
  std::uint32_t stream;
};
reality::Setpoints opposedSwings(std::uint64_t draw, const SwingSizes& sizes);

/// Between three rests: a step, sines of one rate about the second, and a step to the third.
struct RestSwings {
  double slowest, rates;  ///< [1/s], and by how much the fastest is faster
  double size;            ///< [rad]
  double until;           ///< [s]
  std::uint32_t stream;
};
reality::Setpoints swingsBetweenRests(const reality::Arm& arm, std::uint64_t draw, const RestSwings& swings);

/// What such an arm is asked to do, by the number of the motion: sines and steps between tense and slack, fast and
/// slow, then rest.
reality::Setpoints drawSetpoints(MotionArm arm, std::uint64_t draw);
/// Numbers of the first motion that selects, and of the first that judges.
inline std::uint64_t firstSelecting(std::uint64_t seed) { return 1000 * seed; }
inline std::uint64_t firstJudging(std::uint64_t seed) { return 1000 * seed + 500; }
inline constexpr std::size_t kSelectingMotions = 8, kJudgingMotions = 5;

}  // namespace simgap::test
