/// \file
/// Files built into the program (CMake writes the definitions).
#pragma once

#include <string_view>

namespace simgap::assets {

std::string_view chart_js();            ///< Chart.js, minified
std::string_view report_html();         ///< mustache template of every report
std::string_view calibrate_arm_yaml();  ///< configs/calibrate_arm.yaml: the paper's settings

}  // namespace simgap::assets
