#include "simgap/report/poses/exchange_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace simgap {
namespace {

constexpr std::size_t kMostPlaces = 3;

Json remarksJson(const std::vector<ExchangeRemark>& remarks) {
  Json list = Json::array();
  for (const ExchangeRemark& remark : remarks) {
    list.push_back(
        {{"what", remark.what}, {"done", remark.done}, {"matters", remark.matters}, {"places", remark.places}});
  }
  return list;
}

std::size_t surfaces(const ArmModel& model) {
  std::size_t count = 0;
  for (const Body& body : model.bodies) count += body.surfaces.size();
  return count;
}

std::string remarkLines(const std::vector<ExchangeRemark>& remarks, bool matters, const std::string& title) {
  std::string text;
  for (const ExchangeRemark& remark : remarks) {
    if (remark.matters != matters) continue;
    const std::size_t shown = std::min(remark.places.size(), kMostPlaces);
    std::string places = fmt::format(
        "{}", fmt::join(remark.places.begin(), remark.places.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
    if (shown < remark.places.size()) places += fmt::format(" and {} more", remark.places.size() - shown);
    text += fmt::format("  {}: {}{}\n", remark.what, remark.done, places.empty() ? "" : " (" + places + ")");
  }
  return text.empty() ? "" : "\n" + title + "\n" + text;
}

}  // namespace

Json toJson(const RobotExchange& exchange) {
  const ExchangeReplay& replay = exchange.replay;
  const bool rested = replay.rests > 0;
  return {{"format", "simgap/convert/1"},
          {"from", {{"file", exchange.from.string()}, {"format", nameOf(exchange.from_format)}}},
          {"to", {{"file", exchange.to.string()}, {"format", nameOf(exchange.to_format)}}},
          {"robot",
           {{"name", exchange.model.name},
            {"bodies", exchange.model.bodies.size()},
            {"joints", exchange.model.joints.size()},
            {"muscles", exchange.model.muscles.size()},
            {"passive_tendons", exchange.model.tendons.size()},
            {"surfaces", surfaces(exchange.model)},
            {"extensions", exchange.model.extensions.size()}}},
          {"remarks", {{"read", remarksJson(exchange.read)}, {"written", remarksJson(exchange.written)}}},
          {"read_back",
           {{"positions", replay.positions},
            {"largest_way_m", replay.way},
            {"largest_turn_deg", toDegrees(replay.turn)},
            {"largest_mass_kg", replay.mass},
            {"largest_centre_m", replay.centre},
            {"largest_inertia_share", replay.inertia},
            {"rests", replay.rests},
            {"not_compared", replay.not_compared},
            {"largest_way_at_rest_m", rested ? Json(replay.rest_way) : Json(nullptr)},
            {"largest_turn_at_rest_deg", rested ? Json(toDegrees(replay.rest_turn)) : Json(nullptr)}}}};
}

std::string terminalTable(const RobotExchange& exchange) {
  const ArmModel& model = exchange.model;
  const ExchangeReplay& replay = exchange.replay;
  std::string text = fmt::format("{} ({}) -> {} ({})\n", exchange.from.string(), nameOf(exchange.from_format),
                                 exchange.to.string(), nameOf(exchange.to_format));
  text += fmt::format("robot      {}: {} bodies, {} joints, {} muscles, {} passive tendons, {} surfaces\n", model.name,
                      model.bodies.size(), model.joints.size(), model.muscles.size(), model.tendons.size(),
                      surfaces(model));
  text += fmt::format("read back  {} positions of the joints: bodies within {:.1e} m and {:.1e} deg\n",
                      replay.positions, replay.way, toDegrees(replay.turn));
  text += fmt::format("           masses within {:.1e} kg, their centres {:.1e} m, inertias {:.1e} of themselves\n",
                      replay.mass, replay.centre, replay.inertia);
  if (replay.rests > 0) {
    text += fmt::format("           {} poses at rest{}: bodies within {:.1e} m and {:.1e} deg\n", replay.rests,
                        model.extensions.empty() ? "" : " without extensions", replay.rest_way,
                        toDegrees(replay.rest_turn));
  } else if (replay.not_compared == 0 && model.commands() > 0) {
    text += "           no poses at rest: not all that pulls is the same, read back\n";
  }
  if (replay.not_compared > 0) {
    text += fmt::format("           {} poses without a rest that could be compared\n", replay.not_compared);
  }
  for (const auto* remarks : {&exchange.read, &exchange.written}) {
    const bool read = remarks == &exchange.read;
    const std::string side = read ? "of " + exchange.from.filename().string() : "in " + exchange.to.filename().string();
    text += remarkLines(*remarks, true,
                        fmt::format("{} {}, and it matters:", read ? "left out or changed" : "not the same", side));
    text += remarkLines(*remarks, false,
                        fmt::format("{} {}, without effect on rest or motion here:",
                                    read ? "left out or changed" : "not the same", side));
  }
  return text;
}

}  // namespace simgap
