#include "surrogates.h"

#include <algorithm>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "simgap/core/random.h"

namespace simgap {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The largest length up to n of which a fast transform is made of factors 2, 3 and 5.
Index smoothLength(Index n) {
  for (Index length = n; length > 1; --length) {
    Index rest = length;
    for (const Index factor : {Index{2}, Index{3}, Index{5}}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return length;
  }
  return n;
}

}  // namespace

double placeboP(double gain, std::span<const double> of_placebos) {
  const auto reach = std::ranges::count_if(of_placebos, [&](double placebo) { return placebo >= gain; });
  return (1.0 + static_cast<double>(reach)) / (1.0 + static_cast<double>(of_placebos.size()));
}

VectorXd phaseRandomised(const VectorXd& values, std::uint32_t draw, std::uint64_t seed) {
  const Index n = smoothLength(values.size());
  const double mean = values.head(n).mean();
  const VectorXd centred = values.head(n).array() - mean;
  Eigen::FFT<double> fft;
  Eigen::VectorXcd spectrum;
  fft.fwd(spectrum, centred);
  const CounterRandom random(seed);
  // A real signal: the phase of -f is minus that of f; the mean and, of even lengths, the highest frequency stay real.
  for (Index f = 1; 2 * f < n; ++f) {
    const double turn = 2.0 * std::numbers::pi * random.uniform({draw, static_cast<std::uint32_t>(f), 0, 3});
    spectrum[f] *= std::polar(1.0, turn);
    spectrum[n - f] = std::conj(spectrum[f]);
  }
  VectorXd drawn(n);
  fft.inv(drawn, spectrum);
  VectorXd result = VectorXd::Constant(values.size(), mean);
  result.head(n).array() += drawn.array();
  return result;
}

}  // namespace simgap
