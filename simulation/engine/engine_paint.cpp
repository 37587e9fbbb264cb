// A brush alone, while everything else stands still.
#include <algorithm>

#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

namespace {

/// Random numbers of paint steps follow those of all iterations; the tracer has room for 24 bits above the lowest 32.
constexpr std::int64_t kPaintKey = std::int64_t{1} << 52;

/// At each step one of so many shares of a brush's gammatons is born, and so many steps they live while it paints:
/// every place of a stroke gets as many.
constexpr std::int64_t kShares = 8;

GammatonRange gammatons_of(const Scene& scene, std::size_t emitter, std::int64_t step) {
  GammatonRange range{.begin = 0, .end = 0, .num_shares = kShares, .born_share = step % kShares};
  for (std::size_t k = 0; k <= emitter; ++k) {
    range.begin = range.end;
    range.end += scene.emitters[k].gammatons;
  }
  return range;
}

/// An emitter that is on, whatever the weather, for a while.
class SwitchedOn {
 public:
  explicit SwitchedOn(Emitter& emitter) : emitter_(emitter), was_on_(emitter.is_on), born_share_(emitter.born_share) {
    emitter_.is_on = true;
    emitter_.born_share = 1.0;
  }
  ~SwitchedOn() {
    emitter_.is_on = was_on_;
    emitter_.born_share = born_share_;
  }
  SwitchedOn(const SwitchedOn&) = delete;
  SwitchedOn& operator=(const SwitchedOn&) = delete;

 private:
  Emitter& emitter_;
  bool was_on_;
  double born_share_;
};

}  // namespace

std::size_t Simulation::State::brush_index(const std::string& emitter) const {
  const auto found =
      std::find_if(scene.emitters.begin(), scene.emitters.end(), [&](const Emitter& e) { return e.name == emitter; });
  if (found == scene.emitters.end()) throw InvalidInput("the scene has no emitter called '" + emitter + "'");
  if (found->shape == EmitterShape::Sky)
    throw InvalidInput("the emitter '" + emitter + "' is the whole sky; only one that stands somewhere can paint");
  return static_cast<std::size_t>(found - scene.emitters.begin());
}

/// Those that were born when it last was their share's turn come to rest, where they still are: on the surface, or on
/// their way to it.
void Simulation::State::end_share(const GammatonRange& moving, ExchangeTime now, const RunControl& control) {
  ended.clear();
  for (auto i = static_cast<std::size_t>(moving.begin); i < static_cast<std::size_t>(moving.end); ++i) {
    if (moving.may_be_born(i) && gammatons.state[i] == GammatonState::Floating)
      ended.push_back(static_cast<std::uint32_t>(i));
  }
  deposit(ended, now, control);
  for (auto i = static_cast<std::size_t>(moving.begin); i < static_cast<std::size_t>(moving.end); ++i) {
    if (!moving.may_be_born(i) || gammatons.state[i] == GammatonState::Waiting) continue;
    gammatons.state[i] = GammatonState::Waiting;
    ledger.end(static_cast<std::uint32_t>(i), CargoEnd::Rested, cargo);
    ++counters.rested;
  }
}

void Simulation::apply_due(const RunControl& control) {
  State& s = *state_;
  while (s.next_event < s.scene.events.size() && s.scene.events[s.next_event].iteration <= s.iteration) {
    const SceneEvent event = s.scene.events[s.next_event++];
    apply(event, control);
  }
  if (s.series_done >= s.iteration) return;
  s.series_done = s.iteration;
  for (std::size_t i = 0; i < s.scene.series.size(); ++i) {
    if (!s.scene.series[i].is_due(s.iteration)) continue;
    const SceneEvent event{.iteration = s.iteration, .what = s.scene.series[i].what};
    apply(event, control);
  }
}

void Simulation::paint(const std::string& emitter, const Vec3& position_mm, const RunControl& control) {
  State& s = *state_;
  const std::size_t k = s.brush_index(emitter);
  s.change_on_host(control);
  if (!position_mm.allFinite()) throw InvalidInput("the position of a brush must be finite");
  s.scene.emitters[k].position_mm = position_mm;
  const SwitchedOn on(s.scene.emitters[k]);
  const GammatonRange moving = gammatons_of(s.scene, k, s.num_paint_steps);
  const std::int64_t key = kPaintKey + s.num_paint_steps;
  s.end_share(moving, {s.iteration, key}, control);
  s.tracer.trace(s.gammatons, s.scene, key, s.trace, control, moving);
  s.begin_lives_and_end_them({s.iteration, key}, control);
  s.follow_contacts();
  const ExchangeReport report = s.exchanger.exchange(s.trace.contacts, s.scene.exchange, {s.iteration, key}, s.cargo,
                                                     s.atlas, s.maps.get(), control);
  s.ledger.add(report);
  s.mark(report.dirty_tiles);
  s.rules->wake(report.dirty_tiles);  // they age what is there, once time continues
  const std::unique_ptr<SurfaceNormals> normals = s.bounce_normals(control);
  const std::optional<WetPaths> wet = s.wet_paths();
  s.tracer.respond(s.gammatons, s.scene, key, s.trace, normals.get(), control, moving, wet ? &*wet : nullptr);
  s.begin_lives_and_end_them({s.iteration, key}, control);
  const TraceCounters& c = s.counters;
  s.counters.alive = c.emitted - c.absorbed - c.left - c.rested;  // of all, those that stand still too
  ++s.num_paint_steps;
}

}  // namespace patinate::simulation
