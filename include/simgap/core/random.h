/// \file
/// Counter-based random numbers (Random123, Threefry-2x64-20): a number is a pure function of (seed, counter), so any
/// thread may draw any number at any time and a resumed run draws the same ones.
#pragma once

#include <array>
#include <cstdint>

namespace simgap {

/// Where in a run a number is drawn. The fields are hashed together; equal counters give equal numbers.
struct RandomCounter {
  std::uint32_t generation = 0;
  std::uint32_t individual = 0;
  std::uint32_t parameter = 0;
  std::uint32_t purpose = 0;  ///< separates independent draws at the same place
};

/// A stream of random numbers with a fixed seed; stateless, free to copy.
class CounterRandom {
 public:
  explicit CounterRandom(std::uint64_t seed) : seed_(seed) {}
  /// Two independent 64-bit words.
  std::array<std::uint64_t, 2> bits(const RandomCounter& counter) const noexcept;
  /// Uniform in the open interval (0, 1), 52 bits: with 53 the largest would round to 1.
  double uniform(const RandomCounter& counter) const noexcept;
  /// Two independent standard normal numbers (Box-Muller); finite, |z| < 8.6.
  std::array<double, 2> normalPair(const RandomCounter& counter) const noexcept;

 private:
  std::uint64_t seed_;
};

}  // namespace simgap
