#include <algorithm>

#include "report/actuators/fit_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::fit_pam {
namespace {

Page make(const ResultFiles& files) {
  if (isRefit(files)) return refitPage(files);
  Page page = beginFitPage(files);
  Chart forces = lineChart("Force over apparent contraction", {"apparent contraction"}, {"force [N]"},
                           seriesOf(files.table("forces.csv"), "contraction", "force_N"));
  forces.wide = true;
  page.add(std::move(forces));
  std::vector<Series> errors = seriesOf(files.table("errors.csv"), "force_N", "error_N");
  for (Series& points : errors) points.style = Series::Style::kPoints;
  page.add(lineChart("Error over force", {"measured force [N]"}, {"predicted - measured [N]"}, errors));
  addFitDetails(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/fit-pam/1", make};

}  // namespace simgap::pages::fit_pam
