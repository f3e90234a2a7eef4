#include "report/actuators/response_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages {

extern const ResultPage fit_motor;
const ResultPage fit_motor{"simgap/fit-motor/1", driveFitPage};

}  // namespace simgap::pages
