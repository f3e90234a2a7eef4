// Writes a simulated log of 003's size (or ROWS rows) to stdout: make_friction_log [ROWS [bristles]] > log.csv
// bristles: friction that is none of the fitted laws, bristles with a static part that fades hyperbolically.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "reality/friction_log.h"

int main(int argc, char** argv) {
  simgap::reality::FrictionTruth truth;
  truth.sliding_offset = 1.2;
  truth.noise = 0.87;
  simgap::reality::LogDesign design;
  design.rows = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 247900;
  design.sessions = 40;
  design.heaviest = 28.0;  // beyond the 20 N m of 003 table 1 while they swing
  const bool bristles = argc > 2 && argv[2] == std::string_view("bristles");
  if (bristles) {
    truth.breakaway_offset = 1.2;
    truth.velocity_noise = 0.15;
    truth.load_noise = 0.03;
    truth.current_grain = 0.01;
    truth.bristle_travel = 0.02;
    truth.fades_hyperbolically = true;
  }
  const std::string text = simgap::reality::simulateFrictionLog(truth, design).csv(bristles);
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? 0 : 1;
}
