#include "report/actuators/fit_page.h"
#include "report/actuators/response_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages {

namespace {

Page make(const ResultFiles& files) { return isRefit(files) ? refitPage(files) : driveFitPage(files); }

}  // namespace

extern const ResultPage fit_motor;
const ResultPage fit_motor{"simgap/fit-motor/1", make};

}  // namespace simgap::pages
