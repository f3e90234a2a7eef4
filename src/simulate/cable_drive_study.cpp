#include "simgap/simulate/cable_drive_study.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>

#include "simgap/simulate/tick_steps.h"

namespace simgap {
namespace {

void noteLimits(const CableDriveStudy& study, std::vector<std::string>& notes) {
  constexpr double kMostChange = 0.05;
  if (study.half_step > kMostChange) {
    notes.push_back(
        fmt::format("the step of {:g} s is too large: at half of it the error changes by {:.0f} %; try "
                    "--step-s {:g}",
                    study.step, 100.0 * study.half_step, 0.5 * study.step));
  }
  for (const ComparedDrive& compared : study.runs) {
    const DriveTracking& t = compared.run.tracking;
    if (t.at_limit > 0.0) {
      notes.push_back(fmt::format("with {} the current was at its limit for {:.1f} % of the time", compared.name,
                                  100.0 * t.at_limit));
    }
  }
}

}  // namespace

CableDriveStudy studyCableDrive(const CableDrive& drive, const CableDriveCommands& commands, double end, double step,
                                double row_rate) {
  CableDriveStudy study;
  study.start = commands.over_time.times.front();
  study.end = end;
  study.step = stepWithinTick(1.0 / drive.rate, step);
  for (const FrictionCompensation& c : drive.compensations) study.runs.push_back({c.name, c.share, {}});
  DriveRun fine;
  tbb::parallel_for(std::size_t{0}, study.runs.size() + 1, [&](std::size_t i) {
    const bool again = i == study.runs.size();
    const DrivePlay play{.step = again ? 0.5 * study.step : study.step, .row_rate = row_rate};
    (again ? fine : study.runs[i].run) = playCableDrive(drive, drive.compensations[again ? 0 : i], commands, end, play);
  });
  const double rms = study.runs.front().run.tracking.rms;
  if (rms > 0.0) study.half_step = std::abs(fine.tracking.rms - rms) / rms;
  noteLimits(study, study.notes);
  return study;
}

}  // namespace simgap
