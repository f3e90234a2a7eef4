#include "report/actuators/response_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages {

extern const ResultPage fit_gearbox;
const ResultPage fit_gearbox{"simgap/fit-gearbox/1", driveFitPage};

}  // namespace simgap::pages
