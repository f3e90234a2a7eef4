/// \file
/// A spring, cord or tendon on a tensile rig. Nothing in it has a closed form that a model could share: the elastic
/// part is a table of forces that was read off a curve, creep is a chain of many Maxwell elements in small steps,
/// friction is a pack of sliders whose slip distances were drawn at random, a cord that hangs loose is a wire that
/// cannot push. The deflection is read by an encoder with a coarse step; the rig ramps, dwells, cycles and rests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

struct SpringTruth {
  /// (deflection [m], force [N]), rising; straight between them and beyond; empty: 150 N/m.
  std::vector<std::pair<double, double>> curve;
  double damping = 4.0;          ///< [N s/m]
  double sliding = 0.0;          ///< [N] of molecules that slide (Eyring): sliding asinh(rate / 1 mm/s)
  double creep_stiffness = 0.0;  ///< [N/m] of all Maxwell elements together
  double creep_seconds = 2.0;    ///< middle of their relaxation times
  double creep_decades = 0.0;    ///< over which these are spread
  double friction = 0.0;         ///< [N] of all sliders together
  double slip = 0.004;           ///< [m] mean distance after which they slip
  double slip_spread = 0.0;      ///< 0: all alike; 1: drawn between 0 and twice the mean
  double breaking = 0.0;         ///< [N/m] of chains that break for good, each beyond a stretch of its own
  double breaking_reach = 0.12;  ///< [m] up to which these are drawn
  bool pulls_only = false;       ///< no force below slack_below
  double slack_below = 0.0;      ///< [m]
  double force_offset = 0.0;     ///< [N] of the sensor
  double sweating = 0.0;         ///< a cause without a name: the force swings with humidity
};

struct SpringDesign {
  int sessions = 6;
  double seconds = 60.0;            ///< per session
  double rate = 50.0;               ///< [Hz]
  double low = -0.05, high = 0.05;  ///< [m] range of the motion
  bool growing = false;             ///< every session goes further than the one before it
  double force_noise = 0.05;        ///< [N]
  double encoder_step = 2e-5;       ///< [m]
  int spikes = 0;                   ///< single wrong samples of either channel
  double force_limit = 1e9;         ///< [N] beyond which the sensor stays there
  std::uint64_t seed = 1;
};

struct SpringRecord {
  std::vector<double> time, deflection, force, humidity;
  std::vector<int> session;
  std::string csv() const;
};

SpringRecord recordSpring(const SpringTruth& truth, const SpringDesign& design);

/// Forces of natural rubber in simple tension over expansion up to 100 %, read off a measured curve and scaled: 150 N/m
/// to begin with, less and less from there; the same of compression mirrored.
std::vector<std::pair<double, double>> rubberCurve(double length);
/// A rope whose fibres straighten: soft at first, then stiff.
std::vector<std::pair<double, double>> ropeCurve(double length);

}  // namespace simgap::reality
