#include <fmt/format.h>

#include <cctype>

#include "report/capture/capture_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages {
namespace {

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  std::vector<std::string> names;
  std::vector<double> residual, centre;
  std::string answer;
  for (const Json& j : result.at("joints")) {
    const std::string name = j.at("name");
    const bool axis = j.contains("axis_sd_deg");
    answer += axis ? fmt::format("{} axis within {:.2f}°, ", name, numberOf(j.at("axis_sd_deg")))
                   : fmt::format("{} centre within {:.2f} mm, ", name, numberOf(j.at("centre_sd_mm")));
    names.push_back(name);
    residual.push_back(numberOf(j.at("residual_mm")));
    centre.push_back(numberOf(j.at("centre_sd_mm")));
  }
  answer.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(answer.front())));
  Page page{"simgap calibrate-joints",
            answer + fmt::format("upper arm {:.1f} mm; the zero pose is {}.", numberOf(result.at("upper_arm_mm")),
                                 result.at("zero_pose_from_frames").get<bool>() ? "that of the frames named"
                                                                                : "that of the target file"),
            {}};
  page.add(barChart("How well each joint is known", names, {"[mm]"},
                    {{"residual of a frame", {}, residual}, {"standard deviation of the centre", {}, centre}}));
  page.add(jointTable(result));
  return page;
}

}  // namespace

extern const ResultPage calibrate_joints;
const ResultPage calibrate_joints{"simgap/calibrate-joints/1", make};

}  // namespace simgap::pages
