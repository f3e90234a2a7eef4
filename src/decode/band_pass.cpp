#include "simgap/decode/band_pass.h"

#include <cmath>
#include <complex>
#include <numbers>

namespace simgap {
namespace {

using Complex = std::complex<double>;

/// The bilinear transform bends frequencies: this analogue one becomes `frequency`. [rad per half sample time]
double warped(double frequency, double rate) { return std::tan(std::numbers::pi * frequency / rate); }

Complex sectionResponse(double a1, double a2, Complex z) {
  return (1.0 - 1.0 / (z * z)) / (1.0 + a1 / z + a2 / (z * z));
}

}  // namespace

BandPass::BandPass(int order, double low, double high, double rate) {
  const double from = warped(low, rate), to = warped(high, rate);
  const double middle_squared = from * to, half_width = 0.5 * (to - from);
  const double middle = std::sqrt(middle_squared);
  const Complex z_middle = (1.0 + Complex(0.0, middle)) / (1.0 - Complex(0.0, middle));
  for (int k = 0; k < order; ++k) {
    // The low-pass' poles lie on the unit circle's left half; p -> p w/2 +- sqrt((p w/2)^2 - w0^2) makes two of each.
    const Complex pole = half_width * std::polar(1.0, std::numbers::pi * (2.0 * k + order + 1.0) / (2.0 * order));
    const Complex root = std::sqrt(pole * pole - middle_squared);
    for (const Complex analogue : {pole + root, pole - root}) {
      if (analogue.imag() <= 0.0) continue;  // its conjugate stands for both
      const Complex digital = (1.0 + analogue) / (1.0 - analogue);
      Section section;
      section.a1 = -2.0 * digital.real();
      section.a2 = std::norm(digital);
      section.gain = 1.0 / std::abs(sectionResponse(section.a1, section.a2, z_middle));
      sections_.push_back(section);
    }
  }
}

double BandPass::operator()(double value) {
  for (Section& s : sections_) {
    const double in = s.gain * value;
    const double out = in + s.state[0];
    s.state[0] = s.state[1] - s.a1 * out;
    s.state[1] = -in - s.a2 * out;
    value = out;
  }
  return value;
}

void BandPass::reset() {
  for (Section& section : sections_) section.state = {};
}

}  // namespace simgap
