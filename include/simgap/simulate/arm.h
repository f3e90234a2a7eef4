/// \file
/// An arm as another program's internal model: the header and shared library that `cmake --install` puts there
/// (find_package(simgap), simgap::arm). Standard types alone, so that the program needs none of simgap's libraries.
///
///     simgap::Arm arm("arm.yaml");
///     arm.reset(simgap::Arm::Command::kSetpoint);
///     arm.step(setpoints);                          // 1 ms later
///     const double elbow = arm.joint(1).front();
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace simgap {

/// Moves as `simgap simulate` moves it. One thread at a time; what it does depends on model, options and commands since
/// the last reset alone, to the last bit. Every function throws std::runtime_error with one sentence when it is used
/// against what is said here.
class Arm {
 public:
  /// What the numbers of a command are, of all muscles.
  enum class Command {
    kSetpoint,  ///< of the shafts [rad]
    kVoltage,   ///< of the motors, at most the supply [V]
    kForce,     ///< of the lines, >= 0 [N]
  };
  struct Options {
    double step = 0.001;             ///< [s] a period of the controllers is a whole number of steps
    double controller_rate = 500.0;  ///< [Hz]
    double shaft_gain = 50.0;        ///< K_p of the shaft controllers [V/rad]
  };
  /// \param model  a file of `simgap/arm/1` or `/2`
  explicit Arm(const std::string& model, const Options& options);
  explicit Arm(const std::string& model) : Arm(model, Options()) {}
  ~Arm();
  Arm(Arm&&) noexcept;
  Arm& operator=(Arm&&) noexcept;

  const std::vector<std::string>& muscles() const;
  const std::vector<std::string>& joints() const;

  /// Time 0, shafts at 0, joints where every pose begins.
  void reset(Command command);
  /// One step. \param commands  shape (muscles), behind them those of pneumatic muscles and motors at joints, in the
  /// order of the file [Pa, A, rad]; controllers look at them when they tick
  /// \throws when the simulation has blown up: a smaller step may hold it
  void step(const std::vector<double>& commands);

  double time() const;                                 ///< since reset() [s]
  std::vector<double> joint(std::size_t joint) const;  ///< angle [rad], way [m], a ball's unit quaternion w, x, y, z
  std::vector<double> velocity(
      std::size_t joint) const;              ///< [rad/s, m/s] of the same joint, a ball's in the child's frame
  double shaft(std::size_t muscle) const;    ///< [rad]
  double force(std::size_t muscle) const;    ///< [N]
  double current(std::size_t muscle) const;  ///< [A]

 private:
  struct Simulation;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace simgap
