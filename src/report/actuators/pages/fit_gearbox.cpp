#include "report/actuators/response_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::fit_gearbox {

extern const ResultPage entry;
const ResultPage entry{"simgap/fit-gearbox/1", driveFitPage};

}  // namespace simgap::pages::fit_gearbox
