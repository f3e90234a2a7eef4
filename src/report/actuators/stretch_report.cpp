#include "simgap/report/actuators/stretch_report.h"

#include <fmt/format.h>

#include "simgap/core/csv.h"
#include "simgap/report/actuators/prediction_report.h"

namespace simgap {

Json toJson(const JointStretch& stretch, const std::string& kind) {
  Json result = toJson(stretch.angle, kind);
  result["joint_angle"] = {{"compliance_rad_Nm", stretch.compliance},
                           {"hardening_rad_Nm2", stretch.hardening},
                           {"largest_load_Nm", stretch.largest_load},
                           {"stretch_at_largest_load_rad", stretch.stretch(stretch.largest_load)},
                           {"stiffness_Nm_rad", numberOrNull(stretch.stiffness(0.0))},
                           {"stiffness_at_largest_load_Nm_rad", numberOrNull(stretch.stiffness(stretch.largest_load))},
                           {"offset_rad", stretch.offset},
                           {"lag_s", stretch.lag},
                           {"rms_error_stiff", stretch.stiff_rms ? Json(*stretch.stiff_rms) : Json(nullptr)}};
  return result;
}

std::string stretchCsv(const JointStretch& stretch) {
  CsvWriter csv({"load_Nm", "joint_position_rad", "rows", "stretch_rad", "model_rad"});
  for (const StretchCell& cell : stretch.cells) {
    csv.add(cell.load).add(cell.angle).add(cell.rows).add(cell.measured).add(cell.modelled).endRow();
  }
  return csv.text();
}

std::string stretchAnswer(const Json& result) {
  const Json& own = result.at("joint_angle");
  std::string text = fmt::format("The cable stretches by {} of the joint under {} N m",
                                 numberText(own.at("stretch_at_largest_load_rad"), "{:.3g} rad"),
                                 numberText(own.at("largest_load_Nm"), "{:.3g}"));
  if (!own.at("rms_error_stiff").is_number()) return text + "; the log holds no joint angle to compare with.";
  return text + fmt::format(": the joint's angle follows from the motor's to {} rad (RMS), with a stiff cable to {}.",
                            numberText(result.at("rms_error"), "{:.3g}"),
                            numberText(own.at("rms_error_stiff"), "{:.3g}"));
}

Table stretchTable(const Json& result) {
  const Json& own = result.at("joint_angle");
  return {"Cable between motor and joint",
          {"", "without load", "under the largest load"},
          {{"stiffness [N m/rad]", numberText(own.at("stiffness_Nm_rad"), "{:.4g}"),
            numberText(own.at("stiffness_at_largest_load_Nm_rad"), "{:.4g}")},
           {"stretch of the joint [rad]", "0", numberText(own.at("stretch_at_largest_load_rad"), "{:.3g}")}}};
}

}  // namespace simgap
