/// \file
/// Threefry-2x64-20 of Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3", by the Random123 library.
/// The seed is the key and the four fields fill the 128-bit counter, so no two places of a run share a number.
#include "simgap/core/random.h"

#include <Random123/threefry.h>

#include <cmath>

namespace simgap {
namespace {

std::uint64_t join(std::uint32_t high, std::uint32_t low) { return (static_cast<std::uint64_t>(high) << 32) | low; }

/// The middle of one of 2^52 equal cells of (0, 1): neither 0 nor 1, whatever the bits.
double openUnit(std::uint64_t bits) { return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52; }

}  // namespace

std::array<std::uint64_t, 2> CounterRandom::bits(const RandomCounter& counter) const noexcept {
  using Generator = r123::Threefry2x64;
  const Generator::ctr_type place = {
      {join(counter.generation, counter.individual), join(counter.parameter, counter.purpose)}};
  const Generator::key_type key = {{seed_, 0}};
  const Generator::ctr_type words = Generator()(place, key);
  return {words[0], words[1]};
}

double CounterRandom::uniform(const RandomCounter& counter) const noexcept { return openUnit(bits(counter)[0]); }

std::array<double, 2> CounterRandom::normalPair(const RandomCounter& counter) const noexcept {
  constexpr double kTwoPi = 6.28318530717958647692;
  const auto words = bits(counter);
  // The argument of the logarithm is at least 2^-53, so the radius is finite.
  const double radius = std::sqrt(-2.0 * std::log(openUnit(words[0])));
  const double angle = kTwoPi * openUnit(words[1]);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace simgap
