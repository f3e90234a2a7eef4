// Writes a simulated log of 003's size (or ROWS rows) to stdout: make_friction_log [ROWS] > log.csv
#include <cstdio>
#include <cstdlib>

#include "reality/friction_log.h"

int main(int argc, char** argv) {
  simgap::reality::FrictionTruth truth;
  truth.sliding_offset = 1.2;
  truth.noise = 0.87;
  simgap::reality::LogDesign design;
  design.rows = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 247900;
  design.sessions = 20;
  const std::string text = simgap::reality::simulateFrictionLog(truth, design).csv();
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? 0 : 1;
}
