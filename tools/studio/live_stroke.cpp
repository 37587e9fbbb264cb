// A stroke: while it lasts the brush lives alone, along a way without gaps however rarely the browser tells where it
// is.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "simulation/files/scene_event.h"
#include "tools/studio/live_client.h"
#include "tools/studio/scene_text.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxAhead = 20'000;
constexpr double kSpacing = 0.25;                ///< From step to step, in widths of the brush.
constexpr double kMaxBetween = 200.0;            ///< Steps between two places, whatever the width.
constexpr std::size_t kEraserSteps = 3;          ///< At each place: one takes away about a third.
constexpr std::chrono::milliseconds kDwell{20};  ///< A brush that stays paints on, so often.

/// Width of a brush's mark, mm.
double width_of(const simulation::Emitter& brush) {
  for (const double width : {brush.size_mm[0], brush.distance_mm}) {
    if (width > 0.0) return width;
  }
  return 1.0;
}

const simulation::Emitter& emitter_named(const simulation::Scene& scene, const std::string& name) {
  return *std::find_if(scene.emitters.begin(), scene.emitters.end(),
                       [&](const simulation::Emitter& e) { return e.name == name; });
}

/// Coordinate in mm as a scene file holds it: enough digits to lie within a tenth of a micrometer.
double of_file(double mm, double mm_per_unit) { return std::round(1e4 * mm) / 1e4 / mm_per_unit; }

}  // namespace

bool LiveEngine::can_paint(const std::string& emitter) const {
  const std::vector<simulation::Emitter>& all = simulation_.scene().emitters;
  return std::any_of(all.begin(), all.end(), [&](const simulation::Emitter& e) {
    return e.name == emitter && e.shape == simulation::EmitterShape::Surface;
  });
}

void LiveEngine::begin_stroke(const Client& client, const std::string& emitter, const std::vector<Vec3>& way,
                              const std::vector<std::string>& erased) {
  refuse_picture();
  if (!can_paint(emitter))
    throw InvalidInput("/emitter: found \"" + emitter + "\"; expected an emitter of shape surface");
  const std::vector<std::string>& materials = simulation_.scene().materials;
  for (const std::string& name : erased) {
    if (std::find(materials.begin(), materials.end(), name) == materials.end())
      throw InvalidInput("/erase: found \"" + name + "\"; expected a material of the scene");
  }
  if (!is_doing_again()) stop_replay();
  finish_stroke();
  remember((erased.empty() ? "Stroke with " : "Erase with ") + emitter, true);
  stroke_.emplace();
  stroke_->emitter = emitter;
  stroke_->client = &client;
  if (!erased.empty()) begin_erasing(erased);
  lengthen(way, true);
}

void LiveEngine::move_stroke(const Client& client, const std::vector<Vec3>& way, bool jumps, bool is_lifted) {
  if (!stroke_ || stroke_->client != &client || stroke_->is_lifted) throw InvalidInput("/phase: no stroke has begun");
  stroke_->is_lifted = is_lifted;
  lengthen(way, jumps);
}

/// @param jumps  The first place is not joined to the last one before.
void LiveEngine::lengthen(const std::vector<Vec3>& way, bool jumps) {
  Stroke& stroke = *stroke_;
  if (stroke.ahead.size() > kMaxAhead)
    throw InvalidInput("/positions: the simulation is " + std::to_string(kMaxAhead) +
                       " steps behind the brush; paint more slowly");
  const double spacing = kSpacing * width_of(emitter_named(simulation_.scene(), stroke.emitter));
  for (const Vec3& to : way) {
    const Vec3 from = stroke.at;
    const double steps = jumps ? 1.0 : std::clamp(std::ceil((to - from).norm() / spacing), 1.0, kMaxBetween);
    for (double i = 1.0; i <= steps; i += 1.0) {
      const Vec3 place = i < steps ? Vec3(from + (to - from) * (i / steps)) : to;
      stroke.ahead.insert(stroke.ahead.end(), stroke.afterward.empty() ? 1 : kEraserSteps, place);
    }
    stroke.at = to;
    jumps = false;
  }
}

/// The next step, if it is time for one.
void LiveEngine::paint() {
  Stroke& stroke = *stroke_;
  if (stroke.ahead.empty() && stroke.is_lifted) return finish_stroke();
  if (stroke.ahead.empty() && Clock::now() - stroke.painted < kDwell) return;
  const Vec3 position = stroke.ahead.empty() ? stroke.at : stroke.ahead.front();
  if (!stroke.ahead.empty()) stroke.ahead.pop_front();
  paint_at(stroke.emitter, position);
}

/// The brush stands where a scene file will say that it stood.
void LiveEngine::paint_at(const std::string& emitter, const Vec3& position_mm) {
  const double unit = file_.mm_per_unit;
  const std::array<double, 3> of{of_file(position_mm.x(), unit), of_file(position_mm.y(), unit),
                                 of_file(position_mm.z(), unit)};
  simulation_.paint(emitter, Vec3(of[0], of[1], of[2]) * unit,
                    {.on_progress = {}, .stop = {}, .num_threads = options_.num_threads});
  record_.add_paint(emitter, simulation_.iteration(), of);
  if (stroke_) stroke_->painted = Clock::now();
  opened_.clear();
  has_news_ = true;
}

void LiveEngine::catch_up() {
  while (stroke_ && !stroke_->ahead.empty()) {
    const Vec3 position = stroke_->ahead.front();
    stroke_->ahead.pop_front();
    paint_at(stroke_->emitter, position);
  }
}

/// An eraser is a brush whose drops are empty, take up all of some materials and nothing of the others, and bounce
/// away.
void LiveEngine::begin_erasing(const std::vector<std::string>& erased) {
  const simulation::Scene& scene = simulation_.scene();
  Json brush = emitter_of_file(emitter_named(scene, stroke_->emitter), scene.materials, file_.mm_per_unit);
  brush["carries"] = Json::object();
  std::vector<Json> events{{{"op", "emitter"}, {"emitter", std::move(brush)}},
                           {{"op", "ratio"}, {"ratio", 0.0}},
                           {{"op", "behavior"},
                            {"behavior",
                             {{"bounce", 1.0},
                              {"float", 0.0},
                              {"absorb", 0.0},
                              {"deceleration_bounce", 0.0},
                              {"deceleration_float", 0.0}}}}};
  for (const std::string& material : scene.materials) {
    const bool goes = std::find(erased.begin(), erased.end(), material) != erased.end();
    events.push_back({{"op", "rate"}, {"target", material}, {"rate", goes ? 1.0 : 0.0}});
  }
  const Json before = scene_json();
  auto shown = std::make_shared<Json>(Json::object());
  for (const char* key : {"emitters", "behavior", "slider", "exchange"}) (*shown)[key] = before[key];
  for (Json& event : events) {
    Json now{{"iteration", simulation_.iteration()}};
    now.update(event);
    std::vector<BackEvent> back = opposite(parse_event(now, scene, file_.mm_per_unit));
    stroke_->afterward.insert(stroke_->afterward.end(), back.begin(), back.end());
    perform_now(event);
  }
  stroke_->shown = std::move(shown);
}

/// What the drops hold goes with them, far from all objects; then everything is as it was.
void LiveEngine::finish_erasing() {
  constexpr int kSteps = 8;  // After as many, each drop of a brush has been born again.
  const simulation::Scene& scene = simulation_.scene();
  const Box box = bounding_box(simulation_.mesh());
  simulation::Emitter away = emitter_named(scene, stroke_->emitter);
  away.shape = simulation::EmitterShape::Disk;
  away.position_mm = box.high + 2.0 * box.diagonal() * Vec3(1, 0, 0);
  away.direction = Vec3(1, 0, 0);
  away.size_mm = {0.0, 0.0};
  away.spread_deg = 0.0;
  const std::string name = away.name;
  // The stroke itself has ended for can_paint().
  const Stroke ended = std::move(*stroke_);
  stroke_.reset();
  perform_now({{"op", "emitter"}, {"emitter", emitter_of_file(away, scene.materials, file_.mm_per_unit)}});
  for (int i = 0; i < kSteps; ++i) paint_at(name, away.position_mm);
  for (const BackEvent& back : ended.afterward) perform_now(*back.event);
}

void LiveEngine::finish_stroke() {
  catch_up();
  if (!stroke_) return;
  if (!stroke_->afterward.empty()) finish_erasing();
  stroke_.reset();
  const auto step = std::find_if(past_.rbegin(), past_.rend(), [](const Step& s) { return s.is_stroke; });
  if (step != past_.rend()) step->num_events_then = record_.num_events();
  has_news_ = true;
  counted_from_ = Clock::now();
  counted_iterations_ = 0;
}

}  // namespace patinate::studio
