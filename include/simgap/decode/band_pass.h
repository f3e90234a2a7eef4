/// \file
/// Butterworth's band-pass as it runs beside a recording: causal, sample by sample.
#pragma once

#include <array>
#include <vector>

namespace simgap {

class BandPass {
 public:
  /// \param order  of the low-pass it is made from: 2 `order` poles  \param low, high  where 3 dB are lost [Hz]
  /// \param rate  [Hz], above 2 high
  BandPass(int order, double low, double high, double rate);
  double operator()(double value);
  void reset();

 private:
  /// A pair of poles, with a zero at no frequency and one at the highest: direct form II, transposed.
  struct Section {
    double gain = 1.0;
    double a1 = 0.0, a2 = 0.0;
    std::array<double, 2> state{};
  };
  std::vector<Section> sections_;
};

}  // namespace simgap
