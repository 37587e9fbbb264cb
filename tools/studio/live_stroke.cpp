// A stroke: while it lasts the brush lives alone, along a way without gaps however rarely the browser tells where it
// is.
#include <algorithm>
#include <cmath>

#include "patinate/core/error.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxAhead = 20'000;
constexpr double kSpacing = 0.25;                ///< From step to step, in widths of the brush.
constexpr double kMaxBetween = 200.0;            ///< Steps between two places, whatever the width.
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

void LiveEngine::begin_stroke(const Client& client, const std::string& emitter, const std::vector<Vec3>& way) {
  refuse_picture();
  if (!can_paint(emitter))
    throw InvalidInput("/emitter: found \"" + emitter + "\"; expected an emitter of shape surface");
  stop_replay();
  finish_stroke();
  remember();
  stroke_.emplace();
  stroke_->emitter = emitter;
  stroke_->client = &client;
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
    for (double i = 1.0; i <= steps; i += 1.0)
      stroke.ahead.push_back(i < steps ? Vec3(from + (to - from) * (i / steps)) : to);
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
  paint_at(position);
}

/// The brush stands where a scene file will say that it stood.
void LiveEngine::paint_at(const Vec3& position_mm) {
  const double unit = file_.mm_per_unit;
  const std::array<double, 3> of{of_file(position_mm.x(), unit), of_file(position_mm.y(), unit),
                                 of_file(position_mm.z(), unit)};
  simulation_.paint(stroke_->emitter, Vec3(of[0], of[1], of[2]) * unit,
                    {.on_progress = {}, .stop = {}, .num_threads = options_.num_threads});
  record_.add_paint(stroke_->emitter, simulation_.iteration(), of);
  stroke_->painted = Clock::now();
  opened_.clear();
  has_news_ = true;
}

void LiveEngine::catch_up() {
  while (stroke_ && !stroke_->ahead.empty()) {
    const Vec3 position = stroke_->ahead.front();
    stroke_->ahead.pop_front();
    paint_at(position);
  }
}

void LiveEngine::finish_stroke() {
  catch_up();
  if (!stroke_) return;
  stroke_.reset();
  has_news_ = true;
  counted_from_ = Clock::now();
  counted_iterations_ = 0;
}

}  // namespace patinate::studio
