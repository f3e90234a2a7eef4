/// \file
/// Files built into the program (CMake writes the definitions).
#pragma once

#include <string_view>

namespace simgap::assets {

std::string_view chart_js();                ///< Chart.js, minified
std::string_view three_js();                ///< three.js, minified
std::string_view orbit_controls_js();       ///< turns the camera of a three.js scene
std::string_view report_html();             ///< mustache template of every report
std::string_view report_css();              ///< its looks
std::string_view report_js();               ///< draws its charts
std::string_view arm_view_js();             ///< draws its three-dimensional views
std::string_view calibrate_arm_yaml();      ///< configs/calibrate_arm.yaml: the paper's settings
std::string_view calibrate_lines_yaml();    ///< configs/calibrate_lines.yaml: arms without muscles
std::string_view calibrate_motions_yaml();  ///< configs/calibrate_motions.yaml: the same for motions

}  // namespace simgap::assets
